//! A time law that starts from the averaged profile and lowers its time by an interior-point
//! method.

use super::barrier::BarrierProblem;
use super::certificate::Certificate;
use super::course::{KEPT_SHARE, problem};
use super::ideal::{ideal, time_between};
use super::spans::{Span, spans};
use super::spline::Grid;
use super::{Node, Section, TimeLaw};
use crate::motion::{Knot, PathState, state_at, states};

/// Intervals in the longest time over which a joint builds up its acceleration. A choice: more
/// follow the limits closer and cost time in proportion.
const WINDOW_INTERVALS: f64 = 8.0;
/// Part of the time that a faster motion has to promise. Record 35 of the decisions gives what it
/// costs.
const LEAST_GAIN: f64 = 2e-3;
/// Steps that a ramp on a straight line takes longer than without a jerk limit: 0.08 of eight at
/// its start from rest, and a little at its end.
const RAMP_STEPS: f64 = 1.0;
/// A span of fewer intervals is left as it is. A choice: one and a half of the longest window;
/// shorter spans have little to gain.
const LEAST_INTERVALS: usize = 12;
/// Complementarity with which the interior-point method starts, as a part of an interval's time. A
/// choice: larger forgets the start, smaller keeps to its bounds.
const FIRST_COMPLEMENTARITY: f64 = 0.3;
/// The same where it goes on from a solution that passed a limit. A choice: near a solution little
/// is needed.
const REPAIR_COMPLEMENTARITY: f64 = 0.02;
/// The same at which it stops. A choice: the time for each bound that may still be gained.
const LAST_COMPLEMENTARITY: f64 = 1e-4;
/// Most steps of the interior-point method in one solution. A choice: six whole steps suffice at
/// `CENTERING`; short ones take more.
const MAX_STEPS: usize = 40;
/// How often a span for which no faster motion was found is split. A choice: eight parts at most;
/// each costs a solution.
const MAX_SPLITS: usize = 3;
/// Steps on either side of the place that was in the way which stay as they are. A choice: a
/// coefficient of the spline reaches over three intervals.
const KEPT_STEPS: f64 = 2.0;
/// How often goals are made stricter where limits are passed, before the base is kept. A choice:
/// each solves the span again.
const MAX_REPAIRS: usize = 8;
/// Factor on a goal beyond the excess of its limit. A choice: less needs further repairs, more
/// costs time on the path.
const GOAL_REPAIR: f64 = 0.997;
/// Factor on the cap of the squared speed beyond the excess of the speed. A choice: less needs
/// further repairs, more costs time on the path.
const CAP_REPAIR: f64 = 0.999;

/// The averaged profile, made faster.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refined;

impl TimeLaw for Refined {
    fn plan(&self, section: &Section<'_>) -> Vec<Knot> {
        let base = section.base;
        // On one straight line the averaged profile is the time-optimal S-curve already.
        if section
            .intervals
            .iter()
            .all(|interval| interval.demand.is_straight())
            && section.pieces.len() == 1
        {
            return base.to_vec();
        }
        let step_s = section.machine.longest_window_s() / WINDOW_INTERVALS;
        let mut joined = Joined {
            base,
            knots: Vec::with_capacity(base.len()),
            next: 0,
            shift_s: 0.0,
        };
        let spans = spans(base, section.intervals, step_s, LEAST_INTERVALS);
        let gains = Gains::new(section);
        for span in spans {
            gains.take(span, step_s, MAX_SPLITS, &mut joined);
        }
        joined.finish()
    }
}

/// Makes a motion faster where it may become so.
struct Gains<'a> {
    section: &'a Section<'a>,
    ideal: Vec<Node>,
}

impl<'a> Gains<'a> {
    fn new(section: &'a Section<'a>) -> Gains<'a> {
        let ends = section.nodes.first().zip(section.nodes.last());
        let ideal = ends.map_or_else(Vec::new, |(from, to)| {
            ideal(section.machine, section.intervals, *from, *to)
        });
        Gains { section, ideal }
    }

    fn are_there(&self, span: &Span, step_s: f64) -> bool {
        let [from, to] = [span.from, span.to].map(|t| state_at(self.section.base, t).s);
        let own = span.to - span.from;
        own - time_between(&self.ideal, from, to) > LEAST_GAIN * own + RAMP_STEPS * step_s
    }

    /// Replaces a span of the motion by a faster one. Where none was found for all of it, the parts
    /// before and after the place that was in the way are tried separately.
    fn take(&self, span: Span, step_s: f64, splits: usize, joined: &mut Joined<'_>) {
        if !self.are_there(&span, step_s) {
            return;
        }
        match refine(self.section, span, step_s) {
            Ok(faster) => joined.replace(span, &faster),
            Err(at) if splits > 0 => {
                let kept_s = KEPT_STEPS * step_s;
                let parts = [
                    Span {
                        to: at - kept_s,
                        ..span
                    },
                    Span {
                        from: at + kept_s,
                        ..span
                    },
                ];
                for part in parts
                    .into_iter()
                    .filter(|part| part.to - part.from > LEAST_INTERVALS as f64 * step_s)
                {
                    self.take(part, step_s, splits - 1, joined);
                }
            }
            Err(_) => {}
        }
    }
}

/// A motion with parts of it replaced.
struct Joined<'a> {
    base: &'a [Knot],
    knots: Vec<Knot>,
    /// First knot of the base that is not taken over yet.
    next: usize,
    /// By how much later than in the base the motion is now.
    shift_s: f64,
}

impl Joined<'_> {
    fn keep(&mut self, until: f64) {
        let shift_s = self.shift_s;
        let kept = self.base[self.next..]
            .iter()
            .take_while(|knot| knot.t < until);
        let before = self.knots.len();
        self.knots.extend(kept.map(|knot| Knot {
            t: knot.t + shift_s,
            ..*knot
        }));
        self.next += self.knots.len() - before;
    }

    /// Puts knots in the place of a span. Their times begin at 0; in the state of the last one the
    /// base goes on.
    fn replace(&mut self, span: Span, faster: &[Knot]) {
        self.keep(span.from);
        let from = span.from + self.shift_s;
        self.knots.extend(faster.iter().map(|knot| Knot {
            t: knot.t + from,
            ..*knot
        }));
        self.next = self.base.partition_point(|knot| knot.t <= span.to);
        // The base goes on within one of its knots, with the jerk of that knot.
        let jerk = self
            .next
            .checked_sub(1)
            .and_then(|index| self.base.get(index))
            .map_or(0.0, |knot| knot.j);
        if let Some(last) = self.knots.last_mut() {
            last.j = jerk;
            self.shift_s = last.t - span.to;
        }
    }

    fn finish(mut self) -> Vec<Knot> {
        self.keep(f64::INFINITY);
        self.knots
    }
}

/// A faster motion over a span of the base, its times from 0; or about the time in the base of the
/// place that was in the way.
fn refine(section: &Section<'_>, span: Span, step_s: f64) -> Result<Vec<Knot>, f64> {
    let (base, Span { from, to }) = (section.base, span);
    let count = ((to - from) / step_s).ceil();
    let time = |k: f64| from + (to - from) * (k / count);
    let middle = time(0.5 * count);
    // Even times of the base make intervals that are short where the motion is slow.
    let mut times: Vec<f64> = (0..=count as usize).map(|k| time(k as f64)).collect();
    let snapped = snap(section, &mut times);
    let mut states = states(base, times.iter().copied());
    // Without rounding: a place beside the meeting is on another piece.
    for (k, s) in snapped {
        states[k].s = s;
    }
    // b(s) needs forward motion in every interval.
    let stuck = states
        .windows(2)
        .position(|pair| pair[1].s <= pair[0].s || pair[0].v <= 0.0 || pair[1].v <= 0.0);
    if let Some(interval) = stuck {
        return Err(0.5 * (times[interval] + times[interval + 1]));
    }
    let grid = Grid::new(states.iter().map(|state| state.s).collect());
    let start = start(base, &grid, &states, &times).ok_or(middle)?;
    let mut problem = problem(section, &grid).ok_or(middle)?;
    let mut beyond = middle;
    let (mut c, mut first) = (start, FIRST_COMPLEMENTARITY);
    // Solve, prove, make goals stricter where the proof fails. A repair starts near its solution
    // and so with little complementarity.
    for _ in 0..=MAX_REPAIRS {
        problem.solve(
            &mut c,
            first * step_s,
            LAST_COMPLEMENTARITY * step_s,
            MAX_STEPS,
        );
        first = REPAIR_COMPLEMENTARITY;
        let knots =
            knots(&grid, &c).map_err(|interval| 0.5 * (times[interval] + times[interval + 1]))?;
        // Without a gain the base is kept.
        if knots.last().is_none_or(|last| last.t >= to - from) {
            return Err(middle);
        }
        match repaired(section, &mut problem, &knots) {
            Ok(()) => return Ok(knots),
            Err(interval) => beyond = 0.5 * (times[interval] + times[interval + 1]),
        }
    }
    Err(beyond)
}

/// Least distance of two times, in steps. A choice.
const LEAST_STEP: f64 = 0.35;

/// Moves times to when the base goes from piece to piece, where third derivatives step: an interval
/// with two of them has the limits of both.
fn snap(section: &Section<'_>, times: &mut [f64]) -> Vec<(usize, f64)> {
    let mut snapped = Vec::new();
    let base = section.base;
    let last = times.len() - 1;
    let step = (times[last] - times[0]) / last as f64;
    let mut k = 1;
    let mut place = state_at(base, times[1]).s;
    let first = state_at(base, times[0]).s;
    let from = section.pieces.partition_point(|(start, _)| *start <= first);
    let mut next_free = 1;
    for (start, _) in section.pieces.range(from..) {
        while place < *start && k < last {
            k += 1;
            place = state_at(base, times[k]).s;
        }
        if place < *start {
            break;
        }
        // When the base is there: a root in the interval before.
        let (mut low, mut high) = (times[k - 1], times[k]);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if state_at(base, middle).s < *start {
                low = middle;
            } else {
                high = middle;
            }
        }
        let near = if high - times[k - 1] < times[k] - high {
            k - 1
        } else {
            k
        };
        if near >= next_free
            && near < last
            && high - times[near - 1] > LEAST_STEP * step
            && times[near + 1] - high > LEAST_STEP * step
        {
            times[near] = high;
            snapped.push((near, *start));
            next_free = near + 1;
            if near == k {
                place = *start;
            }
        }
    }
    snapped
}

/// Coefficients of the base.
fn start(base: &[Knot], grid: &Grid, states: &[PathState], times: &[f64]) -> Option<Vec<f64>> {
    let mut c = vec![0.0; grid.len() + 2];
    let middles = (1..grid.len() - 1).map(|k| 0.5 * (times[k] + times[k + 1]));
    // A coefficient of the quadratic spline is nearly b in the middle of its interval.
    for (c, middle) in c[2..].iter_mut().zip(crate::motion::states(base, middles)) {
        *c = middle.v * middle.v;
    }
    c[..2].copy_from_slice(&grid.ends(false, states.first()?));
    let last = c.len() - 2;
    c[last..].copy_from_slice(&grid.ends(true, states.last()?));
    Some(c)
}

/// The motion that the coefficients describe, two knots to an interval and one at the end; or the
/// interval in which there is none.
fn knots(grid: &Grid, c: &[f64]) -> Result<Vec<Knot>, usize> {
    let mut out = Vec::with_capacity(2 * grid.len() + 1);
    let mut end = Knot::default();
    for interval in 0..grid.len() {
        let [first, second, last] = grid.knots(c, interval, end.t).ok_or(interval)?;
        out.extend([first, second]);
        end = last;
    }
    out.push(end);
    Ok(out)
}

/// Makes goals stricter around each interval that passes a limit. Returns an error with the
/// interval that passes one by most, or whose pose the machine cannot take.
fn repaired(
    section: &Section<'_>,
    problem: &mut BarrierProblem<'_>,
    knots: &[Knot],
) -> Result<(), usize> {
    let mut certificate = Certificate::new(section);
    let (mut worst, mut most) = (None, KEPT_SHARE);
    let count = problem.goals.len();
    for interval in 0..count {
        let [v, a, j] = certificate
            .most(&knots[2 * interval..2 * interval + 3])
            .ok_or(interval)?;
        if v.max(a).max(j) > most {
            (worst, most) = (Some(interval), v.max(a).max(j));
        }
        // A coefficient reaches over three intervals, so that the neighbours get the same goal.
        let near = interval.saturating_sub(2)..(interval + 3).min(count);
        for (kind, used) in [a, j]
            .into_iter()
            .enumerate()
            .filter(|(_, used)| *used > KEPT_SHARE)
        {
            // From what it was planned to use here: a share of the whole would not change what was
            // made stricter before.
            let stricter = problem.goals[interval][kind] * GOAL_REPAIR / used;
            for goal in &mut problem.goals[near.clone()] {
                goal[kind] = goal[kind].min(stricter);
            }
        }
        // Speed has a cap of its square in place of a goal.
        if v > KEPT_SHARE {
            for cap in &mut problem.caps[near] {
                *cap *= CAP_REPAIR / (v * v);
            }
        }
    }
    worst.map_or(Ok(()), Err)
}
