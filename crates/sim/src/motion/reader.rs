//! The program as a stream of motion, with the plane in force.

use super::steer::{MotionFault, Read, Steering};
use crate::error::SimError;
use crate::machine::Machine;
use crate::options::SimulateOptions;
use crate::program::Operations;
use crate::setup::Setup;
use lostmotion_base::{BlockRef, Coords};
use lostmotion_gcode::{
    CanonicalOp, Diagnostic, Diagnostics, InterpreterConfig, MotionFold, MotionItem, Plane,
    Problem, SourcedOp, Tool, ToolTable, Units,
};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// First parameters (RS274/NGC) that hold the places of G28 and G30.
const HOME_PARAMETERS: [u16; 2] = [5161, 5181];

/// Motion out of a program.
pub(crate) struct Reader {
    program: Operations,
    fold: MotionFold,
    steering: Steering,
    /// What the last operations have made the machine do, and the plane in force.
    pending: VecDeque<Read>,
    plane: Plane,
    /// Work coordinate system in force, from 1 for G54.
    system: u16,
    /// The first move that follows the spindle.
    synchronised: Option<BlockRef>,
    /// Whether each spindle that turns does so clockwise, and how often any has changed that.
    spindles: BTreeMap<u8, bool>,
    spindle_events: u64,
    bytes: u64,
}

impl Reader {
    pub(crate) fn new(setup: &Setup<'_>) -> Result<Reader, SimError> {
        let (machine, options) = (setup.machine, setup.options);
        setup
            .program
            .len()
            .map_err(|error| setup.unreadable(error))?;
        let mut program = setup
            .program
            .operations(interpreter_config(machine, options))
            .map_err(|error| setup.unreadable(error))?;
        if let Some(loader) = &options.loader {
            program = program.with_loader(Arc::clone(loader));
        }
        let fold =
            MotionFold::new(machine.start()).with_spline_tolerance_mm(options.spline_tolerance_mm);
        let steering = Steering::new(Arc::clone(&setup.kinematics), setup.tip_control);
        Ok(Reader {
            program,
            fold,
            steering,
            pending: VecDeque::new(),
            plane: Plane::Xy,
            system: 1,
            synchronised: None,
            spindles: BTreeMap::new(),
            spindle_events: 0,
            bytes: 0,
        })
    }

    /// The next motion. A problem in folding is the motion's own and does not end the program.
    pub(crate) fn next(&mut self) -> Option<Result<Read, (Problem, BlockRef)>> {
        loop {
            if let Some(read) = self.pending.pop_front() {
                return Some(Ok(read));
            }
            // At the end of the program moves may still wait for directions behind them.
            let Some(sourced) = self.program.next() else {
                match self.steering.flush(&mut self.fold, &mut self.pending) {
                    Ok(true) => continue,
                    Ok(false) => return None,
                    Err(MotionFault { problem, block }) => {
                        return Some(Err((problem, block.unwrap_or_default())));
                    }
                }
            };
            // Progress is measured in the main file; a loop's blocks lie before the farthest place
            // read.
            if sourced.block.span.file == 0 {
                self.bytes = self.bytes.max(sourced.block.span.start);
            }
            match sourced.op {
                // Modes that the fold does not keep, for the segments that follow.
                CanonicalOp::SelectPlane(plane) => self.plane = plane,
                CanonicalOp::SetG5xOffset { system, .. } => self.system = system,
                CanonicalOp::StartSpeedFeedSync(_) => {
                    self.synchronised = self.synchronised.or(Some(sourced.block));
                }
                CanonicalOp::StartSpindle { spindle, clockwise } => {
                    self.turn(spindle, Some(clockwise));
                }
                CanonicalOp::StopSpindle { spindle } => self.turn(spindle, None),
                _ => {}
            }
            if let Err(MotionFault { problem, block }) = self.take(&sourced) {
                return Some(Err((problem, block.unwrap_or(sourced.block))));
            }
        }
    }

    fn take(&mut self, sourced: &SourcedOp) -> Result<(), MotionFault> {
        let straight = matches!(
            sourced.op,
            CanonicalOp::StraightFeed(_) | CanonicalOp::StraightTraverse(_)
        );
        // Under G43.5 a straight move has a direction but no rotary words yet: it waits until those
        // behind it are known.
        if straight && self.steering.directs() {
            return match self.fold.push(sourced)? {
                Some(MotionItem::Move(motion)) => {
                    self.steering.hold(motion, self.plane, &mut self.pending)
                }
                _ => Ok(()),
            };
        }
        match sourced.op {
            CanonicalOp::ToolTipControl(on) => {
                self.flush()?;
                self.steering.program(on, &mut self.fold)?;
            }
            CanonicalOp::OrientTool(direction) if self.steering.steers() => {
                // G43.5 tells directions in the coordinates of the program, G53.1 in those of the
                // workpiece.
                let direction = if self.steering.follows_program() {
                    self.fold.turned(direction)
                } else {
                    direction
                };
                let turn = self
                    .steering
                    .orient(direction, &mut self.fold, sourced.block)?;
                let Some((item, tip)) = turn else {
                    return Ok(());
                };
                self.pending.push_back(Read {
                    item,
                    plane: self.plane,
                    tip,
                });
            }
            CanonicalOp::UseToolLengthOffset(_) if self.steering.steers() => {
                self.flush()?;
                // A new length offset must not move the machine: the joints are taken before and
                // restored after.
                let joints = self.steering.joints(&self.fold)?;
                self.fold.push(sourced)?;
                if !self.steering.stand(&joints, &mut self.fold) {
                    return Ok(());
                }
            }
            CanonicalOp::SetTilt(None) => {
                self.flush()?;
                self.fold.push(sourced)?;
                self.steering.level(&mut self.fold)?;
            }
            _ => {
                let mut items = Vec::new();
                self.fold.push_all(sourced, &mut items)?;
                // Moves that wait come before this one; operations without motion may overtake
                // them.
                if !items.is_empty() {
                    self.flush()?;
                }
                let (plane, tip) = (self.plane, self.steering.on);
                self.pending
                    .extend(items.into_iter().map(|item| Read { item, plane, tip }));
                return Ok(());
            }
        }
        // The interpreter works out later words from where the program now is.
        self.program.moved_to(self.fold.program_place());
        Ok(())
    }

    /// Hands over moves whose directions have waited for more.
    fn flush(&mut self) -> Result<(), MotionFault> {
        if self.steering.flush(&mut self.fold, &mut self.pending)? {
            self.program.moved_to(self.fold.program_place());
        }
        Ok(())
    }

    /// Work coordinate system in force, from 1 for G54.
    pub(crate) fn system(&self) -> u16 {
        self.system
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
        // Repeating M3 changes nothing and takes no time.
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

    /// The error that a problem with a motion is.
    pub(crate) fn refused(&self, name: &str, problem: Problem, place: BlockRef) -> SimError {
        let provenance = self.diagnostics().provenance().clone();
        let mut diagnostics = Diagnostics::new(1).with_provenance(provenance);
        diagnostics.push(Diagnostic { problem, place });
        SimError::Program {
            name: name.to_owned(),
            diagnostics: Box::new(diagnostics),
        }
    }

    /// What has been found.
    pub(crate) fn diagnostics(&self) -> &Diagnostics {
        self.program.diagnostics()
    }
}

/// The interpreter's settings for a machine: its tools, offsets, homes and place at the start.
pub fn interpreter_config(machine: &Machine, options: &SimulateOptions) -> InterpreterConfig {
    let dialect = options.dialect.unwrap_or(machine.dialect());
    let units = machine.control_units();
    let mut config = InterpreterConfig {
        machine_units: units,
        program_units: machine.program_units(),
        dialect,
        leniencies: options.leniencies.unwrap_or(dialect.leniencies()),
        block_delete: options.block_delete,
        block_skips: options.block_skips.clone(),
        m_codes: options.m_codes.clone(),
        told: options.told.clone(),
        tool_table: options.tool_table.clone().or_else(|| tool_table(machine)),
        start: machine.start(),
        limits: options.limits.clone(),
        ..InterpreterConfig::default()
    };
    for (system, origin) in (1u8..).zip(machine.work_offsets()) {
        config = config.with_work_offset(system, origin);
    }
    // Programs see the homes as parameters, nine numbers each.
    for (first, home) in HOME_PARAMETERS
        .into_iter()
        .zip([machine.home_g28(), machine.home_g30()])
    {
        config
            .parameters
            .extend((first..).zip(in_units(&home, units)));
    }
    config
}

/// Lengths in the control's units and degrees, as parameters hold them.
fn in_units(coords: &Coords, units: Units) -> [f64; 9] {
    let mut values = coords.0;
    for (index, value) in values.iter_mut().enumerate() {
        *value = if (3..6).contains(&index) {
            lostmotion_base::units::deg(*value)
        } else {
            Units::Mm.convert(*value, units)
        };
    }
    values
}

fn tool_table(machine: &Machine) -> Option<ToolTable> {
    // Without a table a program may name any tool.
    if machine.tools().is_empty() {
        return None;
    }
    let units = machine.control_units();
    let mut table = ToolTable::default();
    for entry in machine.tools() {
        let mut offset = [0.0; 9];
        offset[2] = Units::Mm.convert(entry.length_mm, units);
        // Machine files have no carousel: every tool stands in the pocket of its number.
        let number = entry.number as i32;
        table.insert(Tool {
            number,
            pocket: number,
            offset,
            diameter: Units::Mm.convert(entry.diameter_mm, units),
            ..Tool::default()
        });
    }
    Some(table)
}
