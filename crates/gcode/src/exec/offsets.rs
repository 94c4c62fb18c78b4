//! Work coordinate systems (G54 to G59.3, G52, G92) and G10.

use super::Exec;
use crate::codes::{Code, whole};
use crate::dialect::Leniency;
use crate::exec::registers::extra_system;
use crate::exec::words::whole_within;
use crate::ops::{CanonicalOp, Position};
use crate::parameters::{G92, G92_ACTIVE, SYSTEM, system_parameter};
use crate::problem::Problem;
use crate::state::{Offsets, convert, rotate, subtract};
use crate::tool_table::{Tool, ToolTable};

/// G54 to G59.3: selects a work coordinate system.
pub(crate) fn select(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    // G54 to G59 are systems 1 to 6, G59.1 to G59.3 are 7 to 9; P of G54.1 and G154 goes on.
    let system = match code.tenths {
        541 | 1540 => extra_system(exec, code)?,
        591..=593 => code.tenths - 590 + 6,
        tenths => (tenths - 540) / 10 + 1,
    };
    exec.note_extra_system(system);
    if system != exec.state.system {
        exec.load_system(system);
        exec.emit(CanonicalOp::SetG92Offset(exec.state.offsets.g92));
        exec.emit(CanonicalOp::SetXyRotation(exec.state.offsets.rotation_deg));
    }
    Ok(())
}

impl Exec<'_> {
    /// Puts a coordinate system into force as its parameters describe it.
    pub(crate) fn load_system(&mut self, system: u16) {
        // Origin and rotation as the parameters have them, which are in machine units.
        let first = system_parameter(system);
        let origin = convert(
            &self.stored_origin(system),
            self.config.machine_units,
            self.state.units,
        );
        let rotation = self.parameters.get(first + 9);
        // The machine stays where it is; its program coordinates change.
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

    /// Puts a G52 shift into force and remembers it.
    pub(crate) fn put_shift(&mut self, shift: Position) {
        self.apply_g92(shift);
        self.remember_g92();
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
            // The offset grows by what the present place is to lose.
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

/// G92.1: forgets the G92 offset and its parameters.
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

/// The system that L11 measures tools in: G59.3.
const FIXTURE_SYSTEM: u16 = 9;

/// G10: data of tools (L1, L10, L11) and of coordinate systems (L2, L20).
pub(crate) fn g10(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let selector = exec.need(b'L', code, "L, what it sets")?;
    let number = exec.need(b'P', code, "P, the coordinate system or tool")?;
    // With axis words, L10 and L11 are LinuxCNC's measurements, without them Fanuc's memories.
    let is_control = exec.config.dialect.is_fanuc()
        || exec.config.leniencies.has(Leniency::ToolMemory)
            && matches!(whole(selector), Some(10.0..=13.0));
    if is_control && let Some(result) = exec.control_data(code, selector, number) {
        return result;
    }
    match whole(selector) {
        Some(2.0) => exec.set_system(code, number, false),
        Some(20.0) => exec.set_system(code, number, true),
        Some(1.0) => exec.set_tool(code, number, |exec, tool| exec.with_axis_words(&tool)),
        Some(10.0) => exec.set_tool(code, number, |exec, tool| {
            let offsets = exec.state.offsets;
            exec.measured(&tool, &offsets)
        }),
        Some(11.0) => exec.set_tool(code, number, |exec, tool| {
            let origin = exec.system_offsets(FIXTURE_SYSTEM);
            exec.measured(
                &tool,
                &Offsets {
                    g92: [0.0; 9],
                    ..origin
                },
            )
        }),
        _ => Err(Problem::WordOutOfRange {
            code,
            letter: 'L',
            value: selector,
            allowed: "1, 2, 10, 11 or 20",
        }),
    }
}

impl Exec<'_> {
    /// The offsets that a system would have if it were in force; the tool is none.
    fn system_offsets(&self, system: u16) -> Offsets {
        let first = system_parameter(system);
        let g5x = convert(
            &self.parameters.position(first),
            self.config.machine_units,
            self.state.units,
        );
        Offsets {
            g5x,
            g92: self.state.offsets.g92,
            tool: [0.0; 9],
            rotation_deg: self.parameters.get(first + 9),
            tilt: None,
        }
    }

    /// L2 gives the origin, L20 the coordinates that the present place is to have.
    fn set_system(&mut self, code: Code, number: f64, from_place: bool) -> Result<(), Problem> {
        // P0 is the system in force.
        let system = match whole(number).filter(|number| (0.0..=9.0).contains(number)) {
            Some(0.0) => self.state.system,
            Some(number) => number as u16,
            None => {
                return Err(Problem::WordOutOfRange {
                    code,
                    letter: 'P',
                    value: number,
                    allowed: "a system from 0 to 9",
                });
            }
        };
        // These belong to tools: a mistaken L would otherwise go unnoticed.
        for letter in *b"IJQ" {
            if let Some(value) = self.word(letter) {
                return Err(Problem::UnusedWord {
                    letter: char::from(letter),
                    value,
                    users: "G10 L1, L10 and L11".to_owned(),
                });
            }
        }
        let mut offsets = self.system_offsets(system);
        // L2 may set the rotation with R; L20 keeps it, and R is refused there as in LinuxCNC.
        if let Some(value) = self.word(b'R').filter(|_| from_place) {
            return Err(Problem::UnusedWord {
                letter: 'R',
                value,
                users: "G10 L2, which sets the rotation".to_owned(),
            });
        }
        offsets.rotation_deg = self.word(b'R').unwrap_or(offsets.rotation_deg);
        if from_place {
            let place = subtract(&self.state.machine(), &self.state.offsets.tool);
            let wanted = self.with_axis_words(&offsets.to_program(&place));
            // L20: the origin is the present place minus where the wanted coordinates lead without
            // an origin.
            offsets.g5x = [0.0; 9];
            offsets.g5x = subtract(&place, &offsets.to_machine(&wanted));
        } else {
            offsets.g5x = self.with_axis_words(&offsets.g5x);
        }
        self.check_target(&offsets.g5x)?;
        self.store_system(system, &offsets);
        Ok(())
    }

    fn store_system(&mut self, system: u16, offsets: &Offsets) {
        let first = system_parameter(system);
        let stored = convert(&offsets.g5x, self.state.units, self.config.machine_units);
        self.parameters.put_position(first, &stored);
        self.parameters.put(first + 9, offsets.rotation_deg);
        // The system in force takes effect at once.
        if system == self.state.system {
            self.load_system(system);
            self.emit(CanonicalOp::SetXyRotation(self.state.offsets.rotation_deg));
        }
    }

    /// The tool offset with which the present place would have the coordinates that the block
    /// names.
    fn measured(&self, tool: &Position, offsets: &Offsets) -> Position {
        let without = Offsets {
            tool: [0.0; 9],
            ..*offsets
        };
        // The present place in program coordinates without the tool.
        let mut place = subtract(&self.state.machine(), &without.g5x);
        rotate(&mut place, -without.rotation_deg);
        let here = subtract(&subtract(&place, &without.g92), tool);
        // What the tool's offset has to add so that the block's coordinates come out, turned back
        // into the machine's axes.
        let mut change = subtract(&here, &self.with_axis_words(&here));
        rotate(&mut change, without.rotation_deg);
        std::array::from_fn(|axis| tool[axis] + change[axis])
    }

    /// Changes a tool's offset, radius (R), angles (I, J) and orientation (Q). In force with the
    /// next G43.
    fn set_tool(
        &mut self,
        code: Code,
        number: f64,
        offset: impl FnOnce(&Self, Position) -> Position,
    ) -> Result<(), Problem> {
        let number = whole_within((code, b'P'), number, 1.0..1e9, "a tool number")? as i32;
        let known = self
            .tools
            .as_ref()
            .and_then(|table| table.get(number))
            .copied();
        // With a table only its tools exist; without one a tool is made.
        if known.is_none() && self.tools.is_some() {
            return Err(Problem::NoSuchTool {
                tool: i64::from(number),
            });
        }
        let mut tool = known.unwrap_or(Tool {
            number,
            ..Tool::default()
        });
        // Offsets are computed in program units and stored in machine units.
        let (program, machine) = (self.state.units, self.config.machine_units);
        let changed = offset(self, convert(&tool.offset, machine, program));
        self.check_target(&changed)?;
        tool.offset = convert(&changed, program, machine);
        tool.diameter = self.word(b'R').map_or(tool.diameter, |radius| {
            2.0 * program.convert(radius, machine)
        });
        tool.front_angle = self.word(b'I').unwrap_or(tool.front_angle);
        tool.back_angle = self.word(b'J').unwrap_or(tool.back_angle);
        if let Some(value) = self.word(b'Q') {
            tool.orientation =
                whole_within((code, b'Q'), value, 0.0..=9.0, "an orientation from 0 to 9")? as i32;
        }
        self.tools
            .get_or_insert_with(ToolTable::default)
            .insert(tool);
        Ok(())
    }
}
