//! What a description lacks, from a machine that lends it, and the whole as a machine file.

use super::draft::{Draft, DraftAxis, Fate, MachineSize, Row, Told, filled, float};
use super::places::{home_of, positions};
use super::{Imported, USUAL_PRESET, gantry, problem, stepper};
use crate::control::Control;
use crate::machine::{LimitsTable, Machine, MachineAxis, PathStops, Problem, presets};
use lostmotion_base::units::rad;
use lostmotion_drive::config::{AxisUnit, Cycles};
use lostmotion_gcode::Units;
use lostmotion_kinematics::{KinematicsSpec, Words};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write;

/// Lends rotary axes where the preset has none.
const ROTARY_LENDER: &str = "trunnion5";

/// Ends of an axis that turns and of which no control told an end, degrees: as often round as
/// programs go. The lender's are those of a tilting table.
const ENDLESS_DEG: f64 = 36_000.0;

/// Places of limits: min, max, velocity, acceleration, jerk.
const MIN: usize = 0;
const MAX: usize = 1;
const VELOCITY: usize = 2;
const ACCELERATION: usize = 3;
const JERK: usize = 4;

/// How far off a gap may be that is lent or a guess, as a part of it. A choice: between machines of one
/// kind gaps differ by ten times, and what nobody measured is not to be set or rewritten for.
const OF_GUESSED_GAP: f64 = 0.9;

/// Time in which a control without a limit of jerk reaches its acceleration here, s. A choice: some
/// cycles of the control.
const SUDDEN_S: f64 = 5e-3;
/// What machine files take as a jerk.
const LEAST_JERK: f64 = 0.1;
const MOST_JERK: f64 = 1e9;

/// A machine file out of a draft.
pub(super) fn machine(
    file: &str,
    mut draft: Draft,
    named: Option<&str>,
) -> Result<Imported, Vec<Problem>> {
    let preset = named.unwrap_or(USUAL_PRESET);
    check_preset(preset)?;
    // In the order of the axes, as machine files and results have them.
    draft.axes.sort_by_key(|axis| axis.id);
    let reversed: Vec<Problem> = draft.axes.iter().filter_map(reversed).collect();
    if !reversed.is_empty() {
        return Err(reversed);
    }
    let mut rows = std::mem::take(&mut draft.rows);
    if named.is_some() {
        unused_steps(&draft, preset, &mut rows);
    } else {
        unused_errors(&mut draft, &mut rows);
    }
    let mut axes = String::new();
    let travel = sections(&draft, named, &mut axes, &mut rows)?;
    // A pose has several solutions: home says on which of them the machine stands.
    if let KinematicsSpec::Chain(chain) = &mut draft.kinematics
        && chain.words == Some(Words::Pose)
    {
        let home: Vec<f64> = chain
            .joint
            .iter()
            .map(|joint| home_of(joint, &draft.axes, &travel))
            .collect();
        rows.push(filled(
            "kinematics.home",
            format!("{home:?}"),
            "within the travel, away from straight poses: chooses among the solutions",
        ));
        chain.home = Some(home);
    }
    let mut toml = head(&draft, preset);
    general(&draft, named.is_none(), &mut toml, &mut rows);
    positions(&draft, &travel, &mut toml, &mut rows)?;
    gantry::table(&draft, &travel, &mut axes, &mut rows);
    toml.push_str(&axes);
    // Read back like any machine file. The lines of a problem would be those of the generated text, which is not at
    // hand then: it is of the line that its key was made of.
    Machine::from_stable_toml(file, &toml)
        .map(|_| Imported { toml, rows })
        .map_err(|error| {
            let found = error.problems.into_iter();
            found.map(|problem| placed(problem, &draft)).collect()
        })
}

/// A problem of the machine file at the line that was read.
fn placed(found: Problem, draft: &Draft) -> Problem {
    let Some(told) = draft.told(&found.key) else {
        return Problem {
            line: 1,
            column: 1,
            ..found
        };
    };
    Problem {
        line: u32::try_from(told.line).unwrap_or(u32::MAX),
        column: 1,
        message: format!("{}, by {} = {}", found.message, told.from, told.value),
        ..found
    }
}

/// Refuses a preset that there is not.
fn check_preset(preset: &str) -> Result<(), Vec<Problem>> {
    let known: Vec<&str> = presets().iter().map(|info| info.name).collect();
    if known.contains(&preset) {
        return Ok(());
    }
    Err(vec![problem(
        1,
        "preset",
        format!("there is no machine `{preset}`"),
        &format!("known are {}", known.join(", ")),
    )])
}

/// Writes the sections of all axes; gives their travel, mm or deg. Told limits stay; drive, motor, load and all
/// other limits come from the lender.
fn sections(
    draft: &Draft,
    named: Option<&str>,
    out: &mut String,
    rows: &mut Vec<Row>,
) -> Result<Vec<(f64, f64)>, Vec<Problem>> {
    let mut travel = Vec::new();
    let mut lenders = BTreeMap::new();
    let preset = named.unwrap_or(USUAL_PRESET);
    for axis in &draft.axes {
        let lender = lender(axis, preset, &mut lenders).ok_or_else(|| {
            vec![problem(
                1,
                "preset",
                format!("no machine lends an axis like {}", axis.id),
                "",
            )]
        })?;
        // A machine that the user names lends its servos, whatever moves the axis.
        let stepper = axis.stepper.as_ref().filter(|_| named.is_none());
        let ends = Ends::of(draft, axis, &lender, named);
        let (ends, dynamic) = limits(axis, &lender, stepper.is_some(), ends, out, rows);
        travel.push(ends);
        match stepper {
            Some(own) => stepper::drive(axis, own, draft.size, dynamic, out, rows),
            None => section(axis, &lender, out, rows),
        }
        compensation(axis, named.is_some(), out, rows);
    }
    Ok(travel)
}

/// What is told of steppers means nothing where a machine is named that lends its servos.
fn unused_steps(draft: &Draft, preset: &str, rows: &mut [Row]) {
    for axis in &draft.axes {
        let Some(own) = &axis.stepper else { continue };
        let told = [
            &own.per_turn,
            &own.steps_per_unit,
            &own.full_steps,
            &own.microsteps,
            &own.peak_current_a,
        ];
        for told in told.into_iter().flatten() {
            let used = |row: &&mut Row| row.key == told.from && row.fate == Fate::Used;
            if let Some(row) = rows.iter_mut().find(used) {
                row.fate = Fate::Ignored;
                row.note = format!("of the stepper: the drive comes from {preset}");
            }
        }
    }
}

/// Limits of the following error of a stepper are of the control's own count, in which no lost step is seen.
fn unused_errors(draft: &mut Draft, rows: &mut [Row]) {
    for axis in draft.axes.iter_mut().filter(|it| it.stepper.is_some()) {
        for told in [axis.following_error.take(), axis.standstill_error.take()] {
            let Some(told) = told else { continue };
            let used = |row: &&mut Row| row.key == told.from && row.fate == Fate::Used;
            if let Some(row) = rows.iter_mut().find(used) {
                row.fate = Fate::Ignored;
                row.note = format!(
                    "axis {}: of the pulses of a stepper, which follow; the machine stops where its rotor loses a step",
                    axis.id
                );
            }
        }
    }
}

/// A travel that is told and is none.
fn reversed(axis: &DraftAxis) -> Option<Problem> {
    let (min, max) = (axis.min.as_ref()?, axis.max.as_ref()?);
    let message = format!(
        "travel of {} from {} ({}) to {}",
        axis.id, min.value, min.from, max.value
    );
    (min.value >= max.value).then(|| {
        problem(
            max.line,
            &max.from,
            message,
            "the first has to be below the second",
        )
    })
}

/// An axis of a preset, with its text.
struct Lender {
    preset: &'static str,
    letter: char,
    text: &'static str,
    axis: MachineAxis,
}

/// The axis of the same letter, else the first of the same kind, of the preset, else of one that
/// has rotary axes.
fn lender(
    axis: &DraftAxis,
    preset: &str,
    read: &mut BTreeMap<&'static str, Machine>,
) -> Option<Lender> {
    [preset, ROTARY_LENDER].into_iter().find_map(|name| {
        let info = presets().iter().find(|info| info.name == name)?;
        let machine = match read.entry(info.name) {
            Entry::Occupied(found) => found.into_mut(),
            Entry::Vacant(place) => place.insert(Machine::preset(name).ok()?),
        };
        // What drives a slide does not fit a joint that turns.
        let same = machine
            .axes()
            .iter()
            .filter(|other| other.is_rotary() == axis.rotary);
        let found = same
            .clone()
            .find(|other| other.id == axis.id)
            .or_else(|| same.clone().next())?;
        Some(Lender {
            preset: info.name,
            letter: found.id.letter().to_ascii_lowercase(),
            text: info.toml,
            axis: found.clone(),
        })
    })
}

/// The limits that the lender has, in the order min, max, velocity, acceleration, jerk.
fn lent(axis: &MachineAxis) -> [f64; 5] {
    match *axis.limits_table() {
        LimitsTable::Linear(l) => [
            l.min_mm,
            l.max_mm,
            l.velocity_mm_s,
            l.acceleration_mm_s2,
            l.jerk_mm_s3,
        ],
        LimitsTable::Rotary(r) => [
            r.min_deg,
            r.max_deg,
            r.velocity_deg_s,
            r.acceleration_deg_s2,
            r.jerk_deg_s3,
        ],
    }
}

/// Where the ends of a travel come from that are not told.
#[derive(Clone, Copy, PartialEq)]
enum Ends {
    Lent,
    /// As far from the one that is told as the lender's are apart.
    Opposite,
    /// As long as the lender's, from zero on.
    FromZero,
    /// Turning as often as it likes.
    Endless,
}

impl Ends {
    /// For an axis of a draft; `named` is the machine that the user names.
    fn of(draft: &Draft, axis: &DraftAxis, lender: &Lender, named: Option<&str>) -> Ends {
        let kinematics = &draft.kinematics;
        let is_cartesian = matches!(kinematics, KinematicsSpec::Cartesian(_));
        if axis.min.is_some() != axis.max.is_some() {
            return Ends::Opposite;
        }
        let is_told = axis.min.is_some();
        // Printers have their bed beyond zero, and nothing but its length is lent.
        let from_zero = draft.size == MachineSize::Printer
            && (is_cartesian || matches!(kinematics, KinematicsSpec::CoreXy(_)))
            && !axis.rotary;
        let endless = lender.preset == ROTARY_LENDER
            && named != Some(ROTARY_LENDER)
            && is_cartesian
            && axis.rotary;
        match (is_told, from_zero, endless) {
            (false, true, _) => Ends::FromZero,
            (false, _, true) => Ends::Endless,
            _ => Ends::Lent,
        }
    }
}

/// Writes an axis' limits, of one that steps or not; gives its travel, and its velocity and
/// acceleration.
fn limits(
    axis: &DraftAxis,
    lender: &Lender,
    steps: bool,
    ends: Ends,
    out: &mut String,
    rows: &mut Vec<Row>,
) -> ((f64, f64), [f64; 2]) {
    let letter = axis.id.letter().to_ascii_lowercase();
    let unit = if axis.rotary { "deg" } else { "mm" };
    let told: [Option<&Told>; 5] = [
        axis.min.as_ref(),
        axis.max.as_ref(),
        axis.velocity.as_ref(),
        axis.acceleration.as_ref(),
        axis.jerk.as_ref(),
    ];
    let keys = [
        format!("min_{unit}"),
        format!("max_{unit}"),
        format!("velocity_{unit}_s"),
        format!("acceleration_{unit}_s2"),
        format!("jerk_{unit}_s3"),
    ];
    let source = format!("{}:{}", lender.preset, lender.letter);
    let _ = write!(out, "\n# ---- {} ----\n[axis.{letter}.limits]\n", axis.id);
    let mut values = [0.0; 5];
    let mut lent = lent(&lender.axis);
    let guess = match ends {
        Ends::Lent => None,
        Ends::FromZero => {
            lent[MAX] -= lent[MIN];
            lent[MIN] = 0.0;
            Some("guess: a travel that begins at zero, as long as a mill's".to_owned())
        }
        Ends::Endless => {
            (lent[MIN], lent[MAX]) = (-ENDLESS_DEG, ENDLESS_DEG);
            Some("guess: no end is told, so that it turns as often as it likes".to_owned())
        }
        Ends::Opposite => {
            let length = lent[MAX] - lent[MIN];
            lent[MIN] = axis
                .max
                .as_ref()
                .map_or(lent[MIN], |max| max.value - length);
            lent[MAX] = axis
                .min
                .as_ref()
                .map_or(lent[MAX], |min| min.value + length);
            Some(format!(
                "guess: one end is told, and the travel as long as that of preset {source}"
            ))
        }
    };
    for (place, (told, key)) in told.into_iter().zip(keys).enumerate() {
        // What is told goes before what is lent, and every line says which of the two it is.
        let (value, from, fate) = match told {
            Some(told) => (told.value, told.from.clone(), Fate::Used),
            // Controls of steppers know no jerk: theirs is as sudden as their cycle.
            None if steps && place == JERK => (
                (values[ACCELERATION] / SUDDEN_S).clamp(LEAST_JERK, MOST_JERK),
                "guess: such controls have no limit of jerk".to_owned(),
                Fate::Guessed,
            ),
            None => match guess.as_ref().filter(|_| place == MIN || place == MAX) {
                Some(guess) => (lent[place], guess.clone(), Fate::Guessed),
                None => (lent[place], format!("preset {source}"), Fate::Filled),
            },
        };
        values[place] = value;
        let _ = writeln!(out, "{key} = {} # {from}", float(value));
        if fate != Fate::Used {
            rows.push(Row {
                key: format!("axis.{letter}.limits.{key}"),
                value: float(value),
                fate,
                note: from,
            });
        }
    }
    (
        (values[0], values[1]),
        [values[VELOCITY], values[ACCELERATION]],
    )
}

/// Writes drive, motor and load of the lender.
fn section(axis: &DraftAxis, lender: &Lender, out: &mut String, rows: &mut Vec<Row>) {
    let letter = axis.id.letter().to_ascii_lowercase();
    let source = format!("{}:{}", lender.preset, lender.letter);
    let _ = write!(
        out,
        "\n# drive, motor and load: preset {source}, where every value has its source\n"
    );
    // The lender's own lines with this axis' letter, and the gap where it is told.
    for line in parts(lender.text, lender.letter) {
        let line = line.replace(
            &format!("[axis.{}.", lender.letter),
            &format!("[axis.{letter}."),
        );
        let gap = axis.gap.as_ref().filter(|_| line.starts_with("gap_"));
        match gap {
            Some(gap) => {
                let key = if axis.rotary { "gap_mdeg" } else { "gap_um" };
                let _ = writeln!(out, "{key} = {} # {}", float(gap.value * 1e3), gap.from);
            }
            None => {
                let _ = writeln!(out, "{line}");
            }
        }
    }
    monitoring(axis, lender, out);
    let what = if axis.gap.is_some() {
        "drive, motor, load"
    } else {
        "drive, motor, load, gap"
    };
    rows.push(filled(
        format!("axis.{letter}"),
        what,
        format!("preset {source}"),
    ));
}

/// Writes the method that the control runs, and how little is known of a gap that nobody told, neither
/// the description nor the user by the name of a machine.
fn compensation(axis: &DraftAxis, is_named: bool, out: &mut String, rows: &mut Vec<Row>) {
    let letter = axis.id.letter().to_ascii_lowercase();
    let is_told = axis.gap.is_some() || is_named;
    if is_told && axis.carried.is_none() {
        return;
    }
    let _ = write!(out, "\n[axis.{letter}.compensation]\n");
    if !is_told {
        let note =
            "nobody tells the gap: methods are told a tenth of this one until it is measured";
        let value = float(OF_GUESSED_GAP);
        let _ = writeln!(out, "gap_uncertainty = {value} # guess: {note}");
        rows.push(Row {
            key: format!("axis.{letter}.compensation.gap_uncertainty"),
            value,
            fate: Fate::Guessed,
            note: note.to_owned(),
        });
    }
    let Some(carried) = &axis.carried else { return };
    let _ = writeln!(
        out,
        "# the control does it already: {}\nmethod = \"{}\"",
        carried.from, carried.method
    );
    let table = carried.method.replace('-', "_");
    if !carried.settings.is_empty() {
        let _ = write!(out, "\n[axis.{letter}.compensation.{table}]\n");
    }
    for (key, value) in &carried.settings {
        let _ = writeln!(out, "{key} = {}", float(*value));
    }
}

/// Writes the limits of the following error that are told, in the unit of the axis that lends its
/// drive.
fn monitoring(axis: &DraftAxis, lender: &Lender, out: &mut String) {
    let letter = axis.id.letter().to_ascii_lowercase();
    let told = [
        ("following_error_units", &axis.following_error),
        ("standstill_error_units", &axis.standstill_error),
    ];
    let told = told.map(|(key, value)| value.as_ref().map(|value| (key, value)));
    if told.iter().all(Option::is_none) {
        return;
    }
    let _ = write!(out, "\n[axis.{letter}.monitoring]\n");
    for (key, Told { value, from, .. }) in told.into_iter().flatten() {
        // Told in mm or deg; an axis may be described in rad.
        let value = if lender.axis.config.unit() == AxisUnit::Rad {
            rad(*value)
        } else {
            *value
        };
        let _ = writeln!(out, "{key} = {} # {from}", float(value));
    }
}

/// The lines of an axis in a preset's text, without its limits.
fn parts(text: &str, letter: char) -> Vec<&str> {
    let own = format!("[axis.{letter}.");
    let mut lines: Vec<&str> = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        if line.starts_with('[') {
            inside = line.starts_with(&own) && !line.ends_with(".limits]");
        } else if line.starts_with("# ----") {
            // A heading belongs to the axis behind it.
            inside = false;
        }
        if inside {
            lines.push(line);
        }
    }
    // Blank lines and comments at the end belong to what is behind them.
    while lines
        .last()
        .is_some_and(|line| line.is_empty() || line.starts_with('#'))
    {
        lines.pop();
    }
    lines
}

fn head(draft: &Draft, preset: &str) -> String {
    // These would end the string in the file.
    let name = draft.name.replace(['"', '\\', '\n'], " ");
    let mut text = format!(
        "# Imported from {}; what it does not say was taken from `{preset}` or another machine, or is a guess, as every comment tells.\n\nname = \"{name}\"\ndescription = \"imported from {}\"\n\n",
        draft.source, draft.source
    );
    if let Some(dialect) = draft.dialect {
        let _ = write!(text, "dialect = \"{dialect}\"\n\n");
    }
    control_keys(draft, &mut text);
    #[derive(serde::Serialize)]
    struct Tables<'a> {
        kinematics: &'a KinematicsSpec,
    }
    let _ = write!(
        text,
        "# {}\n{}\n",
        draft.source,
        toml::to_string(&Tables {
            kinematics: &draft.kinematics
        })
        .unwrap_or_default()
    );
    text
}

/// How the control counts: its units, those in which programs start, and its joints.
fn control_keys(draft: &Draft, text: &mut String) {
    let before = text.len();
    let name = |units: Units| match units {
        Units::Mm => "mm",
        Units::Inch => "inch",
    };
    let (control, from) = &draft.control_units;
    if *control != Units::Mm {
        let _ = writeln!(text, "control_units = \"{}\" # {from}", name(*control));
    }
    if let Some((units, from)) = &draft.program_units
        && units != control
    {
        let _ = writeln!(text, "program_units = \"{}\" # {from}", name(*units));
    }
    if let Some(letters) = draft.joint_letters() {
        let _ = writeln!(text, "joint_axes = \"{letters}\"");
    }
    if text.len() > before {
        text.push('\n');
    }
}

/// Cycles, tolerance of the path, control and tools, as far as they are told.
fn general(draft: &Draft, steps: bool, out: &mut String, rows: &mut Vec<Row>) {
    let steps = steps && draft.axes.iter().any(|axis| axis.stepper.is_some());
    if steps || draft.command_ms.is_some() {
        let command_ms = draft.command_ms.as_ref().map_or(1.0, |told| told.value);
        let longest_us = if steps {
            stepper::servo_us(&draft.axes, draft.size)
        } else {
            Cycles::default().servo_us
        };
        out.push_str("\n[cycles]\n");
        if let Some(told) = &draft.command_ms {
            let _ = writeln!(out, "command_ms = {} # {}", float(command_ms), told.from);
        }
        let servo_us = part_of(command_ms, longest_us);
        let _ = writeln!(out, "servo_us = {}", float(servo_us));
        if steps {
            rows.push(filled(
                "cycles.servo_us",
                float(servo_us),
                "the rotor of a stepper is followed by no loop: short, so that it swings as it does",
            ));
        }
    }
    let stops = draft.control.map_or(PathStops::Never, Control::stops);
    if draft.path_tolerance_mm.is_some() || stops != PathStops::Never {
        out.push_str("\n[planner]\n");
    }
    if let Some(told) = &draft.path_tolerance_mm {
        let _ = writeln!(
            out,
            "default_tolerance_mm = {} # {}",
            float(told.value),
            told.from
        );
    }
    if stops != PathStops::Never {
        let _ = writeln!(out, "stops = \"{}\"", stops.name());
        rows.push(Row {
            key: "planner.stops".to_owned(),
            value: stops.name().to_owned(),
            fate: Fate::Used,
            note: "the control takes the gap up by a move of its own".to_owned(),
        });
    }
    if let Some(control) = draft.control {
        let _ = write!(out, "\n[simulate]\ncontrol = \"{}\"\n", control.name());
    }
    for tool in &draft.tools {
        let _ = write!(
            out,
            "\n[[tool]]\nnumber = {}\nlength_mm = {}\ndiameter_mm = {}\n",
            tool.number,
            float(tool.length_mm),
            float(tool.diameter_mm)
        );
    }
    if !out.ends_with("\n\n") {
        out.push('\n');
    }
}

/// The longest whole part of a cycle that is a whole number of nanoseconds and no longer than this,
/// us.
fn part_of(command_ms: f64, longest_us: f64) -> f64 {
    let command_ns = (command_ms * 1e6).round() as u64;
    let longest_ns = (longest_us * 1e3) as u64;
    let least = command_ns.div_ceil(longest_ns.max(1)).max(1);
    let parts = (least..=command_ns).find(|parts| command_ns.is_multiple_of(*parts));
    (command_ns / parts.unwrap_or(1)) as f64 * 1e-3
}
