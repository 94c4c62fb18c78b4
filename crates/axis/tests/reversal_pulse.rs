//! A pulse at the reversal: lower peaks, the same offset.
#![allow(clippy::unwrap_used, reason = "tests")]

mod support;

use support::{circle, mill_x, ratio_on_a_sine, run};

#[test]
fn it_lowers_the_peak_and_leaves_the_offset() {
    for (radius, feed) in [(5.0, 1500.0), (10.0, 3000.0), (50.0, 3000.0)] {
        let [rms, max] = ratio_on_a_sine(&mill_x(0.1, 10.0, None), "reversal-pulse", radius, feed / 60.0 / radius, 4.0);
        assert!(rms > 0.9 && rms < 1.0 && max < 0.9, "R {radius} F {feed}: {rms} {max}");
    }
}

#[test]
fn without_speed_it_does_nothing() {
    let mut config = mill_x(0.1, 10.0, None);
    config.compensation.reversal_pulse.speed_rad_s = Some(0.0);
    let motion = |t: f64| circle(10.0, 5.0, t);
    assert_eq!(run(&config, "reversal-pulse", &motion, 3.0).load, run(&config, "none", &motion, 3.0).load);
}

#[test]
fn it_waits_for_its_delay() {
    let mut config = mill_x(0.1, 10.0, None);
    config.compensation.reversal_pulse.delay_ms = 100.0;
    let motion = |t: f64| circle(10.0, 5.0, t);
    let (with, without) = (run(&config, "reversal-pulse", &motion, 1.0), run(&config, "none", &motion, 1.0));
    // the first direction counts as a reversal: 0.25 ms after the start the reference moves, one period later than its setpoint
    let first = with.load.iter().zip(&without.load).position(|(a, b)| a != b).unwrap();
    let tick = first as f64 * 0.25;
    assert!(tick > 100.0 && tick < 104.0, "{tick} ms");
}
