//! What an interpreter remembers from block to block.

pub(crate) mod held;
mod offsets;

use crate::code::Code;
use crate::ops::{PathControl, Plane, Position, Units};
pub use held::{Compensation, NurbsDraft, PendingCorner};
pub use offsets::Offsets;
pub(crate) use offsets::is_angle;
pub use offsets::{add, convert, rotate, subtract};
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
    /// 1 for G54 to 9 for G59.3.
    pub system: u8,
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
    /// Line being executed, from 1.
    pub line: u32,
    /// An M2, M30 or closing % has been reached.
    pub ended: bool,
    /// A code that may have been a motion mode was refused: what follows may lack a mode because of
    /// that.
    pub motion_unknown: bool,
    /// The missing feed has been reported.
    pub feed_missed: bool,
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
            line: 0,
            ended: false,
            motion_unknown: false,
            feed_missed: false,
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
