//! Detection of crossings: keeps the last ticks, opens a window where another flank is about to
//! carry the load, closes it once that flank does.
//!
//! A flank carries the load where the torque observed behind the motor is at least half of what the
//! gapless twin's shaft carries. A new flank that gives way before it has carried the load does not
//! count: the window stays open over both changes (the flank wavered), and its reading counts as
//! faint.
//!
//! ```text
//! z' = K_t i - b_v w - F_M sign(w) - T        T = omega (z - J_M w)         momentum observer: T is the shaft's torque through
//!                                                                          a low pass with corner omega, without any derivative
//! ```

use super::window::{Recent, Sample, Tick, Window};
use lostmotion_base::{Clock, Number};
use lostmotion_drive::Signals;
use lostmotion_drive::twin::TwinState;
use serde::{Deserialize, Serialize};

/// Bounds of the torque with which a flank is certainly pressed, parts of the rated torque; between
/// them it is half of the load's friction. Tuned (0.02 alone before, which a light load does not
/// reach).
const PRESSING_LIMITS: [f64; 2] = [3e-3, 0.02];
/// Servo ticks on the new flank after which the crossing is over: 10 ms. A choice: two periods of a
/// shaft that rings at 200 Hz.
const ARRIVED_TICKS: u32 = 40;
/// Least servo ticks of a window from the change of flank on: 40 ms. A choice: shorter windows may
/// end before the far flank is met, longer ones delay the next crossing's.
const LEAST_TICKS: u32 = 160;
/// The same where the flank has to carry so little that contact cannot be told: 100 ms. A choice:
/// as much as a window keeps singly (`TICKS_AT_END`).
const LEAST_TICKS_FAINT: u32 = 400;
/// Torque below which contact cannot be told, part of the rated torque. A choice: the lower of
/// `PRESSING_LIMITS`.
const FAINT_SHARE: f64 = 3e-3;

/// What the drive knows of its motor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motor {
    pub(super) torque_constant: f64,
    pub(super) inertia: f64,
    pub(super) viscous: f64,
    pub(super) rated_torque: f64,
    /// Standard deviation of a measured position, rad.
    pub(super) noise: f64,
}

/// What the window under way is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Open {
    /// There is none.
    #[default]
    Nothing,
    /// The flank gave way, and as yet no other has to carry the load.
    Left,
    /// Another flank has to carry it.
    Crossing,
}

/// The last ticks and the window under way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Watch {
    disturbance: Disturbance,
    recent: Recent,
    open: Open,
    window: Window,
    /// The last window that was complete, until it is taken or let go.
    pub(super) complete: Window,
    /// Ticks since the change of flank, and those on the new one.
    since: u32,
    arrived: u32,
    /// Whether the present flank has carried the load.
    engaged: bool,
    /// Whether it is certainly pressed now.
    pressed: bool,
    current: f64,
    sample: Sample,
}

impl Watch {
    /// Room for all that is ever kept.
    pub(super) fn make_room(&mut self) {
        self.recent.make_room();
        self.window.make_room();
        self.complete.make_room();
    }

    /// Records the last tick: observed torque and sample.
    #[inline(always)]
    pub(super) fn observe(&mut self, motor: &Motor, signals: &Signals, twin: &TwinState) {
        // the twin knows in which direction the motor slides, or that it sticks
        let friction = motor.viscous * signals.motor_velocity - twin.motor_friction;
        self.disturbance.step(
            motor.torque_constant * signals.mean_current - friction,
            motor.inertia * signals.motor_velocity,
        );
        let fall = self.current - signals.current;
        self.current = signals.current;
        self.sample = Sample {
            position: signals.motor_position,
            current: signals.mean_current,
            fall,
            ticks: 1,
        };
        let stands = twin.plant.load_velocity.abs() <= 0.0;
        self.recent.push(Tick {
            position: signals.motor_position,
            current: signals.mean_current,
            fall,
            seen: self.disturbance.torque,
            stands,
        });
    }

    /// Observed torque behind the motor, N m.
    pub(super) fn seen(&self) -> f64 {
        self.disturbance.torque
    }

    /// One tick: the flank that carried the load up to now, the one that has to from now on, the
    /// torque that it has to carry, and the load's Coulomb friction (N m). Returns whether a window
    /// is complete.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        motor: &Motor,
        before: i8,
        now: i8,
        wanted: f64,
        friction: f64,
    ) -> bool {
        let (seen, sign) = (self.seen(), f64::from(now));
        // same direction, and at least half of what the twin's shaft carries
        let carries = wanted * sign > 0.0 && seen * sign > 0.5 * wanted * sign;
        // contact counts up, loss of contact twice as fast down: ringing is no arrival
        self.arrived = if carries {
            (self.arrived + 1).min(ARRIVED_TICKS)
        } else {
            self.arrived.saturating_sub(2)
        };
        self.engaged |= self.arrived >= ARRIVED_TICKS;
        self.since = self.since.saturating_add(1);
        // a window that is full is dropped: the crossing takes too long
        if self.open != Open::Nothing && !self.window.push(self.sample) {
            self.forget();
        }
        self.give_way(motor, before, 0.5 * friction);
        // no change of flank: the window closes once the new flank has carried the load for long
        // enough
        if now == before {
            let least = if wanted.abs() > FAINT_SHARE * motor.rated_torque {
                LEAST_TICKS
            } else {
                LEAST_TICKS_FAINT
            };
            let over = self.since >= least && self.arrived >= ARRIVED_TICKS;
            return over && self.close(now);
        }
        // change of flank: one that had not carried the load yet only wavered; otherwise the old
        // window ends and a new one starts where the flank gave way
        let mut complete = false;
        if self.open == Open::Crossing && !self.engaged {
            self.window.wavered = true;
        } else {
            complete = self.close(before);
            let pressed =
                self.pressed && seen * f64::from(before) > 0.5 * wanted * f64::from(before);
            let opens = self.open == Open::Left
                || (self.engaged || pressed) && self.window.begin(&self.recent, before);
            if opens {
                self.open = Open::Crossing;
            }
            self.since = 0;
        }
        (self.arrived, self.engaged, self.pressed) = (0, false, false);
        complete
    }

    /// Opens a window where a flank that certainly carried the load gives way: at rest that may be long
    /// before another one has to carry it.
    #[inline(always)]
    fn give_way(&mut self, motor: &Motor, flank: i8, least: f64) {
        // half of the load's friction, but no less than noise and no more than a light load shows
        let [low, high] = PRESSING_LIMITS.map(|part| part * motor.rated_torque);
        let pressed = self.seen() * f64::from(flank) > least.larger(low).lesser(high);
        let before = std::mem::replace(&mut self.pressed, pressed);
        if self.pressed && self.open == Open::Left {
            self.forget();
        } else if !self.pressed
            && before
            && self.engaged
            && self.open != Open::Crossing
            && self.window.begin(&self.recent, flank)
        {
            self.open = Open::Left;
        }
    }

    /// Ends the window on a flank. Returns whether it is complete: one that ends on the flank where it
    /// began shows nothing.
    fn close(&mut self, flank: i8) -> bool {
        if self.open != Open::Crossing {
            return false;
        }
        let tells = self.engaged && self.window.side != 0 && self.window.side != flank;
        if tells {
            self.window.close();
            std::mem::swap(&mut self.window, &mut self.complete);
        }
        self.forget();
        tells
    }

    /// Drops the window under way.
    fn forget(&mut self) {
        self.open = Open::Nothing;
        self.window.clear();
    }
}

/// Corner of the momentum observer, rad/s: 30 Hz; above it the encoder's steps are louder than the
/// load.
const CORNER_RAD_S: f64 = 190.0;

/// Momentum observer of the torque behind the motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Disturbance {
    momentum: f64,
    /// Torque of the shaft on the load, N m.
    pub(super) torque: f64,
}

impl Disturbance {
    /// `drive`: motor torque less its friction, mean over the last tick (N m); `momentum`: `J_M w`
    /// (N m s).
    pub(super) fn step(&mut self, drive: f64, momentum: f64) {
        self.momentum += Clock::SERVO.period_s() * (drive - self.torque);
        self.torque = CORNER_RAD_S * (self.momentum - momentum);
    }
}
