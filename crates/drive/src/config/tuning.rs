//! A stated rule for a drive's gains, so that every machine of a catalogue is tuned the same way.

use super::drive::Drive;
use super::filter::TorqueFilters;
use super::load::Reflected;
use super::loops::{AntiWindup, LeastMargins};
use super::motor::Motor;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What the gains of a drive follow from.
///
/// Rule:
/// - current PI by pole-zero cancellation: integral time `L/R`, gain `2 pi f_c L`, so the closed
///   loop is a first-order lag of bandwidth `f_c`;
/// - velocity PI for the rigid axis, inertia `J` of rotor, screw and load: natural frequency
///   `w_n = 2 pi f_v` and damping `D`, so the gain is `(2 D w_n J - b)/K_t` and the integral time
///   `(2 D w_n J - b)/(w_n^2 J)`;
/// - position gain `Kv = position_ratio * w_n`.
///
/// `f_v` has to stay well below the first resonance and below what the loop's delays allow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tuning {
    /// Bandwidth f_c of the current loop, Hz.
    pub current_bandwidth_hz: f64,
    /// Natural frequency f_v of the velocity loop, Hz.
    pub velocity_frequency_hz: f64,
    /// Damping D of the velocity loop.
    pub velocity_damping: f64,
    /// Position gain over the velocity loop's natural frequency (rad/s).
    pub position_ratio: f64,
    /// Part of the velocity that is fed forward, 0 to 1.
    pub velocity_feedforward: f64,
    /// Part of the acceleration that is fed forward, 0 to 1.
    pub acceleration_feedforward: f64,
}

impl Default for Tuning {
    /// A stiffly tuned machine tool axis: 800 Hz, 40 Hz, D 1, ratio 1/4 (Kv 63 1/s), full
    /// feed-forward.
    fn default() -> Tuning {
        Tuning {
            current_bandwidth_hz: 800.0,
            velocity_frequency_hz: 40.0,
            velocity_damping: 1.0,
            position_ratio: 0.25,
            velocity_feedforward: 1.0,
            acceleration_feedforward: 1.0,
        }
    }
}

impl Drive {
    /// A drive whose gains follow from the motor and the load by the rule of [`Tuning`].
    ///
    /// The limits are the caller's: `current_limit_a` as i_q amplitude, `bus_voltage_v` as DC. The
    /// encoder is ideal, the current loop has its usual period (50 us) and one period of delay; all
    /// fields can be set afterwards.
    pub fn tuned(
        motor: &Motor,
        load: &Reflected,
        tuning: &Tuning,
        current_limit_a: f64,
        bus_voltage_v: f64,
    ) -> Drive {
        let inductance = motor.phase_inductance_h();
        let inertia = motor.inertia_kgm2 + load.motor_side_inertia_kgm2 + load.inertia_kgm2;
        let viscous = motor.viscous_nm_s_per_rad + load.viscous_nm_s_per_rad;
        let natural = TAU * tuning.velocity_frequency_hz;
        let damping_torque = 2.0 * tuning.velocity_damping * natural * inertia - viscous;
        Drive {
            current_gain_v_per_a: TAU * tuning.current_bandwidth_hz * inductance,
            current_time_s: inductance / motor.phase_resistance_ohm(),
            velocity_gain_a_s_per_rad: damping_torque / motor.torque_constant_nm_per_a,
            velocity_time_s: damping_torque / (natural * natural * inertia),
            position_gain_per_s: tuning.position_ratio * natural,
            velocity_feedforward: tuning.velocity_feedforward,
            acceleration_feedforward: tuning.acceleration_feedforward,
            told_inertia_kgm2: None,
            current_limit_a,
            bus_voltage_v,
            encoder_counts_per_rev: None,
            current_period_us: None,
            voltage_delay_periods: 1,
            command_delay_periods: 0,
            friction_feedforward: None,
            torque_filter: TorqueFilters::default(),
            anti_windup: AntiWindup::default(),
            least_margins: LeastMargins::default(),
        }
    }
}
