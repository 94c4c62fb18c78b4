//! Programs and machines of a sweep, held against what was planned with.

use crate::error::SweepError;
use crate::key::sha256;
use crate::manifest::{Header, Input};
use crate::missing::{Need, Needs};
use lostmotion_sim::machine::presets;
use lostmotion_sim::request::{ReadingRequest, RunRequest};
use lostmotion_sim::{Program, SimulateOptions};
use serde::Deserialize;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest machine file, bytes. A choice: a thousand times the usual.
const MAX_MACHINE_BYTES: u64 = 16 << 20;
/// Programs are held in memory as long as they are no more than this together, bytes; further ones
/// are read where they stand. A choice: a quarter of what a worker may take.
const HELD_BYTES: usize = 48 << 20;

/// A machine as it was planned with.
#[derive(Clone, Debug)]
pub struct MachineText {
    /// Name for messages.
    pub name: String,
    /// The file.
    pub toml: String,
}

/// Everything that cells need.
#[derive(Debug)]
pub struct Inputs {
    /// What they have in common.
    pub(crate) header: Header,
    pub(crate) programs: Vec<Option<Program>>,
    pub(crate) machines: Vec<MachineText>,
    reading: ReadingRequest,
    pub(crate) options: SimulateOptions,
}

/// The text of a machine: of a name that comes with the program, or of a file.
pub(crate) fn machine_text(name: &str, folder: &Path) -> Result<MachineText, SweepError> {
    if let Some(preset) = presets().iter().find(|preset| preset.name == name) {
        return Ok(MachineText {
            name: format!("{name}.toml"),
            toml: preset.toml.to_owned(),
        });
    }
    let path = folder.join(name);
    let unread = |error| SweepError::unread("machine file", &path, error);
    let file = File::open(&path).map_err(|error| match error.kind() {
        // A name without an ending was meant to be one that comes with the program.
        std::io::ErrorKind::NotFound if Path::new(name).extension().is_none() => {
            let known: Vec<&str> = presets().iter().map(|preset| preset.name).collect();
            SweepError::value(
                format!("there is no machine \"{name}\""),
                lostmotion_base::names::did_you_mean(name, &known),
            )
        }
        _ => unread(error),
    })?;
    let mut toml = String::new();
    file.take(MAX_MACHINE_BYTES + 1)
        .read_to_string(&mut toml)
        .map_err(unread)?;
    if toml.len() as u64 > MAX_MACHINE_BYTES {
        let message =
            format!("{name} has more than {MAX_MACHINE_BYTES} bytes; that is no machine file");
        return Err(SweepError::value(message, ""));
    }
    Ok(MachineText {
        name: name.to_owned(),
        toml,
    })
}

/// SHA-256 of everything in folders of subroutines; nothing where there are none.
pub(crate) fn subroutines_sha256(
    reading: &serde_json::Value,
    folder: &Path,
) -> Result<Option<String>, SweepError> {
    let folders: Vec<PathBuf> = folders(reading, folder);
    let mut listing = String::new();
    for path in &folders {
        let unread = |error| SweepError::unread("folder of subroutines", path, error);
        let mut files = Vec::new();
        for entry in std::fs::read_dir(path).map_err(unread)? {
            let path = entry.map_err(unread)?.path();
            if path.is_file() {
                files.push(path);
            }
        }
        files.sort();
        for file in files {
            let unread = |error| SweepError::unread("subroutine", &file, error);
            let digest = File::open(&file).and_then(sha256).map_err(unread)?;
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            listing.push_str(&format!("{digest} {name}\n"));
        }
        listing.push('\n');
    }
    let digest = (!folders.is_empty()).then(|| sha256(listing.as_bytes()));
    digest
        .transpose()
        .map_err(|error| SweepError::unread("folders of subroutines", folder, error))
}

/// Folders of subroutines, which a sweep names from its own folder on.
fn folders(reading: &serde_json::Value, folder: &Path) -> Vec<PathBuf> {
    let named = reading.get("subroutines").and_then(|list| list.as_array());
    let named = named.into_iter().flatten().filter_map(|name| name.as_str());
    named.map(|name| folder.join(name)).collect()
}

impl Inputs {
    /// Reads the files of a manifest that cells need.
    ///
    /// # Errors
    /// A file that cannot be read, or that has changed since the plan, by the key of the first cell
    /// that needs it.
    pub fn load(header: &Header, needs: &Needs, folder: &Path) -> Result<Inputs, SweepError> {
        let mut held = 0;
        let mut programs = Vec::with_capacity(header.programs.len());
        for (input, need) in header.programs.iter().zip(&needs.programs) {
            programs.push(if need.cells > 0 {
                let program = program(input, folder, &mut held)?;
                if program.is_none() {
                    return Err(has_changed(&input.name, need));
                }
                program
            } else {
                None
            });
        }
        let mut machines = Vec::with_capacity(header.machines.len());
        for (input, need) in header.machines.iter().zip(&needs.machines) {
            // A machine that no cell here needs may be missing.
            let machine = if need.cells > 0 {
                machine_text(&input.name, folder)?
            } else {
                MachineText {
                    name: input.name.clone(),
                    toml: String::new(),
                }
            };
            machines.push(machine);
        }
        Inputs::of_parts(header.clone(), programs, machines, needs, folder)
    }

    /// The same from contents that are already at hand; `programs` has nothing where no cell needs
    /// one.
    ///
    /// # Errors
    /// A machine or a folder of subroutines that has changed since the plan; settings that cannot be
    /// used.
    pub fn of_parts(
        header: Header,
        programs: Vec<Option<Program>>,
        machines: Vec<MachineText>,
        needs: &Needs,
        folder: &Path,
    ) -> Result<Inputs, SweepError> {
        let all = header.machines.iter().zip(&machines).zip(&needs.machines);
        for ((input, machine), need) in all {
            let digest = sha256(machine.toml.as_bytes())
                .map_err(|error| SweepError::unread("machine", Path::new(&input.name), error))?;
            if digest != input.sha256 && need.cells > 0 {
                return Err(has_changed(&input.name, need));
            }
        }
        if subroutines_sha256(&header.reading, folder)? != header.subroutines {
            return Err(has_changed("a folder of subroutines", &needs.all));
        }
        let (reading, options) = requests(&header, folder)?;
        Ok(Inputs {
            header,
            programs,
            machines,
            reading,
            options,
        })
    }

    /// How programs are read.
    pub(crate) fn reading(&self) -> &ReadingRequest {
        &self.reading
    }
}

/// How the programs of a sweep are read and run.
pub(crate) fn requests(
    header: &Header,
    folder: &Path,
) -> Result<(ReadingRequest, SimulateOptions), SweepError> {
    let unfit = |error: serde_json::Error| SweepError::value(error.to_string(), "");
    let mut reading = header.reading.clone();
    if let Some(named) = reading.get_mut("subroutines") {
        *named = serde_json::json!(folders(&header.reading, folder));
    }
    let run = RunRequest::deserialize(&header.run).map_err(unfit)?;
    let mut options = run.options()?;
    // A sweep compares cells; runs with gap and friction told wrong are for those who ask.
    options.misled_share = options.misled_share.or(Some(0.0));
    options.threads = 1;
    Ok((
        ReadingRequest::deserialize(&reading).map_err(unfit)?,
        options,
    ))
}

/// A file that is not the one of the plan.
pub(crate) fn has_changed(what: &str, need: &Need) -> SweepError {
    SweepError::Changed {
        what: what.to_owned(),
        key: need.first.map(|key| key.to_string()).unwrap_or_default(),
        cells: need.cells,
    }
}

/// A program as it was planned with; `None` if it has changed. Small ones are held, so that they
/// cannot change any more.
fn program(input: &Input, folder: &Path, held: &mut usize) -> Result<Option<Program>, SweepError> {
    let path = folder.join(&input.name);
    let unread = |error| SweepError::unread("part program", &path, error);
    let length = std::fs::metadata(&path).map_err(unread)?.len();
    let room = HELD_BYTES.saturating_sub(*held) as u64;
    if length > room {
        let digest = File::open(&path).and_then(sha256).map_err(unread)?;
        let program = Program::from_path(&path);
        return Ok((digest == input.sha256).then_some(program));
    }
    let bytes = std::fs::read(&path).map_err(unread)?;
    *held += bytes.len();
    let digest = sha256(bytes.as_slice()).map_err(unread)?;
    let program = Program::from_bytes(input.name.clone(), bytes);
    Ok((digest == input.sha256).then_some(program))
}
