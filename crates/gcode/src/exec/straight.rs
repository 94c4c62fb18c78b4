//! Straight moves: G0, G1, G53, polar words, homes (G28, G30), probing (G38.2 to G38.5); and G4.

use super::Exec;
use crate::codes::Code;
use crate::codes::row::bit;
use crate::ops::{CanonicalOp, Plane, Position, StraightProbe, Units};
use crate::parameters::HOME;
use crate::problem::Problem;
use crate::state::{FeedMode, TipControl, convert};
use crate::syntax::special::{CORNER_CHAMFER, CORNER_RADIUS};
use lostmotion_base::math;
use lostmotion_base::units::{deg, rad};

/// Slowest feed that inverse time results in, units per minute. Published: LinuxCNC.
const LEAST_INVERSE_TIME_RATE: f64 = 0.1;

/// Bits of `,R` and `,C`.
pub(crate) const CORNER_BITS: u32 = bit(CORNER_RADIUS) | bit(CORNER_CHAMFER);

/// G0.
pub(crate) fn traverse(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    let end = exec.target()?;
    let start = exec.state.current;
    exec.state.current = end;
    exec.straight(&start, end, false)
}

/// G1.
pub(crate) fn feed(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    let end = exec.target()?;
    let start = exec.state.current;
    exec.state.current = end;
    exec.check_feed(code)?;
    // The rate of inverse time follows from the length, so that the ends come first.
    exec.inverse_time(|| straight_length(&start, &end));
    // A move with ,R or ,C waits for the next one, which makes the corner.
    if exec.words.mask & CORNER_BITS != 0 && exec.hold_corner(&start, end)? {
        return Ok(());
    }
    exec.straight(&start, end, true)
}

/// G53: the motion itself asks for it; alone it means nothing.
pub(crate) fn machine_coordinates(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    match exec.words.motion {
        Some(row) if row.code.tenths <= 10 => {}
        _ => return Err(Problem::G53WithoutMotion),
    }
    if exec.state.absolute {
        Ok(())
    } else {
        Err(Problem::G53Incremental)
    }
}

/// What the feed rate is measured along: X Y Z, or U V W if those stand still, or degrees of A B C.
pub(crate) fn straight_length(start: &Position, end: &Position) -> f64 {
    // Euclidean length of three axes from an index on.
    let norm = |from: usize| {
        (from..from + 3)
            .map(|i| (end[i] - start[i]) * (end[i] - start[i]))
            .sum::<f64>()
            .sqrt()
    };
    [0, 6, 3]
        .into_iter()
        .map(norm)
        .find(|length| *length > 0.0)
        .unwrap_or(0.0)
}

/// Bits of the tool's direction (G43.5).
const TOOL_DIRECTION_BITS: u32 = bit(b'I') | bit(b'J') | bit(b'K');

impl Exec<'_> {
    /// Where the axis words lead to.
    pub(crate) fn target(&self) -> Result<Position, Problem> {
        // G53 counts from the machine's zero, without offsets, and is always absolute.
        let in_machine = self.words.has_g(530);
        let mut end = if in_machine {
            self.state.machine()
        } else {
            self.state.current
        };
        let absolute = in_machine || self.state.absolute;
        for (axis, coordinate) in end.iter_mut().enumerate() {
            if let Some(value) = self.axis_word(axis) {
                *coordinate = if absolute { value } else { *coordinate + value };
            }
        }
        self.polar(&mut end)?;
        if in_machine {
            end = self.state.offsets.to_program(&end);
        }
        self.check_target(&end)?;
        Ok(end)
    }

    /// A straight move, compensated for the cutter if that is on.
    pub(crate) fn straight(
        &mut self,
        start: &Position,
        end: Position,
        feed: bool,
    ) -> Result<(), Problem> {
        self.state.arc_not_allowed = false;
        // Under G43.5 the direction of the tool belongs to the end of the move and comes before
        // it.
        if self.words.mask & TOOL_DIRECTION_BITS != 0
            && self.state.tip_control == TipControl::WithVector
        {
            self.tool_vector()?;
        }
        if self
            .state
            .compensation
            .as_ref()
            .is_some_and(|compensation| compensation.acts())
        {
            return self.compensated_line(start, end, feed);
        }
        self.emit(if feed {
            CanonicalOp::StraightFeed(end)
        } else {
            CanonicalOp::StraightTraverse(end)
        });
        Ok(())
    }

    /// Refuses motion at a feed that is not known.
    pub(crate) fn check_feed(&mut self, code: Code) -> Result<(), Problem> {
        match self.state.feed_mode {
            FeedMode::InverseTime => match self.word(b'F') {
                Some(f) if f > 0.0 => Ok(()),
                _ => Err(Problem::NoInverseTimeFeed { code }),
            },
            FeedMode::PerRevolution
                if self.state.spindle.speed == 0.0 && !self.state.feed_missed =>
            {
                self.state.feed_missed = true;
                match code.tenths {
                    10 => Err(Problem::NoRevolutions { code: "G1" }),
                    20 => Err(Problem::NoRevolutions { code: "G2" }),
                    30 => Err(Problem::NoRevolutions { code: "G3" }),
                    _ => Ok(()),
                }
            }
            _ if self.state.feed > 0.0 || self.state.feed_missed => Ok(()),
            _ => {
                // Said once: the following moves lack the same F.
                self.state.feed_missed = true;
                Err(Problem::NoFeed { code })
            }
        }
    }

    /// In inverse time, the rate that does a length in 1/F minutes. Under cutter compensation, and
    /// on the move that leaves it, the path has another length than what was programmed; it is the
    /// rate that then holds (as recorded), also for the arcs at corners.
    pub(crate) fn inverse_time(&mut self, length: impl FnOnce() -> f64) {
        if self.state.feed_mode == FeedMode::InverseTime {
            let per_minute = self.word(b'F').unwrap_or_default();
            let acts = self
                .state
                .compensation
                .as_ref()
                .is_some_and(|compensation| compensation.acts());
            let differs = acts || self.state.arc_not_allowed;
            self.set_feed(
                (length() * per_minute).max(LEAST_INVERSE_TIME_RATE),
                Some(per_minute).filter(|_| !differs),
            );
        }
    }
}

impl Exec<'_> {
    /// Puts @ and ^ into a position. What is missing is taken from where the tool is; incremental
    /// ones are added to that.
    pub(crate) fn polar(&self, end: &mut Position) -> Result<(), Problem> {
        let (radius, angle) = (self.word(b'@'), self.word(b'^'));
        if radius.is_none() && angle.is_none() {
            return Ok(());
        }
        // X and Y would say the same twice.
        if let Some(letter) = ['X', 'Y']
            .into_iter()
            .find(|letter| self.words.has(*letter as u8))
        {
            return Err(Problem::Polar {
                message: "and X or Y",
                letter,
            });
        }
        // A plane that is selected on the line itself is in force for it; XY is meant all the same
        // (as recorded).
        if self.state.plane != Plane::Xy && !self.words.has_g(180) && !self.words.has_g(190) {
            return Err(Problem::Polar {
                message: "outside the XY plane (G17)",
                letter: '@',
            });
        }
        if self.words.has_g(530) {
            return Err(Problem::Polar {
                message: "with G53",
                letter: '@',
            });
        }
        let [x, y, ..] = self.state.current;
        // The tool's place in polar coordinates replaces what is missing.
        let here = [math::hypot(x, y), deg(math::atan2(y, x))];
        let [radius, angle] = if self.state.absolute {
            [radius.unwrap_or(here[0]), angle.unwrap_or(here[1])]
        } else if here[0] == 0.0 {
            return Err(Problem::Polar {
                message: "in incremental distances (G91) at the origin, where there is no angle,",
                letter: '^',
            });
        } else {
            [
                here[0] + radius.unwrap_or(0.0),
                here[1] + angle.unwrap_or(0.0),
            ]
        };
        let (sin, cos) = math::sin_cos(rad(angle));
        (end[0], end[1]) = (radius * cos, radius * sin);
        Ok(())
    }
}

/// G4 P.
pub(crate) fn dwell(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let seconds = exec.need(b'P', code, "P, the seconds to wait")?;
    exec.pause(seconds)
}

impl Exec<'_> {
    /// A dwell of a checked length.
    pub(crate) fn pause(&mut self, seconds: f64) -> Result<(), Problem> {
        let limit = self.config.limits.dwell_s;
        // LinuxCNC accepts a negative time; it is likely a mistake.
        if seconds < 0.0 {
            self.warnings.push(Problem::NegativeDwell { seconds });
        }
        if seconds > limit {
            return Err(Problem::DwellTooLong { seconds, limit });
        }
        self.emit(CanonicalOp::Dwell(seconds));
        Ok(())
    }
}

/// Distance between the parameters of the homes of G28 and G30. Published: LinuxCNC, "Numbered
/// Parameters".
const SECOND_HOME_OFFSET: u16 = 20;

const fn first_parameter(code: Code) -> u16 {
    if code.tenths >= 300 {
        HOME + SECOND_HOME_OFFSET
    } else {
        HOME
    }
}

/// Through the programmed point, then to the home of the named axes; of all, if none is named.
pub(crate) fn go(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let by_way = exec.target()?;
    exec.emit(CanonicalOp::StraightTraverse(by_way));
    exec.state.current = by_way;
    // Homes are machine coordinates; axes that are not named stay at the machine place of the
    // named point.
    let home = convert(
        &exec.parameters.position(first_parameter(code)),
        exec.config.machine_units,
        exec.state.units,
    );
    let named = exec.axes_with_words();
    let mut end = exec.state.machine();
    for axis in 0..9 {
        if named == 0 || named & (1 << axis) != 0 {
            end[axis] = home[axis];
        }
    }
    let end = exec.state.offsets.to_program(&end);
    exec.check_target(&end)?;
    // Of all axes those that every machine has: of the others a machine without them knows no word.
    let named = if named == 0 { 0b111 } else { named };
    exec.emit_named(CanonicalOp::StraightTraverse(end), named);
    exec.state.current = end;
    Ok(())
}

/// G28.1 and G30.1.
pub(crate) fn store(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let here = convert(
        &exec.state.machine(),
        exec.state.units,
        exec.config.machine_units,
    );
    exec.parameters.put_position(first_parameter(code), &here);
    Ok(())
}

/// Distance before its end at which a probing move counts as stopped, mm. Recorded from LinuxCNC's
/// stand-alone interpreter: 0.01 inch.
const PROBE_STOP_MM: f64 = 0.254;
/// Shortest probing move (LinuxCNC: 0.00000001 units).
const SHORTEST_PROBE: f64 = 1e-8;
/// Parameters: where the probe touched, in program coordinates.
const TOUCHED_PARAMETER: u16 = 5061;
/// Parameter: whether it touched.
const TOUCHED_FLAG_PARAMETER: u16 = 5070;

/// Probes up to the programmed end. There is no probe: #5061 to #5069 become the end, #5070 says
/// that nothing was touched, and the tool is taken to be a little before the end.
pub(crate) fn probe(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    let end = exec.target()?;
    let start = exec.state.current;
    exec.state.current = end;
    exec.check_feed(code)?;
    if exec.state.feed_mode == FeedMode::PerRevolution {
        return Err(Problem::ProbeFeed { code });
    }
    // G38.2 and G38.4 demand a contact, G38.3 and G38.5 do not; from G38.4 on they move away.
    let must = code.tenths.is_multiple_of(2);
    let ways: [f64; 9] = std::array::from_fn(|axis| end[axis] - start[axis]);
    if must && ways.iter().all(|way| way.abs() < SHORTEST_PROBE) {
        return Err(Problem::ProbeTooShort { code });
    }
    // The stop lies a fixed distance before the end, along the move.
    let length = ways.iter().take(3).map(|way| way * way).sum::<f64>().sqrt();
    let mut stop = end;
    if length > 0.0 {
        let share = Units::Mm.convert(PROBE_STOP_MM, exec.state.units) / length;
        for axis in 0..3 {
            stop[axis] -= ways[axis] * share;
        }
    }
    let probe = StraightProbe {
        end,
        stop,
        away: code.tenths >= 384,
        must,
    };
    exec.parameters.put_position(TOUCHED_PARAMETER, &end);
    exec.parameters.put(TOUCHED_FLAG_PARAMETER, 0.0);
    exec.emit(CanonicalOp::StraightProbe(Box::new(probe)));
    exec.state.current = stop;
    Ok(())
}
