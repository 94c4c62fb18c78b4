//! Marlin's settings: what it answers to M503, or its Configuration.h and Configuration_adv.h.
//!
//! M92 steps/mm, M203 mm/s, M201 mm/s2, M906 current in mA (effective), M425 gap in mm with F and S.
//! `#define` of DEFAULT_AXIS_STEPS_PER_UNIT, DEFAULT_MAX_FEEDRATE, DEFAULT_MAX_ACCELERATION,
//! BACKLASH_DISTANCE_MM, BACKLASH_CORRECTION, BACKLASH_SMOOTHING_MM, X_MIN_POS, X_MAX_POS (with
//! X_BED_SIZE), X_MICROSTEPS, X_CURRENT, COREXY. M503 tells no travel, and its answer
//! in inches (G20) is refused. See
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
            let mut codes = text.lines().map(|line| mcodes::code(1, line));
            codes.any(|code| matches!(code, Ok(Some(code)) if code.code == wanted))
        };
        text.contains("DEFAULT_AXIS_STEPS_PER_UNIT") || (code("M92") && code("M203"))
    },
    is_lines: true,
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
    /// Motors of axes behind their first.
    further: Vec<(AxisId, String)>,
}

/// Reads the file.
fn read(text: &str, _: &ImportOptions<'_>) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft::new("Marlin");
    draft.dialect = Some("marlin");
    draft.control = Some(Control::Marlin);
    draft.size = MachineSize::Printer;
    draft
        .expected
        .extend(super::XYZ.map(|axis| (axis, "machines of this control have it")));
    let (mut problems, mut spread) = (Vec::new(), Spread::default());
    let defines = defines(text)?;
    let last: LastDefines<'_> = defines.iter().map(|it| (it.name, it.value)).collect();
    let mut is_corexy = false;
    for define in &defines {
        match take_define(&mut draft, &last, define, &mut spread) {
            Ok(found) => is_corexy |= found,
            Err(found) => problems.push(found),
        }
    }
    let is_header = !defines.is_empty();
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        let code = match mcodes::code(number, line) {
            // Lines of a header are C, and as many as those of a book.
            Ok(None) if is_header => Ok(()),
            Ok(None) => {
                if let Some(text) = mcodes::other(line) {
                    draft.row(format!("line {number}"), text, Fate::Ignored, "no code");
                }
                Ok(())
            }
            Ok(Some(code)) => take(&mut draft, &code, &mut spread),
            Err(found) => Err(found),
        };
        problems.extend(code.err());
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
    if draft.axes.iter().any(|axis| axis.gap.is_some()) {
        for (key, _) in settings.iter().filter(|(_, value)| value.is_none()) {
            let why = "how the gap is taken up is not told";
            draft.row(
                format!("fixed_by_travel.{key}"),
                "usual",
                Fate::Guessed,
                why,
            );
        }
    }
    // A correction of 0 is none.
    if spread.correction != Some(0.0) {
        draft.carry("fixed-by-travel", |_| told.into_iter().flatten().collect());
    }
    draft.add_motors(&spread.further);
    if is_corexy {
        draft.belts();
    }
    Ok(draft)
}

fn take(draft: &mut Draft, code: &MCode, spread: &mut Spread) -> Result<(), Problem> {
    code.check()?;
    match code.code.as_str() {
        "M906" | "M350" if code.word('I').is_some_and(|index| index.trim() != "0") => {
            let index = code.word('I').map_or("", str::trim);
            let words = code.words.iter();
            let axes = words.filter_map(|(letter, _)| AxisId::from_letter(*letter));
            spread
                .further
                .extend(axes.map(|axis| (axis, format!("motor I{index} of {axis}"))));
            code.ignore(draft, "further motors, taken to be like the first");
        }
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
        // Its answer in inches divides steps of a mm by 25.4 where it should multiply them, and not
        // every version has all of the rest in inches.
        "G20" => {
            let message = "the settings are in inches, in which Marlin tells wrong steps";
            let hint = "send G21 before M503, and import that answer";
            return Err(problem(code.line, "G20", message, hint));
        }
        "G21" => draft.row("G21", "", Fate::Used, "the settings are in mm"),
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

/// What may stand behind the hash of a header's line.
const DIRECTIVES: [&str; 13] = [
    "define", "undef", "if", "ifdef", "ifndef", "elif", "else", "endif", "include", "error",
    "warning", "pragma", "line",
];

/// The defines of a header; none if the text is none.
///
/// # Errors
/// Directives that are none, and comments and conditions that do not end: of a header that was cut.
fn defines(text: &str) -> Result<Vec<Define<'_>>, Vec<Problem>> {
    if !text.lines().any(|line| line.contains("#define")) {
        return Ok(Vec::new());
    }
    let (mut found, mut problems) = (Vec::new(), Vec::new());
    // Where a comment, and where conditions began that have not ended yet.
    let (mut comment, mut conditions) = (None, Vec::new());
    for (index, line) in text.lines().enumerate() {
        let line_number = index + 1;
        let mut told = line;
        if comment.is_some() {
            let Some((_, behind)) = told.split_once("*/") else {
                continue;
            };
            (comment, told) = (None, behind);
        }
        told = told.split("//").next().unwrap_or_default();
        if let Some((before, behind)) = told.split_once("/*") {
            told = before;
            if !behind.contains("*/") {
                comment = Some(line_number);
            }
        }
        let Some(rest) = told.trim().strip_prefix('#') else {
            continue;
        };
        let rest = rest.trim_start();
        let end = rest
            .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
            .unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        match word {
            "define" => {
                let (name, value) = rest
                    .trim_start()
                    .split_once(char::is_whitespace)
                    .unwrap_or((rest.trim_start(), ""));
                if name.is_empty() {
                    problems.push(problem(line_number, "#define", "has no name", CUT));
                }
                found.push(Define {
                    line: line_number,
                    name,
                    value: value.trim(),
                });
            }
            "if" | "ifdef" | "ifndef" => conditions.push(line_number),
            "endif" if conditions.pop().is_none() => {
                let message = "there is no #if before it";
                problems.push(problem(line_number, "#endif", message, CUT));
            }
            word if !DIRECTIVES.contains(&word) => {
                let key = format!("#{word}");
                let hint = "write #define NAME VALUE";
                problems.push(problem(line_number, &key, "is no directive", hint));
            }
            _ => {}
        }
    }
    for (open, what) in [(conditions.last().copied(), "#if"), (comment, "/*")] {
        if let Some(line) = open {
            problems.push(problem(line, what, "does not end", CUT));
        }
    }
    if problems.is_empty() {
        Ok(found)
    } else {
        Err(problems)
    }
}

/// What damage like this may come from.
const CUT: &str = "is a part of the file missing?";

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
        let values = define
            .value
            .strip_prefix('{')
            .and_then(|rest| rest.strip_suffix('}'));
        let Some(values) = values else {
            let message = format!("`{}` is no list", define.value);
            let hint = "write { 80, 80, 400 }";
            return Err(problem(define.line, define.name, message, hint));
        };
        for (axis, text) in LETTERS.into_iter().zip(values.split(',')) {
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
