//! A pulse at each reversal: extra velocity or torque for a short time that pushes the motor across
//! the gap.
//!
//! ```text
//! after each change of sign of w_ref (|w_ref| <= 1e-6 rad/s keeps it) and the set delay, for 0 <= t < T:
//! velocity  s a (1 - t/T), rad/s        torque  s m (1 - t/T), N m        s: commanded direction
//! a left out and no torque given: a T/2 = 2 b, the pulse's area is the total gap
//! by travel   x/X in place of t/T, behind the delay: x the way of the reference since the reversal
//! second      s a2, s m2 while X1 <= x < X2, beside the first
//! by travel and second only while |w_ref| > 1e-6 rad/s: an axis that stops on the way is not pushed
//! ```
//! A pulse that ends in time is right at one acceleration A of the reversal alone: friction and gap
//! are overcome on a way x, which is there after `(2 x/A)^(1/2)`. One that ends by travel follows the
//! acceleration by itself; its area does not, and its height has to be given. Fanuc's second stage
//! begins at a distance from the first one and ends at twice or three times that distance.
//! Nothing holds the motor there afterwards: the position loop does not know of the gap and pulls
//! it back. The pulse shortens the time in which the load stands still after a reversal; the offset
//! of half a gap stays. Against the velocity loop a torque pulse works only while it is shorter
//! than the loop's own time (about 1/(2 pi f_v)), and it lands the motor hard.
//!
//! Signals: reference position and velocity (rad, rad/s). Settings: speed a (rad/s at the motor),
//! torque m (N m), time T (ms) or
//! travel X (axis unit), delay (ms), second speed, torque and travel. It knows the gap where neither
//! speed nor torque is given.
//!
//! Fails: too strong, it makes a notch of the opposite sign; right at one feed and friction, it is
//! wrong at others; on a load without friction it pushes at the wrong time.
//!
//! Source: common practice, backlash acceleration of Fanuc (servo function), stick-slip or friction
//! injection pulse of Siemens and Heidenhain. By travel: Heidenhain, MANUALplus 620, technical manual
//! 01/2012 p. 909 (compStrength is a way, compWidth the pulse's length as travel of some um; its
//! parabola is not printed in full, so that the shape is the triangle here). Second stage: Fanuc,
//! B-65270EN/05 p. 188.

use crate::AxisConfig;
use crate::registry::{Registered, Settings};
use crate::traverse::{STANDING_RAD_S, direction};
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, between, not_negative, positive};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `reversal-pulse`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReversalPulseSettings {
    /// Speed at the start of the pulse, rad/s at the motor. If left out, the pulse's area is the
    /// machine's true gap, or there is no velocity pulse where a torque is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_rad_s: Option<f64>,
    /// Torque at the start of the pulse, N m; no torque if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_nm: Option<f64>,
    /// Time in which it falls to zero, ms.
    pub time_ms: f64,
    /// Travel of the reference from the reversal on over which it falls to zero, in place of the time
    /// (Heidenhain's compWidth): mm, deg or rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub travel_units: Option<f64>,
    /// From the reversal of the reference to the pulse, ms.
    pub delay_ms: f64,
    /// Travel of the reference from the reversal on at which a second pulse of constant height begins
    /// and ends (Fanuc's second stage ends at twice or three times its start): mm, deg or rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_travel_units: Option<[f64; 2]>,
    /// Speed of the second pulse, rad/s at the motor; none if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_speed_rad_s: Option<f64>,
    /// Torque of the second pulse, N m; none if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_torque_nm: Option<f64>,
}

impl Default for ReversalPulseSettings {
    fn default() -> ReversalPulseSettings {
        ReversalPulseSettings {
            speed_rad_s: None,
            torque_nm: None,
            time_ms: 20.0,
            travel_units: None,
            delay_ms: 0.0,
            second_travel_units: None,
            second_speed_rad_s: None,
            second_torque_nm: None,
        }
    }
}

impl Settings for ReversalPulseSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        not_negative("speed_rad_s", self.speed_rad_s.unwrap_or(0.0))?;
        not_negative("torque_nm", self.torque_nm.unwrap_or(0.0))?;
        between("time_ms", self.time_ms, 0.25, 1000.0)?;
        between("delay_ms", self.delay_ms, 0.0, 1000.0)?;
        if let Some(travel) = self.travel_units {
            positive("travel_units", travel)?;
            if self.speed_rad_s.is_none() && self.torque_nm.is_none() {
                return Err(AxisConfigError::Mismatch {
                    key: "travel_units".to_owned(),
                    reason: "the area of a pulse that ends by travel is another at every acceleration, so that the gap does not tell its height".to_owned(),
                    hint: "give speed_rad_s or torque_nm".to_owned(),
                });
            }
        }
        let second_speed = self.second_speed_rad_s.unwrap_or(0.0);
        not_negative("second_speed_rad_s", second_speed)?;
        let second_torque = self.second_torque_nm.unwrap_or(0.0);
        not_negative("second_torque_nm", second_torque)?;
        let mut from = 0.0;
        for travel in self.second_travel_units.into_iter().flatten() {
            between("second_travel_units", travel, from, f64::MAX)?;
            from = travel;
        }
        if (second_speed > 0.0 || second_torque > 0.0) && self.second_travel_units.is_none() {
            return Err(AxisConfigError::Mismatch {
                key: "second_travel_units".to_owned(),
                reason: "a second pulse is given, and not where it begins and ends".to_owned(),
                hint: "give both, such as [0.01, 0.02]".to_owned(),
            });
        }
        Ok(())
    }
}

/// The method `reversal-pulse`.
#[derive(Clone, Copy, Debug)]
pub struct ReversalPulse {
    /// Height of the velocity pulse, rad/s.
    speed: f64,
    /// Height of the torque pulse, N m.
    torque: f64,
    /// Length of the pulse, servo ticks.
    ticks: f64,
    /// Length of the pulse as travel of the reference, rad; none for one that ends in time.
    travel: Option<f64>,
    /// From the reversal to the pulse, servo ticks.
    delay: f64,
    /// Where the second pulse begins and ends, rad from the reversal; an empty range without one.
    second: [f64; 2],
    second_speed: f64,
    second_torque: f64,
}

/// Direction of the motion, ticks since it changed, and where it did so.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReversalPulseState {
    direction: i8,
    since: f64,
    /// Reference at the reversal, rad.
    turned_at: f64,
}

impl Registered for ReversalPulse {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "reversal-pulse",
        summary: "a short pulse of speed or torque at each reversal of the commanded velocity",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "common practice: Fanuc backlash acceleration, Siemens and Heidenhain friction pulse",
    };

    fn from_axis(config: &AxisConfig) -> ReversalPulse {
        let settings = &config.compensation.reversal_pulse;
        let per_ms = 1e-3 / config.servo_period_s();
        let per_unit = config.transmission.motor_rad_per_unit();
        // a triangle whose area is the total gap
        let of_gap = 2.0 * config.reflected_load().gap_rad / (settings.time_ms * 1e-3);
        ReversalPulse {
            speed: settings
                .speed_rad_s
                .unwrap_or(if settings.torque_nm.is_none() {
                    of_gap
                } else {
                    0.0
                }),
            torque: settings.torque_nm.unwrap_or(0.0),
            ticks: settings.time_ms * per_ms,
            travel: settings.travel_units.map(|travel| travel * per_unit),
            delay: settings.delay_ms * per_ms,
            second: settings
                .second_travel_units
                .map_or([0.0; 2], |told| told.map(|travel| travel * per_unit)),
            second_speed: settings.second_speed_rad_s.unwrap_or(0.0),
            second_torque: settings.second_torque_nm.unwrap_or(0.0),
        }
    }
}

impl Compensator for ReversalPulse {
    type State = ReversalPulseState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> ReversalPulseState {
        ReversalPulseState {
            direction: 0,
            // no pulse before the first reversal
            since: self.delay + self.ticks,
            turned_at: 0.0,
        }
    }

    #[inline]
    fn step(&self, state: &mut ReversalPulseState, signals: &Signals) -> Correction {
        let reference = signals.reference;
        let direction = direction(reference.velocity, state.direction);
        if direction != state.direction {
            *state = ReversalPulseState {
                direction,
                since: 0.0,
                turned_at: reference.position,
            };
        }
        let side = f64::from(state.direction);
        // no way for an axis that stands, whatever it has come
        let way = if reference.velocity.abs() > STANDING_RAD_S {
            side * (reference.position - state.turned_at)
        } else {
            f64::NAN
        };
        // part of the pulse that has passed: below 0 in the delay, 1 and more behind it
        let of_time = (state.since - self.delay) / self.ticks;
        let u = match self.travel {
            Some(travel) if of_time >= 0.0 => way / travel,
            Some(_) => -1.0,
            None => of_time,
        };
        state.since = (state.since + 1.0).min(self.delay + self.ticks);
        let mut correction = Correction::NONE;
        if (0.0..1.0).contains(&u) {
            // falling triangle in the commanded direction
            let shape = side * (1.0 - u);
            correction.velocity = self.speed * shape;
            correction.torque = self.torque * shape;
        }
        let [from, to] = self.second;
        if (from..to).contains(&way) {
            correction.velocity += side * self.second_speed;
            correction.torque += side * self.second_torque;
        }
        correction
    }
}
