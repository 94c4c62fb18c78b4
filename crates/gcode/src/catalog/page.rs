//! `docs/diagnostics.md`, made from the tables.

use super::rows;
use crate::diagnostics::Severity;
use crate::lint::rules;
use std::fmt::Write;

/// The page of all diagnostics and lints, in Markdown.
pub fn page() -> String {
    let mut page = String::from(
        "# Diagnostics\n\nEvery code that lostmotion reports about a part program. Codes are stable; the wording of messages is not.\n\
         This page is made from the tables in `crates/gcode`; a test keeps it in step.\n\n\
         ## Errors, warnings and notes of the front end\n\nAn error refuses its block and the program; a warning or a note does not, and notes change no exit code.\n\n\
         | code | | what has been found | what to do |\n|---|---|---|---|\n",
    );
    for row in rows() {
        let severity = match row.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        // Writing to a String cannot fail.
        let _ = writeln!(
            page,
            "| `{}` | {severity} | {} | {} |",
            row.code,
            cell(row.summary),
            cell(row.advice)
        );
    }
    page.push_str(
        "\n## Lints\n\n`lostmotion lint PART` reports these besides. `--allow CODE` switches one off, `--deny CODE` makes it an error, `--warn CODE` switches one on that \
         is off.\n\n| code | | what has been found | why it matters, what to do |\n|---|---|---|---|\n",
    );
    for rule in rules::all() {
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {} |",
            rule.code,
            rule.level.name(),
            cell(rule.summary),
            cell(rule.advice)
        );
    }
    page
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
