//! The order of a block: by phase, whatever the order on the line; and which function carries out a
//! code.

use super::straight::CORNER_BITS;
use super::{
    Exec, arc, compensation, controls, curves, cycles, modes, offsets, outputs, spindle, stop,
    straight, thread, tool, turning,
};
use crate::codes::row::{PHASE_F, PHASE_MOTION, PHASE_S, PHASE_T};
use crate::codes::{Code, CodeRow, Group, whole};
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
        for (index, used) in words.codes().iter().enumerate() {
            let mut result = self.words_before(&mut next, used.row.phase);
            let mut failed_at = index;
            // Motion by mode comes before stops, as a code on the line would.
            if result.is_ok() && !moved && used.row.phase > PHASE_MOTION {
                moved = true;
                result = self.modal_motion();
            }
            if result.is_ok() {
                failed_at = index + 1;
                if used.row.group == Group::Motion {
                    moved = true;
                    self.state.motion_unknown = false;
                }
                result = self
                    .act(used.row)
                    .map_err(|problem| (problem, Some(used.text)));
            }
            // The codes behind one that fails still set their modes.
            if result.is_err() {
                self.go_on_quietly(failed_at, next, moved, &[]);
                return result;
            }
        }
        self.words_before(&mut next, u8::MAX)?;
        if !moved {
            self.modal_motion()?;
        }
        if self.state.doubtful != 0 {
            self.settle();
        }
        Ok(())
    }

    pub(super) fn act(&mut self, row: &'static CodeRow) -> Result<(), Problem> {
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
    pub(super) fn words_before(
        &mut self,
        next: &mut u8,
        phase: u8,
    ) -> Result<(), (Problem, Option<Text>)> {
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

/// Carries a code out.
pub(crate) type Action = fn(&mut Exec<'_>, Code) -> Result<(), Problem>;

/// The function of a code; `None` if there is none.
pub(crate) fn action(code: Code) -> Option<Action> {
    Some(match (code.letter, code.tenths) {
        ('G', 0) => straight::traverse,
        ('G', 10) => straight::feed,
        ('G', 20 | 30) => arc::arc,
        ('G', 40) => straight::dwell,
        ('G', 50) => curves::cubic,
        ('G', 51) => curves::quadratic,
        ('G', 52) => curves::nurbs,
        ('G', 53) => curves::nurbs_end,
        ('G', 70 | 80) => modes::diameter,
        ('G', 100) => offsets::g10,
        ('G', 120 | 130) => controls::pocket,
        ('G', 170 | 180 | 190) => modes::plane,
        ('G', 200 | 210) => modes::units,
        ('G', 280 | 300) => straight::go,
        ('G', 281 | 301) => straight::store,
        ('G', 330) => spindle::synchronised,
        ('G', 331) => spindle::rigid_tap,
        ('G', 382..=385) => straight::probe,
        ('G', 400) => compensation::off,
        ('G', 410 | 420) => compensation::on,
        ('G', 411 | 421) => compensation::dynamic,
        ('G', 430) => tool::length,
        ('G', 431) => tool::dynamic_length,
        ('G', 432) => tool::added_length,
        ('G', 434 | 435) => controls::tip,
        ('G', 440) => tool::negative_length,
        ('G', 490) => tool::no_length,
        ('G', 520) => offsets::local,
        ('G', 530) => straight::machine_coordinates,
        ('G', 531) => controls::orient,
        ('G', 540 | 541 | 550 | 560 | 570 | 580 | 590 | 591 | 592 | 593 | 1540) => offsets::select,
        ('G', 610) => modes::exact_path,
        ('G', 611) => modes::exact_stop,
        ('G', 640) => modes::continuous,
        ('G', 680) => controls::rotate,
        ('G', 682) => controls::tilt,
        ('G', 690) => controls::untilt,
        ('G', 700 | 710 | 711 | 712 | 720 | 721 | 722) => turning::cycle,
        ('G', 730 | 740 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890) => cycles::cycle,
        ('G', 760) => thread::thread,
        ('G', 800) => modes::no_motion,
        ('G', 900 | 910) => modes::distance,
        ('G', 901 | 911) => modes::arc_distance,
        ('G', 920) => offsets::g92,
        ('G', 921) => offsets::g92_forget,
        ('G', 922) => offsets::g92_suspend,
        ('G', 923) => offsets::g92_restore,
        ('G', 930 | 940 | 950) => modes::feed_mode,
        ('G', 960) => spindle::surface_speed,
        ('G', 970) => spindle::constant_speed,
        ('G', 980 | 990) => cycles::retract,
        ('M', 0) => stop::stop,
        ('M', 10) => stop::optional_stop,
        ('M', 20 | 300) => stop::end,
        ('M', 30 | 40) => spindle::spindle_on,
        ('M', 50) => spindle::spindle_off,
        ('M', 60) => tool::change,
        ('M', 70 | 80 | 90) => spindle::coolant,
        ('M', 190) => spindle::orient,
        ('M', 480 | 490) => spindle::overrides,
        ('M', 500) => spindle::feed_override,
        ('M', 510) => spindle::speed_override,
        ('M', 520) => spindle::adaptive_feed,
        ('M', 530) => spindle::feed_hold,
        ('M', 600) => stop::pallet,
        ('M', 610) => tool::set_number,
        ('M', 620 | 630 | 640 | 650) => outputs::digital,
        ('M', 660) => outputs::input,
        ('M', 670 | 680) => outputs::analog,
        ('M', 700 | 730) => modes::save,
        ('M', 710) => modes::forget,
        ('M', 720) => modes::bring_back,
        ('M', 980) => stop::call,
        ('M', 990) => stop::back,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::action;
    use crate::codes::Code;
    use crate::codes::{find, rows};

    #[test]
    fn the_codes_with_a_row_are_those_with_a_function() {
        for row in rows() {
            assert!(action(row.code).is_some(), "{} has no function", row.code);
        }
        for letter in ['G', 'M'] {
            for tenths in 0..=u16::MAX {
                let code = Code { letter, tenths };
                assert!(
                    action(code).is_none() || find(code).is_some(),
                    "{code} has no row"
                );
            }
        }
    }
}
