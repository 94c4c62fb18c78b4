//! The parameter of a curve: it goes as the motion does as which the curve was found, but for the ends,
//! where it goes on as the parameters of what lies beyond.
//!
//! With such a parameter the motion is a steady pace, and all that the plan has to find is a pace that
//! hardly changes, however much the speed does.

use super::spline::Breaks;
use super::way::Way;
use super::{Cubic, Tie, TubeExcess, linear};
use lostmotion_base::vec::{along, dot, norm, scale};
use lostmotion_path::{HermiteEnd, Quintic};

/// A curve by its parameter.
#[derive(Debug)]
pub(super) struct Paced<'a> {
    /// The way with the parameter of the curve.
    pub(super) way: Way<'a>,
    pub(super) breaks: Breaks,
    pub(super) states: Vec<HermiteEnd>,
}

impl<'a> Paced<'a> {
    /// A curve given by its states at breaks of the time, and when it passes each vertex.
    pub(super) fn new(
        way: &Way<'a>,
        ties: &[Tie; 2],
        (times, states): (&Breaks, &[HermiteEnd]),
        passed: &[f64],
    ) -> Option<Paced<'a>> {
        let pace = Pace::new(ties, states, times)?;
        let mut parameters = vec![0.0];
        let mut parameter = 0.0;
        for (k, t) in times.0[1..].iter().enumerate() {
            parameter += pace.parameter(k, times.0[k], *t);
            parameters.push(parameter);
        }
        let mut states: Vec<HermiteEnd> = states
            .iter()
            .zip(&times.0)
            .enumerate()
            .map(|(k, (state, t))| {
                let [c, slope] = pace.at(k.min(times.intervals() - 1), *t);
                let d1 = scale(state.d1.linear(), 1.0 / c);
                let d2 = along(state.d2.linear(), d1, -slope);
                HermiteEnd {
                    d1: linear(d1),
                    d2: linear(scale(d2, 1.0 / (c * c))),
                    ..*state
                }
            })
            .collect();
        let last = states.len() - 1;
        for (tie, end) in ties.iter().zip([0, last]) {
            if let Tie::State(given) = tie {
                states[end] = *given;
            }
        }
        let passed = passed
            .iter()
            .map(|t| {
                let k = times.interval(*t);
                (parameters[k] + pace.parameter(k, times.0[k], *t)).min(parameters[k + 1])
            })
            .collect();
        Some(Paced {
            way: way.with_parameters(passed),
            breaks: Breaks(parameters),
            states,
        })
    }

    /// Where it leaves the tube; `None` where a piece has no length.
    pub(super) fn excess(&self) -> Option<TubeExcess> {
        let quintics: Option<Vec<Quintic>> = self
            .states
            .windows(2)
            .zip(self.breaks.0.windows(2))
            .map(|(ends, w)| Quintic::hermite(ends[0], ends[1], w[1] - w[0]).ok())
            .collect();
        let quintics = quintics?;
        Some(TubeExcess::new(&self.way, &self.breaks, |k| quintics[k]))
    }
}

/// How fast the parameter of the curve grows with the time.
///
/// Evenly, so that the curve at a steady pace is the motion; but at the ends as the parameters there,
/// since a step between two curves would be one of the speed. A short curve that hardly gets slower is
/// all end: there it is the speed, so that the parameter goes as the length does.
#[derive(Debug)]
enum Pace<'b> {
    Speed {
        times: &'b Breaks,
        states: &'b [HermiteEnd],
    },
    Even(EvenPace),
}

/// An even pace but for its ends.
#[derive(Clone, Copy, Debug)]
struct EvenPace {
    /// At the start.
    first: f64,
    /// Its slope but for the ends.
    slope: f64,
    /// By how much the slope at either end differs from that, and how long it takes to vanish.
    bumps: [[f64; 2]; 2],
    time: f64,
}

/// Intervals over which the slope goes from what is given to what is even. A choice: with fewer the
/// parameter takes jerk of its own, with more less of the curve goes as the motion does.
const PACE_INTERVALS: usize = 8;
/// Least pace, in units of those at the ends. A choice: keeps it from zero.
const LEAST_PACE: f64 = 0.25;
/// Intervals of a curve that is all end, and least speed along it in units of the largest. A choice:
/// for single corners in between both are as fast.
const SHORT_INTERVALS: usize = 64;
const GENTLE_PART: f64 = 0.33;

impl<'b> Pace<'b> {
    fn new(ties: &[Tie; 2], states: &'b [HermiteEnd], times: &'b Breaks) -> Option<Pace<'b>> {
        let last = times.intervals();
        if last < SHORT_INTERVALS && ties.iter().all(Tie::is_by_length) {
            let speeds = states.iter().map(|state| norm(state.d1.linear()));
            let (least, most) = speeds.fold((f64::INFINITY, 0.0_f64), |(least, most), v| {
                (least.min(v), most.max(v))
            });
            if least > GENTLE_PART * most {
                return Some(Pace::Speed { times, states });
            }
        }
        let time = times.0[last];
        let end = |tie: &Tie, state: &HermiteEnd| {
            let v = state.d1.linear();
            // Where the motion rests the parameter goes as the length does.
            let (d1, d2) = match tie {
                Tie::State(given) => (given.d1.linear(), given.d2.linear()),
                Tie::Place => (scale(v, 1.0 / norm(v)), [0.0; 3]),
            };
            let square = dot(d1, d1);
            let pace = dot(v, d1) / square;
            // What the parameter has to add to the curve's own acceleration.
            let slope = dot(along(state.d2.linear(), d2, -pace * pace), d1) / square;
            [pace, slope]
        };
        let ends = [end(&ties[0], &states[0]), end(&ties[1], &states[last])];
        let least = LEAST_PACE * ends[0][0].min(ends[1][0]);
        (0..=PACE_INTERVALS.min(last / 2))
            .rev()
            .map(|k| EvenPace::new(ends, [times.0[k], time - times.0[last - k]], time))
            .find(|pace| least > 0.0 && times.0.iter().all(|t| pace.at(*t)[0] > least))
            .map(Pace::Even)
    }

    /// The pace at a time in interval k, and its slope.
    fn at(&self, k: usize, t: f64) -> [f64; 2] {
        match self {
            Pace::Even(pace) => pace.at(t),
            Pace::Speed { times, states } => {
                let from = times.0[k];
                let cubic = Cubic::new(&states[k], &states[k + 1], times.0[k + 1] - from);
                let (v, a) = (cubic.at(t - from).d1, along(cubic.d2, cubic.d3, t - from));
                let speed = norm(v);
                [speed, dot(v, a) / speed]
            }
        }
    }

    /// By how much the parameter grows from one time in interval k to another, by Simpson's rule.
    fn parameter(&self, k: usize, from: f64, to: f64) -> f64 {
        let at = |part: f64| self.at(k, from + (to - from) * part)[0];
        (to - from) / 12.0 * (at(0.0) + 4.0 * (at(0.25) + at(0.75)) + 2.0 * at(0.5) + at(1.0))
    }
}

impl EvenPace {
    /// Given pace and slope at both ends, and how long it takes the slopes to vanish.
    fn new([start, end]: [[f64; 2]; 2], reaches: [f64; 2], time: f64) -> EvenPace {
        let grown = 0.5 * (start[1] * reaches[0] + end[1] * reaches[1]);
        let slope = (end[0] - start[0] - grown) / (time - 0.5 * (reaches[0] + reaches[1]));
        EvenPace {
            first: start[0],
            slope,
            bumps: [[start[1] - slope, reaches[0]], [end[1] - slope, reaches[1]]],
            time,
        }
    }

    fn at(&self, t: f64) -> [f64; 2] {
        let mut pace = [self.first + self.slope * t, self.slope];
        let [[slope, reach], [end_slope, end_reach]] = self.bumps;
        // Linearly to none from the start, and from none to the end.
        let grown = t.min(reach);
        if reach > 0.0 {
            pace[0] += slope * grown * (1.0 - 0.5 * grown / reach);
            pace[1] += slope * (1.0 - grown / reach);
        }
        let grown = t - (self.time - end_reach);
        if end_reach > 0.0 && grown > 0.0 {
            pace[0] += 0.5 * end_slope * grown * grown / end_reach;
            pace[1] += end_slope * grown / end_reach;
        }
        pace
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::Coords;

    /// How far, how fast and how hard: a speed that falls to the least one and rises again.
    fn falls_and_rises(least: f64, t: f64) -> [f64; 3] {
        let x = t - 0.06;
        [
            least * t + 4e3 / 3.0 * (x * x * x),
            least + 4e3 * x * x,
            8e3 * x,
        ]
    }

    /// A line with these along it.
    fn line(times: &Breaks, speed: impl Fn(f64) -> [f64; 3]) -> Vec<HermiteEnd> {
        let states = times.0.iter().map(|t| {
            let [gone, v, a] = speed(*t);
            HermiteEnd {
                p: Coords::xyz(0.0, gone, 0.0),
                d1: Coords::xyz(0.0, v, 0.0),
                d2: Coords::xyz(0.0, a, 0.0),
            }
        });
        states.collect()
    }

    /// Beside lines and other curves the pace is what their states ask for, its slope is that of the
    /// values, and the parameter their integral.
    #[test]
    fn the_pace_goes_from_what_is_given_to_what_is_given() {
        let times = Breaks::even(0.1, 20);
        let speed = |t| falls_and_rises(10.0, t);
        let states = line(&times, speed);
        let given = |d1: f64, d2: f64| {
            Tie::State(HermiteEnd {
                p: Coords::ZERO,
                d1: Coords::xyz(0.0, d1, 0.0),
                d2: Coords::xyz(0.0, d2, 0.0),
            })
        };
        let pace = Pace::new(&[given(1.0, 0.0), given(1.1, 0.02)], &states, &times).unwrap();
        let close = |[a, b]: [f64; 2], [c, d]: [f64; 2]| {
            assert!(
                (a - c).abs() < 1e-9 && (b - d).abs() < 1e-7,
                "{a} {b}, {c} {d}"
            );
        };
        close(pace.at(0, 0.0), [24.4, -480.0]);
        // The curve beyond goes by 1.1 there, and its second derivative is 0.02.
        let end = 16.4 / 1.1;
        close(pace.at(19, 0.1), [end, (320.0 - end * end * 0.02) / 1.1]);
        // Evenly in between.
        let slopes = [9, 10].map(|k| pace.at(k, times.0[k] + 1e-3)[1]);
        assert!((slopes[0] - slopes[1]).abs() < 1e-9, "{slopes:?}");
        for k in 0..20 {
            let (from, to) = (times.0[k], times.0[k + 1]);
            let difference = pace.at(k, to)[0] - pace.at(k, from)[0];
            let mean = 0.5 * (pace.at(k, from)[1] + pace.at(k, to)[1]);
            assert!(
                (difference - 0.005 * mean).abs() < 1e-9,
                "{difference} {mean}"
            );
            let sum: f64 = (0..400)
                .map(|j| pace.at(k, from + 0.005 * ((f64::from(j) + 0.5) / 400.0))[0])
                .sum();
            let parameter = pace.parameter(k, from, to);
            assert!(
                (parameter - 0.005 / 400.0 * sum).abs() < 1e-7,
                "{k} {parameter}"
            );
        }
    }

    /// A short and gentle curve has its length as the parameter, and derivatives of unit length.
    #[test]
    fn a_gentle_curve_goes_by_its_length() {
        let times = Breaks::even(0.1, 20);
        let speed = |t| falls_and_rises(30.0, t);
        let states = line(&times, speed);
        let pace = Pace::new(&[Tie::Place, Tie::Place], &states, &times).unwrap();
        for k in 0..20 {
            let [from, to] = [times.0[k], times.0[k + 1]];
            let gone = speed(to)[0] - speed(from)[0];
            assert!((pace.parameter(k, from, to) - gone).abs() < 1e-9);
            let [_, v, a] = speed(from);
            let [pace, slope] = pace.at(k, from);
            assert!(
                (pace - v).abs() < 1e-9 && (slope - a).abs() < 1e-7,
                "{pace} {slope}"
            );
        }
    }
}
