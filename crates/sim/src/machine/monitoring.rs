//! The limits that the control of a machine watches, as they are in force: those of the file, and
//! for those that it leaves out what follows from the axis.
//!
//! With the largest speed `v` and acceleration `a` of the axis, its position gain `Kv` and the part
//! `f` of the velocity that is fed forward:
//! ```text
//! standstill   max(a/Kv^2, v 1 ms) + gap + 3 (1 - f) a/Kv^2
//! full speed   standstill + 3 (1 - f) v/Kv
//! overtravel   standstill
//! ```
//! A position loop answers an error `e` with the acceleration `Kv^2 e`: beyond `a/Kv^2` the axis
//! cannot catch up within its limits. `(1 - f) v/Kv` is the error that the loop needs at constant
//! speed, `(1 - f) a/Kv^2` what it is behind that while it accelerates. A compensator may hold the
//! motor off its command by the gap.

use super::MachineAxis;
use lostmotion_base::math;
use lostmotion_methods::AxisConfig;

/// Factor of what a loop without feed-forward leaves by itself. A choice: the loops inside it lag,
/// too.
const LAG_FACTOR: f64 = 3.0;
/// Least error at standstill by default as a time at the largest speed, s. A choice: what friction,
/// cutting and steps of the encoder do to a stiff loop is far below the way in a command cycle.
const LEAST_WAY_S: f64 = 1e-3;

/// The limits of one motor, in the unit of its axis; `None` for what is not watched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MonitorLimits {
    /// Of the following error.
    pub following: Option<FollowingLimit>,
    /// Where the motor may be.
    pub travel: Option<[f64; 2]>,
    /// Of the current.
    pub overload: Option<OverloadLimit>,
    /// Of the time that the drive is at its current or voltage limit without a break, s.
    pub at_limit_s: Option<f64>,
}

/// How far the motor may be behind its command, or ahead of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowingLimit {
    /// At rest.
    pub standstill: f64,
    /// At the largest speed.
    pub full_speed: f64,
    /// The largest speed, per s.
    pub speed: f64,
}

impl FollowingLimit {
    /// At a commanded speed.
    pub fn at(&self, speed: f64) -> f64 {
        (self.full_speed * speed.abs() / self.speed).max(self.standstill)
    }
}

/// How warm the motor may get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverloadLimit {
    /// Current that it bears without end, A.
    pub continuous_a: f64,
    /// Time constant of its warming up, s.
    pub time_s: f64,
}

impl OverloadLimit {
    /// How long a constant current is borne from cold, s; `None` for one that is borne without end.
    pub fn borne_s(&self, current_a: f64) -> Option<f64> {
        let ratio = self.continuous_a / current_a.abs();
        // heat = (i/i_c)^2 (1 - exp(-t/T)) reaches 1
        (ratio < 1.0).then(|| -self.time_s * math::log1p(-ratio * ratio))
    }
}

impl MachineAxis {
    /// The limits that are watched on this axis; on a gantry those of its first motor.
    ///
    /// ```
    /// use lostmotion_base::AxisId;
    /// use lostmotion_sim::Machine;
    ///
    /// let machine = Machine::preset("vmc3")?
    ///     .edit(|m| m.axis("x").monitoring.following_error_units = Some(0.8))?;
    /// let x = machine.axis(AxisId::X).ok_or("no X")?.monitor_limits();
    /// assert_eq!(x.following.map(|limit| limit.at(0.0)), Some(0.8));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn monitor_limits(&self) -> MonitorLimits {
        self.monitor_limits_of(&self.config)
    }

    /// Those of a motor of this axis with a description of its own.
    pub(crate) fn monitor_limits_of(&self, config: &AxisConfig) -> MonitorLimits {
        // Joint units of the limits to the axis' own.
        let units = self.axis_units_per_joint_unit();
        let speed = self.limits.velocity * units;
        let told = config.monitoring;
        let usual = usual_following(config, speed, self.limits.acceleration * units);
        let full_speed = told.following_error_units.or(usual.map(|[_, full]| full));
        // A limit at full speed alone is one at every speed, as where LinuxCNC has no MIN_FERROR.
        let standstill = told
            .standstill_error_units
            .or(told.following_error_units)
            .or(usual.map(|[standstill, _]| standstill));
        let following = full_speed
            .zip(standstill)
            .filter(|(full, _)| *full > 0.0)
            .map(|(full_speed, standstill)| FollowingLimit {
                standstill,
                full_speed: full_speed.max(standstill),
                speed,
            });
        let overtravel = told
            .overtravel_units
            .or(usual.map(|[standstill, _]| standstill));
        let travel = overtravel.filter(|over| *over > 0.0).map(|over| {
            [
                self.limits.min * units - over,
                self.limits.max * units + over,
            ]
        });
        let continuous_a = told
            .continuous_current_a
            .unwrap_or(config.motor.rated_torque_nm / config.motor.torque_constant_nm_per_a);
        MonitorLimits {
            following,
            travel,
            overload: (continuous_a > 0.0).then_some(OverloadLimit {
                continuous_a,
                time_s: told.overload_time_s,
            }),
            at_limit_s: (told.at_limit_s > 0.0).then_some(told.at_limit_s),
        }
    }
}

/// The following error by default, at rest and at the largest speed; `None` without a position
/// loop.
fn usual_following(config: &AxisConfig, speed: f64, acceleration: f64) -> Option<[f64; 2]> {
    let gain = config.drive.position_gain_per_s;
    if gain <= 0.0 {
        return None;
    }
    let left = LAG_FACTOR * (1.0 - config.drive.velocity_feedforward);
    let catches_up = acceleration / (gain * gain);
    let standstill = catches_up.max(speed * LEAST_WAY_S) + config.gap_in_unit() + left * catches_up;
    Some([standstill, standstill + left * speed / gain])
}
