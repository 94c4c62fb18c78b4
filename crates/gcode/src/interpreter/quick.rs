//! Straight moves that need nothing but their axis words, which nearly all blocks of real programs are.
//!
//! What a block means stands in `exec`; this does the same for G0 and G1 with literal X Y Z A B C and F in the modes that
//! nearly all programs are in, and leaves every other block, and every block with something wrong, to that. The tests run
//! programs both ways.

use super::Interpreter;
use crate::ops::{CanonicalOp, SourcedOp};
use crate::problem::Code;
use crate::state::{FeedMode, State};
use crate::syntax::Value;
use lostmotion_base::span::BlockRef;

const RAPID: Code = Code { letter: 'G', tenths: 0 };
const FEED: Code = Code { letter: 'G', tenths: 10 };

/// Whether nothing is in force that a straight move has to ask about.
fn is_plain(state: &State) -> bool {
    state.absolute
        && !state.diameter
        && state.feed_mode == FeedMode::PerMinute
        && state.compensation.is_none()
        && state.nurbs.is_none()
        && state.corner.is_none()
        && !state.motion_unknown
}

impl Interpreter {
    /// Carries the block out if it is a straight move of that kind. False: nothing has been done.
    #[inline]
    pub(super) fn quick_move(&mut self, out: &mut Vec<SourcedOp>) -> bool {
        let waits = self.special || self.profile.is_some() || self.modal_macro.is_some();
        if waits || self.block.comment.is_some() || !self.block.settings.is_empty() || !is_plain(&self.state) {
            return false;
        }
        let (mut code, mut explicit, mut rate) = (self.state.motion, false, None);
        let mut end = self.state.current;
        let mut seen = 0u32;
        for word in &self.block.words {
            let Value::Number(value) = word.value else { return false };
            let axis = match word.letter {
                letter @ b'X'..=b'Z' => usize::from(letter - b'X'),
                letter @ b'A'..=b'C' => usize::from(letter - b'A') + 3,
                b'G' if !explicit && (value == 0.0 || value == 1.0) => {
                    (code, explicit) = (Some(if value == 0.0 { RAPID } else { FEED }), true);
                    continue;
                }
                b'F' if rate.is_none() && value >= 0.0 => {
                    rate = Some(value);
                    continue;
                }
                _ => return false,
            };
            if seen & (1 << axis) != 0 {
                return false;
            }
            seen |= 1 << axis;
            end[axis] = value;
        }
        let op = match code {
            Some(RAPID) => CanonicalOp::StraightTraverse(end),
            Some(FEED) if rate.unwrap_or(self.state.feed) > 0.0 => CanonicalOp::StraightFeed(end),
            _ => return false,
        };
        let mut exec = self.exec(out);
        let too_fast = rate.is_some_and(|rate| rate * exec.state.units.mm() > exec.config.limits.feed);
        if seen == 0 || too_fast || exec.check_target(&end).is_err() {
            return false;
        }
        if let Some(rate) = rate {
            exec.set_feed(rate, None);
        }
        let state = exec.state;
        state.motion = code;
        (state.current, state.corner_exit, state.spline_exit, state.arc_not_allowed) = (end, None, None, false);
        out.push(SourcedOp { op, block: BlockRef { span: self.span, call_stack: self.stack_index } });
        true
    }
}
