//! Whether the joints stay in their travel.

use crate::error::{PlanError, TravelViolation};
use crate::{Move, PlannerConfig};
use lostmotion_base::{AXES, AxisId, AxisLimits, Coords};
use lostmotion_kinematics::{JointMap, Kinematics, KinematicsError};
use lostmotion_path::{Bounds, Curve};
use std::sync::Arc;

/// Distance beyond a limit that counts as rounding, mm or rad.
const TRAVEL_ROUNDING: f64 = 1e-6;
/// Intervals of a move at whose ends the joints are evaluated where the kinematics bends it. A
/// choice: more find shorter excursions beyond the travel and cost an inverse each.
const TRAVEL_POINTS: usize = 64;

/// Checks moves against the joints' travel without planning them: a pass over a whole program
/// before anything is done.
///
/// Exact for kinematics whose joints are program coordinates up to a constant; for others the
/// joints are looked at in 65 points of every move.
///
/// ```
/// use lostmotion_base::{AxisLimits, BlockRef, Coords};
/// use lostmotion_kinematics::Cartesian;
/// use lostmotion_path::Curve;
/// use lostmotion_plan::{FeedLimit, Move, PathControl, PlannerConfig, TravelCheck};
/// use std::sync::Arc;
///
/// let limits = AxisLimits { min: 0.0, max: 300.0, velocity: 100.0, acceleration: 1e3, jerk: 3e4 };
/// let mut config = PlannerConfig::new([None; 9]);
/// config.limits[..3].fill(Some(limits));
/// let mut check = TravelCheck::new(&config, Arc::new(Cartesian));
/// check.push(&Move {
///     curve: Curve::line(Coords::ZERO, Coords::xyz(310.0, 0.0, 0.0)),
///     feed: FeedLimit::Rapid,
///     control: PathControl::ExactPath,
///     tool_mm: [0.0; 3],
///     block: BlockRef::default(),
/// })?;
/// assert_eq!(check.take_violations().len(), 1);
/// # Ok::<(), lostmotion_plan::PlanError>(())
/// ```
#[derive(Clone, Debug)]
pub struct TravelCheck {
    limits: [Option<AxisLimits>; AXES],
    kinematics: Arc<dyn Kinematics>,
    violations: Vec<TravelViolation>,
}

impl TravelCheck {
    /// A check with the planner's settings.
    pub fn new(config: &PlannerConfig, kinematics: Arc<dyn Kinematics>) -> TravelCheck {
        TravelCheck {
            limits: config.limits,
            kinematics,
            violations: Vec::new(),
        }
    }

    /// Looks at a move.
    ///
    /// # Errors
    /// A pose that the machine cannot take; violations of the travel are collected instead.
    pub fn push(&mut self, item: &Move) -> Result<(), PlanError> {
        let found = violations(&self.limits, self.kinematics.as_ref(), item)?;
        self.violations.extend(found);
        Ok(())
    }

    /// Hands over the violations found since the last call, so that a long program does not pile
    /// them up.
    pub fn take_violations(&mut self) -> Vec<TravelViolation> {
        std::mem::take(&mut self.violations)
    }

    /// Every violation so far, in the order of the program: for each move and joint the farthest
    /// position.
    pub fn violations(&self) -> &[TravelViolation] {
        &self.violations
    }
}

/// The joints that leave their travel on a move.
pub(crate) fn violations(
    limits: &[Option<AxisLimits>; AXES],
    kinematics: &dyn Kinematics,
    item: &Move,
) -> Result<Vec<TravelViolation>, PlanError> {
    let bounds =
        joint_bounds(kinematics, &item.curve, &item.tool_mm).map_err(|source| PlanError::Pose {
            block: item.block,
            source: Box::new(source),
        })?;
    let mut found = Vec::new();
    for (joint, limit) in AxisId::ALL.into_iter().zip(limits) {
        let Some(limit) = limit else { continue };
        let (low, high) = (bounds.min[joint], bounds.max[joint]);
        // One violation for a move and joint: that of the farther end.
        let (below, above) = (limit.min - low, high - limit.max);
        if below.max(above) > TRAVEL_ROUNDING {
            let (value, limit) = if below > above {
                (low, limit.min)
            } else {
                (high, limit.max)
            };
            found.push(TravelViolation {
                block: item.block,
                joint,
                value,
                limit,
            });
        }
    }
    Ok(found)
}

/// From where to where each joint goes on a curve.
fn joint_bounds(
    kinematics: &dyn Kinematics,
    curve: &Curve,
    tool_mm: &[f64; 3],
) -> Result<Bounds, KinematicsError> {
    let start = kinematics.inverse(&curve.start(), tool_mm)?;
    if kinematics.joint_map() == JointMap::Shifted {
        let (offset, bounds) = (start - curve.start(), curve.bounds());
        return Ok(Bounds {
            min: bounds.min + offset,
            max: bounds.max + offset,
        });
    }
    let mut bounds = Bounds {
        min: start,
        max: start,
    };
    let length = curve.length();
    let mut before = (0.0, start);
    for point in 1..=TRAVEL_POINTS {
        let s = length * (point as f64 / TRAVEL_POINTS as f64);
        let joints = kinematics.inverse(&curve.point(s), tool_mm)?;
        // Both places may be within the travel although the inverse jumps between its solutions.
        is_continuous(
            kinematics,
            curve,
            tool_mm,
            before,
            (s, joints),
            JUMP_HALVINGS,
        )?;
        bounds.include(joints);
        before = (s, joints);
    }
    Ok(bounds)
}

/// Distances of a joint between two places, mm and rad, from which on it has to be shown that the
/// joint does not jump. A choice: smaller looks closer at more places, larger may miss a jump to a
/// near solution.
const JUMP_SIZE: [f64; 2] = [20.0, 0.3];
/// Halvings of a stretch to show that: to a billionth of a move.
const JUMP_HALVINGS: u32 = 24;

/// Refuses a move on which joints would jump from one solution to another.
fn is_continuous(
    kinematics: &dyn Kinematics,
    curve: &Curve,
    tool_mm: &[f64; 3],
    (s0, start): (f64, Coords),
    (s1, end): (f64, Coords),
    halvings: u32,
) -> Result<(), KinematicsError> {
    let far = AxisId::ALL
        .into_iter()
        .find(|axis| (end[*axis] - start[*axis]).abs() > JUMP_SIZE[usize::from(axis.is_rotary())]);
    let Some(joint) = far else { return Ok(()) };
    let middle = 0.5 * (s0 + s1);
    // A fast joint comes nearer when the places do; one that jumps does not.
    if halvings == 0 || middle <= s0 || middle >= s1 {
        return Err(KinematicsError::Jump {
            pose: curve.point(s0),
            joint,
            by: end[joint] - start[joint],
        });
    }
    let joints = kinematics.inverse(&curve.point(middle), tool_mm)?;
    is_continuous(
        kinematics,
        curve,
        tool_mm,
        (s0, start),
        (middle, joints),
        halvings - 1,
    )?;
    is_continuous(
        kinematics,
        curve,
        tool_mm,
        (middle, joints),
        (s1, end),
        halvings - 1,
    )
}
