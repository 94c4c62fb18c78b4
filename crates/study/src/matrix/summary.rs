//! Statistics of each method over the cells.

use super::factor::FACTORS;
use super::result::CellResult;
use lostmotion_methods::MethodId;
use serde::Serialize;

/// Distribution of a ratio over cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Number of cells.
    pub cells: usize,
    /// Half of the cells have no more.
    pub median: f64,
    /// 95 of 100 cells have no more.
    pub p95: f64,
    /// The largest.
    pub worst: f64,
}

impl Spread {
    /// Of some values, by nearest rank; `None` if there are none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Spread> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        // Nearest rank: a value that occurs, no interpolation.
        let rank = |part: f64| {
            let index = (part * sorted.len() as f64).ceil().max(1.0) as usize - 1;
            sorted.get(index).copied()
        };
        Some(Spread {
            cells: sorted.len(),
            median: rank(0.5)?,
            p95: rank(0.95)?,
            worst: *sorted.last()?,
        })
    }
}

/// One method over a set of cells. Ratios are to `none`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MethodSummary {
    /// Registered name.
    pub method: String,
    /// Cells, whether they have a ratio or not: those that the counts below are out of.
    pub cells: usize,
    /// RMS of what backlash adds to the contour error.
    pub rms_ratio: Option<Spread>,
    /// Its largest magnitude.
    pub max_ratio: Option<Spread>,
    /// Cells whose RMS is worse than that of `none` by more than 0.1 um.
    pub worse_rms: usize,
    /// Cells whose largest error is worse by more than that.
    pub worse_max: usize,
    /// Cells in which it hunts.
    pub hunts: usize,
    /// Cells in which a drive was at a limit for more than a hundredth of the time.
    pub saturated: usize,
    /// Cells in which it leaves no more RMS than is wanted, or than the practical limit where that
    /// is more ([`super::result`]); and the same for the largest error.
    pub within: [usize; 2],
    /// Relative error of the gap's estimate, if it makes one.
    pub gap_error: Option<Spread>,
}

/// A regime: cells with one level of one factor.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Regime {
    /// Factor.
    pub factor: String,
    /// Level.
    pub level: String,
    /// A row a method.
    pub methods: Vec<MethodSummary>,
    /// What physics leaves at least, over what `none` leaves: RMS.
    pub limit_rms_ratio: Option<Spread>,
    /// The practical limit: RMS.
    pub practical_rms_ratio: Option<Spread>,
}

/// A cell that is among a method's worst.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstCell {
    /// Registered name.
    pub method: String,
    /// Name of the cell.
    pub cell: String,
    /// RMS and largest error over those of `none`.
    pub ratios: [f64; 2],
}

/// The whole matrix.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Cells.
    pub cells: usize,
    /// Machine time, s.
    pub simulated_s: f64,
    /// What physics leaves at least, over what `none` leaves: RMS.
    pub limit_rms_ratio: Option<Spread>,
    /// The same: largest error.
    pub limit_max_ratio: Option<Spread>,
    /// The practical limit, RMS and largest error ([`super::result`]).
    pub practical_ratio: [Option<Spread>; 2],
    /// A row a method.
    pub methods: Vec<MethodSummary>,
    /// Every level of every factor.
    pub regimes: Vec<Regime>,
    /// The worst cells of each method by RMS ratio, worst first.
    pub worst: Vec<WorstCell>,
}

/// Part of the time at a limit from which on a cell counts as saturated. A choice.
const SATURATED_TIME_SHARE: f64 = 0.01;
/// Worst cells listed for each method. A choice.
const WORST_CELLS: usize = 5;

/// Statistics of all cells.
pub fn summary(results: &[CellResult]) -> Summary {
    let all: Vec<&CellResult> = results.iter().collect();
    // The same methods in every cell, `none` first.
    let names: Vec<&str> = results.first().map_or(Vec::new(), |cell| {
        cell.methods
            .iter()
            .map(|figures| figures.method.as_str())
            .collect()
    });
    Summary {
        cells: results.len(),
        simulated_s: results.iter().map(|cell| cell.duration_s).sum(),
        limit_rms_ratio: limit(&all, 0),
        limit_max_ratio: limit(&all, 1),
        practical_ratio: [0, 1].map(|which| practical(&all, which)),
        methods: names.iter().map(|name| method(&all, name)).collect(),
        regimes: regimes(results, &names),
        worst: names
            .iter()
            .skip(1)
            .flat_map(|name| worst(results, name))
            .collect(),
    }
}

/// What physics leaves at least, over what `none` leaves: RMS (0) or largest error (1).
fn limit(cells: &[&CellResult], which: usize) -> Option<Spread> {
    let usable = cells
        .iter()
        .filter(|cell| cell.ratios(MethodId::NONE.name()).is_some());
    Spread::of(usable.filter_map(|cell| {
        let (least, none) = (
            [cell.limit_rms_um, cell.limit_max_um],
            cell.of(MethodId::NONE.name())?,
        );
        Some(least.get(which)? / [none.rms_um, none.max_um].get(which)?)
    }))
}

/// The practical limit, over what `none` leaves: RMS (0) or largest error (1).
fn practical(cells: &[&CellResult], which: usize) -> Option<Spread> {
    Spread::of(
        cells
            .iter()
            .filter_map(|cell| cell.practical()?.get(which).copied()),
    )
}

/// Statistics of one method over some cells.
fn method(cells: &[&CellResult], name: &str) -> MethodSummary {
    // Cells in which `none` leaves next to nothing have no ratio and count for none of the spreads.
    let ratios: Vec<[f64; 2]> = cells.iter().filter_map(|cell| cell.ratios(name)).collect();
    let figures = || cells.iter().filter_map(|cell| cell.of(name));
    MethodSummary {
        method: name.to_owned(),
        cells: cells.len(),
        rms_ratio: Spread::of(ratios.iter().map(|[rms, _]| *rms)),
        max_ratio: Spread::of(ratios.iter().map(|[_, max]| *max)),
        worse_rms: cells.iter().filter(|cell| cell.worse(name)[0]).count(),
        worse_max: cells.iter().filter(|cell| cell.worse(name)[1]).count(),
        hunts: figures().filter(|figures| figures.hunts).count(),
        saturated: figures()
            .filter(|figures| figures.saturated > SATURATED_TIME_SHARE)
            .count(),
        within: [0, 1].map(|which: usize| {
            cells
                .iter()
                .filter(|cell| cell.within(name).is_some_and(|within| within[which]))
                .count()
        }),
        gap_error: Spread::of(figures().filter_map(|figures| figures.gap_error)),
    }
}

/// One regime for loads held and floating, and for every level of every factor that varies.
fn regimes(results: &[CellResult], names: &[&str]) -> Vec<Regime> {
    let mut regimes = Vec::new();
    let mut add = |factor: &str, level: &str, belongs: &dyn Fn(&CellResult) -> bool| {
        let cells: Vec<&CellResult> = results.iter().filter(|result| belongs(result)).collect();
        if !cells.is_empty() {
            let methods = names.iter().map(|name| method(&cells, name)).collect();
            regimes.push(Regime {
                factor: factor.to_owned(),
                level: level.to_owned(),
                methods,
                limit_rms_ratio: limit(&cells, 0),
                practical_rms_ratio: practical(&cells, 0),
            });
        }
    };
    // Loads that float are a regime of their own: no method on the motor sees them.
    add("load", "held", &|result| !result.floats());
    add("load", "floats", &CellResult::floats);
    for (index, factor) in FACTORS
        .iter()
        .enumerate()
        .filter(|(_, factor)| factor.levels.len() > 1)
    {
        for level in factor.levels {
            add(factor.name, level, &|result| {
                result.cell.level_name(index) == *level
            });
        }
    }
    regimes
}

/// The worst cells of a method by RMS ratio.
fn worst(results: &[CellResult], name: &str) -> Vec<WorstCell> {
    let mut list: Vec<WorstCell> = results
        .iter()
        .filter_map(|cell| {
            Some(WorstCell {
                method: name.to_owned(),
                cell: cell.cell.to_string(),
                ratios: cell.ratios(name)?,
            })
        })
        .collect();
    // In total order a ratio that is no number comes first, where it is seen.
    list.sort_by(|a, b| f64::total_cmp(&b.ratios[0], &a.ratios[0]));
    list.truncate(WORST_CELLS);
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_values_that_occur() {
        let spread = Spread::of((1..=100).map(f64::from)).unwrap();
        assert_eq!(
            spread,
            Spread {
                cells: 100,
                median: 50.0,
                p95: 95.0,
                worst: 100.0
            }
        );
        assert_eq!(
            Spread::of([7.0]).unwrap(),
            Spread {
                cells: 1,
                median: 7.0,
                p95: 7.0,
                worst: 7.0
            }
        );
        assert_eq!(Spread::of([]), None);
    }
}
