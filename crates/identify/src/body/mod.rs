//! What a log tells of an axis as one body: inertia, friction, the servo's gains, and how position
//! is lost after a reversal.
//!
//! Unlike [`fit_backlash`](crate::fit_backlash), which finds the gap, these fits need neither a
//! motor's data sheet nor a load's scale. Positions are at the load in m or rad; what drives the
//! axis is in any unit (force, torque, current, voltage), and so are the coefficients per second
//! squared, per second and alone:
//!
//! ```text
//! drive = inertia a + viscous v + coulomb sign(v) + constant
//! ```
//!
//! Both sides are averaged with one triangular window, so that no lag arises between them and the
//! acceleration needs no filter of its own. Intervals come from the scatter between blocks of the
//! log.

mod followed;
mod identified;
pub(crate) mod load_off;
pub mod lost;
pub mod motion;
pub mod replay;
mod rigid;
mod servo;
mod squares;
mod times;
mod windows;

pub use identified::{BodyRows, Identified};
pub use load_off::LoadOff;
pub use lost::{LostMotion, fit_lost_motion};
pub use motion::{Motion, Stroke};
pub use replay::{Replayed, replay};
pub use rigid::{RigidBody, fit_body};
pub use servo::{ServoGains, fit_servo};
pub(crate) use times::MAX_PERIOD_S;
pub use times::times_go_with;

use crate::averages::{Averages, Rates};
use crate::error::FitError;
use crate::even::EvenGrid;
use crate::rounding::rounding_step;
use crate::settings::LATENESS_S;
use serde::Serialize;

/// What is off by all of itself or more is told as off by this part.
const MOST_UNCERTAIN: f64 = 0.99;

/// A figure with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// The estimate.
    pub value: f64,
    /// Standard error.
    pub error: f64,
    /// 95 % interval.
    pub interval: [f64; 2],
}

impl Figure {
    /// Whether the interval leaves zero out.
    pub fn is_told(&self) -> bool {
        self.interval[0] > 0.0 || self.interval[1] < 0.0
    }

    /// How far off the value may be, as a part of it, below 1: the longer half of the interval.
    pub fn uncertainty(&self) -> f64 {
        let [low, high] = self.interval;
        let half = (self.value - low).max(high - self.value);
        (half / self.value.abs()).clamp(0.0, MOST_UNCERTAIN)
    }

    /// The same with an interval that is wider by so much to either side.
    #[must_use]
    pub(crate) fn widened(self, by: f64) -> Figure {
        let [low, high] = self.interval;
        Figure {
            interval: [low - by, high + by],
            ..self
        }
    }

    /// The same with an interval that holds that of another, too.
    #[must_use]
    pub(crate) fn joined(self, other: Figure) -> Figure {
        let ([a, b], [c, d]) = (self.interval, other.interval);
        Figure {
            interval: [a.min(c), b.max(d)],
            ..self
        }
    }

    /// The same in another unit.
    #[must_use]
    pub fn times(self, factor: f64) -> Figure {
        let mut interval = self.interval.map(|end| end * factor);
        if factor < 0.0 {
            interval.reverse();
        }
        Figure {
            value: self.value * factor,
            error: self.error * factor.abs(),
            interval,
        }
    }
}

/// Columns of one axis at even times.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyLog {
    /// Time between two samples, s.
    pub period_s: f64,
    /// Position of the motor at the load, m or rad.
    pub motor: Vec<f64>,
    /// Position of the load; empty where it was not logged.
    pub load: Vec<f64>,
    /// Commanded position; empty where it was not logged.
    pub command: Vec<f64>,
    /// What drives the axis; empty where it was not logged.
    pub drive: Vec<f64>,
    /// Samples in the place of missing rows; empty for a whole log.
    lost: Vec<bool>,
    /// How many of them there were in the log.
    missing_rows: usize,
    /// How the load was off the motor, where that was taken off.
    load_off: Option<LoadOff>,
    /// How much later or earlier than the motor's the load may be read where the log does not tell it, s.
    lateness_s: f64,
    /// How large a scale of the load may be that was not taken off, in parts of the travel.
    unseen_scale: f64,
    /// Smallest steps of motor and load.
    steps: [f64; 2],
}

impl BodyLog {
    /// A log from rows with their times in s, in order. Uneven rows are carried over to even times.
    ///
    /// # Errors
    /// Times that are not in order, columns of another length, fewer than three rows, more missing
    /// than present ones.
    pub fn from_rows(
        time_s: &[f64],
        motor: Vec<f64>,
        load: Vec<f64>,
        command: Vec<f64>,
        drive: Vec<f64>,
    ) -> Result<BodyLog, FitError> {
        for column in [&load, &command, &drive] {
            if !column.is_empty() && column.len() != motor.len() || motor.len() != time_s.len() {
                return Err(FitError::LengthMismatch {
                    motor: motor.len(),
                    load: load.len(),
                    current: drive.len(),
                });
            }
        }
        if time_s.len() < 3 {
            return Err(FitError::Empty);
        }
        let grid = EvenGrid::new(time_s)?;
        let steps = [rounding_step(&motor), rounding_step(&load)];
        if grid.even {
            return Ok(BodyLog {
                period_s: grid.period_s,
                motor,
                load,
                command,
                drive,
                lost: Vec::new(),
                missing_rows: 0,
                load_off: None,
                lateness_s: LATENESS_S,
                unseen_scale: 0.0,
                steps,
            });
        }
        let smooth = |column: &[f64]| {
            if column.is_empty() {
                Vec::new()
            } else {
                grid.cubic(time_s, column)
            }
        };
        Ok(BodyLog {
            motor: smooth(&motor),
            load: smooth(&load),
            command: smooth(&command),
            drive: if drive.is_empty() {
                drive
            } else {
                grid.straight(time_s, &drive)
            },
            period_s: grid.period_s,
            missing_rows: grid.lost.iter().filter(|lost| **lost).count(),
            lost: grid.lost,
            load_off: None,
            lateness_s: LATENESS_S,
            unseen_scale: 0.0,
            steps,
        })
    }

    /// The same with the load put right where its lengths or its clock are certainly not the motor's: see
    /// [`Self::load_off`].
    #[must_use]
    pub fn put_right(mut self, motion: &Motion) -> BodyLog {
        if self.load.is_empty() {
            return self;
        }
        let looked = self.pair().put_right(motion);
        self.unseen_scale = looked.unseen_scale;
        if let Some(right) = looked.right {
            (self.load, self.lost, self.load_off) = (right.load, right.lost, Some(right.off));
        }
        self
    }

    /// The same with what [`fit_backlash`](crate::fit_backlash) found of how the load of the same rows is off taken
    /// off, too: lateness and scale each where they were not taken off already.
    #[must_use]
    pub fn with_late_taken_off(mut self, off: LoadOff) -> BodyLog {
        if self.load.len() != self.motor.len() {
            return self;
        }
        let before = self.load_off.unwrap_or_default();
        let (mut rest, mut all) = (LoadOff::default(), before);
        if before.late_s == 0.0 && off.late_s != 0.0 {
            rest.late_s = off.late_s;
            all = all.read_as(&off);
        }
        if before.scale == 0.0 && off.scale != 0.0 {
            rest.scale = off.scale;
            (all.scale, all.scale_interval) = (off.scale, off.scale_interval);
            self.unseen_scale = 0.0;
        }
        if all != before {
            (self.load, self.lost) = self.pair().without(&rest);
            self.load_off = Some(all);
        }
        self
    }

    /// The same whose load may be read so much later or earlier than its motor where the log does not tell it,
    /// s: [`LATENESS_S`] if not given, nothing where one drive reads both at the same time.
    ///
    /// # Errors
    /// [`FitError::Setting`] for a time that is negative or not finite.
    pub fn read_within(self, lateness_s: f64) -> Result<BodyLog, FitError> {
        let lateness_s = crate::settings::not_negative("lateness_s", lateness_s)?;
        Ok(BodyLog { lateness_s, ..self })
    }

    /// The motor and the load beside it.
    fn pair(&self) -> load_off::Pair<'_> {
        load_off::Pair {
            period_s: self.period_s,
            motor: &self.motor,
            load: &self.load,
            drive: &self.drive,
            lost: &self.lost,
        }
    }

    /// How the load was off the motor; `None` where nothing was taken off.
    pub fn load_off(&self) -> Option<&LoadOff> {
        self.load_off.as_ref()
    }

    /// Samples in the log.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.motor.len()
    }

    /// Samples in the place of rows that were missing: nothing is read there.
    pub fn missing_rows(&self) -> usize {
        self.missing_rows
    }

    /// Share of the samples that stand for rows that were lost.
    fn lost_share(&self) -> f64 {
        self.lost.iter().filter(|lost| **lost).count() as f64 / self.len().max(1) as f64
    }

    /// Whether any sample of a range stands for a row that was lost.
    fn touches_lost(&self, samples: std::ops::RangeInclusive<usize>) -> bool {
        self.lost
            .get(samples)
            .is_some_and(|range| range.contains(&true))
    }
}

/// Longest time between two turns of a velocity loop, s. A choice: drives have 31 us to 1 ms.
const SLOWEST_TURN_S: f64 = 1e-3;
