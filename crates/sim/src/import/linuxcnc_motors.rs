//! What moves LinuxCNC's joints: steppers by STEPGEN_MAXVEL, STEPGEN_MAXACCEL, STEP_SCALE, by SCALE
//! where HAL has step generators, or by the generator in HAL that the joint's command is wired to.

use super::draft::{Draft, Fate, Quantity, StepperDraft, Told, float, unlike_first};
use super::hal::Hal;
use super::ini::{Entry, Ini};
use super::kins::Numbered;
use super::{number, problem};
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

/// Steps of a unit of the machine, and where they are told.
struct Steps<'a> {
    from: String,
    line: usize,
    value: &'a str,
}

impl<'a> Steps<'a> {
    fn of(entry: &'a Entry) -> Steps<'a> {
        Steps {
            from: entry.name(),
            line: entry.line,
            value: entry.plain(),
        }
    }

    /// What HAL sets on a joint's generator, which may stand for an entry of the INI file.
    fn of_hal(hal: &'a Hal, ini: &'a Ini, joint: usize) -> Option<Steps<'a>> {
        let (line, pin, value) = hal.steps(joint)?;
        Some(ini.named(value).map_or_else(
            || Steps {
                from: format!("[HAL] setp {pin}"),
                line,
                value,
            },
            Steps::of,
        ))
    }
}

/// Tells the steppers of the joints that have them.
pub(super) fn tell(
    draft: &mut Draft,
    ini: &Ini,
    hal: &Hal,
    joints: &[Option<Numbered>],
    (mm, deg): (f64, f64),
) -> Result<(), Problem> {
    let of_axes = joints.iter().enumerate();
    for (index, (axis, turns)) in of_axes.filter_map(|(index, joint)| Some((index, (*joint)?))) {
        // Sections of axes by number are those of LinuxCNC before 2.8.
        let sections = [format!("JOINT_{index}"), format!("AXIS_{index}")];
        let own = |key: &str| -> Option<&Entry> {
            sections
                .iter()
                .find_map(|section| ini.first(&[section], key))
        };
        let generator = GENERATOR.iter().find_map(|key| own(key));
        let told = STEPS.iter().find_map(|key| own(key));
        // A generator may also turn a spindle, or what the INI file does not describe.
        let is_described = || {
            let mut entries = ini.entries.iter();
            entries.any(|entry| sections.contains(&entry.section))
        };
        let is_stepper = generator.is_some()
            || (hal.has_generators() && !hal.is_no_stepper(index) && own("SCALE").is_some())
            || (hal.generator(index).is_some() && is_described());
        if !is_stepper {
            if let Some(told) = told {
                draft.row(
                    told.name(),
                    told.value.as_str(),
                    Fate::Ignored,
                    "of an encoder: the drive comes from the preset",
                );
            }
            continue;
        }
        // What reaches the generator goes before what the INI file says of it.
        let steps = Steps::of_hal(hal, ini, index).or_else(|| told.map(Steps::of));
        if let (Some(steps), Some(told)) = (&steps, told)
            && told.name() != steps.from
        {
            let note = format!("{} counts", steps.from);
            draft.row(told.name(), told.value.as_str(), Fate::Ignored, note);
        }
        // A further motor is like the first.
        let own_axis = draft.axis(axis, turns);
        if let Some(stepper) = &own_axis.stepper {
            let unit = if turns { deg } else { mm };
            let first = stepper.steps_per_unit.as_ref();
            let first = first.map(|it| (it.from.clone(), float(it.value * unit)));
            further(draft, steps, first.as_ref());
            continue;
        }
        own_axis.stepper = Some(StepperDraft::default());
        // Where nobody tells the steps they are a guess of the stepper's drive, and listed there.
        if let Some(steps) = steps {
            // Old files have an offset behind it; the sign is the direction.
            let first = steps.value.split_whitespace().next().unwrap_or_default();
            let value = number(steps.line, &steps.from, first)?.abs();
            if value == 0.0 {
                let message = format!("is {}; it has to be other than 0", steps.value);
                return Err(problem(steps.line, &steps.from, message, ""));
            }
            let unit = if turns { deg } else { mm };
            let told = Told {
                value: value / unit,
                from: steps.from,
                line: steps.line,
            };
            draft.tell(axis, Quantity::StepsPerUnit, told, steps.value);
        }
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

/// Reports the steps of a further motor, and where the first has others: where those are told, and their number.
fn further(draft: &mut Draft, steps: Option<Steps<'_>>, first: Option<&(String, String)>) {
    let Some(steps) = steps else { return };
    // The sign is the direction; old files have an offset behind it.
    let own = steps.value.split_whitespace().next().unwrap_or_default();
    let own = own.trim_start_matches('-');
    let first = first.map(|(from, value)| (from.as_str(), value.as_str()));
    let note = unlike_first(first, own);
    draft.row(steps.from, steps.value, Fate::Ignored, note);
}

/// Says where the step generator has too little room for what the control adds at reversals.
fn room(draft: &mut Draft, entry: &Entry, limit: Option<&Entry>) -> Result<(), Problem> {
    let value = number(entry.line, &entry.name(), entry.plain())?;
    let limit = match limit {
        Some(limit) => number(limit.line, &limit.name(), limit.plain())?,
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
