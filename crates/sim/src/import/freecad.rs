//! FreeCAD's machine files (.fcm): JSON with `machine.name` and `machine.axes`, an object of axes
//! by letter with `type` (`linear`, `angular`), `min` and `max` in mm or degrees (also inside
//! `limits`), `max_velocity` in mm/min or degrees/min; where the axis sits is in `role`, `parent`
//! and `joint`. See
//! <https://freecad.github.io/Addon-Academy/Topics/Types/Machines>.

use super::draft::{Draft, Fate, Told};
use super::freecad_chain::{Place, chain};
use super::{Format, ImportOptions, problem};
use crate::machine::Problem;
use lostmotion_base::AxisId;
use lostmotion_kinematics::{ChainSpec, TipControl};
use serde_json::{Map, Value};

/// The format's row.
pub(super) const FORMAT: Format = Format {
    name: "freecad",
    extensions: &["fcm"],
    looks_like: |text| text.trim_start().starts_with('{'),
    is_lines: false,
    read,
};

/// Postprocessors whose programs are in a dialect of the same or another name.
const DIALECTS: [(&str, &str); 4] = [
    ("linuxcnc", "linuxcnc"),
    ("fanuc", "fanuc"),
    ("haas", "haas"),
    ("marlin", "marlin"),
];

/// Reads the file.
fn read(text: &str, _: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let root: Value = serde_json::from_str(text).map_err(|error| {
        vec![problem(
            error.line(),
            "",
            format!("not JSON: {error}"),
            "is it a FreeCAD machine (.fcm)?",
        )]
    })?;
    // The axes may stand at the top of the file, too.
    let machine = root.get("machine").unwrap_or(&root);
    let Some(axes) = machine.get("axes").and_then(Value::as_object) else {
        let hint = "a FreeCAD machine has machine.axes, an object of axes by letter";
        return Err(vec![problem(1, "machine.axes", "missing", hint)]);
    };
    let mut draft = Draft::new("FreeCAD");
    let mut problems = Vec::new();
    general(&mut draft, &root, machine);
    let mut places = Vec::new();
    for (letter, axis) in axes {
        let line = line_of(text, letter);
        let mut chars = letter.chars();
        let id = chars
            .next()
            .and_then(AxisId::from_letter)
            .filter(|_| chars.next().is_none());
        match (id, axis.as_object()) {
            (Some(id), Some(axis)) => {
                places.extend(take(&mut draft, line, id, axis, &mut problems));
            }
            _ => problems.push(problem(
                line,
                &format!("machine.axes.{letter}"),
                "is not an axis",
                "axes are X Y Z A B C U V W, each an object",
            )),
        }
    }
    if draft.axes.is_empty() && problems.is_empty() {
        problems.push(problem(
            line_of(text, "axes"),
            "machine.axes",
            "is empty",
            "a machine has axes by letter, such as \"X\": {\"min\": 0, \"max\": 500}",
        ));
    }
    // Linear axes alone need no chain: their joints carry the axes of their own names.
    if draft.axes.iter().any(|axis| axis.rotary) {
        match chain(&places) {
            Ok(joints) => {
                draft.kinematics = ChainSpec {
                    tip_control: Some(TipControl::Programmed),
                    joint: joints,
                    ..ChainSpec::default()
                }
                .into();
                let note = "positive words move the tool along and about each `joint`'s direction, relative to the part: set sign = -1 where the table's own motion is meant";
                draft.row("kinematics.joint.sign", "1", Fate::Filled, note);
            }
            // Not an error: the axes are sound, and without a chain there is just no control of the
            // tool's tip.
            Err(why) => draft.row(
                "kinematics.kind",
                "cartesian",
                Fate::Filled,
                format!("{why}: describe it as kind = \"chain\""),
            ),
        }
    }
    if problems.is_empty() {
        Ok(draft)
    } else {
        Err(problems)
    }
}

/// What is not an axis.
fn general(draft: &mut Draft, root: &Value, machine: &Value) {
    for (key, value) in machine
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(key, _)| *key != "axes")
    {
        if key == "name" {
            draft.name = value.as_str().unwrap_or("imported").to_owned();
        }
        let note = if key == "units" {
            "of the programs; lengths here are mm"
        } else {
            ""
        };
        draft.row(
            format!("machine.{key}"),
            short(value),
            if key == "name" {
                Fate::Used
            } else {
                Fate::Ignored
            },
            note,
        );
    }
    for (key, value) in root
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(key, _)| *key != "machine" && root.get("machine").is_some())
    {
        // The postprocessor tells in which dialect the machine's programs are.
        let post = value
            .get("file_name")
            .and_then(Value::as_str)
            .filter(|_| key == "postprocessor");
        let dialect =
            post.and_then(|post| DIALECTS.iter().find(|(name, _)| post.starts_with(name)));
        if let (Some(post), Some((_, dialect))) = (post, dialect) {
            draft.dialect = Some(dialect);
            draft.row("postprocessor.file_name", post, Fate::Used, "dialect");
        } else {
            draft.row(key.clone(), short(value), Fate::Ignored, "");
        }
    }
}

/// Takes an axis; gives where it sits, as far as that is told.
fn take(
    draft: &mut Draft,
    line: usize,
    id: AxisId,
    axis: &Map<String, Value>,
    problems: &mut Vec<Problem>,
) -> Option<Place> {
    // `type` may be left out; then the letter tells.
    let rotary = axis
        .get("type")
        .and_then(Value::as_str)
        .map_or(id.is_rotary(), |kind| kind != "linear");
    if rotary != id.is_rotary() {
        problems.push(problem(
            line,
            &format!("machine.axes.{id}.type"),
            "does not fit the letter",
            "X Y Z U V W are linear, A B C angular",
        ));
        return None;
    }
    let before = problems.len();
    // Limits stand in the axis itself or in an object `limits` within it.
    let limits = axis.get("limits").and_then(Value::as_object);
    let nested = limits
        .into_iter()
        .flatten()
        .map(|(key, value)| (format!("limits.{key}"), key.as_str(), value));
    let own = axis
        .iter()
        .filter(|(key, value)| !(*key == "limits" && value.is_object()));
    for (path, key, value) in own
        .map(|(key, value)| (key.clone(), key.as_str(), value))
        .chain(nested)
    {
        let path = format!("machine.axes.{id}.{path}");
        let target = draft.axis(id, rotary);
        let (slot, scale) = match key {
            "min" => (&mut target.min, 1.0),
            "max" => (&mut target.max, 1.0),
            // Per minute in the file, per second here.
            "max_velocity" => (&mut target.velocity, 1.0 / 60.0),
            _ => {
                let fate = if ["type", "joint", "role", "parent"].contains(&key) {
                    Fate::Used
                } else {
                    Fate::Ignored
                };
                draft.row(path, short(value), fate, "");
                continue;
            }
        };
        match value.as_f64() {
            Some(number) if key != "max_velocity" || number > 0.0 => {
                *slot = Some(Told {
                    value: number * scale,
                    from: path.clone(),
                    line,
                });
            }
            _ => problems.push(problem(
                line,
                &path,
                format!("is {}; it has to be a number, speeds above 0", short(value)),
                "write it without quotes: \"max\": 500.0",
            )),
        }
        draft.row(path, short(value), Fate::Used, format!("axis {id}"));
    }
    // An axis whose limits could not be read is not placed either: one cause, one problem.
    if problems.len() > before {
        return None;
    }
    let unread = |(key, why): (&str, String)| {
        let hint = "write [[0, 0, 50], [1, 0, 0]]: a point on the axis, and its direction";
        problems.push(problem(
            line,
            &format!("machine.axes.{id}.{key}"),
            why,
            hint,
        ));
    };
    Place::of(id, rotary, axis).map_err(unread).ok()
}

/// A value on one line, cut where it is long.
fn short(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() > 40 {
        format!("{}...", text.chars().take(37).collect::<String>())
    } else {
        text
    }
}

/// The line on which an axis begins.
fn line_of(text: &str, letter: &str) -> usize {
    let key = format!("\"{letter}\"");
    text.lines()
        .position(|line| line.trim_start().starts_with(&key))
        .map_or(1, |index| index + 1)
}
