//! What keeps the motion from going faster, sample by sample, from the samples alone.
//!
//! Over the interval between two samples each constraint has a utilisation, the part of its limit
//! that is used:
//! ```text
//! feed          mean path speed / programmed feed                 (not on rapids)
//! velocity      |q'(n) + q'(n+1)|/2 / limit                       for each joint
//! acceleration  |q''(n) + q''(n+1)|/2 / limit
//! jerk          |q''(n+1) - q''(n)|/T / limit
//! chord         sqrt(bow between the two / its limit)             (where one is kept; it grows with the square of the speed)
//! ```
//! The largest is the active one if it is at least 0.97. Where none is, the interval counts as
//! `tolerance` if the command is off the programmed path (it rounds a corner; a larger tolerance
//! would let it be faster), as `look-ahead` otherwise. Nothing of how the planner came to its
//! samples is used.

mod along;

pub(crate) use along::{Along, Interval};

use lostmotion_base::{AXES, AxisId, AxisLimits, Coords};
use lostmotion_plan::Sample;
use std::fmt;

/// Utilisation from which a constraint is active. Tuned: the smoothing of a profile leaves about 2 %
/// of a limit unused.
const ACTIVE_UTILISATION: f64 = 0.97;

/// What keeps a motion from going faster.
///
/// ```
/// use lostmotion_base::AxisId;
/// use lostmotion_sim::Limiter;
///
/// assert_eq!(Limiter::Jerk(AxisId::X).to_string(), "jerk X");
/// assert_eq!(Limiter::ALL.len(), Limiter::COUNT);
/// assert!(Limiter::ALL.iter().enumerate().all(|(n, limiter)| limiter.index() == n));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Limiter {
    /// The programmed feed.
    Feed,
    /// The speed of a joint.
    Velocity(AxisId),
    /// The acceleration of a joint.
    Acceleration(AxisId),
    /// The jerk of a joint.
    Jerk(AxisId),
    /// A corner is rounded with no joint at a limit: a larger tolerance would let it be faster.
    Tolerance,
    /// Nothing is at its limit: the motion gets ready for what comes or leaves what has been.
    LookAhead,
    /// The program stands.
    Dwell,
    /// The operator holds the motion.
    FeedHold,
    /// The tool's bow between two commands.
    Chord,
}

impl Limiter {
    /// How many there are.
    pub const COUNT: usize = 6 + 3 * AXES;

    /// Every one, each at its [`Limiter::index`].
    pub const ALL: [Limiter; Limiter::COUNT] = {
        let mut all = [Limiter::Feed; Limiter::COUNT];
        let mut axis = 0;
        while axis < AXES {
            let id = AxisId::ALL[axis];
            all[1 + axis] = Limiter::Velocity(id);
            all[1 + AXES + axis] = Limiter::Acceleration(id);
            all[1 + 2 * AXES + axis] = Limiter::Jerk(id);
            axis += 1;
        }
        all[1 + 3 * AXES] = Limiter::Tolerance;
        all[2 + 3 * AXES] = Limiter::LookAhead;
        all[3 + 3 * AXES] = Limiter::Dwell;
        all[4 + 3 * AXES] = Limiter::FeedHold;
        all[5 + 3 * AXES] = Limiter::Chord;
        all
    };

    /// Its place in tables.
    pub const fn index(self) -> usize {
        match self {
            Limiter::Feed => 0,
            Limiter::Velocity(axis) => 1 + axis.index(),
            Limiter::Acceleration(axis) => 1 + AXES + axis.index(),
            Limiter::Jerk(axis) => 1 + 2 * AXES + axis.index(),
            Limiter::Tolerance => 1 + 3 * AXES,
            Limiter::LookAhead => 2 + 3 * AXES,
            Limiter::Dwell => 3 + 3 * AXES,
            Limiter::FeedHold => 4 + 3 * AXES,
            Limiter::Chord => 5 + 3 * AXES,
        }
    }
}

/// The name for people and files: `feed`, `jerk X`, `look-ahead`.
impl fmt::Display for Limiter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Limiter::Feed => f.write_str("feed"),
            Limiter::Velocity(axis) => write!(f, "velocity {}", axis.letter()),
            Limiter::Acceleration(axis) => write!(f, "acceleration {}", axis.letter()),
            Limiter::Jerk(axis) => write!(f, "jerk {}", axis.letter()),
            Limiter::Tolerance => f.write_str("tolerance"),
            Limiter::LookAhead => f.write_str("look-ahead"),
            Limiter::Dwell => f.write_str("dwell"),
            Limiter::FeedHold => f.write_str("feed hold"),
            Limiter::Chord => f.write_str("chord"),
        }
    }
}

/// Limits of the joints as reciprocals; 0 for joints that there are not.
#[derive(Clone, Copy, Debug)]
struct Joints {
    per: [[f64; 3]; AXES],
    period_s: f64,
}

impl Joints {
    fn new(limits: &[Option<AxisLimits>; AXES], period_s: f64) -> Joints {
        let per = limits.map(|limits| {
            limits.map_or([0.0; 3], |l| {
                [1.0 / l.velocity, 1.0 / l.acceleration, 1.0 / l.jerk]
            })
        });
        Joints { per, period_s }
    }

    /// The joint constraint of the largest utilisation between two samples, and that utilisation.
    fn most(&self, a: &Sample, b: &Sample) -> (Limiter, f64) {
        const OF_A_JOINT: [fn(AxisId) -> Limiter; 3] =
            [Limiter::Velocity, Limiter::Acceleration, Limiter::Jerk];
        let mut most = (Limiter::LookAhead, 0.0);
        for (id, per) in AxisId::ALL.into_iter().zip(&self.per) {
            let joint = id.index();
            let (v, [a0, a1]) = (
                0.5 * (a.velocity.0[joint] + b.velocity.0[joint]),
                [a, b].map(|s| s.acceleration.0[joint]),
            );
            // Means over the interval for velocity and acceleration, the difference quotient for
            // jerk: what the drive sees between two commands.
            let uses = [
                v * per[0],
                0.5 * (a0 + a1) * per[1],
                (a1 - a0) / self.period_s * per[2],
            ];
            for (of, usage) in OF_A_JOINT.into_iter().zip(uses) {
                // The first of equals stays: joint by joint, velocity before acceleration before
                // jerk.
                if usage.abs() > most.1 {
                    most = (of(id), usage.abs());
                }
            }
        }
        most
    }

    /// What limits an interval on which something moves. `feed`: path speed allowed by the program;
    /// `chord`: what is used of the limit of the tool's bow; `off`: whether the command is off the
    /// path.
    fn limiter(
        &self,
        [a, b]: [&Sample; 2],
        feed: Option<f64>,
        chord: f64,
        off: impl FnOnce() -> bool,
    ) -> Limiter {
        // The largest utilisation is the active constraint; feed goes before joints among equals.
        let used = feed.map_or(0.0, |feed| 0.5 * (a.path_speed + b.path_speed) / feed);
        let (joint, usage) = self.most(a, b);
        if used >= ACTIVE_UTILISATION && used >= usage.max(chord) {
            Limiter::Feed
        } else if chord >= ACTIVE_UTILISATION && chord >= usage {
            Limiter::Chord
        } else if usage >= ACTIVE_UTILISATION {
            joint
        } else if off() {
            Limiter::Tolerance
        } else {
            Limiter::LookAhead
        }
    }
}

/// Whether a sample stands still.
fn stands(sample: &Sample) -> bool {
    let still = |coords: &Coords| coords.0.iter().all(|c| c.abs() <= 1e-9);
    still(&sample.velocity) && still(&sample.acceleration)
}
