//! Rounding a corner in time: the next stretch sets out before the one before has come to rest.
//!
//! Where two lines meet at an angle, a stop makes every joint that only one of them moves wait for
//! the other. Letting the end of one motion and the start of the next add up for a time tau cuts
//! the corner a little and saves tau. With the distance u still to go on the first line and the
//! distance w gone on the second, the tool is w from the first line and u from the second, at most,
//! so that it leaves the path by no more than min(u, w). Where u = w = x it is x |e - d| from the
//! corner, with the directions d and e of the lines. The tolerance holds for both distances, so
//! that the time of overlap follows from the two motions alone; the joints' limits are checked on
//! the sum of both.

use crate::chord::Chord;
use crate::machine::Machine;
use crate::motion::Stretch;
use crate::motion::{PathState, Profile};
use crate::piece::{Piece, corner_reach};
use lostmotion_base::root::Bracket;
use lostmotion_base::{Coords, math};
use lostmotion_path::Curve;

/// Halvings in the search for the time at which a distance is reached: to 1e-12 of the longest
/// overlap.
const TIME_HALVINGS: usize = 40;
/// Halvings in the search for an overlap that keeps the limits: to a thousandth of the longest one.
const FIT_HALVINGS: usize = 10;
/// Shorter overlaps, s, are left out: they save nothing that counts.
const NEGLIGIBLE_S: f64 = 1e-4;
/// Steps of the jerk that are nearer to each other than this, s, are taken as one: a difference of
/// accelerations between them would be rounding.
const SAME_STEP_S: f64 = 1e-7;
/// Places in a time without a step of the jerk at which the bow of the tool is evaluated. A choice:
/// more find sharper peaks and cost an evaluation each.
const BOW_PLACES: u32 = 8;
/// Sums of two motions that both keep a limit exactly may pass it by rounding.
const ROUNDING_FACTOR: f64 = 1.0 + 1e-7;

/// One of the two motions at a corner, seen from the corner: distance from it by time from rest.
#[derive(Clone, Debug)]
pub(crate) struct Leg {
    profile: Profile,
    /// Place of the corner.
    from: f64,
    /// Derivative of the joints by the path, in the direction of travel.
    direction: Coords,
    /// Length of the straight line at the corner.
    room: f64,
    /// Longest overlap, s.
    longest_s: f64,
    /// Largest speed of the path parameter, 1/s.
    feed: f64,
    /// Program coordinates at the corner, and the tool's offset.
    corner: Coords,
    tool_mm: [f64; 3],
}

impl Leg {
    /// The end of a stretch that comes to rest on a line.
    pub(crate) fn end_of(stretch: &Stretch) -> Option<Leg> {
        let piece = stretch.last()?;
        Leg::new(
            piece,
            piece.curve.end(),
            stretch.profile.reversed(),
            0.0,
            stretch.longest_overlap_s(),
        )
    }

    /// The start of a stretch on a line.
    pub(crate) fn start_of(stretch: &Stretch) -> Option<Leg> {
        let piece = stretch.first()?;
        Leg::new(
            piece,
            piece.curve.start(),
            stretch.profile.clone(),
            stretch.from,
            stretch.longest_overlap_s(),
        )
    }

    fn new(
        piece: &Piece,
        corner: Coords,
        profile: Profile,
        from: f64,
        longest_s: f64,
    ) -> Option<Leg> {
        let Curve::Line(_) = piece.curve else {
            return None;
        };
        let direction = piece.curve.eval(0.0).d1;
        let (room, feed, tool_mm) = (piece.curve.length(), piece.feed, piece.tool_mm);
        Some(Leg {
            profile,
            from,
            direction,
            room,
            longest_s,
            feed,
            corner,
            tool_mm,
        })
    }

    /// Distance from the corner, speed and acceleration at a time from rest.
    fn at(&self, t: f64) -> PathState {
        let state = self.profile.at(t);
        PathState {
            s: state.s - self.from,
            ..state
        }
    }

    /// The latest time, up to the longest, at which it is no farther from the corner than a
    /// distance.
    fn time_to(&self, distance: f64) -> f64 {
        let near_enough = |t: f64| self.at(t).s <= distance;
        if near_enough(self.longest_s) {
            return self.longest_s;
        }
        Bracket::new(0.0, self.longest_s)
            .bisect(TIME_HALVINGS, near_enough)
            .low
    }
}

/// How long two motions may overlap at their corner without leaving the path by more than a
/// tolerance, s.
pub(crate) fn overlap_s(machine: &Machine, before: &Leg, after: &Leg, tolerance: f64) -> f64 {
    let reach = corner_reach(&before.direction, &after.direction, tolerance);
    // One of both motions has to be within reach of the corner at any time.
    let longest = (before.time_to(reach) + after.time_to(reach))
        .min(before.longest_s)
        .min(after.longest_s);
    // With one motion's jerk after the other's, joints that both move have less to bear than while
    // both have jerk.
    let in_turn = before.profile.onset_s() + after.profile.onset_s();
    // Both candidates are checked before the search for what the limits leave.
    for overlap in [longest, in_turn] {
        if overlap <= longest && fits(machine, before, after, overlap) {
            return overlap;
        }
    }
    let overlap = Bracket::new(0.0, longest.min(in_turn))
        .bisect(FIT_HALVINGS, |overlap| {
            fits(machine, before, after, overlap)
        })
        .low;
    if overlap > NEGLIGIBLE_S { overlap } else { 0.0 }
}

/// About how long the motions along two lines overlap at their corner, s, if both use the window T
/// and neither gives more than `most_s`.
pub(crate) fn usual_overlap_s(
    machine: &Machine,
    [a, b]: [&Coords; 2],
    tolerance: f64,
    window_s: f64,
    most_s: f64,
) -> f64 {
    // Path jerk from rest: the largest that joints have, or that builds up their acceleration in
    // one window.
    let jerk = |d: &Coords| {
        machine
            .joints()
            .map(|(joint, [_, a, j])| j.min(a / window_s) / d.0[joint].abs())
            .fold(f64::INFINITY, f64::min)
    };
    let (first, second) = (jerk(a), jerk(b));
    // The way on either line that the tolerance allows.
    let reach = corner_reach(a, b, tolerance);
    // The jerk lasts one window, and the acceleration is constant from then on.
    let time_to = |jerk: f64| {
        let cubic = math::cbrt(6.0 * reach / jerk);
        let later = 2.0 * reach / (jerk * window_s) - window_s * window_s / 12.0;
        if cubic <= window_s {
            cubic
        } else {
            0.5 * window_s + later.sqrt()
        }
    };
    let longest = (time_to(first) + time_to(second)).min(most_s);
    // What each motion takes of the jerk of each joint.
    let jerks = machine
        .joints()
        .map(|(joint, [.., j])| [first * a.0[joint] / j, second * b.0[joint] / j]);
    if jerks.clone().any(|[d, e]| (d + e).abs() > ROUNDING_FACTOR) {
        // Not while both have jerk; in between the first slows down while the second speeds up.
        let mut accelerations = machine.joints().map(|(joint, [_, limit, _])| {
            (second * b.0[joint] - first * a.0[joint]).abs() * window_s / limit
        });
        let fit = accelerations.all(|part| part <= ROUNDING_FACTOR);
        return if fit && longest >= 2.0 * window_s {
            2.0 * window_s
        } else {
            0.0
        };
    }
    // One window from rest the jerk of a motion may change its sign.
    if jerks.clone().any(|[d, e]| (d - e).abs() > ROUNDING_FACTOR) {
        longest.min(window_s)
    } else {
        longest
    }
}

/// Whether the sum of both motions keeps every limit over an overlap.
fn fits(machine: &Machine, before: &Leg, after: &Leg, overlap_s: f64) -> bool {
    // Beyond its line a motion would go in another direction.
    if before.at(overlap_s).s > before.room || after.at(overlap_s).s > after.room {
        return false;
    }
    // Between two steps of either jerk the sum has constant jerk: its ends bound it.
    let mut times = Vec::new();
    before.profile.steps(overlap_s, &mut times);
    // The motion before the corner runs backward from it.
    times.iter_mut().for_each(|t| *t = overlap_s - *t);
    after.profile.steps(overlap_s, &mut times);
    times.push(overlap_s);
    times.sort_by(f64::total_cmp);
    let states = |t: f64| Sum {
        before: before.at(overlap_s - t),
        after: after.at(t),
    };
    let mut start = 0.0;
    let mut left = states(0.0);
    for t in times {
        let step = t - start;
        if step < SAME_STEP_S {
            continue;
        }
        let right = states(t);
        // Its bow has no such bound: look at places in between.
        let bows = |chord: &Chord| {
            (1..=BOW_PLACES).any(|k| {
                bows(
                    chord,
                    before,
                    after,
                    &states(start + step * f64::from(k) / f64::from(BOW_PLACES)),
                )
            })
        };
        if !keeps(machine, before, after, &left, &right, step)
            || machine.chord.as_ref().is_some_and(bows)
        {
            return false;
        }
        (start, left) = (t, right);
    }
    true
}

/// The states of two motions that add up. The one before runs backward in its own time: its speed
/// counts as it is, its acceleration with the other sign.
#[derive(Clone, Copy, Debug)]
struct Sum {
    before: PathState,
    after: PathState,
}

/// Whether a command cycle around a place of the sum takes the tool too far off its way.
fn bows(chord: &Chord, before: &Leg, after: &Leg, sum: &Sum) -> bool {
    let velocity = after.direction * sum.after.v + before.direction * sum.before.v;
    let acceleration = after.direction * sum.after.a + before.direction * -sum.before.a;
    let joints = after.corner + Coords::xyz(after.tool_mm[0], after.tool_mm[1], after.tool_mm[2]);
    chord.part([&joints, &velocity, &acceleration], &after.tool_mm) > 1.0
}

/// Whether the sum keeps every limit over a time without a step of the jerk, given the states at
/// its ends.
fn keeps(machine: &Machine, before: &Leg, after: &Leg, left: &Sum, right: &Sum, step: f64) -> bool {
    // Between its ends a motion of constant jerk leaves the chord of its speed by at most j h^2 /
    // 8.
    let jerk = [
        (right.before.a - left.before.a) / -step,
        (right.after.a - left.after.a) / step,
    ];
    let bulge = |k: usize| jerk[k].abs() * step * step / 8.0;
    let fastest =
        left.before.v.max(right.before.v) + bulge(0) + left.after.v.max(right.after.v) + bulge(1);
    let free = fastest <= before.feed.min(after.feed) * ROUNDING_FACTOR;
    free && machine.joints().all(|(joint, [v, a, j])| {
        let (d, e) = (before.direction.0[joint], after.direction.0[joint]);
        // Velocities of both motions add up; accelerations too, where that of the one that slows
        // down has the other sign in its own time.
        let speed = |sum: &Sum| (sum.before.v * d + sum.after.v * e).abs();
        let acceleration = |sum: &Sum| (sum.after.a * e - sum.before.a * d).abs();
        let bulge = (jerk[0] * d + jerk[1] * e).abs() * step * step / 8.0;
        speed(left).max(speed(right)) + bulge <= v * ROUNDING_FACTOR
            && acceleration(left).max(acceleration(right)) <= a * ROUNDING_FACTOR
            && (jerk[0] * d + jerk[1] * e).abs() <= j * ROUNDING_FACTOR
    })
}
