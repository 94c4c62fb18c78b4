//! The shape of a motion: its curve by length, as the plan takes it.

use super::Motion;
use crate::condition::tube::spline::{Breaks, ORDER, combined};
use crate::condition::tube::way::Way;
use crate::condition::tube::{Cubic, Tie, linear};
use lostmotion_base::vec::{along, dot, norm, scale, sub};
use lostmotion_path::{HermiteEnd, Quintic};

/// A curve found as a motion, by its length.
#[derive(Debug)]
pub(in crate::condition::tube) struct Swung<'a> {
    /// The way with the parameter of the curve.
    pub(in crate::condition::tube) way: Way<'a>,
    pub(in crate::condition::tube) breaks: Breaks,
    pub(in crate::condition::tube) states: Vec<HermiteEnd>,
    /// The motion's speed at each break, mm/s.
    pub(in crate::condition::tube) speeds: Vec<f64>,
}

impl<'a> Motion<'a, '_> {
    /// The curve by its length.
    pub(super) fn by_length(&self) -> Option<Swung<'a>> {
        let states = self.breaks.states(&self.coefficients);
        let width = |k: usize| self.breaks.0[k + 1] - self.breaks.0[k];
        let cubics: Vec<Cubic> = (0..self.breaks.intervals())
            .map(|k| Cubic::new(&states[k], &states[k + 1], width(k)))
            .collect();
        let mut lengths = vec![0.0];
        let mut length = 0.0;
        for (k, cubic) in cubics.iter().enumerate() {
            length += travelled(cubic, width(k));
            lengths.push(length);
        }
        let rate = Rate::new(&self.ties, &lengths)?;
        let mut parameters = vec![0.0];
        let mut parameter = 0.0;
        for pair in lengths.windows(2) {
            parameter += rate.parameter(pair[0], pair[1]);
            parameters.push(parameter);
        }
        let mut ends = Vec::with_capacity(states.len());
        for (state, length) in states.iter().zip(&lengths) {
            let (v, a) = (state.d1.linear(), state.d2.linear());
            let square = dot(v, v);
            if square <= 0.0 {
                return None;
            }
            let direction = scale(v, 1.0 / square.sqrt());
            let bend = scale(along(a, direction, -dot(a, direction)), 1.0 / square);
            let [g, slope] = rate.at(*length);
            ends.push(HermiteEnd {
                d1: linear(scale(direction, g)),
                d2: linear(along(scale(bend, g * g), direction, slope * g)),
                ..*state
            });
        }
        let last = ends.len() - 1;
        for (tie, end) in self.ties.iter().zip([0, last]) {
            if let Tie::State(given) = tie {
                ends[end] = *given;
            }
        }
        let passed = self
            .passed
            .iter()
            .map(|t| {
                let k = self.breaks.interval(*t);
                let length =
                    lengths[k] + travelled(&cubics[k], (t - self.breaks.0[k]).min(width(k)));
                (parameters[k] + rate.parameter(lengths[k], length)).min(parameters[k + 1])
            })
            .collect();
        let slower = self.time_s() / self.needed_s();
        Some(Swung {
            way: self.way.with_parameters(passed),
            breaks: Breaks(parameters),
            states: ends,
            speeds: states
                .iter()
                .map(|state| slower * norm(state.d1.linear()))
                .collect(),
        })
    }

    /// How much of the jerk a shape by length misses at the ends of its pieces, in units of its limit:
    /// where the motion nearly rests its direction changes too fast for one piece.
    pub(super) fn lost(&self, quintics: &[Quintic]) -> f64 {
        let states = self.breaks.states(&self.coefficients);
        let mut most = 0.0_f64;
        for (k, quintic) in quintics.iter().enumerate() {
            let third = combined(&self.coefficients[k..k + ORDER], &self.breaks.third(k));
            for (end, place) in [(k, 0.0), (k + 1, quintic.length())] {
                let (v, a) = (states[end].d1.linear(), states[end].d2.linear());
                let at = quintic.eval(place);
                let [d1, d2, d3] = [at.d1, at.d2, at.d3].map(|d| d.linear());
                // Speed, acceleration and jerk of the parameter follow from those of the motion.
                let square = dot(d1, d1);
                let speed = dot(v, d1) / square;
                let acceleration = dot(along(a, d2, -speed * speed), d1) / square;
                let bent = along(
                    scale(d3, speed * speed * speed),
                    d2,
                    3.0 * speed * acceleration,
                );
                let jerk = dot(sub(third, bent), d1) / square;
                let off = sub(along(bent, d1, jerk), third);
                for joint in self.joints {
                    most = most.max(dot(joint.per_mm, off).abs() / joint.jerk);
                }
            }
        }
        most
    }
}

/// The length of a cubic from its start to a parameter, by Simpson's rule.
fn travelled(cubic: &Cubic, x: f64) -> f64 {
    let speed = |part: f64| norm(cubic.at(part * x).d1);
    x / 12.0 * (speed(0.0) + 4.0 * (speed(0.25) + speed(0.75)) + 2.0 * speed(0.5) + speed(1.0))
}

/// How fast the length grows with the parameter of the curve: as given at its ends, and by one
/// otherwise. A step between two of its pieces would be one of the speed.
#[derive(Debug)]
struct Rate {
    /// At the start and at the end: how far it reaches, by how much it is off one, and its slope.
    ends: [[f64; 3]; 2],
    length: f64,
}

/// Intervals over which the rate goes from what is given to one.
const RATE_INTERVALS: usize = 4;

impl Rate {
    fn new(ties: &[Tie; 2], lengths: &[f64]) -> Option<Rate> {
        let last = lengths.len() - 1;
        let length = lengths[last];
        let reach = RATE_INTERVALS.min(last / 2);
        let reaches = [lengths[reach], length - lengths[last - reach]];
        let mut ends = [[1.0, 0.0, 0.0]; 2];
        for (end, (tie, (reach, sign))) in ends
            .iter_mut()
            .zip(ties.iter().zip(reaches.into_iter().zip([1.0, -1.0])))
        {
            if let Tie::State(given) = tie {
                let (d1, d2) = (given.d1.linear(), given.d2.linear());
                let rate = norm(d1);
                if !(rate > 0.0 && reach > 0.0) {
                    return None;
                }
                // By the length, inwards.
                *end = [reach, rate - 1.0, sign * dot(d2, d1) / (rate * rate)];
            }
        }
        Some(Rate { ends, length })
    }

    /// The rate and its slope at a length.
    fn at(&self, length: f64) -> [f64; 2] {
        let mut rate = [1.0, 0.0];
        let from_end = [(length, 1.0), (self.length - length, -1.0)];
        for ([reach, off, slope], (s, sign)) in self.ends.iter().zip(from_end) {
            let x = s / reach;
            if x < 1.0 {
                let left = 1.0 - x;
                rate[0] += off * (1.0 + 2.0 * x) * left * left + slope * reach * x * left * left;
                rate[1] += sign * (-6.0 * off * x * left / reach + slope * left * (1.0 - 3.0 * x));
            }
        }
        rate
    }

    /// By how much the parameter grows between two lengths, by Simpson's rule.
    fn parameter(&self, from: f64, to: f64) -> f64 {
        let at = |part: f64| 1.0 / self.at(from + (to - from) * part)[0];
        (to - from) / 12.0 * (at(0.0) + 4.0 * (at(0.25) + at(0.75)) + 2.0 * at(0.5) + at(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::Coords;

    /// The rate is as given at both ends and one between them, its slope is that of its values, and
    /// the parameter its inverse's integral.
    #[test]
    fn the_rate_goes_from_what_is_given_to_one() {
        let tie = |rate: f64, slope: f64| {
            Tie::State(HermiteEnd {
                p: Coords::ZERO,
                d1: Coords::xyz(0.0, rate, 0.0),
                d2: Coords::xyz(3.0, rate * rate * slope, 0.0),
            })
        };
        let lengths: Vec<f64> = (0..=20).map(|k| 0.1 * f64::from(k)).collect();
        let rate = Rate::new(&[tie(0.98, 0.3), tie(1.03, -0.2)], &lengths).unwrap();
        let close = |[a, b]: [f64; 2], [c, d]: [f64; 2]| {
            assert!((a - c).abs() < 1e-12 && (b - d).abs() < 1e-12, "{a} {b}");
        };
        // The second derivative along the curve is by the parameter: rate times slope.
        close(rate.at(0.0), [0.98, 0.3 * 0.98]);
        close(rate.at(2.0), [1.03, -0.2 * 1.03]);
        close(rate.at(1.0), [1.0, 0.0]);
        let mut sum = 0.0;
        for k in 0..2000 {
            let s = 1e-3 * (f64::from(k) + 0.5);
            let [value, slope] = rate.at(s);
            let difference = (rate.at(s + 1e-6)[0] - rate.at(s - 1e-6)[0]) / 2e-6;
            assert!(
                (slope - difference).abs() < 1e-6,
                "{s}: {slope} {difference}"
            );
            sum += 1e-3 / value;
        }
        let parameter: f64 = lengths.windows(2).map(|s| rate.parameter(s[0], s[1])).sum();
        assert!((parameter - sum).abs() < 1e-7, "{parameter} {sum}");
    }
}
