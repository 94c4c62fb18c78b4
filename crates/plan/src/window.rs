//! The look-ahead: path that waits to be planned, and the part of its plan that is final.

use crate::demand::Interval;
use crate::intervals::Intervals;
use crate::machine::Machine;
use crate::motion::Knot;
use crate::piece::{Piece, Soft};
use crate::profile::{
    Certificate, Node, Plan, Section, Task, TimeLaw, average, duration_s, ideal, plan,
};
use crate::soft;
use crate::{PlanError, PlannerConfig};
use lostmotion_kinematics::{Kinematics, KinematicsError};
use std::collections::VecDeque;
use std::sync::Arc;

/// Parts of the usual window that are tried: on curves and short ways a shorter one may be faster.
/// Tuned (0.7, 0.5, 0.35 and 0.2 before).
const SHORTER_WINDOWS: [f64; 5] = [0.75, 0.6, 0.45, 0.3, 0.2];
/// Intervals at the beginning of a stretch on which windows are compared. A choice: more tell
/// better and cost a scan for each window.
const COMPARED_INTERVALS: usize = 192;
/// A window is good enough if its time is within this factor of the time without a jerk limit.
/// Record 35 of the decisions gives what it costs.
const GOOD_TIME: f64 = 1.003;
/// The search for a shorter window ends where one takes longer than the best by this factor. A
/// choice: with 1.02 windows are tried in vain, and one of 688 programs finds another one.
const WORSE_TIME: f64 = 1.003;
/// Parts of the limits of acceleration and jerk that are planned for, one after the other, until
/// the motion is proven to keep the limits. The first nearly always does: for all but one of 7,000
/// sections of generated programs.
const LIMIT_PARTS: [f64; 5] = [1.0, 0.8, 0.5, 0.2, 0.05];

/// Path between two stops that is not planned for good yet.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    builder: Intervals,
    pieces: VecDeque<(f64, Arc<Piece>)>,
    /// How many of them at the front have been output and are held because the next section begins
    /// on them.
    given: usize,
    intervals: Vec<Interval>,
    /// Where the profile goes on, and the speed squared there.
    from: Node,
    /// Window of the moving average of the stretch being planned, s.
    window_s: f64,
    max_intervals: usize,
    max_pieces: usize,
    law: &'static dyn TimeLaw,
    /// Numbers of intervals and of pieces at which the next plan is made.
    due: [usize; 2],
}

/// A part of a profile that is final.
#[derive(Debug)]
pub(crate) struct Settled {
    pub(crate) pieces: Vec<(f64, Arc<Piece>)>,
    /// Its corners, from the time 0.
    pub(crate) knots: Vec<Knot>,
    /// Whether it ends at rest.
    pub(crate) complete: bool,
    /// Whether its ends are soft where they should be.
    pub(crate) soft: bool,
}

impl Window {
    pub(crate) fn new(config: &PlannerConfig) -> Window {
        let (max_intervals, max_pieces) = (config.window_intervals, config.window_pieces);
        Window {
            builder: Intervals::gathered(),
            pieces: VecDeque::new(),
            given: 0,
            intervals: Vec::new(),
            from: Node::new(0.0, 0.0),
            window_s: 0.0,
            max_intervals,
            max_pieces,
            law: config.quality.law(),
            due: [max_intervals, max_pieces],
        }
    }

    /// Adds a piece.
    pub(crate) fn push(
        &mut self,
        piece: Arc<Piece>,
        machine: &Machine,
        kinematics: &dyn Kinematics,
    ) -> Result<(), PlanError> {
        let block = piece.marks[0].block;
        let start = self.builder.end();
        let pose = |source: KinematicsError| PlanError::Pose {
            block,
            source: Box::new(source),
        };
        self.builder
            .push(&piece, machine, kinematics, &mut self.intervals)
            .map_err(pose)?;
        self.pieces.push_back((start, piece));
        Ok(())
    }

    /// Whether the window is as full as it may get before some of it is planned.
    pub(crate) fn is_due(&self) -> bool {
        self.intervals.len() >= self.due[0] || self.len() >= self.due[1]
    }

    /// How many pieces wait.
    pub(crate) fn len(&self) -> usize {
        self.pieces.len() - self.given
    }

    fn task<'a>(&'a self, machine: &'a Machine, complete: bool, window_s: f64) -> Task<'a> {
        Task {
            machine,
            intervals: &self.intervals,
            from: self.from.s,
            speed_squared: self.from.b,
            complete,
            window_s,
        }
    }

    /// The longest window that a moving joint needs.
    fn usual_window_s(&self, machine: &Machine) -> f64 {
        let window = machine.window_over_s(&self.intervals);
        if window > 0.0 {
            window
        } else {
            machine.longest_window_s()
        }
    }

    /// Plans the window and outputs its final part; `None` if the window may still grow. The flag
    /// tells whether the profile had to come to rest for want of look-ahead.
    pub(crate) fn settle(
        &mut self,
        machine: &Machine,
        kinematics: &dyn Kinematics,
    ) -> Option<(Settled, bool)> {
        // The averaging window can change only at rest: within a stretch it shapes the motion on
        // both sides.
        if self.from.b == 0.0 {
            self.window_s = self.best_window(machine).0;
        }
        for part in LIMIT_PARTS {
            let plan = plan(&self.task(&machine.part(part), false, self.window_s));
            // Final is only what lies before a plateau at the cap.
            let Some(cut) = plan
                .last_cut(self.window_s)
                .filter(|cut| cut.s > self.from.s)
            else {
                break;
            };
            let nodes: Vec<Node> = plan
                .nodes
                .iter()
                .copied()
                .take_while(|node| node.s <= cut.s)
                .collect();
            // Without a proof, the same part is planned again with less of the limits.
            if let Some(knots) = self.timed(machine, kinematics, &nodes, false) {
                return Some((self.give(knots, &plan, cut), false));
            }
        }
        let full = self.intervals.len() >= self.max_intervals || self.len() >= self.max_pieces;
        if full {
            // A stop separates the window from the path that will come, so that all of it can be
            // planned.
            return self
                .finish(machine, kinematics, [None; 2])
                .map(|settled| (settled, true));
        }
        self.due = [self.max_intervals, self.max_pieces];
        None
    }

    /// Removes the part before a cut, and drops the demands that do not reach beyond it.
    fn give(&mut self, knots: Vec<Knot>, plan: &Plan, cut: Node) -> Settled {
        // The pieces of this part; the next one may begin on the last of them.
        let done = self.pieces.partition_point(|(start, _)| *start < cut.s);
        let next = knots.last().map_or(0.0, |knot| knot.s);
        // An interval matters as long as its demands reach beyond the cut.
        let past = plan.reach_ends.partition_point(|end| *end <= cut.s);
        let pieces = self
            .pieces
            .range(self.given.min(done)..done)
            .cloned()
            .collect();
        // The averaged motion ends half a window before the cut: pieces from there on are held.
        let past_pieces = self
            .pieces
            .partition_point(|(start, _)| *start <= next)
            .saturating_sub(1)
            .min(done);
        self.pieces.drain(..past_pieces);
        self.given = done - past_pieces;
        self.intervals.drain(..past);
        self.from = cut;
        // Not at once again: each plan looks at all that waits.
        let later = |waiting: usize, most: usize| most.min(waiting + most / 2);
        self.due = [
            later(self.intervals.len(), self.max_intervals),
            later(self.len(), self.max_pieces),
        ];
        Settled {
            pieces,
            knots,
            complete: false,
            soft: false,
        }
    }

    /// Plans the rest, which ends at a stop, its ends soft if it is one line; nothing if there is
    /// no path left.
    pub(crate) fn finish(
        &mut self,
        machine: &Machine,
        kinematics: &dyn Kinematics,
        ends: [Option<Soft>; 2],
    ) -> Option<Settled> {
        self.builder.finish(&mut self.intervals);
        let settled = (!self.intervals.is_empty()).then(|| {
            // Soft ends make the rounding of a corner faster, but only a single line has them in
            // closed form.
            let soft = self.soft_knots(machine, kinematics, ends);
            let is_soft = soft.is_some();
            let knots = soft.unwrap_or_else(|| self.final_knots(machine, kinematics));
            Settled {
                pieces: self.pieces.drain(..).skip(self.given).collect(),
                knots,
                complete: true,
                soft: is_soft,
            }
        });
        self.pieces.clear();
        self.given = 0;
        self.intervals.clear();
        self.from = Node::new(0.0, 0.0);
        self.due = [self.max_intervals, self.max_pieces];
        settled
    }

    /// The motion over a final part of the profile; `None` if it does not keep every limit.
    fn timed(
        &self,
        machine: &Machine,
        kinematics: &dyn Kinematics,
        nodes: &[Node],
        complete: bool,
    ) -> Option<Vec<Knot>> {
        let base = average(nodes, self.window_s, complete);
        let section = Section {
            machine,
            kinematics,
            pieces: &self.pieces,
            intervals: &self.intervals,
            nodes,
            base: &base,
        };
        // The time law starts from a motion that is proven.
        Certificate::new(&section)
            .holds(&base)
            .then(|| self.law.plan(&section))
    }

    /// The motion over one line with soft ends.
    fn soft_knots(
        &self,
        machine: &Machine,
        kinematics: &dyn Kinematics,
        ends: [Option<Soft>; 2],
    ) -> Option<Vec<Knot>> {
        let ([only], 1, true) = (
            self.intervals.as_slice(),
            self.pieces.len(),
            ends != [None; 2] && self.from.b == 0.0,
        ) else {
            return None;
        };
        let (_, piece) = self
            .pieces
            .front()
            .filter(|_| only.demand.is_straight() && self.from.s == only.start)?;
        let reach = soft::Reach::along(machine, &piece.curve.eval(0.0).d1, only.cap);
        let knots = soft::line(only.start, only.end - only.start, reach, ends);
        let (nodes, base) = (&[], &knots);
        let section = Section {
            machine,
            kinematics,
            pieces: &self.pieces,
            intervals: &self.intervals,
            nodes,
            base,
        };
        Certificate::new(&section).holds(&knots).then_some(knots)
    }

    /// The motion to the end.
    fn final_knots(&mut self, machine: &Machine, kinematics: &dyn Kinematics) -> Vec<Knot> {
        let mut planned = None;
        if self.from.b == 0.0 {
            (self.window_s, planned) = self.best_window(machine);
        }
        let mut nodes = Vec::new();
        for part in LIMIT_PARTS {
            // All of the limits come first, and may have been planned for already.
            nodes = planned.take().unwrap_or_else(|| {
                plan(&self.task(&machine.part(part), true, self.window_s)).nodes
            });
            if let Some(knots) = self.timed(machine, kinematics, &nodes, true) {
                return knots;
            }
        }
        average(&nodes, self.window_s, true)
    }

    /// The window with which the beginning of the path takes the least time, and the profile with it
    /// where the beginning is all of the path.
    fn best_window(&self, machine: &Machine) -> (f64, Option<Vec<Node>>) {
        let usual = self.usual_window_s(machine);
        // A straight stretch has a closed form.
        if let [only] = self.intervals.as_slice()
            && only.demand.is_straight()
        {
            let window = machine.straight_window_s(&only.demand, only.end - self.from.s);
            return (usual.min(window), None);
        }
        // Planning all of a long stretch for each window would cost too much; its beginning tells.
        let intervals = &self.intervals[..self.intervals.len().min(COMPARED_INTERVALS)];
        let profile = |window_s: f64| {
            let task = Task {
                intervals,
                ..self.task(machine, true, window_s)
            };
            let nodes = plan(&task).nodes;
            // Averaging adds one window to the time of the profile.
            (duration_s(&nodes) + window_s, nodes)
        };
        let all = |nodes| (intervals.len() == self.intervals.len()).then_some(nodes);
        let (mut best, (mut least, mut nodes)) = (usual, profile(usual));
        let (from, to) = (
            self.from,
            Node::new(intervals.last().map_or(self.from.s, |last| last.end), 0.0),
        );
        // Near the time without a jerk limit no other window can gain much.
        if least <= usual + GOOD_TIME * duration_s(&ideal(machine, intervals, from, to))
            && machine.is_short(intervals, usual)
        {
            return (usual, all(nodes));
        }
        // A shorter window spreads the demands less far but leaves less acceleration: from the
        // usual one downward until the time rises.
        for part in SHORTER_WINDOWS {
            let (tried, profile) = profile(part * usual);
            if tried > WORSE_TIME * least {
                break;
            }
            if tried < least {
                (best, least, nodes) = (part * usual, tried, profile);
            }
        }
        (best, all(nodes))
    }
}
