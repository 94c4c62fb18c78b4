//! `lostmotion simulate`.

use super::{DONE, OUTSIDE, accepted, check_fit, failure, prepare, show, text_options, to_json};
use crate::args::run::Simulate;
use crate::failure::Failure;
use crate::output::stdout_has_color;
use crate::record::{Answer, Record};
use crate::voice::Voice;
use lostmotion::report::text;
use lostmotion::sim::Simulation;

/// Runs a program with one method. Exit code 0 within tolerance, 1 outside.
pub(crate) fn run(args: &Simulate, voice: Voice) -> Result<u8, Failure> {
    let (program, machine, options) = prepare(&args.run)?;
    check_fit(&args.method, &machine)?;
    let mut record = Record::new(&args.run, std::slice::from_ref(&args.method), voice.quiet)?;
    let run = Simulation::new(&program, &machine)
        .method(&args.method)
        .options(options.clone())
        .observer(&mut record)
        .run()
        .map_err(|error| failure(&program, &error, voice))?;
    let simulation = run
        .into_single()
        .ok_or_else(|| Failure::message("no method was run".to_owned()))?;
    accepted(&program, &machine, &options, voice)?;
    let json = to_json(&simulation)?;
    let plain = text::simulation(&simulation, &text_options(false));
    record.finish(&Answer {
        program: &simulation.program.name,
        machine: &simulation.machine,
        duration_s: simulation.plan.duration_s,
        tolerance_um: simulation.tolerance_um,
        results: std::slice::from_ref(&simulation.result),
        json_name: "simulation.json",
        json: &json,
        text_name: "simulation.txt",
        text: &plain,
    })?;
    show(
        args.run.format,
        &json,
        &text::simulation(&simulation, &text_options(stdout_has_color())),
    )?;
    Ok(if simulation.result.within_tolerance {
        DONE
    } else {
        OUTSIDE
    })
}
