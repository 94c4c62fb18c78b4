//! The axis as a linear system in discrete time: plant, current loop, velocity and position loop,
//! with every delay of the drive.
//!
//! Between two current periods the plant is stepped by its matrix exponential; the loops are the
//! servo's own equations without limits and quantisation. So the model is exact for motions that
//! stay on a flank (or between them) and within the limits. States: `i_q`, `w_M`, motor travel
//! since the last servo tick, and on a flank penetration and `w_L`; then the current integral, the
//! pending voltage, the two last commands, the velocity integral, the filters, and the motor's
//! position.

use super::response::StateSpace;
use lostmotion_base::matrix::SquareMatrix;
use lostmotion_drive::config::Drive;
use lostmotion_drive::servo::Filters;
use lostmotion_methods::AxisConfig;

const CURRENT: usize = 0;
const MOTOR: usize = 1;
const TRAVEL: usize = 2;
const PENETRATION: usize = 3;
const LOAD: usize = 4;

/// What the motor drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coupling {
    /// Part of stiffness and damping that acts: 1 on a flank, 0 with the motor alone, between as
    /// the gap's describing function.
    pub(super) share: f64,
    /// Viscous friction on top of the motor's and the load's, N m s/rad: friction as its describing
    /// function has it.
    pub(super) extra_viscous: [f64; 2],
}

impl Coupling {
    pub(super) const ENGAGED: Coupling = Coupling {
        share: 1.0,
        extra_viscous: [0.0; 2],
    };
    pub(super) const GAP: Coupling = Coupling {
        share: 0.0,
        extra_viscous: [0.0; 2],
    };
}

/// Which position the position loop sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Feedback {
    /// The motor's encoder.
    Motor,
    /// The load's scale.
    Load,
}

/// The linear axis.
pub(super) struct Model {
    step: SquareMatrix,
    drive: Drive,
    filters: Filters,
    back_emf: f64,
    period_s: f64,
    servo_period_s: f64,
    /// Number of plant states; in the step's matrix the voltage follows them.
    plant: usize,
}

impl Model {
    pub(super) fn new(config: &AxisConfig, coupling: Coupling) -> Model {
        let drive = config.drive;
        // In the gap the load's two states do not act on the motor.
        let plant = if coupling.share > 0.0 { 5 } else { 3 };
        let period_s = config.current_period_us() * 1e-6;
        let servo_period_s = config.servo_period_s();
        Model {
            step: equations(config, coupling, plant)
                .scaled(period_s)
                .exponential(),
            drive,
            filters: Filters::new(&drive.torque_filter, servo_period_s),
            back_emf: config.motor.back_emf_v_s_per_rad(),
            period_s,
            servo_period_s,
            plant,
        }
    }

    /// The current loop, broken at its error: i_q for an error of one ampere, the rotor held. (The
    /// back-EMF of a turning one is fed forward.)
    pub(super) fn current_loop(config: &AxisConfig, gain: f64) -> StateSpace {
        // An infinite inertia holds the rotor.
        let mut held = config.clone();
        held.motor.inertia_kgm2 = f64::INFINITY;
        let model = Model::new(&held, Coupling::GAP);
        StateSpace::of(model.plant + 2, model.period_s, |x, error| {
            let current = x[CURRENT];
            model.current_period(x, gain * error, 0.0);
            // Speed and travel are no states of a held rotor.
            x[MOTOR] = 0.0;
            x[TRAVEL] = 0.0;
            current
        })
    }

    /// The velocity loop, broken at its error: measured velocity for an error of 1 rad/s, the
    /// current loop closed.
    pub(super) fn velocity_loop(&self, gain: f64) -> StateSpace {
        StateSpace::of(self.states(), self.servo_period_s, |x, error| {
            let speed = x[TRAVEL] / self.servo_period_s;
            self.velocity_period(x, gain * error);
            speed
        })
    }

    /// The position loop, broken at its error: the position it sees for an error of 1 rad, the
    /// velocity loop closed.
    pub(super) fn position_loop(&self, feedback: Feedback, gain: f64) -> StateSpace {
        StateSpace::of(self.states() + 1, self.servo_period_s, |x, error| {
            let place = self.states();
            // The load lags the motor by the penetration (the gap itself is constant on a flank).
            let seen = match feedback {
                Feedback::Motor => x[place],
                Feedback::Load => {
                    x[place]
                        - if self.plant > PENETRATION {
                            x[PENETRATION]
                        } else {
                            0.0
                        }
                }
            };
            // Velocity as the drive sees it: the encoder's difference over a servo period.
            let speed = x[TRAVEL] / self.servo_period_s;
            self.velocity_period(x, gain * self.drive.position_gain_per_s * error - speed);
            x[place] += x[TRAVEL];
            seen
        })
    }

    fn states(&self) -> usize {
        self.plant + 5 + 2 * self.filters.len()
    }

    /// One period of the current loop; its integral and the pending voltage follow the plant's
    /// states.
    fn current_period(&self, x: &mut [f64], error: f64, emf: f64) {
        let (integral, pending) = (self.plant, self.plant + 1);
        // PI controller and back-EMF feed-forward.
        let push = self.drive.current_gain_v_per_a * error;
        let computed = push + x[integral] + emf;
        x[integral] += self.period_s / self.drive.current_time_s * push;
        // Dead time of the converter: the voltage of the period before acts.
        let applied = if self.drive.voltage_delay_periods == 0 {
            computed
        } else {
            x[pending]
        };
        x[pending] = computed;
        // The plant's exact step under a constant voltage.
        let mut next = [0.0; 5];
        for (row, entry) in next.iter_mut().enumerate().take(self.plant) {
            let row = self.step.row(row);
            *entry = row
                .iter()
                .zip(x.iter())
                .take(self.plant)
                .map(|(factor, state)| factor * state)
                .sum::<f64>()
                + row[self.plant] * applied;
        }
        x[..self.plant].copy_from_slice(&next[..self.plant]);
    }

    /// One servo period from an error of velocity.
    fn velocity_period(&self, x: &mut [f64], error: f64) {
        let (commands, integral) = (self.plant + 2, self.plant + 4);
        // The feed-forward uses the measured speed, which is held over the servo period.
        let emf = self.back_emf * x[TRAVEL] / self.servo_period_s;
        x[TRAVEL] = 0.0;
        // PI controller, then the torque filters.
        let push = self.drive.velocity_gain_a_s_per_rad * error;
        let wanted = push + x[integral];
        x[integral] += self.servo_period_s / self.drive.velocity_time_s * push;
        let filters = x[integral + 1..integral + 1 + 2 * self.filters.len()]
            .as_chunks_mut::<2>()
            .0;
        let command = self.filters.step(filters, wanted);
        let steps = (self.servo_period_s / self.period_s).round() as u32;
        for period in 0..steps {
            // Dead time of the command: in the first current periods an older command is in force.
            let age = self
                .drive
                .command_delay_periods
                .saturating_sub(period)
                .div_ceil(steps);
            let in_force = [command, x[commands], x[commands + 1]][age.min(2) as usize];
            let error = in_force - x[CURRENT];
            self.current_period(x, error, emf);
        }
        // The delay line moves on by one servo period.
        x[commands + 1] = x[commands];
        x[commands] = command;
    }
}

/// The plant's equations of motion, the voltage as one more column.
fn equations(config: &AxisConfig, coupling: Coupling, plant: usize) -> SquareMatrix {
    let (motor, load) = (&config.motor, config.reflected_load());
    let (stiffness, damping) = (
        coupling.share * load.stiffness_nm_per_rad,
        coupling.share * load.damping_nm_s_per_rad,
    );
    let (motor_inertia, inductance) =
        (config.motor_side_inertia_kgm2(), motor.phase_inductance_h());
    let motor_viscous = motor.viscous_nm_s_per_rad + coupling.extra_viscous[0];
    let load_viscous = load.viscous_nm_s_per_rad + coupling.extra_viscous[1];
    let mut a = SquareMatrix::zero(plant + 1);
    // Voltage equation of the winding.
    a.set(CURRENT, CURRENT, -motor.phase_resistance_ohm() / inductance);
    a.set(CURRENT, MOTOR, -motor.back_emf_v_s_per_rad() / inductance);
    a.set(CURRENT, plant, 1.0 / inductance);
    a.set(
        MOTOR,
        CURRENT,
        motor.torque_constant_nm_per_a / motor_inertia,
    );
    a.set(TRAVEL, MOTOR, 1.0);
    // The motor alone: its torque against its own friction.
    if plant <= PENETRATION {
        a.set(MOTOR, MOTOR, -motor_viscous / motor_inertia);
        return a;
    }
    // Two masses with spring and damper between them.
    a.set(MOTOR, MOTOR, -(motor_viscous + damping) / motor_inertia);
    a.set(MOTOR, PENETRATION, -stiffness / motor_inertia);
    a.set(MOTOR, LOAD, damping / motor_inertia);
    a.set(PENETRATION, MOTOR, 1.0);
    a.set(PENETRATION, LOAD, -1.0);
    a.set(LOAD, MOTOR, damping / load.inertia_kgm2);
    a.set(LOAD, PENETRATION, stiffness / load.inertia_kgm2);
    a.set(LOAD, LOAD, -(damping + load_viscous) / load.inertia_kgm2);
    a
}
