//! Files that LinuxCNC's INI names, and keys that say no limit: tool table, parameters (work
//! offsets and homes), a screw's compensation, the servo's period, the code at start.

use super::draft::{Draft, Fate, LEADING, Quantity, Told, ToolDraft};
use super::ini::Entry;
use super::kins::Numbered;
use super::{ImportOptions, not_negative, number, positive, problem};
use crate::machine::Problem;
use lostmotion_base::AxisId;
use lostmotion_gcode::Units;

/// Longest screw's table that LinuxCNC reads.
const MOST_TRIPLETS: usize = 256;

/// Most tools that are read.
const MOST_TOOLS: usize = 1000;

/// Lengths and diameters that machine files take, mm.
const LENGTHS_MM: std::ops::RangeInclusive<f64> = 0.0..=1e4;

/// Parameters of positions: table, and that of X; Y, Z, A, B, C, U, V, W follow.
const POSITIONS: [(&str, u32); 11] = [
    ("home.g28", 5161),
    ("home.g30", 5181),
    ("work_offset.g54", 5221),
    ("work_offset.g55", 5241),
    ("work_offset.g56", 5261),
    ("work_offset.g57", 5281),
    ("work_offset.g58", 5301),
    ("work_offset.g59", 5321),
    ("work_offset.g59_1", 5341),
    ("work_offset.g59_2", 5361),
    ("work_offset.g59_3", 5381),
];

/// Times a cycle of setpoints may take, ms.
const COMMAND_MS: std::ops::RangeInclusive<f64> = 0.25..=8.0;

/// A row of a screw's table this many times as far apart as the middle one is called unlikely.
const UNLIKELY: f64 = 3.0;

/// What is asked of a file: the entry that names it, and the machine's units in mm and deg.
struct NamedFile<'a> {
    entry: &'a Entry,
    mm: f64,
}

impl NamedFile<'_> {
    /// A problem in a line of the file.
    fn fault(&self, line: usize, message: &str) -> Problem {
        let message = format!("{message} (line {line} of {})", self.entry.value);
        problem(self.entry.line, &self.entry.name(), message, "")
    }
}

/// Takes an entry that is about none of the limits; false if it is something else.
pub(super) fn take(
    draft: &mut Draft,
    entry: &Entry,
    mm: f64,
    options: &ImportOptions<'_>,
) -> Result<bool, Problem> {
    let named = NamedFile { entry, mm };
    match (entry.section.as_str(), entry.key.as_str()) {
        ("EMCIO", "TOOL_TABLE") => tools(draft, &named, options)?,
        ("RS274NGC", "PARAMETER_FILE") => parameters(draft, &named, options)?,
        ("RS274NGC", "RS274NGC_STARTUP_CODE" | "STARTUP_CODE") => startup(draft, &named)?,
        ("EMCMOT", "SERVO_PERIOD") => {
            let ms = positive(entry.line, &entry.name(), entry.plain())? * 1e-6;
            if COMMAND_MS.contains(&ms) {
                draft.row(
                    entry.name(),
                    entry.value.as_str(),
                    Fate::Used,
                    "cycle of the setpoints, ns",
                );
                draft.command_ms = Some(Told {
                    value: ms,
                    from: entry.name(),
                    line: entry.line,
                });
            } else {
                let note = format!("{ms} ms; cycles of 0.25 to 8 ms are known here: 1 ms is taken");
                draft.row(entry.name(), entry.value.as_str(), Fate::Ignored, note);
            }
        }
        _ => return Ok(false),
    }
    Ok(true)
}

/// Whether a letter of a tool table is neither tool, pocket, length nor diameter.
fn is_across(letter: &str) -> bool {
    "XYABCUVWIJQ".contains(&letter.to_ascii_uppercase())
}

/// `T1 P1 Z+0.5 D0.25 ;comment`, or five columns: pocket, tool, length, diameter, comment.
fn tools(
    draft: &mut Draft,
    named: &NamedFile<'_>,
    options: &ImportOptions<'_>,
) -> Result<(), Problem> {
    let Some(text) = named.entry.text(draft, options) else {
        return Ok(());
    };
    let key = named.entry.name();
    for (index, line) in text.lines().enumerate() {
        let told = line.split(';').next().unwrap_or_default();
        let words: Vec<&str> = told.split_whitespace().collect();
        let value = |text: &str| match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(named.fault(index + 1, &format!("`{text}` is not a number"))),
        };
        let of = |letter: char| {
            let mut all = words.iter();
            all.find_map(|word| word.strip_prefix([letter, letter.to_ascii_lowercase()]))
        };
        // Offsets across the tool, and angles of a lathe's.
        let across = words.iter().filter(|word| {
            let own = word.get(..1).zip(word.get(1..));
            own.is_some_and(|(letter, amount)| {
                is_across(letter) && amount.parse::<f64>().is_ok_and(|amount| amount != 0.0)
            })
        });
        let across: Vec<&str> = across.copied().collect();
        let (tool, length, diameter) = match (of('T'), words.as_slice()) {
            (Some(tool), _) => (tool, of('Z').unwrap_or("0"), of('D').unwrap_or("0")),
            // A heading has no numbers.
            (None, [pocket, tool, length, diameter, ..]) if pocket.parse::<u32>().is_ok() => {
                (*tool, *length, *diameter)
            }
            _ => continue,
        };
        let Ok(number) = tool.parse::<u32>() else {
            return Err(named.fault(index + 1, &format!("`{tool}` is no tool")));
        };
        let row = format!("{key} T{number}");
        if of('T').is_some() && !across.is_empty() {
            let note = "not carried: a tool has a length and a diameter here";
            draft.row(row.as_str(), across.join(" "), Fate::Ignored, note);
        }
        let tool = ToolDraft {
            number,
            length_mm: value(length)? * named.mm,
            diameter_mm: value(diameter)?.abs() * named.mm,
        };
        if diameter.starts_with('-') && tool.diameter_mm > 0.0 {
            let note = "its sign, with which LinuxCNC compensates on the other side of the path; the size is taken";
            draft.row(row.as_str(), format!("D{diameter}"), Fate::Ignored, note);
        }
        if !LENGTHS_MM.contains(&tool.length_mm) || !LENGTHS_MM.contains(&tool.diameter_mm) {
            let note =
                "lengths below 0 or above 10 m are none here: measured against another tool?";
            draft.row(row, length, Fate::Ignored, note);
            continue;
        }
        // Of a tool that stands in two pockets the last counts, as on the machine.
        let before = draft.tools.len();
        draft.tools.retain(|other| other.number != number);
        if draft.tools.len() < before {
            let note = format!(
                "given again in line {} of {}, which counts",
                index + 1,
                named.entry.value
            );
            draft.row(row, "before", Fate::Ignored, note);
        }
        draft.tools.push(tool);
        if draft.tools.len() > MOST_TOOLS {
            return Err(named.fault(index + 1, &format!("more than {MOST_TOOLS} tools")));
        }
    }
    let note = format!("{} tools", draft.tools.len());
    draft.row(key, named.entry.value.as_str(), Fate::Used, note);
    Ok(())
}

/// Lines of a parameter's number and its value.
fn parameters(
    draft: &mut Draft,
    named: &NamedFile<'_>,
    options: &ImportOptions<'_>,
) -> Result<(), Problem> {
    let Some(text) = named.entry.text(draft, options) else {
        return Ok(());
    };
    let before = draft.offsets.len();
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let (Some(key), Some(value)) = (words.next(), words.next()) else {
            continue;
        };
        let Ok(key) = key.parse::<u32>() else {
            continue;
        };
        let place = POSITIONS.iter().find_map(|(table, first)| {
            let axis = AxisId::ALL.get(key.checked_sub(*first)? as usize)?;
            Some((*table, *axis))
        });
        let Some((table, axis)) = place else { continue };
        let value = match value.parse::<f64>() {
            Ok(value) if value.is_finite() => value,
            _ => return Err(named.fault(index + 1, &format!("`{value}` is not a number"))),
        };
        if value != 0.0 {
            let value = if axis.is_rotary() {
                value
            } else {
                value * named.mm
            };
            draft.offsets.push((
                table,
                axis,
                Told {
                    value,
                    from: format!("#{key} in {}", named.entry.value),
                    line: named.entry.line,
                },
            ));
        }
    }
    let note = format!("{} places of axes", draft.offsets.len() - before);
    draft.row(
        named.entry.name(),
        named.entry.value.as_str(),
        Fate::Used,
        note,
    );
    Ok(())
}

/// The words of a block, letter and number.
fn words(entry: &Entry) -> Result<Vec<(char, String)>, Problem> {
    let mut words: Vec<(char, String)> = Vec::new();
    // Comments in brackets say nothing here.
    let code = entry.value.split(';').next().unwrap_or_default();
    let mut is_open = false;
    for c in code.chars().filter(|c| !c.is_whitespace()) {
        let is_comment = is_open || c == '(';
        is_open = is_comment && c != ')';
        match words.last_mut() {
            _ if is_comment => {}
            _ if c.is_ascii_alphabetic() => words.push((c.to_ascii_uppercase(), String::new())),
            Some((_, text)) => text.push(c),
            None => words.push((c, String::new())),
        }
    }
    // G-code writes no exponents, and nothing at the start extrudes.
    let is_decimal = |text: &str| {
        let mut chars = text.chars();
        chars.all(|c| c.is_ascii_digit() || "+-.".contains(c)) && text.parse::<f64>().is_ok()
    };
    match words
        .iter()
        .find(|(letter, text)| !letter.is_ascii_alphabetic() || *letter == 'E' || !is_decimal(text))
    {
        Some((letter, text)) => Err(problem(
            entry.line,
            &entry.name(),
            format!("`{letter}{text}` is no word"),
            "write codes such as G21 G40 G64 P0.02",
        )),
        None => Ok(words),
    }
}

/// G codes at start that change nothing: LinuxCNC and the interpreter here begin with them.
const USUAL_CODES: [f64; 13] = [
    8.0, 17.0, 40.0, 49.0, 50.0, 54.0, 80.0, 90.0, 91.1, 92.1, 94.0, 97.0, 98.0,
];

/// Of the code at start, one block, what machine files have: the units and the tolerance of G64. The
/// rest is named.
fn startup(draft: &mut Draft, named: &NamedFile<'_>) -> Result<(), Problem> {
    let entry = named.entry;
    let words = words(entry)?;
    if let Some((letter, text)) = words
        .iter()
        .find(|(letter, _)| AxisId::from_letter(*letter).is_some())
    {
        let note = format!("`{letter}{text}` moves an axis, which is not read: is it meant?");
        draft.row(entry.name(), entry.value.as_str(), Fate::Ignored, note);
    }
    let is = |word: &(char, String), letter: char, code: f64| {
        word.0 == letter && word.1.parse() == Ok(code)
    };
    let has = |code: f64| words.iter().any(|word| is(word, 'G', code));
    let units = match (has(20.0), has(21.0)) {
        (true, true) => {
            let hint = "LinuxCNC takes one code of a group in a block: keep the one that is meant";
            let message = "has both G20 and G21";
            return Err(problem(entry.line, &entry.name(), message, hint));
        }
        (true, false) => Some(Units::Inch),
        (false, true) => Some(Units::Mm),
        (false, false) => None,
    };
    let mut taken = Vec::new();
    if let Some(units) = units {
        draft.program_units = Some((units, entry.name()));
        taken.push("units in which programs start");
    }
    let blends = has(64.0);
    // Wherever they stand in a block, the units come before the path control.
    let mm = units.map_or(named.mm, Units::mm);
    let told = words.iter().find(|(letter, _)| blends && *letter == 'P');
    let tolerance = match told {
        Some((_, text)) => not_negative(entry.line, &entry.name(), text)? * mm,
        None => 0.0,
    };
    if tolerance > 0.0 {
        taken.push("tolerance of G64");
        draft.path_tolerance_mm = Some(Told {
            value: tolerance,
            from: entry.name(),
            line: entry.line,
        });
    } else if blends {
        let note = "G64 without P blends without a bound: a tolerance is kept here";
        draft.row(entry.name(), entry.value.as_str(), Fate::Ignored, note);
    }
    let is_taken = |word: &(char, String)| {
        [20.0, 21.0, 64.0].iter().any(|code| is(word, 'G', *code)) || (blends && word.0 == 'P')
    };
    let is_usual = |word: &(char, String)| {
        let mut usual = USUAL_CODES.iter();
        usual.any(|code| is(word, 'G', *code)) || is(word, 'M', 5.0) || is(word, 'M', 9.0)
    };
    let left: Vec<String> = words
        .iter()
        .filter(|word| !is_taken(word) && !is_usual(word))
        .map(|(letter, text)| format!("{letter}{text}"))
        .collect();
    if !taken.is_empty() {
        let note = taken.join(", ");
        draft.row(entry.name(), entry.value.as_str(), Fate::Used, note);
    } else if left.is_empty() && !blends {
        let note = "programs start so anyway";
        draft.row(entry.name(), entry.value.as_str(), Fate::Used, note);
    }
    if !left.is_empty() {
        let note = "not carried: write it into the program";
        draft.row(entry.name(), left.join(" "), Fate::Ignored, note);
    }
    Ok(())
}

/// Whether a screw's table holds trims (1), or places (0, LinuxCNC's default).
fn holds_trims(kind: Option<&Entry>) -> Result<bool, Problem> {
    let Some(kind) = kind else { return Ok(false) };
    let value = number(kind.line, &kind.name(), kind.plain())?;
    if value != 0.0 && value != 1.0 {
        let message = format!("is {}; 0 and 1 are known", kind.value);
        return Err(problem(kind.line, &kind.name(), message, ""));
    }
    Ok(value == 1.0)
}

/// The gaps of a screw's table, mm or deg, with their signs. LinuxCNC reads up to the first line that does not
/// begin with three numbers, at which the rest is told to be left out.
fn screw_gaps(
    draft: &mut Draft,
    named: &NamedFile<'_>,
    has_trims: bool,
    text: &str,
) -> Result<Vec<f64>, Problem> {
    let mut gaps = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for (index, line) in text.lines().enumerate() {
        let words: Vec<Option<f64>> = line
            .split_whitespace()
            .map(|word| word.parse().ok().filter(|value: &f64| value.is_finite()))
            .collect();
        let [Some(nominal), Some(forward), Some(backward), ..] = words.as_slice() else {
            let rest = text.lines().skip(index);
            let left = rest.filter(|line| !line.trim().is_empty()).count();
            if left > 0 && index > 0 {
                let note = format!(
                    "line {} of {}: not three numbers; LinuxCNC reads no further, which leaves {left} lines out: mend it",
                    index + 1,
                    named.entry.value
                );
                draft.row(named.entry.name(), line.trim(), Fate::Ignored, note);
            }
            break;
        };
        if *nominal <= last {
            return Err(named.fault(index + 1, "positions have to rise"));
        }
        last = *nominal;
        // LinuxCNC makes trims of places (nominal less place) and takes a BACKLASH as trims of half of it forward
        // and minus half backward (control.c, compute_screw_comp).
        let gap = if has_trims {
            forward - backward
        } else {
            backward - forward
        };
        gaps.push(gap * named.mm);
        if gaps.len() > MOST_TRIPLETS {
            let message = format!("more than {MOST_TRIPLETS} rows: LinuxCNC reads no more");
            return Err(named.fault(index + 1, &message));
        }
    }
    gaps.sort_by(f64::total_cmp);
    Ok(gaps)
}

/// The gap that a screw's table holds, of the file's text: the middle one of its rows.
pub(super) fn screw(
    draft: &mut Draft,
    entry: &Entry,
    kind: Option<&Entry>,
    (axis, _): Numbered,
    mm: f64,
    text: &str,
) -> Result<(), Problem> {
    let named = NamedFile { entry, mm };
    let gaps = screw_gaps(draft, &named, holds_trims(kind)?, text)?;
    let (Some(least), Some(most)) = (gaps.first(), gaps.last()) else {
        return Err(named.fault(1, "the first line is no triplet"));
    };
    let middle = gaps[gaps.len() / 2];
    let widest = most.max(-least);
    let unlikely = if widest > UNLIKELY * middle.abs().max(1e-6) {
        "; the largest is unlikely: is it a typing error?"
    } else {
        ""
    };
    let shown = format!(
        "{} rows: {:.4} to {:.4}, middle {middle:.4} mm{unlikely}",
        gaps.len(),
        least,
        most
    );
    if middle < 0.0 {
        let note =
            format!("axis {axis}: {LEADING}; are the columns, or COMP_FILE_TYPE, exchanged?");
        draft.row(entry.name(), shown, Fate::Ignored, note);
        return Ok(());
    }
    let told = Told {
        value: middle,
        from: entry.name(),
        line: entry.line,
    };
    // A second joint of an axis has its own.
    let mut further = draft.axis(axis, axis.is_rotary()).further.iter_mut();
    if let Some(motor) = further.find(|motor| motor.from == entry.section) {
        motor.gap = Some(told);
        let note = format!("gap of a further motor of {axis}");
        draft.row(entry.name(), shown, Fate::Used, note);
        return Ok(());
    }
    // Of a joint and its axis the wider gap counts.
    if let Some(other) = &draft.axis(axis, axis.is_rotary()).gap
        && other.value > middle
    {
        let note = format!("axis {axis}: {} counts", other.from);
        draft.row(entry.name(), shown, Fate::Ignored, note);
        return Ok(());
    }
    draft.tell(axis, Quantity::Gap, told, &shown);
    Ok(())
}
