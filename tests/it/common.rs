//! Shared by the tests of the whole chain.
use lostmotion::sim::{Machine, Program, Run, SimError, Simulation};
use std::path::PathBuf;

/// A sample of gcode_samples/parts.
pub(crate) fn part(name: &str) -> Program {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("gcode_samples/parts")
        .join(name);
    Program::from_bytes(
        name,
        std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())),
    )
}

/// A program as text.
pub(crate) fn program(text: &str) -> Program {
    Program::from_bytes("test.ngc", text.as_bytes().to_vec())
}

/// An embedded machine.
pub(crate) fn machine(name: &str) -> Machine {
    Machine::preset(name).unwrap_or_else(|error| panic!("{error}"))
}

/// All methods on one plan with default options.
pub(crate) fn run(source: &Program, machine: &Machine, methods: &[&str]) -> Result<Run, SimError> {
    let methods: Vec<String> = methods.iter().map(ToString::to_string).collect();
    Simulation::new(source, machine).methods(&methods).run()
}
