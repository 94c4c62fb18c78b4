//! Limits of an axis.

use serde::{Deserialize, Serialize};

/// Limits of one axis, in mm (linear) or rad (rotary) and s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisLimits {
    /// Lower end of the travel.
    pub min: f64,
    /// Upper end of the travel.
    pub max: f64,
    /// Largest speed per second.
    pub velocity: f64,
    /// Largest acceleration per s2.
    pub acceleration: f64,
    /// Largest jerk per s3.
    pub jerk: f64,
}

/// An invalid limit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LimitError {
    /// A velocity, acceleration or jerk that is not a positive finite number.
    #[error("{what} is {value}; it has to be a positive finite number")]
    NotPositive {
        /// Which limit.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A travel whose lower end is not below its upper end, or is not a number.
    #[error("the travel goes from {min} to {max}; its lower end has to lie below its upper end")]
    EmptyTravel {
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
}

impl AxisLimits {
    /// Checks every limit.
    ///
    /// # Errors
    /// The first invalid limit.
    pub fn check(&self) -> Result<(), LimitError> {
        for (what, value) in [
            ("velocity", self.velocity),
            ("acceleration", self.acceleration),
            ("jerk", self.jerk),
        ] {
            // Written so that NaN fails, too.
            if !(value.is_finite() && value > 0.0) {
                return Err(LimitError::NotPositive { what, value });
            }
        }
        // False where an end is NaN.
        if self.min < self.max {
            Ok(())
        } else {
            Err(LimitError::EmptyTravel {
                min: self.min,
                max: self.max,
            })
        }
    }

    /// Whether a position lies in the travel, with `slack` to either side.
    pub fn contains(&self, position: f64, slack: f64) -> bool {
        position >= self.min - slack && position <= self.max + slack
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_refused_with_its_value() {
        let good = AxisLimits {
            min: -1.0,
            max: 1.0,
            velocity: 1.0,
            acceleration: 1.0,
            jerk: 1.0,
        };
        assert_eq!(good.check(), Ok(()));
        assert_eq!(
            AxisLimits { jerk: 0.0, ..good }.check(),
            Err(LimitError::NotPositive {
                what: "jerk",
                value: 0.0
            })
        );
        assert!(
            AxisLimits {
                velocity: f64::NAN,
                ..good
            }
            .check()
            .is_err()
        );
        assert!(AxisLimits { max: -1.0, ..good }.check().is_err());
    }
}
