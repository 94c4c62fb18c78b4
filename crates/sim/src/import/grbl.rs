//! grbl's and grblHAL's settings: lines `$110=1500.000 (x rate, mm/min)`.
//!
//! $100 to $105 steps/mm (or degree), $110 to $115 rate in mm/min, $120 to $125 acceleration in
//! mm/s2, $130 to $135 travel in mm, $160 to $165 (grblHAL) backlash in mm, for X Y Z A B C, and
//! $170 to $175 (grblHAL) the offset of an axis' second motor. $140 to
//! $149 differ from firmware to firmware: they are told.
//! Machine coordinates run from minus the travel to 0; where grblHAL sets its origin at the
//! switches ($22 with 8 in it) and an axis homes downwards ($23), from 0 to the travel. See
//! <https://github.com/gnea/grbl/wiki/Grbl-v1.1-Configuration>.

use super::draft::{Draft, Fate, LEADING, Quantity, Told};
use super::{Format, ImportOptions, number, positive, problem};
use crate::control::Control;
use crate::machine::Problem;
use lostmotion_base::AxisId;
use std::collections::BTreeMap;

/// The format's row. Its files have no extension of their own.
pub(super) const FORMAT: Format = Format {
    name: "grbl",
    extensions: &[],
    looks_like: |text| {
        let mut lines = text.lines().map(str::trim);
        lines.any(|line| line.starts_with("$1") && line.contains('='))
    },
    is_lines: true,
    read,
};

/// Bit of $22: the origin is where the switches are.
const ORIGIN_AT_HOME: u32 = 8;

/// What others are for, so that the report says more than a number.
const KNOWN: [(u32, &str); 21] = [
    (0, "length of a step's pulse"),
    (1, "delay before motors are released"),
    (2, "step pins inverted"),
    (3, "directions inverted"),
    (4, "enable pin inverted"),
    (5, "limit pins inverted"),
    (6, "probe pin inverted"),
    (10, "what status reports hold"),
    (
        11,
        "how fast corners are taken on the exact path: no tolerance of the path",
    ),
    (12, "chords of arcs: arcs are exact here"),
    (13, "reports in inches; settings stay in mm"),
    (20, "soft limits: always on here"),
    (21, "hard limits"),
    (24, "feed of homing"),
    (25, "feed of homing"),
    (26, "homing's debounce"),
    (27, "homing's pull-off"),
    (30, "spindle's speed"),
    (31, "spindle's speed"),
    (32, "laser mode"),
    (33, "spindle's pulse width"),
];

/// A line with a value.
struct Setting<'a> {
    line: usize,
    code: u32,
    value: &'a str,
    /// What stands behind the value.
    comment: &'a str,
}

impl Setting<'_> {
    /// `$110`, as the report has it.
    fn key(&self) -> String {
        format!("${}", self.code)
    }

    /// Whether it is the gap of an axis, mm.
    fn is_gap(&self) -> bool {
        self.code >= 160
    }
}

/// Reads the settings.
fn read(text: &str, options: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft::new("grbl");
    draft
        .expected
        .extend(super::XYZ.map(|axis| (axis, "machines of this control have it")));
    let (mut problems, mut settings, mut further) = (Vec::new(), Vec::new(), Vec::new());
    for (index, line) in text.lines().enumerate() {
        match setting(&mut draft, index + 1, line.trim()) {
            Ok(found) => settings.extend(found),
            Err(problem) => problems.push(problem),
        }
    }
    // The last one counts, as on the machine.
    let mut mask = |code: u32| {
        let Some(told) = settings.iter().rfind(|s| s.code == code) else {
            let why = "not told: as if it were 0";
            draft.row(format!("${code}"), "0", Fate::Guessed, why);
            return 0;
        };
        told.value.parse::<u32>().unwrap_or_else(|_| {
            let message = format!("`{}` is no mask", told.value);
            let hint = "a whole number, such as 3";
            problems.push(problem(told.line, &format!("${code}"), message, hint));
            0
        })
    };
    // Axes whose travel runs from 0 upwards: those that home downwards, with the origin there.
    let upwards = if mask(22) & ORIGIN_AT_HOME != 0 {
        mask(23)
    } else {
        0
    };
    let last: BTreeMap<u32, usize> = settings
        .iter()
        .enumerate()
        .map(|(index, setting)| (setting.code, index))
        .collect();
    for setting in &settings {
        // Given again further on: this one does not count, which is told.
        let last = last.get(&setting.code).and_then(|at| settings.get(*at));
        if let Some(last) = last.filter(|last| !std::ptr::eq(*last, setting)) {
            draft.row(
                format!("${}", setting.code),
                setting.value,
                Fate::Ignored,
                format!(
                    "line {}: given again in line {}, which counts",
                    setting.line, last.line
                ),
            );
            continue;
        }
        if let Err(problem) = take(&mut draft, setting, upwards, &mut further) {
            problems.push(problem);
        }
    }
    if draft.axes.is_empty() && problems.is_empty() {
        problems.push(problem(
            1,
            "",
            "there is no setting of an axis",
            "it has to be what grbl answers to `$$`, with $110=... and so on",
        ));
    }
    // A machine that the user names lends what is not told.
    if options.preset.is_none() {
        defaults(&mut draft, &last, upwards);
    }
    draft.add_motors(&further);
    // grblHAL where it was built with $160: a rapid before the move.
    if draft.axes.iter().any(|axis| axis.gap.is_some()) {
        draft.control = Some(Control::GrblHal);
        draft.carry("fixed", |_| Vec::new());
    }
    if problems.is_empty() {
        Ok(draft)
    } else {
        Err(problems)
    }
}

/// grbl's own settings (1.1, defaults.h, DEFAULTS_GENERIC): that of X, value in its unit, factor to mm and s, and
/// the quantity.
const DEFAULTS: [(u32, f64, f64, Quantity); 4] = [
    (100, 250.0, 1.0, Quantity::StepsPerUnit),
    (110, 500.0, 1.0 / 60.0, Quantity::Velocity),
    (120, 10.0, 1.0, Quantity::Acceleration),
    (130, 200.0, 1.0, Quantity::Max),
];

/// Takes grbl's own settings for those that the answer lacks of a linear axis that it has: guesses, since grblHAL
/// and builders of machines have others.
fn defaults(draft: &mut Draft, told: &BTreeMap<u32, usize>, upwards: u32) {
    let axes: Vec<AxisId> = draft.axes.iter().map(|axis| axis.id).collect();
    for axis in axes.into_iter().filter(|axis| !axis.is_rotary()) {
        for (first, value, factor, quantity) in DEFAULTS {
            let code = first + axis.index() as u32;
            if told.contains_key(&code) {
                continue;
            }
            let own = Told {
                value: value * factor,
                from: format!("guess: ${code} is not told, grbl's own is {value}"),
                line: 1,
            };
            if quantity == Quantity::Max {
                let (min, max) = ends(axis, value, upwards);
                let end = |value: f64| Told {
                    value,
                    ..own.clone()
                };
                draft.default(axis, Quantity::Min, end(min));
                draft.default(axis, quantity, end(max));
            } else {
                draft.default(axis, quantity, own);
            }
            let note = "not told: grbl's own (1.1); grblHAL and builders of machines have others";
            draft.row(format!("${code}"), value.to_string(), Fate::Guessed, note);
        }
    }
}

/// A line; `None` if it is no setting.
fn setting<'a>(
    draft: &mut Draft,
    line: usize,
    text: &'a str,
) -> Result<Option<Setting<'a>>, Problem> {
    // A sender's prompt, or the command itself.
    let text = text.trim_start_matches(['>', '<', ' ']);
    let Some(rest) = text
        .strip_prefix('$')
        .filter(|rest| !rest.starts_with(['$', 'N', 'I', 'G', '#', 'H', 'X', 'C', 'S', 'J']))
    else {
        if !text.is_empty() && text != "ok" {
            draft.row(
                format!("line {line}"),
                text.chars().take(60).collect::<String>(),
                Fate::Ignored,
                "not a setting",
            );
        }
        return Ok(None);
    };
    // From here on it is a setting, well written or not.
    let hint = "settings are written as $110=1500.0";
    let (key, value) = rest
        .split_once('=')
        .ok_or_else(|| problem(line, text, "has no value", hint))?;
    let code = key
        .trim()
        .parse()
        .map_err(|_| problem(line, &format!("${}", key.trim()), "is not a setting", hint))?;
    let end = value.find(['(', ';']).unwrap_or(value.len());
    let (value, comment) = value.split_at(end);
    Ok(Some(Setting {
        line,
        code,
        value: value.trim(),
        comment,
    }))
}

fn says(comment: &str, word: &str) -> bool {
    comment.to_ascii_lowercase().contains(word)
}

/// What $140 to $149 are, which controls use in their own ways: of uCNC and of forks of grbl for
/// megas the backlash, a current of grblHAL and Grbl_Esp32.
fn of_driver_or_gap(comment: &str) -> &'static str {
    if says(comment, "backlash") {
        "backlash, not carried, since firmware has it in mm or in steps: as gap_um in the axis' load, with compensation.method = \"fixed\""
    } else if says(comment, "current") {
        "of the motor's driver: the drive comes from the preset"
    } else {
        "a current of the motor's driver (grblHAL, Grbl_Esp32), or backlash in mm or steps (uCNC, grbl-mega): not carried; if it is backlash, as gap_um in the axis' load, with compensation.method = \"fixed\""
    }
}

/// Takes a setting over; `upwards` are the axes whose travel runs from 0 upwards.
fn take(
    draft: &mut Draft,
    setting: &Setting<'_>,
    upwards: u32,
    further: &mut Vec<(AxisId, String)>,
) -> Result<(), Problem> {
    let Setting {
        line,
        code,
        value,
        comment,
    } = *setting;
    let name = setting.key();
    // The last digit is the axis, those before it the quantity: $110 is the rate of X.
    let axis = AxisId::from_index((code % 10) as usize)
        .filter(|axis| axis.index() < 6 && (100..170).contains(&code));
    let Some(axis) = axis.filter(|_| !matches!(code / 10, 14 | 15)) else {
        of_no_limit(draft, setting, further);
        return Ok(());
    };
    if code < 110 {
        let told = Told {
            value: positive(line, &name, value)?,
            from: name,
            line,
        };
        draft.tell(axis, Quantity::StepsPerUnit, told, value);
        return Ok(());
    }
    let amount = number(line, &name, value)?;
    // grblHAL tells gaps with three digits behind the point.
    if setting.is_gap() && amount >= 1.0 && !value.contains('.') && !says(comment, "backlash") {
        let note =
            "a whole number: microsteps (Grbl_Esp32), no gap in mm; a gap is written as 1.000";
        draft.row(name, value, Fate::Ignored, note);
        return Ok(());
    }
    // grblHAL holds no axis to a travel of 0, as tables that turn have it.
    if code / 10 == 13 && amount == 0.0 && axis.is_rotary() {
        draft.axis(axis, true);
        draft.row(name, value, Fate::Ignored, "no limit");
        return Ok(());
    }
    if setting.is_gap() && amount < 0.0 {
        draft.row(name, value, Fate::Ignored, LEADING);
        return Ok(());
    }
    check_amount(setting, amount)?;
    limit(draft, setting, axis, amount, upwards);
    Ok(())
}

/// Reports a setting that is neither steps, a limit nor a gap of an axis.
fn of_no_limit(draft: &mut Draft, setting: &Setting<'_>, further: &mut Vec<(AxisId, String)>) {
    let code = setting.code;
    let (fate, note) = match code {
        22 | 23 => (Fate::Used, "where the machine's zero is"),
        140..150 => (Fate::Ignored, of_driver_or_gap(setting.comment)),
        // Told where the axis has two motors and a switch for each.
        170..176 => {
            let axis = AxisId::from_index((code % 10) as usize);
            let name = setting.key();
            further.extend(axis.map(|axis| (axis, format!("{name} second motor"))));
            (
                Fate::Used,
                "of the second motor of an axis, by which it is squared",
            )
        }
        150..160 => (
            Fate::Ignored,
            "of the motor's driver: the drive comes from the preset",
        ),
        _ => (
            Fate::Ignored,
            KNOWN
                .iter()
                .find(|(known, _)| *known == code)
                .map_or("no limit of an axis", |(_, note)| note),
        ),
    };
    draft.row(setting.key(), setting.value, fate, note);
}

/// Refuses a limit that is none: one of 0 would stop the axis. A gap of 0 is none.
fn check_amount(setting: &Setting<'_>, amount: f64) -> Result<(), Problem> {
    if setting.is_gap() || amount > 0.0 {
        return Ok(());
    }
    let message = format!("is {}; it has to be above 0", setting.value);
    let hint = "leave the line out if it is not known";
    Err(problem(setting.line, &setting.key(), message, hint))
}

/// The ends of a travel of an axis; bit n of `upwards` is the nth axis.
fn ends(axis: AxisId, travel: f64, upwards: u32) -> (f64, f64) {
    if upwards >> axis.index() & 1 == 1 {
        (0.0, travel)
    } else {
        (-travel, 0.0)
    }
}

/// Takes over a limit or a gap of an axis.
fn limit(draft: &mut Draft, setting: &Setting<'_>, axis: AxisId, amount: f64, upwards: u32) {
    let entry = draft.axis(axis, axis.is_rotary());
    let told = |value: f64| {
        Some(Told {
            value,
            from: setting.key(),
            line: setting.line,
        })
    };
    let what = match setting.code / 10 {
        11 => {
            entry.velocity = told(amount / 60.0);
            "velocity, from units/min"
        }
        12 => {
            entry.acceleration = told(amount);
            "acceleration"
        }
        13 => {
            let (min, max) = ends(axis, amount, upwards);
            (entry.min, entry.max) = (told(min), told(max));
            if max > 0.0 {
                "travel, from 0 to this"
            } else {
                "travel, from minus this to 0"
            }
        }
        _ => {
            entry.gap = told(amount);
            "gap"
        }
    };
    let note = format!("{what} of {axis}");
    draft.row(setting.key(), setting.value, Fate::Used, note);
}
