//! Goes along the samples with the moves that they lie on, and says of each interval what it is spent
//! on.

use super::{Joints, Limiter, stands};
use crate::motion::{Bows, Modes, Note, planner_config};
use crate::options::BowLimit;
use crate::setup::Setup;
use lostmotion_base::BlockRef;
use lostmotion_path::Curve;
use lostmotion_plan::{FeedLimit, Move, PathControl, Quality, Sample};
use std::collections::VecDeque;

/// Part of the tolerance by which the command has to be off the path to be rounding a corner: above
/// the rounding of the planner, far below any blend. A choice.
const OFF_PATH_SHARE: f64 = 0.02;

/// A programmed move.
struct Timed {
    index: u64,
    curve: Curve,
    /// Path speed that the program allows, per s in the unit of s.
    feed: Option<f64>,
    off_mm: f64,
    rapid: bool,
}

/// A dwell that has not been stood yet.
struct Waiting {
    /// Moves before it.
    after: u64,
    left_s: f64,
    block: BlockRef,
}

/// The time between two samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    /// The block that it is spent on.
    pub(crate) block: BlockRef,
    /// The move at its end.
    pub(crate) segment: u64,
    /// Whether that is a rapid.
    pub(crate) rapid: bool,
    pub(crate) limiter: Limiter,
}

/// Where the samples are.
pub(crate) struct Along {
    modes: Modes,
    joints: Joints,
    bows: Option<Bows>,
    period_s: f64,
    default_tolerance_mm: f64,
    exact_tolerance_mm: f64,
    moves: VecDeque<Timed>,
    dwells: VecDeque<Waiting>,
    last: Option<Sample>,
    /// Whether an operator interferes, who may hold the motion.
    interrupted: bool,
    pub(crate) tool_changes: u64,
}

impl Along {
    /// Before the first sample.
    pub(crate) fn new(setup: &Setup<'_>, modes: &Modes) -> Along {
        let (machine, options) = (setup.machine, setup.options);
        // Only limits and tolerances are used, which do not depend on the quality.
        let config = planner_config(machine, Quality::default());
        let clock = machine.cycles().command();
        Along {
            modes: modes.clone(),
            joints: Joints::new(&config.limits, clock.period_s()),
            bows: Bows::new(
                modes.kinematics(true),
                clock.period_s(),
                BowLimit::new(machine, options),
            ),
            period_s: clock.period_s(),
            default_tolerance_mm: config.default_tolerance_mm,
            exact_tolerance_mm: config.exact_path_tolerance_mm,
            moves: VecDeque::new(),
            dwells: VecDeque::new(),
            last: None,
            interrupted: !options.interventions.is_empty(),
            tool_changes: 0,
        }
    }

    /// Takes a chunk of samples and what was read for it; gives for each sample the interval that
    /// ends at it. The first sample of a program ends none, nor does one before any move.
    pub(crate) fn chunk(
        &mut self,
        samples: &[Sample],
        notes: Vec<Note>,
        modes: &Modes,
    ) -> impl Iterator<Item = Option<Interval>> {
        self.modes.clone_from(modes);
        for note in notes {
            match note {
                Note::Move { index, item } => self.moves.push_back(self.timed(index, &item)),
                Note::Dwell {
                    after,
                    seconds,
                    block,
                } => self.dwells.push_back(Waiting {
                    after,
                    left_s: seconds,
                    block,
                }),
                Note::ToolChange => self.tool_changes += 1,
            }
        }
        samples.iter().map(|sample| {
            let last = self.last.replace(*sample)?;
            self.interval(&last, sample)
        })
    }

    fn timed(&self, index: u64, item: &Move) -> Timed {
        let feed = match item.feed {
            FeedLimit::Rapid => None,
            FeedLimit::PerSecond(feed) | FeedLimit::Fixed(feed) => Some(feed),
            // Inverse time allows the mean speed of its duration.
            FeedLimit::Duration(seconds) => Some(item.curve.length() / seconds),
        };
        let tolerance = match item.control {
            PathControl::Continuous { tolerance_mm, .. } => {
                tolerance_mm.unwrap_or(self.default_tolerance_mm)
            }
            PathControl::ExactPath | PathControl::ExactStop => self.exact_tolerance_mm,
        };
        Timed {
            index,
            curve: item.curve,
            feed,
            off_mm: OFF_PATH_SHARE * tolerance,
            rapid: item.feed == FeedLimit::Rapid,
        }
    }

    fn interval(&mut self, a: &Sample, b: &Sample) -> Option<Interval> {
        // Rest belongs to a dwell where one is due; else to a stop within the motion.
        let rests = stands(a) && stands(b);
        if let Some(block) = rests.then(|| self.stand(b.segment)).flatten() {
            return Some(Interval {
                block,
                segment: b.segment,
                rapid: false,
                limiter: Limiter::Dwell,
            });
        }
        // Samples come in the order of the path: moves before the one at hand are done with.
        while self.moves.len() > 1
            && self
                .moves
                .front()
                .is_some_and(|first| first.index < b.segment)
        {
            self.moves.pop_front();
        }
        let first = self.moves.front()?;
        let of = |limiter| Interval {
            block: b.block,
            segment: b.segment,
            rapid: first.rapid,
            limiter,
        };
        // A standstill within a move that no dwell explains is the operator's feed hold.
        if self.interrupted && rests {
            return Some(of(Limiter::FeedHold));
        }
        // Whether the command has left the programmed path: it rounds a corner.
        let off = || {
            let pose = self.modes.at(b.segment).tool_pose(&b.position, &b.tool_mm);
            let (tip, place) = (pose.tip, first.curve.point(b.s).linear());
            let square = |axis: usize| (tip[axis] - place[axis]) * (tip[axis] - place[axis]);
            (square(0) + square(1) + square(2)).sqrt() > first.off_mm
        };
        let limiter = self.joints.limiter(
            [a, b],
            first.feed,
            self.bows.as_ref().map_or(0.0, |bows| bows.part(a, b)),
            off,
        );
        Some(of(limiter))
    }

    /// Gives an interval of rest to the dwell that it belongs to; the block of that, if there is one.
    fn stand(&mut self, segment: u64) -> Option<BlockRef> {
        // A dwell is over when a move behind it has begun.
        let past =
            |dwell: &Waiting| segment > dwell.after || (segment == dwell.after && segment > 0);
        while self
            .dwells
            .front()
            .is_some_and(|dwell| past(dwell) || dwell.left_s < 0.5 * self.period_s)
        {
            self.dwells.pop_front();
        }
        let dwell = self.dwells.front_mut()?;
        // Cycle by cycle, so that a dwell's row has the time that the plan gives it.
        dwell.left_s -= self.period_s;
        Some(dwell.block)
    }
}
