//! Machines.

use crate::error::Refusal;
use lostmotion::sim::files;
use lostmotion::sim::import::{FileSource, ImportFormat, ImportOptions, MAX_BYTES, import};
use lostmotion::sim::machine::{self, AxisReview, Change, MachineError, MachineFile};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyMapping, PyTuple};
use pythonize::{depythonize, pythonize};
use serde_json::Value;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// A checked machine.
#[pyclass(frozen, eq, from_py_object, module = "lostmotion")]
#[derive(Clone, PartialEq)]
pub(crate) struct Machine(pub(crate) lostmotion::Machine);

/// The text of a file.
fn text_of(path: &Path) -> PyResult<String> {
    // Python's own exceptions for files, with the number of the system's error.
    std::fs::read_to_string(path).map_err(|error| {
        let text = format!("{}: {error}", path.display());
        PyErr::from(std::io::Error::new(error.kind(), text))
    })
}

/// A value of Python's as TOML.
fn toml_of(value: &Bound<'_, PyAny>) -> PyResult<String> {
    // Numbers and arrays of numpy's give Python's own.
    let plain = match value.getattr_opt("tolist")? {
        Some(tolist) => tolist.call0()?,
        None => value.clone(),
    };
    let value: Value = depythonize(&plain).map_err(|error| {
        let hint = "a value is a number, a text, a truth value or a list of these";
        Refusal::option(format!("not a value of a machine file: {error}"), hint).raised(value.py())
    })?;
    // Numbers, texts, truth values and lists of them are written alike in JSON and TOML.
    Ok(value.to_string())
}

/// Changes as the reader of machines takes them.
fn changes_of(changes: &Bound<'_, PyMapping>) -> PyResult<Vec<Change>> {
    let change = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String = key.extract()?;
        // JSON has no NaN: told as what it is.
        let value = match value.extract::<f64>() {
            Ok(number) if !number.is_finite() => format!("{number:?}").to_lowercase(),
            _ => toml_of(&value)?,
        };
        Ok(Change {
            name: format!("{key} = {value}"),
            key,
            value,
        })
    };
    let items = changes.items()?;
    items.iter().map(|item| change(item.extract()?)).collect()
}

#[pymethods]
impl Machine {
    #[staticmethod]
    fn preset(name: &str) -> PyResult<Machine> {
        Ok(lostmotion::Machine::preset(name)
            .map(Machine)
            .map_err(Refusal::from)?)
    }

    #[staticmethod]
    #[pyo3(signature = (text, name = "machine.toml"))]
    fn from_toml(text: &str, name: &str) -> PyResult<Machine> {
        let machine = lostmotion::Machine::from_toml(name, text);
        Ok(machine.map(Machine).map_err(Refusal::from)?)
    }

    #[staticmethod]
    #[expect(clippy::needless_pass_by_value, reason = "Python hands a path over")]
    fn from_file(path: PathBuf) -> PyResult<Machine> {
        Machine::from_toml(&text_of(&path)?, &path.display().to_string())
    }

    #[staticmethod]
    fn from_dict(description: &Bound<'_, PyDict>) -> PyResult<Machine> {
        let file: MachineFile = depythonize(description).map_err(|error| {
            let hint = "keys are those of machine files, see machine_keys()";
            let text = format!("this is no description of a machine: {error}");
            Refusal::new("MachineError", "machine", text, hint).raised(description.py())
        })?;
        Ok(file.check().map(Machine).map_err(Refusal::from)?)
    }

    /// All that is wrong with a machine file, tuning included.
    #[staticmethod]
    #[pyo3(signature = (text, name = "machine.toml"))]
    fn problems<'py>(py: Python<'py>, text: &str, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let text = text.to_owned();
        let name = name.to_owned();
        let checked = crate::apart::apart(py, None, move |_| {
            Ok(lostmotion::Machine::check_toml(&name, &text).map(drop))
        })?;
        match checked {
            Ok(()) => Ok(PyList::empty(py).into_any()),
            Err(error) => Refusal::from(error)
                .raised(py)
                .value(py)
                .getattr("findings"),
        }
    }

    /// The machine with other values of its keys.
    fn edit(&self, changes: &Bound<'_, PyMapping>) -> PyResult<Machine> {
        let text = self.to_toml()?;
        let changes = changes_of(changes)?;
        let machine = lostmotion::Machine::from_changed_toml(self.0.name(), &text, &changes);
        Ok(machine.map(Machine).map_err(Refusal::from)?)
    }

    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    #[getter]
    fn description(&self) -> &str {
        self.0.description()
    }

    #[getter]
    fn dialect(&self) -> &'static str {
        self.0.dialect().name()
    }

    #[getter]
    fn drives(&self) -> Vec<String> {
        self.0.drives()
    }

    /// Of what makes machines equal: their description.
    fn __hash__(&self) -> PyResult<u64> {
        let mut hasher = DefaultHasher::new();
        self.to_toml()?.hash(&mut hasher);
        Ok(hasher.finish())
    }

    fn to_toml(&self) -> PyResult<String> {
        let text = self.0.to_toml();
        Ok(text.map_err(|error| Refusal::new("MachineError", "machine", error.to_string(), ""))?)
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize(py, &self.0.file())?)
    }

    /// What a commissioning engineer would object to.
    fn remarks(&self) -> Vec<String> {
        let reviews = self.0.review();
        reviews.iter().flat_map(AxisReview::remarks).collect()
    }

    /// A row for each loop of each axis.
    fn tuning<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let machine = self.0.clone();
        let tuning = crate::apart::apart(py, None, move |_| Ok(machine.tuning()))?;
        let rows = PyList::empty(py);
        for axis in &tuning {
            for at in &axis.loops.loops {
                let row = PyDict::new(py);
                row.set_item("axis", axis.axis.to_string())?;
                row.set_item("loop", at.kind.to_string())?;
                row.set_item("regime", at.regime.to_string())?;
                row.set_item("gain_margin_db", at.margins.gain_margin_db)?;
                row.set_item("phase_margin_deg", at.margins.phase_margin_deg)?;
                row.set_item("crossover_hz", at.margins.crossover_hz)?;
                row.set_item("bandwidth_hz", at.margins.bandwidth_hz)?;
                rows.append(row)?;
            }
        }
        Ok(rows)
    }

    fn __repr__(&self) -> String {
        format!(
            "Machine({:?}: {})",
            self.0.name(),
            self.0.drives().join(", ")
        )
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Machine>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let machine = slf.get();
        let text = machine.to_toml()?;
        let restore = slf.get_type().getattr("from_toml")?;
        Ok((
            restore,
            PyTuple::new(slf.py(), [text, machine.0.name().to_owned()])?,
        ))
    }
}

/// Names of the machines that come with the library, each with a line about it.
#[pyfunction]
pub(crate) fn presets() -> Vec<(&'static str, &'static str)> {
    let presets = machine::presets();
    presets
        .iter()
        .map(|preset| (preset.name, preset.summary))
        .collect()
}

/// Every key of machine files with what its value is.
#[pyfunction]
pub(crate) fn machine_keys() -> Vec<(String, String)> {
    let keys = machine::keys().into_iter();
    keys.map(|key| (key.key, key.kind)).collect()
}

/// What came of an import.
#[pyclass(frozen, get_all, module = "lostmotion")]
pub(crate) struct Imported {
    /// The machine.
    machine: Machine,
    /// Its file, where every value says where it is from.
    toml: String,
    /// Key, value, fate and note of every key.
    rows: Vec<(String, String, &'static str, String)>,
}

/// Files that a description names, in its folder where it has one.
struct Beside(Option<PathBuf>);

impl Beside {
    fn path(&self, name: &str) -> Result<PathBuf, String> {
        let folder = self.0.as_ref().ok_or("other files are not read here")?;
        Ok(folder.join(name))
    }
}

impl FileSource for Beside {
    fn text(&self, name: &str) -> Result<String, String> {
        files::text(&self.path(name)?).map_err(|error| error.to_string())
    }

    fn names(&self, folder: &str) -> Result<Vec<String>, String> {
        files::names(&self.path(folder)?).map_err(|error| error.to_string())
    }
}

/// Turns another program's description of a machine into a machine.
#[pyfunction]
#[pyo3(signature = (text, name, format, preset, tip, max_bytes, folder))]
pub(crate) fn import_machine(
    text: &str,
    name: &str,
    format: Option<&str>,
    preset: Option<&str>,
    tip: Option<&str>,
    max_bytes: Option<usize>,
    folder: Option<PathBuf>,
) -> PyResult<Imported> {
    let named = |wanted: &str| {
        let found = ImportFormat::NAMES.iter().find(|(name, _)| *name == wanted);
        found.map(|(_, format)| *format)
    };
    let format = match format {
        Some(format) => named(format),
        None => ImportFormat::recognise(name, text),
    };
    let format = format.ok_or_else(|| {
        let known = ImportFormat::NAMES.map(|(name, _)| name).join(", ");
        let hint = format!("name it: {known}");
        Refusal::new(
            "MachineError",
            "format",
            format!("{name}: the format is not known"),
            &hint,
        )
    })?;
    let files = Beside(folder);
    let options = ImportOptions {
        preset,
        max_bytes: max_bytes.unwrap_or(MAX_BYTES),
        tip,
        files: &files,
    };
    let imported = import(name, text, format, &options)
        .and_then(|imported| {
            let machine = lostmotion::Machine::from_toml(name, &imported.toml)?;
            Ok::<_, MachineError>((imported, machine))
        })
        .map_err(Refusal::from)?;
    let (imported, machine) = imported;
    let rows = imported.rows.into_iter();
    Ok(Imported {
        machine: Machine(machine),
        toml: imported.toml,
        rows: rows
            .map(|row| (row.key, row.value, row.fate.name(), row.note))
            .collect(),
    })
}
