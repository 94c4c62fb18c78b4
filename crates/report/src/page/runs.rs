//! Several runs side by side as a page: figures, differences to the first, worst blocks.

use super::data::escape;
use super::html::{file_name, foot, head, meter};
use super::picture::signed;
use crate::number::{duration, error, fixed, plain};
use crate::runs::{NamedRun, worst, worst_blocks};
use crate::text::{stop_place, stop_reason};
use lostmotion_sim::results::MethodResult;
use std::fmt::Write;

/// Most blocks in the table. A choice, as on the page of one run.
const MOST_BLOCKS: usize = 20;

/// Writes the page of several runs, of each the method that decides. It needs no scripts and no
/// network; runs are told apart by their names.
pub fn runs_page(runs: &[NamedRun]) -> String {
    let mut out = String::new();
    head(&mut out, &format!("{} runs side by side", runs.len()));
    let _ = writeln!(
        out,
        "<main>\n<header><h1>{} runs side by side</h1></header>",
        runs.len()
    );
    figures(&mut out, runs);
    bars(&mut out, runs);
    blocks(&mut out, runs);
    axes(&mut out, runs);
    foot(&mut out, "");
    out
}

/// Runs with the method that decides.
fn decided(runs: &[NamedRun]) -> impl Iterator<Item = (&NamedRun, &MethodResult)> {
    runs.iter().filter_map(|named| Some((named, named.main()?)))
}

fn figures(out: &mut String, runs: &[NamedRun]) {
    out.push_str("<section id=\"runs\"><h2>Verdicts</h2>\n<div class=\"scroll\"><table><thead><tr><th>run<th>program<th>machine<th>method<th class=\"n\">max \u{b5}m<th class=\"n\">to the first<th class=\"n\">RMS<th class=\"n\">by backlash<th class=\"n\">cycle time<th>verdict<th>worst place</tr></thead><tbody>\n");
    let first = runs.first().and_then(NamedRun::main);
    for (index, (named, result)) in decided(runs).enumerate() {
        let run = &named.run;
        let _ = write!(
            out,
            "<tr><th scope=\"row\">{}<td>{}<td>{}<td>{}",
            escape(&named.name),
            escape(file_name(&run.program.name)),
            escape(&run.machine),
            escape(&result.method)
        );
        // Figures up to a stop are no figures of the whole program.
        if let Some(stop) = &result.stop {
            let _ = writeln!(
                out,
                "<td colspan=\"5\">-<td class=\"bad\">stops {}<td>{}</tr>",
                escape(&stop_place(stop)),
                escape(&stop_reason(stop))
            );
            continue;
        }
        let change = first
            .filter(|first| index > 0 && first.stop.is_none())
            .map_or("-".to_owned(), |first| {
                signed(result.cutting.max - first.cutting.max)
            });
        let (class, word) = if result.within_tolerance {
            ("good", "within")
        } else {
            ("bad", "outside")
        };
        let place = worst(result).map_or(String::new(), |block| {
            let line = block.block.span.line;
            format!("line {line}, {}", escape(&block.cause.to_string()))
        });
        let _ = writeln!(
            out,
            "<td class=\"n\">{}<td class=\"n\">{change}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"{class}\">{word} {} \u{b5}m<td>{place}</tr>",
            error(result.cutting.max),
            error(result.cutting.rms),
            error(result.backlash.max),
            duration(run.plan.duration_s),
            plain(run.tolerance_um),
        );
    }
    out.push_str("</tbody></table></div>\n<p class=\"note\"><i>To the first</i> is the largest error less that of the first run, \u{b5}m: below 0 is better.</p>\n</section>\n");
}

/// The largest error of each run beside its tolerance.
fn bars(out: &mut String, runs: &[NamedRun]) {
    out.push_str(
        "<section id=\"bars\"><h2>Largest error against the tolerance</h2>\n<div class=\"places\">",
    );
    for (named, result) in decided(runs) {
        let _ = write!(
            out,
            "<figure class=\"place\"><figcaption><b>{}</b> {} \u{b5}m</figcaption>",
            escape(&named.name),
            error(result.cutting.max)
        );
        meter(out, result.cutting.max, named.run.tolerance_um);
        out.push_str("</figure>");
    }
    out.push_str("</div>\n<p class=\"note\">Each bar has a scale of its own: what counts is how far it is from its mark.</p>\n</section>\n");
}

fn blocks(out: &mut String, runs: &[NamedRun]) {
    let rows = worst_blocks(runs, MOST_BLOCKS);
    if rows.is_empty() {
        return;
    }
    out.push_str("<section id=\"worst\"><h2>Worst blocks, \u{b5}m</h2>\n<div class=\"scroll\"><table><thead><tr><th class=\"n\">line");
    for named in runs {
        let _ = write!(out, "<th class=\"n\">{}", escape(&named.name));
    }
    out.push_str("<th>block</tr></thead><tbody>\n");
    for row in rows {
        let _ = write!(out, "<tr><td class=\"n\">{}", escape(&row.line));
        for (um, named) in row.max_um.iter().zip(runs) {
            let is_out = um.is_some_and(|um| um.abs() > named.run.tolerance_um);
            let class = if is_out { " bad" } else { "" };
            let text = um.map_or("-".to_owned(), signed);
            let _ = write!(out, "<td class=\"n{class}\">{text}");
        }
        let _ = writeln!(out, "<td class=\"code\">{}</tr>", escape(&row.text));
    }
    out.push_str("</tbody></table></div>\n<p class=\"note\">Blocks of the same line and text are one block. - : not among the worst that the run lists. Positive: left of the direction of travel.</p>\n</section>\n");
}

/// Following errors of the axes, which tell machines apart.
fn axes(out: &mut String, runs: &[NamedRun]) {
    out.push_str("<section id=\"axes\"><h2>Axes</h2>\n<div class=\"scroll\"><table><thead><tr><th>run<th>axis<th class=\"n\">gap<th class=\"n\">following max<th class=\"n\">without gap<th class=\"n\">reversals<th class=\"n\">peak speed</tr></thead><tbody>\n");
    for (named, result) in decided(runs) {
        for axis in &result.axes {
            let (small, unit) = match axis.unit.as_str() {
                "mdeg" => ("mdeg", "deg"),
                _ => ("\u{b5}m", "mm"),
            };
            let _ = writeln!(
                out,
                "<tr><th scope=\"row\">{}<td>{}<td class=\"n\">{} {small}<td class=\"n\">{} {small}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{} {unit}/s</tr>",
                escape(&named.name),
                axis.axis.letter(),
                error(axis.gap),
                error(axis.following.max),
                error(axis.following_without_gap.max),
                axis.reversals,
                fixed(axis.peak_velocity, 1),
            );
        }
    }
    out.push_str("</tbody></table></div>\n</section>\n");
}
