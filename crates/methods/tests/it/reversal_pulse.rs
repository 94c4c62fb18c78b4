//! A pulse at the reversal: lower peaks, the same offset.

use lostmotion_methods::AxisConfig;
use lostmotion_rig::{circle, mill_x, ratio_on_a_sine, run};

#[test]
fn it_lowers_the_peak_and_leaves_the_offset() {
    for (radius, feed) in [(5.0, 1500.0), (10.0, 3000.0), (50.0, 3000.0)] {
        let [rms, max] = ratio_on_a_sine(
            &mill_x(0.1, 10.0, None),
            "reversal-pulse",
            radius,
            feed / 60.0 / radius,
            4.0,
        );
        assert!(
            rms > 0.9 && rms < 1.0 && max < 0.9,
            "R {radius} F {feed}: {rms} {max}"
        );
    }
}

#[test]
fn without_speed_it_does_nothing() {
    let mut config = mill_x(0.1, 10.0, None);
    config.compensation.reversal_pulse.speed_rad_s = Some(0.0);
    let motion = |t: f64| circle(10.0, 5.0, t);
    assert_eq!(
        run(&config, "reversal-pulse", &motion, 3.0).load,
        run(&config, "none", &motion, 3.0).load
    );
}

#[test]
fn it_waits_for_its_delay() {
    let mut config = mill_x(0.1, 10.0, None);
    config.compensation.reversal_pulse.delay_ms = 100.0;
    let motion = |t: f64| circle(10.0, 5.0, t);
    let (with, without) = (
        run(&config, "reversal-pulse", &motion, 1.0),
        run(&config, "none", &motion, 1.0),
    );
    // the first direction counts as a reversal: 0.25 ms after the start the reference moves, one
    // period later than its setpoint
    let first = with
        .load
        .iter()
        .zip(&without.load)
        .position(|(a, b)| a != b)
        .unwrap();
    let tick = first as f64 * 0.25;
    assert!(tick > 100.0 && tick < 104.0, "{tick} ms");
}

/// The paper's motor in the middle of its gap, without friction, its loops all but off: what turns
/// it is the pulse alone.
fn loose() -> AxisConfig {
    let mut config = AxisConfig::paper();
    config.motor.viscous_nm_s_per_rad = 0.0;
    config.drive.position_gain_per_s = 0.0;
    config.drive.velocity_gain_a_s_per_rad *= 1e-9;
    config
}

#[test]
fn a_pulse_of_torque_gives_the_motor_its_momentum() {
    for (torque_nm, time_ms) in [(2.0, 10.0), (0.5, 10.0), (3.0, 4.0)] {
        let mut config = loose();
        let pulse = &mut config.compensation.reversal_pulse;
        (pulse.torque_nm, pulse.time_ms) = (Some(torque_nm), time_ms);
        // 3 rad/s at most: the load stays behind in the gap of 0.2 rad
        let out = run(&config, "reversal-pulse", &|t| circle(10.0, 5.0, t), 0.02);
        let speeds = out.trace.unwrap();
        // when the current loop has settled
        let reached = speeds
            .iter()
            .take_while(|s| s.load_velocity == 0.0)
            .last()
            .map_or(0.0, |s| s.motor_velocity);
        // a triangle that falls to zero, held over servo ticks: T + 250 us of half its height
        let expected = 0.5 * torque_nm * (time_ms + 0.25) * 1e-3 / config.motor.inertia_kgm2;
        assert!(
            (reached / expected - 1.0).abs() < 0.01,
            "{torque_nm} N m for {time_ms} ms: {reached} rad/s against {expected}"
        );
        assert!(
            speeds[20..60].iter().all(|s| s.motor_velocity > 0.0),
            "the first way is the positive one"
        );
    }
}
