//! Fanuc's parameters as punched out: `N01851Q1A1P4A2P0`, parameter, kind of data, then axis and value.
//! The 30i, 31i, 32i and later have `M250.0` and `I9.8425` for lengths in mm and inch, whatever the
//! machine counts in, `L` for the path, `S` for the spindle and `T` for the machine group; their `Q1` says
//! that the data are parameters (B-63950EN, p. 8; B-63330EN, p. 25).
//!
//! 1001#0 INM, 1006#0 ROT, 1013 or 1004 increment system, 1020 names of axes, 1320 and 1321 stroke
//! limits, 1420 rapid speed (mm/min, deg/min), 1620 its time constant (ms), 1660 largest
//! acceleration before interpolation (mm/s2), 1800#4 RBK, 1825 position gain (0.01/s, listed only),
//! 1820 command multiplier, 1828 and 1829 limits of the position deviation, 1851 and 1852 gaps, 8311 the
//! axis that one follows under axis synchronous control. Lengths
//! without a point are in the increment of the axis, gaps and deviations in detection units: the
//! increment by the command multiplier. Source: parameter manuals B-63090EN, B-64120EN, B-64490EN,
//! B-63950EN (1820).

use super::draft::{Draft, Fate, LEADING, Quantity, Told};
use super::{Format, ImportOptions, not_negative, number, problem};
use crate::control::Control;
use crate::machine::Problem;
use lostmotion_base::AxisId;
use std::collections::{BTreeMap, BTreeSet};

/// The format's row. Its files have the extensions of many.
pub(super) const FORMAT: Format = Format {
    name: "fanuc",
    extensions: &[],
    looks_like: |text| {
        let numbers = ["N01420", "N1420", "N01851", "N1851", "N01320", "N1320"];
        let mut lines = text.lines().map(str::trim_start);
        lines.any(|line| {
            let rest = numbers.iter().find_map(|it| line.strip_prefix(it));
            rest.is_some_and(|rest| {
                let rest = rest.trim_start();
                rest.starts_with(['Q', 'A']) && rest.contains(['P', 'M', 'I'])
            })
        })
    },
    is_lines: true,
    read,
};

/// Parameters of eight bits.
const BITS: [u32; 5] = [1001, 1004, 1006, 1013, 1800];

/// Axes of a path that a control has at most.
const MOST_AXES: usize = 32;

/// Unit of the servo loop's gain (1825), 1/s.
const GAIN_PER_S: f64 = 0.01;

/// Stroke limits from here on are none, in increments.
const NO_LIMIT: f64 = 99_999_999.0;

/// Parameters that are taken over.
const TAKEN: [u32; 17] = [
    1001, 1004, 1006, 1013, 1020, 1320, 1321, 1420, 1620, 1660, 1800, 1820, 1828, 1829, 1851, 1852,
    8311,
];

/// Parameters whose values are lengths and what is made of them, and may be told in inches. Gaps and
/// deviations are in detection units.
const LENGTHS: [u32; 4] = [1320, 1321, 1420, 1660];

/// An inch, mm.
const INCH_MM: f64 = 25.4;

/// Least increments of an inch in those of a mm: 0.0001 inch where the other is 0.001 mm (B-64490EN).
const INCH_INCREMENT: f64 = 0.1;

/// A value of one parameter of one axis; axis 0 of those that have none.
struct ParameterValue<'a> {
    line: usize,
    number: u32,
    axis: usize,
    value: &'a str,
    /// Whether its letter is I, for inch.
    is_inch: bool,
}

impl ParameterValue<'_> {
    fn name(&self) -> String {
        if self.axis == 0 {
            format!("N{}", self.number)
        } else {
            format!("N{} A{}", self.number, self.axis)
        }
    }

    /// What the value is in, mm; 1 of an axis that turns, whose degrees are the same in inches.
    fn mm(&self, axis: AxisId) -> f64 {
        if self.is_inch && !axis.is_rotary() {
            INCH_MM
        } else {
            1.0
        }
    }

    /// Bit of a value of eight binary digits, which has been checked.
    fn bit(&self, bit: usize) -> bool {
        self.value.as_bytes().iter().rev().nth(bit) == Some(&b'1')
    }

    /// Refuses what is no value of eight bits.
    fn check_bits(&self) -> Result<(), Problem> {
        let is_bits = self.value.len() == 8 && self.value.bytes().all(|b| matches!(b, b'0' | b'1'));
        if is_bits {
            return Ok(());
        }
        let message = format!("`{}` has no eight bits", self.value);
        Err(problem(self.line, &self.name(), message, "write 00010000"))
    }
}

/// Whether a listing that begins or ends with a percent sign has the other one, too.
fn check_ends(text: &str) -> Result<(), Problem> {
    let mut lines = text
        .lines()
        .map(str::trim)
        .enumerate()
        .filter(|(_, line)| !line.is_empty());
    let (first, last) = (lines.next(), lines.last());
    let is_end = |line: Option<(usize, &str)>| line.is_some_and(|(_, text)| text.starts_with('%'));
    match (is_end(first), is_end(last)) {
        (true, false) if last.is_some() => Err(problem(
            last.map_or(1, |(index, _)| index + 1),
            "",
            "the listing begins with % and does not end with one",
            "it was cut: punch it out again",
        )),
        (false, true) => Err(problem(
            1,
            "",
            "the listing ends with % and does not begin with one",
            "its beginning is missing: punch it out again",
        )),
        _ => Ok(()),
    }
}

/// The values of a line; where some are not taken, why.
fn line<'a>(
    number: usize,
    text: &'a str,
    entries: &mut Vec<ParameterValue<'a>>,
) -> Result<Option<&'static str>, Problem> {
    let told = text
        .split(['(', ';', '%'])
        .next()
        .unwrap_or_default()
        .trim();
    let Some(rest) = told.strip_prefix('N') else {
        return Ok((!told.is_empty()).then_some("no parameter"));
    };
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let (code, rest) = rest.split_at(digits);
    let bad = || {
        let hint = "parameters are written as N01851Q1A1P4A2P0";
        problem(number, told, "is no parameter", hint)
    };
    let code: u32 = code.parse().map_err(|_| bad())?;
    let before = entries.len();
    match values(number, code, rest, entries) {
        Some(why) => Ok(why),
        None if TAKEN.contains(&code) => Err(bad()),
        // Whatever it is: no axis needs it.
        None => {
            entries.truncate(before);
            Ok(Some("not read, and of no axis"))
        }
    }
}

/// The values behind a parameter's number, and why some of them are not taken; `None` if they are not
/// written as values are.
fn values<'a>(
    line: usize,
    number: u32,
    mut rest: &'a str,
    entries: &mut Vec<ParameterValue<'a>>,
) -> Option<Option<&'static str>> {
    let before = entries.len();
    // Whether an axis has been named whose value has not come yet.
    let (mut axis, mut waits) = (0, false);
    // Why the values that follow are not taken, and why any was not.
    let (mut left_out, mut why) = (None, None);
    while let Some(letter) = rest.chars().next() {
        let behind = &rest[letter.len_utf8()..];
        let end = behind
            .find(|c: char| c.is_ascii_alphabetic())
            .unwrap_or(behind.len());
        let (value, next) = behind.split_at(end);
        let value = value.trim();
        match letter {
            // Parameters, or the first path: both are written as 1. Further paths are other machines'
            // halves.
            'Q' => match value.parse::<u32>() {
                Ok(0) => return Some(Some("data of the pitch error compensation")),
                Ok(1) => {}
                Ok(_) => return Some(Some("of another path")),
                Err(_) => return None,
            },
            'L' => {
                let is_further = value.parse::<u32>().is_ok_and(|path| path > 1);
                left_out = is_further.then_some("of another path");
            }
            'T' => {
                let is_first = value.parse::<u32>().is_ok_and(|group| group == 1);
                left_out = (!is_first || !TAKEN.contains(&number)).then_some("of a machine group");
            }
            'A' if waits => return None,
            'A' => (axis, waits) = (value.parse().ok()?, true),
            'P' | 'M' | 'I' if axis > MOST_AXES => return None,
            'P' | 'M' | 'I' if left_out.is_some() => (waits, why) = (false, left_out),
            'I' if TAKEN.contains(&number) && !LENGTHS.contains(&number) => {
                (waits, why) = (false, Some("in inches, which it cannot be"));
            }
            'P' | 'M' | 'I' => {
                waits = false;
                entries.push(ParameterValue {
                    line,
                    number,
                    axis,
                    value,
                    is_inch: letter == 'I',
                });
            }
            // Of spindles.
            'S' | ' ' => {}
            _ => return None,
        }
        rest = next;
    }
    (!waits && (entries.len() > before || why.is_some())).then_some(why)
}

/// All parameters.
struct PunchedOut<'a>(Vec<ParameterValue<'a>>);

impl PunchedOut<'_> {
    fn of(&self, number: u32, axis: usize) -> Option<&ParameterValue<'_>> {
        let mut all = self.0.iter().rev();
        all.find(|entry| entry.number == number && entry.axis == axis)
    }

    /// The least increment of an axis, mm or deg.
    fn increment(&self, axis: usize) -> f64 {
        let flags = self.of(1013, axis).or_else(|| self.of(1004, 0));
        match flags {
            Some(flags) if flags.bit(0) => 0.01,
            Some(flags) if flags.bit(1) => 0.0001,
            _ => 0.001,
        }
    }

    /// Detection units in an increment: twice that is told, or, below a half, the inverse and 100.
    fn command_multiplier(&self, axis: usize) -> Option<f64> {
        match self.of(1820, axis)?.value.parse::<u32>().ok()? {
            twice @ 1..=96 => Some(0.5 * f64::from(twice)),
            inverse @ 101..=127 => Some(1.0 / f64::from(inverse - 100)),
            _ => None,
        }
    }

    fn axis(&self, number: usize) -> Option<(AxisId, bool)> {
        let named = self
            .of(1020, number)
            .and_then(|it| it.value.parse::<u8>().ok());
        match named {
            Some(code) => AxisId::from_letter(char::from(code)).map(|axis| (axis, true)),
            None => AxisId::from_index(number.checked_sub(1)?).map(|axis| (axis, false)),
        }
    }
}

/// Reads the parameters.
fn read(text: &str, _: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft::new("Fanuc");
    draft.dialect = Some("fanuc");
    draft.control = Some(Control::Fanuc);
    let (mut problems, mut entries) = (Vec::new(), Vec::new());
    problems.extend(check_ends(text).err());
    for (index, text) in text.lines().enumerate() {
        match line(index + 1, text, &mut entries) {
            Ok(None) => {}
            Ok(Some(why)) => {
                let key = format!("line {}", index + 1);
                draft.row(key, text.trim(), Fate::Ignored, why);
            }
            Err(found) => problems.push(found),
        }
    }
    for entry in entries.iter().filter(|it| BITS.contains(&it.number)) {
        problems.extend(entry.check_bits().err());
    }
    let all = PunchedOut(entries);
    if let Some(inch) = all.of(1001, 0).filter(|it| it.bit(0)) {
        let message = "the machine is in inches (INM), which is not read";
        problems.push(problem(inch.line, "N1001", message, ""));
    }
    let numbers: Vec<usize> = (1..=MOST_AXES)
        .filter(|axis| {
            [1020, 1420, 1320, 1851]
                .iter()
                .any(|key| all.of(*key, *axis).is_some())
        })
        .collect();
    // A parameter of axes has a value for each of them.
    let of_axes = all.0.iter().filter(|entry| entry.axis > 0);
    for key in of_axes.map(|entry| entry.number).collect::<BTreeSet<u32>>() {
        let lacks = numbers.iter().filter(|axis| all.of(key, **axis).is_none());
        let lacks: Vec<String> = lacks.map(|axis| format!("A{axis}")).collect();
        if !lacks.is_empty() {
            let why = "other axes have a value there: is the line whole?";
            draft.row(
                format!("N{key}"),
                format!("no {}", lacks.join(", ")),
                Fate::Guessed,
                why,
            );
        }
    }
    let followers = followers(&all, &numbers);
    let own = |number: &usize| followers.iter().all(|(own, _)| own != number);
    let numbers: Vec<usize> = numbers.into_iter().filter(own).collect();
    problems.extend(same_names(&all, &numbers));
    for number in numbers {
        problems.extend(numbered(&mut draft, &all, number).err());
    }
    for (own, leading) in &followers {
        problems.extend(follow(&mut draft, &all, *own, *leading).err());
    }
    if draft.axes.is_empty() && problems.is_empty() {
        let hint = "punch out the parameters: N01420A1P24000 and so on";
        problems.push(problem(1, "", "there is no parameter of an axis", hint));
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    for entry in all.0.iter().filter(|entry| !TAKEN.contains(&entry.number)) {
        let note = match entry.value.parse::<f64>() {
            Ok(gain) if entry.number == 1825 => super::untaken_gain(gain * GAIN_PER_S),
            _ => backlash_acceleration(entry.number, entry.value).to_owned(),
        };
        draft.row(entry.name(), entry.value, Fate::Ignored, note);
    }
    Ok(draft)
}

/// Axes that have one name: the second would take the place of the first.
fn same_names(all: &PunchedOut<'_>, numbers: &[usize]) -> Vec<Problem> {
    let mut first: BTreeMap<char, usize> = BTreeMap::new();
    let mut problems = Vec::new();
    for number in numbers {
        let Some((axis, _)) = all.axis(*number) else {
            continue;
        };
        let letter = axis.letter();
        let Some(before) = first.insert(letter, *number) else {
            continue;
        };
        let line = all.of(1020, *number).or_else(|| all.of(1020, before));
        let message = format!("A{before} and A{number} are both named {letter}");
        let hint = "give one of them another name, or tell in 8311 that it follows the other";
        problems.push(problem(
            line.map_or(1, |it| it.line),
            "N1020",
            message,
            hint,
        ));
    }
    problems
}

/// What the servo adds at reversals, which is not carried: its units have no primary source here. Bits
/// are written from #7 to #0.
fn backlash_acceleration(number: u32, value: &str) -> &'static str {
    match number {
        2003 if value.chars().rev().nth(5) == Some('1') => {
            "backlash acceleration (2003#5) is on, and not carried"
        }
        2009 | 2048 | 2071 => "of the backlash acceleration (2003#5), which is not carried",
        _ => "",
    }
}

/// Takes over what is told of the axis of a number, or says why it is left out.
fn numbered(draft: &mut Draft, all: &PunchedOut<'_>, number: usize) -> Result<(), Problem> {
    let Some((axis, named)) = all.axis(number) else {
        let why = "its name (1020) is no letter of an axis";
        draft.row(format!("A{number}"), "", Fate::Ignored, why);
        return Ok(());
    };
    let is_told = |key: &u32| all.of(*key, number).is_some();
    if ![1420, 1320, 1851].iter().any(is_told) {
        draft.expected.push((axis, "1020 names it"));
        return Ok(());
    }
    let turns = all.of(1006, number).is_some_and(|it| it.bit(0));
    if turns != axis.is_rotary() && named {
        let note = format!("{axis} does not {}", if turns { "turn" } else { "slide" });
        draft.row(format!("A{number}"), "", Fate::Ignored, note);
        return Ok(());
    }
    if !named {
        let why = "its name (1020) is not in the file: by its number";
        draft.row(
            format!("A{number}"),
            format!("axis {axis}"),
            Fate::Guessed,
            why,
        );
    }
    take(draft, all, number, axis)
}

/// The axes that follow another (8311 of the one that follows names the one that leads), and the number
/// of the axis that each follows, which follows none itself.
fn followers(all: &PunchedOut<'_>, numbers: &[usize]) -> Vec<(usize, usize)> {
    let leads = |own: usize| -> Option<usize> {
        let leading = all.of(8311, own)?.value.parse().ok()?;
        (leading != own && numbers.contains(&leading)).then_some(leading)
    };
    let all = numbers.iter().filter_map(|own| Some((*own, leads(*own)?)));
    all.filter(|(_, leading)| leads(*leading).is_none())
        .collect()
}

/// Takes over what is told of the second motor of an axis, which has a number of its own: its gap.
fn follow(
    draft: &mut Draft,
    all: &PunchedOut<'_>,
    own: usize,
    leading: usize,
) -> Result<(), Problem> {
    let axis = all.axis(leading).map(|(axis, _)| axis);
    let index = draft.axes.iter().position(|it| Some(it.id) == axis);
    let (Some(axis), Some(index)) = (axis, index) else {
        let why = format!("follows A{leading} (8311), which is left out");
        draft.row(format!("A{own}"), "", Fate::Ignored, why);
        return Ok(());
    };
    draft.axes[index].further_motor(&format!("A{own}"));
    let multiplier = all.command_multiplier(own).unwrap_or(1.0);
    let unit = all.increment(own) / multiplier;
    for entry in all.0.iter().filter(|entry| entry.axis == own) {
        let (fate, note) = match entry.number {
            1851 if entry.value.starts_with('-') => {
                number(entry.line, &entry.name(), entry.value)?;
                (Fate::Ignored, LEADING.to_owned())
            }
            1851 => {
                let gap = not_negative(entry.line, &entry.name(), entry.value)? * unit;
                let from = entry.name();
                let motor = draft.axes[index].further_motor(&format!("A{own}"));
                motor.gap = Some(Told {
                    value: gap,
                    from,
                    line: entry.line,
                });
                (Fate::Used, format!("gap of the second motor of {axis}"))
            }
            1820 => (
                Fate::Used,
                format!(
                    "detection unit of the second motor of {axis}: {unit} {}",
                    unit_of(axis)
                ),
            ),
            8311 => (Fate::Used, format!("second motor of {axis}")),
            1004 | 1006 | 1013 | 1020 | 1320 | 1321 | 1420 | 1620 | 1660 | 1828 | 1829 | 1852 => (
                Fate::Ignored,
                format!("of the second motor of {axis}, taken to be like the first"),
            ),
            _ => continue,
        };
        draft.row(entry.name(), entry.value, fate, note);
    }
    Ok(())
}

fn take(
    draft: &mut Draft,
    all: &PunchedOut<'_>,
    number_of: usize,
    axis: AxisId,
) -> Result<(), Problem> {
    let increment = all.increment(number_of);
    let told = |entry: &ParameterValue<'_>, value: f64| Told {
        value,
        from: entry.name(),
        line: entry.line,
    };
    for (key, quantity) in [(1321, Quantity::Min), (1320, Quantity::Max)] {
        let Some(entry) = all.of(key, number_of) else {
            continue;
        };
        let value = number(entry.line, &entry.name(), entry.value)?;
        // Newer controls write mm with a point, older ones increments.
        let value = match (entry.value.contains('.'), entry.is_inch) {
            (true, _) => value,
            (false, false) => value * increment,
            (false, true) => value * increment * INCH_INCREMENT,
        };
        let value = value * entry.mm(axis);
        if value.abs() >= NO_LIMIT * increment {
            draft.row(entry.name(), entry.value, Fate::Ignored, "no limit");
        } else {
            draft.tell(axis, quantity, told(entry, value), entry.value);
        }
    }
    let amount = |key: u32| match all.of(key, number_of) {
        None => Ok(None),
        Some(entry) => {
            let value = not_negative(entry.line, &entry.name(), entry.value)? * entry.mm(axis);
            Ok::<_, Problem>(Some((entry, value)).filter(|(_, value)| *value > 0.0))
        }
    };
    let rapid = amount(1420)?;
    if let Some((entry, value)) = rapid {
        draft.tell(
            axis,
            Quantity::Velocity,
            told(entry, value / 60.0),
            entry.value,
        );
    }
    match (amount(1660)?, rapid, amount(1620)?) {
        (Some((entry, value)), ..) => {
            draft.tell(
                axis,
                Quantity::Acceleration,
                told(entry, value),
                entry.value,
            );
        }
        // The rapid speed in this time.
        (None, Some((_, rapid)), Some((entry, ms))) => {
            let value = rapid / 60.0 / (ms * 1e-3);
            draft.tell(
                axis,
                Quantity::Acceleration,
                told(entry, value),
                entry.value,
            );
        }
        _ => {}
    }
    let multiplier = all.command_multiplier(number_of);
    let unit = increment / multiplier.unwrap_or(1.0);
    if let Some(entry) = all.of(1820, number_of) {
        let (fate, note) = match multiplier {
            Some(_) => (
                Fate::Used,
                format!("detection unit of {axis}: {unit} {}", unit_of(axis)),
            ),
            None => (Fate::Ignored, "no command multiplier".to_owned()),
        };
        draft.row(entry.name(), entry.value, fate, note);
    }
    if let Some((entry, value)) = amount(1828)? {
        draft.row(
            entry.name(),
            entry.value,
            Fate::Used,
            format!("following error of {axis}"),
        );
        draft.axis(axis, axis.is_rotary()).following_error = Some(told(entry, value * unit));
    }
    if let Some((entry, value)) = amount(1829)? {
        draft.row(
            entry.name(),
            entry.value,
            Fate::Used,
            format!("following error of {axis} at rest"),
        );
        draft.axis(axis, axis.is_rotary()).standstill_error = Some(told(entry, value * unit));
    }
    gap(draft, all, number_of, axis, unit)
}

fn unit_of(axis: AxisId) -> &'static str {
    if axis.is_rotary() { "deg" } else { "mm" }
}

/// 1851 of cutting feeds, and 1852 of rapids where RBK is set.
fn gap(
    draft: &mut Draft,
    all: &PunchedOut<'_>,
    number_of: usize,
    axis: AxisId,
    unit: f64,
) -> Result<(), Problem> {
    let Some(entry) = all.of(1851, number_of) else {
        return Ok(());
    };
    if entry.value.starts_with('-') {
        number(entry.line, &entry.name(), entry.value)?;
        draft.row(entry.name(), entry.value, Fate::Ignored, LEADING);
        return Ok(());
    }
    let amount = |entry: &ParameterValue<'_>| -> Result<f64, Problem> {
        Ok(not_negative(entry.line, &entry.name(), entry.value)? * unit)
    };
    let cutting = amount(entry)?;
    if all.command_multiplier(number_of).is_none() {
        draft.row(
            entry.name(),
            format!("{unit} {}", unit_of(axis)),
            Fate::Guessed,
            "the detection unit is taken to be the least increment (CMR 1)",
        );
    }
    let told = Told {
        value: cutting,
        from: entry.name(),
        line: entry.line,
    };
    draft.tell(axis, Quantity::Gap, told, entry.value);
    let apart = all.of(1800, 0).is_some_and(|it| it.bit(4));
    let rapid = match all.of(1852, number_of) {
        Some(entry) if entry.value.starts_with('-') => {
            number(entry.line, &entry.name(), entry.value)?;
            draft.row(entry.name(), entry.value, Fate::Ignored, LEADING);
            cutting
        }
        Some(entry) if apart => {
            draft.row(
                entry.name(),
                entry.value,
                Fate::Used,
                format!("gap of {axis} in rapids (RBK)"),
            );
            amount(entry)?
        }
        Some(entry) => {
            draft.row(
                entry.name(),
                entry.value,
                Fate::Ignored,
                "RBK (1800#4) is not set",
            );
            cutting
        }
        None => cutting,
    };
    // Both in thousandths: um, or mdeg.
    let keys = if axis.is_rotary() {
        ["cutting.mdeg", "rapid.mdeg"]
    } else {
        ["cutting.um", "rapid.um"]
    };
    let own = draft.axis(axis, axis.is_rotary());
    own.carry(
        "fixed-fanuc",
        vec![(keys[0], cutting * 1e3), (keys[1], rapid * 1e3)],
    );
    let row = own.carried_row();
    draft.rows.extend(row);
    Ok(())
}
