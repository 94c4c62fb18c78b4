//! How an axis begins: at rest or moving, its shaft wound up or not, its drive on or off.

use crate::config::AxisConfig;
use crate::error::AxisError;
use std::f64::consts::TAU;

/// Largest speed that motor and load may begin with, rad/s at the motor. A choice: beyond any
/// motor's.
const LARGEST_START_SPEED_RAD_S: f64 = 1e4;
/// Largest wind-up that a shaft may begin with, rad at the motor. A choice: a turn, beyond any
/// shaft's.
const LARGEST_WIND_UP_RAD: f64 = TAU;

/// How an axis begins, in the axis' own unit (mm, deg or rad at the load).
///
/// With the drive off no current flows whatever the motor does, as with an open winding: motor and
/// load move by their speeds, shaft, friction and forces alone.
///
/// ```
/// use lostmotion_drive::AxisStart;
///
/// let thrown = AxisStart { load_velocity: 20.0, drive_off: true, ..AxisStart::at(100.0) };
/// assert_eq!((thrown.position, thrown.wind_up), (100.0, None));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisStart {
    /// Position of the motor.
    pub position: f64,
    /// Speed of the motor, per s.
    pub motor_velocity: f64,
    /// Speed of the load, per s.
    pub load_velocity: f64,
    /// Wind-up of the shaft: motor less load, past the flank on the side of its sign. `None`: as
    /// at rest, where in its gap [`AxisConfig::start_in_gap`] says, or on the flank that carries a
    /// constant load.
    pub wind_up: Option<f64>,
    /// Whether the drive is off.
    pub drive_off: bool,
}

impl AxisStart {
    /// At rest with the motor at a position and the drive on.
    pub fn at(position: f64) -> AxisStart {
        AxisStart {
            position,
            ..AxisStart::default()
        }
    }

    /// Checks every value for an axis whose description has been checked.
    ///
    /// # Errors
    /// A position that is not finite, a speed or a wind-up that no axis has.
    pub fn check<C>(&self, config: &AxisConfig<C>) -> Result<(), AxisError> {
        if !self.position.is_finite() {
            return Err(AxisError::StartPosition {
                value: self.position,
            });
        }
        let per_unit = config.transmission.motor_rad_per_unit();
        let within = |what: &'static str, value: f64, largest_rad: f64| {
            let highest = largest_rad / per_unit;
            // written so that a value that is not a number is refused, too
            if value.abs() <= highest {
                Ok(())
            } else {
                Err(AxisError::Start {
                    what,
                    value,
                    highest,
                })
            }
        };
        within(
            "motor velocity",
            self.motor_velocity,
            LARGEST_START_SPEED_RAD_S,
        )?;
        within(
            "load velocity",
            self.load_velocity,
            LARGEST_START_SPEED_RAD_S,
        )?;
        within("wind-up", self.wind_up.unwrap_or(0.0), LARGEST_WIND_UP_RAD)
    }
}
