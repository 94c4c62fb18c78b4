//! The registers of Fanuc and Haas: work offsets and tool memories by G10 and by system variables,
//! systems beyond G59.
//!
//! G10 under G91 adds to what is there (B-63944EN, "Programmable Data Input"; Haas, G10). L2 P0 is
//! the external offset of Fanuc, which shifts all systems, and the shift of G52 at Haas. L20 P is
//! G54.1 P or G154 P. L10 and L11 are geometry and wear of a length, L12 and L13 those of a radius
//! (Fanuc) or diameter (Haas, Setting 40); L1 is L11 of older programs.

use super::Exec;
use super::words::whole_within;
use crate::codes::{Code, whole};
use crate::config::InterpreterConfig;
use crate::dialect::{Dialect, Leniency};
use crate::ops::{CanonicalOp, Position};
use crate::parameters::control::{
    EXTERNAL_ORIGIN, EXTRA_SYSTEM, FIRST_EXTRA, cell_factor, extra_systems,
};
use crate::parameters::{Parameters, system_parameter};
use crate::problem::Problem;
use crate::state::{convert, is_angle};
use crate::tool_table::{MemoryCell, ToolTable};

const SYSTEMS_OF_L2: &str = "a system from 0 to 6";

/// The system of a G54.1 or G154: its P counts from 1.
pub(crate) fn extra_system(exec: &Exec<'_>, code: Code) -> Result<u16, Problem> {
    let number = exec.word(b'P').unwrap_or(1.0);
    let (most, allowed) = match exec.config.dialect {
        Dialect::Haas => (extra_systems(Dialect::Haas).0, "a system from 1 to 99"),
        dialect => (extra_systems(dialect).0, "a system from 1 to 300"),
    };
    let number = whole_within((code, b'P'), number, 1.0..=f64::from(most), allowed)?;
    Ok(FIRST_EXTRA - 1 + number as u16)
}

/// The origin of a system in machine units, with Fanuc's external offset.
pub(crate) fn origin(parameters: &Parameters, config: &InterpreterConfig, system: u16) -> Position {
    let mut origin = parameters.position(system_parameter(system));
    if config.dialect == Dialect::Fanuc {
        let external = parameters.position(EXTERNAL_ORIGIN);
        // The ninth place is that of another parameter: no control has so many axes.
        for (coordinate, more) in origin.iter_mut().zip(external).take(8) {
            *coordinate += more;
        }
    }
    origin
}

impl Exec<'_> {
    /// The origin of a system in machine units.
    pub(crate) fn stored_origin(&self, system: u16) -> Position {
        origin(self.parameters, self.config, system)
    }

    /// G10 as Fanuc and Haas mean it; `None` for what they share with RS274/NGC.
    pub(crate) fn control_data(
        &mut self,
        code: Code,
        selector: f64,
        number: f64,
    ) -> Option<Result<(), Problem>> {
        let axes = (0..9).any(|axis| self.axis_word(axis).is_some());
        let memory = self.config.leniencies.has(Leniency::ToolMemory) && !axes;
        match whole(selector)? {
            2.0 => Some(self.set_origin(code, number)),
            20.0 => Some(self.set_extra_origin(code)),
            selector @ (1.0 | 10.0..=13.0) if memory => {
                Some(self.set_memory(code, selector, number))
            }
            _ => None,
        }
    }

    /// G10 L2.
    fn set_origin(&mut self, code: Code, number: f64) -> Result<(), Problem> {
        let system = whole_within((code, b'P'), number, 0.0..=6.0, SYSTEMS_OF_L2)? as u16;
        if system == 0 && self.config.dialect == Dialect::Haas {
            return self.set_shift(Self::given);
        }
        self.write_origin(system)
    }

    /// G10 L20.
    fn set_extra_origin(&mut self, code: Code) -> Result<(), Problem> {
        let leniency = Leniency::ExtraSystems;
        if !self.config.leniencies.has(leniency) {
            return Err(Problem::NotLenient { leniency });
        }
        self.warnings.push(Problem::Lenient { leniency });
        let system = extra_system(self, code)?;
        self.write_origin(system)
    }

    /// What the axis words of a G10 make of a value: in its place, or added to it under G91.
    fn given(&self, axis: usize, now: f64) -> f64 {
        match self.axis_word(axis) {
            Some(value) if self.state.absolute => value,
            Some(value) => now + value,
            None => now,
        }
    }

    /// Puts the axis words into an origin; 0 is the external one.
    fn write_origin(&mut self, system: u16) -> Result<(), Problem> {
        let first = first_of(system);
        let (program, machine) = (self.state.units, self.config.machine_units);
        let now = convert(&self.parameters.position(first), machine, program);
        let origin: Position = std::array::from_fn(|axis| self.given(axis, now[axis]));
        self.check_target(&origin)?;
        let stored = convert(&origin, program, machine);
        // The external offset has eight places: the ninth is that of another parameter.
        let axes = if system == 0 { 8 } else { 9 };
        for (axis, value) in stored.into_iter().enumerate().take(axes) {
            self.parameters.put(first + axis as u16, value);
        }
        self.reload(system);
        Ok(())
    }

    /// Brings a changed origin into force, if it is that of the system in force or of all.
    fn reload(&mut self, system: u16) {
        if system == 0 || system == self.state.system {
            self.load_system(self.state.system);
            self.emit(CanonicalOp::SetXyRotation(self.state.offsets.rotation_deg));
        }
    }

    /// Changes the shift of G52 axis by axis.
    fn set_shift(&mut self, change: impl Fn(&Self, usize, f64) -> f64) -> Result<(), Problem> {
        let now = self.state.offsets.g92;
        let shift: Position = std::array::from_fn(|axis| change(self, axis, now[axis]));
        self.check_target(&shift)?;
        self.put_shift(shift);
        Ok(())
    }

    /// A program's setting of a system variable that is an origin.
    pub(crate) fn assign_origin(
        &mut self,
        system: u16,
        axis: usize,
        value: f64,
    ) -> Result<(), Problem> {
        self.refuse_change()?;
        let mut target = [0.0; 9];
        target[axis] = value;
        self.check_target(&target)?;
        let stored = if is_angle(axis) {
            value
        } else {
            self.state.units.convert(value, self.config.machine_units)
        };
        self.parameters.put(first_of(system) + axis as u16, stored);
        self.reload(system);
        Ok(())
    }

    /// A program's setting of a system variable that is the shift of G52.
    pub(crate) fn assign_shift(&mut self, axis: usize, value: f64) -> Result<(), Problem> {
        self.refuse_change()?;
        self.set_shift(|_, at, now| if at == axis { value } else { now })
    }

    /// The held move of cutter compensation is in the coordinates of its block.
    fn refuse_change(&self) -> Result<(), Problem> {
        if self.state.compensation.is_some() {
            return Err(Problem::Compensation {
                message: "the coordinate system cannot change under cutter compensation",
            });
        }
        Ok(())
    }

    /// A tool memory by G10: in place of what is there, or added to it under G91.
    fn set_memory(&mut self, code: Code, memory: f64, number: f64) -> Result<(), Problem> {
        let value = self.need(b'R', code, "R, the value of the tool memory")?;
        self.warnings.push(Problem::Lenient {
            leniency: Leniency::ToolMemory,
        });
        let number = whole_within((code, b'P'), number, 1.0..1e9, "a tool number")? as i32;
        let cell = match memory as u8 {
            10 => MemoryCell::Length,
            12 => MemoryCell::Diameter,
            13 => MemoryCell::DiameterWear,
            _ => MemoryCell::LengthWear,
        };
        self.assign_memory(cell, number, value, !self.state.absolute);
        Ok(())
    }

    /// Puts a value in program units into a tool memory, or adds it.
    pub(crate) fn assign_memory(&mut self, cell: MemoryCell, number: i32, value: f64, adds: bool) {
        let factor = cell_factor(self.config.dialect, cell);
        let is_diameter = matches!(cell, MemoryCell::Diameter | MemoryCell::DiameterWear);
        if is_diameter && self.config.dialect == Dialect::Haas {
            self.warnings
                .push(Problem::DiameterAssumed { offset: number });
        }
        let value = factor * self.state.units.convert(value, self.config.machine_units);
        let table = self.tools.get_or_insert_with(ToolTable::default);
        let now = table.memory(number, cell).filter(|_| adds).unwrap_or(0.0);
        table.set_memory(number, cell, now + value);
    }

    /// What #4130 shows after a system has been selected.
    pub(crate) fn note_extra_system(&mut self, system: u16) {
        let number = (system + 1).saturating_sub(FIRST_EXTRA);
        self.parameters.put(EXTRA_SYSTEM, f64::from(number));
    }
}

/// First parameter of an origin, 0 being the external one.
const fn first_of(system: u16) -> u16 {
    if system == 0 {
        EXTERNAL_ORIGIN
    } else {
        system_parameter(system)
    }
}
