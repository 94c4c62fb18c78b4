//! Why there is no result, as Python's exceptions: those of `lostmotion.errors`, each with a code, a
//! place and a hint.

use lostmotion::contour::ContourError;
use lostmotion::plan::PlanError;
use lostmotion::report::findings::Finding;
use lostmotion::sim::machine::MachineError;
use lostmotion::{Program, SimError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use pythonize::pythonize;
use serde_json::{Value, json};

/// An exception that is still to be raised.
#[derive(Debug)]
pub(crate) struct Refusal {
    /// Class in `lostmotion.errors`.
    class: &'static str,
    code: String,
    message: String,
    hint: String,
    /// What was found, each with its place.
    findings: Vec<Value>,
}

impl Refusal {
    /// One without a place.
    pub(crate) fn new(
        class: &'static str,
        code: &str,
        message: impl Into<String>,
        hint: &str,
    ) -> Refusal {
        Refusal {
            class,
            code: code.to_owned(),
            message: message.into(),
            hint: hint.to_owned(),
            findings: Vec::new(),
        }
    }

    /// Of a value that a caller gave.
    pub(crate) fn option(message: impl Into<String>, hint: &str) -> Refusal {
        Refusal::new("OptionError", "option", message, hint)
    }

    /// Of data: arrays, logs.
    pub(crate) fn data(message: impl Into<String>, hint: &str) -> Refusal {
        Refusal::new("DataError", "data", message, hint)
    }

    /// Of a program that cannot be read.
    pub(crate) fn unread(program: &Program, error: &std::io::Error) -> Refusal {
        let message = format!("cannot read {}: {error}", program.name());
        Refusal::new("ProgramError", "read", message, "")
    }

    /// Of findings, the first of which gives code, place and hint.
    pub(crate) fn of_findings(
        class: &'static str,
        message: String,
        findings: Vec<Finding>,
        program: &Program,
    ) -> Refusal {
        let findings: Vec<Value> = findings
            .into_iter()
            .map(|finding| placed(finding, program))
            .collect();
        let of_first = |key: &str| {
            let value = findings.first().and_then(|found| found.get(key));
            value.and_then(Value::as_str).unwrap_or_default().to_owned()
        };
        Refusal {
            class,
            code: of_first("code"),
            hint: of_first("hint"),
            message,
            findings,
        }
    }

    /// Of a run, plan or check of a program.
    pub(crate) fn of_run(error: &SimError, program: &Program) -> Refusal {
        let findings = Finding::from_error(error, program.name());
        if !findings.is_empty() {
            let message = told(&findings, error);
            return Refusal::of_findings("ProgramError", message, findings, program);
        }
        let text = error.to_string();
        match error {
            SimError::Read { .. } => Refusal::new("ProgramError", "read", text, ""),
            SimError::Empty { .. } => Refusal::new("ProgramError", "empty", text, ""),
            SimError::TooLong { .. } => {
                let hint = "raise max_duration_s if that is meant";
                Refusal::new("OptionError", "too-long", text, hint)
            }
            SimError::Option { .. } => Refusal::new("OptionError", "option", text, ""),
            SimError::Threads { .. } => Refusal::new("OptionError", "threads", text, ""),
            SimError::Plan(PlanError::Setting { .. }) => {
                Refusal::new("OptionError", "option", text, "")
            }
            SimError::Plan(_) => Refusal::new("ProgramError", "plan", text, ""),
            SimError::Method(_) => Refusal::new("MethodError", "unknown-method", text, ""),
            SimError::Axis { .. } => Refusal::new("MethodError", "axis", text, ""),
            SimError::Machine(error) => Refusal::from(error.clone()),
            SimError::Kinematics(_) => Refusal::new("MachineError", "kinematics", text, ""),
            SimError::Refused { what, hint } => {
                Refusal::new("OptionError", "refused", what.clone(), hint)
            }
            SimError::Contour(ContourError::NotFinite { .. }) => {
                let hint = "a simulated axis has run away: Machine.tuning() tells whether its loops are stable; a force may be too much for its motor";
                Refusal::new("Error", "not-finite", text, hint)
            }
            SimError::Cancelled => Refusal::new("Cancelled", "cancelled", text, ""),
            _ => Refusal::new("Error", "run", text, ""),
        }
    }

    /// The exception.
    pub(crate) fn raised(self, py: Python<'_>) -> PyErr {
        self.exception(py)
            .map_or_else(|error| error, PyErr::from_value)
    }

    fn exception<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let class = py.import("lostmotion.errors")?.getattr(self.class)?;
        let named = PyDict::new(py);
        named.set_item("code", &self.code)?;
        named.set_item("hint", &self.hint)?;
        let findings = PyList::empty(py);
        for found in &self.findings {
            findings.append(pythonize(py, found)?)?;
        }
        named.set_item("findings", findings)?;
        class.call((&self.message,), Some(&named))
    }
}

/// A finding with the line that it is about, as `lostmotion.errors.Finding` takes it.
pub(crate) fn placed(finding: Finding, program: &Program) -> Value {
    let excerpt = if finding.span.file == 0 && finding.span.line > 0 {
        program.block_text(finding.span).unwrap_or_default()
    } else {
        finding.excerpt
    };
    json!({
        "code": finding.code,
        "severity": finding.severity,
        "message": finding.message,
        "file": finding.file,
        "line": finding.span.line,
        "column": finding.span.column,
        "length": finding.span.len,
        "hint": finding.hint.unwrap_or_default(),
        "excerpt": excerpt,
        "values": finding.values,
    })
}

/// The first finding with its place, and how many there are.
fn told(findings: &[Finding], error: &SimError) -> String {
    let Some(first) = findings.first() else {
        return error.to_string();
    };
    let place = format!("{}:{}:{}", first.file, first.span.line, first.span.column);
    let more = match findings.len() {
        1 => String::new(),
        count => format!(" (and {} more)", count - 1),
    };
    format!("{place}: {}{more}", first.message)
}

impl From<MachineError> for Refusal {
    fn from(error: MachineError) -> Refusal {
        let finding = |problem: &lostmotion::sim::machine::Problem| {
            json!({
                "code": "machine",
                "severity": "error",
                "message": problem.message,
                "file": error.file,
                "line": problem.line,
                "column": problem.column,
                "length": 0,
                "hint": problem.hint,
                "excerpt": problem.option.clone().unwrap_or_default(),
                "values": { "key": problem.key },
            })
        };
        let text: Vec<String> = error
            .problems
            .iter()
            .map(|problem| error.text_of(problem))
            .collect();
        let hint = error.problems.first().map(|problem| problem.hint.clone());
        Refusal {
            class: "MachineError",
            code: "machine".to_owned(),
            message: text.join("\n"),
            hint: hint.unwrap_or_default(),
            findings: error.problems.iter().map(finding).collect(),
        }
    }
}

impl From<std::io::Error> for Refusal {
    /// Of a table in memory, where writing does not fail.
    fn from(error: std::io::Error) -> Refusal {
        Refusal::new("Error", "internal", error.to_string(), "")
    }
}

impl From<Refusal> for PyErr {
    fn from(refusal: Refusal) -> PyErr {
        Python::attach(|py| refusal.raised(py))
    }
}
