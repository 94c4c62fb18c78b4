//! The table of codes: one row per code.
//!
//! Adding a code is one row in `table`, one function with its line in `exec/run.rs`, and one
//! sample program; tests fail while one of them is missing.
//!
//! ```
//! use lostmotion_gcode::Code;
//! use lostmotion_gcode::codes::find;
//!
//! let row = find(Code::g(591)).unwrap();
//! assert_eq!((row.group.name(), row.example), ("coordinate system", "G59.1"));
//! ```

use std::fmt::Write;

pub mod row;
mod table;

pub use row::{AxisUse, Code, CodeRow, Group, whole};

/// Codes at or above this many tenths have no row.
const G_SIZE: usize = 2000;
const M_SIZE: usize = 2000;
const NONE: u8 = u8::MAX;

/// All rows: first G, then M codes.
pub fn rows() -> impl Iterator<Item = &'static CodeRow> {
    table::G_ROWS.iter().chain(table::M_ROWS)
}

const fn index<const N: usize>(rows: &[CodeRow]) -> [u8; N] {
    let mut index = [NONE; N];
    let mut at = 0;
    // Evaluated at compile time: a code is found by one index instead of a search.
    while at < rows.len() {
        index[rows[at].code.tenths as usize] = at as u8;
        at += 1;
    }
    index
}

static G_INDEX: [u8; G_SIZE] = index(table::G_ROWS);
static M_INDEX: [u8; M_SIZE] = index(table::M_ROWS);

/// The row of a code, if this interpreter has it.
pub fn find(code: Code) -> Option<&'static CodeRow> {
    let (rows, index) = if code.letter == 'G' {
        (table::G_ROWS, &G_INDEX[..])
    } else {
        (table::M_ROWS, &M_INDEX[..])
    };
    index
        .get(usize::from(code.tenths))
        .and_then(|&row| rows.get(usize::from(row)))
}

/// Names of the codes that take a word, for hints.
pub(crate) fn users(letter: char) -> String {
    let codes: Vec<String> = rows()
        .filter(|row| row.words.contains(letter))
        .map(|row| row.code.to_string())
        .collect();
    codes.join(" ")
}

const HEAD: &str = "# Codes\n\nEvery G and M code that lostmotion reads: its modal group (one line may have one code of a group), the words it takes besides F, S and T, what it \
does, a line that uses it. This page is made from the table in `crates/gcode/src/codes`; a test keeps it in step. Each code has a sample program in \
[gcode_samples/codes](../../../../gcode_samples/codes), whose canonical operations are recorded as a snapshot.\n\n\
Axis words are X Y Z A B C U V W, and in motions the polar @ and ^. In brackets: may be there.\n";

/// The page of all codes, in Markdown.
pub fn page() -> String {
    let mut page = String::from(HEAD);
    // One table for each letter, in the order of the rows.
    for (letter, title) in [('G', "G codes"), ('M', "M codes")] {
        // Writing to a String cannot fail.
        let _ = write!(
            page,
            "\n## {title}\n\n| code | group | words | meaning | example | sample |\n|---|---|---|---|---|---|\n"
        );
        for row in rows().filter(|row| row.code.letter == letter) {
            let sample = format!("[{0}](../../../../gcode_samples/codes/{0})", row.sample);
            let _ = writeln!(
                page,
                "| {} | {} | {} | {} | `{}` | {sample} |",
                row.code,
                row.group.name(),
                words(row),
                row.meaning,
                row.example
            );
        }
    }
    page
}

fn words(row: &CodeRow) -> String {
    let axes = match row.axes {
        AxisUse::None => None,
        AxisUse::May => Some("(axes)".to_owned()),
        AxisUse::Needs => Some("axes".to_owned()),
    };
    let letters = row.words.chars().map(String::from);
    axes.into_iter()
        .chain(letters)
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_found_by_its_code_and_no_code_has_two() {
        for row in rows() {
            assert!(std::ptr::eq(find(row.code).unwrap(), row), "{}", row.code);
        }
        assert!(find(Code::g(390)).is_none());
        assert!(find(Code::m(9999)).is_none());
    }

    #[test]
    fn examples_name_their_code() {
        for row in rows() {
            assert!(
                row.example.contains(&row.code.to_string()),
                "{}: {}",
                row.code,
                row.example
            );
        }
    }
}
