//! From the motion of a program to curves and to the planner's items.

use super::reader::Reader;
use super::steer::Read;
use crate::error::SimError;
use crate::setup::Setup;
use lostmotion_base::Coords;
use lostmotion_base::units::deg;
use lostmotion_gcode::{Feed, Motion, MotionItem, PathMode, Plane};
use lostmotion_path::{Arc, ArcSpec, Curve, HermiteEnd, PathError, Quintic};
use lostmotion_plan::{Dwell, FeedLimit, Halt, Move, PathControl, PlanItem};

/// Seconds in a minute: programs give feeds per minute.
const MINUTE_S: f64 = 60.0;

/// The planner's item for an item of motion: a move, a dwell or a halt; `None` for what neither
/// moves nor stops the machine.
///
/// # Errors
/// [`SimError::Path`]: an arc whose ends are not at one distance from its centre.
pub fn plan_item(item: &MotionItem) -> Result<Option<PlanItem>, SimError> {
    Ok(Some(match item {
        MotionItem::Move(motion) => PlanItem::Move(planned_move(motion)?),
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

fn planned_move(motion: &Motion) -> Result<Move, SimError> {
    let curve = curve(motion).map_err(|source| SimError::Path {
        block: motion.block,
        source,
        provenance: Box::default(),
    })?;
    // A duration (G93) replaces the feed; rapids heed neither.
    let feed = match (motion.feed, motion.duration_s) {
        (Feed::Rapid, _) => FeedLimit::Rapid,
        (_, Some(seconds)) => FeedLimit::Duration(seconds),
        (Feed::MmPerMin(feed), None) => FeedLimit::PerSecond(feed / MINUTE_S),
        // The parameter of a curve on which only rotary axes move is in degrees.
        (Feed::RadPerMin(feed), None) => FeedLimit::PerSecond(deg(feed) / MINUTE_S),
    };
    // M49 takes the override away: the feed is fixed, and a duration becomes the mean speed that
    // keeps it.
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

/// The curve of a motion in machine coordinates, mm and rad: a line, an arc or helix, or a piece of
/// a spline as a quintic.
///
/// # Errors
/// An arc whose ends are not at one distance from its centre.
pub fn curve(motion: &Motion) -> Result<Curve, PathError> {
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
    // Pieces of splines have tangents and curvatures at their ends; all else that is no circle is
    // straight.
    let Some(bend) = &motion.bend else {
        return Ok(Curve::line(motion.start, motion.end));
    };
    let ends = [motion.start, motion.end];
    // Derivatives by arc length: the unit tangent, and the curvature vector in 1/mm.
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

/// One move of a program: its curve in machine coordinates, with what was in force.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ProgrammedMove {
    /// Curve, feed, path control, tool and block.
    pub motion: Move,
    /// Plane in force (G17 to G19).
    pub plane: Plane,
    /// Origin of the program's coordinates in machine coordinates, mm.
    pub origin_mm: [f64; 3],
    /// The same of all axes, mm and rad.
    pub origin: Coords,
    /// Whether the curve is that of the tool's tip; else that of the linear joints.
    pub is_tip: bool,
}

impl ProgrammedMove {
    /// Whether it is a G0 move.
    pub fn is_rapid(&self) -> bool {
        self.motion.feed == FeedLimit::Rapid
    }
}

/// The moves of a program, made as they are asked for; ends at the first error.
pub struct Curves {
    reader: Reader,
    name: String,
    over: bool,
}

impl Curves {
    pub(crate) fn new(setup: &Setup<'_>) -> Result<Curves, SimError> {
        Ok(Curves {
            reader: Reader::new(setup)?,
            name: setup.program.name().to_owned(),
            over: false,
        })
    }

    fn made(&self, read: &Read) -> Result<Option<ProgrammedMove>, SimError> {
        let MotionItem::Move(motion) = &read.item else {
            return Ok(None);
        };
        let motion_of = planned_move(motion)
            .map_err(|error| error.with_provenance(self.reader.diagnostics()))?;
        Ok(Some(ProgrammedMove {
            motion: motion_of,
            plane: read.plane,
            origin_mm: motion.origin.linear(),
            origin: motion.origin,
            is_tip: read.tip,
        }))
    }
}

impl Iterator for Curves {
    type Item = Result<ProgrammedMove, SimError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.over {
            let item = match self.reader.next() {
                None => {
                    self.over = true;
                    // Errors of the text do not stop the reader: they are told at its end.
                    let found = self.reader.diagnostics();
                    return (found.errors() > 0).then(|| {
                        Err(SimError::Program {
                            name: self.name.clone(),
                            diagnostics: Box::new(found.clone()),
                        })
                    });
                }
                Some(Ok(read)) => self.made(&read).transpose(),
                Some(Err((problem, place))) => {
                    Some(Err(self.reader.refused(&self.name, problem, place)))
                }
            };
            if let Some(item) = item {
                // What lies behind an error would start in the wrong place.
                self.over = item.is_err();
                return Some(item);
            }
        }
        None
    }
}
