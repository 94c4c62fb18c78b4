//! Cutter compensation: the tool keeps its radius to the left (G41) or right (G42) of the
//! programmed path.
//!
//! Each move is held back until the next one is known, because an inside corner shortens it: the
//! tool turns where the two offset paths cross. At an outside corner the tool rolls about the
//! corner. A move that the tool would have to make backwards is a gouge, and an error.
//! `State::current` stays the programmed place; only what is emitted is offset.

use super::Exec;
use crate::codes::{Code, whole};
use crate::exec::words::whole_within;
use crate::ops::{Plane, SourcedOp};
use crate::problem::Problem;
use crate::state::{Compensation, HeldOp};
use lostmotion_base::vec::Vec2;

mod geometry;
mod path;
mod stray;

/// Operations that may wait for the end of a move.
const MOST_HELD: usize = 100_000;

/// G40: the held operations are emitted as they are.
pub(crate) fn off(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    exec.end_compensation()
}

/// G41 and G42: the radius of tool D, or of the one in the spindle.
pub(crate) fn on(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    // Without a table every tool is accepted, with radius zero.
    let number = exec.named_tool(code, b'D')?;
    exec.check_tool(number)?;
    let tool = exec
        .tools
        .as_ref()
        .and_then(|table| table.get(number))
        .copied()
        .unwrap_or_default();
    // D0 is no tool: radius 0 is what it asks for. A tool without a diameter is not known well.
    if number != 0 && tool.diameter == 0.0 {
        exec.warnings.push(Problem::NoToolRadius { tool: number });
    }
    let diameter = exec
        .config
        .machine_units
        .convert(tool.diameter, exec.state.units);
    exec.begin_compensation(code, diameter, tool.orientation.clamp(0, 9) as u8)
}

/// G41.1 and G42.1: D is the diameter, L the orientation of a lathe tool.
pub(crate) fn dynamic(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let diameter = exec.need(b'D', code, "D, the tool's diameter")?;
    let value = exec.word(b'L').unwrap_or(0.0);
    let orientation = whole_within((code, b'L'), value, 0.0..=9.0, "an orientation from 0 to 9")?;
    if orientation != 0.0 && exec.state.plane != Plane::Zx {
        return Err(Problem::Compensation {
            message: "the orientation of a lathe tool (L) needs the ZX plane (G18)",
        });
    }
    exec.begin_compensation(code, diameter, orientation as u8)
}

impl Exec<'_> {
    fn begin_compensation(
        &mut self,
        code: Code,
        diameter: f64,
        orientation: u8,
    ) -> Result<(), Problem> {
        // The radius and the side cannot change while a move is held that was offset by the old
        // ones.
        if self.state.compensation.is_some() {
            return Err(Problem::Compensation {
                message: "cutter compensation is already on: G40 comes first",
            });
        }
        if self.state.plane == Plane::Yz {
            return Err(Problem::Compensation {
                message: "cutter compensation needs the XY or ZX plane (G17 or G18)",
            });
        }
        // Signed radius: positive to the left of the path (G41), negative to the right (G42).
        let left = if code.tenths < 420 {
            0.5 * diameter
        } else {
            -0.5 * diameter
        };
        let compensation = Compensation {
            left,
            orientation,
            last: None,
            fixed: false,
            held: Vec::new(),
            strayed: None,
        };
        self.state.compensation = Some(Box::new(compensation));
        Ok(())
    }

    /// Refuses codes that would move the path away under the compensation; before a stop, emits the
    /// operations that are held.
    #[cold]
    pub(crate) fn under_compensation(&mut self, code: Code) -> Result<(), Problem> {
        let message = match (code.letter, code.tenths) {
            // At a stop the operator sees the tool where the held move ends, so that its end
            // becomes final.
            ('M', 0 | 10 | 600) => {
                if let Some(compensation) = &mut self.state.compensation {
                    let result = compensation.release(self.state.plane, None, self.out);
                    compensation.fixed = true;
                    return result;
                }
                return Ok(());
            }
            ('G', 280 | 281 | 300 | 301) => "G28 and G30 cannot be used under cutter compensation",
            ('G', 382..=385) => "probing is not possible under cutter compensation",
            ('G', 710..=722) => "roughing cycles cannot be used under cutter compensation",
            ('G', 330 | 331 | 530 | 730..=760 | 810..=890) => {
                "cycles, G33 and G53 cannot be used under cutter compensation"
            }
            ('G', 531 | 680..=690) => "the coordinates cannot turn under cutter compensation",
            ('G', 430..=490) => "the tool offset cannot change under cutter compensation",
            ('G', 520 | 540..=593 | 920 | 1540) => {
                "the coordinate system cannot change under cutter compensation"
            }
            ('G', 610..=640) => "path control cannot change under cutter compensation",
            ('M', 60 | 610) => "the tool cannot change under cutter compensation",
            ('M', 620..=680) => "inputs and outputs cannot be used under cutter compensation",
            ('G', 100) if self.changes_system_in_force() => {
                "the coordinate system cannot change under cutter compensation"
            }
            _ => return Ok(()),
        };
        Err(Problem::Compensation { message })
    }

    /// Whether a G10 L2 or L20 is about the system in force.
    fn changes_system_in_force(&self) -> bool {
        let named = self.word(b'P').and_then(whole);
        let selector = self.word(b'L').and_then(whole);
        // L20 of Fanuc and Haas counts the systems beyond G59.3, which are 10 and on.
        let from = match selector {
            Some(20.0) if self.config.dialect.is_fanuc() => 9.0,
            _ => 0.0,
        };
        let number = named.map(|number| number + from);
        let is_current = number == Some(0.0) || number == Some(f64::from(self.state.system));
        is_current && matches!(selector, Some(2.0 | 20.0))
    }

    /// Emits the held operations and turns the compensation off.
    pub(crate) fn end_compensation(&mut self) -> Result<(), Problem> {
        let Some(mut compensation) = self.state.compensation.take() else {
            return Ok(());
        };
        // The next move leads from the offset place back to the path.
        let moved = compensation.last.is_some();
        let result = compensation.release(self.state.plane, None, self.out);
        self.state.arc_not_allowed = moved;
        result
    }

    /// Adds an operation to what waits for the held move; true if there is one.
    #[cold]
    pub(crate) fn hold(&mut self, sourced: SourcedOp) {
        match &mut self.state.compensation {
            Some(compensation)
                if compensation.last.is_some() && compensation.held.len() < MOST_HELD =>
            {
                compensation.held.push(HeldOp {
                    sourced,
                    follows: false,
                });
            }
            Some(compensation) if compensation.last.is_some() => {
                // Beyond the bound the held move is emitted with its plain end: memory stays
                // bounded.
                let message = "too much happens between two moves under cutter compensation";
                self.warnings.push(Problem::Compensation { message });
                self.out
                    .extend(compensation.held.drain(..).map(|held| held.sourced));
                compensation.fixed = true;
                self.out.push(sourced);
            }
            _ => self.out.push(sourced),
        }
    }
}

impl Compensation {
    /// Fixes the end of the held move, if the corner moves it, and emits everything that is held.
    fn release(
        &mut self,
        plane: Plane,
        end: Option<Vec2>,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), Problem> {
        // A move that the corner shortens to less than nothing is a gouge.
        let result = match (&self.last, end) {
            (Some(edge), end) if !self.fixed && (end.is_some() || !edge.astray) => {
                edge.check(end.unwrap_or(edge.end), self.left.abs())
            }
            _ => Ok(()),
        };
        let shift = self.nose(plane);
        // The move itself, and moves across the plane that share its end, get the final end.
        for (index, mut held) in self.held.drain(..).enumerate() {
            if let Some(end) = end.filter(|_| index == 0 || held.follows) {
                path::set_end(
                    &mut held.sourced.op,
                    plane,
                    [end[0] + shift[0], end[1] + shift[1]],
                );
            }
            out.push(held.sourced);
        }
        result
    }

    /// From the centre of a lathe tool's nose to the point that the program controls.
    fn nose(&self, plane: Plane) -> Vec2 {
        if plane != Plane::Zx {
            return [0.0; 2];
        }
        let radius = self.left.abs();
        // Orientations 1 to 9 as in LinuxCNC's tool table: which corner of the nose is controlled.
        let z = match self.orientation {
            2 | 7 | 3 => -radius,
            1 | 5 | 4 => radius,
            _ => 0.0,
        };
        let x = match self.orientation {
            2 | 6 | 1 => -radius,
            3 | 8 | 4 => radius,
            _ => 0.0,
        };
        [z, x]
    }
}
