//! Work coordinate systems and the offsets of G92 and G52.

use super::Exec;
use crate::code::Code;
use crate::ops::{CanonicalOp, Position};
use crate::parameters::{G92, G92_ACTIVE, SYSTEM};
use crate::problem::Problem;
use crate::state::convert;

/// Parameters of G54 start here, those of the other systems 20 apart.
const FIRST_SYSTEM: u16 = 5221;

/// First parameter of a system, 1 to 9.
pub(crate) fn system_parameter(system: u8) -> u16 {
    FIRST_SYSTEM + 20 * (u16::from(system.max(1)) - 1)
}

/// G54 to G59.3.
pub(crate) fn select(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let system = if code.tenths > 590 {
        code.tenths - 590 + 6
    } else {
        (code.tenths - 540) / 10 + 1
    } as u8;
    if system != exec.state.system {
        exec.load_system(system);
        exec.emit(CanonicalOp::SetG92Offset(exec.state.offsets.g92));
        exec.emit(CanonicalOp::SetXyRotation(exec.state.offsets.rotation_deg));
    }
    Ok(())
}

impl Exec<'_> {
    /// Puts a coordinate system into force as its parameters describe it.
    pub(crate) fn load_system(&mut self, system: u8) {
        let first = system_parameter(system);
        let origin = convert(
            &self.parameters.position(first),
            self.config.machine_units,
            self.state.units,
        );
        let rotation = self.parameters.get(first + 9);
        self.state.rebase(|offsets| {
            offsets.g5x = origin;
            offsets.rotation_deg = rotation;
        });
        self.state.system = system;
        self.parameters.put(SYSTEM, f64::from(system));
        self.emit(CanonicalOp::SetG5xOffset {
            system,
            offset: origin,
        });
    }

    /// Puts a G92 offset into force.
    fn apply_g92(&mut self, offset: Position) {
        self.state.rebase(|offsets| offsets.g92 = offset);
        self.emit(CanonicalOp::SetG92Offset(offset));
    }

    fn remember_g92(&mut self) {
        let stored = convert(
            &self.state.offsets.g92,
            self.state.units,
            self.config.machine_units,
        );
        self.parameters.put_position(G92, &stored);
        self.parameters.put(G92_ACTIVE, 1.0);
    }
}

/// G92: the place where the tool is gets the given coordinates.
pub(crate) fn g92(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    let mut offset = exec.state.offsets.g92;
    for (axis, slot) in offset.iter_mut().enumerate() {
        if let Some(value) = exec.axis_word(axis) {
            *slot += exec.state.current[axis] - value;
        }
    }
    exec.check_target(&offset)?;
    exec.apply_g92(offset);
    // What the line says holds exactly, not to the rounding of the offsets.
    exec.state.current = exec.with_axis_words(&exec.state.current);
    exec.remember_g92();
    Ok(())
}

/// G52: the same offset, given directly.
pub(crate) fn local(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    let mut offset = exec.state.offsets.g92;
    for (axis, slot) in offset.iter_mut().enumerate() {
        *slot = exec.axis_word(axis).unwrap_or(*slot);
    }
    exec.check_target(&offset)?;
    exec.apply_g92(offset);
    exec.remember_g92();
    Ok(())
}

/// G92.1.
pub(crate) fn g92_forget(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.parameters.put_position(G92, &[0.0; 9]);
    g92_suspend(exec, code)
}

/// G92.2.
pub(crate) fn g92_suspend(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.apply_g92([0.0; 9]);
    exec.parameters.put(G92_ACTIVE, 0.0);
    Ok(())
}

/// G92.3.
pub(crate) fn g92_restore(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    let offset = convert(
        &exec.parameters.position(G92),
        exec.config.machine_units,
        exec.state.units,
    );
    exec.check_target(&offset)?;
    exec.apply_g92(offset);
    exec.parameters.put(G92_ACTIVE, 1.0);
    Ok(())
}
