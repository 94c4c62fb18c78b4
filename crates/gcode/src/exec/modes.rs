//! Modes: plane, units, distances, feed, path control.

use super::Exec;
use crate::code::Code;
use crate::ops::{CanonicalOp, PathControl, Plane, Units};
use crate::problem::Problem;
use crate::state::{FeedMode, convert};

/// G17 to G19.
pub(crate) fn plane(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let plane = match code.tenths {
        180 => Plane::Zx,
        190 => Plane::Yz,
        _ => Plane::Xy,
    };
    // The held move is offset in its own plane.
    if plane != exec.state.plane && exec.state.compensation.is_some() {
        return Err(Problem::Compensation {
            message: "the plane cannot change under cutter compensation",
        });
    }
    exec.state.plane = plane;
    exec.emit(CanonicalOp::SelectPlane(plane));
    Ok(())
}

/// G20 and G21: places and offsets stay where they are.
pub(crate) fn units(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let units = if code.tenths == 200 {
        Units::Inch
    } else {
        Units::Mm
    };
    // Emitted even if nothing changes, as LinuxCNC does.
    exec.emit(CanonicalOp::UseLengthUnits(units));
    let state = &mut *exec.state;
    if units != state.units {
        if state.compensation.is_some() {
            return Err(Problem::Compensation {
                message: "the units cannot change under cutter compensation",
            });
        }
        // F is carried out before the units change and was taken in the old ones.
        if exec.words.has(b'F') && state.feed_mode != FeedMode::InverseTime {
            exec.warnings.push(Problem::FeedBeforeUnits {
                code,
                unit: state.units.name(),
            });
        }
        exec.change_units(units);
    }
    Ok(())
}

/// G7 and G8.
pub(crate) fn diameter(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.diameter = code.tenths == 70;
    Ok(())
}

/// G90 and G91.
pub(crate) fn distance(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.absolute = code.tenths == 900;
    Ok(())
}

/// G90.1 and G91.1.
pub(crate) fn arc_distance(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.arc_absolute = code.tenths == 901;
    Ok(())
}

/// G93 to G95. Each of them forgets the feed rate, so that no F is taken for one of another kind.
pub(crate) fn feed_mode(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let mode = match code.tenths {
        930 => FeedMode::InverseTime,
        950 => FeedMode::PerRevolution,
        _ => FeedMode::PerMinute,
    };
    exec.set_feed_mode(mode);
    Ok(())
}

/// G80.
pub(crate) fn no_motion(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.state.motion = None;
    Ok(())
}

/// G61.
pub(crate) fn exact_path(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.set_path_control(PathControl::ExactPath);
    Ok(())
}

/// G61.1.
pub(crate) fn exact_stop(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.set_path_control(PathControl::ExactStop);
    Ok(())
}

/// G64: without P any deviation is allowed; P alone also merges short moves within it.
pub(crate) fn continuous(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let tolerance = exec.word(b'P').unwrap_or(0.0);
    // P bounds the deviation at corners, Q that of merged short moves.
    let merge = exec.word(b'Q').unwrap_or(tolerance);
    for (letter, value) in [('P', tolerance), ('Q', merge)] {
        if value < 0.0 {
            return Err(Problem::WordOutOfRange {
                code,
                letter,
                value,
                allowed: "zero or more",
            });
        }
    }
    exec.set_path_control(PathControl::Continuous { tolerance });
    exec.state.merge_tolerance = merge;
    exec.emit(CanonicalOp::SetNaiveCamTolerance(merge));
    Ok(())
}

impl Exec<'_> {
    /// Puts what has lengths into other units; the machine stays where it is.
    pub(crate) fn change_units(&mut self, units: Units) {
        let state = &mut *self.state;
        let from = state.units;
        for position in [
            &mut state.current,
            &mut state.offsets.g5x,
            &mut state.offsets.g92,
            &mut state.offsets.tool,
        ] {
            *position = convert(position, from, units);
        }
        state.offsets.tilt = state.offsets.tilt.map(|tilt| tilt.convert(from, units));
        state.units = units;
    }

    /// Puts a feed mode into force.
    pub(crate) fn set_feed_mode(&mut self, mode: FeedMode) {
        self.state.feed_mode = mode;
        self.emit(CanonicalOp::SetFeedMode {
            per_revolution: mode == FeedMode::PerRevolution,
        });
        // In inverse time each move brings its own F.
        if mode != FeedMode::InverseTime {
            self.set_feed(0.0, None);
        }
    }

    pub(crate) fn set_path_control(&mut self, control: PathControl) {
        self.state.path_control = control;
        self.emit(CanonicalOp::SetMotionControlMode(control));
    }
}
