//! Machine kinematics: from the tool in the part to the joints and back.
//!
//! A kind of machine is one file, with the keys that describe it, and one line in `kinds!` below.
//! Serial machines need no code of their own: they are a list of joints, [`serial`].
//!
//! ```
//! use lostmotion_base::Coords;
//! use lostmotion_kinematics::{CoreXySpec, build};
//!
//! let belts = build(&CoreXySpec {}.into())?;
//! // One motor stands still while the carriage goes along the diagonal.
//! let joints = belts.inverse(&Coords::xyz(10.0, 10.0, 0.0), &[0.0; 3])?;
//! assert_eq!(joints.linear(), [20.0, 0.0, 0.0]);
//! # Ok::<(), lostmotion_kinematics::KinematicsError>(())
//! ```

use lostmotion_base::{AXES, AxisId, AxisSet, Coords, Jet};
use serde::{Deserialize, Serialize};

mod bow;
pub mod chain;
mod kind;
pub mod machine_tool;
pub mod orient;
mod pose;
mod rotation;

pub use bow::{bow_mm, chord_bend};
pub use cartesian::Cartesian;
pub use chain::{Chain, ChainJoint, Family};
pub use kind::{KindInfo, KindSpec, KindVisitor, TipControl, build, build_within};
pub use machine_tool::MachineTool;
pub use orient::{OrientError, Orientation};
pub use scara::Elbow;
pub use serial::Words;

/// Makes, from one line a file, the module, the variants of [`KinematicsSpec`] and the rows of
/// [`KINDS`]: `file: "name" Variant(its keys), ...;`.
macro_rules! kinds {
    ($($file:ident: $($name:literal $kind:ident($spec:ident)),+;)*) => {
        $(pub mod $file;)*
        $($(pub use $file::$spec;)+)*

        /// The description of a machine's kinematics: the table `[kinematics]` of a machine file,
        /// in which `kind` names the variant.
        ///
        /// ```
        /// use lostmotion_kinematics::{DeltaSpec, KinematicsSpec};
        ///
        /// let spec = KinematicsSpec::from(DeltaSpec {
        ///     tower_radius_mm: 150.0,
        ///     rod_mm: 320.0,
        ///     tower_angles_deg: None,
        /// });
        /// assert_eq!(spec.kind(), "delta");
        /// ```
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "kind")]
        #[non_exhaustive]
        pub enum KinematicsSpec {
            $($(
                #[doc = concat!("`kind = \"", $name, "\"`.")]
                #[serde(rename = $name)]
                $kind($spec),
            )+)*
        }

        /// Every registered kind of machine.
        pub static KINDS: &[KindInfo] = &[
            $($(KindInfo {
                kind: $name,
                summary: <$spec as KindSpec>::SUMMARY,
                keys: kind::keys_of::<$spec>,
            },)+)*
        ];

        $($(
            impl $spec {
                /// The kind's name in machine files.
                pub const KIND: &'static str = $name;
            }

            impl From<$spec> for KinematicsSpec {
                fn from(spec: $spec) -> KinematicsSpec {
                    KinematicsSpec::$kind(spec)
                }
            }
        )+)*

        impl KinematicsSpec {
            /// The kind's name in machine files.
            pub fn kind(&self) -> &'static str {
                match self {
                    $($(KinematicsSpec::$kind(_) => $name,)+)*
                }
            }

            /// Calls a visitor with the type that describes a kind.
            ///
            /// # Errors
            /// An unknown kind.
            pub fn visit_kind<V: KindVisitor>(
                kind: &str,
                visitor: V,
            ) -> Result<V::Output, KinematicsError> {
                match kind {
                    $($($name => Ok(visitor.visit::<$spec>()),)+)*
                    _ => Err(KinematicsError::unknown(kind)),
                }
            }

            /// When X Y Z are the tool's tip.
            pub fn tip_control(&self) -> TipControl {
                match self {
                    $($(KinematicsSpec::$kind(spec) => spec.tip_control(),)+)*
                }
            }

            /// Whether the joint of a letter is rotary.
            pub fn is_rotary(&self, joint: AxisId) -> bool {
                match self {
                    $($(KinematicsSpec::$kind(spec) => spec.is_rotary(joint),)+)*
                }
            }

            fn build_kind(&self, reach: &Reach) -> Result<Box<dyn Kinematics>, String> {
                match self {
                    $($(KinematicsSpec::$kind(spec) => spec.build(reach),)+)*
                }
            }
        }
    };
}

kinds! {
    cartesian: "cartesian" Cartesian(CartesianSpec);
    trunnion: "trunnion-ac" TrunnionAc(TrunnionAcSpec), "trunnion-bc" TrunnionBc(TrunnionBcSpec);
    serial: "chain" Chain(ChainSpec);
    corexy: "corexy" CoreXy(CoreXySpec);
    delta: "delta" Delta(DeltaSpec);
    scara: "scara" Scara(ScaraSpec);
}

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

/// A pose for people: X, Y and Z, and the other coordinates that are not 0, in mm and degrees.
fn told(pose: &Coords) -> String {
    let words = AxisId::ALL.into_iter().filter_map(|axis| {
        let value = pose[axis];
        match axis {
            AxisId::X | AxisId::Y | AxisId::Z => Some(format!("{axis} {value:.3} mm")),
            _ if value == 0.0 => None,
            _ if axis.is_rotary() => Some(format!(
                "{axis} {:.3} deg",
                lostmotion_base::units::deg(value)
            )),
            _ => Some(format!("{axis} {value:.3} mm")),
        }
    });
    words.collect::<Vec<_>>().join(", ")
}

/// A pose that the machine cannot take.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KinematicsError {
    /// No joint positions give the pose.
    #[error("the machine cannot reach {}: {why}", told(pose))]
    Unreachable {
        /// Program coordinates, mm and rad.
        pose: Coords,
        /// What stands in the way.
        why: String,
    },
    /// The joints cannot move the tool in every direction there.
    #[error("the machine is singular at {}: {why}", told(pose))]
    Singular {
        /// Program coordinates, mm and rad.
        pose: Coords,
        /// In which way.
        why: &'static str,
    },
    /// Neighbouring poses of a move need joint positions that are far apart.
    #[error(
        "joint {joint} would have to jump by {by:.4} (mm or rad) near {}",
        told(pose)
    )]
    Jump {
        /// Program coordinates, mm and rad.
        pose: Coords,
        /// The joint.
        joint: AxisId,
        /// By how much, mm or rad.
        by: f64,
    },
    /// A description with measures that no machine of its kind can have, or of an unknown kind.
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

    fn unknown(kind: &str) -> KinematicsError {
        let known: Vec<&str> = KINDS.iter().map(|info| info.kind).collect();
        KinematicsError::Description {
            kind: kind.to_owned(),
            why: format!("there is no such kind; known are {}", known.join(", ")),
        }
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
