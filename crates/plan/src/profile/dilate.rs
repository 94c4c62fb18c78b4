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
        let bound = |interval: &Interval| task.machine.acceleration(&interval.demand, interval.cap, v, task.window_s);
        task.intervals[self.first..self.past].iter().map(bound).fold(f64::INFINITY, f64::min)
    }
}

/// Boundaries nearer to each other than this part of a reach become one; the cell then takes in the demands of both sides.
const MERGE: f64 = 0.02;

/// Cells from `task.from` to the end, or to where demands not known yet may reach back.
/// Also tells up to where the demands of each interval hold.
pub(super) fn dilate(task: &Task<'_>) -> (Vec<Cell>, Vec<f64>) {
    let reaches = reaches(task);
    let end = settled_end(task);
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
        cells.push(Cell { start, end, cap, first, past, straight });
    }
    (cells, reaches.into_iter().map(|reach| reach.1).collect())
}

/// How far the motion gets in a time from an interval's edge, over its neighbours, at no more than a speed.
///
/// The interval's own cap holds as far as this, so that the motion cannot get farther.
fn outward<'a>(speed: f64, time_s: f64, neighbours: impl Iterator<Item = &'a Interval>) -> f64 {
    let (mut time, mut distance) = (time_s, 0.0);
    for interval in neighbours {
        let (length, v) = (interval.end - interval.start, speed.min(interval.cap));
        if length >= v * time {
            return distance + v * time;
        }
        time -= length / v;
        distance += length;
    }
    distance
}

/// From where to where each interval's demands hold; both rise from one interval to the next.
fn reaches(task: &Task<'_>) -> Vec<(f64, f64)> {
    let (intervals, half) = (task.intervals, 0.5 * task.window_s);
    let mut reaches: Vec<(f64, f64)> = intervals
        .iter()
        .enumerate()
        .map(|(k, interval)| {
            let low = interval.start - outward(interval.cap, half, intervals[..k].iter().rev());
            (low, interval.end + outward(interval.cap, half, intervals[k + 1..].iter()))
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
fn settled_end(task: &Task<'_>) -> f64 {
    let Some(last) = task.intervals.last() else { return task.from };
    if task.complete {
        return last.end;
    }
    // One window, not half of one: the window of the last point planned must not see the unknown either.
    let back = outward(f64::INFINITY, task.window_s, task.intervals.iter().rev());
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
