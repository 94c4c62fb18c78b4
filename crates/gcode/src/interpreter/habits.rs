//! Habits of writing: leniencies that are reported once a file with their count.

use super::Interpreter;
use crate::diagnostics::Diagnostic;
use crate::dialect::{LENIENCIES, Leniency};
use crate::exec::words::SECONDARY_BITS;
use crate::problem::Problem;
use lostmotion_base::span::{BlockRef, Span};
use std::collections::BTreeMap;

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
