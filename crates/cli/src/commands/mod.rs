//! One file a command.

mod axis;
mod canon;
mod compare;
mod explain;
pub(crate) mod fit;
mod format;
mod import;
mod interpreter;
mod lint;
mod machine;
mod plan;
mod reproduce;
mod simulate;
mod study;
mod time;
mod tuning;
mod write;

use crate::args::run::Run;
use crate::args::{Cli, Command, Form, Format};
use crate::diagnostics::Findings;
use crate::failure::Failure;
use crate::voice::Voice;
use crate::{drives, machines};
use lostmotion::base::units::deg;
use lostmotion::gcode::Severity;
use lostmotion::methods::MethodId;
use lostmotion::plan::TravelViolation;
use lostmotion::report::{json, number, text::TextOptions};
use lostmotion::sim::{Machine, Program, SimError, SimulateOptions};
use serde::Serialize;

/// Done, and within tolerance where there is one.
pub(crate) const DONE: u8 = 0;
/// The part comes out outside its tolerance.
pub(crate) const OUTSIDE: u8 = 1;

/// Runs the command asked for; gives its exit code.
pub(crate) fn run(cli: &Cli) -> Result<u8, Failure> {
    match &cli.command {
        Command::Simulate(args) => simulate::run(args, cli.voice),
        Command::Compare(args) => compare::run(args, cli.voice),
        Command::Canon(args) => canon::run(args, cli.voice),
        Command::Lint(args) => lint::run(args, cli.voice),
        Command::Format(args) => format::run(args, cli.voice),
        Command::Explain(args) => explain::run(args, cli.voice),
        Command::Write(args) => write::run(args, cli.voice),
        Command::Plan(args) => plan::run(args, cli.voice),
        Command::Axis(args) => axis::run(args),
        Command::Fit(args) => fit::run(args, cli.voice),
        Command::Machine(args) => machine::run(args),
        Command::Reproduce(what) => reproduce::run(what),
        Command::Time(args) => time::run(args, cli.voice),
        Command::Study(args) => study::run(args, cli.voice),
    }
}

/// What a run is given: the program, the machine, and how.
fn prepare(run: &Run) -> Result<(Program, Machine, SimulateOptions), Failure> {
    let program = crate::input::program(&run.on.part)?;
    let machine = drives::with_drives(&run.on.machine()?, &run.drives)?;
    let machine = machines::with_fits(machine, &run.fitted)?;
    if let Some(tolerance) = run.tolerance_um.filter(|um| !(um.is_finite() && *um > 0.0)) {
        return Err(Failure::message(format!(
            "--tolerance-um is {tolerance}; it has to be a positive finite number"
        )));
    }
    if run.threads == Some(0) {
        return Err(Failure::with_hint(
            "--threads is 0",
            "leave it out to use all cores",
        ));
    }
    let (tolerance_um, cutting_force_n, bow_limit_um) =
        (run.tolerance_um, run.cutting_force_n, run.bow_limit_um);
    let (quality, interventions) = (run.quality.of_planner(), run.interventions.read()?);
    let threads = run.threads.unwrap_or(0);
    let options = SimulateOptions {
        tolerance_um,
        cutting_force_n,
        bow_limit_um,
        threads,
        quality,
        interventions,
        ..SimulateOptions::default()
    };
    let options = run.on.options(&machine, options)?;
    Ok((program, machine, options))
}

/// Whether any axis was told the gap of a fit.
fn has_fit(machine: &Machine) -> bool {
    machine
        .axes()
        .iter()
        .any(|axis| axis.config.compensation.fitted_lookup.gap.is_some())
}

/// Refuses the method for fits where no axis has one: it would leave everything as it is.
fn check_fit(method: &str, machine: &Machine) -> Result<(), Failure> {
    let needs_fit = method.parse::<MethodId>().is_ok_and(MethodId::needs_fit);
    if !needs_fit || has_fit(machine) {
        return Ok(());
    }
    let hint = "give a result of `lostmotion fit` as --fitted AXIS=FILE.json, or set compensation.fitted_lookup.gap in the machine file";
    Err(Failure::with_hint(
        format!("{method} needs a fitted gap, and no axis was told one"),
        hint,
    ))
}

/// An error of the session, with the lines of the program it is about.
fn failure(program: &Program, error: &SimError, voice: Voice) -> Failure {
    let mut findings = Findings::none(program);
    match error {
        SimError::Program { diagnostics, .. } => {
            return Findings::of(program, diagnostics).failure(voice);
        }
        SimError::Travel {
            violations,
            provenance,
            ..
        } => {
            findings = findings.with_provenance(provenance);
            add_travel(&mut findings, Severity::Error, violations);
        }
        SimError::NoAxis {
            block,
            axis,
            machine,
            provenance,
        } => {
            findings = findings.with_provenance(provenance);
            let hint = "take a machine with that axis, see `lostmotion machine list`";
            findings.add(
                Severity::Error,
                "no-axis",
                *block,
                format!("machine \"{machine}\" has no axis {axis}"),
                Some(hint.to_owned()),
            );
        }
        SimError::Path {
            block,
            source,
            provenance,
        } => {
            findings = findings.with_provenance(provenance);
            findings.add(Severity::Error, "path", *block, source.to_string(), None);
        }
        _ => return Failure::message(error.to_string()),
    }
    match (error, findings.failure(voice)) {
        (SimError::Travel { .. }, Failure::Rendered(text)) if voice.diagnostics == Form::Text => {
            Failure::Rendered(format!("{text}error: {error}"))
        }
        (_, failure) => failure,
    }
}

/// Moves beyond the travel as findings.
fn add_travel(findings: &mut Findings<'_>, severity: Severity, violations: &[TravelViolation]) {
    for violation in violations {
        findings.add(
            severity,
            "outside-travel",
            violation.block,
            travel(violation),
            None,
        );
    }
}

/// What the front end found in a program that was accepted, for those who want a document.
fn accepted(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    voice: Voice,
) -> Result<(), Failure> {
    if voice.diagnostics == Form::Text {
        return Ok(());
    }
    let mut reading = interpreter::open(
        program,
        lostmotion::sim::interpreter_config(machine, options),
    )?;
    if let Some(loader) = &options.loader {
        reading = reading.with_loader(std::sync::Arc::clone(loader));
    }
    for _ in reading.by_ref() {}
    Findings::of(program, reading.diagnostics()).remark(voice)
}

/// How far a move leaves the travel, in the units that people use.
fn travel(violation: &TravelViolation) -> String {
    let TravelViolation {
        joint,
        value,
        limit,
        ..
    } = violation;
    let (unit, factor) = if joint.is_rotary() {
        ("deg", deg(1.0))
    } else {
        ("mm", 1.0)
    };
    let [value, limit] = [value * factor, limit * factor].map(|v| number::fixed(v, 3));
    format!(
        "axis {joint} would have to go to {value} {unit} in machine coordinates, beyond its limit of {limit} {unit}"
    )
}

/// A result as JSON text.
fn to_json(value: &impl Serialize) -> Result<String, Failure> {
    let mut out = Vec::new();
    json::write(&mut out, value)
        .map_err(|error| Failure::message(format!("cannot make JSON of the result: {error}")))?;
    String::from_utf8(out).map_err(|error| Failure::message(error.to_string()))
}

/// Tables for a file, and for stdout.
fn text_options(color: bool) -> TextOptions {
    TextOptions {
        color,
        ..TextOptions::default()
    }
}

/// The answer in the form asked for.
fn show(format: Format, json: &str, text: &str) -> Result<(), Failure> {
    crate::output::print(match format {
        Format::Text => text,
        Format::Json => json,
    })
}
