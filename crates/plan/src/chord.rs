//! How far the tool may be off its way between two commands that drives join by straight lines of
//! the joints.
//!
//! With joints q(s) on a path travelled with speed v, the middle of their chord over a command
//! cycle T is T2/8 q'' v2 off them, square to the way. What the tool makes of that has a limit, so
//! that v has one.

use crate::piece::Piece;
use lostmotion_base::{AXES, Coords, Jet};
use lostmotion_kinematics::{Kinematics, KinematicsError, chord_bend};
use std::sync::Arc;

/// Part of the limit that is planned for; the rest is for terms of higher order in the cycle. A
/// choice, record 31 of the decisions: less is slower, more lets those terms pass the limit.
const BOW_PART: f64 = 0.99;

/// A limit of the tool's distance from its way in the middle between two commands.
#[derive(Clone, Debug)]
pub struct Chord {
    /// Where the joints take the tool in the part's frame, with tool-centre-point control or
    /// without.
    kinematics: Arc<dyn Kinematics>,
    /// The largest bend by time, mm/s2.
    most: f64,
}

impl Chord {
    /// For drives that go straight over a command cycle of `period_s` on a machine with these
    /// kinematics, whose tool may be off its way by `bow_mm`.
    pub fn new(kinematics: Arc<dyn Kinematics>, bow_mm: f64, period_s: f64) -> Chord {
        // The sagitta T^2/8 of a bend by time, solved for the bend.
        Chord {
            kinematics,
            most: BOW_PART * 8.0 * bow_mm / (period_s * period_s),
        }
    }

    /// The largest speed of the path parameter over part of a piece, from the joints at its ends
    /// and in its middle.
    pub(crate) fn speed(&self, jets: [&[Jet; AXES]; 3], tool_mm: &[f64; 3]) -> f64 {
        let [a, m, b] = jets.map(|jets| {
            self.bend(
                [0, 1, 2].map(|order| Coords(jets.map(|jet| jet.0[order]))),
                tool_mm,
            )
        });
        // The middle's distance from the mean of the ends stands for what the bend may rise above
        // all three.
        self.speed_at(a.max(m).max(b) + (m - 0.5 * (a + b)).abs())
    }

    /// The same under kinematics that have to be asked first.
    pub(crate) fn speed_over(
        &self,
        piece: &Piece,
        kinematics: &dyn Kinematics,
        [s0, s1]: [f64; 2],
    ) -> Result<f64, KinematicsError> {
        let at = |s: f64| kinematics.inverse_jet(&piece.curve.jet(s), &piece.tool_mm);
        let [a, m, b] = [at(s0)?, at(0.5 * (s0 + s1))?, at(s1)?];
        Ok(self.speed([&a, &m, &b], &piece.tool_mm))
    }

    /// The largest speed of the path parameter at a place.
    pub(crate) fn speed_here(&self, jets: &[Jet; AXES], tool_mm: &[f64; 3]) -> f64 {
        self.speed_at(self.bend(
            [0, 1, 2].map(|order| Coords(jets.map(|jet| jet.0[order]))),
            tool_mm,
        ))
    }

    /// Speed as a part of the allowed one, given joints with their velocities and accelerations.
    pub(crate) fn part(&self, motion: [&Coords; 3], tool_mm: &[f64; 3]) -> f64 {
        (chord_bend(self.kinematics.as_ref(), motion, tool_mm) / self.most).sqrt()
    }

    /// The limit for a nominal motion that will be passed at the given pace.
    pub(crate) fn at_pace(&self, pace: f64) -> Chord {
        Chord {
            most: self.most / (pace * pace),
            ..self.clone()
        }
    }

    fn bend(&self, [joints, first, second]: [Coords; 3], tool_mm: &[f64; 3]) -> f64 {
        chord_bend(
            self.kinematics.as_ref(),
            [&joints, &first, &second],
            tool_mm,
        )
    }

    fn speed_at(&self, bend: f64) -> f64 {
        if bend > 0.0 {
            (self.most / bend).sqrt()
        } else {
            f64::INFINITY
        }
    }
}
