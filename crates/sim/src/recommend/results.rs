//! What is said about the settings of a control, as data.

use crate::results::{ErrorStats, MisledResult, Trust};
use serde::{Deserialize, Serialize};

/// Version of the JSON form of [`ControlSettings`].
pub const SETTINGS_SCHEMA_VERSION: u32 = 1;

/// Answer of `recommend`: what to set on a control, and what it does to a program.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ControlSettings {
    /// Version of this form, 1.
    pub schema: u32,
    /// File name of the program as given.
    pub program: String,
    /// Machine name.
    pub machine: String,
    /// Name of the control.
    pub control: String,
    /// Tolerance of the verdict, um.
    pub tolerance_um: f64,
    /// The method of compensation that stands for the control's function; `None` where nothing is
    /// recommended.
    pub method: Option<String>,
    /// How it is set, where an amount was sought by simulation.
    pub chosen: String,
    /// Why nothing is recommended, if nothing is.
    pub refused: Option<String>,
    /// The parameters.
    pub settings: Vec<ControlSetting>,
    /// The parameters as the control takes them, line by line.
    pub paste: Vec<String>,
    /// What has to be true for them to work as simulated.
    pub preconditions: Vec<String>,
    /// Remarks: what is not known, not simulated, or not printed.
    pub notes: Vec<String>,
    /// Where the parameters' meaning comes from.
    pub source: String,
    /// Contour error of cutting moves without compensation, um.
    pub before: ErrorStats,
    /// The same with the settings, um.
    pub after: ErrorStats,
    /// The machine without a gap and without compensation: the best that any setting can reach, um.
    pub without_gap: ErrorStats,
    /// Within tolerance with the settings; false where nothing is recommended and the machine
    /// without compensation is outside.
    pub within_tolerance: bool,
    /// How far off the gap may be, as a part of it: the largest of all axes; `None` where neither the
    /// machine description nor the caller says it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_uncertainty: Option<f64>,
    /// What is left where the true gap lies at an end of its interval; empty where the machine
    /// description does not say how well it is known.
    pub uncertain: Vec<GapEnd>,
    /// What is left where the gap was measured wrong, or another quantity told wrong.
    pub wrong: Vec<MisledResult>,
    /// How well the axes would have to be known for the settings to be recommended, where they are
    /// not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trust: Option<Trust>,
    /// What other methods would leave, which this control does not have.
    pub better: Vec<Better>,
    /// How many simulations of the program this rests on.
    pub runs: u64,
}

/// A parameter of a control.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ControlSetting {
    /// Its name or number in the control's manual.
    pub name: String,
    /// The axis, `Y2` for the second motor of a gantry; empty where it is of the whole control.
    pub axis: String,
    /// Its value as the control takes it, with its sign.
    pub value: String,
    /// Unit of the value.
    pub unit: String,
    /// What it does.
    pub meaning: String,
}

/// What is left where the gap is in truth as small or large as it may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct GapEnd {
    /// True gap over the one of the machine description.
    pub factor: f64,
    /// Contour error of cutting moves without compensation, um.
    pub before: ErrorStats,
    /// The same with the settings, um.
    pub after: ErrorStats,
    /// Whether the control stops the machine with the settings.
    pub stops: bool,
}

/// What a method would leave that the control does not have.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct Better {
    /// The method.
    pub method: String,
    /// Contour error of cutting moves, um.
    pub cutting: ErrorStats,
    /// Whether the control stops the machine with it.
    pub stops: bool,
}

impl ControlSettings {
    /// Whether there is something to set, and it keeps the tolerance.
    pub fn is_within_tolerance(&self) -> bool {
        self.method.is_some() && self.within_tolerance
    }
}
