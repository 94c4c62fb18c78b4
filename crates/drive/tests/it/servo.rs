//! The drive: closed forms of its loops, its limits, and what a run as a whole has to keep.

use lostmotion_drive::config::{Drive, Load, Tuning};
use lostmotion_drive::{AxisOutput, AxisRunner, AxisSim};
use lostmotion_methods::AxisConfig;
use lostmotion_methods::none::Uncompensated;
use lostmotion_methods::{MethodId, build_runner};
use lostmotion_rig::{Move, circle, errors, max_abs, mill, rms, run, setpoints};

/// From rest to a constant velocity.
fn ramp_up(speed: f64, t: f64) -> (f64, f64, f64) {
    let rise = 0.1;
    if t < rise {
        let u = t / rise;
        (
            speed * rise * (u * u * u - 0.5 * u * u * u * u),
            speed * (3.0 * u * u - 2.0 * u * u * u),
            speed * 6.0 * (u - u * u) / rise,
        )
    } else {
        (speed * (0.5 * rise + t - rise), speed, 0.0)
    }
}

#[test]
fn without_feed_forward_the_following_error_is_velocity_over_kv() {
    for config in [
        AxisConfig::paper(),
        AxisConfig {
            drive: Drive {
                velocity_feedforward: 0.0,
                ..mill(0.0, 0.0).drive
            },
            ..mill(0.0, 0.0)
        },
    ] {
        let config = config.without_gap();
        let out = run(&config, "none", &|t| ramp_up(5.0, t), 2.0);
        let lag = *errors(&out).last().unwrap();
        let expected = 5.0 / config.drive.position_gain_per_s;
        assert!(
            (lag / expected - 1.0).abs() < 1e-3,
            "{lag} against {expected}"
        );
    }
}

#[test]
fn with_feed_forward_an_arc_without_gap_is_tracked_to_under_a_micrometre() {
    // R 10 mm, F 3000 mm/min, after the jump of acceleration at the start has died away
    for config in [mill(0.0, 0.0), mill(0.0, 500.0)] {
        let out = run(
            &config.without_gap(),
            "none",
            &|t| circle(10.0, 5.0, t),
            5.0,
        );
        let error = max_abs(errors(&out).split_off(4000));
        assert!(error < 1e-3, "{} um", error * 1e3);
    }
}

#[test]
fn the_radius_shrinks_as_a_position_loop_says() {
    // to first order in (w/Kv)^2: gain of the loop 1/sqrt(1 + (w/Kv)^2) for a fast velocity loop
    let mut config = mill(0.0, 0.0).without_gap();
    config.drive.velocity_feedforward = 0.0;
    config.drive.acceleration_feedforward = 0.0;
    config.drive.position_gain_per_s = 20.0;
    let out = run(
        &config,
        "none",
        &|t| circle(10.0, 2.0, t),
        8.0 * std::f64::consts::PI,
    );
    let tail = &out.load[out.load.len() - 4 * 3142..];
    let (low, high) = tail
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    let shrink = 10.0 - 0.5 * (high - low);
    let expected = 10.0 * 0.5 * (2.0_f64 / 20.0) * (2.0 / 20.0);
    assert!(
        (shrink / expected - 1.0).abs() < 0.1,
        "{shrink} against {expected}"
    );
}

#[test]
fn limits_hold_and_the_axis_comes_back_from_them() {
    let mut config = AxisConfig::paper().without_gap();
    config.drive.current_limit_a = 2.0;
    // asks for three times the torque there is
    let fast = Move {
        distance: 20.0,
        velocity: 40.0,
        acceleration: 800.0,
        jerk: 40_000.0,
    };
    let out = run(&config, "none", &|t| fast.at(t), 4.0);
    assert!(
        out.saturated_samples > 50 && out.peak_current_a < 2.2,
        "{} {}",
        out.saturated_samples,
        out.peak_current_a
    );
    let error = errors(&out);
    assert!(max_abs(error[error.len() - 400..].iter().copied()) < 1e-6);
    let overshoot = out.load.iter().fold(0.0_f64, |max, p| max.max(p - 20.0));
    assert!(overshoot < 2.0, "{overshoot}");

    let mut config = AxisConfig::paper().without_gap();
    config.drive.bus_voltage_v = 40.0;
    let out = run(&config, "none", &|t| fast.at(t), 4.0);
    assert!(out.saturated_samples > 50);
    // 40/sqrt(3) V hold 32 rad/s at most
    let trace = out.trace.unwrap();
    assert!(
        trace
            .iter()
            .all(|s| s.motor_velocity < 40.0 / 3.0_f64.sqrt() / 0.72 * 1.05)
    );
    assert!((trace.last().unwrap().load_position - 20.0).abs() < 1e-6);
}

#[test]
fn every_method_settles_and_stands_still_on_a_machine_with_friction() {
    let stroke = Move {
        distance: 30.0,
        velocity: 100.0,
        acceleration: 2000.0,
        jerk: 50_000.0,
    };
    // the printed gain diverges: tests/compensators.rs
    for method in MethodId::all().filter(|method| method.name() != "published-literal") {
        let out = run(
            &mill(300.0, 100.0),
            method.name(),
            &|t| stroke.at(t - 0.02),
            2.0,
        );
        assert!(max_abs(errors(&out).split_off(7800)) < 0.01);
        let trace = out.trace.unwrap();
        let tail = &trace[trace.len() - 200..];
        let spread = max_abs(tail.iter().map(|s| s.load_position - tail[0].load_position));
        assert!(spread < 1e-9, "{method} moves by {spread} rad");
    }
}

#[test]
fn the_field_current_stays_near_zero() {
    // i_d is not in the trace; what it would cost shows in the plant's state
    let mut runner = build_runner(&AxisConfig::paper(), MethodId::NONE, 0.0).unwrap();
    let mut out = AxisOutput::default();
    let fast = Move {
        distance: 20.0,
        velocity: 40.0,
        acceleration: 400.0,
        jerk: 8000.0,
    };
    for setpoint in setpoints(&|t| fast.at(t), 1.0) {
        runner.push(&[setpoint], &mut out).unwrap();
        assert!(
            runner.plant().current_d.abs() < 0.05,
            "{}",
            runner.plant().current_d
        );
    }
}

#[test]
fn a_coarse_encoder_costs_about_its_count() {
    let mut config = mill(0.0, 0.0).without_gap();
    config.drive.encoder_counts_per_rev = Some(1 << 17);
    let out = run(&config, "none", &|t| circle(10.0, 2.0, t), 4.0);
    let count_mm = 10.0 / f64::from(1 << 17);
    let error = rms(errors(&out).split_off(4000));
    assert!(error < 10.0 * count_mm, "{error}");
}

#[test]
fn chunks_and_copies_do_not_change_a_bit() {
    let points = setpoints(&|t| circle(10.0, 5.0, t), 0.6);
    for method in MethodId::all() {
        let mut whole = AxisOutput::new(false);
        build_runner(&mill(200.0, 0.0), method, 0.0)
            .unwrap()
            .push(&points, &mut whole)
            .unwrap();
        let mut pieces = AxisOutput::new(false);
        let mut runner = build_runner(&mill(200.0, 0.0), method, 0.0).unwrap();
        for chunk in points.chunks(7) {
            runner.push(chunk, &mut pieces).unwrap();
            runner = runner.boxed_clone();
        }
        assert_eq!(whole, pieces, "{method}");
    }
}

#[test]
fn a_state_kept_as_text_goes_on_to_the_bit() {
    let points = setpoints(&|t| circle(10.0, 5.0, t), 0.6);
    let mut sim = AxisSim::new(&mill(200.0, 0.0), Uncompensated, 0.0);
    let mut out = AxisOutput::new(false);
    sim.push(&points[..300], &mut out).unwrap();
    let kept = serde_json::to_string(sim.state()).unwrap();
    let mut other = AxisSim::new(&mill(200.0, 0.0), Uncompensated, 0.0);
    other.restore(serde_json::from_str(&kept).unwrap());
    out.clear();
    let mut again = AxisOutput::new(false);
    sim.push(&points[300..], &mut out).unwrap();
    other.push(&points[300..], &mut again).unwrap();
    assert_eq!(out.load, again.load);
}

#[test]
fn a_hanging_axis_holds_its_place() {
    let mut config = mill(100.0, 0.0);
    if let Load::Slide(slide) = &mut config.load {
        slide.constant_n = 1500.0;
    }
    let out = run(&config, "none", &|_| (50.0, 0.0, 0.0), 0.5);
    assert!(max_abs(out.load.iter().map(|p| p - out.load[0])) < 1e-9);
    // half the gap and the wind-up of 1500 N over 120 N/um below the motor
    assert!(
        (out.load[0] - (50.0 - 0.005 - 0.0125)).abs() < 1e-9,
        "{}",
        out.load[0]
    );
}

#[test]
fn the_tuning_rule_places_the_poles_it_names() {
    let config = AxisConfig::paper();
    let tuning = Tuning {
        velocity_frequency_hz: 161.4 / std::f64::consts::TAU,
        velocity_damping: 0.6976,
        ..Tuning::default()
    };
    let drive = config.tuned(&tuning).drive;
    // the paper's own gains decode to this natural frequency and damping
    assert!(
        (drive.velocity_gain_a_s_per_rad / 1.74 - 1.0).abs() < 2e-3,
        "{}",
        drive.velocity_gain_a_s_per_rad
    );
    assert!(
        (drive.velocity_time_s / 8.6e-3 - 1.0).abs() < 1e-2,
        "{}",
        drive.velocity_time_s
    );
}
