//! Settings of the methods that controls and textbooks have, one table per method, every field with
//! a default.

use super::compensation::Gap;
use super::error::{AxisConfigError, between, finite, not_negative, positive};
use super::transmission::Transmission;
use serde::{Deserialize, Serialize};

fn told(key: &str, gap: Option<Gap>, transmission: &Transmission) -> Result<(), AxisConfigError> {
    gap.map_or(Ok(()), |gap| {
        gap.check(transmission).map_err(|e| e.within(key))
    })
}

/// Settings of `fixed-linuxcnc`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedLinuxcncSettings {
    /// Total gap that the control was told (BACKLASH); the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// The joint's limit of velocity, of which half is used: mm, deg or rad per s. None if left
    /// out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_units_s: Option<f64>,
    /// The joint's limit of acceleration, of which half is used: mm, deg or rad per s2. What the
    /// rated torque gives the whole axis if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_units_s2: Option<f64>,
}

impl FixedLinuxcncSettings {
    pub(super) fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        positive("velocity_units_s", self.velocity_units_s.unwrap_or(1.0))?;
        positive(
            "acceleration_units_s2",
            self.acceleration_units_s2.unwrap_or(1.0),
        )
    }
}

/// Settings of `fixed-fanuc`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedFanucSettings {
    /// Total gap for cutting (parameter 1851); the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutting: Option<Gap>,
    /// Total gap for rapid traverse (parameter 1852); that for cutting if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rapid: Option<Gap>,
    /// Speed of the axis from which on a motion counts as rapid: mm, deg or rad per s.
    pub rapid_above_units_s: f64,
    /// Time over which the correction goes from one amount to another, ms.
    pub ramp_ms: f64,
}

impl Default for FixedFanucSettings {
    fn default() -> FixedFanucSettings {
        FixedFanucSettings {
            cutting: None,
            rapid: None,
            rapid_above_units_s: 200.0,
            ramp_ms: 8.0,
        }
    }
}

impl FixedFanucSettings {
    pub(super) fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("cutting", self.cutting, transmission)?;
        told("rapid", self.rapid, transmission)?;
        positive("rapid_above_units_s", self.rapid_above_units_s)?;
        between("ramp_ms", self.ramp_ms, 0.0, 10_000.0)
    }
}

/// Settings of `adaptive-inverse`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdaptiveInverseSettings {
    /// Gain of the gradient, 1/s.
    pub gain_per_s: f64,
    /// Total gap beyond which nothing is learned; a turn of the motor if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest_gap: Option<Gap>,
    /// Time over which the correction goes from one side to the other, ms.
    pub ramp_ms: f64,
}

impl Default for AdaptiveInverseSettings {
    fn default() -> AdaptiveInverseSettings {
        AdaptiveInverseSettings {
            gain_per_s: 10.0,
            largest_gap: None,
            ramp_ms: 8.0,
        }
    }
}

impl AdaptiveInverseSettings {
    pub(super) fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        between("gain_per_s", self.gain_per_s, 0.0, 1e4)?;
        told("largest_gap", self.largest_gap, transmission)?;
        between("ramp_ms", self.ramp_ms, 0.0, 10_000.0)
    }
}

/// Settings of `disturbance-observer`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DisturbanceObserverSettings {
    /// Bandwidth of the observer's filter, Hz.
    pub bandwidth_hz: f64,
    /// Part of the observed torque that is cancelled, 0 to 1.
    pub share: f64,
}

impl Default for DisturbanceObserverSettings {
    fn default() -> DisturbanceObserverSettings {
        DisturbanceObserverSettings {
            bandwidth_hz: 30.0,
            share: 0.8,
        }
    }
}

impl DisturbanceObserverSettings {
    pub(super) fn check(&self) -> Result<(), AxisConfigError> {
        between("bandwidth_hz", self.bandwidth_hz, 0.1, 500.0)?;
        between("share", self.share, 0.0, 1.0)
    }
}

/// A load as a fit of the motor's signals found it, at the motor's shaft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToldLoad {
    /// Inertia, kg m2.
    pub inertia_kgm2: f64,
    /// Viscous friction, N m s/rad.
    pub viscous_nm_s_per_rad: f64,
    /// Coulomb friction, N m.
    pub coulomb_nm: f64,
    /// Constant torque against the positive direction, N m.
    pub constant_nm: f64,
}

impl ToldLoad {
    fn check(&self) -> Result<(), AxisConfigError> {
        positive("inertia_kgm2", self.inertia_kgm2)?;
        not_negative("viscous_nm_s_per_rad", self.viscous_nm_s_per_rad)?;
        not_negative("coulomb_nm", self.coulomb_nm)?;
        finite("constant_nm", self.constant_nm)
    }
}

/// Settings of `fitted-lookup`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FittedLookupSettings {
    /// Total gap that a fit found; without one the axis is left as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Inertia and friction that it found; those of the description if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<ToldLoad>,
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
}

impl Default for FittedLookupSettings {
    fn default() -> FittedLookupSettings {
        FittedLookupSettings {
            gap: None,
            load: None,
            torque_share: 0.5,
        }
    }
}

impl FittedLookupSettings {
    pub(super) fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        self.load
            .map_or(Ok(()), |load| load.check().map_err(|e| e.within("load")))?;
        between("torque_share", self.torque_share, 0.01, 1.0)
    }
}

/// Settings of `reversal-pulse`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReversalPulseSettings {
    /// Speed at the start of the pulse, rad/s at the motor; if left out, so much that the pulse's
    /// area is the machine's true gap, or none where the pulse is one of torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_rad_s: Option<f64>,
    /// Torque at the start of the pulse, N m; none if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_nm: Option<f64>,
    /// Time in which it falls to zero, ms.
    pub time_ms: f64,
    /// From the reversal of the reference to the pulse, ms.
    pub delay_ms: f64,
}

impl Default for ReversalPulseSettings {
    fn default() -> ReversalPulseSettings {
        ReversalPulseSettings {
            speed_rad_s: None,
            torque_nm: None,
            time_ms: 20.0,
            delay_ms: 0.0,
        }
    }
}

impl ReversalPulseSettings {
    pub(super) fn check(&self) -> Result<(), AxisConfigError> {
        not_negative("speed_rad_s", self.speed_rad_s.unwrap_or(0.0))?;
        not_negative("torque_nm", self.torque_nm.unwrap_or(0.0))?;
        between("time_ms", self.time_ms, 0.25, 1000.0)?;
        between("delay_ms", self.delay_ms, 0.0, 1000.0)
    }
}

/// Settings of `iterative-learning`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IterativeLearningSettings {
    /// Part of the error that a repetition takes up, 0 to 1.
    pub rate: f64,
    /// How far ahead of the error its correction comes, ms.
    pub lead_ms: f64,
    /// Half the width of the filter's running mean, whole ms.
    pub filter_ms: f64,
    /// Strokes that are remembered, s of motion.
    pub memory_s: f64,
}

impl Default for IterativeLearningSettings {
    fn default() -> IterativeLearningSettings {
        IterativeLearningSettings {
            rate: 0.5,
            lead_ms: 4.0,
            filter_ms: 2.0,
            memory_s: 60.0,
        }
    }
}

impl IterativeLearningSettings {
    pub(super) fn check(&self) -> Result<(), AxisConfigError> {
        between("rate", self.rate, 0.0, 1.0)?;
        between("lead_ms", self.lead_ms, 0.0, 100.0)?;
        between("filter_ms", self.filter_ms, 0.0, 100.0)?;
        between("memory_s", self.memory_s, 0.0, 3600.0)
    }
}
