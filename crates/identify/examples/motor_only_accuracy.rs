//! Prints how well the fit from the motor alone does on simulated logs: errors over friction,
//! coverage of the interval.
//!
//! `cargo run --release -p lostmotion-identify --example motor_only_accuracy [first seed] [logs] [seconds]`

#[path = "../tests/it/rig/mod.rs"]
#[allow(dead_code, unreachable_pub, clippy::unwrap_used)]
mod rig;

use lostmotion_identify::{BacklashFit, FitError, MotorLog, fit_motor_only};
use rig::{RATED_TORQUE, Rig};

/// Error that is wanted, as a part of the gap.
const WANTED: f64 = 5e-3;

fn main() {
    let mut arguments = std::env::args()
        .skip(1)
        .filter_map(|text| text.parse::<u64>().ok());
    let first: u64 = arguments.next().unwrap_or(1);
    let logs: u64 = arguments.next().unwrap_or(100);
    let seconds = arguments.next().map_or(15.0, |seconds| seconds as f64);
    for share in [0.0, 0.02, 0.05, 0.1, 0.2, 0.3] {
        for half_gap in [1e-1, 6.283e-3, 6.283e-4] {
            let rig = Rig {
                half_gap,
                friction: share * RATED_TORQUE,
                offset: 0.003,
                seed: first,
                ..Rig::default()
            };
            println!(
                "friction {share:.2}, half gap {half_gap:.3e} rad: {}",
                told(&rig, &fit(&rig, 30.0))
            );
        }
    }
    let (mut covered, mut refused, mut errors) = (0, 0, Vec::new());
    for seed in first..first + logs {
        let rig = Rig::random(seed);
        match fit(&rig, seconds) {
            Ok(fit) => {
                covered += u32::from(
                    (fit.half_gap_interval_rad[0]..=fit.half_gap_interval_rad[1])
                        .contains(&rig.half_gap),
                );
                errors.push((fit.half_gap_rad / rig.half_gap - 1.0).abs());
                if errors.last().is_some_and(|error| *error > WANTED) {
                    println!("seed {seed}: {}", outlier(&rig, &fit));
                }
            }
            Err(error) => {
                refused += 1;
                println!("seed {seed}: {error}");
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    let at = |part: f64| {
        errors
            .get((part * errors.len() as f64) as usize)
            .or(errors.last())
            .map_or(f64::NAN, |error| 100.0 * error)
    };
    let within = errors.iter().filter(|error| **error <= WANTED).count();
    println!(
        "{logs} random logs from seed {first}: the interval covers the truth in {covered}, {refused} refused"
    );
    println!(
        "error: median {:.3} %, 95 of 100 {:.3} %, worst {:.3} %; within 0.5 %: {within}",
        at(0.5),
        at(0.95),
        at(1.0)
    );
}

fn fit(rig: &Rig, seconds: f64) -> Result<BacklashFit, FitError> {
    fit_motor_only(
        &MotorLog::from(rig.run(seconds)),
        &rig.settings().motor_only(),
    )
}

fn told(rig: &Rig, fit: &Result<BacklashFit, FitError>) -> String {
    match fit {
        Ok(fit) => format!(
            "error {:+.3} %",
            100.0 * (fit.half_gap_rad / rig.half_gap - 1.0)
        ),
        Err(error) => error.to_string(),
    }
}

fn outlier(rig: &Rig, fit: &BacklashFit) -> String {
    let [low, high] = fit
        .half_gap_interval_rad
        .map(|bound| 100.0 * (bound / rig.half_gap - 1.0));
    let load = fit.load.unwrap_or_default();
    format!(
        "error {:+.2} % ({low:+.2} to {high:+.2}) of {:.2e} rad; friction {:.2}, found {:.2}; J_L {:.5}, found {:+.1} %; compliance {:+.1} %; \
         current noise {:.3}, {} of {} equations from {} changes",
        100.0 * (fit.half_gap_rad / rig.half_gap - 1.0),
        rig.half_gap,
        rig.friction,
        load.coulomb_nm,
        rig.load_inertia,
        100.0 * (load.inertia_kgm2 / rig.load_inertia - 1.0),
        100.0 * (fit.compliance_rad_per_nm * rig.stiffness - 1.0),
        rig.current_noise,
        fit.outliers,
        fit.samples_used,
        fit.traversals,
    )
}
