//! Cells as messages: what a worker on another machine needs, without files of its own.
//!
//! A driver opens a [`Driver`], sends [`Driver::shared`] once to each worker, its programs once each,
//! and lines of cells in batches; a worker answers with lines of results ([`work`]), which the driver
//! appends. A worker in the driver's own process gives each line as it is finished ([`work_each`]), so
//! that a kill loses no more than the cells in flight. Who carries the messages is no matter of this
//! crate.

use crate::cell::CellResult;
use crate::error::SweepError;
use crate::inputs::{Inputs, MachineText, has_changed, machine_text};
use crate::key::{Key, sha256};
use crate::manifest::{Cell, Header, Manifest};
use crate::missing::{Missing, MissingCells, Needs, Shard};
use crate::results::{Results, line};
use crate::run::run_cells;
use lostmotion_sim::Program;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// What is the same for all cells.
#[derive(Debug, Serialize, Deserialize)]
struct Shared {
    header: Header,
    /// Name and text of each machine.
    machines: Vec<(String, String)>,
    /// Where folders of subroutines are named from.
    folder: PathBuf,
}

/// The side that has the manifest and the file of results.
#[derive(Debug)]
pub struct Driver {
    manifest: Manifest,
    missing: Missing,
    /// Those of them that were not handed out yet.
    left: MissingCells,
    folder: PathBuf,
    results: Results,
}

impl Driver {
    /// Opens a manifest and its file of results.
    ///
    /// # Errors
    /// A manifest or results that cannot be read; inputs that have changed since the plan.
    pub fn open(manifest: &Path, shard: Shard, results: &Path) -> Result<Driver, SweepError> {
        let folder = match manifest.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let folder = folder
            .canonicalize()
            .map_err(|error| SweepError::unread("folder", folder, error))?;
        let manifest = Manifest::read(manifest)?;
        let (results, done) = Results::open(results)?;
        let missing = Missing::of(&manifest, shard, &done)?;
        // Read once to be held against the plan; workers get them one by one.
        drop(Inputs::load(&manifest.header, &missing.needs, &folder)?);
        Ok(Driver {
            left: missing.cells(&manifest)?,
            missing,
            manifest,
            folder,
            results,
        })
    }

    /// Number of cells that are to be run.
    pub fn len(&self) -> usize {
        self.missing.len()
    }

    /// Whether all are done.
    pub fn is_empty(&self) -> bool {
        self.missing.is_empty()
    }

    /// What every worker needs.
    ///
    /// # Errors
    /// A machine file that cannot be read any more.
    pub fn shared(&self) -> Result<Vec<u8>, SweepError> {
        let machines = self.manifest.header.machines.iter();
        let machines = machines
            .zip(&self.missing.needs.machines)
            .map(|(input, need)| {
                match machine_text(&input.name, &self.folder) {
                    Ok(text) => Ok((text.name, text.toml)),
                    // One that no cell needs may be missing.
                    Err(_) if need.cells == 0 => Ok((input.name.clone(), String::new())),
                    Err(error) => Err(error),
                }
            });
        let shared = Shared {
            header: Header::clone(&self.manifest.header),
            machines: machines.collect::<Result<_, _>>()?,
            folder: self.folder.clone(),
        };
        serde_json::to_vec(&shared).map_err(|error| unfit(&error))
    }

    /// Lines of the next cells that are to be run, `count` at most, and the programs that they need; none
    /// where all have been handed out.
    ///
    /// # Errors
    /// A manifest that cannot be read any more.
    pub fn take(&mut self, count: usize) -> Result<(Vec<String>, Vec<usize>), SweepError> {
        let (mut lines, mut programs) = (Vec::new(), Vec::new());
        for cell in self.left.by_ref().take(count) {
            let cell = cell?;
            lines.push(serde_json::to_string(&cell).map_err(|error| unfit(&error))?);
            programs.push(cell.program);
        }
        programs.dedup();
        Ok((lines, programs))
    }

    /// The text of a program.
    ///
    /// # Errors
    /// It cannot be read any more.
    pub fn program(&self, index: usize) -> Result<Vec<u8>, SweepError> {
        let input = self.manifest.header.programs.get(index);
        let name = input.map_or("", |input| input.name.as_str());
        let path = self.folder.join(name);
        std::fs::read(&path).map_err(|error| SweepError::unread("part program", &path, error))
    }

    /// Appends lines of results; gives the number of cells without figures among them, and the
    /// machine time that was simulated, s.
    ///
    /// # Errors
    /// A line that is no result; a disk that is full.
    pub fn append(&mut self, lines: &[String]) -> Result<(usize, f64), SweepError> {
        let (mut failed, mut simulated_s) = (0, 0.0);
        for text in lines {
            let result: CellResult = serde_json::from_str(text).map_err(|error| unfit(&error))?;
            self.results.append_line(text)?;
            match result.outcome {
                crate::cell::Outcome::Figures(figures) => {
                    simulated_s += figures.duration_s.unwrap_or_default();
                }
                crate::cell::Outcome::Error(_) => failed += 1,
            }
        }
        Ok((failed, simulated_s))
    }

    /// Makes sure that all results are on the disk.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn sync(&self) -> Result<(), SweepError> {
        self.results.sync()
    }
}

fn unfit(error: &serde_json::Error) -> SweepError {
    SweepError::value(format!("a message of the sweep is broken: {error}"), "")
}

/// Runs the cells of a batch on a number of threads (0: one per core); gives the lines of their
/// results in the order of the cells. `stop` ends it early, with what is done by then.
///
/// # Errors
/// Messages that are broken; a program that is not the one of the plan.
pub fn work(
    shared: &[u8],
    programs: Vec<(usize, Vec<u8>)>,
    cells: &[String],
    threads: usize,
    stop: &AtomicBool,
) -> Result<Vec<String>, SweepError> {
    let mut by_key = HashMap::with_capacity(cells.len());
    let keys = work_each(shared, programs, cells, threads, stop, &mut |key, line| {
        by_key.insert(key, line);
        Ok(())
    })?;
    Ok(keys.iter().filter_map(|key| by_key.remove(key)).collect())
}

/// The same; gives the keys of the cells, and `sink` takes each line as it is finished, in no particular
/// order, on the caller's thread.
///
/// # Errors
/// As [`work`]; whatever the sink answers.
pub fn work_each(
    shared: &[u8],
    programs: Vec<(usize, Vec<u8>)>,
    cells: &[String],
    threads: usize,
    stop: &AtomicBool,
    sink: &mut dyn FnMut(Key, String) -> Result<(), SweepError>,
) -> Result<Vec<Key>, SweepError> {
    let Shared {
        header,
        machines,
        folder,
    } = serde_json::from_slice(shared).map_err(|error| unfit(&error))?;
    let cells: Vec<Cell> = cells
        .iter()
        .map(|text| header.cell(text).map_err(|why| SweepError::value(why, "")))
        .collect::<Result<_, _>>()?;
    let mut needs = Needs::none(&header);
    cells.iter().for_each(|cell| needs.count(cell));
    let mut at_hand: Vec<Option<Program>> = header.programs.iter().map(|_| None).collect();
    for (index, bytes) in programs {
        let Some((input, place)) = header.programs.get(index).zip(at_hand.get_mut(index)) else {
            return Err(SweepError::value(
                format!("there is no program {index}"),
                "",
            ));
        };
        let digest = sha256(bytes.as_slice());
        if digest.ok().as_ref() != Some(&input.sha256) {
            let need = needs.programs.get(index).copied().unwrap_or_default();
            return Err(has_changed(&input.name, &need));
        }
        *place = Some(Program::from_bytes(input.name.clone(), bytes));
    }
    let machines = machines
        .into_iter()
        .map(|(name, toml)| MachineText { name, toml })
        .collect();
    let inputs = Inputs::of_parts(header, at_hand, machines, &needs, &folder)?;
    let count = cells.len();
    let keys = cells.iter().map(|cell| cell.key).collect();
    let cells = cells.into_iter().map(Ok);
    run_cells(&inputs, (cells, count), threads, stop, &mut |result, _| {
        sink(result.key, line(result)?)
    })?;
    Ok(keys)
}
