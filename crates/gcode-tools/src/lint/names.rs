//! Lints of names: parameters that are never read, subroutines that are never called, blocks that
//! never run.

use super::Check;
use super::rules::{Lint, LintFindings, LintRule, rule};
use super::scan::Scan;

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
    rules: &[
        &LINE_NUMBER_TWICE,
        &UNUSED_PARAMETER,
        &UNREACHABLE_SUB,
        &CODE_AFTER_END,
    ],
    check: || Box::new(Names),
};

static LINE_NUMBER_TWICE: LintRule = rule(
    "line-number-twice",
    "Two lines have the same N number.",
    "A jump or an operator who searches for it may end up at the other one. Numbers that begin anew (after N9000 and beyond, or from a subroutine's start) are not reported; of a row of such lines the first is.",
);

static UNUSED_PARAMETER: LintRule = rule(
    "unused-parameter",
    "A parameter is set and never read.",
    "It may be misspelt where it is meant to be read. Not reported if parameters are read by computed numbers, or other files are called.",
);

static UNREACHABLE_SUB: LintRule = rule(
    "unreachable-sub",
    "A subroutine is never called.",
    "Its name may be misspelt in the call. Not reported if a call computes its name, or the file holds nothing but subroutines.",
);

static CODE_AFTER_END: LintRule = rule(
    "code-after-end",
    "There are blocks after the end of the program.",
    "They never run: nothing after M2, M30 or the second `%` does, except subroutines.",
);

/// Parameters up to here belong to the program; those above are the machine's.
const OWN_PARAMETERS: f64 = 5000.0;

struct Names;

impl Check for Names {
    fn lines(&mut self, scan: &Scan, found: &mut LintFindings) {
        report(scan, found);
    }
}

fn report(scan: &Scan, found: &mut LintFindings) {
    for (number, line, place) in &scan.twice {
        let message = format!("N{number} is also the number of line {line}");
        found.add(
            &LINE_NUMBER_TWICE,
            *place,
            message,
            &[("number", *number as f64)],
            "number the lines anew",
        );
    }
    parameters(scan, found);
    // A file of subroutines alone is a library: its callers are elsewhere.
    if scan.has_main && !scan.calls_computed {
        for (name, place) in scan
            .subs
            .iter()
            .filter(|(name, _)| !scan.called.contains(*name))
        {
            let message = format!("subroutine {name} is never called");
            found.add(
                &UNREACHABLE_SUB,
                *place,
                message,
                &[],
                "call it, or remove it",
            );
        }
    }
    if let Some(place) = scan.after_end {
        let message = "this block comes after the end of the program and never runs".to_owned();
        found.add(
            &CODE_AFTER_END,
            place,
            message,
            &[],
            "move it before M2, M30 or the second %",
        );
    }
}

fn parameters(scan: &Scan, found: &mut LintFindings) {
    // A called file may read any parameter that is not local to a subroutine.
    let calls_others =
        scan.calls_computed || scan.called.iter().any(|name| !scan.subs.contains_key(name));
    for (name, place) in scan
        .set
        .iter()
        .filter(|(name, _)| !scan.read.contains(*name))
    {
        let number: Option<f64> = name
            .strip_prefix('#')
            .and_then(|number| number.parse().ok());
        // Reads that cannot be seen here: computed numbers, other files, the machine's own
        // parameters.
        let is_shared = match number {
            Some(number) => {
                scan.reads_computed || calls_others || number > OWN_PARAMETERS || !scan.has_main
            }
            None => name.starts_with("#<_") && (calls_others || !scan.has_main),
        };
        if !is_shared {
            let message = format!("{name} is set and never read");
            found.add(
                &UNUSED_PARAMETER,
                *place,
                message,
                &[],
                "check its spelling where it is meant to be read, or remove it",
            );
        }
    }
}
