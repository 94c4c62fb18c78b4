//! Where a steady curve is slower than its feed, and by how much.

use super::{LEAST_OVER_FEED, LinearJoint, averaged, largest};
use crate::condition::tube::spline::Breaks;
use crate::condition::tube::way::Way;
use lostmotion_base::math;
use lostmotion_base::vec::{Vec3, dot, norm, scale, sub};
use lostmotion_path::HermiteEnd;
use std::ops::Range;

/// Slowness of an interval, in units of that at its feed, from which on it counts as slower. A choice: a
/// quarter of what a motion has to gain.
const OVER_FEED: f64 = 1.01;
/// Part of the time of a stop around what is slower that belongs to it. Tuned on zigzags, polygons,
/// circles, surfaces and 240 drawn programs: with all of it planning takes longer and plans are no faster,
/// with a quarter of it one in 100 gets 4 to 19 % slower, since a motion begins where the curve bends.
const AROUND_PART: f64 = 0.5;

/// Where a steady curve is slower than its feed, by intervals, with as much around it as the motion takes
/// to get slower and faster: what lies between needs no motion. All of it where none is slow by itself, but
/// its parameter wavers: it follows lines not much longer than the tube is wide, and a motion, which
/// slides along them, finds a shorter way.
pub(in crate::condition::tube) fn busy(
    way: &Way<'_>,
    (breaks, states): (&Breaks, &[HermiteEnd]),
    joints: &[LinearJoint],
) -> Vec<Range<usize>> {
    let least = |limit: fn(&LinearJoint) -> f64| {
        let limits = joints.iter().map(|joint| limit(joint) / norm(joint.per_mm));
        limits.fold(f64::INFINITY, f64::min)
    };
    let acceleration = least(|joint| joint.acceleration);
    let built_up_s = acceleration / least(|joint| joint.jerk);
    let slowness = Slowness::along(way, (breaks, states), joints);
    let limited = paced(&slowness, 1.0, false);
    let fed_s = passed_s(breaks, &fed(&slowness));
    let mut busy: Vec<Range<usize>> = Vec::new();
    let mut walk = way.walk();
    for (k, w) in breaks.0.windows(2).enumerate() {
        if limited[k] <= OVER_FEED * slowness[k].fed {
            continue;
        }
        let speed = walk.to(0.5 * (w[0] + w[1])).feed();
        let around_s = AROUND_PART * (speed / acceleration + built_up_s);
        let [from, to] = [fed_s[k] - around_s, fed_s[k + 1] + around_s];
        let start = fed_s[..k].partition_point(|t| *t <= from).saturating_sub(1);
        let end = (k + 1 + fed_s[k + 1..].partition_point(|t| *t < to)).min(slowness.len());
        match busy.last_mut() {
            // What is short in between belongs to both.
            Some(last) if fed_s[start] - fed_s[last.end] <= around_s => {
                *last = last.start.min(start)..last.end.max(end);
            }
            _ => busy.push(start..end),
        }
    }
    if busy.is_empty() {
        let all = slowness.len();
        let paced_s = passed_s(breaks, &paced(&slowness, 1.0, true))[all];
        if paced_s >= LEAST_OVER_FEED * fed_s[all] {
            busy.push(0..all);
        }
    }
    busy
}

/// The time that an interval takes at least, for its width.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slowness {
    /// At the feed.
    fed: f64,
    /// At the limits of speed and acceleration.
    limits: f64,
    /// At the limits of jerk.
    jerk: f64,
}

impl Slowness {
    fn new(joints: &[LinearJoint], feed: f64, ends: &[HermiteEnd], width: f64) -> Slowness {
        let [from, to] = [0, 1].map(|k| (ends[k].d1.linear(), ends[k].d2.linear()));
        let third = scale(sub(to.1, from.1), 1.0 / width);
        let mut slowness = Slowness {
            fed: norm(from.0).max(norm(to.0)) / feed,
            limits: 0.0,
            jerk: 0.0,
        };
        for joint in joints {
            let of = |vector: Vec3| dot(joint.per_mm, vector).abs();
            slowness.limits = slowness
                .limits
                .max(of(from.0).max(of(to.0)) / joint.velocity)
                .max((of(from.1).max(of(to.1)) / joint.acceleration).sqrt());
            slowness.jerk = slowness.jerk.max(math::cbrt(of(third) / joint.jerk));
        }
        slowness
    }

    /// On each interval of a curve.
    pub(super) fn along(
        way: &Way<'_>,
        (breaks, states): (&Breaks, &[HermiteEnd]),
        joints: &[LinearJoint],
    ) -> Vec<Slowness> {
        let intervals = breaks.0.windows(2).zip(states.windows(2));
        let mut walk = way.walk();
        let of = |(w, ends): (&[f64], &[HermiteEnd])| {
            let feed = walk.to(0.5 * (w[0] + w[1])).feed();
            Slowness::new(joints, feed, ends, w[1] - w[0])
        };
        intervals.map(of).collect()
    }
}

/// The slowness at the feed.
pub(super) fn fed(slowness: &[Slowness]) -> Vec<f64> {
    slowness.iter().map(|slowness| slowness.fed).collect()
}

/// When each break is passed at a slowness of each interval, s.
pub(super) fn passed_s(breaks: &Breaks, slowness: &[f64]) -> Vec<f64> {
    let mut times = vec![0.0];
    let mut time = 0.0;
    for (w, slowness) in breaks.0.windows(2).zip(slowness) {
        time += (w[1] - w[0]) * slowness;
        times.push(time);
    }
    times
}

/// The slowness of a pace that hardly changes from interval to interval, with a part of what jerk asks
/// for; at the feed, too, or at the limits alone.
pub(super) fn paced(slowness: &[Slowness], of_jerk: f64, heeds_feed: bool) -> Vec<f64> {
    let slowness = slowness.iter().map(|slowness| {
        let fed = if heeds_feed { slowness.fed } else { 0.0 };
        fed.max(slowness.limits).max(of_jerk * slowness.jerk)
    });
    averaged(&largest(&slowness.collect::<Vec<f64>>(), 2), 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PathControl;
    use crate::condition::tube::{Found, Tie, curve, steady};
    use crate::item::Heeds;
    use crate::piece::Programmed;
    use lostmotion_base::{BlockRef, Coords};
    use lostmotion_path::Curve;

    /// Lines of 60 mm that turn by 20 degrees to either side.
    fn lines(feed: f64) -> Vec<Programmed> {
        let place = |k: usize| Coords::xyz(59.1 * k as f64, 10.4 * (k % 2) as f64, 0.0);
        moves(&(0..6).map(place).collect::<Vec<_>>(), feed)
    }

    /// A Koch curve of 64 lines.
    fn snowflake(line: f64, feed: f64) -> Vec<Programmed> {
        let mut turns = vec![0_i32];
        for _ in 0..3 {
            turns = turns
                .iter()
                .flat_map(|turn| [0, 1, -1, 0].map(|by| turn + by))
                .collect();
        }
        let mut places = vec![Coords::ZERO];
        let mut place = [0.0; 2];
        for turn in turns {
            let (sin, cos) = math::sin_cos(f64::from(turn) * std::f64::consts::FRAC_PI_3);
            place = [place[0] + line * cos, place[1] + line * sin];
            places.push(Coords::xyz(place[0], place[1], 0.0));
        }
        moves(&places, feed)
    }

    fn moves(places: &[Coords], feed: f64) -> Vec<Programmed> {
        let line = |(k, ends): (usize, &[Coords])| {
            let curve = Curve::line(ends[0], ends[1]);
            Programmed {
                length: curve.length(),
                curve,
                feed,
                heeds: Heeds::Feed,
                control: PathControl::ExactPath,
                tool_mm: [0.0; 3],
                segment: k as u64,
                block: BlockRef::default(),
            }
        };
        places.windows(2).enumerate().map(line).collect()
    }

    fn joints() -> [LinearJoint; 2] {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|per_mm| LinearJoint {
            per_mm,
            velocity: 100.0,
            acceleration: 1e3,
            jerk: 3e4,
        })
    }

    /// Each corner by itself, and none at a feed that the curve allows everywhere.
    #[test]
    fn only_corners_are_slow() {
        let ties = [Tie::Place, Tie::Place];
        for (feed, expected) in [(60.0, 4), (1.0, 0)] {
            let lines = lines(feed);
            let way = Way::new(&lines, 0.0, lines[4].length, &[0.01; 5]).unwrap();
            let steady = steady(&way, ties).unwrap();
            let found = busy(&way, (&steady.breaks, &steady.states), &joints());
            assert_eq!(found.len(), expected, "{found:?}");
            for (stretch, corner) in found.iter().zip(1..) {
                let [from, to] = [stretch.start, stretch.end].map(|k| steady.breaks.0[k]);
                let at = way.parameters()[corner];
                assert!(from < at && at < to, "{corner}");
                // not as far as the middle of a line: breaks lie some millimetres apart there
                assert!(
                    at - from < 28.0 && to - at < 28.0,
                    "{corner}: {from} {at} {to}"
                );
            }
        }
    }

    /// Lines that are not much longer than the tube is wide may be slow nowhere by themselves; a motion
    /// finds a shorter way all the same.
    #[test]
    fn all_is_slow_where_the_parameter_wavers() {
        let lines = snowflake(0.2, 1.0);
        let way = Way::new(&lines, 0.0, lines[63].length, &[0.1; 64]).unwrap();
        let ties = [Tie::Place, Tie::Place];
        let steady = steady(&way, ties).unwrap();
        let found = busy(&way, (&steady.breaks, &steady.states), &joints());
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0], 0..steady.breaks.intervals());
        let length = |found: &Found| -> f64 {
            let chords = found.pieces.iter().map(|piece| {
                let at = |k: i32| {
                    piece
                        .curve
                        .point(piece.curve.length() * f64::from(k) / 8.0)
                        .linear()
                };
                (0..8).map(|k| norm(sub(at(k + 1), at(k)))).sum::<f64>()
            });
            chords.sum()
        };
        let motion = curve(&way, ties, &joints(), 1).unwrap();
        let steady = steady.found.unwrap();
        assert!(motion.has_motion());
        let [with, without] = [length(&motion), length(&steady)];
        assert!(with < 0.992 * without, "{with} {without}");
    }

    /// Where a motion takes the place of some of the steady curve, place and derivatives go on, and so do
    /// the lines under it.
    #[test]
    fn what_is_replaced_goes_on_as_the_rest_does() {
        let lines = lines(60.0);
        let way = Way::new(&lines, 0.0, lines[4].length, &[0.01; 5]).unwrap();
        let found = curve(&way, [Tie::Place, Tie::Place], &joints(), 1).unwrap();
        let changes = found
            .speeds
            .windows(2)
            .filter(|pair| pair[0].is_some() != pair[1].is_some());
        assert_eq!(changes.count(), 8);
        for (pair, place) in found.pieces.windows(2).zip(&found.places) {
            let [before, next] = [&pair[0].curve, &pair[1].curve];
            let (end, start) = (before.eval(before.length()), next.eval(0.0));
            for (a, b) in [(end.p, start.p), (end.d1, start.d1), (end.d2, start.d2)] {
                assert!(norm(sub(a.linear(), b.linear())) < 1e-9, "{place:?}");
            }
            // the next piece begins under the place at which this one ends, or at a vertex
            let first = pair[1].marks[0];
            let (line, s) = *place;
            let at_vertex =
                first.segment == line as u64 + 1 && first.s == 0.0 && s == lines[line].length;
            assert!(
                at_vertex || (first.segment == line as u64 && (first.s - s).abs() < 1e-9),
                "{place:?} {first:?}"
            );
        }
    }
}
