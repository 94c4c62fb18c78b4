//! A time law that starts from the averaged profile and lowers its time by an interior-point
//! method.

use super::barrier::BarrierProblem;
use super::certificate::Certificate;
use super::course::{KEPT_SHARE, problem};
use super::ideal::{ideal, time_between};
use super::spans::{Span, spans};
use super::spline::Grid;
use super::steps::Steps;
use super::stub::Stub;
use super::{Node, Section, TimeLaw};
use crate::motion::{Knot, PathState, state_at, states};

/// Part of the time that a faster motion has to promise. Record 35 of the decisions gives what it
/// costs.
const LEAST_GAIN: f64 = 2e-3;
/// Usual steps that a ramp on a straight line takes longer than without a jerk limit: 0.12 of twelve at
/// its start from rest, and a little at its end.
const RAMP_STEPS: f64 = 1.5;
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
/// Usual steps on either side of the place that was in the way which stay as they are. A choice: a
/// coefficient of the spline reaches over three intervals.
const KEPT_STEPS: f64 = 2.0;
/// How often goals are made stricter where limits are passed, before the base is kept. A choice:
/// each solves the span again.
const MAX_REPAIRS: usize = 8;
/// Factor on a goal beyond the excess of its limit. A choice: less needs further repairs, more
/// costs time on the path.
const GOAL_REPAIR: f64 = 0.997;
/// Intervals' times at rest that keep the shape of the base, since b(s) has no bounded derivatives
/// there: finest ones, or usual ones where the base leaves no more than this part of its time to
/// gain. A choice: an interval of the spline uses less of the jerk there than a base that is at its
/// limits; with finest ones everywhere programs of stops take 0.2 % longer, with usual ones short
/// programs 2 to 10 %.
const REST_STEPS: f64 = 5.0;
const REST_GAIN: f64 = 0.03;
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
        let steps = Steps::new(section);
        let mut joined = Joined {
            base,
            knots: Vec::with_capacity(base.len()),
            next: 0,
            shift_s: 0.0,
        };
        let gains = Gains::new(section, steps);
        for span in spans(base, section.intervals, &steps, rests_s(section, &steps)) {
            gains.take(span, MAX_SPLITS, &mut joined);
        }
        joined.finish()
    }
}

/// How long the motion keeps its shape at its ends, s.
fn rests_s(section: &Section<'_>, steps: &Steps) -> [f64; 2] {
    let (Some(first), Some(last)) = (section.base.first(), section.base.last()) else {
        return [0.0; 2];
    };
    let usual_s = REST_STEPS * steps.usual_s;
    let rest_s = |knot: &Knot, from: f64, to: f64| {
        if knot.v > 0.0 {
            return 0.0;
        }
        let stub = Stub::of(section.base, from, to);
        if stub.fastest(section).lasts_s() < (1.0 - REST_GAIN) * stub.lasts_s() {
            REST_STEPS * steps.finest_s
        } else {
            usual_s
        }
    };
    [
        rest_s(first, first.t, first.t + usual_s),
        rest_s(last, last.t - usual_s, last.t),
    ]
}

/// Makes a motion faster where it may become so.
struct Gains<'a> {
    section: &'a Section<'a>,
    steps: Steps,
    ideal: Vec<Node>,
}

impl<'a> Gains<'a> {
    fn new(section: &'a Section<'a>, steps: Steps) -> Gains<'a> {
        let ends = section.nodes.first().zip(section.nodes.last());
        let ideal = ends.map_or_else(Vec::new, |(from, to)| {
            ideal(section.machine, section.intervals, *from, *to)
        });
        Gains {
            section,
            steps,
            ideal,
        }
    }

    fn are_there(&self, span: &Span) -> bool {
        let [from, to] = [span.from, span.to].map(|t| state_at(self.section.base, t).s);
        let own = span.to - span.from;
        let least = LEAST_GAIN * own + RAMP_STEPS * self.steps.usual_s;
        own - time_between(&self.ideal, from, to) > least
    }

    /// Replaces a span of the motion by a faster one. Where none was found for all of it, the parts
    /// before and after the place that was in the way are tried separately.
    fn take(&self, span: Span, splits: usize, joined: &mut Joined<'_>) {
        if !self.are_there(&span) {
            return;
        }
        match self.faster(span) {
            Ok((span, faster)) => joined.replace(span, &faster),
            Err(at) if splits > 0 => {
                let kept_s = KEPT_STEPS * self.steps.usual_s;
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
                for part in parts.into_iter().filter(|part| part.is_long(&self.steps)) {
                    self.take(part, splits - 1, joined);
                }
            }
            Err(_) => {}
        }
    }

    /// A faster motion over a span, its times from 0, with the stubs beside it and the span that it
    /// is in the place of; or about the time in the base of the place that was in the way.
    fn faster(&self, span: Span) -> Result<(Span, Vec<Knot>), f64> {
        let base = self.section.base;
        let (Some(first), Some(last)) = (base.first(), base.last()) else {
            return Err(span.from);
        };
        let beside = |rest: &Knot, from: f64, to: f64| {
            (rest.v == 0.0 && to - from <= 2.0 * REST_STEPS * self.steps.usual_s)
                .then(|| Stub::of(base, from, to).fastest(self.section))
        };
        let stubs = [
            beside(first, first.t, span.from),
            beside(last, span.to, last.t),
        ];
        // Beside a motion that is faster at its ends there may be none that gets slower in time.
        let fast = refine(
            self.section,
            span,
            &self.steps,
            [stubs[0].as_ref(), stubs[1].as_ref()],
        );
        let (knots, stubs) = match fast {
            Ok(knots) => (knots, stubs),
            Err(_) if stubs.iter().any(Option::is_some) => {
                let knots = refine(self.section, span, &self.steps, [None; 2])?;
                (knots, [None, None])
            }
            Err(at) => return Err(at),
        };
        let [before, after] = stubs;
        let whole = Span {
            from: if before.is_some() { first.t } else { span.from },
            to: if after.is_some() { last.t } else { span.to },
        };
        let mut out: Vec<Knot> = Vec::with_capacity(knots.len());
        let parts = [
            before.map(|stub| stub.knots),
            Some(knots),
            after.map(|stub| stub.knots),
        ];
        for part in parts.into_iter().flatten() {
            // The next part begins in the state in which the last one ended.
            let from = out.pop().map_or(0.0, |last| last.t);
            out.extend(part.iter().map(|knot| Knot {
                t: knot.t + from,
                ..*knot
            }));
        }
        Ok((whole, out))
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

/// A faster motion over a span of the base, its times from 0, that begins and ends in the states of
/// the stubs beside it or of the base; or about the time in the base of the place that was in the
/// way.
fn refine(
    section: &Section<'_>,
    span: Span,
    steps: &Steps,
    stubs: [Option<&Stub>; 2],
) -> Result<Vec<Knot>, f64> {
    let (base, Span { from, to }) = (section.base, span);
    let middle = 0.5 * (from + to);
    let (times, meetings) = steps.times(section, [from, to]);
    let mut states: Vec<PathState> = states(base, times.iter().copied()).collect();
    // Without rounding: a place beside the meeting is on another piece.
    for (k, s) in meetings {
        states[k].s = s;
    }
    let [before, after] = stubs.map(|stub| stub.map(|stub| stub.knots.as_slice()));
    let last = states.len() - 1;
    for (k, knot) in [
        (0, before.and_then(<[Knot]>::last)),
        (last, after.and_then(<[Knot]>::first)),
    ] {
        if let Some(knot) = knot {
            (states[k].v, states[k].a) = (knot.v, knot.a);
        }
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
            first * steps.usual_s,
            LAST_COMPLEMENTARITY * steps.usual_s,
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
