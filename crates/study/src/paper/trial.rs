//! One run of the paper's axis and its outcome.

use super::motion::Move;
use crate::error::StudyError;
use lostmotion_base::Clock;
use lostmotion_drive::{AxisOutput, AxisSample};
use lostmotion_methods::published::PublishedSettings;
use lostmotion_methods::{AxisConfig, MethodId, build_runner};

/// Conditions of a run that the paper does not give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// The move.
    pub motion: Move,
    /// Initial covariance of the least squares.
    pub p0: f64,
    /// Threshold of the inertia, as the paper's lambda.
    pub lambda: f64,
}

impl Trial {
    /// The conditions that we assume for the paper.
    pub const CHOSEN: Trial = Trial {
        motion: Move::CHOSEN,
        p0: 300.0,
        lambda: 0.60,
    };

    fn axis(&self) -> AxisConfig {
        let mut axis = AxisConfig::paper();
        let published = axis.compensation.published;
        axis.compensation.published = PublishedSettings {
            p0: self.p0,
            lambda: Some(self.lambda),
            ..published
        };
        axis
    }

    /// Runs the axis; one sample a servo tick.
    fn run(&self, method: MethodId, without_gap: bool) -> Result<Vec<AxisSample>, StudyError> {
        let axis = if without_gap {
            self.axis().without_gap()
        } else {
            self.axis()
        };
        let mut runner = build_runner(&axis, method, 0.0)?;
        let mut out = AxisOutput::new(true);
        runner.push(&self.motion.setpoints(), &mut out)?;
        Ok(out.trace.unwrap_or_default())
    }
}

/// Outcome of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Reference minus load at the end of both rests, rad.
    pub offset_rad: [f64; 2],
    /// Estimated minus true backlash angle there, rad; NaN where the method estimates none.
    pub estimate_error_rad: [f64; 2],
    /// RMS over the whole run of what the gap adds to the load's position, over that of `none`.
    pub rms_ratio: f64,
    /// Largest of what the gap adds, over that of `none`.
    pub max_ratio: f64,
}

impl Outcome {
    /// The larger settled offset as a part of half the gap.
    pub fn worst_offset(&self, half_gap_rad: f64) -> f64 {
        self.offset_rad
            .iter()
            .map(|offset| offset.abs() / half_gap_rad)
            .fold(0.0, f64::max)
    }

    /// The larger error of the estimate at rest as a part of half the gap.
    pub fn worst_estimate(&self, half_gap_rad: f64) -> f64 {
        self.estimate_error_rad
            .iter()
            .map(|error| error.abs() / half_gap_rad)
            .fold(0.0, f64::max)
    }
}

/// All methods under the same conditions.
#[derive(Clone, Debug)]
pub struct Trials {
    /// The conditions.
    pub trial: Trial,
    /// Half the gap, rad.
    pub half_gap_rad: f64,
    /// Methods with their outcomes and every servo tick; the first is `none`.
    pub runs: Vec<(MethodId, Outcome, Vec<AxisSample>)>,
}

/// Runs `none` and these methods under the same conditions.
///
/// # Errors
/// Settings that make no sense.
pub fn trials(trial: &Trial, methods: &[MethodId]) -> Result<Trials, StudyError> {
    // The same axis without a gap is the reference: what is left is what the gap causes.
    let (rigid, none) = (
        trial.run(MethodId::NONE, true)?,
        trial.run(MethodId::NONE, false)?,
    );
    let of_none = deviation(&none, &rigid);
    let outcome = |samples: &[AxisSample]| {
        let [squares, max] = deviation(samples, &rigid);
        // The two rests, where the offset has settled.
        let at = trial.motion.settled_s().map(|time| {
            samples
                .get((time / Clock::SERVO.period_s()) as usize)
                .copied()
                .unwrap_or_default()
        });
        Outcome {
            offset_rad: at.map(|sample| sample.reference.position - sample.load_position),
            estimate_error_rad: at.map(|sample| {
                sample.gap_angle_estimate - (sample.motor_position - sample.load_position)
            }),
            // As many ticks in both: the ratio of the sums is that of the means.
            rms_ratio: (squares / of_none[0]).sqrt(),
            max_ratio: max / of_none[1],
        }
    };
    let mut runs = vec![(MethodId::NONE, outcome(&none), none)];
    for method in methods {
        let samples = trial.run(*method, false)?;
        runs.push((*method, outcome(&samples), samples));
    }
    Ok(Trials {
        trial: *trial,
        half_gap_rad: trial.axis().reflected_load().half_gap_rad(),
        runs,
    })
}

/// Sum of squares and largest magnitude of what the gap adds to the load's position.
fn deviation(samples: &[AxisSample], rigid: &[AxisSample]) -> [f64; 2] {
    samples
        .iter()
        .zip(rigid)
        .fold([0.0, 0.0], |[squares, max], (with, without)| {
            let off = with.load_position - without.load_position;
            [squares + off * off, max.max(off.abs())]
        })
}
