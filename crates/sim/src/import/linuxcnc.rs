//! LinuxCNC's INI file: [EMC] MACHINE; [TRAJ] COORDINATES, LINEAR_UNITS, ANGULAR_UNITS; [KINS] KINEMATICS; and of every
//! [JOINT_n] and [AXIS_L] the limits; [HAL] HALCMD where it sets a trunnion's pins. Units are those of the machine and seconds.

use super::draft::{Draft, Fate, Told};
use super::{hal, number, problem};
use crate::machine::Problem;
use lostmotion_base::AxisId;

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
                None => problems.push(problem(index + 1, line, "the section's name is not closed", "write [TRAJ]")),
            }
        } else if let Some((key, value)) = line.split_once('=') {
            found.push(Entry { line: index + 1, section, key: key.trim(), value: value.trim() });
        } else if !line.starts_with(".include") && !line.starts_with("#INCLUDE") {
            problems.push(problem(index + 1, "", format!("`{line}` is neither a section nor KEY = VALUE"), "write MAX_VELOCITY = 50.0"));
        }
    }
    if problems.is_empty() { Ok(found) } else { Err(problems) }
}

/// Reads the file.
pub(super) fn read(text: &str) -> Result<Draft, Vec<Problem>> {
    let entries = entries(text)?;
    let first = |sections: &[&str], key: &str| entries.iter().find(|entry| sections.contains(&entry.section) && entry.key == key);
    let mut problems = Vec::new();
    let mut draft = Draft { name: "imported".into(), source: "LinuxCNC", ..Draft::default() };
    if let Some(name) = first(&["EMC"], "MACHINE").filter(|entry| !entry.value.is_empty()) {
        draft.name = name.value.to_owned();
    }
    let kins = first(&["KINS", "TRAJ"], "KINEMATICS");
    let mut words = kins.map_or("trivkins", |entry| entry.value).split_whitespace();
    let module = words.next().unwrap_or("trivkins");
    let told = words.find_map(|word| word.strip_prefix("coordinates="));
    kinematics(&mut draft, module, kins.map_or(1, |entry| entry.line)).unwrap_or_else(|found| problems.push(found));
    let coordinates = told.or_else(|| first(&["TRAJ"], "COORDINATES").map(|entry| entry.value)).unwrap_or("XYZ");
    let letters: Vec<AxisId> = coordinates.chars().filter_map(AxisId::from_letter).collect();
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
    let mut pointed = false;
    for entry in &entries {
        if (entry.section, entry.key) == ("HAL", "HALCMD") && draft.kinematics.kind.starts_with("trunnion") {
            match hal::take(&mut draft, module, entry.line, entry.value, scale.linear) {
                Ok(true) => {
                    pointed |= entry.value.contains("-rot-point");
                    continue;
                }
                Ok(false) => {}
                Err(found) => problems.push(found),
            }
        }
        if let Err(found) = take(&mut draft, entry, &letters, &scale) {
            problems.push(found);
        }
    }
    if draft.kinematics.kind.starts_with("trunnion") && !pointed {
        let note = "LinuxCNC has it in HAL (x-rot-point, ...), and no HALCMD of the INI file sets it: set it";
        draft.row("kinematics.rotation_point_mm", "[0, 0, 0]", Fate::Filled, note);
    }
    if draft.axes.is_empty() && problems.is_empty() {
        problems.push(problem(1, "", "there is no [JOINT_n] or [AXIS_L] with limits", "is it the machine's INI file?"));
    }
    if problems.is_empty() { Ok(draft) } else { Err(problems) }
}

/// Machine units in mm and degrees.
struct Units {
    linear: f64,
    angular: f64,
}

fn kinematics(draft: &mut Draft, module: &str, line: usize) -> Result<(), Problem> {
    let spec = &mut draft.kinematics;
    let kind = match module {
        "trivkins" | "gentrivkins" => "cartesian",
        "corexykins" => "corexy",
        "xyzac-trt-kins" => "trunnion-ac",
        "xyzbc-trt-kins" => "trunnion-bc",
        other => {
            let hint = "known are trivkins, corexykins, xyzac-trt-kins, xyzbc-trt-kins; describe others as kind = \"chain\" by hand";
            return Err(problem(line, "KINS.KINEMATICS", format!("`{other}` is not known here"), hint));
        }
    };
    spec.kind = kind.into();
    if !kind.starts_with("trunnion") {
        return Ok(());
    }
    spec.rotation_point_mm = Some([0.0; 3]);
    spec.conventional_directions = Some(false);
    Ok(())
}

/// The axis whose section it is.
fn axis_of(section: &str, letters: &[AxisId]) -> Option<AxisId> {
    if let Some(letter) = section.strip_prefix("AXIS_") {
        let mut chars = letter.chars();
        return chars.next().filter(|_| chars.next().is_none()).and_then(|letter| match letter.to_digit(10) {
            // Before 2.8 axes were numbered.
            Some(index) => AxisId::from_index(index as usize),
            None => AxisId::from_letter(letter),
        });
    }
    letters.get(section.strip_prefix("JOINT_")?.parse::<usize>().ok()?).copied()
}

fn take(draft: &mut Draft, entry: &Entry<'_>, letters: &[AxisId], units: &Units) -> Result<(), Problem> {
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
    let limits = ["MIN_LIMIT", "MAX_LIMIT", "MAX_VELOCITY", "MAX_ACCELERATION", "BACKLASH"];
    let axis = axis_of(entry.section, letters).filter(|_| limits.contains(&entry.key));
    let Some(axis) = axis else {
        let fate = if entry.key == "TYPE" { Fate::Used } else { Fate::Ignored };
        draft.row(key, entry.value, fate, if fate == Fate::Used { "kind of joint, by its letter" } else { "" });
        return Ok(());
    };
    let scale = if axis.is_rotary() { units.angular } else { units.linear };
    let value = number(entry.line, &key, entry.value)? * scale;
    if entry.key.starts_with("MAX_V") || entry.key.starts_with("MAX_A") {
        if value <= 0.0 {
            return Err(problem(entry.line, &key, format!("is {}; it has to be above 0", entry.value), ""));
        }
    } else if entry.key == "BACKLASH" && value < 0.0 {
        return Err(problem(entry.line, &key, "is below 0", ""));
    }
    let joint = entry.section.starts_with("JOINT_");
    let draft_axis = draft.axis(axis, axis.is_rotary());
    let slot = match entry.key {
        "MIN_LIMIT" => &mut draft_axis.min,
        "MAX_LIMIT" => &mut draft_axis.max,
        "MAX_VELOCITY" => &mut draft_axis.velocity,
        "MAX_ACCELERATION" => &mut draft_axis.acceleration,
        _ => &mut draft_axis.gap,
    };
    // What a joint may do counts; an axis section only where there is no other.
    let takes = joint || slot.is_none();
    if takes {
        *slot = Some(Told { value, from: key.clone() });
    }
    let note = if takes { format!("axis {axis}") } else { format!("axis {axis}: the joint's own counts") };
    draft.row(key, entry.value, if takes { Fate::Used } else { Fate::Ignored }, note);
    Ok(())
}
