//! A change of the motor's torque at each reversal by what the friction changes there.
//!
//! ```text
//! s       sign of w_ref; |w_ref| <= 1e-6 rad/s keeps the last one
//! torque  s m/2, N m at the motor: it changes by the amount m at a reversal, m+ into the positive and m- into
//!         the negative direction
//! ```
//! What the integrator of the velocity loop would have to build up after the reversal is there at
//! once. m left out: twice the Coulomb friction of the load. It says nothing of the gap: the offset
//! stays, and the motor crosses sooner.
//!
//! Signals: reference velocity, rad/s. Settings: both amounts (N m at the motor).
//!
//! Fails: too much makes a notch of the opposite sign at the quadrants, and pushes the load where it
//! rests. The friction of a machine changes with temperature and lubrication.
//!
//! Source: Mitsubishi, lost motion compensation: SV027 bit 9, SV016 and SV041 in per cent of the
//! stall current, of which twice the friction torque is the standard.

use crate::AxisConfig;
use crate::registry::{Registered, Settings};
use crate::traverse::direction;
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, not_negative};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `friction-torque`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FrictionTorqueSettings {
    /// Amount into the positive direction (SV016), N m at the motor; twice the true Coulomb friction
    /// of the load if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amount_nm: Option<f64>,
    /// Amount into the negative direction (SV041), N m at the motor; the same if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub negative_amount_nm: Option<f64>,
}

impl Settings for FrictionTorqueSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        not_negative("amount_nm", self.amount_nm.unwrap_or(0.0))?;
        let negative = self.negative_amount_nm.unwrap_or(0.0);
        not_negative("negative_amount_nm", negative)
    }
}

/// The method `friction-torque`.
#[derive(Clone, Copy, Debug)]
pub struct FrictionTorque {
    /// Torque while moving in the positive and in the negative direction, N m.
    torque: [f64; 2],
}

/// Commanded direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrictionTorqueState {
    direction: i8,
}

impl Registered for FrictionTorque {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "friction-torque",
        summary: "known change of the friction added to the torque at each reversal",
        knows: Knowledge {
            load_scale: false,
            gap: false,
            load: true,
        },
        source: "Mitsubishi lost motion compensation, SV016 and SV041",
    };

    fn from_axis(config: &AxisConfig) -> FrictionTorque {
        let settings = &config.compensation.friction_torque;
        let friction = config.reflected_load().coulomb_nm;
        let positive = settings.amount_nm.unwrap_or(2.0 * friction);
        let negative = settings.negative_amount_nm.unwrap_or(positive);
        FrictionTorque {
            torque: [0.5 * positive, -0.5 * negative],
        }
    }
}

impl Compensator for FrictionTorque {
    type State = FrictionTorqueState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> FrictionTorqueState {
        FrictionTorqueState { direction: 0 }
    }

    #[inline]
    fn step(&self, state: &mut FrictionTorqueState, signals: &Signals) -> Correction {
        state.direction = direction(signals.reference.velocity, state.direction);
        Correction {
            torque: match state.direction {
                1 => self.torque[0],
                -1 => self.torque[1],
                _ => 0.0,
            },
            ..Correction::NONE
        }
    }
}
