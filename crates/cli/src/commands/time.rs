//! `lostmotion time`.

use super::{DONE, accepted, failure, show, to_json};
use crate::args::time::Time;
use crate::failure::Failure;
use crate::input;
use crate::voice::Voice;
use lostmotion::report::atomic::{AtomicFile, OutputFolder};
use lostmotion::report::csv::TimeWriter;
use lostmotion::report::{WriteError, text};
use lostmotion::sim::time::TimeOptions;
use lostmotion::sim::time::results::BlockTime;
use lostmotion::sim::{SimError, SimulateOptions, Simulation};
use std::io::{self, Write};
use std::path::PathBuf;

/// The folder of an answer, with its table of blocks.
struct Files {
    blocks: TimeWriter<AtomicFile>,
    /// Last, so that it goes when the files in it are gone and can take a folder that it made
    /// along.
    folder: OutputFolder,
}

impl Files {
    fn new(path: &PathBuf) -> Result<Files, Failure> {
        let folder = OutputFolder::create(path)?;
        let blocks = TimeWriter::new(folder.file("blocks.csv")?).map_err(unwritten(&folder))?;
        Ok(Files { blocks, folder })
    }

    fn finish(self, json: &str, text: &str) -> Result<(), Failure> {
        let Files { blocks, mut folder } = self;
        let blocks = blocks.finish().map_err(unwritten(&folder))?;
        folder.add(blocks);
        for (name, content) in [("time.json", json), ("time.txt", text)] {
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
pub(crate) fn run(args: &Time, voice: Voice) -> Result<u8, Failure> {
    if args.threads == Some(0) {
        return Err(Failure::with_hint(
            "--threads is 0",
            "leave it out to use all cores",
        ));
    }
    let program = input::program(&args.on.part)?;
    let machine = args.on.machine()?;
    let (quality, interventions) = (args.quality.of_planner(), args.interventions.read()?);
    let (threads, bow_limit_um) = (args.threads.unwrap_or(0), args.bow_limit_um);
    let options = SimulateOptions {
        threads,
        quality,
        interventions,
        bow_limit_um,
        ..SimulateOptions::default()
    };
    let options = args.on.options(&machine, options)?;
    let wanted = TimeOptions {
        keep_blocks: args.top,
        tool_change_s: args.tool_change_s,
        spindle_event_s: args.spindle_s,
        what_if: !args.no_what_if,
    };
    let mut files = args.out.as_ref().map(Files::new).transpose()?;
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
    let (json, text) = (to_json(&time)?, text::time(&time));
    if let Some(files) = files {
        files.finish(&json, &text)?;
    }
    show(args.format, &json, &text)?;
    Ok(DONE)
}
