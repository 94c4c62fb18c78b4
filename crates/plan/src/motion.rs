//! Motion along the path by time: states, knots of constant jerk between them, profiles made of knots,
//! and the motion between two stops.

use crate::piece::Piece;
use lostmotion_base::Coords;
use lostmotion_base::root::Bracket;
use std::collections::VecDeque;
use std::sync::Arc;

/// Most steps of Newton's method towards the time at which a motion is at a place; halving alone
/// would need 53.
const TIME_STEPS: usize = 60;

/// Place, speed and acceleration on the path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PathState {
    pub(crate) s: f64,
    pub(crate) v: f64,
    pub(crate) a: f64,
}

/// A corner of a profile: the state at a time, and the jerk from then to the next knot (0 in the
/// last one). Between two knots the place is the cubic that this makes, which meets the state of
/// the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Knot {
    /// s since the start of the section or stretch.
    pub(crate) t: f64,
    pub(crate) s: f64,
    pub(crate) v: f64,
    pub(crate) a: f64,
    pub(crate) j: f64,
}

impl Knot {
    /// The state at a time before the next knot.
    pub(crate) fn at(&self, t: f64) -> PathState {
        let x = t - self.t;
        PathState {
            s: self.s + (self.v + (0.5 * self.a + self.j / 6.0 * x) * x) * x,
            v: self.v + (self.a + 0.5 * self.j * x) * x,
            a: self.a + self.j * x,
        }
    }

    /// When a motion that goes forward is at a place, between two times before the next knot.
    pub(crate) fn time_at(&self, s: f64, from: f64, to: f64) -> f64 {
        let (first, last) = (self.at(from).s, self.at(to).s);
        if last <= s {
            return to;
        }
        // Newton's method from where the chord says, within a bracket, as the place rises with
        // time.
        let mut bracket = Bracket::new(from, to);
        let part = (s - first) / (last - first);
        let mut t = from + (to - from) * if part > 0.0 && part < 1.0 { part } else { 0.5 };
        for _ in 0..TIME_STEPS {
            let motion = self.at(t);
            bracket.narrow(t, motion.s - s);
            let next = bracket.inside_or_middle(t - (motion.s - s) / motion.v);
            if (next - t).abs() <= f64::EPSILON * to {
                return next.max(bracket.low);
            }
            t = next;
        }
        bracket.high
    }
}

/// The state at a time; before the first knot and after the last one it rests in their states.
pub(crate) fn state_at(knots: &[Knot], t: f64) -> PathState {
    let index = knots.partition_point(|knot| knot.t <= t).saturating_sub(1);
    match knots.get(index) {
        Some(knot) if index + 1 < knots.len() && t >= knot.t => knot.at(t),
        Some(knot) => PathState {
            s: knot.s,
            v: knot.v,
            a: knot.a,
        },
        None => PathState::default(),
    }
}

/// The states at rising times.
pub(crate) fn states(
    knots: &[Knot],
    times: impl Iterator<Item = f64>,
) -> impl Iterator<Item = PathState> {
    let mut rest = knots;
    times.map(move |t| {
        while rest.get(1).is_some_and(|next| next.t <= t) {
            rest = &rest[1..];
        }
        state_at(rest.get(..2).unwrap_or(rest), t)
    })
}

/// Place by time over a stretch, as far as it is known.
#[derive(Clone, Debug, Default)]
pub(crate) struct Profile {
    knots: VecDeque<Knot>,
}

impl Profile {
    /// Adds a section that sets out from the state at the end so far.
    pub(crate) fn extend(&mut self, section: &[Knot]) {
        let end_s = self.end_s();
        self.knots.pop_back();
        self.knots.extend(section.iter().map(|knot| Knot {
            t: knot.t + end_s,
            ..*knot
        }));
    }

    /// The same motion backward in time, from its end: places are distances to go.
    pub(crate) fn reversed(&self) -> Profile {
        let (time, to) = (self.end_s(), self.to());
        let mut knots = VecDeque::with_capacity(self.knots.len());
        // The jerk of a knot lasts until the next one, which backward is the knot before.
        let before = self
            .knots
            .iter()
            .rev()
            .skip(1)
            .map(|knot| knot.j)
            .chain([0.0]);
        for (knot, j) in self.knots.iter().rev().zip(before) {
            knots.push_back(Knot {
                t: time - knot.t,
                s: to - knot.s,
                v: knot.v,
                a: -knot.a,
                j,
            });
        }
        Profile { knots }
    }

    /// Time of the last state known, s since the start.
    pub(crate) fn end_s(&self) -> f64 {
        self.knots.back().map_or(0.0, |knot| knot.t)
    }

    /// Place of the last state known.
    pub(crate) fn to(&self) -> f64 {
        self.knots.back().map_or(0.0, |knot| knot.s)
    }

    /// How long the jerk lasts with which it sets out, s.
    pub(crate) fn onset_s(&self) -> f64 {
        self.knots
            .iter()
            .zip(self.knots.iter().skip(1))
            .find(|(knot, _)| knot.j != 0.0)
            .map_or(0.0, |(knot, next)| next.t - knot.t)
    }

    /// Times up to `until` at which the jerk steps, added to `out`.
    pub(crate) fn steps(&self, until: f64, out: &mut Vec<f64>) {
        out.extend(
            self.knots
                .iter()
                .map(|knot| knot.t)
                .filter(|t| 0.0 < *t && *t < until),
        );
    }

    /// The state at a time; before its start and after its end it rests in the states there.
    pub(crate) fn at(&self, t: f64) -> PathState {
        let index = self
            .knots
            .partition_point(|knot| knot.t <= t)
            .saturating_sub(1);
        let Some(knot) = self.knots.get(index) else {
            return PathState::default();
        };
        if index + 1 == self.knots.len() || t < knot.t {
            return PathState {
                s: knot.s,
                v: knot.v,
                a: knot.a,
            };
        }
        knot.at(t)
    }

    /// The state at a time that never falls: what lies before it is forgotten.
    pub(crate) fn advance(&mut self, t: f64) -> PathState {
        while self.knots.get(1).is_some_and(|next| next.t <= t) {
            self.knots.pop_front();
        }
        match self.knots.front() {
            Some(knot) if self.knots.len() > 1 && t >= knot.t => knot.at(t),
            Some(knot) => PathState {
                s: knot.s,
                v: knot.v,
                a: knot.a,
            },
            None => PathState::default(),
        }
    }
}

/// The motion between two stops.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    /// When it starts, s since the start of the program.
    pub(crate) start_s: f64,
    /// Place and time on the path.
    pub(crate) profile: Profile,
    /// Where on the path it starts.
    pub(crate) from: f64,
    /// Pieces of the path with the place where each begins.
    pieces: VecDeque<(f64, Arc<Piece>)>,
    /// Time up to which the motion was final before the last part was added, s.
    settled_s: f64,
    /// Whether it comes to rest at its end and nothing more will be added.
    pub(crate) complete: bool,
    /// The corner at its start, if it sets out before the stretch before has come to rest.
    pub(crate) corner: Option<Coords>,
}

impl Stretch {
    pub(crate) fn new(from: f64) -> Stretch {
        Stretch {
            start_s: 0.0,
            profile: Profile::default(),
            from,
            pieces: VecDeque::new(),
            settled_s: 0.0,
            complete: false,
            corner: None,
        }
    }

    /// Adds pieces and the motion over them.
    pub(crate) fn extend(
        &mut self,
        pieces: impl Iterator<Item = (f64, Arc<Piece>)>,
        knots: &[Knot],
    ) {
        self.pieces.extend(pieces);
        self.settled_s = self.profile.end_s();
        self.profile.extend(knots);
    }

    /// When the motion ends as far as it is known, s since the start of the program.
    pub(crate) fn rest_s(&self) -> f64 {
        self.start_s + self.profile.end_s()
    }

    /// The longest time at its start, and at its end if it is complete, over which it may move
    /// together with its neighbour: less than half of it, and nothing of what may have been sampled
    /// before its end was known.
    pub(crate) fn longest_overlap_s(&self) -> f64 {
        let half = 0.5 * self.profile.end_s();
        if self.complete {
            half.min(self.profile.end_s() - self.settled_s)
        } else {
            half
        }
    }

    /// Up to when the motion is known for good, s since the start of the program.
    pub(crate) fn known_s(&self) -> f64 {
        if self.complete {
            self.rest_s() - self.longest_overlap_s()
        } else {
            self.rest_s()
        }
    }

    /// The motion at a time that never falls; what lies before it is forgotten.
    pub(crate) fn advance(&mut self, t: f64) -> PathState {
        let motion = self.profile.advance(t);
        while self.pieces.len() > 1
            && self
                .pieces
                .get(1)
                .is_some_and(|(start, _)| *start <= motion.s)
        {
            self.pieces.pop_front();
        }
        motion
    }

    /// The piece at the place where it has advanced to, and the place on it.
    pub(crate) fn here(&self, s: f64) -> Option<(&Piece, f64)> {
        self.pieces
            .front()
            .map(|(start, piece)| (piece.as_ref(), (s - start).max(0.0)))
    }

    /// The piece at a place and the place on it.
    pub(crate) fn peek(&self, s: f64) -> Option<(&Piece, f64)> {
        let index = self
            .pieces
            .partition_point(|(start, _)| *start <= s)
            .saturating_sub(1);
        self.pieces
            .get(index)
            .map(|(start, piece)| (piece.as_ref(), (s - start).max(0.0)))
    }

    /// The first piece of those that it holds.
    pub(crate) fn first(&self) -> Option<&Piece> {
        self.pieces.front().map(|(_, piece)| piece.as_ref())
    }

    /// The last piece.
    pub(crate) fn last(&self) -> Option<&Piece> {
        self.pieces.back().map(|(_, piece)| piece.as_ref())
    }

    /// How many pieces it holds.
    pub(crate) fn len(&self) -> usize {
        self.pieces.len()
    }
}
