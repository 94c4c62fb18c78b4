//! RepRapFirmware's config.g, of Duet boards.
//!
//! M92 steps/mm, M203 mm/min, M201 mm/s2, M208 travel (`X0:200`, or S1 for the lower ends and S0
//! for the upper ones), M350 microsteps, M906 peak current in mA, M425 gap with its multiple S,
//! M584 drivers, M669 kinematics (K0 cartesian, K1 CoreXY), M550 name; files that M98 calls. Lines below
//! `if`, `elif`, `else` and `while` are taken only where the condition is true as it is written. See
//! <https://docs.duet3d.com/User_manual/Reference/Gcodes> and, on conditions,
//! <https://docs.duet3d.com/User_manual/Reference/Gcode_meta_commands>.

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
    /// Whether files call each other too deep: nothing further is read.
    too_deep: bool,
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
        too_deep: false,
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
    let mut conditions = Conditions::default();
    for (index, line) in text.lines().enumerate() {
        if whole.too_deep {
            return;
        }
        let place = at.unwrap_or(index + 1);
        if let Some(why) = conditions.line(place, line) {
            if let Some(text) = mcodes::other(line) {
                draft.row(format!("line {place}"), text, Fate::Ignored, why);
            }
            continue;
        }
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
            if depth == DEEPEST {
                let message = format!("files call each other more than {DEEPEST} deep");
                let hint = "does a file call itself?";
                problems.push(problem(code.line, "M98", message, hint));
                whole.too_deep = true;
                return;
            }
            match options.files.text(super::file_name(name)) {
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

/// A branch of a condition: the lines that are indented further than its word.
struct IfBranch {
    /// Column of the word.
    indent: usize,
    /// Its line.
    line: usize,
    /// Whether the lines run; `None` where only the firmware knows.
    runs: Option<bool>,
    /// Whether this branch or one before it ran, for an `else` behind them.
    ran: Option<bool>,
}

/// Columns to which a tab moves on: a multiple of these (RepRapFirmware, StringParser::Put).
const TAB: usize = 4;

/// The branches around a line.
#[derive(Default)]
struct Conditions(Vec<IfBranch>);

impl Conditions {
    /// Goes on to a line; why it is not taken, if it is not.
    fn line(&mut self, place: usize, line: &str) -> Option<String> {
        let told = line.split(';').next().unwrap_or_default();
        // Empty lines and comments end no block.
        if told.trim().is_empty() {
            return None;
        }
        let blanks = told.chars().take_while(|c| matches!(c, ' ' | '\t'));
        let indent = blanks.fold(0, |at, c| {
            if c == '\t' {
                (at / TAB + 1) * TAB
            } else {
                at + 1
            }
        });
        self.0.retain(|branch| branch.indent <= indent);
        // A line as far out as the word of a branch ends it, or is its next branch.
        let before = self.0.pop_if(|branch| branch.indent == indent);
        let around = self.0.iter().rfind(|branch| branch.runs != Some(true));
        let why = around.map(|branch| match branch.runs {
            None => format!("depends on the condition in line {}", branch.line),
            _ => format!("the condition in line {} is false", branch.line),
        });
        let told = told.trim();
        let end = told
            .find(|c: char| !c.is_ascii_lowercase())
            .unwrap_or(told.len());
        let (word, condition) = told.split_at(end);
        let ran = before.map_or(Some(true), |branch| branch.ran);
        let (runs, ran) = match word {
            "if" => (literal(condition), literal(condition)),
            // How often is not known either.
            "while" => (literal(condition).filter(|runs| !runs), Some(true)),
            "elif" => {
                let own = literal(condition);
                (
                    both(negated(ran), own),
                    negated(both(negated(ran), negated(own))),
                )
            }
            "else" => (negated(ran), Some(true)),
            _ => return why,
        };
        self.0.push(IfBranch {
            indent,
            line: place,
            runs,
            ran,
        });
        why
    }
}

/// A condition that is told as it is written; `None` for all that the firmware works out.
fn literal(condition: &str) -> Option<bool> {
    match condition.trim_matches(|c: char| c.is_whitespace() || "{}()".contains(c)) {
        "true" => Some(true),
        "false" => Some(false),
        _ => None,
    }
}

fn negated(value: Option<bool>) -> Option<bool> {
    value.map(|value| !value)
}

/// Whether both hold; false if one is, whatever the other.
fn both(a: Option<bool>, b: Option<bool>) -> Option<bool> {
    match (a, b) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), b) => b,
        (None, _) => None,
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
