//! LinuxCNC's INI file: [EMC] MACHINE; [TRAJ] COORDINATES, LINEAR_UNITS, ANGULAR_UNITS; [KINS]
//! KINEMATICS; and of every [JOINT_n] and [AXIS_L] limits, BACKLASH, FERROR, MIN_FERROR; [HAL] HALCMD where it sets pins of
//! the kinematics. Units are those of the machine and seconds. See
//! <https://linuxcnc.org/docs/stable/html/config/ini-config.html>.

use super::draft::{Draft, Fate, Told};
use super::hal::Pins;
use super::kins::{self, Module, Numbered};
use super::{Format, number, problem};
use crate::machine::Problem;
use lostmotion_base::AxisId;
use lostmotion_kinematics::KinematicsSpec;

/// The format's row.
pub(super) const FORMAT: Format = Format {
    name: "linuxcnc",
    extensions: &["ini"],
    looks_like: |text| {
        let mut lines = text.lines().map(str::trim);
        lines.any(|line| matches!(line, "[EMC]" | "[TRAJ]" | "[KINS]"))
    },
    read,
};

/// A line `KEY = VALUE`.
struct Entry<'a> {
    line: usize,
    section: &'a str,
    key: &'a str,
    value: &'a str,
}

/// Sections and keys with their lines.
fn entries(text: &str) -> Result<Vec<Entry<'_>>, Vec<Problem>> {
    let (mut found, mut problems) = (Vec::new(), Vec::new());
    let mut section = "";
    for (index, raw) in text.lines().enumerate() {
        let line = raw.trim();
        if line.is_empty() || line.starts_with(['#', ';']) {
            continue;
        }
        if let Some(name) = line.strip_prefix('[') {
            match name.split_once(']') {
                Some((name, _)) => section = name.trim(),
                None => problems.push(problem(
                    index + 1,
                    line,
                    "the section's name is not closed",
                    "write [TRAJ]",
                )),
            }
        } else if let Some((key, value)) = line.split_once('=') {
            found.push(Entry {
                line: index + 1,
                section,
                key: key.trim(),
                value: value.trim(),
            });
        } else if included(line).is_none() {
            problems.push(problem(
                index + 1,
                "",
                format!("`{line}` is neither a section nor KEY = VALUE"),
                "write MAX_VELOCITY = 50.0",
            ));
        }
    }
    if problems.is_empty() {
        Ok(found)
    } else {
        Err(problems)
    }
}

/// The file that a line includes, if it is such a line.
fn included(line: &str) -> Option<&str> {
    let rest = ["#INCLUDE", ".include"]
        .iter()
        .find_map(|word| line.strip_prefix(word))?;
    Some(rest.trim())
}

/// Reads the file.
fn read(text: &str) -> Result<Draft, Vec<Problem>> {
    let entries = entries(text)?;
    let first = |sections: &[&str], key: &str| {
        entries
            .iter()
            .find(|entry| sections.contains(&entry.section) && entry.key == key)
    };
    let mut problems = Vec::new();
    let mut draft = Draft::new("LinuxCNC");
    // What is asked for may stand in an included file; in silence defaults would take its place.
    for file in text.lines().filter_map(|line| included(line.trim())) {
        let note = "not read: put its text in the line's place if it describes axes";
        draft.row("#INCLUDE", file, Fate::Ignored, note);
    }
    if let Some(name) = first(&["EMC"], "MACHINE").filter(|entry| !entry.value.is_empty()) {
        draft.name = name.value.to_owned();
    }
    // KINEMATICS = MODULE [coordinates=LETTERS]: in [KINS], or in [TRAJ] of older files.
    let kins = first(&["KINS", "TRAJ"], "KINEMATICS");
    let mut words = kins
        .map_or("trivkins", |entry| entry.value)
        .split_whitespace();
    let name = words.next().unwrap_or("trivkins");
    let line = kins.map_or(1, |entry| entry.line);
    let told = words.find_map(|word| word.strip_prefix("coordinates="));
    let module = kins::find(name, line)
        .map_err(|found| problems.push(found))
        .ok();
    let usual = module.map_or("XYZ", |module| module.coordinates);
    // Which axes there are: the module's argument, then [TRAJ], then what the module usually has.
    let coordinates = told
        .or_else(|| first(&["TRAJ"], "COORDINATES").map(|entry| entry.value))
        .unwrap_or(usual);
    let letters: Vec<Numbered> = coordinates
        .chars()
        .filter_map(AxisId::from_letter)
        .map(|axis| (axis, axis.is_rotary()))
        .collect();
    // Factors from the machine's units to mm and degrees.
    let scale = Units {
        linear: match first(&["TRAJ"], "LINEAR_UNITS").map_or("mm", |entry| entry.value) {
            "inch" | "in" | "imperial" => 25.4,
            _ => 1.0,
        },
        angular: match first(&["TRAJ"], "ANGULAR_UNITS").map_or("degree", |entry| entry.value) {
            "radian" | "rad" => lostmotion_base::units::deg(1.0),
            _ => 1.0,
        },
    };
    let numbered = module.map_or_else(|| letters.clone(), |module| module.numbered(coordinates));
    let joints = IniJoints {
        numbered,
        words_too: module.is_none_or(Module::words_are_joints),
        units: scale,
    };
    // Pins of the kinematics wait for the module; any other key is taken or reported as ignored.
    let mut pins = Pins::new(name, line);
    for entry in &entries {
        if (entry.section, entry.key) == ("HAL", "HALCMD") && pins.take(entry.line, entry.value) {
            continue;
        }
        if let Err(found) = take(&mut draft, entry, &joints) {
            problems.push(found);
        }
    }
    if draft.axes.is_empty() && problems.is_empty() {
        problems.push(problem(
            1,
            "",
            "there is no [JOINT_n] or [AXIS_L] with limits",
            "is it the machine's INI file?",
        ));
    }
    if let Some(module) = module
        && let Err(found) = module.describe(&mut draft, pins, joints.units.linear, &letters)
    {
        problems.push(found);
    }
    complete(&mut draft);
    if problems.is_empty() {
        Ok(draft)
    } else {
        Err(problems)
    }
}

/// All joints of the kinematics have axes, and nothing else has.
fn complete(draft: &mut Draft) {
    let joints: Vec<Numbered> = match &draft.kinematics {
        KinematicsSpec::Chain(chain) => chain
            .joint
            .iter()
            .filter_map(|joint| Some((joint.axis_id()?, joint.is_rotary())))
            .collect(),
        KinematicsSpec::Delta(_) => [AxisId::X, AxisId::Y, AxisId::Z]
            .map(|axis| (axis, false))
            .to_vec(),
        KinematicsSpec::Scara(_) => kins::SCARA.to_vec(),
        // The other kinds take the axes as they are told.
        _ => return,
    };
    // Axes that the kinematics does not have are dropped, and reported.
    let (kept, left): (Vec<_>, Vec<_>) = draft
        .axes
        .drain(..)
        .partition(|own| joints.iter().any(|(axis, _)| *axis == own.id));
    draft.axes = kept;
    for axis in left {
        draft.row(
            format!("axis {}", axis.id),
            "",
            Fate::Ignored,
            "has no place in these kinematics",
        );
    }
    for (axis, turns) in joints {
        draft.axis(axis, turns);
    }
}

/// Machine units in mm and degrees.
struct Units {
    linear: f64,
    angular: f64,
}

/// What joints there are.
struct IniJoints {
    numbered: Vec<Numbered>,
    /// Whether what a word may do is what the joint of its letter may.
    words_too: bool,
    units: Units,
}

impl IniJoints {
    /// The axis whose section it is, and whether it turns.
    fn of(&self, section: &str) -> Option<Numbered> {
        if let Some(letter) = section.strip_prefix("AXIS_").filter(|_| self.words_too) {
            let mut chars = letter.chars();
            let axis = chars
                .next()
                .filter(|_| chars.next().is_none())
                .and_then(|letter| match letter.to_digit(10) {
                    // Before 2.8 axes were numbered.
                    Some(index) => AxisId::from_index(index as usize),
                    None => AxisId::from_letter(letter),
                });
            return axis.map(|axis| (axis, axis.is_rotary()));
        }
        // Joints go by their number; which axis that is, the kinematics module says.
        self.numbered
            .get(section.strip_prefix("JOINT_")?.parse::<usize>().ok()?)
            .copied()
    }
}

fn take(draft: &mut Draft, entry: &Entry<'_>, joints: &IniJoints) -> Result<(), Problem> {
    let key = format!("[{}] {}", entry.section, entry.key);
    let used = [
        ("EMC", "MACHINE"),
        ("TRAJ", "COORDINATES"),
        ("TRAJ", "LINEAR_UNITS"),
        ("TRAJ", "ANGULAR_UNITS"),
        ("KINS", "KINEMATICS"),
        ("TRAJ", "KINEMATICS"),
    ];
    if used.contains(&(entry.section, entry.key)) {
        draft.row(key, entry.value, Fate::Used, "general");
        return Ok(());
    }
    let limits = [
        "MIN_LIMIT",
        "MAX_LIMIT",
        "MAX_VELOCITY",
        "MAX_ACCELERATION",
        "MAX_JERK",
        "BACKLASH",
        "FERROR",
        "MIN_FERROR",
    ];
    let axis = joints
        .of(entry.section)
        .filter(|_| limits.contains(&entry.key));
    let Some((axis, turns)) = axis else {
        let fate = if entry.key == "TYPE" {
            Fate::Used
        } else {
            Fate::Ignored
        };
        draft.row(
            key,
            entry.value,
            fate,
            if fate == Fate::Used {
                "kind of joint, by its letter"
            } else {
                ""
            },
        );
        return Ok(());
    };
    // The machine's units to mm and degrees.
    let scale = if turns {
        joints.units.angular
    } else {
        joints.units.linear
    };
    let value = number(entry.line, &key, entry.value)? * scale;
    let above_zero = [
        "MAX_VELOCITY",
        "MAX_ACCELERATION",
        "MAX_JERK",
        "FERROR",
        "MIN_FERROR",
    ];
    if above_zero.contains(&entry.key) {
        if value <= 0.0 {
            return Err(problem(
                entry.line,
                &key,
                format!("is {}; it has to be above 0", entry.value),
                "",
            ));
        }
    } else if entry.key == "BACKLASH" && value < 0.0 {
        return Err(problem(entry.line, &key, "is below 0", ""));
    }
    let joint = entry.section.starts_with("JOINT_");
    let draft_axis = draft.axis(axis, turns);
    let slot = match entry.key {
        "MIN_LIMIT" => &mut draft_axis.min,
        "MAX_LIMIT" => &mut draft_axis.max,
        "MAX_VELOCITY" => &mut draft_axis.velocity,
        "MAX_ACCELERATION" => &mut draft_axis.acceleration,
        "MAX_JERK" => &mut draft_axis.jerk,
        "FERROR" => &mut draft_axis.following_error,
        "MIN_FERROR" => &mut draft_axis.standstill_error,
        _ => &mut draft_axis.gap,
    };
    // What a joint may do counts; an axis section only where there is no other.
    let takes = joint || slot.is_none();
    if takes {
        *slot = Some(Told {
            value,
            from: key.clone(),
            line: entry.line,
        });
    }
    let note = if takes {
        format!("axis {axis}")
    } else {
        format!("axis {axis}: the joint's own counts")
    };
    draft.row(
        key,
        entry.value,
        if takes { Fate::Used } else { Fate::Ignored },
        note,
    );
    Ok(())
}
