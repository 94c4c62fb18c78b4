//! The machine of a cell.
//!
//! Rotor 0.00189 kg m2, rated torque 11 N m at 2000 1/min, at most 43 N m; screw of 20 mm lead,
//! shaft of 2400 N m/rad with 5 % of critical damping. Gains follow from the inertias by the rule
//! of [`Tuning`], as a commissioning engineer would set them: 40 Hz, but so low that the loop
//! is still stable when the motor turns alone in its gap.
//!
//! In half of the cells the machine changes while it runs, in a straight line over the length of
//! the motion, or 30 s if that is more: the gap grows by a tenth, the load's friction by three
//! tenths, its inertia by a fifth. No method is told.

use super::factor::{Cell, DRIFT, ENCODER, FRICTION, GAP, INERTIA, VISCOUS};
use super::motion::moves_z;
use crate::error::StudyError;
use lostmotion_base::AxisId;
use lostmotion_drive::config::{Change, Drift, Load, Reflected, Shape, Tuning};
use lostmotion_methods::AxisConfig;
use lostmotion_sim::Machine;
use std::f64::consts::TAU;

/// The axes that a cell is about.
pub const AXES: [AxisId; 2] = [AxisId::X, AxisId::Y];

/// Speed for which motors of this class are rated, rad/s (2000 1/min).
const RATED_SPEED_RAD_S: f64 = 2000.0 / 60.0 * TAU;
/// Damping of the shaft in parts of the critical one: common for ball screws on roller guides, as
/// in the preset `vmc3`.
const SHAFT_DAMPING: f64 = 0.05;
/// Natural frequency of the velocity loop, Hz, where the loop is stable with it: that of
/// [`Tuning`]'s default.
const VELOCITY_HZ: f64 = 40.0;
/// Highest gain crossover of the velocity loop with the motor alone, 1/s: 45 degrees for the delays
/// of encoder difference, servo and current loop (0.5 ms in all).
const ALONE_PER_S: f64 = 1600.0;
/// Final factors of a drifting gap, friction and inertia. A choice.
const DRIFTED: [f64; 3] = [1.1, 1.3, 1.2];
/// Shortest time of a drift, s: slower than any learning. A choice.
const DRIFT_S: f64 = 30.0;
/// The planner's side of the machine, and the motor.
const TEXT: &str = include_str!("machine.toml");

/// The planner's side of a cell's machine: the limits, the same for all cells; without Z where the
/// program does not move it.
///
/// # Errors
/// None, as long as the file beside this is in order.
pub fn machine(cell: &Cell) -> Result<Machine, StudyError> {
    let machine = Machine::from_toml("machine.toml", TEXT)?;
    if moves_z(cell) {
        return Ok(machine);
    }
    Ok(machine.edit(|machine| machine.remove_axis("z"))?)
}

/// A machine with all axes alike.
pub(super) fn of_cell(machine: &Machine, axis: &AxisConfig) -> Machine {
    machine.map_axes(|_| axis.clone())
}

/// How a cell's machine changes over a motion of some length, s.
pub fn drift(cell: &Cell, motion_s: f64) -> Drift {
    if cell.level_name(DRIFT) == "steady" {
        return Drift::NONE;
    }
    // Over the motion, or longer: a short motion sees only the beginning.
    let [gap, friction, inertia] = DRIFTED.map(|factor| {
        Some(Change {
            factor,
            over_s: DRIFT_S.max(motion_s),
            shape: Shape::Ramp,
        })
    });
    Drift {
        gap,
        load_coulomb: friction,
        load_viscous: friction,
        load_inertia: inertia,
        ..Drift::NONE
    }
}

/// One axis of a cell, without its drift; both are alike.
///
/// # Errors
/// As [`machine`], and a description that makes no sense.
pub fn axis(cell: &Cell) -> Result<AxisConfig, StudyError> {
    let machine = machine(cell)?;
    let [first, _] = AXES;
    let base = machine
        .axis(first)
        .map(|axis| axis.config.clone())
        .unwrap_or_else(AxisConfig::paper);
    let motor = base.motor;
    // The levels of the cell in SI units at the motor.
    let inertia = cell.number(INERTIA) * motor.inertia_kgm2;
    let together = motor.inertia_kgm2 * inertia / (motor.inertia_kgm2 + inertia);
    let old = base.reflected_load();
    let load = Reflected {
        inertia_kgm2: inertia,
        coulomb_nm: 0.01 * cell.number(FRICTION) * motor.rated_torque_nm,
        viscous_nm_s_per_rad: 0.01 * cell.number(VISCOUS) * motor.rated_torque_nm
            / RATED_SPEED_RAD_S,
        damping_nm_s_per_rad: 2.0 * SHAFT_DAMPING * (old.stiffness_nm_per_rad * together).sqrt(),
        gap_rad: 1e-3 * cell.number(GAP) * base.transmission.motor_rad_per_unit(),
        ..old
    };
    // Velocity loop of motor and load; when the motor is alone in the gap its crossover is higher
    // by the ratio of the inertias, and that has to stay below the limit.
    let alone_hz = ALONE_PER_S * motor.inertia_kgm2 / (2.0 * (motor.inertia_kgm2 + inertia)) / TAU;
    let tuning = Tuning {
        velocity_frequency_hz: VELOCITY_HZ.min(alone_hz),
        ..Tuning::default()
    };
    let mut axis = AxisConfig {
        load: Load::Reflected(load),
        ..base
    }
    .tuned(&tuning);
    // Commissioned with the true inertia.
    axis.drive.told_inertia_kgm2 = Some(motor.inertia_kgm2 + inertia);
    // No bits stand for an ideal encoder.
    let bits = cell.number(ENCODER) as u32;
    axis.drive.encoder_counts_per_rev = (bits > 0).then(|| 1 << bits);
    axis.check().map_err(lostmotion_drive::AxisError::from)?;
    Ok(axis)
}
