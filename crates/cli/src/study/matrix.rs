//! `lostmotion study matrix`: cells that are run, and the journal in which the results so far are
//! kept.

use super::{Page, failure, known_methods, methods, write_page};
use crate::options::{Format, show, threads, whole};
use crate::output::{DONE, Failure, Progress, create_folder, refuse_standard};
use clap::{Args, ValueHint};
use lostmotion::report::WriteError;
use lostmotion::report::page::study_page;
use lostmotion_study::StudyError;
use lostmotion_study::matrix::journal::{Found, Header, line, read};
use lostmotion_study::matrix::{Cell, CellResult, all_cells, run_cells, sample, table};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// `study matrix`.
#[derive(Debug, Args)]
pub(crate) struct MatrixArgs {
    /// Number of cells sampled
    #[arg(long, value_name = "N", default_value_t = 120, conflicts_with = "full", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) cells: usize,
    /// Seed of the sample
    #[arg(long, value_name = "S", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>)]
    pub(crate) seed: u64,
    /// Every cell; takes days
    #[arg(long)]
    pub(crate) full: bool,
    /// Compensation methods, separated by commas; all but `fitted-lookup`, if left out
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = known_methods())]
    pub(crate) methods: Vec<String>,
    /// Folder for the tables, and for the results so far: run again, a stopped study goes on
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) page: Page,
    /// Forget the results so far in the folder
    #[arg(long, requires = "out")]
    pub(crate) fresh: bool,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    /// Threads to use at most; all cores, if left out. The answer does not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) threads: Option<usize>,
}

/// Runs the cells that are not there yet, and sums up.
pub(super) fn run(args: &MatrixArgs, quiet: bool) -> Result<u8, Failure> {
    let threads = threads(args.threads)?;
    let methods = methods(&args.methods)?;
    let cells = if args.full {
        all_cells()
    } else {
        sample(args.cells, args.seed).map_err(|error| failure(&error))?
    };
    // All that the figures depend on, so that a journal of another study is noticed.
    let header = Header::new((!args.full).then_some(args.cells), args.seed, &methods);
    let page_file = args.page.open()?;
    let mut journal = args
        .out
        .as_deref()
        .map(|folder| Journal::open(folder, &header, args.fresh))
        .transpose()?;
    // What an earlier run has finished is not run again.
    let mut results = journal
        .as_mut()
        .map(|journal| std::mem::take(&mut journal.results))
        .unwrap_or_default();
    let missing: Vec<Cell> = cells
        .iter()
        .copied()
        .filter(|cell| !results.contains_key(cell))
        .collect();
    for result in run_missing(&missing, &methods, threads, journal.as_mut(), quiet)? {
        results.insert(result.cell, result);
    }
    // In the order of the sample, whichever run or thread finished a cell.
    let results = in_order(&cells, results);
    let what = if args.full {
        "all".to_owned()
    } else {
        format!("sampled with seed {}", args.seed)
    };
    let (markdown, json) = (
        table::markdown(&results, &what),
        table::json(&results, &what).map_err(|error| failure(&error))?,
    );
    let title = format!("Test matrix of the compensators, {what}");
    let page = study_page(&title, &table::left(&results), &markdown);
    if let Some(folder) = &args.out {
        write(
            folder,
            &[
                ("matrix.md", &markdown),
                ("matrix.html", &page),
                ("matrix.csv", &table::csv(&results)),
                ("matrix.json", &json),
            ],
        )?;
    }
    write_page(page_file, &page)?;
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
    // Each result goes to the journal at once: a study of days can be stopped at any time.
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
    // A full disk is the cause; that the study was stopped is its effect.
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
    let mut folder = create_folder(folder)?;
    for (name, text) in files {
        let mut file = folder.file(name)?;
        file.write_all(text.as_bytes())
            .map_err(|error| WriteError::io("write into", folder.path(), error))?;
        folder.add(file);
    }
    folder.commit()?;
    Ok(())
}

/// File of the results so far in the folder of a study.
const JOURNAL_NAME: &str = "cells.jsonl";

/// A journal open for more results.
struct Journal {
    path: PathBuf,
    file: File,
    /// What was there.
    results: BTreeMap<Cell, CellResult>,
}

impl Journal {
    /// Opens the journal of a folder, which is made if it does not exist; begins it if there is
    /// none, or if asked to.
    fn open(folder: &Path, header: &Header, fresh: bool) -> Result<Journal, Failure> {
        refuse_standard(folder, "a folder")?;
        if folder.exists() && !folder.is_dir() {
            return Err(WriteError::NotFolder {
                path: folder.to_path_buf(),
            }
            .into());
        }
        std::fs::create_dir_all(folder).map_err(|error| WriteError::io("create", folder, error))?;
        let path = folder.join(JOURNAL_NAME);
        let failed = |error| Failure::from(WriteError::io("write", &path, error));
        // In place, not as a file that appears at the end: what is done must survive a kill at any
        // time.
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(fresh)
            .open(&path)
            .map_err(failed)?;
        let mut text = String::new();
        file.read_to_string(&mut text)
            .map_err(|error| match error.kind() {
                ErrorKind::InvalidData => {
                    Failure::with_hint(format!("{} is not text", path.display()), OTHER_STUDY_HINT)
                }
                _ => failed(error),
            })?;
        // A journal of other cells or methods is refused: mixing them would make a wrong table.
        let found = read(&text, header).map_err(|error| {
            Failure::with_hint(format!("{}: {error}", path.display()), OTHER_STUDY_HINT)
        })?;
        let mut journal = Journal {
            file,
            results: BTreeMap::new(),
            path,
        };
        // The last line may be half written where a run was killed.
        journal.trim(&found)?;
        // A journal that has not begun, or that was cut off within its header.
        if found.whole_bytes == 0 {
            journal.append(&line(header).map_err(|error| failure(&error))?)?;
        }
        journal.results = found.results;
        Ok(journal)
    }

    /// Cuts off a line that was not finished.
    fn trim(&mut self, found: &Found) -> Result<(), Failure> {
        let end = found.whole_bytes as u64;
        let done = self
            .file
            .set_len(end)
            .and_then(|()| self.file.seek(SeekFrom::Start(end)));
        done.map(|_| ())
            .map_err(|error| WriteError::io("write", &self.path, error).into())
    }

    /// Puts a line at the end, at once and whole.
    fn append(&mut self, text: &str) -> Result<(), Failure> {
        self.file
            .write_all(text.as_bytes())
            .map_err(|error| WriteError::io("write", &self.path, error).into())
    }
}

/// What to do about a journal of another study.
const OTHER_STUDY_HINT: &str = "--fresh forgets what is there; another --out keeps it";
