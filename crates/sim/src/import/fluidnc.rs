//! FluidNC's configuration (YAML): keys below `axes:` by their indents.
//!
//! Of every axis steps_per_mm, max_rate_mm_per_min, acceleration_mm_per_sec2, max_travel_mm, and of
//! `homing:` mpos_mm and positive_direction, which say where the travel lies; of `motor0:` the
//! driver's microsteps and run_amps (A, effective); `kinematics:` cartesian and corexy; `name:`.
//! Rotary axes are in degrees under the same keys. FluidNC has no setting for a gap. See
//! <http://wiki.fluidnc.com/en/config/axes>.

use super::draft::{Draft, Fate, LIKE_FIRST, Quantity, Told, filled, float, unlike_first};
use super::{Format, ImportOptions, number, positive, problem};
use crate::machine::Problem;
use lostmotion_base::AxisId;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::SQRT_2;

/// The format's row. Its files share their extension with others.
pub(super) const FORMAT: Format = Format {
    name: "fluidnc",
    extensions: &[],
    looks_like: |text| {
        let has = |key: &str| text.lines().any(|line| line.trim_start().starts_with(key));
        has("axes:") && (has("steps_per_mm:") || has("max_rate_mm_per_min:"))
    },
    is_lines: true,
    read,
};

/// Deepest nesting of keys; FluidNC's own go five deep.
const DEEPEST: usize = 32;

/// Keys that have values.
const VALUES: [&str; 8] = [
    "steps_per_mm",
    "max_rate_mm_per_min",
    "acceleration_mm_per_sec2",
    "max_travel_mm",
    "mpos_mm",
    "positive_direction",
    "microsteps",
    "run_amps",
];

/// Keys that may end a file: they hold nothing.
const BARE: [&str; 3] = ["null_motor:", "cartesian:", "corexy:"];

/// A key with a value, and the keys above it.
struct Leaf {
    line: usize,
    /// In lower case, as FluidNC compares them.
    path: Vec<String>,
    value: String,
}

/// The lines that have values, by their indents.
fn leaves(text: &str) -> Result<Vec<Leaf>, Problem> {
    let mut above: Vec<(usize, String)> = Vec::new();
    let mut leaves = Vec::new();
    for (index, line) in text.lines().enumerate() {
        // A hash begins a comment at the start or behind a blank.
        let mut told = line.trim_end();
        if told.trim_start().starts_with('#') {
            continue;
        }
        if let Some((before, _)) = told.split_once(" #") {
            told = before.trim_end();
        }
        let indent = told.len() - told.trim_start().len();
        if told.get(..indent).is_some_and(|blank| blank.contains('\t')) {
            let message = "is indented by a tab, which YAML forbids";
            let key = told.trim();
            return Err(problem(index + 1, key, message, "indent by blanks"));
        }
        let bad =
            |key: &str, message: &str| Err(problem(index + 1, key, message, "write `key: value`"));
        let (key, value) = match told.trim().split_once(':') {
            Some((key, value)) if !key.trim().is_empty() => (key.trim(), value.trim()),
            Some(_) => return bad(told.trim(), "there is no key"),
            None if told.trim().is_empty() || told.trim() == "---" => continue,
            None => return bad(told.trim(), "is no `key: value`"),
        };
        above.retain(|(own, _)| *own < indent);
        if above.len() == DEEPEST {
            let message = format!("keys stand in each other more than {DEEPEST} deep");
            return Err(problem(index + 1, key, message, ""));
        }
        above.push((indent, key.to_ascii_lowercase()));
        let value = value.trim_matches(['"', '\'']);
        // Other keys without a value hold those that stand further in.
        if value.is_empty()
            && above
                .last()
                .is_some_and(|(_, key)| VALUES.contains(&key.as_str()))
        {
            return bad(key, "has no value");
        }
        if !value.is_empty() {
            leaves.push(Leaf {
                line: index + 1,
                path: above.iter().map(|(_, key)| key.clone()).collect(),
                value: value.to_owned(),
            });
        }
    }
    Ok(leaves)
}

/// The last value of every path, which counts.
type LastLeaves<'a> = BTreeMap<String, &'a Leaf>;

/// Reads the file.
fn read(text: &str, _: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft::new("FluidNC");
    draft
        .expected
        .extend(super::XYZ.map(|axis| (axis, "machines of this control have it")));
    let leaves = leaves(text).map_err(|found| vec![found])?;
    let mut problems = Vec::new();
    let mut is_corexy = false;
    for (index, line) in text.lines().enumerate() {
        // Kinds of kinematics are keys without values.
        let kind = line.trim().to_ascii_lowercase();
        match kind.as_str() {
            "corexy:" => is_corexy = true,
            "wallplotter:" | "wall_plotter:" | "parallel_delta:" | "midtbot:" => {
                problems.push(problem(
                    index + 1,
                    "kinematics",
                    format!("`{}` is not known here", kind.trim_end_matches(':')),
                    "known are cartesian and corexy",
                ));
            }
            _ => {}
        }
    }
    // A key that ends the file has lost what it holds.
    let end = text.lines().rfind(|line| !line.trim().is_empty());
    if let Some(end) = end
        .map(str::trim)
        .filter(|end| end.ends_with(':') && !BARE.contains(end))
    {
        let why = "the file ends within this key: is it whole?";
        draft.row("axes", end, Fate::Guessed, why);
    }
    let last: LastLeaves<'_> = leaves
        .iter()
        .map(|leaf| (leaf.path.join("."), leaf))
        .collect();
    for leaf in &leaves {
        let counts = last
            .get(&leaf.path.join("."))
            .is_some_and(|other| std::ptr::eq(*other, leaf));
        if !counts {
            let note = "given again further on, which counts";
            draft.row(
                leaf.path.join("."),
                leaf.value.as_str(),
                Fate::Ignored,
                note,
            );
        } else if let Err(found) = take(&mut draft, &last, leaf) {
            problems.push(found);
        }
    }
    let letters: BTreeSet<&str> = leaves.iter().filter_map(axis_key).collect();
    for letter in letters {
        if let Err(found) = defaults(&mut draft, &last, letter) {
            problems.push(found);
        }
    }
    if draft.axes.is_empty() && problems.is_empty() {
        problems.push(problem(1, "axes", "there is no axis with limits", ""));
    }
    if is_corexy && problems.is_empty() {
        draft.belts();
    }
    if problems.is_empty() {
        Ok(draft)
    } else {
        Err(problems)
    }
}

fn take(draft: &mut Draft, leaves: &LastLeaves<'_>, leaf: &Leaf) -> Result<(), Problem> {
    let name = leaf.path.join(".");
    let path: Vec<&str> = leaf.path.iter().map(String::as_str).collect();
    let value = leaf.value.as_str();
    let told = |value: f64| Told {
        value,
        from: name.clone(),
        line: leaf.line,
    };
    if path == ["name"] {
        value.clone_into(&mut draft.name);
        draft.row("name", value, Fate::Used, "general");
        return Ok(());
    }
    let axis = match path.as_slice() {
        ["axes", letter, ..] if letter.len() == 1 => {
            letter.chars().next().and_then(AxisId::from_letter)
        }
        _ => None,
    };
    let Some(axis) = axis else {
        draft.row(name.as_str(), value, Fate::Ignored, "");
        return Ok(());
    };
    let above_zero = || positive(leaf.line, &name, value);
    let (quantity, amount) = match &path[2..] {
        ["steps_per_mm"] => (Quantity::StepsPerUnit, above_zero()?),
        ["max_rate_mm_per_min"] => (Quantity::Velocity, above_zero()? / 60.0),
        ["acceleration_mm_per_sec2"] => (Quantity::Acceleration, above_zero()?),
        ["max_travel_mm"] => {
            let (min, max) = travel(leaves, path[1], above_zero()?)?;
            draft.tell(axis, Quantity::Min, told(min), value);
            (Quantity::Max, max)
        }
        ["homing", key @ ("mpos_mm" | "positive_direction")] => {
            if *key == "mpos_mm" {
                number(leaf.line, &name, value)?;
            } else if !["true", "false"].contains(&value.to_ascii_lowercase().as_str()) {
                let message = format!("`{value}` is neither true nor false");
                return Err(problem(leaf.line, &name, message, ""));
            }
            draft.row(name.as_str(), value, Fate::Used, "where the travel lies");
            return Ok(());
        }
        ["motor0", _, "microsteps"] => (Quantity::Microsteps, above_zero()?),
        ["motor0", _, "run_amps"] => (Quantity::PeakCurrent, above_zero()? * SQRT_2),
        [motor, ..] if motor.starts_with("motor") && *motor != "motor0" => {
            let from = format!("{}.{motor}", path[..2].join("."));
            draft.axis(axis, axis.is_rotary()).further_motor(&from);
            let key = path[path.len() - 1];
            let note = if matches!(key, "microsteps" | "run_amps") {
                // Its driver may be of another kind.
                let mut all = leaves.values();
                let first = all.find(|it| {
                    it.path[..2] == leaf.path[..2]
                        && it.path.get(2).is_some_and(|own| own == "motor0")
                        && it.path.last() == leaf.path.last()
                });
                let first = first.map(|it| (it.path.join("."), it.value.as_str()));
                unlike_first(
                    first.as_ref().map(|(name, value)| (name.as_str(), *value)),
                    value,
                )
            } else {
                LIKE_FIRST.to_owned()
            };
            draft.row(name.as_str(), value, Fate::Ignored, note);
            return Ok(());
        }
        _ => {
            draft.row(name.as_str(), value, Fate::Ignored, "");
            return Ok(());
        }
    };
    draft.tell(axis, quantity, told(amount), value);
    Ok(())
}

/// The letter of the axis that a value is of.
fn axis_key(leaf: &Leaf) -> Option<&str> {
    let [axes, letter, ..] = leaf.path.as_slice() else {
        return None;
    };
    (axes == "axes" && letter.len() == 1).then_some(letter.as_str())
}

/// With what FluidNC runs an axis where a key is left out (Axis.h, v3): key, value in its own unit, and the quantity.
const DEFAULTS: [(&str, f64, Quantity); 4] = [
    ("steps_per_mm", 80.0, Quantity::StepsPerUnit),
    ("max_rate_mm_per_min", 1000.0, Quantity::Velocity),
    ("acceleration_mm_per_sec2", 25.0, Quantity::Acceleration),
    ("max_travel_mm", 1000.0, Quantity::Max),
];

/// Puts FluidNC's defaults into the place of keys that an axis lacks.
fn defaults(draft: &mut Draft, leaves: &LastLeaves<'_>, letter: &str) -> Result<(), Problem> {
    let Some(axis) = letter.chars().next().and_then(AxisId::from_letter) else {
        return Ok(());
    };
    let has = |key: &str| leaves.contains_key(&format!("axes.{letter}.{key}"));
    for (key, value, quantity) in DEFAULTS {
        // Travel bounds an axis with soft limits alone: one that turns goes on without.
        if has(key) || (quantity == Quantity::Max && axis.is_rotary()) {
            continue;
        }
        let key = format!("axes.{letter}.{key}");
        let told = |value: f64| Told {
            value,
            from: format!("{key}: {value} if left out"),
            line: 1,
        };
        match quantity {
            Quantity::Velocity => {
                let own = told(value);
                let per_s = Told {
                    value: value / 60.0,
                    ..own
                };
                draft.default(axis, quantity, per_s);
            }
            Quantity::Max => {
                let (min, max) = travel(leaves, letter, value)?;
                let own = told(value);
                draft.default(
                    axis,
                    Quantity::Min,
                    Told {
                        value: min,
                        ..own.clone()
                    },
                );
                draft.default(axis, quantity, Told { value: max, ..own });
            }
            _ => draft.default(axis, quantity, told(value)),
        }
        let note = "FluidNC's own where the key is left out";
        draft.rows.push(filled(key, float(value), note));
    }
    // Where the travel lies.
    for (key, value) in [("mpos_mm", "0"), ("positive_direction", "true")] {
        if !has(&format!("homing.{key}")) && !axis.is_rotary() {
            let note = "FluidNC's own where the key is left out: where the travel lies";
            draft
                .rows
                .push(filled(format!("axes.{letter}.homing.{key}"), value, note));
        }
    }
    Ok(())
}

/// From where homing leaves the axis, away from the switch.
fn travel(leaves: &LastLeaves<'_>, letter: &str, length: f64) -> Result<(f64, f64), Problem> {
    let of = |key: &str| leaves.get(&format!("axes.{letter}.homing.{key}"));
    let home = match of("mpos_mm") {
        Some(leaf) => number(leaf.line, &leaf.path.join("."), &leaf.value)?,
        None => 0.0,
    };
    let upwards =
        of("positive_direction").is_none_or(|leaf| !leaf.value.eq_ignore_ascii_case("false"));
    Ok(if upwards {
        (home - length, home)
    } else {
        (home, home + length)
    })
}
