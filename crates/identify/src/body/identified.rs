//! All that a log tells of an axis as one body, each part with why it is not told where it is not.

use super::{
    BodyLog, LoadOff, LostMotion, Motion, RigidBody, ServoGains, fit_body, fit_lost_motion,
    fit_servo, times_go_with,
};
use crate::error::FitError;
use lostmotion_base::units;
use lostmotion_drive::config::AxisUnit;
use serde::Serialize;

/// Columns of an axis; empty what was not logged.
#[derive(Clone, Copy, Debug)]
pub struct BodyRows<'a> {
    /// Unit of the positions.
    pub unit: AxisUnit,
    /// Times, s.
    pub time_s: &'a [f64],
    /// Motor, seen at the load.
    pub motor: &'a [f64],
    /// Load.
    pub load: &'a [f64],
    /// Commanded position.
    pub command: &'a [f64],
    /// What drives the axis: force, torque, current or voltage.
    pub drive: &'a [f64],
    /// How much later or earlier than the motor's the position of the load may be read, s, where the log does
    /// not tell it: [`LATENESS_S`](crate::LATENESS_S) where nobody knows, zero where one drive reads both at
    /// the same time.
    pub lateness_s: f64,
}

/// What a log tells; m or rad, and the log's unit of what drives the axis.
#[derive(Clone, Debug, Serialize)]
pub struct Identified {
    /// Rows, on even times.
    pub samples: usize,
    /// Time between two of them, s.
    pub period_s: f64,
    /// Strokes of the motion.
    pub strokes: usize,
    /// Reversals of the motion.
    pub reversals: usize,
    /// How the load's scale was off the motor's, which was taken off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_off: Option<LoadOff>,
    /// How position is lost after a reversal.
    pub lost_motion: Option<LostMotion>,
    /// Inertia and friction.
    pub body: Option<RigidBody>,
    /// Gains of the servo.
    pub servo: Option<ServoGains>,
    /// What is not told, and why.
    pub untold: Vec<String>,
}

impl Identified {
    /// Finds what the columns tell.
    ///
    /// # Errors
    /// Those of [`BodyLog::from_rows`], [`BodyLog::read_within`] and [`times_go_with`].
    pub fn of(rows: &BodyRows<'_>) -> Result<Identified, FitError> {
        let scaled = |values: &[f64]| -> Vec<f64> {
            let base = |value: f64| match rows.unit {
                AxisUnit::Mm => value * 1e-3,
                AxisUnit::Deg => units::rad(value),
                AxisUnit::Rad => value,
            };
            values.iter().map(|value| base(*value)).collect()
        };
        let log = BodyLog::from_rows(
            rows.time_s,
            scaled(rows.motor),
            scaled(rows.load),
            scaled(rows.command),
            rows.drive.to_vec(),
        )?
        .read_within(rows.lateness_s)?;
        let motion = Motion::of(&log);
        times_go_with(&log, &motion)?;
        let log = log.put_right(&motion);
        let mut untold = Vec::new();
        let mut kept = |what: &str, why: String| untold.push(format!("{what}: {why}"));
        let body = fit_body(&log, &motion)
            .and_then(|body| {
                let reversed = || "the axis speeds up against what drives it: a sign is reversed";
                (!body.is_reversed())
                    .then_some(body)
                    .ok_or_else(|| reversed().to_owned())
            })
            .map_err(|why| kept("inertia and friction", why))
            .ok();
        let lost_motion = fit_lost_motion(&log, body.as_ref())
            .map_err(|why| kept("lost motion", why))
            .ok();
        let servo = fit_servo(&log, &motion)
            .map_err(|why| kept("servo", why))
            .ok();
        untold.extend(body.iter().flat_map(|body| body.untold.iter().cloned()));
        untold.extend(servo.iter().flat_map(|servo| servo.untold.iter().cloned()));
        Ok(Identified {
            samples: log.len(),
            period_s: log.period_s,
            strokes: motion.strokes.len(),
            reversals: motion.reversals,
            load_off: log.load_off().copied(),
            lost_motion,
            body,
            servo,
            untold,
        })
    }
}
