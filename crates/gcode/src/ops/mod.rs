//! Canonical operations: what a program does, resolved and free of modes.
//!
//! Numbers are as the program has them: lengths in the units in force (millimetres or inches),
//! angles in degrees, positions without offsets. [`crate::motion`] turns them into machine
//! coordinates in mm and rad.

mod parts;

pub use lostmotion_base::Plane;
use lostmotion_base::span::BlockRef;
pub use parts::Tilt;
pub use parts::{
    ArcFeed, ControlPoint, NurbsFeed, OrientWay, OutputValue, PathControl, Position, StraightProbe,
    TextKind, Units, WaitFor,
};
use serde::{Deserialize, Serialize};

/// One action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum CanonicalOp {
    /// Units of all following lengths.
    UseLengthUnits(Units),
    /// Origin of a work coordinate system, 1 for G54 to 9 for G59.3, 10 for G54.1 P1 and on.
    SetG5xOffset {
        /// Number of the system.
        system: u16,
        /// Its origin.
        offset: Position,
    },
    /// G92 and G52 offset.
    SetG92Offset(Position),
    /// Rotation of the work coordinate system about Z, degrees.
    SetXyRotation(f64),
    /// Feed in units per minute, or per revolution in that mode.
    SetFeedRate {
        /// The rate. Degrees when only rotary axes move.
        rate: f64,
        /// The F word per minute, if the rate came from inverse time.
        inverse_time: Option<f64>,
    },
    /// Whether the feed is per revolution of the spindle.
    SetFeedMode {
        /// G95.
        per_revolution: bool,
    },
    /// Motion at full speed.
    StraightTraverse(Position),
    /// Motion at the feed rate.
    StraightFeed(Position),
    /// Circular motion at the feed rate.
    ArcFeed(ArcFeed),
    /// Motion along a curve at the feed rate.
    NurbsFeed(Box<NurbsFeed>),
    /// Motion that a probe ends.
    StraightProbe(Box<StraightProbe>),
    /// Down to X Y Z in step with the spindle, then back with the spindle reversed.
    RigidTap([f64; 3]),
    /// From here the feed follows the spindle: units per revolution.
    StartSpeedFeedSync(f64),
    /// The feed is free of the spindle.
    StopSpeedFeedSync,
    /// A pause, seconds.
    Dwell(f64),
    /// The plane of arcs.
    SelectPlane(Plane),
    /// Path control.
    SetMotionControlMode(PathControl),
    /// Tolerance for merging short collinear moves, program units; 0 is off.
    SetNaiveCamTolerance(f64),
    /// Turned coordinates (G68, G68.2); `None` with G69.
    SetTilt(Option<Box<Tilt>>),
    /// Whether X Y Z are the tool's tip, whatever the rotary axes do (G43.4, G43.5).
    ToolTipControl(bool),
    /// The tool turns to a direction, a unit vector from its tip to the spindle in the workpiece's
    /// coordinates (G53.1), or in those of the program with the next move (G43.5).
    OrientTool([f64; 3]),
    /// Offset of the tool in force.
    UseToolLengthOffset(Position),
    /// The tool that the next change will bring.
    SelectTool(i32),
    /// A tool change begins.
    StartChange,
    /// The tool is in the spindle.
    ChangeTool(i32),
    /// The tool in the spindle is another than thought; nothing moves.
    ChangeToolNumber(i32),
    /// Speed of a spindle.
    SetSpindleSpeed {
        /// Which spindle.
        spindle: u8,
        /// rev/min, or units of surface speed.
        speed: f64,
    },
    /// Constant surface speed up to a number of rev/min; 0 turns it off.
    SetSpindleMode {
        /// Which spindle.
        spindle: u8,
        /// Highest rev/min.
        highest: f64,
    },
    /// Starts a spindle.
    StartSpindle {
        /// Which spindle.
        spindle: u8,
        /// M3; otherwise M4.
        clockwise: bool,
    },
    /// Stops a spindle.
    StopSpindle {
        /// Which spindle.
        spindle: u8,
    },
    /// Turns a spindle to an angle.
    OrientSpindle {
        /// Which spindle.
        spindle: u8,
        /// The angle.
        degrees: f64,
        /// Which way round.
        way: OrientWay,
        /// In the course of a boring cycle (G87), whose record has other numbers for the ways.
        boring: bool,
    },
    /// Waits until the spindle has been turned to its angle; the value is the longest wait, s.
    WaitOrient {
        /// Which spindle.
        spindle: u8,
        /// At most this long, s.
        seconds: f64,
    },
    /// Sets an output.
    SetOutput {
        /// Which output of its kind.
        index: u8,
        /// To what.
        value: OutputValue,
        /// With the beginning of the next move (M62, M63, M67); otherwise at once.
        with_motion: bool,
    },
    /// Reads an input, after waiting for it.
    ReadInput {
        /// Which input of its kind.
        index: u8,
        /// An analogue one.
        analog: bool,
        /// What to wait for.
        wait: WaitFor,
        /// At most this long, s.
        seconds: f64,
    },
    /// Mist coolant on or off.
    Mist(bool),
    /// Flood coolant on or off.
    Flood(bool),
    /// Whether the feed may be overridden.
    FeedOverride(bool),
    /// Whether the spindle's speed may be overridden.
    SpeedOverride(bool),
    /// Whether the feed may be adapted.
    AdaptiveFeed(bool),
    /// Whether a feed hold is obeyed.
    FeedHold(bool),
    /// A text.
    Text {
        /// Where it goes.
        kind: TextKind,
        /// The text; bytes that are not UTF-8 are replaced.
        text: String,
    },
    /// M0: stop until told to go on.
    ProgramStop,
    /// M1: the same if the operator wants it.
    OptionalProgramStop,
    /// M60: exchange of pallets.
    PalletShuttle,
    /// M2 or M30.
    ProgramEnd,
}

/// An operation with the block it came from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SourcedOp {
    /// What to do.
    pub op: CanonicalOp,
    /// Because of which block.
    pub block: BlockRef,
    /// Axes whose place the block itself says, absolute or by a way home: bit 0 for X to 8 for W. A word that
    /// leads to where the axis is believed to stand counts, since the machine may stand elsewhere.
    #[serde(skip)]
    pub named: u16,
}
