//! Soft ends of straight motions. At a corner at which the motions along two lines overlap their
//! jerks add up. Where the sum is beyond the limit of a joint, both motions use less jerk while they
//! overlap. That costs far less than the overlap saves, since little way is left there.

use crate::machine::Machine;
use crate::motion::Knot;
use crate::piece::{Soft, corner_reach};
use lostmotion_base::root::Bracket;
use lostmotion_base::{Coords, math};

/// Halvings in the search for the speed that a way leaves room for: to the last bit.
const SPEED_HALVINGS: usize = 60;
/// Part of a joint's jerk that the sum of both motions is planned to use, so that rounding cannot
/// pass it.
const JERK_PART: f64 = 1.0 - 1e-6;
/// Least ratio of the time that an overlap saves to the time that its soft ends cost. A choice:
/// both times are estimates.
const LEAST_GAIN: f64 = 1.1;

/// Limits of a straight motion: speed, acceleration and jerk of the path with which each joint
/// keeps its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    pub(crate) v: f64,
    a: f64,
    j: f64,
}

impl Reach {
    /// In a direction, at most at the given speed.
    pub(crate) fn along(machine: &Machine, d: &Coords, speed: f64) -> Reach {
        let least = |kind: usize| {
            machine
                .joints()
                .map(|(joint, limits)| limits[kind] / d.0[joint].abs())
                .fold(f64::INFINITY, f64::min)
        };
        Reach {
            v: least(0).min(speed),
            a: least(1),
            j: least(2),
        }
    }
}

/// Speeding up from rest: times and jerks of its phases.
#[derive(Clone, Copy, Debug)]
struct SoftRamp([(f64, f64); 4]);

impl SoftRamp {
    /// To a speed.
    fn to(v: f64, Reach { a, j, .. }: Reach, soft: Option<Soft>) -> SoftRamp {
        let (low, knee) = soft.map_or((j, 0.0), |soft| {
            (soft.part * j, (soft.part * j * soft.time_s).min(a))
        });
        // Speed when the acceleration has gone up to the knee, and down again from a peak above it.
        let rise = 0.5 * knee * knee * (1.0 / low - 1.0 / j);
        let full = rise + a * a / j;
        // With a phase of constant acceleration, with a peak above the knee, or at the lower jerk
        // all the way up.
        let peak = if v >= full {
            a
        } else if v >= rise + knee * knee / j {
            ((v - rise) * j).sqrt()
        } else {
            (2.0 * v / (1.0 / low + 1.0 / j)).sqrt()
        };
        let first = peak.min(knee);
        SoftRamp([
            (first / low, low),
            ((peak - first) / j, j),
            ((v - full).max(0.0) / a, 0.0),
            (peak / j, -j),
        ])
    }

    /// How long it takes, and how far it goes.
    fn extent(&self) -> [f64; 2] {
        let (mut t, mut s, mut v, mut a) = (0.0, 0.0, 0.0, 0.0);
        // Constant jerk in each phase: exact.
        for (time, jerk) in self.0 {
            s += (v + (0.5 * a + jerk / 6.0 * time) * time) * time;
            v += (a + 0.5 * jerk * time) * time;
            a += jerk * time;
            t += time;
        }
        [t, s]
    }
}

/// The motion from rest to rest over a way, from the place `from`, with soft ends.
pub(crate) fn line(from: f64, length: f64, reach: Reach, ends: [Option<Soft>; 2]) -> Vec<Knot> {
    let ramps = |v: f64| ends.map(|soft| SoftRamp::to(v, reach, soft));
    let way = |v: f64| ramps(v).map(|ramp| ramp.extent()[1]).iter().sum::<f64>();
    let mut v = reach.v;
    // Both ramps are too long for the way. Their length grows with the speed, so that halving finds
    // the speed that fits.
    if way(v) > length {
        v = Bracket::new(0.0, v)
            .bisect(SPEED_HALVINGS, |v| way(v) <= length)
            .low;
    }
    // The rest of the way at that speed.
    let [up, down] = ramps(v);
    let cruise = ((length - way(v)) / v).max(0.0);
    // Slowing down is speeding up backward in time, in which jerks keep their sign.
    let phases =
        up.0.into_iter()
            .chain([(cruise, 0.0)])
            .chain(down.0.into_iter().rev());
    let mut here = Knot {
        s: from,
        ..Knot::default()
    };
    let mut knots = Vec::with_capacity(10);
    for (time, jerk) in phases.filter(|(time, _)| *time > 0.0) {
        here.j = jerk;
        knots.push(here);
        let t = here.t + time;
        let motion = here.at(t);
        here = Knot {
            t,
            s: motion.s,
            v: motion.v.max(0.0),
            a: motion.a,
            j: 0.0,
        };
    }
    // The end exactly: rounding of the phases must not move it.
    knots.push(Knot {
        t: here.t,
        s: from + length,
        ..Knot::default()
    });
    knots
}

/// The speed that a line from rest to rest is long enough for, up to one.
pub(crate) fn fastest(machine: &Machine, d: &Coords, speed: f64, length: f64) -> f64 {
    let Reach { v, a, j } = Reach::along(machine, d, speed);
    let t = a / j;
    // With a phase of constant acceleration, or with the jerk alone.
    let peak = if length >= 2.0 * a * t * t {
        0.5 * a * ((t * t + 4.0 * length / a).sqrt() - t)
    } else {
        j * math::pow(0.5 * length / j, 2.0 / 3.0)
    };
    v.min(peak)
}

/// Whether a line from rest to rest is long enough for its speed.
pub(crate) fn gets_fast(machine: &Machine, d: &Coords, speed: f64, length: f64) -> bool {
    let Reach { v, a, j } = Reach::along(machine, d, speed);
    length >= v * (v / a + a / j)
}

/// Time lost by a stop from a speed, s: its duration less that of its way at the speed.
fn lost_s(reach: Reach, soft: Option<Soft>) -> f64 {
    let [time, way] = SoftRamp::to(reach.v, reach, soft).extent();
    time - way / reach.v
}

/// How soft the ends of two motions along these directions have to be so that they may overlap at
/// their corner as long as the tolerance allows, and the time that the overlap saves, s. `None` if
/// hard ends do as well or nothing is saved. `speeds` are those that the lines are long enough for.
pub(crate) fn soften(
    machine: &Machine,
    [d, e]: [&Coords; 2],
    speeds: [f64; 2],
    tolerance: f64,
) -> Option<(Soft, f64)> {
    let legs = [
        Reach::along(machine, d, speeds[0]),
        Reach::along(machine, e, speeds[1]),
    ];
    // What the sum of both jerks takes of the joint that has least left.
    let sum = machine
        .joints()
        .map(|(joint, [.., j])| (legs[0].j * d.0[joint] + legs[1].j * e.0[joint]).abs() / j)
        .fold(0.0, f64::max);
    if sum <= 1.0 {
        return None;
    }
    let part = JERK_PART / sum;
    let reach = corner_reach(d, e, tolerance);
    // At the jerk p j a motion from rest covers p j t^3 / 6: the time within the tolerance on
    // either line.
    let longest: f64 = legs
        .iter()
        .map(|leg| math::cbrt(6.0 * reach / (part * leg.j)))
        .sum();
    // The lower jerk ends where it has built up the acceleration.
    let time_s = legs
        .iter()
        .fold(longest, |time, leg| time.min(leg.a / (part * leg.j)));
    let soft = Soft { part, time_s };
    // Both stops get longer; that has to be clearly less than the overlap.
    let cost: f64 = legs
        .iter()
        .map(|leg| lost_s(*leg, Some(soft)) - lost_s(*leg, None))
        .sum();
    (time_s > LEAST_GAIN * cost).then_some((soft, time_s - cost))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Knots meet, ends rest, limits hold, and without soft ends it is the S-curve of the closed
    /// form.
    #[test]
    fn lines_with_soft_ends_are_one_motion() {
        let reach = Reach {
            v: 100.0,
            a: 1000.0,
            j: 30_000.0,
        };
        let soft = |part, time_s| Some(Soft { part, time_s });
        for length in [0.01, 0.5, 3.0, 40.0] {
            let mut shortest = f64::INFINITY;
            for ends in [
                [None, None],
                [None, soft(0.6, 0.02)],
                [soft(0.5, 0.08), soft(0.8, 0.01)],
            ] {
                let knots = line(2.0, length, reach, ends);
                for pair in knots.windows(2) {
                    let (end, next) = (pair[0].at(pair[1].t), pair[1]);
                    assert!(
                        (end.s - next.s).abs() < 1e-9
                            && (end.v - next.v).abs() < 1e-6
                            && (end.a - next.a).abs() < 1e-4,
                        "{end:?} {next:?}"
                    );
                    assert!(
                        end.v <= reach.v * (1.0 + 1e-9)
                            && end.a.abs() <= reach.a * (1.0 + 1e-9)
                            && pair[0].j.abs() <= reach.j
                    );
                }
                let duration = knots.last().map_or(0.0, |knot| knot.t);
                shortest = if ends == [None, None] {
                    duration
                } else {
                    shortest
                };
                assert!(
                    duration >= shortest && duration < shortest * 1.6,
                    "{length}: {duration} {shortest}"
                );
            }
            // From rest to rest: four phases of jerk; with a phase of constant acceleration; with a
            // cruise.
            let expected = match length {
                l if l <= 2.0 * 1000.0 / (30.0 * 30.0) => 4.0 * math::cbrt(0.5 * l / 30_000.0),
                l if l <= 100.0 * (0.1 + 1.0 / 30.0) => {
                    let t = 1.0 / 30.0;
                    let v = 0.5 * ((t * t + 4.0 * l / 1000.0).sqrt() - t) * 1000.0;
                    2.0 * (v / 1000.0 + t)
                }
                l => l / 100.0 + 0.1 + 1.0 / 30.0,
            };
            assert!(
                (shortest - expected).abs() < 1e-9,
                "{length}: {shortest} {expected}"
            );
        }
    }
}
