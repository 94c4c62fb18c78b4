//! How near sound machines come to being stopped: every machine with every method on every sample
//! part that fits it, and the largest part of each limit that was used.
//!
//! `cargo run --release --example stop_margins` takes all of them, which is hours; with arguments
//! only the machines and parts whose names contain one of them.

use lostmotion::methods::MethodId;
use lostmotion::sim::presets;
use lostmotion::sim::results::LimitsUsed;
use lostmotion::{Machine, Program, Simulation};
use std::path::Path;

/// The largest part of a limit, and where.
struct Most {
    limit: &'static str,
    of: fn(&LimitsUsed) -> f64,
    used: f64,
    place: String,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let takes = |name: &str| wanted.is_empty() || wanted.iter().any(|part| name.contains(part));
    let most = |limit, of| Most {
        limit,
        of,
        used: 0.0,
        place: String::new(),
    };
    let mut all = [
        most("following error", |used: &LimitsUsed| used.following_error),
        most("travel", |used: &LimitsUsed| used.travel),
        most("overload", |used: &LimitsUsed| used.overload),
        most("time at the drive's limit", |used: &LimitsUsed| {
            used.at_limit
        }),
    ];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("gcode_samples/parts");
    let mut parts: Vec<_> = std::fs::read_dir(folder)?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_, std::io::Error>>()?;
    parts.sort();
    let (mut runs, mut stops) = (0_u32, 0_u32);
    for preset in presets() {
        let machine = Machine::preset(preset.name)?;
        for path in &parts {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if !takes(preset.name) && !takes(&name) {
                continue;
            }
            let program = Program::from_str(&*name, &std::fs::read_to_string(path)?);
            let methods = MethodId::all().map(MethodId::name);
            let run = match Simulation::new(&program, &machine).methods(methods).run() {
                Ok(run) => run,
                // Made for another machine.
                Err(_) => continue,
            };
            for result in &run.results {
                runs += 1;
                let place = format!("{} {name} {}", preset.name, result.method);
                if let Some(stop) = &result.stop {
                    stops += 1;
                    println!(
                        "stops: {place}: {} {:?} at {:.3} s: {}",
                        stop.axis, stop.limit, stop.time_s, stop.reason
                    );
                    continue;
                }
                for most in &mut all {
                    for used in &result.limits_used {
                        let share = (most.of)(used);
                        if share > most.used {
                            most.used = share;
                            most.place = format!("{place} {}", used.axis);
                        }
                    }
                }
            }
        }
    }
    println!("{runs} runs, {stops} stops; of the others the most of each limit:");
    for most in &all {
        println!(
            "{:>26}: {:>5.1} % {}",
            most.limit,
            1e2 * most.used,
            most.place
        );
    }
    Ok(())
}
