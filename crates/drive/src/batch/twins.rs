//! The models that compensators have of their own axes (`twin`), stepped side by
//! side: what `Twin::step` does, operation by operation.
//!
//! Each tick they are taken up from their compensators and given back, so these need not know that
//! they have company. One whose voltage would be cut is left as it was and steps by itself.

use super::lanes::{DriveNumbers, Row, WIDTH};
use super::tick::{Asked, Commanded, Fast, Voltages, parts};
use super::vector::Wide;
use crate::runner::TwinStep;
use crate::twin::{MotorNumbers, Rates, Twin, TwinState};
use pulp::{Arch, Simd, WithSimd};

/// Numbers of drive and motor.
#[derive(Clone, Debug, Default)]
pub(super) struct TwinNumbers {
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
pub(super) struct TwinRows {
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
    pub(super) numbers: TwinNumbers,
    pub(super) states: TwinRows,
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

impl TwinNumbers {
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

impl TwinRows {
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

// A servo period of all twins: what `Twin::step` does, operation by operation.

/// Steps the twins that are taken.
pub(super) struct Steps<'a> {
    pub(super) twins: &'a mut Twins,
    pub(super) taken: [bool; WIDTH],
    pub(super) periods: u32,
}

impl WithSimd for Steps<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Twins {
            numbers, states, ..
        } = self.twins;
        for part in 0..parts::<S>(&self.taken) {
            let vector = Wide { simd, part };
            vector.drive(numbers, states);
            for _ in 0..self.periods {
                vector.advance(numbers, states);
            }
        }
    }
}

impl<S: Simd> Wide<S> {
    /// Measuring, position and velocity loop.
    #[inline(always)]
    fn drive(self, n: &TwinNumbers, x: &mut TwinRows) {
        let zero = self.all(0.0);
        let seen = self.add(self.get(&x.place), self.get(&x.gap_angle));
        let measured = self.div(self.sub(seen, self.get(&x.seen)), self.get(&n.drive.period));
        let [position, velocity, next_velocity] =
            [0, 1, 2].map(|which: usize| self.get(&x.reference[which]));
        let asked = Asked {
            position,
            velocity,
            next_velocity,
            last_position: self.get(&x.last_position),
            seen,
            measured,
            correction: [zero; 4],
            integral: self.get(&x.integral),
            limited: self.get(&x.limited),
        };
        let Commanded {
            cut,
            free,
            integral,
        } = self.velocity_loop(&n.drive, &asked);
        let saturated = self.choose(self.simd.equal_f64s(cut, free), zero, self.all(1.0));
        self.put(&mut x.seen, seen);
        self.put(&mut x.integral, integral);
        self.put(&mut x.command, cut);
        self.put(&mut x.saturated, saturated);
        self.put(
            &mut x.electric_speed,
            self.mul(self.get(&n.drive.pole_pairs), measured),
        );
        self.put(
            &mut x.back_emf,
            self.mul(self.get(&n.drive.back_emf), measured),
        );
    }

    /// A period of the current loop, and motor, shaft and load.
    #[inline(always)]
    fn advance(self, n: &TwinNumbers, x: &mut TwinRows) {
        let [
            share,
            keep,
            back_emf,
            constant,
            viscous,
            coulomb,
            inverse_motor,
            motor_step,
            motor_most,
            scale,
        ] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|which: usize| self.get(&n.motor[which]));
        let [
            load_constant,
            load_viscous,
            load_coulomb,
            inverse_load,
            load_step,
            load_most,
            stiffness,
            damping,
            give,
        ] = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|which: usize| self.get(&x.rates[which]));
        let (zero, h, current) = (
            self.all(0.0),
            self.get(&n.period),
            [self.get(&x.current[0]), self.get(&x.current[1])],
        );
        let Voltages {
            limited,
            voltage: [_, voltage],
            integral,
            free,
        } = self.current_loop(&Fast {
            gain: self.get(&n.gain),
            share: self.get(&n.share),
            limit_squared: self.get(&n.limit_squared),
            delayed: self.get(&n.delayed),
            command: self.get(&x.command),
            cross: self.mul(self.get(&x.electric_speed), self.get(&n.inductance)),
            back_emf: self.get(&x.back_emf),
            current,
            integral: [self.get(&x.fast_integral[0]), self.get(&x.fast_integral[1])],
            pending: [self.get(&x.pending[0]), self.get(&x.pending[1])],
        });
        let cut = self.choose(limited, self.all(1.0), self.get(&x.cut));
        let sum = self.add(self.get(&x.sum), current[1]);
        let (motor, load, lead) = (
            self.get(&x.motor),
            self.get(&x.load),
            self.get(&x.gap_angle),
        );

        let next = self.mul(
            self.add(
                current[1],
                self.mul(share, self.sub(voltage, self.mul(back_emf, motor))),
            ),
            keep,
        );
        let drive = self.sub(self.mul(constant, next), self.mul(viscous, motor));
        let drag = self.sub(
            self.simd.neg_f64s(load_constant),
            self.mul(load_viscous, load),
        );
        let held = |coulomb, speed| {
            self.both(
                self.less(zero, coulomb),
                self.simd.less_than_or_equal_f64s(self.abs(speed), zero),
            )
        };
        let of_motor = self.choose(held(coulomb, motor), zero, inverse_motor);
        let of_load = self.choose(held(load_coulomb, load), zero, inverse_load);
        let parting = self.mul(
            h,
            self.sub(self.mul(drive, of_motor), self.mul(drag, of_load)),
        );
        let apart = self.add(self.sub(motor, load), parting);
        let ahead = self.add(lead, self.mul(h, apart));
        let pushed = self.add(self.mul(stiffness, ahead), self.mul(damping, apart));
        let torque = self.div(
            pushed,
            self.add(self.all(1.0), self.mul(give, self.add(of_motor, of_load))),
        );
        let [motor, friction] = self.slide(
            motor,
            self.mul(motor_step, self.sub(drive, torque)),
            motor_most,
        );
        let [load, _] = self.slide(load, self.mul(load_step, self.add(torque, drag)), load_most);

        self.put(&mut x.cut, cut);
        self.put(&mut x.sum, sum);
        for which in 0..2 {
            self.put(&mut x.fast_integral[which], integral[which]);
            self.put(&mut x.pending[which], free[which]);
        }
        self.put(&mut x.current[1], next);
        self.put(&mut x.motor, motor);
        self.put(&mut x.load, load);
        self.put(
            &mut x.gap_angle,
            self.add(lead, self.mul(h, self.sub(motor, load))),
        );
        let place = self.add(self.get(&x.place), self.mul(h, load));
        self.put(&mut x.place, place);
        self.put(&mut x.torque, torque);
        self.put(&mut x.friction, self.mul(friction, scale));
    }

    /// See `slide` of the twin.
    #[inline(always)]
    fn slide(self, speed: S::f64s, gain: S::f64s, most: S::f64s) -> [S::f64s; 2] {
        let zero = self.all(0.0);
        let free = self.add(speed, gain);
        let taken = self.clamp(free, self.simd.neg_f64s(most), most);
        let left = self.sub(free, taken);
        let stops = self.less(self.mul(speed, left), zero);
        [
            self.choose(stops, zero, left),
            self.simd.neg_f64s(self.choose(stops, free, taken)),
        ]
    }
}
