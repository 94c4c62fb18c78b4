//! The plant against closed forms.

use lostmotion_base::math;
use lostmotion_drive::config::ContactLaw;
use lostmotion_drive::plant::{
    Contact, Friction, Mode, Plant, PlantInput, PlantParams, PlantState, Side,
};
use lostmotion_methods::AxisConfig;
use std::f64::consts::PI;

const NOTHING: PlantInput = PlantInput {
    voltage_d: 0.0,
    voltage_q: 0.0,
    load_torque: 0.0,
};

/// The paper's shaft without friction and with a motor that neither drives nor brakes.
fn bare(law: ContactLaw) -> PlantParams {
    let mut params = PlantParams::new(&AxisConfig::paper());
    params.back_emf_v_s_per_rad = 0.0;
    params.motor_viscous_nm_s_per_rad = 0.0;
    params.contact = law;
    params
}

fn reduced_mass(p: &PlantParams) -> f64 {
    p.motor_inertia_kgm2 * p.load_inertia_kgm2 / (p.motor_inertia_kgm2 + p.load_inertia_kgm2)
}

/// Closing speed after over closing speed before one impact on the positive flank.
fn restitution(params: &PlantParams, speed: f64) -> f64 {
    let plant = Plant::new(params);
    let mut state = PlantState::at_rest(params, 0.0, 0.0);
    state.motor_velocity = speed;
    for _ in 0..200_000 {
        plant.step(&mut state, &NOTHING);
        if state.motor_velocity < state.load_velocity && state.mode.contact == Contact::Gap {
            return (state.load_velocity - state.motor_velocity) / speed;
        }
    }
    panic!("no bounce");
}

#[test]
fn coasting_in_the_gap_leaves_the_load_speed_bit_equal() {
    let params = PlantParams::new(&AxisConfig::paper());
    let plant = Plant::new(&params);
    let mut state = PlantState::at_rest(&params, 1234.5, 0.0);
    state.load_velocity = 0.123_456_789;
    state.motor_velocity = 0.123_456_789;
    for k in 0..2000 {
        plant.step(
            &mut state,
            &PlantInput {
                voltage_q: if k % 7 < 3 { 0.2 } else { -0.1 },
                ..NOTHING
            },
        );
        if state.mode.contact != Contact::Gap {
            assert!(k > 100, "the gap should last a while");
            return;
        }
        assert_eq!(state.load_velocity.to_bits(), 0.123_456_789_f64.to_bits());
    }
}

#[test]
fn linear_contact_bounces_as_a_damped_oscillator() {
    let params = bare(ContactLaw::Linear);
    let omega = (params.stiffness_nm_per_rad / reduced_mass(&params)).sqrt();
    let zeta = params.damping_nm_s_per_rad / (2.0 * reduced_mass(&params) * omega);
    let expected = math::exp(-PI * zeta / (1.0 - zeta * zeta).sqrt());
    for speed in [0.05, 1.0, 30.0] {
        let e = restitution(&params, speed);
        assert!((e / expected - 1.0).abs() < 1e-10, "{e} against {expected}");
    }
}

#[test]
fn clamped_contact_bounces_as_known() {
    let params = bare(ContactLaw::Clamped);
    let omega = (params.stiffness_nm_per_rad / reduced_mass(&params)).sqrt();
    let zeta = params.damping_nm_s_per_rad / (2.0 * reduced_mass(&params) * omega);
    // the torque vanishes where the phase is 2 acos(zeta); there the speed is exp(-zeta omega t) of
    // the impact's
    let expected = math::exp(-zeta * 2.0 * math::acos(zeta) / (1.0 - zeta * zeta).sqrt());
    let e = restitution(&params, 5.0);
    assert!((e / expected - 1.0).abs() < 1e-10, "{e} against {expected}");
}

#[test]
fn bounded_contact_bounces_by_its_three_arcs() {
    let params = bare(ContactLaw::Bounded);
    let (k, d, m) = (
        params.stiffness_nm_per_rad,
        params.damping_nm_s_per_rad,
        reduced_mass(&params),
    );
    // arc 1: twice the spring until d v = k x
    let fast = (2.0 * k / m).sqrt();
    let phase = math::atan(d * fast / k);
    let (x1, v1) = (math::sin(phase) / fast, math::cos(phase));
    // arc 2: damped oscillation until k x + d v = 0; after that no torque (arc 3)
    let (alpha, omega) = (d / (2.0 * m), (k / m).sqrt());
    let damped = (omega * omega - alpha * alpha).sqrt();
    let at = |t: f64| {
        let (s, c) = math::sin_cos(damped * t);
        let b = (v1 + alpha * x1) / damped;
        let e = math::exp(-alpha * t);
        (
            e * (x1 * c + b * s),
            e * ((damped * b - alpha * x1) * c - (damped * x1 + alpha * b) * s),
        )
    };
    let (mut low, mut high) = (PI / damped * 0.3, PI / damped);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        let (x, v) = at(middle);
        if k * x + d * v > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let expected = -at(low).1;
    let e = restitution(&params, 5.0);
    assert!((e / expected - 1.0).abs() < 1e-9, "{e} against {expected}");
}

#[test]
fn an_undamped_bounce_keeps_energy_and_momentum() {
    let params = PlantParams {
        damping_nm_s_per_rad: 0.0,
        ..bare(ContactLaw::Linear)
    };
    let plant = Plant::new(&params);
    let mut state = PlantState::at_rest(&params, 0.0, 0.0);
    state.motor_velocity = 10.0;
    let (jm, jl) = (params.motor_inertia_kgm2, params.load_inertia_kgm2);
    let energy = |s: &PlantState| {
        let depth = (s.gap_angle.abs() - params.half_gap_rad).max(0.0);
        0.5 * (jm * s.motor_velocity * s.motor_velocity
            + jl * s.load_velocity * s.load_velocity
            + params.stiffness_nm_per_rad * depth * depth)
    };
    let start = energy(&state);
    for _ in 0..40_000 {
        plant.step(&mut state, &NOTHING);
    }
    assert!(state.events > 100, "{}", state.events);
    assert!((energy(&state) / start - 1.0).abs() < 1e-11);
    assert!(
        ((jm * state.motor_velocity + jl * state.load_velocity) / (jm * 10.0) - 1.0).abs() < 1e-11
    );
}

#[test]
fn stick_is_true_below_the_coulomb_torque_and_ends_above() {
    let params = PlantParams {
        load_coulomb_nm: 0.5,
        motor_coulomb_nm: 0.2,
        ..PlantParams::new(&AxisConfig::paper())
    };
    let plant = Plant::new(&params);
    let mut state = PlantState::at_rest(&params, 0.0, 0.0);
    // 0.19 N m cannot move the motor
    let below = params.resistance_ohm * 0.19 / params.torque_constant_nm_per_a;
    for _ in 0..40_000 {
        plant.step(
            &mut state,
            &PlantInput {
                voltage_q: below,
                ..NOTHING
            },
        );
    }
    assert_eq!(
        (state.motor_velocity, state.load_velocity, state.gap_angle),
        (0.0, 0.0, 0.0)
    );
    // 0.65 N m takes the motor to the flank, where it creeps into balance with spring and friction;
    // a little less, and it stands
    let at = |torque: f64| PlantInput {
        voltage_q: params.resistance_ohm * torque / params.torque_constant_nm_per_a,
        ..NOTHING
    };
    for k in 0..100_000 {
        plant.step(&mut state, &at(if k < 80_000 { 0.65 } else { 0.6 }));
    }
    assert_eq!(
        state.mode,
        Mode {
            contact: Contact::Spring(Side::Positive),
            motor: Friction::Stuck,
            load: Friction::Stuck
        }
    );
    let rest = state;
    for _ in 0..1000 {
        plant.step(&mut state, &at(0.6));
    }
    assert_eq!(
        (state.load_position, state.gap_angle),
        (rest.load_position, rest.gap_angle)
    );
    assert!(
        (plant.contact_torque(&state) - 0.45).abs() < 1e-9,
        "{}",
        plant.contact_torque(&state)
    );
    // 0.8 N m moves both
    for _ in 0..20_000 {
        plant.step(&mut state, &at(0.8));
    }
    assert!(state.load_velocity > 0.0);
}

#[test]
fn a_sliding_load_stops_where_its_friction_says() {
    let params = PlantParams {
        load_coulomb_nm: 0.05,
        half_gap_rad: 50.0,
        ..bare(ContactLaw::Linear)
    };
    let plant = Plant::new(&params);
    let mut state = PlantState::at_rest(&params, 0.0, 0.0);
    state.load_velocity = -3.0;
    state.mode.load = Friction::Sliding(Side::Negative);
    for _ in 0..20_000 {
        plant.step(&mut state, &NOTHING);
    }
    assert_eq!(state.load_velocity, 0.0);
    let way = -0.5 * params.load_inertia_kgm2 * 9.0 / 0.05;
    assert!(
        (state.load_position / way - 1.0).abs() < 1e-12,
        "{} against {way}",
        state.load_position
    );
}

#[test]
fn a_hanging_load_starts_in_equilibrium() {
    let params = PlantParams {
        load_constant_nm: 1.5,
        load_coulomb_nm: 0.3,
        ..PlantParams::new(&AxisConfig::paper())
    };
    let plant = Plant::new(&params);
    let mut state = PlantState::at_rest(&params, 7.0, 0.0);
    let hold = PlantInput {
        voltage_q: params.resistance_ohm * state.current_q,
        ..NOTHING
    };
    for _ in 0..1000 {
        plant.step(&mut state, &hold);
    }
    assert!((state.motor_position() - 7.0).abs() < 1e-9 && state.motor_velocity.abs() < 1e-9);
    assert!((state.gap_angle - (0.1 + 1.5 / 2000.0)).abs() < 1e-9);
}

#[test]
fn a_contact_far_out_is_as_sharp_as_at_the_origin() {
    let params = PlantParams {
        load_coulomb_nm: 0.2,
        ..PlantParams::new(&AxisConfig::paper())
    };
    let plant = Plant::new(&params);
    let (mut near, mut far) = (
        PlantState::at_rest(&params, 0.0, 0.0),
        PlantState::at_rest(&params, 50_000.0, 0.0),
    );
    for k in 0..20_000_u32 {
        let input = PlantInput {
            voltage_q: if k / 1500 % 2 == 0 { 3.0 } else { -3.0 },
            ..NOTHING
        };
        plant.step(&mut near, &input);
        plant.step(&mut far, &input);
        assert_eq!(
            (near.gap_angle, near.load_velocity, near.events),
            (far.gap_angle, far.load_velocity, far.events)
        );
    }
    assert!(near.events > 20, "{}", near.events);
}
