//! Numbered and named parameters, and the predefined names that show the state (LinuxCNC,
//! "Predefined Named Parameters").

pub(crate) mod control;

use crate::codes::whole;
use crate::config::InterpreterConfig;
use crate::ops::{Plane, Position, Units};
use crate::problem::Problem;
use crate::state::{FeedMode, State};
use crate::syntax::evaluate::{Lookup, valued};
use crate::tool_table::ToolTable;
use std::collections::BTreeMap;

/// The highest parameter number.
pub const HIGHEST: u16 = 5602;
/// #1 to this are the arguments and locals of a subroutine. Published: LinuxCNC, "Subroutines".
pub const LOCALS: usize = 30;
/// #1 to this are the locals of a macro of Fanuc and Haas. Published: Haas 96-8000, "Local
/// Variables"; B-63944EN, "Variables".
pub const MACRO_LOCALS: usize = 33;
/// Home of G28 and, 20 higher, of G30.
pub(crate) const HOME: u16 = 5161;
/// 1 if a G92 offset is in force.
pub(crate) const G92_ACTIVE: u16 = 5210;
/// The G92 offset.
pub(crate) const G92: u16 = 5211;
/// Number of the work coordinate system in force.
pub(crate) const SYSTEM: u16 = 5220;
/// Origin of G54; those of the other systems follow 20 apart, each with its rotation after the nine
/// axes.
pub const SYSTEM_ORIGINS: u16 = 5221;
/// Parameters that a program cannot set.
const READ_ONLY: std::ops::RangeInclusive<u16> = 5400..=5428;

type Names = BTreeMap<Box<[u8]>, f64>;

/// All parameters of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    numbered: Vec<f64>,
    known: Vec<bool>,
    /// How many of them belong to a call.
    pub(crate) locals: usize,
    globals: Names,
    /// One scope per call; the first is the main program's.
    scopes: Vec<Names>,
    names: usize,
    limit: usize,
    /// The last parameter that was read before it was set.
    pub(crate) unset_read: Option<u16>,
    /// Parameters that have not been set are vacant, as `#0` is; otherwise they are 0.
    pub(crate) vacants: bool,
    /// A vacant parameter was read.
    pub(crate) vacant_read: bool,
    /// What a read has to warn of.
    pub(crate) noted: Option<Box<Problem>>,
}

/// First parameter of a work coordinate system: 1 to 9 for G54 to G59.3, 10 on for those beyond.
pub(crate) const fn system_parameter(system: u16) -> u16 {
    if system < control::FIRST_EXTRA {
        SYSTEM_ORIGINS + 20 * (if system == 0 { 1 } else { system } - 1)
    } else {
        control::EXTRA_ORIGINS + 20 * (system - control::FIRST_EXTRA)
    }
}

impl Parameters {
    /// Everything zero except the number of the work coordinate system.
    pub fn new(limit: usize) -> Parameters {
        let size = usize::from(HIGHEST) + 1;
        let mut parameters = Parameters {
            numbered: vec![0.0; size],
            // Those from #5061 on are the machine's and always have a value.
            known: (0..size).map(|number| number > 5060).collect(),
            locals: LOCALS,
            globals: Names::new(),
            scopes: vec![Names::new()],
            names: 0,
            limit,
            unset_read: None,
            vacants: false,
            vacant_read: false,
            noted: None,
        };
        parameters.put(SYSTEM, 1.0);
        parameters.put_global(b"_value", 0.0);
        parameters.put_global(b"_value_returned", 0.0);
        parameters
    }

    /// Makes room for the system variables of Fanuc and Haas; those of RS274/NGC from #1000 on have
    /// no value, but for positions and origins.
    pub(crate) fn add_control_variables(&mut self) {
        let size = usize::from(control::LAST);
        self.numbered.resize(size, 0.0);
        self.known.resize(size, false);
        for number in control::FIRST as usize..size {
            let kept = matches!(number, 5061..=5070 | 5161..=5400);
            if let Some(known) = self.known.get_mut(number) {
                *known = kept;
            }
        }
        for (group, code) in control::POWER_ON {
            self.put(control::GROUPS + group, code);
        }
    }

    /// Whether a parameter has been given a value.
    pub(crate) fn is_known(&self, number: u16) -> bool {
        self.known
            .get(usize::from(number))
            .copied()
            .unwrap_or(false)
    }

    /// The stored value of a parameter; 0 out of range.
    pub fn get(&self, number: u16) -> f64 {
        self.numbered
            .get(usize::from(number))
            .copied()
            .unwrap_or_default()
    }

    /// Stores a value; NaN takes the value away. Numbers out of range are ignored.
    pub fn put(&mut self, number: u16, value: f64) {
        let index = usize::from(number);
        if let (Some(slot), Some(known)) = (self.numbered.get_mut(index), self.known.get_mut(index))
        {
            *slot = valued(value);
            *known = !value.is_nan();
        }
    }

    /// Nine consecutive parameters as a position.
    pub(crate) fn position(&self, first: u16) -> Position {
        std::array::from_fn(|index| self.get(first + index as u16))
    }

    /// Stores a position in nine consecutive parameters.
    pub(crate) fn put_position(&mut self, first: u16, position: &Position) {
        for (index, value) in position.iter().enumerate() {
            self.put(first + index as u16, *value);
        }
    }

    /// A program's setting of a numbered parameter.
    pub(crate) fn set(&mut self, number: f64, value: f64) -> Result<(), Problem> {
        let number = in_range(number)?;
        if READ_ONLY.contains(&number) {
            return Err(Problem::ReadOnlyParameter { number });
        }
        self.put(number, value);
        Ok(())
    }

    /// A program's setting of a named parameter: `_name` is global, others belong to the
    /// subroutine.
    pub(crate) fn set_name(
        &mut self,
        name: &[u8],
        value: f64,
        state: &State,
    ) -> Result<(), Problem> {
        let shown = || String::from_utf8_lossy(name).into_owned();
        // Names that show the state cannot be set.
        if name.first() == Some(&b'_') && system_name(name, state).is_some() {
            return Err(Problem::ReadOnlyName { name: shown() });
        }
        let table = if name.first() == Some(&b'_') {
            Some(&mut self.globals)
        } else {
            self.scopes.last_mut()
        };
        let Some(table) = table else { return Ok(()) };
        // A known name is replaced without an allocation; only new ones count towards the limit.
        if let Some(slot) = table.get_mut(name) {
            *slot = value;
            return Ok(());
        }
        if self.names >= self.limit {
            return Err(Problem::TooManyParameters { limit: self.limit });
        }
        self.names += 1;
        table.insert(name.into(), value);
        Ok(())
    }

    /// Stores a name that the interpreter is told: a global, or one of the main program.
    pub(crate) fn put_told(&mut self, name: &[u8], value: f64) {
        if name.first() == Some(&b'_') {
            self.put_global(name, value);
        } else if let Some(scope) = self.scopes.first_mut() {
            scope.insert(name.into(), value);
        }
    }

    /// Stores a global that the interpreter itself sets.
    pub(crate) fn put_global(&mut self, name: &[u8], value: f64) {
        self.globals.insert(name.into(), value);
    }

    /// Whether a name has a value, of its own or as one that shows the state.
    pub(crate) fn has_name(&self, name: &[u8], state: &State) -> bool {
        self.name(name).is_some()
            || (name.first() == Some(&b'_') && system_name(name, state).is_some())
    }

    /// The names that have been set and can be read here.
    pub(crate) fn visible_names(&self) -> impl Iterator<Item = &[u8]> {
        let locals = self.scopes.last().into_iter().flat_map(Names::keys);
        locals.chain(self.globals.keys()).map(|name| &**name)
    }

    fn name(&self, name: &[u8]) -> Option<f64> {
        let table = if name.first() == Some(&b'_') {
            Some(&self.globals)
        } else {
            self.scopes.last()
        };
        table.and_then(|names| names.get(name)).copied()
    }

    /// Opens a scope with new numbered locals and returns the old ones.
    pub(crate) fn enter(&mut self, arguments: &[f64]) -> [f64; MACRO_LOCALS] {
        self.scopes.push(Names::new());
        // NaN stands for a parameter without a value, so that it comes back without one.
        let kept = |index: usize| {
            if self.known.get(index + 1) == Some(&false) {
                f64::NAN
            } else {
                self.get(index as u16 + 1)
            }
        };
        let old = std::array::from_fn(kept);
        let missing = if self.vacants { f64::NAN } else { 0.0 };
        for number in 1..=self.locals {
            self.put(
                number as u16,
                arguments.get(number - 1).copied().unwrap_or(missing),
            );
        }
        old
    }

    /// Closes a scope and brings the caller's numbered locals back.
    pub(crate) fn leave(&mut self, old: &[f64; MACRO_LOCALS]) {
        if self.scopes.len() > 1 {
            self.names -= self.scopes.pop().map_or(0, |scope| scope.len());
        }
        for (index, value) in old.iter().enumerate().take(self.locals) {
            self.put(index as u16 + 1, *value);
        }
    }
}

fn in_range(number: f64) -> Result<u16, Problem> {
    match whole(number) {
        Some(whole) if (1.0..=f64::from(HIGHEST)).contains(&whole) => Ok(whole as u16),
        _ => Err(Problem::ParameterRange { number }),
    }
}

/// The number of a system variable.
pub(crate) fn control_number(number: f64) -> Result<u32, Problem> {
    whole(number)
        .filter(|whole| *whole < 1e9)
        .map(|whole| whole as u32)
        .ok_or(Problem::ParameterRange { number })
}

/// Parameters as an expression sees them: with those that show the state.
pub(crate) struct View<'a> {
    pub(crate) parameters: &'a mut Parameters,
    pub(crate) state: &'a State,
    pub(crate) tools: Option<&'a ToolTable>,
    pub(crate) config: &'a InterpreterConfig,
}

impl Lookup for View<'_> {
    fn numbered(&mut self, number: f64) -> Result<f64, Problem> {
        // #0 is always vacant in Macro B and does not exist in RS274/NGC.
        if number == 0.0 && self.parameters.vacants {
            self.parameters.vacant_read = true;
            return Ok(f64::NAN);
        }
        if number >= f64::from(control::FIRST) && self.config.dialect.is_fanuc() {
            let number = control_number(number)?;
            return self.control_variable(number);
        }
        let number = in_range(number)?;
        Ok(match number {
            // Parameters that show the state: tool, its offsets, the present place.
            5400 => f64::from(self.state.loaded_tool),
            5401..=5409 => {
                let index = usize::from(number - 5401);
                self.state
                    .offsets
                    .tool
                    .get(index)
                    .copied()
                    .unwrap_or_default()
            }
            5420..=5428 => self
                .state
                .current
                .get(usize::from(number - 5420))
                .copied()
                .unwrap_or_default(),
            _ => {
                if !self
                    .parameters
                    .known
                    .get(usize::from(number))
                    .copied()
                    .unwrap_or(true)
                {
                    // Without a value: vacant in Macro B, 0 with a warning in RS274/NGC.
                    if self.parameters.vacants {
                        self.parameters.vacant_read = true;
                        return Ok(f64::NAN);
                    }
                    self.parameters.unset_read = Some(number);
                }
                self.parameters.get(number)
            }
        })
    }

    fn numbered_exists(&self, number: f64) -> bool {
        in_range(number).is_ok()
    }

    fn named(&self, name: &[u8]) -> Option<f64> {
        let system = if name.first() == Some(&b'_') {
            system_name(name, self.state)
        } else {
            None
        };
        system.or_else(|| self.parameters.name(name))
    }
}

/// Numbers that `#<_coord_system>` shows for G54 to G59.3.
const SYSTEM_CODES: [f64; 9] = [
    540.0, 550.0, 560.0, 570.0, 580.0, 590.0, 591.0, 592.0, 593.0,
];

fn truth(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}

/// The value of a predefined parameter; `None` if there is none of that name.
pub(crate) fn system_name(name: &[u8], state: &State) -> Option<f64> {
    let name = std::str::from_utf8(name).ok()?;
    Some(match name {
        "_vmajor" => 2.9,
        "_vminor" => 0.0,
        "_line" => f64::from(state.line),
        "_motion_mode" => state.motion.map_or(800.0, |code| f64::from(code.tenths)),
        "_plane" => match state.plane {
            Plane::Xy => 170.0,
            Plane::Zx => 180.0,
            Plane::Yz => 190.0,
        },
        "_ccomp" => state
            .compensation
            .as_ref()
            .map_or(400.0, |compensation| compensation.code()),
        "_metric" => truth(state.units == Units::Mm),
        "_imperial" => truth(state.units == Units::Inch),
        "_absolute" => truth(state.absolute),
        "_incremental" => truth(!state.absolute),
        "_inverse_time" => truth(state.feed_mode == FeedMode::InverseTime),
        "_units_per_minute" => truth(state.feed_mode == FeedMode::PerMinute),
        "_units_per_rev" => truth(state.feed_mode == FeedMode::PerRevolution),
        "_coord_system" => SYSTEM_CODES
            .get(usize::from(state.system) - 1)
            .copied()
            .unwrap_or_default(),
        "_tool_offset" => truth(state.offsets.tool.iter().any(|offset| *offset != 0.0)),
        "_retract_r_plane" => truth(!state.retract_to_start),
        "_retract_old_z" => truth(state.retract_to_start),
        "_spindle_rpm_mode" => truth(state.spindle.surface_limit.is_none()),
        "_spindle_css_mode" => truth(state.spindle.surface_limit.is_some()),
        "_ijk_absolute_mode" => truth(state.arc_absolute),
        "_lathe_diameter_mode" => truth(state.diameter),
        "_lathe_radius_mode" => truth(!state.diameter),
        "_spindle_on" => truth(state.spindle.clockwise.is_some()),
        "_spindle_cw" => truth(state.spindle.clockwise == Some(true)),
        "_mist" => truth(state.mist),
        "_flood" => truth(state.flood),
        "_speed_override" => truth(state.speed_override),
        "_feed_override" => truth(state.feed_override),
        "_adaptive_feed" => truth(state.adaptive_feed),
        "_feed_hold" => truth(state.feed_hold),
        "_feed" => state.feed,
        "_rpm" => state.spindle.speed,
        "_current_tool" => f64::from(state.loaded_tool),
        "_current_pocket" => f64::from(state.loaded_tool),
        "_selected_tool" | "_selected_pocket" => f64::from(state.selected_tool.unwrap_or(-1)),
        "_task" | "_remap_level" => 0.0,
        _ => return coordinate(name, state),
    })
}

/// `_x` to `_w`: where the tool is; `_abs_x` to `_abs_w`: in machine coordinates.
fn coordinate(name: &str, state: &State) -> Option<f64> {
    // One letter after the prefix: anything longer is another name.
    let (position, letter) = match name.strip_prefix("_abs_") {
        Some(letter) => (state.machine(), letter),
        None => (state.current, name.strip_prefix('_')?),
    };
    let index = "xyzabcuvw".find(letter)?;
    if letter.len() == 1 {
        position.get(index).copied()
    } else {
        None
    }
}
