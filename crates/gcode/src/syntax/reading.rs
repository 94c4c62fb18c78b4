//! Lines as a dialect means them: what its leniencies accept beyond RS274/NGC, before anything is
//! carried out.

use super::block::{Block, Fault, Text, Value};
use super::special::{is_heidenhain, parse_special, siemens_word};
use crate::codes::whole;
use crate::dialect::{Leniencies, Leniency};
use crate::limits::Limits;
use crate::problem::Problem;

/// Another try at a line that is a fault in RS274/NGC; which leniencies it took.
///
/// # Errors
/// The fault of RS274/NGC, or what tells better what is wrong.
#[cold]
pub(crate) fn parse_accepted(
    line: &[u8],
    block: &mut Block,
    limits: &Limits,
    accepted: Leniencies,
    fault: Fault,
) -> Result<Vec<Leniency>, Fault> {
    // The dialect's own grammar; only if it took something that RS274/NGC lacks is the line accepted.
    match parse_special(line, block, limits, accepted) {
        Ok(taken) if !taken.is_empty() => return Ok(taken),
        Err(Fault { rest, problem }) if matches!(*problem, Problem::Checksum { .. }) => {
            return Err(Fault { rest, problem });
        }
        _ => {}
    }
    let problem = if is_heidenhain(line) {
        Problem::Heidenhain
    } else if let Some(what) = siemens_word(line) {
        Problem::Siemens { what }
    } else {
        return Err(fault);
    };
    Err(Fault {
        problem: Box::new(problem),
        ..fault
    })
}

/// Exponents: `X1.2E-12` has been read as X1.2 and E-12, which is put right. True if there were any.
/// `is_signless` says whether `E5` is one, too; else it is a word.
pub(crate) fn merge_exponents(line: &[u8], block: &mut Block, is_signless: bool) -> bool {
    let mut found = false;
    let mut index = 0;
    while let Some(&word) = block.words.get(index) {
        let (from, to) = (
            word.text.start as usize,
            (word.text.start + word.text.len) as usize,
        );
        let exponent = line
            .get(from + 1..to)
            .and_then(|text| std::str::from_utf8(text).ok());
        let is_one = is_signless || exponent.is_some_and(|text| text.starts_with(['+', '-']));
        match exponent.filter(|_| word.letter == b'E' && is_one) {
            Some(exponent) if merge_exponent(block, index, word.text, exponent) => found = true,
            _ => index += 1,
        }
    }
    found
}

/// Joins the E word of an index to the word or setting that ends where it begins.
fn merge_exponent(block: &mut Block, index: usize, text: Text, exponent: &str) -> bool {
    let ends_here = |other: &Text| other.start + other.len == text.start;
    let power = |value: Value| match value {
        Value::Number(number) => format!("{number:e}")
            .split_once('e')
            .and_then(|(digits, own)| {
                // The decimal exponents are added and the text is read anew, which rounds once.
                let sum = own
                    .parse::<i64>()
                    .ok()?
                    .checked_add(exponent.parse::<i64>().ok()?)?;
                format!("{digits}e{sum}")
                    .parse::<f64>()
                    .ok()
                    .filter(|number| number.is_finite())
            }),
        Value::Ops(..) => None,
    };
    // The number may end a word or a setting; codes and other E words have no exponent.
    let before = index
        .checked_sub(1)
        .and_then(|before| block.words.get_mut(before));
    if let Some(word) =
        before.filter(|word| ends_here(&word.text) && !matches!(word.letter, b'G' | b'M' | b'E'))
    {
        let Some(value) = power(word.value) else {
            return false;
        };
        (word.value, word.text.len) = (Value::Number(value), word.text.len + text.len);
    } else if let Some(setting) = block
        .settings
        .iter_mut()
        .find(|setting| ends_here(&setting.text))
    {
        let Some(value) = power(setting.value) else {
            return false;
        };
        (setting.value, setting.text.len) = (Value::Number(value), setting.text.len + text.len);
    } else {
        return false;
    }
    block.words.remove(index);
    true
}

/// G codes in tenths, and M codes, of printers that mean the same here.
const PRINTER_G: [u16; 25] = [
    0, 10, 20, 30, 40, 50, 170, 180, 190, 200, 210, 280, 530, 540, 550, 560, 570, 580, 590, 591,
    592, 593, 900, 910, 920,
];
const PRINTER_M: [f64; 11] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 30.0];

/// Whether a line has a code that only printers have: temperatures, fans, bed levelling. None of them
/// moves the axes.
pub(crate) fn is_printers_code(block: &Block) -> bool {
    block
        .words
        .iter()
        .any(|word| match (word.letter, word.value) {
            (b'G', Value::Number(number)) => whole(number * 10.0)
                .is_none_or(|tenths| !PRINTER_G.iter().any(|known| f64::from(*known) == tenths)),
            (b'M', Value::Number(number)) => !PRINTER_M.contains(&number),
            _ => false,
        })
}
