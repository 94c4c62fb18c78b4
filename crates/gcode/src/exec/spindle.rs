//! Speed modes of the spindle, its orientation, and moves in step with it.

use super::Exec;
use crate::code::Code;
use crate::code::whole;
use crate::ops::{CanonicalOp, OrientWay};
use crate::problem::Problem;

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
