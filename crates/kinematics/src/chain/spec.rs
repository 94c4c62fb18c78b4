//! A chain as a machine file describes it.

use super::{Chain, ChainJoint};
use crate::rotation::Turning;
use lostmotion_base::AxisId;
use lostmotion_base::units::rad;
use lostmotion_base::vec::{cross, dot, unit};
use serde::{Deserialize, Serialize};

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JointType {
    /// Along its direction.
    Linear,
    /// About its axis.
    Rotary,
}

/// On which side of the base a joint is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Between workpiece and base: it moves the workpiece.
    Table,
    /// Between base and tool: it moves the tool.
    Head,
}

/// `[[kinematics.joint]]`: one joint, in the order from the workpiece to the tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointSpec {
    /// Letter of the axis that moves it: `x` to `w`.
    pub axis: String,
    /// `linear` or `rotary`.
    #[serde(rename = "type")]
    pub kind: JointType,
    /// `table` or `head`; linear joints may leave it out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<Side>,
    /// Along which (about which) positive coordinates move the tool relative to the workpiece, with
    /// all joints at zero; any length.
    pub direction: [f64; 3],
    /// A point on the axis of a rotary joint with all joints at zero, machine coordinates, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point_mm: Option<[f64; 3]>,
    /// 1, or -1 if it counts against its direction; 1 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sign: Option<f64>,
    /// Position of a linear joint at which everything is at zero, mm; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero_mm: Option<f64>,
    /// Position of a rotary joint at which everything is at zero, deg; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero_deg: Option<f64>,
    /// Whether a rotary joint turns without end and takes the shortest way; false if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wrap: Option<bool>,
}

/// `[kinematics.gauge]`: the spindle with all joints at zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeSpec {
    /// Its gauge point, machine coordinates, mm; [0, 0, 0] if not given.
    #[serde(default)]
    pub point_mm: [f64; 3],
    /// From the tip of a tool to the spindle; [0, 0, 1] if not given.
    #[serde(default = "up")]
    pub axis: [f64; 3],
    /// X of the tool's frame, across the axis; [1, 0, 0] if not given.
    #[serde(default = "right")]
    pub x_axis: [f64; 3],
}

fn up() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn right() -> [f64; 3] {
    [1.0, 0.0, 0.0]
}

impl Default for GaugeSpec {
    fn default() -> GaugeSpec {
        GaugeSpec {
            point_mm: [0.0; 3],
            axis: up(),
            x_axis: right(),
        }
    }
}

fn finite(values: &[f64]) -> bool {
    values
        .iter()
        .all(|value| value.is_finite() && value.abs() <= 1e6)
}

impl Chain {
    /// From its description.
    ///
    /// # Errors
    /// The first thing that makes no sense, as a text for people.
    pub fn new(joints: &[JointSpec], gauge: &GaugeSpec) -> Result<Chain, String> {
        let mut made: Vec<ChainJoint> = Vec::new();
        for (index, spec) in joints.iter().enumerate() {
            let joint = spec
                .joint()
                .map_err(|why| format!("joint {} (`{}`): {why}", index + 1, spec.axis))?;
            // Positions are kept by letter, so one letter is one joint.
            if made.iter().any(|other| other.axis == joint.axis) {
                return Err(format!(
                    "joint {}: axis {} moves a joint already",
                    index + 1,
                    joint.axis
                ));
            }
            // The base lies between the sides: no table follows the first joint of the head.
            if joint.side == Side::Table && made.iter().any(|other| other.side == Side::Head) {
                return Err(format!(
                    "joint {} (`{}`): a joint on the table's side follows one on the head's; joints go from the workpiece to the tool",
                    index + 1,
                    spec.axis
                ));
            }
            made.push(joint);
        }
        let (Some(z), true) = (unit(gauge.axis), finite(&gauge.point_mm)) else {
            return Err(
                "the gauge's `axis` has to be a direction and its `point_mm` finite".into(),
            );
        };
        // X of the frame is what is left of the given one square to Z (Gram-Schmidt).
        let lean = dot(gauge.x_axis, z);
        let Some(x) = unit(std::array::from_fn(|i| gauge.x_axis[i] - lean * z[i])) else {
            return Err("the gauge's `x_axis` has to be a direction across its `axis`".into());
        };
        Ok(Chain {
            joints: made,
            gauge: gauge.point_mm,
            columns: [x, cross(z, x), z],
        })
    }
}

impl JointSpec {
    /// A linear joint with its zero at 0; `side` is left out.
    pub fn linear(axis: AxisId, direction: [f64; 3]) -> JointSpec {
        JointSpec {
            axis: axis.letter().to_ascii_lowercase().to_string(),
            kind: JointType::Linear,
            side: None,
            direction,
            point_mm: None,
            sign: None,
            zero_mm: None,
            zero_deg: None,
            wrap: None,
        }
    }

    /// A rotary joint with its zero at 0, about an axis through a point, mm.
    pub fn rotary(axis: AxisId, side: Side, direction: [f64; 3], point_mm: [f64; 3]) -> JointSpec {
        JointSpec {
            kind: JointType::Rotary,
            side: Some(side),
            point_mm: Some(point_mm),
            ..JointSpec::linear(axis, direction)
        }
    }

    /// The axis that moves it; `None` if `axis` is not one of the nine letters in lower case.
    pub fn axis_id(&self) -> Option<AxisId> {
        let mut letters = self.axis.chars();
        match (letters.next(), letters.next()) {
            (Some(letter), None) if letter.is_ascii_lowercase() => AxisId::from_letter(letter),
            _ => None,
        }
    }

    /// Whether it is rotary.
    pub fn is_rotary(&self) -> bool {
        self.kind == JointType::Rotary
    }

    fn joint(&self) -> Result<ChainJoint, String> {
        let axis = self
            .axis_id()
            .ok_or("`axis` has to be one of x, y, z, a, b, c, u, v, w")?;
        let rotary = self.is_rotary();
        let direction = unit(self.direction)
            .filter(|_| finite(&self.direction))
            .ok_or("`direction` has to have a length")?;
        let sign = self.sign.unwrap_or(1.0);
        // Anything else would be a scale, which belongs to the transmission.
        if sign.abs() != 1.0 {
            return Err(format!("`sign` is {sign}; it has to be 1 or -1"));
        }
        // Keys that only one of the two types of joints has.
        match (
            rotary,
            self.point_mm,
            self.zero_mm,
            self.zero_deg,
            self.wrap,
        ) {
            (true, None, ..) => {
                return Err("a rotary joint needs `point_mm`, a point on its axis".into());
            }
            (true, _, Some(_), ..) => {
                return Err("`zero_mm` is for linear joints; a rotary one has `zero_deg`".into());
            }
            (false, Some(_), ..) => return Err("a linear joint has no use for `point_mm`".into()),
            (false, _, _, Some(_), _) => {
                return Err("`zero_deg` is for rotary joints; a linear one has `zero_mm`".into());
            }
            (false, .., Some(true)) => return Err("a linear joint cannot wrap".into()),
            _ => {}
        }
        // A linear joint gives the same poses on either side of the base.
        let side = match self.side {
            Some(side) => side,
            None if rotary => {
                return Err("a rotary joint needs `side`: `table` if it turns the workpiece, `head` if it turns the tool".into());
            }
            None => Side::Head,
        };
        let (point, zero) = (
            self.point_mm.unwrap_or_default(),
            self.zero_mm.or(self.zero_deg.map(rad)).unwrap_or(0.0),
        );
        if !finite(&point) || !finite(&[zero]) {
            return Err("`point_mm` and the zero have to be finite and within 1e6".into());
        }
        Ok(ChainJoint {
            axis,
            rotary,
            side,
            point,
            sign,
            zero,
            wraps: self.wrap.unwrap_or(false),
            turning: Turning::about(direction),
        })
    }
}
