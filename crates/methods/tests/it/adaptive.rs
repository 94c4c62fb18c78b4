//! `adaptive`, which is told neither gap nor load: what it leaves of the gap's part of the error,
//! what it learns, and that it does nothing if unsure.

use lostmotion_drive::config::{Load, Slide};
use lostmotion_drive::{AxisSample, AxisSim};
use lostmotion_methods::AxisConfig;
use lostmotion_methods::build_runner;
use lostmotion_rig::{circle, max_abs, mill_x, ratio_on_a_sine, run};
use std::f64::consts::TAU;

/// Radius in mm and feed in mm/min.
const SINES: [(f64, f64); 3] = [(5.0, 1500.0), (10.0, 3000.0), (50.0, 3000.0)];
const TURNS: f64 = 8.0;

fn last(config: &AxisConfig, radius: f64, w: f64, turns: f64) -> AxisSample {
    *run(
        config,
        "adaptive",
        &|t| circle(radius, w, t),
        turns * TAU / w,
    )
    .trace
    .unwrap()
    .last()
    .unwrap()
}

#[test]
fn a_load_with_friction_loses_less_than_two_hundredths() {
    for (share, gap, counts) in [
        (0.02, 5.0, None),
        (0.1, 60.0, None),
        (0.02, 60.0, Some(1 << 23)),
        (0.1, 10.0, Some(1 << 20)),
        (0.3, 20.0, Some(1 << 20)),
    ] {
        for (radius, feed) in SINES {
            let [rms, max] = ratio_on_a_sine(
                &mill_x(share, gap, counts),
                "adaptive",
                radius,
                feed / 60.0 / radius,
                TURNS,
            );
            assert!(
                rms < 0.02 && max < 0.15,
                "friction {share} gap {gap} counts {counts:?} R {radius} F {feed}: {rms} {max}"
            );
        }
    }
}

#[test]
fn the_gap_is_known_within_two_hundredths_and_the_inertia_within_three() {
    let config = mill_x(0.1, 10.0, Some(1 << 20));
    let sample = last(&config, 10.0, 5.0, 6.0);
    let gap_um = 2.0 * sample.gap_angle_estimate.abs() * 16e3 / TAU;
    assert!((gap_um / 10.0 - 1.0).abs() < 0.02, "{gap_um}");
    let inertia = config.motor_side_inertia_kgm2() + config.reflected_load().inertia_kgm2;
    assert!(
        (sample.inertia_estimate / inertia - 1.0).abs() < 0.03,
        "{} {inertia}",
        sample.inertia_estimate
    );
}

#[test]
fn nothing_of_the_load_but_its_shaft_is_told() {
    let config = mill_x(0.1, 10.0, None);
    let mut other = config.clone();
    if let Load::Slide(slide) = &mut other.load {
        *slide = Slide {
            mass_kg: 900.0,
            viscous_n_s_per_m: 0.0,
            coulomb_n: 1000.0,
            constant_n: 50.0,
            gap_um: 33.0,
            ..*slide
        };
    }
    // the drive's own settings are those of the first axis; the description differs only in what
    // may not be known
    other.drive.told_inertia_kgm2 =
        Some(config.motor_side_inertia_kgm2() + config.reflected_load().inertia_kgm2);
    let first = build_runner(&config, "adaptive".parse().unwrap(), 0.0).unwrap();
    assert!(!first.info().knows.gap && !first.info().knows.load && !first.info().knows.load_scale);
    let [rms, max] = ratio_on_a_sine(&other, "adaptive", 10.0, 5.0, TURNS);
    assert!(rms < 0.03 && max < 0.2, "{rms} {max}");
}

#[test]
fn on_a_machine_without_a_gap_it_does_nothing() {
    let rigid = mill_x(0.1, 10.0, Some(1 << 20)).without_gap();
    let motion = |t: f64| circle(10.0, 5.0, t);
    assert_eq!(
        run(&rigid, "adaptive", &motion, 8.0).load,
        run(&rigid, "none", &motion, 8.0).load
    );
}

#[test]
fn the_papers_axis_with_a_small_gap_and_some_friction() {
    let mut config = AxisConfig::paper().with_gap(0.004);
    let Load::Reflected(load) = &mut config.load else {
        panic!("the paper's load turns");
    };
    load.coulomb_nm = 0.03 * config.motor.rated_torque_nm;
    for feedforward in [0.0, 1.0] {
        config.drive.velocity_feedforward = feedforward;
        config.drive.acceleration_feedforward = feedforward;
        let [rms, max] = ratio_on_a_sine(&config, "adaptive", 5.0, 6.0, TURNS);
        assert!(rms < 0.02 && max < 0.1, "{feedforward}: {rms} {max}");
    }
}

#[test]
fn a_load_without_friction_is_left_exactly_as_it_is() {
    let mut config = AxisConfig::paper().with_gap(0.004);
    for feedforward in [0.0, 1.0] {
        config.drive.velocity_feedforward = feedforward;
        config.drive.acceleration_feedforward = feedforward;
        let motion = |t: f64| circle(5.0, 6.0, t);
        assert_eq!(
            run(&config, "adaptive", &motion, 8.0).load,
            run(&config, "none", &motion, 8.0).load
        );
    }
}

#[test]
fn it_learns_the_same_in_the_mirror() {
    let config = mill_x(0.1, 10.0, None);
    let [forth, back] =
        [10.0, -10.0].map(|radius| run(&config, "adaptive", &|t| circle(radius, 5.0, t), 8.0));
    let difference = max_abs(forth.load.iter().zip(&back.load).map(|(a, b)| a + b));
    assert!(difference < 1e-6, "{difference} mm");
}

#[test]
fn it_goes_on_from_a_state_kept_as_text() {
    use lostmotion_drive::AxisRunner;
    use lostmotion_methods::adaptive::Adaptive;
    use lostmotion_methods::registry::Registered;
    let config = mill_x(0.1, 10.0, None);
    let points = lostmotion_rig::setpoints(&|t| circle(10.0, 5.0, t), 6.0);
    let new = || AxisSim::new(&config, Adaptive::from_axis(&config), 0.0);
    let (mut sim, mut other) = (new(), new());
    let mut out = lostmotion_drive::AxisOutput::new(false);
    sim.push(&points[..5100], &mut out).unwrap();
    other.restore(serde_json::from_str(&serde_json::to_string(sim.state()).unwrap()).unwrap());
    out.clear();
    let mut again = lostmotion_drive::AxisOutput::new(false);
    sim.push(&points[5100..], &mut out).unwrap();
    other.push(&points[5100..], &mut again).unwrap();
    let difference = max_abs(out.load.iter().zip(&again.load).map(|(a, b)| a - b));
    assert!(
        difference < 1e-4,
        "{difference} mm: text rounds the last bit of some numbers"
    );
}

#[test]
fn strokes_with_their_rests_too() {
    use lostmotion_rig::{Move, rms, there_and_back};
    let stroke = Move {
        distance: 20.0,
        velocity: 50.0,
        acceleration: 1000.0,
        jerk: 50_000.0,
    };
    for (rest, bound) in [(0.0, 0.03), (0.2, 0.03)] {
        let config = mill_x(0.1, 10.0, Some(1 << 20));
        let period = 2.0 * (stroke.duration() + rest);
        let motion = |t: f64| there_and_back(stroke, rest, t % period);
        let rigid = run(&config.without_gap(), "none", &motion, 6.0 * period);
        let [with, without] = ["adaptive", "none"].map(|method| {
            let out = run(&config, method, &motion, 6.0 * period);
            let half = out.load.len() / 2;
            rms(out
                .load
                .iter()
                .zip(&rigid.load)
                .skip(half)
                .map(|(a, b)| a - b))
        });
        assert!(with < bound * without, "rest {rest}: {}", with / without);
    }
}

#[test]
fn where_it_learns_slowly_or_not_at_all_it_is_not_worse_than_nothing() {
    let mut paper = AxisConfig::paper();
    (
        paper.drive.velocity_feedforward,
        paper.drive.acceleration_feedforward,
    ) = (1.0, 1.0);
    let with_friction = |gap: f64| {
        let mut config = paper.with_gap(gap);
        if let Load::Reflected(load) = &mut config.load {
            load.coulomb_nm = 1.1;
        }
        config
    };
    let cells = [
        (with_friction(0.02), 5.0, 6.0),
        (with_friction(0.2), 5.0, 6.0),
        (with_friction(0.004), 1.0, 15.0),
        (paper.with_gap(0.02), 5.0, 2.0),
        (mill_x(0.1, 5.0, Some(1 << 20)), 5.0, 1.0),
        (mill_x(0.0, 60.0, Some(1 << 23)), 25.0, 20.0 / 3.0),
    ];
    for (config, radius, w) in cells {
        let [rms, max] = ratio_on_a_sine(&config, "adaptive", radius, w, TURNS);
        assert!(
            rms < 1.01 && max < 1.01,
            "gap {:?} A {radius} w {w}: {rms} {max}",
            config.gap_in_unit()
        );
    }
}

#[test]
fn two_turns_are_enough_and_a_gap_that_grows_is_followed() {
    use lostmotion_drive::config::{Change, Shape};
    let steady = mill_x(0.1, 20.0, Some(1 << 20));
    let mut growing = steady.clone();
    growing.drift.gap = Some(Change {
        factor: 1.2,
        over_s: 6.0,
        shape: Shape::Ramp,
    });
    let (radius, w) = (10.0, 5.0);
    let motion = |t: f64| circle(radius, w, t);
    for config in [&steady, &growing] {
        let seconds = 5.0 * TAU / w;
        let rigid = run(&config.without_gap(), "none", &motion, seconds);
        let [with, without] = ["adaptive", "none"].map(|method| {
            let out = run(config, method, &motion, seconds);
            // after the fourth reversal: two turns
            lostmotion_rig::rms(
                out.load
                    .iter()
                    .zip(&rigid.load)
                    .skip(out.load.len() * 9 / 20)
                    .map(|(a, b)| a - b),
            )
        });
        assert!(with < 0.06 * without, "{}", with / without);
    }
}

#[test]
fn a_stiffness_that_is_wrong_by_three_tenths_does_little() {
    use lostmotion_drive::config::{Change, Shape};
    for factor in [0.7, 1.3] {
        let mut config = mill_x(0.1, 20.0, Some(1 << 20));
        config.drift.stiffness = Some(Change {
            factor,
            over_s: 1e-3,
            shape: Shape::Ramp,
        });
        let [rms, _] = ratio_on_a_sine(&config, "adaptive", 10.0, 5.0, TURNS);
        assert!(rms < 0.1, "{factor}: {rms}");
    }
}

#[test]
fn minutes_of_motion_change_nothing() {
    let config = mill_x(0.1, 10.0, Some(1 << 20));
    let motion = |t: f64| circle(10.0, 5.0, t);
    let seconds = 120.0;
    let [with, without, rigid] = [
        ("adaptive", &config),
        ("none", &config),
        ("none", &config.without_gap()),
    ]
    .map(|(method, config)| run(config, method, &motion, seconds));
    let share = |part: std::ops::Range<usize>| {
        let rms = |out: &lostmotion_drive::AxisOutput| {
            lostmotion_rig::rms(
                out.load[part.clone()]
                    .iter()
                    .zip(&rigid.load[part.clone()])
                    .map(|(a, b)| a - b),
            )
        };
        rms(&with) / rms(&without)
    };
    let sixth = rigid.load.len() / 6;
    for n in 1..6 {
        let left = share(n * sixth..(n + 1) * sixth);
        assert!(left < 0.02, "{n}: {left}");
    }
    let gap_um = 2.0 * with.trace.unwrap().last().unwrap().gap_angle_estimate.abs() * 16e3 / TAU;
    assert!((gap_um / 10.0 - 1.0).abs() < 0.01, "{gap_um}");
}
