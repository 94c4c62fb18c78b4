//! Energy of every kind of axis: what goes in is stored or lost, to 1e-8.
//!
//! The plant's powers are written down from its documented equations and integrated over its states
//! by Simpson's rule. A step within which an event has happened is taken again in ever shorter
//! steps, since a power may jump there.

use crate::hybrid::{Contact, Friction, Machine, State};
use crate::plants::{Inputs, any_plant, inputs, plain};
use lostmotion_base::math;
use lostmotion_drive::plant::{self, Mode, Plant, PlantInput, PlantParams, PlantState, Wave};
use proptest::prelude::*;

/// Periods for which an input is held.
const HOLD: usize = 60;
/// Steps for which a period is integrated, and by which a step with an event in it is refined.
const FINE: usize = 16;
/// Refinements: the last step is 0.1 ps. In much shorter ones angles would not move for rounding.
const LEVELS: usize = 6;

/// The same plant with ever shorter periods, each half a step of Simpson's rule.
struct Meter {
    machine: Machine,
    levels: Vec<Plant>,
    work: f64,
    lost: f64,
}

fn states(state: &PlantState) -> State {
    let [z_motor, z_load] = state.bristles;
    [
        state.current_q,
        state.motor_position(),
        state.load_position,
        state.motor_velocity,
        state.load_velocity,
        z_motor,
        z_load,
    ]
}

fn contact(mode: Mode) -> Contact {
    match mode.contact {
        plant::Contact::Rigid => Contact::Rigid,
        plant::Contact::Gap => Contact::Gap,
        plant::Contact::Spring(side) => Contact::Spring(side.sign()),
        plant::Contact::Doubled(side) => Contact::Doubled(side.sign()),
        plant::Contact::Lifted(side) => Contact::Lifted(side.sign()),
    }
}

fn friction(friction: plant::Friction) -> Friction {
    match friction {
        plant::Friction::None => Friction::Free,
        plant::Friction::Stuck => Friction::Stuck,
        plant::Friction::Sliding(side) => Friction::Slide(side.sign()),
        plant::Friction::Creeping(side) => Friction::Creep(side.sign()),
        plant::Friction::Bristles(side) => Friction::Bristles(side.sign()),
    }
}

/// Potential of torques over an angle.
fn potential(waves: &[Wave], angle: f64) -> f64 {
    waves
        .iter()
        .map(|wave| {
            -wave.amplitude / wave.per_rad * math::cos(wave.per_rad * angle + wave.phase_rad)
        })
        .sum()
}

impl Meter {
    fn new(params: &PlantParams) -> Meter {
        let mut period = params.period_s / (2 * FINE) as f64;
        let levels = (0..=LEVELS).map(|_| {
            let plant = Plant::new(&PlantParams {
                period_s: period,
                ..*params
            });
            period /= FINE as f64;
            plant
        });
        Meter {
            machine: Machine {
                p: *params,
                voltage: 0.0,
                extra: 0.0,
            },
            levels: levels.collect(),
            work: 0.0,
            lost: 0.0,
        }
    }

    fn side(contact: Contact) -> f64 {
        match contact {
            Contact::Rigid | Contact::Gap => 0.0,
            Contact::Spring(s) | Contact::Doubled(s) | Contact::Lifted(s) => s,
        }
    }

    fn stored(&self, state: &PlantState) -> f64 {
        let (p, y, contact) = (&self.machine.p, states(state), contact(state.mode));
        let depth = if contact == Contact::Gap {
            0.0
        } else {
            self.machine.depth(Meter::side(contact), &y)[0]
        };
        let bristles = [
            (p.motor_coulomb_nm, p.motor_friction, y[5]),
            (p.load_coulomb_nm, p.load_friction, y[6]),
        ];
        let bent: f64 = bristles
            .iter()
            .filter_map(|(coulomb, law, z)| {
                law.bristles
                    .map(|b| 0.5 * coulomb / b.presliding_rad * z * z)
            })
            .sum();
        0.75 * p.inductance_h * y[0] * y[0]
            + 0.5 * (p.motor_inertia_kgm2 * y[3] * y[3] + p.load_inertia_kgm2 * y[4] * y[4])
            + 0.5 * p.stiffness_nm_per_rad * depth * depth
            + bent
            + potential(p.curved.cogging.as_slice(), y[1])
            + potential(p.curved.gravity.as_slice(), y[2])
    }

    /// Power that goes in, and that is lost.
    fn powers(&self, state: &PlantState) -> [f64; 2] {
        let (m, p, y, contact) = (
            &self.machine,
            &self.machine.p,
            states(state),
            contact(state.mode),
        );
        let work = 1.5 * m.voltage * y[0] - (m.extra + p.load_constant_nm) * y[4];
        let mut lost = 1.5 * p.resistance_ohm * y[0] * y[0]
            + p.motor_viscous_nm_s_per_rad * y[3] * y[3]
            + p.load_viscous_nm_s_per_rad * y[4] * y[4];
        if contact != Contact::Gap {
            let [depth, speed, _] = m.depth(Meter::side(contact), &y);
            lost += (m.contact_torques(contact, &y)[0] - p.stiffness_nm_per_rad * depth) * speed;
        }
        for (mass, mode) in [state.mode.motor, state.mode.load].into_iter().enumerate() {
            let (torque, rate) = m.friction(mass, friction(mode), &y);
            let law = [p.motor_friction, p.load_friction][mass];
            let coulomb = [p.motor_coulomb_nm, p.load_coulomb_nm][mass];
            let bending = law
                .bristles
                .map_or(0.0, |b| coulomb / b.presliding_rad * y[5 + mass] * rate);
            lost += torque * y[3 + mass] - bending;
        }
        [work, lost]
    }

    /// Simpson's rule over two steps of a level, refined where there is an event within.
    fn advance(&mut self, state: &mut PlantState, level: usize) {
        let input = PlantInput {
            voltage_d: 0.0,
            voltage_q: self.machine.voltage,
            load_torque: self.machine.extra,
        };
        let (start, plant) = (*state, &self.levels[level]);
        let mut middle = start;
        plant.step(&mut middle, &input);
        let mut end = middle;
        plant.step(&mut end, &input);
        if end.events != start.events && level < LEVELS {
            for _ in 0..FINE {
                self.advance(state, level + 1);
            }
            return;
        }
        let third = plant.params().period_s / 3.0;
        let [a, b, c] = [&start, &middle, &end].map(|state| self.powers(state));
        self.work += third * (a[0] + 4.0 * b[0] + c[0]);
        self.lost += third * (a[1] + 4.0 * b[1] + c[1]);
        *state = end;
    }
}

/// What is missing from the balance, in parts of the energy lost; and the number of events.
fn residual(params: &PlantParams, inputs: &Inputs) -> (f64, u64) {
    let mut meter = Meter::new(params);
    let mut state = PlantState::at_rest(params, 0.0, 0.0);
    let before = meter.stored(&state);
    for &(voltage, extra) in inputs {
        (meter.machine.voltage, meter.machine.extra) = (voltage, extra);
        for _ in 0..HOLD * FINE {
            meter.advance(&mut state, 0);
        }
    }
    let balance = meter.work - meter.lost - (meter.stored(&state) - before);
    (balance / meter.lost, state.events)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(11), ..ProptestConfig::default() })]

    #[test]
    fn plain_axes_keep_the_balance(params in plain(), inputs in inputs()) {
        let (residual, events) = residual(&params, &inputs);
        prop_assert!(residual.abs() < 1e-8, "{residual} after {events} events");
    }

    #[test]
    fn axes_with_every_option_keep_the_balance(params in any_plant(), inputs in inputs()) {
        let (residual, events) = residual(&params, &inputs);
        prop_assert!(residual.abs() < 1e-8, "{residual} after {events} events");
    }
}
