//! `lostmotion plan`.

use super::{DONE, accepted, failure};
use crate::args::drives::Cycles as Given;
use crate::args::run::Plan;
use crate::failure::Failure;
use crate::voice::Voice;
use crate::{drives, input};
use lostmotion::contour::ProgrammedSegment;
use lostmotion::drive::config::Cycles;
use lostmotion::plan::Sample;
use lostmotion::report::atomic::AtomicFile;
use lostmotion::report::csv::PlanWriter;
use lostmotion::report::{WriteError, number, text};
use lostmotion::sim::{BowLimit, SimError, SimulateOptions, Simulation};

/// Cycles of a plan: that of the command counts alone, and any servo's that goes with it will do.
fn planned(command_ms: Option<f64>, own: Cycles) -> Result<Cycles, Failure> {
    let Some(command_ms) = command_ms else {
        return Ok(own);
    };
    let servo_us = (0..4)
        .map(|halves| command_ms * 1e3 / f64::from(1 << halves))
        .find(|us| *us <= 1000.0);
    drives::cycles(
        Given {
            command_ms: Some(command_ms),
            servo_us,
        },
        own,
    )
}

/// Writes the plan of a program as CSV.
pub(crate) fn run(args: &Plan, voice: Voice) -> Result<u8, Failure> {
    let program = input::program(&args.on.part)?;
    let machine = args.on.machine()?;
    let machine = machine.with_cycles(planned(args.command_ms, machine.cycles())?);
    let unwritten = |error| Failure::from(WriteError::io("write", &args.out, error));
    let create = AtomicFile::create(&args.out)?;
    let mut writer = PlanWriter::new(
        create,
        machine.axis_set(),
        machine.rotary_joints(),
        machine.cycles().command(),
    )
    .map_err(unwritten)?;
    let mut sink =
        |samples: &[Sample], _: &[ProgrammedSegment]| writer.push(samples).map_err(Into::into);
    let (quality, interventions) = (args.quality.of_planner(), args.interventions.read()?);
    let options = SimulateOptions {
        quality,
        interventions,
        bow_limit_um: args.bow_limit_um,
        ..args.on.options(&machine, SimulateOptions::default())?
    };
    let info = Simulation::new(&program, &machine)
        .options(options.clone())
        .plan(&mut sink)
        .map_err(|error| match error {
            SimError::Sink(why) => {
                Failure::message(format!("cannot write {}: {why}", args.out.display()))
            }
            other => failure(&program, &other, voice),
        })?;
    accepted(&program, &machine, &options, voice)?;
    writer.finish().map_err(unwritten)?.commit()?;
    if !voice.quiet {
        crate::output::print(&format!(
            "{}: {}, {} mm cutting, {} mm rapid\n",
            args.out.display(),
            number::duration(info.duration_s),
            number::fixed(info.cutting_mm, 1),
            number::fixed(info.rapid_mm, 1)
        ))?;
        crate::output::print(&text::straightness(&info))?;
        if let Some(warning) = info.bow_warning(BowLimit::new(&machine, &options).um) {
            eprintln!("warning: {warning}");
        }
    }
    Ok(DONE)
}
