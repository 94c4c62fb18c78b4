//! Cells as messages: what a worker on another machine needs, without files of its own.
//!
//! A driver opens a [`Driver`], sends [`Driver::shared`] once to each worker, its programs once each,
//! and lines of cells in batches; a worker answers with lines of results ([`work`]), which the driver
//! appends. Who carries the messages is no matter of this crate.

use crate::cell::CellResult;
use crate::error::SweepError;
use crate::inputs::{Inputs, MachineText, machine_text};
use crate::key::sha256;
use crate::manifest::{Cell, Header, Manifest};
use crate::results::{Results, line};
use crate::run::{Shard, missing, run_cells};
use lostmotion_sim::Program;
use serde::{Deserialize, Serialize};
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
    missing: Vec<Cell>,
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
        let results = Results::open(results)?;
        let cells = missing(&manifest, shard, results.done());
        // Read once to be held against the plan; workers get them one by one.
        drop(Inputs::load(&manifest, &cells, &folder)?);
        let missing = cells.into_iter().cloned().collect();
        Ok(Driver {
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
        let machines = self.manifest.header.machines.iter().map(|input| {
            // One that no cell needs may be missing.
            let needed = || {
                let of = |cell: &Cell| self.manifest.header.machine(cell) == input.name;
                self.missing.iter().any(of)
            };
            match machine_text(&input.name, &self.folder) {
                Ok(text) => Ok((text.name, text.toml)),
                Err(_) if !needed() => Ok((input.name.clone(), String::new())),
                Err(error) => Err(error),
            }
        });
        let shared = Shared {
            header: self.manifest.header.clone(),
            machines: machines.collect::<Result<_, _>>()?,
            folder: self.folder.clone(),
        };
        serde_json::to_vec(&shared).map_err(|error| unfit(&error))
    }

    /// Lines of some cells that are to be run, and the programs that they need.
    ///
    /// # Errors
    /// None for a manifest that was read.
    pub fn batch(
        &self,
        start: usize,
        count: usize,
    ) -> Result<(Vec<String>, Vec<usize>), SweepError> {
        let cells = self.missing.iter().skip(start).take(count);
        let mut programs: Vec<usize> = cells.clone().map(|cell| cell.program).collect();
        programs.dedup();
        let lines = cells.map(|cell| serde_json::to_string(cell).map_err(|error| unfit(&error)));
        Ok((lines.collect::<Result<_, _>>()?, programs))
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
            // A batch that was run twice, as its worker was lost too late, counts once.
            if !self.results.done().contains(&result.key) {
                self.results.append_line(text)?;
            }
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
    let Shared {
        header,
        machines,
        folder,
    } = serde_json::from_slice(shared).map_err(|error| unfit(&error))?;
    let cells: Vec<Cell> = cells
        .iter()
        .map(|text| header.cell(text).map_err(|why| SweepError::value(why, "")))
        .collect::<Result<_, _>>()?;
    let cells: Vec<&Cell> = cells.iter().collect();
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
            return Err(SweepError::Changed {
                what: input.name.clone(),
                cells: cells.iter().filter(|cell| cell.program == index).count(),
                key: cells
                    .first()
                    .map(|cell| cell.key.to_string())
                    .unwrap_or_default(),
            });
        }
        *place = Some(Program::from_bytes(input.name.clone(), bytes));
    }
    let machines = machines
        .into_iter()
        .map(|(name, toml)| MachineText { name, toml })
        .collect();
    let inputs = Inputs::of_parts(header, at_hand, machines, &cells, &folder)?;
    let mut lines = Vec::with_capacity(cells.len());
    run_cells(&inputs, &cells, threads, stop, &mut |result, _| {
        lines.push((result.key, line(result)?));
        Ok(())
    })?;
    let mut by_key: std::collections::HashMap<_, _> = lines.into_iter().collect();
    Ok(cells
        .iter()
        .filter_map(|cell| by_key.remove(&cell.key))
        .collect())
}
