//! Whatever a checked axis is told to do, it stays finite, and no step hangs.

use lostmotion_drive::config::{ContactLaw, Load, StartInGap};
use lostmotion_drive::{AxisOutput, Setpoint};
use lostmotion_methods::AxisConfig;
use lostmotion_methods::{MethodId, build_runner};
use lostmotion_rig::mill;
use proptest::prelude::*;

fn config() -> impl Strategy<Value = AxisConfig> {
    let law = prop_oneof![
        Just(ContactLaw::Linear),
        Just(ContactLaw::Clamped),
        Just(ContactLaw::Bounded)
    ];
    let encoder = prop_oneof![Just(None), Just(Some(64)), Just(Some(1 << 20))];
    let friction = || prop_oneof![Just(0.0), 1e-9..1e-3_f64, 1.0..3000.0_f64];
    (
        law,
        encoder,
        friction(),
        friction(),
        0.0..200.0_f64,
        -1.0..=1.0_f64,
        1.0..5000.0_f64,
        0.1..30.0_f64,
    )
        .prop_map(
            |(contact, encoder, load_friction, motor_friction, gap, start, stiffness, gain)| {
                let mut config = mill(load_friction, 0.0);
                if let Load::Slide(slide) = &mut config.load {
                    slide.gap_um = gap;
                    slide.stiffness_n_per_um = stiffness;
                    slide.constant_n = 200.0 * start;
                }
                config.motor.coulomb_nm = motor_friction * 1e-3;
                config.contact = contact;
                config.start_in_gap = StartInGap(start);
                config.drive.encoder_counts_per_rev = encoder;
                // from sluggish to far beyond stability
                config.drive.velocity_gain_a_s_per_rad *= gain;
                config.drive.voltage_delay_periods = u32::from(start > 0.0);
                config
            },
        )
}

fn setpoint() -> impl Strategy<Value = Setpoint> {
    let number = || prop_oneof![Just(0.0), -1.0..1.0_f64, -1e6..1e6_f64];
    (prop_oneof![Just(0.0), -10.0..10.0_f64], number(), number()).prop_map(
        |(position, velocity, acceleration)| Setpoint::moving(position, velocity, acceleration),
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_command_leaves_finite_numbers(config in config(), commands in prop::collection::vec(setpoint(), 1..12)) {
        config.check().unwrap();
        for method in MethodId::all() {
            let mut runner = build_runner(&config, method, 0.0).unwrap();
            let mut out = AxisOutput::default();
            for command in &commands {
                runner.push(&[*command; 12], &mut out).unwrap();
            }
            prop_assert!(out.load.iter().all(|p| p.is_finite()), "{}", method);
            prop_assert!(runner.plant().current_d.is_finite());
            // 32 events in a step is the bound; a real axis stays far below it on average
            let steps = out.load.len() as u64 * 5;
            prop_assert!(runner.plant().events < 2 * steps, "{} events in {steps} steps", runner.plant().events);
        }
    }
}
