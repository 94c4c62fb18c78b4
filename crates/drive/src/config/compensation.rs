//! Settings of the compensators: one table per method, every field with a default.

use super::classic::{
    AdaptiveInverseSettings, DisturbanceObserverSettings, FittedLookupSettings, FixedFanucSettings,
    FixedLinuxcncSettings, IterativeLearningSettings, ReversalPulseSettings,
};
use super::error::{AxisConfigError, between, not_negative, positive};
use super::estimators::{KalmanSettings, MultipleModelsSettings};
use super::table::ARCSEC_PER_DEG;
use super::transmission::{AxisUnit, Transmission};
use serde::{Deserialize, Serialize};

/// A total gap in the unit that suits whoever tells it: `{ um = 10.0 }`, `{ mdeg = 3.0 }`,
/// `{ arcsec = 11.0 }`, `{ deg = 0.003 }` or `{ motor_rad = 0.2 }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gap {
    /// Micrometre at the slide.
    Um(f64),
    /// Millidegree at the table.
    Mdeg(f64),
    /// Second of arc at the table.
    Arcsec(f64),
    /// Degree at the table.
    Deg(f64),
    /// Radian at the motor's shaft.
    MotorRad(f64),
}

impl Gap {
    /// Checks the value and that the unit suits the axis.
    ///
    /// # Errors
    /// A negative or non-finite gap, micrometres on a rotary axis, an angle on a linear one.
    pub fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        let linear = transmission.unit() == AxisUnit::Mm;
        let (key, value, fits) = match *self {
            Gap::Um(value) => ("um", value, linear),
            Gap::Mdeg(value) => ("mdeg", value, !linear),
            Gap::Arcsec(value) => ("arcsec", value, !linear),
            Gap::Deg(value) => ("deg", value, !linear),
            Gap::MotorRad(value) => ("motor_rad", value, true),
        };
        if !fits {
            return Err(AxisConfigError::Mismatch {
                key: key.to_owned(),
                reason: format!("the axis is in {}", transmission.unit().symbol()),
                hint: "give the gap as um on a linear axis, arcsec, mdeg or deg on a rotary one, or motor_rad".to_owned(),
            });
        }
        not_negative(key, value)
    }

    /// The gap in rad at the motor's shaft.
    pub fn motor_rad(&self, transmission: &Transmission) -> f64 {
        let ratio = transmission.load_per_motor_rad();
        match *self {
            Gap::Um(um) => um * 1e-6 / ratio,
            Gap::Mdeg(mdeg) => (mdeg * 1e-3).to_radians() / ratio,
            Gap::Arcsec(arcsec) => (arcsec / ARCSEC_PER_DEG).to_radians() / ratio,
            Gap::Deg(deg) => deg.to_radians() / ratio,
            Gap::MotorRad(rad) => rad,
        }
    }
}

/// Settings of `fixed`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedSettings {
    /// Total gap that the control was told; the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Time over which the correction goes from one side to the other, ms.
    pub ramp_ms: f64,
}

impl Default for FixedSettings {
    fn default() -> FixedSettings {
        FixedSettings {
            gap: None,
            ramp_ms: 15.0,
        }
    }
}

/// Settings of `published` and `published-literal`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PublishedSettings {
    /// Threshold of the inertia: J_min = J_M/(1 - lambda), 0 < lambda < 1. It has to be below 1 -
    /// J_M/(J_M + J_L). If left out: 0.775 of that bound, which makes 0.60 on the paper's axis; who
    /// commissions an axis would choose it so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lambda: Option<f64>,
    /// Initial covariance P0 = p0 I of the recursive least squares (angles in rad, current in A).
    pub p0: f64,
    /// A reference acceleration no larger than this counts as zero, rad/s2 at the motor. The paper
    /// compares with exact zero; a spline of floating-point setpoints leaves rounding where the
    /// acceleration is meant to be zero.
    pub acceleration_zero_rad_s2: f64,
}

impl Default for PublishedSettings {
    fn default() -> PublishedSettings {
        PublishedSettings {
            lambda: None,
            p0: 300.0,
            acceleration_zero_rad_s2: 1e-3,
        }
    }
}

/// Settings of `lookup`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LookupSettings {
    /// Total gap that the drive was told; the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
    /// Part of the shaft's wind-up that is added to the reference, 0 to 1.
    pub wind_up: f64,
}

impl Default for LookupSettings {
    fn default() -> LookupSettings {
        LookupSettings {
            gap: None,
            torque_share: 0.5,
            wind_up: 0.0,
        }
    }
}

/// Settings of `adaptive`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdaptiveSettings {
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
}

impl Default for AdaptiveSettings {
    fn default() -> AdaptiveSettings {
        AdaptiveSettings { torque_share: 0.5 }
    }
}

fn is_default<T: Default + PartialEq>(settings: &T) -> bool {
    *settings == T::default()
}

/// The compensator of an axis: which method it uses by itself, and the settings of each method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CompensationConfig {
    /// Registered name of the method that the axis uses when nothing else is asked for.
    pub method: String,
    /// Whether the drive estimates stiffness and damping of its shaft while it runs, whatever the
    /// method; it changes nothing but traces.
    #[serde(skip_serializing_if = "is_default")]
    pub estimate_shaft: bool,
    /// Settings of `fixed`.
    pub fixed: FixedSettings,
    /// Settings of `published` and `published-literal`.
    pub published: PublishedSettings,
    /// Settings of `fixed-linuxcnc`.
    #[serde(skip_serializing_if = "is_default")]
    pub fixed_linuxcnc: FixedLinuxcncSettings,
    /// Settings of `fixed-fanuc`.
    #[serde(skip_serializing_if = "is_default")]
    pub fixed_fanuc: FixedFanucSettings,
    /// Settings of `adaptive-inverse`.
    #[serde(skip_serializing_if = "is_default")]
    pub adaptive_inverse: AdaptiveInverseSettings,
    /// Settings of `disturbance-observer`.
    #[serde(skip_serializing_if = "is_default")]
    pub disturbance_observer: DisturbanceObserverSettings,
    /// Settings of `iterative-learning`.
    #[serde(skip_serializing_if = "is_default")]
    pub iterative_learning: IterativeLearningSettings,
    /// Settings of `kalman`.
    #[serde(skip_serializing_if = "is_default")]
    pub kalman: KalmanSettings,
    /// Settings of `multiple-models`.
    #[serde(skip_serializing_if = "is_default")]
    pub multiple_models: MultipleModelsSettings,
    /// Settings of `fitted-lookup`.
    #[serde(skip_serializing_if = "is_default")]
    pub fitted_lookup: FittedLookupSettings,
    /// Settings of `reversal-pulse`.
    #[serde(skip_serializing_if = "is_default")]
    pub reversal_pulse: ReversalPulseSettings,
    /// Settings of `lookup`.
    #[serde(skip_serializing_if = "is_default")]
    pub lookup: LookupSettings,
    /// Settings of `adaptive`.
    #[serde(skip_serializing_if = "is_default")]
    pub adaptive: AdaptiveSettings,
}

impl Default for CompensationConfig {
    fn default() -> CompensationConfig {
        CompensationConfig {
            method: "none".to_owned(),
            estimate_shaft: false,
            fixed: FixedSettings::default(),
            published: PublishedSettings::default(),
            fixed_linuxcnc: FixedLinuxcncSettings::default(),
            fixed_fanuc: FixedFanucSettings::default(),
            adaptive_inverse: AdaptiveInverseSettings::default(),
            disturbance_observer: DisturbanceObserverSettings::default(),
            iterative_learning: IterativeLearningSettings::default(),
            kalman: KalmanSettings::default(),
            multiple_models: MultipleModelsSettings::default(),
            fitted_lookup: FittedLookupSettings::default(),
            reversal_pulse: ReversalPulseSettings::default(),
            lookup: LookupSettings::default(),
            adaptive: AdaptiveSettings::default(),
        }
    }
}

impl CompensationConfig {
    /// Checks the settings of every method, whichever is used.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        if let Some(gap) = &self.fixed.gap {
            gap.check(transmission).map_err(|e| e.within("fixed.gap"))?;
        }
        between("fixed.ramp_ms", self.fixed.ramp_ms, 0.0, 10_000.0)?;
        if let Some(lambda) = self.published.lambda {
            between("published.lambda", lambda, 1e-6, 1.0 - 1e-6)?;
        }
        if let Some(gap) = &self.lookup.gap {
            gap.check(transmission)
                .map_err(|e| e.within("lookup.gap"))?;
        }
        between("lookup.torque_share", self.lookup.torque_share, 0.01, 1.0)?;
        self.fixed_linuxcnc
            .check(transmission)
            .map_err(|e| e.within("fixed_linuxcnc"))?;
        self.fixed_fanuc
            .check(transmission)
            .map_err(|e| e.within("fixed_fanuc"))?;
        self.adaptive_inverse
            .check(transmission)
            .map_err(|e| e.within("adaptive_inverse"))?;
        self.disturbance_observer
            .check()
            .map_err(|e| e.within("disturbance_observer"))?;
        self.iterative_learning
            .check()
            .map_err(|e| e.within("iterative_learning"))?;
        self.kalman
            .check(transmission)
            .map_err(|e| e.within("kalman"))?;
        self.multiple_models
            .check(transmission)
            .map_err(|e| e.within("multiple_models"))?;
        self.fitted_lookup
            .check(transmission)
            .map_err(|e| e.within("fitted_lookup"))?;
        self.reversal_pulse
            .check()
            .map_err(|e| e.within("reversal_pulse"))?;
        between(
            "adaptive.torque_share",
            self.adaptive.torque_share,
            0.01,
            1.0,
        )?;
        between("lookup.wind_up", self.lookup.wind_up, 0.0, 1.0)?;
        positive("published.p0", self.published.p0)?;
        not_negative(
            "published.acceleration_zero_rad_s2",
            self.published.acceleration_zero_rad_s2,
        )
    }
}
