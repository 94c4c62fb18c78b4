//! The page of a sweep: what each method leaves, over what is varied, and where it is worst.

use crate::cell::Outcome;
use crate::collect::Finished;
use crate::design::Level;
use crate::error::SweepError;
use crate::manifest::{Cell, Manifest};
use lostmotion_methods::MethodId;
use lostmotion_report::number::{fixed, percent};
use lostmotion_report::page::{CellRatio, MethodCells, study_page};
use std::collections::BTreeMap;
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
    cell: usize,
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
                            cell: index,
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
    let missing: Vec<_> = finished.missing().collect();
    let header = &manifest.header;
    let mut out = String::new();
    let _ = writeln!(
        out,
        "Cells: {}; programs: {}, machines: {}, methods side by side: {}. Cells that could not be run: {}, missing: {}. Errors are contour errors of cutting moves, in um.\n",
        manifest.cells.len(),
        header.programs.len(),
        header.machines.len(),
        header.methods.len(),
        summary.failed,
        missing.len()
    );
    methods(&mut out, manifest, &summary);
    for coordinate in 0..header.vary.len() {
        by_level(&mut out, manifest, &summary, coordinate);
    }
    worst(&mut out, manifest, &summary);
    if !summary.reasons.is_empty() {
        let _ = writeln!(
            out,
            "\n## Cells that could not be run\n\n| cell | inputs | why |\n|--:|---|---|"
        );
        for (index, why) in &summary.reasons {
            let _ = writeln!(
                out,
                "| {index} | {} | {} |",
                inputs(manifest, *index),
                cell_text(why)
            );
        }
        more(&mut out, summary.failed);
    }
    if !missing.is_empty() {
        let _ = writeln!(
            out,
            "\n## Missing cells\n\n| cell | key | inputs |\n|--:|---|---|"
        );
        for (index, cell) in missing.iter().take(LISTED) {
            let _ = writeln!(
                out,
                "| {index} | {} | {} |",
                cell.key,
                inputs(manifest, *index)
            );
        }
        more(&mut out, missing.len());
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

/// Groups of cells by the value of a coordinate, each with what it is called.
fn groups(manifest: &Manifest, coordinate: usize) -> Vec<(String, Vec<usize>)> {
    let level = |cell: &Cell| cell.values.get(coordinate).cloned();
    let mut by_text: BTreeMap<String, (f64, Vec<usize>)> = BTreeMap::new();
    for (index, cell) in manifest.cells.iter().enumerate() {
        let Some(level) = level(cell) else { continue };
        let order = match level {
            Level::Number(number) => number,
            _ => f64::NAN,
        };
        by_text
            .entry(level.to_string())
            .or_insert((order, Vec::new()))
            .1
            .push(index);
    }
    let mut levels: Vec<_> = by_text
        .into_iter()
        .map(|(text, (order, cells))| (text, order, cells))
        .collect();
    // Numbers by their size; texts stay in their order.
    levels.sort_by(|a, b| a.1.total_cmp(&b.1));
    if levels.len() <= MOST_LEVELS {
        return levels
            .into_iter()
            .map(|(text, _, cells)| (text, cells))
            .collect();
    }
    let step = levels.len().div_ceil(MOST_LEVELS);
    levels
        .chunks(step)
        .map(|part| {
            let ends = part.first().zip(part.last());
            let name = ends.map_or(String::new(), |(first, last)| {
                format!("{} to {}", short(first), short(last))
            });
            (
                name,
                part.iter()
                    .flat_map(|(_, _, cells)| cells.iter().copied())
                    .collect(),
            )
        })
        .collect()
}

/// A level in few digits.
fn short((text, number, _): &(String, f64, Vec<usize>)) -> String {
    digits(*number).unwrap_or_else(|| text.clone())
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

fn by_level(out: &mut String, manifest: &Manifest, summary: &Summary, coordinate: usize) {
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
    for (text, cells) in groups(manifest, coordinate) {
        let _ = write!(out, "| {} | {} |", cell_text(&text), cells.len());
        let mut is_member = vec![false; manifest.cells.len()];
        for cell in cells {
            if let Some(member) = is_member.get_mut(cell) {
                *member = true;
            }
        }
        for kept in &summary.methods {
            let members = kept
                .iter()
                .filter(|kept| is_member.get(kept.cell) == Some(&true));
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
}

fn worst(out: &mut String, manifest: &Manifest, summary: &Summary) {
    let methods = manifest.header.methods.iter().zip(&summary.methods);
    let mut all: Vec<(&str, &Kept)> = methods
        .flat_map(|(name, cells)| cells.iter().map(move |kept| (name.as_str(), kept)))
        .filter(|(_, kept)| kept.max_um.is_finite())
        .collect();
    // Stable: of equal errors the earlier cell comes first.
    all.sort_by(|a, b| b.1.max_um.total_cmp(&a.1.max_um));
    let _ = writeln!(
        out,
        "\n## Worst cells\n\n| cell | method | largest error | within | inputs |\n|--:|---|--:|---|---|"
    );
    for (method, kept) in all.into_iter().take(LISTED) {
        let within = match (kept.stopped, kept.within) {
            (true, _) => "stopped",
            (false, true) => "yes",
            (false, false) => "no",
        };
        let _ = writeln!(
            out,
            "| {} | {method} | {} | {within} | {} |",
            kept.cell,
            um(kept.max_um),
            inputs(manifest, kept.cell)
        );
    }
}

/// The inputs of a cell by their names.
fn inputs(manifest: &Manifest, index: usize) -> String {
    let header = &manifest.header;
    let Some(cell) = manifest.cells.get(index) else {
        return String::new();
    };
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
