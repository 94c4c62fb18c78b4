//! A servo period of all twins: what `Twin::step` does, operation by operation.

use super::current::{Fast, Voltages};
use super::lanes::WIDTH;
use super::tick::{Asked, Commanded, parts};
use super::twins::{Numbers, States, Twins};
use super::vector::Vector;
use pulp::{Simd, WithSimd};

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
            let vector = Vector { simd, part };
            vector.drive(numbers, states);
            for _ in 0..self.periods {
                vector.advance(numbers, states);
            }
        }
    }
}

impl<S: Simd> Vector<S> {
    /// Measuring, position and velocity loop.
    #[inline(always)]
    fn drive(self, n: &Numbers, x: &mut States) {
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
    fn advance(self, n: &Numbers, x: &mut States) {
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
