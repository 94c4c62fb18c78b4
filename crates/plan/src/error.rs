//! Errors of the planner: moves that it cannot plan, and settings that make no sense.

use lostmotion_base::{AxisId, BlockRef, LimitError};
use lostmotion_kinematics::KinematicsError;

/// Why something cannot be planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// A joint would leave its travel.
    #[error(transparent)]
    Travel(#[from] TravelViolation),
    /// A joint moves that the machine does not have.
    #[error("{}: the move turns or shifts joint {joint}, which the machine does not have; give it limits or leave it out of the program", block.span)]
    NoLimits {
        /// Block that commands the move.
        block: BlockRef,
        /// The joint.
        joint: AxisId,
    },
    /// A move does not start where the one before ended.
    #[error("{}: the move starts {distance} mm or rad away from the end of the one before (axis {axis})", block.span)]
    Jump {
        /// Block that commands the move.
        block: BlockRef,
        /// The axis with the largest distance.
        axis: AxisId,
        /// The distance, mm or rad.
        distance: f64,
    },
    /// A number that is not finite, or a feed, duration or dwell that cannot be.
    #[error("{}: {what} is {value}; it has to be a finite number and {condition}", block.span)]
    Number {
        /// Block that commands the move.
        block: BlockRef,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it has to be besides finite.
        condition: &'static str,
    },
    /// The machine cannot take a pose of the move.
    #[error("{}: {source}", block.span)]
    Pose {
        /// Block that commands the move.
        block: BlockRef,
        /// What the kinematics says.
        source: Box<KinematicsError>,
    },
    /// A limit in the configuration makes no sense.
    #[error("limits of joint {joint}: {source}")]
    Limits {
        /// The joint.
        joint: AxisId,
        /// What is wrong.
        source: LimitError,
    },
    /// A setting in the configuration makes no sense.
    #[error("planner setting {what} is {value}; it has to be {condition}")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it has to be.
        condition: &'static str,
    },
    /// The machine cannot take the pose at which the program starts.
    #[error("start of the program: {0}")]
    Start(Box<KinematicsError>),
    /// Something was pushed after the end.
    #[error("the planner was given something after its end")]
    Finished,
}

/// A joint that would leave its travel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: joint {joint} would have to go to {value}, beyond its limit of {limit} (mm or rad)", block.span)]
pub struct TravelViolation {
    /// Block that commands the move.
    pub block: BlockRef,
    /// The joint.
    pub joint: AxisId,
    /// The farthest position that the move asks for, mm or rad.
    pub value: f64,
    /// The limit that it passes, mm or rad.
    pub limit: f64,
}
