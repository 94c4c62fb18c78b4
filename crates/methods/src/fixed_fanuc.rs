//! Half the gap towards the commanded direction, with one amount for cutting and another one for
//! rapid traverse, as Fanuc controls have it.
//!
//! ```text
//! s       sign of w_ref; |w_ref| <= 1e-6 rad/s keeps the last one
//! rapid   whether the block is G00, where the control sends it along; else it becomes true where |w_ref|
//!         exceeds a threshold, rad/s, and false again at the next reversal or standstill
//! target  s A/2 while cutting, s B/2 in rapid, rad; along 3 u^2 - 2 u^3 over the ramp time
//! ```
//! A and B are total gaps. A reversal while cutting moves the motor by A, one from cutting to rapid
//! by (A + B)/2, and a change between cutting and rapid in one direction by (B - A)/2: the table of
//! the control's manual.
//!
//! Signals: reference velocity, rad/s; the kind of the block. Settings: both amounts (um, mdeg or
//! motor rad; B is A if left out), the speed above which a motion counts as rapid where no control
//! tells it (axis unit per s), ramp time (ms). Part programs tell it; an axis that runs alone does
//! not. There a rapid stroke counts as cutting until it is fast enough, and cutting faster than the
//! threshold counts as rapid: set it between the fastest cutting feed and the rapid speed.
//!
//! Fails: as `fixed`. Two amounts help where wind-up or overshoot differ between slow and fast
//! reversals. They do not help where the load coasts.
//!
//! Source: Fanuc series 16i/18i/21i/30i, parameters 1851 (cutting), 1852 (rapid) and RBK of 1800.

use crate::AxisConfig;
use crate::registry::{Registered, Settings, told, told_or_true_gap};
use crate::traverse::{Ramp, RampTime, STANDING_RAD_S, direction};
use lostmotion_drive::config::check::{AxisConfigError, between, positive};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `fixed-fanuc`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedFanucSettings {
    /// Total gap for cutting (parameter 1851); the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutting: Option<Gap>,
    /// Total gap for rapid traverse (parameter 1852); that for cutting if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rapid: Option<Gap>,
    /// Speed of the axis from which on a motion counts as rapid where no block tells it: mm, deg or
    /// rad per s.
    pub rapid_above_units_s: f64,
    /// Time over which the correction goes from one amount to another, ms.
    pub ramp_ms: f64,
}

impl Default for FixedFanucSettings {
    fn default() -> FixedFanucSettings {
        FixedFanucSettings {
            cutting: None,
            rapid: None,
            rapid_above_units_s: 200.0,
            ramp_ms: 8.0,
        }
    }
}

impl Settings for FixedFanucSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("cutting", self.cutting, transmission)?;
        told("rapid", self.rapid, transmission)?;
        positive("rapid_above_units_s", self.rapid_above_units_s)?;
        between("ramp_ms", self.ramp_ms, 0.0, 10_000.0)
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.cutting, &mut self.rapid]
    }
}

/// The method `fixed-fanuc`.
#[derive(Clone, Copy, Debug)]
pub struct FixedFanuc {
    /// Half of the amounts for cutting and rapid, rad.
    half: [f64; 2],
    /// Speed from which a motion counts as rapid, rad/s at the motor.
    rapid_above: f64,
    time: RampTime,
    period_s: f64,
}

/// Direction and kind of the motion, and where the correction is on its way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedFanucState {
    direction: i8,
    rapid: bool,
    ramp: Ramp,
}

impl Registered for FixedFanuc {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "fixed-fanuc",
        summary: "known half gap added at each reversal, with separate amounts for cutting and rapid traverse",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "Fanuc, parameters 1851 and 1852",
    };

    fn from_axis(config: &AxisConfig) -> FixedFanuc {
        let settings = &config.compensation.fixed_fanuc;
        // the second parameter is optional on the control, too
        let cutting = told_or_true_gap(settings.cutting, config);
        let rapid = settings
            .rapid
            .map_or(cutting, |told| told.motor_rad(&config.transmission));
        FixedFanuc {
            half: [0.5 * cutting, 0.5 * rapid],
            rapid_above: settings.rapid_above_units_s * config.transmission.motor_rad_per_unit(),
            time: RampTime::from_ms(settings.ramp_ms, config.servo_period_s()),
            period_s: config.servo_period_s(),
        }
    }
}

impl FixedFanuc {
    /// Offset that the ramp leads to, rad.
    fn target(&self, state: &FixedFanucState) -> f64 {
        f64::from(state.direction) * self.half[usize::from(state.rapid)]
    }
}

impl Compensator for FixedFanuc {
    type State = FixedFanucState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> FixedFanucState {
        FixedFanucState {
            direction: 0,
            rapid: false,
            ramp: Ramp::DONE,
        }
    }

    #[inline]
    fn step(&self, state: &mut FixedFanucState, signals: &Signals) -> Correction {
        let before = state.ramp.towards(self.target(state));
        let speed = signals.reference.velocity.abs();
        let direction = direction(signals.reference.velocity, state.direction);
        // hysteresis: a rapid stroke stays one while it slows down, until it reverses or stands
        let ends = direction != state.direction || speed <= STANDING_RAD_S;
        let by_speed = || speed > self.rapid_above || (state.rapid && !ends);
        let rapid = match signals.block {
            // At rest the amount in force stays until the axis moves again.
            Some(_) if speed <= STANDING_RAD_S => state.rapid,
            Some(block) => block.rapid,
            None => by_speed(),
        };
        // a new target: the ramp starts from the present offset
        if (direction, rapid) != (state.direction, state.rapid) {
            (state.direction, state.rapid) = (direction, rapid);
            state.ramp.start(before);
        }
        state.ramp.advance(self.time);
        let position = state.ramp.towards(self.target(state));
        Correction {
            position,
            velocity: (position - before) / self.period_s,
            gap_angle_estimate: self.target(state),
            engagement_estimate: Engagement::of_sign(direction),
            ..Correction::NONE
        }
    }
}
