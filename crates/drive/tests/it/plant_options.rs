//! The plant's options against closed forms.

use lostmotion_base::math;
use lostmotion_drive::plant::{
    Bell, Bristles, Contact, Curved, Friction, FrictionShape, Mode, Plant, PlantInput, PlantParams,
    PlantState, Side, Wave, Waves,
};
use lostmotion_methods::AxisConfig;
use std::f64::consts::{FRAC_PI_2, TAU};

/// The paper's axis, the load alone in a gap that is too wide to be crossed, without friction.
fn lone_load() -> PlantParams {
    let base = PlantParams::new(&AxisConfig::paper());
    PlantParams {
        half_gap_rad: 1e6,
        motor_viscous_nm_s_per_rad: 0.0,
        back_emf_v_s_per_rad: 0.0,
        ..base
    }
}

/// A torque that drives the load.
fn push(torque: f64) -> PlantInput {
    PlantInput {
        load_torque: -torque,
        ..PlantInput::default()
    }
}

fn run(plant: &Plant, state: &mut PlantState, input: &PlantInput, periods: usize) {
    for _ in 0..periods {
        plant.step(state, input);
    }
}

#[test]
fn a_load_breaks_away_at_its_static_friction_and_speeds_up_as_friction_falls() {
    let (coulomb, most, speed) = (0.4, 0.6, 2.0);
    let law = FrictionShape {
        static_factor: most / coulomb,
        speed_rad_s: speed,
        bristles: None,
    };
    let params = PlantParams {
        load_coulomb_nm: coulomb,
        load_friction: law,
        ..lone_load()
    };
    let plant = Plant::new(&params);
    let mut state = PlantState::at_rest(&params, 0.0, 0.0);
    run(&plant, &mut state, &push(0.599_999), 2000);
    assert_eq!(
        (state.load_velocity, state.load_position, state.events),
        (0.0, 0.0, 0)
    );
    let (torque, inertia) = (0.62, params.load_inertia_kgm2);
    let slope = (most - coulomb) / speed;
    // J dv/dt = (T - F_s) + slope v up to v_s, J dv/dt = T - F_c after it
    let creeping = inertia / slope * math::log(1.0 + speed * slope / (torque - most));
    let ticks = (creeping / params.period_s) as usize;
    run(&plant, &mut state, &push(torque), ticks / 2);
    assert_eq!(state.mode.load, Friction::Creeping(Side::Positive));
    let time = (ticks / 2) as f64 * params.period_s;
    let expected = (torque - most) / slope * math::expm1(slope / inertia * time);
    assert!(
        (state.load_velocity / expected - 1.0).abs() < 1e-11,
        "{} against {expected}",
        state.load_velocity
    );
    run(&plant, &mut state, &push(torque), ticks);
    assert_eq!(state.mode.load, Friction::Sliding(Side::Positive));
    let time = (ticks / 2 + ticks) as f64 * params.period_s;
    let expected = speed + (torque - coulomb) / inertia * (time - creeping);
    assert!(
        (state.load_velocity / expected - 1.0).abs() < 1e-11,
        "{} against {expected}",
        state.load_velocity
    );
}

#[test]
fn bristles_hold_as_a_spring_and_slip_at_their_level() {
    let (coulomb, presliding) = (0.4, 0.01);
    let bristles = Some(Bristles {
        presliding_rad: presliding,
        damping_s: 2e-3,
    });
    let law = FrictionShape {
        static_factor: 1.5,
        speed_rad_s: 0.5,
        bristles,
    };
    let params = PlantParams {
        load_coulomb_nm: coulomb,
        load_friction: law,
        load_viscous_nm_s_per_rad: 0.02,
        ..lone_load()
    };
    let plant = Plant::new(&params);
    let mut state = PlantState::at_rest(&params, 0.0, 0.0);
    run(&plant, &mut state, &push(0.004), 40_000);
    let stiffness = coulomb / presliding;
    assert!(
        (state.bristles[1] * stiffness / 0.004 - 1.0).abs() < 1e-6,
        "{}",
        state.bristles[1]
    );
    // it went the bend, and a little more by slip while it swung
    let slip = state.load_position - state.bristles[1];
    assert!(slip >= 0.0 && slip < 0.1 * state.load_position, "{slip}");
    // put on at once it swings up to twice the torque, still below the breakaway
    run(&plant, &mut state, &push(0.25), 80_000);
    assert!(state.load_velocity.abs() < 1e-6, "{}", state.load_velocity);
    assert!(
        (state.bristles[1] * stiffness / 0.25 - 1.0).abs() < 1e-6,
        "{}",
        state.bristles[1]
    );
    // at 10 v_s the level is the Coulomb friction, and viscous friction balances the rest
    run(&plant, &mut state, &push(0.6 + 0.1), 180_000);
    let expected = (0.7 - coulomb) / 0.02;
    assert!(
        (state.load_velocity / expected - 1.0).abs() < 1e-6,
        "{} against {expected}",
        state.load_velocity
    );
    assert!(
        (state.bristles[1] / presliding - 1.0).abs() < 1e-6,
        "{}",
        state.bristles[1]
    );
}

/// Period of a pendulum of small frequency `omega` at an amplitude, by the arithmetic-geometric
/// mean.
fn pendulum_period(omega: f64, amplitude: f64) -> f64 {
    let (mut a, mut g) = (1.0, math::cos(0.5 * amplitude));
    for _ in 0..20 {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    TAU / omega / a
}

#[test]
fn a_hanging_joint_swings_as_a_pendulum() {
    let (torque, ratio, amplitude) = (3.0, 0.2, 2.5);
    let gravity = Waves::new([Wave {
        amplitude: torque * ratio,
        per_rad: ratio,
        phase_rad: 0.0,
    }]);
    let params = PlantParams {
        curved: Curved {
            gravity,
            ..Curved::default()
        },
        ..lone_load()
    };
    let plant = Plant::new(&params);
    let mut state = PlantState::at_rest(&params, 0.0, 0.0);
    state.mode = Mode {
        contact: Contact::Gap,
        ..state.mode
    };
    (state.load_position, state.gap_angle) = (amplitude / ratio, -amplitude / ratio);
    // J theta'' = -torque ratio^2 sin(theta) in joint angles
    let period = pendulum_period(
        (torque * ratio * ratio / params.load_inertia_kgm2).sqrt(),
        amplitude,
    );
    let periods = (3.0 * period / params.period_s) as usize;
    run(&plant, &mut state, &PlantInput::default(), periods);
    // what is left to three whole swings, of motion at the turning point
    let left = 3.0 * period - periods as f64 * params.period_s;
    let speed = torque * ratio / params.load_inertia_kgm2 * math::sin(amplitude) * left;
    assert!(
        (state.load_velocity - speed).abs() < 1e-9,
        "{} against {speed}",
        state.load_velocity
    );
    assert!(
        (state.load_position * ratio / amplitude - 1.0).abs() < 1e-8,
        "{}",
        state.load_position * ratio
    );
}

#[test]
fn a_motor_rocks_about_its_detents_as_a_pendulum() {
    let (torque, per_turn, amplitude) = (0.2, 30.0, 0.9);
    let cogging = Waves::new([Wave {
        amplitude: torque,
        per_rad: per_turn,
        phase_rad: 0.0,
    }]);
    // without back-EMF and voltage there is no current: only the magnets act
    let params = PlantParams {
        curved: Curved {
            cogging,
            ..Curved::default()
        },
        ..lone_load()
    };
    let plant = Plant::new(&params);
    let mut state = PlantState::at_rest(&params, 0.0, 0.0);
    (state.gap_angle, state.current_q) = (amplitude / per_turn, 0.0);
    let period = pendulum_period(
        (torque * per_turn / params.motor_inertia_kgm2).sqrt(),
        amplitude,
    );
    let quarters = (4.25 * period / params.period_s) as usize;
    run(&plant, &mut state, &PlantInput::default(), quarters);
    let left = 4.25 * period - quarters as f64 * params.period_s;
    // at a quarter it passes the detent at its highest speed
    let speed =
        -2.0 * (torque / per_turn / params.motor_inertia_kgm2).sqrt() * math::sin(0.5 * amplitude);
    assert!(
        (state.gap_angle + speed * left).abs() < 1e-9,
        "{} against {}",
        state.gap_angle,
        -speed * left
    );
    assert!(
        (state.motor_velocity / speed - 1.0).abs() < 1e-4,
        "{} against {speed}",
        state.motor_velocity
    );
}

#[test]
fn ripple_changes_torque_and_back_emf_alike() {
    let ripple = Waves::new([Wave {
        amplitude: 0.1,
        per_rad: 6.0,
        phase_rad: FRAC_PI_2,
    }]);
    let base = PlantParams::new(&AxisConfig::paper());
    let plain = PlantParams {
        torque_constant_nm_per_a: 1.1 * 1.08,
        back_emf_v_s_per_rad: 1.1 * 0.72,
        motor_coulomb_nm: 100.0,
        ..base
    };
    let with = PlantParams {
        curved: Curved {
            ripple,
            ..Curved::default()
        },
        motor_coulomb_nm: 100.0,
        ..base
    };
    // at angle 0 the constant is a tenth higher; a motor that is held turns nowhere
    let (one, two) = (Plant::new(&plain), Plant::new(&with));
    let (mut a, mut b) = (
        PlantState::at_rest(&plain, 0.0, 0.0),
        PlantState::at_rest(&with, 0.0, 0.0),
    );
    let input = PlantInput {
        voltage_q: 5.0,
        ..PlantInput::default()
    };
    run(&one, &mut a, &input, 10_000);
    run(&two, &mut b, &input, 10_000);
    assert!((a.current_q / b.current_q - 1.0).abs() < 1e-12);
    assert_eq!((b.motor_velocity, b.mode.motor), (0.0, Friction::Stuck));
    assert!((b.current_q - 5.0 / 0.21).abs() < 1e-9, "{}", b.current_q);
}

#[test]
fn flanks_are_where_wear_and_middle_put_them() {
    let base = PlantParams {
        load_constant_nm: 1.5,
        gap_middle: -0.25,
        ..PlantParams::new(&AxisConfig::paper())
    };
    let bell = Bell {
        excess: 1.5,
        at_rad: 3.0,
        width_rad: 2.0,
    };
    let params = PlantParams {
        curved: Curved {
            wear: Some(bell),
            ..Curved::default()
        },
        ..base
    };
    for (motor, torque) in [(0.0, 1.5), (3.2, 1.5), (3.2, -1.5), (9.0, -1.5)] {
        let params = PlantParams {
            load_constant_nm: torque,
            ..params
        };
        let state = PlantState::at_rest(&params, motor, 0.0);
        let u = (state.load_position - 3.0) / 2.0;
        let half = 0.1 * (1.0 + 1.5 * math::exp(-u * u));
        let expected = (torque.signum() - 0.25) * half + torque / 2000.0;
        assert!(
            (state.gap_angle - expected).abs() < 1e-12,
            "{} against {expected}",
            state.gap_angle
        );
        // it stays, up to the part of the load that the flank's slope takes, which is that of the
        // bell
        let hold = PlantInput {
            voltage_q: params.resistance_ohm * state.current_q,
            ..PlantInput::default()
        };
        let mut later = state;
        run(&Plant::new(&params), &mut later, &hold, 20);
        assert!(
            (later.gap_angle - state.gap_angle).abs() < 1e-5,
            "{} {}",
            later.gap_angle,
            state.gap_angle
        );
    }
}
