//! What `adaptive` learned as a memory: it teaches the next run from its first reversal on, is bound to
//! its axis, and no value of it makes an axis run away.

use lostmotion_base::math;
use lostmotion_drive::{AxisOutput, AxisStart, Learned};
use lostmotion_methods::{AxisConfig, AxisMemory, MethodId, build_runner, build_runner_from};
use lostmotion_rig::{circle, mill_x, rms, run, setpoints};
use proptest::prelude::*;
use std::f64::consts::TAU;

/// What is learned on some turns of a circle.
fn learned(config: &AxisConfig, turns: f64) -> Learned {
    let mut runner = build_runner(config, MethodId::ADAPTIVE, 0.0).unwrap();
    assert_eq!(runner.learned(), None);
    let motion = |t: f64| circle(10.0, 5.0, t);
    let mut out = AxisOutput::new(false);
    runner
        .push(&setpoints(&motion, turns * TAU / 5.0), &mut out)
        .unwrap();
    runner.learned().unwrap()
}

fn remembering(config: &AxisConfig, learned: Learned) -> AxisConfig {
    let mut warm = config.clone();
    warm.compensation.learned = Some(AxisMemory::new(learned, config));
    warm
}

/// RMS of what the gap does to the load in the first turn, against the axis without one.
fn lost_in_the_first_turn(config: &AxisConfig, method: &str) -> f64 {
    let motion = |t: f64| circle(10.0, 5.0, t);
    let rigid = run(&config.without_gap(), "none", &motion, TAU / 5.0);
    let out = run(config, method, &motion, TAU / 5.0);
    // the load starts in the middle of the gap, on which no method has a say: a tenth of the turn
    let skip = out.load.len() / 10;
    let lost = out.load.iter().zip(&rigid.load).skip(skip);
    rms(lost.map(|(with, without)| with - without))
}

#[test]
fn what_was_learned_is_used_from_the_first_reversal_on() {
    for (friction, gap_um, counts) in [(0.1, 60.0, None), (0.03, 20.0, Some(1 << 20))] {
        let cold = mill_x(friction, gap_um, counts);
        let learned = learned(&cold, 6.0);
        let truth = cold.reflected_load();
        assert!((2.0 * learned.half_gap_rad / truth.gap_rad - 1.0).abs() < 0.02);
        assert!((learned.load_inertia_kgm2 / truth.inertia_kgm2 - 1.0).abs() < 0.05);
        assert!(learned.gap_readings > 1 && !learned.floats);
        let warm = remembering(&cold, learned);
        let none = lost_in_the_first_turn(&cold, "none");
        let (cold, warm) = (
            lost_in_the_first_turn(&cold, "adaptive"),
            lost_in_the_first_turn(&warm, "adaptive"),
        );
        assert!(
            warm < 0.03 * none && warm < cold,
            "friction {friction} gap {gap_um}: none {none} cold {cold} warm {warm}"
        );
    }
}

#[test]
fn an_axis_whose_load_may_float_starts_anew() {
    let cold = mill_x(0.1, 40.0, Some(1 << 20));
    let known = learned(&cold, 4.0);
    let start = |learned: Learned| {
        let motion = |t: f64| circle(10.0, 5.0, t);
        run(&remembering(&cold, learned), "adaptive", &motion, TAU / 5.0).load
    };
    let floats = |half_gap_rad: f64| Learned {
        floats: true,
        half_gap_rad,
        load_inertia_kgm2: 0.8 * known.load_inertia_kgm2,
        ..known
    };
    let motion = |t: f64| circle(10.0, 5.0, t);
    let anew = run(&cold, "adaptive", &motion, TAU / 5.0).load;
    assert!(start(floats(known.half_gap_rad)) == anew);
    // a gap too small to matter is known whatever holds the load: nobody waits for it
    assert!(start(floats(0.0)) != anew && start(known) != anew);
}

#[test]
fn a_memory_that_is_kept_and_read_back_is_the_same_to_the_bit() {
    let config = mill_x(0.1, 40.0, Some(1 << 20));
    let memory = AxisMemory::new(learned(&config, 4.0), &config);
    let text = serde_json::to_string(&memory).unwrap();
    let back: AxisMemory = serde_json::from_str(&text).unwrap();
    assert_eq!(memory.check(&config), Ok(()));
    // rounding of the decimal text is below that of the values
    let [a, b] = [memory, back].map(|memory| memory.learned.covariance());
    for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!((a - b).abs() <= 1e-12 * a.abs(), "{a} {b}");
    }
}

#[test]
fn another_axis_is_refused_by_the_key_that_differs_and_another_tuning_is_not() {
    let config = mill_x(0.1, 40.0, Some(1 << 20));
    let memory = AxisMemory::new(learned(&config, 3.0), &config);
    let mut tuned = remembering(&config, memory.learned);
    tuned.drive.position_gain_per_s *= 0.8;
    tuned.drive.velocity_gain_a_s_per_rad *= 0.9;
    assert!(build_runner(&tuned, MethodId::ADAPTIVE, 0.0).is_ok());
    type Change = (&'static str, fn(&mut AxisConfig));
    let changes: [Change; 5] = [
        ("learned_on.rotor_inertia_kgm2", |axis| {
            axis.motor.inertia_kgm2 *= 1.5;
        }),
        ("learned_on.rated_torque_nm", |axis| {
            axis.motor.rated_torque_nm *= 1.1;
        }),
        ("learned_on.lead_mm", |axis| {
            if let lostmotion_drive::config::Transmission::Linear(linear) = &mut axis.transmission {
                linear.lead_mm *= 2.0;
            }
        }),
        ("learned_on.stiffness_nm_per_rad", |axis| {
            if let lostmotion_drive::config::Load::Slide(slide) = &mut axis.load {
                slide.stiffness_n_per_um *= 0.5;
            }
        }),
        ("learned_on.encoder_counts_per_rev", |axis| {
            axis.drive.encoder_counts_per_rev = None;
        }),
    ];
    for (key, change) in changes {
        let mut other = config.clone();
        change(&mut other);
        other.compensation.learned = Some(memory);
        let Err(error) = build_runner(&other, MethodId::ADAPTIVE, 0.0) else {
            panic!("{key} is not missed");
        };
        let text = error.to_string();
        assert!(
            text.contains(key) && text.contains("it was learned on an axis with"),
            "{text}"
        );
        // a method that learns nothing does not look at it
        assert!(build_runner(&other, MethodId::LOOKUP, 0.0).is_ok());
    }
}

#[test]
fn correlations_of_a_covariance_are_those_of_its_definition() {
    let covariance = [
        [4.0, 1.0, 0.0, -0.5],
        [1.0, 1.0, 0.1, 0.0],
        [0.0, 0.1, 9.0, 0.3],
        [-0.5, 0.0, 0.3, 0.25],
    ];
    let learned = Learned {
        load_inertia_kgm2: 1.0,
        ..Learned::default()
    }
    .with_covariance(&covariance);
    // c_ij / sqrt(c_ii c_jj)
    assert_eq!(
        learned.correlations,
        [0.5, 0.0, -0.5, 0.1 / 3.0, 0.0, 0.3 / 1.5]
    );
    for (row, expected) in learned.covariance().iter().zip(covariance) {
        for (value, expected) in row.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-15);
        }
    }
    // three quantities of which each is the opposite of both others do not exist
    let impossible = Learned {
        correlations: [-1.0, -1.0, 0.0, -1.0, 0.0, 0.0],
        ..learned
    };
    assert!(
        impossible
            .check()
            .unwrap_err()
            .to_string()
            .contains("correlations")
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever a file says is refused or can be run.
    #[test]
    fn no_memory_makes_an_axis_run_away(
        exponents in proptest::array::uniform12(-12.0..12.0_f64),
        signs in any::<u16>(),
        readings in any::<u32>(),
        floats in any::<bool>(),
        correlations in proptest::array::uniform6(-1.2..1.2_f64),
        special in 0..14_usize,
    ) {
        let mut value: Vec<f64> = exponents
            .iter()
            .enumerate()
            .map(|(n, exponent)| {
                // mostly positive: a sign alone is soon refused
                let sign = if signs & (1 << n) == 0 || n != 8 { 1.0 } else { -1.0 };
                sign * math::exp(exponent * std::f64::consts::LN_10)
            })
            .collect();
        if let Some(value) = value.get_mut(special) {
            *value = if special % 2 == 0 { f64::NAN } else { f64::INFINITY };
        }
        let config = mill_x(0.1, 40.0, Some(1 << 20));
        let learned = Learned {
            half_gap_rad: value[0],
            half_gap_deviation_rad: value[1],
            gap_readings: readings,
            floats,
            load_inertia_kgm2: value[2],
            load_inertia_deviation_kgm2: value[3],
            viscous_nm_s_per_rad: value[4],
            viscous_deviation_nm_s_per_rad: value[5],
            coulomb_nm: value[6],
            coulomb_deviation_nm: value[7],
            constant_nm: value[8],
            constant_deviation_nm: value[9],
            correlations: correlations.map(|value| if special % 3 == 0 { 0.0 } else { value }),
        };
        let warm = remembering(&config, learned);
        let start = AxisStart::at(0.0);
        let Ok(mut runner) = build_runner_from(&warm, MethodId::ADAPTIVE, &start) else {
            prop_assert!(learned.check().is_err());
            return Ok(());
        };
        prop_assert!(learned.check().is_ok());
        let motion = |t: f64| circle(10.0, 5.0, t);
        let mut out = AxisOutput::new(false);
        runner.push(&setpoints(&motion, 1.5), &mut out).unwrap();
        prop_assert!(out.load.iter().all(|load| load.is_finite()));
    }
}

#[test]
fn a_memory_that_does_not_tell_the_friction_is_not_used() {
    let cold = mill_x(0.1, 60.0, None);
    let (learned, rated_nm) = (learned(&cold, 6.0), cold.motor.rated_torque_nm);
    let with = |coulomb: f64, deviation: f64| Learned {
        coulomb_nm: coulomb * rated_nm,
        coulomb_deviation_nm: deviation * rated_nm,
        ..learned
    };
    let motion = |t: f64| circle(10.0, 5.0, t);
    let load = |config: &AxisConfig| run(config, "adaptive", &motion, 4.0).load;
    // the axis starts cold, whatever is said of gap and inertia
    let untold = remembering(&cold, with(0.1, 0.006));
    assert_eq!(load(&untold), load(&cold));
    assert!(load(&remembering(&cold, learned)) != load(&cold));
    // that it holds the load has to be certain by three deviations: 0.5 % of the rated torque
    let floats = |learned| AxisMemory::new(learned, &cold).learned.floats;
    assert!(!floats(learned) && !floats(with(0.01, 0.0016)));
    assert!(floats(with(0.01, 0.0017)));
}
