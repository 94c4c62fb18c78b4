//! `lostmotion study sweep`: many programs, machines and settings; planned, run in parts, collected.

use crate::input;
use crate::options::{threads, whole};
use crate::output::{self, DONE, FOUND, Failure, Progress, refuse_inputs};
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand, ValueHint};
use lostmotion::report::WriteError;
use lostmotion::report::atomic::AtomicFile;
use lostmotion::report::csv::Rows;
use lostmotion::report::parquet::Columns;
use lostmotion_sweep::SweepError;
use lostmotion_sweep::collect::Finished;
use lostmotion_sweep::emit::{Job, Scheduler, script};
use lostmotion_sweep::file::SweepFile;
use lostmotion_sweep::inputs::Inputs;
use lostmotion_sweep::manifest::Manifest;
use lostmotion_sweep::missing::{Missing, Shard};
use lostmotion_sweep::page::page as sweep_page;
use lostmotion_sweep::plan::{Folders, plan};
use lostmotion_sweep::results::Results;
use lostmotion_sweep::run::run_cells;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// `study sweep`.
#[derive(Debug, Subcommand)]
pub(crate) enum SweepCommand {
    /// Plan a sweep: a manifest with a line for each cell
    Plan(PlanArgs),
    /// Run the cells of a manifest, or a shard of them; goes on where an earlier run stopped
    Run(RunArgs),
    /// Put results together: one table in the order of the manifest, and a page
    Collect(CollectArgs),
    /// Print a script that runs the shards with a scheduler: Slurm, HyperQueue, Dask, Kubernetes
    Emit(EmitArgs),
}

/// `study sweep plan`.
#[derive(Debug, Args)]
pub(crate) struct PlanArgs {
    /// Sweep file: programs, machines, methods, and what is varied
    #[arg(value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// Manifest to write; file names in it start from its folder
    #[arg(long, short, value_name = "MANIFEST.jsonl", value_hint = ValueHint::FilePath)]
    out: PathBuf,
    /// Most cells, in place of the file's own limit
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    most_cells: Option<usize>,
}

/// `study sweep run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Manifest that `study sweep plan` has written
    #[arg(value_hint = ValueHint::FilePath)]
    manifest: PathBuf,
    /// Part of the cells: the Ith of every N
    #[arg(
        long,
        value_name = "I/N",
        default_value = "1/1",
        allow_hyphen_values = true
    )]
    shard: Shard,
    /// File of results to go on with; if left out MANIFEST.results.jsonl, of a shard
    /// MANIFEST.results-I-of-N.jsonl
    #[arg(long, short, value_name = "RESULTS.jsonl", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,
    /// Threads to use at most; all cores, if left out. The results do not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    threads: Option<usize>,
}

/// `study sweep collect`.
#[derive(Debug, Args)]
pub(crate) struct CollectArgs {
    /// Manifest of the sweep
    #[arg(value_hint = ValueHint::FilePath)]
    manifest: PathBuf,
    /// Files of results; if left out all that `study sweep run` names after the manifest
    #[arg(value_hint = ValueHint::FilePath)]
    results: Vec<PathBuf>,
    /// Table to write, a row for each cell and method: .parquet, .csv, or .jsonl with a line for each
    /// cell
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    out: PathBuf,
    /// Also write a page for a browser: what each method leaves, over what is varied
    #[arg(long, value_name = "FILE.html", value_hint = ValueHint::FilePath)]
    html: Option<PathBuf>,
}

/// `study sweep emit`.
#[derive(Debug, Args)]
pub(crate) struct EmitArgs {
    /// Scheduler
    #[arg(value_parser = PossibleValuesParser::new(Scheduler::ALL.map(|(name, _)| name)))]
    scheduler: String,
    /// Manifest, as the machines that run it see it
    #[arg(value_hint = ValueHint::FilePath)]
    manifest: PathBuf,
    /// Number of shards; if left out as many as give each 100 cells, at most 1000
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    shards: Option<usize>,
    /// Cores for each shard
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<usize>)]
    cores: usize,
    /// Container image with this program, for k8s
    #[arg(long, value_name = "NAME", default_value = "lostmotion:latest")]
    image: String,
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Failure {
        match error {
            SweepError::Machine(error) => crate::options::machine::failure(&error),
            error => Failure::with_hint(error.to_string(), error.hint()),
        }
    }
}

/// Whether a run of cells is on, which is to be ended after those in flight.
static RUNNING: AtomicBool = AtomicBool::new(false);
/// Whether it is to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// Asks a run of cells to end; false where there is none, or it has been asked before: then the
/// process may end at once, and nothing that is finished is lost.
pub(crate) fn ends_after_cells() -> bool {
    let first = RUNNING.load(Ordering::SeqCst) && !STOP.swap(true, Ordering::SeqCst);
    if first {
        output::remark("ending after the cells in flight; once more ends at once");
    }
    first
}

/// Does what was asked for.
pub(super) fn run(command: &SweepCommand, quiet: bool) -> Result<u8, Failure> {
    match command {
        SweepCommand::Plan(args) => planned(args, quiet),
        SweepCommand::Run(args) => ran(args, quiet),
        SweepCommand::Collect(args) => collected(args, quiet),
        SweepCommand::Emit(args) => emitted(args),
    }
}

/// The folder of a file.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A file as messages name it, of which the last part is enough.
fn file_name(path: &Path) -> String {
    path.file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn planned(args: &PlanArgs, quiet: bool) -> Result<u8, Failure> {
    output::refuse_standard(&args.out, "a file")?;
    output::refuse_input(&args.out, &args.file, "sweep file")?;
    let text = input::text(&args.file, "sweep file")?;
    let file = SweepFile::from_toml(&file_name(&args.file), &text)?;
    let folders = Folders {
        file: folder(&args.file),
        manifest: folder(&args.out),
    };
    if !folders.manifest.is_dir() {
        let message = format!("the folder {} does not exist", folders.manifest.display());
        return Err(Failure::with_hint(
            message,
            "file names in a manifest start from its folder",
        ));
    }
    let plan = plan(&file, folders, args.most_cells)?;
    plan.write(&args.out)?;
    if !quiet {
        let header = &plan.header;
        output::remark(&format!(
            "{}: cells: {}; programs: {}, machines: {}, methods side by side: {}",
            args.out.display(),
            header.cells,
            header.programs.len(),
            header.machines.len(),
            header.methods.len()
        ));
    }
    Ok(DONE)
}

/// A manifest that exists.
fn manifest(path: &Path) -> Result<Manifest, Failure> {
    // For its messages about folders and files that are not there.
    input::open(path, "manifest")?;
    Ok(Manifest::read(path)?)
}

/// The name of a manifest without its ending.
fn stem(manifest: &Path) -> String {
    let name = file_name(manifest);
    name.strip_suffix(".jsonl").unwrap_or(&name).to_owned()
}

fn ran(args: &RunArgs, quiet: bool) -> Result<u8, Failure> {
    let threads = threads(args.threads)?;
    let manifest = manifest(&args.manifest)?;
    let shard = args.shard;
    let out = args.out.clone().unwrap_or_else(|| {
        let part = match shard {
            Shard::WHOLE => String::new(),
            Shard { index, count } => format!("-{index}-of-{count}"),
        };
        let name = format!("{}.results{part}.jsonl", stem(&args.manifest));
        args.manifest.with_file_name(name)
    });
    output::refuse_standard(&out, "a file")?;
    output::refuse_input(&out, &args.manifest, "manifest")?;
    let (mut results, done) = Results::open(&out)?;
    if results.cut_bytes() > 0 && !quiet {
        let cut = results.cut_bytes();
        output::remark(&format!(
            "{}: cut off {cut} bytes of a line that was not finished",
            out.display()
        ));
    }
    let missing = Missing::of(&manifest, shard, &done)?;
    drop(done);
    if missing.is_empty() {
        if !quiet {
            output::remark(&format!("{}: nothing is left to run", out.display()));
        }
        return Ok(DONE);
    }
    let inputs = Inputs::load(&manifest.header, &missing.needs, folder(&args.manifest))?;
    let cells = (missing.cells(&manifest)?, missing.len());
    let mut bar = Progress::new(quiet);
    RUNNING.store(true, Ordering::SeqCst);
    let progress = run_cells(&inputs, cells, threads, &STOP, &mut |result, progress| {
        bar.update(
            progress.done as u64,
            progress.all as u64,
            progress.simulated_s,
        );
        results.append(result)
    });
    bar.finish();
    let progress = progress?;
    results.sync()?;
    let stopped = progress.done < progress.all;
    if !quiet {
        output::remark(&format!(
            "{}: {} of {} cells run{}{}",
            out.display(),
            progress.done,
            progress.all,
            match progress.failed {
                0 => String::new(),
                failed =>
                    format!(", {failed} of them without figures (`study sweep collect` says why)"),
            },
            if stopped { "; run again to go on" } else { "" }
        ));
    }
    Ok(match (stopped, progress.failed) {
        (true, _) => crate::INTERRUPTED,
        (false, 0) => DONE,
        (false, _) => FOUND,
    })
}

/// The files of results that `run` names after a manifest.
fn results_of(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    let there = folder(path);
    let unread =
        |error| Failure::message(format!("cannot read folder {}: {error}", there.display()));
    let start = format!("{}.results", stem(path));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(there).map_err(unread)? {
        let entry = entry.map_err(unread)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let rest = name
            .strip_prefix(&start)
            .and_then(|rest| rest.strip_suffix(".jsonl"));
        if rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('-')) {
            found.push(entry.path());
        }
    }
    // Whatever order the file system has: duplicates are told by the same file each time.
    found.sort();
    if found.is_empty() {
        return Err(Failure::with_hint(
            format!("there are no results of {} beside it", path.display()),
            "`study sweep run` makes them; files elsewhere are named behind the manifest",
        ));
    }
    Ok(found)
}

/// How many missing cells are named on stderr. A choice.
const NAMED: usize = 10;

fn collected(args: &CollectArgs, quiet: bool) -> Result<u8, Failure> {
    let ending = args.out.extension().and_then(|ending| ending.to_str());
    let Some(ending @ ("parquet" | "csv" | "jsonl")) = ending else {
        return Err(Failure::with_hint(
            format!(
                "{} ends neither in .parquet, .csv nor .jsonl",
                args.out.display()
            ),
            "the ending says the form of the table",
        ));
    };
    let manifest = manifest(&args.manifest)?;
    let paths = if args.results.is_empty() {
        results_of(&args.manifest)?
    } else {
        args.results.clone()
    };
    for out in std::iter::once(&args.out).chain(&args.html) {
        let results = paths.iter().map(|path| (path.as_path(), "file of results"));
        refuse_inputs(out, results.chain([(args.manifest.as_path(), "manifest")]))?;
    }
    let mut finished = Finished::read(&manifest, &paths)?;
    // Both files are begun before either is finished: a name that cannot be written is told at once.
    let mut table = output::create(&args.out)?;
    let page = args.html.as_deref().map(output::create).transpose()?;
    let table = match ending {
        "csv" => finished.write_table::<Rows<AtomicFile>>(table)?,
        "parquet" => finished.write_table::<Columns<AtomicFile>>(table)?,
        _ => {
            finished.write_lines(&mut table)?;
            table
        }
    };
    let html = page
        .as_ref()
        .map(|_| sweep_page(&manifest, &mut finished))
        .transpose()?;
    table.commit()?;
    if let (Some(mut page), Some(html)) = (page, html) {
        let written = page.write_all(html.as_bytes());
        written.map_err(|error| WriteError::io("write", page.path(), error))?;
        page.commit()?;
    }
    let (missing, named) = finished.missing(NAMED)?;
    if !quiet {
        let (all, out) = (manifest.header.cells, args.out.display());
        let mut text = format!("{out}: {} of {all} cells", all - missing);
        for (count, what) in [
            (finished.repeated, "results that are there twice"),
            (finished.strangers, "results of other sweeps"),
        ] {
            if count > 0 {
                text.push_str(&format!(", without {count} {what}"));
            }
        }
        output::remark(&text);
    }
    if missing == 0 {
        return Ok(DONE);
    }
    // Even with --quiet: a table with gaps must not pass for a whole one.
    let mut text = format!("missing: {missing} cells");
    for (index, cell) in &named {
        let header = &manifest.header;
        text.push_str(&format!(
            "\n  cell {index}, key {}: {} on {}",
            cell.key,
            header.program(cell),
            header.machine(cell)
        ));
    }
    if missing > NAMED {
        text.push_str(&format!("\n  and {} more", missing - NAMED));
    }
    output::remark(&text);
    Ok(FOUND)
}

/// Cells of a shard where their number is not told, and most shards then. Choices: a task of a
/// minute or more, and an array that schedulers take.
const USUAL_CELLS: usize = 100;
const USUAL_SHARDS: usize = 1000;

fn emitted(args: &EmitArgs) -> Result<u8, Failure> {
    let manifest = manifest(&args.manifest)?;
    let scheduler: Scheduler = args.scheduler.parse().map_err(Failure::message)?;
    let usual = manifest
        .header
        .cells
        .div_ceil(USUAL_CELLS)
        .clamp(1, USUAL_SHARDS);
    let job = Job {
        manifest: args.manifest.display().to_string(),
        shards: args.shards.unwrap_or(usual),
        cores: args.cores,
        image: args.image.clone(),
    };
    output::print(&script(scheduler, &job)?)?;
    Ok(DONE)
}
