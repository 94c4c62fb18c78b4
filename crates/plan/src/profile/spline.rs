//! The square of the speed by place, as a quadratic B-spline.

use crate::motion::{Knot, PathState};

/// Most steps towards the time that an interval takes. A choice: a few suffice; the bound ends
/// intervals without a solution.
const TIME_STEPS: usize = 12;
/// Part of the time by which the last step may change it: near rounding.
const TIME_TOLERANCE: f64 = 1e-13;

/// Places that cut a section into intervals, with what the shape of a quadratic spline b(s) on them
/// needs.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) nodes: Vec<f64>,
    /// Lengths of the intervals, the first and the last one twice.
    widths: Vec<f64>,
}

impl Grid {
    /// At least two nodes, rising.
    pub(super) fn new(nodes: Vec<f64>) -> Grid {
        let mut widths: Vec<f64> = nodes.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let (first, last) = (widths.first().copied(), widths.last().copied());
        widths.splice(0..0, first);
        widths.extend(last);
        Grid { nodes, widths }
    }

    /// Number of intervals.
    pub(super) fn len(&self) -> usize {
        self.nodes.len().saturating_sub(1)
    }

    pub(super) fn width(&self, interval: usize) -> f64 {
        self.widths[interval + 1]
    }

    /// The two coefficients that give a state at the start of the first interval or the end of the
    /// last one.
    pub(super) fn ends(&self, at_end: bool, state: &PathState) -> [f64; 2] {
        let half = if at_end {
            self.widths[self.len()]
        } else {
            self.widths[0]
        } * state.a;
        [state.v * state.v - half, state.v * state.v + half]
    }

    /// b and its slope at a node, from the coefficients.
    pub(super) fn at_node(&self, c: &[f64], node: usize) -> (f64, f64) {
        let (left, right) = (self.widths[node], self.widths[node + 1]);
        let sum = left + right;
        (
            (right * c[node] + left * c[node + 1]) / sum,
            2.0 * (c[node + 1] - c[node]) / sum,
        )
    }

    /// b and its slope in the middle of an interval, and its second derivative there, each as a sum
    /// over the interval's three coefficients.
    pub(super) fn basis(&self, interval: usize) -> [[f64; 3]; 3] {
        let [before, h, after] = [0, 1, 2].map(|k| self.widths[interval + k]);
        let (alpha, beta) = (2.0 / (before + h), 2.0 / (h + after));
        let second = [alpha / h, -(alpha + beta) / h, beta / h];
        // The mean of b at both ends, below which the middle lies by h^2/8 times the second
        // derivative.
        let ends = [
            0.25 * h * alpha,
            0.25 * (before * alpha + after * beta),
            0.25 * h * beta,
        ];
        let middle = [0, 1, 2].map(|k| ends[k] - h * h / 8.0 * second[k]);
        [
            middle,
            [-0.5 * alpha, 0.5 * (alpha - beta), 0.5 * beta],
            second,
        ]
    }

    /// The state at a node.
    fn state(&self, c: &[f64], node: usize) -> PathState {
        let (b, slope) = self.at_node(c, node);
        PathState {
            s: self.nodes[node],
            v: b.max(0.0).sqrt(),
            a: 0.5 * slope,
        }
    }

    /// The motion over an interval: from state to state with one jerk in the first half of the time
    /// and another in the second. The first knot begins at a time; that of the end of the interval
    /// is returned, too. `None` where no such motion goes forward all the time: near rest the
    /// acceleration of b(s) changes too fast for two jerks.
    pub(super) fn knots(&self, c: &[f64], interval: usize, t: f64) -> Option<[Knot; 3]> {
        let (from, to) = (self.state(c, interval), self.state(c, interval + 1));
        let (ds, dv, da) = (to.s - from.s, to.v - from.v, to.a - from.a);
        // For any time two jerks meet the speed and the acceleration of the end.
        let jerks = |half: f64| {
            let first = (dv - (2.0 * from.a + 0.5 * da) * half) / (half * half);
            [first, da / half - first]
        };
        // Places from the start of the interval, so that far along the path no digits are lost.
        let middle = |half: f64, j: f64| {
            Knot {
                t: 0.0,
                s: 0.0,
                v: from.v,
                a: from.a,
                j,
            }
            .at(half)
        };
        // What is left is the place of the end: Newton's method for the time, with the mean speed
        // as slope.
        let mut half = ds / (from.v + to.v);
        for _ in 0..TIME_STEPS {
            let [first, second] = jerks(half);
            let m = middle(half, first);
            let end = Knot {
                t: 0.0,
                s: m.s,
                v: m.v,
                a: m.a,
                j: second,
            }
            .at(half);
            let step = (ds - end.s) / (from.v + to.v);
            half += step;
            if step.abs() <= TIME_TOLERANCE * half {
                let [first, second] = jerks(half);
                let m = middle(half, first);
                return (m.v > 0.0).then_some([
                    Knot {
                        t,
                        s: from.s,
                        v: from.v,
                        a: from.a,
                        j: first,
                    },
                    Knot {
                        t: t + half,
                        s: from.s + m.s,
                        v: m.v,
                        a: m.a,
                        j: second,
                    },
                    Knot {
                        t: t + 2.0 * half,
                        s: to.s,
                        v: to.v,
                        a: to.a,
                        j: 0.0,
                    },
                ]);
            }
        }
        None
    }
}
