//! Lines that stand for curves, however coarsely or finely they are cut: one smooth curve inside the
//! tube of the program, as fast as the curve that they stand for.

use crate::common::generate::Dice;
use crate::common::{
    LIMITS, Program, assert_limits, cartesian, continuous, optimal, run, three_axes,
};
use lostmotion_base::{Coords, math};
use lostmotion_path::Curve;
use lostmotion_plan::{FeedLimit, Move, PlanItem, PlannerConfig, Sample};
use std::f64::consts::{PI, TAU};

fn seconds(samples: &[Sample]) -> f64 {
    (samples.len() - 1) as f64 * 1e-3
}

fn round(value: f64, grid: f64) -> f64 {
    if grid > 0.0 {
        (value / grid).round() * grid
    } else {
        value
    }
}

/// Turns of a circle in chords, their ends on a grid.
fn chords(radius: f64, in_a_turn: u32, turns: u32, tolerance: f64, grid: f64) -> Program {
    let mut program = Program::new(continuous(tolerance), 100.0);
    for k in 1..=in_a_turn * turns {
        let (sin, cos) = math::sin_cos(TAU * f64::from(k) / f64::from(in_a_turn));
        program.line(
            round(radius * sin, grid),
            round(radius * (1.0 - cos), grid),
            0.0,
        );
    }
    program
}

/// How long a turn by an angle takes as an arc, s.
fn turn(radius: f64, angle: f64) -> f64 {
    let mut program = Program::new(continuous(0.01), 100.0);
    program.arc(0.0, radius, angle);
    seconds(&program.run())
}

/// The same as arcs.
fn arcs(radius: f64, turns: u32) -> f64 {
    let mut program = Program::new(continuous(0.01), 100.0);
    for _ in 0..turns {
        program.arc(0.0, radius, TAU);
    }
    seconds(&program.run())
}

/// Lines of one length that turn by the angles of a rule.
fn turned(length: f64, count: usize, tolerance: f64, turn: impl Fn(usize) -> f64) -> Program {
    let mut program = Program::new(continuous(tolerance), 100.0);
    let mut heading = 0.0;
    for k in 0..count {
        let [x, y, z] = program.here.linear();
        let (sin, cos) = math::sin_cos(heading);
        program.line(x + length * cos, y + length * sin, z);
        heading += turn(k);
    }
    program
}

fn zigzag(length: f64, degrees: f64, count: usize, tolerance: f64) -> Program {
    let turn = degrees.to_radians();
    turned(length, count, tolerance, |k| {
        if k % 2 == 0 { turn } else { -turn }
    })
}

/// Distance of a point from lines, mm.
fn distance(point: Coords, curves: impl Iterator<Item = Curve>) -> f64 {
    curves
        .map(|curve| {
            curve
                .nearest(point.linear(), (0.0, f64::INFINITY), 1e-9)
                .distance
        })
        .fold(f64::INFINITY, f64::min)
}

/// Along a curve inside the tube each sample is where it says.
const CURVE: [f64; 2] = [1.1, 1e-6];
/// Blends say so to first order, and so do corners that are rounded in time.
const ANY: [f64; 2] = [8.0, 1e-6];
/// Retimed samples lie between nominal ones, so that near a change of feed they are a little faster.
const RETIMED: [f64; 2] = [8.0, 2e-3];

/// How far from the ends of a move two motions that add up may be, in tolerances: at equal distances
/// x from a corner between the directions d and e the tool is x |e - d| from it.
fn rounded(moves: &[Move], k: usize) -> f64 {
    let pairs = moves[k.saturating_sub(1)..moves.len().min(k + 2)].windows(2);
    pairs
        .map(|pair| {
            let (d, e) = (
                pair[0].curve.eval(pair[0].curve.length()).d1,
                pair[1].curve.eval(0.0).d1,
            );
            1.0 / (e - d).linear_norm()
        })
        .fold(0.0, f64::max)
}

/// What an outsider finds: limits by differences; both sides of the tube against the lines alone,
/// those that a sample names and those beside them; every vertex against the chords of the samples;
/// feed; the place that each sample names is within `named` tolerances of it, or of a corner that may be
/// rounded in time as far as that reaches, and the feed is passed by no more than the part `over`.
fn judge(program: &Program, samples: &[Sample], tolerance: f64, [named, over]: [f64; 2]) {
    assert_limits(samples, &[Some(LIMITS); 3]);
    let moves = &program.moves;
    for sample in samples {
        let k = sample.segment as usize;
        let place = moves[k].curve.point(sample.s);
        let off = (place - sample.position).linear_norm();
        let near = k.saturating_sub(2)..moves.len().min(k + 3);
        let side = distance(sample.position, moves[near].iter().map(|m| m.curve));
        assert!(
            side <= tolerance + 1e-9,
            "{side} mm beside line {k} of {tolerance}"
        );
        // The place that is named is one on the way, not just any.
        let reach = if named > CURVE[0] {
            rounded(moves, k)
        } else {
            0.0
        };
        assert!(
            off <= named.max(reach) * tolerance + 1e-9,
            "{off} mm from {k} {}",
            sample.s
        );
        if let FeedLimit::PerSecond(feed) = moves[k].feed {
            let speed = sample.velocity.linear_norm();
            assert!(
                speed <= feed * (1.0 + over),
                "{speed} of {feed} on line {k} at {} of {}",
                sample.s,
                moves[k].curve.length()
            );
        }
    }
    assert!(
        samples
            .windows(2)
            .all(|pair| pair[0].segment <= pair[1].segment)
    );
    // Both axes at their acceleration leave the chord of two samples by a T^2 / 8.
    let sagitta = 1.5 * LIMITS.acceleration * 1e-6 / 8.0;
    let mut from = 0;
    for (k, vertex) in moves.iter().map(|m| m.curve.end()).enumerate() {
        while from + 1 < samples.len() && (samples[from + 1].segment as usize) + 3 < k {
            from += 1;
        }
        let legs = samples[from..].windows(2);
        let legs = legs.take_while(|pair| pair[0].segment as usize <= k + 4);
        let missed = distance(
            vertex,
            legs.map(|pair| Curve::line(pair[0].position, pair[1].position)),
        );
        assert!(
            missed <= tolerance + sagitta,
            "vertex {k} is missed by {missed} mm of {tolerance}"
        );
    }
    let last = samples[samples.len() - 1].position;
    assert!((last - program.here).linear_norm() < 1e-8);
}

/// Sagittas of two fifths to twice of the tolerance.
#[test]
fn coarse_chords_take_the_time_of_their_circle() {
    for (radius, in_a_turn, tolerance) in [
        (5.0, 79, 0.01),
        (5.0, 70, 0.01),
        (5.0, 50, 0.01),
        (5.0, 36, 0.01),
        (2.0, 45, 0.01),
        (20.0, 100, 0.01),
        (10.0, 100, 0.005),
        (10.0, 50, 0.02),
    ] {
        let program = chords(radius, in_a_turn, 3, tolerance, 0.0);
        let samples = program.run();
        judge(&program, &samples, tolerance, CURVE);
        let (time, arc) = (seconds(&samples), arcs(radius, 3));
        assert!(
            time <= 1.02 * arc,
            "R{radius} in {in_a_turn}: {time}, as arcs {arc}"
        );
    }
}

/// However dense the points are, and however coarse the grid that they are rounded to.
#[test]
fn dense_points_take_the_time_of_their_circle() {
    let arc = arcs(20.0, 1);
    for (step, grid) in [
        (0.1, 1e-3),
        (0.02, 1e-3),
        (0.01, 1e-3),
        (0.005, 1e-3),
        (0.005, 2.54e-3),
    ] {
        let in_a_turn = (20.0 * TAU / step) as u32;
        let program = chords(20.0, in_a_turn, 1, 0.01, grid);
        let samples = program.run();
        assert_limits(&samples, &[Some(LIMITS); 3]);
        let time = seconds(&samples);
        assert!(
            time <= 1.02 * arc,
            "every {step} mm on {grid}: {time}, as an arc {arc}"
        );
        for sample in &samples {
            let [x, y, _] = sample.position.linear();
            let off = (math::hypot(x, y - 20.0) - 20.0).abs();
            // The points lie within half a diagonal of the grid beside the circle.
            assert!(off <= 0.01 + 0.8 * grid, "{off} mm beside the circle");
        }
    }
}

/// Milliseconds a corner, against the least that a linear program over the jerk finds.
#[test]
fn zigzags_swing_across_the_tube() {
    for (degrees, least_ms, factor) in [
        (6.0, 32.0, 1.12),
        (10.0, 40.0, 1.06),
        (20.0, 66.0, 1.14),
        (30.0, 80.0, 1.16),
    ] {
        let program = zigzag(2.0, degrees, 60, 0.01);
        let samples = program.run();
        judge(&program, &samples, 0.01, CURVE);
        let corner_ms = 1e3 * seconds(&samples) / 60.0;
        assert!(
            corner_ms <= factor * least_ms,
            "{degrees} degrees: {corner_ms} ms a corner, {least_ms} can be reached"
        );
    }
}

/// Hexagons of sides so short that their corners are one motion: a linear program over the jerk takes
/// 43.8 ms a corner, and the smoothest curve at a steady pace 51.
#[test]
fn corners_that_are_near_each_other_are_one_motion() {
    let program = turned(0.46, 72, 0.01, |_| PI / 3.0);
    let samples = program.run();
    judge(&program, &samples, 0.01, ANY);
    let corner_ms = 1e3 * seconds(&samples) / 72.0;
    assert!(corner_ms <= 1.14 * 43.8, "{corner_ms}");
}

/// One corner between lines that are long enough for any speed: a linear program over the jerk takes
/// 0.312 s.
#[test]
fn a_single_corner_is_passed_within_its_tube() {
    let program = turned(5.0, 2, 0.01, |_| PI / 6.0);
    let samples = program.run();
    judge(&program, &samples, 0.01, ANY);
    assert!(seconds(&samples) <= 1.06 * 0.312, "{}", seconds(&samples));
}

/// A kind of lines that follow from a seed: even or uneven, on a grid or not.
fn drawn(seed: u64) -> (Program, f64) {
    let mut dice = Dice::seeded(seed ^ 0x71BE);
    let tolerance = dice.spread(0.002, 0.1);
    let mut program = Program::new(continuous(tolerance), dice.between(20.0, 100.0));
    let mut heading = dice.between(0.0, TAU);
    for _ in 0..4 {
        let kind = dice.roll();
        let (length, turn) = (dice.spread(0.005, 5.0), dice.spread(0.005, 0.7));
        let (grid, side) = (
            dice.one_of(&[0.0, 0.0, 1e-3, 2.54e-3]),
            dice.one_of(&[-1.0, 1.0]),
        );
        let climb = dice.one_of(&[0.0, 0.2]);
        if dice.roll() < 0.3 {
            program.feed = FeedLimit::PerSecond(dice.between(20.0, 100.0));
        }
        for k in 0..dice.spread(5.0, 60.0) as usize {
            heading += if kind < 0.3 {
                side * turn
            } else if kind < 0.6 {
                turn * if k % 2 == 0 { 1.0 } else { -1.0 }
            } else {
                dice.between(-turn, turn)
            };
            let [x, y, z] = program.here.linear();
            let (sin, cos) = math::sin_cos(heading);
            program.line(
                round(x + length * cos, grid),
                round(y + length * sin, grid),
                round(z + climb * length, grid),
            );
        }
        if dice.roll() < 0.3 {
            heading += dice.between(-2.0, 2.0);
        }
        if dice.roll() < 0.2 {
            let radius = dice.spread(0.2, 20.0);
            let (sin, cos) = math::sin_cos(heading);
            program.arc(-radius * sin, radius * cos, dice.between(0.2, 3.0));
        }
    }
    (program, tolerance)
}

#[test]
fn limits_tube_and_vertices_hold_on_lines_of_any_kind() {
    for seed in 0..400 {
        let (program, tolerance) = drawn(seed);
        judge(&program, &program.run(), tolerance, ANY);
    }
}

#[test]
fn so_they_do_at_nearly_the_least_time() {
    for seed in 1000..1012 {
        let (program, tolerance) = drawn(seed);
        judge(&program, &program.run_with(optimal()), tolerance, RETIMED);
    }
}

/// A stretch of many lines is worked off in parts; where they meet nothing shows.
#[test]
fn long_stretches_are_found_in_parts() {
    let mut dice = Dice::seeded(11);
    let noise: Vec<f64> = (0..6000).map(|_| dice.between(-0.003, 0.003)).collect();
    let mut program = Program::new(continuous(0.01), 100.0);
    for (k, noise) in noise.iter().enumerate() {
        let x = 0.05 * (k + 1) as f64;
        program.line(x, 3.0 * math::sin(0.2 * x) + noise, 0.0);
    }
    let samples = program.run();
    judge(&program, &samples, 0.01, CURVE);
    // 300 mm at the feed, a little longer by the sine, start and stop.
    let time = seconds(&samples);
    assert!(time < 1.04 * 3.28 + 0.15, "{time}");
}

/// The place that it says is also off along the path: on fillets by a little more.
const FILLETS: [f64; 2] = [1.2, 1e-6];

/// A meander of lines of 10 and 8 mm with fillets of R2, which are arcs or `chords` lines each.
/// Turned by an angle.
fn fillets(tolerance: f64, chords: Option<usize>, turned_deg: f64) -> Program {
    let mut program = Program::new(continuous(tolerance), 100.0);
    let mut heading = turned_deg.to_radians();
    for k in 0..24 {
        let (length, side) = ([10.0, 8.0, 6.0, 8.0][k % 4], [1.0, -1.0, -1.0, 1.0][k % 4]);
        let [x, y, _] = program.here.linear();
        let (sin, cos) = math::sin_cos(heading);
        program.line(x + length * cos, y + length * sin, 0.0);
        let [x, y, _] = program.here.linear();
        let offset = [-2.0 * side * sin, 2.0 * side * cos];
        match chords {
            None => program.arc(offset[0], offset[1], side * 0.5 * PI),
            Some(count) => {
                for j in 1..=count {
                    let (s, c) = math::sin_cos(side * 0.5 * PI * j as f64 / count as f64);
                    let [a, b] = offset.map(|offset| -offset);
                    program.line(
                        x + offset[0] + a * c - b * s,
                        y + offset[1] + a * s + b * c,
                        0.0,
                    );
                }
            }
        }
        heading += side * 0.5 * PI;
    }
    program
}

/// Arcs and chords describe the same way, and take the same time, however they lie to the axes: a curve that
/// goes on from a bend is found with the pace that it needs there.
#[test]
fn fillets_take_as_long_as_arcs_and_as_chords() {
    for tolerance in [0.01, 0.03, 0.1] {
        for turned_deg in [0.0, 14.0, 22.0, 44.0] {
            let [arcs, chords] = [None, Some(24)].map(|count| {
                let program = fillets(tolerance, count, turned_deg);
                let samples = program.run();
                judge(&program, &samples, tolerance, FILLETS);
                seconds(&samples)
            });
            assert!(
                (arcs / chords - 1.0).abs() < 0.003,
                "P {tolerance}, {turned_deg} degrees: {arcs} s as arcs, {chords} s as chords"
            );
        }
    }
}

/// Arcs of 10 mm that turn by 40 degrees and meet in corners, as arcs or as points a step apart, on a grid.
fn cusps(corner_deg: f64, tolerance: f64, points: Option<[f64; 2]>) -> Program {
    let mut program = Program::new(continuous(tolerance), 100.0);
    let sweep: f64 = 40_f64.to_radians();
    let radius = 10.0 / sweep;
    let mut heading: f64 = 0.0;
    let mut start = [0.0, 0.0];
    for _ in 0..4 {
        let (sin, cos) = math::sin_cos(heading);
        let centre = [start[0] - radius * sin, start[1] + radius * cos];
        let place = |turned: f64| {
            let (sin, cos) = math::sin_cos(heading + turned);
            [centre[0] + radius * sin, centre[1] - radius * cos]
        };
        match points {
            None => program.arc(-radius * sin, radius * cos, sweep),
            Some([step, grid]) => {
                let count = (10.0 / step).round() as usize;
                for k in 1..=count {
                    let at = place(sweep * k as f64 / count as f64).map(|at| round(at, grid));
                    if at != [program.here.0[0], program.here.0[1]] {
                        program.line(at[0], at[1], 0.0);
                    }
                }
            }
        }
        start = place(sweep);
        heading += sweep + corner_deg.to_radians();
    }
    program
}

/// Sharp corners between dense points take as long as between the arcs that the points stand for.
#[test]
fn corners_between_points_take_as_long_as_between_arcs() {
    for (corner_deg, tolerance, points) in [
        (75.0, 0.005, [0.05, 1e-4]),
        (89.0, 0.01, [0.005, 1e-3]),
        (100.0, 0.02, [0.2, 1e-4]),
        (118.0, 0.01, [0.05, 1e-3]),
    ] {
        let arcs = seconds(&cusps(corner_deg, tolerance, None).run());
        let program = cusps(corner_deg, tolerance, Some(points));
        let samples = program.run();
        judge(&program, &samples, tolerance, ANY);
        let times = seconds(&samples) / arcs;
        assert!(times < 1.02, "{corner_deg} degrees, P {tolerance}: {times}");
    }
}

/// A grid half as coarse as the tolerance, or as coarse: points may lie 0.7 P beside the circle that they stand
/// for. However dense they are, they take as long as their circle. Of the largest one a quarter.
#[test]
fn points_on_a_coarse_grid_take_the_time_of_their_circle() {
    for (radius, in_a_turn, grid) in [
        (5.0, 1571, 0.01),
        (5.0, 3142, 0.01),
        (5.0, 10_472, 0.007),
        (12.0, 7540, 0.0085),
        (12.0, 25_133, 0.007),
        (30.0, 62_832, 0.005),
    ] {
        let mut program = chords(radius, in_a_turn, 1, 0.01, grid);
        let part = if radius > 20.0 { 4 } else { 1 };
        program.moves.truncate((in_a_turn / part) as usize);
        program.here = program.moves[program.moves.len() - 1].curve.end();
        program.moves.retain(|m| m.curve.length() > 0.0);
        let samples = program.run();
        judge(&program, &samples, 0.01, ANY);
        let circle = turn(radius, TAU / f64::from(part));
        let times = seconds(&samples) / circle;
        assert!(
            times < 1.01,
            "R{radius}, {in_a_turn} points, grid {grid}: {times}"
        );
    }
}

/// Arcs alone, each tangent to the one before.
fn bows(seed: u64) -> (Program, f64) {
    let mut dice = Dice::seeded(seed ^ 0xA2C5);
    let tolerance = dice.spread(0.002, 0.1);
    let mut program = Program::new(continuous(tolerance), dice.between(20.0, 100.0));
    let mut heading = dice.between(0.0, TAU);
    for _ in 0..dice.spread(4.0, 40.0) as usize {
        let radius = dice.spread(0.2, 30.0) * dice.one_of(&[-1.0, 1.0]);
        let sweep = dice.spread(0.02, 3.0) * radius.signum();
        if dice.roll() < 0.2 {
            heading += dice.between(-0.5, 0.5);
        }
        let (sin, cos) = math::sin_cos(heading);
        program.arc(-radius * sin, radius * cos, sweep);
        heading += sweep;
    }
    (program, tolerance)
}

#[test]
fn limits_tube_and_vertices_hold_on_arcs() {
    for seed in 0..200 {
        let (program, tolerance) = bows(seed);
        judge(&program, &program.run(), tolerance, ANY);
    }
}

/// A part of the lines at a lower feed costs what it takes at that feed.
#[test]
fn a_change_of_feed_counts_from_its_line_on() {
    let slow = |from: usize, to: usize| {
        let mut program = chords(20.0, 400, 1, 0.01, 0.0);
        for m in &mut program.moves[from..to] {
            m.feed = FeedLimit::PerSecond(20.0);
        }
        let items = program.moves.iter().map(|m| PlanItem::Move(*m));
        let samples = run(three_axes(), cartesian(), Coords::ZERO, items);
        judge(&program, &samples, 0.01, CURVE);
        seconds(&samples)
    };
    // 100 lines of 0.314 mm at 20 instead of 100 mm/s: 1.256 s more, and the ramps.
    let more = slow(100, 200) - slow(0, 0);
    assert!((1.256..1.256 + 0.12).contains(&more), "{more}");
}

/// What is held does not grow with the program.
#[test]
fn memory_is_bounded() {
    let config = PlannerConfig {
        window_pieces: 256,
        ..three_axes()
    };
    let mut planner = lostmotion_plan::Planner::new(config, cartesian(), Coords::ZERO).unwrap();
    let mut samples = Vec::new();
    let mut held = 0;
    for m in &chords(5.0, 50, 100, 0.01, 0.0).moves {
        planner.push(PlanItem::Move(*m)).unwrap();
        planner.take(usize::MAX, &mut samples);
        samples.clear();
        held = held.max(planner.held_pieces());
    }
    assert!(held < 1024, "{held}");
}
