//! Part programs: what can be said of one without moving anything.

use crate::apart::apart;
use crate::error::{Refusal, told};
use crate::machine::Machine;
use crate::options;
use lostmotion::report::findings::Finding;
use lostmotion::report::reading::{
    Style, explained, formatted, found_in, levels_of, reader_of, resolved,
};
use lostmotion::report::refusal::placed;
use lostmotion::sim::program::Operations as Reader;
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

/// What was found, each with its line.
fn shown(found: Vec<Finding>, program: &lostmotion::Program) -> Vec<Value> {
    found
        .into_iter()
        .map(|finding| told(&placed(finding, program)))
        .collect()
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
        let levels = lints.map(|given| {
            levels_of(
                given
                    .iter()
                    .map(|(code, level)| (code.as_str(), level.as_str())),
            )
        });
        let levels = levels.transpose().map_err(Refusal::from)?;
        let machine = machine.map(|machine| machine.0);
        let found = apart(py, None, move |_| {
            let found = found_in(&program, &reading, machine.as_ref(), levels)?;
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
        let machine = machine.map(|machine| &machine.0);
        let (reader, _) = reader_of(&self.program, &reading, machine).map_err(Refusal::from)?;
        Ok(Operations {
            reader: Mutex::new(reader),
            program: self.program.clone(),
        })
    }

    /// The program in one style.
    #[pyo3(signature = (*, case = "upper", indent = 2, line_numbers = "keep"))]
    fn format(&self, case: &str, indent: usize, line_numbers: &str) -> PyResult<String> {
        let style = Style {
            case: case.to_owned(),
            indent,
            line_numbers: line_numbers.to_owned(),
        };
        Ok(formatted(&self.program, &style).map_err(Refusal::from)?)
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
        let machine = machine.map(|machine| machine.0);
        let explanation = apart(py, None, move |_| {
            Ok(explained(&program, &reading, machine.as_ref(), line)?)
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
        let machine = machine.map(|machine| machine.0);
        apart(py, None, move |_| {
            Ok(resolved(&program, &reading, machine.as_ref(), system)?)
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
