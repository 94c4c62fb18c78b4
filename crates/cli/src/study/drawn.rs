//! `lostmotion study drawn`: machines and programs drawn at random.

use super::{failure, known_methods, methods};
use crate::options::{threads, whole};
use crate::output::{self, DONE, Failure};
use clap::{Args, ValueHint};
use lostmotion::report::WriteError;
use lostmotion_study::drawn::{draw, markdown, run_all};
use std::io::Write;
use std::path::PathBuf;

/// Most cells of a run: hours of work.
const MOST_CELLS: u32 = 10_000;

/// `study drawn`.
#[derive(Debug, Args)]
pub(crate) struct Drawn {
    /// Seed of the cells: look at one, judge with another that nobody has looked at
    #[arg(long, value_name = "S", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>)]
    pub(crate) seed: u64,
    /// Number of cells
    #[arg(long, value_name = "N", default_value_t = 32, allow_negative_numbers = true, value_parser = whole::<u32>)]
    pub(crate) cells: u32,
    /// Compensation methods, separated by commas; all but `fitted-lookup`, if left out
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = known_methods())]
    pub(crate) methods: Vec<String>,
    /// Folder for the machines and programs in place of running them: NAME.toml and NAME.ngc
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) export: Option<PathBuf>,
    /// Threads to use at most; all cores, if left out. The answer does not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) threads: Option<usize>,
}

/// Runs the cells, or writes them.
pub(super) fn run(args: &Drawn) -> Result<u8, Failure> {
    if args.cells == 0 || args.cells > MOST_CELLS {
        return Err(Failure::message(format!(
            "--cells is {}; it has to be from 1 to {MOST_CELLS}",
            args.cells
        )));
    }
    if let Some(folder) = &args.export {
        return export(args, folder);
    }
    let methods = methods(&args.methods)?;
    let results = run_all(args.seed, args.cells, &methods, threads(args.threads)?)
        .map_err(|error| failure(&error))?;
    let what = format!("drawn with seed {}", args.seed);
    output::print(&markdown(&results, &what))?;
    Ok(DONE)
}

fn export(args: &Drawn, folder: &std::path::Path) -> Result<u8, Failure> {
    let mut folder = output::create_folder(folder)?;
    for index in 0..args.cells {
        let cell = draw(args.seed, index).map_err(|error| failure(&error))?;
        let machine = cell
            .machine
            .to_toml()
            .map_err(|error| Failure::message(error.to_string()))?;
        for (suffix, text) in [("toml", &machine), ("ngc", &cell.program)] {
            let mut file = folder.file(&format!("{}.{suffix}", cell.name))?;
            file.write_all(text.as_bytes())
                .map_err(|error| WriteError::io("write into", folder.path(), error))?;
            folder.add(file);
        }
    }
    folder.commit()?;
    Ok(DONE)
}
