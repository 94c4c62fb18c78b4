//! System variables of Fanuc and Haas as a program sets them, and the modes and last words that
//! they show. What the numbers mean stands in [`crate::parameters::control`].

use super::Once;
use crate::codes::Code;
use crate::config::InterpreterConfig;
use crate::dialect::Dialect;
use crate::exec::words::Words;
use crate::interpreter::Interpreter;
use crate::ops::{SourcedOp, Units};
use crate::parameters::Parameters;
use crate::parameters::control::{
    ADDRESSES, FIRST, GROUPS, PROGRAM_NUMBER, SEQUENCE_NUMBER, Variable, modal_group, variable,
};
use crate::problem::Problem;
use crate::state::State;
use crate::syntax::evaluate::valued;

/// Letters in the order of the numbers of their last values, #4101 and on: as the arguments of a
/// macro are numbered. G has none, and L, N, O and P have others.
const LETTERS: [(u8, u16); 21] = [
    (b'A', 1),
    (b'B', 2),
    (b'C', 3),
    (b'I', 4),
    (b'J', 5),
    (b'K', 6),
    (b'D', 7),
    (b'E', 8),
    (b'F', 9),
    (b'H', 11),
    (b'Q', 17),
    (b'R', 18),
    (b'S', 19),
    (b'T', 20),
    (b'U', 21),
    (b'V', 22),
    (b'W', 23),
    (b'X', 24),
    (b'Y', 25),
    (b'Z', 26),
    (b'M', 13),
];

/// What the modes show before the first block.
pub(crate) fn note_start(parameters: &mut Parameters, config: &InterpreterConfig, state: &State) {
    if !config.dialect.is_fanuc() {
        return;
    }
    let units = match state.units {
        Units::Inch => Code::g(200),
        Units::Mm => Code::g(210),
    };
    note_code(parameters, config, units);
    note_modal_macro(parameters, config, false);
    note_code(parameters, config, Code::g(530 + 10 * state.system.min(6)));
}

/// Group 12 of Fanuc: G66 while a modal macro is in force, else G67. Haas has the work coordinate
/// systems there.
pub(super) fn note_modal_macro(parameters: &mut Parameters, config: &InterpreterConfig, on: bool) {
    if config.dialect == Dialect::Fanuc {
        parameters.put(GROUPS + 12, if on { 66.0 } else { 67.0 });
    }
}

/// Puts a code into the group that shows it.
fn note_code(parameters: &mut Parameters, config: &InterpreterConfig, code: Code) {
    let Some(group) = modal_group(config.dialect, code) else {
        return;
    };
    parameters.put(GROUPS + group, f64::from(code.tenths) / 10.0);
    // A code of group 01 ends a canned cycle as G80 does.
    if group == 1 {
        parameters.put(GROUPS + 9, 80.0);
    }
}

impl Interpreter {
    /// Keeps what #4001 to #4130 show: the codes and words of a block that has been carried out.
    pub(crate) fn note_modes(&mut self) {
        let (parameters, words): (&mut Parameters, &Words) = (&mut self.parameters, &self.words);
        for used in words.codes() {
            let code = used.row.code;
            if code.letter == 'M' {
                parameters.put(ADDRESSES + 13, f64::from(code.tenths) / 10.0);
                continue;
            }
            note_code(parameters, &self.config, code);
            if modal_group(self.config.dialect, code) == Some(1) {
                self.state.rigid_tapping = false;
            }
        }
        for (letter, number) in LETTERS {
            if let Some(value) = words.get(letter) {
                parameters.put(ADDRESSES + number, value);
            }
        }
    }

    /// Keeps the sequence number of a block that has run.
    pub(crate) fn note_line_number(&mut self) {
        if let Some(number) = self.block.line_number {
            self.parameters.put(SEQUENCE_NUMBER, number);
        }
    }

    /// Says which program runs, before a block reads it.
    pub(crate) fn note_program(&mut self) {
        let called = self.flow.frames.last().map(|frame| frame.name.parse());
        let number = match called {
            Some(Ok(number)) => number,
            _ => self.program_number,
        };
        self.parameters.put(PROGRAM_NUMBER, number);
    }

    /// Whether a number is a system variable of the dialect.
    pub(crate) fn is_control_variable(&self, number: f64) -> bool {
        number >= f64::from(FIRST) && self.config.dialect.is_fanuc()
    }

    /// A program's setting of a system variable.
    pub(crate) fn set_control_variable(
        &mut self,
        number: f64,
        value: f64,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), Problem> {
        let whole = crate::parameters::control_number(number)?;
        let read_only = || Problem::ReadOnlyParameter {
            number: u16::try_from(whole).unwrap_or(u16::MAX),
        };
        match variable(self.config.dialect, whole) {
            // A number that no control here has.
            Variable::Outside(0, what) => Err(Problem::ControlVariable {
                number: whole,
                what,
            }),
            // A vacant value takes the value away.
            Variable::Kept(cell) | Variable::Vacant(cell) | Variable::Outside(cell, _) => {
                self.parameters.put(cell, value);
                Ok(())
            }
            // A clock goes on by itself from what it is set to.
            Variable::Clock(_) => Ok(()),
            Variable::Shown(_) | Variable::Position(..) => Err(read_only()),
            Variable::Origin(system, axis) => {
                self.exec(out).assign_origin(system, axis, valued(value))
            }
            Variable::Shift(axis) => self.exec(out).assign_shift(axis, valued(value)),
            Variable::Tool(cell, offset, depends) => {
                self.exec(out)
                    .assign_memory(cell, offset, valued(value), false);
                if depends && self.told_once.insert(Once::Variable(whole)) {
                    self.report(Problem::MemoryAssumed { number: whole });
                }
                Ok(())
            }
            Variable::Alarm => {
                self.state.ended = true;
                let text = self.message();
                Err(Problem::MacroAlarm {
                    number: valued(value),
                    text,
                })
            }
            Variable::Stop => self.exec(out).stop_program(),
        }
    }

    /// The text in parentheses on the line: the message of an alarm.
    fn message(&self) -> String {
        let line = String::from_utf8_lossy(&self.line);
        let inside = line
            .rsplit_once('(')
            .and_then(|(_, rest)| rest.split_once(')'));
        inside.map_or_else(String::new, |(text, _)| text.trim().to_owned())
    }

    /// Tells what reading a system variable has to warn of, once a number.
    pub(crate) fn warn_of_variables(&mut self) {
        let Some(problem) = self.parameters.noted.take() else {
            return;
        };
        let number = match *problem {
            Problem::OffsetUnknown { number, .. } | Problem::MemoryAssumed { number } => number,
            _ => 0,
        };
        if self.told_once.insert(Once::Variable(number)) {
            self.report(*problem);
        }
    }
}
