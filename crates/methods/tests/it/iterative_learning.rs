//! Strokes that come again: the load's whole error falls from run to run; strokes that do not are
//! left alone.

use lostmotion_base::math;
use lostmotion_methods::AxisConfig;
use lostmotion_rig::{Motion, Move, circle, errors, max_abs, mill_x, rms, run, there_and_back};
use std::f64::consts::TAU;

const METHOD: &str = "iterative-learning";

/// RMS of reference minus load over the last quarter, over that of `none`.
fn ratio(config: &AxisConfig, motion: Motion, seconds: f64) -> f64 {
    let [with, without] = [METHOD, "none"].map(|method| {
        let mut error = errors(&run(config, method, motion, seconds));
        rms(error.split_off(error.len() * 3 / 4))
    });
    with / without
}

#[test]
fn circles_with_friction_lose_less_than_a_tenth_of_all_error() {
    for (share, gap) in [(0.02, 20.0), (0.1, 5.0), (0.3, 20.0)] {
        for (radius, feed) in [(5.0, 1500.0), (50.0, 3000.0), (25.0, 10_000.0)] {
            let w = feed / 60.0 / radius;
            let ratio = ratio(
                &mill_x(share, gap, Some(1 << 20)),
                &|t| circle(radius, w, t),
                10.0 * TAU / w,
            );
            assert!(
                ratio < 0.1,
                "friction {share} gap {gap} R {radius} F {feed}: {ratio}"
            );
        }
    }
}

#[test]
fn a_load_without_friction_gains_less_and_loses_nothing() {
    for (radius, feed) in [(10.0, 3000.0), (25.0, 10_000.0)] {
        let w = feed / 60.0 / radius;
        let ratio = ratio(
            &mill_x(0.0, 20.0, Some(1 << 20)),
            &|t| circle(radius, w, t),
            10.0 * TAU / w,
        );
        assert!(ratio < 0.4, "R {radius} F {feed}: {ratio}");
    }
}

#[test]
fn strokes_with_rests_are_known_again() {
    let stroke = Move {
        distance: 20.0,
        velocity: 50.0,
        acceleration: 1000.0,
        jerk: 50_000.0,
    };
    let period = 2.0 * (stroke.duration() + 0.1);
    let ratio = ratio(
        &mill_x(0.1, 20.0, Some(1 << 20)),
        &|t| there_and_back(stroke, 0.1, t % period),
        8.0 * period,
    );
    assert!(ratio < 0.1, "{ratio}");
}

#[test]
fn what_never_comes_again_is_left_alone() {
    // an amplitude that grows by a hundredth of a mm and more from reversal to reversal
    let motion = |t: f64| {
        let (s, c) = math::sin_cos(5.0 * t);
        let (r, g) = (5.0 + t, 1.0);
        (
            r * (1.0 - c),
            g * (1.0 - c) + r * 5.0 * s,
            2.0 * g * 5.0 * s + r * 25.0 * c,
        )
    };
    let config = mill_x(0.1, 10.0, None);
    assert_eq!(
        run(&config, METHOD, &motion, 8.0).load,
        run(&config, "none", &motion, 8.0).load
    );
}

#[test]
fn a_stroke_that_turns_out_otherwise_is_given_up_gently() {
    // three strokes alike, then one that begins alike and goes elsewhere
    let stroke = Move {
        distance: 20.0,
        velocity: 50.0,
        acceleration: 1000.0,
        jerk: 50_000.0,
    };
    let longer = Move {
        distance: 30.0,
        ..stroke
    };
    let period = 2.0 * (stroke.duration() + 0.1);
    let motion = |t: f64| {
        if t < 3.0 * period {
            there_and_back(stroke, 0.1, t % period)
        } else {
            longer.at(t - 3.0 * period)
        }
    };
    let seconds = 3.0 * period + longer.duration() + 0.3;
    let config = mill_x(0.1, 20.0, None);
    let [with, without] = [METHOD, "none"].map(|method| {
        let mut error = errors(&run(&config, method, &motion, seconds));
        max_abs(error.split_off((12_000.0 * period) as usize))
    });
    assert!(with < 1.1 * without, "{with} {without}");
}

#[test]
fn the_memory_has_its_bound() {
    let mut config = mill_x(0.1, 20.0, None);
    // shorter than a stroke of 628 ms: nothing is learned
    config.compensation.iterative_learning.memory_s = 0.5;
    let motion = |t: f64| circle(10.0, 5.0, t);
    assert_eq!(
        run(&config, METHOD, &motion, 6.0).load,
        run(&config, "none", &motion, 6.0).load
    );
}
