//! Margins against closed forms and against the gain at which the simulated axis begins to
//! oscillate; limit cycles beside the simulation.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

use lostmotion_analysis::{
    Cycle, Feedback, LimitCycle, LoopDelays, LoopKind, Margins, Regime, analyse, limit_cycle,
    simulated_cycle,
};
use lostmotion_base::math;
use lostmotion_drive::config::{Load, LowPass, Notch, TorqueFilter, TorqueFilters};
use lostmotion_methods::AxisConfig;
use lostmotion_rig::{max_abs, mill, mill_x, run};
use std::f64::consts::{PI, TAU};

fn with_load(
    mut config: AxisConfig,
    change: impl Fn(&mut lostmotion_drive::config::Reflected),
) -> AxisConfig {
    if let Load::Reflected(load) = &mut config.load {
        change(load);
    }
    config
}

/// The mill with everything in its loops that costs phase.
fn slow_drive() -> AxisConfig {
    let mut config = mill(0.0, 0.0);
    config.drive.command_delay_periods = 7;
    let notch = TorqueFilter::Notch(Notch {
        frequency_hz: 150.0,
        width_hz: 60.0,
        depth_db: 20.0,
    });
    let low = TorqueFilter::LowPass(LowPass {
        frequency_hz: 600.0,
        damping: 0.7,
    });
    config.drive.torque_filter = TorqueFilters::try_from(vec![notch, low]).unwrap();
    config
}

fn margins(config: &AxisConfig, kind: LoopKind, regime: Regime) -> Margins {
    *analyse(config).margins(kind, regime).unwrap()
}

#[test]
fn the_papers_velocity_loop_has_the_frequency_and_damping_of_its_gains() {
    // with J_T: 161 rad/s and 0.70; with J_M alone: 340 rad/s and 1.47 (decoded from 1.74 A s/rad
    // and 8.6 ms); a stiff shaft, so that the resonance has no part in it
    let stiff = with_load(AxisConfig::paper(), |load| load.stiffness_nm_per_rad = 2e5);
    for (regime, natural, damping) in [(Regime::Engaged, 161.4, 0.698), (Regime::Gap, 340.0, 1.47)]
    {
        let found = margins(&stiff, LoopKind::Velocity, regime);
        // |(2 D w_n s + w_n^2)/s^2| = 1
        let d2: f64 = 2.0 * damping * damping;
        let crossover = natural * (d2 + (d2 * d2 + 1.0).sqrt()).sqrt();
        let crossover_found = found.crossover_hz.unwrap() * TAU;
        assert!(
            (crossover_found / crossover - 1.0).abs() < 0.03,
            "{regime}: {crossover_found} against {crossover}"
        );
        // dead time: half a period for the encoder's difference, half for the hold, and the current
        // loop's lag (bandwidth 1370 Hz)
        let dead_time = 250e-6 + 1.0 / (TAU * 1370.0);
        let phase = (math::atan(2.0 * damping * crossover_found / natural)
            - crossover_found * dead_time)
            .to_degrees();
        let phase_found = found.phase_margin_deg.unwrap();
        assert!(
            (phase_found - phase).abs() < 3.0,
            "{regime}: {phase_found} against {phase}"
        );
    }
}

/// Gain of the paper's velocity loop in continuous time, from its equation (2) and its gains.
fn paper_velocity_gain(w: f64) -> f64 {
    let (jm, jl, k, d, kt, b) = (0.00189, 0.0065, 2000.0, 0.8, 1.08, 0.01);
    let size = |re: f64, im: f64| math::hypot(re, im);
    let pi = 1.74 * size(1.0, 1.0 / (w * 8.6e-3));
    let zeros = size(k - jl * w * w, d * w);
    let poles = size(k - jm * jl / (jm + jl) * w * w, d * w);
    pi * kt / size((jm + jl) * w, b) * zeros / poles
}

#[test]
fn on_a_flank_the_papers_velocity_loop_crosses_over_where_equation_2_says() {
    let found = margins(&AxisConfig::paper(), LoopKind::Velocity, Regime::Engaged)
        .crossover_hz
        .unwrap()
        * TAU;
    assert!(
        (paper_velocity_gain(found) - 1.0).abs() < 0.02,
        "{}",
        paper_velocity_gain(found)
    );
}

#[test]
fn a_cancelling_current_loop_is_an_integrator_with_its_delay() {
    // the mill's gains cancel L/R: w_c/s with 1.5 periods of delay, w_c = 2 pi 800 Hz
    let found = margins(&mill(0.0, 0.0), LoopKind::Current, Regime::Engaged);
    assert!(
        (found.crossover_hz.unwrap() / 800.0 - 1.0).abs() < 1e-2,
        "{:?}",
        found.crossover_hz
    );
    let phase = 90.0 - 800.0 * 360.0 * 75e-6;
    assert!(
        (found.phase_margin_deg.unwrap() - phase).abs() < 0.5,
        "{:?} against {phase}",
        found.phase_margin_deg
    );
    // -180 deg where w 75 us = pi/2: 3333 Hz
    assert!((found.gain_margin_hz.unwrap() * 4.0 * 75e-6 - 1.0).abs() < 1e-2);
}

/// Largest motor speed in the third quarter of a run after a kick, and in the last.
fn ringing(config: &AxisConfig) -> [f64; 2] {
    let out = run(
        config,
        "none",
        &|t| (if t > 0.02 { 1e-4 } else { 0.0 }, 0.0, 0.0),
        2.0,
    );
    let speeds: Vec<f64> = out
        .trace
        .unwrap()
        .iter()
        .map(|sample| sample.motor_velocity)
        .collect();
    [4000..6000, 6000..8000].map(|part| max_abs(speeds[part].iter().copied()))
}

/// Scales a gain to 2 % below and above its limit; the simulated axis has to decay and to grow (up
/// to the drive's limits).
fn oscillates_at_its_limit(name: &str, config: &AxisConfig, kind: LoopKind, regime: Regime) {
    let limit = math::pow(
        10.0,
        margins(config, kind, regime).gain_margin_db.unwrap() / 20.0,
    );
    let at = |factor: f64| {
        let mut scaled = config.clone();
        let drive = &mut scaled.drive;
        match kind {
            LoopKind::Current => panic!("its oscillation does not show in the motor's speed"),
            LoopKind::Velocity => drive.velocity_gain_a_s_per_rad *= factor * limit,
            LoopKind::Position => drive.position_gain_per_s *= factor * limit,
        }
        ringing(&scaled)
    };
    let ([before, after], [earlier, later]) = (at(0.98), at(1.02));
    assert!(
        after < 0.9 * before || after < 1e-12,
        "{name}, {kind} {regime}, 2 % below {limit}: {before} to {after}"
    );
    assert!(
        later > 1.1 * earlier || later > 4.0,
        "{name}, {kind} {regime}, 2 % above {limit}: {earlier} to {later}"
    );
}

#[test]
fn the_simulated_axis_begins_to_oscillate_at_the_gain_predicted() {
    for (name, config) in [
        ("paper", AxisConfig::paper()),
        ("mill", mill(0.0, 0.0)),
        ("slow", slow_drive()),
    ] {
        let engaged = config.without_gap();
        oscillates_at_its_limit(name, &engaged, LoopKind::Position, Regime::Engaged);
        let mut open = engaged.clone();
        open.drive.position_gain_per_s = 0.0;
        open.drive.velocity_feedforward = 1.0;
        oscillates_at_its_limit(name, &open, LoopKind::Velocity, Regime::Engaged);
        // a gap so wide that the motor stays in it
        let wide = config.with_gap(2.0 * config.gap_in_unit() + 10.0);
        oscillates_at_its_limit(name, &wide, LoopKind::Position, Regime::Gap);
    }
}

#[test]
fn the_simulated_current_begins_to_oscillate_at_the_gain_predicted() {
    for config in [AxisConfig::paper(), mill(0.0, 0.0)] {
        let mut soft = config.without_gap();
        (
            soft.drive.velocity_feedforward,
            soft.drive.acceleration_feedforward,
        ) = (1.0, 0.0);
        soft.drive.velocity_gain_a_s_per_rad *= 1e-3;
        let limit = math::pow(
            10.0,
            margins(&soft, LoopKind::Current, Regime::Engaged)
                .gain_margin_db
                .unwrap()
                / 20.0,
        );
        let torque = |factor: f64| {
            let mut scaled = soft.clone();
            scaled.drive.current_gain_v_per_a *= factor * limit;
            let out = run(
                &scaled,
                "none",
                &|t| (if t > 0.02 { 1e-4 } else { 0.0 }, 0.0, 0.0),
                1.0,
            );
            // some time after the kick; later the voltage is cut at its limit and what grew may die
            // away again
            max_abs(
                out.trace.unwrap()[110..250]
                    .iter()
                    .map(|sample| sample.torque),
            )
        };
        let (below, above) = (torque(0.98), torque(1.02));
        assert!(
            below < 1e-3 && above > 1.0,
            "{below} and {above} N m, limit {limit}"
        );
    }
}

#[test]
fn an_unstable_loop_is_named_with_the_factor_that_mends_it() {
    let mut config = AxisConfig::paper();
    config.drive.velocity_gain_a_s_per_rad *= 8.0;
    let fault = analyse(&config).fault(&config).unwrap();
    assert_eq!(
        (fault.at().kind, fault.at().regime),
        (LoopKind::Velocity, Regime::Engaged)
    );
    assert!(
        fault
            .to_string()
            .starts_with("the velocity loop is unstable on a flank"),
        "{fault}"
    );
    let factor = fault.at().stable_factor.unwrap();
    let margin = math::pow(
        10.0,
        margins(&AxisConfig::paper(), LoopKind::Velocity, Regime::Engaged)
            .gain_margin_db
            .unwrap()
            / 20.0,
    );
    assert!(
        (factor * 8.0 / margin - 1.0).abs() < 1e-3,
        "{factor} against {margin}"
    );

    let mut config = AxisConfig::paper();
    config.drive.least_margins.phase_deg = 62.0;
    let fault = analyse(&config).fault(&config).unwrap();
    assert!(fault.to_string().contains("phase margin of 59."), "{fault}");
    config.drive.least_margins.phase_deg = 40.0;
    assert_eq!(analyse(&config).fault(&config), None);
}

#[test]
fn delays_are_stated() {
    let mut config = mill(0.0, 0.0);
    config.drive.command_delay_periods = 2;
    let delays = LoopDelays::of(&config);
    assert_eq!(
        delays,
        LoopDelays {
            current_us: 75.0,
            velocity_us: 350.0,
            position_us: 225.0
        }
    );
    assert_eq!(analyse(&config).delays, delays);
    // 100 us more at the crossover
    let lost = |config: &AxisConfig| margins(config, LoopKind::Velocity, Regime::Engaged);
    let (with, without) = (lost(&config), lost(&mill(0.0, 0.0)));
    let phase = without.phase_margin_deg.unwrap() - with.phase_margin_deg.unwrap();
    assert!(
        (phase / (360.0 * with.crossover_hz.unwrap() * 1e-4) - 1.0).abs() < 0.05,
        "{phase}"
    );
}

fn swing(prediction: LimitCycle) -> Cycle {
    match prediction {
        LimitCycle::Swing {
            frequency_hz,
            load_rad,
            ..
        } => Cycle {
            amplitude: load_rad,
            frequency_hz,
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn load_feedback_swings_through_the_papers_gap() {
    // stiff flanks with lossy contact: the true swing is far from a sine, and slower than predicted
    let config = AxisConfig::paper();
    let (predicted, simulated) = (
        swing(limit_cycle(&config, Feedback::Load)),
        simulated_cycle(&config, Feedback::Load).unwrap(),
    );
    assert!((simulated.frequency_hz - 8.4).abs() < 0.2, "{simulated:?}");
    assert!((1.0..2.3).contains(&(predicted.frequency_hz / simulated.frequency_hz)));
    assert!((predicted.amplitude / simulated.amplitude - 1.0).abs() < 0.3);
}

#[test]
fn on_soft_flanks_the_prediction_is_near_the_simulation() {
    let soft = with_load(AxisConfig::paper(), |load| {
        (load.stiffness_nm_per_rad, load.damping_nm_s_per_rad) = (200.0, 0.05);
    });
    let (predicted, simulated) = (
        swing(limit_cycle(&soft, Feedback::Load)),
        simulated_cycle(&soft, Feedback::Load).unwrap(),
    );
    assert!((predicted.frequency_hz / simulated.frequency_hz - 1.0).abs() < 0.08);
    assert!((predicted.amplitude / simulated.amplitude - 1.0).abs() < 0.2);
}

#[test]
fn where_none_is_predicted_none_is_simulated() {
    let rubbing = with_load(AxisConfig::paper(), |load| load.coulomb_nm = 3.0);
    let cases = [
        (AxisConfig::paper(), Feedback::Motor),
        (mill(0.0, 0.0), Feedback::Motor),
        (mill_x(0.1, 20.0, None), Feedback::Motor),
        (AxisConfig::paper().without_gap(), Feedback::Load),
        (rubbing, Feedback::Load),
    ];
    for (config, feedback) in cases {
        assert_eq!(limit_cycle(&config, feedback), LimitCycle::None);
        assert_eq!(simulated_cycle(&config, feedback), None);
    }
}

#[test]
fn the_phase_of_a_dead_time_is_that_of_textbooks() {
    // current loop of the mill at several bandwidths: PM = 90 deg - w_c T_d
    for bandwidth in [200.0, 500.0, 1000.0] {
        let tuning = lostmotion_drive::config::Tuning {
            current_bandwidth_hz: bandwidth,
            ..Default::default()
        };
        let found = margins(
            &mill(0.0, 0.0).tuned(&tuning),
            LoopKind::Current,
            Regime::Engaged,
        );
        let phase = 90.0 - (TAU * bandwidth * 75e-6).to_degrees();
        assert!(
            (found.phase_margin_deg.unwrap() - phase).abs() < 1.0,
            "{bandwidth}"
        );
        let limit = PI / (2.0 * 75e-6 * TAU * bandwidth);
        assert!(
            (math::pow(10.0, found.gain_margin_db.unwrap() / 20.0) / limit - 1.0).abs() < 0.06,
            "{bandwidth}"
        );
    }
}
