//! The table of diagnostics: one row for every code that the front end can report.
//!
//! `docs/book/src/reference/diagnostics.md` is made from it, and it gives SARIF its rules. Tests fail for a code
//! without a row.

mod lenient;
mod meaning;
mod page;
mod syntax;

pub use page::page;

use crate::severity::Severity;

/// What is known about a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CatalogRow {
    /// Stable name, kebab case.
    pub code: &'static str,
    /// Whether it refuses the program.
    pub severity: Severity,
    /// What has been found.
    pub summary: &'static str,
    /// What to do about it.
    pub advice: &'static str,
}

/// All rows: first those about how a program is written, then those about what it means.
pub fn rows() -> impl Iterator<Item = &'static CatalogRow> {
    syntax::ROWS
        .iter()
        .chain(meaning::ROWS)
        .chain(&lenient::ROWS)
}

/// The row of a code.
pub fn find(code: &str) -> Option<&'static CatalogRow> {
    rows().find(|row| row.code == code)
}

const fn error(code: &'static str, summary: &'static str, advice: &'static str) -> CatalogRow {
    CatalogRow {
        code,
        severity: Severity::Error,
        summary,
        advice,
    }
}

const fn warning(code: &'static str, summary: &'static str, advice: &'static str) -> CatalogRow {
    CatalogRow {
        code,
        severity: Severity::Warning,
        summary,
        advice,
    }
}
