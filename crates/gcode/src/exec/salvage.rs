//! What a block with an error does all the same: its modes, F, S and T, and where its motion would
//! have led. Blocks after it are judged by that, so that one mistake gives one message.

use super::Exec;
use super::words::AXIS_LETTERS;
use crate::codes::row::PHASE_MOTION;
use crate::codes::{AxisUse, Code, CodeRow, Group};

const CANCEL: Code = Code::g(800);

/// Whether a code only sets what later blocks rely on.
const fn is_mode(row: &CodeRow) -> bool {
    match row.group {
        Group::FeedMode
        | Group::SpindleMode
        | Group::ModalState
        | Group::Coolant
        | Group::Override
        | Group::Plane
        | Group::Units
        | Group::Diameter
        | Group::CoordinateSystem
        | Group::PathControl
        | Group::Distance
        | Group::ArcDistance
        | Group::Retract
        | Group::AxisOffset => true,
        // M6, M3 to M5, G40, G43 and G49, M2 and M30.
        Group::ToolChange => row.code.tenths == 60,
        Group::Spindle => matches!(row.code.tenths, 30 | 40 | 50),
        Group::CutterCompensation => row.code.tenths == 400,
        Group::ToolLength => matches!(row.code.tenths, 430 | 490),
        Group::Stop => matches!(row.code.tenths, 20 | 300),
        Group::Output | Group::NonModal | Group::Motion => false,
    }
}

impl Exec<'_> {
    /// Carries out what can be told of a block in which the words of some letters were refused.
    #[cold]
    pub(crate) fn salvage(&mut self, refused: &[u8]) {
        // F, S and T that are there but wrong count as given.
        for letter in refused {
            match letter {
                b'F' => self.state.feed_missed = true,
                b'S' if self.state.spindle.speed == 0.0 => self.state.spindle.speed = 1.0,
                b'T' => {
                    self.state.selected_tool.get_or_insert(0);
                }
                _ => {}
            }
        }
        self.go_on_quietly(0, 0, false, refused);
    }

    /// Carries out the modes among the codes from an index on and takes the motion as made.
    #[cold]
    pub(super) fn go_on_quietly(
        &mut self,
        from: usize,
        mut next: u8,
        mut moved: bool,
        refused: &[u8],
    ) {
        let words = self.words;
        for used in words.codes().iter().skip(from) {
            // The order of a block that runs, without its errors.
            let _ = self.words_before(&mut next, used.row.phase);
            if !moved && used.row.phase >= PHASE_MOTION {
                moved = true;
                self.take_as_moved(refused);
            }
            if is_mode(used.row) {
                let _ = self.act(used.row);
            }
        }
        let _ = self.words_before(&mut next, u8::MAX);
        if !moved {
            self.take_as_moved(refused);
        }
    }

    /// Puts the tool where the motion of the block leads, as far as its words tell.
    fn take_as_moved(&mut self, refused: &[u8]) {
        let mask = |is_in: &dyn Fn(u8) -> bool| {
            let bits = AXIS_LETTERS.iter().enumerate();
            bits.filter(|(_, letter)| is_in(**letter))
                .fold(0, |mask, (axis, _)| mask | 1 << axis)
        };
        let lost: u32 = mask(&|letter| refused.contains(&letter));
        let named: u32 = mask(&|letter| self.words.has(letter)) & !lost;
        // A corner, or a move under cutter compensation, cannot be made with a move that is missing.
        self.state.corner = None;
        let moves = self.words.motion.is_some() && named != 0;
        if (moves || lost != 0) && self.state.compensation.is_some() {
            let _ = self.end_compensation();
            self.state.arc_not_allowed = false;
        }
        // A code that is wrong may have been a motion mode. A straight one does as well, an arc or a
        // cycle would miss its words.
        if refused.contains(&b'G') {
            self.state.motion = self.state.motion.filter(|code| code.tenths <= 10);
            self.state.motion_unknown = true;
            self.state.doubtful |= named | lost;
            return;
        }
        if let Some(row) = self.words.motion {
            self.take_mode(row, refused);
            match self.target() {
                Ok(end) => self.state.current = end,
                Err(_) => self.state.doubtful |= named,
            }
            self.settle();
        } else {
            self.state.doubtful |= named;
        }
        self.state.doubtful |= lost;
    }

    fn take_mode(&mut self, row: &CodeRow, refused: &[u8]) {
        if row.group != Group::Motion {
            return;
        }
        self.state.motion_unknown = false;
        self.state.motion = (row.code != CANCEL).then_some(row.code);
        // Cycles keep their words: without one of them the blocks after this are not judged.
        let is_cycle = row.code.tenths >= 700 && row.axes != AxisUse::None;
        if is_cycle {
            let [_, _, normal] = self.state.plane.axes();
            self.state.doubtful |= 1 << normal;
        }
        if is_cycle && !refused.is_empty() {
            (self.state.motion, self.state.motion_unknown) = (None, true);
        }
    }

    /// The axes that a motion has placed are known again.
    pub(super) fn settle(&mut self) {
        let is_absolute = self.state.absolute
            || [280, 300, 530, 920]
                .into_iter()
                .any(|tenths| self.words.has_g(tenths));
        if !is_absolute {
            return;
        }
        for (axis, letter) in AXIS_LETTERS.into_iter().enumerate() {
            if self.words.has(letter) {
                self.state.doubtful &= !(1 << axis);
            }
        }
    }
}
