//! Everything that can be wrong with a program.

use crate::diagnostics::Severity;
use crate::dialect::Leniency;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A G or M code as written: letter and number in tenths, `G59.1` is ('G', 591).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Code {
    /// 'G' or 'M'.
    pub letter: char,
    /// Ten times the number.
    pub tenths: u16,
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.letter, self.tenths / 10)?;
        if self.tenths.is_multiple_of(10) { Ok(()) } else { write!(f, ".{}", self.tenths % 10) }
    }
}

/// What is wrong, with the values that show it. Lengths are in the program's units unless a name says otherwise.
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
    #[error("{first} and {second} exclude each other: both set the {group}")]
    ModalConflict { first: Code, second: Code, group: &'static str },
    #[error("no code on this line uses {letter}{value}")]
    UnusedWord { letter: char, value: f64, users: String },
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
    WordOutOfRange { code: Code, letter: char, value: f64, allowed: &'static str },

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
    #[error("radius to start {start_radius:.4} {unit}, to end {end_radius:.4} {unit}, which differ by {difference:.4}")]
    ArcRadii { start_radius: f64, end_radius: f64, difference: f64, unit: &'static str, center_absolute: bool },
    #[error("the arc's radius is {radius} {unit}, smaller than {least} {unit}")]
    ArcTooSmall { radius: f64, least: f64, unit: &'static str },
    #[error("radius {radius} is too small: the end is {distance:.4} {unit} away from the start, which takes at least {least:.4}")]
    ArcRadiusShort { radius: f64, distance: f64, least: f64, unit: &'static str },
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
    #[error("an arc in the {plane} plane while the coordinate system is rotated about Z by {degrees} degrees")]
    RotatedArcPlane { plane: &'static str, degrees: f64 },
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
    #[error("the move follows the spindle, which is taken to turn at its programmed speed all the time")]
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
    #[error("the profile of {code}, subroutine o{name}, has no move after the one that leads to its start")]
    ProfileEmpty { code: Code, name: String },
    #[error("the profile of {code} turns back in {axis}: this move goes from {from} to {to}")]
    ProfileTurnsBack { code: Code, axis: char, from: f64, to: f64 },
    #[error("{code} cannot stand in a profile")]
    ProfileCode { code: Code },
    #[error("the corner {letter}{size} of the profile {}", if *.two { "is given with both A and C" } else { "cannot be made between its moves" })]
    ProfileCorner { letter: char, size: f64, two: bool },
    #[error("{letter} in a profile while coordinates are incremental (G91)")]
    ProfileIncrement { letter: char },
    #[error("there is no room for the profile of {code} at a distance of {distance}")]
    ProfileDistance { code: Code, distance: f64 },

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
    #[error("loops and subroutines have made {limit} operations at a stretch; the program does not seem to end")]
    TooManyOperations { limit: u64 },
    #[error("{limit} blocks in a row have run without any motion; the loop does not seem to end")]
    IdleLoop { limit: u64 },

    #[error("line N{number} is not in the program")]
    NoSuchLine { number: f64 },
    #[error("the checksum is {found}, but the line adds up to {wanted}")]
    Checksum { found: u8, wanted: u8 },
    #[error("{what} is of Siemens (Sinumerik), whose programs are not read")]
    Siemens { what: &'static str },
    #[error("{message}")]
    FiveAxis { message: &'static str },
    #[error("the corner {message}")]
    Corner { message: &'static str },
    #[error("{}", .leniency.meaning())]
    Lenient { leniency: Leniency },
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
    if byte.is_ascii_graphic() { format!("'{}'", char::from(byte)) } else { format!("byte 0x{byte:02x}") }
}

impl Problem {
    /// Stable name, kebab case.
    pub fn code(&self) -> &'static str {
        use Problem as P;
        match self {
            P::LineTooLong { .. } => "line-too-long",
            P::SourceTooLong { .. } => "source-too-long",
            P::TooManyWords { .. } => "too-many-words",
            P::TooDeep { .. } => "too-deep",
            P::Unreadable { .. } => "unreadable",
            P::Nul => "nul-byte",
            P::BadCharacter { .. } => "bad-character",
            P::MissingNumber { .. } => "missing-number",
            P::BadNumber { .. } => "bad-number",
            P::Expected { .. } => "syntax",
            P::UnknownName { .. } => "unknown-name",
            P::UnclosedComment => "unclosed-comment",
            P::NestedComment => "nested-comment",
            P::TextBeforePercent => "text-before-percent",
            P::MisplacedLineNumber => "misplaced-line-number",
            P::RepeatedWord { .. } => "repeated-word",
            P::BadWordValue { .. } => "bad-word-value",
            P::UnsupportedCode { .. } => "unsupported-code",
            P::NotACode { .. } => "not-a-code",
            P::Unsupported { .. } => "unsupported",
            P::ModalConflict { .. } => "modal-conflict",
            P::UnusedWord { .. } => "unused-word",
            P::TwoAxisUsers { .. } => "two-axis-users",
            P::AxisWithoutCode => "axis-without-code",
            P::AxesMissing { .. } => "axes-missing",
            P::AxesNotAllowed { .. } => "axes-not-allowed",
            P::WordMissing { .. } => "word-missing",
            P::WordOutOfRange { .. } => "word-out-of-range",
            P::Domain { .. } => "outside-domain",
            P::NotFinite => "not-finite",
            P::DivisionByZero => "division-by-zero",
            P::ParameterRange { .. } => "parameter-range",
            P::ReadOnlyParameter { .. } | P::ReadOnlyName { .. } => "read-only-parameter",
            P::UnknownParameter { .. } => "unknown-parameter",
            P::TooManyParameters { .. } => "too-many-parameters",
            P::UnsetParameter { .. } => "unset-parameter",
            _ => self.code_of_meaning(),
        }
    }

    fn code_of_meaning(&self) -> &'static str {
        use Problem as P;
        match self {
            P::NoFeed { .. } => "no-feed",
            P::FeedBeforeUnits { .. } => "feed-before-units",
            P::NoInverseTimeFeed { .. } => "no-inverse-time-feed",
            P::NoRevolutions { .. } => "no-revolutions",
            P::ArcRadii { .. } => "arc-radii",
            P::ArcTooSmall { .. } => "arc-too-small",
            P::ArcRadiusShort { .. } => "arc-radius-short",
            P::ArcSamePoint => "arc-same-point",
            P::ArcWithoutCenter { .. } => "arc-without-center",
            P::ArcTwoFormats { .. } => "arc-two-formats",
            P::ArcOffPlane { .. } => "arc-off-plane",
            P::ArcCenterWord { .. } => "arc-center-word",
            P::G53WithoutMotion => "g53-without-motion",
            P::G53Incremental => "g53-incremental",
            P::NoSuchTool { .. } => "no-such-tool",
            P::NoToolTable { .. } => "no-tool-table",
            P::NoToolSelected => "no-tool-selected",
            P::ToolTable { .. } => "tool-table",
            P::CoordinateTooLarge { .. } => "coordinate-too-large",
            P::RadiusTooLarge { .. } => "radius-too-large",
            P::FeedTooLarge { .. } => "feed-too-large",
            P::NegativeDwell { .. } => "negative-dwell",
            P::DwellTooLong { .. } => "dwell-too-long",
            P::RotatedArcPlane { .. } => "rotated-arc-plane",
            P::SpindleStopped { .. } => "spindle-stopped",
            P::ProbeTooShort { .. } => "probe-too-short",
            P::Curve { .. } | P::CurvePoints { .. } => "curve",
            P::CurveTooLong { .. } => "curve-too-long",
            P::Polar { .. } | P::PolarWithoutMotion { .. } => "polar",
            P::NothingSaved { .. } => "nothing-saved",
            P::NoMotionFor { .. } => "no-motion-for",
            P::SpindleAssumed => "spindle-assumed",
            P::Compensation { .. } => "compensation",
            P::EndlessMain => "endless-main",
            P::Cycle { .. } => "cycle",
            P::CycleTooLong { .. } => "cycle-too-long",
            P::TurningPlane { .. } => "turning-plane",
            P::ProfileEmpty { .. } => "profile-empty",
            P::ProfileTurnsBack { .. } => "profile-turns-back",
            P::ProfileCode { .. } => "profile-code",
            P::ProfileCorner { .. } => "profile-corner",
            P::ProfileIncrement { .. } => "profile-increment",
            P::ProfileDistance { .. } => "profile-distance",
            P::Flow { .. } => "flow",
            P::UnclosedSub { .. } => "unclosed-sub",
            P::NoSuchSub { .. } => "no-such-sub",
            P::SubFile { .. } => "sub-file",
            P::TooManyFiles { .. } => "too-many-files",
            P::CallsTooDeep { .. } => "calls-too-deep",
            P::TooManyOpen { .. } => "too-many-open",
            P::TooMuchHeld { .. } => "too-much-held",
            P::TooManyBlocks { .. } => "too-many-blocks",
            P::TooManyOperations { .. } => "too-many-operations",
            P::IdleLoop { .. } => "idle-loop",
            P::NoSuchLine { .. } => "no-such-line",
            P::Checksum { .. } => "wrong-checksum",
            P::Siemens { .. } => "siemens",
            P::FiveAxis { .. } => "five-axis-use",
            P::Corner { .. } => "corner",
            P::Lenient { leniency } | P::NotLenient { leniency } => leniency.name(),
            P::NoProgramEnd => "no-program-end",
            P::NoClosingPercent => "no-closing-percent",
            P::ByteOrderMark => "byte-order-mark",
            _ => "other",
        }
    }

    /// Warnings leave the program accepted.
    pub fn severity(&self) -> Severity {
        match self {
            Problem::NoProgramEnd
            | Problem::NoClosingPercent
            | Problem::ByteOrderMark
            | Problem::UnsetParameter { .. }
            | Problem::NoToolTable { .. }
            | Problem::FeedBeforeUnits { .. }
            | Problem::NegativeDwell { .. }
            | Problem::EndlessMain
            | Problem::Lenient { .. }
            | Problem::SpindleAssumed
            | Problem::UnclosedSub { .. } => Severity::Warning,
            _ => Severity::Error,
        }
    }

    /// What to try.
    pub fn hint(&self) -> Option<String> {
        let text = match self {
            Problem::ArcRadii { center_absolute: false, .. } => "did you mean G90.1, absolute arc centres?",
            Problem::ArcRadii { .. } => "did you mean G91.1, centres relative to the start?",
            Problem::ArcRadiusShort { .. } => "check R, and whether the start is where it is meant to be",
            Problem::ArcSamePoint => "write a full circle with I, J or K",
            Problem::NoFeed { .. } => "set F first",
            Problem::FeedBeforeUnits { .. } => "put F on the next line",
            Problem::NoInverseTimeFeed { .. } => "G93 needs F on every G1, G2 and G3; G94 goes back to units per minute",
            Problem::NoRevolutions { .. } => "start the spindle with M3 or M4 and S, or use G94",
            Problem::AxisWithoutCode => "start the line with G0 or G1",
            Problem::Nul => "the file may be damaged or not a text file",
            Problem::SpindleStopped { .. } => "start the spindle with M3 or M4",
            Problem::TurningPlane { .. } => "put G18 before it",
            Problem::ProfileEmpty { .. } => "the first move leads to the profile, the others are the profile",
            Problem::ProfileTurnsBack { .. } => "write it so that it never goes back, or cut it in two cycles",
            Problem::ProfileCode { .. } => "a profile consists of G0, G1, G2 and G3",
            Problem::ProfileCorner { two: false, .. } => "make it positive and smaller than the moves before and after it",
            Problem::ProfileIncrement { .. } => "X and Z are incremental already; U and W are for G90",
            Problem::ProfileDistance { .. } => "reduce D, or widen the grooves of the profile",
            Problem::G53Incremental => "put G90 before it",
            Problem::Siemens { .. } => "write it as RS274/NGC (G-code), or post-process the part for another control",
            Problem::Checksum { .. } => "the line has been changed since the checksum was made",
            Problem::NoProgramEnd => "end the program with M2",
            Problem::NoClosingPercent => "a program that starts with % also ends with %",
            Problem::TwoAxisUsers { .. } => "put them on two lines",
            Problem::NoSuchTool { .. } => "check the tool table",
            Problem::UnusedWord { users, .. } if !users.is_empty() => return Some(format!("it belongs to {users}")),
            Problem::LineTooLong { .. } | Problem::TooManyWords { .. } | Problem::TooDeep { .. } | Problem::CoordinateTooLarge { .. } => {
                "the limit can be raised"
            }
            _ => return None,
        };
        Some(text.to_owned())
    }
}
