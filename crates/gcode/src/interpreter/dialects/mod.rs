//! Lines of other dialects: what of them is rewritten, skipped or called before the words are carried
//! out; and habits of writing, which are reported once a file with their count.

mod builder;
mod fanuc;
mod klipper;
mod renamed;
mod variables;

use super::Interpreter;
use crate::codes::Code;
use crate::diagnostics::Diagnostic;
use crate::dialect::{Dialect, LENIENCIES, Leniency};
use crate::exec::corner::is_straight;
use crate::exec::words::SECONDARY_BITS;
use crate::ops::SourcedOp;
use crate::problem::Problem;
use crate::syntax::reading::{is_printers_code, merge_exponents, parse_accepted};
use crate::syntax::special::siemens_word;
use crate::syntax::{Fault, Text, Value};
pub(crate) use builder::words as builders_words;
pub(crate) use fanuc::ModalMacro;
pub(crate) use klipper::Klipper;
use lostmotion_base::span::{BlockRef, Span};
use std::collections::BTreeMap;
pub(crate) use variables::note_start;

/// What is told once only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Once {
    /// A code that is not known.
    Code(Code),
    /// A system variable.
    Variable(u32),
    /// SET_VELOCITY_LIMIT.
    VelocityLimit,
}

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
        let taken = parse_accepted(
            &self.line,
            &mut self.block,
            &self.config.limits,
            self.config.leniencies,
            fault,
        )
        .inspect_err(|fault| {
            // A program for quite another control: one message instead of one for each line.
            self.state.ended |= match *fault.problem {
                Problem::Heidenhain => true,
                Problem::Siemens { .. } => self.config.dialect == Dialect::Siemens,
                _ => false,
            };
        })?;
        if !self.is_passing() {
            taken.into_iter().for_each(|leniency| self.tell(leniency));
        }
        Ok(())
    }

    /// What a dialect other than RS274/NGC makes of a line before its words are collected.
    #[cold]
    pub(crate) fn dialect_line(
        &mut self,
        out: &mut Vec<SourcedOp>,
    ) -> Result<Line, (Problem, Option<Text>)> {
        let accepted = self.config.leniencies;
        // Sinumerik programs are refused at the first block that has something of their own.
        if self.config.dialect == Dialect::Siemens
            && !(self.block.words.is_empty() && self.block.settings.is_empty())
        {
            let is_read = accepted.has(Leniency::PlainSiemens);
            let own = siemens_word(&self.line);
            if let Some(what) = own.or((!is_read).then_some("the program")) {
                self.state.ended = true;
                return Err((Problem::Siemens { what }, None));
            }
            self.tell(Leniency::PlainSiemens);
        }
        if self.config.dialect.is_printer() {
            if accepted.has(Leniency::GcodeStates)
                && self.block.words.is_empty()
                && self
                    .klipper_command(out)
                    .map_err(|problem| (problem, None))?
            {
                return Ok(Line::Done);
            }
            if self.home_printer(out).map_err(|problem| (problem, None))? {
                return Ok(Line::Done);
            }
            return Ok(self.printer_line());
        }
        if self.config.dialect == Dialect::Haas {
            self.rename_extra_systems();
        }
        if accepted.has(Leniency::IgnoredCodes) && self.ignore_codes() {
            return Ok(Line::Done);
        }
        // The raw words are looked at: these codes have no row in the table.
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
        // The same codes are turning cycles elsewhere, so that only Haas has patterns.
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
            // `G0 G28 Z0`: the motion code only sets the mode.
            self.words.drop_motion();
            self.state.motion = Some(*other);
            self.tell(Leniency::ExtraMotion);
            return true;
        }
        false
    }
}

impl Interpreter {
    /// Exponents: `X1.2E-12` has been read as X1.2 and E-12, which is put right. True if there were
    /// any.
    pub(crate) fn merge_exponents(&mut self) -> bool {
        if !self.config.leniencies.has(Leniency::Exponents) {
            return false;
        }
        let found = merge_exponents(&self.line, &mut self.block, self.config.dialect.is_fanuc());
        if found {
            self.habit_at(Leniency::Exponents, self.span);
        }
        found
    }
}

impl Interpreter {
    /// What a printer's line means on a machine tool.
    fn printer_line(&mut self) -> Line {
        let accepted = self.config.leniencies;
        // Temperatures, fans, bed levelling: they do not move the axes.
        if accepted.has(Leniency::PrinterCodes) && is_printers_code(&self.block) {
            self.tell(Leniency::PrinterCodes);
            return Line::Done;
        }
        if accepted.has(Leniency::ExtruderWords)
            && self.block.words.iter().any(|word| word.letter == b'E')
        {
            self.tell(Leniency::ExtruderWords);
            self.block.words.retain(|word| word.letter != b'E');
            // `G92 E0` resets the extruder only and goes with its E.
            let has_axis = self
                .block
                .words
                .iter()
                .any(|word| matches!(word.letter, b'X'..=b'Z' | b'A'..=b'C' | b'U'..=b'W'));
            self.block.words.retain(|word| {
                has_axis || word.letter != b'G' || word.value != Value::Number(92.0)
            });
        }
        self.printer_dwell();
        Line::Words
    }

    /// G4 of printers: P in milliseconds, S in seconds.
    fn printer_dwell(&mut self) {
        if !self
            .block
            .words
            .iter()
            .any(|word| word.letter == b'G' && word.value == Value::Number(4.0))
        {
            return;
        }
        // S in seconds comes before P, as in Marlin.
        let has_s = self.block.words.iter().any(|word| word.letter == b'S');
        self.block
            .words
            .retain(|word| !(has_s && word.letter == b'P'));
        for word in &mut self.block.words {
            match (word.letter, word.value) {
                (b'S', _) => word.letter = b'P',
                (b'P', Value::Number(ms)) => word.value = Value::Number(ms / 1000.0),
                _ => {}
            }
        }
    }
}

/// Longest line that LinuxCNC reads, in bytes.
const LINUXCNC_LINE: usize = 255;

/// How often each habit has occurred.
#[derive(Clone, Debug)]
pub(super) struct Habits {
    /// In the program itself.
    own: [u64; LENIENCIES.len()],
    /// In files of subroutines.
    others: BTreeMap<(u32, Leniency), u64>,
}

impl Default for Habits {
    fn default() -> Habits {
        Habits {
            own: [0; LENIENCIES.len()],
            others: BTreeMap::new(),
        }
    }
}

impl Habits {
    fn count(&mut self, file: u32, leniency: Leniency) -> u64 {
        // The program's own counts lie in an array: this runs for every line of some programs.
        let count = match self.own.get_mut(leniency as usize).filter(|_| file == 0) {
            Some(count) => count,
            None => self.others.entry((file, leniency)).or_default(),
        };
        *count += 1;
        *count
    }
}

impl Interpreter {
    /// Counts a habit at a place, and tells it the first time.
    pub(crate) fn habit_at(&mut self, leniency: Leniency, span: Span) {
        // Told at the first occurrence, counted afterwards.
        if self.habits.count(span.file, leniency) > 1 {
            return;
        }
        let accepted = self.config.leniencies.has(leniency);
        let problem = if accepted {
            Problem::Habit { leniency, count: 1 }
        } else {
            Problem::NotLenient { leniency }
        };
        self.diagnostics.push(Diagnostic {
            problem,
            place: BlockRef {
                span,
                call_stack: self.stack_index,
            },
        });
    }

    /// The habits of a line that has been parsed.
    #[inline]
    pub(crate) fn note_habits(&mut self) {
        // One test on the hot path: most lines have none of these.
        if self.block.lower_case | self.block.glued | (self.line.len() > LINUXCNC_LINE) {
            self.note_writing();
        }
    }

    #[cold]
    fn note_writing(&mut self) {
        let long = self.line.len() > LINUXCNC_LINE;
        let found = [
            (self.block.lower_case, Leniency::LowerCase),
            (self.block.glued, Leniency::NoBlanks),
            (long, Leniency::LongLines),
        ];
        for (_, leniency) in found.into_iter().filter(|(there, _)| *there) {
            self.habit_at(leniency, self.span);
        }
    }

    /// Words of axes that most machines do not have.
    pub(crate) fn note_axes(&mut self) {
        if self.words.mask & SECONDARY_BITS != 0 {
            self.habit_at(Leniency::SecondaryAxes, self.span);
        }
    }

    /// Puts the counts into what has been told.
    pub(crate) fn settle_habits(&mut self) {
        for (leniency, &count) in LENIENCIES
            .into_iter()
            .zip(&self.habits.own)
            .filter(|(_, count)| **count > 1)
        {
            self.diagnostics.recount(0, leniency, count);
        }
        for (&(file, leniency), &count) in &self.habits.others {
            self.diagnostics.recount(file, leniency, count);
        }
    }
}
