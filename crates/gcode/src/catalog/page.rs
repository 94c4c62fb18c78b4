//! `docs/book/src/reference/diagnostics.md`, made from the tables.

use super::rows;
use std::fmt::Write;

/// The page of all diagnostics, in Markdown; the tools' lints add theirs.
pub fn page() -> String {
    let mut page = String::from(
        "# Diagnostics\n\nEvery code that lostmotion reports about a part program. Codes are stable; the wording of messages is not.\n\
         This page is made from the tables in `crates/gcode` and `crates/gcode-tools`; a test keeps it in step.\n\n\
         ## Errors, warnings and notes of the front end\n\nAn error refuses its block and the program; a warning or a note does not, and notes change no exit code.\n\n\
         | code | | what has been found | what to do |\n|---|---|---|---|\n",
    );
    for row in rows() {
        let severity = row.severity.name();
        // Writing to a String cannot fail.
        let _ = writeln!(
            page,
            "| `{}` | {severity} | {} | {} |",
            row.code,
            cell(row.summary),
            cell(row.advice)
        );
    }
    page
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
