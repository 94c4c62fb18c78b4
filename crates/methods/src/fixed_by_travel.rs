//! Half the gap towards the commanded direction, in steps that are added to the moves behind the
//! reversal: in proportion to the way, whatever the time.
//!
//! ```text
//! s         sign of w_ref; |w_ref| <= 1e-6 rad/s keeps the last one;   r = s b c - correction: what is left
//! each servo period T_s, only towards the commanded direction:
//! correction += sign(r) min(|r|, |w_ref| T_s/m, |r| v_path T_s/S), rad
//! velocity   its derivative, rad/s
//! m  multiple: the gap is taken up over at least m times its own length of the axis' way
//! S  smoothing, mm of the path of all axes: the part exp(-path/S) of the gap is left; none if 0
//! c  part of the gap that is corrected
//! ```
//! Marlin adds no more steps than the axis makes anyway (m = 1), and with smoothing a part of what
//! is left for each part of the path. RepRapFirmware takes m of 10 and no smoothing. Near a
//! reversal on an arc the axis hardly moves: `x = p^2/(2 R)` at the path p, so m times the gap takes
//! a path of `sqrt(2 R m 2 b)`.
//!
//! Signals: reference velocity, rad/s; speed along the path, mm/s, where the control tells it, else
//! that of the axis. Settings: told total gap (um, mdeg or motor rad), c, m, S.
//!
//! Fails: as `fixed`. Large m or S smear the error along the contour instead of removing it; m near
//! 1 doubles the speed of the axis at once, without limits of acceleration: printers shake and lose
//! steps (Marlin issue 13033).
//!
//! Source: Marlin, M425 F S and BACKLASH_SMOOTHING_MM (`feature/backlash`, pull request 11061);
//! RepRapFirmware 3.5, M425 S. Blocks are taken as short.

use crate::AxisConfig;
use crate::registry::{Registered, Settings, told, told_or_true_gap};
use crate::traverse::direction;
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `fixed-by-travel`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedByTravelSettings {
    /// Total gap that the control was told (M425 X, Y, Z); the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Part of the gap that is corrected, 0 to 1 (Marlin: M425 F).
    pub correction: f64,
    /// Way of the axis over which the gap is taken up, in gaps; 1 and above (RepRapFirmware: M425 S;
    /// 1 for Marlin).
    pub multiple: f64,
    /// Path over which Marlin takes up the part 1 - 1/e of what is left, mm (M425 S); none if 0.
    pub smoothing_mm: f64,
}

impl Default for FixedByTravelSettings {
    fn default() -> FixedByTravelSettings {
        FixedByTravelSettings {
            gap: None,
            correction: 1.0,
            multiple: 10.0,
            smoothing_mm: 0.0,
        }
    }
}

impl Settings for FixedByTravelSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        between("correction", self.correction, 0.0, 1.0)?;
        between("multiple", self.multiple, 1.0, 1e6)?;
        between("smoothing_mm", self.smoothing_mm, 0.0, 1e6)
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.gap]
    }
}

/// The method `fixed-by-travel`.
#[derive(Clone, Copy, Debug)]
pub struct FixedByTravel {
    /// Half of the told gap, as far as it is corrected, rad at the motor.
    half_gap: f64,
    per_way: f64,
    /// 1/mm; infinite without smoothing.
    per_path_mm: f64,
    units_per_rad: f64,
    period_s: f64,
}

/// Commanded direction and present correction, rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedByTravelState {
    direction: i8,
    position: f64,
}

impl Registered for FixedByTravel {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "fixed-by-travel",
        summary: "known half gap added in proportion to the way behind each reversal",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "Marlin and RepRapFirmware, M425",
    };

    fn from_axis(config: &AxisConfig) -> FixedByTravel {
        let settings = &config.compensation.fixed_by_travel;
        FixedByTravel {
            half_gap: 0.5 * settings.correction * told_or_true_gap(settings.gap, config),
            per_way: 1.0 / settings.multiple,
            per_path_mm: 1.0 / settings.smoothing_mm,
            units_per_rad: 1.0 / config.transmission.motor_rad_per_unit(),
            period_s: config.servo_period_s(),
        }
    }
}

impl Compensator for FixedByTravel {
    type State = FixedByTravelState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> FixedByTravelState {
        FixedByTravelState {
            direction: 0,
            position: 0.0,
        }
    }

    #[inline]
    fn step(&self, state: &mut FixedByTravelState, signals: &Signals) -> Correction {
        let speed = signals.reference.velocity;
        state.direction = direction(speed, state.direction);
        let target = f64::from(state.direction) * self.half_gap;
        let left = target - state.position;
        let path_speed = signals.block.map_or(
            // An axis alone: its own way.
            (speed * self.units_per_rad).abs(),
            |block| block.path_speed_mm_s,
        );
        let mut way = (speed.abs() * self.period_s * self.per_way).min(left.abs());
        if self.per_path_mm.is_finite() {
            way = way.min(left.abs() * path_speed * self.period_s * self.per_path_mm);
        }
        let before = state.position;
        if way >= left.abs() {
            state.position = target;
        } else {
            state.position += way * left.signum();
        }
        Correction {
            position: state.position,
            velocity: (state.position - before) / self.period_s,
            gap_angle_estimate: target,
            engagement_estimate: Engagement::of_sign(state.direction),
            ..Correction::NONE
        }
    }
}
