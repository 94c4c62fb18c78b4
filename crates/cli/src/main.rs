//! The program `lostmotion`: arguments in, a verdict out.
//!
//! Exit codes: 0 done, and within tolerance where there is one; 1 outside tolerance; 2 bad input,
//! with a message on stderr and nothing written; 130 ended by Ctrl-C, with nothing left behind.
//! `lint`: 1 warnings, 2 errors. `format --check`: 1 the program would change.

mod args;
mod commands;
mod diagnostics;
mod drives;
mod excerpt;
mod failure;
mod input;
mod machines;
mod output;
mod progress;
mod reading;
mod record;
mod subroutines;
mod voice;

use clap::Parser;
use std::process::ExitCode;

/// Exit code of a run that was told to end: 128 and the number of the signal of Ctrl-C, as shells
/// have it.
const ENDED: i32 = 130;

fn main() -> ExitCode {
    // Where a handler cannot be had, a run that is ended leaves its unfinished files behind.
    let _ = ctrlc::set_handler(|| {
        lostmotion::report::atomic::abandon();
        std::process::exit(ENDED);
    });
    let cli = args::Cli::parse();
    match commands::run(&cli) {
        Ok(code) => ExitCode::from(code),
        Err(failure) => failure.report(),
    }
}
