//! From the text of a machine file to a machine, or to all that is wrong with it.

use super::document::{Change, ChangedText, Document, not_finite};
use super::limits::{LimitsTable, LinearLimits, RotaryLimits};
use super::problem::{MachineError, Problem, UNKNOWN_KEY};
use super::section::{join, read};
use super::{
    General, Homes, Machine, MachineAxis, PlannerSettings, SimulateSettings, ToolEntry, WorkOffsets,
};
use super::{check, gantry};
use lostmotion_base::AxisId;
use lostmotion_base::names::did_you_mean;
use lostmotion_drive::config::Cycles;
use lostmotion_gcode::{Dialect, Units};
use lostmotion_kinematics::{KINDS, KindInfo, KindSpec, KindVisitor, KinematicsSpec};
use lostmotion_methods::AxisConfig;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Tables of a machine file that are read on their own.
const TABLES: [&str; 10] = [
    "cycles",
    "gantry",
    "kinematics",
    "planner",
    "simulate",
    "start",
    "work_offset",
    "home",
    "tool",
    "axis",
];

/// Keys of a machine file outside any table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Head {
    /// Name of the machine in results.
    name: String,
    /// One line for people.
    #[serde(default)]
    description: String,
    /// Dialect that its programs are in.
    #[serde(default)]
    dialect: Dialect,
    /// Unit of length of the control's settings, parameters and tool table; the machine file itself
    /// is in mm.
    #[serde(default)]
    control_units: Units,
    /// Unit of length in which programs start, without G20 and G21; `control_units` if left out.
    #[serde(default)]
    program_units: Option<Units>,
    /// Letters of the axes of LinuxCNC's joints in the order of their numbers, `XYYZ` or `X-Z` with
    /// a joint of no axis; each axis once, in their order, if left out.
    #[serde(default)]
    joint_axes: Option<String>,
}

impl Machine {
    /// Reads and checks a machine file. `name` is the file's name, for messages only.
    ///
    /// # Errors
    /// Everything that is wrong: syntax; or else unknown, missing and mistyped keys and, as far as
    /// what was read allows, values out of their range and parts that do not go together.
    pub fn from_toml(name: &str, text: &str) -> Result<Machine, MachineError> {
        Machine::from_changed_toml(name, text, &[])
    }

    /// The same with values in place of the file's own, checked as if they stood there.
    ///
    /// # Errors
    /// As [`Machine::from_toml`]; problems with a change carry its name.
    ///
    /// # Examples
    /// ```
    /// use lostmotion_sim::Machine;
    /// use lostmotion_sim::machine::{Change, presets};
    ///
    /// let softer = Change {
    ///     key: "axis.x.drive.position_gain_per_s".to_owned(),
    ///     value: "30".to_owned(),
    ///     name: "my change".to_owned(),
    /// };
    /// let machine = Machine::from_changed_toml("vmc3", presets()[0].toml, &[softer])?;
    /// assert_eq!(machine.axes()[0].config.drive.position_gain_per_s, 30.0);
    /// # Ok::<(), lostmotion_sim::machine::MachineError>(())
    /// ```
    pub fn from_changed_toml(
        name: &str,
        text: &str,
        changes: &[Change],
    ) -> Result<Machine, MachineError> {
        let changed = ChangedText::new(text, changes);
        let document =
            Document::parse(&changed).map_err(|problems| MachineError::new(name, problems))?;
        // First, since of several problems with a key the first is kept: inf and nan are told as
        // what they are.
        let mut problems = non_finite_numbers(&document);
        let general = read_general(&document, &mut problems);
        let mut axes = read_axes(&document, &mut problems);
        // Cycles out of range are told once, not again for each axis.
        let cycles = general
            .as_ref()
            .map(|general| general.cycles)
            .filter(|cycles| cycles.check().is_ok());
        for axis in &mut axes {
            axis.config.cycles = cycles.unwrap_or_default();
        }
        check::axes(&document, general.as_ref(), &axes, &mut problems);
        let gantry = gantry::read(&document, &axes, cycles.unwrap_or_default(), &mut problems);
        if let Some(general) = &general {
            check::general(&document, general, &axes, &mut problems);
        }
        match general {
            Some(general) if problems.is_empty() => Ok(Machine {
                general,
                axes,
                gantry,
            }),
            _ => Err(MachineError::new(name, problems)),
        }
    }
}

/// Reads and checks a file that describes one axis alone (the tables of `[axis.x]` besides
/// `limits`). `name` is the file's name, for messages only.
///
/// # Errors
/// Everything that is wrong, as [`Machine::from_toml`].
pub fn axis_from_toml(name: &str, text: &str) -> Result<AxisConfig, MachineError> {
    axis_from_changed_toml(name, text, &[])
}

/// An axis as a file that [`axis_from_toml`] reads back to an equal one.
///
/// ```
/// use lostmotion_sim::machine::{axis_from_toml, axis_preset_toml, axis_to_toml};
///
/// let axis = axis_from_toml("paper", &axis_preset_toml("paper").ok_or("no preset")?)?;
/// assert_eq!(axis_from_toml("again", &axis_to_toml(&axis)?)?, axis);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A number that TOML cannot hold.
pub fn axis_to_toml(axis: &AxisConfig) -> Result<String, toml::ser::Error> {
    toml::to_string_pretty(axis)
}

/// The same with values in place of the file's own, as [`Machine::from_changed_toml`].
///
/// # Errors
/// Everything that is wrong, as [`Machine::from_toml`].
pub fn axis_from_changed_toml(
    name: &str,
    text: &str,
    changes: &[Change],
) -> Result<AxisConfig, MachineError> {
    let changed = ChangedText::new(text, changes);
    let document =
        Document::parse(&changed).map_err(|problems| MachineError::new(name, problems))?;
    let mut problems = non_finite_numbers(&document);
    let config: Option<AxisConfig> = read(
        &document,
        "",
        &spanned(document.root.clone(), 0..0),
        &[],
        &mut problems,
    );
    if let Some(config) = &config {
        check::config(&document, "", config, &mut problems);
    }
    match config {
        Some(config) if problems.is_empty() => Ok(config),
        _ => Err(MachineError::new(name, problems)),
    }
}

pub(super) fn non_finite_numbers(document: &Document<'_>) -> Vec<Problem> {
    let report = |(key, value): (String, String)| {
        document.problem(
            &key,
            format!("is {value}; it has to be a finite number"),
            "",
        )
    };
    not_finite(&document.root).into_iter().map(report).collect()
}

/// A table as a value, with a place.
pub(super) fn spanned(table: DeTable<'_>, at: std::ops::Range<usize>) -> Spanned<DeValue<'_>> {
    Spanned::new(at, DeValue::Table(table))
}

fn read_general(document: &Document<'_>, problems: &mut Vec<Problem>) -> Option<General> {
    // Every table is read by itself, so that an error in one does not hide those of the others.
    let mut head = document.root.clone();
    for table in TABLES {
        head.remove(table);
    }
    let head: Option<Head> = read(document, "", &spanned(head, 0..0), &TABLES, problems);
    let kinematics = read_kinematics(document, problems);
    let cycles: Option<Cycles> = table_or_default(document, "cycles", problems);
    let planner: Option<PlannerSettings> = table_or_default(document, "planner", problems);
    let simulate: Option<SimulateSettings> = table_or_default(document, "simulate", problems);
    let work_offset: Option<WorkOffsets> = table_or_default(document, "work_offset", problems);
    let home: Option<Homes> = table_or_default(document, "home", problems);
    let tool: Option<Vec<ToolEntry>> = table_or_default(document, "tool", problems);
    let start = if document.root.contains_key("start") {
        table(document, "start", problems).map(Some)
    } else {
        Some(None)
    };
    // Only now: every table has told its problems.
    let head = head?;
    Some(General {
        name: head.name,
        description: head.description,
        dialect: head.dialect,
        control_units: head.control_units,
        program_units: head.program_units,
        joint_axes: head.joint_axes,
        cycles: cycles?,
        kinematics: kinematics?,
        planner: planner?,
        simulate: simulate?,
        start: start?,
        work_offset: work_offset?,
        home: home?,
        tool: tool?,
    })
}

/// The key of `[kinematics]` that all kinds have.
#[derive(Deserialize)]
struct KindName {
    kind: String,
}

/// `[kinematics]`: `kind` says which type the other keys are read into.
fn read_kinematics(document: &Document<'_>, problems: &mut Vec<Problem>) -> Option<KinematicsSpec> {
    let Some(part) = document.root.get("kinematics") else {
        problems.push(document.problem(
            "kinematics",
            "missing",
            "add a table [kinematics] with kind = \"cartesian\"",
        ));
        return None;
    };
    let KindName { kind } = read(document, "kinematics", part, &[], problems)?;
    let mut keys = part.get_ref().as_table()?.clone();
    // It chooses the type, which does not know it.
    keys.remove("kind");
    let before = problems.len();
    let read = KinematicsSpec::visit_kind(
        &kind,
        KindReader {
            document,
            part: spanned(keys, part.span()),
            problems,
        },
    );
    for problem in problems.iter_mut().skip(before) {
        tell_other_kinds(problem, &kind);
    }
    match read {
        Ok(spec) => spec,
        Err(unknown) => {
            let known: Vec<&str> = KINDS.iter().map(|info| info.kind).collect();
            let hint = did_you_mean(&kind, &known);
            problems.push(document.problem("kinematics.kind", unknown.to_string(), hint));
            None
        }
    }
}

/// Reads the keys of a kind.
struct KindReader<'a, 'd> {
    document: &'a Document<'d>,
    part: Spanned<DeValue<'a>>,
    problems: &'a mut Vec<Problem>,
}

impl KindVisitor for KindReader<'_, '_> {
    type Output = Option<KinematicsSpec>;

    fn visit<S: KindSpec>(self) -> Option<KinematicsSpec> {
        let spec: Option<S> = read(
            self.document,
            "kinematics",
            &self.part,
            &["kind"],
            self.problems,
        );
        spec.map(Into::into)
    }
}

/// Says of a key that only other kinds have which these are.
fn tell_other_kinds(problem: &mut Problem, kind: &str) {
    let Some(key) = problem
        .key
        .strip_prefix("kinematics.")
        .filter(|_| problem.message == UNKNOWN_KEY)
    else {
        return;
    };
    let others: Vec<&str> = KINDS
        .iter()
        .filter(|info| info.keys().contains(&key))
        .map(|info| info.kind)
        .collect();
    // A key of no kind at all stays an unknown key.
    if others.is_empty() {
        return;
    }
    problem.message = format!("is a key of kind {}, not of {kind}", others.join(", "));
    let own = KINDS.iter().find(|info| info.kind == kind);
    problem.hint = match own.map(KindInfo::keys) {
        None | Some([]) => format!("{kind} has no keys besides `kind`"),
        Some(keys) => format!("{kind} takes {}", keys.join(", ")),
    };
}

fn table<T: DeserializeOwned>(
    document: &Document<'_>,
    key: &str,
    problems: &mut Vec<Problem>,
) -> Option<T> {
    document
        .root
        .get(key)
        .and_then(|part| read(document, key, part, &[], problems))
}

fn table_or_default<T: DeserializeOwned + Default>(
    document: &Document<'_>,
    key: &str,
    problems: &mut Vec<Problem>,
) -> Option<T> {
    if document.root.contains_key(key) {
        table(document, key, problems)
    } else {
        Some(T::default())
    }
}

fn read_axes(document: &Document<'_>, problems: &mut Vec<Problem>) -> Vec<MachineAxis> {
    let Some(part) = document.root.get("axis") else {
        problems.push(document.problem(
            "axis",
            "missing",
            "add a table for each axis: [axis.x.limits], [axis.x.motor], ...",
        ));
        return Vec::new();
    };
    let Some(tables) = part.get_ref().as_table() else {
        problems.push(document.problem(
            "axis",
            "has to be a table of axes",
            "write [axis.x.limits] and so on",
        ));
        return Vec::new();
    };
    let mut axes: Vec<MachineAxis> = tables
        .iter()
        .filter_map(|(letter, table)| read_axis(document, letter.get_ref(), table, problems))
        .collect();
    // In index order, as results list them.
    axes.sort_by_key(|axis| axis.id);
    axes
}

/// The axis that a key of `[axis]` names.
fn letter(name: &str) -> Option<AxisId> {
    let mut letters = name.chars();
    match (letters.next(), letters.next()) {
        // Lower case alone: a key has one spelling.
        (Some(letter), None) if letter.is_ascii_lowercase() => AxisId::from_letter(letter),
        _ => None,
    }
}

fn read_axis(
    document: &Document<'_>,
    name: &str,
    part: &Spanned<DeValue<'_>>,
    problems: &mut Vec<Problem>,
) -> Option<MachineAxis> {
    let key = join("axis", name);
    let Some(id) = letter(name) else {
        let hint = did_you_mean(
            &name.to_lowercase(),
            &["x", "y", "z", "a", "b", "c", "u", "v", "w"],
        );
        problems.push(document.problem(&key, "no axis has this name", hint));
        return None;
    };
    let Some(all) = part.get_ref().as_table() else {
        problems.push(document.problem(
            &key,
            "has to be a table",
            format!("write [{key}.limits], [{key}.motor] and so on"),
        ));
        return None;
    };
    // What is left is an axis as it may stand alone, without a travel.
    let mut rest = all.clone();
    let limits = rest.remove("limits");
    // An axis alone may have cycles of its own; the axes of a machine share one clock.
    if rest.remove("cycles").is_some() {
        let hint = "all axes of a machine run in the same cycles: write a table [cycles] at the top of the file";
        problems.push(document.problem(&join(&key, "cycles"), "is not an axis' own", hint));
    }
    let config: Option<AxisConfig> = read(
        document,
        &key,
        &spanned(rest, part.span()),
        &["limits"],
        problems,
    );
    let key = join(&key, "limits");
    let Some(limits) = limits else {
        problems.push(document.problem(
            &key,
            "missing",
            format!("add a table [{key}] with travel, velocity, acceleration and jerk"),
        ));
        return None;
    };
    // Limits in degrees belong to a joint that turns, whatever its letter: those of arms have all
    // of them.
    let in_degrees = limits
        .get_ref()
        .as_table()
        .is_some_and(|table| table.keys().any(|key| key.get_ref().contains("_deg")));
    let table = if in_degrees || id.is_rotary() {
        read::<RotaryLimits>(document, &key, &limits, &[], problems).map(LimitsTable::Rotary)
    } else {
        read::<LinearLimits>(document, &key, &limits, &[], problems).map(LimitsTable::Linear)
    }?;
    Some(MachineAxis {
        id,
        limits: table.limits(),
        config: config?,
        table,
    })
}
