//! G43.4, G43.5, G53.1, G68, G68.2, G69: five-axis words of other controls.

use super::Exec;
use crate::code::Code;
use crate::ops::Tilt;
use crate::ops::{CanonicalOp, Plane};
use crate::problem::Problem;
use crate::state::TipControl;
use lostmotion_base::math;

fn failed(message: &'static str) -> Problem {
    Problem::FiveAxis { message }
}

/// G43.4 and G43.5: the tool offset of H, and X Y Z are the tip, whatever the rotary axes do.
pub(crate) fn tip(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    if exec.state.plane != Plane::Xy {
        return Err(failed("tool-centre-point control needs the XY plane (G17)"));
    }
    // Tip control needs the tool's length: it is applied first.
    super::tool::length(exec, code)?;
    // G43.5 also takes the direction of the tool from I, J and K.
    exec.state.tip_control = if code.tenths == 435 {
        TipControl::WithVector
    } else {
        TipControl::On
    };
    exec.emit(CanonicalOp::ToolTipControl(true));
    Ok(())
}

/// G68: X Y is the centre, R the angle.
pub(crate) fn rotate(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.no_tilt_yet()?;
    if exec.state.plane != Plane::Xy {
        return Err(failed(
            "coordinates can only be turned in the XY plane (G17)",
        ));
    }
    let degrees = exec.need(b'R', code, "R, the angle")?;
    let center = [0, 1].map(|axis| exec.axis_word(axis).unwrap_or(exec.state.current[axis]));
    exec.set_tilt(Some(Tilt::in_plane(center, degrees)))
}

/// G68.2: X Y Z is the origin, I J K the Euler angles (Z, X, Z).
pub(crate) fn tilt(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.no_tilt_yet()?;
    if exec.state.tip_control != TipControl::Off {
        return Err(failed(
            "a tilted plane cannot begin under tool-centre-point control (G49 comes first)",
        ));
    }
    // Words that are missing are zero: origin at the program's zero, no rotation.
    let origin = [0, 1, 2].map(|axis| exec.axis_word(axis).unwrap_or(0.0));
    let euler = [b'I', b'J', b'K'].map(|letter| exec.word(letter).unwrap_or(0.0));
    exec.set_tilt(Some(Tilt::in_space(origin, euler)))
}

/// G69: ends the turned coordinates.
pub(crate) fn untilt(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.set_tilt(None)
}

/// G53.1: the rotary axes turn so that the tool stands upright on the tilted plane.
pub(crate) fn orient(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    let Some(tilt) = exec.state.offsets.tilt else {
        return Err(failed("G53.1 needs a tilted plane (G68.2) before it"));
    };
    // The third column of the rotation is the plane's normal in program coordinates.
    let axis = tilt.rows.map(|row| row[2]);
    exec.emit(CanonicalOp::OrientTool(axis));
    Ok(())
}

impl Exec<'_> {
    fn no_tilt_yet(&self) -> Result<(), Problem> {
        if self.state.compensation.is_some() {
            return Err(Problem::Compensation {
                message: "the coordinates cannot turn under cutter compensation",
            });
        }
        if self.state.offsets.tilt.is_some() {
            Err(failed(
                "the coordinates are turned already (G69 comes first)",
            ))
        } else {
            Ok(())
        }
    }

    pub(crate) fn set_tilt(&mut self, tilt: Option<Tilt>) -> Result<(), Problem> {
        if self.state.offsets.tilt == tilt {
            return Ok(());
        }
        self.state.rebase(|offsets| offsets.tilt = tilt);
        self.emit(CanonicalOp::SetTilt(tilt.map(Box::new)));
        self.check_target(&self.state.current)
    }

    /// Leaves tool-centre-point control.
    pub(crate) fn end_tip_control(&mut self) {
        if self.state.tip_control != TipControl::Off {
            self.state.tip_control = TipControl::Off;
            self.emit(CanonicalOp::ToolTipControl(false));
        }
    }

    /// I J K of a straight move under G43.5.
    pub(crate) fn tool_vector(&mut self) -> Result<(), Problem> {
        let named = [b'I', b'J', b'K'].map(|letter| self.word(letter));
        if named.iter().all(Option::is_none) {
            return Ok(());
        }
        let [i, j, k] = named.map(Option::unwrap_or_default);
        // A direction: only the ratio of I, J and K counts.
        let length = math::hypot(math::hypot(i, j), k);
        if length == 0.0 {
            return Err(failed("the direction of the tool (I, J, K) has no length"));
        }
        self.emit(CanonicalOp::OrientTool([
            i / length,
            j / length,
            k / length,
        ]));
        Ok(())
    }
}
