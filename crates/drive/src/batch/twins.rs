//! The models that compensators have of their own axes (`twin`), stepped side by
//! side: what `Twin::step` does, operation by operation.
//!
//! Each tick they are taken up from their compensators and given back, so these need not know that
//! they have company. One whose voltage would be cut is left as it was and steps by itself.

use super::lanes::{Row, WIDTH};
use super::loops::DriveNumbers;
use super::twin_kernel::Steps;
use crate::runner::TwinStep;
use crate::twin::{MotorNumbers, Rates, Twin, TwinState};
use pulp::Arch;

/// Numbers of drive and motor.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    pub(super) drive: DriveNumbers,
    pub(super) gain: Row,
    pub(super) share: Row,
    pub(super) limit_squared: Row,
    pub(super) delayed: Row,
    pub(super) inductance: Row,
    pub(super) period: Row,
    pub(super) motor: [Row; 10],
}

/// What comes with a tick, and what a twin carries.
#[derive(Clone, Debug, Default)]
pub(super) struct States {
    /// Position, velocity, next velocity.
    pub(super) reference: [Row; 3],
    pub(super) rates: [Row; 9],
    pub(super) seen: Row,
    pub(super) last_position: Row,
    pub(super) integral: Row,
    pub(super) command: Row,
    pub(super) limited: Row,
    pub(super) electric_speed: Row,
    pub(super) back_emf: Row,
    pub(super) fast_integral: [Row; 2],
    pub(super) pending: [Row; 2],
    pub(super) sum: Row,
    pub(super) current: [Row; 2],
    pub(super) gap_angle: Row,
    pub(super) motor: Row,
    pub(super) load: Row,
    pub(super) place: Row,
    pub(super) torque: Row,
    pub(super) friction: Row,
    pub(super) saturated: Row,
    /// 1 where a voltage would be cut, else 0.
    pub(super) cut: Row,
}

/// The twins of a group of axes.
#[derive(Clone, Debug, Default)]
pub(super) struct Twins {
    pub(super) numbers: Numbers,
    pub(super) states: States,
    known: [bool; WIDTH],
    plain: [bool; WIDTH],
}

impl Twins {
    /// The axis of a lane may be another one from now on.
    pub(super) fn forget(&mut self, lane: usize) {
        self.known[lane] = false;
    }

    /// Steps all that there are.
    pub(super) fn step(
        &mut self,
        arch: Arch,
        steps: &mut [Option<TwinStep<'_>>; WIDTH],
        periods: u32,
    ) {
        let mut taken = [false; WIDTH];
        for (lane, step) in steps.iter().enumerate() {
            let Some(step) = step else { continue };
            if !self.known[lane] {
                (self.plain[lane], self.known[lane]) =
                    (self.numbers.put(lane, step.twin.twin), true);
            }
            if self.plain[lane] {
                self.states.take(lane, step);
                taken[lane] = true;
            }
        }
        if taken.iter().any(|taken| *taken) {
            arch.dispatch(Steps {
                twins: self,
                taken,
                periods,
            });
        }
        for (lane, step) in steps.iter_mut().enumerate() {
            let Some(step) = step.take() else { continue };
            if taken[lane] && self.states.cut.0[lane] <= 0.0 {
                self.states
                    .give(lane, step.twin.state, step.reference.position);
            } else {
                step.run();
            }
        }
    }
}

impl Numbers {
    /// Takes up a twin; false if its drive is not a plain one.
    fn put(&mut self, lane: usize, twin: &Twin) -> bool {
        let (Some(tick), Some(current)) =
            (twin.servo().tick_numbers(), twin.servo().current_numbers())
        else {
            return false;
        };
        self.drive.put(lane, &tick);
        self.gain.0[lane] = current.gain;
        self.share.0[lane] = current.share;
        self.limit_squared.0[lane] = current.limit_squared;
        self.delayed.0[lane] = f64::from(u8::from(current.delayed));
        self.inductance.0[lane] = current.inductance;
        self.period.0[lane] = twin.period_s();
        let n: &MotorNumbers = twin.numbers();
        let values = [
            n.current_share,
            n.current_keep,
            n.back_emf,
            n.torque_constant,
            n.viscous,
            n.coulomb,
            n.inverse_motor,
            n.motor_step,
            n.motor_most,
            n.friction_scale,
        ];
        fill(&mut self.motor, lane, values);
        tick.encoder_step <= 0.0
    }
}

fn fill<const N: usize>(rows: &mut [Row; N], lane: usize, values: [f64; N]) {
    for (row, value) in rows.iter_mut().zip(values) {
        row.0[lane] = value;
    }
}

impl States {
    fn take(&mut self, lane: usize, step: &TwinStep<'_>) {
        let (state, rates): (&TwinState, Rates) =
            (step.twin.state, step.twin.twin.rates(&step.twin.load));
        fill(
            &mut self.reference,
            lane,
            [
                step.reference.position,
                step.reference.velocity,
                step.next.velocity,
            ],
        );
        let load = [
            rates.load_constant,
            rates.load_viscous,
            rates.load_coulomb,
            rates.inverse_load,
            rates.load_step,
            rates.load_most,
        ];
        fill(
            &mut self.rates,
            lane,
            [
                load[0],
                load[1],
                load[2],
                load[3],
                load[4],
                load[5],
                rates.stiffness,
                rates.damping,
                rates.give,
            ],
        );
        let (velocity, current, plant) =
            (&state.servo.velocity, &state.servo.current, &state.plant);
        self.seen.0[lane] = velocity.position;
        self.last_position.0[lane] = velocity.reference;
        self.integral.0[lane] = velocity.integral;
        self.command.0[lane] = velocity.current_command;
        self.limited.0[lane] = f64::from(u8::from(current.limited));
        fill(
            &mut self.fast_integral,
            lane,
            [current.integral_d, current.integral_q],
        );
        fill(&mut self.pending, lane, current.pending);
        self.sum.0[lane] = current.sum;
        fill(&mut self.current, lane, [plant.current_d, plant.current_q]);
        self.gap_angle.0[lane] = plant.gap_angle;
        self.motor.0[lane] = plant.motor_velocity;
        self.load.0[lane] = plant.load_velocity;
        self.place.0[lane] = plant.load_position;
        self.cut.0[lane] = 0.0;
    }

    fn give(&self, lane: usize, state: &mut TwinState, reference: f64) {
        let (velocity, current, plant) = (
            &mut state.servo.velocity,
            &mut state.servo.current,
            &mut state.plant,
        );
        velocity.position = self.seen.0[lane];
        velocity.reference = reference;
        velocity.integral = self.integral.0[lane];
        velocity.earlier_commands = [velocity.current_command, velocity.earlier_commands[0]];
        velocity.current_command = self.command.0[lane];
        current.limited = false;
        current.electric_speed = self.electric_speed.0[lane];
        current.back_emf = self.back_emf.0[lane];
        (current.integral_d, current.integral_q) =
            (self.fast_integral[0].0[lane], self.fast_integral[1].0[lane]);
        current.pending = [self.pending[0].0[lane], self.pending[1].0[lane]];
        current.sum = self.sum.0[lane];
        plant.current_q = self.current[1].0[lane];
        plant.gap_angle = self.gap_angle.0[lane];
        plant.motor_velocity = self.motor.0[lane];
        plant.load_velocity = self.load.0[lane];
        plant.load_position = self.place.0[lane];
        state.servo.saturated = self.saturated.0[lane] > 0.0;
        (state.torque, state.motor_friction) = (self.torque.0[lane], self.friction.0[lane]);
    }
}
