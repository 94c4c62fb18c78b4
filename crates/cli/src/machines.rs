//! Machines and axes by name or file.

use crate::failure::Failure;
use crate::input;
use lostmotion::base::AxisId;
use lostmotion::methods::AxisConfig;
use lostmotion::sim::Machine;
use lostmotion::sim::machine::{
    AxisTuning, DEFAULT_MACHINE, MachineError, axis_from_toml, axis_preset, axis_presets, presets,
};
use std::path::Path;

/// Whether an argument means a file rather than a name.
fn is_file(name: &str) -> bool {
    name.ends_with(".toml") || name.contains(['/', '\\'])
}

/// The names of the machines there are.
fn known() -> String {
    presets()
        .iter()
        .map(|preset| preset.name)
        .collect::<Vec<_>>()
        .join(", ")
}

/// The machine asked for, or the default one.
pub(crate) fn load(name: Option<&str>) -> Result<Machine, Failure> {
    let name = name.unwrap_or(DEFAULT_MACHINE);
    if is_file(name) {
        return read(Path::new(name));
    }
    Machine::preset(name).map_err(|_| {
        let hint = format!(
            "known machines: {}; a machine file's name has to end in .toml",
            known()
        );
        Failure::with_hint(format!("there is no machine \"{name}\""), hint)
    })
}

/// The machine of a file.
pub(crate) fn read(path: &Path) -> Result<Machine, Failure> {
    let text = input::text(path, "machine file")?;
    Machine::from_toml(&path.display().to_string(), &text).map_err(|error| failure(&error))
}

/// The machine of a file or a name, with its tuning; refused if that is not good enough.
pub(crate) fn check(path: &Path) -> Result<(Machine, Vec<AxisTuning>), Failure> {
    let embedded = presets()
        .iter()
        .find(|preset| Path::new(preset.name) == path);
    let text = embedded.map_or_else(
        || input::text(path, "machine file"),
        |preset| Ok(preset.toml.to_owned()),
    )?;
    Machine::check_toml(&path.display().to_string(), &text).map_err(|error| failure(&error))
}

fn failure(error: &MachineError) -> Failure {
    let count = error.problems.len();
    Failure::Rendered(format!(
        "{error}\n{count} error{}",
        if count == 1 { "" } else { "s" }
    ))
}

/// The axis of a preset (`paper`, `vmc3:x`), of a machine file (`FILE.toml:x`), or of a file with
/// the tables of one axis.
pub(crate) fn axis(name: &str) -> Result<AxisConfig, Failure> {
    if let Some(axis) = axis_preset(name) {
        return Ok(axis);
    }
    if let Some((file, letter)) = name.rsplit_once(".toml:") {
        let machine = read(Path::new(&format!("{file}.toml")))?;
        return machine.drive(letter).cloned().ok_or_else(|| {
            Failure::with_hint(
                format!("{file}.toml has no axis \"{letter}\""),
                format!("its axes: {}", machine.drives().join(", ")),
            )
        });
    }
    if is_file(name) {
        let text = input::text(Path::new(name), "axis file")?;
        return axis_from_toml(name, &text).map_err(|error| failure(&error));
    }
    let hint = format!(
        "known axes: {}; an axis of a machine file: FILE.toml:x",
        axis_presets().join(", ")
    );
    Err(Failure::with_hint(
        format!("there is no axis \"{name}\""),
        hint,
    ))
}

fn letter_of(text: &str) -> Option<AxisId> {
    let mut letters = text.chars();
    match (letters.next(), letters.next()) {
        (Some(letter), None) => AxisId::from_letter(letter),
        _ => None,
    }
}

/// The machine whose compensators that may know the gap were told those of fits, and those that may
/// know the load what a fit found of it, each given as `AXIS=FILE.json`; `y2` is the second motor
/// of a gantry's Y.
pub(crate) fn with_fits(mut machine: Machine, fits: &[String]) -> Result<Machine, Failure> {
    for fit in fits {
        let (name, file) = fit.split_once('=').ok_or_else(|| {
            Failure::with_hint(
                format!("--fitted {fit} is not of the form AXIS=FILE.json"),
                "for example: --fitted x=x-axis.json",
            )
        })?;
        let drive = machine.drive(name).ok_or_else(|| {
            let hint = format!("its axes: {}", machine.drives().join(", "));
            Failure::with_hint(
                format!(
                    "--fitted {fit}: machine \"{}\" has no axis {}",
                    machine.name(),
                    name.to_ascii_uppercase()
                ),
                hint,
            )
        })?;
        let told = crate::commands::fit::with_fit(Path::new(file), drive)?;
        machine = match letter_of(name) {
            Some(id) => machine.with_axis_config(id, &told),
            None => machine.with_second_config(&told),
        };
    }
    Ok(machine)
}
