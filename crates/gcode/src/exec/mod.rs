//! Carrying out a block: one file per kind of action.

pub(crate) mod arc;
mod arc_hint;
pub(crate) mod compensation;
pub(crate) mod controls;
pub(crate) mod corner;
pub(crate) mod curves;
pub(crate) mod cycles;
pub(crate) mod holes;
pub(crate) mod modes;
pub(crate) mod offsets;
pub(crate) mod outputs;
pub(crate) mod registers;
pub(crate) mod run;
mod salvage;
pub(crate) mod spindle;
pub(crate) mod stop;
pub(crate) mod straight;
pub(crate) mod thread;
pub(crate) mod tool;
pub(crate) mod turning;
pub(crate) mod words;

use crate::codes::Code;
use crate::config::InterpreterConfig;
use crate::ops::{CanonicalOp, Position, SourcedOp};
use crate::parameters::Parameters;
use crate::problem::Problem;
use crate::state::{Saved, State, is_angle};
use crate::tool_table::ToolTable;
use lostmotion_base::axis::AxisId;
use lostmotion_base::span::BlockRef;
use words::Words;

/// Where a block sends the program.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Jump {
    /// M98.
    Call { name: String, rounds: u64 },
    /// G70 to G72.2: the profile is a subroutine.
    Profile(Box<turning::Turning>),
    /// M99.
    Return,
    /// M99 P: to the line of an N number.
    ReturnTo {
        /// P.
        line: f64,
    },
}

/// A block being carried out.
pub(crate) struct Exec<'a> {
    pub(crate) state: &'a mut State,
    pub(crate) parameters: &'a mut Parameters,
    pub(crate) config: &'a InterpreterConfig,
    pub(crate) tools: &'a mut Option<ToolTable>,
    pub(crate) jump: &'a mut Option<Jump>,
    /// What M70 and M73 have saved, the last one at this level of calls.
    pub(crate) saved: &'a mut Vec<Saved>,
    pub(crate) words: &'a Words,
    pub(crate) block: BlockRef,
    pub(crate) out: &'a mut Vec<SourcedOp>,
    pub(crate) warnings: &'a mut Vec<Problem>,
}

impl Exec<'_> {
    pub(crate) fn emit(&mut self, op: CanonicalOp) {
        let named = self.named(&op);
        self.emit_named(op, named);
    }

    /// Emits an operation that says the places of these axes.
    pub(crate) fn emit_named(&mut self, op: CanonicalOp, named: u16) {
        let sourced = SourcedOp {
            op,
            block: self.block,
            named,
        };
        if self.state.compensation.is_some() {
            return self.hold(sourced);
        }
        self.out.push(sourced);
    }

    /// The axes whose place the block says for an operation, see [`SourcedOp::named`]. What cycles do is
    /// computed, but for the way to a hole.
    pub(crate) fn named(&self, op: &CanonicalOp) -> u16 {
        use CanonicalOp as O;
        let goes = matches!(
            op,
            O::StraightTraverse(_) | O::StraightFeed(_) | O::ArcFeed(_) | O::StraightProbe(_)
        );
        if !(goes && (self.state.absolute || self.words.has_g(530))) {
            return 0;
        }
        match self.words.motion.map(|row| row.code.tenths) {
            Some(0..=30 | 330 | 331 | 382..=385) => self.axes_with_words(),
            None if self.words.has_g(280) || self.words.has_g(300) => self.axes_with_words(),
            _ => 0,
        }
    }

    /// The axes that the block has a word of; X and Y where it has a polar one.
    pub(crate) fn axes_with_words(&self) -> u16 {
        let is_polar = self.words.has(b'@') || self.words.has(b'^');
        let has =
            |axis: &usize| self.words.has(words::AXIS_LETTERS[*axis]) || is_polar && *axis < 2;
        (0..9).filter(has).fold(0, |named, axis| named | 1 << axis)
    }

    /// The value of a word.
    pub(crate) fn word(&self, letter: u8) -> Option<f64> {
        self.words.get(letter)
    }

    /// The value of the word of an axis index.
    pub(crate) fn axis_word(&self, axis: usize) -> Option<f64> {
        let value = self.words.get(words::AXIS_LETTERS[axis]);
        // X is a diameter in G7.
        if axis == 0 && self.state.diameter {
            value.map(|x| 0.5 * x)
        } else {
            value
        }
    }

    /// A position with the axes that the block names.
    pub(crate) fn with_axis_words(&self, position: &Position) -> Position {
        std::array::from_fn(|axis| self.axis_word(axis).unwrap_or(position[axis]))
    }

    /// The value of a word that a code cannot do without.
    pub(crate) fn need(&self, letter: u8, code: Code, what: &'static str) -> Result<f64, Problem> {
        self.word(letter).ok_or(Problem::WordMissing { code, what })
    }

    /// Refuses a target beyond the coordinate limit, which is in mm or degrees.
    pub(crate) fn check_target(&self, target: &Position) -> Result<(), Problem> {
        let limit = self.config.limits.coordinate;
        for (index, &value) in target.iter().enumerate() {
            // The limit is in mm or degrees, program values may be in inches.
            let size = if is_angle(index) {
                value.abs()
            } else {
                value.abs() * self.state.units.mm()
            };
            // NaN compares false with everything and has to be refused by name.
            if size.is_nan() || size > limit {
                let axis = AxisId::from_index(index).map_or('?', AxisId::letter);
                return Err(Problem::CoordinateTooLarge { axis, value, limit });
            }
        }
        Ok(())
    }
}
