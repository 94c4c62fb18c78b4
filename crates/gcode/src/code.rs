//! A code as it stands in a program, and the integers that values stand for.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Largest difference between a value and the integer that it stands for, as in LinuxCNC's
/// interpreter.
const WHOLE_TOLERANCE: f64 = 1e-4;

/// The integer that a value stands for, where codes, tool numbers and counts are expected; `None`
/// if it is more than 0.0001 from one.
pub fn whole(value: f64) -> Option<f64> {
    let nearest = value.round();
    ((value - nearest).abs() <= WHOLE_TOLERANCE).then_some(nearest)
}

/// A G or M code as written: letter and number in tenths, `G59.1` is ('G', 591).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Code {
    /// 'G' or 'M'.
    pub letter: char,
    /// Ten times the number.
    pub tenths: u16,
}

impl Code {
    /// A G code from ten times its number.
    pub const fn g(tenths: u16) -> Code {
        Code {
            letter: 'G',
            tenths,
        }
    }

    /// An M code from ten times its number.
    pub const fn m(tenths: u16) -> Code {
        Code {
            letter: 'M',
            tenths,
        }
    }

    /// The code of a letter and number; `None` for numbers that no code has.
    pub fn of(letter: char, value: f64) -> Option<Code> {
        let tenths = whole(value * 10.0).filter(|tenths| (0.0..=65_535.0).contains(tenths))?;
        Some(Code {
            letter,
            tenths: tenths as u16,
        })
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.letter, self.tenths / 10)?;
        if self.tenths.is_multiple_of(10) {
            Ok(())
        } else {
            write!(f, ".{}", self.tenths % 10)
        }
    }
}
