//! Warnings about what is accepted beyond RS274/NGC.

use super::{CatalogRow, warning};
use crate::dialect::{LENIENCIES, Leniency};

/// Two leniencies have rows of their own: the end of the program and the byte order mark, which come first.
const OWN: usize = 2;
const ADVICE: &str = "Write it as RS274/NGC has it, or refuse it by this code.";

/// A row for each.
pub(super) const ROWS: [CatalogRow; LENIENCIES.len() - OWN] = {
    let mut rows = [warning("", "", ""); LENIENCIES.len() - OWN];
    let mut at = 0;
    while at < rows.len() {
        let leniency: Leniency = LENIENCIES[at + OWN];
        rows[at] = warning(leniency.name(), leniency.meaning(), ADVICE);
        at += 1;
    }
    rows
};
