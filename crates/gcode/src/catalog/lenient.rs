//! Warnings about what is accepted beyond RS274/NGC.

use super::{CatalogRow, warning};
use crate::dialect::{LENIENCIES, Leniency};
use crate::severity::Severity;

/// Two leniencies have rows of their own: the end of the program and the byte order mark, which
/// come first.
const OWN: usize = 2;
const NOTE: &str = "Nothing needs to be done; told once a file, with how often it occurs.";
const ADVICE: &str = "Write it as RS274/NGC has it, or refuse it by this code.";

/// A row for each.
pub(super) const ROWS: [CatalogRow; LENIENCIES.len() - OWN] = {
    let mut rows = [warning("", "", ""); LENIENCIES.len() - OWN];
    let mut at = 0;
    while at < rows.len() {
        let leniency: Leniency = LENIENCIES[at + OWN];
        rows[at] = CatalogRow {
            code: leniency.name(),
            severity: leniency.severity(),
            summary: leniency.meaning(),
            advice: match leniency.severity() {
                Severity::Note => NOTE,
                _ => ADVICE,
            },
        };
        at += 1;
    }
    rows
};
