//! Results as lines of JSON, from which a study that was stopped goes on.
//!
//! The first line says which study it is; each further one is a [`CellResult`]. A last line without
//! its end is a cell that was being written when the study was stopped: it counts for nothing.

use super::factor::{Cell, FACTORS};
use super::result::CellResult;
use crate::error::StudyError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of definitions, motions and machines; results of different versions are not put
/// together.
pub const VERSION: u32 = 1;

/// Which study a journal belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Always `matrix`.
    pub study: String,
    /// [`VERSION`].
    pub version: u32,
    /// Release that wrote it.
    pub lostmotion: String,
    /// Number of cells; `None` for the full factorial.
    pub cells: Option<usize>,
    /// Seed of the sample.
    pub seed: u64,
    /// Methods besides `none`.
    pub methods: Vec<String>,
    /// Factors with their levels.
    pub factors: Vec<String>,
}

impl Header {
    /// Of a study now.
    pub fn new(cells: Option<usize>, seed: u64, methods: &[String]) -> Header {
        Header {
            study: "matrix".to_owned(),
            version: VERSION,
            lostmotion: env!("CARGO_PKG_VERSION").to_owned(),
            cells,
            seed,
            methods: methods.to_vec(),
            // With their levels: under other ones the name of a cell would mean another cell.
            factors: FACTORS
                .iter()
                .map(|factor| format!("{}: {}", factor.name, factor.levels.join(" ")))
                .collect(),
        }
    }

    /// Refuses a journal of another study, by the first difference.
    fn check(&self, there: &Header) -> Result<(), StudyError> {
        let cells = |header: &Header| {
            header
                .cells
                .map_or("all".to_owned(), |cells| cells.to_string())
        };
        // What decides the figures, in the order in which a difference is worth telling.
        let pairs = [
            ("the study", there.study.clone(), self.study.clone()),
            (
                "its version",
                there.version.to_string(),
                self.version.to_string(),
            ),
            (
                "the release",
                there.lostmotion.clone(),
                self.lostmotion.clone(),
            ),
            ("the number of cells", cells(there), cells(self)),
            ("the seed", there.seed.to_string(), self.seed.to_string()),
            (
                "the list of methods",
                there.methods.join(","),
                self.methods.join(","),
            ),
            (
                "the list of factors",
                there.factors.join("; "),
                self.factors.join("; "),
            ),
        ];
        match pairs.into_iter().find(|(_, there, here)| there != here) {
            Some((what, there, here)) => Err(StudyError::OtherStudy { what, there, here }),
            None => Ok(()),
        }
    }
}

/// A line of a journal: a header or a result.
///
/// # Errors
/// None for the types of this crate.
pub fn line(value: &impl Serialize) -> Result<String, StudyError> {
    let mut text =
        serde_json::to_string(value).map_err(|error| StudyError::Sink(error.to_string()))?;
    text.push('\n');
    Ok(text)
}

/// Contents of a journal.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Results by cell.
    pub results: BTreeMap<Cell, CellResult>,
    /// Bytes of the text up to the end of its last whole line.
    pub whole_bytes: usize,
}

/// Reads a journal that has to belong to this study. Empty text is a journal that has not begun.
///
/// # Errors
/// A journal of another study; a line in the middle that is no result.
pub fn read(text: &str, header: &Header) -> Result<Found, StudyError> {
    // A line without its end was being written when the study was stopped: dropped, and overwritten
    // later.
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    let mut found = Found {
        whole_bytes: whole,
        ..Found::default()
    };
    let mut lines = text.get(..whole).unwrap_or_default().lines().zip(1..);
    let Some((first, _)) = lines.next() else {
        return Ok(found);
    };
    let broken = |line: usize| {
        move |error: serde_json::Error| StudyError::Journal {
            line,
            reason: error.to_string(),
        }
    };
    header.check(&serde_json::from_str(first).map_err(broken(1))?)?;
    for (line, number) in lines {
        let result: CellResult = serde_json::from_str(line).map_err(broken(number))?;
        found.results.insert(result.cell, result);
    }
    Ok(found)
}
