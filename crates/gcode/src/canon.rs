//! Canonical operations as text, as LinuxCNC's stand-alone interpreter prints them.

use crate::config::InterpreterConfig;
use crate::diagnostics::Diagnostics;
use crate::ops::{
    ArcFeed, CanonicalOp, OutputValue, PathControl, Plane, Position, TextKind, Units,
};
use crate::program::Program;
use std::fmt::{self, Display, Formatter};
use std::io::{self, BufRead};

/// Six coordinates, four decimals.
struct Six<'a>(&'a [f64]);

impl Display for Six<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (index, coordinate) in self.0.iter().take(6).enumerate() {
            if index > 0 {
                f.write_str(", ")?;
            }
            Display::fmt(&Four(*coordinate), f)?;
        }
        Ok(())
    }
}

const fn switch(on: bool) -> &'static str {
    if on { "ENABLE" } else { "DISABLE" }
}

fn tool_offset(f: &mut Formatter<'_>, offset: &Position) -> fmt::Result {
    let [x, y, z, a, b, c, u, v, w] = offset;
    write!(
        f,
        "USE_TOOL_LENGTH_OFFSET({x:.4} {y:.4} {z:.4}, {a:.4} {b:.4} {c:.4}, {u:.4} {v:.4} {w:.4})"
    )
}

fn arc(f: &mut Formatter<'_>, arc: &ArcFeed) -> fmt::Result {
    // Plane coordinates first, then the axis normal to the plane, then the rotary axes; U V W are
    // not shown.
    let ([first, second], [center_first, center_second], [a, b, c, ..]) =
        (arc.end, arc.center, arc.others);
    let [first, second, center_first, center_second] =
        [first, second, center_first, center_second].map(Four);
    let [axis_end, a, b, c] = [arc.axis_end, a, b, c].map(Four);
    write!(
        f,
        "ARC_FEED({first}, {second}, {center_first}, {center_second}, {}, {axis_end}, {a}, {b}, {c})",
        arc.turns
    )
}

fn path_control(f: &mut Formatter<'_>, control: PathControl) -> fmt::Result {
    match control {
        PathControl::ExactPath => f.write_str("SET_MOTION_CONTROL_MODE(CANON_EXACT_PATH)"),
        PathControl::ExactStop => f.write_str("SET_MOTION_CONTROL_MODE(CANON_EXACT_STOP)"),
        PathControl::Continuous { tolerance } => write!(
            f,
            "SET_MOTION_CONTROL_MODE(CANON_CONTINUOUS, {tolerance:.6})"
        ),
    }
}

fn text(f: &mut Formatter<'_>, kind: TextKind, text: &str) -> fmt::Result {
    let name = match kind {
        TextKind::Comment => "COMMENT",
        TextKind::Message => "MESSAGE",
        TextKind::Print => "PRINT",
        TextKind::Log => "LOG",
    };
    write!(f, "{name}(\"{text}\")")
}

impl Display for CanonicalOp {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        use CanonicalOp as O;
        match self {
            O::UseLengthUnits(Units::Mm) => f.write_str("USE_LENGTH_UNITS(CANON_UNITS_MM)"),
            O::UseLengthUnits(Units::Inch) => f.write_str("USE_LENGTH_UNITS(CANON_UNITS_INCHES)"),
            O::SetG5xOffset { system, offset } => {
                write!(f, "SET_G5X_OFFSET({system}, {})", Six(offset))
            }
            O::SetG92Offset(offset) => write!(f, "SET_G92_OFFSET({})", Six(offset)),
            O::SetXyRotation(degrees) => write!(f, "SET_XY_ROTATION({degrees:.4})"),
            O::SetFeedRate { rate, .. } => write!(f, "SET_FEED_RATE({})", Four(*rate)),
            O::SetFeedMode { per_revolution } => {
                write!(f, "SET_FEED_MODE(0, {})", u8::from(*per_revolution))
            }
            O::StraightTraverse(end) => write!(f, "STRAIGHT_TRAVERSE({})", Six(end)),
            O::StraightFeed(end) => write!(f, "STRAIGHT_FEED({})", Six(end)),
            O::ArcFeed(feed) => arc(f, feed),
            O::NurbsFeed(curve) => write!(f, "NURBS_FEED({}, ...)", curve.points.len()),
            O::StraightProbe(probe) => write!(f, "STRAIGHT_PROBE({})", Six(&probe.end)),
            O::RigidTap([x, y, z]) => write!(f, "RIGID_TAP({x:.4}, {y:.4}, {z:.4})"),
            O::StartSpeedFeedSync(rate) => write!(f, "START_SPEED_FEED_SYNC({rate:.6},0)"),
            O::StopSpeedFeedSync => f.write_str("STOP_SPEED_FEED_SYNCH()"),
            O::Dwell(seconds) => write!(f, "DWELL({})", Four(*seconds)),
            O::SelectPlane(Plane::Xy) => f.write_str("SELECT_PLANE(CANON_PLANE_XY)"),
            O::SelectPlane(Plane::Zx) => f.write_str("SELECT_PLANE(CANON_PLANE_XZ)"),
            O::SelectPlane(Plane::Yz) => f.write_str("SELECT_PLANE(CANON_PLANE_YZ)"),
            O::SetMotionControlMode(control) => path_control(f, *control),
            O::SetNaiveCamTolerance(tolerance) => {
                write!(f, "SET_NAIVECAM_TOLERANCE({tolerance:.4})")
            }
            O::UseToolLengthOffset(offset) => tool_offset(f, offset),
            O::SetTilt(None) => f.write_str("SET_TILT()"),
            O::SetTilt(Some(tilt)) => {
                // Origin, then the matrix by rows; LinuxCNC has no such operation, so that the
                // form is ours.
                let numbers = tilt
                    .origin
                    .into_iter()
                    .chain(tilt.rows.into_iter().flatten())
                    .map(|number| format!("{number:.4}"));
                write!(f, "SET_TILT({})", numbers.collect::<Vec<_>>().join(", "))
            }
            O::ToolTipControl(on) => write!(f, "TOOL_TIP_CONTROL({})", u8::from(*on)),
            O::OrientTool([i, j, k]) => write!(f, "ORIENT_TOOL({i:.4}, {j:.4}, {k:.4})"),
            O::Text {
                kind,
                text: content,
            } => text(f, *kind, content),
            _ => state_change(f, self),
        }
    }
}

fn output(f: &mut Formatter<'_>, index: u8, value: OutputValue, with_motion: bool) -> fmt::Result {
    let when = if with_motion { "MOTION" } else { "AUX" };
    match value {
        OutputValue::Digital(true) => write!(f, "SET_{when}_OUTPUT_BIT({index})"),
        OutputValue::Digital(false) => write!(f, "CLEAR_{when}_OUTPUT_BIT({index})"),
        OutputValue::Analog(value) => write!(f, "SET_{when}_OUTPUT_VALUE({index},{value:.6})"),
    }
}

/// Operations that do not move an axis.
fn state_change(f: &mut Formatter<'_>, op: &CanonicalOp) -> fmt::Result {
    use CanonicalOp as O;
    match op {
        O::SelectTool(tool) => write!(f, "SELECT_TOOL({tool})"),
        O::StartChange => f.write_str("START_CHANGE()"),
        O::ChangeTool(tool) => write!(f, "CHANGE_TOOL({tool})"),
        O::ChangeToolNumber(tool) => write!(f, "CHANGE_TOOL_NUMBER({tool})"),
        O::SetSpindleSpeed { spindle, speed } => {
            write!(f, "SET_SPINDLE_SPEED({spindle}, {speed:.4})")
        }
        O::SetSpindleMode { spindle, highest } => {
            write!(f, "SET_SPINDLE_MODE({spindle} {highest:.4})")
        }
        O::StartSpindle {
            spindle,
            clockwise: true,
        } => write!(f, "START_SPINDLE_CLOCKWISE({spindle})"),
        O::StartSpindle {
            spindle,
            clockwise: false,
        } => write!(f, "START_SPINDLE_COUNTERCLOCKWISE({spindle})"),
        O::StopSpindle { spindle } => write!(f, "STOP_SPINDLE_TURNING({spindle})"),
        O::OrientSpindle {
            spindle,
            degrees,
            way,
            boring,
        } => {
            write!(
                f,
                "ORIENT_SPINDLE({spindle}, {degrees:.4}, {})",
                way.number() + u8::from(*boring)
            )
        }
        O::WaitOrient { spindle, seconds } => {
            write!(f, "SPINDLE.{spindle}.WAIT_ORIENT_COMPLETE({seconds:.4})")
        }
        O::SetOutput {
            index,
            value,
            with_motion,
        } => output(f, *index, *value, *with_motion),
        O::ReadInput {
            index,
            analog,
            wait,
            seconds,
        } => {
            write!(
                f,
                "WAIT_INPUT({}, {index}, {wait:?}, {seconds:.4})",
                if *analog { "ANALOG" } else { "DIGITAL" }
            )
        }
        O::Mist(on) => write!(f, "MIST_{}()", if *on { "ON" } else { "OFF" }),
        O::Flood(on) => write!(f, "FLOOD_{}()", if *on { "ON" } else { "OFF" }),
        O::FeedOverride(on) => write!(f, "{}_FEED_OVERRIDE()", switch(*on)),
        O::SpeedOverride(on) => write!(f, "{}_SPEED_OVERRIDE(0)", switch(*on)),
        O::AdaptiveFeed(on) => write!(f, "{}_ADAPTIVE_FEED()", switch(*on)),
        O::FeedHold(on) => write!(f, "{}_FEED_HOLD()", switch(*on)),
        O::ProgramStop => f.write_str("PROGRAM_STOP()"),
        O::OptionalProgramStop => f.write_str("OPTIONAL_PROGRAM_STOP()"),
        O::PalletShuttle => f.write_str("PALLET_SHUTTLE()"),
        _ => f.write_str("PROGRAM_END()"),
    }
}

/// Writes a program's canonical operations, one per line, and gives what was found.
///
/// # Errors
/// Those of the writer.
pub fn write<R: BufRead>(
    source: R,
    config: InterpreterConfig,
    out: &mut impl io::Write,
) -> io::Result<Diagnostics> {
    write_program(Program::new(source, config), out)
}

/// The same for a program that is set up already, with a loader of subroutines for example.
///
/// # Errors
/// Those of the writer.
pub fn write_program<R: BufRead>(
    mut program: Program<R>,
    out: &mut impl io::Write,
) -> io::Result<Diagnostics> {
    for (index, sourced) in program.by_ref().enumerate() {
        writeln!(out, "{:5} N..... {}", index + 1, sourced.op)?;
    }
    Ok(program.finish())
}

/// A number that is shown as `{:.4}` shows it.
///
/// Times 10,000 and rounded it is a whole number, whose digits are cheap. The product is off by
/// half a unit in its last place at most; where that could change the rounding, or the product is
/// too large, the standard library does it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Four(pub(crate) f64);

/// Products below this (2^43) are exact to 1/2048.
const LARGEST_SCALED: f64 = 8_796_093_022_208.0;
/// Largest distance from a whole number at which the rounding is certain.
const CERTAIN_DISTANCE: f64 = 0.5 - 1.0 / 1024.0;
/// Bytes: sign, up to 9 digits, point, 4 digits, and one to spare.
const TEXT_BYTES: usize = 16;

impl Display for Four {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        // Ten-thousandths as an integer; halves and very large values are left to the standard
        // library.
        let scaled = self.0.abs() * 1e4;
        let whole = (scaled + 0.5) as u64;
        if scaled.is_nan()
            || scaled >= LARGEST_SCALED
            || (scaled - whole as f64).abs() > CERTAIN_DISTANCE
        {
            return write!(f, "{:.4}", self.0);
        }
        // The buffer is full of minus signs: the one before the first digit is shown for negative
        // numbers.
        let mut text = [b'-'; TEXT_BYTES];
        let start = put(&mut text, whole) - usize::from(self.0.is_sign_negative());
        let shown = text
            .get(start..)
            .and_then(|bytes| std::str::from_utf8(bytes).ok());
        f.write_str(shown.ok_or(fmt::Error)?)
    }
}

/// Puts ten-thousandths at the end of a text and gives where they begin; what lies before is left
/// as it is.
fn put(text: &mut [u8; TEXT_BYTES], mut whole: u64) -> usize {
    let mut start = TEXT_BYTES;
    for (index, slot) in text.iter_mut().enumerate().rev() {
        let place = TEXT_BYTES - 1 - index;
        // The point stands before the last four digits.
        if place == 4 {
            *slot = b'.';
            continue;
        }
        *slot = b'0' + (whole % 10) as u8;
        whole /= 10;
        start = index;
        // At least one digit stands before the point.
        if place > 4 && whole == 0 {
            break;
        }
    }
    start
}

#[cfg(test)]
mod tests {
    use super::Four;
    use proptest::prelude::*;

    fn check(number: f64) {
        assert_eq!(
            Four(number).to_string(),
            format!("{number:.4}"),
            "{number:e}"
        );
    }

    #[test]
    fn borders_of_rounding_and_size_are_as_in_the_standard_library() {
        for number in [
            0.0,
            0.00005,
            0.00015,
            0.12345,
            0.99995,
            0.999_950_000_1,
            9.99995,
            1e-300,
            12345.67895,
            f64::MIN_POSITIVE,
        ] {
            for near in [number, number.next_up(), number.next_down(), -number] {
                check(near);
            }
        }
        for number in [
            879_609_302.220_7,
            879_609_302.220_8,
            879_609_302.3,
            1e9,
            1e22,
            f64::MAX,
            f64::INFINITY,
            f64::NAN,
        ] {
            check(number);
            check(-number);
        }
    }

    proptest! {
        #[test]
        fn all_numbers_are_as_in_the_standard_library(bits in any::<u64>(), small in -1e6..1e6, ten_thousandths in -2_000_000_000_i64..2_000_000_000) {
            check(f64::from_bits(bits));
            check(small);
            // Decimals as programs have them, and half way between.
            check(ten_thousandths as f64 / 1e4);
            check(ten_thousandths as f64 / 1e5);
            check((2 * ten_thousandths + 1) as f64 / 2e4);
        }
    }
}
