//! Cycle times against closed forms of a jerk-limited line, and what limits them.

use lostmotion_sim::machine::Machine;
use lostmotion_sim::time::TimeOptions;
use lostmotion_sim::time::results::{BlockTime, CycleTime, TimeKind};
use lostmotion_sim::{Program, SimulateOptions, Simulation};

/// Limits of `bench3`, mm and s.
const V: f64 = 100.0;
const A: f64 = 1000.0;
const J: f64 = 30_000.0;

fn timed(program: &str, options: &TimeOptions) -> (CycleTime, Vec<BlockTime>) {
    let source = Program::from_bytes("part.ngc", program.as_bytes());
    let machine = Machine::preset("bench3").expect("bench3");
    let mut rows = Vec::new();
    let mut sink = |finished: &[BlockTime]| {
        rows.extend_from_slice(finished);
        Ok(())
    };
    (
        Simulation::new(&source, &machine)
            .time(options, &mut sink)
            .expect("a time"),
        rows,
    )
}

fn of(time: &CycleTime, limit: &str) -> f64 {
    time.limits
        .iter()
        .find(|share| share.limit == limit)
        .map_or(0.0, |share| share.time_s)
}

#[track_caller]
fn near(found: f64, expected: f64, within: f64) {
    assert!(
        (found - expected).abs() <= within,
        "{found} against {expected}"
    );
}

/// Rest to rest at a speed that is reached with a stretch of constant acceleration.
fn line_s(length: f64, v: f64, a: f64, j: f64) -> f64 {
    length / v + v / a + a / j
}

#[test]
fn a_line_from_rest_to_rest_spends_its_time_as_the_s_curve_does() {
    let (time, rows) = timed("G21 G90 G61\nG1 X50 F3000\nM2\n", &TimeOptions::default());
    let (v, ramp) = (50.0, A / J);
    near(time.plan_s, line_s(50.0, v, A, J), 2e-3);
    near(of(&time, "jerk X"), 4.0 * ramp, 6e-3);
    near(of(&time, "acceleration X"), 2.0 * (v / A - ramp), 6e-3);
    near(of(&time, "feed"), 50.0 / v - v / A - ramp, 6e-3);
    near(
        time.limits.iter().map(|share| share.time_s).sum(),
        time.plan_s,
        1e-9,
    );
    near(time.limits.iter().map(|share| share.share).sum(), 1.0, 1e-9);
    assert_eq!(
        (rows.len(), rows[0].block.span.line, rows[0].kind),
        (1, 2, TimeKind::Cutting)
    );
    assert_eq!(time.blocks.len(), 1);
    assert_eq!(time.blocks[0].text, "G1 X50 F3000");
    near(rows[0].time_s, time.plan_s, 1e-9);
}

#[test]
fn what_if_rows_are_the_closed_forms_of_the_better_machine() {
    let (time, _) = timed("G21 G90 G61\nG0 X50\nM2\n", &TimeOptions::default());
    near(time.plan_s, line_s(50.0, V, A, J), 2e-3);
    near(of(&time, "velocity X"), 50.0 / V - V / A - A / J, 6e-3);
    assert_eq!(time.kinds.cutting_s.to_bits(), 0.0_f64.to_bits());
    let plan = |change: &str| {
        time.what_if
            .iter()
            .find(|row| row.change.starts_with(change))
            .expect(change)
            .plan_s
    };
    near(plan("velocity"), line_s(50.0, 1.2 * V, A, J), 2e-3);
    near(plan("acceleration"), line_s(50.0, V, 1.2 * A, J), 2e-3);
    near(plan("jerk"), line_s(50.0, V, A, 1.2 * J), 2e-3);
    near(
        plan("all three"),
        line_s(50.0, 1.2 * V, 1.2 * A, 1.2 * J),
        2e-3,
    );
    near(plan("feed"), time.plan_s, 1e-9);
    near(plan("tolerance"), time.plan_s, 1e-9);
    for row in &time.what_if {
        near(row.saved_s, time.plan_s - row.plan_s, 1e-12);
        near(row.saved_share, row.saved_s / time.plan_s, 1e-12);
    }
}

#[test]
fn a_circle_is_limited_by_its_feed_and_gains_what_the_feed_gains() {
    let (time, _) = timed(
        "G21 G90 G17 G61\nG1 X25 F1200\nG3 I-25 J0 P4 F1200\nM2\n",
        &TimeOptions::default(),
    );
    assert!(of(&time, "feed") > 0.97 * time.plan_s, "{:?}", time.limits);
    let feed = time
        .what_if
        .iter()
        .find(|row| row.change.starts_with("feed"))
        .expect("feed");
    near(feed.saved_share, 1.0 - 1.0 / 1.2, 0.01);
}

#[test]
fn dwells_tool_changes_and_the_spindle_are_kinds_of_their_own() {
    let program = "G21 G90 G61\nG4 P0.5\nS1000 M3\nG1 X10 F3000\nG4 P0.25\nM5\nT2 M6\nG0 X0\nM2\n";
    let options = TimeOptions {
        tool_change_s: 4.0,
        spindle_event_s: 1.5,
        ..TimeOptions::default()
    };
    let (time, rows) = timed(program, &options);
    near(time.kinds.dwell_s, 0.75, 2e-3);
    let dwells: Vec<(u32, f64)> = rows
        .iter()
        .filter(|row| row.kind == TimeKind::Dwell)
        .map(|row| (row.block.span.line, row.time_s))
        .collect();
    assert_eq!(
        dwells.iter().map(|(line, _)| *line).collect::<Vec<_>>(),
        [2, 5]
    );
    near(dwells[0].1, 0.5, 1.1e-3);
    near(dwells[1].1, 0.25, 1.1e-3);
    assert_eq!((time.kinds.tool_changes, time.kinds.spindle_events), (1, 2));
    near(time.total_s, time.plan_s + 4.0 + 2.0 * 1.5, 1e-12);
    near(
        time.kinds.cutting_s + time.kinds.rapid_s + time.kinds.dwell_s,
        time.plan_s,
        1e-9,
    );
    near(rows.iter().map(|row| row.time_s).sum(), time.plan_s, 1e-9);
    for pair in rows.windows(2) {
        near(pair[0].start_s + pair[0].time_s, pair[1].start_s, 1e-9);
    }
}

#[test]
fn rounding_corners_is_said_and_more_tolerance_saves_time() {
    let sides: String = (0..20)
        .map(|n| format!("G1 X{} Y{}\n", 5 * (n / 2 + 1), 5 * (n % 2)))
        .collect();
    let (time, _) = timed(
        &format!("G21 G90 G17 G64 P0.005\nF6000\n{sides}M2\n"),
        &TimeOptions::default(),
    );
    let saved = time
        .what_if
        .iter()
        .find(|row| row.change.starts_with("tolerance"))
        .expect("tolerance")
        .saved_s;
    assert!(saved > 0.0, "{saved}");
    assert!(
        time.limits.iter().all(|share| share.limit != "dwell"),
        "{:?}",
        time.limits
    );
    assert!(
        of(&time, "look-ahead") < 0.5 * time.plan_s,
        "{:?}",
        time.limits
    );
}

#[test]
fn only_so_many_blocks_are_kept_and_they_are_the_longest() {
    let program: String = (0..200)
        .map(|n| format!("G1 X{} F3000\n", f64::from((n * 37) % 101) * 0.5))
        .collect();
    let options = TimeOptions {
        keep_blocks: 7,
        what_if: false,
        ..TimeOptions::default()
    };
    let (time, mut rows) = timed(&format!("G21 G90 G61\n{program}M2\n"), &options);
    assert_eq!(
        (
            time.blocks.len(),
            time.block_count as usize,
            time.what_if.len()
        ),
        (7, rows.len(), 0)
    );
    rows.sort_by(|a, b| {
        b.time_s
            .total_cmp(&a.time_s)
            .then(a.segment.cmp(&b.segment))
    });
    for (kept, row) in time.blocks.iter().zip(&rows) {
        assert_eq!(
            (kept.segment, kept.time_s.to_bits()),
            (row.segment, row.time_s.to_bits())
        );
        assert!(!kept.text.is_empty());
    }
}

#[test]
fn threads_do_not_matter_and_nonsense_is_refused() {
    let source = Program::from_bytes(
        "part.ngc",
        &b"G21 G90 G64 P0.02\nG1 X10 F2000\nG1 Y10\nM2\n"[..],
    );
    let machine = Machine::preset("bench3").expect("bench3");
    let run = |threads, wanted: &TimeOptions| {
        let options = SimulateOptions {
            threads,
            chunk_samples: 37 * (threads + 1),
            ..SimulateOptions::default()
        };
        Simulation::new(&source, &machine)
            .options(options.clone())
            .time(wanted, &mut |_| Ok(()))
    };
    let one = run(1, &TimeOptions::default()).expect("a time");
    assert_eq!(run(4, &TimeOptions::default()).expect("a time"), one);
    let bad = TimeOptions {
        tool_change_s: f64::NAN,
        ..TimeOptions::default()
    };
    assert!(run(1, &bad).is_err());
}
