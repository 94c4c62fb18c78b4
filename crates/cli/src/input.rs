//! Files that are read whole, and part programs.

use crate::failure::Failure;
use lostmotion::sim::Program;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest machine file, tool table or fit result.
const MAX_TEXT_BYTES: u64 = 16 << 20;
/// Largest part program from a pipe: it is held in memory.
const MAX_PIPE_BYTES: u64 = 1 << 30;

/// Opens a file for reading; a folder or a missing file is said to be one.
pub(crate) fn open(path: &Path, what: &str) -> Result<File, Failure> {
    let shown = path.display();
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
    open(path, what)?
        .take(MAX_TEXT_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| Failure::message(format!("cannot read {what} {shown}: {error}")))?;
    if bytes.len() as u64 > MAX_TEXT_BYTES {
        return Err(Failure::message(format!(
            "{shown} has more than {MAX_TEXT_BYTES} bytes; that is no {what}"
        )));
    }
    if bytes.is_empty() {
        return Err(Failure::message(format!("{what} {shown} is empty")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Failure::message(format!(
            "{shown} is not a {what}: no UTF-8 text from byte {at} on"
        ))
    })
}

/// A part program that is there and not empty. A run reads it more than once, so what can be read
/// only once (a pipe) is taken into memory.
pub(crate) fn program(path: &Path) -> Result<Program, Failure> {
    let shown = path.display();
    let failed = |error| Failure::message(format!("cannot read part program {shown}: {error}"));
    let file = open(path, "part program")?;
    let meta = file.metadata().map_err(failed)?;
    let empty = || Failure::message(format!("part program {shown} is empty"));
    if meta.is_file() {
        return if meta.len() == 0 {
            Err(empty())
        } else {
            Ok(Program::from_path(path))
        };
    }
    let mut bytes = Vec::new();
    file.take(MAX_PIPE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    if bytes.len() as u64 > MAX_PIPE_BYTES {
        return Err(Failure::message(format!(
            "{shown} gives more than {MAX_PIPE_BYTES} bytes; a program of that size has to be a file"
        )));
    }
    if bytes.is_empty() {
        Err(empty())
    } else {
        Ok(Program::from_bytes(shown.to_string(), bytes))
    }
}
