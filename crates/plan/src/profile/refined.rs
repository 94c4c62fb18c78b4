//! A time law that starts from the averaged profile and lowers its time by an interior-point method.

use super::barrier::{Problem, Row};
use super::course::Course;
use super::law::{Knot, Motion, Section, TimeLaw, state_at};
use super::spline::Grid;
use super::usage::usage;

/// Intervals in the longest time over which a joint builds up its acceleration.
const INTERVALS: f64 = 8.0;
/// Fewer intervals are left alone.
const LEAST: usize = 12;
/// Parts of the limits of acceleration and jerk that are planned for; the rest is for what happens between the intervals'
/// middles.
const GOALS: [f64; 2] = [0.9985, 0.99];
/// Part of the speed limit planned for.
const CAP: f64 = 0.9999;
/// So many intervals at either end may use all of it, since what is given there may.
const NEAR: usize = 3;
/// Limits are kept within rounding.
const KEPT: f64 = 1.0 + 1e-6;
/// Complementarity of the interior-point method at first and at last, as a part of an interval's time.
const FIRST: f64 = 0.3;
const LAST: f64 = 1e-4;
/// Most steps of it.
const STEPS: usize = 20;
/// How often limits that are passed are made stricter before the base is kept.
const REPAIRS: usize = 3;

/// The averaged profile, made faster.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refined;

impl TimeLaw for Refined {
    fn plan(&self, section: &Section<'_>) -> Vec<Knot> {
        match refine(section) {
            Some(knots) if knots.last().zip(section.base.last()).is_some_and(|(new, old)| new.t < old.t) => knots,
            _ => section.base.to_vec(),
        }
    }
}

/// From when to when a base may be changed: what sets out from rest or comes to rest keeps the time of one jerk there, since
/// b(s) has no bounded derivatives at rest.
fn span(base: &[Knot], step_s: f64) -> Option<(f64, f64)> {
    let (first, last) = (base.first()?, base.last()?);
    let at = |knot: &Knot| if knot.v > 0.0 { 0.0 } else { INTERVALS * step_s };
    let (from, to) = (at(first), last.t - at(last));
    (to - from >= LEAST as f64 * step_s).then_some((from, to))
}

fn refine(section: &Section<'_>) -> Option<Vec<Knot>> {
    let base = section.base;
    if section.intervals.iter().all(|interval| interval.demand.is_straight()) && section.pieces.len() == 1 {
        return None;
    }
    let step_s = section.machine.longest_window_s() / INTERVALS;
    let (from, to) = span(base, step_s)?;
    let count = ((to - from) / step_s).ceil();
    let states: Vec<_> = (0..=count as usize).map(|k| state_at(base, from + (to - from) * (k as f64 / count))).collect();
    if states.windows(2).any(|pair| pair[1].s <= pair[0].s) || states.iter().any(|state| state.v <= 0.0) {
        return None;
    }
    let grid = Grid::new(states.iter().map(|state| state.s).collect());
    let start = start(base, &grid, &states, (from, to))?;
    let mut problem = problem(section, &grid)?;
    for _ in 0..=REPAIRS {
        let mut c = start.clone();
        problem.solve(&mut c, FIRST * step_s, LAST * step_s, STEPS);
        let knots = knots(base, &grid, &c, (from, to))?;
        if repaired(section, &mut problem, &grid, &knots)? {
            return Some(knots);
        }
    }
    None
}

/// Limits at the ends of each interval.
fn problem<'a>(section: &Section<'_>, grid: &'a Grid) -> Option<Problem<'a>> {
    let moves = |joint: usize| section.intervals.iter().any(|interval| interval.demand.d[0][joint] > 0.0);
    let moving: Vec<(usize, [f64; 3])> = section.machine.joints().filter(|(joint, _)| moves(*joint)).collect();
    let mut course = Course::new(section);
    let (mut caps, mut rows) = (Vec::with_capacity(grid.len()), Vec::with_capacity(6 * moving.len() * grid.len()));
    for interval in 0..grid.len() {
        let span = course.over(grid.nodes[interval], grid.nodes[interval + 1])?;
        let mut cap = span.feed;
        for (joint, [v, a, j]) in &moving {
            let [left, right] = [&span.ends[0], &span.ends[1]].map(|place| place.d.map(|d| d[*joint]));
            cap = cap.min(v / left[0].abs().max(right[0].abs()).max(f64::MIN_POSITIVE));
            let half = 0.5 * grid.width(interval);
            // b and b' at an end from those in the middle.
            let [low, high] = span.third.map(|d3| d3[*joint]);
            let acceleration = [right[1], right[1] * half + 0.5 * right[0], 0.5 * half * (right[1] * half + right[0])];
            for side in [1.0, -1.0] {
                // The state at the very end is given.
                let share = if interval + 1 < grid.len() { side / a } else { 0.0 };
                rows.push(Row { f: acceleration.map(|f| f * share), end: 0.0 });
                let third = if side > 0.0 { high } else { low };
                for (end, at) in [(-1.0, &left), (1.0, &right)] {
                    let x = end * half;
                    let jerk = [third, third * x + 1.5 * at[1], 0.5 * third * x * x + 1.5 * at[1] * x + 0.5 * at[0]];
                    rows.push(Row { f: jerk.map(|f| f * side / j), end });
                }
            }
        }
        let near = interval.min(grid.len() - 1 - interval) < NEAR;
        caps.push(cap * cap * if near { KEPT } else { CAP * CAP });
    }
    // At a node both sides' caps hold; the speed at the very end is given.
    for interval in 1..grid.len() {
        caps[interval - 1] = caps[interval - 1].min(caps[interval]);
    }
    if let Some(last) = caps.last_mut() {
        *last = f64::INFINITY;
    }
    Some(Problem::new(grid, caps, rows, vec![GOALS; grid.len()]))
}

/// Coefficients of the base.
fn start(base: &[Knot], grid: &Grid, states: &[Motion], (from, to): (f64, f64)) -> Option<Vec<f64>> {
    let count = grid.len() as f64;
    let mut c = vec![0.0; grid.len() + 2];
    for interval in 1..grid.len() - 1 {
        let middle = state_at(base, from + (to - from) * ((interval as f64 + 0.5) / count));
        c[interval + 1] = middle.v * middle.v;
    }
    c[..2].copy_from_slice(&grid.ends(false, states.first()?));
    let last = c.len() - 2;
    c[last..].copy_from_slice(&grid.ends(true, states.last()?));
    Some(c)
}

/// The base up to where it was changed, what replaces it, and the rest of the base after it.
fn knots(base: &[Knot], grid: &Grid, c: &[f64], (from, to): (f64, f64)) -> Option<Vec<Knot>> {
    let mut out: Vec<Knot> = base.iter().copied().take_while(|knot| knot.t < from).collect();
    let mut t = from;
    for interval in 0..grid.len() {
        let [first, second, end] = grid.knots(c, interval, t)?;
        out.extend([first, second]);
        t = end.t;
    }
    let index = base.partition_point(|knot| knot.t <= to).saturating_sub(1);
    if let Some(knot) = base.get(index) {
        let state = knot.at(to);
        out.push(Knot { t, s: state.s, v: state.v, a: state.a, j: knot.j });
    }
    out.extend(base.iter().skip(index + 1).map(|knot| Knot { t: knot.t + (t - to), ..*knot }));
    Some(out)
}

/// Whether the motion keeps every limit; where it does not, the goals become stricter.
fn repaired(section: &Section<'_>, problem: &mut Problem<'_>, grid: &Grid, knots: &[Knot]) -> Option<bool> {
    let first = knots.partition_point(|knot| knot.s < grid.nodes[0]);
    let mut course = Course::new(section);
    let mut good = true;
    for interval in 0..grid.len() {
        let used = usage(section.machine, &mut course, &knots[first + 2 * interval..first + 2 * interval + 3])?;
        let [v, a, j] = used;
        good &= v <= KEPT && a <= KEPT && j <= KEPT;
        let near = interval.saturating_sub(2)..(interval + 3).min(grid.len());
        for (kind, used) in [a, j].into_iter().enumerate().filter(|(_, used)| *used > KEPT) {
            for goal in &mut problem.goals[near.clone()] {
                goal[kind] = goal[kind].min(GOALS[kind] * 0.997 / used);
            }
        }
        if v > KEPT {
            for cap in &mut problem.caps[near] {
                *cap *= 0.999 / (v * v);
            }
        }
    }
    Some(good)
}
