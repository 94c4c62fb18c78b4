//! The fit against the truth of simulated logs.

use crate::rig::{RATED_TORQUE, Rig};
use lostmotion_base::Random;
use lostmotion_base::math;
use lostmotion_identify::{FitSettings, fit_backlash, solver::SolverStatus};

#[test]
fn half_gap_within_a_tenth_of_a_percent() {
    // 318, 20 and 2 um of total gap at a lead of 10 mm; friction up to 30 % of rated torque
    for half_gap in [1e-1, 6.283e-3, 6.283e-4] {
        for share in [0.0, 0.02, 0.1, 0.3] {
            let rig = Rig {
                half_gap,
                friction: share * RATED_TORQUE,
                offset: 0.003,
                seed: 7,
                ..Rig::default()
            };
            let fit = fit_backlash(&rig.run(4.0), &rig.settings()).unwrap();
            let error = fit.half_gap_rad / half_gap - 1.0;
            assert!(
                error.abs() < 1e-3,
                "gap {half_gap}, friction {share}: {error:+.2e}"
            );
            assert!((fit.offset_rad - 0.003).abs() < 1e-6, "{}", fit.offset_rad);
            // two half gaps of different size, seen from the zero of the log
            let [negative, positive] = fit.flanks_rad();
            assert!(
                (negative - (0.003 - half_gap)).abs() < 1e-3 * half_gap + 1e-6,
                "{negative}"
            );
            assert!(
                (positive - (0.003 + half_gap)).abs() < 1e-3 * half_gap + 1e-6,
                "{positive}"
            );
            assert!(
                (fit.compliance_rad_per_nm * rig.stiffness - 1.0).abs() < 1e-3,
                "{}",
                fit.compliance_rad_per_nm
            );
            assert!(
                (fit.damping_time_s / (rig.damping / rig.stiffness) - 1.0).abs() < 0.105,
                "{}",
                fit.damping_time_s
            );
            assert!(fit.excited && fit.reason.is_none());
            assert_eq!(fit.solver.status, SolverStatus::Solved);
            assert!(fit.solver.optimality < 1e-8, "{:e}", fit.solver.optimality);
        }
    }
}

#[test]
fn interval_covers_the_truth() {
    let mut covered = 0;
    for seed in 0..100 {
        let mut random = Random::new(seed);
        let rig = Rig {
            half_gap: 6e-4 * math::pow(100.0, random.unit()),
            friction: RATED_TORQUE * random.between(0.0, 0.3),
            load_inertia: 0.00189 * random.between(0.5, 8.0),
            offset: random.between(-0.01, 0.01),
            current_noise: random.between(0.0, 0.02),
            pulls: random.unit() < 0.5,
            seed: seed + 5000,
            ..Rig::default()
        };
        let fit = fit_backlash(&rig.run(2.0), &rig.settings()).unwrap();
        let [low, high] = fit.half_gap_interval_rad;
        covered += u32::from(low <= rig.half_gap && rig.half_gap <= high);
        // an interval that covers by being useless proves nothing
        assert!(high - low < 0.02 * rig.half_gap, "{low} {high}");
    }
    assert!(covered >= 93, "{covered} of 100");
}

#[test]
fn a_known_stiffness_and_a_model_without_damping() {
    let rig = Rig {
        friction: 0.5,
        ..Rig::default()
    };
    let log = rig.run(4.0);
    let known = FitSettings {
        stiffness_nm_per_rad: Some(rig.stiffness),
        ..rig.settings()
    };
    let fit = fit_backlash(&log, &known).unwrap();
    assert!((fit.half_gap_rad / rig.half_gap - 1.0).abs() < 1e-3);
    assert!(
        (fit.compliance_rad_per_nm - 1.0 / rig.stiffness).abs() < 1e-15
            && fit.compliance_error_rad_per_nm.abs() < 1e-300
    );
    // wind-up that relaxes while in contact is taken for gap where damping is left out
    let plain = fit_backlash(
        &log,
        &FitSettings {
            fit_damping: false,
            ..rig.settings()
        },
    )
    .unwrap();
    assert!(
        plain.half_gap_rad > rig.half_gap && plain.half_gap_rad < 1.005 * rig.half_gap,
        "{}",
        plain.half_gap_rad
    );
    assert!(plain.residual_rms_rad > 1.5 * fit.residual_rms_rad);
}

#[test]
fn an_unknown_motor_inertia_is_fitted() {
    // with friction, current and acceleration go separate ways, and the inertia itself comes out;
    // without, the gap alone does
    for (friction, inertia_found) in [(0.0, false), (1.0, true), (3.0, true)] {
        let rig = Rig {
            friction,
            ..Rig::default()
        };
        let settings = FitSettings {
            motor_inertia_kgm2: None,
            ..rig.settings()
        };
        let fit = fit_backlash(&rig.run(5.0), &settings).unwrap();
        assert!(
            (fit.half_gap_rad / rig.half_gap - 1.0).abs() < 1e-3,
            "{friction}: {}",
            fit.half_gap_rad
        );
        assert!(
            !inertia_found || (fit.motor_inertia_kgm2 / rig.motor_inertia - 1.0).abs() < 0.02,
            "{}",
            fit.motor_inertia_kgm2
        );
    }
}

#[test]
fn a_millisecond_log_will_do() {
    let rig = Rig {
        period: 1e-3,
        friction: 1.0,
        ..Rig::default()
    };
    let fit = fit_backlash(&rig.run(10.0), &rig.settings()).unwrap();
    assert!(
        (fit.half_gap_rad / rig.half_gap - 1.0).abs() < 5e-3,
        "{}",
        fit.half_gap_rad
    );
}

#[test]
fn the_result_does_not_depend_on_the_run() {
    let rig = Rig::default();
    let log = rig.run(2.0);
    let fits = [(); 2].map(|()| fit_backlash(&log, &rig.settings()).unwrap());
    assert_eq!(fits[0], fits[1]);
}
