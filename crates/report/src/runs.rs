//! Several runs side by side: machines, settings or versions of a program.

use lostmotion_sim::results::{BlockResult, MethodResult, Run, SCHEMA_VERSION, SingleRun};
use serde_json::Value;
use std::collections::BTreeMap;

/// A run with the name that it goes by beside others.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedRun {
    /// Its name, such as that of its file.
    pub name: String,
    /// What it answered.
    pub run: Run,
}

/// A document that is no answer of a run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Not JSON, or a value of another kind than its key has.
    #[error("{name}: {source}")]
    Json {
        /// Name of the document.
        name: String,
        /// What is wrong, with line and column where it is not JSON.
        source: serde_json::Error,
    },
    /// JSON, and something else.
    #[error("{name} is not an answer of `simulate`: {why}")]
    Other {
        /// Name of the document.
        name: String,
        /// In what it differs.
        why: String,
    },
}

impl NamedRun {
    /// Reads the JSON of `simulate`, with one method or with several.
    ///
    /// ```
    /// use lostmotion_report::{json, runs::NamedRun};
    /// use lostmotion_sim::results::Run;
    ///
    /// let mut run = Run::default();
    /// run.schema = 1;
    /// let mut text = Vec::new();
    /// json::write(&mut text, &run)?;
    /// let read = NamedRun::read("a.json", &String::from_utf8(text)?)?;
    /// assert_eq!((read.name.as_str(), &read.run), ("a.json", &run));
    /// assert!(NamedRun::read("b.json", "{}").is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`RunError`]: text that is not JSON, JSON of something else, or of a newer form.
    pub fn read(name: &str, text: &str) -> Result<NamedRun, RunError> {
        let json = |source| RunError::Json {
            name: name.to_owned(),
            source,
        };
        let other = |why: String| RunError::Other {
            name: name.to_owned(),
            why,
        };
        let value: Value = serde_json::from_str(text).map_err(json)?;
        // Every key has a default, so that anything would be read as an empty run.
        let several = value.get("results").is_some();
        if !several && value.get("result").is_none() {
            return Err(other("it has neither `result` nor `results`".to_owned()));
        }
        match value.get("schema").and_then(Value::as_u64) {
            Some(schema) if schema == u64::from(SCHEMA_VERSION) => {}
            Some(schema) => {
                return Err(other(format!(
                    "its `schema` is {schema}, this program reads {SCHEMA_VERSION}"
                )));
            }
            None => return Err(other("it has no number `schema`".to_owned())),
        }
        let run = if several {
            serde_json::from_value::<Run>(value).map_err(json)?
        } else {
            serde_json::from_value::<SingleRun>(value)
                .map_err(json)?
                .into()
        };
        let name = name.to_owned();
        Ok(NamedRun { name, run })
    }

    /// The method that decides; where none is recommended, the first.
    pub fn main(&self) -> Option<&MethodResult> {
        self.run.deciding().or_else(|| self.run.first())
    }
}

/// Names as short as they can be told apart: without the folders that all begin with and the
/// endings that all have in common, part by part between `/`.
///
/// ```
/// use lostmotion_report::runs::short_names;
///
/// let names = ["out/worn/simulation.json", "out/new/simulation.json"];
/// assert_eq!(short_names(&names), ["worn", "new"]);
/// assert_eq!(short_names(&["a.json", "a.json"]), ["a.json", "a.json"]);
/// ```
pub fn short_names(names: &[&str]) -> Vec<String> {
    let parts: Vec<Vec<&str>> = names.iter().map(|name| name.split('/').collect()).collect();
    let shortest = parts.iter().map(Vec::len).min().unwrap_or(0);
    let all_have = |at: &dyn Fn(&[&str]) -> String| {
        let mut found = parts.iter().map(|parts| at(parts));
        let first = found.next();
        found.all(|part| Some(&part) == first.as_ref())
    };
    let nth = |index: usize| {
        all_have(&|parts: &[&str]| parts.get(index).copied().unwrap_or("").to_owned())
    };
    let last = |index: usize| {
        all_have(&|parts: &[&str]| {
            parts
                .iter()
                .rev()
                .nth(index)
                .copied()
                .unwrap_or("")
                .to_owned()
        })
    };
    let before = (0..shortest).take_while(|index| nth(*index)).count();
    // Names that are the same all through stay as they are.
    if before == shortest {
        return names.iter().map(|name| (*name).to_owned()).collect();
    }
    let after = (0..shortest - before)
        .take_while(|index| last(*index))
        .count();
    let short = |parts: &Vec<&str>| {
        let end = (parts.len() - after).max(before + 1).min(parts.len());
        parts.get(before..end).unwrap_or_default().join("/")
    };
    parts.iter().map(short).collect()
}

/// A block of the programs, and its error in each of the runs.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockRow {
    /// Its line, with the file's number before it where it is not the program itself.
    pub line: String,
    /// Its text.
    pub text: String,
    /// Largest error, signed, um; `None` in a run that does not list it among its worst.
    pub max_um: Vec<Option<f64>>,
}

/// The worst blocks of all runs, worst first, at most `most`: blocks of the same line and text are
/// one block.
pub fn worst_blocks(runs: &[NamedRun], most: usize) -> Vec<BlockRow> {
    let mut rows: BTreeMap<(u32, u32, &str), Vec<Option<f64>>> = BTreeMap::new();
    for (index, named) in runs.iter().enumerate() {
        let blocks = named.main().map_or(&[][..], |result| &result.worst_blocks);
        for block in blocks.iter().filter(|block| !block.rapid) {
            let span = block.block.span;
            let key = (span.file, span.line, block.text.as_str());
            let row = rows.entry(key).or_insert_with(|| vec![None; runs.len()]);
            // A block in a loop is listed once for each pass: its worst counts.
            if let Some(cell) = row.get_mut(index) {
                let worse = |cell: &f64| cell.abs() < block.max_um.abs();
                if cell.as_ref().is_none_or(worse) {
                    *cell = Some(block.max_um);
                }
            }
        }
    }
    let magnitude = |row: &BlockRow| {
        row.max_um
            .iter()
            .flatten()
            .map(|um| um.abs())
            .fold(0.0, f64::max)
    };
    let mut rows: Vec<BlockRow> = rows
        .into_iter()
        .map(|((file, line, text), max_um)| BlockRow {
            line: match file {
                0 => line.to_string(),
                file => format!("{file}:{line}"),
            },
            text: text.to_owned(),
            max_um,
        })
        .collect();
    rows.sort_by(|a, b| magnitude(b).total_cmp(&magnitude(a)));
    rows.truncate(most);
    rows
}

/// The worst block of a run that is no rapid.
pub(crate) fn worst(result: &MethodResult) -> Option<&BlockResult> {
    result.worst_blocks.iter().find(|block| !block.rapid)
}
