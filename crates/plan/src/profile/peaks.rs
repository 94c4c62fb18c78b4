//! Widens peaks of the speed to plateaus of at least one window.
//!
//! This is the opening of the profile by a flat element that lasts one window: the highest profile
//! below the given one in which every local maximum lasts that long. Lowering the speed to a
//! constant breaks no limit.

use super::Node;

/// Part of a window from which on a plateau counts as that long: 1 but for rounding.
const WINDOW_ROUNDING: f64 = 1.0 - 1e-9;
/// Speeds squared that differ by less than this part are the same but for rounding.
const SAME_LEVEL: f64 = 1e-12;

/// The profile with every peak held for at least `window_s`. A profile that starts moving is taken
/// to have a plateau before its start.
pub(super) fn widen(nodes: &[Node], window_s: f64) -> Vec<Node> {
    let mut done: Vec<Node> = Vec::with_capacity(nodes.len());
    for &node in nodes {
        let level = done.last().map_or(node.b, |top| {
            if (node.b - top.b).abs() <= SAME_LEVEL * top.b {
                top.b
            } else {
                node.b
            }
        });
        let node = Node::new(node.s, level);
        // Coming down ends a plateau. Lowering it may merge it with the one below, which is then
        // looked at in turn.
        while done.last().is_some_and(|top| node.b < top.b) && lower(&mut done, node, window_s) {}
        done.push(node);
    }
    done
}

/// Lowers the plateau at the end of `done`, which `next` comes down from, if it is a peak and too
/// short. False when nothing is left to do.
fn lower(done: &mut Vec<Node>, next: Node, window_s: f64) -> bool {
    let Some(&right) = done.last() else {
        return false;
    };
    let mut first = done.len() - 1;
    // The plateau is all nodes of one level.
    while first > 0 && done[first - 1].b == right.b {
        first -= 1;
    }
    // A peak has lower speeds on both sides.
    if first == 0 || done[first - 1].b > right.b {
        return false;
    }
    let (before, left) = (done[first - 1], done[first]);
    let width = right.s - left.s;
    if width >= right.b.sqrt() * window_s * WINDOW_ROUNDING {
        return false;
    }
    // Both flanks are linear in the speed squared: at the speed v the peak is width + slope (b -
    // v2) wide.
    let rise = (left.s - before.s) / (left.b - before.b);
    let fall = (next.s - right.s) / (right.b - next.b);
    let slope = rise + fall;
    // A plateau at the speed v has to be v T wide: a quadratic in v, whose positive root is written
    // without cancellation.
    let reach = width + slope * right.b;
    let v = 2.0 * reach / (window_s + (window_s * window_s + 4.0 * slope * reach).sqrt());
    // Lowered to the higher neighbour at most; what is then wider is looked at again.
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WINDOW_S: f64 = 0.04;

    /// Speed squared of a profile at a place.
    fn at(nodes: &[Node], s: f64) -> f64 {
        let pair = nodes
            .windows(2)
            .find(|pair| pair[0].s <= s && s <= pair[1].s && pair[1].s > pair[0].s);
        pair.map_or(0.0, |pair| {
            pair[0].b + (pair[1].b - pair[0].b) * (s - pair[0].s) / (pair[1].s - pair[0].s)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

        /// The opening, straight from its definition on a grid: a place has the level of the best
        /// stretch around it that is nowhere lower and lasts a window at that level.
        #[test]
        fn it_is_the_opening_by_one_window(steps in prop::collection::vec((0.2..3.0f64, 0.0..9000.0f64), 1..8)) {
            let mut nodes = vec![Node::new(0.0, 0.0)];
            let mut s = 0.0;
            for (length, b) in steps {
                s += length;
                nodes.push(Node::new(s, b));
            }
            nodes.push(Node::new(s + 1.0, 0.0));
            let widened = widen(&nodes, WINDOW_S);
            let cells = 600;
            let place = |k: usize| (s + 1.0) * (k as f64 / f64::from(cells));
            let speeds: Vec<f64> = (0..=cells as usize).map(|k| at(&nodes, place(k)).sqrt()).collect();
            for k in (0..=cells as usize).step_by(29) {
                let holds = |level: f64| {
                    let low = (0..=k).rev().take_while(|&i| speeds[i] >= level).last();
                    let high = (k..speeds.len()).take_while(|&i| speeds[i] >= level).last();
                    low.zip(high).is_some_and(|(low, high)| place(high) - place(low) >= level * WINDOW_S)
                };
                let best = (0..2000).map(|n| f64::from(n) * 0.05).filter(|&level| holds(level)).fold(0.0, f64::max);
                let found = at(&widened, place(k)).sqrt();
                // The grid is coarse in place and level: as much as the profile's speed changes
                // over two of its cells.
                let around = [k.saturating_sub(2), (k + 2).min(cells as usize)].map(|i| (speeds[i] - speeds[k]).abs());
                prop_assert!((found - best).abs() <= around[0].max(around[1]) + 2.0, "{found} {best} at {}", place(k));
                prop_assert!(found <= speeds[k] + 1e-6);
            }
        }
    }
}
