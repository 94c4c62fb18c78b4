//! What a move has to fulfil before it is planned.

use crate::error::PlanError;
use crate::travel::violations;
use crate::{FeedLimit, Move, PlannerConfig};
use lostmotion_base::{AXES, AxisId, BlockRef, Coords};
use lostmotion_kinematics::{JointMap, Kinematics};

/// Largest distance, mm or rad, between the end of a move and the start of the next one. A choice:
/// far above the rounding of places up to 1 m (1e-13), far below any tolerance.
const MAX_GAP: f64 = 1e-6;
/// Intervals of a move at whose ends joints are looked for that move without having limits. A
/// choice: a joint that moves shows a speed at one of nine places at least; more cost an inverse
/// each.
const LIMIT_POINTS: usize = 8;
/// Speed of a joint per path parameter up to which it stands still: rounding of the inverse
/// kinematics.
const STILL_SPEED: f64 = 1e-12;

/// Where the program is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Position {
    pub(crate) program: Coords,
    pub(crate) tool_mm: [f64; 3],
}

/// Checks a move against the machine and the place where the last one ended; gives the largest
/// speed of its parameter.
pub(crate) fn admit(
    config: &PlannerConfig,
    kinematics: &dyn Kinematics,
    here: &Position,
    item: &Move,
) -> Result<f64, PlanError> {
    let block = item.block;
    let (start, end, length) = (item.curve.start(), item.curve.end(), item.curve.length());
    let values = start
        .0
        .iter()
        .chain(&end.0)
        .chain([&length])
        .chain(&item.tool_mm);
    if let Some(&value) = values.into_iter().find(|value| !value.is_finite()) {
        return Err(PlanError::Number {
            block,
            what: "a coordinate of the move",
            value,
            condition: "in the reach of the machine",
        });
    }
    let feed = feed(item, length)?;
    connects(kinematics, here, item)?;
    has_limits(config, kinematics, item)?;
    match violations(&config.limits, kinematics, item)?
        .into_iter()
        .next()
    {
        Some(violation) => Err(violation.into()),
        None => Ok(feed),
    }
}

fn feed(item: &Move, length: f64) -> Result<f64, PlanError> {
    let (what, value, feed) = match item.feed {
        FeedLimit::Rapid => return Ok(f64::INFINITY),
        FeedLimit::PerSecond(feed) | FeedLimit::Fixed(feed) => ("the feed per second", feed, feed),
        FeedLimit::Duration(seconds) => ("the duration of the move", seconds, length / seconds),
    };
    positive(item.block, what, value)?;
    Ok(feed)
}

/// Refuses anything that is not a positive finite number.
fn positive(block: BlockRef, what: &'static str, value: f64) -> Result<(), PlanError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(PlanError::Number {
            block,
            what,
            value,
            condition: "positive",
        })
    }
}

/// Refuses a move that does not start where the machine is; under a change of tool the joints have
/// to agree.
fn connects(kinematics: &dyn Kinematics, here: &Position, item: &Move) -> Result<(), PlanError> {
    let start = item.curve.start();
    let delta = if here.tool_mm == item.tool_mm {
        start - here.program
    } else {
        // Under another tool offset the same pose has other program coordinates: joints are
        // compared.
        let joints = |program: &Coords, tool: &[f64; 3]| {
            kinematics
                .inverse(program, tool)
                .map_err(|source| PlanError::Pose {
                    block: item.block,
                    source: Box::new(source),
                })
        };
        joints(&start, &item.tool_mm)? - joints(&here.program, &here.tool_mm)?
    };
    let farthest = AxisId::ALL
        .into_iter()
        .max_by(|a, b| delta[*a].abs().total_cmp(&delta[*b].abs()));
    match farthest {
        Some(axis) if delta[axis].abs() > MAX_GAP => Err(PlanError::Jump {
            block: item.block,
            axis,
            distance: delta[axis].abs(),
        }),
        _ => Ok(()),
    }
}

/// Refuses a move of a joint that has no limits.
fn has_limits(
    config: &PlannerConfig,
    kinematics: &dyn Kinematics,
    item: &Move,
) -> Result<(), PlanError> {
    let curve = &item.curve;
    let mut speed = curve.max_derivatives(0.0, curve.length()).0;
    if kinematics.joint_map() == JointMap::Curved {
        // The bounds of the curve are not those of the joints: their speeds at some places tell
        // which of them move.
        for point in 0..=LIMIT_POINTS {
            let jets = kinematics.inverse_jet(
                &curve.jet(curve.length() * (point as f64 / LIMIT_POINTS as f64)),
                &item.tool_mm,
            );
            let jets = jets.map_err(|source| PlanError::Pose {
                block: item.block,
                source: Box::new(source),
            })?;
            let fresh = |joint: usize| jets[joint].0[1].abs();
            speed = Coords(std::array::from_fn::<f64, AXES, _>(|joint| {
                if point == 0 {
                    fresh(joint)
                } else {
                    speed.0[joint].max(fresh(joint))
                }
            }));
        }
    }
    let missing = AxisId::ALL
        .into_iter()
        .find(|joint| speed[*joint] > STILL_SPEED && config.limits[joint.index()].is_none());
    match missing {
        Some(joint) => Err(PlanError::NoLimits {
            block: item.block,
            joint,
        }),
        None => Ok(()),
    }
}

/// Checks a dwell.
pub(crate) fn dwell(block: BlockRef, seconds: f64) -> Result<(), PlanError> {
    if seconds.is_finite() && seconds >= 0.0 {
        Ok(())
    } else {
        Err(PlanError::Number {
            block,
            what: "the dwell in seconds",
            value: seconds,
            condition: "zero or more",
        })
    }
}
