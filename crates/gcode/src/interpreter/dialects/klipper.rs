//! Klipper: states that are saved and restored, and the offset of G-code coordinates (Klipper
//! documentation, "G-Codes", `[gcode_move]`).
//!
//! Klipper adds a base position to all coordinates: what G92 has set, and the offset of
//! SET_GCODE_OFFSET. It is the G92 offset here. SAVE_GCODE_STATE keeps G90 or G91, the base, the
//! offset, the speed and the place of the tool; RESTORE_GCODE_STATE brings back all but the place,
//! and with `MOVE=1` goes to it. SET_GCODE_OFFSET changes the base without moving; with `MOVE=1` the
//! tool moves by the change. `MOVE_SPEED` is in mm/s and holds for that move alone.
//!
//! G28 homes the axes that it names, whatever number follows the letter, or X, Y and Z: straight to
//! the home, without a point on the way. It forgets what G92 has set of these axes and keeps the
//! offset of SET_GCODE_OFFSET (`gcode_move.py`: at the end of homing `base_position[axis] =
//! homing_position[axis]`); Marlin sets its `position_shift` to 0 there.

use crate::interpreter::Interpreter;
use crate::ops::{CanonicalOp, Position, SourcedOp, Units};
use crate::parameters::HOME;
use crate::problem::Problem;
use crate::state::{convert, subtract};
use crate::syntax::special::{STATE_COMMANDS, command_name};
use crate::syntax::{Value, Word};
use std::collections::BTreeMap;

/// Klipper's speed before the first F, mm/s. Published: `gcode_move.py`.
const FIRST_SPEED_MM_S: f64 = 25.0;
/// Letters of the axes in the order of a position.
const AXIS_LETTERS: [u8; 9] = *b"XYZABCUVW";
/// Name of a state that is given none.
const DEFAULT_STATE: &str = "default";

/// What Klipper's commands keep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Klipper {
    states: BTreeMap<String, SavedState>,
    /// Of SET_GCODE_OFFSET, in mm; it is part of the G92 offset.
    offset: Position,
}

/// A state that has been saved. Lengths in mm.
#[derive(Clone, Debug)]
struct SavedState {
    absolute: bool,
    /// The G92 offset.
    base: Position,
    offset: Position,
    /// mm/min; 0 before the first F.
    feed: f64,
    /// Machine coordinates.
    place: Position,
}

/// `KEY=VALUE` of a command, keys in upper case.
struct Arguments(BTreeMap<String, String>);

impl Arguments {
    /// The arguments of a line after its name.
    fn of(text: &str) -> Result<Arguments, Problem> {
        let text = text.split([';', '#']).next().unwrap_or_default();
        let mut arguments = BTreeMap::new();
        for word in text.split_whitespace() {
            let Some((key, value)) = word.split_once('=') else {
                return Err(Problem::Klipper {
                    message: format!("`{word}` is not of the form NAME=VALUE"),
                });
            };
            let value = value.trim_matches(['"', '\'']).to_owned();
            arguments.insert(key.to_ascii_uppercase(), value);
        }
        Ok(Arguments(arguments))
    }

    fn number(&self, key: &str) -> Result<Option<f64>, Problem> {
        let Some(text) = self.0.get(key) else {
            return Ok(None);
        };
        match text.parse::<f64>().ok().filter(|value| value.is_finite()) {
            Some(value) => Ok(Some(value)),
            None => Err(Problem::Klipper {
                message: format!("{key}={text} is not a number"),
            }),
        }
    }

    fn name(&self) -> String {
        let name = self.0.get("NAME").map_or(DEFAULT_STATE, String::as_str);
        name.to_owned()
    }

    /// Whether the tool moves, and how fast if that is said, mm/s.
    fn movement(&self) -> Result<Option<Option<f64>>, Problem> {
        let speed = self.number("MOVE_SPEED")?;
        if let Some(speed) = speed.filter(|speed| *speed <= 0.0) {
            return Err(Problem::Klipper {
                message: format!("MOVE_SPEED is {speed}; it has to be above 0"),
            });
        }
        let moves = self.number("MOVE")?.is_some_and(|value| value != 0.0);
        Ok(moves.then_some(speed))
    }
}

impl Interpreter {
    /// Carries a command about states and offsets out; false if the line has none.
    pub(crate) fn klipper_command(&mut self, out: &mut Vec<SourcedOp>) -> Result<bool, Problem> {
        let line = String::from_utf8_lossy(&self.line).into_owned();
        let Some((name, rest)) = command_name(&line) else {
            return Ok(false);
        };
        match STATE_COMMANDS.iter().position(|known| *known == name) {
            Some(0) => self.save_state(&Arguments::of(rest)?)?,
            Some(1) => self.restore_state(&Arguments::of(rest)?, out)?,
            Some(_) => self.set_offset(&Arguments::of(rest)?, out)?,
            None if name == "SET_VELOCITY_LIMIT" => {
                if self.told_once.insert(super::Once::VelocityLimit) {
                    self.report(Problem::VelocityLimit);
                }
            }
            None => return Ok(false),
        }
        Ok(true)
    }

    /// G28 of a printer; false if the line has none.
    pub(super) fn home_printer(&mut self, out: &mut Vec<SourcedOp>) -> Result<bool, Problem> {
        let words = &self.block.words;
        let is_home =
            |word: &Word| word.letter == b'G' && matches!(word.value, Value::Number(28.0));
        if !words.iter().any(is_home) {
            return Ok(false);
        }
        let named: [bool; 9] =
            std::array::from_fn(|axis| words.iter().any(|word| word.letter == AXIS_LETTERS[axis]));
        let all = !named[..6].contains(&true);
        let homed = |axis: usize| named[axis] && axis < 6 || all && axis < 3;
        let (units, offset) = (self.state.units, self.klipper.offset);
        let home = convert(
            &self.parameters.position(HOME),
            self.config.machine_units,
            units,
        );
        let mut exec = self.exec(out);
        let here = exec.state.machine();
        let end = std::array::from_fn(|axis| if homed(axis) { home[axis] } else { here[axis] });
        let end = exec.state.offsets.to_program(&end);
        exec.check_target(&end)?;
        let named = (0..9).filter(|axis| homed(*axis));
        let named = named.fold(0, |named, axis| named | 1 << axis);
        exec.emit_named(CanonicalOp::StraightTraverse(end), named);
        exec.state.current = end;
        // What is left of the shift is the offset of SET_GCODE_OFFSET.
        let (now, offset) = (exec.state.offsets.g92, convert(&offset, Units::Mm, units));
        let shift = std::array::from_fn(|axis| if homed(axis) { offset[axis] } else { now[axis] });
        if shift != now {
            exec.put_shift(shift);
        }
        Ok(true)
    }

    fn save_state(&mut self, arguments: &Arguments) -> Result<(), Problem> {
        let name = arguments.name();
        let limit = self.config.limits.named_parameters;
        if self.klipper.states.len() >= limit && !self.klipper.states.contains_key(&name) {
            return Err(Problem::TooManyParameters { limit });
        }
        let state = &self.state;
        let in_mm = |position| convert(position, state.units, Units::Mm);
        let saved = SavedState {
            absolute: state.absolute,
            base: in_mm(&state.offsets.g92),
            offset: self.klipper.offset,
            feed: state.feed * state.units.mm(),
            place: in_mm(&state.machine()),
        };
        self.klipper.states.insert(name, saved);
        Ok(())
    }

    fn restore_state(
        &mut self,
        arguments: &Arguments,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), Problem> {
        let name = arguments.name();
        let movement = arguments.movement()?;
        let Some(saved) = self.klipper.states.get(&name).cloned() else {
            return Err(Problem::Klipper {
                message: format!("there is no state `{name}`: SAVE_GCODE_STATE has not saved it"),
            });
        };
        self.klipper.offset = saved.offset;
        let units = self.state.units;
        let mut exec = self.exec(out);
        exec.state.absolute = saved.absolute;
        exec.put_shift(convert(&saved.base, Units::Mm, units));
        if saved.feed > 0.0 && exec.state.feed * units.mm() != saved.feed {
            exec.set_feed(saved.feed / units.mm(), None);
        }
        if let Some(speed) = movement {
            let place = convert(&saved.place, Units::Mm, units);
            let end = exec.state.offsets.to_program(&place);
            self.move_at(end, speed, out)?;
        }
        Ok(())
    }

    fn set_offset(
        &mut self,
        arguments: &Arguments,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), Problem> {
        let movement = arguments.movement()?;
        let old = self.klipper.offset;
        let mut offset = old;
        // The offset itself, or what is added to it; both at once, Klipper takes the first.
        for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            let value = arguments.number(letter)?;
            let more = arguments.number(&format!("{letter}_ADJUST"))?;
            if let Some(slot) = offset.get_mut(axis) {
                *slot = value.unwrap_or(*slot + more.unwrap_or(0.0));
            }
        }
        let units = self.state.units;
        let change = convert(&subtract(&offset, &old), Units::Mm, units);
        let before = self.state.current;
        let mut exec = self.exec(out);
        let now = exec.state.offsets.g92;
        let shift: Position = std::array::from_fn(|axis| now[axis] + change[axis]);
        exec.check_target(&shift)?;
        exec.put_shift(shift);
        self.klipper.offset = offset;
        // By the change: to the coordinates that the tool had before.
        match movement {
            Some(speed) => self.move_at(before, speed, out),
            None => Ok(()),
        }
    }

    /// A move at a speed that holds for it alone, mm/s; at the speed in force, if none is given.
    fn move_at(
        &mut self,
        end: Position,
        speed: Option<f64>,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), Problem> {
        let mut exec = self.exec(out);
        exec.check_target(&end)?;
        let (feed, mm) = (exec.state.feed, exec.state.units.mm());
        let first = (feed == 0.0).then_some(FIRST_SPEED_MM_S);
        if let Some(speed) = speed.or(first) {
            exec.set_feed(60.0 * speed / mm, None);
        }
        exec.state.current = end;
        exec.emit(CanonicalOp::StraightFeed(end));
        if exec.state.feed != feed {
            exec.set_feed(feed, None);
        }
        Ok(())
    }
}
