//! The servo tick for all resident lanes: the laws of measuring and of position and velocity loop
//! on vectors.

use super::lanes::{Lanes, WIDTH};
use super::vector::{Part, Reach};
use crate::servo::{PlainDrive, VelocityInput, VelocityOutput, counted};
use lostmotion_base::Number;
use pulp::{Simd, WithSimd};

/// Reads the encoders, and writes down where loads and references are.
pub(super) struct Measure<'a> {
    pub(super) lanes: &'a mut Lanes,
    pub(super) index: usize,
    pub(super) resident: [bool; WIDTH],
}

/// Position and velocity loop: the current commands.
pub(super) struct Command<'a> {
    pub(super) lanes: &'a mut Lanes,
    pub(super) index: usize,
    pub(super) resident: [bool; WIDTH],
}

/// Vectors that hold all marked lanes.
pub(super) fn parts<S: Simd>(marked: &[bool; WIDTH]) -> usize {
    marked
        .iter()
        .rposition(|marked| *marked)
        .map_or(0, |last| last + 1)
        .div_ceil(S::F64_LANES)
}

impl WithSimd for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for part in 0..parts::<S>(&self.resident) {
            Part { simd, part }.measure(self.lanes, self.index);
        }
    }
}

impl WithSimd for Command<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for part in 0..parts::<S>(&self.resident) {
            Part { simd, part }.command(self.lanes, self.index);
        }
    }
}

impl<S: Simd> Part<S> {
    #[inline(always)]
    fn measure(self, lanes: &mut Lanes, index: usize) {
        let (x, loops) = (&mut lanes.states, &mut lanes.loops);
        let (numbers, s) = (loops.numbers.map(|row| self.get(row)), &mut loops.states);
        let (load, current) = (self.get(&x.position), self.get(&x.current_q));
        // the encoder sits on the motor: load and gap angle, in whole counts
        let position = counted(load + self.get(&x.gap_angle), numbers.encoder_step);
        let velocity = numbers.speed(position, self.get(&s.seen));
        // the sum is read before it starts anew for the coming servo period
        let mean = numbers.mean_current(self.get(&x.sum), self.get(&s.first), current);
        let units = self.get(&loops.units);
        let reference = self.get(&loops.references[index][0]);
        self.put(&mut s.seen, position);
        self.put(&mut s.first, current);
        self.put(&mut x.sum, self.all(0.0));
        self.put(&mut loops.velocity, velocity);
        let direct = self.get(&x.current_d);
        let squares = self.get(&loops.current_squares) + (direct * direct + current * current);
        self.put(&mut loops.mean_current, mean);
        self.put(&mut loops.current_squares, squares);
        // at the boundary everything is in the axis' unit
        self.put(&mut loops.shown[index][0], load * units);
        self.put(&mut loops.shown[index][1], reference * units);
    }

    #[inline(always)]
    fn command(self, lanes: &mut Lanes, index: usize) {
        let inductance = self.get(&lanes.numbers.current_loop.inductance);
        let (inputs, loops) = (&mut lanes.inputs, &mut lanes.loops);
        let (s, c) = (&mut loops.states, &loops.correction);
        let numbers = loops.numbers.map(|row| self.get(row));
        // there is one row more than ticks, so the reference a tick ahead always exists
        let [position, velocity] = &loops.references[index];
        let (position, velocity) = (self.get(position), self.get(velocity));
        let (zero, measured) = (self.all(0.0), self.get(&loops.velocity));
        let seen = VelocityInput {
            position,
            velocity,
            next_velocity: self.get(&loops.references[index + 1][1]),
            last_position: self.get(&s.reference),
            measured_position: self.get(&s.seen),
            measured_velocity: measured,
            // written out: closures of `map` are at times not compiled for the vectors
            correction: [
                self.get(&c[0]),
                self.get(&c[1]),
                self.get(&c[2]),
                self.get(&c[3]),
            ],
            integral: self.get(&s.integral),
            voltage_limited: zero.less(self.get(&s.limited)),
        };
        let VelocityOutput {
            command,
            within_limit,
            integral,
        } = numbers.command(&seen, &mut PlainDrive);
        // the voltages that rise with speed are held over the servo period, as in the drive of one
        // axis
        let electric_speed = numbers.pole_pairs * measured;
        let (last, before) = (self.get(&s.command), self.get(&s.earlier[0]));
        self.put(&mut s.integral, integral);
        self.put(&mut s.reference, position);
        self.put(&mut s.earlier[0], last);
        self.put(&mut s.earlier[1], before);
        self.put(&mut s.command, command);
        self.put(&mut s.electric_speed, electric_speed);
        // a cut voltage is reported anew in each servo period
        self.put(&mut s.limited, zero);
        self.put(&mut s.saturated, zero.unless(within_limit));
        self.put(&mut inputs.command, command);
        self.put(&mut inputs.cross, electric_speed * inductance);
        self.put(&mut inputs.back_emf, numbers.back_emf * measured);
    }
}
