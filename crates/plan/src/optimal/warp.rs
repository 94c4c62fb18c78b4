//! From beta over nominal time to samples at even steps of real time.

use crate::Sample;
use lostmotion_base::{AXES, Coords};

/// Nodes and weights of Gauss' rule with three points on (0, 1).
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// beta over one interval of nominal time: value, slope and half the curvature by the part of the
/// interval.
#[derive(Clone, Copy, Debug)]
struct Beta([f64; 3]);

impl Beta {
    fn over(x: &[f64]) -> Beta {
        Beta([
            0.5 * (x[0] + x[1]),
            x[1] - x[0],
            0.5 * (x[0] - 2.0 * x[1] + x[2]),
        ])
    }

    fn at(&self, part: f64) -> f64 {
        let [c0, c1, c2] = self.0;
        c0 + part * (c1 + part * c2)
    }

    /// Real by nominal time: the mean of 1 / sqrt(beta) over the interval.
    fn stretch(&self) -> f64 {
        GAUSS
            .iter()
            .map(|(at, weight)| weight / self.at(*at).sqrt())
            .sum()
    }

    fn slope(&self, part: f64) -> f64 {
        self.0[1] + 2.0 * part * self.0[2]
    }

    /// The part of the nominal interval at a part of the real one: a quintic with the true speed
    /// and acceleration at both ends. `stretch` is the real length of the interval by the nominal
    /// one.
    fn part(&self, u: f64, stretch: f64) -> f64 {
        let [v0, v1] = [0.0, 1.0].map(|part| self.at(part).sqrt() * stretch);
        // d2 sigma / dt2 is half the slope of beta.
        let [a0, a1] = [0.0, 1.0].map(|part| 0.5 * self.slope(part) * stretch * stretch);
        quintic([0.0, v0, a0], [1.0, v1, a1], u)[0]
    }
}

/// The quintic on (0, 1) with given value, slope and curvature at both ends: its value, slope and
/// curvature at `u`.
pub(crate) fn quintic([p0, v0, a0]: [f64; 3], [p1, v1, a1]: [f64; 3], u: f64) -> [f64; 3] {
    let (p, v, a) = (p1 - p0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0);
    let c3 = 10.0 * p - 4.0 * v + 0.5 * a;
    let c4 = -15.0 * p + 7.0 * v - a;
    let c5 = 6.0 * p - 3.0 * v + 0.5 * a;
    [
        p0 + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5)))),
        v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5))),
        a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5)),
    ]
}

/// A sample with its place on the nominal motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub(crate) interval: usize,
    pub(crate) part: f64,
    /// d sigma / dt, and its rate of change, 1/s.
    pub(crate) pace: [f64; 2],
    pub(crate) sample: Sample,
}

/// Walks along nominal time in steps of real time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    /// Real time from the start of the next interval to the next sample, s.
    pub(super) ahead_s: f64,
    /// Time between samples, s.
    pub(super) period_s: f64,
}

impl Walk {
    /// Real time over all intervals of the coefficients `x`, s.
    pub(super) fn lasts_s(step_s: f64, x: &[f64]) -> f64 {
        let stretch: f64 = x.windows(3).map(|x| Beta::over(x).stretch()).sum();
        step_s * stretch
    }

    /// Adds the samples, each with its interval, within the nominal intervals between the points,
    /// over which the coefficients `x` give beta.
    pub(super) fn go(&mut self, points: &[Sample], step_s: f64, x: &[f64], out: &mut Vec<Placed>) {
        for (interval, (pair, x)) in points.windows(2).zip(x.windows(3)).enumerate() {
            let beta = Beta::over(x);
            let stretch = beta.stretch();
            let whole = step_s * stretch;
            while self.ahead_s < whole {
                let part = beta.part(self.ahead_s / whole, stretch);
                // The pace in force at the sample, and its rate by real time: d2 sigma / dt2 is
                // beta' / 2.
                let ends = [&pair[0], &pair[1]];
                let pace = [beta.at(part).sqrt(), 0.5 * beta.slope(part) / step_s];
                out.push(Placed {
                    interval,
                    part,
                    pace,
                    sample: between(ends, step_s, part, pace),
                });
                self.ahead_s += self.period_s;
            }
            self.ahead_s -= whole;
        }
    }
}

/// The motion at a part of a nominal interval at a pace and its rate of change, 1/s.
pub(crate) fn between(
    [a, b]: [&Sample; 2],
    step_s: f64,
    part: f64,
    [pace, change]: [f64; 2],
) -> Sample {
    let mut joints = [[0.0; 3]; AXES];
    for (index, joint) in joints.iter_mut().enumerate() {
        let at = |sample: &Sample| {
            [
                sample.position.0[index],
                sample.velocity.0[index] * step_s,
                sample.acceleration.0[index] * step_s * step_s,
            ]
        };
        *joint = quintic(at(a), at(b), part);
    }
    let velocity = joints.map(|joint| joint[1] / step_s);
    let acceleration = joints.map(|joint| joint[2] / (step_s * step_s));
    let speed = a.path_speed + (b.path_speed - a.path_speed) * part;
    // Names come from the nearer end.
    let near = if part < 0.5 { a } else { b };
    let s = if a.segment == b.segment && a.tool_mm == b.tool_mm {
        a.s + (b.s - a.s) * part
    } else {
        near.s
    };
    // By real time: p' pace, and p'' pace^2 + p' times the rate of the pace.
    Sample {
        position: Coords(joints.map(|joint| joint[0])),
        velocity: Coords(velocity.map(|v| v * pace)),
        acceleration: Coords(std::array::from_fn(|k| {
            acceleration[k] * pace * pace + velocity[k] * change
        })),
        path_speed: speed * pace,
        feed_part: (a.feed_part + (b.feed_part - a.feed_part) * part) * pace,
        chord_part: (a.chord_part + (b.chord_part - a.chord_part) * part) * pace,
        s,
        ..*near
    }
}
