//! The textbook methods on plants of which the answer is known.

use lostmotion_drive::config::Gap;
use lostmotion_drive::{Compensator, Signals};
use lostmotion_methods::disturbance_observer::DisturbanceObserver;
use lostmotion_methods::registry::Registered;
use lostmotion_rig::{circle, max_abs, mill_x, ratio_on_a_sine, run};
use std::f64::consts::TAU;

#[test]
fn the_inverse_learns_both_half_gaps_of_a_load_with_friction() {
    for gap in [5.0, 20.0] {
        let config = mill_x(0.1, gap, Some(1 << 20));
        let trace = run(
            &config,
            "adaptive-inverse",
            &|t| circle(10.0, 5.0, t),
            8.0 * TAU / 5.0,
        )
        .trace
        .unwrap_or_default();
        let last = &trace[trace.len() / 2..];
        let um = |rad: f64| rad * 16e3 / TAU;
        let up = last
            .iter()
            .map(|s| um(s.gap_angle_estimate))
            .fold(f64::MIN, f64::max);
        let down = last
            .iter()
            .map(|s| um(s.gap_angle_estimate))
            .fold(f64::MAX, f64::min);
        // the scale reads in steps of 0.1 um
        assert!(
            (up - 0.5 * gap).abs() < 0.1 && (down + 0.5 * gap).abs() < 0.1,
            "{gap}: {down} to {up}"
        );
        let [rms, _] = ratio_on_a_sine(&config, "adaptive-inverse", 10.0, 5.0, 8.0);
        assert!(rms < 0.08, "{gap}: {rms}");
    }
}

#[test]
fn the_inverse_harms_a_load_that_coasts() {
    let [rms, max] = ratio_on_a_sine(&mill_x(0.0, 20.0, None), "adaptive-inverse", 10.0, 5.0, 8.0);
    assert!(rms > 1.2 && max > 1.5, "{rms} {max}");
}

#[test]
fn the_inverse_stays_within_its_bound() {
    let mut config = mill_x(0.1, 20.0, None);
    config.compensation.adaptive_inverse.largest_gap = Some(Gap::Um(8.0));
    let trace = run(&config, "adaptive-inverse", &|t| circle(10.0, 5.0, t), 6.0)
        .trace
        .unwrap_or_default();
    let most = max_abs(trace.iter().map(|s| s.gap_angle_estimate * 16e3 / TAU));
    assert!((most - 4.0).abs() < 1e-9, "{most}");
}

#[test]
fn the_observer_gives_the_torque_that_an_inertia_does_not_need() {
    let mut config = mill_x(0.1, 10.0, None);
    config.drive.told_inertia_kgm2 = Some(0.005);
    config.compensation.disturbance_observer.share = 0.5;
    let method = DisturbanceObserver::from_axis(&config);
    let mut state = method.initial(0.0);
    // J alpha + d = 0.005 * 200 + 1.5; the filter is behind a ramp of the velocity by what it takes
    // out again
    let current = (0.005 * 200.0 + 1.5) / config.motor.torque_constant_nm_per_a;
    let mut torque = 0.0;
    for tick in 0..2000 {
        let signals = Signals {
            current,
            motor_velocity: 200.0 * f64::from(tick) * 250e-6,
            ..Signals::default()
        };
        torque = method.step(&mut state, &signals).torque;
    }
    assert!((torque - 0.75).abs() < 0.03, "{torque}");
}

#[test]
fn the_observer_leaves_the_offset_of_the_gap() {
    for share in [0.0, 0.02, 0.1] {
        let [rms, _] = ratio_on_a_sine(
            &mill_x(share, 20.0, Some(1 << 20)),
            "disturbance-observer",
            10.0,
            5.0,
            4.0,
        );
        assert!(rms > 0.9 && rms < 1.02, "{share}: {rms}");
    }
}
