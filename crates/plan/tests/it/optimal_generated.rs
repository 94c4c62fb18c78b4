//! Generated programs planned with quality `optimal`: every limit, and no slower than `fast`.

use crate::common::generate::program;
use crate::common::{LIMITS, continuous, optimal, peaks};
use lostmotion_plan::Sample;

fn seconds(samples: &[Sample]) -> f64 {
    (samples.len() - 1) as f64 * 1e-3
}

/// Largest part of the limits of acceleration and jerk that any joint takes.
fn used(samples: &[Sample]) -> f64 {
    (0..3)
        .map(|joint| peaks(samples, joint))
        .map(|[_, a, j]| (a / LIMITS.acceleration).max(j / LIMITS.jerk))
        .fold(0.0, f64::max)
}

/// Programs, those whose plans of quality `optimal` pass a limit, and how long those and the plans
/// of `fast` take in all, s.
fn optimal_plans(seeds: std::ops::Range<u64>) -> (usize, [f64; 2]) {
    let (mut beyond, mut time_s) = (0, [0.0; 2]);
    for seed in seeds {
        let program = program(
            seed,
            continuous([0.002, 0.01, 0.05][(seed % 3) as usize]),
            20.0 + (seed % 7) as f64 * 20.0,
        );
        let (fast, samples) = (program.run(), program.run_with(optimal()));
        time_s = [time_s[0] + seconds(&fast), time_s[1] + seconds(&samples)];
        let used = used(&samples);
        // Rounding of positions of some hundred mm makes differences of about 1e-5 of the limit.
        if used > 1.0 + 1e-4 {
            println!("program {seed}: {used}");
            beyond += 1;
        }
    }
    (beyond, time_s)
}

#[test]
fn optimal_plans_keep_every_limit_and_are_faster() {
    let (beyond, [fast, optimal]) = optimal_plans(0..25);
    assert!(beyond == 0 && optimal < fast, "{beyond}: {fast} {optimal}");
}

#[test]
fn optimal_plans_keep_every_limit_on_many() {
    let (beyond, time_s) = optimal_plans(2000..2500);
    assert_eq!(beyond, 0, "{time_s:?}");
}
