//! `lostmotion axis testpart`: the program to run on a machine in order to measure it.

use crate::findings::{Form, Voice};
use crate::options::machine::MachineOptions;
use crate::options::{Names, number};
use crate::output::{self, DONE, Failure, remark};
use crate::parts::failure;
use clap::{Args, ValueEnum, ValueHint};
use lostmotion::gcode::Dialect;
use lostmotion::report::number;
use lostmotion::sim::testpart::{TestKind, TestOptions, program};
use lostmotion::{Program, Simulation};
use std::path::PathBuf;

/// What is to be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PartKind {
    /// Circles of three sizes and two feeds in both senses
    Circle,
    /// Places that are come to from both sides: reversal value B of ISO 230-2
    Reversal,
    /// One circle in both senses with half a turn before and behind
    Ballbar,
    /// The motion that teaches an axis its load and its gap; LinuxCNC alone
    Commission,
    /// Strokes at steady speeds both ways: friction over speed
    Friction,
}

/// `axis testpart`.
#[derive(Debug, Args)]
pub(crate) struct Testpart {
    /// What to measure
    #[arg(long = "for", value_enum, value_name = "WHAT")]
    pub(crate) kind: PartKind,
    /// Dialect of the control; the machine's, if left out
    #[arg(long, value_name = "NAME", value_parser = dialects())]
    pub(crate) dialect: Option<String>,
    /// Radius of the circle, mm; the largest of 300, 150, 100 and 50 that fits, if left out
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = number)]
    pub(crate) radius_mm: Option<f64>,
    /// Feed of the circle, mm/min; 1000, or less where the limits ask for it, if left out
    #[arg(long, value_name = "MM_MIN", allow_negative_numbers = true, value_parser = number)]
    pub(crate) feed: Option<f64>,
    /// Part program to write; stdout, if left out
    #[arg(long, short, value_name = "FILE.ngc", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) on: MachineOptions,
}

fn dialects() -> Names {
    Names::new("dialect", Dialect::ALL.map(|dialect| (dialect.name(), "")))
}

/// Writes the program, once the machine as it is described has run it.
pub(crate) fn run(args: &Testpart, quiet: bool) -> Result<u8, Failure> {
    if args.on.machine.is_none() {
        return Err(Failure::with_hint(
            "a test is written for the travel and the limits of a machine",
            "name it: --machine mill.toml",
        ));
    }
    if let Some(out) = &args.out {
        output::refuse_inputs(out, args.on.inputs())?;
    }
    let machine = args.on.load()?;
    let dialect = match &args.dialect {
        Some(name) => Some(Dialect::from_name(name).ok_or_else(|| dialects().refusal(name))?),
        None => None,
    };
    let kind = match args.kind {
        PartKind::Circle => TestKind::Circle,
        PartKind::Reversal => TestKind::Reversal,
        PartKind::Ballbar => TestKind::Ballbar,
        PartKind::Commission => TestKind::Commission,
        PartKind::Friction => TestKind::Friction,
    };
    let options = TestOptions {
        dialect,
        radius_mm: args.radius_mm,
        feed_mm_min: args.feed,
    };
    let text =
        program(&machine, kind, &options).map_err(|error| Failure::message(error.to_string()))?;
    // Programs for Siemens are not read: the same moves, written for LinuxCNC, are.
    let dialect = dialect.unwrap_or(machine.dialect());
    let (read, dialect) = match dialect {
        Dialect::Siemens => {
            let options = TestOptions {
                dialect: Some(Dialect::LinuxCnc),
                ..options
            };
            let same = program(&machine, kind, &options);
            let same = same.map_err(|error| Failure::message(error.to_string()))?;
            (same, Dialect::LinuxCnc)
        }
        _ => (text.clone(), dialect),
    };
    let written = Program::from_str("the test", &read);
    let voice = Voice {
        quiet,
        diagnostics: Form::Text,
    };
    let run = Simulation::new(&written, &machine)
        .dialect(dialect)
        .threads(0)
        .run()
        .map_err(|error| failure(&written, &error, voice))?;
    let stop = run.results.first().and_then(|result| result.stop.as_ref());
    if let Some(stop) = stop {
        return Err(Failure::with_hint(
            format!(
                "machine \"{}\" as it is described stops on the test after {}: nothing is written",
                machine.name(),
                number::duration(stop.time_s)
            ),
            "take a lower feed, or correct the description: `machine check`",
        ));
    }
    match &args.out {
        Some(out) => output::write_text(out, &text)?,
        None => output::print(&text)?,
    }
    if !quiet {
        remark(&format!(
            "{kind} for {}: {} as simulated on the machine, {} mm cutting, all within travel and limits",
            machine.name(),
            number::duration(run.plan.duration_s),
            number::fixed(run.plan.cutting_mm, 1)
        ));
    }
    Ok(DONE)
}
