//! Siemens Sinumerik 840D, 828D, 808D: machine data of an archive as text, lines
//! `N32450 $MA_BACKLASH[0,AX1]=0.012`.
//!
//! MD10000 AXCONF_MACHAX_NAME_TAB, MD10240 SCALING_SYSTEM_IS_METRIC, MD30300 IS_ROT_AX, MD32000
//! MAX_AX_VELO (mm/min, rev/min), MD32300 MAX_AX_ACCEL (m/s2, rev/s2), MD32431 MAX_AX_JERK (m/s3,
//! rev/s3), MD32450 BACKLASH (mm, deg) times MD32452 BACKLASH_FACTOR, MD36100 and MD36110 POS_LIMIT_MINUS and PLUS,
//! MD37100 GANTRY_AXIS_TYPE (1 leads, 11 follows). Axes are AX1
//! and so on, or the names of MD10000; of data with an index the first counts (DYNNORM, the first
//! measuring system). Source: SINUMERIK 808D ADVANCED, parameter manual 08/2013 p. 228 (32450, 32452);
//! 840D sl, function manuals G2 (30300, 31030), K3 (32450), A3 (36100) and G1 (37100); SINUMERIK ONE, list manual
//! 01/2023 p. 209 (first entries of 32300 and 32431). Units of 32000, 32300 and 32431 are taken from
//! the list manual of the 840D sl, and listed as guesses.

use super::draft::{Draft, Fate, LEADING, Quantity, Told, float};
use super::{Format, ImportOptions, lettered, not_negative, number, positive, problem};
use crate::control::Control;
use crate::machine::Problem;
use lostmotion_base::AxisId;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// The format's row. Its files have the extensions of many.
pub(super) const FORMAT: Format = Format {
    name: "sinumerik",
    extensions: &[],
    looks_like: |text| text.contains("$MA_") || text.contains("$MN_"),
    is_lines: true,
    read,
};

/// Ends of travel from here on are the control's default, that is none, mm or deg.
const NO_LIMIT: f64 = 1e7;

/// How lines begin that hold a file within an archive together.
const FRAME: [&str; 3] = ["%_N_", "M17", "CHANDATA("];

/// Machine axes that an archive may name.
const MOST_AXES: usize = 64;

const DEGREES: f64 = 360.0;

/// MD37100 of an axis that follows is that of the one that leads plus this.
const GANTRY_FOLLOWS: u32 = 10;

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

/// Data without which the machine would be another one: a gap is never made up, nor speeds, nor what units and
/// kinds of axes are.
const NEEDED: [&str; 5] = [
    "MA_MAX_AX_VELO",
    "MA_BACKLASH",
    "MA_BACKLASH_FACTOR",
    "MA_IS_ROT_AX",
    "MN_SCALING_SYSTEM_IS_METRIC",
];

/// What is wrong with the archive.
#[derive(Default)]
struct Wrong {
    /// For these it is refused.
    problems: Vec<Problem>,
    /// Lines that are left out for a value that is none.
    left_out: BTreeSet<usize>,
}

impl Wrong {
    /// Takes down what is wrong with a datum; the report says it where it is not needed. A datum that is
    /// looked at twice is told once.
    fn note(&mut self, draft: &mut Draft, (name, value): (&str, &str), found: Problem) {
        if NEEDED.contains(&name) {
            self.problems.push(found);
        } else if self.left_out.insert(found.line as usize) {
            let note = format!("line {}: {}: left out", found.line, found.message);
            draft.row(found.key, value, Fate::Ignored, note);
        }
    }
}

/// On or off.
fn switch(datum: &Datum<'_>) -> Result<bool, Problem> {
    match datum.value.to_ascii_uppercase().as_str() {
        "1" | "TRUE" => Ok(true),
        "0" | "FALSE" => Ok(false),
        other => {
            let message = format!("`{other}` is neither 1 nor 0");
            Err(problem(datum.line, &datum.key(), message, ""))
        }
    }
}

/// The datum of a line; `None` if it has none.
///
/// # Errors
/// A datum that is not whole.
fn datum(line: usize, text: &str) -> Result<Option<Datum<'_>>, Problem> {
    let told = text.split(';').next().unwrap_or_default().trim();
    let Some(at) = told.find("$M") else {
        return Ok(None);
    };
    let rest = &told[at + 1..];
    let bad = || {
        let hint = "data are written as $MA_BACKLASH[0,AX1]=0.012";
        problem(line, told, "is no datum with a value", hint)
    };
    let (left, value) = rest.split_once('=').ok_or_else(bad)?;
    let (name, index) = match left.split_once('[') {
        Some((name, rest)) => (name, rest.split_once(']').ok_or_else(bad)?.0),
        None => (left, ""),
    };
    // The archive's check sum stands behind it.
    let value = value.split('\'').next().unwrap_or_default();
    let value = value.trim().trim_matches('"');
    if name.trim().is_empty() || value.is_empty() {
        return Err(bad());
    }
    Ok(Some(Datum {
        line,
        name: name.trim(),
        index: index
            .split(',')
            .map(str::trim)
            .filter(|part| !part.is_empty())
            .collect(),
        value,
    }))
}

/// The text with hexadecimal and binary values (`'H1F'`, `'B101'`) as decimal ones; places of lines stay.
fn decimal(text: &str) -> Cow<'_, str> {
    let lower = text.to_ascii_lowercase();
    if !lower.contains("'h") && !lower.contains("'b") {
        return text.into();
    }
    let lines = text.split('\n').map(|line| {
        let told = || {
            let (left, value) = line.split_once('=')?;
            let (digits, behind) = value.trim_start().strip_prefix('\'')?.split_once('\'')?;
            let radix = match digits.get(..1)? {
                "H" | "h" => 16,
                "B" | "b" => 2,
                _ => return None,
            };
            let value = u64::from_str_radix(digits.get(1..)?, radix).ok()?;
            Some(format!("{left}={value}{behind}"))
        };
        told().map_or(Cow::Borrowed(line), Cow::Owned)
    });
    lines.collect::<Vec<_>>().join("\n").into()
}

/// An axis' name in the archive, and which it is.
struct AxisName {
    name: String,
    number: usize,
    axis: Option<AxisId>,
}

/// Reads the archive.
fn read(text: &str, _: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let text = &*decimal(text);
    let mut reading = Reading::new();
    let data = reading.data(text);
    reading.check_end(text);
    let archive = reading.archive(data);
    for datum in &archive.data {
        reading.take_over(&archive, datum);
    }
    reading.list_guesses();
    reading.finish(&archive)
}

/// The data of an archive, and what they say of its axes as a whole. Axes are those that an index names.
struct Archive<'a> {
    data: Vec<Datum<'a>>,
    names: Vec<AxisName>,
    /// Axes that are spindles, and so none here.
    spindles: BTreeSet<&'a str>,
    /// Axes that turn.
    turning: BTreeSet<&'a str>,
    /// Axes that follow another in a gantry, and which.
    gantries: BTreeMap<&'a str, AxisId>,
}

/// What is read so far of an archive.
struct Reading {
    draft: Draft,
    wrong: Wrong,
    /// Axes that are told by their number, as the archive names them.
    guessed: Vec<(String, AxisId)>,
    /// Data whose unit is a guess, and the unit.
    units: BTreeSet<(&'static str, &'static str)>,
}

impl Reading {
    fn new() -> Reading {
        let mut draft = Draft::new("Sinumerik");
        draft.dialect = Some("siemens");
        draft.control = Some(Control::Siemens);
        Reading {
            draft,
            wrong: Wrong::default(),
            guessed: Vec::new(),
            units: BTreeSet::new(),
        }
    }

    /// The data of the lines; lines with anything else are reported.
    fn data<'a>(&mut self, text: &'a str) -> Vec<Datum<'a>> {
        let mut data = Vec::new();
        for (index, line) in text.lines().enumerate() {
            match datum(index + 1, line) {
                Ok(Some(found)) => data.push(found),
                Ok(None) => {
                    let told = line.split(';').next().unwrap_or_default().trim();
                    let is_frame = FRAME.iter().any(|it| told.starts_with(it));
                    if !told.is_empty() && !is_frame {
                        self.draft.row(
                            format!("line {}", index + 1),
                            told,
                            Fate::Ignored,
                            "no machine data",
                        );
                    }
                }
                Err(found) => {
                    let own = line.split(['$', '[', '=']).nth(1).unwrap_or_default();
                    self.wrong
                        .note(&mut self.draft, (own.trim(), line.trim()), found);
                }
            }
        }
        data
    }

    /// Reports an archive that was cut off: every file within it ends with M17.
    fn check_end(&mut self, text: &str) {
        let frames = text.lines().map(str::trim).enumerate();
        if let Some((begin, name)) = frames.filter(|(_, line)| line.starts_with("%_N_")).last()
            && !text.lines().skip(begin).any(|line| line.trim() == "M17")
        {
            let why = "it does not end with M17: is the archive whole?";
            self.draft
                .row(format!("line {}", begin + 1), name, Fate::Guessed, why);
        }
    }

    /// What the data say of the axes as a whole, which has to be known before any of them is taken over.
    fn archive<'a>(&mut self, data: Vec<Datum<'a>>) -> Archive<'a> {
        let names = self.names(&data);
        let spindles = self.axes_with(&data, "MA_SPIND_ASSIGN_TO_MACHAX", |datum| {
            Ok(number(datum.line, &datum.key(), datum.value)? != 0.0)
        });
        let turning = self.axes_with(&data, "MA_IS_ROT_AX", switch);
        let gantries = gantries(&data, &names, &mut self.guessed);
        Archive {
            data,
            names,
            spindles,
            turning,
            gantries,
        }
    }

    /// The names of MD10000; of two for one axis the last.
    fn names(&mut self, data: &[Datum<'_>]) -> Vec<AxisName> {
        let mut names = Vec::new();
        for datum in data
            .iter()
            .filter(|it| it.name == "MN_AXCONF_MACHAX_NAME_TAB")
        {
            let number = datum.index.first().and_then(|it| it.parse::<usize>().ok());
            let Some(number) = number.filter(|number| *number < MOST_AXES) else {
                let hint = "names are written as $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"";
                let message = "names no machine axis by its place";
                let found = problem(datum.line, &datum.key(), message, hint);
                self.note(datum, found);
                continue;
            };
            names.retain(|it: &AxisName| it.number != number + 1);
            names.push(AxisName {
                name: datum.value.to_owned(),
                number: number + 1,
                // Slaves of gantries, spindles and tool changers have longer names: XF1, SP1, ATC1.
                axis: lettered(datum.value),
            });
        }
        names
    }

    /// The axes for which a datum is on.
    fn axes_with<'a>(
        &mut self,
        data: &[Datum<'a>],
        name: &str,
        is_on: fn(&Datum<'_>) -> Result<bool, Problem>,
    ) -> BTreeSet<&'a str> {
        let mut axes = BTreeSet::new();
        for datum in data.iter().filter(|it| it.name == name) {
            match is_on(datum) {
                Ok(true) => axes.extend(datum.index.last().copied()),
                Ok(false) => {}
                Err(found) => self.note(datum, found),
            }
        }
        axes
    }

    /// Takes down what is wrong with a datum.
    fn note(&mut self, datum: &Datum<'_>, found: Problem) {
        self.wrong
            .note(&mut self.draft, (datum.name, datum.value), found);
    }

    /// Takes a datum over, or reports why not.
    fn take_over(&mut self, archive: &Archive<'_>, datum: &Datum<'_>) {
        if self.wrong.left_out.contains(&datum.line) {
            return;
        }
        if datum.name == "MN_SCALING_SYSTEM_IS_METRIC" {
            self.scaling(datum);
            return;
        }
        let is_of_axis = datum.name.starts_with("MA_");
        let own = datum.index.last().copied();
        if is_of_axis && let Some(leading) = archive.gantries.get(own.unwrap_or_default()) {
            if let Err(found) = follow(&mut self.draft, datum, &archive.data, *leading) {
                self.note(datum, found);
            }
            return;
        }
        let axis = own
            .filter(|own| is_of_axis && !archive.spindles.contains(own))
            .and_then(|own| axis_of(own, &archive.names, &mut self.guessed));
        let first = datum.index.len() < 2 || datum.index[0] == "0";
        let Some(axis) = axis.filter(|_| first) else {
            self.of_no_axis(datum);
            return;
        };
        let rotary = own.is_some_and(|own| archive.turning.contains(own));
        // A letter says the kind: X Y Z U V W slide, A B C turn.
        if rotary != axis.is_rotary() {
            let note = format!("{axis} does not {}", if rotary { "turn" } else { "slide" });
            self.draft
                .row(datum.key(), datum.value, Fate::Ignored, note);
            return;
        }
        self.of_axis(archive, datum, axis);
    }

    /// Takes over whether the data are metric; those in inches are refused.
    fn scaling(&mut self, datum: &Datum<'_>) {
        let key = datum.key();
        let is_metric = switch(datum).unwrap_or_else(|found| {
            self.wrong.problems.push(found);
            true
        });
        if !is_metric {
            let message = "the machine's data are in inches, which are not read";
            let hint = "switch the basic system to metric and write the archive again";
            let found = problem(datum.line, &key, message, hint);
            self.wrong.problems.push(found);
        }
        self.draft
            .row(key, datum.value, Fate::Used, "unit of the data");
    }

    /// Reports a datum that no axis takes.
    fn of_no_axis(&mut self, datum: &Datum<'_>) {
        let (fate, note) = if datum.name != "MN_AXCONF_MACHAX_NAME_TAB" {
            (Fate::Ignored, "")
        } else if lettered(datum.value).is_some() {
            (Fate::Used, "")
        } else {
            (Fate::Ignored, "no letter of an axis: its data are left out")
        };
        self.draft.row(datum.key(), datum.value, fate, note);
    }

    /// Takes a datum of an axis over.
    fn of_axis(&mut self, archive: &Archive<'_>, datum: &Datum<'_>, axis: AxisId) {
        match take(&mut self.draft, datum, &archive.data, axis) {
            Ok(unit) => self.units.extend(unit),
            // Of a gap's weight it is the gap that lacks it.
            Err(found) => {
                let mut data = archive.data.iter();
                let other = data.find(|it| it.line == found.line as usize);
                if found.line as usize != datum.line {
                    let note = format!("line {} is needed for it and has no value", found.line);
                    self.draft
                        .row(datum.key(), datum.value, Fate::Ignored, note);
                }
                let value = other.map_or(datum.value, |it| it.value);
                self.wrong.note(&mut self.draft, (datum.name, value), found);
            }
        }
    }

    /// Lists the units and the axes that the archive does not tell.
    fn list_guesses(&mut self) {
        for (name, unit) in &self.units {
            let why = "the archive does not tell it: as the list manual has it for metric systems";
            self.draft
                .row(format!("unit of ${name}"), *unit, Fate::Guessed, why);
        }
        for (name, axis) in &self.guessed {
            let why = "its name in MD10000 is not in the file: by its number";
            self.draft
                .row(name, format!("axis {axis}"), Fate::Guessed, why);
        }
    }

    /// The machine, or for what it is refused.
    fn finish(self, archive: &Archive<'_>) -> Result<Draft, Vec<Problem>> {
        let Reading {
            mut draft, wrong, ..
        } = self;
        let mut problems = wrong.problems;
        if draft.axes.is_empty() && problems.is_empty() {
            let hint = "write the archive as text with the axes' machine data ($MA_...)";
            let message = "there is no machine data of an axis";
            problems.push(problem(1, "", message, hint));
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        let names = archive.names.iter();
        for named in names.filter(|it| !archive.spindles.contains(&*format!("AX{}", it.number))) {
            draft
                .expected
                .extend(named.axis.map(|axis| (axis, "MD10000 names it")));
        }
        draft.carry("actual-value", |_| Vec::new());
        Ok(draft)
    }
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
        return lettered(own);
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

/// The axes that follow another in a gantry (MD37100: 11 follows 1), and the axis that each follows.
fn gantries<'a>(
    data: &[Datum<'a>],
    names: &[AxisName],
    guessed: &mut Vec<(String, AxisId)>,
) -> BTreeMap<&'a str, AxisId> {
    let kinds: Vec<(&str, u32)> = data
        .iter()
        .filter(|it| it.name == "MA_GANTRY_AXIS_TYPE")
        .filter_map(|it| Some((*it.index.last()?, it.value.parse().ok()?)))
        .collect();
    let mut found = BTreeMap::new();
    for (own, kind) in kinds.iter().filter(|(_, kind)| *kind > GANTRY_FOLLOWS) {
        let leads =
            |(other, leading): &&(&str, u32)| other != own && leading + GANTRY_FOLLOWS == *kind;
        let leading = kinds.iter().find(leads);
        if let Some(axis) = leading.and_then(|(name, _)| axis_of(name, names, guessed)) {
            found.insert(*own, axis);
        }
    }
    found
}

/// Takes over what is told of the second motor of a gantry: its gap.
fn follow(
    draft: &mut Draft,
    datum: &Datum<'_>,
    data: &[Datum<'_>],
    leading: AxisId,
) -> Result<(), Problem> {
    let key = datum.key();
    let is_gap = datum.name == "MA_BACKLASH" && (datum.index.len() < 2 || datum.index[0] == "0");
    let motor = datum.index.last().copied().unwrap_or_default();
    let own = draft
        .axis(leading, leading.is_rotary())
        .further_motor(motor);
    let (fate, note) = if is_gap && !datum.value.starts_with('-') {
        own.gap = Some(Told {
            value: not_negative(datum.line, &key, datum.value)? * weight(datum, data)?,
            from: key.clone(),
            line: datum.line,
        });
        (Fate::Used, format!("gap of the second motor of {leading}"))
    } else if is_gap {
        number(datum.line, &key, datum.value)?;
        (Fate::Ignored, LEADING.to_owned())
    } else if datum.name == "MA_GANTRY_AXIS_TYPE" {
        (Fate::Used, format!("second motor of {leading}"))
    } else {
        let note = format!("of the second motor of {leading}, taken to be like the first");
        (Fate::Ignored, note)
    };
    draft.row(key, datum.value, fate, note);
    Ok(())
}

/// Takes a datum over; answers its name and the unit that was taken for it, where that is a guess.
fn take(
    draft: &mut Draft,
    datum: &Datum<'_>,
    data: &[Datum<'_>],
    axis: AxisId,
) -> Result<Option<(&'static str, &'static str)>, Problem> {
    let key = datum.key();
    let turns = axis.is_rotary();
    // mm/min or rev/min; m/s2 or rev/s2.
    let per_minute = if turns { DEGREES / 60.0 } else { 1.0 / 60.0 };
    let per_second = if turns { DEGREES } else { 1e3 };
    let above_zero = |factor: f64| Ok(positive(datum.line, &key, datum.value)? * factor);
    let (quantity, amount, unit) = match datum.name {
        "MA_MAX_AX_VELO" => (
            Quantity::Velocity,
            above_zero(per_minute)?,
            Some(("MA_MAX_AX_VELO", "mm/min, rev/min")),
        ),
        "MA_MAX_AX_ACCEL" => (
            Quantity::Acceleration,
            above_zero(per_second)?,
            Some(("MA_MAX_AX_ACCEL", "m/s2, rev/s2")),
        ),
        "MA_MAX_AX_JERK" => (
            Quantity::Jerk,
            above_zero(per_second)?,
            Some(("MA_MAX_AX_JERK", "m/s3, rev/s3")),
        ),
        "MA_POS_LIMIT_MINUS" | "MA_POS_LIMIT_PLUS" => {
            let end = number(datum.line, &key, datum.value)?;
            if end.abs() >= NO_LIMIT {
                draft.row(key, datum.value, Fate::Ignored, "no limit");
                return Ok(None);
            }
            let quantity = if datum.name == "MA_POS_LIMIT_PLUS" {
                Quantity::Max
            } else {
                Quantity::Min
            };
            (quantity, end, None)
        }
        "MA_BACKLASH" => {
            if datum.value.starts_with('-') {
                number(datum.line, &key, datum.value)?;
                draft.row(key, datum.value, Fate::Ignored, LEADING);
                return Ok(None);
            }
            let gap = not_negative(datum.line, &key, datum.value)?;
            (Quantity::Gap, gap * weight(datum, data)?, None)
        }
        "MA_BACKLASH_FACTOR" => {
            draft.row(key, datum.value, Fate::Used, "weight of the gap");
            return Ok(None);
        }
        "MA_GANTRY_AXIS_TYPE" => {
            let (fate, note) = match datum.value {
                "0" => (Fate::Ignored, "of no gantry"),
                _ => (Fate::Used, "leads a gantry, where an axis follows"),
            };
            draft.row(key, datum.value, fate, note);
            return Ok(None);
        }
        "MA_IS_ROT_AX" => {
            draft.row(key, datum.value, Fate::Used, "kind of axis");
            return Ok(None);
        }
        "MA_POSCTRL_GAIN" => {
            let gain = positive(datum.line, &key, datum.value)? * 1e3 / 60.0;
            draft.row(key, datum.value, Fate::Ignored, super::untaken_gain(gain));
            return Ok(None);
        }
        "MA_LEADSCREW_PITCH" => {
            let note = "lead_mm: the drive comes from the preset, set it with motor and gains";
            draft.row(key, datum.value, Fate::Ignored, note);
            return Ok(None);
        }
        _ => {
            let note = match friction(datum, data, turns)? {
                Some(note) => note,
                None => left_out(datum.name).to_owned(),
            };
            draft.row(key, datum.value, Fate::Ignored, note);
            return Ok(None);
        }
    };
    let told = Told {
        value: amount,
        from: key,
        line: datum.line,
    };
    draft.tell(axis, quantity, told, datum.value);
    Ok(unit)
}

/// What compensations are that are not carried.
fn left_out(name: &str) -> &'static str {
    match name {
        "MA_BACKLASH_DYN" | "MA_BACKLASH_DYN_MAX_VELO" | "MA_BACKLASH_MODE" => {
            "dynamic backlash, which the PLC switches: not carried"
        }
        "MA_ENC_COMP_ENABLE" | "MA_CEC_ENABLE" => {
            "compensation of the screw or of sag: not carried, as the machine's errors are not"
        }
        _ => "",
    }
}

/// What a datum of the friction compensation (MD32490 to MD32580) says; `None` if it is none of it. An
/// axis runs one method, that of its gap: this one is told in the keys of `decaying-pulse`.
fn friction(datum: &Datum<'_>, data: &[Datum<'_>], turns: bool) -> Result<Option<String>, Problem> {
    let Some(name) = datum.name.strip_prefix("MA_FRICT_COMP_") else {
        return Ok(None);
    };
    let own = |name: &str| {
        let mut all = data.iter();
        all.rfind(|it| it.name == name && it.index.last() == datum.index.last())
    };
    let is_on = own("MA_FRICT_COMP_ENABLE").map_or(Ok(false), switch)?;
    let mode = own("MA_FRICT_COMP_MODE")
        .map_or(Ok(1.0), |it| not_negative(it.line, &it.key(), it.value))?;
    if !is_on || mode == 0.0 {
        return Ok(Some("friction compensation, which is off".to_owned()));
    }
    // mm/min or rev/min; m/s2 or rev/s2; s.
    let (speed, rise) = if turns {
        (DEGREES / 60.0, DEGREES)
    } else {
        (1.0 / 60.0, 1e3)
    };
    let value = |factor: f64| {
        let value = not_negative(datum.line, &datum.key(), datum.value)?;
        Ok::<_, Problem>(float(value * factor))
    };
    let what = match name {
        "CONST_MAX" => format!("height_units_s = {}", value(speed)?),
        "CONST_MIN" => format!("least_height_units_s = {}", value(speed)?),
        "TIME" => format!("time_ms = {}", value(1e3)?),
        "ACCEL1" | "ACCEL2" | "ACCEL3" => {
            format!("{} of acceleration_units_s2", value(rise)?)
        }
        _ => "method decaying-pulse".to_owned(),
    };
    Ok(Some(format!(
        "friction compensation is at work, and not carried: {what} (compensation.decaying_pulse)"
    )))
}

/// The weight of an axis' gap, of the first set of parameters (MD32452); 1 if it is not told.
fn weight(gap: &Datum<'_>, data: &[Datum<'_>]) -> Result<f64, Problem> {
    let factor = data.iter().rfind(|it| {
        it.name == "MA_BACKLASH_FACTOR"
            && it.index.last() == gap.index.last()
            && (it.index.len() < 2 || it.index[0] == "0")
    });
    factor.map_or(Ok(1.0), |it| positive(it.line, &it.key(), it.value))
}
