//! The page of a sweep: what each method leaves, over what is varied, and where it is worst.

use crate::cell::Outcome;
use crate::collect::Finished;
use crate::design::Level;
use crate::error::SweepError;
use crate::manifest::{Cell, Header, Manifest};
use lostmotion_methods::MethodId;
use lostmotion_report::number::{fixed, percent};
use lostmotion_report::page::{CellRatio, MethodCells, study_page};
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Rows of the lists of worst, failed and missing cells. A choice.
const LISTED: usize = 20;
/// Dots of a method in the chart; of more cells as many, evenly among them. A choice.
const MOST_DOTS: usize = 500;
/// Levels up to which each has a row of its own; beyond, values are put into as many parts with a
/// like number of cells. A choice.
const MOST_LEVELS: usize = 10;

/// What is kept of a cell and method.
#[derive(Clone, Copy)]
struct Kept {
    /// Its place; manifests have fewer cells than that.
    cell: u32,
    max_um: f64,
    backlash_um: f64,
    /// What backlash adds, over what it adds with `none`.
    ratio: f64,
    within: bool,
    stopped: bool,
}

/// What is kept of a sweep.
#[derive(Default)]
struct Summary {
    /// For each method, in the order of the manifest, its cells.
    methods: Vec<Vec<Kept>>,
    failed: usize,
    /// The first cells that failed, with the reason.
    reasons: Vec<(usize, String)>,
}

/// The value that a part of the values is not above; 0 for the least.
fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted: Vec<f64> = values
        .iter()
        .copied()
        .filter(|value| value.is_finite())
        .collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    let place = (part * last as f64).round() as usize;
    sorted.get(place.min(last)).copied().unwrap_or(f64::NAN)
}

fn um(value: f64) -> String {
    if value.is_finite() {
        fixed(value, 2)
    } else {
        "-".to_owned()
    }
}

/// A text inside a table of Markdown.
fn cell_text(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    lostmotion_base::text::shortened(line, 120).replace('|', "\\|")
}

impl Summary {
    fn of(manifest: &Manifest, finished: &mut Finished<'_>) -> Result<Summary, SweepError> {
        let mut summary = Summary {
            methods: vec![Vec::new(); manifest.header.methods.len()],
            ..Summary::default()
        };
        finished.each(|index, _, result| {
            match &result.outcome {
                Outcome::Figures(figures) => {
                    let of = |value: Option<f64>| value.unwrap_or(f64::NAN);
                    let none = figures
                        .methods
                        .iter()
                        .find(|method| method.method == MethodId::NONE.name());
                    let none = none.map_or(f64::NAN, |none| of(none.backlash_rms_um));
                    for (kept, method) in summary.methods.iter_mut().zip(&figures.methods) {
                        kept.push(Kept {
                            cell: u32::try_from(index).unwrap_or(u32::MAX),
                            max_um: of(method.max_um),
                            backlash_um: of(method.backlash_rms_um),
                            // Of no backlash nothing can be left.
                            ratio: if none > 0.0 {
                                of(method.backlash_rms_um) / none
                            } else {
                                f64::NAN
                            },
                            within: method.within,
                            stopped: method.stop.is_some(),
                        });
                    }
                }
                Outcome::Error(failed) => {
                    summary.failed += 1;
                    if summary.reasons.len() < LISTED {
                        summary.reasons.push((index, failed.message.clone()));
                    }
                }
            }
            Ok(())
        })?;
        Ok(summary)
    }

    /// The cells and methods with the largest errors, the largest first; each with the place of its method.
    /// Of equal errors the earlier method and cell come first.
    fn worst(&self) -> Vec<(usize, Kept)> {
        let mut worst: Vec<(usize, Kept)> = Vec::with_capacity(LISTED + 1);
        for (method, cells) in self.methods.iter().enumerate() {
            for kept in cells.iter().filter(|kept| kept.max_um.is_finite()) {
                let place = worst.partition_point(|(_, other)| {
                    other.max_um.total_cmp(&kept.max_um) != Ordering::Less
                });
                if place < LISTED {
                    worst.insert(place, (method, *kept));
                    worst.truncate(LISTED);
                }
            }
        }
        worst
    }

    /// What each method leaves in the cells, for the chart.
    fn ratios(&self, manifest: &Manifest) -> Vec<MethodCells> {
        let methods = manifest.header.methods.iter().zip(&self.methods);
        let compared = methods.filter(|(name, _)| name.as_str() != MethodId::NONE.name());
        compared
            .map(|(name, cells)| {
                let mut known: Vec<&Kept> =
                    cells.iter().filter(|kept| kept.ratio.is_finite()).collect();
                known.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
                let step = known.len().div_ceil(MOST_DOTS).max(1);
                MethodCells {
                    method: name.clone(),
                    cells: known
                        .into_iter()
                        .step_by(step)
                        .map(|kept| CellRatio {
                            cell: format!("cell {}", kept.cell),
                            ratio: kept.ratio,
                            worse: kept.ratio > 1.0,
                        })
                        .collect(),
                }
            })
            .collect()
    }
}

/// The page of a sweep for a browser.
///
/// # Errors
/// Those of the files of results.
pub fn page(manifest: &Manifest, finished: &mut Finished<'_>) -> Result<String, SweepError> {
    let summary = Summary::of(manifest, finished)?;
    let (missing, first_missing) = finished.missing(LISTED)?;
    let worst = summary.worst();
    let listed = worst.iter().map(|(_, kept)| kept.cell as usize);
    let reasons = summary.reasons.iter().map(|(index, _)| *index);
    let cells = manifest.pick(&listed.chain(reasons).collect())?;
    let inputs = |index: usize| {
        let cell = cells.get(&index);
        cell.map_or(String::new(), |cell| inputs(&manifest.header, cell))
    };
    let header = &manifest.header;
    let mut out = String::new();
    let _ = writeln!(
        out,
        "Cells: {}; programs: {}, machines: {}, methods side by side: {}. Cells that could not be run: {}, missing: {}. Errors are contour errors of cutting moves, in um.\n",
        header.cells,
        header.programs.len(),
        header.machines.len(),
        header.methods.len(),
        summary.failed,
        missing
    );
    methods(&mut out, manifest, &summary);
    for coordinate in 0..header.vary.len() {
        by_level(&mut out, manifest, &summary, coordinate)?;
    }
    list_worst(&mut out, manifest, &worst, inputs);
    if !summary.reasons.is_empty() {
        let _ = writeln!(
            out,
            "\n## Cells that could not be run\n\n| cell | inputs | why |\n|--:|---|---|"
        );
        for (index, why) in &summary.reasons {
            let _ = writeln!(out, "| {index} | {} | {} |", inputs(*index), cell_text(why));
        }
        more(&mut out, summary.failed);
    }
    if missing > 0 {
        let _ = writeln!(
            out,
            "\n## Missing cells\n\n| cell | key | inputs |\n|--:|---|---|"
        );
        for (index, cell) in &first_missing {
            let _ = writeln!(
                out,
                "| {index} | {} | {} |",
                cell.key,
                self::inputs(header, cell)
            );
        }
        more(&mut out, missing);
    }
    Ok(study_page(
        &format!("Sweep {}", header.file),
        &summary.ratios(manifest),
        &out,
    ))
}

/// Says of a list that it goes on.
fn more(out: &mut String, all: usize) {
    if all > LISTED {
        let _ = writeln!(out, "\n{} more; the table has all.", all - LISTED);
    }
}

fn methods(out: &mut String, manifest: &Manifest, summary: &Summary) {
    let _ = writeln!(
        out,
        "## Methods\n\n| method | cells | within tolerance | stopped | largest error, median | 95 % | worst | backlash RMS, median | of none, median |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|"
    );
    for (name, cells) in manifest.header.methods.iter().zip(&summary.methods) {
        let of = |what: fn(&Kept) -> f64| cells.iter().map(what).collect::<Vec<f64>>();
        let (most, backlash, ratio) = (
            of(|kept| kept.max_um),
            of(|kept| kept.backlash_um),
            of(|kept| kept.ratio),
        );
        let within = cells.iter().filter(|kept| kept.within).count();
        let share = if cells.is_empty() {
            "-".to_owned()
        } else {
            percent(within as f64 / cells.len() as f64)
        };
        let left = quantile(&ratio, 0.5);
        let _ = writeln!(
            out,
            "| {name} | {} | {share} | {} | {} | {} | {} | {} | {} |",
            cells.len(),
            cells.iter().filter(|kept| kept.stopped).count(),
            um(quantile(&most, 0.5)),
            um(quantile(&most, 0.95)),
            um(quantile(&most, 1.0)),
            um(quantile(&backlash, 0.5)),
            if left.is_finite() {
                percent(left)
            } else {
                "-".to_owned()
            }
        );
    }
}

/// A value of a coordinate in its order: numbers by their size, then everything else by its text.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Number(f64),
    Other(String),
}

impl Value {
    fn of(level: &Level) -> Value {
        match level {
            Level::Number(number) => Value::Number(*number),
            other => Value::Other(other.to_string()),
        }
    }

    fn order(&self, other: &Value) -> Ordering {
        match (self, other) {
            (Value::Number(a), Value::Number(b)) => a.total_cmp(b),
            (Value::Number(_), Value::Other(_)) => Ordering::Less,
            (Value::Other(_), Value::Number(_)) => Ordering::Greater,
            (Value::Other(a), Value::Other(b)) => a.cmp(b),
        }
    }

    fn text(&self) -> String {
        match self {
            Value::Number(number) => Level::Number(*number).to_string(),
            Value::Other(text) => text.clone(),
        }
    }

    /// In few digits.
    fn short(&self) -> String {
        match self {
            Value::Number(number) => digits(*number).unwrap_or_else(|| self.text()),
            Value::Other(text) => text.clone(),
        }
    }
}

/// The values of a coordinate in groups.
struct Groups {
    /// What each is called.
    names: Vec<String>,
    /// The group of each cell of the manifest: there are no more than [`MOST_LEVELS`].
    of_cell: Vec<u8>,
}

impl Groups {
    fn of(manifest: &Manifest, coordinate: usize) -> Result<Groups, SweepError> {
        // Numbers may be as many as cells; texts stand in the sweep file.
        let (mut numbers, mut others) = (Vec::new(), BTreeSet::new());
        for cell in manifest.cells()? {
            match cell?.values.get(coordinate).map(Value::of) {
                Some(Value::Number(number)) => numbers.push(number),
                Some(Value::Other(text)) => drop(others.insert(text)),
                None => {}
            }
        }
        numbers.sort_unstable_by(f64::total_cmp);
        numbers.dedup_by_key(|number| number.to_bits());
        let numbers = numbers.into_iter().map(Value::Number);
        let levels: Vec<Value> = numbers
            .chain(others.into_iter().map(Value::Other))
            .collect();
        let step = levels.len().div_ceil(MOST_LEVELS).max(1);
        let names = levels.chunks(step).map(|part| match part {
            [one] if step == 1 => one.text(),
            [first, .., last] => format!("{} to {}", first.short(), last.short()),
            [one] => format!("{0} to {0}", one.short()),
            [] => String::new(),
        });
        let mut groups = Groups {
            names: names.collect(),
            of_cell: Vec::new(),
        };
        for cell in manifest.cells()? {
            let value = cell?.values.get(coordinate).map(Value::of);
            let place = value.and_then(|value| {
                let found = levels.binary_search_by(|level| level.order(&value));
                found.ok().and_then(|level| u8::try_from(level / step).ok())
            });
            groups.of_cell.push(place.unwrap_or(u8::MAX));
        }
        Ok(groups)
    }
}

/// A number in four digits; `None` of what is no number, or has no more by itself.
fn digits(number: f64) -> Option<String> {
    if !number.is_finite() || number.to_string().len() <= 6 {
        return None;
    }
    Some(match number.abs() {
        size if !(1e-3..1e6).contains(&size) => format!("{number:.3e}"),
        size if size < 1.0 => format!("{number:.4}"),
        size if size < 10.0 => format!("{number:.3}"),
        size if size < 100.0 => format!("{number:.2}"),
        size if size < 1000.0 => format!("{number:.1}"),
        _ => format!("{number:.0}"),
    })
}

fn by_level(
    out: &mut String,
    manifest: &Manifest,
    summary: &Summary,
    coordinate: usize,
) -> Result<(), SweepError> {
    let header = &manifest.header;
    let name = header
        .vary
        .get(coordinate)
        .map_or("", |coordinate| coordinate.name.as_str());
    let _ = write!(
        out,
        "\n## Over {}\n\nMedian of the largest error of each cell, and what 95 % of them are not above.\n\n| {} | cells |",
        cell_text(name),
        cell_text(name)
    );
    for method in &header.methods {
        let _ = write!(out, " {method} | 95 % |");
    }
    let _ = writeln!(
        out,
        "\n|---|--:|{}",
        "--:|--:|".repeat(header.methods.len())
    );
    let groups = Groups::of(manifest, coordinate)?;
    for (group, text) in groups.names.iter().enumerate() {
        let is_member = |at: &u8| usize::from(*at) == group;
        let count = groups.of_cell.iter().filter(|at| is_member(at)).count();
        let _ = write!(out, "| {} | {count} |", cell_text(text));
        for kept in &summary.methods {
            let members = kept.iter().filter(|kept| {
                let at = groups.of_cell.get(kept.cell as usize);
                at.is_some_and(is_member)
            });
            let most: Vec<f64> = members.map(|kept| kept.max_um).collect();
            let _ = write!(
                out,
                " {} | {} |",
                um(quantile(&most, 0.5)),
                um(quantile(&most, 0.95))
            );
        }
        out.push('\n');
    }
    Ok(())
}

fn list_worst(
    out: &mut String,
    manifest: &Manifest,
    worst: &[(usize, Kept)],
    inputs: impl Fn(usize) -> String,
) {
    let _ = writeln!(
        out,
        "\n## Worst cells\n\n| cell | method | largest error | within | inputs |\n|--:|---|--:|---|---|"
    );
    for (method, kept) in worst {
        let within = match (kept.stopped, kept.within) {
            (true, _) => "stopped",
            (false, true) => "yes",
            (false, false) => "no",
        };
        let method = manifest
            .header
            .methods
            .get(*method)
            .map_or("", String::as_str);
        let _ = writeln!(
            out,
            "| {} | {method} | {} | {within} | {} |",
            kept.cell,
            um(kept.max_um),
            inputs(kept.cell as usize)
        );
    }
}

/// The inputs of a cell by their names.
fn inputs(header: &Header, cell: &Cell) -> String {
    let mut text = format!("{} on {}", header.program(cell), header.machine(cell));
    for (coordinate, level) in header.vary.iter().zip(&cell.values) {
        let few = match level {
            Level::Number(number) => digits(*number),
            _ => None,
        };
        let level = few.unwrap_or_else(|| level.to_string());
        let _ = write!(text, ", {}={level}", coordinate.name);
    }
    cell_text(&text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_in_four_digits() {
        for (number, text) in [
            (39.995_117_187_5, "40.00"),
            (3.994_140_625, "3.994"),
            (0.012_345_678, "0.0123"),
            (1.234_567_89e-7, "1.235e-7"),
            (123_456.789, "123457"),
        ] {
            assert_eq!(digits(number).as_deref(), Some(text));
        }
        assert_eq!(digits(12.5).or(digits(f64::NAN)), None);
    }

    #[test]
    fn quantiles_are_values_of_the_list() {
        let values = [3.0, f64::NAN, 1.0, 2.0, 5.0, 4.0];
        let found = [0.0, 0.5, 0.75, 1.0].map(|part| quantile(&values, part));
        assert_eq!(found, [1.0, 3.0, 4.0, 5.0]);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
