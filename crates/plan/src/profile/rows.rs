//! What the limits of velocity, acceleration and jerk ask of the speed over each interval of a
//! part.

use super::Section;
use super::barrier::{BarrierProblem, Row};
use super::certificate::KEPT_SHARE;
use super::course::JointCourse;
use super::spline::Grid;

/// Parts of the limits of acceleration and jerk that are planned for; the rest is for what happens
/// between the places where they are imposed. A choice: higher needs repairs, lower is slower.
const GOALS: [f64; 2] = [0.9985, 0.99];
/// Part of the speed limit that is planned for. A choice: higher needs repairs, lower is slower.
const SPEED_PART: f64 = 0.9999;
/// Intervals at either end that may use all of the speed limit, since the state given there may. A
/// choice: the given coefficients reach over two intervals, and one more leaves the limit.
const END_INTERVALS: usize = 3;

/// Limits at the ends of each interval.
pub(super) fn problem<'a>(section: &Section<'_>, grid: &'a Grid) -> Option<BarrierProblem<'a>> {
    let moves = |joint: usize| {
        section
            .intervals
            .iter()
            .any(|interval| interval.demand.d[0][joint] > 0.0)
    };
    let moving: Vec<(usize, [f64; 3])> = section
        .machine
        .joints()
        .filter(|(joint, _)| moves(*joint))
        .collect();
    let mut course = JointCourse::new(section);
    let (mut caps, mut rows) = (
        Vec::with_capacity(grid.len()),
        Vec::with_capacity(6 * moving.len() * grid.len()),
    );
    for interval in 0..grid.len() {
        let span = course.over(grid.nodes[interval], grid.nodes[interval + 1])?;
        let mut cap = span.feed;
        for (joint, [v, a, j]) in &moving {
            let [left, right] =
                [0, 1].map(|end| [0, 1, 2].map(|order| span.ends[end].d[order][*joint]));
            cap = cap.min(v / left[0].abs().max(right[0].abs()).max(f64::MIN_POSITIVE));
            let half = 0.5 * grid.width(interval);
            // b and b' at an end from those in the middle.
            let [low, high] = [0, 1].map(|side| span.third[side][*joint]);
            // q'' b + q' b'/2 at the right end, expanded about the middle.
            let acceleration = [
                right[1],
                right[1] * half + 0.5 * right[0],
                0.5 * half * (right[1] * half + right[0]),
            ];
            for side in [1.0, -1.0] {
                // The state at the very end is given.
                let share = if interval + 1 < grid.len() {
                    side / a
                } else {
                    0.0
                };
                rows.push(Row {
                    f: acceleration.map(|f| f * share),
                    end: 0.0,
                });
                // The extreme third derivative to this side bounds all of the interval.
                let third = if side > 0.0 { high } else { low };
                for (end, at) in [(-1.0, &left), (1.0, &right)] {
                    let x = end * half;
                    // q''' b + 3/2 q'' b' + q' b''/2; the factor sqrt(b) is taken by the solver.
                    let jerk = [
                        third,
                        third * x + 1.5 * at[1],
                        0.5 * third * x * x + 1.5 * at[1] * x + 0.5 * at[0],
                    ];
                    rows.push(Row {
                        f: jerk.map(|f| f * side / j),
                        end,
                    });
                }
            }
        }
        let near = interval.min(grid.len() - 1 - interval) < END_INTERVALS;
        caps.push(
            cap * cap
                * if near {
                    KEPT_SHARE
                } else {
                    SPEED_PART * SPEED_PART
                },
        );
    }
    // At a node both sides' caps hold; the speed at the very end is given.
    for interval in 1..grid.len() {
        caps[interval - 1] = caps[interval - 1].min(caps[interval]);
    }
    if let Some(last) = caps.last_mut() {
        *last = f64::INFINITY;
    }
    Some(BarrierProblem::new(
        grid,
        caps,
        rows,
        vec![GOALS; grid.len()],
    ))
}
