//! Macros with arguments by letter (G65 to G67), and subroutines at a line number (M97).

use super::super::Interpreter;
use crate::code::{Code, whole};
use crate::dialect::Leniency;
use crate::problem::Problem;

/// Numbers of the parameters that the letters A to Z of a G65 set; 0 for letters that are no
/// arguments.
const ARGUMENTS: [u8; 26] = [
    1, 2, 3, 7, 8, 9, 0, 11, 4, 5, 6, 0, 13, 0, 0, 0, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26,
];
/// Highest parameter that an argument sets.
const HIGHEST_ARGUMENT: usize = 26;

/// A macro called after every move (G66).
#[derive(Clone, Debug)]
pub(crate) struct ModalMacro {
    name: String,
    arguments: Vec<f64>,
    /// Calls in progress where it was set: its own moves do not call it.
    depth: usize,
}

impl Interpreter {
    /// G65 to G67.
    pub(super) fn macro_line(&mut self) -> Result<(), Problem> {
        // Arguments that are not given are vacant, or 0 where vacancy is not accepted.
        let mut arguments = vec![
            if self.parameters.vacants {
                f64::NAN
            } else {
                0.0
            };
            HIGHEST_ARGUMENT
        ];
        let (mut code, mut name, mut rounds, mut triples) = (0.0, None, 1.0, 0_usize);
        for index in 0..self.block.words.len() {
            let Some(&word) = self.block.words.get(index) else {
                break;
            };
            // G, P and L belong to the call, all other letters set a parameter of the macro.
            let value = self.value_or_vacant(word.value)?;
            match word.letter {
                b'G' => code = value,
                b'P' => name = whole(value),
                b'L' => rounds = value,
                b'N' | b'O' => {}
                letter => {
                    // I, J and K may come in several sets: #4 to #6, #7 to #9 and so on.
                    triples += usize::from(letter == b'I' && index > 0);
                    let first = usize::from(
                        ARGUMENTS
                            .get(usize::from(letter.wrapping_sub(b'A')))
                            .copied()
                            .unwrap_or(0),
                    );
                    let shift = if matches!(letter, b'I'..=b'K') {
                        3 * triples.saturating_sub(1)
                    } else {
                        0
                    };
                    match (first, arguments.get_mut((first + shift).wrapping_sub(1))) {
                        (1.., Some(slot)) => *slot = value,
                        _ => {
                            return Err(Problem::RepeatedWord {
                                letter: char::from(letter),
                            });
                        }
                    }
                }
            }
        }
        // G67 ends the modal macro, G66 sets it, G65 calls at once.
        self.tell(Leniency::MacroCalls);
        if code == 67.0 {
            self.modal_macro = None;
            return Ok(());
        }
        // For messages only: G65 to G67 have no row in the table.
        let code_name = Code {
            letter: 'G',
            tenths: if code == 65.0 { 650 } else { 660 },
        };
        let name = name.ok_or(Problem::WordMissing {
            code: code_name,
            what: "P, the number of the macro",
        })?;
        let name = format!("{name}");
        let rounds = whole(rounds)
            .filter(|rounds| (0.0..=1e15).contains(rounds))
            .ok_or(Problem::BadWordValue {
                letter: 'L',
                value: rounds,
            })?;
        // G66 calls the macro after each later move at the same level.
        if code == 66.0 {
            self.modal_macro = Some(ModalMacro {
                name,
                arguments,
                depth: self.flow.frames.len(),
            });
            return Ok(());
        }
        self.call(name, Some(&arguments), rounds as u64)
    }

    /// Calls the macro of a G66 after a move of the level that set it.
    pub(crate) fn call_modal_macro(&mut self) -> Result<(), Problem> {
        // Moves inside the macro itself do not call it again.
        let Some(modal) = self
            .modal_macro
            .as_ref()
            .filter(|modal| modal.depth == self.flow.frames.len())
        else {
            return Ok(());
        };
        if self.words.motion.is_none() || !self.flow.subs.contains_key(&modal.name) {
            return Ok(());
        }
        let (name, arguments) = (modal.name.clone(), modal.arguments.clone());
        self.call(name, Some(&arguments), 1)
    }

    /// The macro of a G66, if the block moves and the macro is not known yet.
    pub(crate) fn wanted_macro(&self) -> Option<String> {
        let modal = self
            .modal_macro
            .as_ref()
            .filter(|modal| modal.depth == self.flow.frames.len())?;
        // Looked for before the move, so that the block runs once.
        let moves = self.words.mask & crate::exec::words::AXIS_BITS != 0;
        (moves && !self.flow.subs.contains_key(&modal.name)).then(|| modal.name.clone())
    }

    /// M97: the lines from an N number to M99 as a subroutine.
    pub(super) fn local_call(&mut self) -> Result<(), Problem> {
        let (mut number, mut rounds) = (None, 1.0);
        for index in 0..self.block.words.len() {
            let Some(&word) = self.block.words.get(index) else {
                break;
            };
            let value = self.value(word.value)?;
            match word.letter {
                b'P' => number = whole(value),
                // L that is no count is taken as one round.
                b'L' => {
                    rounds = whole(value)
                        .filter(|rounds| (0.0..=1e15).contains(rounds))
                        .unwrap_or(1.0);
                }
                _ => {}
            }
        }
        let code = Code::m(970);
        let number = number.ok_or(Problem::WordMissing {
            code,
            what: "P, the line number of the subroutine",
        })?;
        self.tell(Leniency::LocalCalls);
        self.call(format!("n{number}"), None, rounds as u64)
    }
}
