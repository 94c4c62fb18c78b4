//! What moves LinuxCNC's joints: steppers by STEPGEN_MAXVEL, STEPGEN_MAXACCEL, STEP_SCALE, or SCALE
//! where HAL has step generators.

use super::draft::{Draft, Fate, Quantity, Told};
use super::ini::{Entry, Ini};
use super::kins::Numbered;
use super::{ImportOptions, number, problem};
use crate::machine::Problem;

/// Keys of step generators.
const GENERATOR: [&str; 3] = ["STEPGEN_MAXVEL", "STEPGEN_MAXACCEL", "STEP_SCALE"];

/// Keys that hold the steps of a machine unit, the surest first.
const STEPS: [&str; 3] = ["STEP_SCALE", "SCALE", "INPUT_SCALE"];

/// LinuxCNC's own advice: a step generator needs this many times the acceleration of its joint.
const GENERATOR_ROOM: f64 = 1.5;

/// Whether a joint's key is about its motor and reported here.
pub(super) fn is_motor_key(key: &str) -> bool {
    GENERATOR.contains(&key) || STEPS.contains(&key)
}

/// Tells the steppers of the joints that have them.
pub(super) fn tell(
    draft: &mut Draft,
    ini: &Ini,
    joints: &[Numbered],
    (mm, deg): (f64, f64),
    options: &ImportOptions<'_>,
) -> Result<(), Problem> {
    let wired = ini
        .entries
        .iter()
        .filter(|entry| entry.section == "HAL" && entry.key == "HALFILE")
        .any(|entry| {
            let file = entry.value.split_whitespace().next().unwrap_or_default();
            (options.files)(file).is_ok_and(|text| text.contains("stepgen"))
        });
    for (index, (axis, turns)) in joints.iter().enumerate() {
        // Sections of axes by number are those of LinuxCNC before 2.8.
        let sections = [format!("JOINT_{index}"), format!("AXIS_{index}")];
        let own = |key: &str| -> Option<&Entry> {
            sections
                .iter()
                .find_map(|section| ini.first(&[section], key))
        };
        let generator = GENERATOR.iter().find_map(|key| own(key));
        let steps = STEPS.iter().find_map(|key| own(key));
        let is_stepper = generator.is_some() || (wired && own("SCALE").is_some());
        let Some(steps) = steps else { continue };
        if !is_stepper {
            draft.row(
                steps.name(),
                steps.value.as_str(),
                Fate::Ignored,
                "of an encoder: the drive comes from the preset",
            );
            continue;
        }
        // Of two motors on an axis the first counts.
        let has = draft.axis(*axis, *turns).stepper.is_some();
        if has {
            draft.row(
                steps.name(),
                steps.value.as_str(),
                Fate::Ignored,
                "a further motor of the axis: one moves it here",
            );
            continue;
        }
        // Old files have an offset behind it; the sign is the direction.
        let first = steps.value.split_whitespace().next().unwrap_or_default();
        let value = number(steps.line, &steps.name(), first)?.abs();
        if value == 0.0 {
            let message = format!("is {}; it has to be other than 0", steps.value);
            return Err(problem(steps.line, &steps.name(), message, ""));
        }
        let unit = if *turns { deg } else { mm };
        let told = Told {
            value: value / unit,
            from: steps.name(),
            line: steps.line,
        };
        draft.tell(*axis, Quantity::StepsPerUnit, told, &steps.value);
        let by = generator.map_or_else(|| "HAL".to_owned(), Entry::name);
        draft.row(
            format!("axis {axis}"),
            "stepper, open loop",
            Fate::Guessed,
            format!("by {by}; a servo with step inputs looks the same: name a --preset then"),
        );
        if let Some(entry) = own("STEPGEN_MAXACCEL") {
            room(draft, entry, own("MAX_ACCELERATION"))?;
        }
        if let Some(entry) = own("STEPGEN_MAXVEL") {
            draft.row(
                entry.name(),
                entry.value.as_str(),
                Fate::Ignored,
                "room of the step generator",
            );
        }
    }
    Ok(())
}

/// Says where the step generator has too little room for what the control adds at reversals.
fn room(draft: &mut Draft, entry: &Entry, limit: Option<&Entry>) -> Result<(), Problem> {
    let value = number(entry.line, &entry.name(), &entry.value)?;
    let limit = match limit {
        Some(limit) => number(limit.line, &limit.name(), &limit.value)?,
        None => 0.0,
    };
    // 0 is none.
    let note = if value > 0.0 && value < GENERATOR_ROOM * limit {
        format!(
            "{:.2} times MAX_ACCELERATION: below the 1.5 to 2 times that BACKLASH needs; following errors come of it",
            value / limit
        )
    } else {
        "room of the step generator".to_owned()
    };
    draft.row(entry.name(), entry.value.as_str(), Fate::Ignored, note);
    Ok(())
}
