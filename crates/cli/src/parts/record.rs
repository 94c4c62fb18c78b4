//! What a run shows and writes while it goes on.

use crate::options::{number, whole};
use crate::output::{Failure, Progress, create, create_folder};
use clap::{Args, ValueEnum};
use lostmotion::drive::Learning;
use lostmotion::report::WriteError;
use lostmotion::report::atomic::{AtomicFile, OutputFolder};
use lostmotion::report::csv::{
    BlockWriter, ContourWriter, MotorWriter, ReversalWriter, Rows, TraceRange,
};
use lostmotion::report::findings::BlockRecorder;
use lostmotion::report::mcap::{ContourMessages, MotorMessages, Topics};
use lostmotion::report::page::{Gathered, PageRecorder, page, still};
use lostmotion::report::parquet::{ContourTable, MotorTable};
use lostmotion::report::text::Along;
use lostmotion::sim::results::{BlockResult, ReversalResult, Run};
use lostmotion::sim::{ContourPoint, Machine, MotorPoint, Observer, Program};
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// What is written of every servo tick.
#[derive(Debug, Args)]
pub(crate) struct Trace {
    /// Also write contour.csv (.parquet, .mcap): contour error and places of command and tool at every servo tick
    #[arg(long, requires = "out")]
    pub(crate) trace: bool,
    /// Also write motors.csv (.parquet, .mcap): reference, motor, load, current, torque and engagement of every axis
    /// at every servo tick
    #[arg(long, requires = "out")]
    pub(crate) trace_motors: bool,
    /// Form of the traces
    #[arg(long, value_enum, default_value_t)]
    pub(crate) trace_format: TraceFormat,
    /// Write traces from this time on, in seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = number)]
    pub(crate) from: Option<f64>,
    /// Write traces up to this time, in seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = number)]
    pub(crate) to: Option<f64>,
    /// Of so many servo ticks write only those with the peaks
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<u64>)]
    pub(crate) every: Option<u64>,
}

/// Form of a trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum TraceFormat {
    /// Rows of text, rounded to decimals
    #[default]
    Csv,
    /// Columns of numbers in full, for data tools
    Parquet,
    /// Messages with their times, for robotics tools
    Mcap,
}

impl TraceFormat {
    /// Name of a table.
    fn file(self, table: &str) -> String {
        match self {
            TraceFormat::Csv => format!("{table}.csv"),
            TraceFormat::Parquet => format!("{table}.parquet"),
            TraceFormat::Mcap => format!("{table}.mcap"),
        }
    }
}

/// A table of contour errors in its form.
enum ContourTrace {
    Csv(ContourWriter<Rows<AtomicFile>>),
    Parquet(ContourTable<AtomicFile>),
    Mcap(Box<ContourMessages<AtomicFile>>),
}

impl ContourTrace {
    fn new(form: TraceFormat, file: AtomicFile, range: TraceRange) -> io::Result<ContourTrace> {
        Ok(match form {
            TraceFormat::Csv => ContourTrace::Csv(ContourWriter::new(file, range)?),
            TraceFormat::Parquet => ContourTrace::Parquet(ContourTable::start(file, range)?),
            TraceFormat::Mcap => {
                let topics = Topics::new(file, "contour");
                ContourTrace::Mcap(Box::new(ContourMessages::start(topics, range)?))
            }
        })
    }

    fn push(&mut self, method: &str, points: &[ContourPoint]) -> io::Result<()> {
        match self {
            ContourTrace::Csv(writer) => writer.push(method, points),
            ContourTrace::Parquet(writer) => writer.push(method, points),
            ContourTrace::Mcap(writer) => writer.push(method, points),
        }
    }

    fn finish(self) -> io::Result<AtomicFile> {
        match self {
            ContourTrace::Csv(writer) => writer.finish(),
            ContourTrace::Parquet(writer) => writer.finish(),
            ContourTrace::Mcap(writer) => writer.finish().map(|topics| topics.out),
        }
    }
}

/// A table of motors in its form.
enum MotorTrace {
    Csv(MotorWriter<Rows<AtomicFile>>),
    Parquet(MotorTable<AtomicFile>),
    Mcap(Box<MotorMessages<AtomicFile>>),
}

impl MotorTrace {
    fn new(form: TraceFormat, file: AtomicFile, range: TraceRange) -> MotorTrace {
        match form {
            TraceFormat::Csv => MotorTrace::Csv(MotorWriter::new(file, range)),
            TraceFormat::Parquet => MotorTrace::Parquet(MotorTable::start(file, range)),
            TraceFormat::Mcap => {
                let topics = Topics::new(file, "motors");
                MotorTrace::Mcap(Box::new(MotorMessages::start(topics, range)))
            }
        }
    }

    fn push(&mut self, method: &str, points: &[MotorPoint]) -> io::Result<()> {
        match self {
            MotorTrace::Csv(writer) => writer.push(method, points),
            MotorTrace::Parquet(writer) => writer.push(method, points),
            MotorTrace::Mcap(writer) => writer.push(method, points),
        }
    }

    fn finish(self) -> io::Result<AtomicFile> {
        match self {
            MotorTrace::Csv(writer) => writer.finish(),
            MotorTrace::Parquet(writer) => writer.finish(),
            MotorTrace::Mcap(writer) => writer.finish().map(|topics| topics.out),
        }
    }
}

impl Trace {
    /// The ticks to write.
    pub(crate) fn range(&self) -> Result<TraceRange, Failure> {
        let given = [
            ("--from", self.from.is_some()),
            ("--to", self.to.is_some()),
            ("--every", self.every.is_some()),
            ("--trace-format", self.trace_format != TraceFormat::Csv),
        ];
        // Without a trace they would do nothing, in silence.
        if let Some((flag, _)) = given.iter().find(|(_, given)| *given)
            && !(self.trace || self.trace_motors)
        {
            return Err(Failure::with_hint(
                format!("{flag} is for --trace and --trace-motors; neither is given"),
                "add --trace",
            ));
        }
        let defaults = TraceRange::default();
        let range = TraceRange {
            from_s: self.from.unwrap_or(defaults.from_s),
            to_s: self.to.unwrap_or(defaults.to_s),
            every: self.every.unwrap_or(defaults.every),
        };
        if range.every == 0 {
            return Err(Failure::message("--every is 0; it has to be 1 or above"));
        }
        if range.from_s > range.to_s {
            return Err(Failure::message(format!(
                "--to is {}; it has to be at least --from, {}",
                range.to_s, range.from_s
            )));
        }
        Ok(range)
    }
}

/// The files of a run with `--out`.
struct RunFiles {
    blocks: BlockWriter<Rows<AtomicFile>>,
    reversals: ReversalWriter<Rows<AtomicFile>>,
    contour: Option<ContourTrace>,
    motors: Option<MotorTrace>,
    failed: Option<io::Error>,
    /// Last, so that it goes when the files in it are gone and can take a folder that it made
    /// along.
    folder: OutputFolder,
}

/// Watches a run: progress on a terminal, tables and traces into a folder if one was asked for.
pub(crate) struct Record {
    methods: Vec<String>,
    progress: Progress,
    files: Option<RunFiles>,
    /// What a page shows, if one is written, and its own file, if it has one.
    page: Option<PageRecorder>,
    html: Option<AtomicFile>,
    /// Where the page is wanted as text, too.
    served: Option<PageSlot>,
    /// Blocks outside the tolerance, where they are the answer.
    blocks: Option<BlockRecorder>,
    /// The error along the program of each method, where a terminal shows it.
    along: Vec<Along>,
}

/// Takes the page of a run for whoever shows it.
pub(crate) type PageSlot = Arc<Mutex<String>>;

/// Name of the page in a folder of results.
const PAGE_NAME: &str = "page.html";

fn io_error(folder: &OutputFolder) -> impl Fn(io::Error) -> Failure + '_ {
    |error| WriteError::io("write into", folder.path(), error).into()
}

impl RunFiles {
    fn new(path: &Path, trace: &Trace) -> Result<RunFiles, Failure> {
        let range = trace.range()?;
        let folder = create_folder(path)?;
        let blocks = BlockWriter::new(folder.file("blocks.csv")?).map_err(io_error(&folder))?;
        let reversals =
            ReversalWriter::new(folder.file("reversals.csv")?).map_err(io_error(&folder))?;
        let form = trace.trace_format;
        // A row a servo tick makes gigabytes of an hour: only on request.
        let contour = if trace.trace {
            let file = folder.file(&form.file("contour"))?;
            Some(ContourTrace::new(form, file, range).map_err(io_error(&folder))?)
        } else {
            None
        };
        let motors = if trace.trace_motors {
            let file = folder.file(&form.file("motors"))?;
            Some(MotorTrace::new(form, file, range))
        } else {
            None
        };
        Ok(RunFiles {
            blocks,
            reversals,
            contour,
            motors,
            failed: None,
            folder,
        })
    }

    /// Keeps the first error; an observer cannot stop a run.
    fn keep(&mut self, result: io::Result<()>) {
        if let (Err(error), None) = (result, &self.failed) {
            self.failed = Some(error);
        }
    }

    fn contour(&mut self, name: &str, points: &[ContourPoint]) {
        if let Some(writer) = &mut self.contour {
            let result = writer.push(name, points);
            self.keep(result);
        }
    }
}

impl Record {
    /// Starts watching a run of these methods; `out` is the folder for files, `html` the page,
    /// `trace` what is written of every servo tick.
    pub(crate) fn new(
        out: Option<&Path>,
        html: Option<&Path>,
        trace: &Trace,
        methods: &[String],
        quiet: bool,
    ) -> Result<Record, Failure> {
        if out.is_none() {
            // Wrong without a folder, too.
            trace.range()?;
        }
        let files = out.map(|path| RunFiles::new(path, trace)).transpose()?;
        let html = html.map(create).transpose()?;
        let with_page = files.is_some() || html.is_some();
        Ok(Record {
            methods: methods.to_vec(),
            progress: Progress::new(quiet),
            files,
            page: with_page.then(|| PageRecorder::new(methods.len())),
            html,
            served: None,
            blocks: None,
            along: Vec::new(),
        })
    }

    /// The same, with the page as text in a slot.
    pub(crate) fn with_page_in(mut self, slot: &PageSlot) -> Record {
        let methods = self.methods.len();
        self.page.get_or_insert_with(|| PageRecorder::new(methods));
        Record {
            served: Some(Arc::clone(slot)),
            ..self
        }
    }

    /// The same, keeping the blocks that are outside a tolerance, um.
    pub(crate) fn with_blocks_outside(self, tolerance_um: f64) -> Record {
        let blocks = Some(BlockRecorder::new(self.methods.len(), tolerance_um));
        Record { blocks, ..self }
    }

    /// The same, with the error along the program.
    pub(crate) fn with_along(self) -> Record {
        let along = vec![Along::default(); self.methods.len()];
        Record { along, ..self }
    }

    /// The error along the program of each method; none if it was not asked for.
    pub(crate) fn take_along(&mut self) -> Vec<Along> {
        std::mem::take(&mut self.along)
    }

    /// The blocks outside the tolerance, if they were kept.
    pub(crate) fn take_blocks_outside(&mut self) -> Option<BlockRecorder> {
        self.blocks.take()
    }

    /// Writes the answer, the picture and the page, and gives all files their names. Without
    /// `--out` and `--html` this does nothing.
    pub(crate) fn finish(mut self, answer: &Answer<'_>) -> Result<(), Failure> {
        self.progress.finish();
        let gathered = self.page.map(|recorder| recorder.finish(answer.run));
        let page_of =
            |gathered: &Gathered| page(answer.run, answer.machine, answer.program, gathered);
        let page = gathered
            .as_ref()
            .map(page_of)
            .transpose()
            .map_err(|error| {
                Failure::message(format!("cannot read {}: {error}", answer.program.name()))
            })?
            .unwrap_or_default();
        if let Some(mut file) = self.html {
            let written = file.write_all(page.as_bytes());
            written.map_err(|error| WriteError::io("write", file.path(), error))?;
            file.commit()?;
        }
        if let Some(slot) = &self.served {
            let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
            slot.clone_from(&page);
        }
        let Some(mut files) = self.files else {
            return Ok(());
        };
        // Told now and not where it happened, since an observer cannot stop the run.
        if let Some(error) = files.failed {
            return Err(io_error(&files.folder)(error));
        }
        let svg = gathered
            .as_ref()
            .map(|gathered| still(answer.run, gathered))
            .unwrap_or_default();
        let texts = [
            ("contour.svg", &svg),
            (PAGE_NAME, &page),
            (answer.json_name, answer.json),
            (answer.text_name, answer.text),
        ];
        let folder = &mut files.folder;
        // All files are completed before the folder names the first of them.
        let mut done = vec![files.blocks.finish(), files.reversals.finish()];
        done.extend(files.contour.map(ContourTrace::finish));
        done.extend(files.motors.map(MotorTrace::finish));
        for file in done {
            let file = file.map_err(io_error(folder))?;
            folder.add(file);
        }
        for (name, text) in texts {
            let mut file = folder.file(name)?;
            file.write_all(text.as_bytes()).map_err(io_error(folder))?;
            folder.add(file);
        }
        files.folder.commit()?;
        Ok(())
    }
}

/// What goes into the folder besides the tables.
pub(crate) struct Answer<'a> {
    /// The program.
    pub(crate) program: &'a Program,
    /// The machine.
    pub(crate) machine: &'a Machine,
    /// The answer.
    pub(crate) run: &'a Run,
    /// Name of the JSON file.
    pub(crate) json_name: &'a str,
    /// The answer as JSON.
    pub(crate) json: &'a String,
    /// Name of the text file.
    pub(crate) text_name: &'a str,
    /// The answer as text.
    pub(crate) text: &'a String,
}

impl Observer for Record {
    fn progress(&mut self, done: lostmotion::sim::Progress) -> ControlFlow<()> {
        self.progress
            .update(done.done_bytes, done.total_bytes, done.simulated_s);
        ControlFlow::Continue(())
    }

    fn blocks(&mut self, method: usize, rows: &[BlockResult]) {
        if let Some(blocks) = &mut self.blocks {
            blocks.push(method, rows);
        }
        if let (Some(files), Some(name)) = (&mut self.files, self.methods.get(method)) {
            let result = files.blocks.push(name, rows);
            files.keep(result);
        }
    }

    fn reversals(&mut self, method: usize, rows: &[ReversalResult]) {
        if let (Some(files), Some(name)) = (&mut self.files, self.methods.get(method)) {
            let result = files.reversals.push(name, rows);
            files.keep(result);
        }
    }

    fn wants_contour(&self) -> bool {
        self.files.is_some() || self.page.is_some() || !self.along.is_empty()
    }

    fn contour(&mut self, method: usize, points: &[ContourPoint]) {
        if let Some(along) = self.along.get_mut(method) {
            along.push(points);
        }
        if let Some(page) = &mut self.page {
            page.contour(method, points);
        }
        if let (Some(files), Some(name)) = (&mut self.files, self.methods.get(method)) {
            files.contour(name, points);
        }
    }

    fn wants_limiters(&self) -> bool {
        self.page.is_some()
    }

    fn wants_motors(&self) -> bool {
        // They cost more than all else of a page: that of a folder shows them if they are there.
        let files = self.files.as_ref();
        self.html.is_some()
            || self.served.is_some()
            || files.is_some_and(|files| files.motors.is_some())
    }

    fn motors(&mut self, method: usize, points: &[MotorPoint]) {
        if let Some(page) = &mut self.page {
            page.motors(method, points);
        }
        let (Some(files), Some(name)) = (&mut self.files, self.methods.get(method)) else {
            return;
        };
        if let Some(writer) = &mut files.motors {
            let result = writer.push(name, points);
            files.keep(result);
        }
    }

    fn wants_learning(&self) -> bool {
        self.page.is_some() && self.wants_motors()
    }

    fn learning(&mut self, method: usize, time_s: f64, drives: &[Option<Learning>]) {
        if let Some(page) = &mut self.page {
            page.learning(method, time_s, drives);
        }
    }
}
