//! Tool tables in LinuxCNC's format: `T1 P1 Z5.25 D1.0 ;comment`, one tool per line.

use crate::problem::Problem;
use std::collections::BTreeMap;

/// One tool. Lengths in machine units, angles in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tool {
    /// Number that T and H name.
    pub number: i32,
    /// Pocket it lies in.
    pub pocket: i32,
    /// Offset in X Y Z A B C U V W.
    pub offset: [f64; 9],
    /// Diameter.
    pub diameter: f64,
    /// Angle of a lathe tool's front edge.
    pub front_angle: f64,
    /// Angle of a lathe tool's back edge.
    pub back_angle: f64,
    /// Orientation of a lathe tool, 0 to 9.
    pub orientation: i32,
}

/// The tools of a machine by number.
///
/// ```
/// use lostmotion_gcode::ToolTable;
///
/// let table = ToolTable::parse("T1 P1 Z50.5 D6 ; end mill\n")?;
/// assert_eq!(table.get(1).map(|tool| (tool.offset[2], tool.diameter)), Some((50.5, 6.0)));
/// assert_eq!(
///     ToolTable::parse("T1 Zlong").unwrap_err().to_string().split(':').next(),
///     Some("tool table, line 1")
/// );
/// # Ok::<(), lostmotion_gcode::Problem>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolTable {
    tools: BTreeMap<i32, Tool>,
    /// Numbers whose geometry and wear a program has told apart; the tool has their sums.
    memories: BTreeMap<i32, [f64; 4]>,
}

/// A cell of a control's tool memory: what memory C of Fanuc keeps of a number, lengths in machine
/// units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MemoryCell {
    /// Geometry of the length (H).
    Length,
    /// What its wear adds.
    LengthWear,
    /// Geometry of the diameter (D).
    Diameter,
    /// What its wear adds.
    DiameterWear,
}

impl ToolTable {
    /// Reads a table. Blank lines and comments after `;` are skipped; a later line replaces an
    /// earlier one of the same number.
    ///
    /// # Errors
    /// The first word that is not understood, with its line.
    pub fn parse(text: &str) -> Result<ToolTable, Problem> {
        let mut table = ToolTable::default();
        for (index, line) in text.lines().enumerate() {
            // Comments run from the semicolon to the end of the line.
            let content = line.split(';').next().unwrap_or_default();
            if content.trim().is_empty() {
                continue;
            }
            let tool = parse_tool(content).map_err(|message| Problem::ToolTable {
                line: index as u32 + 1,
                message,
            })?;
            table.insert(tool);
        }
        Ok(table)
    }

    /// Adds or replaces a tool.
    pub fn insert(&mut self, tool: Tool) {
        self.memories.remove(&tool.number);
        self.tools.insert(tool.number, tool);
    }

    /// The four cells of a number in the order of [`MemoryCell`]; a tool of the table has no wear
    /// of its own.
    fn cells(&self, number: i32) -> Option<[f64; 4]> {
        let from_tool = |tool: &Tool| [tool.offset[2], 0.0, tool.diameter, 0.0];
        let told = self.memories.get(&number).copied();
        told.or_else(|| self.tools.get(&number).map(from_tool))
    }

    /// What a cell holds; `None` if there is no tool of that number.
    pub(crate) fn memory(&self, number: i32, cell: MemoryCell) -> Option<f64> {
        self.cells(number)
            .and_then(|cells| cells.get(cell as usize).copied())
    }

    /// Puts a value into a cell, and the sums of geometry and wear into the tool.
    pub(crate) fn set_memory(&mut self, number: i32, cell: MemoryCell, value: f64) {
        let mut cells = self.cells(number).unwrap_or_default();
        if let Some(slot) = cells.get_mut(cell as usize) {
            *slot = value;
        }
        let [length, length_wear, diameter, diameter_wear] = cells;
        let mut tool = self.get(number).copied().unwrap_or(Tool {
            number,
            ..Tool::default()
        });
        tool.offset[2] = length + length_wear;
        tool.diameter = diameter + diameter_wear;
        self.insert(tool);
        self.memories.insert(number, cells);
    }

    /// The tool of a number.
    pub fn get(&self, number: i32) -> Option<&Tool> {
        self.tools.get(&number)
    }

    /// All tools in the order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = &Tool> {
        self.tools.values()
    }
}

fn parse_tool(content: &str) -> Result<Tool, String> {
    let mut tool = Tool::default();
    let mut numbered = false;
    for word in content.split_whitespace() {
        let mut letters = word.chars();
        let letter = letters.next().unwrap_or(' ').to_ascii_uppercase();
        let number = letters.as_str();
        let value: f64 = number
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
            .ok_or_else(|| format!("{word} is not a letter with a number"))?;
        // Numbers and orientations count things: fractions are mistakes.
        let whole = || {
            if value.fract() == 0.0 && value.abs() < 1e9 {
                Ok(value as i32)
            } else {
                Err(format!("{word} is not a whole number"))
            }
        };
        match letter {
            'T' => {
                tool.number = whole()?;
                numbered = true;
            }
            'P' => tool.pocket = whole()?,
            'D' => tool.diameter = value,
            'I' => tool.front_angle = value,
            'J' => tool.back_angle = value,
            'Q' => tool.orientation = whole()?,
            // All other letters are axes of the offset.
            _ => match "XYZABCUVW"
                .find(letter)
                .and_then(|index| tool.offset.get_mut(index))
            {
                Some(offset) => *offset = value,
                None => return Err(format!("{word} is not a word of a tool table")),
            },
        }
    }
    if numbered {
        Ok(tool)
    } else {
        Err("a tool without its number T".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_tools() {
        let table = ToolTable::parse(
            "T1 P1 Z5.25 D1.0 ;drill\n\n;only a comment\nt12 p3 x-1 z+2.5 i95 j155 q2\n",
        )
        .unwrap();
        assert_eq!(
            table.get(1).map(|tool| (tool.offset[2], tool.diameter)),
            Some((5.25, 1.0))
        );
        assert_eq!(
            table
                .get(12)
                .map(|tool| (tool.pocket, tool.offset[0], tool.orientation)),
            Some((3, -1.0, 2))
        );
        assert_eq!(table.iter().count(), 2);
    }

    #[test]
    fn a_bad_line_is_named() {
        let problem = ToolTable::parse("T1 Z1\nT2 Zx\n").unwrap_err();
        assert_eq!(
            problem,
            Problem::ToolTable {
                line: 2,
                message: "Zx is not a letter with a number".to_owned()
            }
        );
        assert!(ToolTable::parse("P1 Z2").is_err());
        assert!(ToolTable::parse("T1 ZNaN").is_err());
    }
}
