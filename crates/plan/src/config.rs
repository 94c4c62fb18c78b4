//! What the planner may do and how far it looks ahead.

use crate::PlanError;
use crate::profile::TimeLaw;
use crate::profile::refined::Refined;
use lostmotion_base::{AXES, AxisId, AxisLimits, Clock};
use serde::{Deserialize, Serialize};

/// How much trouble the planner takes over the time of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// As fast as programs are read, within a few per cent of the shortest time.
    #[default]
    Fast,
    /// Nearly the shortest time that the limits allow.
    Optimal,
}

impl Quality {
    /// What plans the time between states that the look-ahead is sure of.
    pub(crate) fn law(self) -> &'static dyn TimeLaw {
        match self {
            Quality::Fast | Quality::Optimal => &Refined,
        }
    }
}

/// Settings of a [`crate::Planner`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannerConfig {
    /// How much trouble to take over the time.
    #[serde(default)]
    pub quality: Quality,
    /// Rate of the samples.
    pub clock: Clock,
    /// Limits of each joint, by axis index; `None` for a joint that the machine does not have.
    pub limits: [Option<AxisLimits>; AXES],
    /// Tolerance of G64 without P, mm.
    pub default_tolerance_mm: f64,
    /// Distance from the path within which even G61 rounds the steps of curvature between tangent
    /// curves (a line that runs into an arc) and tangent breaks below `exact_path_angle_deg`, mm. A
    /// tenth of a micrometre is below any encoder and keeps the jerk finite without stopping.
    pub exact_path_tolerance_mm: f64,
    /// Largest change of direction that G61 takes for rounding in the program and passes without a
    /// stop, degrees.
    pub exact_path_angle_deg: f64,
    /// How many pieces of path may wait for the look-ahead; the memory that a program takes.
    pub window_pieces: usize,
    /// How many stretches of constant demand may wait for the look-ahead.
    pub window_intervals: usize,
}

impl PlannerConfig {
    /// Usual settings for a machine with these limits.
    ///
    /// ```
    /// use lostmotion_plan::PlannerConfig;
    ///
    /// let mut config = PlannerConfig::new([None; 9]);
    /// config.default_tolerance_mm = -0.01;
    /// let refused = config.check().unwrap_err().to_string();
    /// assert!(refused.contains("default_tolerance_mm") && refused.contains("-0.01"));
    /// ```
    pub fn new(limits: [Option<AxisLimits>; AXES]) -> PlannerConfig {
        PlannerConfig {
            quality: Quality::Fast,
            clock: Clock::CNC,
            limits,
            default_tolerance_mm: 0.01,
            exact_path_tolerance_mm: 1e-4,
            exact_path_angle_deg: 0.1,
            window_pieces: 4096,
            window_intervals: 2048,
        }
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// The first one that makes no sense.
    pub fn check(&self) -> Result<(), PlanError> {
        for (joint, limits) in AxisId::ALL.into_iter().zip(&self.limits) {
            if let Some(limits) = limits {
                limits
                    .check()
                    .map_err(|source| PlanError::Limits { joint, source })?;
            }
        }
        let positive = "positive";
        let settings = [
            (
                "default_tolerance_mm",
                self.default_tolerance_mm,
                self.default_tolerance_mm > 0.0,
                positive,
            ),
            (
                "exact_path_tolerance_mm",
                self.exact_path_tolerance_mm,
                self.exact_path_tolerance_mm > 0.0,
                positive,
            ),
            (
                "exact_path_angle_deg",
                self.exact_path_angle_deg,
                (0.0..=10.0).contains(&self.exact_path_angle_deg),
                "from 0 to 10",
            ),
            (
                "window_pieces",
                self.window_pieces as f64,
                self.window_pieces >= 64,
                "64 or more",
            ),
            (
                "window_intervals",
                self.window_intervals as f64,
                self.window_intervals >= 64,
                "64 or more",
            ),
        ];
        match settings
            .into_iter()
            .find(|(_, value, good, _)| !(value.is_finite() && *good))
        {
            Some((what, value, _, condition)) => Err(PlanError::Setting {
                what,
                value,
                condition,
            }),
            None => Ok(()),
        }
    }
}
