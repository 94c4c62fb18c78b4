//! The machine: which axes it has, what each may do and is made of, where its parts lie.
//!
//! A machine is described by a TOML file in which every key carries its unit; `presets/` holds the
//! ones that come with the library, with a source for every value. A [`Machine`] is immutable and
//! has been checked: [`Machine::from_toml`] either gives a machine that makes sense or everything
//! that is wrong with the text.

mod check;
mod document;
mod file;
mod gantry;
mod keys;
mod limits;
mod memory;
mod monitoring;
mod preset;
mod problem;
mod read;
mod review;
mod section;
mod settings;
mod tuning;

pub use crate::control::PathStops;
pub use document::Change;
pub use file::{AxisEdit, AxisFile, MachineEdit, MachineFile};
pub(crate) use gantry::LEAST_BEAM_MM;
pub use gantry::{Gantry, GantryFile};
pub use keys::{KeyInfo, keys};
pub use limits::{LimitsTable, LinearLimits, RotaryLimits};
pub use memory::Memory;
pub use monitoring::{FollowingLimit, MonitorLimits, OverloadLimit};
pub use preset::{
    DEFAULT_MACHINE, PresetInfo, axis_preset, axis_preset_toml, axis_presets, presets,
};
pub use problem::{MachineError, Problem};
pub use read::{axis_from_changed_toml, axis_from_toml, axis_to_toml};
pub use review::AxisReview;
pub use settings::{
    BOW_LIMIT_UM, Homes, PlannerSettings, Position, SimulateSettings, ToolEntry, WorkOffsets,
};
pub use tuning::AxisTuning;

use lostmotion_base::units::deg;
use lostmotion_base::{AxisId, AxisLimits, AxisSet, Coords};
use lostmotion_drive::config::{AxisUnit, Cycles};
use lostmotion_gcode::{Dialect, Units};
use lostmotion_kinematics::{Kinematics, KinematicsError, KinematicsSpec, Reach, build_within};
use lostmotion_methods::AxisConfig;
use serde::{Deserialize, Serialize};

/// One axis of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineAxis {
    /// Its letter.
    pub id: AxisId,
    /// Travel and limits in joint units: mm or rad.
    pub limits: AxisLimits,
    /// Drive, motor, shaft, load, compensator.
    pub config: AxisConfig,
    table: LimitsTable,
}

impl MachineAxis {
    /// Axis units ([`AxisConfig::unit`]) for one joint unit (mm or rad): 1, or 180/pi for a rotary
    /// axis described in degrees.
    pub fn axis_units_per_joint_unit(&self) -> f64 {
        if self.config.unit() == AxisUnit::Deg {
            deg(1.0)
        } else {
            1.0
        }
    }

    /// Whether its joint turns: A, B and C, and those of arms, whatever their letter.
    pub fn is_rotary(&self) -> bool {
        matches!(self.table, LimitsTable::Rotary(_))
    }

    /// Travel and limits as the file has them.
    pub fn limits_table(&self) -> &LimitsTable {
        &self.table
    }
}

/// Everything in a machine file besides its axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct General {
    /// Name of the machine.
    pub name: String,
    /// One line for people.
    #[serde(default)]
    pub description: String,
    /// Dialect that its programs are in.
    #[serde(default, skip_serializing_if = "is_default")]
    pub dialect: Dialect,
    /// Unit of length of the control's settings, offsets and tools.
    #[serde(default, skip_serializing_if = "is_mm")]
    pub control_units: Units,
    /// Unit of length in which programs start; that of the control if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program_units: Option<Units>,
    /// Letters of the axes of the control's joints, in the order of their numbers; in the order of
    /// the axes if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_axes: Option<String>,
    /// Cycles of command and servo, those of every axis.
    #[serde(default, skip_serializing_if = "Cycles::is_usual")]
    pub cycles: Cycles,
    /// Which kinematics, with its measures.
    pub kinematics: KinematicsSpec,
    /// What the planner is told.
    #[serde(default)]
    pub planner: PlannerSettings,
    /// Tolerance of the verdict and the like.
    #[serde(default)]
    pub simulate: SimulateSettings,
    /// Where the machine stands before the program; the origin of G54 if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<Position>,
    /// Origins of the work coordinate systems.
    #[serde(default)]
    pub work_offset: WorkOffsets,
    /// Where G28 and G30 go.
    #[serde(default)]
    pub home: Homes,
    /// The tools it knows; if there are none, a program may name any.
    #[serde(default)]
    pub tool: Vec<ToolEntry>,
}

impl General {
    fn new(name: String, kinematics: KinematicsSpec) -> General {
        General {
            name,
            description: String::new(),
            dialect: Dialect::default(),
            control_units: Units::default(),
            program_units: None,
            joint_axes: None,
            cycles: Cycles::default(),
            kinematics,
            planner: PlannerSettings::default(),
            simulate: SimulateSettings::default(),
            start: None,
            work_offset: WorkOffsets::default(),
            home: Homes::default(),
            tool: Vec::new(),
        }
    }
}

fn is_default(dialect: &Dialect) -> bool {
    *dialect == Dialect::default()
}

fn is_mm(units: &Units) -> bool {
    *units == Units::Mm
}

/// The travel of joints, as kinematics take it.
fn reach(axes: &[MachineAxis]) -> Reach {
    let mut reach = Reach::default();
    for axis in axes {
        reach.0[axis.id.index()] = Some((axis.limits.min, axis.limits.max));
    }
    reach
}

/// A checked machine.
///
/// It is made from a file ([`Machine::from_toml`]), is one of those that come with the library
/// ([`Machine::preset`]), or is described in code ([`MachineFile::check`]); [`Machine::edit`]
/// changes it. Its serde form is that of [`MachineFile`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "MachineFile", try_from = "MachineFile")]
pub struct Machine {
    general: General,
    axes: Vec<MachineAxis>,
    gantry: Option<Gantry>,
}

impl Machine {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.general.name
    }

    /// One line for people.
    pub fn description(&self) -> &str {
        &self.general.description
    }

    /// The dialect that its programs are in.
    pub fn dialect(&self) -> Dialect {
        self.general.dialect
    }

    /// Unit of length of the control: of its settings, its parameters with offsets and homes, and
    /// its tool table.
    pub fn control_units(&self) -> Units {
        self.general.control_units
    }

    /// Unit of length in which its programs start, before any G20 or G21.
    pub fn program_units(&self) -> Units {
        self.general
            .program_units
            .unwrap_or(self.general.control_units)
    }

    /// The axes of the control's joints in the order of their numbers, `None` for a joint of no axis;
    /// where the file does not tell every axis in their order, that of two motors twice.
    pub fn joint_axes(&self) -> Vec<Option<AxisId>> {
        if let Some(letters) = &self.general.joint_axes {
            return letters.chars().map(AxisId::from_letter).collect();
        }
        let of_two = self.gantry().map(|gantry| gantry.axis);
        let joints = self.axes.iter().flat_map(|axis| {
            let motors = if of_two == Some(axis.id) { 2 } else { 1 };
            std::iter::repeat_n(Some(axis.id), motors)
        });
        joints.collect()
    }

    /// Which kinematics, with its measures; [`lostmotion_kinematics::build`] makes it and does not
    /// fail for a checked machine.
    pub fn kinematics(&self) -> &KinematicsSpec {
        &self.general.kinematics
    }

    /// Cycles of command and servo, those of every axis.
    pub fn cycles(&self) -> Cycles {
        self.general.cycles
    }

    /// The kinematics, with the travel of its joints.
    ///
    /// # Errors
    /// None for a checked machine.
    pub fn build_kinematics(&self) -> Result<Box<dyn Kinematics>, KinematicsError> {
        build_within(&self.general.kinematics, &reach(&self.axes))
    }

    /// Joints that turn.
    pub fn rotary_joints(&self) -> AxisSet {
        self.axes
            .iter()
            .filter(|axis| axis.is_rotary())
            .map(|axis| axis.id)
            .collect()
    }

    /// What the planner is told.
    pub fn planner(&self) -> &PlannerSettings {
        &self.general.planner
    }

    /// Defaults of `simulate`.
    pub fn simulate(&self) -> &SimulateSettings {
        &self.general.simulate
    }

    /// Origins of the work coordinate systems G54 to G59.3 in machine coordinates, mm and rad.
    pub fn work_offsets(&self) -> [Coords; 9] {
        self.general
            .work_offset
            .all()
            .map(|position| position.coords())
    }

    /// Where the machine stands before the program, machine coordinates, mm and rad: `start`, or
    /// the origin of G54.
    pub fn start(&self) -> Coords {
        self.general
            .start
            .unwrap_or(self.general.work_offset.g54)
            .coords()
    }

    /// Where G28 goes, machine coordinates, mm and rad.
    pub fn home_g28(&self) -> Coords {
        self.general.home.g28.coords()
    }

    /// Where G30 goes, machine coordinates, mm and rad.
    pub fn home_g30(&self) -> Coords {
        self.general.home.g30.coords()
    }

    /// The tools it knows; if there are none, a program may name any.
    pub fn tools(&self) -> &[ToolEntry] {
        &self.general.tool
    }

    /// The axis of a letter.
    pub fn axis(&self, id: AxisId) -> Option<&MachineAxis> {
        self.axes.iter().find(|axis| axis.id == id)
    }

    /// All axes in index order.
    pub fn axes(&self) -> &[MachineAxis] {
        &self.axes
    }

    /// The axis that two motors drive, if there is one; [`Machine::axes`] has its first motor.
    pub fn gantry(&self) -> Option<&Gantry> {
        self.gantry.as_ref()
    }

    /// Every axis' description with its letter in lower case, as machine files name it.
    pub(crate) fn configs(&self) -> impl Iterator<Item = (char, &AxisConfig)> {
        let axes = self.axes.iter();
        axes.map(|axis| (axis.id.letter().to_ascii_lowercase(), &axis.config))
    }

    /// Name of the methods that a run uses where it names none: the method of all axes, or each
    /// axis with its own, as in `x fixed, y none`.
    pub fn method_names(&self) -> String {
        names_of_axes(self.configs())
    }

    /// The letters of all axes.
    pub fn axis_set(&self) -> AxisSet {
        self.axes.iter().map(|axis| axis.id).collect()
    }

    /// The same machine with a gap of zero in every axis: the baseline that shows what backlash
    /// alone causes.
    #[must_use]
    pub fn without_gap(&self) -> Machine {
        self.map_axes(AxisConfig::without_gap)
    }

    /// The same machine with other cycles. The caller checks the axes ([`AxisConfig::check`]).
    #[must_use]
    pub fn with_cycles(&self, cycles: Cycles) -> Machine {
        let general = General {
            cycles,
            ..self.general.clone()
        };
        Machine {
            general,
            ..self.clone()
        }
        .map_axes(AxisConfig::clone)
    }

    /// An axis keeps the machine's cycles.
    fn in_step(&self, config: &AxisConfig) -> AxisConfig {
        AxisConfig {
            cycles: self.general.cycles,
            ..config.clone()
        }
    }

    /// The same machine with every axis, and the second motor of a gantry, through a function;
    /// cycles stay the machine's. The caller checks what comes out ([`AxisConfig::check`]).
    #[must_use]
    pub fn map_axes(&self, change: impl Fn(&AxisConfig) -> AxisConfig) -> Machine {
        let change = |config: &AxisConfig| self.in_step(&change(config));
        let of_axis = |axis: &MachineAxis| MachineAxis {
            config: change(&axis.config),
            ..axis.clone()
        };
        let gantry = self.gantry.as_ref().map(|gantry| gantry.map(change));
        Machine {
            general: self.general.clone(),
            axes: self.axes.iter().map(of_axis).collect(),
            gantry,
        }
    }

    /// The same machine, stopping on its path elsewhere.
    #[must_use]
    pub(crate) fn with_stops(&self, stops: PathStops) -> Machine {
        let mut machine = self.clone();
        machine.general.planner.stops = stops;
        machine
    }

    /// The same machine with another axis description for one letter. The caller checks it
    /// ([`AxisConfig::check`]).
    #[must_use]
    pub fn with_axis_config(&self, id: AxisId, config: &AxisConfig) -> Machine {
        let config = self.in_step(config);
        let put = |axis: &MachineAxis| {
            if axis.id == id {
                MachineAxis {
                    config: config.clone(),
                    ..axis.clone()
                }
            } else {
                axis.clone()
            }
        };
        Machine {
            axes: self.axes.iter().map(put).collect(),
            ..self.clone()
        }
    }
}

/// Name of the methods that the axes have of their own: the one of all, or each with its axis.
pub(crate) fn names_of_axes<'a>(axes: impl Iterator<Item = (char, &'a AxisConfig)>) -> String {
    let named: Vec<(char, &str)> = axes
        .map(|(letter, config)| (letter, config.compensation.method.name()))
        .collect();
    // One name where all agree, since that is what people ask for by name.
    match named.first() {
        Some((_, first)) if named.iter().all(|(_, name)| name == first) => (*first).to_owned(),
        _ => named
            .iter()
            .map(|(letter, name)| format!("{letter} {name}"))
            .collect::<Vec<_>>()
            .join(", "),
    }
}
