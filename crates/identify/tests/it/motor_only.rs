//! The fit from the motor alone, on logs of the independent rig and of the simulated axis.

use crate::rig::{RATED_TORQUE, Rig};
use lostmotion_base::math;
use lostmotion_drive::config::Load;
use lostmotion_drive::{AxisOutput, Setpoint};
use lostmotion_identify::{
    BacklashFit, FitError, FitSettings, MotorLog, NotExcited, fit_motor_only, solver::SolverStatus,
};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};

fn fit(rig: &Rig, seconds: f64) -> BacklashFit {
    fit_motor_only(
        &MotorLog::from(rig.run(seconds)),
        &rig.settings().motor_only(),
    )
    .unwrap()
}

#[test]
fn half_gap_within_half_a_percent() {
    // 318, 20 and 2 um of total gap at a lead of 10 mm; friction up to 30 % of rated torque
    for half_gap in [1e-1, 6.283e-3, 6.283e-4] {
        for share in [0.0, 0.02, 0.1, 0.3] {
            let rig = Rig {
                half_gap,
                friction: share * RATED_TORQUE,
                offset: 0.003,
                seed: 7,
                ..Rig::default()
            };
            let fit = fit(&rig, 30.0);
            let error = fit.half_gap_rad / half_gap - 1.0;
            assert!(
                error.abs() < 5e-3,
                "gap {half_gap}, friction {share}: {error:+.2e}"
            );
            let load = fit.load.unwrap_or_default();
            assert!(
                (load.inertia_kgm2 / rig.load_inertia - 1.0).abs() < 0.02,
                "{load:?}"
            );
            assert!(
                (load.coulomb_nm - rig.friction).abs() < 0.01 * (1.0 + rig.friction),
                "{load:?}"
            );
            assert!(
                (fit.compliance_rad_per_nm * rig.stiffness - 1.0).abs() < 0.06,
                "{}",
                fit.compliance_rad_per_nm
            );
            assert!(fit.excited && fit.reason.is_none());
            assert_eq!(fit.solver.status, SolverStatus::Solved);
            assert!(fit.solver.optimality < 1e-6, "{:e}", fit.solver.optimality);
        }
    }
}

/// A random axis and its log: does the interval cover, and how wide is it, as a part of the gap?
fn covers(seed: u64) -> (bool, f64) {
    let rig = Rig::random(seed);
    let fit = fit(&rig, 15.0);
    let [low, high] = fit.half_gap_interval_rad;
    (
        low <= rig.half_gap && rig.half_gap <= high,
        (high - low) / rig.half_gap,
    )
}

#[test]
fn interval_covers_the_truth() {
    let logs: Vec<(bool, f64)> = (0..20).map(covers).collect();
    assert!(logs.iter().filter(|log| log.0).count() >= 19, "{logs:?}");
    // an interval that covers by being useless proves nothing
    let mut widths: Vec<f64> = logs.iter().map(|log| log.1).collect();
    widths.sort_by(f64::total_cmp);
    assert!(widths[10] < 0.02, "{widths:?}");
}

/// The simulated axis on two sines whose periods do not match.
fn simulated(gap: f64, friction: f64) -> (MotorLog, FitSettings) {
    let mut config = AxisConfig::paper().with_gap(gap);
    config.drive.velocity_feedforward = 1.0;
    if let Load::Reflected(load) = &mut config.load {
        load.coulomb_nm = friction;
    }
    let at = |t: f64| {
        let sum = |f: &dyn Fn(f64, f64) -> f64| {
            [(3.0, 9.0), (1.1, 23.0)]
                .into_iter()
                .map(|(a, w)| f(a, w))
                .sum()
        };
        let position = sum(&|a, w| a * math::sin(w * t));
        Setpoint::moving(
            position,
            sum(&|a, w| a * w * math::cos(w * t)),
            sum(&|a, w| -a * w * w * math::sin(w * t)),
        )
    };
    let points: Vec<Setpoint> = (0..20_000).map(|n| at(f64::from(n) * 1e-3)).collect();
    let mut out = AxisOutput::new(true);
    build_runner(&config, MethodId::NONE, 0.0)
        .unwrap()
        .push(&points, &mut out)
        .unwrap();
    let (trace, step) = (out.trace.unwrap(), std::f64::consts::TAU / 1_048_576.0);
    let motor = trace
        .iter()
        .map(|sample| (sample.motor_position / step).floor() * step)
        .collect();
    let current = trace.iter().map(|sample| sample.current).collect();
    (
        MotorLog::new(250e-6, motor, current).unwrap(),
        FitSettings::for_axis(&config).motor_only(),
    )
}

#[test]
fn the_simulated_gap_is_found_from_its_motor() {
    // 318 um with little friction, 20 um with up to 30 % of the rated torque
    for (gap, friction) in [
        (0.2, 0.0),
        (0.2, 1.1),
        (12.57e-3, 0.0),
        (12.57e-3, 0.22),
        (12.57e-3, 1.1),
        (12.57e-3, 3.3),
    ] {
        let (log, settings) = simulated(gap, friction);
        let fit = fit_motor_only(&log, &settings).unwrap();
        let error = 2.0 * fit.half_gap_rad / gap - 1.0;
        assert!(
            error.abs() < 2e-3,
            "gap {gap}, friction {friction}: {error:+.2e}"
        );
    }
    // a load that is held by its friction right after a wide crossing shows neither rest nor
    // sliding long enough
    let (log, settings) = simulated(0.2, 3.3);
    let error = fit_motor_only(&log, &settings).unwrap_err();
    assert!(
        matches!(
            error,
            FitError::NotExcited(NotExcited::CrossingsUnclear { .. })
        ),
        "{error}"
    );
}

#[test]
fn what_the_motor_cannot_tell_is_named() {
    let settings = Rig::default().settings().motor_only();
    let still = MotorLog::new(250e-6, vec![0.0; 4000], vec![0.0; 4000]).unwrap();
    let error = fit_motor_only(&still, &settings).unwrap_err();
    assert!(
        matches!(
            error,
            FitError::NotExcited(NotExcited::TorqueBelowThreshold { .. })
        ),
        "{error}"
    );
    // half a second: hardly a crossing
    let short = MotorLog::from(Rig::default().run(0.4));
    let error = fit_motor_only(&short, &settings).unwrap_err();
    assert!(
        matches!(
            error,
            FitError::NotExcited(NotExcited::CrossingsUnclear { .. })
        ),
        "{error}"
    );
    let error = fit_motor_only(
        &short,
        &FitSettings {
            motor_inertia_kgm2: None,
            ..settings
        },
    )
    .unwrap_err();
    assert!(
        matches!(
            error,
            FitError::Setting {
                name: "motor_inertia_kgm2",
                ..
            }
        ),
        "{error}"
    );
    let error = fit_motor_only(&MotorLog::from(Rig::default().run(0.001)), &settings).unwrap_err();
    assert!(matches!(error, FitError::TooShort { .. }), "{error}");
    // without a gap the fit says that there is none to be told
    let rigid = fit(
        &Rig {
            half_gap: 0.0,
            ..Rig::default()
        },
        10.0,
    );
    assert!(
        !rigid.excited && matches!(rigid.reason, Some(NotExcited::GapBelowNoise { .. })),
        "{rigid:?}"
    );
}

#[test]
fn the_offset_of_the_zero_does_not_matter_and_the_mirror_neither() {
    let rig = Rig {
        friction: 0.5,
        ..Rig::default()
    };
    let here = fit(&rig, 10.0);
    let log = rig.run(10.0);
    let mirrored = MotorLog::new(
        log.period_s(),
        log.motor().iter().map(|x| 5.0 - x).collect(),
        log.current().iter().map(|i| -i).collect(),
    );
    let there = mirrored.and_then(|log| fit_motor_only(&log, &rig.settings().motor_only()));
    assert!(there.is_ok_and(|there| (there.half_gap_rad / here.half_gap_rad - 1.0).abs() < 1e-4));
}
