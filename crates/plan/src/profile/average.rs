//! The moving average of a speed profile over time, which has limited jerk, and the widening of peaks
//! before it.
//!
//! Peaks are widened to plateaus of at least one window by the opening of the profile by a flat
//! element that lasts one window: the highest profile below the given one in which every local
//! maximum lasts that long. Lowering the speed to a constant breaks no limit.

use super::Node;
use crate::motion::Knot;

/// Steps of the acceleration that are nearer to each other than this, s, are taken as one: a jerk
/// between them would be rounding.
const SAME_TIME_S: f64 = 1e-12;

/// A profile of piecewise constant acceleration, asked for at rising times.
struct Cursor<'a> {
    nodes: &'a [Node],
    /// Time of the corner at the front.
    t: f64,
    /// Time to the one after it; the last corner has none.
    lasts: f64,
}

impl<'a> Cursor<'a> {
    fn new(nodes: &'a [Node]) -> Cursor<'a> {
        let mut cursor = Cursor {
            nodes,
            t: 0.0,
            lasts: 0.0,
        };
        cursor.settle();
        cursor
    }

    /// Skips corners from which nothing moves on.
    fn settle(&mut self) {
        while let [first, second, ..] = self.nodes {
            if let Some(lasts) = first.time_to(second) {
                self.lasts = lasts;
                return;
            }
            self.nodes = &self.nodes[1..];
        }
        self.lasts = f64::INFINITY;
    }

    /// Its speed if it does not change before the next corner.
    fn steady(&self) -> Option<f64> {
        match self.nodes {
            [first, second, ..] if first.b == second.b => Some(first.b.sqrt()),
            _ => None,
        }
    }

    /// When the acceleration steps next.
    fn next(&self) -> f64 {
        self.t + self.lasts
    }

    /// Goes on to a time; gives the place and the speed there.
    fn at(&mut self, t: f64) -> (f64, f64) {
        while t >= self.next() {
            self.t += self.lasts;
            self.nodes = &self.nodes[1..];
            self.settle();
        }
        let x = t - self.t;
        match self.nodes {
            [first, second, ..] => {
                let (v, a) = (
                    first.b.sqrt(),
                    (second.b - first.b) / (2.0 * (second.s - first.s)),
                );
                if x <= 0.0 {
                    (first.s + v * x, v)
                } else {
                    (first.s + (v + 0.5 * a * x) * x, v + a * x)
                }
            }
            [last] => (last.s + last.b.sqrt() * x, last.b.sqrt()),
            [] => (0.0, 0.0),
        }
    }
}

/// The mean over the window T of a profile that has been steady for as long before its first
/// corner, delayed by T/2: from half a window before its first corner to half a window before its
/// last, where it has been steady for a window again; or, if it comes to rest there, to the corner
/// itself.
pub(crate) fn average(nodes: &[Node], window_s: f64, complete: bool) -> Vec<Knot> {
    let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else {
        return Vec::new();
    };
    let duration = super::duration_s(nodes);
    // Coming to rest takes the window longer than the profile; a motion that goes on ends half a
    // window before the last corner.
    let end = if complete {
        duration + window_s
    } else {
        duration
    };
    let (mut front, mut back) = (Cursor::new(nodes), Cursor::new(nodes));
    // The speed has been steady before the first corner, so that the mean sets out half a window
    // before it.
    let mut here = Knot {
        s: first.s - 0.5 * first.b.sqrt() * window_s,
        v: first.b.sqrt(),
        ..Knot::default()
    };
    let mut knots = Vec::with_capacity(2 * nodes.len());
    // Never less than rounding of the time.
    let instant = SAME_TIME_S.max(8.0 * f64::EPSILON * end);
    while here.t < end {
        // Far along a path the places lose digits, which a long steady motion would add up.
        let steady = front
            .steady()
            .filter(|_| front.nodes.len() == back.nodes.len());
        if let Some(v) = steady {
            (here.v, here.a) = (v, 0.0);
        }
        // The first corner leaves the window, too.
        let leaves = if here.t < window_s { 0.0 } else { back.next() };
        let t = front.next().min(leaves + window_s).min(end);
        let t = if t - here.t < instant {
            (here.t + instant).min(end)
        } else {
            t
        };
        // The mean speed is the difference of the places at both edges of the window by T, the mean
        // acceleration that of the speeds.
        let ((s1, v1), (s0, v0)) = (front.at(t), back.at(t - window_s));
        let (v, a) = steady.map_or(((s1 - s0) / window_s, (v1 - v0) / window_s), |v| (v, 0.0));
        let dt = t - here.t;
        here.j = (a - here.a) / dt;
        knots.push(here);
        // Exact where the jerk is constant.
        here = Knot {
            t,
            s: here.s + 0.5 * dt * (here.v + v) - dt * dt / 12.0 * (a - here.a),
            v,
            a,
            j: 0.0,
        };
    }
    let s = if complete {
        last.s
    } else {
        last.s - 0.5 * last.b.sqrt() * window_s
    };
    knots.push(Knot {
        t: end,
        s,
        v: last.b.sqrt(),
        a: 0.0,
        j: 0.0,
    });
    knots
}

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

    /// Each knot's cubic ends in the next knot's state.
    #[test]
    fn knots_are_one_motion() {
        let nodes = [
            Node::new(0.0, 0.0),
            Node::new(1.0, 2000.0),
            Node::new(1.4, 2500.0),
            Node::new(9.0, 2500.0),
            Node::new(11.0, 0.0),
        ];
        let knots = average(&nodes, 0.03, true);
        for pair in knots.windows(2) {
            let (end, next) = (pair[0].at(pair[1].t), pair[1]);
            assert!(
                (end.s - next.s).abs() < 1e-12
                    && (end.v - next.v).abs() < 1e-9
                    && (end.a - next.a).abs() < 1e-6,
                "{end:?} {next:?}"
            );
        }
    }

    /// A minute and a half at a steady speed: the last knot is where those before it lead to.
    #[test]
    fn a_long_motion_ends_where_it_should() {
        let (length, v, window_s) = (611.456551117, 7.288328331152532_f64, 0.004367524198872701);
        let ramp = v * v / (2.0 * 853.135);
        let corners = [
            (0.0, 0.0),
            (ramp, v * v),
            (length - ramp, v * v),
            (length, 0.0),
        ];
        let knots = average(&corners.map(|(s, b)| Node::new(s, b)), window_s, true);
        let [.., before, last] = knots.as_slice() else {
            return assert!(!knots.is_empty());
        };
        assert!(last.t > 80.0 && last.s == length);
        assert!(
            (before.at(last.t).s - length).abs() < 1e-12,
            "{}",
            before.at(last.t).s - length
        );
    }

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
