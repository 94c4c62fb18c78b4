//! Files that are read whole, and part programs.

use crate::failure::Failure;
use lostmotion::sim::ProgramSource;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest machine file, tool table or fit result.
const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Opens a file for reading; a folder or a missing file is said to be one.
pub(crate) fn open(path: &Path, what: &str) -> Result<File, Failure> {
    let shown = path.display();
    match std::fs::metadata(path) {
        Ok(meta) if meta.is_dir() => return Err(Failure::message(format!("{shown} is a folder, not a {what}"))),
        Ok(_) => {}
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(Failure::message(format!("{what} {shown} does not exist")));
        }
        Err(error) => return Err(Failure::message(format!("cannot read {what} {shown}: {error}"))),
    }
    File::open(path).map_err(|error| Failure::message(format!("cannot read {what} {shown}: {error}")))
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
        return Err(Failure::message(format!("{shown} has more than {MAX_TEXT_BYTES} bytes; that is no {what}")));
    }
    if bytes.is_empty() {
        return Err(Failure::message(format!("{what} {shown} is empty")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Failure::message(format!("{shown} is not a {what}: no UTF-8 text from byte {at} on"))
    })
}

/// A part program that is there and not empty.
pub(crate) fn program(path: &Path) -> Result<ProgramSource, Failure> {
    let length = open(path, "part program")?.metadata().map(|meta| (meta.is_file(), meta.len()));
    if let Ok((true, 0)) = length {
        return Err(Failure::message(format!("part program {} is empty", path.display())));
    }
    Ok(ProgramSource::from_path(path))
}
