//! Current PI in d and q, with decoupling, back-EMF and the limit of the voltage vector.

use super::Servo;
use crate::plant::{PlantInput, PlantState};
use serde::{Deserialize, Serialize};

/// State of the current loops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurrentState {
    pub(crate) integral_d: f64,
    pub(crate) integral_q: f64,
    /// Voltages computed but not yet applied (d, q), V.
    pub(crate) pending: [f64; 2],
    /// Electric speed as the drive knows it, rad/s; held over a servo period.
    pub(crate) electric_speed: f64,
    /// Back-EMF as the drive knows it, V; held over a servo period.
    pub(crate) back_emf: f64,
    /// Current periods since the last servo tick; counted where the command is delayed.
    pub(super) periods: u32,
    /// Whether the voltage was cut since the last servo tick.
    pub(crate) limited: bool,
    /// i_q at the last servo tick and its sum over the current periods since, A.
    pub(crate) first: f64,
    pub(crate) sum: f64,
}

impl CurrentState {
    pub(super) fn new(voltage: f64, current: f64, periods: f64) -> CurrentState {
        CurrentState {
            integral_d: 0.0,
            integral_q: voltage,
            pending: [0.0, voltage],
            electric_speed: 0.0,
            back_emf: 0.0,
            periods: 0,
            limited: false,
            first: current,
            sum: periods * current,
        }
    }

    #[inline]
    pub(super) fn voltage(
        &mut self,
        servo: &Servo,
        command: f64,
        plant: &PlantState,
    ) -> PlantInput {
        self.sum += plant.current_q;
        let gain = servo.drive.current_gain_v_per_a;
        let share = servo.current_share;
        let cross = self.electric_speed * servo.inductance;
        let (error_d, error_q) = (-plant.current_d, command - plant.current_q);
        let free_d = gain * error_d + self.integral_d - cross * plant.current_q;
        let free_q = gain * error_q + self.integral_q + cross * plant.current_d + self.back_emf;
        let limit = servo.voltage_limit;
        let (cut_d, cut_q) = if free_d * free_d + free_q * free_q > limit * limit {
            self.limited = true;
            // d first: a field current that gets out of hand would weaken or saturate the machine
            let d = free_d.clamp(-limit, limit);
            let room = (limit * limit - d * d).sqrt();
            (d, free_q.clamp(-room, room))
        } else {
            (free_d, free_q)
        };
        self.integral_d += share * (gain * error_d + (cut_d - free_d));
        self.integral_q += share * (gain * error_q + (cut_q - free_q));
        let [voltage_d, voltage_q] = if servo.drive.voltage_delay_periods == 0 {
            [cut_d, cut_q]
        } else {
            self.pending
        };
        self.pending = [cut_d, cut_q];
        PlantInput {
            voltage_d,
            voltage_q,
            load_torque: 0.0,
        }
    }
}
