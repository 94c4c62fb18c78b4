//! What ends a mode, and which mode follows.
//!
//! A guard is a linear function of the states that is not negative as long as its mode lasts.

use super::dynamics::{CURRENT, Held, LOAD, MOTOR, PENETRATION, Vector};
use super::mode::{Contact, Coupling, Friction, Mass, Mode, Side};
use super::params::PlantParams;
use crate::config::ContactLaw;

/// How near to its friction a torque counts as equal to it.
const TORQUE_TIE: f64 = 1e-9;

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
    /// A sliding mass stops.
    Stop(Mass),
    /// A stuck mass breaks away.
    Break(Mass, Side),
    /// A sliding mass becomes so slow that its friction rises.
    Slow(Mass),
    /// A creeping mass becomes so fast that its friction falls no more.
    Fast(Mass),
    /// A mass on bristles turns round.
    Turn(Mass),
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

/// The guards of a mode, contact first: of events at the same instant the first one listed happens
/// first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guards {
    list: [Guard; MAX_GUARDS],
    len: usize,
}

impl Guards {
    pub(super) fn of(params: &PlantParams, mode: Mode, held: &Held) -> Guards {
        let mut guards = Guards::NONE;
        guards.contact(params, mode);
        guards.mass(params, mode, Mass::Motor, held);
        guards.mass(params, mode, Mass::Load, held);
        guards
    }

    /// Those of the friction of a mass: of two the second is the negative of the first, but for their
    /// offsets.
    pub(super) fn of_mass(params: &PlantParams, mode: Mode, mass: Mass, held: &Held) -> Guards {
        let mut guards = Guards::NONE;
        guards.mass(params, mode, mass, held);
        guards
    }

    const NONE: Guards = Guards {
        list: [Guard {
            event: Event::Open,
            offset: 0.0,
            row: [0.0; 4],
        }; MAX_GUARDS],
        len: 0,
    };

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
        // a flank is left where the penetration towards it is used up, and a contact that may not
        // pull where spring and damper together would
        let depth = [0.0, s, 0.0, 0.0];
        let push = [0.0, s * k, s * d, -s * d];
        match mode.contact {
            Contact::Rigid => {}
            Contact::Gap => {
                // the penetration is counted from the middle of the gap here
                self.push(
                    Event::Close(Side::Positive),
                    params.half_gap_rad,
                    [0.0, -1.0, 0.0, 0.0],
                );
                self.push(
                    Event::Close(Side::Negative),
                    params.half_gap_rad,
                    [0.0, 1.0, 0.0, 0.0],
                );
            }
            Contact::Spring(_) => {
                self.push(Event::Open, 0.0, depth);
                if params.contact != ContactLaw::Linear {
                    self.push(Event::Release, 0.0, push);
                }
                if params.contact == ContactLaw::Bounded {
                    // a bounded damper gives at most what the spring does: from there on the torque
                    // is doubled
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

    fn mass(&mut self, params: &PlantParams, mode: Mode, mass: Mass, held: &Held) {
        let speed = match mass {
            Mass::Motor => MOTOR,
            Mass::Load => LOAD,
        };
        let along = |side: Side| {
            // the mass moves in the direction it slides in
            let mut row = [0.0; 4];
            row[speed] = side.sign();
            row
        };
        match mode.friction(mass) {
            Friction::None | Friction::Bristles(_) => {}
            // with Stribeck friction a slower mass first comes to where its friction rises
            Friction::Sliding(side) if params.friction(mass).creeps() => {
                self.push(
                    Event::Slow(mass),
                    -params.friction(mass).speed_rad_s,
                    along(side),
                );
            }
            Friction::Sliding(side) => self.push(Event::Stop(mass), 0.0, along(side)),
            Friction::Creeping(side) => {
                self.push(Event::Stop(mass), 0.0, along(side));
                self.push(
                    Event::Fast(mass),
                    params.friction(mass).speed_rad_s,
                    along(side).map(|entry| -entry),
                );
            }
            Friction::Stuck => {
                // breaks away where the torque on it exceeds its friction in one direction or the
                // other
                let (need, against) = need_row(params, mode, mass, held);
                let limit = params.breakaway(mass);
                self.push(
                    Event::Break(mass, Side::Positive),
                    limit + against,
                    need.map(|entry| -entry),
                );
                self.push(Event::Break(mass, Side::Negative), limit - against, need);
            }
        }
    }
}

/// What the friction of a standing mass has to hold: a row of the states, less a constant.
fn need_row(params: &PlantParams, mode: Mode, mass: Mass, held: &Held) -> (Vector, f64) {
    let (k, d) = params.shaft(mode.contact.coupling());
    match mass {
        Mass::Motor => {
            let mut need = [0.0, -k, -d, d];
            need[CURRENT] = params.torque_constant_nm_per_a;
            (need, 0.0)
        }
        Mass::Load => ([0.0, k, d, -d], held.load_torque),
    }
}

/// A guard that is known to start at zero after an event, with how many of its Taylor coefficients
/// vanish.
pub(super) type Vanishing = Option<(Event, usize)>;

impl PlantParams {
    /// Puts the states exactly on the event's boundary and returns the mode that follows, with what
    /// vanishes in it. `need` is the torque that the friction of a standing mass has to hold.
    pub(super) fn switch(
        &self,
        event: Event,
        mode: Mode,
        x: &mut Vector,
        need: impl Fn(Mass, &Vector) -> f64,
    ) -> (Mode, Vanishing) {
        let mut next = mode;
        let vanishing = match event {
            Event::Close(side) => {
                // the penetration is counted from the new flank
                x[PENETRATION] = 0.0;
                // landing with more damping than spring torque starts at the bound
                let closing = self.damping_nm_s_per_rad * (x[MOTOR] - x[LOAD]) * side.sign();
                let bounded = self.contact == ContactLaw::Bounded && closing > 0.0;
                next.contact = if bounded {
                    Contact::Doubled(side)
                } else {
                    Contact::Spring(side)
                };
                None
            }
            Event::Open => {
                // counted from the middle of the gap again; the flank just left is at distance zero
                x[PENETRATION] = mode.contact.sign() * self.half_gap_rad;
                next.contact = Contact::Gap;
                Some((Event::Close(Side::of(mode.contact.sign())), 1))
            }
            Event::Release => stay_on_flank(&mut next, Contact::Lifted, Event::Reload),
            Event::Reload => stay_on_flank(&mut next, Contact::Spring, Event::Release),
            Event::Saturate => stay_on_flank(&mut next, Contact::Doubled, Event::Desaturate),
            Event::Desaturate => stay_on_flank(&mut next, Contact::Spring, Event::Saturate),
            Event::Stop(mass) => {
                match mass {
                    Mass::Motor => x[MOTOR] = 0.0,
                    Mass::Load => x[LOAD] = 0.0,
                }
                // the mass is at rest to the last bit, so that nothing turns round by rounding
                let (friction, vanishing) = self.stop(mass, need(mass, x));
                next.set_friction(mass, friction);
                vanishing
            }
            Event::Break(mass, side) => {
                next.set_friction(mass, self.starting(mass, side));
                // its speed starts at zero; its acceleration too, unless the torque has jumped
                smooth_start(need(mass, x), self.breakaway(mass), Event::Stop(mass))
            }
            Event::Slow(mass) => {
                next.set_friction(mass, Friction::Creeping(side_of(mode.friction(mass))));
                Some((Event::Fast(mass), 1))
            }
            Event::Fast(mass) => {
                next.set_friction(mass, Friction::Sliding(side_of(mode.friction(mass))));
                Some((Event::Slow(mass), 1))
            }
            Event::Turn(mass) => {
                next.set_friction(
                    mass,
                    Friction::Bristles(Side::of(-mode.friction(mass).sign())),
                );
                Some((event, 1))
            }
        };
        (next, vanishing)
    }

    /// What a mass does whose speed has come to zero under a torque: stands if its friction can
    /// hold it, else slides with the torque.
    fn stop(&self, mass: Mass, need: f64) -> (Friction, Vanishing) {
        let (side, limit) = (Side::of(need), self.breakaway(mass));
        // static friction cannot hold it: it slides on in the torque's direction
        if need.abs() > limit {
            (
                self.starting(mass, side),
                smooth_start(need, limit, Event::Stop(mass)),
            )
        } else {
            (
                // a torque just at the limit would break it away again by rounding
                Friction::Stuck,
                at_border(need, limit).then_some((Event::Break(mass, side), 1)),
            )
        }
    }
}

fn side_of(friction: Friction) -> Side {
    Side::of(friction.sign())
}

fn at_border(need: f64, limit: f64) -> bool {
    (need.abs() - limit).abs() <= TORQUE_TIE * limit
}

/// A mass that breaks away just as the torque reaches its friction starts without acceleration;
/// after a jump of torque it has one.
fn smooth_start(need: f64, limit: f64, stops: Event) -> Vanishing {
    at_border(need, limit).then_some((stops, 2))
}

fn stay_on_flank(next: &mut Mode, contact: fn(Side) -> Contact, back: Event) -> Vanishing {
    next.contact = contact(Side::of(next.contact.sign()));
    Some((back, 1))
}
