//! What ends a mode, and which mode follows.
//!
//! A guard is a linear function of the states that is not negative as long as its mode lasts.

use super::dynamics::{CURRENT, Held, LOAD, MOTOR, PENETRATION, Vector};
use super::mode::{Contact, Coupling, Friction, Mode, Side};
use super::params::PlantParams;
use crate::config::ContactLaw;

/// How near to its friction a torque counts as equal to it.
const BORDER: f64 = 1e-9;

/// An event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event {
    /// A flank is reached.
    Close(Side),
    /// The penetration is used up.
    Open,
    /// The contact torque would turn into a pull.
    Release,
    /// It would push again.
    Reload,
    /// The damping torque exceeds the spring's.
    Saturate,
    /// It does not any more.
    Desaturate,
    /// A sliding motor stops.
    MotorStop,
    /// A stuck motor breaks away.
    MotorBreak(Side),
    /// A sliding load stops.
    LoadStop,
    /// A stuck load breaks away.
    LoadBreak(Side),
}

/// `offset + row . x`, not negative while the mode lasts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guard {
    pub(super) event: Event,
    pub(super) offset: f64,
    pub(super) row: Vector,
}

/// At most two guards each for contact, motor and load; one more for a bounded contact.
pub(super) const MAX_GUARDS: usize = 7;

/// The guards of a mode, contact first: of events at the same instant the first one listed happens first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guards {
    list: [Guard; MAX_GUARDS],
    len: usize,
}

impl Guards {
    pub(super) fn of(params: &PlantParams, mode: Mode, held: &Held) -> Guards {
        let none = Guard { event: Event::Open, offset: 0.0, row: [0.0; 4] };
        let mut guards = Guards { list: [none; MAX_GUARDS], len: 0 };
        guards.contact(params, mode);
        guards.motor(params, mode);
        guards.load(params, mode, held);
        guards
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Guard> {
        self.list.iter().take(self.len)
    }

    fn push(&mut self, event: Event, offset: f64, row: Vector) {
        if let Some(slot) = self.list.get_mut(self.len) {
            *slot = Guard { event, offset, row };
            self.len += 1;
        }
    }

    fn contact(&mut self, params: &PlantParams, mode: Mode) {
        let (k, d) = params.shaft(Coupling::Spring);
        let s = mode.contact.sign();
        let depth = [0.0, s, 0.0, 0.0];
        let push = [0.0, s * k, s * d, -s * d];
        match mode.contact {
            Contact::Rigid => {}
            Contact::Gap => {
                self.push(Event::Close(Side::Positive), params.half_gap_rad, [0.0, -1.0, 0.0, 0.0]);
                self.push(Event::Close(Side::Negative), params.half_gap_rad, [0.0, 1.0, 0.0, 0.0]);
            }
            Contact::Spring(_) => {
                self.push(Event::Open, 0.0, depth);
                if params.contact != ContactLaw::Linear {
                    self.push(Event::Release, 0.0, push);
                }
                if params.contact == ContactLaw::Bounded {
                    self.push(Event::Saturate, 0.0, [0.0, s * k, -s * d, s * d]);
                }
            }
            Contact::Doubled(_) => self.push(Event::Desaturate, 0.0, [0.0, -s * k, s * d, -s * d]),
            Contact::Lifted(_) => {
                self.push(Event::Open, 0.0, depth);
                self.push(Event::Reload, 0.0, push.map(|entry| -entry));
            }
        }
    }

    fn motor(&mut self, params: &PlantParams, mode: Mode) {
        match mode.motor {
            Friction::None => {}
            Friction::Sliding(side) => self.push(Event::MotorStop, 0.0, [0.0, 0.0, side.sign(), 0.0]),
            Friction::Stuck => {
                let (k, d) = params.shaft(mode.contact.coupling());
                let mut need = [0.0, -k, -d, d];
                need[CURRENT] = params.torque_constant_nm_per_a;
                let limit = params.motor_coulomb_nm;
                self.push(Event::MotorBreak(Side::Positive), limit, need.map(|entry| -entry));
                self.push(Event::MotorBreak(Side::Negative), limit, need);
            }
        }
    }

    fn load(&mut self, params: &PlantParams, mode: Mode, held: &Held) {
        match mode.load {
            Friction::None => {}
            Friction::Sliding(side) => self.push(Event::LoadStop, 0.0, [0.0, 0.0, 0.0, side.sign()]),
            Friction::Stuck => {
                let (k, d) = params.shaft(mode.contact.coupling());
                let need = [0.0, k, d, -d];
                let (limit, against) = (params.load_coulomb_nm, held.load_torque);
                self.push(Event::LoadBreak(Side::Positive), limit + against, need.map(|entry| -entry));
                self.push(Event::LoadBreak(Side::Negative), limit - against, need);
            }
        }
    }
}

/// A guard that is known to start at zero after an event, with how many of its Taylor coefficients vanish.
pub(super) type Vanishing = Option<(Event, usize)>;

impl PlantParams {
    /// Puts the states exactly on the event's boundary and returns the mode that follows, with what vanishes in it.
    pub(super) fn switch(&self, event: Event, mode: Mode, x: &mut Vector, held: &Held) -> (Mode, Vanishing) {
        let mut next = mode;
        let vanishing = match event {
            Event::Close(side) => {
                x[PENETRATION] = 0.0;
                let closing = self.damping_nm_s_per_rad * (x[MOTOR] - x[LOAD]) * side.sign();
                let bounded = self.contact == ContactLaw::Bounded && closing > 0.0;
                next.contact = if bounded { Contact::Doubled(side) } else { Contact::Spring(side) };
                None
            }
            Event::Open => {
                x[PENETRATION] = mode.contact.sign() * self.half_gap_rad;
                next.contact = Contact::Gap;
                None
            }
            Event::Release => stay_on_flank(&mut next, Contact::Lifted, Event::Reload),
            Event::Reload => stay_on_flank(&mut next, Contact::Spring, Event::Release),
            Event::Saturate => stay_on_flank(&mut next, Contact::Doubled, Event::Desaturate),
            Event::Desaturate => stay_on_flank(&mut next, Contact::Spring, Event::Saturate),
            Event::MotorStop => {
                x[MOTOR] = 0.0;
                let (friction, vanishing) = stop(self.motor_need(mode, x), self.motor_coulomb_nm, Event::MotorStop, Event::MotorBreak);
                next.motor = friction;
                vanishing
            }
            Event::LoadStop => {
                x[LOAD] = 0.0;
                let (friction, vanishing) = stop(self.load_need(mode, x, held), self.load_coulomb_nm, Event::LoadStop, Event::LoadBreak);
                next.load = friction;
                vanishing
            }
            Event::MotorBreak(side) => {
                next.motor = Friction::Sliding(side);
                smooth_start(self.motor_need(mode, x), self.motor_coulomb_nm, Event::MotorStop)
            }
            Event::LoadBreak(side) => {
                next.load = Friction::Sliding(side);
                smooth_start(self.load_need(mode, x, held), self.load_coulomb_nm, Event::LoadStop)
            }
        };
        (next, vanishing)
    }
}

/// What a mass does whose speed has come to zero under a torque: stands if its friction can hold it, else slides with the torque.
fn stop(need: f64, limit: f64, stops: Event, breaks: fn(Side) -> Event) -> (Friction, Vanishing) {
    let side = Side::of(need);
    if need.abs() > limit {
        (Friction::Sliding(side), smooth_start(need, limit, stops))
    } else {
        (Friction::Stuck, at_border(need, limit).then_some((breaks(side), 1)))
    }
}

fn at_border(need: f64, limit: f64) -> bool {
    (need.abs() - limit).abs() <= BORDER * limit
}

/// A mass that breaks away just as the torque reaches its friction starts without acceleration; after a jump of torque it has one.
fn smooth_start(need: f64, limit: f64, stops: Event) -> Vanishing {
    at_border(need, limit).then_some((stops, 2))
}

fn stay_on_flank(next: &mut Mode, contact: fn(Side) -> Contact, back: Event) -> Vanishing {
    next.contact = contact(Side::of(next.contact.sign()));
    Some((back, 1))
}
