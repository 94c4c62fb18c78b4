//! How lots of logs are fitted: how often the interval holds the truth, how large the errors are,
//! how many logs are refused.

use super::ballscrew::BallScrew;
use lostmotion_base::Random;
use lostmotion_identify::{
    BacklashFit, BacklashLog, FitError, FitSettings, MotorLog, fit_backlash, fit_motor_only,
};

/// What the fit is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Given {
    /// The load's scale and the axis.
    Everything,
    /// The load's scale alone.
    NoAxis,
    /// The axis, and the motor's signals alone.
    MotorOnly,
}

/// A kind of logs.
#[derive(Clone, Copy)]
pub struct Kind {
    pub name: &'static str,
    pub given: Given,
    pub axis: fn(u64) -> BallScrew,
}

/// All kinds that are measured.
pub const KINDS: [Kind; 18] = [
    kind("clean", Given::Everything, BallScrew::random),
    kind("noise and flaws", Given::Everything, BallScrew::noisy),
    kind("odd friction", Given::Everything, BallScrew::odd),
    kind("jitter not recorded", Given::Everything, jitter),
    kind("filtered current", Given::Everything, filtered),
    kind("slow strokes, counts of 1 um", Given::Everything, slow),
    kind("clean, no axis", Given::NoAxis, BallScrew::random),
    kind("noise 2 %, no axis", Given::NoAxis, |seed| {
        noise(seed, 0.02)
    }),
    kind(
        "flaws and odd friction, no axis",
        Given::NoAxis,
        BallScrew::odd,
    ),
    kind("clean, motor only", Given::MotorOnly, BallScrew::random),
    kind("noise 0.2 %, motor only", Given::MotorOnly, |seed| {
        noise(seed, 0.002)
    }),
    kind("noise 0.5 %, motor only", Given::MotorOnly, |seed| {
        noise(seed, 0.005)
    }),
    kind("noise 2 %, motor only", Given::MotorOnly, |seed| {
        noise(seed, 0.02)
    }),
    kind("noise 5 %, motor only", Given::MotorOnly, |seed| {
        noise(seed, 0.05)
    }),
    kind("jitter not recorded, motor only", Given::MotorOnly, jitter),
    kind("filtered current, motor only", Given::MotorOnly, filtered),
    kind("odd friction, motor only", Given::MotorOnly, |seed| {
        BallScrew {
            noise: 0.0,
            missing: 0.0,
            jitter_s: 0.0,
            current_late_s: 0.0,
            ..BallScrew::odd(seed)
        }
    }),
    kind(
        "flaws and odd friction, motor only",
        Given::MotorOnly,
        BallScrew::odd,
    ),
];

const fn kind(name: &'static str, given: Given, axis: fn(u64) -> BallScrew) -> Kind {
    Kind { name, given, axis }
}

fn noise(seed: u64, noise: f64) -> BallScrew {
    BallScrew {
        noise,
        ..BallScrew::random(seed)
    }
}

/// Strokes of 2 to 20 mm/s, whose wind-up hardly changes, under a coarse scale.
fn slow(seed: u64) -> BallScrew {
    BallScrew {
        speeds_mm_s: [2.0, 20.0],
        scale_um: 1.0,
        ..noise(seed, 0.005)
    }
}

fn jitter(seed: u64) -> BallScrew {
    BallScrew {
        jitter_s: Random::new(seed ^ 0x11).between(50e-6, 250e-6),
        jitter_recorded: false,
        ..noise(seed, 0.02)
    }
}

fn filtered(seed: u64) -> BallScrew {
    BallScrew {
        current_filter_s: Random::new(seed ^ 0x22).between(0.5e-3, 4e-3),
        ..noise(seed, 0.02)
    }
}

impl Given {
    /// The fit of a log of this axis, and the half gap that is true, both in one unit.
    pub fn fit(self, axis: &BallScrew) -> (Result<BacklashFit, FitError>, f64) {
        let rows = axis.record();
        match self {
            Given::Everything => (
                axis.log(&rows)
                    .and_then(|log| fit_backlash(&log, &axis.settings())),
                axis.half_gap(),
            ),
            // As it is logged: nobody knows the lead.
            Given::NoAxis => (
                BacklashLog::from_rows(&rows.time_s, rows.motor_mm, rows.load_mm, rows.current_a)
                    .and_then(|log| fit_backlash(&log, &FitSettings::without_axis())),
                0.5e-3 * axis.gap_um,
            ),
            Given::MotorOnly => (
                axis.log(&rows).and_then(|log| {
                    fit_motor_only(&MotorLog::from(log), &axis.settings().motor_only())
                }),
                axis.half_gap(),
            ),
        }
    }
}

/// How a lot of logs was fitted.
#[derive(Clone, Debug, Default)]
pub struct Score {
    pub covered: usize,
    pub refused: Vec<String>,
    /// Errors of the gap in its own parts, the smallest first.
    pub errors: Vec<f64>,
    /// Widths of the intervals in parts of the gap, the narrowest first.
    pub widths: Vec<f64>,
    /// Largest distance of the truth from an interval, in widths.
    pub beyond: f64,
}

impl Score {
    /// Of one log for each seed; `tell` hears of each.
    pub fn of(
        kind: Kind,
        seeds: std::ops::Range<u64>,
        mut tell: impl FnMut(&BallScrew, f64, &Result<BacklashFit, FitError>),
    ) -> Score {
        let mut score = Score::default();
        for seed in seeds {
            let axis = (kind.axis)(seed);
            // Long logs cost time; they are the same at 20 s.
            let axis = BallScrew {
                seconds: axis.seconds.min(20.0),
                ..axis
            };
            let (fit, truth) = kind.given.fit(&axis);
            tell(&axis, truth, &fit);
            match fit {
                Ok(fit) => score.add(&fit, truth),
                Err(error) => score.refused.push(error.to_string()),
            }
        }
        score.errors.sort_by(f64::total_cmp);
        score.widths.sort_by(f64::total_cmp);
        score
    }

    fn add(&mut self, fit: &BacklashFit, truth: f64) {
        assert!(fit.damping_time_s >= 0.0, "{fit:?}");
        assert!(fit.stiffness_nm_per_rad.is_none_or(|k| k < 1e9), "{fit:?}");
        let [low, high] = fit.half_gap_interval_rad;
        self.covered += usize::from(low <= truth && truth <= high);
        self.errors.push((fit.half_gap_rad / truth - 1.0).abs());
        self.widths.push((high - low) / truth);
        let beyond = (low - truth).max(truth - high) / (high - low);
        self.beyond = self.beyond.max(beyond);
    }

    /// Cells of a table: covered, median and worst error, median width, refused.
    pub fn row(&self) -> String {
        let fitted = self.errors.len();
        let percent = |value: Option<&f64>| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{:.2} %", 100.0 * value))
        };
        format!(
            "{} of {fitted} | {} | {} | {} | {:.2} | {}",
            self.covered,
            percent(self.errors.get(fitted / 2)),
            percent(self.errors.last()),
            percent(self.widths.get(fitted / 2)),
            self.beyond,
            self.refused.len()
        )
    }
}
