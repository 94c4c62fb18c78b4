//! A profile of piecewise constant acceleration and its moving average.

use crate::profile::Node;
use std::collections::VecDeque;

/// Constant acceleration over some time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Phase {
    /// When it begins, s since the start of the stretch.
    t: f64,
    duration: f64,
    s: f64,
    v: f64,
    a: f64,
}

impl Phase {
    fn end(&self) -> f64 {
        self.t + self.duration
    }

    fn at(&self, t: f64) -> (f64, f64) {
        let x = t - self.t;
        (self.s + (self.v + 0.5 * self.a * x) * x, self.v + self.a * x)
    }

    /// Integral of `s - origin` between two times.
    fn integral(&self, from: f64, to: f64, origin: f64) -> f64 {
        let primitive = |t: f64| {
            let x = t - self.t;
            ((self.s - origin) + (self.v / 2.0 + self.a / 6.0 * x) * x) * x
        };
        primitive(to) - primitive(from)
    }
}

/// Place, speed and acceleration on the path of a stretch, after smoothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Motion {
    pub(crate) s: f64,
    pub(crate) v: f64,
    pub(crate) a: f64,
}

/// A speed profile from rest, and the moving average of it over the window T, delayed so that it starts with the profile
/// and ends one window after it.
#[derive(Clone, Debug)]
pub(crate) struct Smooth {
    /// Window of the moving average, s.
    pub(crate) window_s: f64,
    /// Where on the path it starts.
    pub(crate) from: f64,
    phases: VecDeque<Phase>,
    /// Where the profile ends so far: time since its start, place, speed.
    end: (f64, f64, f64),
}

impl Smooth {
    pub(crate) fn new(window_s: f64, from: f64) -> Smooth {
        Smooth { window_s, from, phases: VecDeque::new(), end: (0.0, from, 0.0) }
    }

    /// Adds a part of the profile.
    pub(crate) fn extend(&mut self, nodes: &[Node]) {
        for pair in nodes.windows(2) {
            let Some(duration) = pair[0].time_to(&pair[1]) else { continue };
            let a = (pair[1].b - pair[0].b) / (2.0 * (pair[1].s - pair[0].s));
            let phase = Phase { t: self.end.0, duration, s: pair[0].s, v: pair[0].b.sqrt(), a };
            self.end = (phase.end(), pair[1].s, pair[1].b.sqrt());
            self.phases.push_back(phase);
        }
    }

    /// The same motion backward in time, from rest at its end: places are distances to go.
    pub(crate) fn reversed(&self) -> Smooth {
        let (time, to, _) = self.end;
        let mut phases = VecDeque::with_capacity(self.phases.len());
        for phase in self.phases.iter().rev() {
            let (s, v) = phase.at(phase.end());
            phases.push_back(Phase { t: time - phase.end(), duration: phase.duration, s: to - s, v, a: -phase.a });
        }
        let (low, v) = self.phases.front().map_or((self.from, 0.0), |phase| (phase.s, phase.v));
        let end = (time - self.phases.front().map_or(0.0, |phase| phase.t), to - low, v);
        Smooth { window_s: self.window_s, from: 0.0, phases, end }
    }

    /// Time from the start of the profile to its end so far, s.
    pub(crate) fn profile_s(&self) -> f64 {
        self.end.0
    }

    /// Time from the start of the profile to the end of the smoothed motion, s.
    pub(crate) fn duration_s(&self) -> f64 {
        self.end.0 + self.window_s
    }

    /// Where it ends so far.
    pub(crate) fn to(&self) -> f64 {
        self.end.1
    }

    /// Times up to `until` at which the jerk may step, added to `out` in no order.
    pub(crate) fn steps(&self, until: f64, out: &mut Vec<f64>) {
        for phase in self.phases.iter().take_while(|phase| phase.t < until) {
            for t in [phase.t, phase.end(), phase.t + self.window_s, phase.end() + self.window_s] {
                if 0.0 < t && t < until {
                    out.push(t);
                }
            }
        }
    }

    /// Place and speed of the profile.
    fn profile(&self, t: f64) -> (f64, f64) {
        if t <= 0.0 {
            return (self.from, 0.0);
        }
        let index = self.phases.partition_point(|phase| phase.end() < t);
        self.phases.get(index).map_or((self.end.1, self.end.2), |phase| phase.at(t))
    }

    /// The moving average of the profile over the window before a time.
    pub(crate) fn motion(&self, t: f64) -> Motion {
        let (low, high) = (t - self.window_s, t);
        let ((s0, v0), (s1, v1)) = (self.profile(low), self.profile(high));
        let origin = s0;
        let mut sum = (self.from - origin) * (-low).max(0.0).min(self.window_s);
        let first = self.phases.partition_point(|phase| phase.end() <= low);
        for phase in self.phases.iter().skip(first).take_while(|phase| phase.t < high) {
            sum += phase.integral(low.max(phase.t), high.min(phase.end()), origin);
        }
        sum += (self.end.1 - origin) * (high - low.max(self.end.0)).max(0.0);
        Motion { s: origin + sum / self.window_s, v: (s1 - s0) / self.window_s, a: (v1 - v0) / self.window_s }
    }

    /// Forgets what lies before a time and cannot be asked for from then on.
    pub(crate) fn forget(&mut self, t: f64) {
        while self.phases.len() > 1 && self.phases.front().is_some_and(|phase| phase.end() < t - self.window_s) {
            self.phases.pop_front();
        }
    }
}
