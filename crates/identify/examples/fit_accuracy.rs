//! Prints how well the fit does on simulated logs: error over friction and encoder, coverage of the
//! interval; or, for kinds of logs as a workshop records them, what each fit found.
//!
//! `cargo run --release -p lostmotion-identify --example fit_accuracy [seconds of log]`
//! `cargo run --release -p lostmotion-identify --example fit_accuracy logs PART_OF_KIND FIRST_SEED LOGS`

#[path = "../tests/it/rig/mod.rs"]
#[allow(dead_code, unreachable_pub, clippy::unwrap_used)]
mod rig;

use lostmotion_identify::fit_backlash;
use rig::score::{KINDS, Kind, Score};
use rig::{RATED_TORQUE, Rig};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [first, part, seed, logs] = arguments.as_slice()
        && first == "logs"
        && let (Ok(seed), Ok(logs)) = (seed.parse::<u64>(), logs.parse::<u64>())
    {
        return recorded(part, seed..seed + logs);
    }
    let seconds = std::env::args()
        .nth(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(10.0);
    println!(
        "half gap [rad]  friction  counts   error [%]  interval [%]  c error [%]  used  sides  iterations"
    );
    for half_gap in [1e-1, 6.283e-3, 6.283e-4] {
        for share in [0.0, 0.02, 0.1, 0.3] {
            for counts in [0, 1 << 23, 1 << 20, 1 << 17] {
                let rig = Rig {
                    half_gap,
                    friction: share * RATED_TORQUE,
                    counts,
                    seed: 5,
                    ..Rig::default()
                };
                match fit_backlash(&rig.run(seconds), &rig.settings()) {
                    Ok(fit) => println!(
                        "{half_gap:13.3e} {share:9.2} {counts:9} {:10.4} {:12.4} {:12.4} {:6} {:6} {:6}",
                        100.0 * (fit.half_gap_rad / half_gap - 1.0),
                        50.0 * (fit.half_gap_interval_rad[1] - fit.half_gap_interval_rad[0])
                            / half_gap,
                        100.0 * (fit.compliance_rad_per_nm * rig.stiffness - 1.0),
                        fit.samples_used,
                        fit.traversals,
                        fit.solver.iterations
                    ),
                    Err(error) => println!("{half_gap:13.3e} {share:9.2} {counts:9} {error}"),
                }
            }
        }
    }
    for half_gap in [6.283e-3, 6.283e-4] {
        let rig = Rig {
            half_gap,
            friction: 0.1 * RATED_TORQUE,
            seed: 5,
            ..Rig::default()
        };
        let log = rig.run(seconds);
        for (constant, inertia) in [(1.03, 1.0), (1.0, 1.1)] {
            let mut settings = rig.settings();
            settings.torque_constant_nm_per_a *= constant;
            settings.motor_inertia_kgm2 = Some(rig.motor_inertia * inertia);
            if let Ok(fit) = fit_backlash(&log, &settings) {
                let error = 100.0 * (fit.half_gap_rad / half_gap - 1.0);
                println!(
                    "half gap {half_gap:.3e}, torque constant times {constant}, motor inertia times {inertia}: error {error:+.3} %"
                );
            }
        }
    }
    for (name, pulls, noise) in [
        ("pushes only", false, 0.0),
        ("pushes only, 20 mA", false, 0.02),
        ("pulls too", true, 0.0),
    ] {
        let covered = (0..200).filter(|&seed| covers(seed, pulls, noise)).count();
        println!("{name}: interval covers the truth in {covered} of 200 logs of 3 s");
    }
}

/// What is found on the logs of some kinds, and the row of each kind in the book's table.
fn recorded(part: &str, seeds: std::ops::Range<u64>) {
    let whole = KINDS.iter().any(|kind| kind.name == part);
    let wanted = |kind: &Kind| kind.name == part || !whole && kind.name.contains(part);
    for kind in KINDS.into_iter().filter(wanted) {
        let score = Score::of(kind, seeds.clone(), |axis, truth, fit| {
            let of_truth = |value: f64| 100.0 * (value / truth - 1.0);
            let found = match fit {
                Ok(fit) => {
                    let [low, high] = fit.half_gap_interval_rad.map(of_truth);
                    format!(
                        "{:+.2} % ({low:+.2} to {high:+.2}){}",
                        of_truth(fit.half_gap_rad),
                        if low > 0.0 || high < 0.0 {
                            " MISSED"
                        } else {
                            ""
                        }
                    )
                }
                Err(error) => error.to_string(),
            };
            println!(
                "{} {:.1} um, {:.0} N/um, lead {}, friction {:.1} %, noise {:.1} %, {:?}: {found}",
                axis.seed,
                axis.gap_um,
                axis.stiffness_n_per_um,
                axis.lead_mm,
                100.0 * axis.load_coulomb / axis.rated_torque,
                100.0 * axis.noise,
                axis.friction,
            );
        });
        println!("| {} | {seeds:?} | {} |", kind.name, score.row());
    }
}

fn covers(seed: u64, pulls: bool, current_noise: f64) -> bool {
    let mut random = lostmotion_base::Random::new(seed);
    let half_gap = 6e-4 * lostmotion_base::math::pow(100.0, random.unit());
    let friction = RATED_TORQUE * random.between(0.0, 0.3);
    let load_inertia = 0.00189 * random.between(0.5, 8.0);
    let offset = random.between(-0.01, 0.01);
    let rig = Rig {
        half_gap,
        friction,
        load_inertia,
        offset,
        pulls,
        current_noise,
        seed: seed + 1000,
        ..Rig::default()
    };
    match fit_backlash(&rig.run(3.0), &rig.settings()) {
        Ok(fit) => {
            (fit.half_gap_interval_rad[0]..=fit.half_gap_interval_rad[1]).contains(&half_gap)
        }
        Err(error) => {
            println!("{error}");
            false
        }
    }
}
