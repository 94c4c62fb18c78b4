//! The plan of a sweep as lines of JSON: a header, then a line for each cell.

use crate::design::Level;
use crate::error::SweepError;
use crate::key::{Key, ordered};
use lostmotion_report::WriteError;
use lostmotion_report::atomic::AtomicFile;
use lostmotion_sim::machine::Change;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;

/// Version of manifests, keys and results.
pub const VERSION: u32 = 1;

/// Release that plans and runs.
pub const RELEASE: &str = env!("CARGO_PKG_VERSION");

/// Longest line of a manifest, bytes. A choice: room for thousands of programs in the header.
const LONGEST_LINE: u64 = 64 << 20;

/// A file that cells need, with the SHA-256 of its contents.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Input {
    /// A path from the manifest's folder on, or the name of a machine that comes with the program.
    pub name: String,
    /// 64 hexadecimal digits.
    pub sha256: String,
}

/// Something that is varied.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Coordinate {
    /// Its name in the table.
    pub name: String,
    /// Keys of the machine that get its value.
    pub keys: Vec<String>,
}

/// The first line: everything that cells have in common.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// [`VERSION`].
    pub sweep: u32,
    /// [`RELEASE`].
    pub lostmotion: String,
    /// The sweep file that it was made of.
    pub file: String,
    /// Number of cells.
    pub cells: usize,
    /// Compensation methods, side by side in each cell.
    pub methods: Vec<String>,
    /// What is varied.
    pub vary: Vec<Coordinate>,
    /// How programs are read.
    pub reading: Value,
    /// How they are run.
    pub run: Value,
    /// SHA-256 of the folders of subroutines, if there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub subroutines: Option<String>,
    /// The machines.
    pub machines: Vec<Input>,
    /// The programs.
    pub programs: Vec<Input>,
}

/// A line after the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// What it is known by.
    pub key: Key,
    /// Place of its program in the header, from 0.
    pub program: usize,
    /// Place of its machine.
    pub machine: usize,
    /// A value for each coordinate.
    pub values: Vec<Level>,
}

/// A sweep, planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// What its cells have in common.
    pub header: Header,
    /// The cells, in their order.
    pub cells: Vec<Cell>,
}

impl Header {
    /// The values of a cell as changes of its machine.
    pub fn changes(&self, values: &[Level]) -> Vec<Change> {
        let pairs = self.vary.iter().zip(values);
        let changes = pairs.flat_map(|(coordinate, level)| {
            let value = level.to_string();
            coordinate.keys.iter().map(move |key| Change {
                key: key.clone(),
                value: value.clone(),
                name: format!("{key}={value}"),
            })
        });
        changes.collect()
    }

    /// Name of a cell's program.
    pub fn program(&self, cell: &Cell) -> &str {
        let input = self.programs.get(cell.program);
        input.map_or("", |input| input.name.as_str())
    }

    /// Name of its machine.
    pub fn machine(&self, cell: &Cell) -> &str {
        let input = self.machines.get(cell.machine);
        input.map_or("", |input| input.name.as_str())
    }

    /// What is the same in the keys of all cells of a program on a machine.
    pub fn key_stem(&self, program: usize, machine: usize) -> String {
        let of = |list: &[Input], index: usize| {
            list.get(index)
                .map_or(String::new(), |input| input.sha256.clone())
        };
        format!(
            "lostmotion sweep {}\nrelease {}\nmethods {}\nreading {}\nrun {}\nsubroutines {}\nprogram {}\nmachine {}\n",
            self.sweep,
            self.lostmotion,
            self.methods.join(","),
            ordered(&self.reading),
            ordered(&self.run),
            self.subroutines.as_deref().unwrap_or_default(),
            of(&self.programs, program),
            of(&self.machines, machine),
        )
    }

    /// The key of a cell: of the stem of its program and machine, and a line `KEY=VALUE` for each
    /// change of the machine.
    pub fn key(&self, stem: &str, values: &[Level]) -> Key {
        let mut text = stem.to_owned();
        for (coordinate, level) in self.vary.iter().zip(values) {
            for key in &coordinate.keys {
                let _ = writeln!(text, "{key}={level}");
            }
        }
        Key::of(&text)
    }
}

impl Manifest {
    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), SweepError> {
        let mut file = AtomicFile::create(path)?;
        let mut line = |text: serde_json::Result<String>| {
            let text = text.map_err(std::io::Error::other);
            text.and_then(|text| writeln!(file, "{text}"))
                .map_err(|error| WriteError::io("write", path, error))
        };
        line(serde_json::to_string(&self.header))?;
        for cell in &self.cells {
            line(serde_json::to_string(cell))?;
        }
        file.commit()?;
        Ok(())
    }

    /// Reads a manifest.
    ///
    /// # Errors
    /// A file that is none, is cut off, or is of another release.
    pub fn read(path: &Path) -> Result<Manifest, SweepError> {
        let file = File::open(path).map_err(|error| SweepError::unread("manifest", path, error))?;
        Manifest::from_lines(
            &path.display().to_string(),
            BufReader::with_capacity(1 << 16, file),
        )
    }

    /// The same from any reader; `name` is for messages.
    ///
    /// # Errors
    /// As [`Manifest::read`].
    pub fn from_lines(name: &str, mut lines: impl BufRead) -> Result<Manifest, SweepError> {
        let mut number = 0;
        let mut line = String::new();
        let mut next = |number: &mut usize| -> Result<Option<String>, SweepError> {
            *number += 1;
            line.clear();
            let read = std::io::Read::take(&mut lines, LONGEST_LINE).read_line(&mut line);
            let read = read.map_err(|source| SweepError::Read {
                what: "manifest",
                file: name.to_owned(),
                source,
            })?;
            Ok((read > 0).then(|| line.trim_end().to_owned()))
        };
        let broken = |line: usize, message: String| SweepError::Manifest {
            file: name.to_owned(),
            line,
            message,
        };
        let none = || "this is no manifest of a sweep (`study sweep plan` makes one)".to_owned();
        let first = next(&mut number)?.ok_or_else(|| broken(1, none()))?;
        let header: Header = serde_json::from_str(&first)
            .map_err(|error| broken(1, format!("{}: {error}", none())))?;
        if header.sweep != VERSION || header.lostmotion != RELEASE {
            return Err(SweepError::Release {
                file: name.to_owned(),
                there: header.lostmotion,
                here: RELEASE,
            });
        }
        let mut cells = Vec::new();
        while let Some(text) = next(&mut number)? {
            let cell = header.cell(&text).map_err(|why| broken(number, why))?;
            cells.push(cell);
        }
        if cells.len() != header.cells {
            let why = format!(
                "{} cells, but the header says {}",
                cells.len(),
                header.cells
            );
            return Err(broken(number, why));
        }
        Ok(Manifest { header, cells })
    }
}

impl Header {
    /// A cell from its line.
    ///
    /// # Errors
    /// A line that is none of this header's.
    pub fn cell(&self, line: &str) -> Result<Cell, String> {
        let cell: Cell = serde_json::from_str(line).map_err(|error| error.to_string())?;
        if cell.program >= self.programs.len() || cell.machine >= self.machines.len() {
            return Err("the header has no such program or machine".to_owned());
        }
        if cell.values.len() != self.vary.len() {
            let (found, wanted) = (cell.values.len(), self.vary.len());
            return Err(format!("{found} values where the header varies {wanted}"));
        }
        // A cell that was edited by hand would stand beside the result of another.
        let key = self.key(&self.key_stem(cell.program, cell.machine), &cell.values);
        if key != cell.key {
            return Err(format!("its key is {}, its inputs make {key}", cell.key));
        }
        Ok(cell)
    }
}
