//! Words of Fanuc and Haas that RS274/NGC writes with other letters or codes, or not at all.

use crate::codes::{AxisUse, Code, CodeRow, Group};
use crate::dialect::{Dialect, Leniency};
use crate::exec::cycles::is_canned;
use crate::exec::words::AXIS_BITS;
use crate::interpreter::Interpreter;
use crate::ops::SourcedOp;
use crate::parameters::control::GROUPS;
use crate::syntax::{Value, Word};

impl Interpreter {
    /// G110 to G129 of Haas are G154 P1 to P20.
    pub(super) fn rename_extra_systems(&mut self) {
        for index in 0..self.block.words.len() {
            let Some(word) = self.block.words.get_mut(index) else {
                break;
            };
            let number = match (word.letter, word.value) {
                (b'G', Value::Number(number)) if (110.0..=129.0).contains(&number) => number,
                _ => continue,
            };
            word.value = Value::Number(154.0);
            let system = Word {
                letter: b'P',
                value: Value::Number(number - 109.0),
                text: word.text,
            };
            self.block.words.push(system);
            return;
        }
    }

    /// Words of Fanuc that RS274/NGC has under other letters or not at all: K of a canned cycle is L,
    /// `G54 P2` is `G54.1 P2`, and axis words beside G80 move in the mode that it leaves.
    pub(crate) fn fanuc_words(&mut self, out: &mut Vec<SourcedOp>) {
        self.cycle_repeats();
        if self.words.has(b'P')
            && self.config.leniencies.has(Leniency::ExtraSystems)
            && self.words.only_user_of(Code::g(540), b'P')
        {
            self.words.replace(Code::g(540), Code::g(541));
            self.tell(Leniency::ExtraSystems);
        }
        if self.words.has_g(800) && self.words.mask & AXIS_BITS != 0 {
            let other = |row: &CodeRow| row.group != Group::Motion && row.axes != AxisUse::None;
            if !self.words.codes().iter().any(|used| other(used.row)) {
                self.words.drop_motion();
                self.exec(out).end_cycle();
                self.parameters.put(GROUPS + 9, 80.0);
            }
        }
    }

    /// K of a canned cycle at Fanuc is the count of its repetitions, as L is elsewhere.
    fn cycle_repeats(&mut self) {
        let accepted = self.config.leniencies.has(Leniency::CycleRepeats);
        let named = self
            .words
            .codes()
            .iter()
            .find(|used| used.row.group == Group::Motion)
            .map(|used| used.row.code);
        let repeats = named.or(self.state.motion).is_some_and(is_canned);
        let moves = named.is_some() || self.words.mask & AXIS_BITS != 0;
        if !accepted || !repeats || !moves {
            return;
        }
        let letter = match (self.words.get(b'K'), self.words.get(b'L')) {
            (Some(_), None) if self.config.dialect == Dialect::Fanuc => b'K',
            (_, Some(0.0)) => b'L',
            _ => return,
        };
        if let Some(count) = self.words.get(letter) {
            let text = self.words.text(letter);
            self.words.drop_word(letter);
            self.words.put_at(b'L', count, text);
            self.tell(Leniency::CycleRepeats);
        }
    }
}
