//! The plant against general-purpose solvers with location of events, on random axes under random
//! voltages and loads.

use crate::hybrid::{Machine, Method, Phase};
use crate::plants::{HOLD, Inputs, any_plant, inputs, plain};
use lostmotion_drive::plant::{Plant, PlantInput, PlantParams, PlantState};
use proptest::prelude::*;

/// Largest difference of load and motor position, in parts of the gap.
fn difference(params: &PlantParams, inputs: &Inputs, method: Method) -> (f64, u64) {
    let plant = Plant::new(params);
    let mut state = PlantState::at_rest(params, 0.0, 0.0);
    let mut other = Phase::of(params, &state);
    let scale = if params.half_gap_rad > 0.0 {
        2.0 * params.half_gap_rad
    } else {
        1e-2
    };
    let mut worst: f64 = 0.0;
    for &(voltage, extra) in inputs {
        let machine = Machine {
            p: *params,
            voltage,
            extra,
        };
        for _ in 0..HOLD / 20 {
            for _ in 0..20 {
                plant.step(
                    &mut state,
                    &PlantInput {
                        voltage_d: 0.0,
                        voltage_q: voltage,
                        load_torque: extra,
                    },
                );
            }
            machine.advance(&mut other, 20.0 * params.period_s, method);
            let off = (state.load_position - other.y[2])
                .abs()
                .max((state.motor_position() - other.y[1]).abs());
            worst = worst.max(off / scale);
        }
    }
    (worst, state.events)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn plain_axes_agree_with_a_stiff_solver(params in plain(), inputs in inputs()) {
        let (worst, events) = difference(&params, &inputs, Method::Radau(1e-12));
        prop_assert!(worst < 1e-7, "{worst} of the gap after {events} events");
    }

    #[test]
    fn plain_axes_agree_with_an_explicit_solver(params in plain(), inputs in inputs()) {
        let (worst, events) = difference(&params, &inputs, Method::Explicit(1e-12));
        prop_assert!(worst < 1e-8, "{worst} of the gap after {events} events");
    }

    #[test]
    fn axes_with_every_option_agree_with_an_explicit_solver(params in any_plant(), inputs in inputs()) {
        let (worst, events) = difference(&params, &inputs, Method::Explicit(1e-12));
        prop_assert!(worst < 1e-7, "{worst} of the gap after {events} events");
    }
}
