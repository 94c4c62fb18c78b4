//! Chains whose words are a pose: X Y Z the tip, A B C roll, pitch and yaw of the tool's frame (R =
//! Rz(C) Ry(B) Rx(A)), both in the workpiece's frame; joints are whatever the chain has.
//!
//! Six rotary joints whose last three meet in a point have a closed form ([`arm`]); every other
//! chain is solved by Newton's method ([`numeric`]). `home` in the machine file picks the branch:
//! the one in which the machine stands at home.

mod arm;
mod numeric;

use crate::chain::Chain;
use crate::rotation::{angles_of, roll_pitch_yaw};
use crate::{Kinematics, Layout, Reach};
use lostmotion_base::units::rad;
use lostmotion_base::vec::{Vec3, constant};
use lostmotion_base::{AXES, AxisId, AxisSet, Coords, Real};

pub(crate) use arm::Arm;
pub(crate) use numeric::Numeric;

/// Builds the closed form if there is one for the chain, else the numeric inverse. `home` are the
/// joints at home in the order of the chain, mm and deg; `kind` is the name that the machine gives
/// itself.
pub(crate) fn build(
    kind: &'static str,
    chain: Chain,
    home: &[f64],
    reach: &Reach,
) -> Result<Box<dyn Kinematics>, String> {
    let home = joints_at_home(&chain, home)?;
    match Arm::new(kind, &chain, &home) {
        Some(arm) => Ok(Box::new(arm)),
        None => Ok(Box::new(Numeric::new(kind, chain, home, reach)?)),
    }
}

/// Joints at home, mm and rad.
fn joints_at_home(chain: &Chain, given: &[f64]) -> Result<Coords, String> {
    if given.len() != chain.joints.len() {
        return Err(format!(
            "`home` has to list a position for each of the {} joints in their order, mm and degrees, away from limits and singular poses; it chooses among the solutions",
            chain.joints.len()
        ));
    }
    let mut home = Coords::ZERO;
    for (joint, value) in chain.joints.iter().zip(given) {
        home[joint.axis] = if joint.rotary { rad(*value) } else { *value };
    }
    Ok(home)
}

/// Tip and frame of the tool.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose<R> {
    pub(crate) tip: Vec3<R>,
    /// Columns of the tool's frame.
    pub(crate) columns: [Vec3<R>; 3],
}

impl<R: Real> Pose<R> {
    /// From program words.
    pub(crate) fn of_words(words: &[R; AXES]) -> Pose<R> {
        let angles = [words[3], words[4], words[5]];
        let column = |axis: [f64; 3]| roll_pitch_yaw(constant(axis), angles);
        Pose {
            tip: [words[0], words[1], words[2]],
            columns: [
                column([1.0, 0.0, 0.0]),
                column([0.0, 1.0, 0.0]),
                column([0.0, 0.0, 1.0]),
            ],
        }
    }

    /// Of a chain's joints.
    pub(crate) fn of_joints(chain: &Chain, joints: &[R; AXES], tool: &[f64; 3]) -> Pose<R> {
        Pose {
            tip: chain.tip(joints, tool),
            columns: chain.columns.map(|column| chain.direction(joints, column)),
        }
    }
}

/// Program words of joints; U, V and W are the joints' own.
pub(crate) fn words(chain: &Chain, joints: &Coords, tool: &[f64; 3]) -> Coords {
    let pose = Pose::of_joints(chain, &joints.0, tool);
    let mut words = Coords::ZERO;
    words.0[..3].copy_from_slice(&pose.tip);
    words.0[3..6].copy_from_slice(&angles_of(&pose.columns));
    words.0[6..].copy_from_slice(&joints.0[6..]);
    words
}

/// Words and joints of a chain whose words are a pose.
pub(crate) fn layout(chain: &Chain) -> Layout {
    let joints: AxisSet = chain.joints.iter().map(|joint| joint.axis).collect();
    let pose = AxisId::ALL.into_iter().take(6);
    let extra = joints.iter().filter(|axis| axis.index() >= 6);
    Layout {
        words: pose.chain(extra).collect(),
        joints,
    }
}

/// Joint positions by axis from those in the chain's order.
pub(crate) fn in_order<R: Real>(chain: &Chain, positions: &[R]) -> [R; AXES] {
    let mut joints = [R::constant(0.0); AXES];
    for (joint, position) in chain.joints.iter().zip(positions) {
        joints[joint.axis.index()] = *position;
    }
    joints
}

/// A rotary position a whole number of turns away, nearest to another: the cut lies half a turn
/// from it.
pub(crate) fn turns_to(angle: f64, near: f64) -> f64 {
    std::f64::consts::TAU * ((near - angle) / std::f64::consts::TAU).round()
}

/// The axes of a chain's joints, for messages.
pub(crate) fn letters(chain: &Chain) -> String {
    chain
        .joints
        .iter()
        .map(|joint| AxisId::letter(joint.axis))
        .collect()
}
