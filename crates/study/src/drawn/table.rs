//! The drawn cells for people: one table of methods, one of cells.

use super::run::{DrawnFigures, DrawnResult, Part};
use lostmotion_methods::MethodId;
use lostmotion_report::number::{fixed, percent};
use lostmotion_report::page::{CellRatio, MethodCells};
use std::fmt::Write;

/// Contour errors may be larger than those of `none` by this much before a method counts as worse:
/// share of the RMS, share of the maximum and um on top. A choice: below it nobody can measure it.
const WORSE: (f64, f64, f64) = (1.02, 1.02, 0.5);

/// Whether a method leaves a worse contour than no compensation.
fn is_worse(with: &Part, none: &Part) -> bool {
    let within = with.contour_rms <= WORSE.0 * none.contour_rms
        && with.contour_max <= WORSE.1 * none.contour_max + WORSE.2;
    // Not a number is worse, too.
    !within
}

/// The value below which a share of the sorted values lies, by rank.
fn at(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted
        .get(rank.saturating_sub(1))
        .copied()
        .unwrap_or(f64::NAN)
}

/// A figure of a method over that of `none`, sorted, in the cells in which `none` leaves any.
fn ratios(
    results: &[DrawnResult],
    method: usize,
    of: fn(&DrawnFigures) -> Part,
    figure: fn(&Part) -> f64,
) -> Vec<f64> {
    let mut ratios: Vec<f64> = results
        .iter()
        .filter_map(|result| {
            let [with, none] =
                [result.methods.get(method)?, result.none()?].map(|figures| figure(&of(figures)));
            (none > 0.0).then(|| with / none)
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios
}

/// A limit over what `none` leaves, sorted: RMS (0) or largest (1).
fn limits(results: &[DrawnResult], of: fn(&DrawnResult) -> [f64; 2], which: usize) -> Vec<f64> {
    let mut ratios: Vec<f64> = results
        .iter()
        .filter_map(|result| {
            let none = result.none()?.whole;
            let none = [none.backlash_rms, none.backlash_max];
            let none = none.get(which).copied().filter(|none| *none > 0.0)?;
            Some(of(result).get(which)? / none)
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios
}

/// Median, 95th percentile and the largest, each behind a bar.
fn spread(sorted: &[f64]) -> String {
    let [median, high, most] = [0.5, 0.95, 1.0].map(|share| percent(at(sorted, share)));
    format!("{median} | {high} | {most} |")
}

/// As Markdown: what each method leaves of what `none` leaves, cold and warm, and in how many cells
/// the contour is worse than with `none`; the worst cells of methods that learn, with the cause;
/// then the cells by name.
pub fn markdown(results: &[DrawnResult], what: &str) -> String {
    let mut out = format!(
        "{}, {what}\n\nAll over `none`; median, 95 % and the largest of the cells. Warm: the axes were commissioned for a minute each and start from what they learned. Worse: cells whose contour error is larger than with `none` (RMS 2 %, maximum 2 % and 0.5 um).\n\n",
        count_of(results.len())
    );
    out.push_str("| method | backlash RMS | p95 | worst | second half | p95 | worst | backlash max | p95 | worst | contour RMS | p95 | worst | contour max | p95 | worst | worse | worse if told wrong |\n|---");
    out.push_str(&"|--:".repeat(17));
    out.push_str("|\n");
    let names = results.first().map_or(&[][..], |first| &first.methods);
    for (index, method) in names.iter().enumerate().skip(1) {
        let whole = |figure| spread(&ratios(results, index, |figures| figures.whole, figure));
        let second = ratios(
            results,
            index,
            |figures| figures.second_half,
            |part| part.backlash_rms,
        );
        let count = |of: fn(&DrawnFigures) -> Part| {
            let worse = results.iter().filter(|result| {
                let pair = (result.methods.get(index), result.none());
                matches!(pair, (Some(with), Some(none)) if is_worse(&of(with), &none.whole))
            });
            worse.count()
        };
        let told = results
            .iter()
            .filter_map(|result| result.methods.get(index))
            .any(|figures| figures.misled != Part::default());
        let misled = if told {
            count(|figures| figures.misled).to_string()
        } else {
            "-".to_owned()
        };
        let _ = writeln!(
            out,
            "| `{}` | {} {} {} {} {} {} | {misled} |",
            method.name(),
            whole(|part| part.backlash_rms),
            spread(&second),
            whole(|part| part.backlash_max),
            whole(|part| part.contour_rms),
            whole(|part| part.contour_max),
            count(|figures| figures.whole),
        );
    }
    let limit = |of: fn(&DrawnResult) -> [f64; 2]| {
        let [rms, max] = [0, 1].map(|which| spread(&limits(results, of, which)));
        format!("{rms} | | | {max} | | | | | | | |")
    };
    let _ = writeln!(
        out,
        "| limit of a cold start | {}\n| practical limit | {}\n\nLimit of a cold start: `lookup` that knows each axis exactly from its first change of flank on; no method that learns can know a gap before the motor has crossed it.",
        limit(|result| result.cold_um),
        limit(|result| result.practical_um),
    );
    let _ = writeln!(out, "\n{}", recommended(results));
    for (index, method) in names.iter().enumerate() {
        // Of methods that learn the time line is known, and with it the cause.
        if results.iter().any(|result| {
            let of = result.methods.get(index);
            of.is_some_and(|figures| !figures.told.is_empty())
        }) {
            out.push_str(&worst(results, index, &method.name()));
        }
    }
    out.push_str(&cells(results));
    out
}

/// What each method but `none` leaves in each cell, over the whole program: for the chart of a page.
pub fn left(results: &[DrawnResult]) -> Vec<MethodCells> {
    let names = results.first().map_or(&[][..], |first| &first.methods);
    let of = |(index, method): (usize, &DrawnFigures)| MethodCells {
        method: method.name(),
        cells: results
            .iter()
            .filter_map(|result| {
                let (with, none) = (result.methods.get(index)?, result.none()?);
                Some(CellRatio {
                    cell: result.name.clone(),
                    ratio: with.whole.backlash_rms / none.whole.backlash_rms,
                    worse: is_worse(&with.whole, &none.whole),
                })
            })
            .collect(),
    };
    names.iter().enumerate().skip(1).map(of).collect()
}

/// Cells that are listed with their cause.
const WORST_CELLS: usize = 10;

/// The worst cells of a method by the backlash RMS over that of `none`, and all that are worse, with
/// the cause.
fn worst(results: &[DrawnResult], index: usize, name: &str) -> String {
    let lookup = MethodId::LOOKUP.name();
    let mut rows: Vec<(f64, &DrawnResult, &DrawnFigures, &DrawnFigures)> = results
        .iter()
        .filter_map(|result| {
            let (with, none) = (result.methods.get(index)?, result.none()?);
            let ratio = with.whole.backlash_rms / none.whole.backlash_rms;
            Some((ratio, result, with, none))
        })
        .collect();
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut out = format!(
        "\n## The worst cells of `{name}`\n\n| cell | backlash RMS | max | contour RMS | max | `{lookup}`: backlash RMS | practical limit | cause |\n|---|--:|--:|--:|--:|--:|--:|---|\n"
    );
    for (place, (ratio, result, with, none)) in rows.into_iter().enumerate() {
        let is_worse = is_worse(&with.whole, &none.whole);
        if place >= WORST_CELLS && !is_worse {
            continue;
        }
        let over = |figure: fn(&Part) -> f64| percent(figure(&with.whole) / figure(&none.whole));
        let told = result.methods.iter().find(|method| method.method == lookup);
        let _ = writeln!(
            out,
            "| {}{} | {} | {} | {} | {} | {} | {} | {} |",
            result.name,
            if is_worse { " (worse)" } else { "" },
            percent(ratio),
            over(|part| part.backlash_max),
            over(|part| part.contour_rms),
            over(|part| part.contour_max),
            told.map_or("-".to_owned(), |told| percent(
                told.whole.backlash_rms / none.whole.backlash_rms
            )),
            percent(result.practical_um[0] / none.whole.backlash_rms),
            if with.cause.is_empty() {
                "-"
            } else {
                &with.cause
            },
        );
    }
    out
}

/// How good the recommendation is.
fn recommended(results: &[DrawnResult]) -> String {
    let mut worse = Vec::new();
    let mut shares = Vec::new();
    for result in results {
        let Some(name) = &result.recommended else {
            continue;
        };
        let with = result.methods.iter().find(|m| m.method == *name);
        if let (Some(with), Some(none)) = (with, result.none()) {
            shares.push(with.whole.contour_rms / none.whole.contour_rms);
            if is_worse(&with.whole, &none.whole) {
                worse.push(result.name.as_str());
            }
        }
    }
    shares.sort_by(f64::total_cmp);
    let named = if worse.is_empty() {
        String::new()
    } else {
        format!(": {}", worse.join(", "))
    };
    format!(
        "Recommended: contour RMS {} of that of `none` in the median, {} at worst; worse than `none` in {}{named}.",
        percent(at(&shares, 0.5)),
        percent(at(&shares, 1.0)),
        count_of(worse.len())
    )
}

/// A number of cells in words.
fn count_of(cells: usize) -> String {
    format!("{cells} {}", if cells == 1 { "cell" } else { "cells" })
}

/// One row a cell: what it is, what `none` leaves, and the ratio of each method.
fn cells(results: &[DrawnResult]) -> String {
    let names = results.first().map_or(&[][..], |first| &first.methods);
    let mut out = "\n## Cells\n\n| cell | gaps, um | friction, % | inertia | encoder | feed-forward | s | `none`: contour max | backlash RMS |".to_owned();
    for method in names.iter().skip(1) {
        let _ = write!(out, " `{}` |", method.name());
    }
    out.push_str(" recommended |\n|---|---|---|---|--:|---|--:|--:|--:|");
    out.push_str(&"--:|".repeat(names.len().saturating_sub(1)));
    out.push_str("---|\n");
    for result in results {
        let traits = &result.traits;
        let pair = |[x, y]: [f64; 2], decimals: usize| {
            format!("{}, {}", fixed(x, decimals), fixed(y, decimals))
        };
        let none = result.none().map(|none| none.whole).unwrap_or_default();
        let _ = write!(
            out,
            "| {} | {} | {} | {} | 2^{} | {} | {} | {} | {} |",
            result.name,
            pair(traits.gap_um, 1),
            pair(traits.friction.map(|share| 100.0 * share), 1),
            pair(traits.inertia_ratio, 1),
            traits.encoder_bits,
            if traits.feed_forward { "yes" } else { "no" },
            fixed(result.duration_s, 0),
            fixed(none.contour_max, 1),
            fixed(none.backlash_rms, 2),
        );
        for method in result.methods.iter().skip(1) {
            let ratio = percent(method.whole.backlash_rms / none.backlash_rms);
            let mark = if is_worse(&method.whole, &none) {
                " (worse)"
            } else {
                ""
            };
            let _ = write!(out, " {ratio}{mark} |");
        }
        let _ = writeln!(out, " {} |", result.recommended.as_deref().unwrap_or("-"));
    }
    out
}
