//! Part programs: what can be said of one without moving anything.

use crate::apart::apart;
use crate::error::{Refusal, told};
use crate::machine::Machine;
use crate::options;
use lostmotion::gcode::InterpreterConfig;
use lostmotion::gcode_tools::explain::explain;
use lostmotion::gcode_tools::format::{
    Case, FormatOptions, LineNumbers, format, refers_to_line_numbers,
};
use lostmotion::gcode_tools::lint::{Level, Levels};
use lostmotion::gcode_tools::writer::write_program;
use lostmotion::report::findings::Finding;
use lostmotion::report::refusal::{self, findings_of, operations_of, placed};
use lostmotion::sim::program::Operations as Reader;
use lostmotion::sim::request::ReadingRequest;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pythonize::pythonize;
use serde_json::Value;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// A part program: a file, which is read where it stands, or a text.
#[pyclass(frozen, module = "lostmotion._native")]
pub(crate) struct Program {
    pub(crate) program: lostmotion::Program,
    /// Where it stands, if it is a file.
    pub(crate) path: Option<PathBuf>,
}

impl Program {
    /// Its interpreter.
    fn reader(
        program: &lostmotion::Program,
        reading: &ReadingRequest,
        machine: Option<&Machine>,
    ) -> Result<(Reader, InterpreterConfig), Refusal> {
        let (config, loader) = reading.config(machine.map(|machine| &machine.0))?;
        Ok((operations_of(program, config.clone(), loader)?, config))
    }

    /// What interpreter and lints find, in the order of the text.
    fn found(
        program: &lostmotion::Program,
        reading: &ReadingRequest,
        machine: Option<&Machine>,
        levels: Option<Levels>,
    ) -> Result<Vec<Finding>, Refusal> {
        let (config, loader) = reading.config(machine.map(|machine| &machine.0))?;
        Ok(findings_of(program, config, loader, levels)?)
    }
}

/// What was found, each with its line.
fn shown(found: Vec<Finding>, program: &lostmotion::Program) -> Vec<Value> {
    found
        .into_iter()
        .map(|finding| told(&placed(finding, program)))
        .collect()
}

/// Levels of lints from their names.
fn levels_of(given: Vec<(String, String)>) -> Result<Levels, Refusal> {
    let mut levels = Levels::default();
    for (code, level) in given {
        let level = match level.as_str() {
            "allow" => Level::Allow,
            "warn" => Level::Warn,
            "deny" => Level::Deny,
            other => {
                return Err(Refusal::option(
                    format!("\"{other}\" is no level"),
                    "levels are allow, warn and deny",
                ));
            }
        };
        let known = lostmotion::gcode_tools::lint::rules::find(&code).is_some() || code == "all";
        if !known {
            return Err(Refusal::option(
                format!("there is no lint \"{code}\""),
                "`lostmotion check --help` lists them",
            ));
        }
        levels.set(&code, level);
    }
    Ok(levels)
}

#[pymethods]
impl Program {
    #[staticmethod]
    #[pyo3(signature = (text, name = "program"))]
    fn from_text(text: &str, name: &str) -> Program {
        Program {
            program: lostmotion::Program::from_str(name, text),
            path: None,
        }
    }

    #[staticmethod]
    fn from_file(path: PathBuf) -> PyResult<Program> {
        let program = lostmotion::Program::from_path(&path);
        match program.len() {
            Ok(_) => Ok(Program {
                program,
                path: Some(path),
            }),
            Err(error) => {
                let text = format!("{}: {error}", path.display());
                Err(std::io::Error::new(error.kind(), text).into())
            }
        }
    }

    #[getter]
    fn name(&self) -> &str {
        self.program.name()
    }

    #[getter]
    fn text(&self) -> PyResult<String> {
        let text = self.program.text();
        Ok(text.map_err(|error| Refusal::unread(&self.program, &error))?)
    }

    fn _findings<'py>(
        &self,
        py: Python<'py>,
        machine: Option<Machine>,
        lints: Option<Vec<(String, String)>>,
        reading: &Bound<'py, PyDict>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let reading = options::reading(self.path.as_ref(), reading)?;
        let program = self.program.clone();
        let levels = lints.map(levels_of).transpose()?;
        let found = apart(py, None, move |_| {
            let found = Program::found(&program, &reading, machine.as_ref(), levels)?;
            Ok(shown(found, &program))
        })?;
        Ok(pythonize(py, &found)?)
    }

    fn _operations(
        &self,
        machine: Option<&Machine>,
        reading: &Bound<'_, PyDict>,
    ) -> PyResult<Operations> {
        let reading = options::reading(self.path.as_ref(), reading)?;
        let (reader, _) = Program::reader(&self.program, &reading, machine)?;
        Ok(Operations {
            reader: Mutex::new(reader),
            program: self.program.clone(),
        })
    }

    /// The program in one style.
    #[pyo3(signature = (*, case = "upper", indent = 2, line_numbers = "keep"))]
    fn format(&self, case: &str, indent: usize, line_numbers: &str) -> PyResult<String> {
        let case = match case {
            "upper" => Case::Upper,
            "lower" => Case::Lower,
            "keep" => Case::Keep,
            other => {
                let hint = "cases are upper, lower and keep";
                return Err(Refusal::option(format!("\"{other}\" is no case"), hint).into());
            }
        };
        let line_numbers = match line_numbers {
            "keep" => LineNumbers::Keep,
            "remove" => LineNumbers::Remove,
            step => match step.parse() {
                Ok(step @ 1..=10_000) => LineNumbers::Renumber { step },
                _ => {
                    let hint = "keep, remove, or a step from 1 to 10000";
                    let text = format!("line_numbers is \"{step}\"");
                    return Err(Refusal::option(text, hint).into());
                }
            },
        };
        let unread = |error: std::io::Error| Refusal::unread(&self.program, &error);
        let open = || self.program.open().map_err(unread);
        // GOTO and M99 P jump to N numbers: a new numbering would change what the program does.
        if line_numbers != LineNumbers::Keep
            && let Some(line) = refers_to_line_numbers(open()?).map_err(unread)?
        {
            let text = format!("line {line}: the program refers to its line numbers");
            return Err(Refusal::option(text, "use line_numbers=\"keep\"").into());
        }
        let options = FormatOptions {
            case,
            indent,
            line_numbers,
            ..FormatOptions::default()
        };
        let mut out = Vec::new();
        format(open()?, &options, &mut out).map_err(unread)?;
        Ok(String::from_utf8_lossy(&out).into_owned())
    }

    /// What a line does: a text for people and the same as data.
    fn _explain<'py>(
        &self,
        py: Python<'py>,
        line: u32,
        machine: Option<Machine>,
        reading: &Bound<'py, PyDict>,
    ) -> PyResult<(String, Bound<'py, PyAny>)> {
        let reading = options::reading(self.path.as_ref(), reading)?;
        let program = self.program.clone();
        let explanation = apart(py, None, move |_| {
            let (mut reader, _) = Program::reader(&program, &reading, machine.as_ref())?;
            explain(&mut reader, line).ok_or_else(|| {
                let text = format!("{} has no line {line}", program.name());
                Refusal::option(text, "lines count from 1")
            })
        })?;
        Ok((explanation.to_string(), pythonize(py, &explanation)?))
    }

    /// The program with everything computed.
    fn _resolved(
        &self,
        py: Python<'_>,
        machine: Option<Machine>,
        system: u8,
        reading: &Bound<'_, PyDict>,
    ) -> PyResult<String> {
        let reading = options::reading(self.path.as_ref(), reading)?;
        let program = self.program.clone();
        apart(py, None, move |_| {
            let found = Program::found(&program, &reading, machine.as_ref(), None)?;
            let wrong: Vec<Finding> = found
                .into_iter()
                .filter(|finding| finding.severity == lostmotion::gcode::Severity::Error)
                .collect();
            if let Some(first) = wrong.first() {
                let text = format!("{}:{}: {}", first.file, first.span.line, first.message);
                return Err(refusal::Refusal::of_findings(text, wrong, &program).into());
            }
            let (mut reader, config) = Program::reader(&program, &reading, machine.as_ref())?;
            let mut out = Vec::new();
            write_program(&mut reader, &config, system, &mut out)
                .map_err(|error| Refusal::new("ProgramError", "write", error.to_string(), ""))?;
            Ok(String::from_utf8_lossy(&out).into_owned())
        })
    }

    fn __repr__(&self) -> String {
        format!("Program({:?})", self.program.name())
    }

    /// A file stays a file: what is pickled is its path.
    fn __reduce__<'py>(
        slf: &Bound<'py, Program>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, program) = (slf.py(), slf.get());
        Ok(match &program.path {
            Some(path) => {
                let restore = slf.get_type().getattr("from_file")?;
                (restore, PyTuple::new(py, [path])?)
            }
            None => {
                let restore = slf.get_type().getattr("from_text")?;
                let name = program.program.name().to_owned();
                (restore, PyTuple::new(py, [program.text()?, name])?)
            }
        })
    }
}

/// Canonical operations one after the other: line, column, file and text of each.
#[pyclass(frozen, module = "lostmotion._native")]
pub(crate) struct Operations {
    reader: Mutex<Reader>,
    program: lostmotion::Program,
}

#[pymethods]
impl Operations {
    fn __iter__(slf: PyRef<'_, Operations>) -> PyRef<'_, Operations> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<(u32, u32, u32, String)>> {
        // A program may compute for long between two operations.
        let next = py.detach(|| {
            let mut reader = self.reader.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(found) = reader.next() {
                let span = found.block.span;
                return Ok(Some((
                    span.line,
                    span.column,
                    span.file,
                    found.op.to_string(),
                )));
            }
            // At the end it is told what was wrong on the way.
            let diagnostics = reader.diagnostics();
            if diagnostics.errors() == 0 {
                return Ok(None);
            }
            let error = lostmotion::SimError::Program {
                name: self.program.name().to_owned(),
                diagnostics: Box::new(diagnostics.clone()),
            };
            Err(Refusal::of_run(&error, &self.program))
        });
        Ok(next?)
    }
}
