//! `kalman` and `multiple-models`, which are told the load and not the gap: what they find, what it
//! is good for, and that they do nothing if unsure.

use lostmotion_drive::config::{Gap, Load};
use lostmotion_rig::{circle, mill_x, ratio_on_a_sine, rms, run};
use std::f64::consts::TAU;

const METHODS: [&str; 2] = ["kalman", "multiple-models"];

#[test]
fn a_load_with_friction_loses_less_than_a_tenth() {
    for method in METHODS {
        for (share, gap, radius, feed) in [
            (0.02, 5.0, 10.0, 3000.0),
            (0.1, 5.0, 10.0, 3000.0),
            (0.3, 5.0, 5.0, 1500.0),
            (0.3, 20.0, 50.0, 3000.0),
            (0.1, 20.0, 25.0, 10_000.0),
        ] {
            let [rms, max] = ratio_on_a_sine(
                &mill_x(share, gap, Some(1 << 20)),
                method,
                radius,
                feed / 60.0 / radius,
                8.0,
            );
            assert!(
                rms < 0.1 && max < 0.2,
                "{method} friction {share} gap {gap} R {radius} F {feed}: {rms} {max}"
            );
        }
    }
}

#[test]
fn an_ideal_encoder_is_no_reason_to_be_too_sure() {
    for method in METHODS {
        for share in [0.1, 0.3] {
            let [rms, _] = ratio_on_a_sine(&mill_x(share, 20.0, None), method, 10.0, 5.0, 8.0);
            assert!(rms < 0.1, "{method} friction {share}: {rms}");
        }
    }
}

#[test]
fn the_mixture_follows_the_gap_angle_itself() {
    let config = mill_x(0.1, 20.0, Some(1 << 20));
    let trace = run(
        &config,
        "multiple-models",
        &|t| circle(10.0, 5.0, t),
        6.0 * TAU / 5.0,
    )
    .trace
    .unwrap_or_default();
    let error = rms(trace
        .iter()
        .skip(trace.len() / 2)
        .map(|s| s.gap_angle_estimate - (s.motor_position - s.load_position)));
    let half_gap = config.reflected_load().half_gap_rad();
    assert!(error < 0.1 * half_gap, "{}", error / half_gap);
}

#[test]
fn without_friction_they_are_no_worse_than_nothing() {
    for method in METHODS {
        for (radius, feed) in [(5.0, 1500.0), (10.0, 3000.0), (50.0, 3000.0)] {
            let [rms, max] = ratio_on_a_sine(
                &mill_x(0.0, 20.0, Some(1 << 20)),
                method,
                radius,
                feed / 60.0 / radius,
                8.0,
            );
            assert!(
                rms < 1.001 && max < 1.001,
                "{method} R {radius}: {rms} {max}"
            );
        }
    }
}

#[test]
fn without_a_gap_they_do_nothing() {
    let rigid = mill_x(0.1, 20.0, Some(1 << 20)).without_gap();
    let motion = |t: f64| circle(10.0, 5.0, t);
    for method in METHODS {
        assert_eq!(
            run(&rigid, method, &motion, 6.0).load,
            run(&rigid, "none", &motion, 6.0).load,
            "{method}"
        );
    }
}

#[test]
fn the_gap_itself_is_not_known() {
    // the same drive on a larger gap and a spread that says less: still found
    for method in METHODS {
        let mut config = mill_x(0.1, 60.0, Some(1 << 20));
        config.compensation.kalman.gap_spread = Some(Gap::Um(200.0));
        config.compensation.multiple_models.gap_spread = Some(Gap::Um(200.0));
        if let Load::Slide(slide) = &mut config.load {
            slide.constant_n = 60.0;
        }
        let [rms, _] = ratio_on_a_sine(&config, method, 10.0, 5.0, 16.0);
        assert!(rms < 0.2, "{method}: {rms}");
    }
}
