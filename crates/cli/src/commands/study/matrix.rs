//! `lostmotion study matrix`.

use super::journal::Journal;
use super::{failure, methods};
use crate::args::study::Matrix;
use crate::commands::{DONE, show};
use crate::failure::Failure;
use crate::progress::Progress;
use lostmotion::report::WriteError;
use lostmotion::report::atomic::OutputFolder;
use lostmotion_study::StudyError;
use lostmotion_study::matrix::journal::{Header, line};
use lostmotion_study::matrix::{Cell, CellResult, all_cells, run_cells, sample, table};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// Runs the cells that are not there yet, and sums up.
pub(crate) fn run(args: &Matrix, quiet: bool) -> Result<u8, Failure> {
    if args.threads == Some(0) {
        return Err(Failure::with_hint(
            "--threads is 0",
            "leave it out to use all cores",
        ));
    }
    let methods = methods(&args.methods)?;
    let cells = if args.full {
        all_cells()
    } else {
        sample(args.cells, args.seed).map_err(|error| failure(&error))?
    };
    let header = Header::new((!args.full).then_some(args.cells), args.seed, &methods);
    let mut journal = args
        .out
        .as_deref()
        .map(|folder| Journal::open(folder, &header, args.fresh))
        .transpose()?;
    let mut results = journal
        .as_mut()
        .map(|journal| std::mem::take(&mut journal.results))
        .unwrap_or_default();
    let missing: Vec<Cell> = cells
        .iter()
        .copied()
        .filter(|cell| !results.contains_key(cell))
        .collect();
    for result in run_missing(
        &missing,
        &methods,
        args.threads.unwrap_or(0),
        journal.as_mut(),
        quiet,
    )? {
        results.insert(result.cell, result);
    }
    let results = in_order(&cells, results);
    let what = if args.full {
        "all there are".to_owned()
    } else {
        format!("sampled with seed {}", args.seed)
    };
    let (markdown, json) = (
        table::markdown(&results, &what),
        table::json(&results, &what).map_err(|error| failure(&error))?,
    );
    if let Some(folder) = &args.out {
        write(
            folder,
            &[
                ("matrix.md", &markdown),
                ("matrix.csv", &table::csv(&results)),
                ("matrix.json", &json),
            ],
        )?;
    }
    show(args.format, &json, &markdown)?;
    Ok(DONE)
}

fn run_missing(
    cells: &[Cell],
    methods: &[String],
    threads: usize,
    mut journal: Option<&mut Journal>,
    quiet: bool,
) -> Result<Vec<CellResult>, Failure> {
    let mut progress = Progress::new(quiet);
    let mut unwritten = None;
    let run = run_cells(cells, methods, threads, &mut |result, state| {
        progress.update(state.done as u64, state.all as u64, state.simulated_s);
        let Some(journal) = journal.as_mut() else {
            return Ok(());
        };
        journal.append(&line(result)?).map_err(|failure| {
            unwritten = Some(failure);
            StudyError::Sink("the results cannot be kept".to_owned())
        })
    });
    progress.finish();
    match (unwritten, run) {
        (Some(failure), _) => Err(failure),
        (None, run) => run.map_err(|error| failure(&error)),
    }
}

fn in_order(cells: &[Cell], mut results: BTreeMap<Cell, CellResult>) -> Vec<CellResult> {
    cells
        .iter()
        .filter_map(|cell| results.remove(cell))
        .collect()
}

fn write(folder: &Path, files: &[(&str, &String)]) -> Result<(), Failure> {
    let mut folder = OutputFolder::create(folder)?;
    for (name, text) in files {
        let mut file = folder.file(name)?;
        file.write_all(text.as_bytes())
            .map_err(|error| WriteError::io("write into", folder.path(), error))?;
        folder.add(file);
    }
    folder.commit()?;
    Ok(())
}
