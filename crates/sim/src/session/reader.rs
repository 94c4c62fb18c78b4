//! The program as a stream of motion, with the plane in force.

use crate::error::SimError;
use crate::machine::Machine;
use crate::options::SimulateOptions;
use crate::source::ProgramSource;
use lostmotion_base::{BlockRef, Coords};
use lostmotion_gcode::{
    CanonicalOp, Diagnostics, InterpreterConfig, MotionFold, MotionItem, Plane, Problem, Program, Tool, ToolTable, Units,
};
use std::collections::{BTreeMap, VecDeque};
use std::io::BufRead;
use std::sync::Arc;

/// First parameters of the places of G28 and G30.
const HOMES: [u16; 2] = [5161, 5181];

/// Motion out of a program.
pub(crate) struct Reader {
    program: Program<Box<dyn BufRead + Send>>,
    fold: MotionFold,
    /// What the last operation has made the machine do, and the plane in force.
    pending: VecDeque<MotionItem>,
    plane: Plane,
    /// The first move that follows the spindle.
    synchronised: Option<BlockRef>,
    /// Whether each spindle that turns does so clockwise, and how often any has changed that.
    spindles: BTreeMap<u8, bool>,
    spindle_events: u64,
    bytes: u64,
}

impl Reader {
    pub(crate) fn new(source: &ProgramSource, machine: &Machine, options: &SimulateOptions) -> Result<Reader, SimError> {
        let read = |error| SimError::Read { name: source.name().to_owned(), source: error };
        source.len().map_err(read)?;
        let reader = source.open().map_err(read)?;
        let mut program = Program::new(reader, interpreter_config(machine, options));
        if let Some(loader) = &options.loader {
            program = program.with_loader(Arc::clone(loader));
        }
        let fold = MotionFold::new(machine.start()).with_spline_tolerance_mm(options.spline_tolerance_mm);
        Ok(Reader {
            program,
            fold,
            pending: VecDeque::new(),
            plane: Plane::Xy,
            synchronised: None,
            spindles: BTreeMap::new(),
            spindle_events: 0,
            bytes: 0,
        })
    }

    /// The next motion and the plane in force. A problem in folding is the motion's own and does not end the program.
    pub(crate) fn next(&mut self) -> Option<Result<(MotionItem, Plane), (Problem, lostmotion_base::BlockRef)>> {
        loop {
            if let Some(item) = self.pending.pop_front() {
                return Some(Ok((item, self.plane)));
            }
            let sourced = self.program.next()?;
            if sourced.block.span.file == 0 {
                self.bytes = self.bytes.max(sourced.block.span.start);
            }
            match sourced.op {
                CanonicalOp::SelectPlane(plane) => self.plane = plane,
                CanonicalOp::StartSpeedFeedSync(_) => self.synchronised = self.synchronised.or(Some(sourced.block)),
                CanonicalOp::StartSpindle { spindle, clockwise } => self.turn(spindle, Some(clockwise)),
                CanonicalOp::StopSpindle { spindle } => self.turn(spindle, None),
                _ => {}
            }
            if let Err(problem) = self.fold.push_all(&sourced, &mut self.pending) {
                return Some(Err((problem, sourced.block)));
            }
        }
    }

    /// The first move that follows the spindle, if there has been one.
    pub(crate) fn synchronised(&self) -> Option<BlockRef> {
        self.synchronised
    }

    fn turn(&mut self, spindle: u8, clockwise: Option<bool>) {
        let before = match clockwise {
            Some(clockwise) => self.spindles.insert(spindle, clockwise),
            None => self.spindles.remove(&spindle),
        };
        self.spindle_events += u64::from(before != clockwise);
    }

    /// How often the spindle has been told to start, stop or turn round.
    pub(crate) fn spindle_events(&self) -> u64 {
        self.spindle_events
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
    let dialect = options.dialect.unwrap_or(machine.dialect());
    let mut config = InterpreterConfig {
        dialect,
        leniencies: options.leniencies.unwrap_or(dialect.leniencies()),
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
