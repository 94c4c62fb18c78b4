//! What is in force before the first line: parameters, work system, offsets and position.

use crate::config::InterpreterConfig;
use crate::dialect::Leniency;
use crate::exec::registers::origin;
use crate::ops::{Position, Units};
use crate::parameters::{
    G92, G92_ACTIVE, HIGHEST, MACRO_LOCALS, Parameters, SYSTEM, system_parameter,
};
use crate::state::{State, convert};
use lostmotion_base::units::deg;

/// The parameters that the control has stored, and those that it was told.
pub(super) fn parameters(config: &InterpreterConfig) -> Parameters {
    let mut parameters = Parameters::new(config.limits.named_parameters);
    parameters.vacants = config.leniencies.has(Leniency::Vacant);
    if config.dialect.is_fanuc() || config.leniencies.has(Leniency::ExtraSystems) {
        parameters.add_control_variables();
    }
    if config.dialect.is_fanuc() {
        parameters.locals = MACRO_LOCALS;
    }
    for &(number, value) in &config.parameters {
        if number <= HIGHEST && value.is_finite() {
            parameters.put(number, value);
        }
    }
    for (name, value) in &config.told {
        match name.parse::<u16>() {
            Ok(number) => parameters.put(number, *value),
            Err(_) => parameters.put_told(name.as_bytes(), *value),
        }
    }
    parameters
}

/// The modes at power-on, with the work system and the offsets of the stored parameters.
pub(super) fn state(config: &InterpreterConfig, parameters: &Parameters) -> State {
    let mut state = State::new(config.program_units);
    // The power-on state of these controls is G98, that of LinuxCNC G99.
    state.retract_to_start = config.dialect.is_fanuc();
    let system = parameters.get(SYSTEM);
    state.system = if (1.0..=9.0).contains(&system) {
        system as u16
    } else {
        1
    };
    // Offsets in force at the start, as the control's memory has them.
    let unit = |position| convert(&position, config.machine_units, config.program_units);
    let rotation = system_parameter(state.system) + 9;
    state.offsets.g5x = unit(origin(parameters, config, state.system));
    state.offsets.rotation_deg = parameters.get(rotation);
    if parameters.get(G92_ACTIVE) != 0.0 {
        state.offsets.g92 = unit(parameters.position(G92));
    }
    // The machine's place is given; the program coordinates follow from the offsets.
    let start = convert(&machine_place(config), Units::Mm, config.program_units);
    state.current = state.offsets.to_program(&start);
    state
}

/// Where the machine stands, mm and degrees: the configuration is in mm and rad, the interpreter in program
/// units and degrees.
fn machine_place(config: &InterpreterConfig) -> Position {
    std::array::from_fn(|axis| {
        let place = config.start.0[axis];
        if (3..6).contains(&axis) {
            deg(place)
        } else {
            place
        }
    })
}
