//! Lints of names: parameters that nobody reads, subroutines that nobody calls, blocks that never
//! run.

use super::scan::Scan;
use super::{LintFindings, rules};

/// Parameters up to here belong to the program; those above are the machine's.
const OWN_PARAMETERS: f64 = 5000.0;

pub(super) fn report(scan: &Scan, found: &mut LintFindings) {
    for (number, line, place) in &scan.twice {
        let message = format!("N{number} is also the number of line {line}");
        found.add(
            &rules::LINE_NUMBER_TWICE,
            *place,
            message,
            &[("number", *number as f64)],
            "number the lines anew",
        );
    }
    parameters(scan, found);
    if scan.has_main && !scan.calls_computed {
        for (name, place) in scan
            .subs
            .iter()
            .filter(|(name, _)| !scan.called.contains(*name))
        {
            let message = format!("subroutine {name} is never called");
            found.add(
                &rules::UNREACHABLE_SUB,
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
            &rules::CODE_AFTER_END,
            place,
            message,
            &[],
            "move it before M2, M30 or the second %",
        );
    }
}

fn parameters(scan: &Scan, found: &mut LintFindings) {
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
        let is_shared = match number {
            Some(number) => {
                scan.reads_computed || calls_others || number > OWN_PARAMETERS || !scan.has_main
            }
            None => name.starts_with("#<_") && (calls_others || !scan.has_main),
        };
        if !is_shared {
            let message = format!("{name} is set and never read");
            found.add(
                &rules::UNUSED_PARAMETER,
                *place,
                message,
                &[],
                "check its spelling where it is meant to be read, or remove it",
            );
        }
    }
}
