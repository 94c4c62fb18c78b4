//! Operations in one frame, without what changes nothing: what has been set last need not be set again.

use super::WriterError;
use lostmotion_base::span::BlockRef;
use lostmotion_gcode::config::InterpreterConfig;
use lostmotion_gcode::ops::{
    ArcFeed, CanonicalOp, ControlPoint, NurbsFeed, PathControl, Plane, Position, SourcedOp,
    StraightProbe, Units,
};
use lostmotion_gcode::parameters::SYSTEM_ORIGINS;
use lostmotion_gcode::state::{Offsets, add, convert, rotate, subtract};

/// A work coordinate system whose origin stays where it is: what the coordinates of a written
/// program are about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// 1 for G54 to 9 for G59.3.
    pub system: u8,
    /// Its origin in machine coordinates, in the units that a program starts in, and degrees.
    pub origin: Position,
    /// Those units.
    pub units: Units,
}

impl Frame {
    /// A work coordinate system as an interpreter's parameters have it before the program.
    ///
    /// # Errors
    /// The system does not exist or is rotated.
    pub fn of(config: &InterpreterConfig, system: u8) -> Result<Frame, WriterError> {
        if !(1..=9).contains(&system) {
            return Err(WriterError::NoSuchSystem { system });
        }
        // Parameters of a system: 9 axes from `first`, the rotation at `first + 9`, the next
        // system 20 on.
        let first = SYSTEM_ORIGINS + 20 * (u16::from(system) - 1);
        let value = |number: u16| {
            config
                .parameters
                .iter()
                // Later settings of a parameter replace earlier ones.
                .rev()
                .find(|(known, _)| *known == number)
                .map_or(0.0, |(_, value)| *value)
        };
        let degrees = value(first + 9);
        if degrees != 0.0 {
            return Err(WriterError::RotatedFrame { system, degrees });
        }
        let origin: Position = std::array::from_fn(|axis| value(first + axis as u16));
        Ok(Frame {
            system,
            origin: convert(&origin, config.machine_units, config.program_units),
            units: config.program_units,
        })
    }
}

/// Brings operations into a frame. Operations that set an offset go, and so do those that set what
/// is set already.
#[derive(Clone, Debug)]
pub struct Resolver {
    units: Units,
    origin: Position,
    offsets: Offsets,
    settled: Settled,
    /// The end of a move in step with the spindle, which another such move may follow.
    stop_sync: bool,
    /// Where the tool is believed to be; `None` before the offsets in force at the start are told.
    at: Option<Position>,
}

impl Resolver {
    /// A resolver before the first operation of an interpreter with this configuration.
    pub fn new(config: &InterpreterConfig, frame: Frame) -> Resolver {
        let (units, origin) = (config.program_units, frame.origin);
        Resolver {
            units,
            origin,
            offsets: Offsets {
                g5x: origin,
                ..Offsets::default()
            },
            settled: Settled::new(units),
            stop_sync: false,
            at: None,
        }
    }

    /// Takes an operation and gives what it is in the frame: none, one, or two if one was held
    /// back.
    ///
    /// # Errors
    /// An arc that a rotation turns out of its plane.
    pub fn push(&mut self, sourced: &SourcedOp) -> Result<Vec<SourcedOp>, WriterError> {
        use CanonicalOp as O;
        let op = &sourced.op;
        // The end of a synchronised move is held back: a second one that follows keeps the mode on.
        if self.stop_sync && matches!(op, O::StartSpeedFeedSync(_)) {
            self.stop_sync = false;
        }
        // Any other operation lets the held end go first.
        let mut out: Vec<CanonicalOp> = std::mem::take(&mut self.stop_sync)
            .then_some(O::StopSpeedFeedSync)
            .into_iter()
            .collect();
        if out.first().is_some_and(|stop| !self.settled.is_news(stop)) {
            out.clear();
        }
        match op {
            O::SetG5xOffset { offset, .. } => self.offsets.g5x = *offset,
            O::SetG92Offset(offset) => self.offsets.g92 = *offset,
            O::SetXyRotation(degrees) => {
                self.offsets.rotation_deg = *degrees;
                // The last offset that the start tells: the tool is taken to stand at program zero.
                self.at = self.at.or_else(|| Some(self.place(&[0.0; 9])));
            }
            O::StopSpeedFeedSync => self.stop_sync = true,
            // G94 and the like take F back; no move is made without another one.
            O::SetFeedRate {
                rate: 0.0,
                inverse_time: None,
            } => {}
            op => {
                let op = self.resolved(op)?;
                if self.settled.is_news(&op) && !self.stays(&op, sourced.named) {
                    out.push(op);
                }
            }
        }
        let named = self.named(sourced.named);
        let block = sourced.block;
        Ok(out
            .into_iter()
            .map(|op| SourcedOp { op, block, named })
            .collect())
    }

    /// Whether an operation is a rapid that goes nowhere and says no place, such as the first half of
    /// `G91 G28 Z0`. Keeps where the tool is.
    fn stays(&mut self, op: &CanonicalOp, named: u16) -> bool {
        let end = match op {
            CanonicalOp::StraightTraverse(end) | CanonicalOp::StraightFeed(end) => *end,
            CanonicalOp::ArcFeed(arc) => arc.position(),
            CanonicalOp::StraightProbe(probe) => probe.stop,
            CanonicalOp::NurbsFeed(curve) => curve.end,
            _ => return false,
        };
        let before = self.at.replace(end);
        let is_there =
            before.is_some_and(|before| before.map(f64::to_bits) == end.map(f64::to_bits));
        matches!(op, CanonicalOp::StraightTraverse(_)) && named == 0 && is_there
    }

    /// Axes of the frame whose place is said: a rotation makes X and Y one.
    fn named(&self, named: u16) -> u16 {
        if self.offsets.rotation_deg != 0.0 && named & XY != 0 {
            named | XY
        } else {
            named
        }
    }

    /// What is still held back.
    pub fn finish(&mut self) -> Option<CanonicalOp> {
        std::mem::take(&mut self.stop_sync).then_some(CanonicalOp::StopSpeedFeedSync)
    }

    fn resolved(&mut self, op: &CanonicalOp) -> Result<CanonicalOp, WriterError> {
        use CanonicalOp as O;
        Ok(match op {
            O::UseLengthUnits(units) => {
                self.change_units(*units);
                op.clone()
            }
            O::StraightTraverse(end) => O::StraightTraverse(self.place(end)),
            O::StraightFeed(end) => O::StraightFeed(self.place(end)),
            O::ArcFeed(arc) => O::ArcFeed(self.arc(arc)?),
            O::NurbsFeed(curve) => O::NurbsFeed(Box::new(self.curve(curve))),
            O::StraightProbe(probe) => {
                let StraightProbe { end, stop, .. } = **probe;
                O::StraightProbe(Box::new(StraightProbe {
                    end: self.place(&end),
                    stop: self.place(&stop),
                    ..**probe
                }))
            }
            O::OrientSpindle {
                spindle,
                degrees,
                way,
                ..
            } => O::OrientSpindle {
                spindle: *spindle,
                degrees: *degrees,
                way: *way,
                boring: false,
            },
            O::RigidTap([x, y, z]) => {
                let [x, y, z, ..] = self.place(&[*x, *y, *z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                O::RigidTap([x, y, z])
            }
            other => other.clone(),
        })
    }

    fn change_units(&mut self, units: Units) {
        // Offsets are kept in the units in force, as the operations give them.
        let from = std::mem::replace(&mut self.units, units);
        for position in [
            &mut self.origin,
            &mut self.offsets.g5x,
            &mut self.offsets.g92,
        ]
        .into_iter()
        .chain(&mut self.at)
        {
            *position = convert(position, from, units);
        }
    }

    /// Program coordinates to those of the frame. Unchanged, to the bit, where the offsets are the
    /// frame's own.
    fn place(&self, program: &Position) -> Position {
        let mut work = *program;
        // The order of RS274/NGC: G92 and tool shift, then rotation about Z, then the system's
        // origin.
        if self.offsets.g92 != [0.0; 9] {
            work = add(&work, &self.offsets.g92);
        }
        rotate(&mut work, self.offsets.rotation_deg);
        if self.offsets.g5x != self.origin {
            work = subtract(&add(&work, &self.offsets.g5x), &self.origin);
        }
        // No negative zeros.
        work.map(|coordinate| coordinate + 0.0)
    }

    fn arc(&self, arc: &ArcFeed) -> Result<ArcFeed, WriterError> {
        let degrees = self.offsets.rotation_deg;
        if arc.plane != Plane::Xy && degrees != 0.0 {
            return Err(WriterError::RotatedArc {
                plane: arc.plane.name(),
                degrees,
                block: BlockRef::default(),
            });
        }
        let [first, second, normal] = arc.plane.axes();
        // The centre is carried as a place of the arc's plane, so that it shifts and turns with
        // the end.
        let mut center = arc.position();
        (center[first], center[second]) = (arc.center[0], arc.center[1]);
        let (center, end) = (self.place(&center), self.place(&arc.position()));
        let [_, _, _, others @ ..] = end;
        Ok(ArcFeed {
            end: [end[first], end[second]],
            center: [center[first], center[second]],
            axis_end: end[normal],
            others,
            ..*arc
        })
    }

    fn curve(&self, curve: &NurbsFeed) -> NurbsFeed {
        let point = |point: &ControlPoint| {
            let [x, y, ..] =
                self.place(&[point.at[0], point.at[1], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            ControlPoint {
                at: [x, y],
                ..*point
            }
        };
        NurbsFeed {
            points: curve.points.iter().map(point).collect(),
            end: self.place(&curve.end),
            ..curve.clone()
        }
    }
}

/// The bits of X and Y.
const XY: u16 = 0b11;

/// The last operation of each kind that only sets something.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    last: Vec<Option<CanonicalOp>>,
}

/// Kinds of settings that are remembered.
const KIND_COUNT: usize = 17;
/// That of feed rates.
const RATE_KIND: usize = 1;
/// That of the first spindle's turning.
const SPINDLE_KIND: usize = 9;

/// The kind of an operation that only sets something; `None` for all others.
fn kind(op: &CanonicalOp) -> Option<usize> {
    use CanonicalOp as O;
    Some(match op {
        O::UseLengthUnits(_) => 0,
        O::SetFeedRate { .. } => RATE_KIND,
        O::SetFeedMode { .. } => 2,
        O::SelectPlane(_) => 3,
        O::SetMotionControlMode(_) => 4,
        O::SetNaiveCamTolerance(_) => 5,
        O::UseToolLengthOffset(_) => 6,
        O::SetSpindleSpeed { spindle: 0, .. } => 7,
        O::SetSpindleMode { spindle: 0, .. } => 8,
        O::StartSpindle { spindle: 0, .. } | O::StopSpindle { spindle: 0 } => SPINDLE_KIND,
        O::Mist(_) => 10,
        O::Flood(_) => 11,
        O::FeedOverride(_) => 12,
        O::SpeedOverride(_) => 13,
        O::AdaptiveFeed(_) => 14,
        O::FeedHold(_) => 15,
        O::StartSpeedFeedSync(_) | O::StopSpeedFeedSync => 16,
        _ => return None,
    })
}

impl Settled {
    /// What is in force before a program.
    pub(super) fn new(units: Units) -> Settled {
        use CanonicalOp as O;
        let mut settled = Settled {
            last: vec![None; KIND_COUNT],
        };
        let start = [
            O::UseLengthUnits(units),
            O::SetFeedRate {
                rate: 0.0,
                inverse_time: None,
            },
            O::SetFeedMode {
                per_revolution: false,
            },
            O::SelectPlane(Plane::Xy),
            O::SetMotionControlMode(PathControl::Continuous { tolerance: 0.0 }),
            O::SetNaiveCamTolerance(0.0),
            O::UseToolLengthOffset([0.0; 9]),
            O::SetSpindleSpeed {
                spindle: 0,
                speed: 0.0,
            },
            O::SetSpindleMode {
                spindle: 0,
                highest: 0.0,
            },
            O::StopSpindle { spindle: 0 },
            O::Mist(false),
            O::Flood(false),
            O::FeedOverride(true),
            O::SpeedOverride(true),
            O::AdaptiveFeed(false),
            O::FeedHold(true),
            O::StopSpeedFeedSync,
        ];
        for op in start {
            settled.is_news(&op);
        }
        settled
    }

    /// Whether an operation changes anything; it is remembered.
    pub(super) fn is_news(&mut self, op: &CanonicalOp) -> bool {
        // Other units: remembered lengths no longer compare.
        if matches!(op, CanonicalOp::UseLengthUnits(_))
            && kind(op).is_some_and(|kind| self.last.get(kind) != Some(&Some(op.clone())))
        {
            self.forget_lengths();
        }
        // A spindle that has been turned to an angle stands still.
        if matches!(
            op,
            CanonicalOp::OrientSpindle { spindle: 0, .. }
                | CanonicalOp::WaitOrient { spindle: 0, .. }
        ) {
            self.forget(SPINDLE_KIND);
        }
        // Operations that act are always news.
        let Some(slot) = kind(op).and_then(|kind| self.last.get_mut(kind)) else {
            return true;
        };
        // The rate of an inverse time holds for one move.
        let lasting = !matches!(
            op,
            CanonicalOp::SetFeedRate {
                inverse_time: Some(_),
                ..
            }
        );
        let news = slot.as_ref() != Some(op);
        *slot = lasting.then(|| op.clone());
        // Each feed mode begins without a rate, so that the next F is news.
        if news && matches!(op, CanonicalOp::SetFeedMode { .. }) {
            self.forget(RATE_KIND);
        }
        news
    }

    /// The rate is of another kind, or gone.
    fn forget(&mut self, kind: usize) {
        if let Some(slot) = self.last.get_mut(kind) {
            *slot = None;
        }
    }

    /// In other units the same numbers mean something else.
    fn forget_lengths(&mut self) {
        for kind in [RATE_KIND, 4, 5, 6, 16] {
            if let Some(slot) = self.last.get_mut(kind) {
                *slot = slot
                    .take()
                    .filter(|op| matches!(op, CanonicalOp::StopSpeedFeedSync));
            }
        }
    }
}
