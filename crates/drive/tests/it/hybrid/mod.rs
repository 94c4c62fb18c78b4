//! The plant written a second time, from its documented equations: a right-hand side in absolute
//! angles, guards, and transitions between modes. How it is integrated and where its guards cross
//! is left to a general-purpose solver, `flow`.
#![allow(
    dead_code,
    clippy::panic,
    reason = "a part of it for each test file; a test may panic"
)]

mod flow;

use lostmotion_base::math;
use lostmotion_drive::config::ContactLaw;
use lostmotion_drive::plant::{PlantParams, PlantState, Wave};

#[allow(
    unused_imports,
    reason = "the balance of energy needs the equations alone"
)]
pub(crate) use flow::Method;

/// i, theta_M, theta_L, w_M, w_L, z_M, z_L.
pub(crate) type State = [f64; 7];

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Contact {
    Rigid,
    Gap,
    Spring(f64),
    Doubled(f64),
    Lifted(f64),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Friction {
    Free,
    Stuck,
    Slide(f64),
    Creep(f64),
    Bristles(f64),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cause {
    Contact(Contact),
    Friction(usize, Friction),
    /// The mass has come to rest; what follows depends on the torque.
    Rest(usize),
}

/// The discrete and the continuous state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Phase {
    pub(crate) y: State,
    pub(crate) contact: Contact,
    pub(crate) friction: [Friction; 2],
    pub(crate) events: u64,
}

/// The equations with what is held.
#[derive(Clone, Copy)]
pub(crate) struct Machine {
    pub(crate) p: PlantParams,
    pub(crate) voltage: f64,
    pub(crate) extra: f64,
}

fn waves(list: &[Wave], angle: f64) -> f64 {
    list.iter()
        .map(|wave| wave.amplitude * math::sin(wave.per_rad * angle + wave.phase_rad))
        .sum()
}

impl Phase {
    /// At rest as the axis is.
    pub(crate) fn of(p: &PlantParams, state: &PlantState) -> Phase {
        let laws = [
            (p.motor_coulomb_nm, p.motor_friction),
            (p.load_coulomb_nm, p.load_friction),
        ];
        let friction = laws.map(|(coulomb, law)| match (coulomb > 0.0, law.bristles) {
            (false, _) => Friction::Free,
            (true, None) => Friction::Stuck,
            (true, Some(_)) => Friction::Bristles(1.0),
        });
        use lostmotion_drive::plant::Contact as Theirs;
        let contact = match state.mode.contact {
            Theirs::Rigid => Contact::Rigid,
            Theirs::Gap => Contact::Gap,
            Theirs::Spring(side) | Theirs::Doubled(side) | Theirs::Lifted(side) => {
                Contact::Spring(side.sign())
            }
        };
        let y = [
            state.current_q,
            state.motor_position(),
            state.load_position,
            0.0,
            0.0,
            state.bristles[0],
            state.bristles[1],
        ];
        Phase {
            y,
            contact,
            friction,
            events: 0,
        }
    }
}

impl Machine {
    /// Half gap and its slope along the load's place.
    fn half_gap(&self, place: f64) -> (f64, f64) {
        let b = self.p.half_gap_rad;
        self.p.curved.wear.map_or((b, 0.0), |wear| {
            let u = (place - wear.at_rad) / wear.width_rad;
            let bell = wear.excess * math::exp(-u * u);
            (b * (1.0 + bell), -2.0 * b * bell * u / wear.width_rad)
        })
    }

    /// Depth past a flank (past the middle of the gap for 0), its speed, and by how much the load's
    /// lever is longer.
    pub(crate) fn depth(&self, sign: f64, y: &State) -> [f64; 3] {
        let (b, slope) = self.half_gap(y[2]);
        let m = self.p.gap_middle + sign;
        [
            y[1] - y[2] - m * b,
            y[3] - y[4] * (1.0 + m * slope),
            1.0 + m * slope,
        ]
    }

    fn side(contact: Contact) -> f64 {
        match contact {
            Contact::Rigid | Contact::Gap => 0.0,
            Contact::Spring(s) | Contact::Doubled(s) | Contact::Lifted(s) => s,
        }
    }

    /// Torque on the motor (negative) and on the load.
    pub(crate) fn contact_torques(&self, contact: Contact, y: &State) -> [f64; 2] {
        let [depth, speed, lever] = self.depth(Machine::side(contact), y);
        let torque = match contact {
            Contact::Gap | Contact::Lifted(_) => 0.0,
            Contact::Rigid | Contact::Spring(_) => {
                self.p.stiffness_nm_per_rad * depth + self.p.damping_nm_s_per_rad * speed
            }
            Contact::Doubled(_) => 2.0 * self.p.stiffness_nm_per_rad * depth,
        };
        [torque, torque * lever]
    }

    /// Torques that friction has to hold at rest.
    pub(crate) fn need(&self, contact: Contact, y: &State) -> [f64; 2] {
        let [motor, load] = self.contact_torques(contact, y);
        let curved = &self.p.curved;
        let constant =
            self.p.torque_constant_nm_per_a * (1.0 + waves(curved.ripple.as_slice(), y[1]));
        [
            constant * y[0] - motor - waves(curved.cogging.as_slice(), y[1]),
            load - self.p.load_constant_nm - self.extra - waves(curved.gravity.as_slice(), y[2]),
        ]
    }

    fn coulomb(&self, mass: usize) -> f64 {
        [self.p.motor_coulomb_nm, self.p.load_coulomb_nm][mass]
    }

    /// Breakaway torque and Stribeck speed.
    fn breakaway(&self, mass: usize) -> (f64, f64) {
        let law = [self.p.motor_friction, self.p.load_friction][mass];
        (self.coulomb(mass) * law.static_factor, law.speed_rad_s)
    }

    /// Friction torque against a mass, and the speed of its bristles.
    pub(crate) fn friction(&self, mass: usize, friction: Friction, y: &State) -> (f64, f64) {
        let (coulomb, (most, speed)) = (self.coulomb(mass), self.breakaway(mass));
        let (v, z) = (y[3 + mass], y[5 + mass]);
        match friction {
            Friction::Free | Friction::Stuck => (0.0, 0.0),
            Friction::Slide(s) => (s * coulomb, 0.0),
            Friction::Creep(s) => (s * most - (most - coulomb) * v / speed, 0.0),
            Friction::Bristles(s) => {
                let Some(bristles) = [self.p.motor_friction, self.p.load_friction][mass].bristles
                else {
                    panic!("no bristles")
                };
                let level = coulomb + (most - coulomb) * math::exp(-(v / speed) * (v / speed));
                let stiffness = coulomb / bristles.presliding_rad;
                let rate = v - stiffness * s * v * z / level;
                (stiffness * (z + bristles.damping_s * rate), rate)
            }
        }
    }

    pub(crate) fn derivative(&self, phase: &Phase, y: &State) -> State {
        let p = &self.p;
        let need = self.need(phase.contact, y);
        let back_emf = p.back_emf_v_s_per_rad * (1.0 + waves(p.curved.ripple.as_slice(), y[1]));
        let mass = |m: usize, viscous: f64, inertia: f64| {
            let (friction, rate) = self.friction(m, phase.friction[m], y);
            let moving = phase.friction[m] != Friction::Stuck;
            (
                if moving {
                    (need[m] - viscous * y[3 + m] - friction) / inertia
                } else {
                    0.0
                },
                rate,
            )
        };
        let (motor, z_motor) = mass(0, p.motor_viscous_nm_s_per_rad, p.motor_inertia_kgm2);
        let (load, z_load) = mass(1, p.load_viscous_nm_s_per_rad, p.load_inertia_kgm2);
        let current = (self.voltage - p.resistance_ohm * y[0] - back_emf * y[3]) / p.inductance_h;
        [current, y[3], y[4], motor, load, z_motor, z_load]
    }

    /// The guard that is lowest, in units of about 1; negative where the mode has ended.
    pub(crate) fn lowest(&self, phase: &Phase, y: &State) -> (f64, Option<Cause>) {
        let mut lowest = (f64::INFINITY, None);
        let mut guard = |value: f64, cause: Cause| {
            if value < lowest.0 {
                lowest = (value, Some(cause));
            }
        };
        self.contact_guards(phase.contact, y, &mut guard);
        let need = self.need(phase.contact, y);
        for mass in 0..2 {
            let (v, (most, speed)) = (y[3 + mass], self.breakaway(mass));
            let falls = most > self.coulomb(mass);
            let start = |s: f64| {
                Cause::Friction(
                    mass,
                    if falls {
                        Friction::Creep(s)
                    } else {
                        Friction::Slide(s)
                    },
                )
            };
            match phase.friction[mass] {
                Friction::Free => {}
                Friction::Stuck => {
                    guard((most - need[mass]) / most, start(1.0));
                    guard((most + need[mass]) / most, start(-1.0));
                }
                Friction::Slide(s) if falls => {
                    guard(s * v - speed, Cause::Friction(mass, Friction::Creep(s)));
                }
                Friction::Slide(s) => guard(s * v, Cause::Rest(mass)),
                Friction::Creep(s) => {
                    guard(s * v, Cause::Rest(mass));
                    guard(speed - s * v, Cause::Friction(mass, Friction::Slide(s)));
                }
                // a speed of 1e-10 the wrong way round makes no difference to bristles
                Friction::Bristles(s) => {
                    guard(s * v + 1e-10, Cause::Friction(mass, Friction::Bristles(-s)));
                }
            }
        }
        lowest
    }

    fn contact_guards(&self, contact: Contact, y: &State, guard: &mut impl FnMut(f64, Cause)) {
        let p = &self.p;
        let parts = |s: f64| {
            let [depth, speed, _] = self.depth(s, y);
            (
                s * depth / p.half_gap_rad,
                s * p.stiffness_nm_per_rad * depth,
                s * p.damping_nm_s_per_rad * speed,
            )
        };
        let mut to = |value: f64, contact: Contact| guard(value, Cause::Contact(contact));
        match contact {
            Contact::Rigid => {}
            Contact::Gap => {
                for s in [1.0, -1.0] {
                    let (depth, _, damper) = parts(s);
                    let touching = if p.contact == ContactLaw::Bounded && damper > 0.0 {
                        Contact::Doubled(s)
                    } else {
                        Contact::Spring(s)
                    };
                    to(-depth, touching);
                }
            }
            Contact::Spring(s) => {
                let (depth, spring, damper) = parts(s);
                to(depth, Contact::Gap);
                if p.contact != ContactLaw::Linear {
                    to(spring + damper, Contact::Lifted(s));
                }
                if p.contact == ContactLaw::Bounded {
                    to(spring - damper, Contact::Doubled(s));
                }
            }
            Contact::Doubled(s) => {
                let (_, spring, damper) = parts(s);
                to(damper - spring, Contact::Spring(s));
            }
            Contact::Lifted(s) => {
                let (depth, spring, damper) = parts(s);
                to(depth, Contact::Gap);
                to(-spring - damper, Contact::Spring(s));
            }
        }
    }

    pub(crate) fn switch(&self, phase: &mut Phase, cause: Cause) {
        phase.events += 1;
        match cause {
            Cause::Contact(contact) => phase.contact = contact,
            Cause::Friction(mass, friction) => phase.friction[mass] = friction,
            Cause::Rest(mass) => {
                phase.y[3 + mass] = 0.0;
                let (need, (most, _)) = (
                    self.need(phase.contact, &phase.y)[mass],
                    self.breakaway(mass),
                );
                let falls = most > self.coulomb(mass);
                phase.friction[mass] = match need.abs() > most {
                    false => Friction::Stuck,
                    true if falls => Friction::Creep(need.signum()),
                    true => Friction::Slide(need.signum()),
                };
            }
        }
    }
}
