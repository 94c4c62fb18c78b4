//! Spindle, coolant and overrides.

use super::Exec;
use crate::code::Code;
use crate::code::whole;
use crate::ops::CanonicalOp;
use crate::problem::Problem;
use crate::state::Spindle;

impl Exec<'_> {
    /// The spindle that `$` names for a move in step with it, 0 without the word.
    pub(crate) fn spindle_number(&self, code: Code) -> Result<u8, Problem> {
        let Some(value) = self.word(b'$') else {
            return Ok(0);
        };
        match whole(value).filter(|number| (0.0..8.0).contains(number)) {
            Some(number) => Ok(number as u8),
            None => Err(Problem::WordOutOfRange {
                code,
                letter: '$',
                value,
                allowed: "a spindle from 0 to 7",
            }),
        }
    }

    /// The spindles that `$` names, as bits: one of them, or with -1 all that the program has used
    /// so far.
    pub(crate) fn spindles(&self) -> Result<Spindles, Problem> {
        let number = self.word(b'$').unwrap_or(0.0);
        match whole(number).filter(|number| (-1.0..8.0).contains(number)) {
            Some(-1.0) => {
                let used = self
                    .state
                    .more_spindles
                    .iter()
                    .enumerate()
                    .filter(|(_, spindle)| **spindle != Spindle::default());
                Ok(Spindles(used.fold(1, |bits, (index, _)| bits | 2 << index)))
            }
            Some(number) => Ok(Spindles(1 << number as u8)),
            None => Err(Problem::BadWordValue {
                letter: '$',
                value: number,
            }),
        }
    }

    /// What is known of a spindle.
    pub(crate) fn spindle_state(&mut self, spindle: u8) -> &mut Spindle {
        let index = usize::from(spindle).wrapping_sub(1);
        self.state
            .more_spindles
            .get_mut(index)
            .unwrap_or(&mut self.state.spindle)
    }

    /// P of an override: on unless it is 0.
    fn switched_on(&self, code: Code) -> Result<bool, Problem> {
        match self.word(b'P') {
            Some(value) if value < 0.0 => Err(Problem::WordOutOfRange {
                code,
                letter: 'P',
                value,
                allowed: "0 or 1",
            }),
            value => Ok(value != Some(0.0)),
        }
    }
}

/// Spindles by the bits of their numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spindles(u8);

impl Iterator for Spindles {
    type Item = u8;

    fn next(&mut self) -> Option<u8> {
        let lowest = self.0.trailing_zeros();
        self.0 &= self.0.wrapping_sub(1);
        (lowest < 8).then_some(lowest as u8)
    }
}

/// M3 and M4.
pub(crate) fn spindle_on(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let clockwise = code.tenths == 30;
    for spindle in exec.spindles()? {
        exec.spindle_state(spindle).clockwise = Some(clockwise);
        exec.emit(CanonicalOp::StartSpindle { spindle, clockwise });
    }
    Ok(())
}

/// M5.
pub(crate) fn spindle_off(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    for spindle in exec.spindles()? {
        exec.spindle_state(spindle).clockwise = None;
        exec.emit(CanonicalOp::StopSpindle { spindle });
    }
    Ok(())
}

/// M7, M8 and M9.
pub(crate) fn coolant(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    match code.tenths {
        70 => {
            exec.state.mist = true;
            exec.emit(CanonicalOp::Mist(true));
        }
        80 => {
            exec.state.flood = true;
            exec.emit(CanonicalOp::Flood(true));
        }
        _ => exec.coolant_off(),
    }
    Ok(())
}

impl Exec<'_> {
    pub(crate) fn coolant_off(&mut self) {
        (self.state.mist, self.state.flood) = (false, false);
        self.emit(CanonicalOp::Mist(false));
        self.emit(CanonicalOp::Flood(false));
    }
}

/// M48 and M49.
pub(crate) fn overrides(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let on = code.tenths == 480;
    (exec.state.feed_override, exec.state.speed_override) = (on, on);
    exec.emit(CanonicalOp::FeedOverride(on));
    exec.emit(CanonicalOp::SpeedOverride(on));
    Ok(())
}

/// M50.
pub(crate) fn feed_override(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.feed_override = exec.switched_on(code)?;
    exec.emit(CanonicalOp::FeedOverride(exec.state.feed_override));
    Ok(())
}

/// M51.
pub(crate) fn speed_override(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.spindles()?;
    exec.state.speed_override = exec.switched_on(code)?;
    exec.emit(CanonicalOp::SpeedOverride(exec.state.speed_override));
    Ok(())
}

/// M52.
pub(crate) fn adaptive_feed(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.adaptive_feed = exec.switched_on(code)?;
    exec.emit(CanonicalOp::AdaptiveFeed(exec.state.adaptive_feed));
    Ok(())
}

/// M53.
pub(crate) fn feed_hold(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.feed_hold = exec.switched_on(code)?;
    exec.emit(CanonicalOp::FeedHold(exec.state.feed_hold));
    Ok(())
}
