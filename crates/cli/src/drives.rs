//! Machines and axes whose drives are commanded in another way than their files say.

use crate::args::drives::{Cycles as Given, Drives};
use crate::failure::Failure;
use lostmotion::base::AxisId;
use lostmotion::drive::config::{Cycles, Interpolator};
use lostmotion::methods::AxisConfig;
use lostmotion::sim::Machine;

/// The cycles asked for, the others as they are.
///
/// # Errors
/// Cycles that do not go together.
pub(crate) fn cycles(given: Given, own: Cycles) -> Result<Cycles, Failure> {
    let cycles = Cycles {
        command_ms: given.command_ms.unwrap_or(own.command_ms),
        servo_us: given.servo_us.unwrap_or(own.servo_us),
    };
    cycles.check().map_err(|error| {
        Failure::with_hint(
            error.to_string(),
            "--command-ms and --servo-us set them; one has to divide the other",
        )
    })?;
    Ok(cycles)
}

/// The interpolator of a name.
///
/// # Errors
/// A name that there is not.
pub(crate) fn interpolator(name: &str) -> Result<Interpolator, Failure> {
    Interpolator::from_name(name).ok_or_else(|| {
        let known: Vec<&str> = Interpolator::ALL
            .into_iter()
            .map(Interpolator::name)
            .collect();
        Failure::with_hint(
            format!("there is no interpolator \"{name}\""),
            format!("known interpolators: {}", known.join(", ")),
        )
    })
}

/// The machine with the cycles and interpolators asked for.
///
/// # Errors
/// What does not exist or does not go together, named with its axis.
pub(crate) fn with_drives(machine: &Machine, drives: &Drives) -> Result<Machine, Failure> {
    let mut machine = machine.with_cycles(cycles(drives.cycles, machine.cycles())?);
    for word in &drives.interpolator {
        let Some((letter, name)) = word.split_once('=') else {
            let interpolator = interpolator(word)?;
            machine = machine.map_axes(|axis| AxisConfig {
                interpolator,
                ..axis.clone()
            });
            continue;
        };
        let found = letter
            .chars()
            .next()
            .and_then(AxisId::from_letter)
            .filter(|_| letter.len() == 1);
        let axis = found.and_then(|id| machine.axis(id)).ok_or_else(|| {
            Failure::with_hint(
                format!(
                    "--interpolator {word}: machine \"{}\" has no axis \"{letter}\"",
                    machine.name()
                ),
                "for example: --interpolator linear --interpolator x=quintic-hermite",
            )
        })?;
        let (id, config) = (
            axis.id,
            AxisConfig {
                interpolator: interpolator(name)?,
                ..axis.config.clone()
            },
        );
        machine = machine.with_axis_config(id, &config);
    }
    for axis in machine.axes() {
        axis.config
            .check()
            .map_err(|error| Failure::message(format!("axis {}: {error}", axis.id)))?;
    }
    Ok(machine)
}
