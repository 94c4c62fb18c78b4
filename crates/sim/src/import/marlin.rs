//! Marlin's settings: what it answers to M503, or its Configuration.h and Configuration_adv.h.
//!
//! M92 steps/mm, M203 mm/s, M201 mm/s2, M906 current in mA (effective), M425 gap in mm with F and S.
//! `#define` of DEFAULT_AXIS_STEPS_PER_UNIT, DEFAULT_MAX_FEEDRATE, DEFAULT_MAX_ACCELERATION,
//! BACKLASH_DISTANCE_MM, BACKLASH_CORRECTION, BACKLASH_SMOOTHING_MM, X_MIN_POS, X_MAX_POS (with
//! X_BED_SIZE), X_MICROSTEPS, X_CURRENT, COREXY. M503 tells no travel. See
//! <https://marlinfw.org/docs/configuration/configuration.html>.

use super::draft::{Draft, Fate, MachineSize, Quantity, Told};
use super::mcodes::{self, Firmware, MCode};
use super::{Format, ImportOptions, not_negative, number, positive, problem};
use crate::control::Control;
use crate::machine::Problem;
use lostmotion_base::AxisId;
use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;

/// The format's row. Its files have no extension of their own.
pub(super) const FORMAT: Format = Format {
    name: "marlin",
    extensions: &[],
    looks_like: |text| {
        let code = |wanted: &str| {
            let mut codes = text.lines().filter_map(|line| mcodes::code(1, line));
            codes.any(|code| code.code == wanted)
        };
        text.contains("DEFAULT_AXIS_STEPS_PER_UNIT") || (code("M92") && code("M203"))
    },
    read,
};

const UNITS: Firmware = Firmware {
    speed: 1.0,
    peak_a: 1e-3 * SQRT_2,
};

/// Deepest chain of names that stand for names.
const DEEPEST: usize = 16;

const LETTERS: [AxisId; 3] = [AxisId::X, AxisId::Y, AxisId::Z];

/// How the gap is spread, and what was passed over.
#[derive(Default)]
struct Spread {
    correction: Option<f64>,
    smoothing_mm: Option<f64>,
    /// Defines that say nothing of an axis: too many for a row each.
    others: usize,
}

/// Reads the file.
fn read(text: &str, _: &ImportOptions<'_>) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft::new("Marlin");
    draft.dialect = Some("marlin");
    draft.control = Some(Control::Marlin);
    draft.size = MachineSize::Printer;
    let (mut problems, mut spread) = (Vec::new(), Spread::default());
    let defines: Vec<Define<'_>> = defines(text);
    let last: LastDefines<'_> = defines.iter().map(|it| (it.name, it.value)).collect();
    let mut is_corexy = false;
    for define in &defines {
        match take_define(&mut draft, &last, define, &mut spread) {
            Ok(found) => is_corexy |= found,
            Err(found) => problems.push(found),
        }
    }
    for (index, line) in text.lines().enumerate() {
        if let Some(code) = mcodes::code(index + 1, line)
            && let Err(found) = take(&mut draft, &code, &mut spread)
        {
            problems.push(found);
        }
    }
    if problems.is_empty() {
        let hint = "it has to be what Marlin answers to M503, or its Configuration.h";
        problems.extend(mcodes::no_axes(&draft, hint));
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    if spread.others > 0 {
        let note = "switches and values that say nothing of an axis";
        draft.row(
            "#define",
            format!("{} others", spread.others),
            Fate::Ignored,
            note,
        );
    }
    let settings = [
        ("correction", spread.correction),
        ("smoothing_mm", spread.smoothing_mm),
    ];
    let told = settings.map(|(key, value)| value.map(|value| (key, value)));
    // A correction of 0 is none.
    if spread.correction != Some(0.0) {
        draft.carry("fixed-by-travel", |_| told.into_iter().flatten().collect());
    }
    if is_corexy {
        draft.belts();
    }
    Ok(draft)
}

fn take(draft: &mut Draft, code: &MCode, spread: &mut Spread) -> Result<(), Problem> {
    match code.code.as_str() {
        "M425" => {
            for (letter, text) in &code.words {
                let value = match letter {
                    'F' => &mut spread.correction,
                    'S' => &mut spread.smoothing_mm,
                    _ => continue,
                };
                let name = code.name(*letter);
                *value = Some(not_negative(code.line, &name, text)?);
                draft.row(name, text.as_str(), Fate::Used, "how the gap is taken up");
            }
            mcodes::limits(draft, code, &UNITS)?;
        }
        "M205" => code.ignore(
            draft,
            "how suddenly corners are taken: no tolerance of the path",
        ),
        "M204" => code.ignore(
            draft,
            "acceleration by kind of move: the limit of the axes counts",
        ),
        "M665" => {
            let hint = "start from `machine show delta`";
            return Err(problem(code.line, "M665", "a delta is not read", hint));
        }
        _ => {
            if !mcodes::limits(draft, code, &UNITS)? {
                code.ignore(draft, "");
            }
        }
    }
    Ok(())
}

/// A line `#define NAME VALUE` that is no comment.
struct Define<'a> {
    line: usize,
    name: &'a str,
    value: &'a str,
}

/// What every name stands for.
type LastDefines<'a> = BTreeMap<&'a str, &'a str>;

fn defines(text: &str) -> Vec<Define<'_>> {
    let lines = text.lines().enumerate();
    lines
        .filter_map(|(index, line)| {
            let told = line.split("//").next()?.trim();
            let rest = told.strip_prefix("#define")?.trim_start();
            let (name, value) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            Some(Define {
                line: index + 1,
                name,
                value: value.trim(),
            })
        })
        .collect()
}

/// The number that a value is, or that the name in it stands for.
fn resolved(defines: &LastDefines<'_>, define: &Define<'_>, text: &str) -> Result<f64, Problem> {
    let mut text = text.trim().trim_matches(['(', ')']);
    for _ in 0..DEEPEST {
        match defines.get(text) {
            Some(value) => text = value.trim_matches(['(', ')']),
            None => break,
        }
    }
    number(define.line, define.name, text)
}

/// Takes a define over; whether it says that the machine is a CoreXY.
fn take_define(
    draft: &mut Draft,
    defines: &LastDefines<'_>,
    define: &Define<'_>,
    spread: &mut Spread,
) -> Result<bool, Problem> {
    let list = match define.name {
        "DEFAULT_AXIS_STEPS_PER_UNIT" => Some(Quantity::StepsPerUnit),
        "DEFAULT_MAX_FEEDRATE" => Some(Quantity::Velocity),
        "DEFAULT_MAX_ACCELERATION" => Some(Quantity::Acceleration),
        "BACKLASH_DISTANCE_MM" => Some(Quantity::Gap),
        _ => None,
    };
    if let Some(quantity) = list {
        let values = define.value.trim_matches(['{', '}']).split(',');
        for (axis, text) in LETTERS.into_iter().zip(values) {
            let value = resolved(defines, define, text)?;
            let shown = format!("{value}");
            let value = if quantity == Quantity::Gap {
                not_negative(define.line, define.name, &shown)?
            } else {
                positive(define.line, define.name, &shown)?
            };
            let told = Told {
                value,
                from: format!("{} {axis}", define.name),
                line: define.line,
            };
            draft.tell(axis, quantity, told, text.trim());
        }
        return Ok(false);
    }
    match define.name {
        "COREXY" => {
            draft.row("COREXY", "", Fate::Used, "kinematics");
            return Ok(true);
        }
        "DELTA" | "SCARA" | "MORGAN_SCARA" | "COREXZ" | "COREYZ" | "MARKFORGED_XY" | "POLAR" => {
            let hint =
                "known are cartesian and CoreXY; start from `machine show delta` for a delta";
            return Err(problem(define.line, define.name, "is not known here", hint));
        }
        "BACKLASH_CORRECTION" | "BACKLASH_SMOOTHING_MM" => {
            let value = resolved(defines, define, define.value)?;
            let slot = if define.name == "BACKLASH_CORRECTION" {
                &mut spread.correction
            } else {
                &mut spread.smoothing_mm
            };
            *slot = Some(not_negative(define.line, define.name, &format!("{value}"))?);
            draft.row(
                define.name,
                define.value,
                Fate::Used,
                "how the gap is taken up",
            );
            return Ok(false);
        }
        _ => {}
    }
    let mut name = define.name.chars();
    let axis = name.next().and_then(AxisId::from_letter);
    let quantity = match name.as_str() {
        "_MIN_POS" => Quantity::Min,
        "_MAX_POS" => Quantity::Max,
        "_MICROSTEPS" => Quantity::Microsteps,
        "_CURRENT" => Quantity::PeakCurrent,
        _ => {
            spread.others += 1;
            return Ok(false);
        }
    };
    let Some(axis) = axis.filter(|axis| LETTERS.contains(axis)) else {
        return Ok(false);
    };
    let value = resolved(defines, define, define.value)?;
    let factor = if quantity == Quantity::PeakCurrent {
        UNITS.peak_a
    } else {
        1.0
    };
    let told = Told {
        value: value * factor,
        from: define.name.to_owned(),
        line: define.line,
    };
    draft.tell(axis, quantity, told, define.value);
    Ok(false)
}
