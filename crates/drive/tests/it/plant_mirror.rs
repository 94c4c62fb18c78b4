//! Symmetries of the plant: mirrored input, mirrored output; no gap, no gap's options.

use crate::plants::{any_plant, inputs, plain};
use lostmotion_drive::plant::{
    Bell, Curved, Plant, PlantInput, PlantParams, PlantState, Wave, Waves,
};
use proptest::prelude::*;
use std::f64::consts::PI;

/// The axis seen in a mirror.
fn mirrored(params: &PlantParams) -> PlantParams {
    let turned = |waves: &Waves, phase: fn(f64) -> f64| {
        Waves::new(waves.as_slice().iter().map(|wave| Wave {
            phase_rad: phase(wave.phase_rad),
            ..*wave
        }))
    };
    let curved = &params.curved;
    PlantParams {
        gap_middle: -params.gap_middle,
        load_constant_nm: -params.load_constant_nm,
        curved: Curved {
            // a torque changes its sign in the mirror, a factor does not
            cogging: turned(&curved.cogging, |phase| -phase),
            gravity: turned(&curved.gravity, |phase| -phase),
            ripple: turned(&curved.ripple, |phase| PI - phase),
            wear: curved.wear.map(|bell| Bell {
                at_rad: -bell.at_rad,
                ..bell
            }),
        },
        ..*params
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn mirrored_input_gives_mirrored_output_to_the_bit(params in plain(), inputs in inputs(), start in -1.0..1.0_f64) {
        let params = PlantParams { pole_pairs: 5.0, ..params };
        let other = mirrored(&params);
        let (plant, reflection) = (Plant::new(&params), Plant::new(&other));
        let (mut one, mut two) = (PlantState::at_rest(&params, 3.0, start), PlantState::at_rest(&other, -3.0, -start));
        for (voltage, extra) in inputs {
            for _ in 0..100 {
                plant.step(&mut one, &PlantInput { voltage_d: 0.1, voltage_q: voltage, load_torque: extra });
                reflection.step(&mut two, &PlantInput { voltage_d: 0.1, voltage_q: -voltage, load_torque: -extra });
                prop_assert_eq!(one.load_position, -two.load_position);
                prop_assert_eq!(one.gap_angle, -two.gap_angle);
                prop_assert_eq!(one.current_q, -two.current_q);
                prop_assert_eq!(one.current_d, two.current_d);
                prop_assert_eq!(one.events, two.events);
            }
        }
    }

    #[test]
    fn every_option_has_its_mirror(params in any_plant(), inputs in inputs(), start in -1.0..1.0_f64) {
        let other = mirrored(&params);
        let (plant, reflection) = (Plant::new(&params), Plant::new(&other));
        let (mut one, mut two) = (PlantState::at_rest(&params, 0.7, start), PlantState::at_rest(&other, -0.7, -start));
        let scale = params.half_gap_rad.max(1e-3);
        for (voltage, extra) in inputs {
            for _ in 0..100 {
                plant.step(&mut one, &PlantInput { voltage_d: 0.1, voltage_q: voltage, load_torque: extra });
                reflection.step(&mut two, &PlantInput { voltage_d: 0.1, voltage_q: -voltage, load_torque: -extra });
                let off = (one.load_position + two.load_position).abs().max((one.gap_angle + two.gap_angle).abs());
                prop_assert!(off < 1e-9 * scale, "{} of the gap", off / scale);
            }
        }
    }

    #[test]
    fn without_a_gap_its_options_change_nothing(params in any_plant(), inputs in inputs()) {
        let with = PlantParams { half_gap_rad: 0.0, ..params };
        let without = PlantParams { gap_middle: 0.0, curved: Curved { wear: None, ..with.curved }, ..with };
        let (plant, plain) = (Plant::new(&with), Plant::new(&without));
        let (mut one, mut two) = (PlantState::at_rest(&with, 0.0, 0.5), PlantState::at_rest(&without, 0.0, 0.5));
        for (voltage, extra) in inputs {
            for _ in 0..100 {
                let input = PlantInput { voltage_d: 0.1, voltage_q: voltage, load_torque: extra };
                plant.step(&mut one, &input);
                plain.step(&mut two, &input);
                let off = (one.load_position - two.load_position).abs().max((one.gap_angle - two.gap_angle).abs());
                prop_assert!(off < 1e-11, "{off}");
            }
        }
    }
}
