//! The second pass: program in, samples of the plan out, with the programmed segments that they lie on.

use super::check::{kinematics, planner_config};
use super::lower::lower;
use super::reader::Reader;
use crate::error::SimError;
use crate::machine::Machine;
use crate::options::SimulateOptions;
use crate::source::ProgramSource;
use crate::time::what_if::Change;
use lostmotion_base::{BlockRef, Coords};
use lostmotion_contour::ProgrammedSegment;
use lostmotion_gcode::{Diagnostic, Diagnostics, MotionItem};
use lostmotion_kinematics::Kinematics;
use lostmotion_plan::{FeedLimit, Move, PlanItem, Planner, Sample};
use std::sync::Arc;

/// What was read, for those who want to know where time goes.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly all are moves")]
pub(crate) enum Note {
    /// A move with its running number.
    Move { index: u64, item: Move },
    /// A dwell after so many moves.
    Dwell { after: u64, seconds: f64, block: BlockRef },
    /// Another tool.
    ToolChange,
}

/// A program on its way through the planner.
pub(crate) struct Feed {
    name: String,
    reader: Reader,
    planner: Planner,
    kinematics: Arc<dyn Kinematics>,
    start_joints: Coords,
    segments: u64,
    change: Change,
    notes: Option<Vec<Note>>,
    over: bool,
    last: Option<Sample>,
}

impl Feed {
    pub(crate) fn new(source: &ProgramSource, machine: &Machine, options: &SimulateOptions) -> Result<Feed, SimError> {
        Feed::changed(source, machine, options, Change::NONE)
    }

    /// With notes of what is read.
    pub(crate) fn timed(source: &ProgramSource, machine: &Machine, options: &SimulateOptions) -> Result<Feed, SimError> {
        Ok(Feed { notes: Some(Vec::new()), ..Feed::new(source, machine, options)? })
    }

    /// On a machine, or of a program, with something changed.
    pub(crate) fn changed(source: &ProgramSource, machine: &Machine, options: &SimulateOptions, change: Change) -> Result<Feed, SimError> {
        let kinematics = kinematics(machine)?;
        let start = machine.start();
        Ok(Feed {
            name: source.name().to_owned(),
            reader: Reader::new(source, machine, options)?,
            planner: Planner::new(change.of_machine(planner_config(machine, options.quality)), Arc::clone(&kinematics), start)?,
            start_joints: kinematics.inverse(&start, &[0.0; 3])?,
            kinematics,
            segments: 0,
            change,
            notes: None,
            over: false,
            last: None,
        })
    }

    /// The next samples, at most so many, none at the end; and the segments that were read on the way.
    pub(crate) fn chunk(&mut self, most: usize, samples: &mut Vec<Sample>, segments: &mut Vec<ProgrammedSegment>) -> Result<(), SimError> {
        samples.clear();
        while samples.len() < most {
            let taken = self.planner.take(most - samples.len(), samples);
            if taken == 0 {
                if self.over {
                    break;
                }
                self.read(segments)?;
            }
        }
        self.last = samples.last().copied().or(self.last);
        Ok(())
    }

    /// Hands the planner one item more, or the end.
    fn read(&mut self, segments: &mut Vec<ProgrammedSegment>) -> Result<(), SimError> {
        let Some(item) = self.reader.next() else {
            self.over = true;
            return Ok(self.planner.finish()?);
        };
        let (item, in_force) = item.map_err(|(problem, place)| {
            let mut diagnostics = Diagnostics::new(1);
            diagnostics.push(Diagnostic { problem, place });
            SimError::Program { name: self.name.clone(), diagnostics: Box::new(diagnostics) }
        })?;
        let origin = if let MotionItem::Move(motion) = &item { motion.origin } else { Coords::ZERO };
        self.note_stop(&item);
        let Some(item) = lower(&item)?.map(|item| self.change.of_item(item)) else { return Ok(()) };
        self.planner.push(item)?;
        if let PlanItem::Move(item) = item {
            segments.push(ProgrammedSegment {
                index: self.segments,
                curve: item.curve,
                plane: in_force,
                rapid: item.feed == FeedLimit::Rapid,
                origin_mm: origin.linear(),
                block: item.block,
            });
            if let Some(notes) = &mut self.notes {
                notes.push(Note::Move { index: self.segments, item });
            }
            self.segments += 1;
        }
        Ok(())
    }

    fn note_stop(&mut self, item: &MotionItem) {
        let Some(notes) = &mut self.notes else { return };
        match item {
            MotionItem::Dwell { seconds, block } => notes.push(Note::Dwell { after: self.segments, seconds: *seconds, block: *block }),
            MotionItem::ToolChange { .. } => notes.push(Note::ToolChange),
            _ => {}
        }
    }

    /// Notes since the last call.
    pub(crate) fn notes(&mut self) -> Vec<Note> {
        self.notes.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// How often the spindle has been told to start, stop or turn round.
    pub(crate) fn spindle_events(&self) -> u64 {
        self.reader.spindle_events()
    }

    /// The last sample given out.
    pub(crate) fn last(&self) -> Option<Sample> {
        self.last
    }

    pub(crate) fn kinematics(&self) -> Arc<dyn Kinematics> {
        Arc::clone(&self.kinematics)
    }

    /// Joints before the program.
    pub(crate) fn start_joints(&self) -> Coords {
        self.start_joints
    }

    /// How far into the program it has read, bytes.
    pub(crate) fn bytes_done(&self) -> u64 {
        self.reader.bytes_done()
    }
}
