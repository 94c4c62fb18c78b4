//! Canonical operations folded into motion: machine coordinates in mm and rad, with everything that
//! was in force.
//!
//! Positions are those of the controlled point in the machine frame without the tool: program
//! coordinates plus the G92 offset, rotated about Z, plus the origin of the work coordinate system.
//! The spindle is at that place plus the tool offset, which every motion carries.

use crate::ops::{ArcFeed, CanonicalOp, PathControl, Plane, Position, SourcedOp, Units};
use crate::problem::Problem;
use crate::state::{Offsets, convert, is_angle};
use lostmotion_base::Coords;
use lostmotion_base::span::BlockRef;
use lostmotion_base::units::{deg, rad};
use serde::{Deserialize, Serialize};

mod bend;
mod item;
mod several;
mod spline;

pub use item::{Bend, Circle, Feed, Motion, MotionItem, PathMode};
pub use several::SPLINE_TOLERANCE_MM;
pub(crate) use several::curve_length;

/// Folds operations into motion. State only: small, cloneable, serialisable.
///
/// ```
/// use lostmotion_base::Coords;
/// use lostmotion_gcode::{InterpreterConfig, MotionFold, MotionItem, Program};
///
/// let mut origin = Coords::ZERO;
/// origin.0[0] = -300.0;
/// let config = InterpreterConfig::default().with_work_offset(1, origin);
/// let mut fold = MotionFold::new(config.start);
/// let mut moves = Vec::new();
/// for sourced in Program::new(&b"G54 G21 G1 X10 F600\nM2\n"[..], config) {
///     if let Some(MotionItem::Move(motion)) = fold.push(&sourced)? {
///         moves.push(motion);
///     }
/// }
/// // Machine coordinates: the origin of G54 and the programmed 10 mm.
/// assert_eq!(moves[0].end.0[0], -290.0);
/// # Ok::<(), lostmotion_gcode::Problem>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionFold {
    units: Units,
    /// Offsets in mm and degrees; the tool's is kept apart.
    offsets: Offsets,
    tool: Coords,
    /// Where the controlled point is, mm and rad.
    at: Coords,
    /// F in the units of its line: mm and degrees.
    rate_mm: f64,
    rate_deg: f64,
    inverse_time: Option<f64>,
    per_revolution: bool,
    /// Distance per revolution of a move in step with the spindle, mm.
    pitch_mm: Option<f64>,
    spindle_speed: f64,
    spindle_on: bool,
    /// G96: the speed is along the surface, and revolutions depend on the radius.
    surface_speed: bool,
    /// M48 to M50.
    feed_override: bool,
    control: PathControl,
    merge: f64,
    spline_tolerance_mm: f64,
}

impl MotionFold {
    /// Starts with the spindle, without a tool offset, at a place in the machine frame, mm and rad.
    pub fn new(start: Coords) -> MotionFold {
        MotionFold {
            units: Units::Mm,
            offsets: Offsets::default(),
            tool: Coords::ZERO,
            at: start,
            rate_mm: 0.0,
            rate_deg: 0.0,
            inverse_time: None,
            per_revolution: false,
            pitch_mm: None,
            spindle_speed: 0.0,
            spindle_on: false,
            surface_speed: false,
            feed_override: true,
            control: PathControl::Continuous { tolerance: 0.0 },
            merge: 0.0,
            spline_tolerance_mm: SPLINE_TOLERANCE_MM,
        }
    }

    /// How far the polynomials may lie from the spline that they stand for, mm.
    #[must_use]
    pub fn with_spline_tolerance_mm(self, spline_tolerance_mm: f64) -> MotionFold {
        MotionFold {
            spline_tolerance_mm,
            ..self
        }
    }

    /// Where the controlled point is, mm and rad.
    pub fn position(&self) -> Coords {
        self.at
    }

    /// The tool offset in force, mm and rad.
    pub fn tool_offset(&self) -> Coords {
        self.tool
    }

    /// Tells where the controlled point is after a move that is not in the program, mm and rad.
    pub fn moved_to(&mut self, at: Coords) {
        self.at = at;
    }

    /// A direction of the program in the machine's frame: turned as its coordinates are.
    pub fn turned(&self, direction: [f64; 3]) -> [f64; 3] {
        let place = |[x, y, z]: [f64; 3]| {
            self.machine(&[x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
                .linear()
        };
        // The difference of two places turns with the rotation and loses the shifts.
        let (from, to) = (
            place([0.0; 3]),
            place(direction.map(|c| c / self.units.mm())),
        );
        std::array::from_fn(|axis| to[axis] - from[axis])
    }

    /// A rapid move that no operation asks for by its coordinates.
    pub fn rapid_to(&mut self, end: Coords, block: BlockRef) -> MotionItem {
        self.advance(end, None, Feed::Rapid, block)
    }

    /// Takes one operation and gives what it makes the machine do, if anything. What makes several
    /// moves (splines and rigid tapping) needs [`MotionFold::push_all`].
    ///
    /// # Errors
    /// Operations of several moves; feed per revolution at constant surface speed, which is not
    /// motion yet; feed per revolution without a turning spindle; an arc whose plane is none of the
    /// machine's, because the coordinates are turned or tilted.
    pub fn push(&mut self, sourced: &SourcedOp) -> Result<Option<MotionItem>, Problem> {
        let block = sourced.block;
        Ok(Some(match &sourced.op {
            CanonicalOp::StraightTraverse(end) => {
                let end = self.machine(end);
                self.advance(end, None, Feed::Rapid, block)
            }
            CanonicalOp::StraightFeed(end) => {
                let end = self.machine(end);
                let feed = self.feed(&end, "G1")?;
                self.advance(end, None, feed, block)
            }
            // Nothing is touched: the probe goes to where the program takes it to have stopped.
            CanonicalOp::StraightProbe(probe) => {
                let end = self.machine(&probe.stop);
                let feed = self.feed(&end, "G38")?;
                self.advance(end, None, feed, block)
            }
            CanonicalOp::NurbsFeed(_) => {
                return Err(Problem::NoMotionFor {
                    what: "a spline (G5, G5.1, G5.2), as one move,",
                });
            }
            CanonicalOp::RigidTap(_) => {
                return Err(Problem::NoMotionFor {
                    what: "rigid tapping (G33.1), as one move,",
                });
            }
            CanonicalOp::OrientTool(_) => {
                return Err(Problem::NoMotionFor {
                    what: "a direction of the tool (G53.1, or I J K under G43.5), instead of angles of the rotary axes,",
                });
            }
            CanonicalOp::ArcFeed(arc) if self.tilts(arc.plane) => {
                return Err(Problem::NoMotionFor {
                    what: "an arc in a plane that is turned or tilted, as one move,",
                });
            }
            CanonicalOp::ArcFeed(arc) => {
                let end = self.machine(&arc.position());
                let feed = self.arc_feed()?;
                let circle = self.circle(arc);
                self.advance(end, Some(circle), feed, block)
            }
            CanonicalOp::Dwell(seconds) => MotionItem::Dwell {
                seconds: seconds.max(0.0),
                block,
            },
            CanonicalOp::ChangeTool(tool) => MotionItem::ToolChange { tool: *tool, block },
            CanonicalOp::ProgramStop => MotionItem::Stop {
                optional: false,
                block,
            },
            CanonicalOp::OptionalProgramStop => MotionItem::Stop {
                optional: true,
                block,
            },
            CanonicalOp::ProgramEnd => MotionItem::End { block },
            setting => {
                self.set(setting);
                return Ok(None);
            }
        }))
    }

    fn advance(
        &mut self,
        end: Coords,
        circle: Option<Circle>,
        feed: Feed,
        block: BlockRef,
    ) -> MotionItem {
        // F in inverse time is the reciprocal of the duration in minutes.
        let per_minute = self.inverse_time.filter(|_| feed != Feed::Rapid);
        let motion = Motion {
            start: self.at,
            end,
            circle,
            bend: None,
            feed,
            duration_s: per_minute.map(|per_minute| 60.0 / per_minute),
            feed_override: self.feed_override && self.pitch_mm.is_none(),
            path: self.path(),
            tool_offset: self.tool,
            origin: self.machine(&[0.0; 9]),
            block,
        };
        self.at = end;
        MotionItem::Move(motion)
    }

    /// Whether the circles of a plane's arcs do not lie in a plane of the machine.
    pub(super) fn tilts(&self, plane: Plane) -> bool {
        match plane {
            // A rotation about Z keeps circles of the XY plane, but not those of the others.
            Plane::Xy => self.offsets.tilt.is_some_and(|tilt| !tilt.keeps_plane()),
            Plane::Zx | Plane::Yz => {
                self.offsets.tilt.is_some() || self.offsets.rotation_deg != 0.0
            }
        }
    }

    fn path(&self) -> PathMode {
        match self.control {
            PathControl::ExactPath => PathMode::ExactPath,
            PathControl::ExactStop => PathMode::ExactStop,
            PathControl::Continuous { tolerance } => PathMode::Continuous {
                tolerance_mm: if tolerance > 0.0 {
                    Some(tolerance)
                } else {
                    None
                },
                merge_mm: self.merge,
            },
        }
    }

    /// Where the controlled point is, as the program has it.
    pub fn program_place(&self) -> Position {
        // mm and rad to mm and degrees, then through the offsets, then to program units.
        let at: Position = std::array::from_fn(|axis| {
            if is_angle(axis) {
                deg(self.at.0[axis])
            } else {
                self.at.0[axis]
            }
        });
        convert(&self.offsets.to_program(&at), Units::Mm, self.units)
    }

    fn machine(&self, program: &Position) -> Coords {
        coords(
            &self
                .offsets
                .to_machine(&convert(program, self.units, Units::Mm)),
        )
    }

    fn circle(&self, arc: &ArcFeed) -> Circle {
        let [first, second, _] = arc.plane.axes();
        // The centre goes through the offsets as a place in the arc's plane.
        let mut center = arc.position();
        (center[first], center[second]) = (arc.center[0], arc.center[1]);
        let center = self.machine(&center);
        Circle {
            plane: arc.plane,
            center_mm: [center.0[first], center.0[second]],
            turns: arc.turns,
        }
    }
}

/// Millimetres and degrees to mm and rad.
fn coords(position: &Position) -> Coords {
    Coords(std::array::from_fn(|index| {
        if is_angle(index) {
            rad(position[index])
        } else {
            position[index]
        }
    }))
}

impl MotionFold {
    /// Takes an operation that sets something.
    fn set(&mut self, op: &CanonicalOp) {
        match op {
            CanonicalOp::UseLengthUnits(units) => self.units = *units,
            // Lengths are stored in mm: a later change of units does not touch them.
            CanonicalOp::SetG5xOffset { offset, .. } => {
                self.offsets.g5x = convert(offset, self.units, Units::Mm);
            }
            CanonicalOp::SetG92Offset(offset) => {
                self.offsets.g92 = convert(offset, self.units, Units::Mm);
            }
            CanonicalOp::SetTilt(tilt) => {
                self.offsets.tilt = tilt
                    .as_deref()
                    .map(|tilt| tilt.convert(self.units, Units::Mm));
            }
            CanonicalOp::SetXyRotation(degrees) => self.offsets.rotation_deg = *degrees,
            CanonicalOp::UseToolLengthOffset(offset) => {
                let tool = coords(&convert(offset, self.units, Units::Mm));
                // The spindle stays where it is.
                self.at = self.at + self.tool - tool;
                self.tool = tool;
            }
            // The same F counts in mm or in degrees: which of them, the move decides.
            CanonicalOp::SetFeedRate { rate, inverse_time } => {
                (self.rate_mm, self.rate_deg, self.inverse_time) =
                    (*rate * self.units.mm(), *rate, *inverse_time);
            }
            CanonicalOp::StartSpeedFeedSync(pitch) => {
                self.pitch_mm = Some(*pitch * self.units.mm());
            }
            CanonicalOp::StopSpeedFeedSync => self.pitch_mm = None,
            CanonicalOp::FeedOverride(on) => self.feed_override = *on,
            CanonicalOp::SetFeedMode { per_revolution } => self.per_revolution = *per_revolution,
            CanonicalOp::SetSpindleSpeed { spindle: 0, speed } => self.spindle_speed = *speed,
            CanonicalOp::SetSpindleMode {
                spindle: 0,
                highest,
            } => self.surface_speed = *highest > 0.0,
            CanonicalOp::StartSpindle { spindle: 0, .. } => self.spindle_on = true,
            CanonicalOp::StopSpindle { spindle: 0 } => self.spindle_on = false,
            CanonicalOp::SetMotionControlMode(PathControl::Continuous { tolerance }) => {
                self.control = PathControl::Continuous {
                    tolerance: *tolerance * self.units.mm(),
                };
            }
            CanonicalOp::SetMotionControlMode(control) => self.control = *control,
            CanonicalOp::SetNaiveCamTolerance(tolerance) => {
                self.merge = *tolerance * self.units.mm();
            }
            _ => {}
        }
    }
}

impl MotionFold {
    /// What a rate is multiplied by: the spindle's speed if it is per revolution.
    fn per_minute(&self, code: &'static str) -> Result<f64, Problem> {
        match self.per_revolution {
            false => Ok(1.0),
            true if self.surface_speed => self.revolutions_are_known().map(|()| 0.0),
            true if self.spindle_on && self.spindle_speed > 0.0 => Ok(self.spindle_speed),
            true => Err(Problem::NoRevolutions { code }),
        }
    }

    /// At constant surface speed the spindle's speed changes along the move.
    fn revolutions_are_known(&self) -> Result<(), Problem> {
        let what = "a feed per revolution at constant surface speed (G95 or G33 with G96)";
        if self.surface_speed {
            Err(Problem::NoMotionFor { what })
        } else {
            Ok(())
        }
    }

    fn feed(&self, end: &Coords, code: &'static str) -> Result<Feed, Problem> {
        // In step with the spindle: travel per revolution times revolutions per minute.
        if let Some(pitch_mm) = self.pitch_mm {
            self.revolutions_are_known()?;
            return match self.spindle_on && self.spindle_speed > 0.0 && pitch_mm != 0.0 {
                true => Ok(Feed::MmPerMin(pitch_mm.abs() * self.spindle_speed)),
                false => Err(Problem::NoRevolutions { code: "G33" }),
            };
        }
        let per_minute = self.per_minute(code)?;
        let moves = |index: usize| end.0[index] != self.at.0[index];
        // RS274/NGC: F is along the linear axes if any of them moves, else along the rotary ones.
        let linear = (0..9).any(|index| !is_angle(index) && moves(index));
        let turns = (3..6).any(moves);
        Ok(if linear || !turns {
            Feed::MmPerMin(self.rate_mm * per_minute)
        } else {
            Feed::RadPerMin(rad(self.rate_deg * per_minute))
        })
    }

    fn arc_feed(&self) -> Result<Feed, Problem> {
        Ok(Feed::MmPerMin(self.rate_mm * self.per_minute("G2 or G3")?))
    }
}
