//! A part program: where its text comes from, and what can be said of it without a machine.

use crate::files::{self, File};
use lostmotion_base::Span;
use lostmotion_gcode::{Diagnostics, InterpreterConfig, Program as Interpretation, SourceFiles};
use std::io::{BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Longest text kept of a block, characters; a listing has no room for more.
const LONGEST_TEXT: usize = 80;
/// Bytes that this many characters take at most in UTF-8.
const LONGEST_BYTES: usize = 4 * LONGEST_TEXT;

/// Operations of a program as the interpreter gives them, one after the other, with the block each
/// comes from; it holds the diagnostics found on the way.
pub type Operations = Interpretation<Box<dyn BufRead + Send>>;

/// A part program that can be read several times, from a file or from memory.
///
/// A run reads it several times from the start without holding it: to check it, to count its
/// lines, to simulate it, to fetch the text of the worst blocks. A pipe cannot be a program for
/// that reason; read it into memory first.
///
/// ```
/// use lostmotion_sim::Program;
///
/// let program = Program::from_str("slot.ngc", "G21 G90\nG1 X40 F600\nG1 Z-\nM2\n");
/// let found = program.diagnostics(Default::default())?;
/// let first = &found.kept()[0];
/// assert_eq!(first.place.span.line, 3);
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Program {
    name: String,
    origin: Origin,
}

#[derive(Clone, Debug)]
enum Origin {
    File(PathBuf),
    Bytes(Arc<[u8]>),
}

impl Program {
    /// A program given as text, with a name for messages.
    pub fn from_str(name: impl Into<String>, text: impl AsRef<str>) -> Program {
        Program::from_bytes(name, text.as_ref().as_bytes())
    }

    /// A program in memory, with a name for messages. Its bytes need not be UTF-8.
    pub fn from_bytes(name: impl Into<String>, bytes: impl Into<Arc<[u8]>>) -> Program {
        Program {
            name: name.into(),
            origin: Origin::Bytes(bytes.into()),
        }
    }

    /// A file, whose path as given is its name. It is opened when it is read, so that a program of
    /// any length takes no memory; a file that is not there is an error of the run.
    pub fn from_path(path: impl AsRef<Path>) -> Program {
        let path = path.as_ref();
        Program {
            name: path.display().to_string(),
            origin: Origin::File(path.to_path_buf()),
        }
    }

    /// Name for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Size in bytes.
    ///
    /// # Errors
    /// The file cannot be read, or is a folder.
    pub fn len(&self) -> std::io::Result<u64> {
        match &self.origin {
            Origin::Bytes(bytes) => Ok(bytes.len() as u64),
            Origin::File(path) => files::size(path),
        }
    }

    /// Whether there is nothing in it.
    ///
    /// # Errors
    /// As [`Program::len`].
    pub fn is_empty(&self) -> std::io::Result<bool> {
        Ok(self.len()? == 0)
    }

    /// A reader from the start.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn open(&self) -> std::io::Result<Box<dyn BufRead + Send>> {
        Ok(match &self.origin {
            Origin::Bytes(bytes) => Box::new(Cursor::new(bytes.clone())),
            Origin::File(path) => Box::new(BufReader::with_capacity(1 << 16, files::open(path)?)),
        })
    }

    /// All bytes.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn bytes(&self) -> std::io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.open()?.read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// The whole text; bytes that are not UTF-8 become replacement characters.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn text(&self) -> std::io::Result<String> {
        Ok(String::from_utf8_lossy(&self.bytes()?).into_owned())
    }

    /// The text of the block that a span of the program lies in, trimmed and cut to 80 characters.
    ///
    /// ```
    /// use lostmotion_sim::Program;
    ///
    /// let program = Program::from_str("slot.ngc", "G21 G90\nG1 X40 F\nM2\n");
    /// let found = program.diagnostics(Default::default())?;
    /// let place = found.kept()[0].place.span;
    /// assert_eq!(program.block_text(place)?, "G1 X40 F");
    /// # Ok::<(), std::io::Error>(())
    /// ```
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn block_text(&self, span: Span) -> std::io::Result<String> {
        self.lines()?.at(line_start(span))
    }

    /// The canonical operations of the program, read with these settings. They are made as they
    /// are asked for; what is wrong with the program is in [`Operations::diagnostics`] afterwards.
    ///
    /// ```
    /// use lostmotion_gcode::CanonicalOp;
    /// use lostmotion_sim::Program;
    ///
    /// let program = Program::from_str("line.ngc", "G21 G90\nG1 X40 F600\nM2\n");
    /// let feeds = program.operations(Default::default())?.filter(|found| {
    ///     matches!(found.op, CanonicalOp::StraightFeed(_))
    /// });
    /// assert_eq!(feeds.count(), 1);
    /// # Ok::<(), std::io::Error>(())
    /// ```
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn operations(&self, config: InterpreterConfig) -> std::io::Result<Operations> {
        Ok(Interpretation::new(self.open()?, config))
    }

    /// Everything that is wrong or doubtful in the program, read to its end with these settings.
    ///
    /// # Errors
    /// The file cannot be opened. What goes wrong while it is read is among the diagnostics.
    pub fn diagnostics(&self, config: InterpreterConfig) -> std::io::Result<Diagnostics> {
        let mut operations = self.operations(config)?;
        // They are complete once the program has been read to its end.
        operations.by_ref().for_each(drop);
        Ok(operations.diagnostics().clone())
    }

    /// Its lines by place.
    fn lines(&self) -> std::io::Result<Lines> {
        Ok(match &self.origin {
            Origin::Bytes(bytes) => Lines::Bytes(bytes.clone()),
            Origin::File(path) => Lines::File(BufReader::new(files::open(path)?), 0),
        })
    }
}

/// Lines of a program, read where they stand.
enum Lines {
    Bytes(Arc<[u8]>),
    /// With the place that is read next. Blocks are mostly asked for in their order: seeking a
    /// little forward stays in the reader's buffer.
    File(BufReader<File>, u64),
}

impl Lines {
    /// The line from a byte on.
    fn at(&mut self, start: u64) -> std::io::Result<String> {
        match self {
            Lines::Bytes(bytes) => {
                let from = usize::try_from(start).unwrap_or(usize::MAX);
                Ok(first_line(bytes.get(from..).unwrap_or_default()))
            }
            Lines::File(reader, next) => {
                match i64::try_from(start).ok().zip(i64::try_from(*next).ok()) {
                    // Keeps the buffer where the place lies in it; `seek` would always throw it
                    // away.
                    Some((start, next)) => reader.seek_relative(start - next)?,
                    None => drop(reader.seek(SeekFrom::Start(start))?),
                }
                let mut bytes = Vec::with_capacity(LONGEST_BYTES);
                reader
                    .by_ref()
                    .take(LONGEST_BYTES as u64)
                    .read_to_end(&mut bytes)?;
                *next = start + bytes.len() as u64;
                Ok(first_line(&bytes))
            }
        }
    }
}

/// Where the line of a span begins: columns count bytes from 1.
fn line_start(span: Span) -> u64 {
    span.start
        .saturating_sub(u64::from(span.column.saturating_sub(1)))
}

fn first_line(bytes: &[u8]) -> String {
    let line = bytes
        .split(|byte| matches!(byte, b'\n' | b'\r'))
        .next()
        .unwrap_or_default();
    // Cut before it is decoded: a file without line feeds is one long line.
    String::from_utf8_lossy(
        line.get(..line.len().min(LONGEST_BYTES))
            .unwrap_or_default(),
    )
    .trim()
    .chars()
    .take(LONGEST_TEXT)
    .collect()
}

/// Texts of the blocks of a program and of the subroutine files that it calls.
pub(crate) struct BlockTexts {
    lines: Option<Lines>,
    files: SourceFiles,
}

impl BlockTexts {
    /// Of a program and its files. A program that cannot be opened any more has no texts.
    pub(crate) fn new(program: &Program, files: SourceFiles) -> BlockTexts {
        BlockTexts {
            lines: program.lines().ok(),
            files,
        }
    }

    /// The text at a span; empty where it cannot be read.
    pub(crate) fn at(&mut self, span: Span) -> String {
        // File 0 is the program itself, n the nth file of subroutines.
        match (span.file as usize).checked_sub(1) {
            None => self
                .lines
                .as_mut()
                .and_then(|lines| lines.at(line_start(span)).ok())
                .unwrap_or_default(),
            Some(index) => {
                let text = self.files.get(index).map_or(&[][..], |file| &file.text);
                first_line(text.get(line_start(span) as usize..).unwrap_or_default())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn lines_near_and_far_apart_are_found_in_memory_and_in_files() {
        let lines: Vec<String> = (0..400)
            .map(|n| format!("N{n} G1 X{}", "1".repeat(n % 100)))
            .collect();
        let text = lines.join("\n");
        let start = |n: usize| lines[..n].iter().map(|line| line.len() as u64 + 1).sum();
        let path = std::env::temp_dir().join(format!("lostmotion-lines-{}", std::process::id()));
        File::create(&path)
            .unwrap()
            .write_all(text.as_bytes())
            .unwrap();
        let mut sources = [Program::from_str("a", &text), Program::from_path(&path)]
            .map(|program| program.lines().unwrap());
        for source in &mut sources {
            for n in [0, 1, 2, 40, 41, 399, 398, 0, 399, 200] {
                let expected: String = lines[n].chars().take(LONGEST_TEXT).collect();
                assert_eq!(source.at(start(n)).unwrap(), expected);
            }
            assert_eq!(source.at(1 << 40).unwrap(), "");
        }
        std::fs::remove_file(&path).unwrap();
    }
}
