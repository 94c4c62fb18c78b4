//! The fit on logs as a workshop records them: does its interval hold the truth, and does it say so
//! where the log cannot tell? The seeds here were drawn once and nothing is tuned on them.

use crate::rig::ballscrew::BallScrew;
use crate::rig::score::{Given, KINDS, Kind, Score};
use lostmotion_identify::{FitError, NotExcited, fit_backlash};

fn kind(name: &str) -> Kind {
    KINDS.into_iter().find(|kind| kind.name == name).unwrap()
}

fn score(name: &str, seeds: std::ops::Range<u64>) -> Score {
    Score::of(kind(name), seeds, |_, _, _| ())
}

impl Score {
    fn holds(&self, least_covered: f64) {
        let fitted = self.errors.len();
        let median = |values: &[f64]| values[values.len() / 2];
        assert!(
            self.covered as f64 >= least_covered * fitted as f64,
            "{self:?}"
        );
        assert!(10 * self.refused.len() <= fitted, "{self:?}");
        assert!(median(&self.errors) <= 0.01, "{self:?}");
        // an interval that covers by being useless proves nothing
        assert!(median(&self.widths) <= 0.05, "{self:?}");
        assert!(self.beyond <= 1.0, "{self:?}");
    }
}

#[test]
fn clean_logs() {
    score("clean", 90_000..90_016).holds(0.9);
}

#[test]
fn logs_with_noise_and_a_recorder_s_flaws() {
    score("noise and flaws", 91_000..91_024).holds(0.9);
}

#[test]
fn logs_of_a_friction_that_no_model_has() {
    score("odd friction", 92_000..92_016).holds(0.9);
}

/// The shaft gives less than the log can tell: a lower bound of its stiffness that is true, and no
/// value.
#[test]
fn a_shaft_stiffer_than_can_be_told_has_a_bound() {
    let mut bounds = 0;
    for seed in 93_000..93_008 {
        let axis = BallScrew {
            stiffness_n_per_um: 60_000.0,
            scale_um: 1.0,
            noise: 0.05,
            seconds: 20.0,
            ..BallScrew::random(seed)
        };
        let log = axis.log(&axis.record()).unwrap();
        let Ok(fit) = fit_backlash(&log, &axis.settings()) else {
            continue;
        };
        let [low, high] = fit.stiffness_interval_nm_per_rad;
        let low = low.unwrap();
        assert!(low <= 1.05 * axis.stiffness(), "{seed}: {fit:?}");
        assert_eq!(fit.stiffness_nm_per_rad.is_some(), high.is_some());
        // a bound that says nothing would be no figure either: it is above usual shafts, 100 N/um
        assert!(low > axis.stiffness() / 600.0, "{seed}: {fit:?}");
        bounds += usize::from(high.is_none());
        let [shortest, longest] = fit.damping_time_interval_s;
        assert!(
            0.0 <= shortest && shortest <= fit.damping_time_s && fit.damping_time_s <= longest,
            "{fit:?}"
        );
    }
    assert!(bounds >= 2, "{bounds}");
}

/// Whether value and interval of the stiffness hold for usual shafts.
#[test]
fn the_interval_of_the_stiffness_holds_it() {
    let (mut right, mut fitted) = (0, 0);
    for seed in 94_000..94_016 {
        let axis = BallScrew {
            seconds: 20.0,
            ..BallScrew::noisy(seed)
        };
        let log = axis.log(&axis.record()).unwrap();
        let Ok(fit) = fit_backlash(&log, &axis.settings()) else {
            continue;
        };
        fitted += 1;
        let [low, high] = fit.stiffness_interval_nm_per_rad;
        right += usize::from(
            low.is_some_and(|low| low <= axis.stiffness())
                && high.is_none_or(|high| axis.stiffness() <= high),
        );
    }
    assert!(fitted >= 13 && right + 2 >= fitted, "{right} of {fitted}");
}

/// Rows beside their times make the motor's acceleration noisy: told, or refused with the cause.
#[test]
fn logs_of_a_recorder_whose_times_are_rounded() {
    let score = score("jitter not recorded", 97_000..97_012);
    let fitted = score.errors.len();
    assert!(fitted >= 8 && score.covered + 1 >= fitted, "{score:?}");
    assert!(score.errors[fitted / 2] <= 0.02, "{score:?}");
    assert!(score.beyond <= 1.0, "{score:?}");
    let named = |text: &String| text.contains("beside the times that the log gives");
    assert!(score.refused.iter().all(named), "{score:?}");
}

/// A filter before the recorder delays the current by up to 4 ms.
#[test]
fn logs_of_a_filtered_current() {
    let score = score("filtered current", 98_000..98_012);
    let fitted = score.errors.len();
    assert!(fitted >= 10 && score.covered + 1 >= fitted, "{score:?}");
    assert!(score.errors[fitted / 2] <= 0.01, "{score:?}");
    assert!(score.beyond <= 1.0, "{score:?}");
}

/// Sure and wrong is worse than a refusal, which names its cause.
fn honest(score: &Score) {
    let fitted = score.errors.len();
    assert!(score.covered + 1 >= fitted, "{score:?}");
    assert!(score.beyond <= 1.0, "{score:?}");
    let because = |text: &String| text.contains(": log ") || text.contains(": accelerate ");
    assert!(score.refused.iter().all(because), "{score:?}");
}

/// At 1 kHz with the noise of a usual drive the motor alone tells the gap, too.
#[test]
fn noisy_logs_of_the_motor_alone() {
    let score = score("noise 2 %, motor only", 99_000..99_008);
    honest(&score);
    let fitted = score.errors.len();
    assert!(fitted >= 2, "{score:?}");
    assert!(score.errors[fitted / 2] <= 0.02, "{score:?}");
}

/// Another gap than the true one explains this log nearly as well, with less noise than it has.
#[test]
fn a_gap_that_looks_like_another_from_the_motor_alone() {
    honest(&score("noise 2 %, motor only", 96_008..96_009));
}

/// Stiff shafts vibrate at 300 to 600 Hz, of which rows 1 ms apart tell too little.
#[test]
fn shafts_too_fast_for_the_log_of_the_motor_alone() {
    let mut named = 0;
    for (seed, noise) in [(9_720_000, 0.02), (2_610_019, 0.0)] {
        let axis = BallScrew {
            noise,
            seconds: 20.0,
            ..BallScrew::random(seed)
        };
        let masses = 1.0 / axis.motor_inertia + 1.0 / axis.load_inertia;
        assert!((axis.stiffness() * masses).sqrt() > std::f64::consts::TAU * 320.0);
        let (fit, truth) = Given::MotorOnly.fit(&axis);
        match fit {
            Ok(fit) => {
                let [low, high] = fit.half_gap_interval_rad;
                assert!(low <= truth && truth <= high, "{seed}: {fit:?}");
            }
            Err(FitError::NotExcited(NotExcited::ShaftTooFast { .. })) => named += 1,
            Err(_) => {}
        }
    }
    assert!(named >= 1, "{named}");
}

/// Without the axis the motor's inertia and friction are found, too, or it is said that they cannot.
#[test]
fn logs_without_an_axis() {
    let score = score("noise 2 %, no axis", 95_000..95_012);
    let fitted = score.errors.len();
    assert!(
        score.covered + 1 >= fitted && score.refused.len() <= 4,
        "{score:?}"
    );
    assert!(score.errors[fitted / 2] <= 0.02, "{score:?}");
    assert!(score.beyond <= 1.0, "{score:?}");
    let because = |text: &String| text.contains("cannot be told, because");
    assert!(score.refused.iter().all(because), "{score:?}");
}

/// A load that is read at the motor, in counts of its own: nothing of the gap is told, and nothing is wrong
/// with the signs.
#[test]
fn a_load_that_is_the_motor_is_not_refused_for_its_sign() {
    for seed in 0..8 {
        let axis = BallScrew {
            seconds: 10.0,
            ..BallScrew::random(9_940_000 + seed)
        };
        let mut rows = axis.record();
        rows.load_mm = rows
            .motor_mm
            .iter()
            .map(|motor| (motor * 1e4).round() * 1e-4)
            .collect();
        let fit = axis
            .log(&rows)
            .and_then(|log| fit_backlash(&log, &axis.settings()));
        match fit {
            Ok(fit) => assert!(!fit.excited, "{seed}: {fit:?}"),
            Err(error) => assert!(matches!(error, FitError::NotExcited(_)), "{seed}: {error}"),
        }
    }
}
