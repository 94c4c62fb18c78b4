//! Corners that are rounded in time: how much they save, and that they keep everything else.

use crate::common::{
    LIMITS, Program, assert_limits, cartesian, continuous, deviation, optimal, three_axes,
};
use lostmotion_base::units::rad;
use lostmotion_base::{Coords, math};
use lostmotion_path::Curve;
use lostmotion_plan::{FeedLimit, PathControl, PlanItem, Planner, Sample};
use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

fn seconds(samples: &[Sample]) -> f64 {
    (samples.len() - 1) as f64 * 1e-3
}

/// Two lines that meet at an angle, turned as a whole.
fn corner(control: PathControl, feed: f64, turn_deg: f64, rotation_deg: f64) -> Program {
    let mut program = Program::new(control, feed);
    let (s0, c0) = math::sin_cos(rad(rotation_deg));
    let (s1, c1) = math::sin_cos(rad(rotation_deg + turn_deg));
    program.line(30.0 * c0, 30.0 * s0, 0.0);
    program.line(30.0 * (c0 + c1), 30.0 * (s0 + s1), 0.0);
    program
}

/// A corner rounded in time: both axes follow J t^3 / 6, and the tool is one tolerance from the corner
/// when they are equally far from it. A curve through it may save more.
#[test]
fn a_square_corner_saves_the_time_of_two_cubics_at_least() {
    for tolerance in [0.002, 0.01, 0.02] {
        let exact = seconds(&corner(PathControl::ExactPath, 60.0, 90.0, 0.0).run());
        let program = corner(continuous(tolerance), 60.0, 90.0, 0.0);
        let samples = program.run();
        let saved = 2.0 * math::cbrt(6.0 * tolerance * FRAC_1_SQRT_2 / LIMITS.jerk);
        assert!(
            exact - seconds(&samples) - saved > -1.1e-3,
            "{tolerance}: {exact} {} {saved}",
            seconds(&samples)
        );
        let worst = deviation(&samples, &program.moves);
        assert!(
            worst <= tolerance + 1e-9 && worst > 0.5 * tolerance,
            "{worst} of {tolerance}"
        );
        assert_limits(&samples, &[Some(LIMITS); 3]);
    }
}

#[test]
fn a_larger_tolerance_is_hardly_ever_slower_and_breaks_nothing() {
    for turn in (5..180).step_by(25) {
        for rotation in (0..90).step_by(15) {
            let mut last = seconds(
                &corner(
                    PathControl::ExactPath,
                    90.0,
                    f64::from(turn),
                    f64::from(rotation),
                )
                .run(),
            );
            for tolerance in [0.001, 0.005, 0.02, 0.05, 0.2, 0.5] {
                let program = corner(
                    continuous(tolerance),
                    90.0,
                    f64::from(turn),
                    f64::from(rotation),
                );
                let samples = program.run();
                assert_limits(&samples, &[Some(LIMITS); 3]);
                assert!(deviation(&samples, &program.moves) <= tolerance + 1e-8);
                let time = seconds(&samples);
                // Whether to blend or to stop is decided from estimates of both times.
                assert!(
                    time <= 1.01 * last,
                    "{turn} degrees from {rotation}, {tolerance} mm: {time} after {last}"
                );
                last = last.min(time);
            }
        }
    }
}

/// How near the chords between samples come to a point, mm.
fn nearest(samples: &[Sample], point: Coords) -> f64 {
    let legs = samples.windows(2).map(|pair| {
        Curve::line(pair[0].position, pair[1].position)
            .nearest(point.linear(), (0.0, f64::INFINITY), 1e-9)
            .distance
    });
    legs.fold(f64::INFINITY, f64::min)
}

/// LinuxCNC on G64 P: "no more than P- away from the programmed endpoint".
#[test]
fn the_tool_passes_every_corner_within_the_tolerance() {
    for config in [three_axes(), optimal()] {
        for turn in [15.0, 40.0, 60.0, 90.0, 120.0, 150.0, 170.0, 174.9] {
            for rotation in [0.0, 20.0, 45.0] {
                for tolerance in [0.01, 0.1] {
                    let program = corner(continuous(tolerance), 60.0, turn, rotation);
                    let samples = program.run_with(config.clone());
                    let missed = nearest(&samples, program.moves[0].curve.end());
                    // Both axes at their acceleration leave the chord of two samples by a T^2 / 8.
                    let sagitta = SQRT_2 * LIMITS.acceleration * 1e-6 / 8.0;
                    assert!(
                        missed <= tolerance + sagitta,
                        "{turn} degrees from {rotation}: {missed} mm of {tolerance}"
                    );
                    assert!(deviation(&samples, &program.moves) <= tolerance + 1e-8);
                }
            }
        }
    }
}

#[test]
fn g64_without_p_takes_the_time_of_its_default_tolerance() {
    let circle = |control| {
        let mut program = Program::new(control, 60.0);
        for k in 1..=2000 {
            let (sin, cos) = math::sin_cos(f64::from(k) * 1e-3 * PI);
            program.line(3.0 - 3.0 * cos, 3.0 * sin, 0.0);
        }
        program.run()
    };
    let bare = PathControl::Continuous {
        tolerance_mm: None,
        merge_tolerance_mm: Some(0.0),
    };
    let default = three_axes().default_tolerance_mm;
    assert!(circle(bare) == circle(continuous(default)));
}

/// On a straight line there is nothing to round, whatever the tolerance: each line keeps its feed.
#[test]
fn a_change_of_feed_on_a_line_takes_the_time_of_the_exact_path() {
    let lines = |control| {
        let mut program = Program::new(control, 100.0);
        program.line(100.0, 0.0, 0.0);
        program.feed = FeedLimit::PerSecond(20.0);
        program.line(200.0, 0.0, 0.0);
        seconds(&program.run())
    };
    let exact = lines(PathControl::ExactPath);
    assert!(exact < 1.3 + 5.1, "{exact}");
    for tolerance in [0.01, 0.1, 1.0] {
        assert!((lines(continuous(tolerance)) - exact).abs() < 1.1e-3);
    }
}

/// Wherever the corner points: the jerks of both motions add up to more than a joint has in most
/// directions.
#[test]
fn corners_of_any_direction_are_passed_nearly_as_fast_as_can_be() {
    for turn in [60.0, 90.0, 120.0] {
        for rotation in [0.0, 5.0, 20.0, 45.0, 70.0] {
            let exact = seconds(&corner(PathControl::ExactPath, 60.0, turn, rotation).run());
            let program = corner(continuous(0.01), 60.0, turn, rotation);
            let samples = program.run();
            let (fast, least) = (seconds(&samples), seconds(&program.run_with(optimal())));
            assert_limits(&samples, &[Some(LIMITS); 3]);
            assert!(deviation(&samples, &program.moves) <= 0.01 + 1e-9);
            // Of what quality `optimal` saves at least two thirds.
            assert!(
                exact - fast >= 0.66 * (exact - least) - 1.1e-3,
                "{turn} degrees from {rotation}: {exact}, {fast}, {least}"
            );
        }
    }
}

#[test]
fn the_feed_holds_while_two_motions_add_up() {
    for feed in [0.5, 3.0, 10.0] {
        for turn in [60.0, 90.0, 120.0, 150.0] {
            for sample in corner(continuous(0.1), feed, turn, 0.0).run() {
                assert!(
                    sample.velocity.linear_norm() <= feed * (1.0 + 1e-6),
                    "{turn} degrees at {feed}: {sample:?}"
                );
            }
        }
    }
}

/// A zigzag with legs from far to very near, and arcs between some.
fn zigzag(control: PathControl) -> Program {
    let mut program = Program::new(control, 80.0);
    for i in 0..40 {
        let [x, y, z] = program.here.linear();
        let length = [20.0, 0.05, 3.0, 0.4, 9.0][i % 5];
        let (sin, cos) = math::sin_cos(2.1 * i as f64);
        if i % 7 == 6 {
            program.arc(0.0, 2.0, 1.5);
        } else {
            program.line(x + length * cos, y + length * sin, z + 0.3 * length);
        }
    }
    program
}

#[test]
fn corners_are_the_same_however_samples_are_taken() {
    let program = zigzag(continuous(0.05));
    let take = |every: usize, chunk: usize| {
        let mut planner = Planner::new(three_axes(), cartesian(), Coords::ZERO).unwrap();
        let mut samples = Vec::new();
        for (i, item) in program.moves.iter().enumerate() {
            planner.push(PlanItem::Move(*item)).unwrap();
            if i % every == 0 {
                planner.take(chunk, &mut samples);
            }
        }
        planner.finish().unwrap();
        while planner.take(chunk, &mut samples) > 0 {}
        samples
    };
    let all = take(usize::MAX, usize::MAX);
    assert!(all == take(1, usize::MAX));
    assert!(all == take(2, 13));
    assert_limits(&all, &[Some(LIMITS); 3]);
    assert!(deviation(&all, &program.moves) <= 0.05 + 1e-8);
    assert!(all.windows(2).all(|pair| pair[0].segment < pair[1].segment
        || pair[0].segment == pair[1].segment && pair[0].s <= pair[1].s));
    assert!(seconds(&all) < 0.98 * seconds(&zigzag(PathControl::ExactPath).run()));
    assert!((all[all.len() - 1].position - program.here).linear_norm() < 1e-9);
}
