//! Spreads each interval's demands over the reach of a window around it.

use super::Task;
use crate::demand::{Demand, Direction, Interval};
use crate::machine::NO_LIMIT;
use std::cell::OnceCell;

/// A stretch of path with everything whose window reaches it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) start: f64,
    pub(crate) end: f64,
    /// Largest steady speed.
    pub(crate) cap: f64,
    /// Where the list of intervals that make demands here begins and ends. Each by itself has to be
    /// met; their joint maximum would ask for the curvature of one and the slope of another at the
    /// same time.
    first: usize,
    past: usize,
    /// Whether the bound of the acceleration is the same at all speeds.
    pub(crate) straight: bool,
    /// See [`Cell::gentle`], by direction.
    gentle: [OnceCell<Option<f64>>; 2],
}

/// A cell is nearly straight if this part of the acceleration of a straight cell is left at its
/// cap. Record 35 of the decisions gives what it costs.
const STRAIGHT_PART: f64 = 0.97;

impl Cell {
    /// An acceleration that holds at all speeds, where the cell is nearly straight.
    pub(super) fn gentle(
        &self,
        task: &Task<'_>,
        members: &[usize],
        direction: Direction,
    ) -> Option<f64> {
        *self.gentle[direction as usize].get_or_init(|| {
            // One maximum over all that reaches the cell bounds each of them.
            let mut all = Demand::NONE;
            let mut cap = self.cap;
            for &index in &members[self.first..self.past] {
                task.machine.join(&mut all, &task.intervals[index].demand);
                cap = cap.max(task.intervals[index].cap);
            }
            // The acceleration without curvature; the part of it that the curvature takes at the
            // cap decides.
            let most = task.machine.straight_acceleration(&all, task.window_s);
            let a = task
                .machine
                .acceleration(&all, direction, cap, self.cap, task.window_s, most);
            (a >= STRAIGHT_PART * most).then_some(a)
        })
    }

    /// Largest acceleration in a direction at a speed; never rises with it. `members` is what
    /// [`dilate`] gave with the cell.
    pub(super) fn acceleration(
        &self,
        task: &Task<'_>,
        members: &[usize],
        direction: Direction,
        v: f64,
    ) -> f64 {
        // What one interval leaves is all that the next one has to be asked about.
        let bound = |most: f64, &index: &usize| {
            let interval = &task.intervals[index];
            task.machine.acceleration(
                &interval.demand,
                direction,
                interval.cap,
                v,
                task.window_s,
                most,
            )
        };
        members[self.first..self.past].iter().fold(NO_LIMIT, bound)
    }

    /// Whether an acceleration is within the bound at a speed.
    pub(super) fn allows(
        &self,
        task: &Task<'_>,
        members: &[usize],
        direction: Direction,
        v: f64,
        a: f64,
    ) -> bool {
        members[self.first..self.past].iter().all(|&index| {
            let interval = &task.intervals[index];
            task.machine.allows(
                &interval.demand,
                direction,
                interval.cap,
                v,
                task.window_s,
                a,
            )
        })
    }
}

/// Boundaries that are nearer to each other than this part of a reach become one; the cell then
/// takes in the demands of both sides. A choice: larger has fewer cells and more demand in each.
const MERGED_REACH: f64 = 0.02;

/// What demands hold where.
#[derive(Debug)]
pub(super) struct Dilated {
    /// Cells from `task.from` to the end, or to where demands not known yet may reach back.
    pub(super) cells: Vec<Cell>,
    /// The lists of intervals that make demands in the cells, one after the other.
    pub(super) members: Vec<usize>,
    /// Up to where the demands of each interval and of all before it hold.
    pub(super) reach_ends: Vec<f64>,
}

/// Spreads the demands.
pub(super) fn dilate(task: &Task<'_>) -> Dilated {
    let reaches = reaches(task);
    let end = settled_end(task);
    let marks = boundaries(task, &reaches, end);
    let (begins, ends) = envelopes(&reaches);
    let intervals = task.intervals.iter();
    let are_straight: Vec<bool> = intervals.map(|each| each.demand.is_straight()).collect();
    let mut cells = Vec::with_capacity(marks.len());
    let mut members = Vec::with_capacity(4 * marks.len());
    let mut low = 0;
    for pair in marks.windows(2) {
        let (start, end) = (pair[0], pair[1]);
        // Reaches end in rising order along the path, so that those that hold here are found by
        // going along.
        while low + 1 < reaches.len() && ends[low] <= start {
            low += 1;
        }
        let high = low + begins[low..].partition_point(|begin| *begin < end);
        let first = members.len();
        members.extend((low..high).filter(|&k| reaches[k].0 < end && reaches[k].1 > start));
        let here = &members[first..];
        let caps = here.iter().map(|&k| task.intervals[k].cap);
        let cap = caps.fold(f64::INFINITY, f64::min);
        let straight = here.iter().all(|&k| are_straight[k]);
        let gentle = [const { OnceCell::new() }; 2];
        cells.push(Cell {
            start,
            end,
            cap,
            first,
            past: members.len(),
            straight,
            gentle,
        });
    }
    Dilated {
        cells,
        members,
        reach_ends: ends,
    }
}

/// Where the first of each interval and all after it begins to demand, and where the last of it and
/// all before ends to.
fn envelopes(reaches: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
    let (mut begins, mut ends): (Vec<f64>, Vec<f64>) = reaches.iter().copied().unzip();
    for k in 1..reaches.len() {
        ends[k] = ends[k].max(ends[k - 1]);
    }
    for k in (1..reaches.len()).rev() {
        begins[k - 1] = begins[k - 1].min(begins[k]);
    }
    (begins, ends)
}

/// Largest distance that the motion covers in a time from an interval's edge over its neighbours,
/// at most at the given speed and within their caps.
///
/// The interval's own cap holds up to there, so that the motion cannot get farther.
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

/// From where to where each interval's demands hold.
fn reaches(task: &Task<'_>) -> Vec<(f64, f64)> {
    let (intervals, half) = (task.intervals, 0.5 * task.window_s);
    intervals
        .iter()
        .enumerate()
        .map(|(k, interval)| {
            let low = interval.start - outward(interval.cap, half, intervals[..k].iter().rev());
            (
                low,
                interval.end + outward(interval.cap, half, intervals[k + 1..].iter()),
            )
        })
        .collect()
}

/// Up to where the demands cannot change any more by what comes after the last interval.
fn settled_end(task: &Task<'_>) -> f64 {
    let Some(last) = task.intervals.last() else {
        return task.from;
    };
    if task.complete {
        return last.end;
    }
    // One window, not half of one: the window of the last point planned must not see the unknown
    // either.
    let back = outward(f64::INFINITY, task.window_s, task.intervals.iter().rev());
    (last.end - back).max(task.from)
}

/// Boundaries of cells in rising order.
fn boundaries(task: &Task<'_>, reaches: &[(f64, f64)], end: f64) -> Vec<f64> {
    let mut marks = Vec::with_capacity(3 * reaches.len());
    let along = || task.intervals.iter().zip(reaches);
    // A boundary may be left out if it is within a part of its own reach of the last one. Each kind by
    // itself mostly rises, which leaves little to sort.
    marks.extend(along().map(|(interval, (low, _))| (*low, (interval.start - low) * MERGED_REACH)));
    marks
        .extend(along().map(|(interval, (_, high))| (*high, (high - interval.end) * MERGED_REACH)));
    marks.extend(along().map(|(interval, (low, high))| {
        let (before, after) = (interval.start - low, high - interval.end);
        (interval.end, before.min(after) * MERGED_REACH)
    }));
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
