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
use lostmotion_base::vec::{dot, norm};
use lostmotion_path::Curve;

/// Intervals in the longest time over which a joint builds up its acceleration. A choice: more
/// follow the limits closer and cost time in proportion; with eight zigzags take 0.5 to 2 % longer.
const WINDOW_INTERVALS: f64 = 12.0;
/// Largest turn of a piece in one of its intervals, rad, and most intervals of a piece by its turn.
/// A choice: where the direction turns, what the limits leave of the jerk changes, and one jerk for
/// all of an interval is the least of them. With 3 degrees corners take 0.5 % longer.
const LARGEST_TURN: f64 = 0.026;
const MOST_BY_TURN: f64 = 8.0;
/// Shortest interval that ends where pieces meet, as a part of the usual one. A choice: where pieces
/// are shorter the number of intervals stays.
const LEAST_STEP: f64 = 0.35;
/// Part of the time that a faster motion has to promise. Record 35 of the decisions gives what it
/// costs.
const LEAST_GAIN: f64 = 2e-3;
/// Steps that a ramp on a straight line takes longer than without a jerk limit: 0.12 of twelve at
/// its start from rest, and a little at its end.
const RAMP_STEPS: f64 = 1.5;
/// A span of fewer intervals is left as it is. A choice: one and a half of the longest window;
/// shorter spans have little to gain.
const LEAST_INTERVALS: usize = 18;
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
    let middle = 0.5 * (from + to);
    let (times, meetings) = times(section, span, step_s);
    let mut states = states(base, times.iter().copied());
    // Without rounding: a place beside the meeting is on another piece.
    for (k, s) in meetings {
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

/// Times of the base at which intervals begin, and the places of those at which it goes from piece
/// to piece: third derivatives step there, and an interval with two of them has the limits of both.
/// Between those the times are even, so that intervals are short where the motion is slow.
fn times(section: &Section<'_>, span: Span, step_s: f64) -> (Vec<f64>, Vec<(usize, f64)>) {
    let base = section.base;
    let mut times = vec![span.from];
    let mut meetings = Vec::new();
    let fill = |times: &mut Vec<f64>, to: f64, turn: f64| {
        let from = times.last().copied().unwrap_or(to);
        let by_turn = (turn / LARGEST_TURN).min(MOST_BY_TURN);
        let count = ((to - from) / step_s).max(by_turn).round().max(1.0);
        times.extend((1..count as usize).map(|k| from + (to - from) * (k as f64 / count)));
        times.push(to);
    };
    let [first, last] = [span.from, span.to].map(|t| state_at(base, t).s);
    let from = section.pieces.partition_point(|(start, _)| *start <= first);
    let mut index = base.partition_point(|knot| knot.t <= span.from);
    let (mut before, mut turn) = (span.from, 0.0);
    let ended = section.pieces.range(from.saturating_sub(1)..);
    for ((_, ended), (start, _)) in ended.zip(section.pieces.range(from..)) {
        if *start >= last {
            break;
        }
        while base.get(index).is_some_and(|knot| knot.s < *start) {
            index += 1;
        }
        let Some(knot) = index.checked_sub(1).and_then(|index| base.get(index)) else {
            continue;
        };
        let next = base.get(index).map_or(span.to, |next| next.t);
        let at = knot.time_at(*start, knot.t, next);
        turn += turned(&ended.curve);
        if (at - before).min(span.to - at) >= LEAST_STEP * step_s {
            fill(&mut times, at, turn);
            meetings.push((times.len() - 1, *start));
            (before, turn) = (at, 0.0);
        }
    }
    fill(&mut times, span.to, 0.0);
    (times, meetings)
}

/// By how much the direction of the tip changes from the start of a curve to its end, nearly rad.
fn turned(curve: &Curve) -> f64 {
    if matches!(curve, Curve::Line(_)) {
        return 0.0;
    }
    let [from, to] = [0.0, curve.length()].map(|s| curve.eval(s).d1.linear());
    let product = norm(from) * norm(to);
    if product > 0.0 {
        (2.0 - 2.0 * dot(from, to) / product).max(0.0).sqrt()
    } else {
        0.0
    }
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
