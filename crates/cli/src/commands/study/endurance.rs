//! `lostmotion study endurance`.

use super::{failure, methods};
use crate::args::study::Endurance as Args;
use crate::commands::DONE;
use crate::failure::Failure;
use crate::output;
use lostmotion::report::number::{fixed, percent};
use lostmotion_study::endurance::run as endure;
use lostmotion_study::matrix::Cell;

/// Longest run, minutes: a day.
const MOST_MINUTES: f64 = 1440.0;

/// Runs an axis and prints what each stretch of the time showed.
pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    if !(args.minutes > 0.0 && args.minutes <= MOST_MINUTES) {
        return Err(Failure::with_hint(
            format!("--minutes is {}", args.minutes),
            format!("above 0, up to {MOST_MINUTES}"),
        ));
    }
    let cell = Cell::parse(&args.cell).map_err(|error| failure(&error))?;
    methods(std::slice::from_ref(&args.method))?;
    let stretches =
        endure(&cell, &args.method, 60.0 * args.minutes).map_err(|error| failure(&error))?;
    let mut out = format!(
        "what the gap adds to the load's place, X of {cell}\n\n| until min | `none`: RMS, um | max, um | `{0}`: RMS, um | max, um | RMS of none | gap off by |\n|--:|--:|--:|--:|--:|--:|--:|\n",
        args.method
    );
    for stretch in &stretches {
        let ([none, rms], [none_max, max]) = (stretch.rms_um, stretch.max_um);
        let gap = stretch
            .gap_error
            .map_or("-".to_owned(), |error| format!("{:.2} %", 100.0 * error));
        let columns = [none, none_max, rms, max]
            .map(|um| fixed(um, 3))
            .join(" | ");
        out.push_str(&format!(
            "| {} | {columns} | {} | {gap} |\n",
            fixed(stretch.until_s / 60.0, 1),
            percent(rms / none)
        ));
    }
    output::print(&out)?;
    Ok(DONE)
}
