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

use lostmotion_base::{AXES, AxisId, AxisLimits, Coords};
use lostmotion_plan::Sample;

/// Utilisation from which a constraint is active. Tuned: the smoothing of a profile leaves about 2 %
/// of a limit unused.
const ACTIVE_UTILISATION: f64 = 0.97;

/// Ways of being limited: feed, three for each joint, tolerance, look-ahead, dwell, feed hold,
/// chord.
pub(super) const LIMITERS: usize = 6 + 3 * AXES;

/// Number of a limiter.
pub(super) type Limiter = usize;

pub(super) const FEED: Limiter = 0;
pub(super) const TOLERANCE: Limiter = 1 + 3 * AXES;
pub(super) const LOOK_AHEAD: Limiter = 2 + 3 * AXES;
pub(super) const DWELL: Limiter = 3 + 3 * AXES;
/// The operator holds the motion.
pub(super) const HELD: Limiter = DWELL + 1;
/// The tool's bow between two commands.
pub(super) const CHORD: Limiter = HELD + 1;

/// Name for people and files.
pub(super) fn name(limiter: Limiter) -> String {
    let joint = |first: usize| AxisId::from_index(limiter - first).map_or(' ', AxisId::letter);
    match limiter {
        FEED => "feed".to_owned(),
        TOLERANCE => "tolerance".to_owned(),
        LOOK_AHEAD => "look-ahead".to_owned(),
        DWELL => "dwell".to_owned(),
        HELD => "feed hold".to_owned(),
        CHORD => "chord".to_owned(),
        _ if limiter <= AXES => format!("velocity {}", joint(1)),
        _ if limiter <= 2 * AXES => format!("acceleration {}", joint(1 + AXES)),
        _ => format!("jerk {}", joint(1 + 2 * AXES)),
    }
}

/// Limits of the joints as reciprocals; 0 for joints that there are not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joints {
    per: [[f64; 3]; AXES],
    period_s: f64,
}

impl Joints {
    pub(super) fn new(limits: &[Option<AxisLimits>; AXES], period_s: f64) -> Joints {
        let per = limits.map(|limits| {
            limits.map_or([0.0; 3], |l| {
                [1.0 / l.velocity, 1.0 / l.acceleration, 1.0 / l.jerk]
            })
        });
        Joints { per, period_s }
    }

    /// The joint constraint of the largest utilisation between two samples, and that utilisation.
    fn most(&self, a: &Sample, b: &Sample) -> (Limiter, f64) {
        let mut most = (LOOK_AHEAD, 0.0);
        for (joint, per) in self.per.iter().enumerate() {
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
            for (kind, usage) in uses.into_iter().enumerate() {
                // The first of equals stays: joint by joint, velocity before acceleration before
                // jerk.
                if usage.abs() > most.1 {
                    most = (1 + kind * AXES + joint, usage.abs());
                }
            }
        }
        most
    }

    /// What limits an interval on which something moves. `feed`: path speed allowed by the program;
    /// `chord`: what is used of the limit of the tool's bow; `off`: whether the command is off the
    /// path.
    pub(super) fn limiter(
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
            FEED
        } else if chord >= ACTIVE_UTILISATION && chord >= usage {
            CHORD
        } else if usage >= ACTIVE_UTILISATION {
            joint
        } else if off() {
            TOLERANCE
        } else {
            LOOK_AHEAD
        }
    }
}

/// Whether a sample stands still.
pub(super) fn stands(sample: &Sample) -> bool {
    let still = |coords: &Coords| coords.0.iter().all(|c| c.abs() <= 1e-9);
    still(&sample.velocity) && still(&sample.acceleration)
}
