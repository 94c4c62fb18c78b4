//! The program `lostmotion`: arguments in, a verdict out.
//!
//! Exit codes: 0 done, and within tolerance where there is one; 1 outside tolerance, a machine that
//! stops, warnings of `check` and `gcode lint`, or a program that `gcode format --check` would
//! change; 2 bad input, with a message on stderr and nothing written; 130 ended by Ctrl-C, with
//! nothing left behind.
//!
//! Modules in the order of their dependencies: `output`, `input`, `findings`, `logs` and `fits`; `options`
//! that commands share, and `commission`, what methods that learn start from, and `identify`, what a log tells; a module for the
//! commands of each heading; `cli` above them.

mod axis;
mod ballbar;
mod check_log;
mod cli;
mod commission;
mod findings;
mod fits;
mod identify;
mod input;
mod log_overview;
mod logs;
mod machine;
mod method;
mod options;
mod output;
mod parts;
mod shell;
mod study;
mod testpart;

use std::process::ExitCode;

/// Exit code of a run that was interrupted: 128 and the number of Ctrl-C's signal, as in shells.
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    // Without a handler, an interrupted run leaves its unfinished files behind.
    let _ = ctrlc::set_handler(|| {
        // A sweep finishes what it is at; whatever else there is ends here.
        if study::ends_after_cells() {
            return;
        }
        let _none_begins = lostmotion::report::atomic::abandon();
        std::process::exit(i32::from(INTERRUPTED));
    });
    match cli::Cli::of_process().run() {
        Ok(code) => ExitCode::from(code),
        Err(failure) => failure.report(),
    }
}
