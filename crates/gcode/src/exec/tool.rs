//! T, M6, M61 and tool offsets.

use super::Exec;
use crate::codes::{Code, whole};
use crate::dialect::Dialect;
use crate::exec::words::whole_within;
use crate::ops::{CanonicalOp, Position};
use crate::problem::Problem;
use crate::state::convert;

impl Exec<'_> {
    /// T.
    pub(crate) fn select_tool(&mut self, tool: i32) -> Result<(), Problem> {
        self.check_tool(tool)?;
        self.state.selected_tool = Some(tool);
        self.emit(CanonicalOp::SelectTool(tool));
        Ok(())
    }

    /// Refuses tools that the table does not have; 0 is no tool.
    pub(crate) fn check_tool(&mut self, tool: i32) -> Result<(), Problem> {
        match &*self.tools {
            Some(table) if tool != 0 && table.get(tool).is_none() => Err(Problem::NoSuchTool {
                tool: i64::from(tool),
            }),
            _ => Ok(()),
        }
    }

    /// The offset of a tool in program units.
    fn tool_offset(&mut self, tool: i32) -> Result<Position, Problem> {
        self.check_tool(tool)?;
        if self.tools.is_none() && tool != 0 {
            self.warnings.push(Problem::NoToolTable { tool });
        }
        let entry = self.tools.as_ref().and_then(|table| table.get(tool));
        Ok(entry.map_or([0.0; 9], |tool| {
            convert(&tool.offset, self.config.machine_units, self.state.units)
        }))
    }

    pub(crate) fn apply_tool_offset(&mut self, offset: Position) -> Result<(), Problem> {
        self.check_target(&offset)?;
        self.state.rebase(|offsets| offsets.tool = offset);
        self.emit(CanonicalOp::UseToolLengthOffset(offset));
        Ok(())
    }

    /// The tool that H or D names; without it the one in the spindle. For LinuxCNC, 0 is the
    /// spindle's, too; for other controls it is no tool.
    pub(crate) fn named_tool(&self, code: Code, letter: u8) -> Result<i32, Problem> {
        let Some(value) = self.word(letter) else {
            return Ok(self.state.loaded_tool);
        };
        match whole(value).filter(|number| (0.0..1e9).contains(number)) {
            Some(0.0) if self.config.dialect == Dialect::LinuxCnc => Ok(self.state.loaded_tool),
            Some(number) => Ok(number as i32),
            None => Err(Problem::WordOutOfRange {
                code,
                letter: char::from(letter),
                value,
                allowed: "a tool number",
            }),
        }
    }
}

/// M6: the spindle stops and the selected tool comes; its length does not apply yet.
pub(crate) fn change(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    let tool = exec.state.selected_tool.ok_or(Problem::NoToolSelected)?;
    // As in LinuxCNC: change begins, spindle stops, tool comes.
    exec.emit(CanonicalOp::StartChange);
    exec.emit(CanonicalOp::StopSpindle { spindle: 0 });
    exec.state.spindle.clockwise = None;
    exec.state.loaded_tool = tool;
    exec.emit(CanonicalOp::ChangeTool(tool));
    Ok(())
}

/// M61 Q.
pub(crate) fn set_number(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let value = exec.need(b'Q', code, "Q, the tool's number")?;
    let tool = whole_within((code, b'Q'), value, 0.0..1e9, "a tool number")? as i32;
    exec.check_tool(tool)?;
    exec.state.loaded_tool = tool;
    exec.state.selected_tool = Some(tool);
    exec.emit(CanonicalOp::ChangeToolNumber(tool));
    Ok(())
}

/// G43.
pub(crate) fn length(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let tool = exec.named_tool(code, b'H')?;
    let offset = exec.tool_offset(tool)?;
    exec.apply_tool_offset(offset)
}

/// G44 of Fanuc and Haas: the offset is subtracted (B-63944EN, "Tool Length Offset": G43 adds the
/// value of the memory to the end point, G44 subtracts it).
pub(crate) fn negative_length(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let tool = exec.named_tool(code, b'H')?;
    let offset = exec.tool_offset(tool)?;
    // 0 - x, not -x: the offset of an axis without one stays 0.
    exec.apply_tool_offset(offset.map(|value| 0.0 - value))
}

/// G43.1: axes that are not named keep their offset.
pub(crate) fn dynamic_length(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    // The offset in force is the base: axes that are not named keep theirs.
    let mut offset = exec.state.offsets.tool;
    for (axis, slot) in offset.iter_mut().enumerate() {
        *slot = exec.axis_word(axis).unwrap_or(*slot);
    }
    exec.apply_tool_offset(offset)
}

/// G43.2: adds the offset of H, or that of the axis words, to the one in force.
pub(crate) fn added_length(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let named = exec.word(b'H').is_some();
    if !named && (0..9).all(|axis| exec.axis_word(axis).is_none()) {
        return Err(Problem::WordMissing {
            code,
            what: "H or an axis word",
        });
    }
    let mut offset = exec.state.offsets.tool;
    let more = if named {
        exec.named_tool(code, b'H')
            .and_then(|tool| exec.tool_offset(tool))?
    } else {
        [0.0; 9]
    };
    for axis in 0..9 {
        offset[axis] += if named {
            more[axis]
        } else {
            exec.axis_word(axis).unwrap_or(0.0)
        };
    }
    exec.apply_tool_offset(offset)
}

/// G49: no tool offset.
pub(crate) fn no_length(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.end_tip_control();
    exec.apply_tool_offset([0.0; 9])
}
