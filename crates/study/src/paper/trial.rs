//! One run of the paper's axis and its outcome, and a scan of the conditions that the paper does not
//! give.

use super::CLAIM;
use super::motion::Move;
use crate::error::StudyError;
use lostmotion_base::Clock;
use lostmotion_drive::{AxisOutput, AxisSample};
use lostmotion_methods::published::PublishedSettings;
use lostmotion_methods::{AxisConfig, MethodId, build_runner};
use rayon::prelude::*;

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

/// Initial covariances tried: from no learning to numerical trouble.
pub(super) const P0: [f64; 12] = [
    1.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 1e5, 1e6, 1e7, 1e8,
];
/// Lambdas tried; the bound of the paper's axis is 0.775.
pub(super) const LAMBDA: [f64; 8] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8];
/// Distances tried, rad.
pub(super) const DISTANCE_RAD: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
/// Speeds tried, rad/s.
pub(super) const VELOCITY_RAD_S: [f64; 5] = [5.0, 10.0, 20.0, 40.0, 80.0];
/// Both forms of the method.
pub const FORMS: [MethodId; 2] = [MethodId::PUBLISHED, MethodId::PUBLISHED_LITERAL];

/// One point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanPoint {
    /// `published` or `published-literal`.
    pub method: MethodId,
    /// The conditions.
    pub trial: Trial,
    /// Its outcome.
    pub outcome: Outcome,
    /// The larger settled offset, in parts of half the gap.
    pub offset: f64,
    /// The larger error of the estimate at rest, in parts of half the gap.
    pub estimate: f64,
}

impl ScanPoint {
    /// Whether "less than 15 %" holds for the settled load and for the estimate.
    pub fn holds(&self) -> bool {
        self.offset < CLAIM && self.estimate < CLAIM
    }
}

/// All points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    /// P0 by lambda, on the chosen move.
    pub tuning: Vec<ScanPoint>,
    /// Distance by speed, with the chosen P0 and lambda.
    pub motion: Vec<ScanPoint>,
}

/// Runs all points, on all cores; the result does not depend on how many there are.
///
/// # Errors
/// None for the preset.
pub fn scan() -> Result<Scan, StudyError> {
    let chosen = Trial::CHOSEN;
    // The unknown settings on the chosen move, then the unknown move with the chosen settings.
    let tuning: Vec<Trial> = P0
        .iter()
        .flat_map(|p0| {
            LAMBDA.map(|lambda| Trial {
                p0: *p0,
                lambda,
                ..chosen
            })
        })
        .collect();
    let at = |distance: f64| {
        VELOCITY_RAD_S.map(|velocity| Trial {
            motion: Move::CHOSEN.with(distance, velocity),
            ..chosen
        })
    };
    let motion: Vec<Trial> = DISTANCE_RAD
        .iter()
        .flat_map(|distance| at(*distance))
        .collect();
    Ok(Scan {
        tuning: points(&tuning)?,
        motion: points(&motion)?,
    })
}

fn points(list: &[Trial]) -> Result<Vec<ScanPoint>, StudyError> {
    let rows: Vec<Result<Vec<ScanPoint>, StudyError>> = list
        .par_iter()
        .map(|trial| {
            // The first run is `none`, which the outcomes already refer to.
            let answer = trials(trial, &FORMS)?;
            let pairs = FORMS.iter().zip(answer.runs.iter().skip(1));
            let point =
                |(method, (_, outcome, _)): (&MethodId, &(MethodId, Outcome, _))| ScanPoint {
                    method: *method,
                    trial: *trial,
                    outcome: *outcome,
                    offset: outcome.worst_offset(answer.half_gap_rad),
                    estimate: outcome.worst_estimate(answer.half_gap_rad),
                };
            Ok(pairs.map(point).collect())
        })
        .collect();
    // First error in the order of the points, whatever thread met one first.
    let mut points = Vec::new();
    for row in rows {
        points.extend(row?);
    }
    Ok(points)
}
