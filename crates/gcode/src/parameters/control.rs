//! System variables of Fanuc and Haas: what the numbers from #1000 on stand for.
//!
//! Fanuc: B-63944EN (Series 30i), "System Variables"; Haas: the mill operator's manual, "System
//! Variables". Both read the modes of the block before (#4001 to #4130), and positions: #5001 the
//! end of the last block in the work coordinate system without the tool's offset, #5021 the machine
//! coordinates, #5041 the work coordinates with the tool's offset included (probing macros take the
//! length off #5043), #5081 the tool offset in force. Where the two differ, the dialect decides:
//!
//! | | Fanuc | Haas |
//! |---|---|---|
//! | G54 to G59 | group 14 (#4014) | group 12 (#4012) |
//! | #2001 to #2200, #2201 to #2400 | wear, geometry of lengths (memory C) | geometry, wear |
//! | #2401 to #2800 | work offsets by axis (#2501) | geometry and wear of diameters |
//! | #5201 on | the external offset of all systems | the shift of G52 |
//! | #10001 to #13999 | tool memory C | further variables, inputs, outputs |
//! | G54.1 P, G154 P | 300 systems, 48 of them from #7001 on, all from #14001 on | 99, 20 of them |
//!
//! Fanuc's memory A has the whole offset in #2001: what differs is warned of when it is read. Haas'
//! Setting 40 says whether D is a radius or a diameter: a diameter is taken, with a warning. Some
//! summaries on the web give #4007 as the tool length (it is group 8) and #4109 as the canned cycle
//! (it is F); the manuals are followed.
//!
//! Checked against Haas 96-8000 ("Local Variables", "Offsets": G52 at #5201, G110 at #7001, G129 at
//! #7381), Yasnac LX3, whose macros are Fanuc's (#5001 without, #5021, #5041 and #5061 with the tool
//! offset), B-62093E (calls by M codes) and the list of G codes of the 30i (G54 in group 14, G66 in
//! 12, G15 in 17), published lists of Fanuc's variables (#5201, #5221, #7001 and #7021 of G54.1 P1 and
//! P2) and of Brother's D00 (#14001 and #14021 of the same two). That Haas has G54 in group 12 is from
//! its list of G codes, as in RS274/NGC. Told by no document that was found: #14001 on Haas, the
//! motion mode that holds after G80, and G98 at power-on.

use super::View;
use crate::codes::Code;
use crate::config::InterpreterConfig;
use crate::dialect::Dialect;
use crate::problem::Problem;
use crate::state::{Offsets, is_angle};
use crate::tool_table::MemoryCell;

/// First number that is a system variable; those below are the program's own.
pub(crate) const FIRST: u32 = 1000;
/// Highest number of a system variable that is kept: the last of G54.1 P300.
pub(super) const LAST: u16 = 20_000;
/// Modes by group start after this.
pub(crate) const GROUPS: u16 = 4000;
/// Last words by letter start after this, numbered as the arguments of a macro.
pub(crate) const ADDRESSES: u16 = 4100;
/// Sequence number of the last block that had one.
pub(crate) const SEQUENCE_NUMBER: u16 = 4114;
/// Number of the program that runs.
pub(crate) const PROGRAM_NUMBER: u16 = 4115;
/// Number of the additional work coordinate system in force.
pub(crate) const EXTRA_SYSTEM: u16 = 4130;
/// The external work offset.
pub(crate) const EXTERNAL_ORIGIN: u16 = 5201;
/// Origin of G54.1 P1; the others follow 20 apart.
pub(crate) const EXTRA_ORIGINS: u16 = 14_001;
/// The number of the first system beyond G59.3.
pub(crate) const FIRST_EXTRA: u16 = 10;

/// What a system variable stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Variable {
    /// It keeps what is put there.
    Kept(u16),
    /// The same, vacant until something is put there.
    Vacant(u16),
    /// It shows the state: a group's code or a letter's last value, kept by the interpreter.
    Shown(u16),
    /// It shows a position of an axis.
    Position(Reading, usize),
    /// The origin of a work coordinate system, 0 for the external offset of all.
    Origin(u16, usize),
    /// The shift of G52.
    Shift(usize),
    /// A cell of the tool memory. Of #2001 to #2400 the meaning depends on the memory.
    Tool(MemoryCell, i32, bool),
    /// Stops with an alarm when it is set.
    Alarm,
    /// Stops until the operator goes on when it is set.
    Stop,
    /// Only the machine knows it, and it changes by itself.
    Clock(&'static str),
    /// Only the machine knows it, unless the program has set it.
    Outside(u16, &'static str),
}

/// A position that a system variable shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reading {
    /// The end of the last block in work coordinates.
    BlockEnd,
    /// Machine coordinates.
    Machine,
    /// Work coordinates with the tool's offset.
    Work,
    /// The tool's offset in force.
    ToolOffset,
}

/// Axes that a group of position variables has.
const AXES: u32 = 8;
/// Tool offsets that #2001 and on are for.
const OLD_OFFSETS: u32 = 200;
const OUTSIDE: &str = "a system variable of the control";

/// How many systems beyond G59 a control has, and how many of them from #7001 on.
pub(crate) const fn extra_systems(dialect: Dialect) -> (u16, u16) {
    match dialect {
        Dialect::Haas => (99, 20),
        _ => (300, 48),
    }
}

/// What a number from #1000 on stands for.
pub(crate) fn variable(dialect: Dialect, number: u32) -> Variable {
    let haas = dialect == Dialect::Haas;
    // Numbers beyond those that are kept have no cell; 0 is none of a system variable.
    let cell = u16::try_from(number)
        .ok()
        .filter(|cell| *cell < LAST)
        .unwrap_or(0);
    match number {
        1000..=1099 => Variable::Outside(cell, "an input of the machine"),
        1100..=1199 => Variable::Kept(cell),
        2001..=2800 => old_tool_or_origin(haas, number, cell),
        3000 => Variable::Alarm,
        3001 | 3002 => Variable::Clock("a clock that counts while the program runs"),
        // Single block, feed hold, mirror image: they change no path here.
        3003 | 3004 | 3007 => Variable::Kept(cell),
        3006 => Variable::Stop,
        3011 => Variable::Clock("the date"),
        3012 => Variable::Clock("the time of day"),
        3020..=3028 => Variable::Clock("a clock of the control"),
        3901 | 3902 => Variable::Outside(cell, "a count of parts"),
        4001..=4030 => group(haas, cell),
        // The modes of the block that runs: those before it, as a macro statement reads them.
        4201..=4230 => group(haas, cell - 200),
        4101..=4130 => address(haas, cell),
        4301..=4330 => address(haas, cell - 200),
        5001..=5008 => Variable::Position(Reading::BlockEnd, axis(number - 5001)),
        5021..=5028 => Variable::Position(Reading::Machine, axis(number - 5021)),
        5041..=5048 => Variable::Position(Reading::Work, axis(number - 5041)),
        5061..=5070 => Variable::Kept(cell),
        5081..=5088 => Variable::Position(Reading::ToolOffset, axis(number - 5081)),
        5101..=5108 => Variable::Outside(cell, "the lag of a servo"),
        5201..=5208 if haas => Variable::Shift(axis(number - 5201)),
        5201..=5208 => Variable::Origin(0, axis(number - 5201)),
        5221..=5328 => origin(number - 5221, 1, cell),
        7001..=7960 if (number - 7001) / 20 < u32::from(extra_systems(dialect).1) => {
            origin(number - 7001, FIRST_EXTRA, cell)
        }
        14_001..=19_988 if (number - 14_001) / 20 < u32::from(extra_systems(dialect).0) => {
            origin(number - 14_001, FIRST_EXTRA, cell)
        }
        // Numbers of Haas' newer control: #10100 is #100, some have no older name.
        10_100..=10_199 | 10_500..=10_699 | 10_800..=10_999 if haas => {
            Variable::Vacant(cell - 10_000)
        }
        10_000..=10_999 if haas => Variable::Vacant(cell),
        11_000..=11_255 if haas => Variable::Outside(cell, "an input of the machine"),
        12_000..=12_255 if haas => Variable::Kept(cell),
        10_001..=10_999 => tool(MemoryCell::LengthWear, number - 10_000, false),
        11_001..=11_999 if !haas => tool(MemoryCell::Length, number - 11_000, false),
        12_001..=12_999 if !haas => tool(MemoryCell::DiameterWear, number - 12_000, false),
        13_001..=13_999 if !haas => tool(MemoryCell::Diameter, number - 13_000, false),
        _ => Variable::Outside(cell, OUTSIDE),
    }
}

const fn axis(offset: u32) -> usize {
    offset as usize
}

const fn tool(memory: MemoryCell, offset: u32, depends: bool) -> Variable {
    Variable::Tool(memory, offset as i32, depends)
}

/// #2001 to #2800: tool offsets; at Fanuc, from #2500 on, the work offsets axis by axis.
const fn old_tool_or_origin(haas: bool, number: u32, cell: u16) -> Variable {
    let (block, offset) = (
        (number - 2001) / OLD_OFFSETS,
        (number - 2001) % OLD_OFFSETS + 1,
    );
    match (haas, block) {
        (true, 0) => tool(MemoryCell::Length, offset, false),
        (true, 1) => tool(MemoryCell::LengthWear, offset, false),
        (true, 2) => tool(MemoryCell::Diameter, offset, false),
        (true, _) => tool(MemoryCell::DiameterWear, offset, false),
        (false, 0) => tool(MemoryCell::LengthWear, offset, true),
        (false, 1) => tool(MemoryCell::Length, offset, true),
        _ if number >= 2500 && number % 100 <= 6 => {
            Variable::Origin((number % 100) as u16, axis((number - 2500) / 100))
        }
        _ => Variable::Outside(cell, OUTSIDE),
    }
}

/// An origin 20 numbers apart, from a system on.
const fn origin(offset: u32, first: u16, cell: u16) -> Variable {
    if offset % 20 < AXES {
        Variable::Origin(first + (offset / 20) as u16, axis(offset % 20))
    } else {
        Variable::Outside(cell, OUTSIDE)
    }
}

/// The code in force of a modal group.
const fn group(haas: bool, cell: u16) -> Variable {
    let known = match cell - GROUPS {
        1..=3 | 5..=13 | 15..=17 => true,
        14 => !haas,
        _ => false,
    };
    if known {
        Variable::Shown(cell)
    } else {
        Variable::Outside(cell, "a modal group that is not read")
    }
}

/// The last value of a letter. Haas keeps all of them, Fanuc those that are modal.
const fn address(haas: bool, cell: u16) -> Variable {
    let known = match cell - ADDRESSES {
        2 | 7 | 8 | 9 | 11 | 13 | 14 | 15 | 19 | 20 => true,
        30 => !haas,
        number => haas && number <= 26,
    };
    if known {
        Variable::Shown(cell)
    } else {
        Variable::Outside(cell, OUTSIDE)
    }
}

/// The modal group of a code, counted as #4001 and on.
pub(crate) fn modal_group(dialect: Dialect, code: Code) -> Option<u16> {
    Some(match (code.letter, code.tenths) {
        ('G', 0 | 10 | 20 | 30 | 330) => 1,
        ('G', 170 | 180 | 190) => 2,
        ('G', 900 | 910) => 3,
        ('G', 930 | 940 | 950) => 5,
        ('G', 200 | 210) => 6,
        ('G', 400 | 410 | 420) => 7,
        ('G', 430 | 434 | 435 | 440 | 490) => 8,
        ('G', 730 | 740 | 760 | 800..=890) => 9,
        ('G', 980 | 990) => 10,
        ('G', 960 | 970) => 13,
        ('G', 540..=590 | 1540) if dialect == Dialect::Haas => 12,
        ('G', 540..=590 | 1540) => 14,
        ('G', 610 | 640) => 15,
        ('G', 680 | 682 | 690) => 16,
        _ => return None,
    })
}

/// What the groups show before the first block: the codes that the manuals mark as those of the
/// power-on state. G20 or G21 and the work coordinate system follow the state.
pub(crate) const POWER_ON: [(u16, f64); 13] = [
    (1, 0.0),
    (2, 17.0),
    (3, 90.0),
    (5, 94.0),
    (7, 40.0),
    (8, 49.0),
    (9, 80.0),
    (10, 98.0),
    (11, 50.0),
    (13, 97.0),
    (15, 64.0),
    (16, 69.0),
    (17, 15.0),
];

/// How often a value of the program goes into a cell: Fanuc's D is a radius, the table holds
/// diameters. Haas has diameters unless Setting 40 says radius.
pub(crate) fn cell_factor(dialect: Dialect, cell: MemoryCell) -> f64 {
    match cell {
        MemoryCell::Diameter | MemoryCell::DiameterWear if dialect != Dialect::Haas => 2.0,
        _ => 1.0,
    }
}

impl View<'_> {
    /// The value of a system variable; NaN for one that is vacant.
    #[cold]
    pub(super) fn control_variable(&mut self, number: u32) -> Result<f64, Problem> {
        let told = |view: &Self, cell: u16| {
            (cell != 0 && view.parameters.is_known(cell)).then(|| view.parameters.get(cell))
        };
        let cell = u16::try_from(number).unwrap_or(0);
        match variable(self.config.dialect, number) {
            Variable::Kept(cell) | Variable::Shown(cell) => Ok(self.parameters.get(cell)),
            Variable::Vacant(cell) => Ok(told(self, cell).unwrap_or_else(|| {
                self.parameters.vacant_read = true;
                f64::NAN
            })),
            Variable::Position(place, axis) => self.position(number, place, axis),
            Variable::Origin(system, axis) => {
                let first = match system {
                    0 => EXTERNAL_ORIGIN,
                    system => super::system_parameter(system),
                };
                let origin = self.parameters.get(first + axis as u16);
                Ok(from_machine(self.config, origin, axis, self.state.units))
            }
            Variable::Shift(axis) => Ok(self
                .state
                .offsets
                .g92
                .get(axis)
                .copied()
                .unwrap_or_default()),
            Variable::Tool(memory, offset, depends) => {
                Ok(self.tool(number, memory, offset, depends))
            }
            Variable::Clock(what) => {
                told(self, cell).ok_or(Problem::ControlVariable { number, what })
            }
            Variable::Outside(cell, what) => {
                told(self, cell).ok_or(Problem::ControlVariable { number, what })
            }
            Variable::Alarm | Variable::Stop => Err(Problem::ControlVariable {
                number,
                what: "there to be set",
            }),
        }
    }

    fn position(&self, number: u32, place: Reading, axis: usize) -> Result<f64, Problem> {
        let state = self.state;
        let refused = |what| Err(Problem::ControlVariable { number, what });
        let acts = state
            .compensation
            .as_ref()
            .is_some_and(|compensation| compensation.acts());
        // The held move ends where the next one decides: the manuals call it not readable.
        if acts && matches!(place, Reading::Machine | Reading::Work) {
            return refused("a position under cutter compensation");
        }
        // Whether G68 turns what is read depends on the control's parameters.
        if state.offsets.tilt.is_some() && place != Reading::Machine {
            return refused("a position in turned coordinates");
        }
        let position = match place {
            Reading::BlockEnd => state.current,
            Reading::Machine => state.machine(),
            Reading::Work => Offsets {
                tool: [0.0; 9],
                ..state.offsets
            }
            .to_program(&state.machine()),
            Reading::ToolOffset => state.offsets.tool,
        };
        Ok(position.get(axis).copied().unwrap_or_default())
    }

    /// A cell of the tool memory in program units.
    fn tool(&mut self, number: u32, memory: MemoryCell, offset: i32, depends: bool) -> f64 {
        let cell = |cell| self.tools.and_then(|table| table.memory(offset, cell));
        let Some(value) = cell(memory) else {
            self.parameters.noted = Some(Box::new(Problem::OffsetUnknown { number, offset }));
            return 0.0;
        };
        // Memory A has the sum in one cell, which is the same if the other is 0.
        let other = match memory {
            MemoryCell::Length => MemoryCell::LengthWear,
            _ => MemoryCell::Length,
        };
        if depends && cell(other) != Some(0.0) {
            self.parameters.noted = Some(Box::new(Problem::MemoryAssumed { number }));
        }
        let value = value / cell_factor(self.config.dialect, memory);
        self.config.machine_units.convert(value, self.state.units)
    }
}

/// A coordinate in program units.
fn from_machine(
    config: &InterpreterConfig,
    value: f64,
    axis: usize,
    units: crate::ops::Units,
) -> f64 {
    if is_angle(axis) {
        value
    } else {
        config.machine_units.convert(value, units)
    }
}
