//! Modes: plane, units, distances, feed, path control; saved for a subroutine or the main program and
//! brought back (M70 to M73).

use super::Exec;
use crate::codes::Code;
use crate::exec::cycles::is_canned;
use crate::ops::{CanonicalOp, PathControl, Plane, Units};
use crate::problem::Problem;
use crate::state::{FeedMode, Saved, State, convert};

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

/// G80. Fanuc and Haas have canned cycles in a group of their own (09), which leaves group 01 alone:
/// once the cycle has ended, the motion mode before it is in force again (B-63944EN, "Preparatory
/// Function": codes of group 01 are not affected by a code of a canned cycle). For LinuxCNC there is
/// no motion mode after G80.
pub(crate) fn no_motion(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.end_cycle();
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
    /// Ends a canned cycle, and with it rigid tapping.
    pub(crate) fn end_cycle(&mut self) {
        let state = &mut *self.state;
        state.rigid_tapping = false;
        if !self.config.dialect.is_fanuc() {
            state.motion = None;
        } else if state.motion.is_some_and(is_canned) {
            state.motion = state.before_cycle;
        }
    }

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

/// M70 and M73.
pub(crate) fn save(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    // Curves and corners in progress belong to the path, not to the modes.
    let modes = Some(Box::new(State {
        nurbs: None,
        corner: None,
        corner_exit: None,
        ..exec.state.clone()
    }));
    if let Some(level) = exec.saved.last_mut() {
        *level = Saved {
            modes,
            automatic: code.tenths == 730,
        };
    }
    Ok(())
}

/// M71: forgets the saved modes, if there are any.
pub(crate) fn forget(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    if let Some(level) = exec.saved.last_mut() {
        *level = Saved::default();
    }
    Ok(())
}

/// M72: brings the saved modes back.
pub(crate) fn bring_back(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let modes = exec
        .saved
        .last()
        .and_then(|level| level.modes.clone())
        .ok_or(Problem::NothingSaved { code })?;
    exec.restore(&modes)
}

impl Exec<'_> {
    /// Brings saved modes back. The motion mode, the position and the tool stay as they are; cutter
    /// compensation ends if it was off.
    pub(crate) fn restore(&mut self, saved: &State) -> Result<(), Problem> {
        // Compensation ends before anything that it forbids to change.
        if saved.compensation.is_none() {
            self.end_compensation()?;
        }
        // Units come before all values with lengths, which are then in the saved units.
        if self.state.units != saved.units {
            self.change_units(saved.units);
            self.emit(CanonicalOp::UseLengthUnits(saved.units));
        }
        if self.state.plane != saved.plane && self.state.compensation.is_none() {
            self.state.plane = saved.plane;
            self.emit(CanonicalOp::SelectPlane(saved.plane));
        }
        // The system's origin is read anew: the parameters may have changed meanwhile.
        if self.state.system != saved.system {
            self.load_system(saved.system);
            self.emit(CanonicalOp::SetXyRotation(self.state.offsets.rotation_deg));
        }
        // Operations are emitted only for what differs.
        let tool = convert(&saved.offsets.tool, saved.units, self.state.units);
        if self.state.offsets.tool != tool {
            self.apply_tool_offset(tool)?;
        }
        if (self.state.path_control, self.state.merge_tolerance)
            != (saved.path_control, saved.merge_tolerance)
        {
            self.set_path_control(saved.path_control);
            self.state.merge_tolerance = saved.merge_tolerance;
            self.emit(CanonicalOp::SetNaiveCamTolerance(saved.merge_tolerance));
        }
        self.restore_rates(saved);
        self.restore_switches(saved);
        let state = &mut *self.state;
        (state.absolute, state.arc_absolute) = (saved.absolute, saved.arc_absolute);
        (state.retract_to_start, state.diameter) = (saved.retract_to_start, saved.diameter);
        Ok(())
    }

    fn restore_rates(&mut self, saved: &State) {
        if self.state.feed_mode != saved.feed_mode {
            self.set_feed_mode(saved.feed_mode);
        }
        if self.state.feed != saved.feed {
            self.set_feed(saved.feed, None);
        }
        // Mode and speed come before the start, so that the spindle starts at its speed.
        let (now, then) = (self.state.spindle, saved.spindle);
        if now.surface_limit != then.surface_limit {
            self.emit(CanonicalOp::SetSpindleMode {
                spindle: 0,
                highest: then.surface_limit.unwrap_or(0.0),
            });
        }
        if now.speed != then.speed {
            self.emit(CanonicalOp::SetSpindleSpeed {
                spindle: 0,
                speed: then.speed,
            });
        }
        match then.clockwise {
            turns if turns == now.clockwise => {}
            Some(clockwise) => self.emit(CanonicalOp::StartSpindle {
                spindle: 0,
                clockwise,
            }),
            None => self.emit(CanonicalOp::StopSpindle { spindle: 0 }),
        }
        self.state.spindle = then;
    }

    fn restore_switches(&mut self, saved: &State) {
        // Each switch: its place in the state, the saved value, the operation that sets it.
        type Switch = (fn(&mut State) -> &mut bool, bool, fn(bool) -> CanonicalOp);
        let switches: [Switch; 6] = [
            (|state| &mut state.mist, saved.mist, CanonicalOp::Mist),
            (|state| &mut state.flood, saved.flood, CanonicalOp::Flood),
            (
                |state| &mut state.feed_override,
                saved.feed_override,
                CanonicalOp::FeedOverride,
            ),
            (
                |state| &mut state.speed_override,
                saved.speed_override,
                CanonicalOp::SpeedOverride,
            ),
            (
                |state| &mut state.adaptive_feed,
                saved.adaptive_feed,
                CanonicalOp::AdaptiveFeed,
            ),
            (
                |state| &mut state.feed_hold,
                saved.feed_hold,
                CanonicalOp::FeedHold,
            ),
        ];
        for (slot, then, op) in switches {
            let now = slot(self.state);
            if *now != then {
                *now = then;
                self.emit(op(then));
            }
        }
    }
}
