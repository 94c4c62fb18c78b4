//! The moving average of a speed profile over time, which has limited jerk.

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
