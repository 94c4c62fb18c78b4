//! From demands along the path to a speed profile that keeps every limit.
//!
//! The profile planned here has piecewise constant acceleration; the moving average over the window
//! T that the sampler applies makes its jerk finite. Every step keeps what that average needs:
//!
//! 1. [`dilate`]: the demands of each interval hold for as far around it as a window reaches, so
//!    that speed and acceleration everywhere in a window keep the limits of the point at its
//!    middle, and then so does their mean (|q''| v2 + |q'| a is convex).
//! 2. [`scan`]: the highest speed below the caps, backward and forward, with the acceleration
//!    carried across.
//! 3. [`peaks`]: between speeding up and slowing down lies at least one window, so that the
//!    acceleration in any window changes by no more than its bound.
//! 4. [`average`]: the moving average itself, as corners of piecewise constant jerk.
//! 5. [`law`]: between two states that cannot change any more, a time law may find a faster motion
//!    than that.

mod average;
mod barrier;
mod certificate;
mod course;
mod cut;
mod dilate;
mod ideal;
pub(crate) mod law;
mod node;
mod peaks;
pub(crate) mod refined;
mod rows;
mod scan;
mod spans;
mod spline;

pub(crate) use average::average;
pub(crate) use certificate::Certificate;
pub(crate) use cut::last_cut;
pub(crate) use dilate::Cell;
use dilate::Dilated;
pub(crate) use ideal::ideal;
pub(crate) use law::{Knot, Motion, Profile, Section, TimeLaw};
pub(crate) use node::{Node, duration_s};
use scan::Ground;

use crate::machine::{Demand, Machine};

/// A stretch of path with one set of bounds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Interval {
    /// Where it begins on the path.
    pub(crate) start: f64,
    /// Where it ends.
    pub(crate) end: f64,
    pub(crate) demand: Demand,
    /// Largest steady speed.
    pub(crate) cap: f64,
}

/// What to plan.
#[derive(Debug)]
pub(crate) struct Task<'a> {
    pub(crate) machine: &'a Machine,
    /// Consecutive intervals; those before `from` are there for what they demand of their
    /// neighbourhood.
    pub(crate) intervals: &'a [Interval],
    /// Where the profile begins.
    pub(crate) from: f64,
    /// Square of the speed there: 0, or that of a plateau of at least a window's length.
    pub(crate) speed_squared: f64,
    /// Whether the path stops at the end of the intervals; else it goes on with demands not known
    /// yet.
    pub(crate) complete: bool,
    /// Window of the moving average, s.
    pub(crate) window_s: f64,
}

/// A planned profile.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// Its corners; the speed squared is linear in between.
    pub(crate) nodes: Vec<Node>,
    /// The demands that it kept.
    pub(crate) cells: Vec<Cell>,
    /// Up to where the demands of each interval hold.
    pub(crate) reach_ends: Vec<f64>,
}

/// Plans from `task.from` to a stop: at the end of the path if it is known, else as far as the
/// demands are settled.
pub(crate) fn plan(task: &Task<'_>) -> Plan {
    let Dilated {
        cells,
        members,
        reach_ends,
    } = dilate::dilate(task);
    let nodes = scan::scan(&Ground {
        task,
        cells: &cells,
        members: &members,
    });
    Plan {
        nodes: peaks::widen(&nodes, task.window_s),
        cells,
        reach_ends,
    }
}
