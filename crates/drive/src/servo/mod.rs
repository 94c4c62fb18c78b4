//! The drive: field-oriented current control, velocity PI, position P.
//!
//! Every servo cycle (250 us), from the encoder at that instant (`velocity`, [`Servo::command`]):
//! ```text
//! w     = (theta(k) - theta(k-1)) / T
//! w_ref = Kv (theta_ref + c_pos - theta + c_fb) + f_v (theta_ref(k) - theta_ref(k-1))/T + c_vel
//! i_ff  = (f_a J_told (w_ref'(k+1) - w_ref'(k))/T + c_torque + T_f((theta_ref(k+1) - theta_ref(k))/T)) / K_t   (w_ref' the spline's velocity)
//! i_ref = clamp(F(z) (Kp (w_ref - w) + I + i_ff))
//! ```
//! with the friction T_f that the drive was told ([`crate::config::FrictionFeedforward`]) and the
//! filters F(z) (`filter`), both none by default, and every period of the current loop (50 us),
//! from the currents at that instant (`current`, [`Servo::voltage`]) the voltages in d and q. The
//! velocity fed forward is the reference's mean over the same period as the encoder's difference,
//! and the acceleration the mean over the coming period, in which the torque acts: so neither
//! leaves a following error of its own.
//!
//! Anti-windup of the velocity loop is selectable ([`crate::config::AntiWindup`]); the current
//! loops always use back-calculation: an output that was cut by `delta` moves its integral by
//! `delta` times period over integral time.
//!
//! Delays: the command takes effect `command_delay_periods` current periods after the encoder was
//! read, a voltage `voltage_delay_periods` after the current was; the crate `lostmotion-analysis` lists them
//! and what they cost in phase.

mod filter;
mod loops;

pub use filter::{FilterState, Filters};
pub(crate) use loops::TickNumbers;
pub use loops::{CurrentState, Encoder, VelocityState};

use crate::config::{AxisConfig, Drive};
use crate::plant::{LoadScale, PlantInput, PlantState};
use crate::signal::{Correction, Reference};
use serde::{Deserialize, Serialize};

/// The drive of one axis: immutable, shared.
#[derive(Clone, Debug)]
pub struct Servo {
    drive: Drive,
    filters: Filters,
    encoder: Encoder,
    scale: LoadScale,
    servo_period_s: f64,
    /// Servo period over integral time.
    velocity_share: f64,
    /// Current period over integral time.
    current_share: f64,
    current_steps: u32,
    torque_constant: f64,
    told_inertia: f64,
    inductance: f64,
    resistance: f64,
    back_emf: f64,
    pole_pairs: f64,
    voltage_limit: f64,
}

/// What the drive carries along.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServoState {
    /// Position and velocity loop.
    pub velocity: VelocityState,
    /// Current loops.
    pub current: CurrentState,
    /// Whether the current or the voltage was at its limit in the last servo period.
    pub saturated: bool,
}

/// What the drive measures at a servo tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Motor position, rad.
    pub position: f64,
    /// Motor speed, rad/s.
    pub velocity: f64,
}

impl Servo {
    /// The drive of an axis.
    pub fn new<C>(config: &AxisConfig<C>) -> Servo {
        let (drive, motor, load) = (config.drive, &config.motor, config.reflected_load());
        let (current_period_s, servo_period_s) =
            (config.current_period_us() * 1e-6, config.servo_period_s());
        Servo {
            drive,
            filters: Filters::new(&drive.torque_filter, servo_period_s),
            encoder: drive
                .encoder_counts_per_rev
                .map_or(Encoder::IDEAL, Encoder::with_counts),
            scale: LoadScale::new(config),
            servo_period_s,
            velocity_share: servo_period_s / drive.velocity_time_s,
            current_share: current_period_s / drive.current_time_s,
            current_steps: drive.current_periods(&config.cycles),
            torque_constant: motor.torque_constant_nm_per_a,
            told_inertia: drive
                .told_inertia_kgm2
                .unwrap_or(config.motor_side_inertia_kgm2() + load.inertia_kgm2),
            inductance: motor.phase_inductance_h(),
            resistance: motor.phase_resistance_ohm(),
            back_emf: motor.back_emf_v_s_per_rad(),
            pole_pairs: motor.pole_pairs(),
            voltage_limit: drive.bus_voltage_v / 3.0_f64.sqrt(),
        }
    }

    /// State of a drive that stands still, holding whatever current flows.
    pub fn initial(&self, plant: &PlantState, reference: f64) -> ServoState {
        ServoState {
            velocity: VelocityState::new(
                self,
                self.encoder.read(plant.motor_position()),
                reference,
                plant.current_q,
            ),
            current: CurrentState::new(
                self.resistance * plant.current_q,
                plant.current_q,
                f64::from(self.current_steps),
            ),
            saturated: false,
        }
    }

    /// Current periods in a servo period.
    pub fn current_steps(&self) -> u32 {
        self.current_steps
    }

    /// Reads the motor's encoder, once per servo tick.
    pub fn measure(&self, state: &mut ServoState, plant: &PlantState) -> Measured {
        let position = self.encoder.read(plant.motor_position());
        let velocity = (position - state.velocity.position) / self.servo_period_s;
        state.velocity.position = position;
        Measured { position, velocity }
    }

    /// Reads the load's scale, rad at the motor's shaft.
    pub fn read_scale(&self, load_position: f64) -> f64 {
        self.scale.read(load_position)
    }

    /// Mean i_q over the servo period that ends now, by the trapezoidal rule over the samples of
    /// the current loop, A.
    pub fn mean_current(&self, state: &mut ServoState, plant: &PlantState) -> f64 {
        let current = &mut state.current;
        let mean =
            (current.sum + 0.5 * (plant.current_q - current.first)) / f64::from(self.current_steps);
        (current.first, current.sum) = (plant.current_q, 0.0);
        mean
    }

    /// Position and velocity loop: sets the current command for the coming servo period.
    pub fn command(
        &self,
        state: &mut ServoState,
        reference: &Reference,
        next: &Reference,
        measured: &Measured,
        correction: &Correction,
    ) {
        let voltage_limited = state.current.limited;
        let limited =
            state
                .velocity
                .command(self, reference, next, measured, correction, voltage_limited);
        state.current.limited = false;
        state.current.periods = 0;
        state.current.electric_speed = self.pole_pairs * measured.velocity;
        state.current.back_emf = self.back_emf * measured.velocity;
        state.saturated = limited;
    }

    /// Current loops: the voltages for the coming current period.
    #[inline]
    pub fn voltage(&self, state: &mut ServoState, plant: &PlantState) -> PlantInput {
        let command = self.command_in_force(state);
        let input = state.current.voltage(self, command, plant);
        state.saturated |= state.current.limited;
        input
    }

    /// The current command that holds in the coming current period: the newest one that has taken
    /// effect.
    #[inline]
    fn command_in_force(&self, state: &mut ServoState) -> f64 {
        let delay = self.drive.command_delay_periods;
        if delay == 0 {
            return state.velocity.current_command;
        }
        let age = delay
            .saturating_sub(state.current.periods)
            .div_ceil(self.current_steps);
        state.current.periods += 1;
        let [last, before] = state.velocity.earlier_commands;
        [state.velocity.current_command, last, before]
            .get(age as usize)
            .copied()
            .unwrap_or(before)
    }
}
