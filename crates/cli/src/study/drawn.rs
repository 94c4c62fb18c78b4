//! `lostmotion study drawn`: machines and programs drawn at random.

use super::{CellArgs, Page, failure, known_methods, methods, same_file, write_page};
use crate::options::{threads, whole};
use crate::output::{self, DONE, Failure};
use clap::{Args, ValueHint};
use lostmotion::methods::MethodId;
use lostmotion::report::WriteError;
use lostmotion::report::number::{fixed, percent};
use lostmotion::report::page::study_page;
use lostmotion_study::drawn::{
    DrawnCell, DrawnResult, commissioned, draw, left, markdown, run as run_cell, run_all, trace,
};
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
    /// Folder for the machines and programs in place of running them: NAME.toml, NAME.ngc, and
    /// NAME.learned.toml, what commissioning the machine teaches `adaptive` (`simulate --learned`)
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) export: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) page: Page,
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
    let page = args.page.open()?;
    let results = run_all(args.seed, args.cells, &methods, threads(args.threads)?)
        .map_err(|error| failure(&error))?;
    let what = format!("drawn with seed {}", args.seed);
    let title = format!("Machines and programs {what}");
    let markdown = markdown(&results, &what);
    write_page(page, &study_page(&title, &left(&results), &markdown))?;
    output::print(&markdown)?;
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
        let learned = commissioned(&cell)
            .map_err(|error| failure(&error))?
            .to_toml()
            .map_err(|error| Failure::message(error.to_string()))?;
        for (suffix, text) in [
            ("toml", &machine),
            ("ngc", &cell.program),
            ("learned.toml", &learned),
        ] {
            let mut file = folder.file(&format!("{}.{suffix}", cell.name))?;
            file.write_all(text.as_bytes())
                .map_err(|error| WriteError::io("write into", folder.path(), error))?;
            folder.add(file);
        }
    }
    folder.commit()?;
    Ok(DONE)
}

/// The seed and number of a drawn cell; `None` for the name of another one.
pub(super) fn of_cell(args: &CellArgs) -> Result<Option<(u64, u32)>, Failure> {
    if let Some(pair) = args.seed.zip(args.number) {
        return Ok(Some(pair));
    }
    let name = args.name.as_deref().unwrap_or_default();
    // Names of the matrix begin with a letter.
    if !name.starts_with(|c: char| c.is_ascii_digit()) {
        return Ok(None);
    }
    let mut parts = name.splitn(3, '-');
    let seed = parts.next().and_then(|part| part.parse().ok());
    let number = parts.next().and_then(|part| part.parse().ok());
    let (Some(seed), Some(number)) = (seed, number) else {
        return Err(Failure::with_hint(
            format!("there is no cell `{name}`: it does not begin with a seed and a number"),
            "a drawn cell is 7-3, or --seed 7 --cell 3",
        ));
    };
    Ok(Some((seed, number)))
}

/// Runs a drawn cell: figures, and the time line of what a method that learns knew.
pub(super) fn cell(args: &CellArgs, seed: u64, number: u32) -> Result<u8, Failure> {
    let cell = draw(seed, number).map_err(|error| failure(&error))?;
    // A name says what was drawn: with other ranges the same seed draws another cell.
    let short = format!("{seed}-{number}");
    if let Some(name) = args
        .name
        .as_ref()
        .filter(|name| **name != cell.name && **name != short)
    {
        return Err(Failure::with_hint(
            format!(
                "there is no cell `{name}`: cell {number} of seed {seed} is `{}`",
                cell.name
            ),
            "take that name, or --seed and --cell",
        ));
    }
    if let Some(path) = &args.program {
        output::write_text(path, &cell.program)?;
    }
    let adaptive = MethodId::ADAPTIVE.name().to_owned();
    let methods = methods(&[args.method.clone().unwrap_or(adaptive)])?;
    if let Some(path) = args.out.as_ref().filter(|_| args.out == args.program) {
        return Err(same_file(path));
    }
    // One that cannot be made is reported before the work is done.
    let file = args.out.as_deref().map(output::create).transpose()?;
    let result = run_cell(&cell, &methods).map_err(|error| failure(&error))?;
    if let Some(mut file) = file {
        file.write_all(trace(&result.methods).as_bytes())
            .map_err(|error| WriteError::io("write", file.path(), error))?;
        file.commit()?;
    }
    output::print(&shown(&cell, &result))?;
    Ok(DONE)
}

/// Figures and time lines of a cell.
fn shown(cell: &DrawnCell, result: &DrawnResult) -> String {
    let traits = &cell.traits;
    let pair = |[x, y]: [f64; 2]| format!("{}, {}", fixed(x, 2), fixed(y, 2));
    let mut out = format!(
        "{}: {} s; gaps {} um, friction {} of the rated torque, inertia {} of the motor's, encoder 2^{}, {} feed-forward\n",
        cell.name,
        fixed(result.duration_s, 1),
        pair(traits.gap_um),
        pair(traits.friction),
        pair(traits.inertia_ratio),
        traits.encoder_bits,
        if traits.feed_forward {
            "with"
        } else {
            "without"
        },
    );
    let none = result.none().map(|none| none.whole).unwrap_or_default();
    out.push_str(&format!(
        "practical limit: backlash {} um RMS, {} um max; of a cold start {} RMS, {} max\n",
        fixed(result.practical_um[0], 3),
        fixed(result.practical_um[1], 3),
        fixed(result.cold_um[0], 3),
        fixed(result.cold_um[1], 3)
    ));
    for method in &result.methods {
        let (whole, second) = (&method.whole, &method.second_half);
        out.push_str(&format!(
            "\n{}: backlash {} um RMS ({}), {} max; second half {} RMS; contour {} RMS, {} max\n",
            method.name(),
            fixed(whole.backlash_rms, 3),
            percent(whole.backlash_rms / none.backlash_rms),
            fixed(whole.backlash_max, 2),
            fixed(second.backlash_rms, 3),
            fixed(whole.contour_rms, 3),
            fixed(whole.contour_max, 2),
        ));
        for told in &method.told {
            out.push_str(&format!(
                "  {:>8} s  {}  {}\n",
                fixed(told.time_s, 2),
                told.drive,
                told.what
            ));
        }
        if !method.cause.is_empty() {
            out.push_str(&format!("cause: {}\n", method.cause));
        }
    }
    out
}
