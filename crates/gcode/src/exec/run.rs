//! The order of a block: by phase, whatever the order on the line.

use super::Exec;
use super::actions::action;
use super::straight::CORNER_BITS;
use crate::code::{Code, whole};
use crate::codes::row::{PHASE_F, PHASE_MOTION, PHASE_S, PHASE_T};
use crate::codes::{CodeRow, Group};
use crate::ops::CanonicalOp;
use crate::problem::Problem;
use crate::state::FeedMode;
use crate::syntax::Text;

/// G5, which goes on as the one before it ended.
const CUBIC: Code = Code::g(50);

impl Exec<'_> {
    /// Carries the block out.
    pub(crate) fn run(&mut self) -> Result<(), (Problem, Option<Text>)> {
        let words = self.words;
        // A corner that waits needs the direction of this block's move: it comes first.
        if self.state.corner.is_some() {
            self.turn_corner().map_err(|problem| (problem, None))?;
        }
        // Only a chain of corners goes on from the exit of the one before.
        self.state.corner_exit = self
            .state
            .corner_exit
            .take()
            .filter(|_| words.mask & CORNER_BITS != 0);
        let mut next = 0;
        let mut moved = false;
        // Codes in the order of RS274/NGC's execution; F, S and T take their places between them.
        for used in words.codes() {
            self.words_before(&mut next, used.row.phase)?;
            // Motion by mode comes before stops, as a code on the line would.
            if !moved && used.row.phase > PHASE_MOTION {
                moved = true;
                self.modal_motion()?;
            }
            if used.row.group == Group::Motion {
                moved = true;
                self.state.motion_unknown = false;
            }
            self.act(used.row)
                .map_err(|problem| (problem, Some(used.text)))?;
        }
        self.words_before(&mut next, u8::MAX)?;
        if !moved {
            self.modal_motion()?;
        }
        Ok(())
    }

    fn act(&mut self, row: &'static CodeRow) -> Result<(), Problem> {
        if self.state.compensation.is_some() {
            self.under_compensation(row.code)?;
        }
        // An open NURBS takes control points and its end, and nothing else but a program stop.
        if self.state.nurbs.is_some()
            && row.group != Group::Stop
            && !matches!(
                row.code,
                Code {
                    letter: 'G',
                    tenths: 52 | 53
                }
            )
        {
            return Err(Problem::Curve {
                code: row.code,
                message: "cannot stand between G5.2 and G5.3",
            });
        }
        // G5 may go on from the tangent of the G5 before it only if nothing came between.
        if row.group == Group::Motion && row.code != CUBIC {
            self.state.spline_exit = None;
        }
        let action = action(row.code).ok_or(Problem::UnsupportedCode { code: row.code })?;
        action(self, row.code)
    }

    /// The motion that a mode of an earlier block makes.
    fn modal_motion(&mut self) -> Result<(), (Problem, Option<Text>)> {
        match self.words.motion {
            Some(row) => self.act(row).map_err(|problem| (problem, None)),
            None => Ok(()),
        }
    }

    /// F, S and T that come before a phase and have not been carried out.
    fn words_before(&mut self, next: &mut u8, phase: u8) -> Result<(), (Problem, Option<Text>)> {
        for (at, letter) in [(PHASE_F, b'F'), (PHASE_S, b'S'), (PHASE_T, b'T')] {
            if *next <= at && at < phase {
                *next = at + 1;
                if let Some(value) = self.word(letter) {
                    self.plain_word(letter, value)
                        .map_err(|problem| (problem, Some(self.words.text(letter))))?;
                }
            }
        }
        Ok(())
    }

    fn plain_word(&mut self, letter: u8, value: f64) -> Result<(), Problem> {
        // F, S and T by themselves: feed, speed, selected tool.
        let bad = Problem::BadWordValue {
            letter: char::from(letter),
            value,
        };
        match letter {
            b'F' if value < 0.0 => Err(bad),
            b'F' if value * self.state.units.mm() > self.config.limits.feed => {
                Err(Problem::FeedTooLarge {
                    rate: value,
                    limit: self.config.limits.feed,
                })
            }
            b'F' => {
                // In inverse time F belongs to the move, which computes its rate.
                if self.state.feed_mode != FeedMode::InverseTime {
                    self.set_feed(value, None);
                }
                Ok(())
            }
            b'S' if value < 0.0 => Err(bad),
            b'S' => {
                for spindle in self.spindles()? {
                    self.spindle_state(spindle).speed = value;
                    self.emit(CanonicalOp::SetSpindleSpeed {
                        spindle,
                        speed: value,
                    });
                }
                Ok(())
            }
            _ => match whole(value).filter(|number| (0.0..1e9).contains(number)) {
                Some(number) => self.select_tool(number as i32),
                None => Err(bad),
            },
        }
    }

    pub(crate) fn set_feed(&mut self, rate: f64, inverse_time: Option<f64>) {
        self.state.feed = rate;
        self.state.feed_missed = false;
        self.emit(CanonicalOp::SetFeedRate { rate, inverse_time });
    }
}
