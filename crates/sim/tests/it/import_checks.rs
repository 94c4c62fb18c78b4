//! What has to hold for every description of a machine: shared by the fuzz targets and by the test
//! that replays their corpus.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a check fails by panicking"
)]

use lostmotion_sim::Machine;
use lostmotion_sim::import::{Fate, ImportFormat, ImportOptions, import, rows};

/// Longest included files together: a bound that inputs reach.
const MOST_BYTES: usize = 100_000;
/// The same for very many texts: every file is the description itself, and those that include
/// themselves would take most of the time.
const MOST_BYTES_OF_MANY: usize = 10_000;

/// Any text is refused with the name of the file, or gives a machine that is read as its file says,
/// of which every value is accounted for. Whatever file a description names is the description
/// itself.
pub(crate) fn description(format: &str, bytes: &[u8]) {
    any(format, bytes, true, MOST_BYTES);
}

/// The same for very many texts: the machine is made of one in some thousand of those that are read,
/// which takes a thousand times as long as reading.
#[allow(dead_code, reason = "of the fuzz targets alone")]
pub(crate) fn many(format: &str, bytes: &[u8]) {
    let sum = bytes.iter().fold(7_u32, |sum, byte| {
        sum.wrapping_mul(31).wrapping_add(u32::from(*byte))
    });
    any(format, bytes, sum.is_multiple_of(2048), MOST_BYTES_OF_MANY);
}

fn any(format: &str, bytes: &[u8], is_made: bool, max_bytes: usize) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let (_, format) = ImportFormat::NAMES
        .into_iter()
        .find(|(name, _)| *name == format)
        .unwrap();
    let files = |_: &str| Ok(text.to_owned());
    let options = ImportOptions {
        files: &files,
        max_bytes,
        ..ImportOptions::default()
    };
    if !is_made {
        match rows("fuzzed", text, format, &options) {
            Err(error) => assert!(error.to_string().contains("fuzzed"), "{error}"),
            Ok(found) => assert!(!found.is_empty()),
        }
        return;
    }
    match import("fuzzed", text, format, &options) {
        Err(error) => assert!(error.to_string().contains("fuzzed"), "{error}"),
        Ok(found) => {
            let machine = Machine::from_toml("fuzzed", &found.toml);
            assert!(machine.is_ok(), "{machine:?}\n{}", found.toml);
            assert!(found.rows.iter().any(|row| row.fate != Fate::Ignored));
        }
    }
}
