//! What an interpreter is told before it starts.

use crate::codes::Code;
use crate::dialect::{Dialect, Leniencies};
use crate::limits::Limits;
use crate::ops::Units;
use crate::tool_table::ToolTable;
use lostmotion_base::Coords;
use lostmotion_base::units::deg;
use std::collections::BTreeMap;
use std::str::FromStr;

/// Work coordinate systems G54 to G59.3.
pub const WORK_SYSTEMS: u8 = 9;

/// What an M code of the machine's builder does.
///
/// ```
/// use lostmotion_gcode::MCodeUse;
///
/// assert_eq!("dwell:1.5".parse(), Ok(MCodeUse::Dwell(1.5)));
/// assert!("wait".parse::<MCodeUse>().is_err());
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MCodeUse {
    /// Nothing that moves an axis: it is skipped with its words.
    Ignore,
    /// It stops the program as M0 does, after the rest of its line.
    Stop,
    /// The machine takes this long to carry it out, s; the axes wait, after the rest of the line.
    Dwell(f64),
    /// It calls the subroutine of a number after the rest of its line, as M98 (Fanuc's parameters
    /// 6071 to 6079).
    Call(u32),
    /// It calls the subroutine of a number with the words of its line as arguments, as G65 (Fanuc's
    /// parameters 6080 to 6089).
    Macro(u32),
}

/// Highest number of a program that an M code calls. Published: eight digits (B-63944EN, "Program
/// Number").
const HIGHEST_PROGRAM: u32 = 99_999_999;

impl FromStr for MCodeUse {
    type Err = String;

    /// `ignore`, `stop`, `dwell:SECONDS`, `call:NUMBER` or `macro:NUMBER`.
    fn from_str(text: &str) -> Result<MCodeUse, String> {
        let (name, value) = match text.split_once(':') {
            Some((name, value)) => (name.trim(), Some(value.trim())),
            None => (text.trim(), None),
        };
        let program = |value: &str| {
            let number = value.trim_start_matches(['O', 'o']).parse::<u32>().ok();
            number
                .filter(|number| (1..=HIGHEST_PROGRAM).contains(number))
                .ok_or_else(|| format!("{value} is not the number of a program"))
        };
        match (name.to_ascii_lowercase().as_str(), value) {
            ("ignore", None) => Ok(MCodeUse::Ignore),
            ("stop", None) => Ok(MCodeUse::Stop),
            ("dwell", Some(value)) => value
                .parse::<f64>()
                .ok()
                .filter(|seconds| seconds.is_finite() && *seconds >= 0.0)
                .map(MCodeUse::Dwell)
                .ok_or_else(|| format!("{value} is not a time in seconds, 0 or above")),
            ("call", Some(value)) => program(value).map(MCodeUse::Call),
            ("macro", Some(value)) => program(value).map(MCodeUse::Macro),
            _ => Err(format!(
                "`{text}` is none of ignore, stop, dwell:SECONDS, call:NUMBER and macro:NUMBER"
            )),
        }
    }
}

/// Settings of an interpreter. Immutable while a program runs.
#[derive(Clone, Debug, PartialEq)]
pub struct InterpreterConfig {
    /// Units of the tool table, of the homes #5161 and #5181, and of the offsets in the parameters,
    /// whatever the program uses.
    pub machine_units: Units,
    /// Units a program starts in.
    pub program_units: Units,
    /// How words are meant that controls disagree about.
    pub dialect: Dialect,
    /// What is accepted, with a warning, beyond RS274/NGC: [`Dialect::leniencies`], more or less.
    pub leniencies: Leniencies,
    /// Whether lines that begin with `/` are skipped.
    pub block_delete: bool,
    /// Which of the switches 1 to 9 of `/1` to `/9` are on, `/` being `/1`; as `block_delete` says,
    /// all of them, if `None`.
    pub block_skips: Option<Vec<u8>>,
    /// What M codes of the machine's builder do; they come before the meaning that a code has
    /// otherwise.
    pub m_codes: BTreeMap<Code, MCodeUse>,
    /// Values that the program reads and only the machine knows: the number of a parameter or
    /// system variable (`3011`), or a name (`_hal[spindle.load]`).
    pub told: Vec<(String, f64)>,
    /// Tools. Without a table every tool is accepted, with a warning, and has no length.
    pub tool_table: Option<ToolTable>,
    /// Taps outside the XY plane (G74 and G84 in G18 and G19) as LinuxCNC 2.9 does, along the wrong
    /// axes; for comparison with its output only.
    pub rs274_tapping: bool,
    /// Parameters to start with, in machine units and degrees; numbers out of range are not used.
    pub parameters: Vec<(u16, f64)>,
    /// Where the machine stands at the start: machine coordinates of the spindle, mm and rad.
    pub start: Coords,
    /// Bounds.
    pub limits: Limits,
}

impl Default for InterpreterConfig {
    fn default() -> InterpreterConfig {
        InterpreterConfig {
            machine_units: Units::Mm,
            program_units: Units::Mm,
            dialect: Dialect::default(),
            leniencies: Dialect::default().leniencies(),
            block_delete: false,
            block_skips: None,
            m_codes: BTreeMap::new(),
            told: Vec::new(),
            tool_table: None,
            rs274_tapping: false,
            parameters: Vec::new(),
            start: Coords::ZERO,
            limits: Limits::default(),
        }
    }
}

impl InterpreterConfig {
    /// As LinuxCNC's stand-alone interpreter `rs274` is set up: machine units are inches, programs
    /// start in millimetres.
    pub fn like_rs274() -> InterpreterConfig {
        InterpreterConfig {
            machine_units: Units::Inch,
            rs274_tapping: true,
            ..InterpreterConfig::default()
        }
    }

    /// In a dialect, with all that it accepts.
    #[must_use]
    pub fn with_dialect(self, dialect: Dialect) -> InterpreterConfig {
        InterpreterConfig {
            dialect,
            leniencies: dialect.leniencies(),
            ..self
        }
    }

    /// Whether lines with a number after their `/` are skipped; 0 for none.
    pub fn skips(&self, number: u8) -> bool {
        match &self.block_skips {
            Some(on) => on.contains(&number.max(1)) || (self.block_delete && number <= 1),
            None => self.block_delete,
        }
    }

    /// Sets the origin of a work coordinate system, 1 for G54 to 9 for G59.3, mm and rad. Other
    /// systems are ignored.
    #[must_use]
    pub fn with_work_offset(mut self, system: u8, origin: Coords) -> InterpreterConfig {
        if (1..=WORK_SYSTEMS).contains(&system) {
            for (index, value) in origin.0.into_iter().enumerate() {
                let machine = if (3..6).contains(&index) {
                    deg(value)
                } else {
                    Units::Mm.convert(value, self.machine_units)
                };
                self.parameters
                    .push((5221 + 20 * (u16::from(system) - 1) + index as u16, machine));
            }
        }
        self
    }
}
