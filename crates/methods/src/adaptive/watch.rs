//! Watching for crossings: keeps the last ticks, opens a window where another flank is about to
//! carry the load, closes it once that flank does.
//!
//! A flank carries the load where the torque seen behind the motor (`disturbance`) is at least half
//! of what the gapless twin's shaft carries. A flank that should carry the load but gives way
//! before it does was none: the window stays open over both changes, and its reading counts as
//! faint.

use super::window::{Recent, Sample, Tick, Window};
use lostmotion_base::Clock;
use lostmotion_drive::Signals;
use lostmotion_drive::twin::TwinState;
use serde::{Deserialize, Serialize};

/// Parts of the rated torque with which a flank is surely pressed: half the load's friction, within
/// these bounds.
const PRESSED: [f64; 2] = [3e-3, 0.02];
/// Ticks on the new flank after which the crossing is over, and from the change of flank on at
/// least: 10 and 40 ms; 100 ms where less is wanted of the flank than this part of the rated
/// torque, so that one cannot tell whether it carries.
const ARRIVED: u32 = 40;
const AT_LEAST: u32 = 160;
const AT_LEAST_FAINT: u32 = 400;
const FAINT: f64 = 3e-3;

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

/// The last ticks and the window under way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Watch {
    disturbance: Disturbance,
    recent: Recent,
    window: Option<Window>,
    /// Ticks since the change of flank, and those on the new one.
    since: u32,
    arrived: u32,
    /// Whether the present flank has carried the load, and whether it surely does.
    engaged: bool,
    pressed: bool,
    /// What has been since the flank gave way, as long as no other has to carry the load.
    left: Option<Window>,
    current: f64,
    sample: Sample,
}

impl Watch {
    /// Takes what the motor did in the last tick.
    pub(super) fn observe(&mut self, motor: &Motor, signals: &Signals, twin: &TwinState) {
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
            sample: self.sample,
            seen: self.disturbance.torque,
            stands,
        });
    }

    /// Torque behind the motor as the motor shows it, N m.
    pub(super) fn seen(&self) -> f64 {
        self.disturbance.torque
    }

    /// Takes the flank that carried the load up to now, the one that has to from now on, and the
    /// torque wanted of it, and the load's Coulomb friction (N m). Gives a window that is complete.
    pub(super) fn step(
        &mut self,
        motor: &Motor,
        before: i8,
        now: i8,
        wanted: f64,
        friction: f64,
    ) -> Option<Window> {
        let (seen, sign) = (self.seen(), f64::from(now));
        let carries = wanted * sign > 0.0 && seen * sign > 0.5 * wanted * sign;
        self.arrived = if carries {
            (self.arrived + 1).min(ARRIVED)
        } else {
            self.arrived.saturating_sub(2)
        };
        self.engaged |= self.arrived >= ARRIVED;
        self.since = self.since.saturating_add(1);
        for window in [&mut self.window, &mut self.left] {
            *window = window
                .take()
                .and_then(|mut window| window.push(self.sample).then_some(window));
        }
        self.give_way(motor, before, 0.5 * friction);
        if now == before {
            let least = if wanted.abs() > FAINT * motor.rated_torque {
                AT_LEAST
            } else {
                AT_LEAST_FAINT
            };
            let over = self.since >= least && self.arrived >= ARRIVED;
            return if over { self.close(now) } else { None };
        }
        let mut complete = None;
        match &mut self.window {
            Some(window) if !self.engaged => window.wavered = true,
            _ => {
                complete = self.close(before);
                let pressed =
                    self.pressed && seen * f64::from(before) > 0.5 * wanted * f64::from(before);
                self.window = self.left.take();
                if self.window.is_none() && (self.engaged || pressed) {
                    self.window = Window::new(&self.recent, before);
                }
                self.since = 0;
            }
        }
        (self.arrived, self.engaged, self.pressed, self.left) = (0, false, false, None);
        complete
    }

    /// Keeps what has been since a flank that surely carried the load gave way: at rest that may be
    /// long before another one has to carry it.
    fn give_way(&mut self, motor: &Motor, flank: i8, least: f64) {
        let bounds = PRESSED.map(|part| part * motor.rated_torque);
        let pressed = self.seen() * f64::from(flank) > least.max(bounds[0]).min(bounds[1]);
        let before = std::mem::replace(&mut self.pressed, pressed);
        if self.pressed {
            self.left = None;
        } else if before && self.engaged && self.window.is_none() {
            self.left = Window::new(&self.recent, flank);
        }
    }

    /// Ends the window on a flank; one that ends where it began shows nothing.
    fn close(&mut self, flank: i8) -> Option<Window> {
        let mut window = self.window.take()?;
        window.close();
        (self.engaged && window.side != 0 && window.side != flank).then_some(window)
    }
}

// The torque behind the motor, seen from the motor: a momentum observer.
//
// ```text
// z' = K_t i - b_v w - F_M sign(w) - T        T = omega (z - J_M w)
// ```
// First-order low pass of the true shaft torque with corner omega; no derivative of a measured
// speed comes in.

/// Corner, rad/s: 30 Hz, above it the encoder's steps are louder than the load.
const CORNER_RAD_S: f64 = 190.0;

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
