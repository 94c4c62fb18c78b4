//! Settings of a fit.

use lostmotion_drive::AxisConfig;
use serde::{Deserialize, Serialize};

use crate::error::FitError;

/// Lateness, either way, that intervals of gap and lost motion hold where the log does not tell it, s. A choice: from
/// here on it is taken off before where speeds differ, and ordinary controls read all in a cycle of less.
pub const LATENESS_S: f64 = 400e-6;

/// Settings of a fit. Motor data come from the data sheet; everything else has a default that suits
/// logs of 0.1 to 1 ms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FitSettings {
    /// Torque per current, N m/A.
    pub torque_constant_nm_per_a: f64,
    /// Inertia on the motor's side of the gap, rotor and screw or pinion together, kg m2; fitted if
    /// not given, which costs accuracy and needs a load in which current and acceleration do not
    /// always go together.
    pub motor_inertia_kgm2: Option<f64>,
    /// Viscous friction of the motor, N m s/rad. Give it where the inertia is fitted: friction that
    /// is missing here is attributed to the inertia and from there to the gap (a few percent of the
    /// gap on a load with much friction).
    pub motor_viscous_nm_s_per_rad: f64,
    /// Coulomb friction of the motor's own bearings, N m.
    pub motor_coulomb_nm: f64,
    /// Inertia of motor and load together where a description tells it, kg m2: a log that shows
    /// quite another one is refused.
    pub known_inertia_kgm2: Option<f64>,
    /// Rated torque of the motor, N m: names a current in percent.
    pub rated_torque_nm: Option<f64>,
    /// Largest current of the drive, A: names a current in percent of it.
    pub current_limit_a: Option<f64>,
    /// Angle of the motor for a unit of the log's positions, rad: names positions that are the
    /// motor's turns or its angle.
    pub motor_rad_per_unit: Option<f64>,
    /// Whether the motor's own friction is as given; without it friction and inertia of the motor
    /// are fitted, too, in parts of the torque constant, and presumed to be Coulomb and viscous.
    pub motor_friction_known: bool,
    /// Stiffness of the shaft where it is known, N m/rad; otherwise it is fitted.
    pub stiffness_nm_per_rad: Option<f64>,
    /// Stiffness of the shaft where a description tells it, N m/rad: where the log shows quite another one, the
    /// interval holds the gap that goes with this one, too.
    pub known_stiffness_nm_per_rad: Option<f64>,
    /// Whether the shaft's damping is fitted, too. Without it a torque that falls while in contact
    /// makes the gap look larger.
    pub fit_damping: bool,
    /// Contact torque from which on the side counts as known, N m; from the data if not given.
    pub torque_threshold_nm: Option<f64>,
    /// Residual at which the Huber loss turns from square to linear, rad; 1.345 robust standard
    /// deviations if not given.
    pub huber_delta_rad: Option<f64>,
    /// Half the width of the triangular averaging window, s.
    pub half_window_s: f64,
    /// Time after contact was made that is left out, s: bouncing and ringing of the shaft.
    pub settle_s: f64,
    /// Largest change of the position difference over one window, as a share of the span that it
    /// covers in the log.
    pub slip_share: f64,
    /// Changes of side that the log has to hold.
    pub min_traversals: usize,
    /// How much later or earlier than the motor's the position of the load may be read, s, where the log does
    /// not tell it: intervals hold it. Zero where one drive reads both at the same time.
    pub lateness_s: f64,
    /// Tolerance of the solver on gap and feasibility, in units scaled to 1.
    pub solver_tolerance: f64,
    /// Most iterations of one solve.
    pub solver_iterations: u32,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            torque_constant_nm_per_a: 1.0,
            motor_inertia_kgm2: None,
            motor_viscous_nm_s_per_rad: 0.0,
            motor_coulomb_nm: 0.0,
            known_inertia_kgm2: None,
            rated_torque_nm: None,
            current_limit_a: None,
            motor_rad_per_unit: None,
            motor_friction_known: true,
            stiffness_nm_per_rad: None,
            known_stiffness_nm_per_rad: None,
            fit_damping: true,
            torque_threshold_nm: None,
            huber_delta_rad: None,
            half_window_s: 2.5e-3,
            settle_s: 1e-2,
            slip_share: 0.05,
            min_traversals: 2,
            lateness_s: LATENESS_S,
            solver_tolerance: 1e-9,
            solver_iterations: 100,
        }
    }
}

impl FitSettings {
    /// Defaults for a motor of this torque constant (N m/A) and, where known, inertia (kg m2).
    pub fn new(torque_constant_nm_per_a: f64, motor_inertia_kgm2: Option<f64>) -> Self {
        Self {
            torque_constant_nm_per_a,
            motor_inertia_kgm2,
            ..Self::default()
        }
    }

    /// Defaults with the data of an axis: the motor's torque constant and its own friction,
    /// and the inertia on the motor's side of the gap, rotor and screw or pinion together.
    ///
    /// ```
    /// use lostmotion_identify::FitSettings;
    /// use lostmotion_methods::AxisConfig;
    ///
    /// let axis = AxisConfig::paper();
    /// let settings = FitSettings::for_axis(&axis);
    /// assert_eq!(settings.motor_inertia_kgm2, Some(axis.motor_side_inertia_kgm2()));
    /// assert!(settings.check().is_ok());
    /// ```
    pub fn for_axis<C>(axis: &AxisConfig<C>) -> Self {
        let motor = &axis.motor;
        Self {
            motor_viscous_nm_s_per_rad: motor.viscous_nm_s_per_rad,
            motor_coulomb_nm: motor.coulomb_nm,
            known_inertia_kgm2: Some(
                axis.motor_side_inertia_kgm2() + axis.reflected_load().inertia_kgm2,
            ),
            known_stiffness_nm_per_rad: Some(axis.reflected_load().stiffness_nm_per_rad),
            rated_torque_nm: Some(motor.rated_torque_nm),
            current_limit_a: Some(axis.drive.current_limit_a),
            motor_rad_per_unit: Some(axis.transmission.motor_rad_per_unit()),
            ..Self::new(
                motor.torque_constant_nm_per_a,
                Some(axis.motor_side_inertia_kgm2()),
            )
        }
    }

    /// Defaults where nothing is known of the motor: torques are in A, angles in the log's unit.
    /// Its inertia and friction are found along with the gap; a log that does not tell them apart
    /// is refused with a bound of gap and wind-up together.
    pub fn without_axis() -> Self {
        Self {
            motor_friction_known: false,
            ..Self::default()
        }
    }

    /// The same with windows short enough for a fit from the motor alone: a resting load
    /// shows itself for milliseconds only.
    #[must_use]
    pub fn motor_only(self) -> Self {
        Self {
            half_window_s: 1e-3,
            ..self
        }
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// The first that is out of its range.
    pub fn check(&self) -> Result<(), FitError> {
        // Settings that may be left out are checked where they are given.
        let positive = [
            (
                "torque_constant_nm_per_a",
                Some(self.torque_constant_nm_per_a),
            ),
            ("stiffness_nm_per_rad", self.stiffness_nm_per_rad),
            (
                "known_stiffness_nm_per_rad",
                self.known_stiffness_nm_per_rad,
            ),
            ("torque_threshold_nm", self.torque_threshold_nm),
            ("motor_rad_per_unit", self.motor_rad_per_unit),
            ("huber_delta_rad", self.huber_delta_rad),
            ("slip_share", Some(self.slip_share)),
            ("solver_tolerance", Some(self.solver_tolerance)),
        ];
        let from_zero_on = [
            ("motor_inertia_kgm2", self.motor_inertia_kgm2),
            ("known_inertia_kgm2", self.known_inertia_kgm2),
            ("rated_torque_nm", self.rated_torque_nm),
            ("current_limit_a", self.current_limit_a),
            (
                "motor_viscous_nm_s_per_rad",
                Some(self.motor_viscous_nm_s_per_rad),
            ),
            ("motor_coulomb_nm", Some(self.motor_coulomb_nm)),
            ("half_window_s", Some(self.half_window_s)),
            ("settle_s", Some(self.settle_s)),
            ("lateness_s", Some(self.lateness_s)),
        ];
        for (name, value) in positive
            .into_iter()
            .filter_map(|(name, value)| Some((name, value?)))
        {
            // Written so that NaN fails, too.
            if !(value.is_finite() && value > 0.0) {
                return Err(FitError::Setting {
                    name,
                    value,
                    expected: "a positive finite number",
                });
            }
        }
        for (name, value) in from_zero_on
            .into_iter()
            .filter_map(|(name, value)| Some((name, value?)))
        {
            not_negative(name, value)?;
        }
        if self.solver_iterations == 0 {
            return Err(FitError::Setting {
                name: "solver_iterations",
                value: 0.0,
                expected: "at least 1",
            });
        }
        Ok(())
    }
}

/// A value of that name that is finite and not negative.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<f64, FitError> {
    // Written so that NaN fails, too.
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(FitError::Setting {
        name,
        value,
        expected: "finite and not negative",
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_drive::config::{Load, NoSettings};

    #[test]
    fn the_screw_counts_with_the_rotor() {
        let mut axis = AxisConfig::<NoSettings>::paper();
        let rotor = axis.motor.inertia_kgm2;
        assert_eq!(FitSettings::for_axis(&axis).motor_inertia_kgm2, Some(rotor));
        if let Load::Reflected(load) = &mut axis.load {
            load.motor_side_inertia_kgm2 = 3e-4;
        }
        let settings = FitSettings::for_axis(&axis);
        assert_eq!(settings.motor_inertia_kgm2, Some(rotor + 3e-4));
        assert_eq!(settings.motor_coulomb_nm, axis.motor.coulomb_nm);
    }
}
