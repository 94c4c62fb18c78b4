//! The drawn cells for people: one table of methods, one of cells.

use super::run::{DrawnFigures, DrawnResult, Part};
use lostmotion_report::number::{fixed, percent};
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

/// Ratios of the backlash RMS to that of `none`, sorted, in the cells in which there is any.
fn ratios(results: &[DrawnResult], method: usize, of: fn(&DrawnFigures) -> Part) -> Vec<f64> {
    let mut ratios: Vec<f64> = results
        .iter()
        .filter_map(|result| {
            let [with, none] = [result.methods.get(method)?, result.none()?]
                .map(|figures| of(figures).backlash_rms);
            (none > 0.0).then(|| with / none)
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios
}

/// As Markdown: what each method leaves of the backlash RMS of `none`, and in how many cells the
/// contour is worse than with `none`; then the cells by name.
pub fn markdown(results: &[DrawnResult], what: &str) -> String {
    let mut out = format!(
        "{} cells, {what}\n\nBacklash RMS over that of `none`; worse: cells whose contour error is larger than with `none` (RMS 2 %, maximum 2 % and 0.5 um).\n\n",
        results.len()
    );
    out.push_str("| method | whole: median | p95 | worst | second half: median | p95 | worse | worse if told wrong |\n|---|--:|--:|--:|--:|--:|--:|--:|\n");
    let names = results.first().map_or(&[][..], |first| &first.methods);
    for (index, method) in names.iter().enumerate().skip(1) {
        let whole = ratios(results, index, |figures| figures.whole);
        let second = ratios(results, index, |figures| figures.second_half);
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
            "| `{}` | {} | {} | {} | {} | {} | {} | {misled} |",
            method.method,
            percent(at(&whole, 0.5)),
            percent(at(&whole, 0.95)),
            percent(at(&whole, 1.0)),
            percent(at(&second, 0.5)),
            percent(at(&second, 0.95)),
            count(|figures| figures.whole),
        );
    }
    let _ = writeln!(out, "\n{}", recommended(results));
    out.push_str(&cells(results));
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
        "Recommended: contour RMS {} of that of `none` in the median, {} at worst; worse than `none` in {} cells{named}.",
        percent(at(&shares, 0.5)),
        percent(at(&shares, 1.0)),
        worse.len()
    )
}

/// One row a cell: what it is, what `none` leaves, and the ratio of each method.
fn cells(results: &[DrawnResult]) -> String {
    let names = results.first().map_or(&[][..], |first| &first.methods);
    let mut out = "\n| cell | gaps, um | friction, % | inertia | encoder | feed-forward | s | `none`: contour max | backlash RMS |".to_owned();
    for method in names.iter().skip(1) {
        let _ = write!(out, " `{}` |", method.method);
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
