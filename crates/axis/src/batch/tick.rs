//! The servo tick for all resident lanes: what `Servo::measure` and `Servo::command` do, operation by operation.

use super::lanes::{Lanes, WIDTH};
use super::vector::Vector;
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
    marked.iter().rposition(|marked| *marked).map_or(0, |last| last + 1).div_ceil(S::F64_LANES)
}

impl WithSimd for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for part in 0..parts::<S>(&self.resident) {
            Vector { simd, part }.measure(self.lanes, self.index);
        }
    }
}

impl WithSimd for Command<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for part in 0..parts::<S>(&self.resident) {
            Vector { simd, part }.command(self.lanes, self.index);
        }
    }
}

impl<S: Simd> Vector<S> {
    #[inline(always)]
    fn measure(self, lanes: &mut Lanes, index: usize) {
        let (x, loops) = (&mut lanes.states, &mut lanes.loops);
        let (n, s) = (&loops.numbers, &mut loops.states);
        let (load, current, step) = (self.get(&x.position), self.get(&x.current_q), self.get(&n.encoder_step));
        let place = self.add(load, self.get(&x.gap_angle));
        let counted = self.mul(self.round(self.div(place, step)), step);
        let position = self.choose(self.less(self.all(0.0), step), counted, place);
        let velocity = self.div(self.sub(position, self.get(&s.seen)), self.get(&n.period));
        let change = self.mul(self.all(0.5), self.sub(current, self.get(&s.first)));
        let mean = self.div(self.add(self.get(&x.sum), change), self.get(&n.current_steps));
        let units = self.get(&n.units);
        let reference = self.get(&loops.references[index][0]);
        self.put(&mut s.seen, position);
        self.put(&mut s.first, current);
        self.put(&mut x.sum, self.all(0.0));
        self.put(&mut loops.velocity, velocity);
        self.put(&mut loops.mean_current, mean);
        self.put(&mut loops.shown[index][0], self.mul(load, units));
        self.put(&mut loops.shown[index][1], self.mul(reference, units));
    }

    #[inline(always)]
    fn command(self, lanes: &mut Lanes, index: usize) {
        let (inputs, loops) = (&mut lanes.inputs, &mut lanes.loops);
        let (n, s, c) = (&loops.numbers, &mut loops.states, &loops.correction);
        let (zero, one, period) = (self.all(0.0), self.all(1.0), self.get(&n.period));
        let [position, velocity] = [0, 1].map(|which: usize| self.get(&loops.references[index][which]));
        let next_velocity = self.get(&loops.references[index + 1][1]);
        let measured = self.get(&loops.velocity);
        let mean_velocity = self.div(self.sub(position, self.get(&s.reference)), period);
        let mean_acceleration = self.div(self.sub(next_velocity, velocity), period);
        let seen = self.sub(self.get(&s.seen), self.get(&c[3]));
        let position_error = self.sub(self.add(position, self.get(&c[0])), seen);
        let fed = self.mul(self.get(&n.velocity_feedforward), mean_velocity);
        let wanted = self.add(self.add(self.mul(self.get(&n.position_gain), position_error), fed), self.get(&c[1]));
        let torque = self.add(self.mul(self.get(&n.inertia_feedforward), mean_acceleration), self.get(&c[2]));

        let error = self.sub(wanted, measured);
        let push = self.mul(self.get(&n.velocity_gain), error);
        let integral = self.get(&s.integral);
        let free = self.add(self.add(push, integral), self.div(torque, self.get(&n.torque_constant)));
        let most = self.get(&n.current_limit);
        let least = self.simd.neg_f64s(most);
        let low = self.choose(self.less(free, least), least, free);
        let cut = self.choose(self.less(most, low), most, low);

        let outward = self.less(zero, self.mul(error, cut));
        let held = self.both(self.less(zero, self.get(&s.limited)), outward);
        let gain = self.add(self.choose(held, zero, push), self.sub(cut, free));
        let saturated = self.choose(self.simd.equal_f64s(cut, free), zero, one);
        let electric_speed = self.mul(self.get(&n.pole_pairs), measured);
        let (last, before) = (self.get(&s.command), self.get(&s.earlier[0]));
        self.put(&mut s.integral, self.add(integral, self.mul(self.get(&n.velocity_share), gain)));
        self.put(&mut s.reference, position);
        self.put(&mut s.earlier[0], last);
        self.put(&mut s.earlier[1], before);
        self.put(&mut s.command, cut);
        self.put(&mut s.electric_speed, electric_speed);
        self.put(&mut s.limited, zero);
        self.put(&mut s.saturated, saturated);
        self.put(&mut inputs.command, cut);
        self.put(&mut inputs.cross, self.mul(electric_speed, self.get(&n.inductance)));
        self.put(&mut inputs.back_emf, self.mul(self.get(&n.back_emf), measured));
    }
}
