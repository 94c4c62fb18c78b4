//! The catalog of diagnostics: one row for every code that the front end can report.
//!
//! `docs/book/src/reference/diagnostics.md` is made from it, and it gives SARIF its rules. The rows come from the tables
//! of [`crate::problem`] and [`crate::dialect`].
//!
//! ```
//! let row = lostmotion_gcode::catalog::find("arc-radii").unwrap();
//! assert_eq!(row.severity, lostmotion_gcode::Severity::Error);
//! assert_eq!(row.summary, "The centre of an arc is not as far from its end as from its start.");
//! ```

use crate::dialect::{LENIENCIES, Leniency};
pub use crate::finding::CatalogRow;
use crate::finding::Severity;
use crate::problem::ROWS;
use std::fmt::Write;

/// Advice for leniencies that are notes.
const NOTE: &str = "Nothing needs to be done; told once a file, with how often it occurs.";
/// Advice for leniencies that are warnings.
const ADVICE: &str = "Write it as RS274/NGC has it, or refuse it by this code.";

/// The row of a leniency.
const fn lenient(leniency: Leniency) -> CatalogRow {
    CatalogRow {
        code: leniency.name(),
        severity: leniency.severity(),
        summary: leniency.meaning(),
        advice: match leniency.severity() {
            Severity::Note => NOTE,
            _ => ADVICE,
        },
    }
}

/// The first leniencies have entries among the problems: the end of the program and the byte order
/// mark.
const WITH_OWN_ENTRY: usize = 2;

static LENIENT: [CatalogRow; LENIENCIES.len() - WITH_OWN_ENTRY] = {
    let mut rows = [lenient(Leniency::MissingEnd); LENIENCIES.len() - WITH_OWN_ENTRY];
    let mut at = 0;
    while at < rows.len() {
        rows[at] = lenient(LENIENCIES[at + WITH_OWN_ENTRY]);
        at += 1;
    }
    rows
};

/// All rows: problems, then leniencies.
pub fn rows() -> impl Iterator<Item = &'static CatalogRow> {
    ROWS.iter().chain(&LENIENT)
}

/// The row of a code.
pub fn find(code: &str) -> Option<&'static CatalogRow> {
    rows().find(|row| row.code == code)
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codes::Code;
    use crate::problem::Problem;
    use std::collections::BTreeSet;

    #[test]
    fn no_code_has_two_rows() {
        let codes: BTreeSet<&str> = rows().map(|row| row.code).collect();
        assert_eq!(codes.len(), rows().count());
        assert!(codes.len() > 100);
    }

    #[test]
    fn problems_that_share_a_code_have_its_severity() {
        let code = Code::g(700);
        let mut problems = vec![
            Problem::ReadOnlyName {
                name: String::new(),
            },
            Problem::CurvePoints {
                points: 1,
                order: 3,
            },
            Problem::PolarWithoutMotion { code },
            Problem::FinishDetour {
                code,
                x: 0.0,
                z: 0.0,
            },
        ];
        problems.extend(LENIENCIES.map(|leniency| Problem::Habit { leniency, count: 2 }));
        for problem in problems {
            let row = find(problem.code()).expect("every code has a row");
            assert_eq!(row.severity, problem.severity(), "{}", row.code);
        }
    }
}
