//! G28, G30 and the storing of their places.

use super::Exec;
use crate::code::Code;
use crate::ops::CanonicalOp;
use crate::parameters::HOME;
use crate::problem::Problem;
use crate::state::convert;

/// Distance between the homes of G28 and G30.
const SECOND: u16 = 20;

const fn first_parameter(code: Code) -> u16 {
    if code.tenths >= 300 {
        HOME + SECOND
    } else {
        HOME
    }
}

/// Through the programmed point, then to the home of the named axes; of all, if none is named.
pub(crate) fn go(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let by_way = exec.target()?;
    exec.emit(CanonicalOp::StraightTraverse(by_way));
    exec.state.current = by_way;
    let home = convert(
        &exec.parameters.position(first_parameter(code)),
        exec.config.machine_units,
        exec.state.units,
    );
    let named = |axis: usize| exec.axis_word(axis).is_some();
    let all = !(0..9).any(named);
    let mut end = exec.state.machine();
    for axis in 0..9 {
        if all || named(axis) {
            end[axis] = home[axis];
        }
    }
    let end = exec.state.offsets.to_program(&end);
    exec.check_target(&end)?;
    exec.emit(CanonicalOp::StraightTraverse(end));
    exec.state.current = end;
    Ok(())
}

/// G28.1 and G30.1.
pub(crate) fn store(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let here = convert(
        &exec.state.machine(),
        exec.state.units,
        exec.config.machine_units,
    );
    exec.parameters.put_position(first_parameter(code), &here);
    Ok(())
}
