//! LinuxCNC's INI file: [EMC] MACHINE; [TRAJ] COORDINATES, LINEAR_UNITS, ANGULAR_UNITS; [KINS]
//! KINEMATICS; and of every [JOINT_n] and [AXIS_L] limits, BACKLASH, FERROR, MIN_FERROR; [HAL]
//! HALCMD and HALFILE (`hal`); what moves the joints (`linuxcnc_motors`), and the files that it
//! names (`linuxcnc_files`). Units are those of the machine and seconds. See
//! <https://linuxcnc.org/docs/stable/html/config/ini-config.html>.

use super::draft::{Draft, Fate, LEADING, Told};
use super::hal::{Hal, Pins};
use super::ini::{self, Entry, Ini};
use super::kins::{self, Module, Numbered};
use super::{Format, ImportOptions, linuxcnc_files, linuxcnc_motors, number, problem};
use crate::control::Control;
use crate::machine::Problem;
use lostmotion_base::AxisId;
use lostmotion_gcode::Units as Length;
use lostmotion_kinematics::KinematicsSpec;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

/// The format's row.
pub(super) const FORMAT: Format = Format {
    name: "linuxcnc",
    extensions: &["ini"],
    looks_like: |text| {
        let mut lines = text.lines().map(str::trim);
        lines.any(|line| matches!(line, "[EMC]" | "[TRAJ]" | "[KINS]"))
    },
    is_lines: true,
    read,
};

/// Reads the file.
fn read(text: &str, options: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let mut ini = ini::read(text, options)?;
    let mut problems = Vec::new();
    let mut draft = Draft::new("LinuxCNC");
    let hal = Hal::read(&ini, &mut draft, options);
    replace_by_hal(&mut draft, &mut ini, &hal);
    tell_lines(&mut draft, &ini, &mut problems);
    let name = ini.first(&["EMC"], "MACHINE");
    if let Some(name) = name.filter(|entry| !entry.value.is_empty()) {
        draft.name.clone_from(&name.value);
    }
    let kins = Kins::of(&ini, &mut problems);
    let joints = kins.joints(&ini, units(&ini, &mut draft, &mut problems));
    draft.joint_axes = joints
        .numbered
        .iter()
        .map(|joint| joint.map(|it| it.0))
        .collect();
    // Pins of the kinematics wait for the module; any other key is taken or reported as ignored.
    let pins = Pins::new(kins.name, kins.line, &hal, &ini);
    let tables: Vec<(&Entry, String)> = ini
        .entries
        .iter()
        .filter(|entry| entry.key == "COMP_FILE" && joints.of(&entry.section).is_some())
        .filter_map(|entry| Some((entry, entry.text(&mut draft, options)?)))
        .collect();
    let source = Source {
        ini: &ini,
        hal: &hal,
        module: kins.name,
        joints: &joints,
        tables: &tables,
        options,
    };
    source.take(&mut draft, &mut problems);
    let further: Vec<(AxisId, String)> = ini
        .entries
        .iter()
        .filter(|entry| joints.is_further(&entry.section))
        .filter_map(|entry| Some((joints.of(&entry.section)?.0, entry.section.clone())))
        .collect();
    draft.add_motors(&further);
    source.take_tables(&mut draft, &mut problems);
    let scale = (joints.units.linear, joints.units.angular);
    if let Err(found) = linuxcnc_motors::tell(&mut draft, &ini, &hal, &joints.numbered, scale) {
        problems.push(found);
    }
    motor_rows(&mut draft, &ini, &joints);
    carry(&mut draft);
    if draft.axes.is_empty() && problems.is_empty() {
        problems.push(problem(
            1,
            "",
            "there is no [JOINT_n] or [AXIS_L] with limits",
            match ini.included.iter().find(|file| file.missing.is_some()) {
                Some(_) => "a file that it includes was not read: is it there?",
                None => "is it the machine's INI file?",
            },
        ));
    }
    if let Some(module) = kins.module
        && let Err(found) = module.describe(&mut draft, pins, joints.units.linear, &kins.letters)
    {
        problems.push(found);
    }
    complete(&mut draft);
    let named = kins.letters.iter();
    let named = named.map(|(axis, _)| (*axis, "the coordinates name it"));
    draft.expected.extend(named);
    if problems.is_empty() {
        Ok(draft)
    } else {
        Err(problems)
    }
}

/// Puts what HAL sets into the place of the limits that it sets, and tells what is set besides.
fn replace_by_hal(draft: &mut Draft, ini: &mut Ini, hal: &Hal) {
    for entry in hal.replaced(ini) {
        if !RULES.iter().any(|(key, _)| *key == entry.key) {
            draft.row(
                entry.name(),
                entry.value,
                Fate::Ignored,
                "no limit that is read",
            );
            continue;
        }
        let by = entry.name();
        for before in ini.replace(entry) {
            let note = format!("{by} counts");
            draft.row(before.name(), before.value, Fate::Ignored, note);
        }
    }
}

/// Tells of included files and of lines that are no entries.
fn tell_lines(draft: &mut Draft, ini: &Ini, problems: &mut Vec<Problem>) {
    // What is asked for may stand in an included file; in silence defaults would take its place.
    for included in &ini.included {
        let (fate, note) = match &included.missing {
            None => (Fate::Used, "read in its place".to_owned()),
            Some(why) => (
                Fate::Ignored,
                format!("not read ({why}): put its text in the line's place if it describes axes"),
            ),
        };
        draft.row("#INCLUDE", included.file.as_str(), fate, note);
    }
    for (line, text) in &ini.passed {
        // A limit that lacks its sign would be lost without a word.
        let word = text.split_whitespace().next().unwrap_or_default();
        if RULES.iter().any(|(key, _)| *key == word) {
            let message = format!("`{text}` is neither a section nor KEY = VALUE");
            problems.push(problem(*line, "", message, "write MAX_VELOCITY = 50.0"));
        } else {
            let note = "neither a section nor KEY = VALUE: LinuxCNC passes over it";
            draft.row(format!("line {line}"), text.as_str(), Fate::Ignored, note);
        }
    }
}

/// KINEMATICS = MODULE [coordinates=LETTERS]: in [KINS], or in [TRAJ] of older files.
struct Kins<'a> {
    name: &'a str,
    line: usize,
    /// `None` of one that is not known.
    module: Option<&'static Module>,
    /// Coordinates that the module is told.
    told: Option<&'a str>,
    /// Those that count.
    coordinates: &'a str,
    /// Their axes.
    letters: Vec<Numbered>,
}

impl<'a> Kins<'a> {
    fn of(ini: &'a Ini, problems: &mut Vec<Problem>) -> Kins<'a> {
        let entry = ini.first(&["KINS", "TRAJ"], "KINEMATICS");
        let mut words = entry
            .map_or("trivkins", |entry| entry.value.as_str())
            .split_whitespace();
        let name = words.next().unwrap_or("trivkins");
        let line = entry.map_or(1, |entry| entry.line);
        let told = words.find_map(|word| word.strip_prefix("coordinates="));
        let module = kins::find(name, line)
            .map_err(|found| problems.push(found))
            .ok();
        // Which axes there are: the module's argument, then [TRAJ], then what the module usually has.
        let coordinates = told
            .or_else(|| {
                let entry = ini.first(&["TRAJ"], "COORDINATES")?;
                Some(entry.value.as_str())
            })
            .unwrap_or(module.map_or("XYZ", |module| module.coordinates));
        let letters = coordinates
            .chars()
            .filter_map(AxisId::from_letter)
            .map(|axis| (axis, axis.is_rotary()))
            .collect();
        Kins {
            name,
            line,
            module,
            told,
            coordinates,
            letters,
        }
    }

    /// The joints as the module numbers them.
    fn joints(&self, ini: &Ini, units: Units) -> IniJoints {
        let by_letter = self
            .module
            .filter(|module| self.told.is_none() && module.numbers_all_letters());
        let numbered = by_letter
            .and_then(|_| by_place_of_letter(ini, &self.letters))
            .unwrap_or_else(|| {
                let numbered = self.module.map_or_else(
                    || self.letters.clone(),
                    |module| module.numbered(self.coordinates),
                );
                numbered.into_iter().map(Some).collect()
            });
        IniJoints {
            numbered,
            words_too: self.module.is_none_or(Module::words_are_joints),
            units,
        }
    }
}

/// Names of a unit, and how many of it LinuxCNC counts in a mm or a degree: the file may have the number, too.
type UnitNames<T> = [(&'static [&'static str], f64, T)];
const LENGTHS: &UnitNames<Length> = &[
    (&["mm", "metric"], 1.0, Length::Mm),
    (&["inch", "in", "imperial"], 1.0 / 25.4, Length::Inch),
];
/// With the degrees in it.
const ANGLES: &UnitNames<f64> = &[
    (&["degree", "deg"], 1.0, 1.0),
    (&["radian", "rad"], PI / 180.0, 180.0 / PI),
];
/// How near a number has to be to that of a unit, as a ratio. A choice: three digits tell it.
const NEAR: f64 = 1e-3;

/// The unit that a key names or counts; the first where it is not there.
fn unit<T: Copy>(ini: &Ini, key: &'static str, names: &UnitNames<T>) -> Result<T, Problem> {
    let entry = ini.first(&["TRAJ"], key);
    let Some(entry) = entry else {
        return Ok(names[0].2);
    };
    let counted = entry.plain().parse::<f64>().ok();
    let found = names.iter().find(|(all, count, _)| {
        all.iter()
            .any(|name| name.eq_ignore_ascii_case(entry.plain()))
            || counted.is_some_and(|it| (it / count - 1.0).abs() < NEAR)
    });
    found.map(|found| found.2).ok_or_else(|| {
        let known = names
            .iter()
            .map(|(all, count, _)| format!("{} ({count:.6})", all.join(", ")));
        problem(
            entry.line,
            &entry.name(),
            format!("is {}", entry.value),
            &format!("write one of {}", known.collect::<Vec<_>>().join("; ")),
        )
    })
}

/// Factors from the machine's units to mm and degrees; tells the control's units.
fn units(ini: &Ini, draft: &mut Draft, problems: &mut Vec<Problem>) -> Units {
    let mut told = |found: Result<(), Problem>| problems.extend(found.err());
    // The interpreter starts in the machine's units (LinuxCNC, Interp::init).
    told(unit(ini, "LINEAR_UNITS", LENGTHS).map(|unit| {
        if let Some(entry) = ini
            .first(&["TRAJ"], "LINEAR_UNITS")
            .filter(|_| unit == Length::Inch)
        {
            draft.control_units = (unit, entry.name());
        }
    }));
    let mut angular = 1.0;
    told(unit(ini, "ANGULAR_UNITS", ANGLES).map(|unit| angular = unit));
    Units {
        linear: draft.control_units.0.mm(),
        angular,
    }
}

/// What the draft is taken from.
struct Source<'a> {
    ini: &'a Ini,
    hal: &'a Hal,
    /// Name of the kinematics module.
    module: &'a str,
    joints: &'a IniJoints,
    /// Entries that name a screw's table, with its text.
    tables: &'a [(&'a Entry, String)],
    options: &'a ImportOptions<'a>,
}

impl Source<'_> {
    /// Takes the entries over, and reports those that are not.
    fn take(&self, draft: &mut Draft, problems: &mut Vec<Problem>) {
        let mut limits = Limits::default();
        for entry in &self.ini.entries {
            let has_table = |(table, _): &(&Entry, String)| table.section == entry.section;
            if entry.key == "BACKLASH" && self.tables.iter().any(has_table) {
                let note = "LinuxCNC does not use it beside a COMP_FILE";
                draft.row(entry.name(), entry.value.as_str(), Fate::Ignored, note);
                continue;
            }
            match self.is_taken(draft, entry) {
                Ok(true) => continue,
                Ok(false) => {}
                Err(found) => {
                    problems.push(found);
                    continue;
                }
            }
            match limit(entry, self.joints) {
                Ok(Some(found)) if found.is_leading() => {
                    draft.row(entry.name(), entry.value.as_str(), Fate::Ignored, LEADING);
                }
                Ok(Some(found)) => limits.add(found),
                Ok(None) => other(draft, entry),
                Err(found) => problems.push(found),
            }
        }
        limits.set(draft);
    }

    /// Whether an entry is taken here or told elsewhere: what is of files, motors and HAL.
    fn is_taken(&self, draft: &mut Draft, entry: &Entry) -> Result<bool, Problem> {
        // Files are told where they are read.
        let of_hal = match entry.key.as_str() {
            "HALFILE" | "POSTGUI_HALFILE" => true,
            "HALCMD" | "POSTGUI_HALCMD" => self.hal.takes(entry, self.module),
            _ => false,
        };
        if entry.section == "HAL" && of_hal {
            return Ok(true);
        }
        let is_joint = self.joints.of(&entry.section).is_some();
        let is_screw = matches!(entry.key.as_str(), "COMP_FILE" | "COMP_FILE_TYPE");
        if is_joint && (is_screw || linuxcnc_motors::is_motor_key(&entry.key)) {
            return Ok(true);
        }
        linuxcnc_files::take(draft, entry, self.joints.units.linear, self.options)
    }

    /// Takes the gaps of the screws' tables.
    fn take_tables(&self, draft: &mut Draft, problems: &mut Vec<Problem>) {
        let units = &self.joints.units;
        for (entry, text) in self.tables {
            let Some(joint) = self.joints.of(&entry.section) else {
                continue;
            };
            let kind = self.ini.first(&[&entry.section], "COMP_FILE_TYPE");
            let unit = if joint.1 { units.angular } else { units.linear };
            let taken = linuxcnc_files::screw(draft, entry, kind, joint, unit, text);
            problems.extend(taken.err());
        }
    }
}

/// BACKLASH and COMP_FILE are at work already: the gap is the machine's, the method the control's.
fn carry(draft: &mut Draft) {
    draft.control = Some(Control::LinuxCnc);
    draft.carry("fixed-linuxcnc", |axis| {
        let told = [
            ("velocity_units_s", &axis.velocity),
            ("acceleration_units_s2", &axis.acceleration),
        ];
        let told = told.into_iter().filter(|_| !axis.rotary);
        told.filter_map(|(key, told)| Some((key, told.as_ref()?.value)))
            .collect()
    });
}

/// Keys of motors and of screws that nothing was made of are told as that.
fn motor_rows(draft: &mut Draft, ini: &Ini, joints: &IniJoints) {
    let mut told: BTreeSet<String> = draft.rows.iter().map(|row| row.key.clone()).collect();
    for entry in &ini.entries {
        let screw = entry.key == "COMP_FILE_TYPE";
        if joints.of(&entry.section).is_none()
            || !(screw || linuxcnc_motors::is_motor_key(&entry.key))
            || !told.insert(entry.name())
        {
            continue;
        }
        let fate = if screw { Fate::Used } else { Fate::Ignored };
        draft.row(entry.name(), entry.value.as_str(), fate, "");
    }
}

/// All joints of the kinematics have axes, and nothing else has.
fn complete(draft: &mut Draft) {
    let joints: Vec<Numbered> = match &draft.kinematics {
        KinematicsSpec::Chain(chain) => chain
            .joint
            .iter()
            .filter_map(|joint| Some((joint.axis_id()?, joint.is_rotary())))
            .collect(),
        KinematicsSpec::Delta(_) => [AxisId::X, AxisId::Y, AxisId::Z]
            .map(|axis| (axis, false))
            .to_vec(),
        KinematicsSpec::Scara(_) => kins::SCARA.to_vec(),
        // The other kinds take the axes as they are told.
        _ => return,
    };
    // Axes that the kinematics does not have are dropped, and reported.
    let (kept, left): (Vec<_>, Vec<_>) = draft
        .axes
        .drain(..)
        .partition(|own| joints.iter().any(|(axis, _)| *axis == own.id));
    draft.axes = kept;
    for axis in left {
        draft.row(
            format!("axis {}", axis.id),
            "",
            Fate::Ignored,
            "has no place in these kinematics",
        );
    }
    for (axis, turns) in joints {
        draft.axis(axis, turns);
    }
}

/// Machine units in mm and degrees.
struct Units {
    linear: f64,
    angular: f64,
}

/// What joints there are.
struct IniJoints {
    /// Axes of the joints by their number; `None` of those that no axis is of.
    numbered: Vec<Option<Numbered>>,
    /// Whether what a word may do is what the joint of its letter may.
    words_too: bool,
    units: Units,
}

impl IniJoints {
    /// Whether it is the section of a joint behind the first of its axis.
    fn is_further(&self, section: &str) -> bool {
        let own = section.strip_prefix("JOINT_");
        own.and_then(|own| own.parse::<usize>().ok())
            .and_then(|joint| self.numbered.get(..=joint)?.split_last())
            .is_some_and(|(own, before)| own.is_some() && before.contains(own))
    }

    /// The axis whose section it is, and whether it turns.
    fn of(&self, section: &str) -> Option<Numbered> {
        if let Some(letter) = section.strip_prefix("AXIS_").filter(|_| self.words_too) {
            let mut chars = letter.chars();
            let axis = chars
                .next()
                .filter(|_| chars.next().is_none())
                .and_then(|letter| match letter.to_digit(10) {
                    // Before 2.8 axes were numbered.
                    Some(index) => AxisId::from_index(index as usize),
                    None => AxisId::from_letter(letter),
                });
            return axis.map(|axis| (axis, axis.is_rotary()));
        }
        // Joints go by their number; which axis that is, the kinematics module says.
        self.numbered
            .get(section.strip_prefix("JOINT_")?.parse::<usize>().ok()?)
            .copied()
            .flatten()
    }
}

/// The joints of a module that is not told its coordinates: it numbers the joints of all nine letters,
/// whichever of them the machine has, so that Z of a lathe is joint 2. `None` where the file has no
/// such joints.
fn by_place_of_letter(ini: &Ini, letters: &[Numbered]) -> Option<Vec<Option<Numbered>>> {
    let mut numbered = vec![None; AxisId::ALL.len()];
    for axis in letters {
        let place = AxisId::ALL.iter().position(|id| *id == axis.0)?;
        // Before 2.8 joints were axes by number.
        let sections = [format!("JOINT_{place}"), format!("AXIS_{place}")];
        // Two motors of one axis are numbered in another way.
        let is_new = numbered[place].replace(*axis).is_none();
        let mut entries = ini.entries.iter();
        if !is_new || !entries.any(|entry| sections.contains(&entry.section)) {
            return None;
        }
    }
    Some(numbered)
}

/// Which of two values holds where a joint and its axis, or two joints of one axis, have one each:
/// the tighter limit, since G-code has to keep both, and the wider gap; but two joints have their own
/// gaps.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rule {
    Smaller,
    Larger,
}

/// The keys that describe axes.
const RULES: [(&str, Rule); 8] = [
    ("MIN_LIMIT", Rule::Larger),
    ("MAX_LIMIT", Rule::Smaller),
    ("MAX_VELOCITY", Rule::Smaller),
    ("MAX_ACCELERATION", Rule::Smaller),
    ("MAX_JERK", Rule::Smaller),
    ("BACKLASH", Rule::Larger),
    ("FERROR", Rule::Smaller),
    ("MIN_FERROR", Rule::Smaller),
];

/// A value of an axis, in mm or deg and s.
struct Limit<'a> {
    entry: &'a Entry,
    axis: Numbered,
    /// Whether it is of a motor behind the first of its axis.
    is_further: bool,
    /// Its place among [`RULES`].
    key: usize,
    value: f64,
}

/// What an entry says of an axis; `None` if it says nothing of one.
fn limit<'a>(entry: &'a Entry, joints: &IniJoints) -> Result<Option<Limit<'a>>, Problem> {
    let place = RULES.iter().position(|(key, _)| *key == entry.key);
    let (Some(axis), Some(place)) = (joints.of(&entry.section), place) else {
        return Ok(None);
    };
    // The machine's units to mm and degrees.
    let scale = if axis.1 {
        joints.units.angular
    } else {
        joints.units.linear
    };
    let key = entry.name();
    let value = number(entry.line, &key, entry.plain())? * scale;
    let above_zero = [
        "MAX_VELOCITY",
        "MAX_ACCELERATION",
        "MAX_JERK",
        "FERROR",
        "MIN_FERROR",
    ];
    if above_zero.contains(&entry.key.as_str()) && value <= 0.0 {
        let message = format!("is {}; it has to be above 0", entry.value);
        return Err(problem(entry.line, &key, message, ""));
    }
    Ok(Some(Limit {
        entry,
        axis,
        is_further: joints.is_further(&entry.section),
        key: place,
        value,
    }))
}

/// What a value is of: an axis, its key, and the section of a motor that has a gap of its own.
type Subject<'a> = (AxisId, usize, Option<&'a str>);

impl<'a> Limit<'a> {
    /// Whether it is a gap below 0.
    fn is_leading(&self) -> bool {
        self.entry.key == "BACKLASH" && self.value < 0.0
    }

    fn place(&self) -> Subject<'a> {
        let own = self.is_further && self.entry.key == "BACKLASH";
        let section = own.then_some(self.entry.section.as_str());
        (self.axis.0, self.key, section)
    }
}

/// All values of axes.
#[derive(Default)]
struct Limits<'a>(Vec<Limit<'a>>);

impl<'a> Limits<'a> {
    fn add(&mut self, limit: Limit<'a>) {
        self.0.push(limit);
    }

    /// Where the values stand that hold, of each key of each axis: the first of equal ones.
    fn holding(&self) -> BTreeMap<Subject<'a>, usize> {
        let mut held: BTreeMap<Subject<'a>, usize> = BTreeMap::new();
        for (index, next) in self.0.iter().enumerate() {
            // Within a section LinuxCNC finds the first alone.
            let is_again = |other: &Limit<'_>| {
                (other.key, &other.entry.section) == (next.key, &next.entry.section)
            };
            if self.0.iter().take(index).any(is_again) {
                continue;
            }
            let place = held.entry(next.place()).or_insert(index);
            let tighter = match RULES[next.key].1 {
                Rule::Smaller => next.value < self.0[*place].value,
                Rule::Larger => next.value > self.0[*place].value,
            };
            if tighter {
                *place = index;
            }
        }
        held
    }

    /// Writes them into the draft, and what became of each into its report.
    fn set(&self, draft: &mut Draft) {
        let held = self.holding();
        for limit in &self.0 {
            let holds = held.get(&limit.place());
            let holds = holds.and_then(|at| self.0.get(*at)).unwrap_or(limit);
            let (axis, turns) = limit.axis;
            if !std::ptr::eq(holds, limit) {
                let note = if holds.entry.section == limit.entry.section {
                    format!("axis {axis}: LinuxCNC takes the first of one name")
                } else {
                    format!("axis {axis}: {} counts", holds.entry.name())
                };
                draft.row(
                    limit.entry.name(),
                    limit.entry.value.as_str(),
                    Fate::Ignored,
                    note,
                );
                continue;
            }
            let draft_axis = draft.axis(axis, turns);
            let slot = match limit.entry.key.as_str() {
                "MIN_LIMIT" => &mut draft_axis.min,
                "MAX_LIMIT" => &mut draft_axis.max,
                "MAX_VELOCITY" => &mut draft_axis.velocity,
                "MAX_ACCELERATION" => &mut draft_axis.acceleration,
                "MAX_JERK" => &mut draft_axis.jerk,
                "FERROR" => &mut draft_axis.following_error,
                "MIN_FERROR" => &mut draft_axis.standstill_error,
                _ if limit.is_further => &mut draft_axis.further_motor(&limit.entry.section).gap,
                _ => &mut draft_axis.gap,
            };
            *slot = Some(Told {
                value: limit.value,
                from: limit.entry.name(),
                line: limit.entry.line,
            });
            let note = format!("axis {axis}");
            draft.row(
                limit.entry.name(),
                limit.entry.value.as_str(),
                Fate::Used,
                note,
            );
        }
    }
}

/// Reports a key that describes no axis.
fn other(draft: &mut Draft, entry: &Entry) {
    let used = [
        ("EMC", "MACHINE"),
        ("TRAJ", "COORDINATES"),
        ("TRAJ", "LINEAR_UNITS"),
        ("TRAJ", "ANGULAR_UNITS"),
        ("KINS", "KINEMATICS"),
        ("TRAJ", "KINEMATICS"),
    ];
    let (fate, note) = if used.contains(&(entry.section.as_str(), entry.key.as_str())) {
        (Fate::Used, "general")
    } else if entry.key == "TYPE" {
        (Fate::Used, "kind of joint, by its letter")
    } else {
        (Fate::Ignored, "")
    };
    draft.row(entry.name(), entry.value.as_str(), fate, note);
}
