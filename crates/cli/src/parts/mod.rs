//! `lostmotion simulate`, `time`, `check`, `plan`, `gcode`: what is done with a part program.

pub(crate) mod check;
pub(crate) mod gcode;
pub(crate) mod plan;
mod record;
pub(crate) mod simulate;
pub(crate) mod time;

use crate::findings::{Findings, Form, Voice};
use crate::options::part::interpret;
use crate::output::{Failure, stdout_columns, stdout_has_color};
use lostmotion::base::units::deg;
use lostmotion::gcode::Severity;
use lostmotion::plan::TravelViolation;
use lostmotion::report::{json, number, text::TextOptions};
use lostmotion::sim::{Machine, Program, SimError, SimulateOptions};
use serde::Serialize;

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
    let config = lostmotion::sim::interpreter_config(machine, options);
    let mut reading = interpret(program, config, options.loader.clone())?;
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
pub(crate) fn to_json(value: &impl Serialize) -> Result<String, Failure> {
    let mut out = Vec::new();
    json::write(&mut out, value)
        .map_err(|error| Failure::message(format!("cannot make JSON of the result: {error}")))?;
    String::from_utf8(out).map_err(|error| Failure::message(error.to_string()))
}

/// Text for stdout.
fn shown() -> TextOptions {
    TextOptions {
        color: stdout_has_color(),
        width: Some(stdout_columns()),
        ..TextOptions::default()
    }
}
