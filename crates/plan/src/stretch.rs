//! Motion in time between two stops, smoothed by a moving average.

use crate::condition::Piece;
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

/// The motion between two stops. The planned profile has steps of acceleration; what is commanded is its moving average
/// over the window T, delayed so that it starts with the profile and ends one window after it.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    /// When the profile starts, s since the start of the program.
    pub(crate) start_s: f64,
    /// Window of the moving average, s.
    pub(crate) window_s: f64,
    /// Where on the path it starts.
    from: f64,
    phases: VecDeque<Phase>,
    /// Pieces of the path with the place where each begins.
    pieces: VecDeque<(f64, Piece)>,
    /// Where the profile ends so far: time since its start, place, speed.
    end: (f64, f64, f64),
    /// Whether the profile comes to rest at its end and nothing more will be added.
    pub(crate) complete: bool,
}

impl Stretch {
    pub(crate) fn new(start_s: f64, window_s: f64, from: f64) -> Stretch {
        Stretch { start_s, window_s, from, phases: VecDeque::new(), pieces: VecDeque::new(), end: (0.0, from, 0.0), complete: false }
    }

    /// Adds pieces and the profile over them.
    pub(crate) fn extend(&mut self, pieces: impl Iterator<Item = (f64, Piece)>, nodes: &[Node]) {
        self.pieces.extend(pieces);
        for pair in nodes.windows(2) {
            let Some(duration) = pair[0].time_to(&pair[1]) else { continue };
            let a = (pair[1].b - pair[0].b) / (2.0 * (pair[1].s - pair[0].s));
            let phase = Phase { t: self.end.0, duration, s: pair[0].s, v: pair[0].b.sqrt(), a };
            self.end = (phase.end(), pair[1].s, pair[1].b.sqrt());
            self.phases.push_back(phase);
        }
    }

    /// Time from the start of the profile to its end so far, s.
    pub(crate) fn profile_s(&self) -> f64 {
        self.end.0
    }

    /// When the commanded motion ends, s since the start of the program.
    pub(crate) fn rest_s(&self) -> f64 {
        self.start_s + self.end.0 + self.window_s
    }

    /// Where it ends so far.
    pub(crate) fn to(&self) -> f64 {
        self.end.1
    }

    /// Where it starts.
    pub(crate) fn from(&self) -> f64 {
        self.from
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
    fn motion(&self, t: f64) -> Motion {
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

    /// The commanded motion at a time that never falls; what lies before it is forgotten.
    pub(crate) fn advance(&mut self, t: f64) -> Motion {
        while self.phases.len() > 1 && self.phases.front().is_some_and(|phase| phase.end() < t - self.window_s) {
            self.phases.pop_front();
        }
        let motion = self.motion(t);
        while self.pieces.len() > 1 && self.pieces.get(1).is_some_and(|(start, _)| *start <= motion.s) {
            self.pieces.pop_front();
        }
        motion
    }

    /// The piece at a place and the place on it.
    pub(crate) fn peek(&self, s: f64) -> Option<(&Piece, f64)> {
        let index = self.pieces.partition_point(|(start, _)| *start <= s).saturating_sub(1);
        self.pieces.get(index).map(|(start, piece)| (piece, (s - start).max(0.0)))
    }

    /// How many pieces it holds.
    pub(crate) fn len(&self) -> usize {
        self.pieces.len()
    }
}
