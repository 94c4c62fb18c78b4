//! From results to one table: in the order of the manifest, the same bytes whatever runs, threads
//! and shards they came from.

use crate::cell::{CellResult, MethodFigures, Outcome};
use crate::design::Level;
use crate::error::SweepError;
use crate::key::{Key, Keys};
use crate::manifest::{Cell, Manifest};
use crate::results::scan;
use lostmotion_report::csv::{ColumnKind, TableCell, TableCells, TableColumn, TableWriter};
use serde_json::json;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file of results, read here and there.
#[derive(Debug)]
struct ResultLines {
    path: PathBuf,
    reader: BufReader<File>,
    /// The byte that is read next. Results mostly follow each other as their cells do: seeking a little
    /// forward stays in the reader's buffer.
    next: u64,
}

impl ResultLines {
    fn open(path: &Path) -> Result<ResultLines, SweepError> {
        let file = File::open(path).map_err(|error| SweepError::unread("results", path, error))?;
        Ok(ResultLines {
            path: path.to_path_buf(),
            reader: BufReader::with_capacity(1 << 16, file),
            next: 0,
        })
    }

    /// The result whose line begins at a byte.
    fn at(&mut self, start: u64) -> Result<CellResult, SweepError> {
        let mut line = Vec::new();
        let moved = match i64::try_from(start).ok().zip(i64::try_from(self.next).ok()) {
            Some((start, next)) => self.reader.seek_relative(start - next),
            None => self.reader.seek(SeekFrom::Start(start)).map(drop),
        };
        let read = moved.and_then(|()| self.reader.read_until(b'\n', &mut line));
        let read = read.map_err(|error| SweepError::unread("results", &self.path, error))?;
        self.next = start + read as u64;
        serde_json::from_slice(&line).map_err(|error| SweepError::Results {
            file: self.path.display().to_string(),
            line: 0,
            message: format!("byte {start}: {error}"),
        })
    }
}

/// Where a result is: the number of its file and the first byte of its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place(u64);

/// Bits of a place that say the byte: files up to 16 TB, and a million of them.
const BYTE_BITS: u32 = 44;

impl Place {
    /// No result yet.
    const NONE: Place = Place(u64::MAX);

    /// Of a byte of a file; `None` beyond what can be told.
    fn of(file: usize, byte: u64) -> Option<Place> {
        let file = u64::try_from(file)
            .ok()
            .filter(|file| *file < (1 << (u64::BITS - BYTE_BITS)) - 1)?;
        (byte >> BYTE_BITS == 0).then_some(Place(file << BYTE_BITS | byte))
    }

    fn file(self) -> usize {
        (self.0 >> BYTE_BITS) as usize
    }

    fn byte(self) -> u64 {
        self.0 & ((1 << BYTE_BITS) - 1)
    }
}

/// Results of a sweep, looked up by their cells. Held in memory are keys and places, 24 bytes a cell.
#[derive(Debug)]
pub struct Finished<'m> {
    manifest: &'m Manifest,
    files: Vec<ResultLines>,
    keys: Keys,
    /// In the order of the keys.
    places: Vec<Place>,
    /// Whether all values of each coordinate are numbers.
    numeric: Vec<bool>,
    /// Results that were there more than once, with the same figures.
    pub repeated: usize,
    /// Results of cells that the manifest does not have.
    pub strangers: usize,
}

impl<'m> Finished<'m> {
    /// Reads where the results of a manifest's cells are in some files.
    ///
    /// # Errors
    /// A file that cannot be read; a line that is no result; two results of one cell that differ.
    pub fn read(manifest: &'m Manifest, paths: &[PathBuf]) -> Result<Finished<'m>, SweepError> {
        let mut numeric = vec![true; manifest.header.vary.len()];
        let mut keys = Vec::new();
        for cell in manifest.cells()? {
            let cell = cell?;
            for (numeric, level) in numeric.iter_mut().zip(&cell.values) {
                *numeric &= matches!(level, Level::Number(_));
            }
            keys.push(cell.key);
        }
        let keys = Keys::of(keys);
        let mut finished = Finished {
            manifest,
            files: Vec::new(),
            places: vec![Place::NONE; keys.len()],
            keys,
            numeric,
            repeated: 0,
            strangers: 0,
        };
        for (index, path) in paths.iter().enumerate() {
            finished.files.push(ResultLines::open(path)?);
            let file =
                File::open(path).map_err(|error| SweepError::unread("results", path, error))?;
            let mut repeated = Vec::new();
            let mut beyond = false;
            let (keys, places) = (&finished.keys, &mut finished.places);
            let strangers = &mut finished.strangers;
            scan(path, &file, &mut |key, byte| {
                let known = keys.place(&key).and_then(|place| places.get_mut(place));
                match (known, Place::of(index, byte)) {
                    (None, _) => *strangers += 1,
                    (_, None) => beyond = true,
                    (Some(known), Some(place)) if *known == Place::NONE => *known = place,
                    (Some(known), Some(place)) => repeated.push((*known, place)),
                }
            })?;
            if beyond {
                let message = format!("{} is too long, or one of too many files", path.display());
                return Err(SweepError::value(message, "collect it in parts"));
            }
            for (first, second) in repeated {
                finished.same(first, second)?;
            }
        }
        Ok(finished)
    }

    /// Refuses two results of one cell that differ: a cell has the same figures whenever it is run.
    fn same(&mut self, first: Place, second: Place) -> Result<(), SweepError> {
        let [a, b] = [self.result_at(first)?, self.result_at(second)?];
        if a != b {
            let name = |place: Place| {
                let file = self.files.get(place.file());
                let path = file.map(|file| file.path.display().to_string());
                format!("{} at byte {}", path.unwrap_or_default(), place.byte())
            };
            let message = format!(
                "two results of cell {} differ: {}, and {}",
                a.key,
                name(first),
                name(second)
            );
            return Err(SweepError::value(
                message,
                "one of them was edited, or made by a faulty computer: take both out and run again",
            ));
        }
        self.repeated += 1;
        Ok(())
    }

    fn result_at(&mut self, place: Place) -> Result<CellResult, SweepError> {
        match self.files.get_mut(place.file()) {
            Some(file) => file.at(place.byte()),
            None => Err(SweepError::value("a file of results is not open", "")),
        }
    }

    fn place(&self, key: &Key) -> Option<Place> {
        let place = self.keys.place(key).and_then(|at| self.places.get(at));
        place.copied().filter(|place| *place != Place::NONE)
    }

    /// Number of cells without a result, and the first `most` of them with their places in the manifest.
    ///
    /// # Errors
    /// A manifest that cannot be read any more.
    pub fn missing(&self, most: usize) -> Result<(usize, Vec<(usize, Cell)>), SweepError> {
        let (mut count, mut first) = (0, Vec::new());
        // None of a whole sweep: it need not be read once more.
        if !self.places.contains(&Place::NONE) {
            return Ok((count, first));
        }
        for (index, cell) in self.manifest.cells()?.enumerate() {
            let cell = cell?;
            if self.place(&cell.key).is_none() {
                count += 1;
                if first.len() < most {
                    first.push((index, cell));
                }
            }
        }
        Ok((count, first))
    }

    /// Does something with each finished cell, in the manifest's order.
    pub(crate) fn each(
        &mut self,
        mut act: impl FnMut(usize, &Cell, &CellResult) -> Result<(), SweepError>,
    ) -> Result<(), SweepError> {
        for (index, cell) in self.manifest.cells()?.enumerate() {
            let cell = cell?;
            if let Some(place) = self.place(&cell.key) {
                act(index, &cell, &self.result_at(place)?)?;
            }
        }
        Ok(())
    }

    /// Writes the table: a row for each finished cell and method.
    ///
    /// # Errors
    /// Those of the files and of the writer.
    pub fn write_table<T: TableCells>(&mut self, out: T::Out) -> Result<T::Out, SweepError> {
        let manifest = self.manifest;
        let numbers = self.numeric.clone();
        let columns = columns(manifest, &numbers);
        let mut table =
            TableWriter::<T>::start(out, &columns).map_err(|error| unwritten(&error))?;
        self.each(|index, cell, result| {
            match &result.outcome {
                Outcome::Figures(figures) => {
                    for method in &figures.methods {
                        let [max, rms] = figures.without_gap_um;
                        let (duration, length) = (figures.duration_s, figures.cutting_mm);
                        let common = [duration, length, figures.tolerance_um, max, rms];
                        let row = Row {
                            index,
                            cell,
                            manifest,
                            numbers: &numbers,
                            method: &method.method,
                        };
                        row.write(&mut table, &common, Some(method), "")?;
                    }
                }
                Outcome::Error(failed) => {
                    for method in &manifest.header.methods {
                        let row = Row {
                            index,
                            cell,
                            manifest,
                            numbers: &numbers,
                            method,
                        };
                        row.write(&mut table, &[None; 5], None, &failed.message)?;
                    }
                }
            }
            Ok(())
        })?;
        table.finish().map_err(|error| unwritten(&error))
    }

    /// Writes lines of JSON: each finished cell with its inputs by name, and its result.
    ///
    /// # Errors
    /// Those of the files and of the writer.
    pub fn write_lines(&mut self, out: &mut dyn Write) -> Result<(), SweepError> {
        let manifest = self.manifest;
        self.each(|index, cell, result| {
            let header = &manifest.header;
            let values = header.vary.iter().map(|coordinate| coordinate.name.clone());
            let values: serde_json::Map<_, _> = values
                .zip(cell.values.iter().map(|level| json!(level)))
                .collect();
            let line = json!({
                "cell": index,
                "key": cell.key,
                "program": header.program(cell),
                "machine": header.machine(cell),
                "values": values,
                "result": result.outcome,
            });
            writeln!(out, "{line}").map_err(|error| unwritten(&error))
        })
    }
}

fn unwritten(error: &io::Error) -> SweepError {
    SweepError::value(format!("cannot write the table: {error}"), "")
}

/// Figures of a row besides those of its method.
const COMMON: [&str; 5] = [
    "duration_s",
    "cutting_mm",
    "tolerance_um",
    "without_gap_max_um",
    "without_gap_rms_um",
];

/// Figures of a method.
const OF_METHOD: [&str; 6] = [
    "max_um",
    "rms_um",
    "p99_um",
    "backlash_max_um",
    "backlash_rms_um",
    "rapid_max_um",
];

fn columns(manifest: &Manifest, numbers: &[bool]) -> Vec<TableColumn> {
    use ColumnKind::{Integer, Number, Text};
    let mut columns = vec![TableColumn::new("cell", Integer)];
    columns.extend(["key", "program", "machine"].map(|name| TableColumn::new(name, Text)));
    for (coordinate, is_number) in manifest.header.vary.iter().zip(numbers) {
        let kind = if *is_number { Number } else { Text };
        columns.push(TableColumn::new(&coordinate.name, kind));
    }
    columns.push(TableColumn::new("method", Text));
    columns.extend(COMMON.map(|name| TableColumn::new(name, Number)));
    columns.extend(OF_METHOD.map(|name| TableColumn::new(name, Number)));
    columns.extend(["worst_line", "within"].map(|name| TableColumn::new(name, Integer)));
    columns.extend(["stop", "error"].map(|name| TableColumn::new(name, Text)));
    // What is varied may be named like a figure: the table would have two columns of one name.
    let fixed = columns.clone();
    let vary = 4..4 + manifest.header.vary.len();
    for (index, column) in columns.iter_mut().enumerate() {
        let same = |(other, fixed): (usize, &TableColumn)| {
            !vary.contains(&other) && fixed.name == column.name
        };
        if vary.contains(&index) && fixed.iter().enumerate().any(same) {
            column.name = format!("vary_{}", column.name);
        }
    }
    columns
}

/// A row of the table.
struct Row<'a> {
    index: usize,
    cell: &'a Cell,
    manifest: &'a Manifest,
    /// Which coordinates have numbers alone.
    numbers: &'a [bool],
    method: &'a str,
}

impl Row<'_> {
    fn write<T: TableCells>(
        &self,
        table: &mut TableWriter<T>,
        common: &[Option<f64>; 5],
        figures: Option<&MethodFigures>,
        error: &str,
    ) -> Result<(), SweepError> {
        let header = &self.manifest.header;
        let key = self.cell.key.to_string();
        let mut cells = vec![
            TableCell::Integer(i64::try_from(self.index).unwrap_or(i64::MAX)),
            TableCell::Text(&key),
            TableCell::Text(header.program(self.cell)),
            TableCell::Text(header.machine(self.cell)),
        ];
        let levels: Vec<String> = self.cell.values.iter().map(ToString::to_string).collect();
        for ((level, text), is_number) in self.cell.values.iter().zip(&levels).zip(self.numbers) {
            cells.push(match level {
                Level::Number(number) if *is_number => TableCell::Exact(*number),
                _ => TableCell::Text(text),
            });
        }
        cells.push(TableCell::Text(self.method));
        let of_method = figures.map_or([None; 6], |figures| {
            [
                figures.max_um,
                figures.rms_um,
                figures.p99_um,
                figures.backlash_max_um,
                figures.backlash_rms_um,
                figures.rapid_max_um,
            ]
        });
        let numbers = common.iter().copied().chain(of_method);
        cells.extend(numbers.map(|number| TableCell::Measure(number.unwrap_or(f64::NAN))));
        cells.push(TableCell::Integer(
            figures.map_or(0, |figures| i64::from(figures.worst_line)),
        ));
        // Truth values as 0 and 1, which any program can add up.
        cells.push(TableCell::Integer(
            figures.map_or(0, |figures| i64::from(figures.within)),
        ));
        cells.push(TableCell::Text(
            figures
                .and_then(|figures| figures.stop.as_deref())
                .unwrap_or_default(),
        ));
        cells.push(TableCell::Text(error));
        table.push(&cells).map_err(|error| unwritten(&error))
    }
}
