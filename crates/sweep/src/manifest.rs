//! The plan of a sweep as lines of JSON: a header, then a line for each cell.

use crate::design::Level;
use crate::error::SweepError;
use crate::key::{Key, ordered};
use lostmotion_sim::machine::Change;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::Arc;

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

/// A sweep, planned: what its cells have in common, and where they are read from. The cells themselves are
/// not held, of which there may be millions.
#[derive(Clone, Debug)]
pub struct Manifest {
    /// What its cells have in common.
    pub header: Arc<Header>,
    path: PathBuf,
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

impl Header {
    /// A cell from its line.
    ///
    /// # Errors
    /// A line that is none of this header's.
    pub fn cell(&self, line: &str) -> Result<Cell, String> {
        self.checked(line, &mut Stem::default())
    }

    /// The same of a line among many, which mostly have program and machine in common.
    fn checked(&self, line: &str, stem: &mut Stem) -> Result<Cell, String> {
        let cell: Cell = serde_json::from_str(line).map_err(|error| error.to_string())?;
        if cell.program >= self.programs.len() || cell.machine >= self.machines.len() {
            return Err("the header has no such program or machine".to_owned());
        }
        if cell.values.len() != self.vary.len() {
            let (found, wanted) = (cell.values.len(), self.vary.len());
            return Err(format!("{found} values where the header varies {wanted}"));
        }
        // A cell that was edited by hand would stand beside the result of another.
        let key = self.key(stem.of(self, cell.program, cell.machine), &cell.values);
        if key != cell.key {
            return Err(format!("its key is {}, its inputs make {key}", cell.key));
        }
        Ok(cell)
    }
}

/// The stem of the keys of the program and machine that were asked for last.
#[derive(Debug, Default)]
struct Stem(Option<(usize, usize)>, String);

impl Stem {
    fn of(&mut self, header: &Header, program: usize, machine: usize) -> &str {
        if self.0 != Some((program, machine)) {
            *self = Stem(Some((program, machine)), header.key_stem(program, machine));
        }
        &self.1
    }
}

/// The lines of a manifest.
#[derive(Debug)]
struct ManifestLines {
    path: PathBuf,
    reader: BufReader<File>,
    /// Of the line read last, from 1.
    number: usize,
    line: String,
}

impl ManifestLines {
    fn open(path: &Path) -> Result<ManifestLines, SweepError> {
        let file = File::open(path).map_err(|error| SweepError::unread("manifest", path, error))?;
        Ok(ManifestLines {
            path: path.to_path_buf(),
            reader: BufReader::with_capacity(1 << 16, file),
            number: 0,
            line: String::new(),
        })
    }

    /// Reads the next line. Returns whether there was one.
    fn advance(&mut self) -> Result<bool, SweepError> {
        self.number += 1;
        self.line.clear();
        let read = std::io::Read::take(&mut self.reader, LONGEST_LINE).read_line(&mut self.line);
        let read = read.map_err(|error| SweepError::unread("manifest", &self.path, error))?;
        self.line.truncate(self.line.trim_end().len());
        Ok(read > 0)
    }

    fn broken(&self, message: String) -> SweepError {
        SweepError::Manifest {
            file: self.path.display().to_string(),
            line: self.number,
            message,
        }
    }

    /// The header, which is the first line.
    fn header(&mut self) -> Result<Header, SweepError> {
        let none = "this is no manifest of a sweep (`study sweep plan` makes one)";
        if !self.advance()? {
            return Err(self.broken(none.to_owned()));
        }
        let header: Header = serde_json::from_str(&self.line)
            .map_err(|error| self.broken(format!("{none}: {error}")))?;
        if header.sweep != VERSION || header.lostmotion != RELEASE {
            return Err(SweepError::Release {
                file: self.path.display().to_string(),
                there: header.lostmotion,
                here: RELEASE,
            });
        }
        Ok(header)
    }
}

/// The cells of a manifest as they are read, each held against its key.
#[derive(Debug)]
pub struct Cells {
    header: Arc<Header>,
    lines: ManifestLines,
    stem: Stem,
    read: usize,
    ended: bool,
}

impl Cells {
    fn advance(&mut self) -> Result<Option<Cell>, SweepError> {
        if !self.ended && self.lines.advance()? {
            self.read += 1;
            let cell = self.header.checked(&self.lines.line, &mut self.stem);
            return cell.map(Some).map_err(|why| self.lines.broken(why));
        }
        let (read, wanted) = (self.read, self.header.cells);
        if self.ended || read == wanted {
            return Ok(None);
        }
        Err(self
            .lines
            .broken(format!("{read} cells, but the header says {wanted}")))
    }
}

impl Iterator for Cells {
    type Item = Result<Cell, SweepError>;

    fn next(&mut self) -> Option<Result<Cell, SweepError>> {
        let next = self.advance();
        self.ended |= !matches!(next, Ok(Some(_)));
        next.transpose()
    }
}

impl Manifest {
    /// Opens a manifest. Its cells are held against their keys whenever they are read.
    ///
    /// # Errors
    /// A file that is none, or is of another release.
    pub fn read(path: &Path) -> Result<Manifest, SweepError> {
        Ok(Manifest {
            header: Arc::new(ManifestLines::open(path)?.header()?),
            path: path.to_path_buf(),
        })
    }

    /// Its cells, in their order, read anew from the file. The iterator ends with an error where the file is
    /// cut off or a line is no cell of its header.
    ///
    /// # Errors
    /// A file that cannot be read any more, or is another one now.
    pub fn cells(&self) -> Result<Cells, SweepError> {
        let mut lines = ManifestLines::open(&self.path)?;
        if lines.header()? != *self.header {
            return Err(lines.broken("the manifest has changed while it was read".to_owned()));
        }
        Ok(Cells {
            header: Arc::clone(&self.header),
            lines,
            stem: Stem::default(),
            read: 0,
            ended: false,
        })
    }

    /// Some cells, by their places.
    ///
    /// # Errors
    /// As [`Manifest::cells`].
    pub fn pick(&self, wanted: &BTreeSet<usize>) -> Result<BTreeMap<usize, Cell>, SweepError> {
        let mut found = BTreeMap::new();
        for (index, cell) in self.cells()?.enumerate() {
            if found.len() == wanted.len() {
                break;
            }
            if wanted.contains(&index) {
                found.insert(index, cell?);
            }
        }
        Ok(found)
    }
}
