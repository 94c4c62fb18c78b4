//! What a command reads: files that are read whole, and part programs.

use crate::output::{Failure, is_standard};
use lostmotion::sim::Program;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest machine file, tool table or fit result, bytes. A choice: a thousand times the usual.
const MAX_TEXT_BYTES: u64 = 16 << 20;
/// Largest part program from a pipe, bytes: it is held in memory. A choice.
const MAX_PIPE_BYTES: u64 = 1 << 30;

/// What messages call a part program from stdin.
const STDIN_NAME: &str = "stdin";

/// Opens a file for reading. A folder and a missing file have their own messages.
pub(crate) fn open(path: &Path, what: &str) -> Result<File, Failure> {
    let shown = path.display();
    // Unix opens a folder like a file, and only the first read fails: so it is asked before.
    match std::fs::metadata(path) {
        Ok(meta) if meta.is_dir() => {
            return Err(Failure::message(format!(
                "{shown} is a folder, not a {what}"
            )));
        }
        Ok(_) => {}
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(Failure::message(format!("{what} {shown} does not exist")));
        }
        Err(error) => {
            return Err(Failure::message(format!(
                "cannot read {what} {shown}: {error}"
            )));
        }
    }
    File::open(path)
        .map_err(|error| Failure::message(format!("cannot read {what} {shown}: {error}")))
}

/// Reads a small text file.
pub(crate) fn text(path: &Path, what: &str) -> Result<String, Failure> {
    let shown = path.display();
    let mut bytes = Vec::new();
    // One byte more than allowed tells a file that is too large from one that just fits.
    open(path, what)?
        .take(MAX_TEXT_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| Failure::message(format!("cannot read {what} {shown}: {error}")))?;
    if bytes.len() as u64 > MAX_TEXT_BYTES {
        return Err(Failure::message(format!(
            "{shown} has more than {MAX_TEXT_BYTES} bytes; that is not a {what}"
        )));
    }
    if bytes.is_empty() {
        return Err(Failure::message(format!("{what} {shown} is empty")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Failure::message(format!(
            "{shown} is not a {what}: it is not UTF-8 text (byte {at})"
        ))
    })
}

/// A part program that exists and is not empty; `-` is stdin. A run reads it more than once, so what
/// can be read only once (a pipe) is taken into memory.
pub(crate) fn program(path: &Path) -> Result<Program, Failure> {
    if is_standard(path) {
        return piped(std::io::stdin().lock(), STDIN_NAME);
    }
    let shown = path.display();
    let failed = |error| Failure::message(format!("cannot read part program {shown}: {error}"));
    let file = open(path, "part program")?;
    let meta = file.metadata().map_err(failed)?;
    // A file is read in place, as often as needed; a pipe only once.
    if meta.is_file() {
        return if meta.len() == 0 {
            Err(Failure::message(format!("part program {shown} is empty")))
        } else {
            Ok(Program::from_path(path))
        };
    }
    piped(file, &shown.to_string())
}

/// A part program that can be read only once.
fn piped(pipe: impl Read, name: &str) -> Result<Program, Failure> {
    let mut bytes = Vec::new();
    // One byte more than allowed tells a pipe that is too long from one that just fits.
    pipe.take(MAX_PIPE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| Failure::message(format!("cannot read part program {name}: {error}")))?;
    if bytes.len() as u64 > MAX_PIPE_BYTES {
        return Err(Failure::with_hint(
            format!("{name} gives more than {MAX_PIPE_BYTES} bytes"),
            "a part program of that size has to be a file",
        ));
    }
    if bytes.is_empty() {
        Err(Failure::message(format!("part program {name} is empty")))
    } else {
        Ok(Program::from_bytes(name.to_owned(), bytes))
    }
}
