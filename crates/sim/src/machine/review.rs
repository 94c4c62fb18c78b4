//! What a machine's figures mean: does the motor manage its limits, is the mechanics stiffer than
//! the loops are fast.

use super::{Machine, MachineAxis};
use lostmotion_base::AxisId;
use std::f64::consts::TAU;

/// One axis' figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisReview {
    /// The axis.
    pub axis: AxisId,
    /// Torque for the largest acceleration at the largest speed, with friction and constant load,
    /// over what the current limit gives.
    pub peak_torque_ratio: f64,
    /// Friction (Coulomb of motor and load) over the motor's rated torque.
    pub friction_ratio: f64,
    /// Constant load over the motor's rated torque.
    pub constant_ratio: f64,
    /// Voltage at the largest speed and torque over what the bus gives.
    pub voltage_ratio: f64,
    /// Speed of the motor at the axis' limit, 1/min.
    pub motor_rpm: f64,
    /// Frequency of the load against the held motor (anti-resonance), Hz.
    pub locked_motor_hz: f64,
    /// First resonance: motor against load through the shaft, Hz.
    pub resonance_hz: f64,
    /// Damping of that resonance, in parts of the critical one.
    pub resonance_damping: f64,
    /// Frequency at which the velocity loop's gain crosses 1, from its proportional part and the
    /// whole inertia, Hz.
    pub velocity_loop_hz: f64,
    /// Position gain, 1/s.
    pub position_gain_per_s: f64,
    /// Inertia of the load over all that turns with the motor.
    pub inertia_ratio: f64,
    /// Whether the velocity loop has no integral part: a stepper's rotor on its field, to which no
    /// rule of cascades applies.
    pub is_open_loop: bool,
}

/// Integral time from which there is no integral part, s: beyond any motion between two reversals.
const NO_INTEGRAL_S: f64 = 100.0;

impl AxisReview {
    /// The figures of an axis.
    pub fn of(axis: &MachineAxis) -> AxisReview {
        let (motor, drive, load) = (
            axis.config.motor,
            axis.config.drive,
            axis.config.reflected_load(),
        );
        // Joint units to radians of the motor: axis units in between.
        let motor_rad =
            axis.config.transmission.motor_rad_per_unit() * axis.axis_units_per_joint_unit();
        let speed = axis.limits.velocity * motor_rad;
        let motor_side = axis.config.motor_side_inertia_kgm2();
        let inertia = motor_side + load.inertia_kgm2;
        let coulomb = motor.coulomb_nm + load.coulomb_nm;
        let viscous = (motor.viscous_nm_s_per_rad + load.viscous_nm_s_per_rad) * speed;
        // Torque for the largest acceleration at the largest speed, with friction and gravity.
        let torque = inertia * axis.limits.acceleration * motor_rad
            + coulomb
            + viscous
            + load.constant_nm.abs();
        let current = torque / motor.torque_constant_nm_per_a;
        // Voltage of the q axis (back EMF and resistance) and of the d axis (cross coupling).
        let q_volt = motor.back_emf_v_s_per_rad() * speed + motor.phase_resistance_ohm() * current;
        let d_volt = motor.phase_inductance_h() * motor.pole_pairs() * speed * current;
        // Two masses on a spring: w^2 = k (1/J_motor + 1/J_load).
        let joint = 1.0 / motor_side + 1.0 / load.inertia_kgm2;
        let resonance = (load.stiffness_nm_per_rad * joint).sqrt();
        AxisReview {
            axis: axis.id,
            peak_torque_ratio: current / drive.current_limit_a,
            friction_ratio: coulomb / motor.rated_torque_nm,
            constant_ratio: load.constant_nm.abs() / motor.rated_torque_nm,
            voltage_ratio: (q_volt * q_volt + d_volt * d_volt).sqrt()
                / (drive.bus_voltage_v / 3.0_f64.sqrt()),
            motor_rpm: speed * 60.0 / TAU,
            locked_motor_hz: (load.stiffness_nm_per_rad / load.inertia_kgm2).sqrt() / TAU,
            resonance_hz: resonance / TAU,
            resonance_damping: 0.5 * load.damping_nm_s_per_rad * joint / resonance,
            velocity_loop_hz: drive.velocity_gain_a_s_per_rad * motor.torque_constant_nm_per_a
                / inertia
                / TAU,
            position_gain_per_s: drive.position_gain_per_s,
            inertia_ratio: load.inertia_kgm2 / motor_side,
            is_open_loop: drive.velocity_time_s >= NO_INTEGRAL_S,
        }
    }

    /// What a commissioning engineer would object to; empty for a sound axis.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let mut note = |wrong: bool, text: String| {
            if wrong {
                remarks.push(format!("axis {}: {text}", self.axis));
            }
        };
        let percent = |ratio: f64| (ratio * 100.0).round();
        note(
            self.peak_torque_ratio > 1.0,
            format!(
                "its acceleration needs {} % of the drive's current limit",
                percent(self.peak_torque_ratio)
            ),
        );
        note(
            self.voltage_ratio > 1.0,
            format!(
                "its speed and acceleration need {} % of the bus voltage",
                percent(self.voltage_ratio)
            ),
        );
        note(
            self.friction_ratio + self.constant_ratio > 1.0,
            format!(
                "friction and constant load take {} % of the rated torque",
                percent(self.friction_ratio + self.constant_ratio)
            ),
        );
        // Above the resonance the load no longer moves with the motor.
        note(
            !self.is_open_loop && self.velocity_loop_hz > self.resonance_hz,
            format!(
                "the velocity loop ({:.0} Hz) is faster than the first resonance ({:.0} Hz)",
                self.velocity_loop_hz, self.resonance_hz
            ),
        );
        // The position loop takes the velocity loop for fast; from half its bandwidth on that is
        // not so.
        let ratio = self.position_gain_per_s / (TAU * self.velocity_loop_hz);
        note(
            !self.is_open_loop && ratio > 0.5,
            format!(
                "the position gain is {} % of the velocity loop's bandwidth",
                percent(ratio)
            ),
        );
        remarks
    }
}

impl Machine {
    /// The figures of every axis.
    pub fn review(&self) -> Vec<AxisReview> {
        self.axes().iter().map(AxisReview::of).collect()
    }
}
