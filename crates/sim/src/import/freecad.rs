//! FreeCAD's machine files (.fcm): JSON with `machine.name` and `machine.axes`, an object of axes by letter with `type`
//! (`linear`, `angular`), `min` and `max` in mm or degrees, and `max_velocity` in mm/min or degrees/min.

use super::draft::{Draft, Fate, Told};
use super::problem;
use crate::machine::Problem;
use lostmotion_base::AxisId;
use serde_json::{Map, Value};

/// Reads the file.
pub(super) fn read(text: &str) -> Result<Draft, Vec<Problem>> {
    let root: Value = serde_json::from_str(text)
        .map_err(|error| vec![problem(error.line(), "", format!("not JSON: {error}"), "is it a FreeCAD machine (.fcm)?")])?;
    let machine = root.get("machine").unwrap_or(&root);
    let Some(axes) = machine.get("axes").and_then(Value::as_object) else {
        let hint = "a FreeCAD machine has machine.axes, an object of axes by letter";
        return Err(vec![problem(1, "machine.axes", "missing", hint)]);
    };
    let mut draft = Draft { name: "imported".into(), source: "FreeCAD", ..Draft::default() };
    draft.kinematics.kind = "cartesian".into();
    let mut problems = Vec::new();
    for (key, value) in machine.as_object().into_iter().flatten().filter(|(key, _)| *key != "axes") {
        if key == "name" {
            draft.name = value.as_str().unwrap_or("imported").to_owned();
        }
        draft.row(format!("machine.{key}"), short(value), if key == "name" { Fate::Used } else { Fate::Ignored }, "");
    }
    for (letter, axis) in axes {
        let line = line_of(text, letter);
        let mut chars = letter.chars();
        let id = chars.next().and_then(AxisId::from_letter).filter(|_| chars.next().is_none());
        match (id, axis.as_object()) {
            (Some(id), Some(axis)) => take(&mut draft, line, id, axis, &mut problems),
            _ => problems.push(problem(
                line,
                &format!("machine.axes.{letter}"),
                "is not an axis",
                "axes are X Y Z A B C U V W, each an object",
            )),
        }
    }
    if draft.axes.iter().any(|axis| axis.rotary) {
        draft.row("kinematics.kind", "cartesian", Fate::Filled, "where rotary axes sit is not taken over: describe it as kind = \"chain\"");
    }
    if problems.is_empty() { Ok(draft) } else { Err(problems) }
}

fn take(draft: &mut Draft, line: usize, id: AxisId, axis: &Map<String, Value>, problems: &mut Vec<Problem>) {
    let rotary = axis.get("type").and_then(Value::as_str).map_or(id.is_rotary(), |kind| kind != "linear");
    if rotary != id.is_rotary() {
        problems.push(problem(
            line,
            &format!("machine.axes.{id}.type"),
            "does not fit the letter",
            "X Y Z U V W are linear, A B C angular",
        ));
        return;
    }
    for (key, value) in axis {
        let path = format!("machine.axes.{id}.{key}");
        let target = draft.axis(id, rotary);
        let (slot, scale) = match key.as_str() {
            "min" => (&mut target.min, 1.0),
            "max" => (&mut target.max, 1.0),
            "max_velocity" => (&mut target.velocity, 1.0 / 60.0),
            _ => {
                let fate = if key == "type" { Fate::Used } else { Fate::Ignored };
                draft.row(path, short(value), fate, "");
                continue;
            }
        };
        match value.as_f64() {
            Some(number) if key != "max_velocity" || number > 0.0 => *slot = Some(Told { value: number * scale, from: path.clone() }),
            _ => problems.push(problem(line, &path, format!("is {}; it has to be a number, speeds above 0", short(value)), "")),
        }
        draft.row(path, short(value), Fate::Used, format!("axis {id}"));
    }
}

/// A value on one line, cut where it is long.
fn short(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() > 40 { format!("{}...", text.chars().take(37).collect::<String>()) } else { text }
}

/// The line on which an axis begins.
fn line_of(text: &str, letter: &str) -> usize {
    let key = format!("\"{letter}\"");
    text.lines().position(|line| line.trim_start().starts_with(&key)).map_or(1, |index| index + 1)
}
