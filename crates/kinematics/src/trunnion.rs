//! Tilting rotary table under a spindle that does not turn, with tool-centre-point control: X Y Z
//! are the tool tip in the part's frame, whatever the table does. A short description of one kind
//! of [`chain`](crate::chain).
//!
//! With T the tip in the part's frame, L the tool's offset, O the rotation point (where C's axis
//! meets the table when everything is at zero), D the way from there to the tilting axis, and s = 1
//! for conventional directions, -1 for reversed ones,
//!
//! J = L + O + D + R(-s tilt) [Rz(-s C) (T - O) - D]
//!
//! R turning about X (`trunnion-ac`, D = (0, dy, dz)) or Y (`trunnion-bc`, D = (dx, 0, dz)). These
//! are LinuxCNC's `xyzac-trt` and `xyzbc-trt`, which write the same with P = T + L and dz including
//! the tool's length; s = -1 is their default. Conventional means that a positive program angle
//! turns the tool counter-clockwise about the axis as seen from the part, so the table turns
//! clockwise (ISO 841). U, V and W are passed through.

use crate::chain::{Chain, GaugeSpec, JointSpec, Side};
use crate::kind::finite;
use crate::machine_tool::MachineTool;
use crate::serial::orientation_tolerance;
use crate::{KindSpec, Kinematics, Reach, TipControl};
use lostmotion_base::AxisId;
use serde::{Deserialize, Serialize};

/// Describes a table that tilts about X (A), with C on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrunnionAcSpec {
    /// Where the axis of C meets the table with all axes at zero, machine coordinates, mm.
    pub rotation_point_mm: [f64; 3],
    /// From the rotation point to the tilting axis along Y, mm; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_y_mm: Option<f64>,
    /// From the rotation point to the tilting axis along Z, mm; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_z_mm: Option<f64>,
    /// Whether positive angles turn the tool counter-clockwise as seen from the part (ISO 841);
    /// true if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conventional_directions: Option<bool>,
    /// When X Y Z are the tool's tip: `always` or `programmed`; `always` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_control: Option<TipControl>,
    /// How far the tool's direction may leave the programmed one while it turns, deg; 0.1 if not
    /// given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation_tolerance_deg: Option<f64>,
}

/// Describes a table that tilts about Y (B), with C on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrunnionBcSpec {
    /// Where the axis of C meets the table with all axes at zero, machine coordinates, mm.
    pub rotation_point_mm: [f64; 3],
    /// From the rotation point to the tilting axis along X, mm; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_x_mm: Option<f64>,
    /// From the rotation point to the tilting axis along Z, mm; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_z_mm: Option<f64>,
    /// Whether positive angles turn the tool counter-clockwise as seen from the part (ISO 841);
    /// true if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conventional_directions: Option<bool>,
    /// When X Y Z are the tool's tip: `always` or `programmed`; `always` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_control: Option<TipControl>,
    /// How far the tool's direction may leave the programmed one while it turns, deg; 0.1 if not
    /// given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation_tolerance_deg: Option<f64>,
}

impl KindSpec for TrunnionAcSpec {
    const SUMMARY: &'static str = "table tilting about X (A) with C on it, tool-centre-point";

    fn build(&self, reach: &Reach) -> Result<Box<dyn Kinematics>, String> {
        let (y, z) = (
            self.offset_y_mm.unwrap_or(0.0),
            self.offset_z_mm.unwrap_or(0.0),
        );
        finite("offset_y_mm", &[y])?;
        let table = TiltingTable {
            tilt: AxisId::A,
            about: [1.0, 0.0, 0.0],
            point: self.rotation_point_mm,
            offset: [0.0, y, z],
            conventional: self.conventional_directions.unwrap_or(true),
        };
        let tolerance = orientation_tolerance(self.orientation_tolerance_deg)?;
        table.machine(TrunnionAcSpec::KIND, reach, tolerance)
    }

    fn tip_control(&self) -> TipControl {
        self.tip_control.unwrap_or_default()
    }
}

impl KindSpec for TrunnionBcSpec {
    const SUMMARY: &'static str = "table tilting about Y (B) with C on it, tool-centre-point";

    fn build(&self, reach: &Reach) -> Result<Box<dyn Kinematics>, String> {
        let (x, z) = (
            self.offset_x_mm.unwrap_or(0.0),
            self.offset_z_mm.unwrap_or(0.0),
        );
        finite("offset_x_mm", &[x])?;
        let table = TiltingTable {
            tilt: AxisId::B,
            about: [0.0, 1.0, 0.0],
            point: self.rotation_point_mm,
            offset: [x, 0.0, z],
            conventional: self.conventional_directions.unwrap_or(true),
        };
        let tolerance = orientation_tolerance(self.orientation_tolerance_deg)?;
        table.machine(TrunnionBcSpec::KIND, reach, tolerance)
    }

    fn tip_control(&self) -> TipControl {
        self.tip_control.unwrap_or_default()
    }
}

/// Both kinds of tables.
struct TiltingTable {
    /// The tilting axis and its direction.
    tilt: AxisId,
    about: [f64; 3],
    /// Rotation point O, mm.
    point: [f64; 3],
    /// D, from O to the tilting axis, mm.
    offset: [f64; 3],
    conventional: bool,
}

impl TiltingTable {
    /// The chain of C, the tilt and three slides as a machine tool.
    fn machine(
        &self,
        kind: &'static str,
        reach: &Reach,
        tolerance_rad: f64,
    ) -> Result<Box<dyn Kinematics>, String> {
        finite("rotation_point_mm", &self.point)?;
        finite("offset_z_mm", &self.offset[2..])?;
        let sign = Some(if self.conventional { 1.0 } else { -1.0 });
        let rotary = |axis, direction, point_mm| JointSpec {
            sign,
            ..JointSpec::rotary(axis, Side::Table, direction, point_mm)
        };
        // The workpiece lies on C, C on the tilting table; the slides carry the spindle.
        let on_tilt = std::array::from_fn(|i| self.point[i] + self.offset[i]);
        let joints = [
            rotary(AxisId::C, [0.0, 0.0, 1.0], self.point),
            rotary(self.tilt, self.about, on_tilt),
            JointSpec::linear(AxisId::X, [1.0, 0.0, 0.0]),
            JointSpec::linear(AxisId::Y, [0.0, 1.0, 0.0]),
            JointSpec::linear(AxisId::Z, [0.0, 0.0, 1.0]),
        ];
        let chain = Chain::new(&joints, &GaugeSpec::default())?;
        let machine = MachineTool::new(kind, chain, reach, tolerance_rad)?;
        Ok(Box::new(machine))
    }
}
