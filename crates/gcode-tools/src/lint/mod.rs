//! Lints: programs that are correct and may still break a tool, a part or a machine.
//!
//! [`lint`] runs a program and looks at every block that is carried out, and at every line of the
//! file whether it runs or not. Each lint has a code in the table of [`rules`] and can be switched
//! off, or made an error, by [`Levels`].

mod arcs;
mod dwell;
mod end;
mod feed;
mod findings;
mod home;
mod level;
mod modes;
mod moves;
mod names;
mod rapid;
pub mod rules;
mod scan;
mod spindle;
mod tap;
mod tool;
mod units;

pub use findings::{LintFinding, LintFindings};
pub use level::{Level, Levels};
pub use rules::LintRule;

use lostmotion_base::span::BlockRef;
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::program::Program;
use lostmotion_gcode::program::{Event, watch};
use moves::Leg;
use std::io::BufRead;

/// A lint, or a few that share what they remember.
trait Check {
    /// A block that was carried out without an error, and its moves.
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings);

    /// The program is over; `last` is its last block.
    fn end(&mut self, _last: BlockRef, _found: &mut LintFindings) {}
}

/// Runs a program to its end and gives what the lints say about it. What the front end itself finds
/// is in [`Program::diagnostics`] afterwards.
pub fn lint<R: BufRead>(program: &mut Program<R>, levels: Levels) -> LintFindings {
    let mut found = LintFindings::new(levels);
    let mut checks: Vec<Box<dyn Check>> = vec![
        Box::new(modes::Modes::default()),
        Box::new(dwell::Dwell),
        Box::new(rapid::Rapid::default()),
        Box::new(arcs::Arcs::default()),
        Box::new(feed::Feed::default()),
        Box::new(spindle::Spindles::default()),
        Box::new(tool::Tools::default()),
        Box::new(home::Home),
        Box::new(end::End::default()),
        Box::new(tap::Taps),
        Box::new(units::UnitChanges::default()),
    ];
    let limits = program.interpreter().limits().clone();
    let mut scan = scan::Scan::new(limits);
    let mut last = BlockRef::default();
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
    scan.program_ended(program.interpreter().state().ended);
    while let Some((line, span)) = program.next_line() {
        scan.line(line, span);
    }
    for check in &mut checks {
        check.end(last, &mut found);
    }
    names::report(&scan, &mut found);
    found.sort();
    found
}

/// Whether an operation moves at the feed rate.
fn is_feed(op: &CanonicalOp) -> bool {
    matches!(
        op,
        CanonicalOp::StraightFeed(_) | CanonicalOp::ArcFeed(_) | CanonicalOp::NurbsFeed(_)
    )
}
