//! Siemens Sinumerik 840D, 828D, 808D: machine data of an archive as text, lines
//! `N32450 $MA_BACKLASH[0,AX1]=0.012`.
//!
//! MD10000 AXCONF_MACHAX_NAME_TAB, MD10240 SCALING_SYSTEM_IS_METRIC, MD30300 IS_ROT_AX, MD32000
//! MAX_AX_VELO (mm/min, rev/min), MD32300 MAX_AX_ACCEL (m/s2, rev/s2), MD32431 MAX_AX_JERK (m/s3,
//! rev/s3), MD32450 BACKLASH (mm, deg), MD36100 and MD36110 POS_LIMIT_MINUS and PLUS. Axes are AX1
//! and so on, or the names of MD10000; of data with an index the first counts. Source: SINUMERIK
//! 840D sl, Detailed description of the machine data (list manual).

use super::draft::{Draft, Fate, Quantity, Told};
use super::{Format, ImportOptions, not_negative, number, positive, problem};
use crate::control::Control;
use crate::machine::Problem;
use lostmotion_base::AxisId;
use std::collections::BTreeSet;

/// The format's row. Its files have the extensions of many.
pub(super) const FORMAT: Format = Format {
    name: "sinumerik",
    extensions: &[],
    looks_like: |text| text.contains("$MA_") || text.contains("$MN_"),
    read,
};

/// Ends of travel from here on are the control's default, that is none, mm or deg.
const NO_LIMIT: f64 = 1e7;

/// Machine axes that an archive may name.
const MOST_AXES: usize = 64;

const DEGREES: f64 = 360.0;

/// A line with a value.
struct Datum<'a> {
    line: usize,
    name: &'a str,
    /// What stands in the brackets.
    index: Vec<&'a str>,
    value: &'a str,
}

impl Datum<'_> {
    /// `MD of AX1`, as the report has it.
    fn key(&self) -> String {
        format!("${}[{}]", self.name, self.index.join(","))
    }
}

fn datum(line: usize, text: &str) -> Option<Datum<'_>> {
    let told = text.split(';').next()?.trim();
    let rest = &told[told.find("$M")? + 1..];
    let (left, value) = rest.split_once('=')?;
    let (name, index) = match left.split_once('[') {
        Some((name, rest)) => (name, rest.split_once(']')?.0),
        None => (left, ""),
    };
    Some(Datum {
        line,
        name: name.trim(),
        index: index
            .split(',')
            .map(str::trim)
            .filter(|part| !part.is_empty())
            .collect(),
        // The archive's check sum stands behind it.
        value: value.split('\'').next()?.trim().trim_matches('"'),
    })
}

/// An axis' name in the archive, and which it is.
struct AxisName {
    name: String,
    number: usize,
    axis: Option<AxisId>,
}

/// Reads the archive.
fn read(text: &str, _: &ImportOptions<'_>) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft::new("Sinumerik");
    draft.dialect = Some("siemens");
    draft.control = Some(Control::Siemens);
    let lines = text.lines().enumerate();
    let data: Vec<Datum<'_>> = lines
        .filter_map(|(index, line)| datum(index + 1, line))
        .collect();
    let mut names = Vec::new();
    for datum in data
        .iter()
        .filter(|it| it.name == "MN_AXCONF_MACHAX_NAME_TAB")
    {
        let number = datum.index.first().and_then(|it| it.parse::<usize>().ok());
        if let Some(number) = number.filter(|number| *number < MOST_AXES) {
            names.retain(|it: &AxisName| it.number != number + 1);
            names.push(AxisName {
                name: datum.value.to_owned(),
                number: number + 1,
                axis: datum.value.chars().next().and_then(AxisId::from_letter),
            });
        }
    }
    // Axes that are spindles are none here.
    let spindles: BTreeSet<&str> = data
        .iter()
        .filter(|it| it.name == "MA_SPIND_ASSIGN_TO_MACHAX" && it.value != "0")
        .filter_map(|it| it.index.last().copied())
        .collect();
    let turning: BTreeSet<&str> = data
        .iter()
        .filter(|it| it.name == "MA_IS_ROT_AX" && matches!(it.value, "1" | "TRUE" | "true"))
        .filter_map(|it| it.index.last().copied())
        .collect();
    let mut problems = Vec::new();
    let mut guessed = Vec::new();
    for datum in &data {
        let key = datum.key();
        if datum.name == "MN_SCALING_SYSTEM_IS_METRIC" {
            if datum.value == "0" || datum.value.eq_ignore_ascii_case("false") {
                let message = "the machine's data are in inches, which are not read";
                let hint = "switch the basic system to metric and write the archive again";
                problems.push(problem(datum.line, &key, message, hint));
            }
            draft.row(key, datum.value, Fate::Used, "unit of the data");
            continue;
        }
        let axis = datum
            .index
            .last()
            .filter(|own| datum.name.starts_with("MA_") && !spindles.contains(*own))
            .and_then(|own| axis_of(own, &names, &mut guessed));
        let first = datum.index.len() < 2 || datum.index[0] == "0";
        let Some(axis) = axis.filter(|_| first) else {
            let fate = if datum.name == "MN_AXCONF_MACHAX_NAME_TAB" {
                Fate::Used
            } else {
                Fate::Ignored
            };
            draft.row(key, datum.value, fate, "");
            continue;
        };
        let rotary = datum.index.last().is_some_and(|own| turning.contains(own));
        // A letter says the kind: X Y Z U V W slide, A B C turn.
        if rotary != axis.is_rotary() {
            let note = format!("{axis} does not {}", if rotary { "turn" } else { "slide" });
            draft.row(key, datum.value, Fate::Ignored, note);
            continue;
        }
        if let Err(found) = take(&mut draft, datum, axis) {
            problems.push(found);
        }
    }
    for (name, axis) in guessed {
        let why = "its name in MD10000 is not in the file: by its number";
        draft.row(name, format!("axis {axis}"), Fate::Guessed, why);
    }
    if draft.axes.is_empty() && problems.is_empty() {
        let hint = "write the archive as text with the axes' machine data ($MA_...)";
        problems.push(problem(1, "", "there is no machine data of an axis", hint));
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    draft.carry("actual-value", |_| Vec::new());
    Ok(draft)
}

/// The axis that an index names: a name of MD10000, or AX1; by its number where it has no name.
fn axis_of(own: &str, names: &[AxisName], guessed: &mut Vec<(String, AxisId)>) -> Option<AxisId> {
    if let Some(named) = names.iter().find(|it| it.name == own) {
        return named.axis;
    }
    let number = own
        .strip_prefix("AX")
        .and_then(|it| it.parse::<usize>().ok());
    let Some(number) = number else {
        return own.chars().next().and_then(AxisId::from_letter);
    };
    if let Some(named) = names.iter().find(|it| it.number == number) {
        return named.axis;
    }
    let axis = AxisId::from_index(number.checked_sub(1)?)?;
    if !guessed.iter().any(|(_, known)| *known == axis) {
        guessed.push((own.to_owned(), axis));
    }
    Some(axis)
}

fn take(draft: &mut Draft, datum: &Datum<'_>, axis: AxisId) -> Result<(), Problem> {
    let key = datum.key();
    let turns = axis.is_rotary();
    // mm/min or rev/min; m/s2 or rev/s2.
    let per_minute = if turns { DEGREES / 60.0 } else { 1.0 / 60.0 };
    let per_second = if turns { DEGREES } else { 1e3 };
    let above_zero = |factor: f64| Ok(positive(datum.line, &key, datum.value)? * factor);
    let (quantity, amount) = match datum.name {
        "MA_MAX_AX_VELO" => (Quantity::Velocity, above_zero(per_minute)?),
        "MA_MAX_AX_ACCEL" => (Quantity::Acceleration, above_zero(per_second)?),
        "MA_MAX_AX_JERK" => (Quantity::Jerk, above_zero(per_second)?),
        "MA_POS_LIMIT_MINUS" | "MA_POS_LIMIT_PLUS" => {
            let end = number(datum.line, &key, datum.value)?;
            if end.abs() >= NO_LIMIT {
                draft.row(key, datum.value, Fate::Ignored, "no limit");
                return Ok(());
            }
            let quantity = if datum.name == "MA_POS_LIMIT_PLUS" {
                Quantity::Max
            } else {
                Quantity::Min
            };
            (quantity, end)
        }
        "MA_BACKLASH" => {
            if datum.value.starts_with('-') {
                let hint = "make it positive to go on with a motor's encoder";
                let message = "is negative: of an encoder that the load leads, which is not read";
                return Err(problem(datum.line, &key, message, hint));
            }
            (Quantity::Gap, not_negative(datum.line, &key, datum.value)?)
        }
        "MA_IS_ROT_AX" => {
            draft.row(key, datum.value, Fate::Used, "kind of axis");
            return Ok(());
        }
        "MA_POSCTRL_GAIN" => {
            let gain = positive(datum.line, &key, datum.value)? * 1e3 / 60.0;
            let note = format!(
                "position_gain_per_s = {gain:.1}: the other gains come from the preset, set it with them"
            );
            draft.row(key, datum.value, Fate::Ignored, note);
            return Ok(());
        }
        "MA_LEADSCREW_PITCH" => {
            let note = "lead_mm: the drive comes from the preset, set it with motor and gains";
            draft.row(key, datum.value, Fate::Ignored, note);
            return Ok(());
        }
        _ => {
            draft.row(key, datum.value, Fate::Ignored, "");
            return Ok(());
        }
    };
    let told = Told {
        value: amount,
        from: key,
        line: datum.line,
    };
    draft.tell(axis, quantity, told, datum.value);
    Ok(())
}
