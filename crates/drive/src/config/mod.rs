//! Description of an axis, as machine files hold it: keys carry their unit, those that do not are
//! in the axis' own; unknown keys are refused.
//!
//! What a file may add to an axis, all of it optional and, but for `monitoring`, off where left out
//! (in a machine file the tables are `[axis.x.friction]` and so on):
//!
//! ```
//! # use lostmotion_drive::config::{AxisConfig, NoSettings};
//! # let options = r#"
//! [friction.load.stribeck]    # or: [friction.load.lugre] static_factor, speed_units_s, presliding_units, damping_s
//! static_factor = 1.5         # breakaway over Coulomb friction, 1 to 10
//! speed_units_s = 2.0         # axis units per s from which it is Coulomb friction; at the motor rad/s
//!
//! [flanks]
//! middle = -1.0               # of the gap, in half gaps: pushed forwards the load is where it is told, -1 to 1
//! wear = { factor = 1.8, at_units = 250.0, width_units = 80.0 }    # gap at the worst place over elsewhere; axis units
//!
//! [ripple]
//! cogging = [{ amplitude = 0.05, per_turn = 60 }]             # N m
//! torque = [{ amplitude = 0.01, per_turn = 24, phase_deg = 30.0 }]    # parts of the torque constant
//!
//! [gravity]                   # a joint: rotary transmissions alone
//! torque_nm = 20.0            # m g l at the load
//! hangs_at_deg = -90.0        # where the load hangs straight down
//!
//! [scale]
//! index_units = 12.5          # axis units; counts are whole from here
//! slope_ppm = 8.0
//! errors = [{ amplitude_units = 0.0005, period_units = 0.02 }]    # axis units
//!
//! [drift]                     # gap, load_coulomb, load_viscous, load_inertia, motor_coulomb, motor_viscous, stiffness
//! gap = { factor = 1.5, over_s = 60.0 }
//! load_inertia = { factor = 2.0, over_s = 30.0, shape = "cycle" }
//!
//! [monitoring]                # past a limit the machine stops; 0 switches it off
//! following_error_units = 2.0 # at full speed; axis units
//! standstill_error_units = 0.5
//! # "#;
//! # let axis = toml::to_string(&AxisConfig::<NoSettings>::paper())?;
//! # let config: AxisConfig = toml::from_str(&format!("{axis}{options}"))?;
//! # assert!(config.gravity.is_some() && config.flanks.wear.is_some() && config.drift.load_inertia.is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod check;
mod cycles;
mod drift;
mod drive;
mod filter;
mod flanks;
mod friction;
mod load;
mod monitoring;
mod motor;
mod preset;
mod reference;
mod scale;
mod transmission;

pub use check::AxisConfigError;
pub use cycles::Cycles;
pub use drift::{Change, Drift, Shape};
pub use drive::{AntiWindup, Drive, FrictionFeedforward, LeastMargins, Tuning};
pub use filter::{LowPass, MAX_TORQUE_FILTERS, Notch, TorqueFilter, TorqueFilters};
pub use flanks::{ContactLaw, Flanks, Gap, StartInGap, Wear};
pub use friction::{FrictionLaw, Frictions, Lugre, Stribeck};
pub use load::{Gravity, Load, Reflected, Slide, Table};
pub use monitoring::Monitoring;
pub use motor::{Harmonic, MAX_HARMONICS, Motor, Ripple};
pub use reference::Interpolator;
pub use scale::{Scale, ScaleError};
pub use transmission::{AxisUnit, Linear, Rotary, Transmission};

use check::between;
use serde::{Deserialize, Serialize};

/// What an axis' description tells its compensator: the methods' settings, which are defined above
/// this crate.
pub trait CompensatorSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range, with its key.
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError>;
}

/// No settings: an axis whose compensator is configured elsewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoSettings {}

impl CompensatorSettings for NoSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        Ok(())
    }
}

/// One axis: transmission, motor, load, drive, contact, and settings `C` of its compensators.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisConfig<C = NoSettings> {
    /// Between the axis' unit and the motor.
    pub transmission: Transmission,
    /// The motor.
    pub motor: Motor,
    /// What it moves, through which shaft.
    pub load: Load,
    /// Loops and limits.
    pub drive: Drive,
    /// Cycles of command and servo; on a machine those of the whole machine.
    #[serde(default, skip_serializing_if = "Cycles::is_usual")]
    pub cycles: Cycles,
    /// How the flanks of the gap push on each other.
    #[serde(default)]
    pub contact: ContactLaw,
    /// Where in its gap the axis stands at the start.
    #[serde(default)]
    pub start_in_gap: StartInGap,
    /// How the reference goes from setpoint to setpoint.
    #[serde(default, alias = "reference")]
    pub interpolator: Interpolator,
    /// The compensator and its settings.
    #[serde(default)]
    pub compensation: C,
    /// Laws of the Coulomb frictions.
    #[serde(default, skip_serializing_if = "Frictions::is_plain")]
    pub friction: Frictions,
    /// Where the flanks of the gap are.
    #[serde(default, skip_serializing_if = "Flanks::is_plain")]
    pub flanks: Flanks,
    /// Uneven torque of the motor.
    #[serde(default, skip_serializing_if = "Ripple::is_none")]
    pub ripple: Ripple,
    /// Gravity on a load that turns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
    /// The load's scale.
    #[serde(default, skip_serializing_if = "Scale::is_plain")]
    pub scale: Scale,
    /// What changes while the axis runs.
    #[serde(default, skip_serializing_if = "Drift::is_none")]
    pub drift: Drift,
    /// Limits that are watched while it moves.
    #[serde(default, skip_serializing_if = "Monitoring::is_usual")]
    pub monitoring: Monitoring,
}

impl<C: CompensatorSettings> AxisConfig<C> {
    /// Checks every value, and that the parts go together.
    ///
    /// # Errors
    /// The first value out of range, with its key, value and what is allowed.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        // the transmission first: the checks after it convert with it
        self.transmission
            .check()
            .map_err(|e| e.within("transmission"))?;
        self.motor.check().map_err(|e| e.within("motor"))?;
        self.load
            .check(&self.transmission)
            .map_err(|e| e.within("load"))?;
        self.cycles.check().map_err(|e| e.within("cycles"))?;
        self.drive
            .check(&self.cycles)
            .map_err(|e| e.within("drive"))?;
        between("start_in_gap", self.start_in_gap.0, -1.0, 1.0)?;
        self.compensation
            .check(&self.transmission)
            .map_err(|e| e.within("compensation"))?;
        self.friction.check().map_err(|e| e.within("friction"))?;
        self.flanks
            // the widest gap of a drift has the steepest flanks
            .check(self.gap_in_unit() * self.drift.gap.map_or(1.0, |change| change.factor.max(1.0)))
            .map_err(|e| e.within("flanks"))?;
        self.ripple.check().map_err(|e| e.within("ripple"))?;
        self.gravity
            .map_or(Ok(()), |gravity| gravity.check(&self.transmission))?;
        self.scale.check().map_err(|e| e.within("scale"))?;
        self.drift.check().map_err(|e| e.within("drift"))?;
        self.monitoring
            .check()
            .map_err(|e| e.within("monitoring"))?;
        // last, because it divides by inertias, inductances and speeds that have to be above zero
        self.check_rates()
    }
}

impl<C> AxisConfig<C> {
    /// Period of the current loop, us: the drive's, or what follows from the servo's cycle.
    pub fn current_period_us(&self) -> f64 {
        self.drive.current_period_us(&self.cycles)
    }

    /// Period of position and velocity loop, s.
    pub fn servo_period_s(&self) -> f64 {
        self.cycles.servo().period_s()
    }

    /// Unit of the axis' positions.
    pub fn unit(&self) -> AxisUnit {
        self.transmission.unit()
    }

    /// The load as the motor's shaft sees it.
    pub fn reflected_load(&self) -> Reflected {
        self.load.reflected(&self.transmission)
    }

    /// Inertia that turns with the motor, J_M: rotor and screw or pinion, kg m2.
    pub fn motor_side_inertia_kgm2(&self) -> f64 {
        self.motor.inertia_kgm2 + self.reflected_load().motor_side_inertia_kgm2
    }

    /// Total gap in the axis' unit (mm, deg or rad).
    pub fn gap_in_unit(&self) -> f64 {
        self.reflected_load().gap_rad / self.transmission.motor_rad_per_unit()
    }
}

impl<C: Clone> AxisConfig<C> {
    /// The same axis with a gap of zero: the baseline that shows what backlash alone causes.
    #[must_use]
    pub fn without_gap(&self) -> AxisConfig<C> {
        self.with_gap(0.0)
    }

    /// The same axis with another total gap, given in the axis' unit (mm, deg or rad).
    #[must_use]
    pub fn with_gap(&self, gap: f64) -> AxisConfig<C> {
        let gap_rad = gap * self.transmission.motor_rad_per_unit();
        AxisConfig {
            load: self.load.with_gap_motor_rad(gap_rad, &self.transmission),
            ..self.clone()
        }
    }

    /// The gains follow from the rule of [`Tuning`]; limits, encoder, delays, filters and what else
    /// the drive does stay.
    #[must_use]
    pub fn tuned(&self, tuning: &Tuning) -> AxisConfig<C> {
        let old = self.drive;
        let new = Drive::tuned(
            &self.motor,
            &self.reflected_load(),
            tuning,
            old.current_limit_a,
            old.bus_voltage_v,
        );
        // the rule sets gains only: what was configured besides them is kept
        let drive = Drive {
            encoder_counts_per_rev: old.encoder_counts_per_rev,
            current_period_us: old.current_period_us,
            voltage_delay_periods: old.voltage_delay_periods,
            command_delay_periods: old.command_delay_periods,
            friction_feedforward: old.friction_feedforward,
            torque_filter: old.torque_filter,
            anti_windup: old.anti_windup,
            least_margins: old.least_margins,
            ..new
        };
        AxisConfig {
            drive,
            ..self.clone()
        }
    }
}
