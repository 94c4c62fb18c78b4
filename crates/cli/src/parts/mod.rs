//! `lostmotion simulate`, `recommend`, `compensate`, `time`, `check`, `plan`, `gcode`, `report`, `watch`, `lsp`: what is done with
//! a part program and with the answers about it.

pub(crate) mod check;
pub(crate) mod compensate;
pub(crate) mod gcode;
pub(crate) mod lsp;
pub(crate) mod plan;
pub(crate) mod recommend;
mod record;
pub(crate) mod report;
mod serve;
pub(crate) mod simulate;
pub(crate) mod time;
pub(crate) mod watch;

use crate::findings::{Findings, Form, Voice};
use crate::options::part::interpret;
use crate::output::{Failure, stdout_columns, stdout_has_color};
use lostmotion::base::units::number;
use lostmotion::contour::ContourError;
use lostmotion::gcode::Severity;
use lostmotion::report::{json, text::TextOptions};
use lostmotion::sim::{Machine, Program, SimError, SimulateOptions};
use serde::Serialize;

/// An error of the session, with the lines of the program it is about.
pub(crate) fn failure(program: &Program, error: &SimError, voice: Voice) -> Failure {
    match error {
        SimError::Program { diagnostics, .. } => Findings::of(program, diagnostics).failure(voice),
        SimError::Travel { provenance, .. }
        | SimError::NoAxis { provenance, .. }
        | SimError::Path { provenance, .. } => {
            let mut findings = Findings::none(program).with_provenance(provenance);
            findings.add_error(error, Severity::Error);
            findings.failure(voice)
        }
        SimError::Option {
            what,
            value,
            condition,
        } => {
            let flag = flag_of(what);
            Failure::message(format!(
                "{flag} is {}; it has to be {condition}",
                number(*value)
            ))
        }
        SimError::Contour(ContourError::NotFinite { .. }) => {
            let hint = "a simulated axis has run away: `lostmotion machine check` tells whether its loops are stable; a force may be too much for its motor";
            Failure::with_hint(error.to_string(), hint)
        }
        _ => Failure::message(error.to_string()),
    }
}

/// The option that sets a field of the session's settings.
fn flag_of(field: &str) -> String {
    match field {
        "at_s" => "the time of --at in s".to_owned(),
        "spindle_event_s" => "--spindle-s".to_owned(),
        other => format!("--{}", other.replace('_', "-")),
    }
}

/// Findings in a program that was accepted, where they are wanted as a document.
fn accepted(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    voice: Voice,
) -> Result<(), Failure> {
    if voice.diagnostics == Form::Text {
        return Ok(());
    }
    found(program, machine, options)?.remark(voice)
}

/// What the front end finds in a program, with places and values: a run keeps warnings as text
/// alone, so the program is read once more.
fn found<'a>(
    program: &'a Program,
    machine: &Machine,
    options: &SimulateOptions,
) -> Result<Findings<'a>, Failure> {
    let config = lostmotion::sim::interpreter_config(machine, options);
    let mut reading = interpret(program, config, options.loader.clone())?;
    // The diagnostics are complete only when the interpreter has reached the end.
    for _ in reading.by_ref() {}
    Ok(Findings::of(program, reading.diagnostics()))
}

/// A result as JSON text.
pub(crate) fn to_json(value: &impl Serialize) -> Result<String, Failure> {
    let mut out = Vec::new();
    json::write(&mut out, value)
        .map_err(|error| Failure::message(format!("cannot make JSON of the result: {error}")))?;
    String::from_utf8(out).map_err(|error| Failure::message(error.to_string()))
}

/// Text for stdout.
pub(crate) fn shown() -> TextOptions {
    TextOptions {
        color: stdout_has_color(),
        width: Some(stdout_columns()),
        ..TextOptions::default()
    }
}
