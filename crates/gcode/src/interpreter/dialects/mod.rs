//! Lines of other dialects: what of them is rewritten, skipped or called before the words are
//! carried out.

mod controls;
mod exponents;
mod macros;
mod printers;

use super::Interpreter;
use crate::dialect::{Dialect, Leniency};
use crate::exec::corner::is_straight;
use crate::ops::SourcedOp;
use crate::problem::Problem;
use crate::syntax::siemens::{is_heidenhain, siemens_word};
use crate::syntax::special::parse_special;
use crate::syntax::{Fault, Text, Value};
pub(crate) use macros::ModalMacro;

/// What becomes of a line.
pub(crate) enum Line {
    /// Its words are carried out as usual.
    Words,
    /// It is done.
    Done,
}

impl Interpreter {
    /// Says once that a leniency was made use of.
    pub(crate) fn tell(&mut self, leniency: Leniency) {
        if !self.told.has(leniency) {
            self.told = self.told.with(leniency);
            self.report(Problem::Lenient { leniency });
        }
    }

    /// Reports what a leniency forgives: a warning if it is accepted, an error otherwise.
    pub(crate) fn forgive(&mut self, problem: Problem, leniency: Leniency) {
        self.report(if self.config.leniencies.has(leniency) {
            problem
        } else {
            Problem::NotLenient { leniency }
        });
    }

    /// Another try at a line that is a fault in RS274/NGC.
    #[cold]
    pub(crate) fn parse_specially(&mut self, fault: Fault) -> Result<(), Fault> {
        let accepted = self.config.leniencies;
        match parse_special(&self.line, &mut self.block, &self.config.limits, accepted) {
            Ok(taken) if !taken.is_empty() => {
                if !self.is_passing() {
                    taken.into_iter().for_each(|leniency| self.tell(leniency));
                }
                return Ok(());
            }
            Err(Fault { rest, problem }) if matches!(*problem, Problem::Checksum { .. }) => {
                return Err(Fault { rest, problem });
            }
            _ => {}
        }
        if is_heidenhain(&self.line) {
            self.state.ended = true;
            return Err(Fault {
                problem: Box::new(Problem::Heidenhain),
                ..fault
            });
        }
        match siemens_word(&self.line) {
            Some(what) => Err(Fault {
                problem: Box::new(Problem::Siemens { what }),
                ..fault
            }),
            None => Err(fault),
        }
    }

    /// What a dialect other than RS274/NGC makes of a line before its words are collected.
    #[cold]
    pub(crate) fn dialect_line(
        &mut self,
        out: &mut Vec<SourcedOp>,
    ) -> Result<Line, (Problem, Option<Text>)> {
        let accepted = self.config.leniencies;
        if self.config.dialect == Dialect::Siemens
            && !(self.block.words.is_empty() && self.block.settings.is_empty())
        {
            let what = siemens_word(&self.line).unwrap_or("the program");
            self.state.ended = true;
            return Err((Problem::Siemens { what }, None));
        }
        if self.config.dialect.is_printer() {
            return Ok(self.printer_line());
        }
        if accepted.has(Leniency::IgnoredCodes) && self.ignore_codes() {
            return Ok(Line::Done);
        }
        let has = |letter: u8, number: f64| {
            self.block
                .words
                .iter()
                .any(|word| word.letter == letter && word.value == Value::Number(number))
        };
        if accepted.has(Leniency::MacroCalls)
            && (has(b'G', 65.0) || has(b'G', 66.0) || has(b'G', 67.0))
        {
            return self
                .macro_line()
                .map(|()| Line::Done)
                .map_err(|problem| (problem, None));
        }
        if accepted.has(Leniency::LocalCalls) && has(b'M', 97.0) {
            return self
                .local_call()
                .map(|()| Line::Done)
                .map_err(|problem| (problem, None));
        }
        let patterns = accepted.has(Leniency::HolePatterns)
            && [70.0, 71.0, 72.0]
                .into_iter()
                .any(|number| has(b'G', number));
        if patterns {
            return self.hole_pattern(out).map(|()| Line::Done);
        }
        Ok(Line::Words)
    }

    /// Leniencies about words that contradict one another. True if the block can be tried again.
    #[cold]
    pub(crate) fn reconcile(&mut self, problem: &Problem) -> bool {
        let accepted = self.config.leniencies;
        if let (Problem::TwoAxisUsers { code, other }, true) =
            (problem, accepted.has(Leniency::ExtraMotion))
            && matches!(code.tenths, 280 | 300)
            && is_straight(*other)
        {
            self.words.drop_motion();
            self.state.motion = Some(*other);
            self.tell(Leniency::ExtraMotion);
            return true;
        }
        false
    }
}
