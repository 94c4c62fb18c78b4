//! One serial chain from the workpiece over the base to the tool.
//!
//! With all joints at their zero the tool's gauge point and frame lie at known places in machine
//! coordinates; each joint then moves everything on the tool's side of it, as seen from the
//! workpiece: linear joints along a direction, rotary ones about an axis (direction and point, also
//! at zero). The tool in the workpiece's frame is the product of exponentials
//!
//! T(q) = E1(q1) E2(q2) ... En(qn) T0,   Ei(q) = exp(xi_i s_i (q - zero_i))
//!
//! in the order from the workpiece to the tool (R. W. Brockett, 1984). s = 1 is ISO 841: a positive
//! coordinate moves the tool relative to the workpiece along (or right-handed about) the direction,
//! whichever side really moves; s = -1 is the other way round, as LinuxCNC's tables turn by
//! default. Where the base stands between the joints does not change T, only which joint carries
//! what; it is kept because it names the family of the machine.
//!
//! [`Family`] says what kind of machine a chain is.

mod spec;
pub use spec::{GaugeSpec, JointSpec, JointType, Side};

use crate::rotation::{Turning, apply};
use lostmotion_base::vec::{Vec3, add, along, constant, dot, norm, scale, sub};
use lostmotion_base::{AXES, AxisId, Coords, Real};

/// A joint of a chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainJoint {
    /// The axis that names it: where it stands in [`Coords`].
    pub axis: AxisId,
    /// Whether it turns.
    pub rotary: bool,
    /// Which side of the base it is on.
    pub side: Side,
    /// A point on its axis with all joints at zero, mm.
    pub point: [f64; 3],
    /// 1, or -1 if it counts against its direction.
    pub sign: f64,
    /// Position at which its zero is, mm or rad.
    pub zero: f64,
    /// Whether it turns without end, so that positions a turn apart are the same.
    pub wraps: bool,
    pub(crate) turning: Turning,
}

impl ChainJoint {
    /// Its unit vector with all joints at zero.
    pub fn direction(&self) -> [f64; 3] {
        self.turning.u
    }

    /// How far it is moved from its zero, in the sense of its direction.
    pub(crate) fn moved<R: Real>(&self, position: R) -> R {
        (position - R::constant(self.zero)) * R::constant(self.sign)
    }

    /// The position for a way from its zero.
    pub(crate) fn position<R: Real>(&self, moved: R) -> R {
        moved * R::constant(self.sign) + R::constant(self.zero)
    }

    /// What it makes of a point that it carries.
    pub(crate) fn carry<R: Real>(&self, point: Vec3<R>, position: R) -> Vec3<R> {
        let moved = self.moved(position);
        if self.rotary {
            let center = constant(self.point);
            return add(self.turning.by(sub(point, center), moved), center);
        }
        add(point, scale(constant(self.turning.u), moved))
    }

    /// The same for a direction.
    pub(crate) fn carry_direction<R: Real>(&self, direction: Vec3<R>, position: R) -> Vec3<R> {
        if self.rotary {
            self.turning.by(direction, self.moved(position))
        } else {
            direction
        }
    }

    /// The reverse of [`ChainJoint::carry`].
    pub(crate) fn leave<R: Real>(&self, point: Vec3<R>, position: R) -> Vec3<R> {
        let moved = -self.moved(position);
        if self.rotary {
            let center = constant(self.point);
            return add(self.turning.by(sub(point, center), moved), center);
        }
        add(point, scale(constant(self.turning.u), moved))
    }
}

/// A checked chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    pub(crate) joints: Vec<ChainJoint>,
    /// Gauge point of the spindle with all joints at zero, mm.
    pub(crate) gauge: [f64; 3],
    /// The tool's frame with all joints at zero, by columns: X, Y, and Z from the tip to the
    /// spindle.
    pub(crate) columns: [[f64; 3]; 3],
}

impl Chain {
    /// The joints in the order from the workpiece to the tool.
    pub fn joints(&self) -> &[ChainJoint] {
        &self.joints
    }

    /// What kind of machine it is.
    pub fn family(&self) -> Family {
        Family::of(self)
    }

    /// Place of the tip with all joints at zero for a tool offset, mm.
    pub(crate) fn tip_at_zero(&self, tool: &[f64; 3]) -> [f64; 3] {
        let rows: [[f64; 3]; 3] = std::array::from_fn(|row| self.columns.map(|column| column[row]));
        sub(self.gauge, apply(&rows, *tool))
    }

    /// Direction of the tool with all joints at zero, from its tip to the spindle.
    pub(crate) fn axis_at_zero(&self) -> [f64; 3] {
        self.columns[2]
    }

    /// The tip in the workpiece's frame, mm, for joint positions: for plain numbers and jets alike.
    pub fn tip<R: Real>(&self, joints: &[R; AXES], tool: &[f64; 3]) -> [R; 3] {
        let start = constant(self.tip_at_zero(tool));
        self.joints.iter().rev().fold(start, |point, joint| {
            joint.carry(point, joints[joint.axis.index()])
        })
    }

    /// A direction that is fixed to the tool, in the workpiece's frame; given as it points with all
    /// joints at zero.
    pub fn direction<R: Real>(&self, joints: &[R; AXES], at_zero: [f64; 3]) -> [R; 3] {
        self.joints
            .iter()
            .rev()
            .fold(constant(at_zero), |v, joint| {
                joint.carry_direction(v, joints[joint.axis.index()])
            })
    }

    /// From the tip to the spindle in the workpiece's frame, unit length.
    pub fn axis(&self, joints: &Coords) -> [f64; 3] {
        self.direction(&joints.0, self.axis_at_zero())
    }

    /// From the tip to the spindle in the machine's frame, unit length: what the joints of the head
    /// turn, whatever those of the table do.
    pub fn head_axis(&self, joints: &Coords) -> [f64; 3] {
        let of_head = |joint: &&ChainJoint| joint.side == Side::Head;
        self.joints
            .iter()
            .rev()
            .filter(of_head)
            .fold(self.axis_at_zero(), |v, joint| {
                joint.carry_direction(v, joints[joint.axis])
            })
    }

    /// What each joint does to the tip and to directions for a unit of its position: (velocity of
    /// the tip, angular velocity), the columns of the geometric Jacobian in the workpiece's frame,
    /// in the order of [`Chain::joints`].
    pub fn jacobian(&self, joints: &Coords, tool: &[f64; 3]) -> Vec<([f64; 3], [f64; 3])> {
        let mut columns: Vec<([f64; 3], [f64; 3])> = Vec::with_capacity(self.joints.len());
        // From the tool to the workpiece: each joint carries the tip, and turns the columns of the
        // joints behind it.
        let mut tip = self.tip_at_zero(tool);
        for joint in self.joints.iter().rev() {
            let position = joints[joint.axis];
            tip = joint.carry(tip, position);
            for (linear, angular) in &mut columns {
                *linear = joint.carry_direction(*linear, position);
                *angular = joint.carry_direction(*angular, position);
            }
            // A rotary joint moves the tip by axis x arm, a linear one along its direction.
            let axis = scale(joint.turning.u, joint.sign);
            columns.push(if joint.rotary {
                (
                    lostmotion_base::vec::cross(axis, sub(tip, joint.point)),
                    axis,
                )
            } else {
                (axis, [0.0; 3])
            });
        }
        columns.reverse();
        columns
    }
}

/// Largest component of a direction that leans against all three coordinate axes: 2.6 degrees off
/// the nearest. A choice: it names the family and changes no pose; nearer to 1 an axis off by its
/// alignment would count as nutating.
const MAX_LEANING_COMPONENT: f64 = 0.999;
/// Square of the sine between two axes of a wrist below which they count as parallel. Derived: the
/// rounding of 1 less a squared cosine (1e-16) is a ten-millionth of it.
const PARALLEL_SINE_SQUARED: f64 = 1e-9;
/// Distance within which the three axes of a wrist meet, mm: a micrometre, far below what moves the
/// tool's tip visibly.
const WRIST_MEETING_MM: f64 = 1e-3;

/// Families of serial machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Family {
    /// Linear joints alone.
    Linear,
    /// One rotary joint under the workpiece.
    RotaryTable,
    /// One rotary joint over the tool.
    RotaryHead,
    /// Two rotary joints under the workpiece.
    TableTable,
    /// Two rotary joints over the tool.
    HeadHead,
    /// One of each.
    HeadTable,
    /// Two rotary joints, one of which leans against the axes (45 degrees, usually).
    Nutating,
    /// Six rotary joints, the last three of which meet in a point.
    SphericalWristArm,
    /// Anything else.
    General,
}

impl Family {
    /// Its name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Family::Linear => "linear axes",
            Family::RotaryTable => "rotary table",
            Family::RotaryHead => "rotary head",
            Family::TableTable => "table-table",
            Family::HeadHead => "head-head",
            Family::HeadTable => "head-table",
            Family::Nutating => "nutating",
            Family::SphericalWristArm => "six-axis arm with spherical wrist",
            Family::General => "general chain",
        }
    }

    pub(super) fn of(chain: &Chain) -> Family {
        let rotary: Vec<&ChainJoint> = chain.joints.iter().filter(|joint| joint.rotary).collect();
        let linear = chain.joints.len() - rotary.len();
        match rotary.as_slice() {
            [] => Family::Linear,
            [joint] if linear >= 3 => match joint.side {
                Side::Table => Family::RotaryTable,
                Side::Head => Family::RotaryHead,
            },
            // Leaning decides before the sides do: nutating heads and tables are one family.
            [first, second] if linear >= 3 => {
                let leans = |joint: &ChainJoint| {
                    joint
                        .direction()
                        .iter()
                        .all(|c| c.abs() < MAX_LEANING_COMPONENT)
                };
                match (first.side, second.side) {
                    _ if leans(first) || leans(second) => Family::Nutating,
                    (Side::Table, Side::Table) => Family::TableTable,
                    (Side::Head, Side::Head) => Family::HeadHead,
                    _ => Family::HeadTable,
                }
            }
            // Axes that meet in a point split the pose into a place and an orientation (Pieper).
            [_, _, _, _, _, _] if linear == 0 && wrist_center(chain).is_some() => {
                Family::SphericalWristArm
            }
            _ => Family::General,
        }
    }
}

/// Where the last three of six axes meet with all joints at zero, mm; `None` if they do not meet.
pub(crate) fn wrist_center(chain: &Chain) -> Option<[f64; 3]> {
    let [.., fourth, fifth, sixth] = chain.joints.as_slice() else {
        return None;
    };
    let (p, q) = (fourth.point, fifth.point);
    let (u, v) = (fourth.direction(), fifth.direction());
    // Nearest points of the two lines p + s u and q + r v.
    let lean = dot(u, v);
    let open = 1.0 - lean * lean;
    // Parallel axes have no single nearest point.
    if open < PARALLEL_SINE_SQUARED {
        return None;
    }
    let way = sub(q, p);
    let s = (dot(way, u) - lean * dot(way, v)) / open;
    let center = along(p, u, s);
    // The point lies on the fourth axis; it has to lie on the other two as well.
    let off = |joint: &ChainJoint| {
        let away = sub(center, joint.point);
        let shadow = dot(away, joint.direction());
        norm(along(away, joint.direction(), -shadow))
    };
    (off(fifth) < WRIST_MEETING_MM && off(sixth) < WRIST_MEETING_MM).then_some(center)
}
