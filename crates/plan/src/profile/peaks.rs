//! Widens peaks of the speed to plateaus of at least one window.
//!
//! This is the opening of the profile by a flat element that lasts one window: the highest profile below the given one in
//! which every local maximum lasts that long. Lowering the speed to a constant breaks no limit.

use super::Node;

/// Less than a window by rounding only.
const ROUNDING: f64 = 1.0 - 1e-9;
/// Speeds squared that differ by less than this part are the same but for rounding.
const SAME: f64 = 1e-12;

/// The profile with every peak held for at least `window_s`. A profile that starts moving is taken to have a plateau
/// before its start.
pub(super) fn widen(nodes: &[Node], window_s: f64) -> Vec<Node> {
    let mut done: Vec<Node> = Vec::with_capacity(nodes.len());
    for &node in nodes {
        let level = done.last().map_or(node.b, |top| if (node.b - top.b).abs() <= SAME * top.b { top.b } else { node.b });
        let node = Node::new(node.s, level);
        while done.last().is_some_and(|top| node.b < top.b) && lower(&mut done, node, window_s) {}
        done.push(node);
    }
    done
}

/// Lowers the plateau at the end of `done`, which `next` comes down from, if it is a peak and too short. False when
/// nothing is left to do.
fn lower(done: &mut Vec<Node>, next: Node, window_s: f64) -> bool {
    let Some(&right) = done.last() else { return false };
    let mut first = done.len() - 1;
    while first > 0 && done[first - 1].b == right.b {
        first -= 1;
    }
    if first == 0 || done[first - 1].b > right.b {
        return false;
    }
    let (before, left) = (done[first - 1], done[first]);
    let width = right.s - left.s;
    if width >= right.b.sqrt() * window_s * ROUNDING {
        return false;
    }
    // Both flanks are linear in the speed squared: at the speed v the peak is width + slope (b - v2) wide.
    let rise = (left.s - before.s) / (left.b - before.b);
    let fall = (next.s - right.s) / (right.b - next.b);
    let slope = rise + fall;
    let reach = width + slope * right.b;
    let v = 2.0 * reach / (window_s + (window_s * window_s + 4.0 * slope * reach).sqrt());
    let floor = before.b.max(next.b);
    let level = (v * v).max(floor);
    done.truncate(first);
    let down = right.b - level;
    if level > before.b {
        done.push(Node::new((left.s - rise * down).max(before.s), level));
    }
    if level > next.b {
        done.push(Node::new((right.s + fall * down).min(next.s), level));
        // Only a flank that ends at the level leaves more to lower.
        return level <= before.b;
    }
    true
}
