//! Lints: programs that are correct and may still break a tool, a part or a machine.
//!
//! [`lint`] runs a program and looks at every block that is carried out, and at every line of the
//! file whether it runs or not. Each lint has a code in the table of [`rules`] and can be switched
//! off, or made an error, by [`Levels`].

mod arcs;
mod end;
mod feed;
mod modes;
mod moves;
mod names;
mod rapid;
pub mod rules;
mod scan;
mod spindle;
mod tool;

pub use rules::{Level, Levels, LintFinding, LintFindings, LintRule};

use lostmotion_base::span::BlockRef;
use lostmotion_gcode::program::{Event, Program, watch};
use moves::Leg;
use rules::Lint;
use scan::Scan;
use std::io::BufRead;

/// All files of lints. A new lint is a file with its rules and its check, and its name here.
const LINTS: &[Lint] = &[
    modes::UNSET,
    feed::DWELL,
    rapid::RAPID,
    arcs::LINTS,
    feed::FEED,
    spindle::LINTS,
    tool::LINTS,
    rapid::HOME,
    end::LINTS,
    feed::TAP,
    modes::UNITS,
    names::LINTS,
];

/// A lint, or a few that share what they remember.
trait Check {
    /// A block that was carried out without an error, and its moves.
    fn block(&mut self, _event: &Event<'_>, _legs: &[Leg<'_>], _found: &mut LintFindings) {}

    /// The program is over; `last` is its last block.
    fn end(&mut self, _last: BlockRef, _found: &mut LintFindings) {}

    /// All lines of the file have been looked at, whether they ran or not.
    fn lines(&mut self, _scan: &Scan, _found: &mut LintFindings) {}
}

/// Runs a program to its end and gives what the lints say about it.
///
/// ```
/// use lostmotion_gcode::{InterpreterConfig, Program};
/// use lostmotion_gcode_tools::lint::{Level, Levels, lint};
///
/// let text = b"G21 G90 G17 G94 G54\nG4 P500\nM2\n";
/// let mut program = Program::new(&text[..], InterpreterConfig::default());
/// let mut levels = Levels::default();
/// levels.set("dwell-milliseconds", Level::Deny);
/// let found = lint(&mut program, levels);
/// assert_eq!((found.denied(), found.kept()[0].place.span.line), (1, 2));
/// assert_eq!(found.kept()[0].hint, "P is in seconds; 500 ms are P0.5");
/// ```
/// What the front end itself finds
/// is in [`Program::diagnostics`] afterwards.
pub fn lint<R: BufRead>(program: &mut Program<R>, levels: Levels) -> LintFindings {
    let mut found = LintFindings::new(levels);
    let mut checks: Vec<Box<dyn Check>> = LINTS.iter().map(|lint| (lint.check)()).collect();
    let limits = program.interpreter().limits().clone();
    let mut scan = Scan::new(limits);
    let mut last = BlockRef::default();
    // Lines of the program itself are scanned as text; blocks that run go to every check.
    watch(program, |event| {
        if event.place.span.file == 0 && event.place.span.line > 0 {
            scan.line(event.interpreter.line(), event.place.span);
            last = event.place;
        }
        if event.is_plain() {
            let legs = moves::legs(event);
            for check in &mut checks {
                check.block(event, &legs, &mut found);
            }
        }
    });
    // Lines after the end are scanned, too.
    scan.program_ended(program.interpreter().state().ended);
    while let Some((line, span)) = program.next_line() {
        scan.line(line, span);
    }
    for check in &mut checks {
        check.end(last, &mut found);
        check.lines(&scan, &mut found);
    }
    found.sort();
    found
}
