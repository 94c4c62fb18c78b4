//! What only the kinematics can turn into motion: tool-centre-point control on and off, tilted
//! planes, directions of the tool.
//!
//! With tool-centre-point control the words are the tip in the part's frame; without it they are
//! the linear joints (less the tool's offset), and the tool follows a curve where rotary axes move
//! along. Where the one gives way to the other nothing moves: the joints stay, and the program
//! learns where it is in the new coordinates.
//!
//! [`Modes`] keeps which kinematics the coordinates of a move go through.

use lostmotion_base::{BlockRef, Coords};
use lostmotion_gcode::{Motion, MotionFold, MotionItem, Plane, Problem};
use lostmotion_kinematics::orient::Angles;
use lostmotion_kinematics::{Cartesian, Kinematics, OrientError, TipControl};
use std::collections::VecDeque;
use std::sync::Arc;

/// One item of motion, with what is in force at it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Read {
    pub(crate) item: MotionItem,
    /// Plane in force.
    pub(crate) plane: Plane,
    /// Whether its coordinates are the tip's; else those of the linear joints.
    pub(crate) tip: bool,
}

/// Places nearer than this are the same, mm or rad: far above rounding, far below any step.
const SAME_PLACE_UNITS: f64 = 1e-9;
/// Moves with a direction that are looked at together when solutions are chosen. A choice: each
/// choice sees half as many moves ahead at least; more cost memory and time.
const ORIENTATION_HORIZON_MOVES: usize = 64;

/// The coordinates that programs are in, and moves whose directions wait for those behind them.
#[derive(Debug)]
pub(crate) struct Steering {
    tip: Arc<dyn Kinematics>,
    always: bool,
    /// G43.4 or G43.5.
    programmed: bool,
    /// In a plane that G53.1 has turned to.
    upright: bool,
    /// Whether words are the tip now.
    pub(crate) on: bool,
    /// Direction in force under G43.5.
    direction: Option<[f64; 3]>,
    waiting: VecDeque<(Motion, [f64; 3], Plane)>,
    /// Rotary joints at the start of the first of them.
    from: Angles,
}

/// What is wrong with a motion, and with which block where that is not the one being read.
#[derive(Debug)]
pub(crate) struct MotionFault {
    pub(crate) problem: Problem,
    pub(crate) block: Option<BlockRef>,
}

impl From<Problem> for MotionFault {
    fn from(problem: Problem) -> MotionFault {
        MotionFault {
            problem,
            block: None,
        }
    }
}

fn refuse(error: &OrientError) -> Problem {
    let message = match error {
        OrientError::Unreachable { .. } => {
            "the machine's rotary axes cannot turn the tool to this direction"
        }
        OrientError::Travel { .. } => {
            "the machine's rotary axes would leave their travel for this direction"
        }
        _ => {
            "the tool cannot stay on its way to this direction: the rotary axes would have to change over"
        }
    };
    Problem::FiveAxis { message }
}

const POSE_BEYOND_REACH: Problem = Problem::FiveAxis {
    message: "the machine cannot take the pose where tool-centre-point control begins or ends",
};

impl Steering {
    pub(crate) fn new(tip: Arc<dyn Kinematics>, control: TipControl) -> Steering {
        let always = control == TipControl::Always || tip.orientation().is_none();
        Steering {
            tip,
            always,
            programmed: false,
            upright: false,
            on: always,
            direction: None,
            waiting: VecDeque::new(),
            from: [0.0; 2],
        }
    }

    /// Whether directions of the tool can be had at all.
    pub(crate) fn steers(&self) -> bool {
        self.tip.orientation().is_some()
    }

    /// Whether directions are those of moves (G43.5).
    pub(crate) fn follows_program(&self) -> bool {
        self.programmed
    }

    /// Whether moves take a direction along.
    pub(crate) fn directs(&self) -> bool {
        self.direction.is_some()
    }

    fn kinematics(&self, on: bool) -> &dyn Kinematics {
        if on { self.tip.as_ref() } else { &Cartesian }
    }

    /// G43.4, G43.5 and G49.
    pub(crate) fn program(&mut self, on: bool, fold: &mut MotionFold) -> Result<(), Problem> {
        self.programmed = on;
        self.direction = None;
        self.settle(fold)
    }

    /// G69.
    pub(crate) fn level(&mut self, fold: &mut MotionFold) -> Result<(), Problem> {
        self.upright = false;
        self.settle(fold)
    }

    fn settle(&mut self, fold: &mut MotionFold) -> Result<(), Problem> {
        self.switch(self.always || self.programmed || self.upright, fold)
    }

    /// Takes other coordinates for the same joints.
    fn switch(&mut self, on: bool, fold: &mut MotionFold) -> Result<(), Problem> {
        if on != self.on {
            let tool = fold.tool_offset().linear();
            let joints = self
                .kinematics(self.on)
                .inverse(&fold.position(), &tool)
                .map_err(|_| POSE_BEYOND_REACH)?;
            // Same joints, other words: nothing moves when control of the tip begins or ends.
            fold.moved_to(self.kinematics(on).forward(&joints, &tool));
            self.on = on;
        }
        Ok(())
    }

    /// Where the joints are.
    pub(crate) fn joints(&self, fold: &MotionFold) -> Result<Coords, Problem> {
        self.kinematics(self.on)
            .inverse(&fold.position(), &fold.tool_offset().linear())
            .map_err(|_| POSE_BEYOND_REACH)
    }

    /// After a change of the tool's offset, which the program takes to be along the machine's axes:
    /// the joints stand where they stood, also where the tool leans. False if it was right.
    pub(crate) fn stand(&self, joints: &Coords, fold: &mut MotionFold) -> bool {
        let at = self
            .kinematics(self.on)
            .forward(joints, &fold.tool_offset().linear());
        let wrong = (at - fold.position())
            .0
            .iter()
            .any(|away| away.abs() > SAME_PLACE_UNITS);
        if wrong {
            fold.moved_to(at);
        }
        wrong
    }

    /// A direction of the tool, in the machine's frame: for the moves that follow (G43.5), or now
    /// (G53.1), linear axes standing still.
    pub(crate) fn orient(
        &mut self,
        direction: [f64; 3],
        fold: &mut MotionFold,
        block: BlockRef,
    ) -> Result<Option<(MotionItem, bool)>, Problem> {
        if self.programmed {
            self.direction = Some(direction);
            return Ok(None);
        }
        let tip = Arc::clone(&self.tip);
        let Some(orientation) = tip.orientation() else {
            return Ok(None);
        };
        // G53.1 turns now: of the two solutions the one with the least turning from here.
        let from = orientation.angles(&fold.position());
        let angles = orientation
            .choose(from, &[direction])
            .map_err(|error| refuse(&error))?;
        // Linear joints stand still while the rotary ones turn: joint coordinates for this one
        // move.
        self.switch(false, fold)?;
        let end = orientation.with(&fold.position(), angles.first().copied().unwrap_or(from));
        let item = fold.rapid_to(end, block);
        self.upright = true;
        self.settle(fold)?;
        Ok(Some((item, false)))
    }

    /// Keeps a move until those behind it are known; hands over the moves that are settled.
    pub(crate) fn hold(
        &mut self,
        motion: Motion,
        plane: Plane,
        out: &mut VecDeque<Read>,
    ) -> Result<(), MotionFault> {
        let Some(direction) = self.direction else {
            return Ok(());
        };
        if self.waiting.is_empty() {
            self.from = self
                .tip
                .orientation()
                .map_or([0.0; 2], |orientation| orientation.angles(&motion.start));
        }
        self.waiting.push_back((motion, direction, plane));
        // Half of the window is released and half stays, so that each choice of solution sees at
        // least that many moves ahead.
        if self.waiting.len() >= ORIENTATION_HORIZON_MOVES {
            self.release(ORIENTATION_HORIZON_MOVES / 2, out)
        } else {
            Ok(())
        }
    }

    /// Hands over everything that waits; the joints stand where the last direction wants them.
    pub(crate) fn flush(
        &mut self,
        fold: &mut MotionFold,
        out: &mut VecDeque<Read>,
    ) -> Result<bool, MotionFault> {
        if self.waiting.is_empty() {
            return Ok(false);
        }
        self.release(self.waiting.len(), out)?;
        if let Some(orientation) = self.tip.orientation() {
            // The program goes on from where the last direction has put the rotary joints.
            fold.moved_to(orientation.with(&fold.position(), self.from));
        }
        Ok(true)
    }

    /// Turns the first moves that wait into steps, with solutions chosen over all that wait.
    fn release(&mut self, count: usize, out: &mut VecDeque<Read>) -> Result<(), MotionFault> {
        let tip = Arc::clone(&self.tip);
        let Some(orientation) = tip.orientation() else {
            return Ok(());
        };
        let directions: Vec<[f64; 3]> = self
            .waiting
            .iter()
            .map(|(_, direction, _)| *direction)
            .collect();
        // Least total turning over all that waits (a shortest path through the solutions), not move
        // by move.
        let steps = orientation.follow(self.from, &directions);
        let steps = match steps {
            Ok(steps) => steps,
            Err(error) => {
                // The first move that cannot be followed is the one at fault.
                let at_fault = (1..=directions.len())
                    .find(|count| {
                        orientation
                            .follow(self.from, &directions[..*count])
                            .is_err()
                    })
                    .and_then(|count| self.waiting.get(count - 1));
                let block = at_fault.map(|(motion, ..)| motion.block);
                // It spoils the whole window: the moves behind it would start elsewhere.
                self.waiting.clear();
                let problem = refuse(&error);
                return Err(MotionFault { problem, block });
            }
        };
        // Each move becomes one step, or several where the rotary axes pass a singular place; a
        // step takes its part of the move and of its duration.
        let mut before: Option<(usize, f64)> = None;
        for step in steps.into_iter().take_while(|step| step.turn < count) {
            let Some((motion, _, plane)) = self.waiting.get(step.turn) else {
                break;
            };
            let started = before
                .filter(|(turn, _)| *turn == step.turn)
                .map_or(0.0, |(_, part)| part);
            let place = |part: f64, angles: Angles| {
                orientation.with(&motion.start.lerp(motion.end, part), angles)
            };
            let (start, end): (Coords, Coords) =
                (place(started, self.from), place(step.part, step.angles));
            // Inverse time (G93) gives the whole move a duration; each step has its share.
            let duration_s = motion
                .duration_s
                .map(|seconds| seconds * (step.part - started));
            let item = MotionItem::Move(Motion {
                start,
                end,
                duration_s,
                ..*motion
            });
            out.push_back(Read {
                item,
                plane: *plane,
                tip: true,
            });
            self.from = step.angles;
            before = Some((step.turn, step.part));
        }
        self.waiting.drain(..count.min(self.waiting.len()));
        Ok(())
    }
}

/// With tool-centre-point control or without, by running number of the segment.
#[derive(Clone, Debug)]
pub(crate) struct Modes {
    tip: Arc<dyn Kinematics>,
    plain: Arc<dyn Kinematics>,
    /// First segment of each stretch, and whether its coordinates are the tip's; they come in turn.
    changes: Vec<(u64, bool)>,
}

impl Modes {
    pub(crate) fn new(kinematics: &Arc<dyn Kinematics>) -> Modes {
        Modes {
            tip: Arc::clone(kinematics),
            plain: Arc::new(Cartesian),
            changes: Vec::new(),
        }
    }

    pub(crate) fn kinematics(&self, tip: bool) -> &Arc<dyn Kinematics> {
        if tip { &self.tip } else { &self.plain }
    }

    /// From a segment on coordinates are of this kind. False if they have been.
    pub(crate) fn begin(&mut self, segment: u64, tip: bool) -> bool {
        let changed = self.changes.last().is_none_or(|(_, last)| *last != tip);
        if changed {
            self.changes.push((segment, tip));
        }
        changed
    }

    /// That of a segment.
    pub(crate) fn at(&self, segment: u64) -> &dyn Kinematics {
        self.kinematics(self.is_tip(segment)).as_ref()
    }

    /// Whether the coordinates of a segment are the tip's.
    fn is_tip(&self, segment: u64) -> bool {
        // The last change at or before the segment holds; there are few changes and many look-ups.
        let after = self.changes.partition_point(|(first, _)| *first <= segment);
        after
            .checked_sub(1)
            .and_then(|index| self.changes.get(index))
            .is_none_or(|(_, tip)| *tip)
    }

    /// From the tip to the spindle, unit length, in the frame of a segment's coordinates: the part's
    /// under control of the tip (`axis` is that), the machine's without it.
    pub(crate) fn tool_axis(&self, segment: u64, joints: &Coords, axis: [f64; 3]) -> [f64; 3] {
        if self.is_tip(segment) {
            return axis;
        }
        self.tip
            .chain()
            .map_or(axis, |chain| chain.head_axis(joints))
    }
}
