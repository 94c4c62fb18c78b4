//! The matrix for people (Markdown) and for other programs (CSV, JSON).

use super::factor::{COUNT, FACTORS};
use super::result::CellResult;
use super::summary::{MethodSummary, Spread, Summary, summary};
use crate::error::StudyError;
use lostmotion_methods::MethodId;
use lostmotion_report::number::{fixed, percent};
use lostmotion_report::page::{CellRatio, MethodCells};
use serde::Serialize;
use std::fmt::Write;

/// Writing to a `String` cannot fail.
macro_rules! put {
    ($out:expr, $($arg:tt)*) => { let _ = writeln!($out, $($arg)*); };
}

/// Ratio beyond which a method has run away; how far says nothing. A choice.
const RUNAWAY_RATIO: f64 = 10.0;
/// Median RMS ratio above which a method does next to nothing in a regime. A choice.
const IDLE_RATIO: f64 = 0.9;
/// Part of a regime's cells in which a method is worse than `none`, from which on it does harm
/// there. A choice.
const HARMFUL_CELL_SHARE: f64 = 0.1;

pub(super) fn capped(ratio: f64) -> String {
    if ratio > RUNAWAY_RATIO {
        "> 1000 %".to_owned()
    } else {
        percent(ratio)
    }
}

fn three(spread: Option<Spread>) -> String {
    spread.map_or("- | - | -".to_owned(), |s| {
        format!(
            "{} | {} | {}",
            capped(s.median),
            capped(s.p95),
            capped(s.worst)
        )
    })
}

fn two(spread: Option<Spread>) -> String {
    spread.map_or("-".to_owned(), |s| {
        format!("{} / {}", capped(s.median), capped(s.p95))
    })
}

/// What each method but `none` leaves in each cell: for the chart of a page.
pub fn left(results: &[CellResult]) -> Vec<MethodCells> {
    let names = results.first().map_or(&[][..], |first| &first.methods);
    let methods = names.iter().map(|figures| figures.method.as_str());
    let compensated = methods.filter(|method| *method != MethodId::NONE.name());
    compensated
        .map(|method| MethodCells {
            method: method.to_owned(),
            cells: results
                .iter()
                .filter_map(|result| {
                    let [ratio, _] = result.ratios(method)?;
                    Some(CellRatio {
                        cell: result.cell.to_string(),
                        ratio,
                        worse: result.worse(method).contains(&true),
                    })
                })
                .collect(),
        })
        .collect()
}

/// The summary as Markdown: a table of all methods, one by regime, the worst cells.
pub fn markdown(results: &[CellResult], what: &str) -> String {
    let sum = summary(results);
    let mut out = String::new();
    put!(out, "# Test matrix of the compensators\n");
    put!(
        out,
        "{} cells ({what}), {:.0} s of machine time with each method. Made by `lostmotion study matrix`; do not edit.\n",
        sum.cells,
        sum.simulated_s
    );
    put!(
        out,
        "The figure: signed contour error with the gap minus that of the same machine without a gap, on cutting moves, after the first four"
    );
    put!(
        out,
        "reversals of each axis, in parts of what `none` leaves. Worse: by more than 0.1 um. Hunting: an oscillation that neither the motion nor `none` explains."
    );
    put!(
        out,
        "Gap: mean error of the estimated half gap while in contact (0 where the method was told the gap). Least possible: what physics leaves, the traverse timed and aimed perfectly."
    );
    put!(
        out,
        "Practical limit: the traverse on a quintic within the drive's torque, the gap known to a hundredth, the load's place to a count of the encoder. Within: cells with no more than 2 % RMS"
    );
    put!(
        out,
        "(10 % in the largest error) of what `none` leaves, or than the practical limit where that is more; who is told the gap, or lucky with a coarse encoder, may be below it.\n"
    );
    // From the whole to the single: methods, regimes, failures, the worst cells, all cells.
    overview(&mut out, &sum);
    by_regime(&mut out, &sum);
    failures(&mut out, &sum);
    put!(out, "\n## Worst cells\n");
    put!(
        out,
        "| method | cell | RMS ratio | max ratio |\n|---|---|--:|--:|"
    );
    for worst in &sum.worst {
        let [rms, max] = worst.ratios;
        put!(
            out,
            "| `{}` | `{}` | {} | {} |",
            worst.method,
            worst.cell,
            capped(rms),
            capped(max)
        );
    }
    cells_markdown(&mut out, results);
    out
}

/// All methods over all cells, and `adaptive` over those whose loads are held.
fn overview(out: &mut String, sum: &Summary) {
    put!(
        out,
        "| method | RMS: median | 95 % | worst | max: median | 95 % | worst | worse RMS | worse max | hunting | at a limit | within: RMS | max | gap: median / 95 % |"
    );
    put!(
        out,
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
    );
    for row in &sum.methods {
        let MethodSummary {
            method,
            worse_rms,
            worse_max,
            hunts,
            saturated,
            within: [rms_within, max_within],
            ..
        } = row;
        let (rms, max, gap) = (
            three(row.rms_ratio),
            three(row.max_ratio),
            two(row.gap_error),
        );
        put!(
            out,
            "| `{method}` | {rms} | {max} | {worse_rms} | {worse_max} | {hunts} | {saturated} | {rms_within} | {max_within} | {gap} |"
        );
    }
    // A floating load cannot be seen from the motor: `adaptive` once more without such cells.
    if let Some(held) = sum.regimes.iter().find(|regime| regime.level == "held")
        && let Some(row) = held
            .methods
            .iter()
            .find(|row| row.method == MethodId::ADAPTIVE.name())
    {
        let MethodSummary {
            worse_rms,
            worse_max,
            hunts,
            saturated,
            within: [rms_within, max_within],
            ..
        } = row;
        let (rms, max, gap) = (
            three(row.rms_ratio),
            three(row.max_ratio),
            two(row.gap_error),
        );
        put!(
            out,
            "| `adaptive`, loads held | {rms} | {max} | {worse_rms} | {worse_max} | {hunts} | {saturated} | {rms_within} | {max_within} | {gap} |"
        );
    }
    // Two rows to hold the methods against: no method can do better, and what may be expected.
    put!(
        out,
        "| least possible | {} | {} | | | | | | | |",
        three(sum.limit_rms_ratio),
        three(sum.limit_max_ratio)
    );
    let [rms, max] = sum.practical_ratio;
    put!(
        out,
        "| practical limit | {} | {} | | | | | | | |",
        three(rms),
        three(max)
    );
}

/// RMS ratio of every method in every regime.
fn by_regime(out: &mut String, sum: &Summary) {
    put!(
        out,
        "\n## By regime\n\nRMS ratio, median / 95 %. Least: what physics leaves whatever the method; practical: the practical limit. Load held or floating: loads float in a cell where without"
    );
    put!(
        out,
        "friction and without need of torque they drift through the gap unseen for more than a twentieth of the time.\n"
    );
    // `none` is the first method and the reference: its ratio is 1, so it gets no column.
    let mut header = "| factor | level | cells | least | practical |".to_owned();
    let mut rule = "|---|---|--:|--:|--:|".to_owned();
    for method in sum.methods.iter().skip(1) {
        let _ = write!(header, " `{}` |", method.method);
        rule.push_str("--:|");
    }
    put!(out, "{header}\n{rule}");
    for regime in &sum.regimes {
        // Cells with a ratio: where `none` leaves next to nothing there is none.
        let cells = regime
            .methods
            .first()
            .and_then(|none| none.rms_ratio)
            .map_or(0, |spread| spread.cells);
        let row: Vec<String> = regime
            .methods
            .iter()
            .skip(1)
            .map(|method| two(method.rms_ratio))
            .collect();
        let (least, best) = (two(regime.limit_rms_ratio), two(regime.practical_rms_ratio));
        put!(
            out,
            "| {} | {} | {cells} | {least} | {best} | {} |",
            regime.factor,
            regime.level,
            row.join(" | ")
        );
    }
}

/// Where each method cannot work, from the figures.
fn failures(out: &mut String, sum: &Summary) {
    put!(out, "\n## Where a method does not work\n");
    put!(
        out,
        "Levels (of gap, friction, inertia and encoder, and motions) at which a method leaves more than 90 % of what `none` leaves in half of the"
    );
    put!(
        out,
        "cells, and at which it is worse than `none` in more than a tenth of them.\n"
    );
    put!(
        out,
        "| method | does next to nothing | does harm |\n|---|---|---|"
    );
    for (index, method) in sum.methods.iter().enumerate().skip(1) {
        // Only factors that describe machine and motion; feed and direction are chosen by the user.
        let levels = |fails: &dyn Fn(&MethodSummary) -> bool| -> String {
            let regimes = sum.regimes.iter().filter(|regime| {
                ["gap", "friction", "inertia", "encoder", "motion"]
                    .contains(&regime.factor.as_str())
            });
            let all: Vec<&str> = regimes
                .filter(|r| r.methods.get(index).is_some_and(fails))
                .map(|r| r.level.as_str())
                .collect();
            if all.is_empty() {
                "-".to_owned()
            } else {
                all.join(", ")
            }
        };
        // In half of the cells next to nothing, or in a tenth of them worse.
        let idle = levels(&|m| m.rms_ratio.is_some_and(|spread| spread.median > IDLE_RATIO));
        // Worse counts where `none` leaves next to nothing, too: out of all cells.
        let harmful = levels(&|m| m.worse_rms as f64 > HARMFUL_CELL_SHARE * m.cells as f64);
        put!(out, "| `{}` | {idle} | {harmful} |", method.method);
    }
}

/// A row a cell and method.
pub fn csv(results: &[CellResult]) -> String {
    let mut out = "cell,".to_owned();
    out.push_str(&FACTORS.map(|factor| factor.name).join(","));
    out.push_str(
        ",duration_s,measured_from_s,reached_mm_min,traverse_ms,limit_max_um,limit_rms_um,floating,encoder_um,best_rms_ratio,best_max_ratio,method,rms_um,max_um,rms_ratio,max_ratio,worse_rms,worse_max,x_rms_um,y_rms_um,gap_error,hunts,saturated\n",
    );
    for cell in results {
        for figures in &cell.methods {
            let levels: Vec<&str> = (0..COUNT)
                .map(|factor| cell.cell.level_name(factor))
                .collect();
            let CellResult {
                duration_s,
                measured_from_s,
                reached_mm_min,
                traverse_ms,
                limit_max_um,
                limit_rms_um,
                floating,
                encoder_um,
                ..
            } = cell;
            // Without limit, ratio or estimate the cells stay empty, and the columns in place.
            let best = cell
                .practical()
                .map_or(",".to_owned(), |[rms, max]| format!("{rms:.5},{max:.5}"));
            let _ = write!(
                out,
                "{},{},{duration_s},{measured_from_s},{reached_mm_min}",
                cell.cell,
                levels.join(",")
            );
            let _ = write!(
                out,
                ",{traverse_ms},{limit_max_um},{limit_rms_um},{floating},{encoder_um},{best},{},{},{}",
                figures.method, figures.rms_um, figures.max_um
            );
            let _ = match cell.ratios(&figures.method) {
                Some([rms, max]) => write!(out, ",{rms:.5},{max:.5}"),
                None => write!(out, ",,"),
            };
            let ([worse_rms, worse_max], [x, y]) =
                (cell.worse(&figures.method), figures.axis_rms_um);
            let gap = figures
                .gap_error
                .map_or(String::new(), |error| error.to_string());
            put!(
                out,
                ",{worse_rms},{worse_max},{x},{y},{gap},{},{}",
                figures.hunts,
                figures.saturated
            );
        }
    }
    out
}

/// The whole answer as data.
#[derive(Clone, Debug, Serialize)]
pub struct Matrix<'a> {
    /// Version of this form.
    pub schema: u32,
    /// Which cells.
    pub what: &'a str,
    /// Distribution per method and regime.
    pub summary: Summary,
    /// Every cell.
    pub results: &'a [CellResult],
}

/// Summary and cells as JSON.
///
/// # Errors
/// None for the types of this crate.
pub fn json(results: &[CellResult], what: &str) -> Result<String, StudyError> {
    let matrix = Matrix {
        schema: 1,
        what,
        summary: summary(results),
        results,
    };
    let mut text = serde_json::to_string_pretty(&matrix)
        .map_err(|error| StudyError::Sink(error.to_string()))?;
    text.push('\n');
    Ok(text)
}

/// Methods shown, where they have been run: told everything, and told nothing.
const METHODS_OF_CELLS: [MethodId; 2] = [MethodId::LOOKUP, MethodId::ADAPTIVE];

/// Appends every cell with its limits beside what the methods that need no scale leave.
fn cells_markdown(out: &mut String, results: &[CellResult]) {
    // A study may have run other methods.
    let ran = |name: &&str| results.first().is_some_and(|cell| cell.of(name).is_some());
    let shown: Vec<&str> = METHODS_OF_CELLS
        .map(MethodId::name)
        .into_iter()
        .filter(ran)
        .collect();
    out.push_str(
        "\n## Each cell with its limits\n\nTraverse: the shortest one with all of the drive's torque. Least: what that leaves. Count: of the encoder. Practical: the practical limit (RMS / largest, of `none`). \
         **Bold**: within.\n\n| cell | `none`: RMS, um | max, um | traverse, ms | least: RMS, um | max, um | count, um | practical |",
    );
    shown.iter().for_each(|name| {
        let _ = write!(out, " `{name}` |");
    });
    out.push_str("\n|---|--:|--:|--:|--:|--:|--:|--:|");
    out.push_str(&"--:|".repeat(shown.len()));
    out.push('\n');
    for cell in results {
        cell_row(out, cell, &shown);
    }
}

/// One cell with its limits.
fn cell_row(out: &mut String, cell: &CellResult, shown: &[&str]) {
    // What is no number is shown as `-`.
    let [rms, max] = cell
        .of(MethodId::NONE.name())
        .map_or([f64::NAN; 2], |none| [none.rms_um, none.max_um]);
    let _ = write!(
        out,
        "| `{}` | {} | {} | {} |",
        cell.cell,
        fixed(rms, 2),
        fixed(max, 2),
        fixed(cell.traverse_ms, 2)
    );
    let _ = write!(
        out,
        " {} | {} | {} |",
        fixed(cell.limit_rms_um, 4),
        fixed(cell.limit_max_um, 3),
        fixed(cell.encoder_um, 4)
    );
    let pair = |[rms, max]: [f64; 2]| format!("{} / {}", capped(rms), capped(max));
    let _ = write!(out, " {} |", cell.practical().map_or("-".to_owned(), pair));
    for name in shown {
        let Some(ratios) = cell.ratios(name) else {
            out.push_str(" - |");
            continue;
        };
        // Bold each for itself: a method may reach the RMS that is wanted and not the largest
        // error.
        let mark = |inside: bool| if inside { "**" } else { "" };
        let [rms, max] = cell.within(name).unwrap_or_default().map(mark);
        let _ = write!(
            out,
            " {rms}{}{rms} / {max}{}{max} |",
            capped(ratios[0]),
            capped(ratios[1])
        );
    }
    out.push('\n');
}
