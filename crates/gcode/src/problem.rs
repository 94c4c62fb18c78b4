//! The table of diagnostics: everything that can be wrong with a program.
//!
//! One entry has all that is known about a kind of problem, so that adding one is adding one entry;
//! [`crate::finding`] says how entries are written.

use crate::codes::Code;
use crate::dialect::Leniency;
use crate::finding::{CatalogRow, IntoHint, Severity, problems, severity};
use serde::Serialize;

/// Where an arc leads, for messages: the letters of its plane, its ends and its centre.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArcPlace {
    /// Letters of the two axes.
    pub axes: [char; 2],
    /// Start, program units.
    pub start: [f64; 2],
    /// End, program units.
    pub end: [f64; 2],
    /// Centre, program units; `None` where none could be made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub center: Option<[f64; 2]>,
}

impl std::fmt::Display for ArcPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [first, second] = self.axes;
        let point = |[one, two]: [f64; 2]| format!("{first}{} {second}{}", place(one), place(two));
        write!(f, "from {} to {}", point(self.start), point(self.end))?;
        match self.center {
            Some(center) => write!(f, " about {}", point(center)),
            None => Ok(()),
        }
    }
}

fn builders_code(code: Code) -> Option<String> {
    (code.letter == 'M').then(|| {
        format!(
            "if it is a code of the machine's builder that moves no axis: --m-code {code}=ignore; \
                it may also stop, dwell:SECONDS, call:NUMBER or macro:NUMBER"
        )
    })
}

/// Most decimals of a coordinate in a message.
const SHOWN_DECIMALS: usize = 4;

/// A coordinate without the digits that rounding has left.
pub(crate) fn place(value: f64) -> String {
    let text = format!("{value:.SHOWN_DECIMALS$}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" {
        "0".to_owned()
    } else {
        short.to_owned()
    }
}

fn show_symbol(symbol: char) -> String {
    format!("'{symbol}' (U+{:04X})", u32::from(symbol))
}

fn sub_hint(near: &Option<String>) -> Option<String> {
    Some(match near {
        Some(near) => format!("did you mean o<{near}>?"),
        None => "define it in the program, or put its file into the part's folder or one that \
            subroutines are taken from (--subroutines)"
            .to_owned(),
    })
}

fn belongs_to(users: &str) -> Option<String> {
    (!users.is_empty()).then(|| format!("it belongs to {users}"))
}

fn show_byte(byte: u8) -> String {
    if byte.is_ascii_graphic() {
        format!("'{}'", char::from(byte))
    } else {
        format!("byte 0x{byte:02x}")
    }
}

fn after_colon(text: &str) -> String {
    if text.is_empty() {
        String::new()
    } else {
        format!(": {text}")
    }
}

fn times(count: u64) -> String {
    if count > 1 {
        format!(" ({count} times)")
    } else {
        String::new()
    }
}

problems! {
kinds {
    LineTooLong { bytes: usize, limit: usize } => error "line-too-long" limit "line_bytes",
        says("the line has {bytes} bytes, more than the limit of {limit}"),
        "A line is longer than the limit.",
        "Raise the limit `line_bytes`, or look whether the file is a program.";
    SourceTooLong { limit: u64 } => error "source-too-long" limit "source_bytes",
        says("the source is longer than the limit of {limit} bytes; the rest is not read"),
        "The program is longer than the limit.",
        "Raise the limit `source_bytes`.";
    TooManyWords { limit: usize } => error "too-many-words" limit "words",
        says("more than {limit} words on one line"),
        "A line has more words than the limit.",
        "Spread them over several lines, or raise the limit `words`.";
    TooDeep { limit: usize } => error "too-deep" limit "expression_depth",
        says("brackets, signs or # nested deeper than {limit}"),
        "Brackets, signs or `#` are nested too deep.",
        "Compute parts of the expression in parameters first.";
    Unreadable { message: String } => error "unreadable",
        says("the source cannot be read: {message}"),
        "The source could not be read to its end.",
        "Check the file or the connection it comes from.";
    Nul => error "nul-byte",
        says("a NUL byte in the program"),
        "The program contains a NUL byte.",
        "The file is damaged, or not a text file.",
        hint "the file may be damaged or not a text file";
    BadCharacter { byte: u8 } => error "bad-character",
        says("{} cannot stand here", show_byte(*.byte)),
        "A character cannot stand where it does.",
        "Remove it, or put it into a comment.";
    LookAlike { what: &'static str, text: String, meant: String } => error "look-alike",
        says("{what} in {text}"),
        "A character only looks like the one that is meant: a decimal comma, the letter O for 0, a \
            dash or digit of typesetting.",
        "Write it with the characters of G-code: a point, the digit 0, a hyphen for minus.",
        hint format!("write {meant}");
    Utf16 => error "utf-16",
        says("the file is in UTF-16, which is not read"),
        "The file is in UTF-16, with two bytes a character.",
        "Save it as plain text (ASCII or UTF-8), as controls want it.",
        hint "save it as plain text (ASCII or UTF-8)";
    MissingNumber { after: String } => error "missing-number",
        says("a number is missing after {after}"),
        "A letter or operator is not followed by a number.",
        "Write the number, or remove the letter.";
    BadNumber { text: String } => error "bad-number",
        says("{text} is not a number"),
        "A number cannot be read.",
        "A number has digits and at most one point.";
    Expected { expected: &'static str } => error "syntax",
        says("{expected} expected"),
        "Something else was expected here.",
        "See the message for what.";
    UnknownName { name: String } => error "unknown-name",
        says("{name} is not a function or operator"),
        "A name is neither a function nor an operator.",
        "Known are ABS ACOS ASIN ATAN COS EXP FIX FUP LN ROUND SIN SQRT TAN EXISTS and the \
            operators.";
    UnclosedComment => error "unclosed-comment",
        says("the comment is not closed"),
        "A comment is not closed on its line.",
        "Add the closing parenthesis, or begin the comment with a semicolon.";
    NestedComment => error "nested-comment",
        says("a ( inside a comment"),
        "A comment contains an opening parenthesis.",
        "Use other brackets inside the comment.";
    TextBeforePercent => error "text-before-percent",
        says("text before the first % of the program"),
        "There is text before the first `%`.",
        "Move the `%` to the first line.";
    MisplacedLineNumber => error "misplaced-line-number",
        says("N is only allowed at the start of a line"),
        "N does not stand first on its line.",
        "Move it to the start of the line.";
    RepeatedWord { letter: char } => error "repeated-word",
        says("{letter} is given twice on one line"),
        "A letter is given twice on one line.",
        "Remove one of the two, or put them on two lines.";
    BadWordValue { letter: char, value: f64 } => error "bad-word-value",
        says("{value} is not a valid number for {letter}"),
        "The value of a letter is not possible.",
        "See the message for what the letter takes.";
    UnsupportedCode { code: Code } => error "unsupported-code",
        says("{code} is not a code of this interpreter"),
        "The code is not known.",
        "Check it against the table of codes; take out what only another control understands. An \
            M code of the machine's builder is skipped with `--m-code M10=ignore`, or stops, waits \
            or calls a subroutine (`M10=stop`, `dwell:1.5`, `call:9001`, `macro:9020`); it is told \
            once.",
        hint builders_code(*code);
    NotACode { letter: char, value: f64 } => error "not-a-code",
        says("{letter}{value} is not a code"),
        "The number after G or M is not that of a code.",
        "Codes have at most one decimal.";
    Unsupported { what: String } => error "unsupported",
        says("{} is not supported", .what),
        "The program uses something that is recognised, but not supported.",
        "See the message for what it is.";
    ControlCycle { code: Code, what: &'static str, hint: &'static str } => error "control-cycle",
        says("{code} is {what}, which is not read"),
        "The code is a cycle of another control that is not read.",
        "Have the CAM system write it out as moves.",
        hint *hint;
    ModalConflict { first: Code, second: Code, group: &'static str } => error "modal-conflict",
        says("{first} and {second} exclude each other: both set the {group}"),
        "Two codes of one line set the same mode.",
        "Keep one of them, or put them on two lines.";
    UnusedWord { letter: char, value: f64, users: String } => error "unused-word",
        says("no code on this line uses {letter}{value}"),
        "No code of the line uses the word.",
        "Remove it, or add the code that it belongs to.",
        hint belongs_to(users);
    TwoAxisUsers { code: Code, other: Code } => error "two-axis-users",
        says("{code} and {other} both use the axis words"),
        "Two codes of one line want the axis words.",
        "Put them on two lines.",
        hint "put them on two lines";
    AxisWithoutCode => error "axis-without-code",
        says("axis words without a code that uses them: no motion mode is active"),
        "Axis words stand without a motion mode.",
        "Start the line with G0 or G1.",
        hint "start the line with G0 or G1";
    AxesMissing { code: Code } => error "axes-missing",
        says("{code} without any axis word"),
        "A code lacks its axis words.",
        "Name at least one axis.";
    AxesNotAllowed { code: Code } => error "axes-not-allowed",
        says("{code} does not take axis words"),
        "A code that takes no axis words has some.",
        "Put the motion on a line of its own.";
    WordMissing { code: Code, what: &'static str } => error "word-missing",
        says("{code} needs {what}"),
        "A code lacks a word that it needs.",
        "See the message for which.";
    WordOutOfRange { code: Code, letter: char, value: f64, allowed: &'static str } =>
        error "word-out-of-range",
        says("{letter}{value} for {code} has to be {allowed}"),
        "A word has a value that its code does not allow.",
        "See the message for what is allowed.";
    Domain { what: &'static str, value: f64 } => error "outside-domain",
        says("{what} of {value}"),
        "A function gets a value it is not defined for.",
        "Check the values that lead here.";
    NotFinite => error "not-finite",
        says("the result is not a finite number"),
        "An expression overflows.",
        "Check the values that lead here.";
    DivisionByZero => error "division-by-zero",
        says("division by zero"),
        "An expression divides by zero.",
        "Check the values that lead here.";
    ParameterRange { number: f64 } => error "parameter-range",
        says("parameter number {number} is outside 1 to 5602"),
        "A parameter number is out of range.",
        "Parameters go from #1 to #5602.";
    ReadOnlyParameter { number: u16 } => error "read-only-parameter",
        says("parameter #{number} cannot be set"),
        "A parameter that shows the machine's state is set.",
        "Use another parameter.";
    UnknownParameter { name: String, near: Option<String> } => error "unknown-parameter",
        says("parameter #<{name}> is not set"),
        "A named parameter is read that is not set.",
        "Set it first, or ask with EXISTS. Names without a leading underscore belong to one \
            subroutine.",
        hint near.as_ref().map(|near| format!("did you mean #<{near}>?"));
    ControlVariable { number: u32, what: &'static str } => error "control-variable",
        says("#{number} is {what}, which is not known here"),
        "A system variable of the control is read whose value only the control knows: a clock, the \
            date, an input, a count.",
        "Tell its value: `--set '#3011=20260101'`.",
        hint format!("tell its value: --set '#{number}=VALUE'");
    MacroAlarm { number: f64, text: String } => error "macro-alarm",
        says("the program stops with its own alarm #3000={number}{}", after_colon(.text)),
        "The program raises an alarm by #3000, which ends it.",
        "The message is the program's own: it says what it has checked.";
    OffsetUnknown { number: u32, offset: i32 } => warning "offset-unknown",
        says("#{number} is read, but tool offset {offset} is not in the tool table: it counts as 0"),
        "A tool offset is read by a system variable, and there is no such tool.",
        "Name a tool table that has it, or set it with G10 L10 or L12.",
        hint "name a tool table that has it (--tool-table), or set it with G10 before";
    MemoryAssumed { number: u32 } => warning "tool-memory-assumed",
        says("#{number} is taken to be of tool compensation memory C, where it holds wear or \
            geometry alone"),
        "#2001 to #2400 differ between the tool memories A, B and C of Fanuc; memory C is assumed.",
        "#11001 and on hold the geometry of a length, #10001 and on its wear, whatever the memory.",
        hint "use #11001 (geometry) and #10001 (wear), which mean the same in memories B and C";
    DiameterAssumed { offset: i32 } => warning "diameter-assumed",
        says("D{offset} is set by the program; its value is taken to be a diameter"),
        "The program sets the size of a tool, which at Haas is a radius or a diameter by Setting 40; \
            a diameter is taken.",
        "Nothing, if Setting 40 of the control says diameter; else double the values.",
        hint "if Setting 40 of the control says radius, double the value";
    HalValue { name: String } => error "hal-value",
        says("#<{name}> is a value of the machine's HAL or INI file, which is not known here"),
        "A value of LinuxCNC's HAL or INI file is read.",
        "Tell its value: `--set '#<_hal[name]>=1.5'`.",
        hint format!("tell its value: --set '#<{name}>=VALUE'");
    Klipper { message: String } => error "klipper-command",
        says("{message}"),
        "A command of Klipper cannot be carried out.",
        "See the message.";
    VelocityLimit => warning "velocity-limit",
        says("SET_VELOCITY_LIMIT is not heeded: the limits of the machine's description hold"),
        "SET_VELOCITY_LIMIT is not heeded.",
        "Change the limits of the machine's axes.",
        hint "change the machine's limits, for example --set axis.x.limits.acceleration_mm_s2=3000";
    TooManyParameters { limit: usize } => error "too-many-parameters" limit "named_parameters",
        says("more than {limit} named parameters"),
        "More named parameters than the limit.",
        "Raise the limit `named_parameters`.";
    UnsetParameter { number: u16 } => warning "unset-parameter",
        says("parameter #{number} is read before it is set; its value is 0"),
        "A numbered parameter is read before it is set; it counts as 0.",
        "Set it first.";
    NoFeed { code: Code } => error "no-feed",
        says("{code} without a feed rate"),
        "A feed move without a feed rate.",
        "Set F first. Changing between G93, G94 and G95 forgets the feed.",
        hint "set F first";
    FeedBeforeUnits { code: Code, unit: &'static str } => warning "feed-before-units",
        says("F on the line of {code} is taken before the units change: {unit}/min"),
        "F stands on the line that changes the units, and is taken in the old ones.",
        "Put F on the next line.",
        hint "put F on the next line";
    NoInverseTimeFeed { code: Code } => error "no-inverse-time-feed",
        says("{code} in inverse time feed (G93) without F on its line"),
        "A move in inverse time (G93) without F on its line.",
        "G93 needs F on every G1, G2 and G3.",
        hint "G93 needs F on every G1, G2 and G3; G94 goes back to units per minute";
    NoRevolutions { code: &'static str } => error "no-revolutions",
        says("{code} in feed per revolution (G95) while the spindle does not turn"),
        "Feed per revolution while the spindle does not turn.",
        "Start the spindle, or use G94.",
        hint "start the spindle with M3 or M4 and S, or use G94";
    ProbeFeed { code: Code } => error "probe-feed",
        says("{code} in feed per revolution (G95)"),
        "A probing move in feed per revolution.",
        "Put G94 and F before it.";
    ArcRadii {
        start_radius: f64, end_radius: f64, difference: f64, unit: &'static str,
        place: Box<ArcPlace>, try_this: Option<String>
    } => error "arc-radii",
        says("radius to start {start_radius:.4} {unit}, to end {end_radius:.4} {unit}, which \
            differ by {difference:.4}: {place}"),
        "The centre of an arc is not as far from its end as from its start.",
        "Check whether I, J and K are relative to the start (G91.1) or absolute (G90.1), and their \
            signs. The hint names a change only if the arc is right with it.",
        hint try_this.clone();
    ArcTooSmall { radius: f64, least: f64, unit: &'static str, place: Box<ArcPlace> } =>
        error "arc-too-small",
        says("the arc's radius is {radius} {unit}, smaller than {least} {unit}: {place}"),
        "The radius of an arc is too small.",
        "Replace it by a straight move.";
    ArcRadiusShort {
        radius: f64, distance: f64, least: f64, unit: &'static str, place: Box<ArcPlace>,
        try_this: Option<String>
    } => error "arc-radius-short",
        says("radius {radius} is too small: the end is {distance:.4} {unit} away from the start, \
            which takes at least {least:.4}: {place}"),
        "R is too small for the distance between the ends.",
        "Check R, and whether the start is where it is meant to be.",
        hint try_this.clone().or_else(|| {
            Some("check R, and whether the start is where it is meant to be".to_owned())
        });
    ArcSamePoint => error "arc-same-point",
        says("an arc by radius whose end is its start"),
        "An arc by radius ends where it begins.",
        "Write a full circle with I, J or K.",
        hint "write a full circle with I, J or K";
    ArcWithoutCenter { offsets: &'static str } => error "arc-without-center",
        says("an arc with neither R nor {offsets}"),
        "An arc has neither R nor a centre.",
        "Add R, or the two letters of the plane.";
    ArcTwoFormats { letter: char } => error "arc-two-formats",
        says("an arc with both R and {letter}"),
        "An arc has both R and a centre.",
        "Remove one of them.";
    ArcOffPlane { letter: char, plane: &'static str, try_this: Option<String> } =>
        error "arc-off-plane",
        says("{letter} in an arc of the {plane} plane"),
        "The centre of an arc has a letter outside its plane.",
        "Select the plane (G17, G18, G19), or remove the letter.",
        hint try_this.clone();
    ArcCenterWord { letter: char } => error "arc-center-word",
        says("{letter} is missing: with absolute centres (G90.1) both are needed"),
        "An absolute centre lacks one of its letters.",
        "In G90.1 both letters of the plane are needed.";
    G53WithoutMotion => error "g53-without-motion",
        says("G53 needs G0 or G1"),
        "G53 without G0 or G1.",
        "Put G0 or G1 on its line.";
    G53Incremental => error "g53-incremental",
        says("G53 with incremental distances (G91)"),
        "G53 in incremental distances.",
        "Put G90 before it.",
        hint "put G90 before it";
    NoSuchTool { tool: i64 } => error "no-such-tool",
        says("tool {tool} is not in the tool table"),
        "The tool is not in the tool table.",
        "Check the number, or add the tool.",
        hint "check the tool table";
    NoToolTable { tool: i32 } => warning "no-tool-table",
        says("there is no tool table: tool {tool} has no length"),
        "A tool's length is asked for, and there is no tool table.",
        "Name the tool table; without it every length is 0.";
    NoToolRadius { tool: i32 } => warning "no-tool-radius",
        says("the radius of tool {tool} is not known: the path is compensated with radius 0"),
        "Cutter compensation with a tool whose radius is not known.",
        "Name a tool table in which the tool has a diameter; without it the path of the part is \
         that of the tool's centre.",
        hint "name a tool table in which the tool has a diameter";
    NoToolSelected => error "no-tool-selected",
        says("M6 before any T"),
        "M6 before any T.",
        "Select a tool with T.";
    ToolTable { line: u32, message: String } => error "tool-table",
        says("tool table, line {line}: {message}"),
        "The tool table cannot be read.",
        "See the message for line and word.";
    CoordinateTooLarge { axis: char, value: f64, limit: f64 } =>
        error "coordinate-too-large" limit "coordinate",
        says("{axis} goes to {value}, beyond the limit of {limit}"),
        "A coordinate is beyond the limit.",
        "Check the value; the limit `coordinate` can be raised.";
    RadiusTooLarge { radius_mm: f64, limit: f64 } => error "radius-too-large" limit "radius_mm",
        says("an arc of radius {radius_mm} mm, beyond the limit of {limit} mm"),
        "An arc has a radius beyond the limit.",
        "Check I, J, K or R; the limit can be raised.";
    FeedTooLarge { rate: f64, limit: f64 } => error "feed-too-large" limit "feed",
        says("a feed rate of {rate} a minute, beyond the limit of {limit}"),
        "A feed rate is beyond the limit.",
        "Check F and the units; the limit can be raised.";
    NegativeDwell { seconds: f64 } => warning "negative-dwell",
        says("a dwell of {seconds} s is no dwell"),
        "A dwell of less than zero seconds.",
        "Write a positive P.";
    DwellTooLong { seconds: f64, limit: f64 } => error "dwell-too-long" limit "dwell_s",
        says("a dwell of {seconds} s, longer than the limit of {limit} s"),
        "A dwell is longer than the limit.",
        "P is in seconds; the limit `dwell_s` can be raised.";
    SpindleStopped { code: Code } => error "spindle-stopped",
        says("{code} while the spindle does not turn"),
        "A move in step with the spindle while it does not turn.",
        "Start it with M3 or M4.",
        hint "start the spindle with M3 or M4";
    ProbeTooShort { code: Code } => error "probe-too-short",
        says("{code} begins where it ends: there is nothing to probe"),
        "A probing move begins where it ends.",
        "Program a way to go.";
    Curve { code: Code, message: &'static str } => error "curve",
        says("{code} {message}"),
        "A spline or NURBS is not as it has to be.",
        "See the message.";
    CurveTooLong { limit: usize } => error "curve-too-long" limit "curve_points",
        says("a curve of more than {limit} control points"),
        "A NURBS has more control points than the limit.",
        "Split it, or raise the limit `curve_points`.";
    Polar { message: &'static str, letter: char } => error "polar",
        says("polar coordinates {message} ({letter})"),
        "Polar coordinates are not as they have to be.",
        "See the message.";
    NothingSaved { code: Code } => error "nothing-saved",
        says("{code}, but M70 or M73 has saved nothing here"),
        "M72 without M70 or M73 before it, or after M71.",
        "Save the modes first, at the same level of calls.";
    NoMotionFor { what: &'static str } => error "no-motion-for",
        says("{what} cannot be turned into motion yet"),
        "What the program asks for can be read, but not yet moved.",
        "Replace it by lines and arcs.";
    SpindleAssumed => warning "spindle-assumed",
        says("the move follows the spindle, which is taken to turn at its programmed speed all \
            the time"),
        "A move follows the spindle, which is taken to turn at its programmed speed.",
        "Nothing: real spindles slow down where they reverse, which the plan does not know.";
    Compensation { message: &'static str } => error "compensation",
        says("{message}"),
        "Cutter compensation cannot be carried out.",
        "See the message; often the tool's radius is larger than the corner allows.";
    EndlessMain => warning "endless-main",
        says("M99 in the main program would start it again; it ends here"),
        "M99 in the main program would start it again.",
        "End the program with M2 or M30.";
    Cycle { message: &'static str } => error "cycle",
        says("{message}"),
        "A canned cycle is not as it has to be.",
        "See the message.";
    CycleTooLong { limit: u32 } => error "cycle-too-long" limit "cycle_moves",
        says("the cycle makes more than {limit} moves"),
        "A cycle makes more moves than the limit.",
        "Check Q and L, or raise the limit `cycle_moves`.";
    TurningPlane { code: Code, plane: &'static str } => error "turning-plane",
        says("{code} needs the ZX plane (G18); the {plane} plane is selected"),
        "A turning cycle outside the ZX plane.",
        "Put G18 before it.",
        hint "put G18 before it";
    ProfileEmpty { code: Code, name: String } => error "profile-empty",
        says("the profile of {code}, subroutine o{name}, has no move after the one that leads to \
            its start"),
        "The profile of a turning cycle has no moves.",
        "The first move leads to the profile, the others are the profile.",
        hint "the first move leads to the profile, the others are the profile";
    ProfileTurnsBack { code: Code, axis: char, from: f64, to: f64 } => error "profile-turns-back",
        says("the profile of {code} turns back in {axis}: this move goes from {from} to {to}"),
        "The profile of a turning cycle goes back along its direction of travel.",
        "It must not turn back in Z for G71, in X for G72, and in one of them for G70.",
        hint "write it so that it never goes back, or cut it in two cycles";
    ProfileCode { code: Code } => error "profile-code",
        says("{code} cannot stand in a profile"),
        "A code that moves in another way stands in a profile.",
        "A profile consists of G0, G1, G2 and G3.",
        hint "a profile consists of G0, G1, G2 and G3";
    ProfileCorner { letter: char, size: f64, two: bool } => error "profile-corner",
        says("the corner {letter}{size} of the profile {}", if *.two { "is given with both A and \
            C" } else { "cannot be made between its moves" }),
        "A or C in a profile cannot be made.",
        "It has to be positive and smaller than the moves it stands between.",
        hint (!*two).then(|| "make it positive and smaller than the moves before and after \
            it".to_owned());
    ProfileIncrement { letter: char } => error "profile-increment",
        says("{letter} in a profile while coordinates are incremental (G91)"),
        "U or W in a profile while coordinates are incremental.",
        "X and Z are incremental already.",
        hint "X and Z are incremental already; U and W are for G90";
    ProfileDistance { code: Code, distance: f64 } => error "profile-distance",
        says("there is no room for the profile of {code} at a distance of {distance}"),
        "A profile has no room for the distance that is to remain.",
        "Reduce D, or widen the grooves of the profile.",
        hint "reduce D, or widen the grooves of the profile";
    Flow { message: String } => error "flow",
        says("{message}"),
        "O-words are not nested as they have to be.",
        "See the message for the line that is concerned.";
    Abort { message: String } => error "abort",
        says("the program stops itself: {message}"),
        "A comment `(ABORT, ...)` is reached: the program stops there, with its message.",
        "See what the program checks before it.";
    RunsIntoSub { name: String } => warning "runs-into-sub",
        says("the program runs on through o{name}: nothing has ended it before"),
        "A label without `sub` stands behind blocks that run on into it.",
        "If it begins a subroutine, end the main program before it with M2 or M30.",
        hint "if it begins a subroutine, end the main program before it with M2 or M30";
    UnclosedSub { name: String } => warning "unclosed-sub",
        says("subroutine o{name} is not closed; it is never called"),
        "A subroutine has no end.",
        "Add its endsub, or its M99.";
    NoSuchSub { name: String, near: Option<String> } => error "no-such-sub",
        says("subroutine {name} is not defined"),
        "A subroutine is called that is not defined.",
        "Define it in the program, or put its file into the folder that subroutines come from.",
        hint sub_hint(near);
    SubFile { name: String, message: String } => error "sub-file",
        says("the file of subroutine {name}: {message}"),
        "The file of a subroutine cannot be used.",
        "See the message for the reason.";
    TooManyFiles { limit: usize } => error "too-many-files",
        says("more than {limit} files of subroutines"),
        "More files of subroutines than the limit.",
        "Look for calls whose name is computed.";
    CallsTooDeep { limit: usize } => error "calls-too-deep" limit "call_depth",
        says("calls nested deeper than {limit}"),
        "Calls are nested deeper than the limit.",
        "Look for a subroutine that calls itself, or raise the limit `call_depth`.";
    TooManyOpen { limit: usize } => error "too-many-open" limit "open_structures",
        says("more than {limit} branches and loops are open at once"),
        "More branches and loops are open than the limit.",
        "Look for an if or a loop that is never closed, or raise the limit.";
    TooMuchHeld { limit: usize } => error "too-much-held" limit "held_bytes",
        says("loops and subroutines hold more than {limit} bytes of source"),
        "Loops and subroutines hold more source than the limit.",
        "Raise the limit `held_bytes`.";
    TooManyBlocks { limit: u64 } => error "too-many-blocks" limit "executed_blocks",
        says("{limit} blocks have run; the program does not seem to end"),
        "More blocks have run than the limit.",
        "Look for a loop that does not end, or raise the limit `executed_blocks`.";
    TooManyLoopedBlocks { limit: u64 } => error "too-many-looped-blocks" limit "looped_blocks",
        says("loops and subroutines have run {limit} blocks at a stretch; the program does not \
            seem to end"),
        "Loops and subroutines run more blocks at a stretch than the limit.",
        "Look for a loop that does not end, or raise the limit `looped_blocks`.";
    TooManyOperations { limit: u64 } => error "too-many-operations" limit "looped_operations",
        says("loops and subroutines have made {limit} operations at a stretch; the program does \
            not seem to end"),
        "Loops and subroutines make more operations at a stretch than the limit.",
        "Check what ends the loop; the limit can be raised.";
    IdleLoop { limit: u64 } => error "idle-loop" limit "idle_blocks",
        says("{limit} blocks in a row have run without any motion; the loop does not seem to end"),
        "A loop goes on without any motion.",
        "Look at the condition of the loop.";
    NoSuchLine { number: f64 } => error "no-such-line",
        says("line N{number} is not in the program"),
        "A jump or a local call leads to a line number that is not there.",
        "Give the line its N number.";
    Checksum { found: u8, wanted: u8 } => error "wrong-checksum",
        says("the checksum is {found}, but the line adds up to {wanted}"),
        "The checksum of a line does not fit it.",
        "The line has been changed or damaged; make the checksum anew or remove it.",
        hint "the line has been changed since the checksum was made";
    Siemens { what: &'static str } => error "siemens",
        says("{what} is of Siemens (Sinumerik), whose programs are not read"),
        "A block is of Siemens (Sinumerik), whose programs are not read.",
        "Post-process the part for another control.",
        hint "write it as plain G-code (`--dialect linuxcnc`), or post-process the part for another control \
            and name that (`--dialect fanuc`)";
    Heidenhain => error "heidenhain",
        says("conversational text of Heidenhain, which is not read"),
        "The program is in Heidenhain's conversational language.",
        "Post-process the part for a control that reads G-code.",
        hint "post-process the part for a control that reads G-code";
    FiveAxis { message: &'static str } => error "five-axis-use",
        says("{message}"),
        "A five-axis code cannot be used here.",
        "See the message for what has to come before it.";
    Corner { message: &'static str } => error "corner",
        says("the corner {message}"),
        "A corner (`,R` or `,C`) cannot be made.",
        "It needs two straight moves in the plane, both long enough.";
    NoProgramEnd => warning "no-program-end",
        says("the program ends without M2 or M30"),
        "The program ends without M2 or M30.",
        "End it with M2; without it the spindle and the coolant stay on.",
        hint "end the program with M2";
    NoClosingPercent => warning "no-closing-percent",
        says("the program ends without its closing %"),
        "The program begins with `%`, but does not end with it.",
        "Add a last line with `%`; the file may have been cut off.",
        hint "a program that starts with % also ends with %";
    ByteOrderMark => warning "byte-order-mark",
        says("a byte order mark at the start is skipped"),
        "The file begins with a byte order mark, which is skipped.",
        "Save it as plain text; many controls stumble over the mark.";
}

// Kinds that share the code of another one, and those of leniencies, whose rows stand in the table
// of leniencies.
same_codes {
    BadSymbol { symbol: char } => (Severity::Error, "bad-character"),
        says("{} cannot stand here", show_symbol(*.symbol));
    ReadOnlyName { name: String } => (Severity::Error, "read-only-parameter"),
        says("parameter #<{name}> cannot be set");
    CurvePoints { points: usize, order: u32 } => (Severity::Error, "curve"),
        says("a curve of order {order} needs at least {order} control points; it has {points}");
    PolarWithoutMotion { code: Code } => (Severity::Error, "polar"),
        says("polar coordinates are for motion, not for {code}");
    FinishDetour { code: Code, x: f64, z: f64 } => (Severity::Warning, "finish-detour"),
        says("{code} under cutter compensation goes to the end of its profile first, X{x} Z{z}, \
            as LinuxCNC 2.9 does"),
        hint "write the finishing pass without G41 and G42 (G40, with D or E), or refuse \
            finish-detour if the control goes straight to the profile";
    Lenient { leniency: Leniency } => (leniency.severity(), leniency.name()),
        says("{}", .leniency.meaning());
    Habit { leniency: Leniency, count: u64 } => (leniency.severity(), leniency.name()),
        says("{}{}", .leniency.meaning(), times(*.count)),
        hint leniency.remedy().map(str::to_owned);
    NotLenient { leniency: Leniency } => (Severity::Error, leniency.name()),
        says("{}: that is not allowed here", .leniency.meaning());
}

// What a machine says about a program, not its text.
machine {
    error "no-axis", "The program moves an axis that the machine does not have.", "Take a machine \
            with that axis: see `lostmotion machine list`.";
    error "path", "A move has no geometry.", "See the message.";
}
}
