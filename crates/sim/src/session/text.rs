//! The source lines of the blocks that a result names, read once more from the program.

use crate::source::ProgramSource;
use lostmotion_base::BlockRef;
use lostmotion_gcode::SourceFiles;
use std::collections::BTreeMap;
use std::io::{BufRead, Read};

/// Longest text kept of a block, characters.
const LONGEST: usize = 80;

/// Fills in the texts; those that cannot be read again stay empty.
pub(crate) fn fill(
    source: &ProgramSource,
    files: &SourceFiles,
    mut blocks: Vec<(BlockRef, &mut String)>,
) {
    let own = |(block, _): &(BlockRef, &mut String)| block.span.file == 0;
    for (block, text) in blocks.iter_mut().filter(|row| !own(row)) {
        let file = (block.span.file as usize)
            .checked_sub(1)
            .and_then(|index| files.get(index));
        let rest = file
            .and_then(|file| file.text.get(block.span.start as usize..))
            .unwrap_or_default();
        **text = first_line(rest);
    }
    blocks.retain(own);
    let mut texts: BTreeMap<u64, String> = blocks
        .iter()
        .map(|(block, _)| (block.span.start, String::new()))
        .collect();
    if source
        .open()
        .is_ok_and(|reader| read(reader, &mut texts).is_ok())
    {
        for (block, text) in &mut blocks {
            if let Some(found) = texts.get(&block.span.start) {
                text.clone_from(found);
            }
        }
    }
}

/// Reads the line at each place, going through the program once without holding it.
fn read(
    mut reader: Box<dyn BufRead + Send>,
    texts: &mut BTreeMap<u64, String>,
) -> std::io::Result<()> {
    // A character takes up to four bytes.
    let longest = 4 * LONGEST as u64;
    // The last bytes read, and where they begin: the next place may lie in them.
    let (mut held, mut held_at): (Vec<u8>, u64) = (Vec::new(), 0);
    for (&start, text) in texts {
        let end = held_at + held.len() as u64;
        if start > end {
            std::io::copy(&mut reader.by_ref().take(start - end), &mut std::io::sink())?;
            held.clear();
        } else {
            held.drain(..(start - held_at) as usize);
        }
        held_at = start;
        let missing = longest.saturating_sub(held.len() as u64);
        reader.by_ref().take(missing).read_to_end(&mut held)?;
        *text = first_line(&held);
    }
    Ok(())
}

fn first_line(bytes: &[u8]) -> String {
    let line = bytes
        .split(|byte| matches!(byte, b'\n' | b'\r'))
        .next()
        .unwrap_or_default();
    String::from_utf8_lossy(line.get(..line.len().min(4 * LONGEST)).unwrap_or_default())
        .trim()
        .chars()
        .take(LONGEST)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_near_and_far_apart_are_found() {
        let lines: Vec<String> = (0..100)
            .map(|n| format!("N{n} G1 X{}", "1".repeat(n)))
            .collect();
        let program = lines.join("\n");
        let start = |n: usize| {
            lines[..n]
                .iter()
                .map(|line| line.len() as u64 + 1)
                .sum::<u64>()
        };
        let wanted = [0, 1, 2, 40, 41, 99];
        let mut texts: BTreeMap<u64, String> =
            wanted.iter().map(|n| (start(*n), String::new())).collect();
        read(
            Box::new(std::io::Cursor::new(program.clone().into_bytes())),
            &mut texts,
        )
        .unwrap();
        for n in wanted {
            assert_eq!(
                texts[&start(n)],
                lines[n].chars().take(LONGEST).collect::<String>()
            );
        }
    }
}
