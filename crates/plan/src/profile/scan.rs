//! The highest speed profile below the caps that the acceleration allows.

use super::{Cell, Node, Task};

/// An upper bound of the speed squared, linear on each piece and never rising within one.
#[derive(Clone, Copy, Debug)]
struct Ceiling {
    from: Node,
    to: Node,
    cell: usize,
}

/// The profile from `task.from` to rest at the end of the cells.
pub(super) fn scan(task: &Task<'_>, cells: &[Cell]) -> Vec<Node> {
    let ceilings = backward(task, cells);
    forward(task, cells, &ceilings)
}

/// Constant acceleration over a distance whose bound holds up to the speed that it leads to.
///
/// The bound a(v) never rises, so g(a) = a(speed after the distance at a) falls, and applying it an odd number of times,
/// starting above the fixed point, ends at or below it.
fn steady(task: &Task<'_>, cell: &Cell, b: f64, distance: f64) -> f64 {
    let top = cell.cap * cell.cap;
    let start = cell.acceleration(task, b.sqrt());
    if cell.straight {
        return start;
    }
    let next = |a: f64| cell.acceleration(task, (b + 2.0 * a * distance).min(top).sqrt());
    next(next(next(start)))
}

/// What still allows to stop at the end, from the end to the start; returned in rising order.
fn backward(task: &Task<'_>, cells: &[Cell]) -> Vec<Ceiling> {
    let mut ceilings = Vec::with_capacity(2 * cells.len());
    let mut b = 0.0_f64;
    for (index, cell) in cells.iter().enumerate().rev() {
        let (length, top) = (cell.end - cell.start, cell.cap * cell.cap);
        b = b.min(top);
        let a = steady(task, cell, b, length);
        let reached = b + 2.0 * a * length;
        let end = Node::new(cell.end, b);
        if reached <= top {
            ceilings.push(Ceiling { from: Node::new(cell.start, reached), to: end, cell: index });
            b = reached;
        } else {
            let corner = Node::new(cell.end - (top - b) / (2.0 * a), top);
            if end.s > corner.s {
                ceilings.push(Ceiling { from: corner, to: end, cell: index });
            }
            ceilings.push(Ceiling { from: Node::new(cell.start, top), to: corner, cell: index });
            b = top;
        }
    }
    ceilings.reverse();
    ceilings
}

/// Speeds up from the start as far as the ceiling lets it.
fn forward(task: &Task<'_>, cells: &[Cell], ceilings: &[Ceiling]) -> Vec<Node> {
    let mut nodes = Vec::with_capacity(2 * ceilings.len() + 1);
    let mut here = Node::new(task.from, task.speed_squared);
    nodes.push(here);
    for ceiling in ceilings {
        here = advance(task, &cells[ceiling.cell], ceiling, here, &mut nodes);
    }
    nodes
}

fn advance(task: &Task<'_>, cell: &Cell, ceiling: &Ceiling, here: Node, nodes: &mut Vec<Node>) -> Node {
    let length = ceiling.to.s - here.s;
    if length <= 0.0 {
        return here;
    }
    let fall = (ceiling.from.b - ceiling.to.b).max(0.0) / (ceiling.to.s - ceiling.from.s).max(f64::MIN_POSITIVE);
    let gap = ceiling.from.b - here.b;
    let mut end = ceiling.to;
    if gap > 0.0 {
        let a = steady(task, cell, here.b, length);
        let way = gap / (2.0 * a + fall);
        if way < length {
            let meeting = here.s + way;
            nodes.push(Node::new(meeting, (ceiling.from.b - fall * way).max(ceiling.to.b)));
        } else {
            end = Node::new(ceiling.to.s, (here.b + 2.0 * a * length).min(ceiling.to.b));
        }
    }
    nodes.push(end);
    end
}
