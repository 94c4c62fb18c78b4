//! One period of the current loop for all lanes: the laws of the drive's current loop and of the
//! plant's exact step on vectors. A lane in whose period something happens that is not a product
//! with a table is reported back and left as it was.

use super::lanes::{Lanes, PeriodNumbers, Row, WIDTH};
use super::tick::parts;
use super::vector::{Part, Reach};
use crate::plant::{
    exact_step, keeps_pushing, keeps_sliding, keeps_standing, shaft_torque, stays_within,
};
use crate::servo::{CurrentOutput, CurrentPeriod};
use lostmotion_base::Number;
use lostmotion_base::{Wide, WideMask};
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
        // vectors behind the last active lane are left out
        let parts = parts::<S>(&active);
        for period in from..to {
            let mut stopped = [false; WIDTH];
            let mut any = false;
            for part in 0..parts {
                any |= Part { simd, part }.period(lanes, &active, &mut stopped);
            }
            // no lane may go on to the next period before those that stopped have taken this one:
            // they share the count of periods
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

impl<S: Simd> Part<S> {
    /// One period; whether a lane has to step by itself, and which.
    #[inline(always)]
    fn period(
        self,
        lanes: &mut Lanes,
        active: &[bool; WIDTH],
        stopped: &mut [bool; WIDTH],
    ) -> bool {
        let (s, inputs, n) = (&lanes.states, &lanes.inputs, &lanes.numbers);
        let (current_q, current_d, motor) = (
            self.get(&s.current_q),
            self.get(&s.current_d),
            self.get(&s.motor),
        );

        // the voltages
        let current_loop = n.current_loop.map(|row| self.get(row));
        let period = CurrentPeriod {
            command: self.get(&inputs.command),
            cross: self.get(&inputs.cross),
            back_emf: self.get(&inputs.back_emf),
            current: [current_d, current_q],
            integral: [self.get(&s.integral_d), self.get(&s.integral_q)],
            pending: [self.get(&s.pending_d), self.get(&s.pending_q)],
        };
        let free = current_loop.free_voltage(&period);
        // cutting the vector takes a root and a choice of d before q: a lane at its limit takes the
        // period by itself
        let limited = current_loop.exceeds_limit(free);
        let CurrentOutput { voltage, integral } = current_loop.output(&period, free, free);

        // the plant's exact step in the mode of each lane
        let (held_voltage, next_d) =
            n.electric
                .map(|row| self.get(row))
                .step(motor, [current_d, current_q], voltage);
        let held_load = self.get(&inputs.load_torque);
        let offset = self.get(&n.offset);
        let before = [
            current_q,
            self.get(&s.gap_angle) - offset,
            motor,
            self.get(&s.load),
        ];
        let (after, travel) = exact_step(
            |column, row| self.get(&n.columns[column][row]),
            |column| self.get(&n.travel[column]),
            [
                before[0],
                before[1],
                before[2],
                before[3],
                held_voltage,
                self.get(&n.friction[0]),
                self.get(&n.friction[1]) + held_load,
            ],
        );

        // the look for events
        let mut quiet = stays_within(
            [self.get(&n.range[0]), self.get(&n.range[1])],
            self.get(&n.third),
            &before,
            &after,
        );
        if lanes.any_pushing {
            quiet = quiet
                & keeps_pushing(
                    self.get(&n.push[0]),
                    self.get(&n.push[1]),
                    self.get(&n.push_margin),
                    &before,
                    &after,
                );
        }
        let mut same =
            self.sliding(n, 0, [before[2], after[2]]) & self.sliding(n, 1, [before[3], after[3]]);
        if lanes.any_stuck {
            same = same & self.standing(n, &before, &after, held_load);
        }
        let (zero, one) = (self.all(0.0), self.all(1.0));
        // near rest and near breaking away the cubics tell more
        if !Wide::none(one.flag(same).less(one)) {
            let friction = [
                self.get(&n.friction[0]),
                self.get(&n.friction[1]) + held_load,
            ];
            let held = (held_voltage, friction, held_load);
            let ends = [&before, &after];
            same = same
                | (n.watches[0].keeps(|row| self.get(row), ends, held)
                    & n.watches[1].keeps(|row| self.get(row), ends, held));
        }
        quiet = quiet & same;
        let fine = Wide::choose(limited, zero, one.flag(quiet));
        let any = self.stop(fine, active, stopped);

        // i_q at the start of the period, as the current loop of one axis sums it for its mean
        let next_sum = self.get(&s.sum) + current_q;
        let next_position = self.get(&s.position) + travel;
        let next_gap = after[1] + offset;
        // the peak looks at the end of the period
        let (peak, size) = (self.get(&s.peak), after[0].abs());
        let next_peak = Wide::choose(peak.less(size), size, peak);
        // lanes that stop keep the state before the period
        let keep = if any { Some(fine.less(one)) } else { None };
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
    fn store(self, keep: Option<WideMask<S>>, row: &mut Row, value: Wide<S>) {
        let value = match keep {
            Some(keep) => Wide::choose(keep, self.get(row), value),
            None => value,
        };
        self.put(row, value);
    }

    /// Marks the active lanes that are not fine.
    #[inline(always)]
    fn stop(self, fine: Wide<S>, active: &[bool; WIDTH], stopped: &mut [bool; WIDTH]) -> bool {
        // nearly every period: nothing happens in any lane
        if Wide::none(fine.less(self.all(1.0))) {
            return false;
        }
        let mut row = Row([1.0; WIDTH]);
        self.put(&mut row, fine);
        let mut any = false;
        for ((stop, fine), active) in stopped.iter_mut().zip(row.0).zip(active) {
            // lanes that are not stepped here may hold anything
            let stops = *active && fine < 1.0;
            *stop |= stops;
            any |= stops;
        }
        any
    }

    /// Whether a mass that slides comes near to rest.
    #[inline(always)]
    fn sliding(self, n: &PeriodNumbers, mass: usize, speed: [Wide<S>; 2]) -> WideMask<S> {
        keeps_sliding(
            self.get(&n.sliding[mass]),
            self.get(&n.speed_margin[mass]),
            speed,
        )
    }

    /// Whether no standing mass comes near to breaking away.
    #[inline(always)]
    fn standing(
        self,
        n: &PeriodNumbers,
        before: &[Wide<S>; 4],
        after: &[Wide<S>; 4],
        held_load: Wide<S>,
    ) -> WideMask<S> {
        let constant = self.get(&n.torque_constant);
        let shaft = (self.get(&n.shaft[0]), self.get(&n.shaft[1]));
        let (contact, then) = (shaft_torque(shaft, before), shaft_torque(shaft, after));
        let margin = self.get(&n.torque_margin);
        // torque that friction has to balance: at the motor the current's less the shaft's, at the
        // load the shaft's less what is held against it
        keeps_standing(
            self.get(&n.holding[0]),
            margin,
            constant * before[0] - contact,
            constant * after[0] - then,
        ) & keeps_standing(
            self.get(&n.holding[1]),
            margin,
            contact - held_load,
            then - held_load,
        )
    }
}
