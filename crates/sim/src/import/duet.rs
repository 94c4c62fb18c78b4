//! RepRapFirmware's config.g, of Duet boards.
//!
//! M92 steps/mm, M203 mm/min, M201 mm/s2, M208 travel (`X0:200`, or S1 for the lower ends and S0
//! for the upper ones), M350 microsteps, M906 peak current in mA, M425 gap with its multiple S,
//! M584 drivers, M669 kinematics (K0 cartesian, K1 CoreXY), M550 name; files that M98 calls. See
//! <https://docs.duet3d.com/User_manual/Reference/Gcodes>.

use super::draft::{Draft, Fate, MachineSize, Quantity, Told};
use super::mcodes::{self, Firmware, MCode};
use super::{Format, ImportOptions, number, positive, problem};
use crate::control::Control;
use crate::machine::Problem;
use lostmotion_base::AxisId;

/// The format's row. Its files are also named .g of other programs.
pub(super) const FORMAT: Format = Format {
    name: "duet",
    extensions: &[],
    looks_like: |text| {
        let begins = |code: &str| {
            text.lines().any(|line| {
                let rest = line.trim_start().strip_prefix(code);
                rest.is_some_and(|rest| rest.starts_with([' ', '\t']))
            })
        };
        // Codes that no other firmware has together.
        begins("M584") || (begins("M208") && begins("M92"))
    },
    is_lines: true,
    read,
};

/// Deepest nesting of called files.
const DEEPEST: usize = 4;

const UNITS: Firmware = Firmware {
    speed: 1.0 / 60.0,
    peak_a: 1e-3,
};

/// Steps over which M425 spreads a gap where it does not say it.
const USUAL_MULTIPLE: f64 = 10.0;

/// What codes say of the machine as a whole.
struct Whole {
    is_corexy: bool,
    multiple: f64,
    bytes: usize,
    /// Drivers of axes behind their first.
    further: Vec<(AxisId, String)>,
}

/// Reads the file.
fn read(text: &str, options: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft::new("RepRapFirmware");
    draft.dialect = Some("marlin");
    draft.control = Some(Control::RepRapFirmware);
    draft.size = MachineSize::Printer;
    draft
        .expected
        .extend(super::XYZ.map(|axis| (axis, "machines of this control have it")));
    let mut problems = Vec::new();
    let mut whole = Whole {
        is_corexy: false,
        multiple: USUAL_MULTIPLE,
        bytes: 0,
        further: Vec::new(),
    };
    file(
        text,
        None,
        0,
        options,
        &mut draft,
        &mut whole,
        &mut problems,
    );
    if problems.is_empty() {
        problems.extend(mcodes::no_axes(&draft, "is it the board's config.g?"));
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    draft.add_motors(&whole.further);
    let multiple = whole.multiple;
    draft.carry("fixed-by-travel", |_| vec![("multiple", multiple)]);
    if whole.is_corexy {
        draft.belts();
    }
    Ok(draft)
}

fn file(
    text: &str,
    at: Option<usize>,
    depth: usize,
    options: &ImportOptions<'_>,
    draft: &mut Draft,
    whole: &mut Whole,
    problems: &mut Vec<Problem>,
) {
    for (index, line) in text.lines().enumerate() {
        let place = at.unwrap_or(index + 1);
        let code = match mcodes::code(place, line) {
            Ok(Some(code)) => code,
            Ok(None) => {
                if let Some(text) = mcodes::other(line) {
                    let note = "no code: what it does to the settings is not known here";
                    draft.row(format!("line {place}"), text, Fate::Ignored, note);
                }
                continue;
            }
            Err(found) => {
                problems.push(found);
                continue;
            }
        };
        if code.code == "M98"
            && let Some(name) = code.word('P')
        {
            let found = if depth == DEEPEST {
                Err(format!("more than {DEEPEST} deep"))
            } else {
                options.files.text(name.rsplit('/').next().unwrap_or(name))
            };
            match found {
                Ok(text) if whole.bytes.saturating_add(text.len()) <= options.max_bytes => {
                    whole.bytes += text.len();
                    draft.row("M98", name, Fate::Used, "read in its place");
                    file(
                        &text,
                        Some(code.line),
                        depth + 1,
                        options,
                        draft,
                        whole,
                        problems,
                    );
                }
                Ok(_) => problems.push(problem(
                    code.line,
                    "M98",
                    format!("called files have more than {} bytes", options.max_bytes),
                    "",
                )),
                Err(why) => draft.row("M98", name, Fate::Ignored, format!("not read ({why})")),
            }
        } else if let Err(found) = take(draft, &code, whole) {
            problems.push(found);
        }
    }
}

fn take(draft: &mut Draft, code: &MCode, whole: &mut Whole) -> Result<(), Problem> {
    // Expressions have values that only the firmware knows.
    let expression = code.words.iter().find(|(_, text)| text.contains('{'));
    if let Some((letter, text)) =
        expression.filter(|_| mcodes::NUMERIC.contains(&code.code.as_str()))
    {
        return Err(problem(
            code.line,
            &code.name(*letter),
            format!("`{text}` is an expression, and only numbers are read"),
            "write its value",
        ));
    }
    code.check()?;
    match code.code.as_str() {
        "M550" => {
            if let Some(name) = code.word('P') {
                name.clone_into(&mut draft.name);
                draft.row("M550 P", name, Fate::Used, "general");
            }
        }
        "M208" => travel(draft, code)?,
        "M669" => match code.word('K').map(str::trim) {
            None => code.ignore(draft, ""),
            Some(kind @ ("0" | "1")) => {
                whole.is_corexy = kind == "1";
                draft.row("M669 K", kind, Fate::Used, "kinematics");
            }
            Some(kind) => {
                return Err(problem(
                    code.line,
                    "M669 K",
                    format!("kinematics {kind} are not known here"),
                    "known are 0 (cartesian) and 1 (CoreXY)",
                ));
            }
        },
        "M665" => {
            return Err(problem(
                code.line,
                "M665",
                "a delta is not read",
                "start from `machine show delta`",
            ));
        }
        "M584" => drivers(draft, code, whole),
        "M566" => code.ignore(
            draft,
            "how suddenly corners are taken: no tolerance of the path",
        ),
        "M425" => {
            if let Some(text) = code.word('S') {
                whole.multiple = positive(code.line, "M425 S", text)?.max(1.0);
                draft.row(
                    "M425 S",
                    text,
                    Fate::Used,
                    "over how many gaps one is spread",
                );
            } else {
                draft.row(
                    "M425 S",
                    "",
                    Fate::Guessed,
                    format!("over how many gaps one is spread is not told: {USUAL_MULTIPLE}, as the firmware has it"),
                );
            }
            mcodes::limits(draft, code, &UNITS)?;
        }
        _ => {
            if !mcodes::limits(draft, code, &UNITS)? {
                code.ignore(draft, "");
            }
        }
    }
    Ok(())
}

/// `M208 X0:200`, or `M208 S1 X0` and `M208 S0 X200`.
fn travel(draft: &mut Draft, code: &MCode) -> Result<(), Problem> {
    let one = match code.word('S').map(str::trim) {
        Some("1") => Quantity::Min,
        None | Some("0") => Quantity::Max,
        Some(other) => {
            let message = format!("is `{other}`");
            let hint = "1 sets lower ends, 0 upper ones";
            return Err(problem(code.line, "M208 S", message, hint));
        }
    };
    for (letter, text) in &code.words {
        let Some(axis) = AxisId::from_letter(*letter) else {
            continue;
        };
        let name = code.name(*letter);
        let told = |text: &str| {
            Ok::<_, Problem>(Told {
                value: number(code.line, &name, text)?,
                from: name.clone(),
                line: code.line,
            })
        };
        match text.split_once(':') {
            Some((min, max)) => {
                draft.tell(axis, Quantity::Min, told(min)?, min);
                draft.tell(axis, Quantity::Max, told(max)?, max);
            }
            None => draft.tell(axis, one, told(text)?, text),
        }
    }
    Ok(())
}

/// `M584 X0 Y1:4`: several drivers of an axis are as many motors.
fn drivers(draft: &mut Draft, code: &MCode, whole: &mut Whole) {
    for (letter, text) in &code.words {
        let name = code.name(*letter);
        let Some(axis) = AxisId::from_letter(*letter) else {
            draft.row(name, text.as_str(), Fate::Ignored, "no motor of an axis");
            continue;
        };
        whole.further.retain(|(own, _)| *own != axis);
        let further = text.split(':').skip(1);
        let further = further.map(|driver| (axis, format!("{name} driver {}", driver.trim())));
        whole.further.extend(further);
        draft.row(name, text.as_str(), Fate::Used, format!("motors of {axis}"));
    }
}
