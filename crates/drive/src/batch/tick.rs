//! The servo tick for all resident lanes: what `Servo::measure` and `Servo::command` do, operation
//! by operation.

use super::lanes::{DriveNumbers, Lanes, WIDTH};
use super::vector::Wide;
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
            Wide { simd, part }.measure(self.lanes, self.index);
        }
    }
}

impl WithSimd for Command<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for part in 0..parts::<S>(&self.resident) {
            Wide { simd, part }.command(self.lanes, self.index);
        }
    }
}

impl<S: Simd> Wide<S> {
    #[inline(always)]
    fn measure(self, lanes: &mut Lanes, index: usize) {
        let (x, loops) = (&mut lanes.states, &mut lanes.loops);
        let (n, s) = (&loops.numbers, &mut loops.states);
        let (load, current, step) = (
            self.get(&x.position),
            self.get(&x.current_q),
            self.get(&n.encoder_step),
        );
        let place = self.add(load, self.get(&x.gap_angle));
        let counted = self.mul(self.round(self.div(place, step)), step);
        let position = self.choose(self.less(self.all(0.0), step), counted, place);
        let velocity = self.div(self.sub(position, self.get(&s.seen)), self.get(&n.period));
        let change = self.mul(self.all(0.5), self.sub(current, self.get(&s.first)));
        let mean = self.div(
            self.add(self.get(&x.sum), change),
            self.get(&n.current_steps),
        );
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
        let [position, velocity] =
            [0, 1].map(|which: usize| self.get(&loops.references[index][which]));
        let measured = self.get(&loops.velocity);
        let asked = Asked {
            position,
            velocity,
            next_velocity: self.get(&loops.references[index + 1][1]),
            last_position: self.get(&s.reference),
            seen: self.get(&s.seen),
            measured,
            correction: [0, 1, 2, 3].map(|which: usize| self.get(&c[which])),
            integral: self.get(&s.integral),
            limited: self.get(&s.limited),
        };
        let Commanded {
            cut,
            free,
            integral,
        } = self.velocity_loop(n, &asked);
        let saturated = self.choose(
            self.simd.equal_f64s(cut, free),
            self.all(0.0),
            self.all(1.0),
        );
        let electric_speed = self.mul(self.get(&n.pole_pairs), measured);
        let (last, before) = (self.get(&s.command), self.get(&s.earlier[0]));
        self.put(&mut s.integral, integral);
        self.put(&mut s.reference, position);
        self.put(&mut s.earlier[0], last);
        self.put(&mut s.earlier[1], before);
        self.put(&mut s.command, cut);
        self.put(&mut s.electric_speed, electric_speed);
        self.put(&mut s.limited, self.all(0.0));
        self.put(&mut s.saturated, saturated);
        self.put(&mut inputs.command, cut);
        self.put(
            &mut inputs.cross,
            self.mul(electric_speed, self.get(&n.inductance)),
        );
        self.put(
            &mut inputs.back_emf,
            self.mul(self.get(&n.back_emf), measured),
        );
    }

    /// Position and velocity loop of a plain drive: what `VelocityState::command` computes.
    #[inline(always)]
    pub(super) fn velocity_loop(
        self,
        n: &DriveNumbers,
        asked: &Asked<S::f64s>,
    ) -> Commanded<S::f64s> {
        let (zero, period, c) = (self.all(0.0), self.get(&n.period), &asked.correction);
        let mean_velocity = self.div(self.sub(asked.position, asked.last_position), period);
        let mean_acceleration = self.div(self.sub(asked.next_velocity, asked.velocity), period);
        let position_error = self.sub(self.add(asked.position, c[0]), self.sub(asked.seen, c[3]));
        let fed = self.mul(self.get(&n.velocity_feedforward), mean_velocity);
        let wanted = self.add(
            self.add(self.mul(self.get(&n.position_gain), position_error), fed),
            c[1],
        );
        let torque = self.add(
            self.mul(self.get(&n.inertia_feedforward), mean_acceleration),
            c[2],
        );

        let error = self.sub(wanted, asked.measured);
        let push = self.mul(self.get(&n.velocity_gain), error);
        let free = self.add(
            self.add(push, asked.integral),
            self.div(torque, self.get(&n.torque_constant)),
        );
        let most = self.get(&n.current_limit);
        let cut = self.clamp(free, self.simd.neg_f64s(most), most);

        let outward = self.less(zero, self.mul(error, cut));
        let held = self.both(self.less(zero, asked.limited), outward);
        let gain = self.add(self.choose(held, zero, push), self.sub(cut, free));
        Commanded {
            cut,
            free,
            integral: self.add(asked.integral, self.mul(self.get(&n.velocity_share), gain)),
        }
    }
}

/// What position and velocity loop see at a tick.
#[derive(Clone, Copy)]
pub(super) struct Asked<V> {
    pub(super) position: V,
    pub(super) velocity: V,
    pub(super) next_velocity: V,
    pub(super) last_position: V,
    /// Encoder position, and its difference over the period.
    pub(super) seen: V,
    pub(super) measured: V,
    /// Position, velocity, torque and feedback of the correction.
    pub(super) correction: [V; 4],
    pub(super) integral: V,
    pub(super) limited: V,
}

/// What they answer: the current command, what it would be without a limit, and the integral.
#[derive(Clone, Copy)]
pub(super) struct Commanded<V> {
    pub(super) cut: V,
    pub(super) free: V,
    pub(super) integral: V,
}

// The current loops over a period, for axes and for the models of compensators.

/// What the current loops compute with, d before q.
#[derive(Clone, Copy)]
pub(super) struct Fast<V> {
    pub(super) gain: V,
    pub(super) share: V,
    pub(super) limit_squared: V,
    pub(super) delayed: V,
    pub(super) command: V,
    pub(super) cross: V,
    pub(super) back_emf: V,
    pub(super) current: [V; 2],
    pub(super) integral: [V; 2],
    pub(super) pending: [V; 2],
}

/// What they answer: where the voltage would be cut, the voltages applied, the next integrals, the
/// voltages computed.
#[derive(Clone, Copy)]
pub(super) struct Voltages<V, M> {
    pub(super) limited: M,
    pub(super) voltage: [V; 2],
    pub(super) integral: [V; 2],
    pub(super) free: [V; 2],
}

impl<S: Simd> Wide<S> {
    /// The current loops over a period: what `CurrentState::voltage` computes as long as no voltage
    /// is cut.
    #[inline(always)]
    pub(super) fn current_loop(self, x: &Fast<S::f64s>) -> Voltages<S::f64s, S::m64s> {
        let [current_d, current_q] = x.current;
        let error_d = self.simd.neg_f64s(current_d);
        let error_q = self.sub(x.command, current_q);
        let (push_d, push_q) = (self.mul(x.gain, error_d), self.mul(x.gain, error_q));
        let free_d = self.sub(
            self.add(push_d, x.integral[0]),
            self.mul(x.cross, current_q),
        );
        let free_q = self.add(
            self.add(
                self.add(push_q, x.integral[1]),
                self.mul(x.cross, current_d),
            ),
            x.back_emf,
        );
        let size = self.add(self.mul(free_d, free_d), self.mul(free_q, free_q));
        let delayed = self.less(self.all(0.0), x.delayed);
        let next = |integral, push, free| {
            self.add(
                integral,
                self.mul(x.share, self.add(push, self.sub(free, free))),
            )
        };
        Voltages {
            limited: self.less(x.limit_squared, size),
            voltage: [
                self.choose(delayed, x.pending[0], free_d),
                self.choose(delayed, x.pending[1], free_q),
            ],
            integral: [
                next(x.integral[0], push_d, free_d),
                next(x.integral[1], push_q, free_q),
            ],
            free: [free_d, free_q],
        }
    }
}
