//! Where the time of a program goes, as text.

use super::TextOptions;
use super::parts::{line, warnings};
use super::table::{Align, Cell, Table, short};
use crate::number::{duration, fixed, percent};
use lostmotion_sim::time::results::{CycleTime, KindTimes, LimitShare, TimeKind};

/// Most warnings shown, a choice; the JSON form has all of them.
const MOST_WARNINGS: usize = 3;
/// Longest piece of a block's text in a table, characters. A choice: half a terminal's line.
const LONGEST_BLOCK_TEXT: usize = 40;
/// Most limits listed for a block. A choice: what comes behind them hardly matters.
const MOST_LIMITS: usize = 3;

const LEFT: Align = Align::Left;
const RIGHT: Align = Align::Right;

/// The whole answer: total, kinds, limits, blocks, what-if. Ends in a newline.
pub fn time(time: &CycleTime, options: &TextOptions) -> String {
    let mut out = format!(
        "{} on {}\ncycle time: {}\n",
        time.program.name,
        time.machine,
        duration(time.total_s)
    );
    out.push_str(&warnings(&time.program, MOST_WARNINGS));
    out.push('\n');
    out.push_str(&kinds(&time.kinds, time.total_s, options));
    out.push_str("\nlimited by\n");
    out.push_str(&limits(&time.limits, options));
    let shown = time.blocks.len() as u64;
    out.push_str(&format!(
        "\nblocks that take longest ({shown} of {})\n",
        time.block_count
    ));
    out.push_str(&blocks(time, options));
    if !time.what_if.is_empty() {
        out.push_str("\nwhat if\n");
        out.push_str(&what_if(time, options));
    }
    out
}

fn kinds(kinds: &KindTimes, total_s: f64, options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("kind", LEFT),
        ("time s", RIGHT),
        ("share", RIGHT),
        ("", LEFT),
    ]);
    let mut row = |name: &str, time_s: f64, note: String| {
        table.row([
            name.into(),
            fixed(time_s, 3).into(),
            // A program of no motion has no total to divide by.
            percent(time_s / total_s.max(1e-9)).into(),
            note.into(),
        ]);
    };
    row("cutting", kinds.cutting_s, String::new());
    row("rapid", kinds.rapid_s, String::new());
    row("dwell", kinds.dwell_s, String::new());
    for (name, count, each_s) in [
        ("tool change", kinds.tool_changes, kinds.tool_change_s),
        ("spindle", kinds.spindle_events, kinds.spindle_event_s),
    ] {
        // Assumed times are listed only where the program has such events.
        if count > 0 {
            row(
                name,
                count as f64 * each_s,
                format!("{count} x {} s, as told", fixed(each_s, 1)),
            );
        }
    }
    options.table(&table)
}

fn limits(limits: &[LimitShare], options: &TextOptions) -> String {
    let mut table = Table::new(&[("limit", LEFT), ("time s", RIGHT), ("share", RIGHT)]);
    for limit in limits {
        table.row([
            limit.limit.as_str().into(),
            fixed(limit.time_s, 3).into(),
            percent(limit.share).into(),
        ]);
    }
    options.table(&table)
}

fn blocks(time: &CycleTime, options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("line", RIGHT),
        ("time s", RIGHT),
        ("share", RIGHT),
        ("from s", RIGHT),
        ("kind", LEFT),
        ("limited by", LEFT),
        ("block", LEFT),
    ])
    // First to go on a narrow terminal: start and share.
    .optional(&[3, 2]);
    for block in &time.blocks {
        let kind = match block.kind {
            TimeKind::Cutting => "cutting",
            TimeKind::Rapid => "rapid",
            TimeKind::Dwell => "dwell",
        };
        let limits: Vec<String> = block
            .limits
            .iter()
            // Limits come sorted by their share: the first ones matter.
            .take(MOST_LIMITS)
            .map(|limit| format!("{} {}", limit.limit, percent(limit.share)))
            .collect();
        table.row([
            Cell::from(line(&block.block)),
            fixed(block.time_s, 3).into(),
            // Of the plan: tool changes and spindle belong to no block.
            percent(block.time_s / time.plan_s.max(1e-9)).into(),
            fixed(block.start_s, 3).into(),
            kind.into(),
            limits.join(", ").into(),
            short(&block.text, LONGEST_BLOCK_TEXT).into(),
        ]);
    }
    options.table(&table)
}

fn what_if(time: &CycleTime, options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("change", LEFT),
        ("plan s", RIGHT),
        ("saves s", RIGHT),
        ("share", RIGHT),
    ]);
    // Each row is a plan of its own; tool changes and spindle are not in it, as nothing changes
    // them.
    for row in &time.what_if {
        table.row([
            row.change.as_str().into(),
            fixed(row.plan_s, 3).into(),
            fixed(row.saved_s, 3).into(),
            percent(row.saved_share).into(),
        ]);
    }
    options.table(&table)
}
