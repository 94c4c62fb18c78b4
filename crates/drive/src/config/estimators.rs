//! Settings of the methods that estimate the gap by filters, every field with a default.

use super::compensation::Gap;
use super::error::{AxisConfigError, between, not_negative, positive};
use super::transmission::Transmission;
use serde::{Deserialize, Serialize};

/// Settings of `kalman`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct KalmanSettings {
    /// Standard deviation of the torques that the model does not explain, as part of the rated
    /// torque.
    pub torque_noise_share: f64,
    /// Standard deviation of the unknown gap at the start, as a total gap; a two-hundredth of a
    /// turn of the motor if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_spread: Option<Gap>,
    /// How far the half gap may wander, as a part of its spread at the start per square root of s.
    pub wandering_share: f64,
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
}

impl Default for KalmanSettings {
    fn default() -> KalmanSettings {
        KalmanSettings {
            torque_noise_share: 2e-3,
            gap_spread: None,
            wandering_share: 1e-3,
            torque_share: 0.5,
        }
    }
}

impl KalmanSettings {
    pub(super) fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        check(
            self.torque_noise_share,
            self.gap_spread,
            self.wandering_share,
            self.torque_share,
            transmission,
        )
    }
}

/// Settings of `multiple-models`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MultipleModelsSettings {
    /// Standard deviation of the torques that the models do not explain, as part of the rated
    /// torque.
    pub torque_noise_share: f64,
    /// Standard deviation of the unknown gap at the start, as a total gap; a two-hundredth of a
    /// turn of the motor if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_spread: Option<Gap>,
    /// How far the half gap may wander, as a part of its spread at the start per square root of s.
    pub wandering_share: f64,
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
    /// Probability that contact is made or broken within a tick of 250 us, above 0 to 0.5.
    pub change_per_tick: f64,
}

impl Default for MultipleModelsSettings {
    fn default() -> MultipleModelsSettings {
        MultipleModelsSettings {
            torque_noise_share: 0.015,
            gap_spread: None,
            wandering_share: 1e-3,
            torque_share: 0.5,
            change_per_tick: 3e-4,
        }
    }
}

impl MultipleModelsSettings {
    pub(super) fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        between("change_per_tick", self.change_per_tick, 1e-9, 0.5)?;
        check(
            self.torque_noise_share,
            self.gap_spread,
            self.wandering_share,
            self.torque_share,
            transmission,
        )
    }
}

fn check(
    noise: f64,
    spread: Option<Gap>,
    wandering: f64,
    share: f64,
    transmission: &Transmission,
) -> Result<(), AxisConfigError> {
    between("torque_noise_share", noise, 1e-9, 1.0)?;
    if let Some(gap) = spread {
        gap.check(transmission)
            .map_err(|e| e.within("gap_spread"))?;
        positive("gap_spread", gap.motor_rad(transmission))?;
    }
    not_negative("wandering_share", wandering)?;
    between("torque_share", share, 0.01, 1.0)
}
