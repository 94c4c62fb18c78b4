//! Logs and settings that cannot be fitted, each with its reason.

use crate::rig::Rig;
use lostmotion_base::Random;
use lostmotion_base::math;
use lostmotion_identify::{BacklashLog, FitError, FitSettings, NotExcited, fit_backlash};

/// A log at 1 ms in contact all the time: the torque is given, the load is fixed, the motor winds
/// up against it.
fn wound_up(samples: usize, half_gap: f64, torque: impl Fn(f64) -> f64) -> BacklashLog {
    let mut random = Random::new(3);
    let torques: Vec<f64> = (0..samples).map(|k| torque(k as f64 * 1e-3)).collect();
    let motor = torques
        .iter()
        .map(|t| t.signum() * half_gap + t / 2000.0 + 1e-6 * random.normal())
        .collect();
    BacklashLog::new(1e-3, motor, vec![0.0; samples], torques).unwrap()
}

fn settings() -> FitSettings {
    FitSettings {
        slip_share: 1.0,
        ..FitSettings::new(1.0, None)
    }
}

#[test]
fn columns_that_are_no_log() {
    let new = |motor: &[f64], load: &[f64], current: &[f64]| {
        BacklashLog::new(1e-3, motor.to_vec(), load.to_vec(), current.to_vec())
    };
    assert_eq!(new(&[], &[], &[]), Err(FitError::Empty));
    assert_eq!(
        new(&[1.0], &[1.0, 2.0], &[1.0]),
        Err(FitError::LengthMismatch {
            motor: 1,
            load: 2,
            current: 1
        })
    );
    let error = new(&[1.0, 2.0], &[1.0, f64::NAN], &[1.0, 2.0]).unwrap_err();
    assert!(
        matches!(error, FitError::NotFinite { column: "load", index: 1, value } if value.is_nan()),
        "{error}"
    );
    assert_eq!(
        error.to_string(),
        "load[1] is NaN; a log holds finite numbers only"
    );
    assert!(matches!(
        new(&[1.0], &[1.0], &[f64::INFINITY]),
        Err(FitError::NotFinite {
            column: "current",
            index: 0,
            ..
        })
    ));
    for period in [0.0, -1.0, f64::NAN] {
        assert!(matches!(
            BacklashLog::new(period, vec![0.0], vec![0.0], vec![0.0]),
            Err(FitError::Setting {
                name: "period_s",
                ..
            })
        ));
    }
}

#[test]
fn settings_out_of_range() {
    let log = wound_up(100, 0.01, |t| t);
    let good = settings();
    for (name, bad) in [
        (
            "torque_constant_nm_per_a",
            FitSettings {
                torque_constant_nm_per_a: 0.0,
                ..good
            },
        ),
        (
            "motor_inertia_kgm2",
            FitSettings {
                motor_inertia_kgm2: Some(-1.0),
                ..good
            },
        ),
        (
            "torque_threshold_nm",
            FitSettings {
                torque_threshold_nm: Some(f64::NAN),
                ..good
            },
        ),
        (
            "huber_delta_rad",
            FitSettings {
                huber_delta_rad: Some(0.0),
                ..good
            },
        ),
        (
            "settle_s",
            FitSettings {
                settle_s: f64::INFINITY,
                ..good
            },
        ),
        (
            "solver_iterations",
            FitSettings {
                solver_iterations: 0,
                ..good
            },
        ),
    ] {
        assert!(
            matches!(fit_backlash(&log, &bad), Err(FitError::Setting { name: found, .. }) if found == name),
            "{name}"
        );
    }
}

#[test]
fn logs_too_short_for_a_window() {
    for samples in 1..10 {
        assert!(
            matches!(
                fit_backlash(&wound_up(samples, 0.01, |t| t), &settings()),
                Err(FitError::TooShort { .. })
            ),
            "{samples}"
        );
    }
    let wide = FitSettings {
        half_window_s: 1e300,
        ..settings()
    };
    assert!(matches!(
        fit_backlash(&wound_up(100, 0.01, |t| t), &wide),
        Err(FitError::TooShort { .. })
    ));
}

#[test]
fn a_resting_axis_tells_nothing() {
    let error = fit_backlash(&wound_up(1000, 0.01, |_| 0.0), &settings()).unwrap_err();
    assert!(
        matches!(
            error,
            FitError::NotExcited(NotExcited::TorqueBelowThreshold { .. })
        ),
        "{error}"
    );
    let demanding = FitSettings {
        torque_threshold_nm: Some(50.0),
        ..Rig::default().settings()
    };
    let error = fit_backlash(&Rig::default().run(1.0), &demanding).unwrap_err();
    assert!(
        matches!(error, FitError::NotExcited(NotExcited::TorqueBelowThreshold { threshold_nm, .. }) if threshold_nm > 49.0),
        "{error}"
    );
}

#[test]
fn one_side_alone_tells_nothing() {
    let error = fit_backlash(
        &wound_up(2000, 0.01, |t| 3.0 + math::sin(20.0 * t)),
        &settings(),
    )
    .unwrap_err();
    assert!(
        matches!(error, FitError::NotExcited(NotExcited::OneSide { negative: 0, positive }) if positive > 100),
        "{error}"
    );
}

#[test]
fn too_few_changes_of_side() {
    let once = wound_up(2000, 0.01, |t| math::cos(std::f64::consts::PI * t / 2.0));
    let error = fit_backlash(&once, &settings()).unwrap_err();
    assert_eq!(
        error,
        FitError::NotExcited(NotExcited::TooFewTraversals { seen: 1, needed: 2 })
    );
    let fit = fit_backlash(
        &once,
        &FitSettings {
            min_traversals: 1,
            ..settings()
        },
    )
    .unwrap();
    assert!((fit.half_gap_rad / 0.01 - 1.0).abs() < 1e-3 && fit.traversals == 1);
}

#[test]
fn a_torque_of_one_size_hides_the_gap_in_the_wind_up() {
    let square = wound_up(4000, 0.01, |t| {
        if (t * 4.0).floor() % 2.0 < 0.5 {
            2.0
        } else {
            -2.0
        }
    });
    let error = fit_backlash(&square, &settings()).unwrap_err();
    assert!(
        matches!(
            error,
            FitError::NotExcited(NotExcited::TorqueNotVaried { .. })
        ),
        "{error}"
    );
    let known = FitSettings {
        stiffness_nm_per_rad: Some(2000.0),
        fit_damping: false,
        ..settings()
    };
    let fit = fit_backlash(&square, &known).unwrap();
    assert!((fit.half_gap_rad / 0.01 - 1.0).abs() < 1e-3);
}

#[test]
fn a_gap_below_the_noise_is_fitted_but_not_believed() {
    let fit = fit_backlash(
        &wound_up(4000, 0.0, |t| 3.0 * math::sin(20.0 * t)),
        &settings(),
    )
    .unwrap();
    assert!(!fit.excited && fit.half_gap_interval_rad[0].abs() < 1e-300);
    assert!(
        fit.half_gap_interval_rad[1] < 1e-6,
        "{:?}",
        fit.half_gap_interval_rad
    );
    assert!(
        matches!(fit.reason, Some(NotExcited::GapBelowNoise { upper_rad, .. }) if upper_rad < 1e-6)
    );
    assert!((fit.stiffness_nm_per_rad.unwrap() / 2000.0 - 1.0).abs() < 1e-3);
    let rigid = Rig {
        half_gap: 0.0,
        ..Rig::default()
    };
    let fit = fit_backlash(&rigid.run(2.0), &rigid.settings()).unwrap();
    assert!(fit.half_gap_rad < 1e-6, "{}", fit.half_gap_rad);
}

/// Every seventh row is missing: it is said, not that the axis should move otherwise.
#[test]
fn rows_that_are_missing_everywhere_are_named() {
    let axis = crate::rig::ballscrew::BallScrew::random(94_500);
    let whole = axis.record();
    let some = |column: &[f64]| -> Vec<f64> {
        let rows = column.iter().enumerate();
        rows.filter(|(row, _)| row % 7 != 3)
            .map(|(_, value)| *value)
            .collect()
    };
    let rows = crate::rig::ballscrew::Rows {
        time_s: some(&whole.time_s),
        motor_mm: some(&whole.motor_mm),
        load_mm: some(&whole.load_mm),
        current_a: some(&whole.current_a),
    };
    let error = fit_backlash(&axis.log(&rows).unwrap(), &axis.settings()).unwrap_err();
    assert!(
        matches!(error, FitError::NotExcited(NotExcited::RowsLost { percent }) if (percent - 14.3).abs() < 1.0),
        "{error}"
    );
}
