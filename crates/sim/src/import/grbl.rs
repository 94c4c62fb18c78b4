//! grbl's and grblHAL's settings: lines `$110=1500.000 (x rate, mm/min)`.
//!
//! $100 to $105 steps/mm (or degree), $110 to $115 rate in mm/min, $120 to $125 acceleration in mm/s2, $130 to $135 travel in
//! mm, for X Y Z A B C; machine coordinates run from minus the travel to 0.

use super::draft::{Draft, Fate, Told};
use super::{number, problem};
use crate::machine::Problem;
use lostmotion_base::AxisId;

/// Reads the settings.
pub(super) fn read(text: &str) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft { name: "imported".into(), source: "grbl", ..Draft::default() };
    draft.kinematics.kind = "cartesian".into();
    let mut problems = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if let Err(problem) = setting(&mut draft, index + 1, line.trim()) {
            problems.push(problem);
        }
    }
    if draft.axes.is_empty() && problems.is_empty() {
        problems.push(problem(1, "", "there is no setting of an axis", "it has to be what grbl answers to `$$`, with $110=... and so on"));
    }
    if problems.is_empty() { Ok(draft) } else { Err(problems) }
}

fn setting(draft: &mut Draft, line: usize, text: &str) -> Result<(), Problem> {
    let Some(rest) = text.strip_prefix('$') else {
        if !text.is_empty() && text != "ok" {
            draft.row(format!("line {line}"), text, Fate::Ignored, "not a setting");
        }
        return Ok(());
    };
    let hint = "settings are written as $110=1500.0";
    let (key, value) = rest.split_once('=').ok_or_else(|| problem(line, text, "has no value", hint))?;
    let name = format!("${}", key.trim());
    let code: u32 = key.trim().parse().map_err(|_| problem(line, &name, "is not a setting", hint))?;
    let value = value.split(['(', ';']).next().unwrap_or(value).trim();
    let axis = AxisId::from_index((code % 10) as usize).filter(|axis| axis.index() < 6);
    let Some(axis) = axis.filter(|_| (100..140).contains(&code)) else {
        draft.row(name, value, Fate::Ignored, "no limit of an axis");
        return Ok(());
    };
    if code < 110 {
        draft.row(name, value, Fate::Ignored, format!("steps of {axis}: the drive comes from the preset"));
        return Ok(());
    }
    let amount = number(line, &name, value)?;
    if amount <= 0.0 {
        return Err(problem(line, &name, format!("is {value}; it has to be above 0"), ""));
    }
    let entry = draft.axis(axis, axis.is_rotary());
    let told = |value: f64| Some(Told { value, from: name.clone() });
    let what = match code / 10 {
        11 => {
            entry.velocity = told(amount / 60.0);
            "velocity, from units/min"
        }
        12 => {
            entry.acceleration = told(amount);
            "acceleration"
        }
        _ => {
            (entry.min, entry.max) = (told(-amount), told(0.0));
            "travel, from minus this to 0"
        }
    };
    draft.row(name, value, Fate::Used, format!("{what} of {axis}"));
    Ok(())
}
