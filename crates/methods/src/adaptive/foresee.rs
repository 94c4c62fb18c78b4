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
//! `theta_M` is the measured motor less the correction. With the whole correction the load is that
//! of the gapless twin as long as nothing is corrected; then it is a mass between the flanks of the
//! measured motor, so that what a correction really does to the motor counts.

use super::lanes::slide;
use lostmotion_base::Clock;
use lostmotion_drive::twin::{LoadModel, Shown};
use serde::{Deserialize, Serialize};

/// Command cycles that are kept until somebody asks. A choice: several exchanges between axes.
const MOST_CYCLES: usize = 256;

/// A mass between the flanks of a motor: place (rad) and speed (rad/s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Mass {
    place: f64,
    speed: f64,
}

impl Mass {
    /// A servo tick: to the motor's place (rad) with its speed (rad/s).
    fn step(&mut self, motor: f64, motor_speed: f64, half_gap: f64, load: &LoadModel) {
        let h = Clock::SERVO.period_s();
        let gain = -h * (load.viscous * self.speed + load.constant) / load.inertia;
        let speed = slide(self.speed, gain, h * load.coulomb / load.inertia);
        let free = self.place + h * speed;
        self.place = free.max(motor - half_gap).min(motor + half_gap);
        self.speed = if self.place == free { speed } else { motor_speed };
    }
}

/// The foreseen places since the last question, one pair a command cycle; `None` while the gap is not
/// known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Foresee {
    /// Without a correction, and with that of the moment.
    masses: [Mass; 2],
    /// Servo ticks since the last command cycle began.
    tick: u32,
    kept: Vec<Option<[f64; 2]>>,
}

impl Foresee {
    /// Motor and load at a place, rad.
    pub(super) fn at(place: f64) -> Foresee {
        Foresee {
            masses: [Mass { place, speed: 0.0 }; 2],
            ..Foresee::default()
        }
    }

    /// One servo tick: measured motor position (rad), the correction's offset (rad), the half gap (rad)
    /// if it is known, the load, the gapless twin; `ticks` in a command cycle.
    pub(super) fn step(
        &mut self,
        [motor, offset]: [f64; 2],
        known: Option<f64>,
        load: &LoadModel,
        twin: &Shown,
        ticks: u32,
    ) {
        let (speed, half_gap) = (twin.motor_velocity, known.unwrap_or(0.0));
        let [without, with] = &mut self.masses;
        without.step(motor - offset, speed, half_gap, load);
        if offset != 0.0 {
            with.step(motor, speed, half_gap, load);
        } else {
            *with = *without;
        }
        let first = self.tick == 0;
        self.tick = (self.tick + 1) % ticks.max(1);
        if !first || self.kept.len() >= MOST_CYCLES {
            return;
        }
        let wound = twin.torque / load.stiffness;
        // a weight hangs on one flank: its place is set with the gap in it, and stays
        let hangs = load.constant.abs() > load.coulomb;
        self.kept.push(known.map(|half_gap| {
            if half_gap <= 0.0 || hangs {
                [twin.load_position; 2]
            } else if offset != 0.0 {
                self.masses.map(|mass| mass.place - wound)
            } else {
                [self.masses[0].place - wound, twin.load_position]
            }
        }));
    }

    /// What was foreseen since the last [`Foresee::clear`], rad: without a correction, and with it.
    pub(super) fn kept(&self) -> &[Option<[f64; 2]>] {
        &self.kept
    }

    /// Forgets what was asked for.
    pub(super) fn clear(&mut self) {
        self.kept.clear();
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
            mass.step(motor, 0.01, half_gap, &LOAD);
        }
        assert!((mass.place - (motor - half_gap)).abs() < 1e-15);
        let turned = mass.place;
        for _ in 0..400 {
            motor -= 0.01 * h;
            mass.step(motor, -0.01, half_gap, &LOAD);
        }
        assert!((mass.place - turned).abs() < 1e-6);
        for _ in 0..4000 {
            motor -= 0.01 * h;
            mass.step(motor, -0.01, half_gap, &LOAD);
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
            mass.step(0.0, 0.0, half_gap, &LOAD);
        }
        assert!((mass.place - half_gap).abs() < 1e-15);
        // half that far with a gap that is wider: w^2 J/(2 T_f)
        let mut mass = Mass {
            place: -0.1,
            speed: 2.0,
        };
        for _ in 0..(0.05 / h) as u32 {
            mass.step(0.0, 0.0, 0.1, &LOAD);
        }
        assert!((mass.place - (-0.1 + 0.02)).abs() < 3e-4, "{}", mass.place);
    }
}
