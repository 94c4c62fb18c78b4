//! What a description lacks, from a machine that lends it, and the whole as a machine file.

use super::draft::{Draft, DraftAxis, Fate, Row, Told, float};
use super::{Imported, problem};
use crate::machine::{LimitsTable, Machine, MachineAxis, Problem, presets};
use lostmotion_base::units::{deg, rad};
use lostmotion_base::{AxisId, Coords};
use lostmotion_drive::config::AxisUnit;
use lostmotion_kinematics::chain::JointSpec;
use lostmotion_kinematics::{KinematicsSpec, Words, build};
use std::fmt::Write;

/// Lends rotary axes where the preset has none.
const ROTARY_LENDER: &str = "trunnion5";

/// How far a SCARA's elbow is bent at its homes, degrees: any angle clear of straight and folded.
const ELBOW_DEG: f64 = 60.0;
/// How far the joints of an arm stand from the middle of their travel at home, degrees or mm, by
/// the order of its axes: unequal angles, at which no common arm is straight. A choice: primes,
/// those of the first six axes all different.
const ARM_HOME_OFFSETS: [f64; 9] = [7.0, -23.0, 41.0, 13.0, 37.0, 17.0, 5.0, 5.0, 5.0];
/// Part of its travel that a joint at home keeps from the ends. A choice: room for motion about
/// home.
const HOME_MARGIN: f64 = 0.05;

/// A machine file out of a draft.
pub(super) fn machine(
    file: &str,
    mut draft: Draft,
    preset: &str,
) -> Result<Imported, Vec<Problem>> {
    let known: Vec<&str> = presets().iter().map(|info| info.name).collect();
    if !known.contains(&preset) {
        return Err(vec![problem(
            1,
            "preset",
            format!("there is no machine `{preset}`"),
            &format!("known are {}", known.join(", ")),
        )]);
    }
    // In the order of the axes, as machine files and results have them.
    draft.axes.sort_by_key(|axis| axis.id);
    let reversed: Vec<Problem> = draft.axes.iter().filter_map(reversed).collect();
    if !reversed.is_empty() {
        return Err(reversed);
    }
    let mut rows = std::mem::take(&mut draft.rows);
    let mut axes = String::new();
    let mut travel = Vec::new();
    // Told limits stay; drive, motor, load and all other limits come from the lender.
    for axis in &draft.axes {
        let lender = lender(axis, preset).ok_or_else(|| {
            vec![problem(
                1,
                "preset",
                format!("no machine lends an axis like {}", axis.id),
                "",
            )]
        })?;
        travel.push(section(axis, &lender, &mut axes, &mut rows));
    }
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
    positions(&draft, &travel, &mut toml, &mut rows)?;
    toml.push_str(&axes);
    // Read back like any machine file. The lines of a problem would be those of the generated
    // text, which is not at hand then.
    match Machine::check_toml(file, &toml) {
        Ok(_) => Ok(Imported { toml, rows }),
        Err(error) => Err(error
            .problems
            .into_iter()
            .map(|found| Problem {
                line: 1,
                column: 1,
                ..found
            })
            .collect()),
    }
}

/// A travel that is told and is none.
fn reversed(axis: &DraftAxis) -> Option<Problem> {
    // Where one end is lent the whole machine is checked, not the file blamed.
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

fn filled(key: impl Into<String>, value: impl Into<String>, note: impl Into<String>) -> Row {
    Row {
        key: key.into(),
        value: value.into(),
        fate: Fate::Filled,
        note: note.into(),
    }
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
fn lender(axis: &DraftAxis, preset: &str) -> Option<Lender> {
    [preset, ROTARY_LENDER].into_iter().find_map(|name| {
        let info = presets().iter().find(|info| info.name == name)?;
        let machine = Machine::preset(name).ok()?;
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

/// Writes an axis; gives its travel.
fn section(axis: &DraftAxis, lender: &Lender, out: &mut String, rows: &mut Vec<Row>) -> (f64, f64) {
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
    for (((slot, told), key), lent) in values
        .iter_mut()
        .zip(told)
        .zip(keys)
        .zip(lent(&lender.axis))
    {
        // What is told goes before what is lent, and every line says which of the two it is.
        *slot = told.map_or(lent, |told| told.value);
        let from = told.map_or_else(|| format!("preset {source}"), |told| told.from.clone());
        let _ = writeln!(out, "{key} = {} # {from}", float(*slot));
        if told.is_none() {
            rows.push(filled(
                format!("axis.{letter}.limits.{key}"),
                float(*slot),
                format!("preset {source}"),
            ));
        }
    }
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
    (values[0], values[1])
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

fn home_of(joint: &JointSpec, axes: &[DraftAxis], travel: &[(f64, f64)]) -> f64 {
    let index = axes
        .iter()
        .position(|axis| joint.axis_id() == Some(axis.id));
    let (min, max) = index
        .and_then(|index| travel.get(index))
        .copied()
        .unwrap_or((-90.0, 90.0));
    let middle = if min < 0.0 && max > 0.0 {
        0.0
    } else {
        0.5 * (min + max)
    };
    // A bent arm: straight ones are singular.
    let bent = middle
        + ARM_HOME_OFFSETS
            .get(index.unwrap_or(0))
            .copied()
            .unwrap_or(5.0);
    // A travel with one end lent may be reversed: min and max do not panic as clamp would, and
    // the check of the machine refuses it.
    (bent
        .min(max - HOME_MARGIN * (max - min))
        .max(min + HOME_MARGIN * (max - min))
        * 100.0)
        .round()
        / 100.0
}

fn head(draft: &Draft, preset: &str) -> String {
    // These would end the string in the file.
    let name = draft.name.replace(['"', '\\', '\n'], " ");
    let mut text = format!(
        "# Imported from {}; what it does not say was taken from `{preset}` or another machine, as every comment tells.\n\nname = \"{name}\"\ndescription = \"imported from {}\"\n\n",
        draft.source, draft.source
    );
    if let Some(dialect) = draft.dialect {
        let _ = write!(text, "dialect = \"{dialect}\"\n\n");
    }
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

/// Work offset and homes within the travel: zero where it can be, else the middle.
fn positions(
    draft: &Draft,
    travel: &[(f64, f64)],
    out: &mut String,
    rows: &mut Vec<Row>,
) -> Result<(), Vec<Problem>> {
    let mut joints = Coords::ZERO;
    // The joints stand at zero where their travel has it, else in its middle.
    for (axis, (min, max)) in draft.axes.iter().zip(travel) {
        let at = if *min <= 0.0 && *max >= 0.0 {
            0.0
        } else {
            0.5 * (min + max)
        };
        joints[axis.id] = if axis.rotary {
            lostmotion_base::units::rad(at)
        } else {
            at
        };
        if matches!(draft.kinematics, KinematicsSpec::Scara(_)) && axis.id == AxisId::B {
            // A straight arm is singular.
            joints[axis.id] = lostmotion_base::units::rad(ELBOW_DEG.min(*max).max(*min));
        }
    }
    let kinematics = build(&draft.kinematics)
        .map_err(|error| vec![problem(1, "kinematics", error.to_string(), "")])?;
    // An arm stands at its home, which is clear of singular poses.
    if let KinematicsSpec::Chain(chain) = &draft.kinematics
        && let Some(home) = &chain.home
    {
        for (joint, at) in chain.joint.iter().zip(home) {
            let Some(id) = joint.axis_id() else {
                continue;
            };
            joints[id] = if joint.is_rotary() {
                lostmotion_base::units::rad(*at)
            } else {
                *at
            };
        }
    }
    // Machine files give places in words, not in joints.
    let words = kinematics.forward(&joints, &[0.0; 3]);
    let mut table = String::new();
    for axis in AxisId::ALL {
        let value = if axis.is_rotary() {
            deg(words[axis])
        } else {
            words[axis]
        };
        // What a position leaves out is 0.
        if value.abs() > 1e-9 {
            let _ = writeln!(table, "{} = {}", axis.column(), float(value));
        }
    }
    for key in ["work_offset.g54", "home.g28", "home.g30"] {
        let _ = write!(
            out,
            "# within the travel: set it to where parts are\n[{key}]\n{table}\n"
        );
        rows.push(filled(
            key,
            table.lines().collect::<Vec<_>>().join(", "),
            "within the travel",
        ));
    }
    Ok(())
}
