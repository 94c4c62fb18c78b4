//! Where the time of a program goes, as a page.

use super::data::{escape, line};
use super::html::{file_name, foot, head};
use crate::number::{duration, fixed, percent};
use lostmotion_sim::time::results::{CycleTime, TimeKind};
use std::fmt::Write;

/// Most limits named for a block, and most remarks. Choices: the JSON form has all.
const MOST_LIMITS: usize = 3;
const MOST_WARNINGS: usize = 10;

/// Writes the page of a cycle time. It needs no scripts and no network.
pub fn time_page(time: &CycleTime) -> String {
    let mut out = String::new();
    let name = file_name(&time.program.name);
    head(&mut out, &format!("{name} on {}: cycle time", time.machine));
    let _ = writeln!(
        out,
        "<main>\n<header>\n<h1>{}</h1>\n<p class=\"who\">on {}</p>\n<p class=\"verdict\">{}</p>",
        escape(name),
        escape(&time.machine),
        duration(time.total_s)
    );
    if let (Some(limit), Some(block)) = (time.limits.first(), time.blocks.first()) {
        let _ = writeln!(
            out,
            "<p class=\"finding\">Most of it is limited by <b>{}</b> ({}); line {} takes longest, {} s</p>",
            escape(&limit.limit),
            percent(limit.share),
            line(&block.block),
            fixed(block.time_s, 3)
        );
        let _ = writeln!(
            out,
            "<p class=\"note\">What helps: {}.</p>",
            remedy(&limit.limit)
        );
    }
    out.push_str("</header>\n");
    kinds(&mut out, time);
    limits(&mut out, time);
    what_if(&mut out, time);
    blocks(&mut out, time);
    if !time.program.warnings.is_empty() {
        out.push_str("<section id=\"remarks\"><h2>Remarks</h2>\n<ul>\n");
        for warning in time.program.warnings.iter().take(MOST_WARNINGS) {
            let _ = writeln!(out, "<li>{}</li>", escape(warning));
        }
        out.push_str("</ul>\n</section>\n");
    }
    foot(&mut out, "");
    out
}

/// What a user can do about what limits the motion.
fn remedy(limit: &str) -> &'static str {
    match limit.split(' ').next().unwrap_or_default() {
        "feed" => "a higher feed, if tool and material take it",
        "velocity" => {
            "less way of this axis, or a part that lies otherwise: it is at its top speed"
        }
        "acceleration" => "longer and smoother moves: this axis changes its speed all the time",
        "jerk" => {
            "smoother moves, or a higher jerk limit of this axis: it starts and ends its accelerations all the time"
        }
        "tolerance" => "a larger tolerance at corners (G64 P), where the part allows it",
        "look-ahead" => "fewer stops and reversals, or blocks that go on in the same direction",
        "chord" => "a larger bow limit, or a shorter command cycle",
        "dwell" => "shorter dwells (G4)",
        _ => "see the what-if table",
    }
}

/// A share as a bar; its number stands beside it.
fn bar(share: f64) -> String {
    format!(
        "<td><svg class=\"share\" viewBox=\"0 0 100 10\" aria-hidden=\"true\"><rect class=\"ground\" width=\"100\" height=\"10\"/><rect class=\"part\" width=\"{}\" height=\"10\"/></svg>",
        fixed(100.0 * share.clamp(0.0, 1.0), 1)
    )
}

/// Rows of a name, a time and its share.
fn shares<'a>(out: &mut String, rows: impl Iterator<Item = (&'a str, f64, f64)>) {
    for (name, time_s, share) in rows {
        let _ = writeln!(
            out,
            "<tr><th scope=\"row\">{}<td class=\"n\">{}<td class=\"n\">{}{}</tr>",
            escape(name),
            fixed(time_s, 3),
            percent(share),
            bar(share)
        );
    }
}

fn kinds(out: &mut String, time: &CycleTime) {
    let kinds = &time.kinds;
    let of = |count: u64, each_s: f64| count as f64 * each_s;
    let all = [
        ("cutting", kinds.cutting_s),
        ("rapid", kinds.rapid_s),
        ("dwell", kinds.dwell_s),
        (
            "tool changes, as told",
            of(kinds.tool_changes, kinds.tool_change_s),
        ),
        (
            "spindle, as told",
            of(kinds.spindle_events, kinds.spindle_event_s),
        ),
    ];
    out.push_str("<section id=\"kinds\"><h2>What the time is spent on</h2>\n<div class=\"scroll\"><table><thead><tr><th>kind<th class=\"n\">time s<th class=\"n\">share<th></tr></thead><tbody>\n");
    let spent = all.into_iter().filter(|(_, time_s)| *time_s > 0.0);
    // A program of no motion has no total to divide by.
    shares(
        out,
        spent.map(|(name, s)| (name, s, s / time.total_s.max(1e-9))),
    );
    out.push_str("</tbody></table></div>\n</section>\n");
}

fn limits(out: &mut String, time: &CycleTime) {
    out.push_str("<section id=\"limits\"><h2>What keeps it from going faster</h2>\n<div class=\"scroll\"><table><thead><tr><th>limit<th class=\"n\">time s<th class=\"n\">share<th></tr></thead><tbody>\n");
    let rows = time.limits.iter();
    shares(
        out,
        rows.map(|limit| (limit.limit.as_str(), limit.time_s, limit.share)),
    );
    out.push_str("</tbody></table></div>\n<p class=\"note\"><i>feed</i>: the programmed speed is reached. <i>velocity</i>, <i>acceleration</i>, <i>jerk</i>: the axis is at this limit. <i>tolerance</i>: on the rounding of a corner. <i>look-ahead</i>: nothing is at a limit, the motion gets ready for what comes.</p>\n</section>\n");
}

fn what_if(out: &mut String, time: &CycleTime) {
    if time.what_if.is_empty() {
        return;
    }
    out.push_str("<section id=\"whatif\"><h2>What a change would save</h2>\n<div class=\"scroll\"><table><thead><tr><th>change<th class=\"n\">saves s<th class=\"n\">share<th></tr></thead><tbody>\n");
    let rows = time.what_if.iter();
    shares(
        out,
        rows.map(|row| (row.change.as_str(), row.saved_s, row.saved_share)),
    );
    out.push_str("</tbody></table></div>\n<p class=\"note\">Each row is a plan of its own on a machine that is better in this one thing.</p>\n</section>\n");
}

fn blocks(out: &mut String, time: &CycleTime) {
    if time.blocks.is_empty() {
        return;
    }
    let _ = writeln!(
        out,
        "<section id=\"blocks\"><h2>Blocks that take longest ({} of {})</h2>\n<div class=\"scroll\"><table><thead><tr><th class=\"n\">line<th class=\"n\">time s<th class=\"n\">share<th class=\"n wide\">from s<th>kind<th>limited by<th>block</tr></thead><tbody>",
        time.blocks.len(),
        time.block_count
    );
    for block in &time.blocks {
        let kind = match block.kind {
            TimeKind::Cutting => "cutting",
            TimeKind::Rapid => "rapid",
            TimeKind::Dwell => "dwell",
        };
        let named = |limit: &lostmotion_sim::time::results::LimitShare| {
            format!("{} {}", escape(&limit.limit), percent(limit.share))
        };
        // They come sorted by their share: the first ones matter.
        let limits: Vec<String> = block.limits.iter().take(MOST_LIMITS).map(named).collect();
        let _ = writeln!(
            out,
            "<tr><td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n wide\">{}<td>{kind}<td>{}<td class=\"code\">{}</tr>",
            line(&block.block),
            fixed(block.time_s, 3),
            percent(block.time_s / time.plan_s.max(1e-9)),
            fixed(block.start_s, 3),
            limits.join(", "),
            escape(&block.text)
        );
    }
    out.push_str("</tbody></table></div>\n</section>\n");
}
