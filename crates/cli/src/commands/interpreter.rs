//! The front end alone, for commands that need no machine.

use crate::args::part::Setup;
use crate::failure::Failure;
use crate::{input, machines};
use lostmotion::gcode::{InterpreterConfig, ToolTable};
use lostmotion::sim::{Machine, Program, SimulateOptions};
use std::path::Path;

/// A program that is read by the interpreter.
pub(crate) type Reading = lostmotion::sim::program::Operations;

/// Opens a program.
pub(crate) fn open(source: &Program, config: InterpreterConfig) -> Result<Reading, Failure> {
    source
        .operations(config)
        .map_err(|error| Failure::message(format!("cannot read {}: {error}", source.name())))
}

/// The tool table of a file.
pub(crate) fn tools(path: &Path) -> Result<ToolTable, Failure> {
    let text = input::text(path, "tool table")?;
    ToolTable::parse(&text)
        .map_err(|problem| Failure::message(format!("{}: {problem}", path.display())))
}

/// Settings of the interpreter with what was asked for: those of the machine, if one is named.
pub(crate) fn config(setup: &Setup) -> Result<(InterpreterConfig, Option<Machine>), Failure> {
    let machine = setup
        .machine
        .as_deref()
        .map(|name| machines::load(Some(name)))
        .transpose()?;
    let mut config = match &machine {
        Some(machine) => lostmotion::sim::interpreter_config(machine, &SimulateOptions::default()),
        None => InterpreterConfig::default(),
    };
    if let Some(path) = &setup.tool_table {
        config.tool_table = Some(tools(path)?);
    }
    Ok((setup.reading.config(config)?, machine))
}
