//! The parts of a machine file that are plain values: positions, work offsets, homes, tools,
//! planner, verdict.

use crate::control::{Control, PathStops};
use lostmotion_base::units::rad;
use lostmotion_base::{AxisId, Coords};
use serde::{Deserialize, Serialize};

fn is_zero(value: &f64) -> bool {
    value.to_bits() == 0
}

/// A position: the axes that are left out are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Position {
    /// X, mm.
    #[serde(skip_serializing_if = "is_zero")]
    pub x_mm: f64,
    /// Y, mm.
    #[serde(skip_serializing_if = "is_zero")]
    pub y_mm: f64,
    /// Z, mm.
    #[serde(skip_serializing_if = "is_zero")]
    pub z_mm: f64,
    /// A, deg.
    #[serde(skip_serializing_if = "is_zero")]
    pub a_deg: f64,
    /// B, deg.
    #[serde(skip_serializing_if = "is_zero")]
    pub b_deg: f64,
    /// C, deg.
    #[serde(skip_serializing_if = "is_zero")]
    pub c_deg: f64,
    /// U, mm.
    #[serde(skip_serializing_if = "is_zero")]
    pub u_mm: f64,
    /// V, mm.
    #[serde(skip_serializing_if = "is_zero")]
    pub v_mm: f64,
    /// W, mm.
    #[serde(skip_serializing_if = "is_zero")]
    pub w_mm: f64,
}

impl Position {
    /// In mm and rad.
    pub fn coords(&self) -> Coords {
        let deg = [self.a_deg, self.b_deg, self.c_deg].map(rad);
        Coords([
            self.x_mm, self.y_mm, self.z_mm, deg[0], deg[1], deg[2], self.u_mm, self.v_mm,
            self.w_mm,
        ])
    }

    /// The axes that are not 0.
    pub(super) fn named(&self) -> impl Iterator<Item = AxisId> {
        let coords = self.coords();
        AxisId::ALL
            .into_iter()
            .filter(move |axis| coords[*axis].abs() > 0.0)
    }
}

fn is_origin(position: &Position) -> bool {
    *position == Position::default()
}

/// Origins of the work coordinate systems in machine coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(missing_docs, reason = "the keys are the G-codes")]
pub struct WorkOffsets {
    #[serde(skip_serializing_if = "is_origin")]
    pub g54: Position,
    #[serde(skip_serializing_if = "is_origin")]
    pub g55: Position,
    #[serde(skip_serializing_if = "is_origin")]
    pub g56: Position,
    #[serde(skip_serializing_if = "is_origin")]
    pub g57: Position,
    #[serde(skip_serializing_if = "is_origin")]
    pub g58: Position,
    #[serde(skip_serializing_if = "is_origin")]
    pub g59: Position,
    #[serde(skip_serializing_if = "is_origin")]
    pub g59_1: Position,
    #[serde(skip_serializing_if = "is_origin")]
    pub g59_2: Position,
    #[serde(skip_serializing_if = "is_origin")]
    pub g59_3: Position,
}

impl WorkOffsets {
    /// Keys in the order of the systems.
    pub const KEYS: [&'static str; 9] = [
        "g54", "g55", "g56", "g57", "g58", "g59", "g59_1", "g59_2", "g59_3",
    ];

    /// All nine in order, G54 first.
    pub fn all(&self) -> [Position; 9] {
        [
            self.g54, self.g55, self.g56, self.g57, self.g58, self.g59, self.g59_1, self.g59_2,
            self.g59_3,
        ]
    }
}

/// Where G28 and G30 go, machine coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Homes {
    /// G28.
    pub g28: Position,
    /// G30.
    pub g30: Position,
}

/// One tool.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolEntry {
    /// Number that T and H name.
    pub number: u32,
    /// Length from the spindle's gauge line to the tip, mm.
    pub length_mm: f64,
    /// Diameter, mm.
    #[serde(default)]
    pub diameter_mm: f64,
}

fn is_never(stops: &PathStops) -> bool {
    *stops == PathStops::Never
}

/// What the planner is told.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlannerSettings {
    /// How far the planner may leave the path under G64 without P, mm.
    pub default_tolerance_mm: f64,
    /// Distance from the path within which even G61 rounds what cannot be driven exactly, mm.
    pub exact_path_tolerance_mm: f64,
    /// Largest change of direction that G61 passes without a stop, deg.
    pub exact_path_angle_deg: f64,
    /// Where the path comes to rest besides where the program asks for it.
    #[serde(skip_serializing_if = "is_never")]
    pub stops: PathStops,
}

impl Default for PlannerSettings {
    fn default() -> PlannerSettings {
        PlannerSettings {
            default_tolerance_mm: 0.01,
            exact_path_tolerance_mm: 1e-4,
            exact_path_angle_deg: 0.1,
            stops: PathStops::Never,
        }
    }
}

/// How far the tool may be off its way between two commands without a warning, um, where neither the
/// machine nor the run names a limit. A choice: a quarter of the usual tolerance.
pub const BOW_LIMIT_UM: f64 = 5.0;

/// Defaults of `simulate`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SimulateSettings {
    /// Tolerance of the verdict on the contour error, um.
    pub tolerance_um: f64,
    /// Size of the cutting force, N: on every feed move, against the tool's way through the part.
    /// 0: none.
    #[serde(skip_serializing_if = "is_zero")]
    pub cutting_force_n: f64,
    /// How far the tool may be off its way between two commands that are joined by straight lines
    /// of the joints, um. If it is given, or a drive does join commands so, the planner keeps it;
    /// else there is a warning beyond [`BOW_LIMIT_UM`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bow_limit_um: Option<f64>,
    /// The control of the machine, among whose functions a method is recommended; any method on the
    /// motor if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub control: Option<Control>,
}

impl Default for SimulateSettings {
    fn default() -> SimulateSettings {
        SimulateSettings {
            tolerance_um: 20.0,
            cutting_force_n: 0.0,
            bow_limit_um: None,
            control: None,
        }
    }
}
