//! The source lines of the blocks that a result names, read once more from the program.

use crate::results::BlockResult;
use crate::source::ProgramSource;
use std::collections::BTreeMap;
use std::io::{BufRead, Read};

/// Longest text kept of a block, characters.
const LONGEST: usize = 80;

/// Fills in the texts; those that cannot be read again stay empty.
pub(crate) fn fill(source: &ProgramSource, mut blocks: Vec<&mut BlockResult>) {
    let mut texts: BTreeMap<u64, String> = blocks.iter().map(|block| (block.block.span.start, String::new())).collect();
    if source.open().is_ok_and(|reader| read(reader, &mut texts).is_ok()) {
        for block in &mut blocks {
            if let Some(text) = texts.get(&block.block.span.start) {
                block.text.clone_from(text);
            }
        }
    }
}

/// Reads the line at each place, going through the program once without holding it.
fn read(mut reader: Box<dyn BufRead + Send>, texts: &mut BTreeMap<u64, String>) -> std::io::Result<()> {
    let mut at = 0;
    for (start, text) in texts {
        at += std::io::copy(&mut reader.by_ref().take(start.saturating_sub(at)), &mut std::io::sink())?;
        // A character takes up to four bytes.
        let mut bytes = Vec::new();
        at += reader.by_ref().take(4 * LONGEST as u64).read_to_end(&mut bytes)? as u64;
        let line = bytes.split(|byte| matches!(byte, b'\n' | b'\r')).next().unwrap_or_default();
        *text = String::from_utf8_lossy(line).trim().chars().take(LONGEST).collect();
    }
    Ok(())
}
