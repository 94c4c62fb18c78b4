//! Fanuc and Haas: macros with arguments by letter (G65 to G67), subroutines at a line number (M97),
//! patterns of holes, packed calls, dwells in milliseconds, codes that change no path, cycles that are
//! not read.

use super::super::Interpreter;
use super::variables::note_modal_macro;
use crate::codes::{Code, whole};
use crate::dialect::Dialect::{self, Fanuc, Haas};
use crate::dialect::Leniency;
use crate::ops::SourcedOp;
use crate::parameters::MACRO_LOCALS;
use crate::problem::Problem;
use crate::syntax::{Text, Value, Word};

/// An M98 P beyond this has the rounds in front of four digits of the program's number.
const LEAST_PACKED_CALL: f64 = 10_000.0;
/// Codes in tenths that change no path: high-speed modes, look-ahead, and the ends of modes that
/// cannot have begun.
const IGNORED: [u16; 6] = [80, 150, 500, 501, 1030, 1870];
const BOTH: &[Dialect] = &[Fanuc, Haas];
const WRITE_OUT: &str = "have the CAM system write it out as moves";
/// Codes in tenths that these controls have and this reader has not: whose they are, what they do,
/// and what to do instead.
const CYCLES: [(&[Dialect], u16, &str, &str); 16] = [
    (&[Fanuc], 71, "cylindrical interpolation (Fanuc)", WRITE_OUT),
    (
        &[Fanuc],
        121,
        "polar coordinate interpolation (Fanuc)",
        WRITE_OUT,
    ),
    (
        BOTH,
        160,
        "programming in polar coordinates (Fanuc)",
        "write X and Y, or use @ and ^ of RS274/NGC",
    ),
    (
        BOTH,
        310,
        "a move until a skip signal",
        "use G38.2 to G38.5 of RS274/NGC",
    ),
    (
        &[Haas],
        350,
        "automatic tool diameter measurement (Haas)",
        "measure the tool beforehand and put it into the tool table",
    ),
    (
        &[Haas],
        360,
        "automatic work offset measurement (Haas)",
        "set the work offset with G10 L2",
    ),
    (
        &[Haas],
        370,
        "automatic tool offset measurement (Haas)",
        "measure the tool beforehand and put it into the tool table",
    ),
    (
        &[Haas],
        470,
        "text engraving (Haas)",
        "have the CAM system write the letters out as moves",
    ),
    (BOTH, 510, "scaling", WRITE_OUT),
    (BOTH, 511, "mirroring", WRITE_OUT),
    (
        BOTH,
        541,
        "an additional work coordinate system",
        "use G54 to G59.3",
    ),
    (&[Haas], 1010, "mirroring (Haas)", WRITE_OUT),
    (BOTH, 1070, "cylindrical mapping", WRITE_OUT),
    (
        &[Haas],
        1360,
        "automatic measurement of the work offset's centre (Haas)",
        "set the work offset with G10 L2",
    ),
    (
        &[Haas],
        1500,
        "general-purpose pocket milling (Haas)",
        "have the CAM system write the pocket out as moves",
    ),
    (
        &[Haas],
        1540,
        "an additional work coordinate system (Haas)",
        "use G54 to G59.3",
    ),
];

impl Interpreter {
    /// G70 to G72 of Haas: the cycle in force at the places of a pattern.
    pub(super) fn hole_pattern(
        &mut self,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), (Problem, Option<Text>)> {
        let is_pattern = |word: &Word| {
            word.letter == b'G' && matches!(word.value, Value::Number(70.0 | 71.0 | 72.0))
        };
        // G70 to G72 are turning cycles in the table of codes: the word is taken out before the
        // codes are looked up.
        let Some(at) = self.block.words.iter().position(is_pattern) else {
            return Ok(());
        };
        // The rest of the line has its words collected as usual.
        let word = self.block.words.remove(at);
        self.collect_words()?;
        let tenths = if let Value::Number(number) = word.value {
            (number * 10.0) as u16
        } else {
            0
        };
        let code = Code::g(tenths);
        // The pattern repeats the canned cycle in force; a motion code on its line would
        // contradict it.
        let cycle = match (
            self.words
                .codes()
                .iter()
                .find(|used| used.row.group == crate::codes::Group::Motion),
            self.state.motion,
        ) {
            (Some(used), _) => {
                return Err((
                    Problem::TwoAxisUsers {
                        code,
                        other: used.row.code,
                    },
                    Some(word.text),
                ));
            }
            (None, Some(cycle)) if matches!(cycle.tenths, 730 | 740 | 810..=890) => cycle,
            _ => {
                return Err((
                    Problem::Cycle {
                        message: "a pattern of holes needs a canned cycle (G73, G74, G81 to G89) before it",
                    },
                    Some(word.text),
                ));
            }
        };
        self.tell(Leniency::HolePatterns);
        self.exec(out)
            .pattern(code, cycle)
            .map_err(|problem| (problem, Some(word.text)))
    }

    /// Rounds and number in one P of M98.
    pub(crate) fn unpack_call(&mut self) {
        if !self.config.leniencies.has(Leniency::PackedCalls) || self.words.has(b'L') {
            return;
        }
        let is_call = self
            .words
            .codes()
            .iter()
            .any(|used| used.row.code == Code::m(980));
        // P of five digits or more: rounds, then four digits of the program's number.
        if let (true, Some(number)) = (
            is_call,
            self.words
                .get(b'P')
                .and_then(whole)
                .filter(|number| *number >= LEAST_PACKED_CALL),
        ) {
            self.words.put(b'P', number % LEAST_PACKED_CALL);
            self.words.put(b'L', (number / LEAST_PACKED_CALL).floor());
            self.tell(Leniency::PackedCalls);
        }
    }

    /// Dwells in milliseconds: P without a decimal point; X and U are seconds.
    pub(crate) fn fanuc_dwell(&mut self) {
        let is_dwell = self.words.has_g(40);
        let is_cycle =
            |code: Code| matches!(code.tenths, 730..=742 | 810..=890) && code.letter == 'G';
        let named = self
            .words
            .codes()
            .iter()
            .any(|used| is_cycle(used.row.code));
        let motion = self
            .words
            .codes()
            .iter()
            .any(|used| used.row.group == crate::codes::Group::Motion);
        // G4 X and G4 U give seconds and need no scaling.
        if is_dwell && !self.words.has(b'P') {
            for letter in *b"XU" {
                if let Some(seconds) = self.words.get(letter) {
                    self.words.drop_word(letter);
                    self.words.put(b'P', seconds);
                }
            }
        } else if (is_dwell || named || (!motion && self.state.motion.is_some_and(is_cycle)))
            && let Some(value) = self.words.get(b'P')
        {
            // With a decimal point P is in seconds; computed values are, too.
            let text = self.words.text(b'P');
            let written = self
                .line
                .get(text.start as usize..(text.start + text.len) as usize)
                .unwrap_or_default();
            if !written
                .iter()
                .any(|byte| matches!(byte, b'.' | b'[' | b'#'))
            {
                self.words.put(b'P', value / 1000.0);
            }
        }
    }

    /// Takes codes off the line that change no path; true if nothing is left of it.
    pub(super) fn ignore_codes(&mut self) -> bool {
        // G5.1 is a spline in RS274/NGC; with Q alone it switches a mode of the control.
        let spline = self
            .block
            .words
            .iter()
            .any(|word| !matches!(word.letter, b'G' | b'Q' | b'R'));
        // Modes of the control's own path planning have no counterpart here.
        let ignored = |word: &Word| match (word.letter, word.value) {
            (b'G', Value::Number(5.1)) => !spline,
            (b'G', Value::Number(number)) => IGNORED
                .iter()
                .any(|tenths| f64::from(*tenths) == number * 10.0),
            // M29, rigid tapping: the cycle that follows turns the spindle itself.
            (b'M', Value::Number(29.0)) => true,
            _ => false,
        };
        if !self.block.words.iter().any(ignored) {
            return false;
        }
        self.tell(Leniency::IgnoredCodes);
        let rigid = self
            .block
            .words
            .iter()
            .any(|word| word.letter == b'M' && ignored(word));
        if rigid {
            self.state.rigid_tapping = true;
        }
        self.block.words.retain(|word| !ignored(word));
        // What is left belongs to the mode, or to other codes.
        if !rigid
            && self
                .block
                .words
                .iter()
                .all(|word| matches!(word.letter, b'P' | b'Q' | b'R' | b'E' | b'S'))
        {
            self.block.words.clear();
        }
        self.block.words.is_empty()
    }

    /// A code that this control has and this reader has not.
    pub(crate) fn control_cycle(&self, problem: Problem) -> Problem {
        let Problem::UnsupportedCode { code } = problem else {
            return problem;
        };
        // A known name and a way out are better than `unsupported code`.
        let known = CYCLES.iter().find(|(whose, tenths, ..)| {
            code.letter == 'G' && *tenths == code.tenths && whose.contains(&self.config.dialect)
        });
        known.map_or(Problem::UnsupportedCode { code }, |(_, _, what, hint)| {
            Problem::ControlCycle { code, what, hint }
        })
    }
}

/// Numbers of the parameters that the letters A to Z of a G65 set; 0 for letters that are no
/// arguments.
const ARGUMENTS: [u8; 26] = [
    1, 2, 3, 7, 8, 9, 0, 11, 4, 5, 6, 0, 13, 0, 0, 0, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26,
];

/// The words of a macro's call.
struct MacroWords {
    /// Of G65 to G67.
    code: f64,
    /// P, the number of the macro.
    name: Option<f64>,
    /// L.
    rounds: f64,
    arguments: Vec<f64>,
}

/// A macro called after every move (G66).
#[derive(Clone, Debug)]
pub(crate) struct ModalMacro {
    name: String,
    arguments: Vec<f64>,
    /// Calls in progress where it was set: its own moves do not call it.
    depth: usize,
}

impl Interpreter {
    /// The words of a line as those of a macro's call. The word of an index is left out.
    fn macro_words(&mut self, without: Option<usize>) -> Result<MacroWords, Problem> {
        // Arguments that are not given are vacant, or 0 where vacancy is not accepted.
        let vacant = if self.parameters.vacants {
            f64::NAN
        } else {
            0.0
        };
        let mut words = MacroWords {
            code: 0.0,
            name: None,
            rounds: 1.0,
            arguments: vec![vacant; MACRO_LOCALS],
        };
        let mut triples = 0_usize;
        for index in 0..self.block.words.len() {
            let Some(&word) = self.block.words.get(index) else {
                break;
            };
            if without == Some(index) {
                continue;
            }
            // G, P and L belong to the call, all other letters set a parameter of the macro.
            let value = self.value_or_vacant(word.value)?;
            match word.letter {
                b'G' => words.code = value,
                b'P' => words.name = whole(value),
                b'L' => words.rounds = value,
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
                    let slot = words.arguments.get_mut((first + shift).wrapping_sub(1));
                    match (first, slot) {
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
        Ok(words)
    }

    /// An M code that calls a macro: all other words are arguments.
    pub(crate) fn macro_by_m_code(&mut self, name: String, index: usize) -> Result<(), Problem> {
        let code = self
            .block
            .words
            .iter()
            .find(|word| matches!(word.letter, b'G' | b'P' | b'L'));
        if let Some(&word) = code {
            return Err(Problem::UnusedWord {
                letter: char::from(word.letter),
                value: self.value(word.value)?,
                users:
                    "a line of its own: the M code calls a macro, whose arguments are all other \
                    letters"
                        .to_owned(),
            });
        }
        let words = self.macro_words(Some(index))?;
        self.call_by_m_code(name, Some(&words.arguments))
    }

    /// G65 to G67.
    pub(super) fn macro_line(&mut self) -> Result<(), Problem> {
        let MacroWords {
            code,
            name,
            rounds,
            arguments,
        } = self.macro_words(None)?;
        // G67 ends the modal macro, G66 sets it, G65 calls at once.
        self.tell(Leniency::MacroCalls);
        if code == 67.0 {
            self.modal_macro = None;
            note_modal_macro(&mut self.parameters, &self.config, false);
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
            note_modal_macro(&mut self.parameters, &self.config, true);
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
