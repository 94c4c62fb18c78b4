//! What no time law can beat, nearly: how fast the path could be travelled if jerk cost nothing.
//!
//! An averaged profile is slower than that by how far its demands were spread and its jerk was
//! bounded for the worst case. Where that is next to nothing, as it is nearly everywhere on a path
//! that the feed limits, there is nothing to make faster.

use super::Node;
use crate::demand::Interval;
use crate::machine::Machine;

/// The highest profile that keeps velocity, feed and acceleration of every joint, between two
/// speeds squared.
pub(crate) fn ideal(machine: &Machine, intervals: &[Interval], from: Node, to: Node) -> Vec<Node> {
    let first = intervals.partition_point(|interval| interval.end <= from.s);
    let past = intervals.partition_point(|interval| interval.start < to.s);
    let intervals = &intervals[first.min(past)..past];
    let mut nodes = Vec::with_capacity(intervals.len() + 1);
    nodes.push(from);
    // Forward: as fast as acceleration and caps allow.
    for (k, interval) in intervals.iter().enumerate() {
        let last = nodes[k];
        let s = interval.end.min(to.s);
        let next = intervals.get(k + 1).map_or(f64::INFINITY, |next| next.cap);
        let cap = interval.cap.min(next);
        nodes.push(Node::new(
            s,
            reached(machine, interval, last.b, s - last.s).min(cap * cap),
        ));
    }
    if let Some(last) = nodes.last_mut() {
        last.b = last.b.min(to.b);
    }
    // Backward: slow enough for the next cap.
    for k in (0..intervals.len()).rev() {
        let (next, length) = (nodes[k + 1].b, nodes[k + 1].s - nodes[k].s);
        nodes[k].b = nodes[k]
            .b
            .min(reached(machine, &intervals[k], next, length));
    }
    with_peaks(machine, intervals, &nodes)
}

/// The same with what lies between the ends of each interval: up, along its cap, and down.
fn with_peaks(machine: &Machine, intervals: &[Interval], ends: &[Node]) -> Vec<Node> {
    let mut nodes = Vec::with_capacity(3 * ends.len());
    nodes.extend(ends.first());
    for (interval, pair) in intervals.iter().zip(ends.windows(2)) {
        let (from, to) = (pair[0], pair[1]);
        // The acceleration at the lower speed is the most that the interval allows: the profile may
        // be too fast, never too slow.
        let a = machine.pull(&interval.demand, from.b.min(to.b));
        let peak = (0.5 * (from.b + to.b) + a * (to.s - from.s)).min(interval.cap * interval.cap);
        // Along the cap up to an end, too.
        if peak >= from.b.max(to.b) && peak > from.b.min(to.b) {
            nodes.push(Node::new(from.s + 0.5 * (peak - from.b) / a, peak));
            nodes.push(Node::new(to.s - 0.5 * (peak - to.b) / a, peak));
        }
        nodes.push(to);
    }
    nodes
}

/// Largest speed squared at the other end of a stretch.
fn reached(machine: &Machine, interval: &Interval, b: f64, length: f64) -> f64 {
    b + 2.0 * length * machine.pull(&interval.demand, b)
}

/// Time that a profile takes between two places, s.
pub(super) fn time_between(nodes: &[Node], from: f64, to: f64) -> f64 {
    let first = nodes
        .partition_point(|node| node.s <= from)
        .saturating_sub(1);
    let mut time = 0.0;
    for pair in nodes[first.min(nodes.len())..]
        .windows(2)
        .take_while(|pair| pair[0].s < to)
    {
        let slope = (pair[1].b - pair[0].b) / (pair[1].s - pair[0].s).max(f64::MIN_POSITIVE);
        let at = |s: f64| Node::new(s, (pair[0].b + slope * (s - pair[0].s)).max(0.0));
        time += at(pair[0].s.max(from))
            .time_to(&at(pair[1].s.min(to)))
            .unwrap_or(0.0);
    }
    time
}
