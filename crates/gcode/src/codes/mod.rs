//! The table of codes: one row per code.
//!
//! Adding a code is one row in `g` or `m`, one function that carries it out, and one sample
//! program.

mod g;
mod m;
mod page;
pub mod row;

pub use page::page;
pub use row::{AxisUse, CodeRow, Group};

use crate::code::Code;

/// Codes at or above this many tenths have no row.
const G_SIZE: usize = 1000;
const M_SIZE: usize = 2000;
const NONE: u8 = u8::MAX;

/// All rows: first G, then M codes.
pub fn rows() -> impl Iterator<Item = &'static CodeRow> {
    g::ROWS.iter().chain(m::ROWS)
}

const fn index<const N: usize>(rows: &[CodeRow]) -> [u8; N] {
    let mut index = [NONE; N];
    let mut at = 0;
    while at < rows.len() {
        index[rows[at].code.tenths as usize] = at as u8;
        at += 1;
    }
    index
}

static G_INDEX: [u8; G_SIZE] = index(g::ROWS);
static M_INDEX: [u8; M_SIZE] = index(m::ROWS);

/// The row of a code, if this interpreter has it.
pub fn find(code: Code) -> Option<&'static CodeRow> {
    let (rows, index) = if code.letter == 'G' {
        (g::ROWS, &G_INDEX[..])
    } else {
        (m::ROWS, &M_INDEX[..])
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_found_by_its_code_and_no_code_has_two() {
        for row in rows() {
            assert!(std::ptr::eq(find(row.code).unwrap(), row), "{}", row.code);
        }
        assert!(
            find(Code {
                letter: 'G',
                tenths: 390
            })
            .is_none()
        );
        assert!(
            find(Code {
                letter: 'M',
                tenths: 9999
            })
            .is_none()
        );
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
