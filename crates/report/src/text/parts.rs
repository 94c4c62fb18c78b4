//! Pieces that both kinds of result share.

use super::table::{Align, Cell, Table};
use crate::number::{duration, error, fixed, plain};
use lostmotion_base::BlockRef;
use lostmotion_sim::results::{Cause, ErrorStats, PlanInfo, ProgramInfo, StopLimit, StopResult};

/// `1 line`, `2 lines`.
pub(super) fn count(number: u64, singular: &str) -> String {
    if number == 1 {
        format!("1 {singular}")
    } else {
        format!("{number} {singular}s")
    }
}

/// What was run, in two lines, and one more if the tool was pushed.
pub(super) fn program(program: &ProgramInfo, plan: &PlanInfo) -> String {
    let mut out = format!(
        "program: {}, {}, {}\nplan: {}, {} mm cutting, {} mm rapid\n",
        count(program.lines, "line"),
        count(program.bytes, "byte"),
        count(program.moves, "move"),
        duration(plan.duration_s),
        fixed(plan.cutting_mm, 1),
        fixed(plan.rapid_mm, 1),
    );
    // Most machines and runs have no cutting force: it is told only where it pushes.
    if plan.cutting_force_n > 0.0 {
        out.push_str(&format!(
            "cutting force: {} N against every feed move\n",
            plain(plan.cutting_force_n)
        ));
    }
    out.push_str(&straightness(plan));
    out
}

/// Figures below this are not shown, um: 1 nm, below what the model knows.
const LEAST_SHOWN_UM: f64 = 1e-3;

/// How straight the tool goes, on machines where that is a question: up to two lines.
pub fn straightness(plan: &PlanInfo) -> String {
    let mut out = String::new();
    // Where the joints go straight with the tool there is no bow to tell.
    if let Some(bow) = plan.bow.filter(|bow| bow.max_um >= LEAST_SHOWN_UM) {
        out.push_str(&format!(
            "between two commands: tool off its way by at most {} um with joints that go straight, {}{}\n",
            error(bow.max_um),
            at(&bow.block),
            plan.bow_limit_um.map(|limit| format!(" (kept below {} um)", plain(limit))).unwrap_or_default()
        ));
    }
    // Without tool-centre-point control a straight block with rotary words is a curve in the part.
    if let Some(block) = plan.unstraight {
        out.push_str(&format!(
            "straight blocks with rotary words: tool off the straight line by at most {} um, {}\n",
            error(block.max_um),
            at(&block.block)
        ));
    }
    out
}

fn at(block: &BlockRef) -> String {
    format!("line {}", line(block))
}

/// Warnings of the front end, at most `limit`.
pub(super) fn warnings(program: &ProgramInfo, limit: usize) -> String {
    let mut out = String::new();
    for warning in program.warnings.iter().take(limit) {
        // Findings in the program bring severity and code along: one prefix a message.
        if !warning.starts_with("warning[") {
            out.push_str("warning: ");
        }
        out.push_str(warning);
        out.push('\n');
    }
    if program.warnings.len() > limit {
        out.push_str(&format!(
            "... and {}\n",
            count((program.warnings.len() - limit) as u64, "warning")
        ));
    }
    out
}

/// The columns of a table of [`ErrorStats`], the first being its title.
pub(super) fn stats_table(title: &str) -> Table {
    let right = Align::Right;
    Table::new(&[
        (title, Align::Left),
        ("max", right),
        ("RMS", right),
        ("p50", right),
        ("p95", right),
        ("p99", right),
        ("p99.9", right),
    ])
    .optional(&[3, 4])
}

/// A row of [`stats_table`]; dashes where there was no sample.
pub(super) fn stats_row(table: &mut Table, name: &str, stats: &ErrorStats) {
    let value = |v: f64| {
        // Statistics of no sample are zeros that would look like a perfect result.
        if stats.samples == 0 {
            Cell::from("-")
        } else {
            Cell::Error(v)
        }
    };
    table.row([
        name.into(),
        value(stats.max),
        value(stats.rms),
        value(stats.p50),
        value(stats.p95),
        value(stats.p99),
        value(stats.p999),
    ]);
}

/// Where the machine stops: `in line 14 at 3.218 s`.
pub(crate) fn stop_place(stop: &StopResult) -> String {
    format!(
        "in line {} at {} s",
        line(&stop.block),
        fixed(stop.time_s, 3)
    )
}

/// Which limit was passed, by how much, and why.
pub(crate) fn stop_reason(stop: &StopResult) -> String {
    let StopResult {
        unit,
        value,
        allowed,
        ..
    } = stop;
    let motor = stop.motor();
    let mut text = match stop.limit {
        StopLimit::FollowingError => format!(
            "the following error of {motor} is {} {unit}, allowed are {}",
            error(value.abs()),
            error(*allowed)
        ),
        StopLimit::Travel => format!(
            "the motor of {motor} is at {} {unit}, its travel with overtravel ends at {}",
            fixed(*value, 3),
            fixed(*allowed, 3)
        ),
        StopLimit::AtLimit => format!(
            "the drive of {motor} is at its current or voltage limit for more than {} s without a break",
            plain(*allowed)
        ),
        // The value is beyond the limit by a fraction of a command cycle's.
        _ => format!("the motor of {motor} is overloaded by its current"),
    };
    if !stop.reason.is_empty() {
        text.push_str("; ");
        text.push_str(&stop.reason);
    }
    text
}

/// A cause in words.
pub(super) fn cause(cause: Cause) -> String {
    cause.to_string()
}

/// A block's line, with the file where it is not the program itself.
pub(super) fn line(block: &BlockRef) -> String {
    match block.span.file {
        0 => block.span.line.to_string(),
        file => format!("{}:{}", file, block.span.line),
    }
}
