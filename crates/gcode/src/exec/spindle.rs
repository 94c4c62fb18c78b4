//! The spindle and moves in step with it; coolant and overrides.

use super::Exec;
use crate::codes::{Code, whole};
use crate::exec::words::whole_within;
use crate::ops::{CanonicalOp, OrientWay};
use crate::problem::Problem;
use crate::state::Spindle;

/// Highest rev/min of constant surface speed where D does not say: none.
const NO_LIMIT: f64 = 1e30;

/// G96: S is a surface speed, D the highest rev/min.
pub(crate) fn surface_speed(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.need(b'S', code, "S, the surface speed")?;
    let highest = exec.word(b'D').map_or(NO_LIMIT, f64::abs);
    for spindle in exec.spindles()? {
        exec.spindle_state(spindle).surface_limit = Some(highest);
        exec.emit(CanonicalOp::SetSpindleMode { spindle, highest });
    }
    Ok(())
}

/// G97: S is in rev/min.
pub(crate) fn constant_speed(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    for spindle in exec.spindles()? {
        exec.spindle_state(spindle).surface_limit = None;
        exec.emit(CanonicalOp::SetSpindleMode {
            spindle,
            highest: 0.0,
        });
    }
    Ok(())
}

/// M19: R is the angle, P the way round, Q how long to wait for it.
pub(crate) fn orient(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let spindles = exec.spindles()?;
    let degrees = exec.word(b'R').unwrap_or(0.0);
    if !(0.0..=360.0).contains(&degrees) {
        return Err(Problem::WordOutOfRange {
            code,
            letter: 'R',
            value: degrees,
            allowed: "an angle from 0 to 360",
        });
    }
    let value = exec.word(b'P').unwrap_or(0.0);
    let ways = [
        OrientWay::Shortest,
        OrientWay::Clockwise,
        OrientWay::CounterClockwise,
    ];
    // P: 0 the shortest way, 1 clockwise, 2 counter-clockwise.
    let way = whole(value).and_then(|number| {
        ways.into_iter()
            .find(|way| f64::from(way.number()) == number)
    });
    let way = way.ok_or(Problem::WordOutOfRange {
        code,
        letter: 'P',
        value,
        allowed: "0, 1 or 2",
    })?;
    // Q alone waits for an orientation that was started before.
    let turns = exec.word(b'R').is_some() || exec.word(b'P').is_some();
    let wait = exec.word(b'Q');
    for spindle in spindles {
        // It does not turn any more, which is what the moves that follow it need.
        exec.spindle_state(spindle).clockwise = None;
        if !turns {
            continue;
        }
        exec.emit(CanonicalOp::OrientSpindle {
            spindle,
            degrees,
            way,
            boring: false,
        });
    }
    match wait {
        Some(seconds) if seconds <= 0.0 => Err(Problem::WordOutOfRange {
            code,
            letter: 'Q',
            value: seconds,
            allowed: "greater than zero",
        }),
        Some(seconds) => {
            for spindle in spindles {
                exec.emit(CanonicalOp::WaitOrient { spindle, seconds });
            }
            Ok(())
        }
        None => Ok(()),
    }
}

impl Exec<'_> {
    /// K of a move in step with the spindle, which has to turn.
    fn pitch(&mut self, code: Code) -> Result<f64, Problem> {
        let pitch = self.need(b'K', code, "K, the distance per revolution")?;
        let spindle = self.spindle_number(code)?;
        match self.spindle_state(spindle).clockwise {
            Some(_) => Ok(pitch),
            None => Err(Problem::SpindleStopped { code }),
        }
    }
}

/// G33: a straight move in step with the spindle.
pub(crate) fn synchronised(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    let end = exec.target()?;
    exec.state.current = end;
    let pitch = exec.pitch(code)?;
    // Synchronisation holds for this move alone.
    exec.emit(CanonicalOp::StartSpeedFeedSync(pitch));
    exec.emit(CanonicalOp::StraightFeed(end));
    exec.emit(CanonicalOp::StopSpeedFeedSync);
    Ok(())
}

/// G33.1: there and back in step with the spindle, which is reversed at the end; the tool is then
/// where it was.
pub(crate) fn rigid_tap(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    let end = exec.target()?;
    let pitch = exec.pitch(code)?;
    let [x, y, z, ..] = end;
    exec.emit(CanonicalOp::StartSpeedFeedSync(pitch));
    exec.emit(CanonicalOp::RigidTap([x, y, z]));
    exec.emit(CanonicalOp::StopSpeedFeedSync);
    Ok(())
}

impl Exec<'_> {
    /// The spindle that `$` names for a move in step with it, 0 without the word.
    pub(crate) fn spindle_number(&self, code: Code) -> Result<u8, Problem> {
        let Some(value) = self.word(b'$') else {
            return Ok(0);
        };
        whole_within((code, b'$'), value, 0.0..8.0, "a spindle from 0 to 7")
            .map(|number| number as u8)
    }

    /// The spindles that `$` names, as bits: one of them, or with -1 all that the program has used
    /// so far.
    pub(crate) fn spindles(&self) -> Result<Spindles, Problem> {
        let number = self.word(b'$').unwrap_or(0.0);
        match whole(number).filter(|number| (-1.0..8.0).contains(number)) {
            Some(-1.0) => {
                // A spindle counts as used once its state differs from the initial one.
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
        // Spindle 0 has its own field, the others stand in the list.
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
        // Clears the lowest set bit and returns its number.
        let lowest = self.0.trailing_zeros();
        self.0 &= self.0.wrapping_sub(1);
        (lowest < 8).then_some(lowest as u8)
    }
}

/// M3 and M4: starts the spindles that `$` names.
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

/// M53: whether a feed hold is obeyed.
pub(crate) fn feed_hold(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.feed_hold = exec.switched_on(code)?;
    exec.emit(CanonicalOp::FeedHold(exec.state.feed_hold));
    Ok(())
}
