//! One period of the current loop for all lanes: what `servo::current` and `plant::step` do,
//! operation by operation.
//!
//! Every expression has the operands and the order of its scalar original, and products and sums
//! stay apart, so each lane's bits are those of the single axis. A lane that is reported back has
//! been left as it was.

use super::lanes::{Lanes, PeriodNumbers, Row, WIDTH};
use super::tick::{Fast, Voltages, parts};
use super::vector::Wide;
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
        let Periods {
            lanes,
            from,
            to,
            active,
        } = self;
        let parts = parts::<S>(&active);
        for period in from..to {
            let mut stopped = [false; WIDTH];
            let mut any = false;
            for part in 0..parts {
                any |= Wide { simd, part }.period(lanes, &active, &mut stopped);
            }
            if any {
                return Some(Stop {
                    period,
                    lanes: stopped,
                });
            }
        }
        None
    }
}

impl<S: Simd> Wide<S> {
    /// One period; whether a lane has to step by itself, and which.
    #[inline(always)]
    fn period(
        self,
        lanes: &mut Lanes,
        active: &[bool; WIDTH],
        stopped: &mut [bool; WIDTH],
    ) -> bool {
        let (s, inputs, n) = (&lanes.states, &lanes.inputs, &lanes.numbers);
        let zero = self.simd.splat_f64s(0.0);
        let (current_q, current_d, motor) = (
            self.get(&s.current_q),
            self.get(&s.current_d),
            self.get(&s.motor),
        );

        let voltages = self.current_loop(&Fast {
            gain: self.get(&n.gain),
            share: self.get(&n.share),
            limit_squared: self.get(&n.limit_squared),
            delayed: self.get(&n.delayed),
            command: self.get(&inputs.command),
            cross: self.get(&inputs.cross),
            back_emf: self.get(&inputs.back_emf),
            current: [current_d, current_q],
            integral: [self.get(&s.integral_d), self.get(&s.integral_q)],
            pending: [self.get(&s.pending_d), self.get(&s.pending_q)],
        });
        let Voltages {
            limited,
            voltage: [voltage_d, voltage_q],
            integral,
            free,
        } = voltages;

        // the plant
        let coupling = self.mul(
            self.mul(self.get(&n.pole_pairs), motor),
            self.get(&n.inductance),
        );
        let held_voltage = self.sub(voltage_q, self.mul(coupling, current_d));
        let held_load = self.get(&inputs.load_torque);
        let drive_d = self.add(voltage_d, self.mul(coupling, current_q));
        let next_d = self.add(
            self.mul(self.get(&n.decay_d), current_d),
            self.mul(self.get(&n.gain_d), drive_d),
        );
        let offset = self.get(&n.offset);
        let before = [
            current_q,
            self.sub(self.get(&s.gap_angle), offset),
            motor,
            self.get(&s.load),
        ];
        let against = [
            self.get(&n.friction[0]),
            self.add(self.get(&n.friction[1]), held_load),
        ];
        let sources = [
            before[0],
            before[1],
            before[2],
            before[3],
            held_voltage,
            against[0],
            against[1],
        ];
        let (mut after, mut travel) = ([zero; 4], zero);
        for (index, source) in sources.into_iter().enumerate() {
            let column = &n.columns[index];
            for row in 0..4 {
                after[row] = self.add(after[row], self.mul(self.get(&column[row]), source));
            }
            travel = self.add(travel, self.mul(self.get(&n.travel[index]), source));
        }

        // the look for events
        let mut quiet = self.both(
            self.contact(n, &before, &after),
            self.sliding(n, &before, &after),
        );
        if lanes.any_pushing {
            quiet = self.both(quiet, self.pushing(n, &before, &after));
        }
        if lanes.any_stuck {
            quiet = self.both(quiet, self.standing(n, &before, &after, held_load));
        }
        let one = self.simd.splat_f64s(1.0);
        let fine = self
            .simd
            .select_f64s(limited, zero, self.simd.select_f64s(quiet, one, zero));
        let any = self.stop(fine, active, stopped);

        let next_sum = self.add(self.get(&s.sum), current_q);
        let next_position = self.add(self.get(&s.position), travel);
        let next_gap = self.add(after[1], offset);
        let (peak, size) = (self.get(&s.peak), self.abs(after[0]));
        let next_peak = self.simd.select_f64s(self.less(peak, size), size, peak);
        let keep = if any {
            Some(self.less(fine, one))
        } else {
            None
        };
        let s = &mut lanes.states;
        self.store(keep, &mut s.current_q, after[0]);
        self.store(keep, &mut s.current_d, next_d);
        self.store(keep, &mut s.gap_angle, next_gap);
        self.store(keep, &mut s.motor, after[2]);
        self.store(keep, &mut s.load, after[3]);
        self.store(keep, &mut s.position, next_position);
        self.store(keep, &mut s.integral_d, integral[0]);
        self.store(keep, &mut s.integral_q, integral[1]);
        self.store(keep, &mut s.pending_d, free[0]);
        self.store(keep, &mut s.pending_q, free[1]);
        self.store(keep, &mut s.sum, next_sum);
        self.store(keep, &mut s.peak, next_peak);
        any
    }

    /// Stores a value but in the lanes that keep theirs.
    #[inline(always)]
    fn store(self, keep: Option<S::m64s>, row: &mut Row, value: S::f64s) {
        let value = match keep {
            Some(keep) => self.simd.select_f64s(keep, self.get(row), value),
            None => value,
        };
        self.put(row, value);
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
    fn contact(self, n: &PeriodNumbers, before: &[S::f64s; 4], after: &[S::f64s; 4]) -> S::m64s {
        let third = self.get(&n.third);
        let (rise, fall) = (
            self.mul(self.sub(before[2], before[3]), third),
            self.mul(self.sub(after[2], after[3]), third),
        );
        let (low, high) = (self.get(&n.range[0]), self.get(&n.range[1]));
        let ends = self.both(
            self.within(low, before[1], high),
            self.within(low, after[1], high),
        );
        let inner = self.both(
            self.within(low, self.add(before[1], rise), high),
            self.within(low, self.sub(after[1], fall), high),
        );
        self.both(ends, inner)
    }

    #[inline(always)]
    fn within(self, low: S::f64s, x: S::f64s, high: S::f64s) -> S::m64s {
        self.both(
            self.simd.less_than_or_equal_f64s(low, x),
            self.simd.less_than_or_equal_f64s(x, high),
        )
    }

    /// Spring exceeds damping at both ends.
    #[inline(always)]
    fn pushing(self, n: &PeriodNumbers, before: &[S::f64s; 4], after: &[S::f64s; 4]) -> S::m64s {
        let (a, b) = (self.spare(n, before), self.spare(n, after));
        let least = self.add(self.abs(self.sub(a, b)), self.get(&n.push_margin));
        self.both(self.less(least, a), self.less(least, b))
    }

    #[inline(always)]
    fn spare(self, n: &PeriodNumbers, x: &[S::f64s; 4]) -> S::f64s {
        let damping = self.mul(self.get(&n.push[1]), self.abs(self.sub(x[2], x[3])));
        self.sub(self.mul(self.get(&n.push[0]), x[1]), damping)
    }

    /// No sliding mass comes near to rest.
    #[inline(always)]
    fn sliding(self, n: &PeriodNumbers, before: &[S::f64s; 4], after: &[S::f64s; 4]) -> S::m64s {
        self.both(
            self.slides(n, 0, before[2], after[2]),
            self.slides(n, 1, before[3], after[3]),
        )
    }

    #[inline(always)]
    fn slides(self, n: &PeriodNumbers, mass: usize, from: S::f64s, to: S::f64s) -> S::m64s {
        let sign = self.get(&n.sliding[mass]);
        let least = self.add(
            self.abs(self.sub(to, from)),
            self.get(&n.speed_margin[mass]),
        );
        self.both(
            self.less(least, self.mul(sign, from)),
            self.less(least, self.mul(sign, to)),
        )
    }

    /// No standing mass comes near to breaking away.
    #[inline(always)]
    fn standing(
        self,
        n: &PeriodNumbers,
        before: &[S::f64s; 4],
        after: &[S::f64s; 4],
        held_load: S::f64s,
    ) -> S::m64s {
        let constant = self.get(&n.torque_constant);
        let (contact, then) = (
            self.contact_torque(n, before),
            self.contact_torque(n, after),
        );
        let motor = [
            self.sub(self.mul(constant, before[0]), contact),
            self.sub(self.mul(constant, after[0]), then),
        ];
        let load = [self.sub(contact, held_load), self.sub(then, held_load)];
        self.both(
            self.holds(n, 0, motor[0], motor[1]),
            self.holds(n, 1, load[0], load[1]),
        )
    }

    #[inline(always)]
    fn contact_torque(self, n: &PeriodNumbers, x: &[S::f64s; 4]) -> S::f64s {
        self.add(
            self.mul(self.get(&n.shaft[0]), x[1]),
            self.mul(self.get(&n.shaft[1]), self.sub(x[2], x[3])),
        )
    }

    #[inline(always)]
    fn holds(self, n: &PeriodNumbers, mass: usize, a: S::f64s, b: S::f64s) -> S::m64s {
        let (limit, margin, change) = (
            self.get(&n.holding[mass]),
            self.get(&n.torque_margin),
            self.abs(self.sub(a, b)),
        );
        let (size, other) = (self.abs(a), self.abs(b));
        let below = self.less(self.add(self.add(size, change), margin), limit);
        let still = self.less(self.add(self.add(other, change), margin), limit);
        let same = self.both(self.simd.equal_f64s(a, b), self.less(size, limit));
        self.simd.or_m64s(self.both(below, still), same)
    }
}
