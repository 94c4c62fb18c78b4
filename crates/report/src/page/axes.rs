//! Axes and their reversals as tables of a page.

use super::data::line_link;
use super::picture::signed;
use super::record::Gathered;
use crate::number::{error, fixed, percent};
use lostmotion_sim::results::MethodResult;
use std::fmt::Write;

/// Most reversals in the table. A choice: the files of `--out` have all.
const MOST_REVERSALS: usize = 10;

/// Figures of each axis; with signals of its motor the reversal value, too.
pub(super) fn axes(out: &mut String, result: &MethodResult, record: &Gathered, main: usize) {
    if result.axes.is_empty() {
        return;
    }
    out.push_str("<section id=\"axes\"><h2>Axes</h2>\n<div class=\"scroll\"><table><thead><tr><th>axis<th class=\"n\">gap<th class=\"n\">following max<th class=\"n\">RMS<th class=\"n\">without gap<th class=\"n\">reversals<th class=\"n\">B (ISO 230-2)<th class=\"n\">peak speed<th class=\"n\">range<th class=\"n\">peak current<th class=\"n\">at limit</tr></thead><tbody>\n");
    let motors = record.methods.get(main).map_or(&[][..], |m| &m.motors);
    let reversal_value = |id| {
        let mut own = motors
            .iter()
            .filter(|motor| motor.axis == id && !motor.second);
        let value = own.next().and_then(|motor| motor.reversal_value);
        value.map_or("-".to_owned(), |value| {
            let targets = match value.targets {
                1 => "1 target".to_owned(),
                count => format!("{count} targets"),
            };
            format!(
                "{} at {} ({targets})",
                error(1e3 * value.value),
                fixed(value.target, 3)
            )
        })
    };
    for axis in &result.axes {
        let (small, unit) = match axis.unit.as_str() {
            "mdeg" => ("mdeg", "deg"),
            _ => ("\u{b5}m", "mm"),
        };
        let _ = writeln!(
            out,
            "<tr><th scope=\"row\">{}<td class=\"n\">{} {small}<td class=\"n\">{} {small}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{} {unit}/s<td class=\"n\">{} .. {} {unit}<td class=\"n\">{}<td class=\"n\">{}</tr>",
            axis.axis.letter(),
            error(axis.gap),
            error(axis.following.max),
            error(axis.following.rms),
            error(axis.following_without_gap.max),
            axis.reversals,
            reversal_value(axis.axis),
            fixed(axis.peak_velocity, 1),
            fixed(axis.range[0], 2),
            fixed(axis.range[1], 2),
            percent(axis.peak_current_ratio),
            match axis.saturated_samples {
                0 => "-".to_owned(),
                samples => format!("{samples} samples"),
            },
        );
    }
    out.push_str("</tbody></table></div>\n<p class=\"note\">Following error is what the load is behind its reference; it does no harm where all axes of the path have the same. <i>B</i> is the reversal value of ISO 230-2: the largest difference of the load's mean position at a target between both directions of approach, of the targets at which the axis stood for 0.15 s after either (- where it did at none). Peak current is a part of the drive's limit.</p>\n</section>\n");
}

/// The worst reversals of cutting moves.
pub(super) fn reversals(out: &mut String, result: &MethodResult) {
    let cutting: Vec<_> = result.reversals.iter().filter(|r| !r.rapid).collect();
    if cutting.is_empty() {
        return;
    }
    let _ = writeln!(
        out,
        "<section id=\"reversals\"><h2>Worst reversals ({} in all)</h2>\n<div class=\"scroll\"><table><thead><tr><th>axis<th>to<th class=\"n\">line<th class=\"n\">time s<th class=\"n\">peak \u{b5}m<th class=\"n\">by backlash</tr></thead><tbody>",
        result.reversal_count
    );
    for reversal in cutting.into_iter().take(MOST_REVERSALS) {
        let _ = writeln!(
            out,
            "<tr><th scope=\"row\">{}<td>{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}</tr>",
            reversal.axis.letter(),
            if reversal.direction < 0 {
                "\u{2212}"
            } else {
                "+"
            },
            line_link(&reversal.block, reversal.time_s),
            fixed(reversal.time_s, 3),
            signed(reversal.peak_um),
            signed(reversal.backlash_um),
        );
    }
    out.push_str("</tbody></table></div>\n<p class=\"note\">The largest error within the crossing of the gap, and how much of it backlash adds. An axis that is here again and again needs compensation or a smaller gap; where backlash adds little, its servo or friction does it.</p>\n</section>\n");
}
