//! Whether a structure in Thrift's compact protocol, of which Parquet's headers are, is as long as it says.
//!
//! The format's own crate passes over fields that it does not know element by element. A truth value in a list
//! takes none of its bytes there, so that a list of two thousand million of them, which a few bytes can claim,
//! keeps it for as many steps. Lists longer than what is there are refused here before it reads them, and so are
//! lists of truth values, of which these headers have none.

/// Structures within structures. A choice: Parquet has eight.
const DEEPEST: usize = 32;

/// A structure that has been passed over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Passed {
    /// Bytes that it takes.
    pub(crate) bytes: usize,
    /// Its own third field where that is a whole number: in a page's header the size of the page.
    pub(crate) third: Option<i64>,
}

/// Passes over the structure at the beginning of some bytes.
///
/// # Errors
/// What is wrong with it.
pub(crate) fn pass(bytes: &[u8]) -> Result<Passed, &'static str> {
    let mut rest = bytes;
    let third = structure(&mut rest, DEEPEST)?;
    Ok(Passed {
        bytes: bytes.len() - rest.len(),
        third,
    })
}

fn byte(rest: &mut &[u8]) -> Result<u8, &'static str> {
    let (first, behind) = rest.split_first().ok_or("a header is cut off")?;
    *rest = behind;
    Ok(*first)
}

fn skip(rest: &mut &[u8], count: u64) -> Result<(), &'static str> {
    let count = usize::try_from(count).ok();
    *rest = count
        .and_then(|count| rest.get(count..))
        .ok_or("a header is cut off")?;
    Ok(())
}

fn number(rest: &mut &[u8]) -> Result<u64, &'static str> {
    let mut value = 0;
    for place in 0..10 {
        let next = byte(rest)?;
        value |= u64::from(next & 0x7f) << (7 * place);
        if next & 0x80 == 0 {
            return Ok(value);
        }
    }
    Err("a number in a header is too long")
}

/// A number whose last bit is its sign.
fn signed(rest: &mut &[u8]) -> Result<i64, &'static str> {
    let value = number(rest)?;
    Ok((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
}

fn structure(rest: &mut &[u8], depth: usize) -> Result<Option<i64>, &'static str> {
    let deeper = depth.checked_sub(1).ok_or("a header is nested too deep")?;
    let (mut id, mut third) = (0_i64, None);
    loop {
        let head = byte(rest)?;
        let kind = head & 0x0f;
        if kind == 0 {
            return Ok(third);
        }
        id = match head >> 4 {
            0 => signed(rest)?,
            delta => id.saturating_add(i64::from(delta)),
        };
        match kind {
            // a truth value is in its field's head
            1 | 2 => {}
            4..=6 if id == 3 => third = Some(signed(rest)?),
            kind => value(rest, kind, deeper)?,
        }
    }
}

fn value(rest: &mut &[u8], kind: u8, depth: usize) -> Result<(), &'static str> {
    let deeper = depth.checked_sub(1).ok_or("a header is nested too deep")?;
    match kind {
        3 => byte(rest).map(drop),
        4..=6 => number(rest).map(drop),
        7 => skip(rest, 8),
        8 => {
            let length = number(rest)?;
            skip(rest, length)
        }
        9 | 10 => {
            let head = byte(rest)?;
            let count = match head >> 4 {
                15 => number(rest)?,
                count => u64::from(count),
            };
            elements(rest, &[head & 0x0f], count, deeper)
        }
        11 => {
            let count = number(rest)?;
            if count == 0 {
                return Ok(());
            }
            let kinds = byte(rest)?;
            elements(rest, &[kinds >> 4, kinds & 0x0f], count, deeper)
        }
        12 => structure(rest, deeper).map(drop),
        13 => skip(rest, 16),
        _ => Err("a header has values of no known kind"),
    }
}

fn elements(rest: &mut &[u8], kinds: &[u8], count: u64, depth: usize) -> Result<(), &'static str> {
    // Each takes a byte at least.
    if count > rest.len() as u64 {
        return Err("a list in a header is longer than the file");
    }
    if count > 0 && kinds.iter().any(|kind| matches!(kind, 1 | 2)) {
        return Err("a header has a list of truth values");
    }
    for _ in 0..count {
        for kind in kinds {
            value(rest, *kind, depth)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_structure_is_passed_over_to_its_end() {
        // field 3 as 21, field 4 a list of two numbers, field 5 a text, field 7 true, field 8 a structure
        let bytes = [
            0x35, 42, 0x19, 0x25, 2, 0x90, 1, 0x18, 2, b'a', b'b', 0x21, 0x1c, 0x15, 2, 0, 0, 99,
        ];
        let passed = pass(&bytes).unwrap();
        assert_eq!(
            passed,
            Passed {
                bytes: 17,
                third: Some(21)
            }
        );
        // cut anywhere
        for end in 0..17 {
            assert!(pass(&bytes[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn lists_that_take_no_bytes_are_refused() {
        // two thousand million truth values, as many structures, and few truth values
        for (bytes, why) in [
            (
                &[0x19, 0xf2, 0xff, 0xff, 0xff, 0xff, 7, 0][..],
                "longer than the file",
            ),
            (
                &[0x19, 0xfc, 0xff, 0xff, 0xff, 0xff, 7, 0],
                "longer than the file",
            ),
            (&[0x19, 0x22, 1, 1, 0], "truth values"),
            (&[0x1b, 2, 0x21, 1, 1, 1, 1, 0], "truth values"),
        ] {
            let refused = pass(bytes).unwrap_err();
            assert!(refused.contains(why), "{refused}");
        }
        let nested = [0x1c; 200];
        assert_eq!(pass(&nested), Err("a header is nested too deep"));
    }
}
