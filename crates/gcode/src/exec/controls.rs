//! Codes of other controls: circular pockets (G12, G13) and patterns of holes (G70 to G72) as Haas
//! mills have them; five-axis words (G43.4, G43.5, G53.1, G68, G68.2, G69).

use super::Exec;
use crate::codes::Code;
use crate::exec::words::whole_within;
use crate::ops::{ArcFeed, CanonicalOp, Plane, Position, Tilt};
use crate::problem::Problem;
use crate::state::TipControl;
use lostmotion_base::math;
use lostmotion_base::units::rad;

/// Most holes of one pattern.
const MOST_HOLES: f64 = 10_000.0;

/// G12 and G13: a circular pocket about the place where the tool is. Z is its depth; I the radius
/// of the first circle, K that of the last one and Q the step between them; D the tool whose radius
/// is taken off.
pub(crate) fn pocket(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.check_feed(code)?;
    if exec.state.compensation.is_some() {
        return Err(Problem::Cycle {
            message: "a circular pocket cannot be cut under cutter compensation (G40 comes first)",
        });
    }
    let first = exec.need(b'I', code, "I, the radius of the first circle")?;
    let last = exec.word(b'K').unwrap_or(first);
    // Several circles need a step; one circle does not.
    let step = match (exec.word(b'K'), exec.word(b'Q')) {
        (Some(_), None) => {
            return Err(Problem::WordMissing {
                code,
                what: "Q, the step from circle to circle, with K",
            });
        }
        (_, Some(step)) if step <= 0.0 => {
            return Err(Problem::WordOutOfRange {
                code,
                letter: 'Q',
                value: step,
                allowed: "greater than zero",
            });
        }
        (_, step) => step.unwrap_or(1.0),
    };
    let tool = exec.pocket_tool(code)?;
    let limit = exec.config.limits.cycle_moves;
    // A tiny step would make millions of circles.
    if (last - first).abs() / step > f64::from(limit) / 4.0 {
        return Err(Problem::CycleTooLong { limit });
    }
    let center = exec.state.current;
    let mut floor = center;
    if let Some(z) = exec.axis_word(2) {
        floor[2] = if exec.state.absolute {
            z
        } else {
            center[2] + z
        };
    }
    exec.check_target(&floor)?;
    // Down at the centre, then circles of growing radius, then back to the centre.
    exec.move_to(floor, true);
    let clockwise = code.tenths == 120;
    let mut radius = first;
    loop {
        // The tool's centre runs inside the wall by its radius.
        let cut = radius.min(last.max(first)) - tool;
        if cut <= 0.0 {
            return Err(Problem::Cycle {
                message: "the tool is larger than the pocket",
            });
        }
        exec.pocket_circle(&floor, cut, clockwise);
        if radius >= last {
            break;
        }
        radius = (radius + step).min(last);
    }
    exec.move_to(floor, true);
    Ok(())
}

impl Exec<'_> {
    fn pocket_tool(&mut self, code: Code) -> Result<f64, Problem> {
        let Some(value) = self.word(b'D') else {
            return Ok(0.0);
        };
        let number = whole_within((code, b'D'), value, 0.0..1e9, "a tool number")? as i32;
        self.check_tool(number)?;
        // Tools in the table are measured in machine units.
        let diameter = self
            .tools
            .as_ref()
            .and_then(|table| table.get(number))
            .map_or(0.0, |tool| tool.diameter);
        Ok(0.5
            * self
                .config
                .machine_units
                .convert(diameter, self.state.units))
    }

    /// Out along X to a circle, and once round it.
    fn pocket_circle(&mut self, center: &Position, radius: f64, clockwise: bool) {
        let mut start = *center;
        start[0] += radius;
        self.move_to(start, true);
        let [_, _, z, others @ ..] = start;
        let turns = if clockwise { -1 } else { 1 };
        let arc = ArcFeed {
            plane: crate::ops::Plane::Xy,
            end: [start[0], start[1]],
            center: [center[0], center[1]],
            turns,
            axis_end: z,
            others,
        };
        self.emit(CanonicalOp::ArcFeed(arc));
    }

    /// G70 to G72: the cycle in force at each place of a pattern.
    pub(crate) fn pattern(&mut self, code: Code, cycle: Code) -> Result<(), Problem> {
        let size = self.need(
            b'I',
            code,
            "I, the radius of the pattern or the distance of its holes",
        )?;
        let angle = self.word(b'J').unwrap_or(0.0);
        let count = self.need(b'L', code, "L, the number of holes")?;
        let holes = whole_within((code, b'L'), count, 1.0..=MOST_HOLES, "1 to 10000")? as u32;
        // G70 spreads the holes over the full circle, G71 by K, G72 lies on a line.
        let each = match code.tenths {
            700 => 360.0 / f64::from(holes),
            710 => self.need(b'K', code, "K, the angle between holes")?,
            _ => 0.0,
        };
        let mut origin = self.state.current;
        for axis in [0, 1] {
            let word = self.axis_word(axis);
            origin[axis] = word.map_or(origin[axis], |value| {
                if self.state.absolute {
                    value
                } else {
                    origin[axis] + value
                }
            });
        }
        // G72 is a line, G70 and G71 lie on a circle about the origin.
        for hole in 0..holes {
            let (turn, reach) = if code.tenths == 720 {
                (angle, size * f64::from(hole))
            } else {
                (angle + each * f64::from(hole), size)
            };
            let (sin, cos) = math::sin_cos(rad(turn));
            let mut place = origin;
            (place[0], place[1]) = (origin[0] + reach * cos, origin[1] + reach * sin);
            self.cycle_at(cycle, place)?;
        }
        Ok(())
    }
}

fn failed(message: &'static str) -> Problem {
    Problem::FiveAxis { message }
}

/// G43.4 and G43.5: the tool offset of H, and X Y Z are the tip, whatever the rotary axes do.
pub(crate) fn tip(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    if exec.state.plane != Plane::Xy {
        return Err(failed("tool-centre-point control needs the XY plane (G17)"));
    }
    // Tip control needs the tool's length: it is applied first.
    super::tool::length(exec, code)?;
    // G43.5 also takes the direction of the tool from I, J and K.
    exec.state.tip_control = if code.tenths == 435 {
        TipControl::WithVector
    } else {
        TipControl::On
    };
    exec.emit(CanonicalOp::ToolTipControl(true));
    Ok(())
}

/// G68: X Y is the centre, R the angle.
pub(crate) fn rotate(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.no_tilt_yet()?;
    if exec.state.plane != Plane::Xy {
        return Err(failed(
            "coordinates can only be turned in the XY plane (G17)",
        ));
    }
    let degrees = exec.need(b'R', code, "R, the angle")?;
    let center = [0, 1].map(|axis| exec.axis_word(axis).unwrap_or(exec.state.current[axis]));
    exec.set_tilt(Some(Tilt::in_plane(center, degrees)))
}

/// G68.2: X Y Z is the origin, I J K the Euler angles (Z, X, Z).
pub(crate) fn tilt(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.no_tilt_yet()?;
    if exec.state.tip_control != TipControl::Off {
        return Err(failed(
            "a tilted plane cannot begin under tool-centre-point control (G49 comes first)",
        ));
    }
    // Words that are missing are zero: origin at the program's zero, no rotation.
    let origin = [0, 1, 2].map(|axis| exec.axis_word(axis).unwrap_or(0.0));
    let euler = [b'I', b'J', b'K'].map(|letter| exec.word(letter).unwrap_or(0.0));
    exec.set_tilt(Some(Tilt::in_space(origin, euler)))
}

/// G69: ends the turned coordinates.
pub(crate) fn untilt(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.set_tilt(None)
}

/// G53.1: the rotary axes turn so that the tool stands upright on the tilted plane.
pub(crate) fn orient(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    let Some(tilt) = exec.state.offsets.tilt else {
        return Err(failed("G53.1 needs a tilted plane (G68.2) before it"));
    };
    // The third column of the rotation is the plane's normal in program coordinates.
    let axis = tilt.rows.map(|row| row[2]);
    exec.emit(CanonicalOp::OrientTool(axis));
    Ok(())
}

impl Exec<'_> {
    fn no_tilt_yet(&self) -> Result<(), Problem> {
        if self.state.compensation.is_some() {
            return Err(Problem::Compensation {
                message: "the coordinates cannot turn under cutter compensation",
            });
        }
        if self.state.offsets.tilt.is_some() {
            Err(failed(
                "the coordinates are turned already (G69 comes first)",
            ))
        } else {
            Ok(())
        }
    }

    pub(crate) fn set_tilt(&mut self, tilt: Option<Tilt>) -> Result<(), Problem> {
        if self.state.offsets.tilt == tilt {
            return Ok(());
        }
        self.state.rebase(|offsets| offsets.tilt = tilt);
        self.emit(CanonicalOp::SetTilt(tilt.map(Box::new)));
        self.check_target(&self.state.current)
    }

    /// Leaves tool-centre-point control.
    pub(crate) fn end_tip_control(&mut self) {
        if self.state.tip_control != TipControl::Off {
            self.state.tip_control = TipControl::Off;
            self.emit(CanonicalOp::ToolTipControl(false));
        }
    }

    /// I J K of a straight move under G43.5.
    pub(crate) fn tool_vector(&mut self) -> Result<(), Problem> {
        let named = [b'I', b'J', b'K'].map(|letter| self.word(letter));
        if named.iter().all(Option::is_none) {
            return Ok(());
        }
        let [i, j, k] = named.map(Option::unwrap_or_default);
        // A direction: only the ratio of I, J and K counts.
        let length = math::hypot(math::hypot(i, j), k);
        if length == 0.0 {
            return Err(failed("the direction of the tool (I, J, K) has no length"));
        }
        self.emit(CanonicalOp::OrientTool([
            i / length,
            j / length,
            k / length,
        ]));
        Ok(())
    }
}
