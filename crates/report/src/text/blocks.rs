//! Tables of blocks, axes and reversals.

use super::TextOptions;
use super::parts::{cause, line};
use super::table::{Align, Cell, Table, short};
use crate::number::{error, fixed, percent};
use lostmotion_sim::results::{AxisResult, BlockResult, GantryResult, ReversalResult};

const LEFT: Align = Align::Left;
const RIGHT: Align = Align::Right;

/// Longest piece of a block's text in a table, characters. A choice: half a terminal's line.
const LONGEST_BLOCK_TEXT: usize = 40;

/// Blocks with the largest error: where, how much, what of it comes from where, and why.
pub(super) fn worst_blocks(blocks: &[BlockResult], options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("line", RIGHT),
        ("error", RIGHT),
        ("RMS", RIGHT),
        ("command", RIGHT),
        ("servo", RIGHT),
        ("backlash", RIGHT),
        ("cause", LEFT),
        ("time s", RIGHT),
        ("at x y z mm", LEFT),
        ("block", LEFT),
    ])
    // First to go on a narrow terminal: place, RMS, time.
    .optional(&[8, 2, 7]);
    for block in blocks {
        let [x, y, z] = block.at_mm.map(|c| fixed(c, 3));
        table.row([
            line(&block.block).into(),
            Cell::Signed(block.max_um),
            Cell::Error(block.rms_um),
            Cell::Signed(block.parts_um.command),
            Cell::Signed(block.parts_um.servo),
            Cell::Signed(block.parts_um.backlash),
            format!(
                "{}{}",
                cause(block.cause),
                if block.rapid { ", rapid" } else { "" }
            )
            .into(),
            fixed(block.time_s, 3).into(),
            format!("{x} {y} {z}").into(),
            short(&block.text, LONGEST_BLOCK_TEXT).into(),
        ]);
    }
    options.table(&table)
}

/// Decimals of a speed or a range for people.
fn speed(value: f64) -> String {
    fixed(value, if value.abs() < 100.0 { 2 } else { 1 })
}

/// One line an axis.
pub(super) fn axes(axes: &[AxisResult], options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("axis", LEFT),
        ("unit", LEFT),
        ("gap", RIGHT),
        ("following max", RIGHT),
        ("RMS", RIGHT),
        ("without gap max", RIGHT),
        ("RMS", RIGHT),
        ("reversals", RIGHT),
        ("peak speed", LEFT),
        ("range", LEFT),
        ("peak current", RIGHT),
        ("at limit", RIGHT),
    ])
    // First to go on a narrow terminal: range, both RMS, speed, current, maximum without a gap.
    .optional(&[9, 4, 6, 8, 10, 5]);
    for axis in axes {
        // Errors are in um or mdeg, speeds and ranges in a thousand times that.
        let unit = if axis.unit == "mdeg" { "deg" } else { "mm" };
        table.row([
            axis.axis.letter().to_string().into(),
            axis.unit.as_str().into(),
            Cell::Error(axis.gap),
            Cell::Error(axis.following.max),
            Cell::Error(axis.following.rms),
            Cell::Error(axis.following_without_gap.max),
            Cell::Error(axis.following_without_gap.rms),
            axis.reversals.to_string().into(),
            format!("{} {unit}/s", speed(axis.peak_velocity)).into(),
            format!(
                "{} .. {} {unit}",
                fixed(axis.range[0], 3),
                fixed(axis.range[1], 3)
            )
            .into(),
            percent(axis.peak_current_ratio).into(),
            if axis.saturated_samples == 0 {
                "-".into()
            } else {
                // Servo ticks at the limit of current or voltage.
                format!("{} samples", axis.saturated_samples).into()
            },
        ]);
    }
    options.table(&table)
}

/// One line for the gantry.
pub(super) fn gantry(gantry: &GantryResult) -> String {
    // The skew counts the first end minus the second.
    let ahead = if gantry.peak_um < 0.0 {
        "second"
    } else {
        "first"
    };
    let figures = [gantry.peak_um.abs(), gantry.skew_um.rms].map(error);
    let [peak, rms] = figures;
    let (line, time) = (line(&gantry.block), fixed(gantry.time_s, 3));
    format!(
        "gantry {}: skew at most {peak} um, RMS {rms} um; most in line {line} at {time} s, the {ahead} end ahead\n",
        gantry.axis
    )
}

/// One line a reversal.
pub(super) fn reversals(reversals: &[ReversalResult], options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("axis", LEFT),
        ("to", LEFT),
        ("line", RIGHT),
        ("time s", RIGHT),
        ("peak", RIGHT),
        ("backlash", RIGHT),
        ("move", LEFT),
    ]);
    for reversal in reversals {
        table.row([
            reversal.axis.letter().to_string().into(),
            // The direction in which the axis goes on.
            if reversal.direction < 0 { "-" } else { "+" }.into(),
            line(&reversal.block).into(),
            fixed(reversal.time_s, 3).into(),
            Cell::Signed(reversal.peak_um),
            Cell::Signed(reversal.backlash_um),
            if reversal.rapid { "rapid" } else { "cutting" }.into(),
        ]);
    }
    options.table(&table)
}
