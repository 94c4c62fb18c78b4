//! Where the load would be without a correction, and with it: what the control needs to say whether
//! correcting makes the contour better.
//!
//! The drive knows its load and its gap once they are learned. Without a correction the load is a
//! mass with friction between two flanks that go with the motor; contact is taken to be inelastic:
//! ```text
//! free     w' = w - h (b_L w + T_const + T_f sign(w))/J_L,   x' = x + h w'        to rest at most
//! contact  x' = theta_M -+ b where it would be beyond, w' = w_M                    b: half gap, rad
//! shown    x - T/k                                                                T: shaft of the gapless twin, N m
//! ```
//! What went before the gap became known is foreseen then, from the last seconds of motor and twin.
//!
//! `theta_M` is the measured motor less the correction. With the whole correction the load is that
//! of the gapless twin as long as nothing is corrected; then it is a mass between the flanks of the
//! measured motor, so that what a correction really does to the motor counts.

use super::lanes::slide_alone;
use lostmotion_base::Clock;
use lostmotion_drive::twin::{LoadModel, Shown};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Command cycles that are kept until somebody asks; behind them nothing is foreseen until then. A choice: several
/// exchanges between axes.
const MOST_CYCLES: usize = 256;
/// Command cycles before the gap is known that are foreseen once it is. A choice: 4 s at 1 kHz, in which
/// an axis comes back mostly; 96 kB.
const PAST_CYCLES: usize = 4000;

/// Servo ticks without a correction from which on nothing is corrected. A choice: 2 ms, while a traverse
/// is at zero for one tick.
const IDLE_TICKS: u32 = 8;

/// Part of the half gap from which on a load is on its flank: less by rounding.
const MET_SHARE: f64 = 0.999;

/// A mass between the flanks of a motor: place (rad) and speed (rad/s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Mass {
    place: f64,
    speed: f64,
}

impl Mass {
    /// A step of `h` s: to the motor's place (rad) with its speed (rad/s).
    fn step(&mut self, [motor, motor_speed]: [f64; 2], half_gap: f64, load: &LoadModel, h: f64) {
        let gain = -h * (load.viscous * self.speed + load.constant) / load.inertia;
        let speed = slide_alone(self.speed, gain, h * load.coulomb / load.inertia);
        let free = self.place + h * speed;
        self.place = free.max(motor - half_gap).min(motor + half_gap);
        self.speed = if self.place == free {
            speed
        } else {
            motor_speed
        };
    }
}

/// The foreseen places since the last question, one pair a command cycle; `None` while the gap is not
/// known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Foresee {
    /// Without a correction, and with that of the moment.
    masses: [Mass; 2],
    /// Servo ticks without a correction.
    idle: u32,
    /// Servo ticks since the last command cycle began.
    tick: u32,
    /// Cycles since the last question.
    asked: usize,
    kept: Vec<Option<[f64; 2]>>,
    /// What the last cycles showed while the gap was not known.
    past: VecDeque<Past>,
}

/// A command cycle while the gap was not known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Past {
    /// Motor less the correction, rad.
    motor: f64,
    /// Load of the gapless twin, and the wind-up of its shaft, rad.
    load: f64,
    wound: f64,
}

impl Foresee {
    /// Motor and load at a place, rad.
    pub(super) fn at(place: f64) -> Foresee {
        Foresee {
            masses: [Mass { place, speed: 0.0 }; 2],
            idle: IDLE_TICKS,
            ..Foresee::default()
        }
    }

    /// Room for all that is ever kept: what was recalled, and the cycles until somebody asks.
    pub(super) fn make_room(&mut self) {
        self.kept
            .reserve_exact((PAST_CYCLES + MOST_CYCLES).saturating_sub(self.kept.len()));
        self.past
            .reserve_exact(PAST_CYCLES.saturating_sub(self.past.len()));
    }

    /// Whether anybody asks: nobody does of an axis that moves alone.
    #[inline(always)]
    pub(super) fn is_asked(&self) -> bool {
        self.asked < MOST_CYCLES
    }

    /// One servo tick: measured motor position (rad), the correction's offset (rad), the half gap (rad)
    /// if it is known, the load if that is, the gapless twin; `ticks` in a command cycle.
    pub(super) fn step(
        &mut self,
        [motor, offset]: [f64; 2],
        known: Option<f64>,
        (load, load_known): (&LoadModel, bool),
        twin: &Shown,
        ticks: u32,
    ) {
        if !self.is_asked() {
            return;
        }
        let (speed, half_gap, h) = (
            twin.motor_velocity,
            known.unwrap_or(0.0),
            Clock::SERVO.period_s(),
        );
        if let Some(half_gap) = known
            && !self.past.is_empty()
        {
            self.recall(half_gap, load, f64::from(ticks.max(1)) * h);
        }
        let [without, with] = &mut self.masses;
        without.step([motor - offset, speed], half_gap, load, h);
        // a traverse passes through zero
        self.idle = if offset == 0.0 {
            self.idle.saturating_add(1)
        } else {
            0
        };
        let corrected = self.idle < IDLE_TICKS;
        if corrected {
            with.step([motor, speed], half_gap, load, h);
        } else {
            *with = *without;
        }
        let first = self.tick == 0;
        self.tick = (self.tick + 1) % ticks.max(1);
        if !first {
            return;
        }
        let wound = twin.torque / load.stiffness;
        if known.is_none() && load_known {
            if self.past.len() >= PAST_CYCLES {
                self.past.pop_front();
            }
            self.past.push_back(Past {
                motor: motor - offset,
                load: twin.load_position,
                wound,
            });
        }
        self.asked += 1;
        // a weight hangs on one flank: its place is set with the gap in it, and stays
        let hangs = load.constant.abs() > load.coulomb;
        self.kept.push(known.map(|half_gap| {
            if half_gap <= 0.0 || hangs {
                [twin.load_position; 2]
            } else if corrected {
                self.masses.map(|mass| mass.place - wound)
            } else {
                [self.masses[0].place - wound, twin.load_position]
            }
        }));
    }

    /// Foresees what went before, now that the gap is known: from the middle of the gap on, in cycles of
    /// `period` s. While nothing was corrected the corrected load is that of the twin.
    fn recall(&mut self, half_gap: f64, load: &LoadModel, period: f64) {
        let hangs = load.constant.abs() > load.coulomb;
        let mut mass = Mass {
            place: self.past.front().map_or(0.0, |past| past.motor),
            speed: 0.0,
        };
        let mut before = mass.place;
        // the newest are of the cycles since the last question
        self.kept
            .truncate(self.kept.len().saturating_sub(self.past.len()));
        // where the load was is not known before the motor first met it
        let mut met = false;
        for past in self.past.drain(..) {
            let speed = (past.motor - before) / period;
            before = past.motor;
            mass.step([past.motor, speed], half_gap, load, period);
            met |= (past.motor - mass.place).abs() >= MET_SHARE * half_gap;
            self.kept.push(if half_gap <= 0.0 || hangs {
                Some([past.load; 2])
            } else {
                met.then_some([mass.place - past.wound, past.load])
            });
        }
        self.masses = [mass; 2];
    }

    /// What was foreseen since the last [`Foresee::clear`], and before it once the gap becomes known, rad:
    /// without a correction, and with it.
    pub(super) fn kept(&self) -> &[Option<[f64; 2]>] {
        &self.kept
    }

    /// Forgets what was asked for. `place`: that of the motor, rad, from which it starts anew where nobody had asked
    /// for long.
    pub(super) fn clear(&mut self, place: f64) {
        self.kept.clear();
        if !self.is_asked() {
            self.past.clear();
            (self.masses, self.idle, self.tick) = ([Mass { place, speed: 0.0 }; 2], IDLE_TICKS, 0);
        }
        self.asked = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOAD: LoadModel = LoadModel {
        inertia: 0.01,
        viscous: 0.0,
        coulomb: 1.0,
        constant: 0.0,
        stiffness: 1000.0,
        damping: 0.1,
    };

    #[test]
    fn a_load_that_friction_holds_plays_between_its_flanks() {
        let mut mass = Mass::default();
        let (half_gap, h) = (1e-3, Clock::SERVO.period_s());
        // slowly forth and back: it lags by half the gap, and stands while the gap is crossed
        let mut motor = 0.0;
        for _ in 0..4000 {
            motor += 0.01 * h;
            mass.step([motor, 0.01], half_gap, &LOAD, h);
        }
        assert!((mass.place - (motor - half_gap)).abs() < 1e-15);
        let turned = mass.place;
        for _ in 0..400 {
            motor -= 0.01 * h;
            mass.step([motor, -0.01], half_gap, &LOAD, h);
        }
        assert!((mass.place - turned).abs() < 1e-6);
        for _ in 0..4000 {
            motor -= 0.01 * h;
            mass.step([motor, -0.01], half_gap, &LOAD, h);
        }
        assert!((mass.place - (motor + half_gap)).abs() < 1e-15);
    }

    #[test]
    fn a_load_faster_than_friction_stops_it_runs_to_the_other_flank() {
        let (half_gap, h) = (1e-3, Clock::SERVO.period_s());
        // the motor stops at once from 2 rad/s; friction takes 100 rad/s2: 20 ms and 20 mrad, the
        // gap is 2 mrad
        let mut mass = Mass {
            place: -half_gap,
            speed: 2.0,
        };
        for _ in 0..(0.05 / h) as u32 {
            mass.step([0.0, 0.0], half_gap, &LOAD, h);
        }
        assert!((mass.place - half_gap).abs() < 1e-15);
        // half that far with a gap that is wider: w^2 J/(2 T_f)
        let mut mass = Mass {
            place: -0.1,
            speed: 2.0,
        };
        for _ in 0..(0.05 / h) as u32 {
            mass.step([0.0, 0.0], 0.1, &LOAD, h);
        }
        assert!((mass.place - (-0.1 + 0.02)).abs() < 3e-4, "{}", mass.place);
    }

    #[test]
    fn a_traverse_that_passes_through_zero_is_still_a_correction() {
        let (half_gap, h) = (1e-3, Clock::SERVO.period_s());
        let mut foresee = Foresee::at(0.0);
        // towed forth at 0.2 rad/s with the correction on, which then turns around while the motor slows
        // down as friction does, 100 rad/s2: the load goes on by itself, wherever the motor is
        let (mut position, mut speed) = (0.0, 0.2);
        let mut before = 0.0;
        for tick in 0..440_i32 {
            let share = (f64::from(tick - 404) / 4.0).clamp(-1.0, 1.0);
            let offset = -half_gap * share;
            if tick > 400 {
                speed -= 100.0 * h;
            }
            position += speed.max(0.0) * h;
            let twin = Shown {
                motor_velocity: speed.max(0.0),
                load_position: position,
                ..Shown::default()
            };
            foresee.step(
                [position + offset, offset],
                Some(half_gap),
                (&LOAD, true),
                &twin,
                4,
            );
            let [_, with] = foresee.masses.map(|mass| mass.place);
            assert!(
                tick == 0 || with - before < 0.21 * h,
                "{tick}: {with} {before}"
            );
            before = with;
        }
    }

    #[test]
    fn an_axis_that_nobody_asks_foresees_nothing_until_somebody_does() {
        let mut foresee = Foresee::at(0.0);
        let stand = |foresee: &mut Foresee, place: f64, cycles: usize| {
            let twin = Shown {
                load_position: place,
                ..Shown::default()
            };
            for _ in 0..cycles {
                foresee.step([place, 0.0], Some(1e-3), (&LOAD, true), &twin, 1);
            }
        };
        stand(&mut foresee, 0.0, MOST_CYCLES);
        let alone = foresee.clone();
        stand(&mut foresee, 5.0, 1);
        assert_eq!(foresee, alone);
        foresee.clear(5.0);
        stand(&mut foresee, 5.0, 2);
        assert_eq!(foresee.kept(), [Some([5.0; 2]); 2]);
    }

    #[test]
    fn what_went_before_is_foreseen_once_the_gap_is_known() {
        let (half_gap, h) = (1e-3, Clock::SERVO.period_s());
        let (mut early, mut late) = (Foresee::at(0.0), Foresee::at(0.0));
        let mut motor = 0.0;
        for tick in 0..4001_u32 {
            let speed = if tick < 2000 { 0.01 } else { -0.01 };
            motor += speed * h;
            let twin = Shown {
                motor_velocity: speed,
                load_position: motor,
                ..Shown::default()
            };
            let at = [motor, 0.0];
            // the control asks twenty times a second
            if tick % 200 == 0 {
                early.clear(0.0);
                late.clear(0.0);
            }
            early.step(at, Some(half_gap), (&LOAD, true), &twin, 4);
            let known = (tick == 4000).then_some(half_gap);
            late.step(at, known, (&LOAD, true), &twin, 4);
        }
        // the newest last
        assert_eq!((early.kept().len(), late.kept().len()), (1, 1001));
        let last = |foresee: &Foresee| foresee.kept().last().copied().flatten().unwrap();
        let ([without, with], [expected, _]) = (last(&late), last(&early));
        assert!((without - expected).abs() < 1e-12 && (with - motor).abs() < 1e-15);
        // where the load was before the motor met it is not known
        assert_eq!(late.kept[0], None);
        assert!(late.past.is_empty());
    }
}
