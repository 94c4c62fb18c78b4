//! What a sweep costs beyond its simulations: the cells of a manifest once with their machines made
//! beforehand and nothing kept, and once as `study sweep run` runs them.
//!
//! `cargo run --release -p lostmotion-sweep --example overhead MANIFEST.jsonl RESULTS.jsonl`

use lostmotion_sim::{Machine, Program, Simulation};
use lostmotion_sweep::inputs::Inputs;
use lostmotion_sweep::manifest::Manifest;
use lostmotion_sweep::missing::{Missing, Shard};
use lostmotion_sweep::results::Results;
use lostmotion_sweep::run::run_cells;
use std::error::Error;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

/// Seconds that the processors have worked for this process: unlike the time of day it does not
/// count what others do on the same machine. Linux counts in hundredths.
fn processor_s() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = text
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split(' ')
        .collect();
    let field = |index: usize| fields.get(index).and_then(|f| f.parse::<f64>().ok());
    0.01 * (field(12).unwrap_or_default() + field(13).unwrap_or_default())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [manifest, out] = arguments.as_slice() else {
        return Err("two arguments: a manifest, and a file of results to write".into());
    };
    let folder = Path::new(manifest).parent().unwrap_or(Path::new("."));
    let manifest = Manifest::read(Path::new(manifest))?;
    let header = &manifest.header;
    let missing = Missing::of(&manifest, Shard::WHOLE, &Default::default())?;

    let programs: Vec<Program> = header
        .programs
        .iter()
        .map(|input| {
            std::fs::read(folder.join(&input.name)).map(|text| Program::from_bytes("program", text))
        })
        .collect::<Result<_, _>>()?;
    let mut jobs = Vec::new();
    for cell in missing.cells(&manifest)? {
        let cell = cell?;
        let preset = lostmotion_sim::presets()
            .iter()
            .find(|preset| preset.name == header.machine(&cell));
        let preset = preset.ok_or("machines have to be presets")?;
        let machine =
            Machine::from_changed_toml("machine", preset.toml, &header.changes(&cell.values))?;
        jobs.push((programs.get(cell.program).ok_or("no program")?, machine));
    }
    let (began, worked, next) = (Instant::now(), processor_s(), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some((program, machine)) = jobs.get(next.fetch_add(1, Ordering::Relaxed))
                {
                    let options = lostmotion_sim::SimulateOptions {
                        misled_share: Some(0.0),
                        ..Default::default()
                    };
                    let run = Simulation::new(program, machine)
                        .options(options)
                        .methods(&header.methods)
                        .run();
                    assert!(run.is_ok());
                }
            });
        }
    });
    let pure = (began.elapsed().as_secs_f64(), processor_s() - worked);
    drop(jobs);

    let (began, worked) = (Instant::now(), processor_s());
    let (mut results, _) = Results::open(Path::new(out))?;
    let inputs = Inputs::load(header, &missing.needs, folder)?;
    let done = run_cells(
        &inputs,
        (missing.cells(&manifest)?, missing.len()),
        2,
        &AtomicBool::new(false),
        &mut |result, _| results.append(result),
    )?;
    results.sync()?;
    let swept = (began.elapsed().as_secs_f64(), processor_s() - worked);

    println!("{} cells, {:.0} s of motion", done.done, done.simulated_s);
    println!(
        "simulations alone: {:.2} s, processors {:.2} s",
        pure.0, pure.1
    );
    println!(
        "as a sweep:        {:.2} s, processors {:.2} s",
        swept.0, swept.1
    );
    println!(
        "overhead: {:.1} % of the processors' time",
        100.0 * (swept.1 / pure.1 - 1.0)
    );
    Ok(())
}
