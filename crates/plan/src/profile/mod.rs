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
//! 3. [`average::widen`]: between speeding up and slowing down lies at least one window, so that the
//!    acceleration in any window changes by no more than its bound.
//! 4. [`average`]: the moving average itself, as corners of piecewise constant jerk.
//! 5. [`TimeLaw`]: between two states that cannot change any more, a time law may find a faster motion
//!    than that.

mod average;
mod barrier;
mod certificate;
mod course;
mod dilate;
mod ideal;
pub(crate) mod refined;
mod scan;
mod spans;
mod spline;
mod steps;
mod stub;

pub(crate) use average::average;
pub(crate) use certificate::Certificate;
pub(crate) use dilate::Cell;
use dilate::Dilated;
pub(crate) use ideal::ideal;
use scan::Ground;

use crate::demand::Interval;
use crate::machine::Machine;
use crate::motion::Knot;
use crate::piece::Piece;
use lostmotion_kinematics::Kinematics;
use std::collections::VecDeque;
use std::sync::Arc;

/// Part of a cap from which on it counts as met: 1 but for rounding.
const CAP_MET: f64 = 1.0 - 1e-12;

/// A corner of a speed profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    /// Place on the path.
    pub(crate) s: f64,
    /// Speed squared, linear in s between corners: constant acceleration.
    pub(crate) b: f64,
}

impl Node {
    pub(crate) fn new(s: f64, b: f64) -> Node {
        Node { s, b }
    }

    /// Time from this corner to the next one, s; `None` where the profile does not advance.
    pub(crate) fn time_to(&self, next: &Node) -> Option<f64> {
        let (distance, speeds) = (next.s - self.s, self.b.sqrt() + next.b.sqrt());
        (distance > 0.0 && speeds > 0.0).then(|| 2.0 * distance / speeds)
    }
}

/// Time that a profile takes, s.
pub(crate) fn duration_s(nodes: &[Node]) -> f64 {
    nodes
        .windows(2)
        .filter_map(|pair| pair[0].time_to(&pair[1]))
        .sum()
}

/// A section of path between two states that are both given: rest, or a steady speed where the
/// look-ahead is sure of it.
#[derive(Debug)]
pub(crate) struct Section<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) kinematics: &'a dyn Kinematics,
    /// Pieces of path that hold the section, each with the place where it begins.
    pub(crate) pieces: &'a VecDeque<(f64, Arc<Piece>)>,
    /// Consecutive intervals that hold the section; their demands bound the joints' derivatives all
    /// over each of them.
    pub(crate) intervals: &'a [Interval],
    /// The profile of which the base is the mean.
    pub(crate) nodes: &'a [Node],
    /// A motion that keeps every limit, from the first state to the last; its times begin at 0.
    pub(crate) base: &'a [Knot],
}

/// Plans the time over a section. Since both its ends are given, each section is planned for
/// itself, and a program as it comes.
pub(crate) trait TimeLaw: std::fmt::Debug + Sync {
    /// A motion with the base's first and last state, nowhere backward, that keeps every limit and
    /// takes no longer.
    fn plan(&self, section: &Section<'_>) -> Vec<Knot>;
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

impl Plan {
    /// The last place up to which the plan cannot change by what comes later: a point on a plateau at
    /// the cap, at least one window after the plateau's beginning. The speed there cannot rise, so
    /// nothing before it depends on what follows, and nothing after it needs to know what came before.
    pub(crate) fn last_cut(&self, window_s: f64) -> Option<Node> {
        let mut cut = None;
        let mut cells = self.cells.iter().peekable();
        let mut plateau = None;
        for pair in self.nodes.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            // A plateau has constant speed; two corners at one place change nothing.
            if a.b != b.b || b.s <= a.s {
                if b.s > a.s {
                    plateau = None;
                }
                continue;
            }
            while cells.next_if(|cell| cell.end <= a.s).is_some() {}
            // At the cap the speed cannot rise by what comes later.
            let at_cap = cells
                .peek()
                .is_some_and(|cell| cell.end >= b.s && a.b >= cell.cap * cell.cap * CAP_MET);
            let begin = *plateau.get_or_insert(a.s);
            let earliest = begin + a.b.sqrt() * window_s;
            // With one window of plateau behind it, the average there does not reach back to what
            // came before.
            if at_cap && earliest < b.s {
                cut = Some(Node::new(b.s, b.b));
            }
        }
        cut
    }
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
        nodes: average::widen(&nodes, task.window_s),
        cells,
        reach_ends,
    }
}
