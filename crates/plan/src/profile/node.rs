//! Corners of a speed profile.

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
