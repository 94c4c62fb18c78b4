//! The program as a stream of motion, with the plane in force.

use crate::error::SimError;
use crate::machine::Machine;
use crate::options::SimulateOptions;
use crate::source::ProgramSource;
use lostmotion_base::Coords;
use lostmotion_gcode::{
    CanonicalOp, Diagnostics, InterpreterConfig, MotionFold, MotionItem, Plane, Problem, Program, Tool, ToolTable, Units,
};
use std::io::BufRead;

/// First parameters of the places of G28 and G30.
const HOMES: [u16; 2] = [5161, 5181];

/// Motion out of a program.
pub(crate) struct Reader {
    program: Program<Box<dyn BufRead + Send>>,
    fold: MotionFold,
    plane: Plane,
    bytes: u64,
}

impl Reader {
    pub(crate) fn new(source: &ProgramSource, machine: &Machine, options: &SimulateOptions) -> Result<Reader, SimError> {
        let read = |error| SimError::Read { name: source.name().to_owned(), source: error };
        source.len().map_err(read)?;
        let reader = source.open().map_err(read)?;
        let program = Program::new(reader, interpreter_config(machine, options));
        Ok(Reader { program, fold: MotionFold::new(machine.start()), plane: Plane::Xy, bytes: 0 })
    }

    /// The next motion and the plane in force. A problem in folding is the motion's own and does not end the program.
    pub(crate) fn next(&mut self) -> Option<Result<(MotionItem, Plane), (Problem, lostmotion_base::BlockRef)>> {
        for sourced in self.program.by_ref() {
            self.bytes = self.bytes.max(sourced.block.span.start);
            if let CanonicalOp::SelectPlane(plane) = sourced.op {
                self.plane = plane;
            }
            match self.fold.push(&sourced) {
                Ok(Some(item)) => return Some(Ok((item, self.plane))),
                Ok(None) => {}
                Err(problem) => return Some(Err((problem, sourced.block))),
            }
        }
        None
    }

    /// How far into the program it is, bytes.
    pub(crate) fn bytes_done(&self) -> u64 {
        self.bytes
    }

    /// What has been found.
    pub(crate) fn diagnostics(&self) -> &Diagnostics {
        self.program.diagnostics()
    }
}

/// The interpreter's settings for a machine: its tools, offsets, homes and place at the start.
pub fn interpreter_config(machine: &Machine, options: &SimulateOptions) -> InterpreterConfig {
    let mut config = InterpreterConfig {
        block_delete: options.block_delete,
        tool_table: options.tool_table.clone().or_else(|| tool_table(machine)),
        start: machine.start(),
        limits: options.limits.clone(),
        ..InterpreterConfig::default()
    };
    for (system, origin) in (1u8..).zip(machine.work_offsets()) {
        config = config.with_work_offset(system, origin);
    }
    for (first, home) in HOMES.into_iter().zip([machine.home_g28(), machine.home_g30()]) {
        config.parameters.extend((first..).zip(machine_units(&home)));
    }
    config
}

/// mm and degrees, as parameters hold them.
fn machine_units(coords: &Coords) -> [f64; 9] {
    let mut values = coords.0;
    for value in &mut values[3..6] {
        *value = lostmotion_base::units::deg(*value);
    }
    values
}

fn tool_table(machine: &Machine) -> Option<ToolTable> {
    if machine.tools().is_empty() {
        return None;
    }
    let mut table = ToolTable::default();
    for entry in machine.tools() {
        let mut offset = [0.0; 9];
        offset[2] = Units::Mm.convert(entry.length_mm, InterpreterConfig::default().machine_units);
        let number = entry.number as i32;
        table.insert(Tool { number, pocket: number, offset, diameter: entry.diameter_mm, ..Tool::default() });
    }
    Some(table)
}
