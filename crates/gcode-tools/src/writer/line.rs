//! Canonical operations as blocks of text: words, numbers, comments, motions.

use super::Frame;
use lostmotion_gcode::Dialect;
use lostmotion_gcode::ops::{
    ArcFeed, CanonicalOp, NurbsFeed, OutputValue, PathControl, Plane, Position, SourcedOp,
    TextKind, Units, WaitFor,
};
use lostmotion_gcode::state::{FeedMode, State};

/// A block, or a few, and how many operations they stand for.
pub(super) struct Line {
    pub(super) text: String,
    pub(super) ops: usize,
}

impl Line {
    /// The block of one operation.
    fn one(text: String) -> Line {
        Line { text, ops: 1 }
    }
}

/// The first blocks of every program.
pub(super) fn head(frame: &Frame) -> [String; 3] {
    let system = Dialect::LinuxCnc.system_name(u16::from(frame.system));
    let units = if frame.units == Units::Mm {
        "G21"
    } else {
        "G20"
    };
    [
        format!("(coordinates of {system}; everything else is resolved)"),
        format!("{units} G90 G91.1 G17 G94 G40 G49 G64 G80 G8 G97"),
        format!("{system} G92.1"),
    ]
}

/// The block for the operations at the front.
pub(super) fn line(window: &[&SourcedOp], state: &State, sync: Option<f64>) -> Option<Line> {
    use CanonicalOp as O;
    let ops: Vec<&CanonicalOp> = window.iter().map(|sourced| &sourced.op).collect();
    let ops = ops.as_slice();
    let (first, rest) = ops.split_first()?;
    let (own, next) = (
        window.first()?.named,
        window.get(1).map_or(0, |op| op.named),
    );
    // The program's end first: M2 makes several operations that have blocks of their own.
    if let Some(ops) = end(ops) {
        return Some(Line {
            text: "M2".to_owned(),
            ops,
        });
    }
    match first {
        O::SetFeedRate { rate, inverse_time } => feed((*rate, *inverse_time), rest, next, state),
        // G33 is the start of synchronisation and the move; its end needs no text.
        O::StartSpeedFeedSync(pitch) => rest
            .first()
            .and_then(|op| in_step(op, next, *pitch, state))
            .map(|text| Line { text, ops: 2 }),
        O::StopSpeedFeedSync => Some(Line::one(String::new())),
        O::StraightFeed(_) | O::RigidTap(_) => match sync {
            Some(pitch) => in_step(first, own, pitch, state),
            None => motion(first, own, state),
        }
        .map(Line::one),
        O::StraightTraverse(_) | O::ArcFeed(_) | O::StraightProbe(_) => {
            motion(first, own, state).map(Line::one)
        }
        O::NurbsFeed(feed) => curve(feed).map(Line::one),
        O::SetMotionControlMode(PathControl::Continuous { tolerance }) => {
            Some(continuous(*tolerance, rest, state))
        }
        O::SetNaiveCamTolerance(merge) => match state.path_control {
            PathControl::Continuous { tolerance } => Some(Line::one(g64(tolerance, *merge))),
            _ => None,
        },
        O::SetSpindleMode {
            spindle: 0,
            highest,
        } if *highest > 0.0 => Some(surface_speed(*highest, rest, state)),
        O::SetSpindleSpeed { spindle: 0, speed } => spindle_speed(*speed, rest, state),
        O::SetSpindleSpeed { spindle, speed } => {
            Some(Line::one(format!("{} ${spindle}", word('S', *speed))))
        }
        O::StartChange => change(rest).map(|ops| Line {
            text: "M6".to_owned(),
            ops: 1 + ops,
        }),
        O::SelectTool(tool) if rest.first() == Some(&&O::StartChange) => {
            rest.get(1..).and_then(change).map(|ops| Line {
                text: format!("T{tool} M6"),
                ops: 2 + ops,
            })
        }
        O::OrientSpindle {
            spindle,
            degrees,
            way,
            ..
        } => Some(orient(*spindle, *degrees, way.number(), rest)),
        // M9 switches both off; M7 and M8 switch on singly.
        O::Mist(false) => Some(Line {
            text: "M9".to_owned(),
            ops: 1 + usize::from(rest.first() == Some(&&O::Flood(false))),
        }),
        O::PalletShuttle => Some(Line {
            text: "M60".to_owned(),
            ops: 2.min(ops.len()),
        }),
        other => setting(other, state).map(Line::one),
    }
}

/// G64 P Q sets both tolerances in one block; the second operation may be missing if it changes nothing.
fn continuous(tolerance: f64, rest: &[&CanonicalOp], state: &State) -> Line {
    match rest.first() {
        Some(CanonicalOp::SetNaiveCamTolerance(merge)) => Line {
            text: g64(tolerance, *merge),
            ops: 2,
        },
        _ => Line::one(g64(tolerance, state.merge_tolerance)),
    }
}

fn g64(tolerance: f64, merge: f64) -> String {
    format!("G64 P{tolerance} Q{merge}")
}

/// Constant surface speed up to a highest speed of the spindle. G96 needs an S on its line: the one that
/// follows, or the speed in force.
fn surface_speed(highest: f64, rest: &[&CanonicalOp], state: &State) -> Line {
    // Without D there is no limit, which the interpreter writes as 1e30.
    let limit = if highest >= 1e30 {
        String::new()
    } else {
        format!(" {}", word('D', highest))
    };
    let (speed, ops) = match rest.first() {
        Some(CanonicalOp::SetSpindleSpeed { spindle: 0, speed }) => (*speed, 2),
        _ => (state.spindle.speed, 1),
    };
    Line {
        text: format!("G96{limit} {}", word('S', speed)),
        ops,
    }
}

/// A speed of spindle 0, on the line of its start if that follows.
fn spindle_speed(speed: f64, rest: &[&CanonicalOp], state: &State) -> Option<Line> {
    match rest.first() {
        Some(start @ CanonicalOp::StartSpindle { spindle: 0, .. }) => Some(Line {
            text: format!("{} {}", setting(start, state)?, word('S', speed)),
            ops: 2,
        }),
        _ => Some(Line::one(word('S', speed))),
    }
}

/// M19 with Q orients and waits: two operations, one block.
fn orient(spindle: u8, degrees: f64, way: u8, rest: &[&CanonicalOp]) -> Line {
    let (wait, ops) = match rest.first() {
        Some(CanonicalOp::WaitOrient { seconds, .. }) => (format!(" Q{seconds}"), 2),
        _ => (String::new(), 1),
    };
    Line {
        text: format!("M19 R{degrees} P{way}{wait}{}", numbered(spindle)),
        ops,
    }
}

/// A feed rate, on the line of its move if that follows.
fn feed(
    (rate, inverse_time): (f64, Option<f64>),
    rest: &[&CanonicalOp],
    named: u16,
    state: &State,
) -> Option<Line> {
    // A rapid does not use the feed: F then stands on a line of its own.
    let next = rest
        .first()
        .filter(|op| !matches!(op, CanonicalOp::StraightTraverse(_)))
        .and_then(|op| motion(op, named, state));
    let inverse = state.feed_mode == FeedMode::InverseTime;
    // In inverse time each move has its own F, so that F cannot stand alone.
    if let Some(per_minute) = inverse_time {
        let mode = if inverse { "" } else { "G93 " };
        return next.map(|motion| Line {
            text: format!("{mode}{motion} {}", word('F', per_minute)),
            ops: 2,
        });
    }
    // A plain rate after inverse time needs G94 first.
    let (mode, rate) = (if inverse { "G94 " } else { "" }, word('F', rate));
    Some(match next {
        Some(motion) => Line {
            text: format!("{mode}{motion} {rate}"),
            ops: 2,
        },
        None => Line::one(format!("{mode}{rate}")),
    })
}

/// How many operations end a tool change that has begun.
fn change(rest: &[&CanonicalOp]) -> Option<usize> {
    rest.iter()
        .take(2)
        .position(|op| matches!(op, CanonicalOp::ChangeTool(_)))
        .map(|at| at + 1)
}

/// A move in step with the spindle.
fn in_step(op: &CanonicalOp, named: u16, pitch: f64, state: &State) -> Option<String> {
    let (code, end) = match op {
        CanonicalOp::StraightFeed(end) => ("G33", *end),
        CanonicalOp::RigidTap([x, y, z]) => {
            let [_, _, _, others @ ..] = state.current;
            let [a, b, c, u, v, w] = others;
            ("G33.1", [*x, *y, *z, a, b, c, u, v, w])
        }
        _ => return None,
    };
    let ends = axes(&state.current, &end, named);
    Some(format!("{code} {ends} {}", word('K', pitch)))
}

/// How many operations M2 stands for: those that it makes itself, in its order, up to the end.
/// Spindle and coolant are switched off by blocks of their own where they come first.
fn end(ops: &[&CanonicalOp]) -> Option<usize> {
    use CanonicalOp as O;
    // Only if the whole run up to the end is in M2's own order does M2 stand for it.
    if matches!(
        ops.first(),
        Some(O::StopSpindle { .. } | O::Mist(_) | O::Flood(_))
    ) {
        return None;
    }
    let mut last = 0;
    for (index, op) in ops.iter().enumerate() {
        let rank = match op {
            O::SelectPlane(Plane::Xy) => 1,
            O::SetFeedMode {
                per_revolution: false,
            } => 2,
            O::SetFeedRate {
                rate: 0.0,
                inverse_time: None,
            } => 3,
            O::FeedOverride(true) => 4,
            O::SpeedOverride(true) => 5,
            O::StopSpindle { spindle: 0 } => 6,
            O::SetSpindleMode {
                spindle: 0,
                highest: 0.0,
            } => 7,
            O::Mist(false) => 8,
            O::Flood(false) => 9,
            O::ProgramEnd => return Some(index + 1),
            _ => return None,
        };
        if rank <= last {
            return None;
        }
        last = rank;
    }
    None
}

fn numbered(spindle: u8) -> String {
    if spindle == 0 {
        String::new()
    } else {
        format!(" ${spindle}")
    }
}

/// The block of an operation that stands for itself.
fn setting(op: &CanonicalOp, state: &State) -> Option<String> {
    use CanonicalOp as O;
    let switch = |code: &str, on: bool| format!("{code} P{}", u8::from(on));
    Some(match op {
        O::UseLengthUnits(Units::Mm) => "G21".to_owned(),
        O::UseLengthUnits(Units::Inch) => "G20".to_owned(),
        O::SetFeedMode { per_revolution } => if *per_revolution { "G95" } else { "G94" }.to_owned(),
        O::SelectPlane(Plane::Xy) => "G17".to_owned(),
        O::SelectPlane(Plane::Zx) => "G18".to_owned(),
        O::SelectPlane(Plane::Yz) => "G19".to_owned(),
        O::SetMotionControlMode(PathControl::ExactPath) => "G61".to_owned(),
        O::SetMotionControlMode(PathControl::ExactStop) => "G61.1".to_owned(),
        O::UseToolLengthOffset(offset) if *offset == [0.0; 9] => "G49".to_owned(),
        // Axes that are not named keep their offset: those of a machine without U V W stay unnamed.
        O::UseToolLengthOffset(offset) => {
            format!("G43.1 {}", axes(&state.offsets.tool, offset, 0))
        }
        O::Dwell(seconds) => format!("G4 {}", word('P', *seconds)),
        O::SelectTool(tool) => format!("T{tool}"),
        O::ChangeToolNumber(tool) => format!("M61 Q{tool}"),
        O::SetSpindleMode {
            spindle: 0,
            highest: 0.0,
        } => "G97".to_owned(),
        O::StartSpindle { spindle, clockwise } => format!(
            "{}{}",
            if *clockwise { "M3" } else { "M4" },
            numbered(*spindle)
        ),
        O::StopSpindle { spindle } => format!("M5{}", numbered(*spindle)),
        O::WaitOrient { spindle, seconds } => format!("M19 Q{seconds}{}", numbered(*spindle)),
        O::SetOutput {
            index,
            value,
            with_motion,
        } => output(*index, *value, *with_motion),
        O::ReadInput {
            index,
            analog: true,
            ..
        } => format!("M66 E{index} L0"),
        O::ReadInput {
            index,
            wait,
            seconds,
            ..
        } => format!("M66 P{index} L{} Q{seconds}", wait_number(*wait)),
        O::Mist(true) => "M7".to_owned(),
        O::Flood(true) => "M8".to_owned(),
        O::Flood(false) => "M9".to_owned(),
        O::FeedOverride(on) => switch("M50", *on),
        O::SpeedOverride(on) => switch("M51", *on),
        O::AdaptiveFeed(on) => switch("M52", *on),
        O::FeedHold(on) => switch("M53", *on),
        O::Text { kind, text } => comment(*kind, text),
        O::ProgramStop => "M0".to_owned(),
        O::OptionalProgramStop => "M1".to_owned(),
        _ => return None,
    })
}

fn output(index: u8, value: OutputValue, with_motion: bool) -> String {
    match (value, with_motion) {
        (OutputValue::Digital(true), true) => format!("M62 P{index}"),
        (OutputValue::Digital(false), true) => format!("M63 P{index}"),
        (OutputValue::Digital(true), false) => format!("M64 P{index}"),
        (OutputValue::Digital(false), false) => format!("M65 P{index}"),
        (OutputValue::Analog(value), true) => format!("M67 E{index} Q{value}"),
        (OutputValue::Analog(value), false) => format!("M68 E{index} Q{value}"),
    }
}

const fn wait_number(wait: WaitFor) -> u8 {
    match wait {
        WaitFor::Now => 0,
        WaitFor::Rise => 1,
        WaitFor::Fall => 2,
        WaitFor::High => 3,
        WaitFor::Low => 4,
    }
}

/// A straight move, an arc or a probing move, without its feed.
pub(super) fn motion(op: &CanonicalOp, named: u16, state: &State) -> Option<String> {
    let to = |code: &str, end: &Position| format!("{code} {}", axes(&state.current, end, named));
    Some(match op {
        CanonicalOp::StraightTraverse(end) => to("G0", end),
        // A feed move that goes nowhere: as a distance, since the machine may stand elsewhere.
        CanonicalOp::StraightFeed(end) if changed(&state.current, end, named).is_empty() => {
            "G91 G1 X0".to_owned()
        }
        CanonicalOp::StraightFeed(end) => to("G1", end),
        CanonicalOp::ArcFeed(feed) => arc(feed, named, state),
        CanonicalOp::StraightProbe(probe) => {
            let code = match (probe.away, probe.must) {
                (false, true) => "G38.2",
                (false, false) => "G38.3",
                (true, true) => "G38.4",
                (true, false) => "G38.5",
            };
            to(code, &probe.end)
        }
        _ => return None,
    })
}

fn arc(arc: &ArcFeed, named: u16, state: &State) -> String {
    let [first, second, _] = arc.plane.axes();
    let letter = |axis: usize| ['I', 'J', 'K'].get(axis).copied().unwrap_or('I');
    // The bits of the centre have to come back when the block is read.
    let start = [state.current[first], state.current[second]];
    // I and J relative to the start are short, but the sum may round: then absolute centres
    // (G90.1).
    let offsets = [
        offset(start[0], arc.center[0]),
        offset(start[1], arc.center[1]),
    ];
    let (mode, center) = match offsets {
        [Some(one), Some(two)] => (if state.arc_absolute { "G91.1 " } else { "" }, [one, two]),
        _ => (if state.arc_absolute { "" } else { "G90.1 " }, arc.center),
    };
    let code = if arc.turns < 0 { "G2" } else { "G3" };
    let end = changed(&state.current, &arc.position(), named);
    let end = if end.is_empty() {
        end
    } else {
        format!("{end} ")
    };
    let turns = if arc.turns.abs() > 1 {
        format!(" P{}", arc.turns.abs())
    } else {
        String::new()
    };
    format!(
        "{mode}{code} {end}{} {}{turns}",
        word(letter(first), center[0]),
        word(letter(second), center[1])
    )
}

/// The shortest offset that leads from a start to a centre exactly, if there is one.
fn offset(start: f64, center: f64) -> Option<f64> {
    // From few to many decimals, then the neighbours of the exact difference.
    let exact = center - start;
    let leads = |offset: &f64| (start + offset).to_bits() == center.to_bits();
    let rounded = (0..=12)
        .filter_map(|decimals| format!("{exact:.decimals$}").parse::<f64>().ok())
        .map(|offset| offset + 0.0);
    rounded
        .chain([exact, exact.next_up(), exact.next_down()])
        .find(leads)
}

/// A NURBS block by block.
pub(super) fn curve(curve: &NurbsFeed) -> Option<String> {
    let (first, rest) = curve.points.split_first()?;
    // The first control point is where the tool is: its block has only weight and order.
    let mut text = format!("G5.2 P{} L{}\n", first.weight, curve.order);
    for point in rest {
        text.push_str(&format!(
            "G5.2 X{} Y{} P{}\n",
            point.at[0], point.at[1], point.weight
        ));
    }
    text.push_str("G5.3");
    Some(text)
}

const LETTERS: [char; 9] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];

/// A letter with the shortest decimal that is read as this number.
pub(super) fn word(letter: char, value: f64) -> String {
    format!("{letter}{value}")
}

/// Words of the axes that are named or whose end is not where they are; X if there is none.
pub(super) fn axes(from: &Position, to: &Position, named: u16) -> String {
    let words = changed(from, to, named);
    if words.is_empty() {
        word('X', to[0])
    } else {
        words
    }
}

/// Words of the axes that are named or whose end is not where they are; empty if there is none.
pub(super) fn changed(from: &Position, to: &Position, named: u16) -> String {
    // Compared as bits: -0 and 0 are written differently and have to be read back the same.
    let has_word =
        |axis: &usize| named & (1 << axis) != 0 || from[*axis].to_bits() != to[*axis].to_bits();
    let words = (0..9).filter(has_word);
    let words: Vec<String> = words.map(|axis| word(LETTERS[axis], to[axis])).collect();
    words.join(" ")
}

/// A text as a comment.
pub(super) fn comment(kind: TextKind, text: &str) -> String {
    let prefix = match kind {
        TextKind::Comment => "",
        TextKind::Message => "MSG,",
        TextKind::Print => "PRINT,",
        TextKind::Log => "LOG,",
    };
    if text.contains(['(', ')']) {
        format!(";{prefix}{text}")
    } else {
        format!("({prefix}{text})")
    }
}
