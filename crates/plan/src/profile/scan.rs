//! The highest speed profile below the caps that the acceleration allows.

use super::{Cell, Node, Task};
use crate::demand::Direction;
use lostmotion_base::root::Bracket;

/// What a profile is planned over.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground<'a> {
    pub(super) task: &'a Task<'a>,
    pub(super) cells: &'a [Cell],
    /// Intervals that make demands in the cells.
    pub(super) members: &'a [usize],
}

/// An upper bound of the speed squared, linear on each piece and never rising within one.
#[derive(Clone, Copy, Debug)]
struct Ceiling {
    from: Node,
    to: Node,
    cell: usize,
}

/// The profile from `task.from` to rest at the end of the cells.
pub(super) fn scan(ground: &Ground<'_>) -> Vec<Node> {
    let ceilings = backward(ground);
    forward(ground, &ceilings)
}

/// Part of the cap of the squared speed by which that rises in a step of a curved cell, at most
/// about, since the bound of the acceleration depends on the speed. A choice: smaller steps follow
/// the bound closer and cost time in proportion.
const SPEED_STEP: f64 = 0.08;
/// Halvings in the search for the acceleration of a step. A choice: what is lost is 1/32 of the
/// bracket, on the safe side.
const ACCELERATION_HALVINGS: usize = 5;
/// Halvings while none was found at all, which would leave the motion at rest.
const MAX_HALVINGS: usize = 100;
/// A step that ends within this part of its length of an edge ends at the edge: rounding.
const EDGE_ROUNDING: f64 = 1e-9;
/// Part of a ceiling within which the motion is on it: rounding.
const CEILING_ROUNDING: f64 = 1e-12;

/// A step of constant acceleration: how far, and how much.
#[derive(Clone, Copy, Debug)]
struct Step {
    distance: f64,
    a: f64,
}

/// The next step up from a speed, within a distance: as much as the bound allows at the speed that
/// the step leads to.
fn step(ground: &Ground<'_>, direction: Direction, cell: &Cell, b: f64, distance: f64) -> Step {
    // Nearly straight cells have one acceleration for all speeds.
    if !cell.straight
        && let Some(a) = cell.gentle(ground.task, ground.members, direction)
    {
        return Step { distance, a };
    }
    let top = cell.cap * cell.cap;
    let high = cell.acceleration(ground.task, ground.members, direction, b.sqrt());
    if cell.straight {
        return Step { distance, a: high };
    }
    // Short enough that the bound changes little within the step.
    let distance = distance.min(SPEED_STEP * top / (2.0 * high).max(f64::MIN_POSITIVE));
    let exit = |a: f64| (b + 2.0 * a * distance).min(top).sqrt();
    let allows = |a: f64| cell.allows(ground.task, ground.members, direction, exit(a), a);
    // The bound never rises with the speed: what holds at a higher speed holds at all below.
    let low = cell.acceleration(ground.task, ground.members, direction, exit(high));
    // The largest acceleration whose exit speed still allows it.
    let mut bracket = Bracket::new(low, high).bisect(ACCELERATION_HALVINGS, allows);
    for _ in ACCELERATION_HALVINGS..MAX_HALVINGS {
        if bracket.low > 0.0 {
            break;
        }
        bracket = bracket.bisect(1, allows);
    }
    Step {
        distance,
        a: bracket.low,
    }
}

/// What still allows to stop at the end, from the end to the start; returned in rising order.
fn backward(ground: &Ground<'_>) -> Vec<Ceiling> {
    let mut ceilings = Vec::with_capacity(2 * ground.cells.len());
    let mut b = 0.0_f64;
    for (index, cell) in ground.cells.iter().enumerate().rev() {
        let top = cell.cap * cell.cap;
        // At the boundary both this cap and the ceiling of the next cell hold.
        let mut end = Node::new(cell.end, b.min(top));
        while end.s > cell.start {
            // At the cap along it; below it up, backward in time, as steeply as slowing down
            // allows.
            let from = if end.b >= top {
                Node::new(cell.start, top)
            } else {
                fall(ground, cell, end)
            };
            ceilings.push(Ceiling {
                from,
                to: end,
                cell: index,
            });
            end = from;
        }
        b = end.b;
    }
    ceilings.reverse();
    ceilings
}

/// One step back from a node below the cap.
fn fall(ground: &Ground<'_>, cell: &Cell, end: Node) -> Node {
    let top = cell.cap * cell.cap;
    let Step { distance, a } = step(ground, Direction::Slower, cell, end.b, end.s - cell.start);
    let reached = end.b + 2.0 * a * distance;
    // The ramp meets the cap within the step.
    if reached >= top {
        let s = (end.s - (top - end.b) / (2.0 * a)).max(cell.start);
        return if s < end.s {
            Node::new(s, top)
        } else {
            Node::new(cell.start, top)
        };
    }
    let s = end.s - distance;
    // A step too small to count, or one that ends within rounding of the cell's edge, goes all the
    // way.
    let s = if s >= end.s || s - cell.start < EDGE_ROUNDING * distance {
        cell.start
    } else {
        s
    };
    Node::new(s, reached)
}

/// Speeds up from the start as far as the ceiling lets it.
fn forward(ground: &Ground<'_>, ceilings: &[Ceiling]) -> Vec<Node> {
    let mut nodes = Vec::with_capacity(2 * ceilings.len() + 1);
    let mut here = Node::new(ground.task.from, ground.task.speed_squared);
    nodes.push(here);
    for ceiling in ceilings {
        while here.s < ceiling.to.s {
            here = advance(ground, &ground.cells[ceiling.cell], ceiling, here);
            nodes.push(here);
        }
    }
    nodes
}

/// One step ahead below a ceiling, or along it.
fn advance(ground: &Ground<'_>, cell: &Cell, ceiling: &Ceiling, here: Node) -> Node {
    let fall = (ceiling.from.b - ceiling.to.b).max(0.0) / (ceiling.to.s - ceiling.from.s);
    let gap = ceiling.from.b - fall * (here.s - ceiling.from.s) - here.b;
    let length = ceiling.to.s - here.s;
    // On the ceiling within rounding.
    if gap <= CEILING_ROUNDING * ceiling.from.b {
        return ceiling.to;
    }
    let Step { distance, a } = step(ground, Direction::Faster, cell, here.b, length);
    // Both the ramp and the ceiling are linear in s, so that they meet here.
    let way = gap / (2.0 * a + fall);
    if way < distance {
        let s = here.s + way;
        return if s > here.s {
            Node::new(s, (here.b + 2.0 * a * way).max(ceiling.to.b))
        } else {
            ceiling.to
        };
    }
    let s = here.s + distance;
    let s = if s <= here.s || ceiling.to.s - s < EDGE_ROUNDING * distance {
        ceiling.to.s
    } else {
        s
    };
    let b = here.b + 2.0 * a * distance;
    Node::new(
        s,
        if s >= ceiling.to.s {
            b.min(ceiling.to.b)
        } else {
            b
        },
    )
}
