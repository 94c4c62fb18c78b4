//! What full knowledge gives: the part of the load's error that the gap causes, against no
//! compensation.

use lostmotion_drive::AxisOutput;
use lostmotion_drive::config::{Gap, Load};
use lostmotion_methods::AxisConfig;
use lostmotion_rig::{
    Move, circle, errors, lost_on_a_sine, max_abs, mill_x, ratio_on_a_sine, rms, run,
    there_and_back,
};
use std::f64::consts::TAU;

/// Radius in mm and feed in mm/min.
const SINES: [(f64, f64); 4] = [
    (5.0, 300.0),
    (10.0, 3000.0),
    (50.0, 3000.0),
    (25.0, 10_000.0),
];

#[test]
fn friction_driven_and_mixed_loads_lose_less_than_a_hundredth() {
    for share in [0.02, 0.1, 0.3] {
        for gap in [5.0, 20.0, 60.0] {
            for (radius, feed) in SINES {
                let [rms, max] = ratio_on_a_sine(
                    &mill_x(share, gap, None),
                    "lookup",
                    radius,
                    feed / 60.0 / radius,
                    4.0,
                );
                assert!(
                    rms < 0.0075 && max < 0.09,
                    "friction {share} gap {gap} R {radius} F {feed}: {rms} {max}"
                );
            }
        }
    }
}

#[test]
fn an_encoder_of_finite_steps_costs_no_more_than_its_own_noise() {
    for counts in [1 << 23, 1 << 20] {
        for (radius, feed) in SINES {
            let [rms, _] = ratio_on_a_sine(
                &mill_x(0.1, 10.0, Some(counts)),
                "lookup",
                radius,
                feed / 60.0 / radius,
                4.0,
            );
            assert!(rms < 0.007, "{counts} R {radius} F {feed}: {rms}");
        }
    }
}

#[test]
fn a_load_without_friction_is_caught_softly() {
    for (radius, feed) in &SINES[1..] {
        let [rms, max] = ratio_on_a_sine(
            &mill_x(0.0, 20.0, None),
            "lookup",
            *radius,
            feed / 60.0 / radius,
            4.0,
        );
        assert!(
            rms < 0.0075 && max < 0.08,
            "R {radius} F {feed}: {rms} {max}"
        );
    }
    // so slow that what the load needs is a three-thousandth of the rated torque: no longer soft
    // enough, but better than nothing
    let [rms, max] = ratio_on_a_sine(&mill_x(0.0, 20.0, None), "lookup", 5.0, 1.0, 4.0);
    assert!(rms < 0.1 && max < 0.4, "{rms} {max}");
}

/// Soft loops stop a load a little beside its place, where it sticks; the motor, once it has left its
/// flank, runs on to its reference. A crossing of the whole gap from there would push the load.
#[test]
fn a_motor_that_has_run_ahead_of_a_load_that_sticks_does_not_push_it() {
    let mut config = mill_x(0.013, 10.0, None);
    config.drive.position_gain_per_s = 15.0;
    config.drive.velocity_gain_a_s_per_rad = 0.48;
    config.drive.velocity_time_s = 0.02;
    let stroke = Move {
        distance: 5.0,
        velocity: 30.0,
        acceleration: 500.0,
        jerk: 20_000.0,
    };
    let motion = |t: f64| {
        if t < stroke.duration() {
            stroke.at(t)
        } else {
            (stroke.distance, 0.0, 0.0)
        }
    };
    let rigid = run(&config.without_gap(), "none", &motion, 5.0);
    let out = run(&config, "lookup", &motion, 5.0);
    let stop = (stroke.duration() * 4000.0) as usize;
    let lost: Vec<f64> = out
        .load
        .iter()
        .zip(&rigid.load)
        .skip(stop)
        .map(|(a, b)| (a - b) * 1e3)
        .collect();
    // pushed, it would be 1.2 um off, and stay off by 0.2 um
    let (most, last) = (max_abs(lost.iter().copied()), lost[lost.len() - 1]);
    assert!(most < 0.7 && last.abs() < 0.01, "{most} {last} um");
}

#[test]
fn the_papers_axis_too_with_and_without_feedforward_and_friction() {
    for (coulomb, feedforward) in [(0.0, 0.0), (0.0, 1.0), (1.1, 0.0), (1.1, 1.0)] {
        for (radius, w) in [(5.0, 2.0), (1.0, 15.0)] {
            let mut config = AxisConfig::paper();
            config.drive.velocity_feedforward = feedforward;
            config.drive.acceleration_feedforward = feedforward;
            if let Load::Reflected(load) = &mut config.load {
                load.coulomb_nm = coulomb;
            }
            let [rms, max] = ratio_on_a_sine(&config, "lookup", radius, w, 4.0);
            assert!(
                rms < 0.01 && max < 0.02,
                "{coulomb} {feedforward} A {radius} w {w}: {rms} {max}"
            );
        }
    }
}

#[test]
fn a_wrongly_told_gap_leaves_its_difference() {
    let mut config = mill_x(0.1, 10.0, None);
    config.compensation.lookup.gap = Some(Gap::Um(8.0));
    let [rms, _] = lost_on_a_sine(&config, "lookup", 50.0, 1.0, 4.0);
    // half of what was told too little, on both sides
    assert!((rms - 1.0).abs() < 0.02, "{rms} um");
}

#[test]
fn wind_up_is_made_up_for_when_asked() {
    let stroke = Move {
        distance: 5.0,
        velocity: 20.0,
        acceleration: 200.0,
        jerk: 5000.0,
    };
    let lost = |wind_up: f64| {
        let mut config = mill_x(0.1, 10.0, None);
        config.compensation.lookup.wind_up = wind_up;
        let error = errors(&run(
            &config,
            "lookup",
            &|t| there_and_back(stroke, 0.5, t),
            2.0,
        ));
        // both ways at constant speed
        (error[1000] - error[4400]).abs()
    };
    // (432 N + 500 N s/m * 0.02 m/s) / 238 N/um on each side
    let expected = 2.0 * (0.1 * 11.0 / (0.016 / std::f64::consts::TAU) + 10.0) / 238.0 * 1e-3;
    assert!(
        (lost(0.0) / expected - 1.0).abs() < 0.02,
        "{} against {expected}",
        lost(0.0)
    );
    assert!(lost(1.0) < 0.02 * expected, "{}", lost(1.0));
}

#[test]
fn without_a_gap_it_does_nothing() {
    let config = mill_x(0.1, 10.0, None).without_gap();
    let motion = |t: f64| circle(10.0, 5.0, t);
    assert_eq!(
        run(&config, "lookup", &motion, 3.0).load,
        run(&config, "none", &motion, 3.0).load
    );
}

#[test]
fn mirrored_input_gives_mirrored_output() {
    let config = mill_x(0.1, 10.0, None);
    let forth = run(&config, "lookup", &|t| circle(10.0, 5.0, t), 3.0);
    let mirrored = run(&config, "lookup", &|t| circle(-10.0, 5.0, t), 3.0);
    let difference = max_abs(forth.load.iter().zip(&mirrored.load).map(|(a, b)| a + b));
    assert!(difference < 1e-9 * rms(forth.load), "{difference}");
}

/// A gap that is known to a tenth is taken for the least that it may be: the same as a drive that
/// is told that gap, and wrong by what is missing whichever way it is off.
#[test]
fn a_gap_known_to_a_part_only_is_taken_for_the_least_it_may_be() {
    let mut config = mill_x(0.1, 10.0, None);
    let motion = |t: f64| circle(10.0, 5.0, t);
    let exact = run(&config, "lookup", &motion, 2.0).load;
    let mut less = config.clone();
    less.compensation.lookup.gap = Some(Gap::Um(9.0));
    let told_less = run(&less, "lookup", &motion, 2.0).load;
    config.compensation.lookup.gap = Some(Gap::Um(10.0));
    config.compensation.gap_uncertainty = 0.1;
    let uncertain = run(&config, "lookup", &motion, 2.0).load;
    assert_ne!(uncertain, exact);
    let apart = uncertain
        .iter()
        .zip(&told_less)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(apart < 1e-5, "{apart} mm");
    // What is told no gap does not heed it.
    let none = |config: &AxisConfig| run(config, "none", &motion, 2.0).load;
    assert_eq!(none(&config), none(&less));
    for wrong in [-0.1, 1.0, f64::NAN] {
        config.compensation.gap_uncertainty = wrong;
        let error = config.check().expect_err("out of range").to_string();
        assert!(error.contains("compensation.gap_uncertainty"), "{error}");
    }
}

#[test]
fn a_gap_that_is_used_after_the_first_crossing_moves_nothing_before_it() {
    let config = mill_x(0.1, 20.0, None);
    let mut after = config.clone();
    after.compensation.lookup.after_crossing = true;
    // slowly forth, and back, four times: friction holds the load against its flank up to the first return
    let stroke = Move {
        distance: 20.0,
        velocity: 30.0,
        acceleration: 100.0,
        jerk: 1000.0,
    };
    let turn = stroke.duration();
    let motion = move |t: f64| there_and_back(stroke, 0.0, t % (2.0 * turn));
    let run = |config: &AxisConfig, method| run(config, method, &motion, 8.0 * turn);
    let [none, told, later] = [
        run(&config, "none"),
        run(&config, "lookup"),
        run(&after, "lookup"),
    ];
    // to the bit as without compensation up to the first change of flank
    let samples = |turns: f64| (turns * turn * 4000.0) as usize;
    assert!(later.load[..samples(0.9)] == none.load[..samples(0.9)]);
    assert!(later.load[..samples(1.5)] != none.load[..samples(1.5)]);
    // from the second crossing on as with everything told
    let last = |out: &AxisOutput| rms(errors(out).into_iter().skip(samples(2.0)));
    let [none, told, later] = [&none, &told, &later].map(last);
    assert!(
        later < 1.05 * told && told < 0.3 * none,
        "{none} {told} {later}"
    );
}

/// Where the flank changes while a part of the gap is applied for the first time, that part is wrong twice over on the
/// other flank: it has to go at once, or what is lost is more than without a correction.
#[test]
fn what_is_applied_for_the_first_time_goes_when_the_flank_changes() {
    let config = mill_x(0.02, 60.0, None);
    let mut after = config.clone();
    after.compensation.lookup.after_crossing = true;
    let rigid = config.without_gap();
    for frequency in [4.0, 6.0, 8.0, 10.0, 14.0] {
        let motion = |t: f64| circle(0.5, TAU * frequency, t);
        let lost = |config: &AxisConfig, method| {
            let rigid = run(&rigid, "none", &motion, 3.0 / frequency);
            let out = run(config, method, &motion, 3.0 / frequency);
            max_abs(out.load.iter().zip(&rigid.load).map(|(a, b)| a - b))
        };
        let [none, later] = [lost(&config, "none"), lost(&after, "lookup")];
        assert!(later <= 1.02 * none, "{frequency} Hz: {none} {later} mm");
    }
}
