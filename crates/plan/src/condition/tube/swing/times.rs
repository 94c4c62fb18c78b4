//! How long each stretch of a motion takes.
//!
//! Where the motion is best timed, an interval that is given a little more time lowers what is to be
//! least by the same amount anywhere. That amount follows without another fit: it is the Hamiltonian
//! of the motion, which stays the same in between and steps where a place pulls at it, by that pull
//! times the velocity there. Its mean is known, since with all times longer the jerk falls with their
//! third power.

use super::{Interpolated, Motion, averaged, largest, transferred};
use crate::condition::tube::Cubic;
use crate::condition::tube::fit::Site;
use crate::condition::tube::spline::{Breaks, ORDER, combined};
use lostmotion_base::math;
use lostmotion_base::vec::{dot, norm};

/// Bounds of the factor on the time of an interval beside that of all. A choice: with more the next
/// fit begins too far away.
const FACTORS: [f64; 2] = [0.92, 1.08];
/// Bounds of the factor on all times. A choice, as before.
const EVEN_FACTORS: [f64; 2] = [0.5, 2.0];
/// Least worth of time, as a part of the mean: where more time would be worse than none the factor
/// is the least anyway.
const LEAST_WORTH: f64 = 1e-9;

impl Motion<'_, '_> {
    /// How long it takes, s.
    pub(super) fn time_s(&self) -> f64 {
        self.breaks.0[self.breaks.intervals()]
    }

    fn width(&self, k: usize) -> f64 {
        self.breaks.0[k + 1] - self.breaks.0[k]
    }

    fn power(&self) -> f64 {
        2.0 * f64::from(self.jerks.half_power)
    }

    /// The powers of jerk and acceleration that count on an interval.
    fn powers(&self, k: usize) -> [f64; 2] {
        let these = &self.coefficients[k..k + ORDER];
        let third = combined(these, &self.breaks.third(k));
        let second = combined(these, &self.breaks.second(k));
        self.jerks.powers(&third, &second)
    }

    /// How much longer it would take at the limits of jerk and acceleration: so that the mean of what
    /// is to be least is what a joint at its limit has.
    pub(super) fn longer(&self) -> f64 {
        let sum: f64 = (0..self.breaks.intervals())
            .map(|k| self.width(k) * self.powers(k).iter().sum::<f64>())
            .sum();
        math::pow(
            self.power() * sum / self.time_s(),
            1.0 / (3.0 * self.power()),
        )
    }

    /// How long it would take at all limits, s.
    pub(super) fn needed_s(&self) -> f64 {
        let longer = self.longer();
        let speeds = self.speed_parts();
        (0..self.breaks.intervals())
            .map(|k| self.width(k) * longer.max(0.5 * (speeds[k] + speeds[k + 1])))
            .sum()
    }

    /// Speed at each break, in units of the least of the limits and the feed.
    fn speed_parts(&self) -> Vec<f64> {
        let states = self.breaks.states(&self.coefficients);
        let mut passed = Interpolated::new(&self.passed, self.way.parameters());
        let mut walk = self.way.walk();
        (0..states.len())
            .map(|k| {
                let feed = walk.to(passed.at(self.breaks.0[k])).feed();
                let v = states[k].d1.linear();
                let joints = self.joints.iter();
                joints
                    .map(|joint| dot(joint.per_mm, v).abs() / joint.velocity)
                    .fold(norm(v) / feed, f64::max)
            })
            .collect()
    }

    /// What more time is worth on each interval, in units of its mean.
    fn worth_of_time(&self, sites: &[Site]) -> Vec<f64> {
        let states = self.breaks.states(&self.coefficients);
        let count = self.breaks.intervals();
        let mut steps = vec![0.0; count + 1];
        for site in sites {
            let k = site.interval;
            let x = site.w - self.breaks.0[k];
            let velocity = Cubic::new(&states[k], &states[k + 1], self.width(k))
                .at(x)
                .d1;
            let step = dot(site.pull(&self.coefficients), velocity);
            // Its own interval has a part of it.
            let part = x / self.width(k);
            steps[k] += step * (1.0 - part);
            steps[k + 1] += step * part;
        }
        let power = self.power();
        let (mut height, mut heights) = (0.0, Vec::with_capacity(count));
        let (mut mean, mut above) = (0.0, 0.0);
        let total = self.time_s();
        for (k, step) in steps[..count].iter().enumerate() {
            height += step;
            heights.push(height);
            let [by_third, by_second] = self.powers(k);
            let part = self.width(k) / total;
            mean += part * ((3.0 * power - 1.0) * by_third + (2.0 * power - 1.0) * by_second);
            above += part * height;
        }
        heights
            .into_iter()
            .map(|height| (height - above) / mean + 1.0)
            .collect()
    }

    /// Gives more time where that is worth more, and to all as much as the limits need.
    pub(super) fn retime(&mut self, sites: &[Site]) {
        let states = self.breaks.states(&self.coefficients);
        let count = self.breaks.intervals();
        let even = self.longer().clamp(EVEN_FACTORS[0], EVEN_FACTORS[1]);
        // What the jerk alone asks for, as if the stretches did not touch.
        let exponent = 1.0 / (3.0 * self.power());
        let factors: Vec<f64> = self
            .worth_of_time(sites)
            .into_iter()
            .map(|worth| {
                let factor = math::pow(worth.max(LEAST_WORTH), exponent);
                even * factor.clamp(FACTORS[0], FACTORS[1])
            })
            .collect();
        // Speeds are limits of their own.
        let speeds = self.speed_parts();
        let speeds = largest(&speeds, 1);
        let factors: Vec<f64> = factors
            .into_iter()
            .zip(speeds.windows(2))
            .map(|(factor, speeds)| factor.max(speeds[0]).max(speeds[1]))
            .collect();
        let mut times = vec![0.0];
        let mut time = 0.0;
        for (k, factor) in averaged(&factors, 2).into_iter().enumerate() {
            time += self.width(k) * factor;
            times.push(time);
        }
        let mut next = Interpolated::new(&self.breaks.0, &times);
        for t in &mut self.passed {
            *t = next.at(*t);
        }
        // Even breaks again: uneven ones bend the curve.
        let next = Breaks::even(time, count);
        self.coefficients = transferred(&states, &self.breaks, &times, &next);
        self.breaks = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PathControl;
    use crate::condition::tube::swing::LinearJoint;
    use crate::condition::tube::{Tie, Way, steady};
    use crate::item::Heeds;
    use crate::piece::Programmed;
    use lostmotion_base::vec::sub;
    use lostmotion_base::{BlockRef, Coords};
    use lostmotion_path::Curve;

    fn zigzag(lines: usize) -> Vec<Programmed> {
        let place = |k: usize| Coords::xyz(2.0 * k as f64, 0.7 * (k % 2) as f64, 0.0);
        (0..lines)
            .map(|k| {
                let curve = Curve::line(place(k), place(k + 1));
                Programmed {
                    length: curve.length(),
                    curve,
                    feed: 100.0,
                    heeds: Heeds::Feed,
                    control: PathControl::ExactPath,
                    tool_mm: [0.0; 3],
                    segment: k as u64,
                    block: BlockRef::default(),
                }
            })
            .collect()
    }

    fn joints() -> Vec<LinearJoint> {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
            .into_iter()
            .map(|per_mm| LinearJoint {
                per_mm,
                velocity: 100.0,
                acceleration: 1e3,
                jerk: 3e4,
            })
            .collect()
    }

    /// Each vertex is passed where the curve is nearest to it.
    #[test]
    fn vertices_are_passed_where_they_are_nearest() {
        let (lines, joints) = (zigzag(8), joints());
        let way = Way::new(&lines, 0.0, lines[7].length, &[0.01; 8]).unwrap();
        let ties = [Tie::Place, Tie::Place];
        let steady = steady(&way, ties).unwrap();
        let from = (&steady.breaks, steady.states.as_slice());
        let mut motion = Motion::new(&way, ties, from, &joints).unwrap().0;
        let mut sites = motion.sites();
        assert!(motion.solve(&mut sites, 1.0));
        motion.pass();
        let states = motion.breaks.states(&motion.coefficients);
        for vertex in 1..way.legs() {
            let t = motion.passed[vertex];
            let k = motion.breaks.interval(t);
            let width = motion.width(k);
            let at = Cubic::new(&states[k], &states[k + 1], width).at(t - motion.breaks.0[k]);
            let late_s = dot(sub(at.p, way.vertex(vertex)), at.d1) / dot(at.d1, at.d1);
            assert!(late_s.abs() < 1e-5 * width, "{vertex}: {late_s} of {width}");
        }
    }

    /// What more time for one line is worth, against the difference that it makes when the motion is
    /// found with that line a little slower and a little faster.
    #[test]
    fn more_time_is_worth_what_it_saves() {
        let (lines, joints) = (zigzag(8), joints());
        let way = Way::new(&lines, 0.0, lines[7].length, &[0.01; 8]).unwrap();
        let ties = [Tie::Place, Tie::Place];
        let steady = steady(&way, ties).unwrap();
        let start = || {
            let from = (&steady.breaks, steady.states.as_slice());
            Motion::new(&way, ties, from, &joints).unwrap().0
        };
        let mut motion = start();
        let mut sites = motion.sites();
        assert!(motion.solve(&mut sites, 1.0));
        let sum = |motion: &Motion<'_, '_>, of: fn([f64; 2], f64) -> f64| -> f64 {
            (0..motion.breaks.intervals())
                .map(|k| motion.width(k) * of(motion.powers(k), motion.power()))
                .sum()
        };
        let mean = sum(&motion, |[jerk, acceleration], power| {
            (3.0 * power - 1.0) * jerk + (2.0 * power - 1.0) * acceleration
        }) / motion.time_s();
        let worth = motion.worth_of_time(&sites);
        let passed = motion.passed.clone();
        for line in [2, 3, 5] {
            let [from, to] = [passed[line], passed[line + 1]];
            let least = |longer_s: f64| {
                let mut other = start();
                let part = longer_s / (to - from);
                for t in &mut other.passed {
                    *t += part * (t.clamp(from, to) - from);
                }
                let count = other.breaks.intervals();
                let mut at = Interpolated::new(&passed, &other.passed);
                let times: Vec<f64> = motion.breaks.0.iter().map(|t| at.at(*t)).collect();
                let next = Breaks::even(times[count], count);
                let states = motion.breaks.states(&motion.coefficients);
                other.coefficients = transferred(&states, &motion.breaks, &times, &next);
                other.breaks = next;
                let mut sites = other.sites();
                assert!(other.solve(&mut sites, 1.0));
                sum(&other, |[jerk, acceleration], _| jerk + acceleration)
            };
            let step = 0.01 * (to - from);
            let saved = (least(-step) - least(step)) / (2.0 * step);
            // The mean over the line.
            let of_line: Vec<f64> = (0..motion.breaks.intervals())
                .filter(|k| motion.breaks.0[*k] >= from && motion.breaks.0[*k + 1] <= to)
                .map(|k| mean * worth[k])
                .collect();
            let told = of_line.iter().sum::<f64>() / of_line.len() as f64;
            // What the fit's tolerance leaves.
            assert!(
                (told - saved).abs() < 0.15 * saved,
                "{line}: {saved} {told}"
            );
        }
    }
}
