//! M0, M1, M60, M2 and M30.

use super::{Exec, Jump};
use crate::codes::Group;
use crate::ops::{CanonicalOp, Plane};
use crate::problem::{Code, Problem};
use crate::state::FeedMode;
use crate::syntax::evaluate::whole;

/// M0.
pub(crate) fn stop(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.emit(CanonicalOp::ProgramStop);
    Ok(())
}

/// M1.
pub(crate) fn optional_stop(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.emit(CanonicalOp::OptionalProgramStop);
    Ok(())
}

/// M60.
pub(crate) fn pallet(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.emit(CanonicalOp::PalletShuttle);
    exec.emit(CanonicalOp::ProgramStop);
    Ok(())
}

/// M98: the call comes after everything else on the line.
pub(crate) fn call(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let number = exec.need(b'P', code, "P, the number of the subroutine")?;
    let number = whole(number).filter(|value| *value >= 0.0).ok_or(Problem::BadWordValue { letter: 'P', value: number })?;
    let rounds = exec.word(b'L').unwrap_or(1.0);
    let rounds = whole(rounds).filter(|value| (0.0..=1e15).contains(value)).ok_or(Problem::BadWordValue { letter: 'L', value: rounds })?;
    *exec.jump = Some(Jump::Call { name: format!("{number}"), rounds: rounds as u64 });
    Ok(())
}

/// M99.
pub(crate) fn back(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    *exec.jump = Some(Jump::Return);
    Ok(())
}

/// M2 and M30: G54, G17, G90, G94, M48, M5, M9; the units stay.
pub(crate) fn end(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.load_system(1);
    exec.emit(CanonicalOp::SetXyRotation(exec.state.offsets.rotation_deg));
    if exec.state.plane != Plane::Xy {
        exec.state.plane = Plane::Xy;
        exec.emit(CanonicalOp::SelectPlane(Plane::Xy));
    }
    exec.state.absolute = true;
    exec.state.feed_mode = FeedMode::PerMinute;
    exec.emit(CanonicalOp::SetFeedMode { per_revolution: false });
    exec.set_feed(0.0, None);
    for (allowed, op) in
        [(exec.state.feed_override, CanonicalOp::FeedOverride(true)), (exec.state.speed_override, CanonicalOp::SpeedOverride(true))]
    {
        if !allowed {
            exec.emit(op);
        }
    }
    (exec.state.feed_override, exec.state.speed_override) = (true, true);
    exec.state.spindle.clockwise = None;
    exec.state.spindle.surface_limit = None;
    exec.emit(CanonicalOp::StopSpindle { spindle: 0 });
    exec.emit(CanonicalOp::SetSpindleMode { spindle: 0, highest: 0.0 });
    if exec.state.mist || exec.state.flood {
        exec.coolant_off();
    }
    exec.state.motion = crate::codes::rows().find(|row| row.group == Group::Motion && row.code.tenths == 10).map(|row| row.code);
    exec.state.ended = true;
    exec.emit(CanonicalOp::ProgramEnd);
    Ok(())
}
