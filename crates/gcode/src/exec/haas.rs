//! Circular pockets (G12, G13) and patterns of holes (G70 to G72) as Haas mills have them.

use super::Exec;
use crate::code::{Code, whole};
use crate::ops::{ArcFeed, CanonicalOp, Position};
use crate::problem::Problem;
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
        let number = whole(value).filter(|number| (0.0..1e9).contains(number));
        let number = number.ok_or(Problem::WordOutOfRange {
            code,
            letter: 'D',
            value,
            allowed: "a tool number",
        })? as i32;
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
        let holes = whole(count).filter(|holes| (1.0..=MOST_HOLES).contains(holes));
        let holes = holes.ok_or(Problem::WordOutOfRange {
            code,
            letter: 'L',
            value: count,
            allowed: "1 to 10000",
        })? as u32;
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
