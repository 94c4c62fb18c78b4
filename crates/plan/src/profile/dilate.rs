//! Spreads each interval's demands over the reach of a window around it.

use super::{Interval, Task};

/// A stretch of path with everything whose window reaches it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) start: f64,
    pub(crate) end: f64,
    /// Largest steady speed.
    pub(crate) cap: f64,
    /// Which intervals make demands here: first, and one past the last. Each by itself has to be met; their joint maximum
    /// would ask for the curvature of one and the slope of another at the same time.
    first: usize,
    past: usize,
    /// Whether the bound of the acceleration is the same at all speeds.
    pub(crate) straight: bool,
}

impl Cell {
    /// Largest acceleration at a speed; never rises with it.
    pub(crate) fn acceleration(&self, task: &Task<'_>, v: f64) -> f64 {
        let bound = |interval: &Interval| task.machine.acceleration(&interval.demand, v, task.window_s);
        task.intervals[self.first..self.past].iter().map(bound).fold(f64::INFINITY, f64::min)
    }
}

/// Boundaries nearer to each other than this part of a reach become one; the cell then takes in the demands of both sides.
const MERGE: f64 = 0.02;
/// Curved cells are split until the speed squared changes by about this part of its cap, so that the bound of the
/// acceleration, which depends on the speed, is met closely.
const SPEED_STEP: f64 = 0.08;
/// Most parts of a curved cell.
const MAX_PARTS: f64 = 16.0;

/// Cells from `task.from` to the end, or to where demands not known yet may reach back.
/// Also tells up to where the demands of each interval hold.
pub(super) fn dilate(task: &Task<'_>) -> (Vec<Cell>, Vec<f64>) {
    let rest: Vec<f64> = task.intervals.iter().map(|i| task.machine.acceleration(&i.demand, 0.0, task.window_s)).collect();
    let reaches = reaches(task, &rest);
    let end = settled_end(task, &rest);
    let marks = boundaries(task, &reaches, end);
    let mut cells = Vec::with_capacity(marks.len());
    let mut first = 0;
    for pair in marks.windows(2) {
        let (start, end) = (pair[0], pair[1]);
        while first + 1 < reaches.len() && reaches[first].1 <= start {
            first += 1;
        }
        let past = first + reaches[first..].partition_point(|reach| reach.0 < end);
        let here = &task.intervals[first..past];
        let cap = here.iter().map(|interval| interval.cap).fold(f64::INFINITY, f64::min);
        let straight = here.iter().all(|interval| interval.demand.is_straight());
        split(&mut cells, Cell { start, end, cap, first, past, straight }, task);
    }
    (cells, reaches.into_iter().map(|reach| reach.1).collect())
}

/// Adds a cell, in parts if the acceleration depends on the speed.
fn split(cells: &mut Vec<Cell>, cell: Cell, task: &Task<'_>) {
    let length = cell.end - cell.start;
    let parts = if cell.straight {
        1.0
    } else {
        let rise = 2.0 * cell.acceleration(task, 0.0) * length;
        (rise / (SPEED_STEP * cell.cap * cell.cap)).ceil().clamp(1.0, MAX_PARTS)
    };
    let mut start = cell.start;
    for part in 1..=(parts as usize) {
        let end = if part as f64 >= parts { cell.end } else { cell.start + length * (part as f64 / parts) };
        cells.push(Cell { start, end, ..cell.clone() });
        start = end;
    }
}

/// How far the motion gets in half a window: from an interval's edge, outward over its neighbours, speeding up as they allow.
fn outward<'a>(speed: f64, window_s: f64, neighbours: impl Iterator<Item = (&'a Interval, &'a f64)>) -> f64 {
    let (mut v, mut time, mut distance) = (speed, 0.5 * window_s, 0.0);
    for (interval, &acceleration) in neighbours {
        let length = interval.end - interval.start;
        let entry = v.min(interval.cap);
        let exit = (entry * entry + 2.0 * acceleration * length).sqrt();
        let needed = if exit < interval.cap { 2.0 * length / (entry + exit) } else { length / interval.cap };
        if needed >= time {
            let way = (entry + 0.5 * acceleration * time) * time;
            return distance + way.min(interval.cap * time).min(length);
        }
        time -= needed;
        distance += length;
        v = exit.min(interval.cap);
    }
    distance
}

/// From where to where each interval's demands hold; both rise from one interval to the next.
fn reaches(task: &Task<'_>, rest: &[f64]) -> Vec<(f64, f64)> {
    let intervals = task.intervals;
    let mut reaches: Vec<(f64, f64)> = intervals
        .iter()
        .enumerate()
        .map(|(k, interval)| {
            let before = intervals[..k].iter().zip(&rest[..k]).rev();
            let after = intervals[k + 1..].iter().zip(&rest[k + 1..]);
            let low = interval.start - outward(interval.cap, task.window_s, before);
            (low, interval.end + outward(interval.cap, task.window_s, after))
        })
        .collect();
    for k in 1..reaches.len() {
        reaches[k].1 = reaches[k].1.max(reaches[k - 1].1);
    }
    for k in (1..reaches.len()).rev() {
        reaches[k - 1].0 = reaches[k - 1].0.min(reaches[k].0);
    }
    reaches
}

/// Up to where the demands cannot change any more by what comes after the last interval.
fn settled_end(task: &Task<'_>, rest: &[f64]) -> f64 {
    let Some(last) = task.intervals.last() else { return task.from };
    if task.complete {
        return last.end;
    }
    // One window, not half of one: the window of the last point planned must not see the unknown either.
    let back = outward(last.cap, 2.0 * task.window_s, task.intervals.iter().zip(rest).rev());
    (last.end - back).max(task.from)
}

/// Boundaries of cells in rising order.
fn boundaries(task: &Task<'_>, reaches: &[(f64, f64)], end: f64) -> Vec<f64> {
    let mut marks = Vec::with_capacity(3 * reaches.len());
    for (interval, (low, high)) in task.intervals.iter().zip(reaches) {
        let (before, after) = (interval.start - low, high - interval.end);
        marks.push((*low, before * MERGE));
        marks.push((*high, after * MERGE));
        marks.push((interval.end, before.min(after) * MERGE));
    }
    marks.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut boundaries = vec![task.from];
    let mut last = task.from;
    for (mark, gap) in marks {
        if mark > last && mark - last > gap && end - mark > gap {
            boundaries.push(mark);
            last = mark;
        }
    }
    if end > last {
        boundaries.push(end);
    }
    boundaries
}
