//! The conditions that the paper does not give, scanned.

use super::CLAIM;
use super::motion::Move;
use super::trial::{Outcome, Trial, trials};
use crate::error::StudyError;
use lostmotion_methods::MethodId;
use rayon::prelude::*;

/// Initial covariances tried: from no learning to numerical trouble.
pub const P0: [f64; 12] = [
    1.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 1e5, 1e6, 1e7, 1e8,
];
/// Lambdas tried; the bound of the paper's axis is 0.775.
pub const LAMBDA: [f64; 8] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8];
/// Distances tried, rad.
pub const DISTANCE_RAD: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
/// Speeds tried, rad/s.
pub const VELOCITY_RAD_S: [f64; 5] = [5.0, 10.0, 20.0, 40.0, 80.0];
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
