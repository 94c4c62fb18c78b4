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
pub(crate) use loops::{
    CurrentNumbers, CurrentOutput, CurrentPeriod, PlainDrive, TickNumbers, VelocityInput,
    VelocityOutput, counted,
};
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
    current_steps: u32,
    numbers: TickNumbers<f64>,
    current_numbers: CurrentNumbers<f64>,
    resistance: f64,
    /// Longest voltage vector, V.
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
        // without a told one the drive knows the true inertia
        let told_inertia = drive
            .told_inertia_kgm2
            .unwrap_or(config.motor_side_inertia_kgm2() + load.inertia_kgm2);
        let encoder = drive
            .encoder_counts_per_rev
            .map_or(Encoder::IDEAL, Encoder::with_counts);
        let current_steps = drive.current_periods(&config.cycles);
        // longest vector that space-vector modulation gives without distortion
        let voltage_limit = drive.bus_voltage_v / 3.0_f64.sqrt();
        Servo {
            drive,
            filters: Filters::new(&drive.torque_filter, servo_period_s),
            encoder,
            scale: LoadScale::new(config),
            current_steps,
            numbers: TickNumbers {
                period: servo_period_s,
                encoder_step: encoder.step_rad(),
                current_steps: f64::from(current_steps),
                position_gain: drive.position_gain_per_s,
                velocity_feedforward: drive.velocity_feedforward,
                inertia_feedforward: drive.acceleration_feedforward * told_inertia,
                velocity_gain: drive.velocity_gain_a_s_per_rad,
                velocity_share: servo_period_s / drive.velocity_time_s,
                torque_constant: motor.torque_constant_nm_per_a,
                current_limit: drive.current_limit_a,
                pole_pairs: motor.pole_pairs(),
                back_emf: motor.back_emf_v_s_per_rad(),
            },
            current_numbers: CurrentNumbers {
                gain: drive.current_gain_v_per_a,
                share: current_period_s / drive.current_time_s,
                inductance: motor.phase_inductance_h(),
                limit_squared: voltage_limit * voltage_limit,
                delayed: f64::from(u8::from(drive.voltage_delay_periods != 0)),
            },
            resistance: motor.phase_resistance_ohm(),
            voltage_limit,
        }
    }

    /// The same drive switched off: every gain is zero, so that it sets no voltage.
    #[must_use]
    pub(crate) fn switched_off(mut self) -> Servo {
        self.drive.friction_feedforward = None;
        self.numbers = TickNumbers {
            position_gain: 0.0,
            velocity_feedforward: 0.0,
            inertia_feedforward: 0.0,
            velocity_gain: 0.0,
            // what the decoupling and the back-EMF feed forward
            pole_pairs: 0.0,
            back_emf: 0.0,
            ..self.numbers
        };
        self.current_numbers = CurrentNumbers {
            gain: 0.0,
            ..self.current_numbers
        };
        self
    }

    /// State of a drive at the start, keeping up whatever current flows.
    pub fn initial(&self, plant: &PlantState, reference: f64) -> ServoState {
        // a motor that moves was a period's way back when its encoder was read last
        let speed = plant.motor_velocity;
        let before = plant.motor_position() - speed * self.numbers.period;
        let back_emf = self.numbers.back_emf * speed;
        ServoState {
            // integrals start with the current and the voltage that hold the axis, so nothing moves
            // at the first tick
            velocity: VelocityState::new(
                self,
                self.encoder.read(before),
                reference,
                plant.current_q,
            ),
            current: CurrentState::new(
                self.resistance * plant.current_q,
                back_emf,
                plant.current_q,
                self.numbers.current_steps,
            ),
            saturated: false,
        }
    }

    /// Current periods in a servo period.
    pub fn current_steps(&self) -> u32 {
        self.current_steps
    }

    /// Reads the motor's encoder, once per servo tick.
    #[inline]
    pub fn measure(&self, state: &mut ServoState, plant: &PlantState) -> Measured {
        let position = self.encoder.read(plant.motor_position());
        let velocity = self.numbers.speed(position, state.velocity.position);
        state.velocity.position = position;
        Measured { position, velocity }
    }

    /// Reads the load's scale, rad at the motor's shaft.
    #[inline]
    pub fn read_scale(&self, load_position: f64) -> f64 {
        self.scale.read(load_position)
    }

    /// Mean i_q over the servo period that ends now, by the trapezoidal rule over the samples of
    /// the current loop, A.
    #[inline]
    pub fn mean_current(&self, state: &mut ServoState, plant: &PlantState) -> f64 {
        let current = &mut state.current;
        let mean = self
            .numbers
            .mean_current(current.sum, current.first, plant.current_q);
        (current.first, current.sum) = (plant.current_q, 0.0);
        mean
    }

    /// Position and velocity loop: sets the current command for the coming servo period.
    #[inline]
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
        // from here on limits belong to the coming servo period
        state.current.limited = false;
        state.current.periods = 0;
        // decoupling and back-EMF use the speed that the drive has measured, held until the next
        // tick
        state.current.electric_speed = self.numbers.pole_pairs * measured.velocity;
        state.current.back_emf = self.numbers.back_emf * measured.velocity;
        state.saturated = limited;
    }

    /// Current loops: the voltages for the coming current period.
    #[inline(always)]
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
        // how many servo periods ago the command in force was computed
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
