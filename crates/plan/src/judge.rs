//! Whether a corner is passed faster by a blend or by a stop.

use crate::condition::{Judge, LinearJoint};
use crate::corner::usual_overlap_s;
use crate::demand::{Demand, Direction, Interval};
use crate::intervals::{Intervals, demands};
use crate::machine::{Machine, NO_LIMIT};
use crate::piece::{PathStep, Piece, Programmed, Soft};
use crate::profile::{Node, Task, duration_s, ideal, plan};
use crate::{sharp, soft};
use lostmotion_base::real::Jet;
use lostmotion_base::{AXES, Coords};
use lostmotion_kinematics::{JointMap, Kinematics};
use lostmotion_path::Curve;

/// Part of what soft ends save, on lines long enough to get fast, that counts against a blend. The
/// speed at the corner is not known well enough to count all of it. A choice: half way between
/// counting none and all of it.
const SOFT_SHARE: f64 = 0.5;

/// Part of the time between a profile without a jerk limit and the averaged one that counts. Tuned
/// on single corners of 5 to 60 degrees, 1 to 40 mm, within 1 to 100 um.
const AVERAGED_SHARE: f64 = 0.25;

/// Decides by time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeJudge<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) kinematics: &'a dyn Kinematics,
    /// Whether motions are made soft at a corner: where they are retimed afterwards, that sees to
    /// it.
    pub(crate) softens: bool,
}

impl Judge for TimeJudge<'_> {
    /// A stop takes v/A to slow down, the window T, and v/A to speed up. A blend at the speed w
    /// takes (v - w)/A twice, T, and its own time, but gets on meanwhile. A stop may be cut short
    /// by an overlap.
    fn is_faster(
        &self,
        blend: &Piece,
        before: &Programmed,
        next: &Programmed,
        tolerance: f64,
    ) -> bool {
        let Ok(parts) = demands(blend, self.machine, self.kinematics) else {
            return false;
        };
        // One set of bounds for the whole blend gives a steady pace along it.
        let mut all = Demand::NONE;
        for (_, demand) in &parts {
            all.join(demand);
        }
        let pace = self.machine.speed_cap(&all);
        // The lines beside it: acceleration, and the speed that is reached between two stops.
        let straight = Demand {
            feed: before.feed.min(next.feed),
            ..all.straightened()
        };
        let window = self.machine.window_s(&all);
        let acceleration = self.machine.acceleration(
            &straight,
            Direction::Faster,
            f64::INFINITY,
            0.0,
            window,
            NO_LIMIT,
        );
        let reachable = (acceleration * before.length.min(next.length)).sqrt();
        let speed = self.machine.speed_cap(&straight).min(reachable);
        // A blend at full speed always wins.
        if pace >= speed {
            return true;
        }
        // Between two stops on a short move the window shrinks as it does on a straight one.
        let window = window.min(
            self.machine
                .straight_window_s(&straight, before.length.min(next.length)),
        );
        let own = blend.curve.length() / pace;
        // What the blend saves of slowing down and speeding up, and the way that it gets on, as
        // time at full speed.
        let saved = 2.0 * pace / acceleration + pace * (window + own) / speed
            - pace * pace / (acceleration * speed);
        // A stretch gives at most half of its time to an overlap.
        let shorter = before.length.min(next.length) / speed + speed / acceleration + window;
        saved > own + self.overlap_s(before, next, tolerance, window, 0.5 * shorter)
    }

    fn time_s(&self, steps: &[PathStep]) -> f64 {
        self.stretches_s(Intervals::gathered(), steps, &mut |intervals| {
            self.stretch_s(intervals)
        })
    }

    fn ideal_s(&self, steps: &[PathStep]) -> f64 {
        self.stretches_s(Intervals::apart(), steps, &mut |intervals| {
            self.ideal_stretch_s(intervals)
        })
    }

    fn time_to_beat_s(&self, steps: &[PathStep], part: f64) -> Option<f64> {
        let stops = |step: &PathStep| matches!(step, PathStep::Stop(_));
        let one = steps
            .split_last()
            .is_some_and(|(_, steps)| !steps.iter().any(stops));
        // A shorter window can only make it less, so that the longest one often settles it.
        let (mut straight, mut bounds, mut only) = (Vec::new(), Vec::new(), Vec::new());
        let most_s = self.stretches_s(Intervals::gathered(), steps, &mut |intervals| {
            if intervals.is_empty() {
                straight.push(Vec::new());
                return 0.0;
            }
            let [ideal, long] = self.bounds_s(intervals);
            straight.push(self.straightened(intervals));
            bounds.push([ideal, long]);
            if one {
                only = intervals.to_vec();
            }
            between(ideal, long)
        });
        // A pose that the machine cannot take: told where the path is planned.
        if most_s.is_infinite() {
            return Some(most_s);
        }
        // What any curve takes at least.
        let mut past_s = 0.0;
        let is_out_of_reach = if one {
            let straight = straight.first().map_or(&[] as &[Interval], Vec::as_slice);
            self.takes_s(straight, part * most_s)
        } else {
            past_s = self.past_corners_s(steps, straight);
            past_s >= part * most_s
        };
        if is_out_of_reach {
            return None;
        }
        let short_s = |intervals: &[Interval]| {
            self.averaged_s(intervals, 0.5 * self.machine.longest_window_s())
        };
        let mut bounds = bounds.into_iter();
        let mut nearer_s = |intervals: &[Interval]| {
            let bounds = (!intervals.is_empty()).then(|| bounds.next()).flatten();
            bounds.map_or(0.0, |[ideal, long]| {
                between(ideal, long.min(short_s(intervals)))
            })
        };
        let time_s = if one {
            nearer_s(&only)
        } else {
            self.stretches_s(Intervals::gathered(), steps, &mut nearer_s)
        };
        (one || past_s < part * time_s).then_some(part * time_s)
    }

    fn joints_at(&self, place: &Coords, tool_mm: &[f64; 3]) -> Vec<LinearJoint> {
        let mut per_mm = [[0.0; 3]; AXES];
        for axis in 0..3 {
            let program: [Jet; AXES] = std::array::from_fn(|k| {
                Jet::new(place.0[k], if k == axis { 1.0 } else { 0.0 }, 0.0, 0.0)
            });
            let Ok(joints) = self.kinematics.inverse_jet(&program, tool_mm) else {
                return Vec::new();
            };
            for (joint, jet) in per_mm.iter_mut().zip(joints) {
                joint[axis] = jet.0[1];
            }
        }
        self.machine
            .joints()
            .map(|(index, [velocity, acceleration, jerk])| LinearJoint {
                per_mm: per_mm[index],
                velocity,
                acceleration,
                jerk,
            })
            .filter(|joint| joint.per_mm != [0.0; 3])
            .collect()
    }

    fn soft(&self, before: &Programmed, next: &Programmed, tolerance: f64) -> Option<Soft> {
        self.softened(before, next, tolerance)
            .filter(|_| self.softens)
            .map(|(soft, _)| soft)
    }
}

impl TimeJudge<'_> {
    /// Sum of the times of all stretches between two stops, given what makes the intervals.
    fn stretches_s(
        &self,
        mut builder: Intervals,
        steps: &[PathStep],
        stretch_s: &mut dyn FnMut(&[Interval]) -> f64,
    ) -> f64 {
        let (mut time, mut intervals) = (0.0, Vec::with_capacity(steps.len()));
        for (k, step) in steps.iter().enumerate() {
            match step {
                PathStep::Piece(piece) => {
                    // A pose that the machine cannot take is told where the path is planned.
                    if builder
                        .push(piece, self.machine, self.kinematics, &mut intervals)
                        .is_err()
                    {
                        return f64::INFINITY;
                    }
                }
                PathStep::Stop(stop) => {
                    builder.finish(&mut intervals);
                    time += stretch_s(&intervals);
                    intervals.clear();
                    let around = [k.checked_sub(1), Some(k + 1)].map(|k| steps.get(k?));
                    if let (
                        Some(tolerance),
                        [Some(PathStep::Piece(before)), Some(PathStep::Piece(next))],
                    ) = (stop.tolerance, around)
                    {
                        time -= self.rounding_s(before, next, tolerance);
                    }
                }
            }
        }
        builder.finish(&mut intervals);
        time + stretch_s(&intervals)
    }

    /// Whether a straight way takes at least so long from rest to rest.
    fn takes_s(&self, straight: &[Interval], least_s: f64) -> bool {
        // No profile is faster than that without a jerk limit, and the shorter window is added to each:
        // on long ways that often settles it.
        let ideal_s = self.ideal_stretch_s(straight);
        ideal_s - 0.5 * self.machine.longest_window_s() >= least_s
            || self.stretch_s(straight) >= least_s
    }

    fn straightened(&self, intervals: &[Interval]) -> Vec<Interval> {
        let straight = intervals.iter().map(|interval| {
            let demand = interval.demand.straightened();
            Interval {
                cap: self.machine.speed_cap(&demand),
                demand,
                ..*interval
            }
        });
        straight.collect()
    }

    /// How long any curve takes at least, given the stretches between stops as if they were straight: it
    /// passes each stop as fast as it can, and cuts the corner there, s. Nothing where the tolerance leaves
    /// no corner at a stop.
    fn past_corners_s(&self, steps: &[PathStep], stretches: Vec<Vec<Interval>>) -> f64 {
        let mut stops = steps.iter().enumerate().filter_map(|(k, step)| match step {
            PathStep::Stop(stop) => Some((k, stop.tolerance)),
            PathStep::Piece(_) => None,
        });
        let Some(PathStep::Piece(first)) = steps.first() else {
            return 0.0;
        };
        let joints = self.joints_at(&first.curve.start(), &first.tool_mm);
        let (mut all, mut cut_s): (Vec<Interval>, f64) = (Vec::new(), 0.0);
        for stretch in stretches {
            let gone = all.last().map_or(0.0, |last| last.end);
            all.extend(stretch.into_iter().map(|interval| Interval {
                start: gone + interval.start,
                end: gone + interval.end,
                ..interval
            }));
            let (Some((k, tolerance)), Some(last)) = (stops.next(), all.last()) else {
                continue;
            };
            // At the end there is none.
            if k + 1 == steps.len() {
                break;
            }
            let passed = tolerance.and_then(|tolerance| {
                Some((tolerance, sharp::speed(steps, k, tolerance, &joints)?))
            });
            let Some((tolerance, speed)) = passed else {
                return 0.0;
            };
            // A speed at one place.
            let place = Interval {
                start: last.end,
                cap: last.cap.min(speed),
                ..last.clone()
            };
            cut_s += sharp::CUT * tolerance / place.cap;
            all.push(place);
        }
        self.ideal_stretch_s(&all) - cut_s
    }

    /// About how long the path from rest to rest takes, s.
    fn stretch_s(&self, intervals: &[Interval]) -> f64 {
        let [ideal, long] = self.bounds_s(intervals);
        let short = self.averaged_s(intervals, 0.5 * self.machine.longest_window_s());
        between(ideal, long.min(short))
    }

    /// The time without a jerk limit, and that of the profile averaged over the longest window, s.
    fn bounds_s(&self, intervals: &[Interval]) -> [f64; 2] {
        [
            self.ideal_stretch_s(intervals),
            self.averaged_s(intervals, self.machine.longest_window_s()),
        ]
    }

    /// The time from rest to rest if jerk cost no more than one window, s.
    fn ideal_stretch_s(&self, intervals: &[Interval]) -> f64 {
        let Some(last) = intervals.last() else {
            return 0.0;
        };
        let (from, to) = (Node::new(0.0, 0.0), Node::new(last.end, 0.0));
        duration_s(&ideal(self.machine, intervals, from, to)) + self.machine.longest_window_s()
    }

    /// The time from rest to rest of the averaged profile, s.
    fn averaged_s(&self, intervals: &[Interval], window_s: f64) -> f64 {
        if intervals.is_empty() {
            return 0.0;
        }
        let task = Task {
            machine: self.machine,
            intervals,
            from: 0.0,
            speed_squared: 0.0,
            complete: true,
            window_s,
        };
        duration_s(&plan(&task).nodes) + window_s
    }

    /// About how long the motions along two pieces overlap at a corner rounded in time, s.
    fn rounding_s(&self, before: &Piece, next: &Piece, tolerance: f64) -> f64 {
        let (Curve::Line(a), Curve::Line(b)) = (&before.curve, &next.curve) else {
            return 0.0;
        };
        let window = self.machine.longest_window_s();
        let most = |length: f64, feed: f64| 0.5 * (length / feed) + window;
        let shorter = most(a.length(), before.feed).min(most(b.length(), next.feed));
        usual_overlap_s(
            self.machine,
            [&a.direction(), &b.direction()],
            tolerance,
            window,
            shorter,
        )
    }

    /// About how long the motions before and after a stop overlap, s.
    fn overlap_s(
        &self,
        before: &Programmed,
        next: &Programmed,
        tolerance: f64,
        window_s: f64,
        most_s: f64,
    ) -> f64 {
        match (&before.curve, &next.curve) {
            (Curve::Line(a), Curve::Line(b))
                if self.kinematics.joint_map() == JointMap::Shifted =>
            {
                let usual = usual_overlap_s(
                    self.machine,
                    [&a.eval(0.0).d1, &b.eval(0.0).d1],
                    tolerance,
                    window_s,
                    most_s,
                );
                // Soft ends save time only on lines that get fast before the corner.
                let is_long = [before, next].into_iter().all(|line| {
                    soft::gets_fast(
                        self.machine,
                        &line.curve.eval(0.0).d1,
                        line.feed,
                        line.length,
                    )
                });
                let soft = self.softened(before, next, tolerance).filter(|_| is_long);
                soft.map_or(usual, |(_, saved)| {
                    usual.max((SOFT_SHARE * saved).min(most_s))
                })
            }
            _ => 0.0,
        }
    }

    /// How soft the motions along two lines have to be to overlap at their corner, and what that
    /// saves, s.
    fn softened(
        &self,
        before: &Programmed,
        next: &Programmed,
        tolerance: f64,
    ) -> Option<(Soft, f64)> {
        let (Curve::Line(_), Curve::Line(_), JointMap::Shifted) =
            (&before.curve, &next.curve, self.kinematics.joint_map())
        else {
            return None;
        };
        let directions = [before, next].map(|line| line.curve.eval(0.0).d1);
        let speed =
            |line: &Programmed, d: &Coords| soft::fastest(self.machine, d, line.feed, line.length);
        let speeds = [speed(before, &directions[0]), speed(next, &directions[1])];
        soft::soften(
            self.machine,
            [&directions[0], &directions[1]],
            speeds,
            tolerance,
        )
    }
}

/// The averaged profile alone is too slow, the one without a jerk limit too fast.
fn between(ideal_s: f64, averaged_s: f64) -> f64 {
    // The window that the first one is given may be longer than is needed.
    averaged_s.min(ideal_s + AVERAGED_SHARE * (averaged_s - ideal_s))
}
