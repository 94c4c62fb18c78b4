//! What an interpreter remembers from block to block: modes, offsets, and what waits for the blocks that
//! follow (a move under cutter compensation, a corner, a NURBS).

use crate::codes::Code;
use crate::ops::{ControlPoint, PathControl, Plane, Position, SourcedOp, Tilt, Units};
use lostmotion_base::math;
use lostmotion_base::span::BlockRef;
use lostmotion_base::units::rad;
use lostmotion_base::vec::Vec2;
use serde::{Deserialize, Serialize};

/// What F means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FeedMode {
    /// G93: 1/min, one per move.
    InverseTime,
    /// G94.
    PerMinute,
    /// G95.
    PerRevolution,
}

/// Whether the tool's tip is what the program moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TipControl {
    /// G49.
    #[default]
    Off,
    /// G43.4.
    On,
    /// G43.5: I J K of straight moves are the direction of the tool.
    WithVector,
}

/// A spindle's state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spindle {
    /// S.
    pub speed: f64,
    /// Whether it turns, and which way: clockwise is true.
    pub clockwise: Option<bool>,
    /// Highest rev/min of constant surface speed (G96).
    pub surface_limit: Option<f64>,
}

/// The modes and the position. Lengths in program units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// G20, G21.
    pub units: Units,
    /// G17 to G19.
    pub plane: Plane,
    /// G90; otherwise G91.
    pub absolute: bool,
    /// G90.1; otherwise G91.1.
    pub arc_absolute: bool,
    /// G93 to G95.
    pub feed_mode: FeedMode,
    /// Feed rate in force; 0 before the first F.
    pub feed: f64,
    /// Motion mode; `None` after G80.
    pub motion: Option<Code>,
    /// G7: X is a diameter.
    pub diameter: bool,
    /// Cutter compensation in force (G41, G42).
    pub compensation: Option<Box<Compensation>>,
    /// Cutter compensation has just ended: the next move has to be straight.
    pub arc_not_allowed: bool,
    /// Where the last G5 leads on to.
    pub spline_exit: Option<[f64; 2]>,
    /// The NURBS block that has begun (G5.2).
    pub nurbs: Option<Box<NurbsDraft>>,
    /// A corner to be rounded or chamfered when the next move is known.
    pub corner: Option<Box<PendingCorner>>,
    /// Where the corner before the present move ends, if there was one.
    pub corner_exit: Option<Position>,
    /// G43.4, G43.5.
    pub tip_control: TipControl,
    /// Spindle 0.
    pub spindle: Spindle,
    /// Spindles 1 to 7 (`$`).
    pub more_spindles: [Spindle; 7],
    /// Tool that T named.
    pub selected_tool: Option<i32>,
    /// Tool in the spindle.
    pub loaded_tool: i32,
    /// 1 for G54 to 9 for G59.3, 10 for G54.1 P1 and on.
    pub system: u16,
    /// Offsets in force.
    pub offsets: Offsets,
    /// Where the tool is, in program coordinates.
    pub current: Position,
    /// G61, G61.1, G64.
    pub path_control: PathControl,
    /// Q of G64.
    pub merge_tolerance: f64,
    /// M8.
    pub flood: bool,
    /// M7.
    pub mist: bool,
    /// M48 and M50.
    pub feed_override: bool,
    /// M48 and M51.
    pub speed_override: bool,
    /// M52.
    pub adaptive_feed: bool,
    /// M53.
    pub feed_hold: bool,
    /// G98: cycles retract to where they began; otherwise to R (G99).
    pub retract_to_start: bool,
    /// The words that cycles keep between blocks.
    pub cycle: CycleWords,
    /// The motion mode before the canned cycle in force: Fanuc's G80 brings it back.
    pub before_cycle: Option<Code>,
    /// M29: G84 and G74 turn the spindle themselves.
    pub rigid_tapping: bool,
    /// Line being executed, from 1.
    pub line: u32,
    /// An M2, M30 or closing % has been reached.
    pub ended: bool,
    /// A code that may have been a motion mode was refused: what follows may lack a mode because of
    /// that.
    pub motion_unknown: bool,
    /// The missing feed has been reported.
    pub feed_missed: bool,
    /// Bits of the axes whose place is not known, because a word of theirs was refused.
    pub doubtful: u32,
}

/// Words of a canned cycle that later blocks of the same cycle reuse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CycleWords {
    /// Level along the plane's normal at which the run of cycles began.
    pub level: Option<f64>,
    /// Clearance plane.
    pub r: Option<f64>,
    /// Bottom along the plane's normal.
    pub bottom: Option<f64>,
    /// Dwell.
    pub p: Option<f64>,
    /// Dwell of the last cycle that had one: tapping takes it.
    pub last_p: f64,
    /// Peck depth.
    pub q: Option<f64>,
    /// Spindle that taps (`$`).
    pub spindle: u8,
    /// I, J and K.
    pub ijk: [Option<f64>; 3],
}

impl State {
    /// The state a program starts in.
    pub fn new(units: Units) -> State {
        State {
            units,
            plane: Plane::Xy,
            absolute: true,
            arc_absolute: false,
            feed_mode: FeedMode::PerMinute,
            feed: 0.0,
            motion: None,
            diameter: false,
            compensation: None,
            arc_not_allowed: false,
            spline_exit: None,
            nurbs: None,
            corner: None,
            corner_exit: None,
            tip_control: TipControl::default(),
            spindle: Spindle::default(),
            more_spindles: [Spindle::default(); 7],
            selected_tool: None,
            loaded_tool: 0,
            system: 1,
            offsets: Offsets::default(),
            current: [0.0; 9],
            path_control: PathControl::Continuous { tolerance: 0.0 },
            merge_tolerance: 0.0,
            flood: false,
            mist: false,
            feed_override: true,
            speed_override: true,
            adaptive_feed: false,
            feed_hold: true,
            retract_to_start: false,
            cycle: CycleWords::default(),
            before_cycle: None,
            rigid_tapping: false,
            line: 0,
            ended: false,
            motion_unknown: false,
            feed_missed: false,
            doubtful: 0,
        }
    }

    /// Changes offsets without moving: the program coordinates of the same place follow.
    pub fn rebase(&mut self, change: impl FnOnce(&mut Offsets)) {
        // The machine stands still: its place before the change is its place after it.
        let machine = self.offsets.to_machine(&self.current);
        change(&mut self.offsets);
        self.current = self.offsets.to_program(&machine);
    }

    /// Machine coordinates of the spindle.
    pub fn machine(&self) -> Position {
        self.offsets.to_machine(&self.current)
    }
}

/// Cutter compensation in force. Lengths in program units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compensation {
    /// Distance to the left of the path; negative is to the right.
    pub(crate) left: f64,
    /// Orientation of a lathe tool's nose, 0 to 9.
    pub(crate) orientation: u8,
    /// The last offset move and where it ends; `None` before the first.
    pub(crate) last: Option<Edge>,
    /// The last move has gone out: its end is fixed.
    pub(crate) fixed: bool,
    /// Operations that wait for the end of the last move; the first is that move.
    pub(crate) held: Vec<HeldOp>,
    /// Where a profile that has been read since ends, and the tool is taken to be.
    pub(crate) strayed: Option<Vec2>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct HeldOp {
    pub(crate) sourced: SourcedOp,
    /// Its end in the plane is that of the held move.
    pub(crate) follows: bool,
}

impl Compensation {
    /// What `#<_ccomp>` shows.
    pub(crate) fn code(&self) -> f64 {
        if self.left > 0.0 { 410.0 } else { 420.0 }
    }

    /// Whether it moves the path at all.
    pub(crate) fn acts(&self) -> bool {
        self.left != 0.0
    }
}

/// What an offset move follows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Shape {
    /// A line in a direction.
    Line(Vec2),
    /// A circle.
    Arc {
        center: Vec2,
        radius: f64,
        counter_clockwise: bool,
    },
}

/// An offset move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Edge {
    pub(crate) shape: Shape,
    /// Where it begins.
    pub(crate) start: Vec2,
    /// Where it ends, as far as is known.
    pub(crate) end: Vec2,
    /// It leads from the path to its offset.
    pub(crate) entry: bool,
    /// It leads from where the tool was taken to be, not from the path: only a corner at its end
    /// tells whether it fits.
    pub(crate) astray: bool,
    /// The programmed direction at its end.
    pub(crate) leaves: Vec2,
}

/// A move whose end waits for the direction of the next one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PendingCorner {
    pub(crate) start: Position,
    pub(crate) corner: Position,
    pub(crate) size: f64,
    pub(crate) rounds: bool,
    pub(crate) block: BlockRef,
    pub(crate) named: u16,
}

/// A NURBS block that has begun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NurbsDraft {
    pub(crate) order: u32,
    pub(crate) points: Vec<ControlPoint>,
}

/// Modes that a level of calls has saved.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Saved {
    pub(crate) modes: Option<Box<State>>,
    /// Brought back when the level is left (M73).
    pub(crate) automatic: bool,
}

/// What G53, G54 and the like are about, and how far the tool reaches. Lengths in program units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Offsets {
    /// Origin of the work coordinate system.
    pub g5x: Position,
    /// G92 and G52 offset.
    pub g92: Position,
    /// Tool offset.
    pub tool: Position,
    /// Rotation about Z in degrees.
    pub rotation_deg: f64,
    /// Turned coordinates (G68, G68.2) in those of the workpiece.
    pub tilt: Option<Tilt>,
}

impl Offsets {
    /// Program coordinates to machine coordinates of the spindle: the work coordinates are turned,
    /// then shifted.
    pub fn to_machine(&self, program: &Position) -> Position {
        // Tilt, then G92, then the rotation of the system, then its origin and the tool.
        let mut work = *program;
        if let Some(tilt) = &self.tilt {
            tilt.apply(&mut work);
        }
        work = add(&work, &self.g92);
        rotate(&mut work, self.rotation_deg);
        add(&work, &add(&self.g5x, &self.tool))
    }

    /// Machine coordinates of the spindle to program coordinates.
    pub fn to_program(&self, machine: &Position) -> Position {
        // The steps of `to_machine` undone in reverse order.
        let mut work = subtract(machine, &add(&self.g5x, &self.tool));
        rotate(&mut work, -self.rotation_deg);
        work = subtract(&work, &self.g92);
        if let Some(tilt) = &self.tilt {
            tilt.undo(&mut work);
        }
        work
    }
}

/// Sum by axis.
pub fn add(a: &Position, b: &Position) -> Position {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

/// Difference by axis.
pub fn subtract(a: &Position, b: &Position) -> Position {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// Turns X and Y about the origin.
pub fn rotate(position: &mut Position, degrees: f64) {
    if degrees != 0.0 {
        let (sin, cos) = math::sin_cos(rad(degrees));
        let [x, y, ..] = *position;
        position[0] = x * cos - y * sin;
        position[1] = x * sin + y * cos;
    }
}

/// A position whose lengths are in other units.
pub fn convert(position: &Position, from: Units, to: Units) -> Position {
    let mut converted = *position;
    for (index, coordinate) in converted.iter_mut().enumerate() {
        if !is_angle(index) {
            *coordinate = from.convert(*coordinate, to);
        }
    }
    converted
}

/// Whether an axis index is one of A, B, C.
pub(crate) const fn is_angle(index: usize) -> bool {
    index >= 3 && index < 6
}
