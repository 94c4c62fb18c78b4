//! What kind of machine a chain is.

use super::{Chain, ChainJoint, Side};
use lostmotion_base::vec::{along, dot, norm, sub};

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
