//! Where a plan over an unfinished path is final.

use super::{Node, Plan};

/// A cap counts as met within rounding.
const MET: f64 = 1.0 - 1e-12;

/// The last place up to which the plan cannot change by what comes later: a point on a plateau at
/// the cap, at least one window after the plateau's beginning. The speed there cannot rise, so
/// nothing before it depends on what follows, and nothing after it needs to know what came before.
pub(crate) fn last_cut(plan: &Plan, window_s: f64) -> Option<Node> {
    let mut cut = None;
    let mut cells = plan.cells.iter().peekable();
    let mut plateau = None;
    for pair in plan.nodes.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        if a.b != b.b || b.s <= a.s {
            if b.s > a.s {
                plateau = None;
            }
            continue;
        }
        while cells.next_if(|cell| cell.end <= a.s).is_some() {}
        let at_cap = cells
            .peek()
            .is_some_and(|cell| cell.end >= b.s && a.b >= cell.cap * cell.cap * MET);
        let begin = *plateau.get_or_insert(a.s);
        let earliest = begin + a.b.sqrt() * window_s;
        if at_cap && earliest < b.s {
            cut = Some(Node::new(b.s, b.b));
        }
    }
    cut
}
