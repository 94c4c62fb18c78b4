//! How setpoints become references between them.

use serde::{Deserialize, Serialize};
use std::fmt;

/// How a drive goes from setpoint to setpoint.
///
/// T is the command's cycle. The delay is the time from a setpoint's arrival to the reference
/// reaching it. Errors as measured by the tests, at T = 1 ms and a servo cycle of 250 us, the worst
/// of a jerk-limited line (100 mm/s, 1 m/s2, 30 m/s3) and a circle of 5 mm at the same
/// acceleration: see `docs/book/src/model/interpolation.md`.
///
/// | name | delay | needs | position error | nm | jerk over the motion's |
/// |---|---|---|---|---|---|
/// | `linear` | T | positions | a T^2/8 | 125 | > 500 |
/// | `cubic-differences` | T | positions | a T^2/21 | 47 | > 180 |
/// | `catmull-rom` | 2 T | positions | third order | 0.7 | 3 |
/// | `cubic-hermite` | T | velocity | fourth order | 0.2 | 1.2 |
/// | `quintic-hermite` | T | velocity, acceleration | sixth order | 0.04 | 1.03 |
/// | `b-spline` | 2 T | positions | a T^2/6 | 167 | 1 |
/// | `compensated-b-spline` | 2 T | acceleration | fourth order | 0.7 | 1.1 |
/// | `quintic-differences` | 3 T | positions | fifth order | 0.4 | 1.4 |
///
/// Equal delay on all axes makes no contour error; unequal delays do, `v dt/2` on a line at 45
/// degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolator {
    /// Straight from position to position: the speed steps at every setpoint.
    Linear,
    /// Cubic Hermite with the speed at a setpoint taken for that since the one before.
    CubicDifferences,
    /// Cubic Hermite with the speed at a setpoint taken from both its neighbours.
    CatmullRom,
    /// Cubic Hermite with the velocity sent along.
    CubicHermite,
    /// Quintic Hermite with velocity and acceleration sent along.
    #[default]
    #[serde(alias = "sent-along")]
    QuinticHermite,
    /// Uniform cubic B-spline with the positions for control points: smooth, but it cuts every
    /// curve.
    BSpline,
    /// The same with `p - a T^2/6` for control points, which takes the cut away.
    CompensatedBSpline,
    /// Quintic Hermite with velocity and acceleration from five-point differences.
    #[serde(alias = "differences")]
    QuinticDifferences,
}

impl Interpolator {
    /// All of them.
    pub const ALL: [Interpolator; 8] = [
        Interpolator::Linear,
        Interpolator::CubicDifferences,
        Interpolator::CatmullRom,
        Interpolator::CubicHermite,
        Interpolator::QuinticHermite,
        Interpolator::BSpline,
        Interpolator::CompensatedBSpline,
        Interpolator::QuinticDifferences,
    ];

    /// The name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Interpolator::Linear => "linear",
            Interpolator::CubicDifferences => "cubic-differences",
            Interpolator::CatmullRom => "catmull-rom",
            Interpolator::CubicHermite => "cubic-hermite",
            Interpolator::QuinticHermite => "quintic-hermite",
            Interpolator::BSpline => "b-spline",
            Interpolator::CompensatedBSpline => "compensated-b-spline",
            Interpolator::QuinticDifferences => "quintic-differences",
        }
    }

    /// The interpolator of a name.
    pub fn from_name(name: &str) -> Option<Interpolator> {
        Interpolator::ALL
            .into_iter()
            .find(|interpolator| interpolator.name() == name)
    }

    /// Command cycles from a setpoint's arrival to the reference reaching it.
    pub const fn delay_cycles(self) -> u32 {
        match self {
            Interpolator::Linear
            | Interpolator::CubicDifferences
            | Interpolator::CubicHermite
            | Interpolator::QuinticHermite => 1,
            Interpolator::CatmullRom | Interpolator::BSpline | Interpolator::CompensatedBSpline => {
                2
            }
            Interpolator::QuinticDifferences => 3,
        }
    }

    /// Whether the control has to send the velocity along.
    pub const fn needs_velocity(self) -> bool {
        matches!(
            self,
            Interpolator::CubicHermite | Interpolator::QuinticHermite
        )
    }

    /// Whether the control has to send the acceleration along.
    pub const fn needs_acceleration(self) -> bool {
        matches!(
            self,
            Interpolator::QuinticHermite | Interpolator::CompensatedBSpline
        )
    }
}

impl fmt::Display for Interpolator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
