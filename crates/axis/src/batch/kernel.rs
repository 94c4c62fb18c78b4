//! One period of the current loop for all lanes: what `servo::current` and `plant::step` do, operation by operation.
//!
//! Every expression has the operands and the order of its scalar original, and products and sums stay apart, so each lane's bits are those
//! of the single axis. A lane that is reported back has been left as it was.

use super::lanes::{Lanes, Numbers, Row, WIDTH};
use pulp::{Simd, WithSimd};

/// Takes periods from `from` until one in which a lane has to step by itself.
pub(super) struct Periods<'a> {
    pub(super) lanes: &'a mut Lanes,
    pub(super) from: u32,
    pub(super) to: u32,
    /// Lanes that are stepped here; others are computed along and ignored.
    pub(super) active: [bool; WIDTH],
}

/// A period in which some lanes have to step by themselves.
pub(super) struct Stop {
    pub(super) period: u32,
    pub(super) lanes: [bool; WIDTH],
}

impl WithSimd for Periods<'_> {
    type Output = Option<Stop>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<Stop> {
        let Periods { lanes, from, to, active } = self;
        for period in from..to {
            let mut stopped = [false; WIDTH];
            let mut any = false;
            for part in 0..WIDTH / S::F64_LANES {
                any |= Kernel { simd, part }.period(lanes, &active, &mut stopped);
            }
            if any {
                return Some(Stop { period, lanes: stopped });
            }
        }
        None
    }
}

/// Arithmetic on one vector of the rows.
#[derive(Clone, Copy)]
struct Kernel<S: Simd> {
    simd: S,
    part: usize,
}

impl<S: Simd> Kernel<S> {
    #[inline(always)]
    fn get(self, row: &Row) -> S::f64s {
        S::as_simd_f64s(&row.0).0[self.part]
    }

    #[inline(always)]
    fn put(self, row: &mut Row, value: S::f64s) {
        S::as_mut_simd_f64s(&mut row.0).0[self.part] = value;
    }

    #[inline(always)]
    fn add(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.simd.add_f64s(a, b)
    }

    #[inline(always)]
    fn sub(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.simd.sub_f64s(a, b)
    }

    #[inline(always)]
    fn mul(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.simd.mul_f64s(a, b)
    }

    #[inline(always)]
    fn abs(self, a: S::f64s) -> S::f64s {
        self.simd.abs_f64s(a)
    }

    #[inline(always)]
    fn less(self, a: S::f64s, b: S::f64s) -> S::m64s {
        self.simd.less_than_f64s(a, b)
    }

    #[inline(always)]
    fn both(self, a: S::m64s, b: S::m64s) -> S::m64s {
        self.simd.and_m64s(a, b)
    }

    /// One period; whether a lane has to step by itself, and which.
    #[inline(always)]
    fn period(self, lanes: &mut Lanes, active: &[bool; WIDTH], stopped: &mut [bool; WIDTH]) -> bool {
        let (s, inputs, n) = (&lanes.states, &lanes.inputs, &lanes.numbers);
        let zero = self.simd.splat_f64s(0.0);
        let (current_q, current_d, motor) = (self.get(&s.current_q), self.get(&s.current_d), self.get(&s.motor));

        // the current loops
        let (gain, share, cross) = (self.get(&n.gain), self.get(&n.share), self.get(&inputs.cross));
        let error_d = self.simd.neg_f64s(current_d);
        let error_q = self.sub(self.get(&inputs.command), current_q);
        let (push_d, push_q) = (self.mul(gain, error_d), self.mul(gain, error_q));
        let (integral_d, integral_q) = (self.get(&s.integral_d), self.get(&s.integral_q));
        let free_d = self.sub(self.add(push_d, integral_d), self.mul(cross, current_q));
        let free_q = self.add(self.add(self.add(push_q, integral_q), self.mul(cross, current_d)), self.get(&inputs.back_emf));
        let size = self.add(self.mul(free_d, free_d), self.mul(free_q, free_q));
        let limited = self.less(self.get(&n.limit_squared), size);
        let delayed = self.less(zero, self.get(&n.delayed));
        let voltage_d = self.simd.select_f64s(delayed, self.get(&s.pending_d), free_d);
        let voltage_q = self.simd.select_f64s(delayed, self.get(&s.pending_q), free_q);
        let next_integral_d = self.add(integral_d, self.mul(share, self.add(push_d, self.sub(free_d, free_d))));
        let next_integral_q = self.add(integral_q, self.mul(share, self.add(push_q, self.sub(free_q, free_q))));

        // the plant
        let coupling = self.mul(self.mul(self.get(&n.pole_pairs), motor), self.get(&n.inductance));
        let held_voltage = self.sub(voltage_q, self.mul(coupling, current_d));
        let held_load = self.get(&inputs.load_torque);
        let drive_d = self.add(voltage_d, self.mul(coupling, current_q));
        let next_d = self.add(self.mul(self.get(&n.decay_d), current_d), self.mul(self.get(&n.gain_d), drive_d));
        let offset = self.get(&n.offset);
        let before = [current_q, self.sub(self.get(&s.gap_angle), offset), motor, self.get(&s.load)];
        let against = [self.get(&n.friction[0]), self.add(self.get(&n.friction[1]), held_load)];
        let sources = [before[0], before[1], before[2], before[3], held_voltage, against[0], against[1]];
        let (mut after, mut travel) = ([zero; 4], zero);
        for ((column, along), source) in n.columns.iter().zip(&n.travel).zip(sources) {
            for (sum, entry) in after.iter_mut().zip(column) {
                *sum = self.add(*sum, self.mul(self.get(entry), source));
            }
            travel = self.add(travel, self.mul(self.get(along), source));
        }

        // the look for events
        let mut quiet = self.both(self.contact(n, &before, &after), self.sliding(n, &before, &after));
        if lanes.any_pushing {
            quiet = self.both(quiet, self.pushing(n, &before, &after));
        }
        if lanes.any_stuck {
            quiet = self.both(quiet, self.standing(n, &before, &after, held_load));
        }
        let one = self.simd.splat_f64s(1.0);
        let fine = self.simd.select_f64s(limited, zero, self.simd.select_f64s(quiet, one, zero));
        let any = self.stop(fine, active, stopped);

        let next_position = self.add(self.get(&s.position), travel);
        let next_gap = self.add(after[1], offset);
        let (peak, size) = (self.get(&s.peak), self.abs(after[0]));
        let next_peak = self.simd.select_f64s(self.less(peak, size), size, peak);
        let s = &mut lanes.states;
        let next = [
            (&mut s.current_q, after[0]),
            (&mut s.current_d, next_d),
            (&mut s.gap_angle, next_gap),
            (&mut s.motor, after[2]),
            (&mut s.load, after[3]),
            (&mut s.position, next_position),
            (&mut s.integral_d, next_integral_d),
            (&mut s.integral_q, next_integral_q),
            (&mut s.pending_d, free_d),
            (&mut s.pending_q, free_q),
            (&mut s.peak, next_peak),
        ];
        let keep = self.less(fine, one);
        for (row, value) in next {
            let value = if any { self.simd.select_f64s(keep, self.get(row), value) } else { value };
            self.put(row, value);
        }
        any
    }

    /// Marks the active lanes that are not fine.
    #[inline(always)]
    fn stop(self, fine: S::f64s, active: &[bool; WIDTH], stopped: &mut [bool; WIDTH]) -> bool {
        let one = self.simd.splat_f64s(1.0);
        if self.simd.first_true_m64s(self.less(fine, one)) == S::F64_LANES {
            return false;
        }
        let mut row = Row([1.0; WIDTH]);
        self.put(&mut row, fine);
        let mut any = false;
        for ((stop, fine), active) in stopped.iter_mut().zip(row.0).zip(active) {
            let stops = *active && fine < 1.0;
            *stop |= stops;
            any |= stops;
        }
        any
    }

    /// See `plant::quiet`: the penetration's cubic stays in its range.
    #[inline(always)]
    fn contact(self, n: &Numbers, before: &[S::f64s; 4], after: &[S::f64s; 4]) -> S::m64s {
        let third = self.get(&n.third);
        let slope = |x: &[S::f64s; 4]| self.mul(self.sub(x[2], x[3]), third);
        let places = [before[1], after[1], self.add(before[1], slope(before)), self.sub(after[1], slope(after))];
        let (low, high) = (self.get(&n.range[0]), self.get(&n.range[1]));
        let inside = |x: S::f64s| self.both(self.simd.less_than_or_equal_f64s(low, x), self.simd.less_than_or_equal_f64s(x, high));
        let [a, b, c, d] = places.map(inside);
        self.both(self.both(a, b), self.both(c, d))
    }

    /// Spring exceeds damping at both ends.
    #[inline(always)]
    fn pushing(self, n: &Numbers, before: &[S::f64s; 4], after: &[S::f64s; 4]) -> S::m64s {
        let (stiffness, damping) = (self.get(&n.push[0]), self.get(&n.push[1]));
        let spare = |x: &[S::f64s; 4]| self.sub(self.mul(stiffness, x[1]), self.mul(damping, self.abs(self.sub(x[2], x[3]))));
        let (a, b) = (spare(before), spare(after));
        let least = self.add(self.abs(self.sub(a, b)), self.get(&n.push_margin));
        self.both(self.less(least, a), self.less(least, b))
    }

    /// No sliding mass comes near to rest.
    #[inline(always)]
    fn sliding(self, n: &Numbers, before: &[S::f64s; 4], after: &[S::f64s; 4]) -> S::m64s {
        let [motor, load] = [0, 1].map(|mass| {
            let (sign, from, to) = (self.get(&n.sliding[mass]), before[2 + mass], after[2 + mass]);
            let least = self.add(self.abs(self.sub(to, from)), self.get(&n.speed_margin[mass]));
            self.both(self.less(least, self.mul(sign, from)), self.less(least, self.mul(sign, to)))
        });
        self.both(motor, load)
    }

    /// No standing mass comes near to breaking away.
    #[inline(always)]
    fn standing(self, n: &Numbers, before: &[S::f64s; 4], after: &[S::f64s; 4], held_load: S::f64s) -> S::m64s {
        let (stiffness, damping) = (self.get(&n.shaft[0]), self.get(&n.shaft[1]));
        let (constant, margin) = (self.get(&n.torque_constant), self.get(&n.torque_margin));
        let contact = |x: &[S::f64s; 4]| self.add(self.mul(stiffness, x[1]), self.mul(damping, self.sub(x[2], x[3])));
        let motor = |x: &[S::f64s; 4]| self.sub(self.mul(constant, x[0]), contact(x));
        let load = |x: &[S::f64s; 4]| self.sub(contact(x), held_load);
        let holds = |a: S::f64s, b: S::f64s, limit: &Row| {
            let (limit, change) = (self.get(limit), self.abs(self.sub(a, b)));
            let below = |x: S::f64s| self.less(self.add(self.add(self.abs(x), change), margin), limit);
            let same = self.both(self.simd.equal_f64s(a, b), self.less(self.abs(a), limit));
            self.simd.or_m64s(self.both(below(a), below(b)), same)
        };
        let motor_holds = holds(motor(before), motor(after), &n.holding[0]);
        self.both(motor_holds, holds(load(before), load(after), &n.holding[1]))
    }
}
