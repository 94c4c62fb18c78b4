//! Random plants and what drives them.
#![allow(dead_code, reason = "a part of it for each test file")]

use lostmotion_drive::config::ContactLaw;
use lostmotion_drive::plant::{Bell, Bristles, Curved, FrictionShape, PlantParams, Wave, Waves};
use lostmotion_methods::AxisConfig;
use proptest::prelude::*;

/// What is held over [`HOLD`] periods: voltage in V, torque on the load in N m.
pub(crate) type Inputs = Vec<(f64, f64)>;

/// Periods over which an input is held.
pub(crate) const HOLD: usize = 100;

/// Axes with every contact law, Coulomb and viscous friction, a gap whose middle is anywhere, or
/// none.
pub(crate) fn plain() -> impl Strategy<Value = PlantParams> {
    let law = prop_oneof![
        Just(ContactLaw::Linear),
        Just(ContactLaw::Clamped),
        Just(ContactLaw::Bounded)
    ];
    let friction = || prop_oneof![Just(0.0), 0.02..0.6_f64];
    let gap = prop_oneof![Just(0.0), 1e-3..0.1_f64];
    let middle = prop_oneof![Just(0.0), -1.0..1.0_f64];
    (
        law,
        friction(),
        friction(),
        gap,
        0.0..0.02_f64,
        500.0..20000.0_f64,
        0.05..1.5_f64,
        0.5..8.0_f64,
        middle,
    )
        .prop_map(
            |(
                contact,
                motor,
                load,
                half_gap_rad,
                viscous,
                stiffness,
                damping,
                ratio,
                gap_middle,
            )| {
                let base = PlantParams::new(&AxisConfig::paper());
                PlantParams {
                    contact,
                    motor_coulomb_nm: motor,
                    load_coulomb_nm: load,
                    load_viscous_nm_s_per_rad: viscous,
                    half_gap_rad,
                    gap_middle: if half_gap_rad > 0.0 { gap_middle } else { 0.0 },
                    stiffness_nm_per_rad: stiffness,
                    damping_nm_s_per_rad: damping,
                    load_inertia_kgm2: ratio * base.motor_inertia_kgm2,
                    // the cross-coupling of d and q is held over a period, and the reference has
                    // none
                    pole_pairs: 0.0,
                    ..base
                }
            },
        )
}

fn law() -> impl Strategy<Value = FrictionShape> {
    let falling = (1.05..2.0_f64, 0.05..3.0_f64).prop_map(|(f, v)| FrictionShape {
        static_factor: f,
        speed_rad_s: v,
        bristles: None,
    });
    let bristles = (1.0..2.0_f64, 0.05..3.0_f64, 1e-3..2e-2_f64, 0.0..3e-3_f64).prop_map(
        |(f, v, presliding_rad, damping_s)| FrictionShape {
            static_factor: f,
            speed_rad_s: v,
            bristles: Some(Bristles {
                presliding_rad,
                damping_s,
            }),
        },
    );
    prop_oneof![Just(FrictionShape::PLAIN), falling, bristles]
}

fn waves(amplitude: f64, per_turn: std::ops::Range<u32>) -> impl Strategy<Value = Waves> {
    let wave =
        (0.0..amplitude, per_turn, -3.0..3.0_f64).prop_map(|(amplitude, per_turn, phase_rad)| {
            Wave {
                amplitude,
                per_rad: f64::from(per_turn),
                phase_rad,
            }
        });
    prop::collection::vec(wave, 0..3).prop_map(Waves::new)
}

/// Axes with every option there is.
pub(crate) fn any_plant() -> impl Strategy<Value = PlantParams> {
    let bell =
        (-0.5..3.0_f64, -1.0..1.0_f64, 0.4..2.0_f64).prop_map(|(excess, at_rad, width_rad)| Bell {
            excess,
            at_rad,
            width_rad,
        });
    let wear = prop_oneof![Just(None), bell.prop_map(Some)];
    (
        plain(),
        law(),
        law(),
        waves(0.3, 6..40),
        waves(0.1, 6..40),
        waves(1.0, 1..2),
        wear,
    )
        .prop_map(
            |(plain, motor_friction, load_friction, cogging, ripple, gravity, wear)| PlantParams {
                motor_friction,
                load_friction,
                curved: Curved {
                    cogging,
                    ripple,
                    gravity,
                    wear,
                },
                ..plain
            },
        )
}

/// Inputs that bring contacts, reversals and stops.
pub(crate) fn inputs() -> impl Strategy<Value = Inputs> {
    prop::collection::vec((-12.0..12.0_f64, -0.5..0.5_f64), 4..8)
}
