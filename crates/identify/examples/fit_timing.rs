//! Times the fit of a long log, with window averages and, as a burden on the solver, with every
//! sample (whose acceleration is too noisy to be of use), and prints the peak memory where the
//! system tells it.
//!
//! `cargo run --release -p lostmotion-identify --example fit_timing [seconds of log]`

#[path = "../tests/it/rig/mod.rs"]
#[allow(dead_code, unreachable_pub, clippy::unwrap_used)]
mod rig;

use lostmotion_identify::{FitSettings, fit_backlash};

fn main() {
    let seconds = std::env::args()
        .nth(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(60.0);
    let rig = rig::Rig {
        friction: 1.0,
        ..rig::Rig::default()
    };
    let log = rig.run(seconds);
    println!(
        "log of {seconds} s at {} us: {} samples, peak memory {}",
        log.period_s() * 1e6,
        log.len(),
        peak()
    );
    for (name, half_window_s) in [
        ("averages", FitSettings::default().half_window_s),
        ("every sample", log.period_s()),
    ] {
        let settings = FitSettings {
            half_window_s,
            ..rig.settings()
        };
        let start = std::time::Instant::now();
        match fit_backlash(&log, &settings) {
            Ok(fit) => println!(
                "{name}: {:.3} s, error {:+.4} %, {} used, {} explicit in the last of {} solves, {} iterations, {}, optimality {:.1e}, peak memory {}",
                start.elapsed().as_secs_f64(),
                100.0 * (fit.half_gap_rad / rig.half_gap - 1.0),
                fit.samples_used,
                fit.solver.explicit_samples,
                fit.solver.solves,
                fit.solver.iterations,
                fit.solver.status,
                fit.solver.optimality,
                peak()
            ),
            Err(error) => println!("{name}: {error}"),
        }
    }
}

fn peak() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .map_or("unknown".to_owned(), |peak| peak.trim().to_owned())
}
