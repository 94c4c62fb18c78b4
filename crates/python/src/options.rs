//! How a program is read and run, from dictionaries of Python's: the keywords of `simulate` and of
//! the other functions that take a program.

use crate::error::Refusal;
use lostmotion::sim::request::ReadingRequest;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::depythonize;
use serde::Deserialize;
use std::path::PathBuf;

/// A dictionary as settings.
pub(crate) fn settings<T: for<'de> Deserialize<'de>>(given: &Bound<'_, PyDict>) -> PyResult<T> {
    depythonize(given).map_err(|error| {
        let hint = "the signature says what each keyword takes";
        Refusal::option(format!("a keyword is not understood: {error}"), hint).raised(given.py())
    })
}

/// How a program is to be read, which stands in a file or not.
pub(crate) fn reading(
    part: Option<&PathBuf>,
    given: &Bound<'_, PyDict>,
) -> PyResult<ReadingRequest> {
    let mut reading: ReadingRequest = settings(given)?;
    reading.part = part.cloned().unwrap_or_default();
    Ok(reading)
}
