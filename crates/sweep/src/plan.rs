//! From a sweep file to its manifest.

use crate::error::SweepError;
use crate::file::SweepFile;
use crate::inputs::{machine_text, requests, subroutines_sha256};
use crate::key::sha256;
use crate::manifest::{Cell, Coordinate, Header, Input, RELEASE, VERSION};
use lostmotion_report::WriteError;
use lostmotion_report::atomic::AtomicFile;
use lostmotion_sim::Machine;
use lostmotion_sim::machine::Change;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Where a sweep file and its manifest stand.
#[derive(Clone, Copy, Debug)]
pub struct Folders<'a> {
    /// The folder that the file's names start from.
    pub file: &'a Path,
    /// The folder that the manifest's names start from.
    pub manifest: &'a Path,
}

/// A sweep whose machines and programs have been found good; its cells are made as they are written.
#[derive(Debug)]
pub struct Plan<'a> {
    /// What its cells have in common.
    pub header: Header,
    file: &'a SweepFile,
}

/// Plans a sweep: every program on every machine at every point, in this order. `most_cells` stands
/// in place of the file's own.
///
/// # Errors
/// A pattern that no program fits, a machine that does not exist, a key or value that a machine does
/// not take, more cells than allowed.
pub fn plan<'a>(
    file: &'a SweepFile,
    folders: Folders<'_>,
    most_cells: Option<usize>,
) -> Result<Plan<'a>, SweepError> {
    let header = header(file, folders)?;
    try_machines(file, &header, folders.manifest)?;
    let points = file.design().count(file.spans(), file.points());
    let cells = [header.machines.len(), header.programs.len()]
        .iter()
        .try_fold(points, |cells, count| Some(cells?.checked_mul(*count)))
        .flatten();
    let most = most_cells.unwrap_or(file.most_cells());
    let Some(count) = cells.filter(|cells| *cells <= most) else {
        let [programs, machines] = [header.programs.len(), header.machines.len()];
        let points = points.map_or("more than any machine counts".to_owned(), |n| n.to_string());
        return Err(SweepError::value(
            format!(
                "{}: {programs} programs on {machines} machines at {points} points are more than {most} cells",
                file.name()
            ),
            "`most_cells` in the file, or --most-cells, allows more",
        ));
    };
    let header = Header {
        cells: count,
        ..header
    };
    Ok(Plan { header, file })
}

impl Plan<'_> {
    /// Writes the manifest, whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), SweepError> {
        let (header, file) = (&self.header, self.file);
        let mut out = AtomicFile::create(path)?;
        let mut line = |text: serde_json::Result<String>| {
            let text = text.map_err(std::io::Error::other);
            text.and_then(|text| writeln!(out, "{text}"))
                .map_err(|error| WriteError::io("write", path, error))
        };
        line(serde_json::to_string(header))?;
        for program in 0..header.programs.len() {
            for machine in 0..header.machines.len() {
                let stem = header.key_stem(program, machine);
                let design = file.design();
                for values in design.points(file.spans(), file.points(), file.seed()) {
                    line(serde_json::to_string(&Cell {
                        key: header.key(&stem, &values),
                        program,
                        machine,
                        values,
                    }))?;
                }
            }
        }
        out.commit()?;
        Ok(())
    }
}

fn header(file: &SweepFile, folders: Folders<'_>) -> Result<Header, SweepError> {
    let (reading, run) = file.requests();
    let mut reading = reading.clone();
    let mut machines = Vec::new();
    for name in file.machines() {
        let text = machine_text(name, folders.file)?;
        let is_preset = text.name != *name;
        let digest = sha256(text.toml.as_bytes());
        machines.push(Input {
            name: if is_preset {
                name.clone()
            } else {
                between(&folders.file.join(name), folders.manifest)?
            },
            sha256: digest
                .map_err(|error| SweepError::unread("machine", Path::new(name), error))?,
        });
    }
    // Folders, too, are named from the manifest on.
    if let Some(named) = reading
        .get_mut("subroutines")
        .and_then(|list| list.as_array_mut())
    {
        for name in named {
            let path = folders.file.join(name.as_str().unwrap_or_default());
            *name = between(&path, folders.manifest)?.into();
        }
    }
    let mut programs = Vec::new();
    for path in programs_of(file, folders.file)? {
        let unread = |error| SweepError::unread("part program", &path, error);
        let digest = File::open(&path).and_then(sha256).map_err(unread)?;
        programs.push(Input {
            name: between(&path, folders.manifest)?,
            sha256: digest,
        });
    }
    Ok(Header {
        sweep: VERSION,
        lostmotion: RELEASE.to_owned(),
        file: file.name().to_owned(),
        cells: 0,
        methods: file.methods().to_vec(),
        vary: file
            .coordinates()
            .map(|(name, keys)| Coordinate {
                name: name.to_owned(),
                keys: keys.iter().map(|key| key.trim().to_owned()).collect(),
            })
            .collect(),
        subroutines: subroutines_sha256(&reading, folders.manifest)?,
        reading,
        run: run.clone(),
        machines,
        programs,
    })
}

/// The files that the patterns of a sweep fit, each once, in the order of the patterns and of their
/// names.
fn programs_of(file: &SweepFile, folder: &Path) -> Result<Vec<PathBuf>, SweepError> {
    let mut seen = BTreeSet::new();
    let mut programs = Vec::new();
    for pattern in file.programs() {
        let refused = |why: String, hint: &str| SweepError::File {
            file: file.name().to_owned(),
            message: format!("`programs`: {why}"),
            hint: hint.to_owned(),
        };
        // An absolute pattern stands for itself; others start from the file's folder, whose own
        // name is no pattern.
        let whole = if Path::new(pattern).is_absolute() {
            pattern.clone()
        } else {
            let folder = glob::Pattern::escape(&folder.to_string_lossy());
            format!("{folder}/{pattern}")
        };
        let found = glob::glob(&whole)
            .map_err(|error| refused(format!("\"{pattern}\" is no pattern: {error}"), ""))?;
        let mut fits = 0;
        for path in found {
            let path = path.map_err(|error| {
                SweepError::unread(
                    "folder",
                    error.path(),
                    std::io::Error::other(error.error().to_string()),
                )
            })?;
            if path.is_file() {
                fits += 1;
                if seen.insert(path.clone()) {
                    programs.push(path);
                }
            }
        }
        if fits == 0 {
            return Err(refused(
                format!("\"{pattern}\" fits no file in {}", folder.display()),
                "patterns start from the folder of the sweep file; * stands for any name, ** for any folders",
            ));
        }
    }
    Ok(programs)
}

/// Tries each machine with the values that are known beforehand, one coordinate after the other: a
/// key that is misspelt is told before anything runs.
fn try_machines(file: &SweepFile, header: &Header, folder: &Path) -> Result<(), SweepError> {
    for input in &header.machines {
        let text = machine_text(&input.name, folder)?;
        let machine = Machine::from_toml(&text.name, &text.toml)?;
        // How programs are read and run may depend on the machine.
        let (reading, options) = requests(header, folder)?;
        reading.options(&machine, options)?;
        for (coordinate, span) in header.vary.iter().zip(file.spans()) {
            for level in span.tried() {
                let value = level.to_string();
                let changes: Vec<Change> = coordinate
                    .keys
                    .iter()
                    .map(|key| Change {
                        key: key.clone(),
                        value: value.clone(),
                        name: format!("[[vary]] {key} = {value}"),
                    })
                    .collect();
                Machine::from_changed_toml(&text.name, &text.toml, &changes)?;
            }
        }
    }
    Ok(())
}

/// A path as it is named from a folder on, with `/` between its parts.
fn between(path: &Path, folder: &Path) -> Result<String, SweepError> {
    let whole = |path: &Path| {
        let there = if path.as_os_str().is_empty() {
            Path::new(".")
        } else {
            path
        };
        there
            .canonicalize()
            .map_err(|error| SweepError::unread("path", path, error))
    };
    let (path, folder) = (whole(path)?, whole(folder)?);
    let (to, from): (Vec<_>, Vec<_>) = (path.components().collect(), folder.components().collect());
    let common = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let up = from.iter().skip(common).map(|_| "..");
    let down = to.iter().skip(common).map(|part| part.as_os_str().to_str());
    let parts: Option<Vec<&str>> = up.map(Some).chain(down).collect();
    let parts = parts.ok_or_else(|| {
        let message = format!("the name {} is not UTF-8", path.display());
        SweepError::value(message, "a manifest is text: rename the file")
    })?;
    Ok(parts.join("/"))
}
