//! From the front end's motion to curves and planner items.

use crate::error::SimError;
use lostmotion_base::Coords;
use lostmotion_base::units::deg;
use lostmotion_gcode::{Feed, Motion, MotionItem, PathMode};
use lostmotion_path::{Arc, ArcSpec, Curve, HermiteEnd, PathError, Quintic};
use lostmotion_plan::{Dwell, FeedLimit, Halt, Move, PathControl, PlanItem};

/// Seconds per minute.
const MINUTE: f64 = 60.0;

/// What the planner is to do; nothing for what neither moves nor stops the machine.
///
/// # Errors
/// An arc that cannot be.
pub(crate) fn lower(item: &MotionItem) -> Result<Option<PlanItem>, SimError> {
    Ok(Some(match item {
        MotionItem::Move(motion) => PlanItem::Move(lower_move(motion)?),
        MotionItem::Dwell { seconds, block } => PlanItem::Dwell(Dwell {
            seconds: *seconds,
            block: *block,
        }),
        MotionItem::ToolChange { block, .. }
        | MotionItem::Stop { block, .. }
        | MotionItem::End { block } => PlanItem::Halt(Halt { block: *block }),
        _ => return Ok(None),
    }))
}

fn lower_move(motion: &Motion) -> Result<Move, SimError> {
    let curve = curve(motion).map_err(|source| SimError::Path {
        block: motion.block,
        source,
        provenance: Box::default(),
    })?;
    let feed = match (motion.feed, motion.duration_s) {
        (Feed::Rapid, _) => FeedLimit::Rapid,
        (_, Some(seconds)) => FeedLimit::Duration(seconds),
        (Feed::MmPerMin(feed), None) => FeedLimit::PerSecond(feed / MINUTE),
        // The parameter of a curve on which only rotary axes move is in degrees.
        (Feed::RadPerMin(feed), None) => FeedLimit::PerSecond(deg(feed) / MINUTE),
    };
    let feed = match feed {
        FeedLimit::PerSecond(feed) if !motion.feed_override => FeedLimit::Fixed(feed),
        FeedLimit::Duration(seconds) if !motion.feed_override => {
            FeedLimit::Fixed(curve.length() / seconds)
        }
        other => other,
    };
    let control = match motion.path {
        PathMode::ExactPath => PathControl::ExactPath,
        PathMode::ExactStop => PathControl::ExactStop,
        PathMode::Continuous {
            tolerance_mm,
            merge_mm,
        } => PathControl::Continuous {
            tolerance_mm,
            merge_tolerance_mm: Some(merge_mm),
        },
    };
    Ok(Move {
        curve,
        feed,
        control,
        tool_mm: motion.tool_offset.linear(),
        block: motion.block,
    })
}

fn curve(motion: &Motion) -> Result<Curve, PathError> {
    if let Some(circle) = &motion.circle {
        let spec = ArcSpec {
            start: motion.start,
            end: motion.end,
            plane: circle.plane,
            center: circle.center_mm,
            rotation: circle.turns,
        };
        return Ok(Curve::Arc(Arc::new(spec)?));
    }
    let Some(bend) = &motion.bend else {
        return Ok(Curve::line(motion.start, motion.end));
    };
    let ends = [motion.start, motion.end];
    let [start, end] = [0, 1].map(|at| {
        let [d1, d2] =
            [bend.tangents[at], bend.curvatures_per_mm[at]].map(|[x, y, z]| Coords::xyz(x, y, z));
        HermiteEnd {
            p: ends[at],
            d1,
            d2,
        }
    });
    Ok(Curve::Quintic(Quintic::hermite(
        start,
        end,
        bend.length_mm,
    )?))
}
