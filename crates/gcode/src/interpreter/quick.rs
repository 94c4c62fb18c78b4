//! Moves that need nothing but their axis words and centres, which nearly all blocks of real
//! programs are.
//!
//! What a block means stands in `exec`; this does the same for G0 to G3 with literal X Y Z A B C I
//! J K and F in the modes that nearly all programs are in, and leaves every other block, and every
//! block with something wrong, to that. The tests run programs both ways.

use super::Interpreter;
use crate::codes::Code;
use crate::exec::arc::{arc_feed, check_center, check_radius};
use crate::ops::{CanonicalOp, Position, SourcedOp};
use crate::state::{FeedMode, State};
use crate::syntax::Value;
use lostmotion_base::span::BlockRef;

const RAPID: Code = Code::g(0);
const FEED: Code = Code::g(10);
const CLOCKWISE: Code = Code::g(20);
const COUNTER_CLOCKWISE: Code = Code::g(30);

/// Whether nothing is in force that such a move has to ask about.
fn is_plain(state: &State) -> bool {
    state.absolute
        && !state.diameter
        && state.feed_mode == FeedMode::PerMinute
        && state.compensation.is_none()
        && state.nurbs.is_none()
        && state.corner.is_none()
        && !state.motion_unknown
        && state.doubtful == 0
}

/// What the words of such a block say.
struct Gathered {
    code: Option<Code>,
    /// The block says its code.
    explicit: bool,
    rate: Option<f64>,
    end: Position,
    /// Bits of the axes named.
    axes: u32,
    /// I, J and K.
    center: [f64; 3],
    /// Bits of those named.
    centers: u32,
}

impl Gathered {
    /// Adds a word; false for a word that needs the full path, or that is there already.
    #[inline(always)]
    fn take(&mut self, letter: u8, value: f64) -> bool {
        // Slots are derived from the letter: no table, no search on the hot path.
        let (slot, seen, bit) = match letter {
            b'X'..=b'Z' => (
                self.end.get_mut(usize::from(letter - b'X')),
                &mut self.axes,
                letter - b'X',
            ),
            b'A'..=b'C' => (
                self.end.get_mut(usize::from(letter - b'A') + 3),
                &mut self.axes,
                letter - b'A' + 3,
            ),
            b'I'..=b'K' => (
                self.center.get_mut(usize::from(letter - b'I')),
                &mut self.centers,
                letter - b'I',
            ),
            b'G' if !self.explicit => {
                self.explicit = true;
                self.code = [RAPID, FEED, CLOCKWISE, COUNTER_CLOCKWISE]
                    .into_iter()
                    .find(|code| value * 10.0 == f64::from(code.tenths));
                return self.code.is_some();
            }
            b'F' if self.rate.is_none() && value >= 0.0 => {
                self.rate = Some(value);
                return true;
            }
            _ => return false,
        };
        // A repeated letter is an error, which the full path reports.
        let is_new = *seen & (1 << bit) == 0;
        *seen |= 1 << bit;
        slot.is_some_and(|slot| {
            *slot = value;
            is_new
        })
    }
}

impl Interpreter {
    /// Carries the block out if it is a plain move; false if it is not, and nothing has been done.
    #[inline]
    pub(super) fn quick_move(&mut self, out: &mut Vec<SourcedOp>) -> bool {
        // Dialects, profiles and modal macros look at every block themselves.
        let waits = self.special || self.profile.is_some() || self.modal_macro.is_some();
        if waits
            || self.block.comment.is_some()
            || !self.block.settings.is_empty()
            || !is_plain(&self.state)
        {
            return false;
        }
        // Gather literals; anything unusual leaves the block to the full path.
        let (code, end) = (self.state.motion, self.state.current);
        let mut said = Gathered {
            code,
            explicit: false,
            rate: None,
            end,
            axes: 0,
            center: [0.0; 3],
            centers: 0,
        };
        for word in &self.block.words {
            let Value::Number(value) = word.value else {
                return false;
            };
            if !said.take(word.letter, value) {
                return false;
            }
        }
        let Some(op) = self.quick_op(&said) else {
            return false;
        };
        // Limits, then the state changes as on the full path.
        let mut exec = self.exec(out);
        let too_fast = said
            .rate
            .is_some_and(|rate| rate * exec.state.units.mm() > exec.config.limits.feed);
        if too_fast || exec.check_target(&said.end).is_err() {
            return false;
        }
        if let Some(rate) = said.rate {
            exec.set_feed(rate, None);
        }
        let state = exec.state;
        // Nine axes at most; a plain block is absolute.
        let named = said.axes as u16;
        state.motion = said.code;
        (
            state.current,
            state.corner_exit,
            state.spline_exit,
            state.arc_not_allowed,
        ) = (said.end, None, None, false);
        out.push(SourcedOp {
            op,
            block: BlockRef {
                span: self.span,
                call_stack: self.stack_index,
            },
            named,
        });
        true
    }

    /// The operation, if nothing is wrong with it.
    #[inline(always)]
    fn quick_op(&self, said: &Gathered) -> Option<CanonicalOp> {
        // A missing feed is an error, which the full path reports.
        let is_fed = said.rate.unwrap_or(self.state.feed) > 0.0;
        match said.code? {
            RAPID if said.axes != 0 && said.centers == 0 => {
                Some(CanonicalOp::StraightTraverse(said.end))
            }
            FEED if said.axes != 0 && said.centers == 0 && is_fed => {
                Some(CanonicalOp::StraightFeed(said.end))
            }
            CLOCKWISE if is_fed => self.quick_arc(said, -1),
            COUNTER_CLOCKWISE if is_fed => self.quick_arc(said, 1),
            _ => None,
        }
    }

    /// An arc about a centre relative to its start.
    fn quick_arc(&self, said: &Gathered, turns: i32) -> Option<CanonicalOp> {
        let state = &self.state;
        let [first, second, normal] = state.plane.axes();
        // Off-plane offsets, absolute centres and the exit from compensation need the full path.
        let off_plane = said.centers & (1 << normal) != 0;
        if said.centers == 0 || off_plane || state.arc_absolute || state.arc_not_allowed {
            return None;
        }
        let from = [state.current[first], state.current[second]];
        // Relative centres: the same sum and the same checks as on the full path, to the bit.
        let center = [from[0] + said.center[first], from[1] + said.center[second]];
        check_center(
            from,
            [said.end[first], said.end[second]],
            center,
            state.units,
        )
        .ok()?;
        check_radius(from, center, state.units, self.config.limits.radius_mm).ok()?;
        Some(CanonicalOp::ArcFeed(arc_feed(
            state.plane,
            &said.end,
            center,
            turns,
        )))
    }
}
