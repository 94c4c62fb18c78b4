//! Machine kinematics: from the tool in the part to the joints and back.
//!
//! One file per kind of machine, one line in [`registry`] for each. Serial machines are one
//! description, [`chain`].
//!
//! ```
//! use lostmotion_base::Coords;
//! use lostmotion_kinematics::{KinematicsSpec, build};
//!
//! let belts = build(&KinematicsSpec {
//!     kind: "corexy".into(),
//!     ..KinematicsSpec::default()
//! })?;
//! // One motor stands still while the carriage goes along the diagonal.
//! let joints = belts.inverse(&Coords::xyz(10.0, 10.0, 0.0), &[0.0; 3])?;
//! assert_eq!(joints.linear(), [20.0, 0.0, 0.0]);
//! # Ok::<(), lostmotion_kinematics::KinematicsError>(())
//! ```

use lostmotion_base::{AXES, AxisId, AxisSet, Coords, Jet};

mod bow;
pub mod cartesian;
pub mod chain;
pub mod corexy;
pub mod delta;
pub mod machine_tool;
pub mod orient;
mod pose;
pub mod registry;
mod rotation;
pub mod scara;
mod spec;
pub mod trunnion;
mod turns;

pub use bow::{bow_mm, chord_bend};
pub use cartesian::Cartesian;
pub use chain::{Chain, ChainJoint, Family};
pub use machine_tool::MachineTool;
pub use orient::{OrientError, Orientation};
pub use registry::{RegistryEntry, build, build_within, entries};
pub use spec::{Elbow, KinematicsSpec, TipControl, Words};

/// Where the tool is and how it points, in the part's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPose {
    /// Tool tip in mm.
    pub tip: [f64; 3],
    /// Unit vector along the tool, from its tip to the spindle.
    pub axis: [f64; 3],
}

/// From where to where each joint may go, mm or rad, by axis; `None` where nothing is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reach(pub [Option<(f64, f64)>; AXES]);

/// Words and joints of a machine whose joints do not have the names of its words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// The words that programs give.
    pub words: AxisSet,
    /// The joints that the machine has.
    pub joints: AxisSet,
}

/// How joints follow from program coordinates: what the planner may take from the path itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointMap {
    /// Each joint is the program coordinate of its letter plus a constant: derivatives by path
    /// length, bounds and straight lines are those of the path.
    Shifted,
    /// Any other map: the planner evaluates [`Kinematics::inverse_jet`] along the path.
    Curved,
}

/// A pose that the machine cannot take.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KinematicsError {
    /// No joint positions give the pose.
    #[error("the machine cannot reach {pose:?}: {why}")]
    Unreachable {
        /// Program coordinates, mm and rad.
        pose: Coords,
        /// What stands in the way.
        why: String,
    },
    /// The joints cannot move the tool in every direction there.
    #[error("the machine is singular at {pose:?}: {why}")]
    Singular {
        /// Program coordinates, mm and rad.
        pose: Coords,
        /// In which way.
        why: &'static str,
    },
    /// Neighbouring poses of a move need joint positions that are far apart.
    #[error("joint {joint} would have to jump by {by:.4} (mm or rad) near {pose:?}")]
    Jump {
        /// Program coordinates, mm and rad.
        pose: Coords,
        /// The joint.
        joint: AxisId,
        /// By how much, mm or rad.
        by: f64,
    },
    /// A machine description that does not fit the kind.
    #[error("kinematics `{kind}`: {why}")]
    Description {
        /// Registered name.
        kind: String,
        /// What is wrong, with values.
        why: String,
    },
}

impl KinematicsError {
    pub(crate) fn singular(pose: &Coords, why: &'static str) -> KinematicsError {
        KinematicsError::Singular { pose: *pose, why }
    }
}

/// A machine's kinematics. Program coordinates (tool tip or axis values, as the machine's control
/// takes them) on one side, joint positions on the other; both are [`Coords`], a joint having the
/// index of the axis that names it.
///
/// `tool` is the tool's offset (X, Y, Z in mm) that is in force; program coordinates are those of
/// the tip, so that with all rotary axes at zero X, Y and Z of the joints are the program's plus
/// the offset.
///
/// The trait is open: the planner takes any type that implements it.
///
/// ```
/// use lostmotion_base::{Coords, Jet, Real};
/// use lostmotion_kinematics::{Kinematics, KinematicsError, ToolPose};
///
/// /// A mill whose column leans along X by `lean` mm per mm of height.
/// #[derive(Debug)]
/// struct LeaningColumn {
///     lean: f64,
/// }
///
/// impl LeaningColumn {
///     /// Written once for plain numbers and for jets, which carry the derivatives.
///     fn joints<R: Real>(&self, program: &[R; 9], tool: &[f64; 3]) -> [R; 9] {
///         let mut joints = *program;
///         for (joint, offset) in joints.iter_mut().zip(tool) {
///             *joint = *joint + R::constant(*offset);
///         }
///         joints[0] = joints[0] - R::constant(self.lean) * joints[2];
///         joints
///     }
/// }
///
/// impl Kinematics for LeaningColumn {
///     fn name(&self) -> &'static str {
///         "leaning-column"
///     }
///     fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
///         Ok(Coords(self.joints(&program.0, tool)))
///     }
///     fn inverse_jet(
///         &self,
///         program: &[Jet; 9],
///         tool: &[f64; 3],
///     ) -> Result<[Jet; 9], KinematicsError> {
///         Ok(self.joints(program, tool))
///     }
///     fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords {
///         let mut program = *joints;
///         program.0[0] += self.lean * joints.0[2];
///         program - Coords::xyz(tool[0], tool[1], tool[2])
///     }
///     fn tool_pose(&self, joints: &Coords, tool: &[f64; 3]) -> ToolPose {
///         ToolPose {
///             tip: self.forward(joints, tool).linear(),
///             axis: [0.0, 0.0, 1.0],
///         }
///     }
/// }
///
/// let machine = LeaningColumn { lean: 0.01 };
/// let joints = machine.inverse(&Coords::xyz(10.0, 0.0, 100.0), &[0.0; 3])?;
/// assert_eq!(joints.linear(), [9.0, 0.0, 100.0]);
/// assert_eq!(machine.forward(&joints, &[0.0; 3]).linear(), [10.0, 0.0, 100.0]);
/// # Ok::<(), KinematicsError>(())
/// ```
pub trait Kinematics: Send + Sync + std::fmt::Debug {
    /// Registered name.
    fn name(&self) -> &'static str;

    /// How joints follow from program coordinates.
    fn joint_map(&self) -> JointMap {
        JointMap::Curved
    }

    /// Joint positions of program coordinates, mm and rad.
    ///
    /// # Errors
    /// A pose out of the machine's reach.
    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError>;

    /// The same with the first three derivatives by path parameter: exact joint derivatives for the
    /// planner.
    ///
    /// # Errors
    /// A pose out of the machine's reach.
    fn inverse_jet(&self, program: &[Jet; 9], tool: &[f64; 3])
    -> Result<[Jet; 9], KinematicsError>;

    /// Program coordinates of joint positions: the inverse of [`Kinematics::inverse`].
    fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords;

    /// The tool in the part's frame for joint positions.
    fn tool_pose(&self, joints: &Coords, tool: &[f64; 3]) -> ToolPose;

    /// The chain behind it, if it is one.
    fn chain(&self) -> Option<&Chain> {
        None
    }

    /// Which words a program gives and which joints the machine has, where these are not the same
    /// letters; `None` where they are.
    fn layout(&self) -> Option<Layout> {
        None
    }

    /// What turns directions of the tool into rotary words, for machines whose words are rotary
    /// joints.
    fn orientation(&self) -> Option<&Orientation> {
        None
    }
}
