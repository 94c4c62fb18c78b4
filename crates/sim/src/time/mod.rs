//! Cycle time of a program: by block, by kind, and what limits it.

mod ledger;
pub mod results;

use crate::error::SimError;
use crate::limiter::Along;
use crate::motion::{CHANGES, Checked, Feed, LimitChange, check};
use crate::program::BlockTexts;
use crate::results::PlanInfo;
use crate::setup::Setup;
use ledger::Ledger;
use lostmotion_base::{Tick, threads};
use results::{BlockTime, CycleTime, KindTimes, TIME_SCHEMA, WhatIf};

/// What is counted, and what is taken to last how long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeOptions {
    /// How many of the blocks that take longest a result lists.
    pub keep_blocks: usize,
    /// What a tool change lasts, s.
    pub tool_change_s: f64,
    /// What it takes the spindle to start, stop or turn round, s.
    pub spindle_event_s: f64,
    /// Whether to plan the program again with each change of the machine.
    pub what_if: bool,
}

impl Default for TimeOptions {
    fn default() -> TimeOptions {
        TimeOptions {
            keep_blocks: 10,
            tool_change_s: 0.0,
            spindle_event_s: 0.0,
            what_if: true,
        }
    }
}

/// Takes finished blocks, so that memory does not grow with the program.
pub type BlockSink<'a> = dyn FnMut(&[BlockTime]) -> Result<(), crate::error::SinkError> + 'a;

/// Plans a program and tells where its time goes; the changes of the what-if table are planned side
/// by side on the threads of the run.
pub(crate) fn time(
    setup: &Setup<'_>,
    time: &TimeOptions,
    sink: &mut BlockSink<'_>,
) -> Result<CycleTime, SimError> {
    check_options(time)?;
    let options = setup.options;
    // The program is read once for its errors before time is spent on planning.
    let checked = check(setup)?;
    let mut feed = Feed::timed(setup)?;
    let mut texts = BlockTexts::new(setup.program, checked.files.clone());
    let mut along = Along::new(setup, feed.modes());
    let command = setup.machine.cycles().command();
    let mut ledger = Ledger::new(command, time.keep_blocks);
    let (mut samples, mut segments) = (Vec::new(), Vec::new());
    loop {
        segments.clear();
        feed.chunk(options.chunk_samples, &mut samples, &mut segments)?;
        if samples.is_empty() {
            break;
        }
        let notes = feed.notes();
        // Notes first: a sample may lie on a move that was read in this very chunk.
        let intervals = along.chunk(&samples, notes, feed.modes());
        intervals
            .flatten()
            .for_each(|interval| ledger.add(&interval));
        sink(&finished(&mut ledger, &mut texts)).map_err(SimError::Sink)?;
        // A loop without end would plan for ever.
        if command.seconds(ledger.ticks()) > options.max_duration_s {
            return Err(SimError::TooLong {
                limit_s: options.max_duration_s,
            });
        }
    }
    // The last block has no successor that would end it.
    ledger.close();
    sink(&finished(&mut ledger, &mut texts)).map_err(SimError::Sink)?;
    let what_if = if time.what_if {
        what_if(setup, ledger.ticks())?
    } else {
        Vec::new()
    };
    let mut blocks = ledger.longest();
    for row in &mut blocks {
        row.text = texts.at(row.block.span);
    }
    Ok(answer(
        setup,
        time,
        checked,
        (&ledger, along.tool_changes, &feed),
        blocks,
        what_if,
    ))
}

/// The blocks that have ended since the last call, with their text.
fn finished(ledger: &mut Ledger, texts: &mut BlockTexts) -> Vec<BlockTime> {
    let mut rows = ledger.take_finished();
    // The ledger holds places alone; texts are read again for what is shown.
    for row in &mut rows {
        row.text = texts.at(row.block.span);
    }
    rows
}

fn answer(
    setup: &Setup<'_>,
    time: &TimeOptions,
    checked: Checked,
    (ledger, tool_changes, feed): (&Ledger, u64, &Feed),
    blocks: Vec<BlockTime>,
    what_if: Vec<WhatIf>,
) -> CycleTime {
    let command = setup.machine.cycles().command();
    let [cutting_s, rapid_s, dwell_s] = ledger.kinds.map(|ticks| command.seconds(ticks));
    let kinds = KindTimes {
        cutting_s,
        rapid_s,
        dwell_s,
        tool_changes,
        tool_change_s: time.tool_change_s,
        spindle_events: feed.spindle_events(),
        spindle_event_s: time.spindle_event_s,
    };
    let plan_s = command.seconds(ledger.ticks());
    let mut program = checked.program;
    let mut told = PlanInfo::default();
    feed.tell(&mut told);
    program.warnings.extend(told.late_warning());
    program.warnings.extend(told.shortfall_warning());
    // Tool changes and the spindle are not simulated: what they take is counted times what the
    // caller assumes.
    let assumed_s = kinds.tool_changes as f64 * kinds.tool_change_s
        + kinds.spindle_events as f64 * kinds.spindle_event_s;
    CycleTime {
        schema: TIME_SCHEMA,
        program,
        machine: setup.machine.name().to_owned(),
        total_s: plan_s + assumed_s,
        plan_s,
        kinds,
        limits: ledger::shares(&ledger.counts, ledger.ticks(), command),
        blocks,
        block_count: ledger.count,
        what_if,
    }
}

/// One pass a change, side by side.
fn what_if(setup: &Setup<'_>, ticks: Tick) -> Result<Vec<WhatIf>, SimError> {
    let command = setup.machine.cycles().command();
    let plan_s = command.seconds(ticks);
    let row = |(name, change): &(&str, LimitChange)| {
        let changed_s = command.seconds(duration(setup, *change)?);
        let saved_s = plan_s - changed_s;
        Ok(WhatIf {
            change: (*name).to_owned(),
            plan_s: changed_s,
            saved_s,
            // Of at least one cycle: a program of no motion has no share to save.
            saved_share: saved_s / plan_s.max(command.period_s()),
        })
    };
    setup.on_threads(|threads| {
        // Plans are independent of each other; collected in the table's order.
        let rows = threads::map(threads, CHANGES.iter(), row);
        rows.into_iter().collect()
    })
}

/// Command cycles that the plan takes.
fn duration(setup: &Setup<'_>, change: LimitChange) -> Result<Tick, SimError> {
    let mut feed = Feed::changed(setup, change)?;
    let (mut samples, mut segments, mut count) = (Vec::new(), Vec::new(), 0);
    loop {
        segments.clear();
        feed.chunk(setup.options.chunk_samples, &mut samples, &mut segments)?;
        if samples.is_empty() {
            // n samples bound n - 1 intervals.
            return Ok(Tick::saturating_sub(count, 1));
        }
        count += samples.len() as Tick;
    }
}

/// Longest tool change or spindle event, s: a day.
const LONGEST_EVENT_S: f64 = 86_400.0;

fn check_options(time: &TimeOptions) -> Result<(), SimError> {
    for (what, value) in [
        ("tool_change_s", time.tool_change_s),
        ("spindle_event_s", time.spindle_event_s),
    ] {
        if !(0.0..=LONGEST_EVENT_S).contains(&value) {
            return Err(SimError::Option {
                what,
                value,
                condition: "a finite number, 0 or above, and 86400 (a day) at most",
            });
        }
    }
    Ok(())
}
