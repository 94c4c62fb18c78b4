//! `lostmotion time`: where the time of a part program goes.

use super::{accepted, failure, shown, to_json};
use crate::input;
use crate::options::part::OnMachine;
use crate::options::{Format, Interventions, Quality, number, show, threads, whole};
use crate::output::{DONE, Failure, create, create_folder, refuse_input, refuse_inputs};
use clap::{Args, ValueHint};
use lostmotion::report::atomic::{AtomicFile, OutputFolder};
use lostmotion::report::csv::{Rows, TimeWriter};
use lostmotion::report::page::time_page;
use lostmotion::report::text::TextOptions;
use lostmotion::report::{WriteError, text};
use lostmotion::sim::time::TimeOptions;
use lostmotion::sim::time::results::BlockTime;
use lostmotion::sim::{SimError, SimulateOptions, Simulation};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// `time`.
#[derive(Debug, Args)]
pub(crate) struct Time {
    /// How much effort to put into the cycle time
    #[arg(long, value_enum, default_value_t)]
    pub(crate) quality: Quality,
    /// How far the tool may leave its path between two setpoints, in micrometres; the motion slows
    /// down to keep it. If left out the machine's, or 5 if a drive interpolates linearly
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) bow_limit_um: Option<f64>,
    /// How many of the blocks that take longest to list
    #[arg(long, value_name = "N", default_value_t = 10, allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) top: usize,
    /// How long a tool change takes, in seconds
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0.0,
        allow_negative_numbers = true, value_parser = number)]
    pub(crate) tool_change_s: f64,
    /// How long the spindle takes to start, stop or reverse, in seconds
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0.0,
        allow_negative_numbers = true, value_parser = number)]
    pub(crate) spindle_s: f64,
    /// Leave out the what-if table, for which the program is planned again for each row
    #[arg(long)]
    pub(crate) no_what_if: bool,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    /// Folder for time.json, time.txt, page.html and blocks.csv (a row for each run of a block);
    /// made if it does not exist
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Also write the answer as a page for a browser, one file that needs no network
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) html: Option<PathBuf>,
    /// Threads to use at most; all cores, if left out. The answer does not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) on: OnMachine,
    #[command(flatten)]
    pub(crate) interventions: Interventions,
}

/// The folder of an answer, with its table of blocks.
struct TimeFiles {
    blocks: TimeWriter<Rows<AtomicFile>>,
    /// Last, so that it goes when the files in it are gone and can take a folder that it made
    /// along.
    folder: OutputFolder,
}

impl TimeFiles {
    fn new(path: &Path) -> Result<TimeFiles, Failure> {
        let folder = create_folder(path)?;
        let blocks = TimeWriter::new(folder.file("blocks.csv")?).map_err(unwritten(&folder))?;
        Ok(TimeFiles { blocks, folder })
    }

    fn finish(self, json: &str, text: &str, page: &str) -> Result<(), Failure> {
        let TimeFiles { blocks, mut folder } = self;
        let blocks = blocks.finish().map_err(unwritten(&folder))?;
        folder.add(blocks);
        for (name, content) in [("time.json", json), ("time.txt", text), ("page.html", page)] {
            let mut file = folder.file(name)?;
            file.write_all(content.as_bytes())
                .map_err(unwritten(&folder))?;
            folder.add(file);
        }
        folder.commit()?;
        Ok(())
    }
}

fn unwritten(folder: &OutputFolder) -> impl Fn(io::Error) -> Failure + '_ {
    |error| WriteError::io("write into", folder.path(), error).into()
}

/// Tells where the time of a program goes.
pub(crate) fn run(args: &Time, quiet: bool) -> Result<u8, Failure> {
    let voice = args.on.setup.reading.voice(quiet);
    let program = input::program(&args.on.part)?;
    let machine = args.on.machine()?;
    let options = SimulateOptions {
        threads: threads(args.threads)?,
        quality: args.quality.of_planner(),
        interventions: args.interventions.read()?,
        bow_limit_um: args.bow_limit_um,
        ..SimulateOptions::default()
    };
    let options = args.on.options(&machine, options)?;
    let wanted = TimeOptions {
        keep_blocks: args.top,
        tool_change_s: args.tool_change_s,
        spindle_event_s: args.spindle_s,
        what_if: !args.no_what_if,
    };
    // A folder that cannot be made is found before the planning.
    if let Some(html) = &args.html {
        refuse_input(html, &args.on.part, "part program")?;
        refuse_inputs(html, args.on.setup.on.inputs())?;
    }
    let html = args.html.as_deref().map(create).transpose()?;
    let mut files = args.out.as_deref().map(TimeFiles::new).transpose()?;
    // A row each time a block runs: a loop may make millions, which are never held in memory.
    let mut sink = |rows: &[BlockTime]| {
        files
            .as_mut()
            .map_or(Ok(()), |files| files.blocks.push(rows))
            .map_err(Into::into)
    };
    let time = Simulation::new(&program, &machine)
        .options(options.clone())
        .time(&wanted, &mut sink)
        .map_err(|error| match error {
            SimError::Sink(why) => Failure::message(format!("cannot write blocks.csv: {why}")),
            other => failure(&program, &other, voice),
        })?;
    accepted(&program, &machine, &options, voice)?;
    let json = to_json(&time)?;
    let page = time_page(&time);
    if let Some(mut file) = html {
        let written = file.write_all(page.as_bytes());
        written.map_err(|error| WriteError::io("write", file.path(), error))?;
        file.commit()?;
    }
    if let Some(files) = files {
        files.finish(&json, &text::time(&time, &TextOptions::default()), &page)?;
    }
    show(args.format, &json, &text::time(&time, &shown()))?;
    Ok(DONE)
}
