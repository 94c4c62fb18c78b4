//! From results to one table: in the order of the manifest, the same bytes whatever runs, threads
//! and shards they came from.

use crate::cell::{CellResult, MethodFigures, Outcome};
use crate::design::Level;
use crate::error::SweepError;
use crate::key::Key;
use crate::manifest::{Cell, Manifest};
use crate::results::{Place, scan};
use lostmotion_report::csv::{ColumnKind, TableCell, TableCells, TableColumn, TableWriter};
use serde_json::json;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;

/// Results of a sweep, looked up by their cells. Held in memory are places, not results.
#[derive(Debug)]
pub struct Finished<'m> {
    manifest: &'m Manifest,
    files: Vec<(PathBuf, File)>,
    places: HashMap<Key, Option<(usize, Place)>>,
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
        let mut finished = Finished {
            manifest,
            files: Vec::new(),
            places: manifest.cells.iter().map(|cell| (cell.key, None)).collect(),
            repeated: 0,
            strangers: 0,
        };
        for path in paths {
            let file =
                File::open(path).map_err(|error| SweepError::unread("results", path, error))?;
            let again = file
                .try_clone()
                .map_err(|error| SweepError::unread("results", path, error))?;
            finished.files.push((path.clone(), file));
            let index = finished.files.len() - 1;
            let mut repeated = Vec::new();
            let (places, strangers) = (&mut finished.places, &mut finished.strangers);
            scan(path, &again, &mut |key, place| match places.get_mut(&key) {
                None => *strangers += 1,
                Some(known @ None) => *known = Some((index, place)),
                Some(Some(first)) => repeated.push((*first, (index, place))),
            })?;
            for (first, second) in repeated {
                finished.same(first, second)?;
            }
        }
        Ok(finished)
    }

    /// Refuses two results of one cell that differ: a cell has the same figures whenever it is run.
    fn same(&mut self, first: (usize, Place), second: (usize, Place)) -> Result<(), SweepError> {
        let [a, b] = [self.result_at(first)?, self.result_at(second)?];
        if a != b {
            let name = |place: (usize, Place)| {
                let path = self
                    .files
                    .get(place.0)
                    .map(|(path, _)| path.display().to_string());
                format!("{} at byte {}", path.unwrap_or_default(), place.1.start)
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

    fn result_at(&mut self, (index, place): (usize, Place)) -> Result<CellResult, SweepError> {
        let Some((path, file)) = self.files.get_mut(index) else {
            return Err(SweepError::value("a file of results is not open", ""));
        };
        let mut text = vec![0; place.bytes as usize];
        let read = file
            .seek(SeekFrom::Start(place.start))
            .and_then(|_| file.read_exact(&mut text));
        read.map_err(|error| SweepError::unread("results", path, error))?;
        serde_json::from_slice(&text).map_err(|error| SweepError::Results {
            file: path.display().to_string(),
            line: 0,
            message: format!("byte {}: {error}", place.start),
        })
    }

    /// The result of a cell, if it is done.
    ///
    /// # Errors
    /// The file has gone or changed.
    pub fn result(&mut self, key: Key) -> Result<Option<CellResult>, SweepError> {
        match self.places.get(&key).copied().flatten() {
            Some(place) => self.result_at(place).map(Some),
            None => Ok(None),
        }
    }

    /// Cells without a result, in the manifest's order, with their places in it.
    pub fn missing(&self) -> impl Iterator<Item = (usize, &'m Cell)> {
        let cells = self.manifest.cells.iter().enumerate();
        cells.filter(|(_, cell)| matches!(self.places.get(&cell.key), Some(None) | None))
    }

    /// Does something with each finished cell, in the manifest's order.
    pub(crate) fn each(
        &mut self,
        mut act: impl FnMut(usize, &Cell, &CellResult) -> Result<(), SweepError>,
    ) -> Result<(), SweepError> {
        let manifest = self.manifest;
        for (index, cell) in manifest.cells.iter().enumerate() {
            if let Some(result) = self.result(cell.key)? {
                act(index, cell, &result)?;
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
        let numbers: Vec<bool> = (0..manifest.header.vary.len())
            .map(|coordinate| is_number(manifest, coordinate))
            .collect();
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

/// Whether all values of a coordinate are numbers.
fn is_number(manifest: &Manifest, coordinate: usize) -> bool {
    let mut levels = manifest
        .cells
        .iter()
        .filter_map(|cell| cell.values.get(coordinate));
    levels.all(|level| matches!(level, Level::Number(_)))
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
