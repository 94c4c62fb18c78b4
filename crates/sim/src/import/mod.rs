//! Machine descriptions of other programs, turned into machine files.
//!
//! Other formats tell axes, travel and speeds at best; drive, motor and load, gap and jerk come
//! from a machine that is named. Every key that was read, ignored or filled in is reported, and the
//! file says behind every value where it is from.

mod dh;
mod draft;
mod fill;
mod freecad;
mod freecad_chain;
mod grbl;
mod hal;
mod kins;
mod linuxcnc;
mod urdf;

pub use draft::{Fate, Row};

use crate::machine::MachineError;
use crate::machine::Problem;

/// A format that can be imported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImportFormat {
    /// LinuxCNC's INI file: <https://linuxcnc.org/docs/stable/html/config/ini-config.html>.
    LinuxCnc,
    /// What grbl and grblHAL answer to `$$`:
    /// <https://github.com/gnea/grbl/wiki/Grbl-v1.1-Configuration>.
    Grbl,
    /// FreeCAD's machine library (JSON).
    FreeCad,
    /// Unified robot description (XML): <https://wiki.ros.org/urdf/XML>.
    Urdf,
}

impl ImportFormat {
    /// All of them, by the names that people give.
    pub const NAMES: [(&'static str, ImportFormat); 4] = [
        ("linuxcnc", ImportFormat::LinuxCnc),
        ("grbl", ImportFormat::Grbl),
        ("freecad", ImportFormat::FreeCad),
        ("urdf", ImportFormat::Urdf),
    ];

    /// By extension, then by what the text looks like.
    pub fn recognise(name: &str, text: &str) -> Option<ImportFormat> {
        let extension = name
            .rsplit_once('.')
            .map(|(_, extension)| extension.to_ascii_lowercase());
        match extension.as_deref() {
            Some("ini") => return Some(ImportFormat::LinuxCnc),
            Some("fcm") => return Some(ImportFormat::FreeCad),
            Some("urdf") => return Some(ImportFormat::Urdf),
            _ => {}
        }
        let lines = || text.lines().map(str::trim);
        if lines().any(|line| line.starts_with("$1") && line.contains('=')) {
            return Some(ImportFormat::Grbl);
        }
        if text.contains("<robot") {
            return Some(ImportFormat::Urdf);
        }
        if text.trim_start().starts_with('{') {
            return Some(ImportFormat::FreeCad);
        }
        lines()
            .any(|line| matches!(line, "[EMC]" | "[TRAJ]" | "[KINS]"))
            .then_some(ImportFormat::LinuxCnc)
    }
}

/// The longest text that is read.
const MAX_BYTES: usize = 4 * 1024 * 1024;

/// What came of an import.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// A machine file that [`Machine::from_toml`](crate::Machine::from_toml) accepts.
    pub toml: String,
    /// Every key, in the order of the file, then what was filled in.
    pub rows: Vec<Row>,
}

/// Turns a description into a machine file. `name` is the file's name, `preset` the machine that
/// lends what is missing.
///
/// # Errors
/// Everything that is wrong with the text, with its line; a machine that would not hold together;
/// an unknown preset.
pub fn import(
    name: &str,
    text: &str,
    format: ImportFormat,
    preset: &str,
) -> Result<Imported, MachineError> {
    let fail = |problems| MachineError::new(name, problems);
    if text.len() > MAX_BYTES {
        let message = format!(
            "has {} bytes; more than {MAX_BYTES} are no description of a machine",
            text.len()
        );
        return Err(fail(vec![problem(1, "", message, "")]));
    }
    let draft = match format {
        ImportFormat::LinuxCnc => linuxcnc::read(text),
        ImportFormat::Grbl => grbl::read(text),
        ImportFormat::FreeCad => freecad::read(text),
        ImportFormat::Urdf => urdf::read(text),
    }
    .map_err(fail)?;
    fill::machine(name, draft, preset).map_err(fail)
}

/// A problem at a line.
fn problem(line: usize, key: &str, message: impl Into<String>, hint: &str) -> Problem {
    Problem {
        line: u32::try_from(line).unwrap_or(u32::MAX),
        column: 1,
        key: key.to_owned(),
        message: message.into(),
        hint: hint.to_owned(),
        option: None,
    }
}

/// A number, or what is wrong with it.
fn number(line: usize, key: &str, text: &str) -> Result<f64, Problem> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(problem(
            line,
            key,
            format!("`{}` is not a number", text.trim()),
            "write a decimal number, such as 1500.0",
        )),
    }
}
