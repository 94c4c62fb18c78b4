//! `lostmotion compensate`: a part program rewritten for a control without compensation.

use super::{failure, shown, to_json};
use crate::input;
use crate::options::part::OnMachine;
use crate::options::{Format, number, show, threads, whole};
use crate::output::{DONE, FOUND, Failure, refuse_input, refuse_inputs, write_text};
use clap::{Args, ValueHint};
use lostmotion::report::text;
use lostmotion::sim::SimulateOptions;
use lostmotion::sim::rewrite::{RewriteError, RewriteOptions, rewrite};
use std::path::PathBuf;

/// `compensate`.
#[derive(Debug, Args)]
pub(crate) struct Compensate {
    /// New part program to write
    #[arg(long, short, value_name = "FILE.ngc", value_hint = ValueHint::FilePath)]
    pub(crate) out: PathBuf,
    /// Most that an end point may be moved along an axis, in micrometres: half of the largest gap that is
    /// taken up
    #[arg(long, value_name = "N", default_value_t = 100.0, allow_negative_numbers = true, value_parser = number)]
    pub(crate) most_um: f64,
    /// Most that an end point may be moved besides, along the normal of the contour, in micrometres: against what
    /// friction and servo leave; 0 moves none
    #[arg(long, value_name = "N", default_value_t = 20.0, allow_negative_numbers = true, value_parser = number)]
    pub(crate) normal_um: f64,
    /// How far off the gaps of the machine may be, in per cent; what the machine says of each axis
    /// (`compensation.gap_uncertainty`), if left out. The least that they may be is taken up
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, value_parser = number)]
    pub(crate) gap_uncertainty: Option<f64>,
    /// Tolerance of the contour error in micrometres; the machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) tolerance_um: Option<f64>,
    /// Most moves of a program: half a kilobyte of memory each
    #[arg(long, value_name = "N", default_value_t = 1_000_000, allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) max_moves: usize,
    /// Threads to use at most; all cores, if left out. The answer does not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) threads: Option<usize>,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    #[command(flatten)]
    pub(crate) on: OnMachine,
}

/// Rewrites a program. Exit code 0 where it is written and keeps the tolerance, 1 where it does not,
/// or does not help and is not written.
pub(crate) fn run(args: &Compensate, quiet: bool) -> Result<u8, Failure> {
    let voice = args.on.setup.reading.voice(quiet);
    // Asked for the good range, which NaN is outside of.
    for (flag, value, most) in [
        ("--most-um", args.most_um, 10_000.0),
        ("--normal-um", args.normal_um, 10_000.0),
        (
            "--gap-uncertainty",
            args.gap_uncertainty.unwrap_or(0.0),
            99.0,
        ),
    ] {
        if !(0.0..=most).contains(&value) {
            return Err(Failure::message(format!(
                "{flag} is {value}; it has to be from 0 to {most}"
            )));
        }
    }
    refuse_input(&args.out, &args.on.part, "part program")?;
    refuse_inputs(&args.out, args.on.setup.on.inputs())?;
    let program = input::program(&args.on.part)?;
    let machine = args.on.machine()?;
    let options = SimulateOptions {
        tolerance_um: args.tolerance_um,
        threads: threads(args.threads)?,
        ..SimulateOptions::default()
    };
    let options = args.on.options(&machine, options)?;
    let wanted = RewriteOptions {
        most_um: args.most_um,
        most_normal_um: args.normal_um,
        gap_uncertainty: args.gap_uncertainty.map(|percent| 0.01 * percent),
        max_moves: args.max_moves,
    };
    let answer = rewrite(&program, &machine, &options, &wanted).map_err(|error| match error {
        RewriteError::Sim(error) => failure(&program, &error, voice),
        RewriteError::Lines(all) => {
            let lines = all
                .iter()
                .map(|error| format!("{}: {error}", program.name()));
            Failure::message(lines.collect::<Vec<_>>().join("\n"))
        }
        other => Failure::message(format!("{}: {other}", program.name())),
    })?;
    if answer.refused.is_none() {
        write_text(&args.out, &answer.bytes)?;
    }
    let name = args.out.display().to_string();
    let text = text::rewritten(&name, &answer, &shown());
    show(args.format, &to_json(&answer)?, &text)?;
    Ok(if answer.is_within_tolerance() {
        DONE
    } else {
        FOUND
    })
}
