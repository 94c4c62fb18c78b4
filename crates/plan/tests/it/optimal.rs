//! Quality `optimal`: what it may not change, and what it has to gain.

use crate::common::{
    LIMITS, Program, assert_limits, cartesian, continuous, deviation, optimal, run,
};
use lostmotion_base::{BlockRef, Coords, math};
use lostmotion_plan::{Dwell, PathControl, PlanItem, Planner, Sample};
use std::f64::consts::TAU;

fn time_s(samples: &[Sample]) -> f64 {
    (samples.len() - 1) as f64 * 1e-3
}

/// A wave of short lines.
fn wave(pieces: u32) -> Program {
    let mut program = Program::new(continuous(0.01), 100.0);
    for i in 1..=pieces {
        let x = 0.2 * f64::from(i);
        program.line(x, 0.0, 2.0 * math::sin(x * TAU / 20.0));
    }
    program
}

/// A star whose ten points and corners are sharp.
fn star(tolerance_mm: f64) -> Program {
    let mut program = Program::new(continuous(tolerance_mm), 100.0);
    for i in 1..=10_u32 {
        let (sin, cos) = math::sin_cos(f64::from(i) * TAU / 10.0);
        let radius = if i % 2 == 0 { 30.0 } else { 12.0 };
        program.line(radius * cos - 30.0, radius * sin, 0.0);
    }
    program
}

#[test]
fn a_wave_is_travelled_within_all_limits_and_faster() {
    let program = wave(400);
    let (fast, samples) = (program.run(), program.run_with(optimal()));
    assert_limits(&samples, &[Some(LIMITS); 3]);
    assert!(deviation(&samples, &program.moves) <= 0.01 + 1e-8);
    assert!(
        time_s(&samples) < time_s(&fast),
        "{} {}",
        time_s(&samples),
        time_s(&fast)
    );
}

/// Corners are cut as far as the tolerance allows, whatever the sum of the two motions would ask of
/// the joints before it is retimed.
#[test]
fn corners_are_passed_within_the_tolerance_and_faster() {
    let mut last = f64::INFINITY;
    for tolerance in [0.01, 0.05, 0.2] {
        let program = star(tolerance);
        let (fast, samples) = (program.run(), program.run_with(optimal()));
        assert_limits(&samples, &[Some(LIMITS); 3]);
        let worst = deviation(&samples, &program.moves);
        assert!(worst <= tolerance + 1e-8, "{worst} of {tolerance}");
        assert!(
            time_s(&samples) < time_s(&fast) && time_s(&samples) < last,
            "{tolerance}"
        );
        last = time_s(&samples);
    }
}

/// A dwell lasts as long as it should, and the motion around it rests.
#[test]
fn dwells_keep_their_time() {
    let mut program = Program::new(PathControl::ExactPath, 100.0);
    program.line(20.0, 0.0, 0.0);
    program.line(40.0, 10.0, 0.0);
    let dwell = PlanItem::Dwell(Dwell {
        seconds: 0.4,
        block: BlockRef::default(),
    });
    let items = [
        PlanItem::Move(program.moves[0]),
        dwell,
        PlanItem::Move(program.moves[1]),
    ];
    let samples = run(optimal(), cartesian(), Coords::ZERO, items.into_iter());
    let corner = Coords::xyz(20.0, 0.0, 0.0);
    let resting = samples
        .iter()
        .filter(|sample| (sample.position - corner).linear_norm() < 1e-7)
        .count();
    // The motion creeps within a tenth of a nanometre of the corner for some milliseconds on both
    // sides.
    assert!((400..=410).contains(&resting), "{resting}");
    assert_limits(&samples, &[Some(LIMITS); 3]);
}

/// The samples do not depend on how pushing and taking interleave.
#[test]
fn chunks_make_no_difference() {
    let program = wave(150);
    let whole = program.run_with(optimal());
    for chunk in [1, 7, 1000] {
        let mut planner = Planner::new(optimal(), cartesian(), Coords::ZERO).unwrap();
        let mut samples = Vec::new();
        for (index, item) in program.moves.iter().enumerate() {
            planner.push(PlanItem::Move(*item)).unwrap();
            if index % 3 == 0 {
                planner.take(chunk, &mut samples);
            }
        }
        planner.finish().unwrap();
        while planner.take(chunk, &mut samples) > 0 {}
        assert_eq!(samples, whole);
    }
}

/// Velocity and acceleration are the derivatives of the position.
#[test]
fn velocity_and_acceleration_belong_to_the_position() {
    let samples = star(0.05).run_with(optimal());
    for window in samples.windows(3) {
        for joint in 0..2 {
            let [p0, p1, p2] = [0, 1, 2].map(|k| window[k].position.0[joint]);
            let (v, a) = (window[1].velocity.0[joint], window[1].acceleration.0[joint]);
            // Central differences over 1 ms miss at most j h^2 / 6 of the velocity and, where the
            // jerk turns round, j h / 3 of the acceleration.
            assert!(
                (v - (p2 - p0) * 500.0).abs() < 0.02,
                "{v} {}",
                (p2 - p0) * 500.0
            );
            assert!(
                (a - (p2 - 2.0 * p1 + p0) * 1e6).abs() < 20.0,
                "{a} {}",
                (p2 - 2.0 * p1 + p0) * 1e6
            );
        }
    }
}
