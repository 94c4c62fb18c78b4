//! Stops and ends (M0, M1, M60, M2, M30), calls and returns (M98, M99).

use super::{Exec, Jump};
use crate::codes::{Code, Group, users, whole};
use crate::dialect::Leniency;
use crate::ops::{CanonicalOp, Plane};
use crate::problem::Problem;
use crate::state::FeedMode;

/// M0.
pub(crate) fn stop(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.emit(CanonicalOp::ProgramStop);
    Ok(())
}

impl Exec<'_> {
    /// A stop that is not a code of the block.
    pub(crate) fn stop_program(&mut self) -> Result<(), Problem> {
        // The operator sees the tool where the held move ends.
        if self.state.compensation.is_some() {
            self.under_compensation(Code::m(0))?;
        }
        self.emit(CanonicalOp::ProgramStop);
        Ok(())
    }
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
    let number = whole(number)
        .filter(|value| *value >= 0.0)
        .ok_or(Problem::BadWordValue {
            letter: 'P',
            value: number,
        })?;
    // L0 is no call at all.
    let rounds = exec.word(b'L').unwrap_or(1.0);
    let rounds = whole(rounds)
        .filter(|value| (0.0..=1e15).contains(value))
        .ok_or(Problem::BadWordValue {
            letter: 'L',
            value: rounds,
        })?;
    *exec.jump = Some(Jump::Call {
        name: format!("{number}"),
        rounds: rounds as u64,
    });
    Ok(())
}

/// M99; with P, which Fanuc has, to a line of the caller, or of the main program itself.
pub(crate) fn back(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    // M99 alone returns behind the call.
    let Some(value) = exec.word(b'P') else {
        *exec.jump = Some(Jump::Return);
        return Ok(());
    };
    if !exec.config.leniencies.has(Leniency::PackedCalls) {
        return Err(Problem::UnusedWord {
            letter: 'P',
            value,
            users: users('P'),
        });
    }
    exec.warnings.push(Problem::Lenient {
        leniency: Leniency::PackedCalls,
    });
    *exec.jump = Some(Jump::ReturnTo { line: value });
    Ok(())
}

/// M2 and M30: G54, G17, G90, G94, M48, M5, M9; the units stay.
pub(crate) fn end(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.end_program()
}

impl Exec<'_> {
    pub(crate) fn end_program(&mut self) -> Result<(), Problem> {
        // What shifts or turns the coordinates ends first.
        self.end_compensation()?;
        self.state.arc_not_allowed = false;
        self.end_tip_control();
        self.set_tilt(None)?;
        self.load_system(1);
        self.emit(CanonicalOp::SetXyRotation(self.state.offsets.rotation_deg));
        if self.state.plane != Plane::Xy {
            self.state.plane = Plane::Xy;
            self.emit(CanonicalOp::SelectPlane(Plane::Xy));
        }
        self.state.absolute = true;
        self.state.feed_mode = FeedMode::PerMinute;
        self.emit(CanonicalOp::SetFeedMode {
            per_revolution: false,
        });
        self.set_feed(0.0, None);
        // Overrides are allowed again; spindles stop, coolant goes off.
        for (allowed, op) in [
            (self.state.feed_override, CanonicalOp::FeedOverride(true)),
            (self.state.speed_override, CanonicalOp::SpeedOverride(true)),
        ] {
            if !allowed {
                self.emit(op);
            }
        }
        (self.state.feed_override, self.state.speed_override) = (true, true);
        self.state.spindle.clockwise = None;
        self.state.spindle.surface_limit = None;
        for number in 1..=self.state.more_spindles.len() as u8 {
            // Further spindles are stopped only if they turn: most machines have one.
            let turned = std::mem::take(self.spindle_state(number))
                .clockwise
                .is_some();
            if turned {
                self.emit(CanonicalOp::StopSpindle { spindle: number });
            }
        }
        self.emit(CanonicalOp::StopSpindle { spindle: 0 });
        self.emit(CanonicalOp::SetSpindleMode {
            spindle: 0,
            highest: 0.0,
        });
        if self.state.mist || self.state.flood {
            self.coolant_off();
        }
        // The motion mode after the end is G1, as LinuxCNC leaves it.
        self.state.motion = crate::codes::rows()
            .find(|row| row.group == Group::Motion && row.code.tenths == 10)
            .map(|row| row.code);
        self.state.ended = true;
        self.emit(CanonicalOp::ProgramEnd);
        Ok(())
    }
}
