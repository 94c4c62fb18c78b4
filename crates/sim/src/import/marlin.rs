//! Marlin's settings: what it answers to M503, or its Configuration.h and Configuration_adv.h.
//!
//! M92 steps/mm, M203 mm/s, M201 mm/s2, M906 current in mA (effective), M425 gap in mm with F and S.
//! `#define` of DEFAULT_AXIS_STEPS_PER_UNIT, DEFAULT_MAX_FEEDRATE, DEFAULT_MAX_ACCELERATION,
//! BACKLASH_DISTANCE_MM, BACKLASH_CORRECTION, BACKLASH_SMOOTHING_MM, X_MIN_POS, X_MAX_POS (with
//! X_BED_SIZE), X_MICROSTEPS, X_CURRENT, COREXY. M503 tells no travel, and its answer
//! in inches (G20) is refused. Conditions
//! are read (`header`), values may be sums and products of names, and a Configuration_adv.h beside a
//! Configuration.h is read behind it. See
//! <https://marlinfw.org/docs/configuration/configuration.html>.

use super::draft::{Draft, Fate, MachineSize, Quantity, Told};
use super::expression::Untold;
use super::header::{Define, Header};
use super::mcodes::{self, Firmware, MCode};
use super::{Format, ImportOptions, not_negative, number, positive, problem};
use crate::control::Control;
use crate::machine::Problem;
use lostmotion_base::AxisId;
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
        text.contains(STEPS)
            || (text.contains("#define") && is_companion(text))
            || (code("M92") && code("M203"))
    },
    is_lines: true,
    read,
};

const UNITS: Firmware = Firmware {
    speed: 1.0,
    peak_a: 1e-3 * SQRT_2,
};

/// The switch of the backlash compensation.
const BACKLASH: &str = "BACKLASH_COMPENSATION";

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
fn read(text: &str, options: &ImportOptions<'_>, name: &str) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft::new("Marlin");
    draft.dialect = Some("marlin");
    draft.control = Some(Control::Marlin);
    draft.size = MachineSize::Printer;
    draft
        .expected
        .extend(super::XYZ.map(|axis| (axis, "machines of this control have it")));
    let (mut problems, mut spread) = (Vec::new(), Spread::default());
    let header = header(&mut draft, text, options, name)?;
    let mut is_corexy = false;
    for define in &header.defines {
        match take_define(&mut draft, &header, define, &mut spread) {
            Ok(found) => is_corexy |= found,
            Err(found) => problems.push(found),
        }
    }
    let is_header = !header.defines.is_empty();
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
    carry(&mut draft, &header, &spread);
    draft.add_motors(&spread.further);
    if is_corexy {
        draft.belts();
    }
    Ok(draft)
}

/// What the control does about gaps that are told. A header tells it by a switch, and an answer to M503
/// only where it is on.
fn carry(draft: &mut Draft, header: &Header, spread: &Spread) {
    let has_gap = draft.axes.iter().any(|axis| axis.gap.is_some());
    if has_gap && !header.defines.is_empty() && header.is_on(BACKLASH) != Some(true) {
        let note = "the control takes up no gap without it: BACKLASH_DISTANCE_MM is the gap alone";
        draft.row(BACKLASH, "not defined", Fate::Ignored, note);
        return;
    }
    let settings = [
        ("correction", spread.correction),
        ("smoothing_mm", spread.smoothing_mm),
    ];
    let told = settings.map(|(key, value)| value.map(|value| (key, value)));
    if has_gap {
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

/// The header beside Configuration.h, which Marlin reads behind it.
const COMPANION: &str = "Configuration_adv.h";

/// Defines that only that one has.
const OF_COMPANION: [&str; 3] = [
    "CONFIGURATION_ADV_H_VERSION",
    "BACKLASH_DISTANCE_MM",
    "X_MICROSTEPS",
];

/// Reads the defines of a header and, if it is a Configuration.h, of the one beside it; none if the
/// text is no header.
fn header(
    draft: &mut Draft,
    text: &str,
    options: &ImportOptions<'_>,
    name: &str,
) -> Result<Header, Vec<Problem>> {
    let mut header = Header::default();
    if !text.lines().any(|line| line.contains("#define")) {
        return Ok(header);
    }
    header.read(text, None)?;
    if is_companion(text) {
        let message = format!("is the {COMPANION} of a configuration, without its Configuration.h");
        let hint = "import the Configuration.h beside it: both are read then";
        return Err(vec![problem(1, "", message, hint)]);
    }
    if !name.eq_ignore_ascii_case("Configuration.h") {
        return Ok(header);
    }
    match options.files.text(COMPANION) {
        Ok(beside) if beside.len() > options.max_bytes.saturating_sub(text.len()) => {
            let message = format!("together more than {} bytes", options.max_bytes);
            return Err(vec![problem(1, COMPANION, message, "")]);
        }
        Ok(beside) => {
            header.read(&beside, Some(COMPANION))?;
            draft.row(COMPANION, "", Fate::Used, "read behind Configuration.h");
        }
        Err(why) => {
            let note = format!("not read ({why}): backlash, currents and microsteps stand there");
            draft.row(COMPANION, "", Fate::Ignored, note);
        }
    }
    Ok(header)
}

/// Whether a header is a Configuration_adv.h alone.
fn is_companion(text: &str) -> bool {
    !text.contains(STEPS) && OF_COMPANION.iter().any(|name| text.contains(name))
}

/// What every Configuration.h has.
const STEPS: &str = "DEFAULT_AXIS_STEPS_PER_UNIT";

/// The number that a value is; `None` where what it depends on cannot be told, which is said.
fn resolved(
    draft: &mut Draft,
    header: &Header,
    define: &Define,
    text: &str,
) -> Result<Option<f64>, Problem> {
    match header.number(text) {
        Ok(value) => Ok(Some(value)),
        Err(Untold::Unknown(name)) if header.is_told(&name) || name.contains('(') => {
            let note = format!("depends on {name}, which cannot be told from the file");
            draft.row(define.key(), define.value.as_str(), Fate::Ignored, note);
            Ok(None)
        }
        Err(Untold::Unknown(what)) => number(define.line, &define.key(), &what).map(Some),
        Err(Untold::Bad(_)) => number(define.line, &define.key(), text).map(Some),
    }
}

/// Whether a define says something of an axis or of the kinematics.
fn is_read(name: &str) -> bool {
    list_of(name).is_some()
        || quantity_of(name).is_some()
        || OTHER_KINEMATICS.contains(&name)
        || matches!(
            name,
            "COREXY" | "BACKLASH_CORRECTION" | "BACKLASH_SMOOTHING_MM"
        )
}

/// Kinematics that are not read.
const OTHER_KINEMATICS: [&str; 7] = [
    "DELTA",
    "SCARA",
    "MORGAN_SCARA",
    "COREXZ",
    "COREYZ",
    "MARKFORGED_XY",
    "POLAR",
];

/// What a list of a value for each axis tells.
fn list_of(name: &str) -> Option<Quantity> {
    match name {
        STEPS => Some(Quantity::StepsPerUnit),
        "DEFAULT_MAX_FEEDRATE" => Some(Quantity::Velocity),
        "DEFAULT_MAX_ACCELERATION" => Some(Quantity::Acceleration),
        "BACKLASH_DISTANCE_MM" => Some(Quantity::Gap),
        _ => None,
    }
}

/// What a value of one axis tells: `X_MAX_POS`.
fn quantity_of(name: &str) -> Option<(AxisId, Quantity)> {
    let mut rest = name.chars();
    let axis = rest.next().and_then(AxisId::from_letter);
    let quantity = match rest.as_str() {
        "_MIN_POS" => Quantity::Min,
        "_MAX_POS" => Quantity::Max,
        "_MICROSTEPS" => Quantity::Microsteps,
        "_CURRENT" => Quantity::PeakCurrent,
        _ => return None,
    };
    let axis = axis.filter(|axis| LETTERS.contains(axis))?;
    Some((axis, quantity))
}

/// Takes a list over, a value for each axis.
fn take_list(
    draft: &mut Draft,
    header: &Header,
    define: &Define,
    quantity: Quantity,
) -> Result<(), Problem> {
    let key = define.key();
    let values = define
        .value
        .strip_prefix('{')
        .and_then(|rest| rest.strip_suffix('}'));
    let Some(values) = values else {
        let message = format!("`{}` is no list", define.value);
        let hint = "write { 80, 80, 400 }";
        return Err(problem(define.line, &key, message, hint));
    };
    for (axis, text) in LETTERS.into_iter().zip(values.split(',')) {
        let Some(value) = resolved(draft, header, define, text)? else {
            continue;
        };
        let shown = format!("{value}");
        let value = if quantity == Quantity::Gap {
            not_negative(define.line, &key, &shown)?
        } else {
            positive(define.line, &key, &shown)?
        };
        let told = Told {
            value,
            from: define.key_of(axis),
            line: define.line,
        };
        draft.tell(axis, quantity, told, text.trim());
    }
    Ok(())
}

/// Takes a define over; whether it says that the machine is a CoreXY.
fn take_define(
    draft: &mut Draft,
    header: &Header,
    define: &Define,
    spread: &mut Spread,
) -> Result<bool, Problem> {
    let name = define.name.as_str();
    if !is_read(name) {
        spread.others += 1;
        return Ok(false);
    }
    let key = define.key();
    if let Some(why) = &define.left_out {
        draft.row(key, define.value.as_str(), Fate::Ignored, why.as_str());
        return Ok(false);
    }
    if let Some(quantity) = list_of(name) {
        take_list(draft, header, define, quantity)?;
        return Ok(false);
    }
    if name == "COREXY" {
        draft.row(key, "", Fate::Used, "kinematics");
        return Ok(true);
    }
    if OTHER_KINEMATICS.contains(&name) {
        let hint = "known are cartesian and CoreXY; start from `machine show delta` for a delta";
        return Err(problem(define.line, &key, "is not known here", hint));
    }
    let Some(value) = resolved(draft, header, define, &define.value)? else {
        return Ok(false);
    };
    if let Some((axis, quantity)) = quantity_of(name) {
        let factor = if quantity == Quantity::PeakCurrent {
            UNITS.peak_a
        } else {
            1.0
        };
        let told = Told {
            value: value * factor,
            from: key,
            line: define.line,
        };
        draft.tell(axis, quantity, told, &define.value);
        return Ok(false);
    }
    let slot = if name == "BACKLASH_CORRECTION" {
        &mut spread.correction
    } else {
        &mut spread.smoothing_mm
    };
    *slot = Some(not_negative(define.line, &key, &format!("{value}"))?);
    draft.row(
        key,
        define.value.as_str(),
        Fate::Used,
        "how the gap is taken up",
    );
    Ok(false)
}
