//! `lostmotion plan`: the planned motion of every axis as CSV.

use super::{failure, found};
use crate::findings::Form;
use crate::input;
use crate::options::machine::Cycles;
use crate::options::part::OnMachine;
use crate::options::{Interventions, Quality, number, threads, whole};
use crate::output::{self, DONE, Failure, remark};
use clap::{Args, ValueHint};
use lostmotion::contour::ProgrammedSegment;
use lostmotion::drive::config::Cycles as CyclesConfig;
use lostmotion::plan::Sample;
use lostmotion::report::csv::PlanWriter;
use lostmotion::report::{WriteError, number, text};
use lostmotion::sim::{BowLimit, SimError, SimulateOptions, Simulation};
use std::path::PathBuf;

/// `plan`.
#[derive(Debug, Args)]
pub(crate) struct Plan {
    /// Time from row to row, 0.25 to 8 ms; the machine's command cycle, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) command_ms: Option<f64>,
    /// How much effort to put into the cycle time
    #[arg(long, value_enum, default_value_t)]
    pub(crate) quality: Quality,
    /// How far the tool may leave its path between two setpoints, in micrometres; the motion slows
    /// down to keep it. If left out the machine's, or 5, which is kept if a drive interpolates
    /// linearly and only warned about otherwise
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) bow_limit_um: Option<f64>,
    /// CSV to write: t_s, a position per axis (x_mm ... c_deg), source line
    #[arg(long, short, value_name = "FILE.csv", value_hint = ValueHint::FilePath)]
    pub(crate) out: PathBuf,
    /// Threads to use at most; all cores, if left out. The plan does not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) on: OnMachine,
    #[command(flatten)]
    pub(crate) interventions: Interventions,
}

/// Cycles of a plan: only the command's matters; the servo's is one that divides it.
fn planned(command_ms: Option<f64>, own: CyclesConfig) -> Result<CyclesConfig, Failure> {
    let Some(command_ms) = command_ms else {
        return Ok(own);
    };
    // The servo's cycle has to divide the command's and to be 1 ms at most: halved until it is.
    let servo_us = (0..4)
        .map(|halves| command_ms * 1e3 / f64::from(1 << halves))
        .find(|us| *us <= 1000.0);
    let asked = Cycles {
        command_ms: Some(command_ms),
        servo_us,
    };
    asked.over(own)
}

/// Writes the plan of a program as CSV.
pub(crate) fn run(args: &Plan, quiet: bool) -> Result<u8, Failure> {
    let voice = args.on.setup.reading.voice(quiet);
    let program = input::program(&args.on.part)?;
    let machine = args.on.machine()?;
    let machine = machine.with_cycles(planned(args.command_ms, machine.cycles())?);
    let unwritten = |error| Failure::from(WriteError::io("write", &args.out, error));
    // A file that cannot be written is found before the planning, not after it.
    output::refuse_input(&args.out, &args.on.part, "part program")?;
    output::refuse_inputs(&args.out, args.on.setup.on.inputs())?;
    let create = output::create(&args.out)?;
    let mut writer = PlanWriter::new(
        create,
        machine.axis_set(),
        machine.rotary_joints(),
        machine.cycles().command(),
    )
    .map_err(unwritten)?;
    // Rows go out while the plan is made: memory does not grow with the program.
    let mut sink =
        |samples: &[Sample], _: &[ProgrammedSegment]| writer.push(samples).map_err(Into::into);
    let (quality, interventions) = (args.quality.of_planner(), args.interventions.read()?);
    let options = SimulateOptions {
        quality,
        interventions,
        bow_limit_um: args.bow_limit_um,
        threads: threads(args.threads)?,
        ..args.on.options(&machine, SimulateOptions::default())?
    };
    let info = Simulation::new(&program, &machine)
        .options(options.clone())
        .plan(&mut sink)
        .map_err(|error| match error {
            // The planner only hands the writer's error through.
            SimError::Sink(why) => {
                Failure::message(format!("cannot write {}: {why}", args.out.display()))
            }
            other => failure(&program, &other, voice),
        })?;
    // A plan has no answer that would name them.
    if !quiet || voice.diagnostics != Form::Text {
        found(&program, &machine, &options)?.remark(voice)?;
    }
    writer.finish().map_err(unwritten)?.commit()?;
    if !quiet {
        output::print(&format!(
            "{}: {}, {} mm cutting, {} mm rapid\n",
            args.out.display(),
            number::duration(info.duration_s),
            number::fixed(info.cutting_mm, 1),
            number::fixed(info.rapid_mm, 1)
        ))?;
        output::print(&text::straightness(&info))?;
        // Where no limit is kept the motion does not slow down for the bow: it is only told.
        if let Some(warning) = info.bow_warning(BowLimit::new(&machine, &options).um) {
            remark(&format!("warning: {warning}"));
        }
        let warnings = [info.late_warning(), info.shortfall_warning()];
        for warning in warnings.into_iter().flatten() {
            remark(&format!("warning: {warning}"));
        }
    }
    Ok(DONE)
}
