//! The first half of the work: moves in, the path that is travelled out.

use crate::admit::{Position, admit, dwell};
use crate::condition::Conditioner;
use crate::judge::TimeJudge;
use crate::machine::Machine;
use crate::piece::{PathStep, Programmed, Stop};
use crate::{Move, PlanError, PlanItem, PlannerConfig};
use lostmotion_base::Coords;
use lostmotion_kinematics::Kinematics;
use lostmotion_path::Curve;
use std::sync::Arc;

/// Moves shorter than this, mm or degrees, are dropped; their displacement is added to the next
/// move. A nanometre: no control resolves it, but a path that bends within it would be slow.
const DROPPED_LENGTH: f64 = 1e-6;
/// Displacement of dropped moves that is made up for where the motion comes to rest, if it is
/// larger than this, mm or degrees: less is rounding.
const CLOSED_GAP: f64 = 1e-9;

/// Takes items, and makes the path of them.
#[derive(Clone, Debug)]
pub(crate) struct Intake {
    config: PlannerConfig,
    kinematics: Arc<dyn Kinematics>,
    machine: Machine,
    conditioner: Conditioner,
    here: Position,
    /// Displacement of the dropped moves, which the next move has to make up for.
    gap: Coords,
    /// The last dropped move.
    gap_of: Option<Box<Programmed>>,
    segments: u64,
    /// Whether rounded corners may have soft ends.
    softens: bool,
    finished: bool,
}

impl Intake {
    pub(crate) fn new(
        config: PlannerConfig,
        kinematics: Arc<dyn Kinematics>,
        start: Coords,
        machine: Machine,
        softens: bool,
    ) -> Intake {
        Intake {
            conditioner: Conditioner::new(config.clone()),
            here: Position {
                program: start,
                tool_mm: [0.0; 3],
            },
            gap: Coords::ZERO,
            gap_of: None,
            config,
            kinematics,
            machine,
            segments: 0,
            softens,
            finished: false,
        }
    }

    /// The limits that it judges times with.
    pub(crate) fn machine_mut(&mut self) -> &mut Machine {
        &mut self.machine
    }

    /// How many threads find curves.
    pub(crate) fn set_threads(&mut self, threads: usize) {
        self.conditioner.set_threads(threads);
    }

    /// How often a curve could not be found any further.
    pub(crate) fn curve_stops(&self) -> u64 {
        self.conditioner.curve_stops()
    }

    /// Whether the program has ended.
    pub(crate) fn is_finished(&self) -> bool {
        self.finished
    }

    /// Takes the next item; an item that is refused leaves everything as it was.
    pub(crate) fn push(
        &mut self,
        item: PlanItem,
        steps: &mut Vec<PathStep>,
    ) -> Result<(), PlanError> {
        if self.finished {
            return Err(PlanError::Finished);
        }
        match item {
            PlanItem::Move(item) => self.push_move(&item, steps)?,
            PlanItem::Dwell(item) => {
                dwell(item.block, item.seconds)?;
                self.rest(
                    Stop {
                        dwell_s: item.seconds,
                        ..Stop::default()
                    },
                    steps,
                );
            }
            PlanItem::Halt(_) => self.rest(Stop::default(), steps),
        }
        Ok(())
    }

    /// Ends the program.
    pub(crate) fn finish(&mut self, steps: &mut Vec<PathStep>) {
        if !self.finished {
            self.rest(Stop::default(), steps);
            self.finished = true;
        }
    }

    fn push_move(&mut self, item: &Move, steps: &mut Vec<PathStep>) -> Result<(), PlanError> {
        let feed = admit(&self.config, self.kinematics.as_ref(), &self.here, item)?;
        let segment = self.segments;
        self.segments += 1;
        let Move {
            mut curve,
            control,
            tool_mm,
            block,
            ..
        } = *item;
        // Where the tool offset changes, the same joints have other coordinates.
        let last = if tool_mm == self.here.tool_mm {
            self.here.program
        } else {
            curve.start()
        };
        // The motion is where the dropped moves have left it, so that the curve begins there.
        let drawn = last + self.gap;
        if curve.start() != drawn {
            curve = curve.starting_at(drawn);
        }
        let length = curve.length();
        self.here = Position {
            program: item.curve.end(),
            tool_mm,
        };
        let heeds = item.feed.heeds();
        let programmed = Programmed {
            curve,
            length,
            feed,
            heeds,
            control,
            tool_mm,
            segment,
            block,
        };
        let is_nothing = length <= DROPPED_LENGTH;
        // What this move leaves for the next one to make up for.
        self.gap = if is_nothing { drawn } else { curve.end() } - item.curve.end();
        self.gap_of = (self.gap != Coords::ZERO).then(|| Box::new(programmed));
        if is_nothing {
            return Ok(());
        }
        let judge = TimeJudge {
            machine: &self.machine,
            kinematics: self.kinematics.as_ref(),
            softens: self.softens,
        };
        self.conditioner.push(&programmed, &judge, steps);
        Ok(())
    }

    fn rest(&mut self, stop: Stop, steps: &mut Vec<PathStep>) {
        let judge = TimeJudge {
            machine: &self.machine,
            kinematics: self.kinematics.as_ref(),
            softens: self.softens,
        };
        // Rest is at the programmed point: a short line makes up for the dropped moves.
        if let Some(last) = self.gap_of.take() {
            let end = self.here.program;
            let curve = Curve::line(end + self.gap, end);
            if curve.length() > CLOSED_GAP {
                self.gap = Coords::ZERO;
                self.conditioner.push(
                    &Programmed {
                        curve,
                        length: curve.length(),
                        ..*last
                    },
                    &judge,
                    steps,
                );
            }
        }
        self.conditioner.stop(stop, &judge, steps);
    }
}
