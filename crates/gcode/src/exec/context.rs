//! M70 to M73: modes saved for a subroutine, or for the main program, and brought back.

use super::Exec;
use crate::code::Code;
use crate::ops::CanonicalOp;
use crate::problem::Problem;
use crate::state::held::Saved;
use crate::state::{State, convert};

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
