//! Logs in other units, with other signs or exchanged columns: each is refused with its cause.

use crate::rig::ballscrew::{BallScrew, Rows};
use lostmotion_identify::body::{BodyLog, Motion, times_go_with};
use lostmotion_identify::{Cause, FitError, FitSettings, MotorLog, fit_backlash, fit_motor_only};

fn axis(seed: u64) -> BallScrew {
    BallScrew {
        seconds: 10.0,
        ..BallScrew::noisy(seed)
    }
}

/// The cause that is named for a log of some axes after a change of its rows.
fn cause_of(change: impl Fn(&BallScrew, &mut Rows)) -> Vec<Cause> {
    [4, 5, 7]
        .map(|seed| {
            let axis = axis(seed);
            let mut rows = axis.record();
            change(&axis, &mut rows);
            let log = axis.log(&rows).unwrap();
            match fit_backlash(&log, &axis.settings()) {
                Err(FitError::Implausible { cause, .. }) => cause,
                other => panic!("seed {seed}: {other:?}"),
            }
        })
        .to_vec()
}

fn scale(values: &mut [f64], by: f64) {
    values.iter_mut().for_each(|value| *value *= by);
}

#[test]
fn times_in_milliseconds() {
    let found = cause_of(|_, rows| scale(&mut rows.time_s, 1e3));
    assert_eq!(found, [Cause::Milliseconds; 3]);
    // Without an inertia rows that are far apart may be those of a slow log.
    let axis = axis(4);
    let mut rows = axis.record();
    scale(&mut rows.time_s, 1e3);
    let unknown = FitSettings {
        known_inertia_kgm2: None,
        ..axis.settings()
    };
    let error = fit_backlash(&axis.log(&rows).unwrap(), &unknown).unwrap_err();
    assert!(!error.is_of_the_log(), "{error}");
}

/// A wrong unit of the times is told of the motion alone, without an axis or a current.
#[test]
fn times_in_a_wrong_unit_are_refused_without_an_axis() {
    // 100 mm to and fro at 0.1 m/s with 1 m/s2, a row a millisecond
    let place = |row: i32| {
        let t = f64::from(row.rem_euclid(1100)) * 1e-3;
        let gone = match t {
            t if t < 0.1 => 0.5 * t * t,
            t if t < 1.0 => 0.005 + 0.1 * (t - 0.1),
            t => 0.1 - 0.5 * (1.1 - t) * (1.1 - t),
        };
        if row.rem_euclid(2200) < 1100 {
            gone
        } else {
            0.1 - gone
        }
    };
    let told = |factor: f64| {
        let time: Vec<f64> = (0..6600)
            .map(|row| 1e-3 * factor * f64::from(row))
            .collect();
        let motor = (0..6600).map(place).collect();
        let log = BodyLog::from_rows(&time, motor, vec![], vec![], vec![]).unwrap();
        times_go_with(&log, &Motion::of(&log))
    };
    assert_eq!(told(1.0), Ok(()));
    // A row a second of a slow log, and a fast drive.
    assert_eq!((told(30.0), told(0.05)), (Ok(()), Ok(())));
    for (factor, wanted, unit) in [
        (1e3, Cause::Milliseconds, "unit=ms"),
        (1e-3, Cause::Seconds, "unit=s"),
    ] {
        let error = told(factor).unwrap_err();
        assert!(
            matches!(error, FitError::Implausible { cause, .. } if cause == wanted)
                && error.is_of_the_log(),
            "{error}"
        );
        assert!(error.to_string().contains(unit), "{error}");
    }
}

#[test]
fn a_current_in_percent() {
    let found = cause_of(|axis, rows| {
        let rated_a = axis.rated_torque / axis.torque_constant;
        scale(&mut rows.current_a, 100.0 / rated_a);
    });
    assert_eq!(found, [Cause::PercentOfRated; 3]);
}

/// Where the motion does not tell the inertia: what no motor stands.
#[test]
fn a_current_in_milliamperes() {
    for seed in [4, 5, 7] {
        let axis = axis(seed);
        let mut rows = axis.record();
        let settings = FitSettings {
            known_inertia_kgm2: None,
            ..axis.settings()
        };
        fit_backlash(&axis.log(&rows).unwrap(), &settings).unwrap();
        scale(&mut rows.current_a, 1e3);
        let found = fit_backlash(&axis.log(&rows).unwrap(), &settings);
        assert!(
            matches!(
                found,
                Err(FitError::Implausible {
                    cause: Cause::CurrentUnit,
                    ..
                })
            ),
            "{found:?}"
        );
    }
}

#[test]
fn positions_in_inches_or_micrometres() {
    for (factor, cause) in [(1.0 / 25.4, Cause::Inches), (1e3, Cause::Micrometres)] {
        let found = cause_of(|_, rows| {
            scale(&mut rows.motor_mm, factor);
            scale(&mut rows.load_mm, factor);
        });
        assert_eq!(found, [cause; 3]);
    }
}

#[test]
fn positions_in_metres_degrees_or_revolutions() {
    for (factor, cause) in [
        (1e-3, Cause::Thousand),
        (1.0_f64.to_degrees(), Cause::Degrees),
        (1.0_f64.to_radians(), Cause::Degrees),
        (1.0 / std::f64::consts::TAU, Cause::Revolutions),
    ] {
        let found = cause_of(|_, rows| {
            scale(&mut rows.motor_mm, factor);
            scale(&mut rows.load_mm, factor);
        });
        assert_eq!(found, [cause; 3], "{factor}");
    }
}

/// A wrong unit that hangs on the lead. Where another one is as near (a lead of some 6 mm is TAU for
/// rad, one of 25 mm inches) that one may be named, and where the factor is small, as of an angle and
/// a lead of some 12 mm, noise hides it.
#[test]
fn positions_in_turns_or_as_the_angle_of_the_motor() {
    let mut named = [0; 2];
    for seed in 300..308 {
        let axis = axis(seed);
        let turns = axis.rad_per_mm() / std::f64::consts::TAU;
        for (at, (factor, cause)) in [
            (turns, Cause::Revolutions),
            (axis.rad_per_mm(), Cause::MotorAngle),
        ]
        .into_iter()
        .enumerate()
        {
            let mut rows = axis.record();
            scale(&mut rows.motor_mm, factor);
            scale(&mut rows.load_mm, factor);
            let log = axis.log(&rows).unwrap();
            match fit_backlash(&log, &axis.settings()) {
                Err(FitError::Implausible { cause: found, .. }) => {
                    named[at] += usize::from(found == cause);
                }
                // A noisy log does not tell 12 mm a turn from 2 pi.
                other => assert!((0.4..2.5).contains(&factor), "{seed} {factor}: {other:?}"),
            }
        }
    }
    assert!(named[0] >= 6 && named[1] >= 2, "{named:?}");
}

/// A torque in place of the current is off by the torque constant. Of 0.55 N m/A it is refused, if
/// the log is clean enough to tell; of 1.08 N m/A it looks like a workpiece, and the gap is off by up
/// to 8 % of the wind-up.
#[test]
fn a_torque_for_the_current() {
    let mut refused = 0;
    for seed in 300..308 {
        let axis = axis(seed);
        let mut rows = axis.record();
        scale(&mut rows.current_a, axis.torque_constant);
        let log = axis.log(&rows).unwrap();
        match fit_backlash(&log, &axis.settings()) {
            Err(FitError::Implausible {
                cause: Cause::TorqueForCurrent,
                ..
            }) => refused += 1,
            Ok(fit) => {
                let [low, high] = fit.half_gap_interval_rad;
                let truth = axis.half_gap();
                let doubt = if axis.torque_constant < 1.0 {
                    0.0
                } else {
                    high - low
                };
                assert!(
                    low - doubt <= truth && truth <= high + doubt,
                    "{seed}: {low} {truth} {high}"
                );
            }
            Err(error) => assert!(matches!(error, FitError::NotExcited(_)), "{seed}: {error}"),
        }
    }
    assert!((1..=6).contains(&refused), "{refused}");
}

#[test]
fn columns_in_different_units() {
    let found = cause_of(|_, rows| scale(&mut rows.load_mm, 1.0 / 25.4));
    assert_eq!(found, [Cause::ColumnUnits; 3]);
}

#[test]
fn wrong_signs() {
    let found = cause_of(|_, rows| scale(&mut rows.current_a, -1.0));
    assert_eq!(found, [Cause::CurrentSign; 3]);
    let found = cause_of(|_, rows| scale(&mut rows.load_mm, -1.0));
    assert_eq!(found, [Cause::PositionSigns; 3]);
}

#[test]
fn swapped_columns() {
    let found = cause_of(|_, rows| std::mem::swap(&mut rows.motor_mm, &mut rows.load_mm));
    assert_eq!(found, [Cause::SwappedColumns; 3]);
}

/// Current and a position exchanged: no position follows the other. Before, some of these were
/// fitted, and the gap was "not told from zero".
#[test]
fn a_current_in_place_of_a_position() {
    let found = cause_of(|_, rows| std::mem::swap(&mut rows.load_mm, &mut rows.current_a));
    assert_eq!(found, [Cause::MixedColumns; 3]);
    let found = cause_of(|_, rows| std::mem::swap(&mut rows.motor_mm, &mut rows.current_a));
    assert_eq!(found, [Cause::MixedColumns; 3]);
}

/// From the motor alone much noise leaves a wide interval or none, but not a wrong one.
#[test]
fn noise_that_hides_the_load_is_no_gap() {
    for seed in [4, 5, 7] {
        let axis = BallScrew {
            noise: 0.05,
            ..axis(seed)
        };
        let log = MotorLog::from(axis.log(&axis.record()).unwrap());
        match fit_motor_only(&log, &axis.settings().motor_only()) {
            Ok(fit) => {
                let [low, high] = fit.half_gap_interval_rad;
                let truth = axis.half_gap();
                assert!(
                    low <= truth && truth <= high,
                    "{seed}: {low} {truth} {high}"
                );
            }
            Err(error) => assert!(matches!(error, FitError::NotExcited(_)), "{seed}: {error}"),
        }
    }
}
