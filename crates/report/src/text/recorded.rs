//! A recorded motion against its program, as text.

use super::TextOptions;
use super::parts::{count, line, warnings};
use super::table::{Align, Cell, Table, short};
use crate::number::{error, fixed, plain, round_to};
use lostmotion_base::math;
use lostmotion_sim::recorded::results::{
    LimitUse, RecordCheck, RecordCoordinates, RecordKind, RecordedAxisCheck, RecordedBlock,
};

/// Most warnings shown; the JSON form has all of them.
const MOST_WARNINGS: usize = 3;
/// Longest piece of a block's text in a table, characters. A choice: half a terminal's line.
const LONGEST_BLOCK_TEXT: usize = 40;
/// Time between rows from which it is shown in whole milliseconds, s.
const SLOW_S: f64 = 0.01;

/// Most decimals of a figure: um and s.
const MOST_DECIMALS: f64 = 3.0;

const LEFT: Align = Align::Left;
const RIGHT: Align = Align::Right;

/// The whole answer: verdict, place, limits, worst blocks. `log` is the name of the log. Ends in a
/// newline.
pub fn record_check(log: &str, check: &RecordCheck, options: &TextOptions) -> String {
    let mut out = format!(
        "{log} in {} on {}, {} positions\n{}\n",
        check.program.name,
        check.machine,
        match check.kind {
            RecordKind::Commanded => "commanded",
            RecordKind::Measured => "measured",
        },
        verdict(check),
    );
    out.push_str(&warnings(&check.program, MOST_WARNINGS));
    out.push('\n');
    out.push_str(&place(check));
    out.push_str(&format!(
        "off the programmed path: at most {} um, RMS {} um, +-{} um\n",
        error(check.deviation_max_um),
        error(check.deviation_rms_um),
        error(check.deviation_plus_minus_um),
    ));
    out.push_str("\nlimits of the axes, and the most that the log proves of each\n");
    out.push_str(&limits(&check.axes, options));
    for reason in &check.untold {
        out.push_str(&format!("not told: {reason}\n"));
    }
    let shown = check.blocks.len() as u64;
    out.push_str(&format!(
        "\nworst blocks ({shown} of {})\n",
        check.block_count
    ));
    out.push_str(&blocks(&check.blocks, options));
    out
}

fn verdict(check: &RecordCheck) -> String {
    let Some(worst) = check.blocks.first().filter(|_| !check.is_within()) else {
        return "within limits and tolerance, as far as the log tells".to_owned();
    };
    let mut what = Vec::new();
    if let Some(limit) = worst.limit.as_ref().filter(|limit| limit.is_exceeded) {
        what.push(format!(
            "{} of {} {} times its limit",
            limit.derivative,
            limit.axis,
            times(limit.times)
        ));
    }
    if let Some(allowed) = worst.allowed_um.filter(|_| worst.is_outside) {
        what.push(format!(
            "{} um off the path, {} times the {} um allowed",
            error(worst.deviation_um),
            times(worst.deviation_um / allowed),
            error(allowed)
        ));
    }
    format!(
        "OUTSIDE: {} in line {}; {} at fault",
        what.join(", "),
        line(&worst.block),
        count(check.at_fault, "block"),
    )
}

/// Where in the program, and in whose coordinates.
fn place(check: &RecordCheck) -> String {
    let place = &check.place;
    let period = if check.period_s < SLOW_S {
        plain(round_to(1e3 * check.period_s, 4))
    } else {
        fixed(1e3 * check.period_s, 1)
    };
    let mut out = format!(
        "place: lines {} to {}, {} to {} s of the log, a row every {period} ms\n",
        line(&place.first),
        line(&place.last),
        fixed(place.from_s, 3),
        fixed(place.to_s, 3),
    );
    if place.rows_before + place.rows_behind > 0 {
        out.push_str(&format!(
            "not of the program: {} before and {} behind it\n",
            count(place.rows_before, "row"),
            count(place.rows_behind, "row"),
        ));
    }
    let [x, y, z] = place.shift_mm.map(|mm| fixed(mm, 4));
    out.push_str(&match place.coordinates {
        RecordCoordinates::Machine => "coordinates: those of the machine\n".to_owned(),
        RecordCoordinates::Program => "coordinates: those of the program\n".to_owned(),
        RecordCoordinates::Shifted => format!(
            "coordinates: shifted against those of the machine by X {x} Y {y} Z {z} mm, +-{} mm (fitted)\n",
            fixed(place.shift_error_mm, 4),
        ),
    });
    if place.other_places > 0 {
        let lines: Vec<String> = place.others.iter().map(line).collect();
        out.push_str(&format!(
            "{} as well, from line {}{}: the first is taken\n",
            if place.other_places == 1 {
                "one other place fits".to_owned()
            } else {
                format!("{} other places fit", place.other_places)
            },
            lines.join(", "),
            if place.other_places as usize > lines.len() {
                " and on"
            } else {
                ""
            },
        ));
    }
    out
}

/// How many times over, with two decimals.
fn times(value: f64) -> String {
    fixed(value, if value < 10.0 { 2 } else { 1 })
}

/// A figure with three digits, as far as three decimals go.
fn figure(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return plain(value);
    }
    let decimals = (2.0 - math::log10(value.abs()).floor()).clamp(0.0, MOST_DECIMALS);
    fixed(value, decimals as usize)
}

fn limits(axes: &[RecordedAxisCheck], options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("axis", LEFT),
        ("limit of", LEFT),
        ("limit", RIGHT),
        ("found", RIGHT),
        ("+-", RIGHT),
        ("times", RIGHT),
        ("over ms", RIGHT),
        ("line", RIGHT),
        ("time s", RIGHT),
        ("", LEFT),
    ])
    // First to go on a narrow terminal: over which time, and when.
    .optional(&[6, 8]);
    for axis in axes {
        for limit in &axis.limits {
            table.row([
                format!("{} {}", axis.axis, axis.unit).into(),
                limit.derivative.to_string().into(),
                figure(limit.limit).into(),
                figure(limit.found).into(),
                figure(limit.plus_minus).into(),
                times(limit.times).into(),
                plain(round_to(1e3 * limit.over_s, 2)).into(),
                line(&limit.block).into(),
                fixed(limit.time_s, 3).into(),
                if limit.is_exceeded { "EXCEEDED" } else { "" }.into(),
            ]);
        }
    }
    options.table(&table)
}

fn blocks(blocks: &[RecordedBlock], options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("line", RIGHT),
        ("off um", RIGHT),
        ("allowed", RIGHT),
        ("times", RIGHT),
        ("most used limit", LEFT),
        ("times", RIGHT),
        ("from s", RIGHT),
        ("fault", LEFT),
        ("block", LEFT),
    ])
    .optional(&[6]);
    for block in blocks {
        let limit = block.limit.as_ref();
        let name = |limit: &LimitUse| format!("{} {}", limit.derivative, limit.axis);
        let mut fault = Vec::new();
        if block.is_outside {
            fault.push("path");
        }
        if limit.is_some_and(|limit| limit.is_exceeded) {
            fault.push("limit");
        }
        let off = block.allowed_um.map(|allowed| block.deviation_um / allowed);
        table.row([
            line(&block.block).into(),
            Cell::Error(block.deviation_um),
            block.allowed_um.map_or("-".to_owned(), error).into(),
            off.map_or("-".to_owned(), times).into(),
            limit.map_or("-".to_owned(), name).into(),
            limit
                .map_or("-".to_owned(), |limit| times(limit.times))
                .into(),
            fixed(block.from_s, 3).into(),
            fault.join(", ").into(),
            short(&block.text, LONGEST_BLOCK_TEXT).into(),
        ]);
    }
    options.table(&table)
}
