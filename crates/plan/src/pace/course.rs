//! The planned motion by its own time, as far as it is known.

use crate::optimal::{self, LimitedJoint, between, joints};
use crate::{Heeds, Sample};
use lostmotion_base::{AXES, AxisLimits, Coords};
use std::collections::VecDeque;

/// Part of its limits up to which a joint counts as still: rounding of the plan.
const STILL_PART: f64 = 1e-9;
/// How far the plan is looked at ahead of the motion, in times that the slowest joint takes to
/// stop. Record 41 of the decisions.
const LOOK_AHEAD_STOPS: f64 = 10.0;

/// Place on the plan in steps, pace, and its derivative by real time, 1/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PaceState {
    pub(super) sigma: f64,
    pub(super) w: f64,
    pub(super) u: f64,
}

impl PaceState {
    /// After a time at a constant second derivative of the pace, 1/s2.
    pub(super) fn after(&self, t: f64, r: f64, step_s: f64) -> PaceState {
        let PaceState { sigma, w, u } = *self;
        PaceState {
            sigma: sigma + (w + (0.5 * u + r * t / 6.0) * t) * t / step_s,
            w: w + (u + 0.5 * r * t) * t,
            u: u + r * t,
        }
    }
}

/// One joint's derivatives by the plan's own time at a place. The third may step in its
/// neighbourhood: its least and largest.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rates {
    pub(super) v: f64,
    pub(super) a: f64,
    pub(super) j: [f64; 2],
    /// Limits, or what the plan itself takes where that is more.
    pub(super) limits: [f64; 3],
}

/// All joints that move at a place; the rest are zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct CoursePlace {
    pub(super) joints: [Rates; AXES],
    pub(super) count: usize,
}

impl CoursePlace {
    pub(super) fn joints(&self) -> &[Rates] {
        &self.joints[..self.count]
    }
}

/// The plan: samples at even steps of its own time, between them the quintics that have their
/// velocities and accelerations.
#[derive(Clone, Debug)]
pub(super) struct Course {
    joints: Vec<LimitedJoint>,
    samples: VecDeque<Sample>,
    /// Step of the first sample held.
    first: u64,
    /// Steps from which on another override counts, with that override.
    kinds: VecDeque<(u64, Heeds)>,
    pub(super) step_s: f64,
    pub(super) complete: bool,
}

impl Course {
    pub(super) fn new(limits: &[Option<AxisLimits>; AXES], step_s: f64) -> Course {
        Course {
            joints: joints(limits, [1.0; 3], 0.0),
            samples: VecDeque::new(),
            first: 0,
            kinds: VecDeque::new(),
            step_s,
            complete: false,
        }
    }

    /// How long the slowest joint takes to stop, s.
    pub(super) fn stop_s(&self) -> f64 {
        optimal::stop_s(&self.joints)
    }

    /// The least second derivative of the pace that a joint at full speed can follow, 1/s2.
    pub(super) fn reach(&self) -> f64 {
        self.joints
            .iter()
            .map(
                |LimitedJoint {
                     limits: [v, _, j], ..
                 }| j / v,
            )
            .fold(f64::INFINITY, f64::min)
    }

    /// How far the plan is looked at ahead of the motion, in steps.
    pub(super) fn far(&self) -> usize {
        (LOOK_AHEAD_STOPS * self.stop_s() / self.step_s).ceil() as usize
    }

    pub(super) fn push(&mut self, sample: Sample) {
        if self
            .kinds
            .back()
            .is_none_or(|(_, last)| *last != sample.heeds)
        {
            self.kinds
                .push_back((self.first + self.samples.len() as u64, sample.heeds));
        }
        self.samples.push_back(sample);
    }

    /// The overrides that count at a place and ahead of it, as far as the plan is looked at, in
    /// order.
    pub(super) fn kinds(&self, sigma: f64) -> impl Iterator<Item = Heeds> + '_ {
        let far = sigma + self.far() as f64;
        let begun = self
            .kinds
            .partition_point(|(step, _)| *step as f64 <= sigma)
            .saturating_sub(1);
        self.kinds
            .iter()
            .skip(begun)
            .take_while(move |(step, _)| *step as f64 <= far)
            .map(|(_, kind)| *kind)
    }

    /// The last step known; none before the first sample.
    pub(super) fn end(&self) -> Option<f64> {
        (self.first + self.samples.len() as u64)
            .checked_sub(1)
            .map(|step| step as f64)
    }

    /// How many samples are held.
    pub(super) fn held(&self) -> usize {
        self.samples.len()
    }

    /// Forgets what lies well before a place.
    pub(super) fn forget(&mut self, sigma: f64) {
        while self.samples.len() > 4 && (self.first + 3) as f64 <= sigma {
            self.samples.pop_front();
            self.first += 1;
        }
        while self
            .kinds
            .get(1)
            .is_some_and(|(step, _)| *step <= self.first)
        {
            self.kinds.pop_front();
        }
    }

    /// Index of the interval held that a place is in, and the part of it.
    fn find(&self, sigma: f64) -> (usize, f64) {
        let last = self.samples.len().saturating_sub(2);
        let from = (sigma - self.first as f64).max(0.0);
        let index = (from as usize).min(last);
        (index, (from - index as f64).min(1.0))
    }

    /// Whether the plan stands still over the interval that a place is in.
    pub(super) fn rests(&self, sigma: f64) -> bool {
        let (index, _) = self.find(sigma);
        let rests = |sample: &Sample| {
            sample.velocity == Coords::ZERO && sample.acceleration == Coords::ZERO
        };
        match (self.samples.get(index), self.samples.get(index + 1)) {
            (Some(a), Some(b)) => rests(a) && rests(b) && a.position == b.position,
            (Some(a), None) => rests(a),
            _ => true,
        }
    }

    /// Whether the plan has neither speed nor acceleration at a place.
    pub(super) fn stands(&self, sigma: f64) -> bool {
        let sample = self.sample(&PaceState {
            sigma,
            w: 1.0,
            u: 0.0,
        });
        sample.is_some_and(|sample| {
            sample.velocity == Coords::ZERO && sample.acceleration == Coords::ZERO
        })
    }

    /// The derivatives of the joints at a place.
    pub(super) fn at(&self, sigma: f64) -> CoursePlace {
        let (index, part) = self.find(sigma);
        let mut place = CoursePlace {
            joints: [Rates::default(); AXES],
            count: 0,
        };
        let around = [index.saturating_sub(1), index, index + 1, index + 2].map(|k| {
            self.samples
                .get(k.min(self.samples.len().saturating_sub(1)))
        });
        let [Some(before), Some(a), Some(b), Some(after)] = around else {
            return place;
        };
        for joint in &self.joints {
            let k = joint.index;
            let state = |sample: &Sample| {
                [
                    sample.position.0[k],
                    sample.velocity.0[k] * self.step_s,
                    sample.acceleration.0[k] * self.step_s * self.step_s,
                ]
            };
            let [_, v, acceleration] = optimal::quintic(state(a), state(b), part);
            let accelerations = [before, a, b, after].map(|sample| sample.acceleration.0[k]);
            // Accelerations are sampled, so that the jerk is known as a range over three intervals.
            let [j0, j1, j2] =
                [0, 1, 2].map(|i| (accelerations[i + 1] - accelerations[i]) / self.step_s);
            let (v, a) = (v / self.step_s, acceleration / (self.step_s * self.step_s));
            let j = [j0.min(j1).min(j2), j0.max(j1).max(j2)];
            let [most_v, most_a, most_j] = joint.limits;
            // A joint at rest must not bound the pace by rounding.
            if v.abs() <= STILL_PART * most_v
                && a.abs() <= STILL_PART * most_a
                && j[1] - j[0] <= STILL_PART * most_j
            {
                continue;
            }
            // Where the plan itself uses more than a limit, by rounding, its own pace has to stay
            // possible.
            place.joints[place.count] = Rates {
                v,
                a,
                j,
                limits: [
                    most_v.max(v.abs()),
                    most_a.max(a.abs()),
                    most_j.max(j[1]).max(-j[0]),
                ],
            };
            place.count += 1;
        }
        place
    }

    /// The motion in a state of pace: position on the plan, velocity and acceleration by real time.
    pub(super) fn sample(&self, state: &PaceState) -> Option<Sample> {
        let (index, part) = self.find(state.sigma);
        let a = self.samples.get(index)?;
        if self.complete && self.end().is_some_and(|end| state.sigma >= end) {
            return self.samples.back().copied();
        }
        // At the pace 1 on a sample: that sample, to the bit.
        if part == 0.0 && state.w.to_bits() == 1.0_f64.to_bits() && state.u == 0.0 {
            return Some(*a);
        }
        let b = self.samples.get(index + 1).unwrap_or(a);
        let pair = [a, b].map(|sample| *sample);
        Some(between(
            [&pair[0], &pair[1]],
            self.step_s,
            part,
            [state.w, state.u],
        ))
    }
}
