//! `lostmotion recommend`: what to set on a control for a part program on a machine.

use super::{failure, shown, to_json};
use crate::input;
use crate::options::part::OnMachine;
use crate::options::{Format, Names, number, show, threads, whole};
use crate::output::{DONE, FOUND, Failure};
use clap::Args;
use lostmotion::report::text;
use lostmotion::sim::SimulateOptions;
use lostmotion::sim::control::{Control, UnknownControl};
use lostmotion::sim::recommend::{RecommendOptions, recommend};

/// `recommend`.
#[derive(Debug, Args)]
pub(crate) struct Recommend {
    /// Control that is set; the machine's (`simulate.control`), if left out
    #[arg(long = "for", value_name = "CONTROL", value_parser = named_controls())]
    pub(crate) control: Option<String>,
    /// How far off the gap of the machine may be, in per cent; what the machine says of each axis
    /// (`compensation.gap_uncertainty`), if left out. The least that it may be is set
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, value_parser = number)]
    pub(crate) gap_uncertainty: Option<f64>,
    /// Detection unit of a Fanuc control, in micrometres
    #[arg(long, value_name = "N", default_value_t = 1.0, allow_negative_numbers = true, value_parser = number)]
    pub(crate) detection_unit_um: f64,
    /// Tolerance of the contour error in micrometres; the machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) tolerance_um: Option<f64>,
    /// Threads to use at most; all cores, if left out. The answer does not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) threads: Option<usize>,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    #[command(flatten)]
    pub(crate) on: OnMachine,
}

/// Names of controls, with what their users call them.
fn named_controls() -> Names {
    let names = Control::ALL.map(|control| (control.name(), ""));
    let aliases = Control::ALIASES.map(|(alias, _)| (alias, ""));
    Names::new("control", names.into_iter().chain(aliases))
}

/// Recommends settings. Exit code 0 where they keep the tolerance, 1 where they do not or nothing
/// can be set.
pub(crate) fn run(args: &Recommend, quiet: bool) -> Result<u8, Failure> {
    let voice = args.on.setup.reading.voice(quiet);
    let program = input::program(&args.on.part)?;
    let machine = args.on.machine()?;
    let control = match &args.control {
        Some(name) => name
            .parse()
            .map_err(|error: UnknownControl| Failure::message(error.to_string()))?,
        None => machine.simulate().control.ok_or_else(|| {
            Failure::with_hint(
                format!(
                    "machine \"{}\" does not say which control it has",
                    machine.name()
                ),
                "name it: --for linuxcnc, or simulate.control in the machine file",
            )
        })?,
    };
    let options = SimulateOptions {
        tolerance_um: args.tolerance_um,
        threads: threads(args.threads)?,
        ..SimulateOptions::default()
    };
    let options = args.on.options(&machine, options)?;
    let wanted = RecommendOptions {
        gap_uncertainty: args.gap_uncertainty.map(|percent| 0.01 * percent),
        detection_unit_um: args.detection_unit_um,
    };
    let answer = recommend(&program, &machine, &options, control, &wanted)
        .map_err(|error| failure(&program, &error, voice))?;
    let text = text::control_settings(&answer, &shown());
    show(args.format, &to_json(&answer)?, &text)?;
    Ok(if answer.is_within_tolerance() {
        DONE
    } else {
        FOUND
    })
}
