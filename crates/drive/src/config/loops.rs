//! What a drive's loops do besides their gains: friction feed-forward, anti-windup, and the margins
//! asked of them.

use super::check::{AxisConfigError, not_negative, positive};
use serde::{Deserialize, Serialize};

/// Torque fed forward against friction: `coulomb w/sqrt(w^2 + smoothing^2) + viscous w`, w the
/// reference's mean velocity over the coming servo period, rad/s at the motor.
///
/// The smoothing keeps the torque from jumping at a reversal: at `w = smoothing` it is 71 % of the
/// Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionFeedforward {
    /// Coulomb friction that the drive was told, N m at the motor.
    pub coulomb_nm: f64,
    /// Viscous friction that the drive was told, N m s/rad at the motor.
    #[serde(default)]
    pub viscous_nm_s_per_rad: f64,
    /// Velocity over which the sign is smoothed, rad/s at the motor.
    #[serde(default = "smoothing_rad_s")]
    pub smoothing_rad_s: f64,
}

fn smoothing_rad_s() -> f64 {
    0.1
}

impl FrictionFeedforward {
    pub(super) fn check(&self) -> Result<(), AxisConfigError> {
        not_negative("friction_feedforward.coulomb_nm", self.coulomb_nm)?;
        not_negative(
            "friction_feedforward.viscous_nm_s_per_rad",
            self.viscous_nm_s_per_rad,
        )?;
        positive("friction_feedforward.smoothing_rad_s", self.smoothing_rad_s)
    }
}

/// What the velocity loop's integral does while the current command is cut at its limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AntiWindup {
    /// Back-calculation: a command cut by `delta` moves the integral by `delta` times period over
    /// integral time, so the tracking time is the integral time. While the voltage is at its limit
    /// the integral takes up no error that asks for still more torque. Source: Astrom and
    /// Haegglund, *Advanced PID Control* (2006), section 3.5.
    #[default]
    BackCalculation,
    /// Conditional integration: while current or voltage is at its limit the integral takes up no
    /// error that asks for still more torque.
    Conditional,
    /// None: the integral goes on. For showing what the others are there for.
    None,
}

/// Margins below which [`crate::analysis`] calls a loop badly tuned.
///
/// The defaults are low: they refuse what is about to oscillate, not what a commissioning engineer
/// would do better.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeastMargins {
    /// Phase margin, deg.
    #[serde(default = "phase_deg")]
    pub phase_deg: f64,
    /// Gain margin, dB.
    #[serde(default = "gain_db")]
    pub gain_db: f64,
}

fn phase_deg() -> f64 {
    15.0
}

fn gain_db() -> f64 {
    3.0
}

impl Default for LeastMargins {
    fn default() -> LeastMargins {
        LeastMargins {
            phase_deg: phase_deg(),
            gain_db: gain_db(),
        }
    }
}

impl LeastMargins {
    pub(super) fn check(&self) -> Result<(), AxisConfigError> {
        not_negative("least_margins.phase_deg", self.phase_deg)?;
        not_negative("least_margins.gain_db", self.gain_db)
    }

    /// Whether these are the defaults.
    pub fn is_default(&self) -> bool {
        *self == LeastMargins::default()
    }
}

impl AntiWindup {
    /// Whether this is the default.
    pub fn is_default(&self) -> bool {
        *self == AntiWindup::default()
    }
}
