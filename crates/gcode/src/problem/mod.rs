//! Everything that can be wrong with a program.

mod judged;
mod names;

use crate::code::Code;
use crate::dialect::Leniency;
use serde::Serialize;

/// What is wrong, with the values that show it. Lengths are in the program's units unless a name
/// says otherwise.
///
/// [`Problem::code`] is stable across releases; the wording is not.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize)]
#[non_exhaustive]
#[allow(missing_docs, reason = "each message names its fields")]
pub enum Problem {
    #[error("the line has {bytes} bytes, more than the limit of {limit}")]
    LineTooLong { bytes: usize, limit: usize },
    #[error("the source is longer than the limit of {limit} bytes; the rest is not read")]
    SourceTooLong { limit: u64 },
    #[error("more than {limit} words on one line")]
    TooManyWords { limit: usize },
    #[error("brackets, signs or # nested deeper than {limit}")]
    TooDeep { limit: usize },
    #[error("the source cannot be read: {message}")]
    Unreadable { message: String },
    #[error("a NUL byte in the program")]
    Nul,
    #[error("{} cannot stand here", show_byte(*.byte))]
    BadCharacter { byte: u8 },
    #[error("a number is missing after {after}")]
    MissingNumber { after: String },
    #[error("{text} is not a number")]
    BadNumber { text: String },
    #[error("{expected} expected")]
    Expected { expected: &'static str },
    #[error("{name} is not a function or operator")]
    UnknownName { name: String },
    #[error("the comment is not closed")]
    UnclosedComment,
    #[error("a ( inside a comment")]
    NestedComment,
    #[error("text before the first % of the program")]
    TextBeforePercent,

    #[error("N is only allowed at the start of a line")]
    MisplacedLineNumber,
    #[error("{letter} is given twice on one line")]
    RepeatedWord { letter: char },
    #[error("{value} is not a valid number for {letter}")]
    BadWordValue { letter: char, value: f64 },
    #[error("{code} is not a code of this interpreter")]
    UnsupportedCode { code: Code },
    #[error("{letter}{value} is not a code")]
    NotACode { letter: char, value: f64 },
    #[error("{} is not supported", .what)]
    Unsupported { what: String },
    #[error("{code} is {what}, which is not read")]
    ControlCycle {
        code: Code,
        what: &'static str,
        hint: &'static str,
    },
    #[error("{first} and {second} exclude each other: both set the {group}")]
    ModalConflict {
        first: Code,
        second: Code,
        group: &'static str,
    },
    #[error("no code on this line uses {letter}{value}")]
    UnusedWord {
        letter: char,
        value: f64,
        users: String,
    },
    #[error("{code} and {other} both use the axis words")]
    TwoAxisUsers { code: Code, other: Code },
    #[error("axis words without a code that uses them: no motion mode is active")]
    AxisWithoutCode,
    #[error("{code} without any axis word")]
    AxesMissing { code: Code },
    #[error("{code} does not take axis words")]
    AxesNotAllowed { code: Code },
    #[error("{code} needs {what}")]
    WordMissing { code: Code, what: &'static str },
    #[error("{letter}{value} for {code} has to be {allowed}")]
    WordOutOfRange {
        code: Code,
        letter: char,
        value: f64,
        allowed: &'static str,
    },

    #[error("{what} of {value}")]
    Domain { what: &'static str, value: f64 },
    #[error("the result is not a finite number")]
    NotFinite,
    #[error("division by zero")]
    DivisionByZero,
    #[error("parameter number {number} is outside 1 to 5602")]
    ParameterRange { number: f64 },
    #[error("parameter #{number} cannot be set")]
    ReadOnlyParameter { number: u16 },
    #[error("parameter #<{name}> is not set")]
    UnknownParameter { name: String },
    #[error("parameter #<{name}> cannot be set")]
    ReadOnlyName { name: String },
    #[error("more than {limit} named parameters")]
    TooManyParameters { limit: usize },
    #[error("parameter #{number} is read before it is set; its value is 0")]
    UnsetParameter { number: u16 },

    #[error("{code} without a feed rate")]
    NoFeed { code: Code },
    #[error("F on the line of {code} is taken before the units change: {unit}/min")]
    FeedBeforeUnits { code: Code, unit: &'static str },
    #[error("{code} in inverse time feed (G93) without F on its line")]
    NoInverseTimeFeed { code: Code },
    #[error("{code} in feed per revolution (G95) while the spindle does not turn")]
    NoRevolutions { code: &'static str },
    #[error("{code} in feed per revolution (G95)")]
    ProbeFeed { code: Code },
    #[error(
        "radius to start {start_radius:.4} {unit}, to end {end_radius:.4} {unit}, which differ by {difference:.4}"
    )]
    ArcRadii {
        start_radius: f64,
        end_radius: f64,
        difference: f64,
        unit: &'static str,
        center_absolute: bool,
    },
    #[error("the arc's radius is {radius} {unit}, smaller than {least} {unit}")]
    ArcTooSmall {
        radius: f64,
        least: f64,
        unit: &'static str,
    },
    #[error(
        "radius {radius} is too small: the end is {distance:.4} {unit} away from the start, which takes at least {least:.4}"
    )]
    ArcRadiusShort {
        radius: f64,
        distance: f64,
        least: f64,
        unit: &'static str,
    },
    #[error("an arc by radius whose end is its start")]
    ArcSamePoint,
    #[error("an arc with neither R nor {offsets}")]
    ArcWithoutCenter { offsets: &'static str },
    #[error("an arc with both R and {letter}")]
    ArcTwoFormats { letter: char },
    #[error("{letter} in an arc of the {plane} plane")]
    ArcOffPlane { letter: char, plane: &'static str },
    #[error("{letter} is missing: with absolute centres (G90.1) both are needed")]
    ArcCenterWord { letter: char },
    #[error("G53 needs G0 or G1")]
    G53WithoutMotion,
    #[error("G53 with incremental distances (G91)")]
    G53Incremental,
    #[error("tool {tool} is not in the tool table")]
    NoSuchTool { tool: i64 },
    #[error("there is no tool table: tool {tool} has no length")]
    NoToolTable { tool: i32 },
    #[error("M6 before any T")]
    NoToolSelected,
    #[error("tool table, line {line}: {message}")]
    ToolTable { line: u32, message: String },
    #[error("{axis} goes to {value}, beyond the limit of {limit}")]
    CoordinateTooLarge { axis: char, value: f64, limit: f64 },
    #[error("an arc of radius {radius_mm} mm, beyond the limit of {limit} mm")]
    RadiusTooLarge { radius_mm: f64, limit: f64 },
    #[error("a feed rate of {rate} a minute, beyond the limit of {limit}")]
    FeedTooLarge { rate: f64, limit: f64 },
    #[error("a dwell of {seconds} s is no dwell")]
    NegativeDwell { seconds: f64 },
    #[error("a dwell of {seconds} s, longer than the limit of {limit} s")]
    DwellTooLong { seconds: f64, limit: f64 },
    #[error("{code} while the spindle does not turn")]
    SpindleStopped { code: Code },
    #[error("{code} begins where it ends: there is nothing to probe")]
    ProbeTooShort { code: Code },
    #[error("{code} {message}")]
    Curve { code: Code, message: &'static str },
    #[error("a curve of order {order} needs at least {order} control points; it has {points}")]
    CurvePoints { points: usize, order: u32 },
    #[error("a curve of more than {limit} control points")]
    CurveTooLong { limit: usize },
    #[error("polar coordinates {message} ({letter})")]
    Polar { message: &'static str, letter: char },
    #[error("polar coordinates are for motion, not for {code}")]
    PolarWithoutMotion { code: Code },
    #[error("{code}, but M70 or M73 has saved nothing here")]
    NothingSaved { code: Code },
    #[error("{what} cannot be turned into motion yet")]
    NoMotionFor { what: &'static str },
    #[error(
        "the move follows the spindle, which is taken to turn at its programmed speed all the time"
    )]
    SpindleAssumed,
    #[error("{message}")]
    Compensation { message: &'static str },
    #[error("M99 in the main program would start it again; it ends here")]
    EndlessMain,
    #[error("{message}")]
    Cycle { message: &'static str },
    #[error("the cycle makes more than {limit} moves")]
    CycleTooLong { limit: u32 },

    #[error("{code} needs the ZX plane (G18); the {plane} plane is selected")]
    TurningPlane { code: Code, plane: &'static str },
    #[error(
        "the profile of {code}, subroutine o{name}, has no move after the one that leads to its start"
    )]
    ProfileEmpty { code: Code, name: String },
    #[error("the profile of {code} turns back in {axis}: this move goes from {from} to {to}")]
    ProfileTurnsBack {
        code: Code,
        axis: char,
        from: f64,
        to: f64,
    },
    #[error("{code} cannot stand in a profile")]
    ProfileCode { code: Code },
    #[error("the corner {letter}{size} of the profile {}", if *.two { "is given with both A and C" } else { "cannot be made between its moves" })]
    ProfileCorner { letter: char, size: f64, two: bool },
    #[error("{letter} in a profile while coordinates are incremental (G91)")]
    ProfileIncrement { letter: char },
    #[error("there is no room for the profile of {code} at a distance of {distance}")]
    ProfileDistance { code: Code, distance: f64 },

    #[error(
        "{code} under cutter compensation goes to the end of its profile first, X{x} Z{z}, as LinuxCNC 2.9 does"
    )]
    FinishDetour { code: Code, x: f64, z: f64 },

    #[error("{message}")]
    Flow { message: String },
    #[error("subroutine o{name} is not closed; it is never called")]
    UnclosedSub { name: String },
    #[error("subroutine {name} is not defined")]
    NoSuchSub { name: String },
    #[error("the file of subroutine {name}: {message}")]
    SubFile { name: String, message: String },
    #[error("more than {limit} files of subroutines")]
    TooManyFiles { limit: usize },
    #[error("calls nested deeper than {limit}")]
    CallsTooDeep { limit: usize },
    #[error("more than {limit} branches and loops are open at once")]
    TooManyOpen { limit: usize },
    #[error("loops and subroutines hold more than {limit} bytes of source")]
    TooMuchHeld { limit: usize },
    #[error("{limit} blocks have run; the program does not seem to end")]
    TooManyBlocks { limit: u64 },
    #[error(
        "loops and subroutines have run {limit} blocks at a stretch; the program does not seem to end"
    )]
    TooManyLoopedBlocks { limit: u64 },
    #[error(
        "loops and subroutines have made {limit} operations at a stretch; the program does not seem to end"
    )]
    TooManyOperations { limit: u64 },
    #[error("{limit} blocks in a row have run without any motion; the loop does not seem to end")]
    IdleLoop { limit: u64 },

    #[error("line N{number} is not in the program")]
    NoSuchLine { number: f64 },
    #[error("the checksum is {found}, but the line adds up to {wanted}")]
    Checksum { found: u8, wanted: u8 },
    #[error("{what} is of Siemens (Sinumerik), whose programs are not read")]
    Siemens { what: &'static str },
    #[error("conversational text of Heidenhain, which is not read")]
    Heidenhain,
    #[error("{message}")]
    FiveAxis { message: &'static str },
    #[error("the corner {message}")]
    Corner { message: &'static str },
    #[error("{}", .leniency.meaning())]
    Lenient { leniency: Leniency },
    #[error("{}{}", .leniency.meaning(), times(*.count))]
    Habit { leniency: Leniency, count: u64 },
    #[error("{}: that is not allowed here", .leniency.meaning())]
    NotLenient { leniency: Leniency },
    #[error("the program ends without M2 or M30")]
    NoProgramEnd,
    #[error("the program ends without its closing %")]
    NoClosingPercent,
    #[error("a byte order mark at the start is skipped")]
    ByteOrderMark,
}

fn show_byte(byte: u8) -> String {
    if byte.is_ascii_graphic() {
        format!("'{}'", char::from(byte))
    } else {
        format!("byte 0x{byte:02x}")
    }
}

fn times(count: u64) -> String {
    if count > 1 {
        format!(" ({count} times)")
    } else {
        String::new()
    }
}
