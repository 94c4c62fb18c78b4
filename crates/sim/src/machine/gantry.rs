//! A beam that two motors carry: one axis, each of its ends with a screw, a servo, a gap and a
//! compensator of its own.

use super::check;
use super::document::Document;
use super::problem::Problem;
use super::{Machine, MachineAxis, section};
use lostmotion_base::AxisId;
use lostmotion_drive::Tie;
use lostmotion_drive::config::Cycles;
use lostmotion_methods::AxisConfig;
use serde::{Deserialize, Serialize};

/// Least distance between the two ends of a beam, mm. A choice: the tool's place is divided by it.
pub(crate) const LEAST_BEAM_MM: f64 = 1.0;

/// Table `gantry` of a machine file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GantryFile {
    /// Letter of the axis that two motors drive, in lower case.
    pub axis: char,
    /// Letter of the axis that moves the tool along the beam.
    pub along: char,
    /// Joint position of `along` at which the tool is at the first screw, mm.
    pub first_at_mm: f64,
    /// The same for the second screw, mm.
    pub second_at_mm: f64,
    /// Total gap of the second end, um, where it is like the first but for its gap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_gap_um: Option<f64>,
    /// Stiffness of the beam against skew; `None` if it yields.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beam: Option<Tie>,
    /// The second end; like the first if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second: Option<AxisConfig>,
}

/// An axis that two motors drive.
///
/// Both get the same setpoints. Each moves its end of the beam, with the beam's stiffness against
/// skew between them if there is a table `[gantry.beam]` (`stiffness_n_per_um`,
/// `damping_n_s_per_mm`), else without a force from one on the other (a beam that yields in its
/// plane); the tool sits on the beam like on a lever:
/// ```text
/// y = (1 - w) y1 + w y2        w = (x - x1)/(x2 - x1), x the place of the load of the axis `along` the beam
/// ```
/// In a file: a table `[gantry]` with `axis`, `along`, `first_at_mm` and `second_at_mm` (joint
/// positions of `along` at which the tool is at either screw); the tables of the axis itself
/// describe the first end. The second is like it, but for `second_gap_um`, or has tables of its
/// own, `[gantry.second.motor]` and so on.
#[derive(Clone, Debug, PartialEq)]
pub struct Gantry {
    /// The axis.
    pub axis: AxisId,
    /// The axis that moves the tool along the beam.
    pub along: AxisId,
    /// Where along the beam the ends are, mm.
    pub at_mm: [f64; 2],
    /// The second end's drive, motor, shaft, load, compensator.
    pub second: AxisConfig,
    /// The beam between the ends, square where they stand at the start; `None` if it yields.
    pub beam: Option<Tie>,
}

impl Gantry {
    /// The second end's part of the tool's position with the load of the axis along the beam at a
    /// place.
    pub fn share(&self, along_mm: f64) -> f64 {
        (along_mm - self.at_mm[0]) / (self.at_mm[1] - self.at_mm[0])
    }

    /// The same beam with its second end through a function.
    pub(super) fn map(&self, change: impl Fn(&AxisConfig) -> AxisConfig) -> Gantry {
        Gantry {
            second: change(&self.second),
            ..self.clone()
        }
    }

    /// What a file says of it.
    pub(super) fn file(&self) -> GantryFile {
        let letter = |axis: AxisId| axis.letter().to_ascii_lowercase();
        GantryFile {
            axis: letter(self.axis),
            along: letter(self.along),
            first_at_mm: self.at_mm[0],
            second_at_mm: self.at_mm[1],
            second_gap_um: None,
            beam: self.beam,
            // the machine's own table has the cycles
            second: Some(AxisConfig {
                cycles: Cycles::default(),
                ..self.second.clone()
            }),
        }
    }
}

impl Machine {
    /// The same machine with another description of a gantry's second end; itself without a gantry.
    /// The caller checks it ([`AxisConfig::check`]).
    #[must_use]
    pub fn with_second_config(&self, config: &AxisConfig) -> Machine {
        let gantry = self
            .gantry
            .as_ref()
            .map(|gantry| gantry.map(|_| self.in_step(config)));
        Machine {
            gantry,
            ..self.clone()
        }
    }

    /// The drive of an axis by name: its letter, and behind it a 2 for the second motor of a
    /// gantry.
    pub fn drive(&self, name: &str) -> Option<&AxisConfig> {
        // `y2` is the second motor of `y`.
        let (letter, second) = name
            .strip_suffix('2')
            .map_or((name, false), |letter| (letter, true));
        let mut letters = letter.chars();
        let (letter, None) = (letters.next()?, letters.next()) else {
            return None;
        };
        let id = AxisId::from_letter(letter)?;
        if second {
            return self
                .gantry
                .as_ref()
                .filter(|gantry| gantry.axis == id)
                .map(|gantry| &gantry.second);
        }
        self.axis(id).map(|axis| &axis.config)
    }

    /// Names of all drives, for [`Machine::drive`].
    pub fn drives(&self) -> Vec<String> {
        let letter = |id: AxisId| id.letter().to_ascii_lowercase().to_string();
        let second = self.gantry.iter().map(|gantry| letter(gantry.axis) + "2");
        self.axes
            .iter()
            .map(|axis| letter(axis.id))
            .chain(second)
            .collect()
    }
}

/// The gantry of a file, if it has one.
pub(super) fn read(
    document: &Document<'_>,
    axes: &[MachineAxis],
    cycles: Cycles,
    problems: &mut Vec<Problem>,
) -> Option<Gantry> {
    let part = document.root.get("gantry")?;
    let table: GantryFile = section::read(document, "gantry", part, &[], problems)?;
    let before = problems.len();
    let mut linear = |key: &str, letter: char| {
        let axis = axes
            .iter()
            .find(|axis| axis.id.letter().to_ascii_lowercase() == letter && !axis.id.is_rotary());
        if axis.is_none() {
            let message = format!("the machine has no linear axis `{letter}`");
            problems.push(document.problem(
                &format!("gantry.{key}"),
                message,
                "name one of its axes, in lower case",
            ));
        }
        axis
    };
    let (axis, along) = (linear("axis", table.axis), linear("along", table.along));
    // Both were looked for first, so that both mistakes are told.
    let (axis, along) = (axis?, along?);
    if axis.id == along.id {
        problems.push(document.problem(
            "gantry.along",
            "is the beam's own axis",
            "name the axis that moves the tool along the beam",
        ));
    }
    let at_mm = [table.first_at_mm, table.second_at_mm];
    if (at_mm[1] - at_mm[0]).abs() < LEAST_BEAM_MM
        || at_mm.iter().any(|at| !at.is_finite() || at.abs() > 1e6)
    {
        let message = format!(
            "is {}; the ends of the beam have to lie {LEAST_BEAM_MM} mm apart at least",
            table.second_at_mm
        );
        problems.push(document.problem("gantry.second_at_mm", message, ""));
    }
    let mut second = table.second.unwrap_or_else(|| axis.config.clone());
    // Both motors run in the machine's cycles, whatever their table says.
    second.cycles = cycles;
    if let Some(gap_um) = table.second_gap_um {
        if !(0.0..=1e6).contains(&gap_um) {
            problems.push(document.problem(
                "gantry.second_gap_um",
                format!("is {gap_um}; it has to be from 0 to 1e6"),
                "",
            ));
            return None;
        }
        second = second.with_gap(gap_um * 1e-3);
    }
    check::config(document, "gantry.second", &second, problems);
    check::transmissions(document, &axis.config, &second, problems);
    // The beam is held against both ends, which have to be sound for that.
    if let (Some(beam), true) = (&table.beam, problems.len() == before) {
        let found = beam.check([&axis.config, &second]).err();
        problems.extend(found.map(|error| check::axis_problem(document, "gantry.beam", &error)));
    }
    (problems.len() == before).then_some(Gantry {
        axis: axis.id,
        along: along.id,
        at_mm,
        second,
        beam: table.beam,
    })
}
