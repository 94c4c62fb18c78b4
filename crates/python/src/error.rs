//! Why there is no result, as Python's exceptions: those of `lostmotion.errors`, each with a code, a
//! place and a hint.

use lostmotion::report::findings::Finding;
use lostmotion::report::refusal::{self, RefusalKind};
use lostmotion::sim::machine::MachineError;
use lostmotion::sim::request::RequestError;
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
    refusal: refusal::Refusal,
}

impl Refusal {
    /// One of a class of its own, without a place.
    pub(crate) fn new(
        class: &'static str,
        code: &str,
        message: impl Into<String>,
        hint: &str,
    ) -> Refusal {
        Refusal {
            class,
            refusal: refusal::Refusal::new(RefusalKind::Other, code, message, hint),
        }
    }

    /// Of a value that a caller gave.
    pub(crate) fn option(message: impl Into<String>, hint: &str) -> Refusal {
        refusal::Refusal::option(message, hint).into()
    }

    /// Of data: arrays, logs.
    pub(crate) fn data(message: impl Into<String>, hint: &str) -> Refusal {
        refusal::Refusal::data(message, hint).into()
    }

    /// Of a program that cannot be read.
    pub(crate) fn unread(program: &Program, error: &std::io::Error) -> Refusal {
        refusal::Refusal::unread(program, error).into()
    }

    /// Of a run, plan or check of a program.
    pub(crate) fn of_run(error: &SimError, program: &Program) -> Refusal {
        refusal::Refusal::of_run(error, program).into()
    }

    /// The exception.
    pub(crate) fn raised(self, py: Python<'_>) -> PyErr {
        self.exception(py)
            .map_or_else(|error| error, PyErr::from_value)
    }

    fn exception<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let class = py.import("lostmotion.errors")?.getattr(self.class)?;
        let named = PyDict::new(py);
        named.set_item("code", &self.refusal.code)?;
        named.set_item("hint", &self.refusal.hint)?;
        let findings = PyList::empty(py);
        for found in &self.refusal.findings {
            findings.append(pythonize(py, &told(found))?)?;
        }
        named.set_item("findings", findings)?;
        class.call((&self.refusal.message,), Some(&named))
    }
}

/// A finding as `lostmotion.errors.Finding` takes it.
pub(crate) fn told(finding: &Finding) -> Value {
    json!({
        "code": finding.code,
        "severity": finding.severity,
        "message": finding.message,
        "file": finding.file,
        "line": finding.span.line,
        "column": finding.span.column,
        "length": finding.span.len,
        "hint": finding.hint.as_deref().unwrap_or_default(),
        "excerpt": finding.excerpt,
        "values": finding.values,
    })
}

impl From<refusal::Refusal> for Refusal {
    fn from(refusal: refusal::Refusal) -> Refusal {
        let class = match refusal.kind {
            RefusalKind::Program => "ProgramError",
            RefusalKind::Machine => "MachineError",
            RefusalKind::Method => "MethodError",
            RefusalKind::Option => "OptionError",
            RefusalKind::Data => "DataError",
            RefusalKind::Cancelled => "Cancelled",
            _ => "Error",
        };
        Refusal { class, refusal }
    }
}

impl From<MachineError> for Refusal {
    fn from(error: MachineError) -> Refusal {
        refusal::Refusal::from(error).into()
    }
}

impl From<RequestError> for Refusal {
    fn from(error: RequestError) -> Refusal {
        refusal::Refusal::from(error).into()
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
