//! Klipper's printer.cfg: sections `[stepper_x]`, lines `key: value` or `key = value`.
//!
//! `[printer]` kinematics, max_velocity, max_accel, max_z_velocity, max_z_accel (mm, s); of every
//! `[stepper_x]` rotation_distance, gear_ratio, microsteps, full_steps_per_rotation, position_min,
//! position_max (mm); of its driver (`[tmc2209 stepper_x]`) run_current (A, effective). Files that
//! `[include FILE]` names are read, in the order of their names where it has wildcards. What
//! SAVE_CONFIG wrote (`#*#`) counts. Klipper has no setting for a gap. See
//! <https://www.klipper3d.org/Config_Reference.html>.

use super::draft::{Draft, Fate, LIKE_FIRST, MachineSize, Quantity, Told, unlike_first};
use super::{Format, ImportOptions, number, positive, problem, wildcards};
use crate::control::Control;
use crate::machine::Problem;
use lostmotion_base::AxisId;
use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;

/// The format's row. Its files share their extension with others.
pub(super) const FORMAT: Format = Format {
    name: "klipper",
    extensions: &[],
    looks_like: |text| {
        let mut lines = text.lines().map(str::trim);
        lines.any(|line| line == "[printer]" || line.starts_with("[stepper_"))
    },
    is_lines: true,
    read,
};

/// Deepest nesting of included files: a file that includes itself ends here.
const DEEPEST: usize = 16;

/// Words of the lines that SAVE_CONFIG writes above its part.
const SAVED_HEAD: [&str; 2] = ["SAVE_CONFIG", "DO NOT EDIT"];

/// A line with a value.
struct ConfigLine {
    line: usize,
    section: String,
    key: String,
    value: String,
}

impl ConfigLine {
    fn name(&self) -> String {
        format!("[{}] {}", self.section, self.key)
    }
}

/// ConfigFile of the file and of those that it includes.
#[derive(Default)]
struct ConfigFile {
    entries: Vec<ConfigLine>,
    /// Section and key, and where the last of them stands.
    last: BTreeMap<String, BTreeMap<String, usize>>,
    section: String,
    /// Folder of the file that is read, with a stroke behind it: names of included files begin there.
    folder: String,
    /// Indent of the key that the lines before belong to: what stands further in goes on with it.
    indent: Option<usize>,
    bytes: usize,
}

/// Sections of which something is taken.
fn is_read(section: &str) -> bool {
    section == "printer" || section.starts_with("stepper_") || section.starts_with("tmc")
}

impl ConfigFile {
    /// `at` is the line of the file that is imported where the text is included.
    fn file(
        &mut self,
        text: &str,
        at: Option<usize>,
        depth: usize,
        options: &ImportOptions<'_>,
        draft: &mut Draft,
    ) -> Result<(), Problem> {
        for (index, line) in text.lines().enumerate() {
            let place = at.unwrap_or(index + 1);
            // SAVE_CONFIG writes its part as comments, which count.
            let saved = line.strip_prefix("#*#");
            let line = saved.map_or(line, |own| own.strip_prefix(' ').unwrap_or(own));
            let told = line.split(['#', ';']).next().unwrap_or_default().trim();
            // What stands above the saved part is for people.
            if told.is_empty() || saved.is_some() && SAVED_HEAD.iter().any(|it| told.contains(it)) {
                continue;
            }
            let indent = line.len() - line.trim_start().len();
            let continues = self.indent.is_some_and(|own| own < indent) && !told.starts_with('[');
            if let Some(name) = told.strip_prefix('[') {
                let name = name.strip_suffix(']').ok_or_else(|| {
                    problem(
                        place,
                        told,
                        "the section's name is not closed",
                        "write [printer]",
                    )
                })?;
                match name.strip_prefix("include ") {
                    Some(file) => self.include(file.trim(), place, depth, options, draft)?,
                    None => name.trim().clone_into(&mut self.section),
                }
                self.indent = None;
            } else if continues {
                // Macros, and values over several lines.
                if is_read(&self.section)
                    && let Some(entry) = self.entries.last_mut()
                {
                    entry.value = format!("{} {told}", entry.value).trim().to_owned();
                }
            } else if let Some((key, value)) = told.split_once([':', '=']) {
                self.indent = Some(indent);
                self.entries.push(ConfigLine {
                    line: place,
                    section: self.section.clone(),
                    key: key.trim().to_ascii_lowercase(),
                    value: value.trim().to_owned(),
                });
            } else {
                let message = "is neither a section nor `key: value`";
                let hint = "was the line cut? Klipper does not start with it";
                return Err(problem(place, told, message, hint));
            }
        }
        Ok(())
    }

    fn include(
        &mut self,
        file: &str,
        line: usize,
        depth: usize,
        options: &ImportOptions<'_>,
        draft: &mut Draft,
    ) -> Result<(), Problem> {
        if depth == DEEPEST {
            let message = format!("files include each other more than {DEEPEST} deep");
            return Err(problem(line, file, message, "does a file include itself?"));
        }
        let path = if file.starts_with('/') {
            file.to_owned()
        } else {
            format!("{}{file}", self.folder)
        };
        let found = match wildcards::parts(&path) {
            None => Ok(vec![path.clone()]),
            Some((folder, pattern)) => wildcards::matching(folder, pattern, options.files),
        };
        let files = match found {
            Ok(files) => files,
            Err(why) => {
                draft.row(
                    "[include]",
                    path,
                    Fate::Ignored,
                    format!("not read ({why})"),
                );
                return Ok(());
            }
        };
        if files.is_empty() {
            draft.row("[include]", path, Fate::Ignored, "matches no file");
        }
        for file in files {
            match options.files.text(&file) {
                Ok(text) => {
                    self.bytes = self.bytes.saturating_add(text.len());
                    if self.bytes > options.max_bytes {
                        let message =
                            format!("included files have more than {} bytes", options.max_bytes);
                        return Err(problem(line, &file, message, ""));
                    }
                    draft.row("[include]", file.as_str(), Fate::Used, "read in its place");
                    // A section goes on behind the included file.
                    let section = self.section.clone();
                    let folder = file.rfind('/').map_or("", |end| &file[..=end]).to_owned();
                    let folder = std::mem::replace(&mut self.folder, folder);
                    self.file(&text, Some(line), depth + 1, options, draft)?;
                    (self.section, self.folder) = (section, folder);
                }
                Err(why) => {
                    draft.row(
                        "[include]",
                        file,
                        Fate::Ignored,
                        format!("not read ({why})"),
                    );
                }
            }
        }
        Ok(())
    }

    /// The last of a key counts.
    fn last(&self, section: &str, key: &str) -> Option<&ConfigLine> {
        self.entries.get(*self.last.get(section)?.get(key)?)
    }

    /// Finds the last lines of all keys.
    fn index(&mut self) {
        for (index, entry) in self.entries.iter().enumerate() {
            let keys = self.last.entry(entry.section.clone()).or_default();
            keys.insert(entry.key.clone(), index);
        }
    }
}

/// Reads the file.
fn read(text: &str, options: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let mut draft = Draft::new("Klipper");
    draft.dialect = Some("klipper");
    draft.control = Some(Control::Klipper);
    draft.size = MachineSize::Printer;
    draft
        .expected
        .extend(super::XYZ.map(|axis| (axis, "machines of this control have it")));
    let mut lines = ConfigFile::default();
    lines
        .file(text, None, 0, options, &mut draft)
        .map_err(|found| vec![found])?;
    lines.index();
    let mut problems = Vec::new();
    let kinematics = lines.last("printer", "kinematics");
    if let Some(entry) = kinematics
        && !matches!(entry.value.as_str(), "cartesian" | "corexy")
    {
        problems.push(problem(
            entry.line,
            "[printer] kinematics",
            format!("`{}` is not known here", entry.value),
            nearest(&entry.value),
        ));
    }
    for entry in &lines.entries {
        let counts = lines
            .last(&entry.section, &entry.key)
            .is_some_and(|last| std::ptr::eq(last, entry));
        if !counts {
            draft.row(
                entry.name(),
                entry.value.as_str(),
                Fate::Ignored,
                "given again further on, which counts",
            );
        } else if let Err(found) = take(&mut draft, &lines, entry) {
            problems.push(found);
        }
    }
    if draft.axes.is_empty() && problems.is_empty() {
        problems.push(problem(
            1,
            "",
            "there is no [stepper_x]",
            "is it the printer's main file?",
        ));
    }
    let sections = lines.last.keys();
    let further: Vec<(AxisId, String)> = sections
        .filter_map(|section| match axis_of(section)? {
            (axis, false) => Some((axis, section.clone())),
            _ => None,
        })
        .collect();
    draft.add_motors(&further);
    if kinematics.is_some_and(|entry| entry.value == "corexy") && problems.is_empty() {
        draft.belts();
    }
    if problems.is_empty() {
        Ok(draft)
    } else {
        Err(problems)
    }
}

/// What to start from where the kinematics are not known.
fn nearest(kinematics: &str) -> &'static str {
    match kinematics {
        "delta" => "known are cartesian and corexy; start from `machine show delta`",
        "hybrid_corexy" => {
            "known are cartesian and corexy; start from `machine show corexy`, where both motors move in X and in Y"
        }
        _ => "known are cartesian and corexy; `machine list` names machines to start from",
    }
}

/// The axis of `stepper_x`; `stepper_z1` is a second motor of Z.
fn axis_of(section: &str) -> Option<(AxisId, bool)> {
    let mut name = section.strip_prefix("stepper_")?.chars();
    let axis = AxisId::from_letter(name.next()?).filter(|axis| !axis.is_rotary())?;
    Some((axis, name.next().is_none()))
}

fn take(draft: &mut Draft, lines: &ConfigFile, entry: &ConfigLine) -> Result<(), Problem> {
    let name = entry.name();
    let told = |value: f64| Told {
        value,
        from: name.clone(),
        line: entry.line,
    };
    let value = entry.value.as_str();
    let above_zero = || positive(entry.line, &name, value);
    if entry.section == "printer" {
        return printer(draft, lines, entry, &told);
    }
    // Current of a driver: `[tmc2209 stepper_x]`, effective.
    if let Some((driver, stepper)) = entry.section.split_once(' ')
        && driver.starts_with("tmc")
        && entry.key == "run_current"
        && let Some((axis, first)) = axis_of(stepper)
    {
        if !first {
            // Drivers of an axis may be of different kinds.
            let main = first_section(axis);
            let mut all = lines.entries.iter();
            let own = all.rfind(|it| {
                it.key == entry.key
                    && it.section.starts_with("tmc")
                    && it
                        .section
                        .split_once(' ')
                        .is_some_and(|(_, own)| own == main)
            });
            further(draft, entry, own);
            return Ok(());
        }
        let peak = above_zero()? * SQRT_2;
        draft.tell(axis, Quantity::PeakCurrent, told(peak), value);
        return Ok(());
    }
    let Some((axis, first)) = axis_of(&entry.section) else {
        draft.row(name.as_str(), value, Fate::Ignored, "");
        return Ok(());
    };
    if !first {
        further(draft, entry, lines.last(&first_section(axis), &entry.key));
        return Ok(());
    }
    let (quantity, amount) = match entry.key.as_str() {
        "rotation_distance" => {
            let gear = match lines.last(&entry.section, "gear_ratio") {
                Some(gear) => ratio(gear)?,
                None => 1.0,
            };
            (Quantity::PerTurn, above_zero()? / gear)
        }
        "microsteps" => (Quantity::Microsteps, above_zero()?),
        "full_steps_per_rotation" => (Quantity::FullSteps, above_zero()?),
        "position_max" => {
            // Where Klipper's own default holds it is told as that.
            if lines.last(&entry.section, "position_min").is_none() {
                let zero = Told {
                    from: format!("[{}] position_min: 0 if left out", entry.section),
                    ..told(0.0)
                };
                draft.tell(axis, Quantity::Min, zero, "0");
            }
            (Quantity::Max, number(entry.line, &name, value)?)
        }
        "position_min" => (Quantity::Min, number(entry.line, &name, value)?),
        "gear_ratio" => {
            draft.row(
                name.as_str(),
                value,
                Fate::Used,
                "within the travel of a turn of the motor",
            );
            return Ok(());
        }
        "step_distance" => {
            let hint = "write rotation_distance, which Klipper has asked for since 2021";
            return Err(problem(entry.line, &name, "is not read", hint));
        }
        _ => {
            draft.row(name.as_str(), value, Fate::Ignored, "");
            return Ok(());
        }
    };
    draft.tell(axis, quantity, told(amount), value);
    Ok(())
}

/// The section of an axis' first motor.
fn first_section(axis: AxisId) -> String {
    format!("stepper_{}", axis.letter().to_ascii_lowercase())
}

/// Reports a line of a further motor, and where the first has another value.
fn further(draft: &mut Draft, entry: &ConfigLine, first: Option<&ConfigLine>) {
    let of_motion = [
        "rotation_distance",
        "gear_ratio",
        "full_steps_per_rotation",
        "microsteps",
        "run_current",
    ];
    let first = first.map(|first| (first.name(), first.value.as_str()));
    let note = if of_motion.contains(&entry.key.as_str()) {
        unlike_first(
            first.as_ref().map(|(name, value)| (name.as_str(), *value)),
            &entry.value,
        )
    } else {
        LIKE_FIRST.to_owned()
    };
    draft.row(entry.name(), entry.value.as_str(), Fate::Ignored, note);
}

/// Limits that hold for X and Y, and those of Z.
fn printer(
    draft: &mut Draft,
    lines: &ConfigFile,
    entry: &ConfigLine,
    told: &dyn Fn(f64) -> Told,
) -> Result<(), Problem> {
    let name = entry.name();
    let value = entry.value.as_str();
    let (quantity, of_z) = match entry.key.as_str() {
        "max_velocity" => (Quantity::Velocity, "max_z_velocity"),
        "max_accel" => (Quantity::Acceleration, "max_z_accel"),
        "max_z_velocity" => (Quantity::Velocity, ""),
        "max_z_accel" => (Quantity::Acceleration, ""),
        "kinematics" => {
            draft.row(name, value, Fate::Used, "general");
            return Ok(());
        }
        "square_corner_velocity" | "minimum_cruise_ratio" | "max_accel_to_decel" => {
            let note = "how fast corners are taken: no tolerance of the path";
            draft.row(name, value, Fate::Ignored, note);
            return Ok(());
        }
        _ => {
            draft.row(name, value, Fate::Ignored, "");
            return Ok(());
        }
    };
    let amount = positive(entry.line, &name, value)?;
    // Z has the limits of all axes where it has none of its own.
    let axes: &[AxisId] = match of_z {
        "" => &[AxisId::Z],
        own if lines.last("printer", own).is_some() => &[AxisId::X, AxisId::Y],
        _ => &[AxisId::X, AxisId::Y, AxisId::Z],
    };
    for axis in axes {
        draft.tell(*axis, quantity, told(amount), value);
    }
    Ok(())
}

/// `80:20, 5:1`: turns of the motor for one of what it drives.
fn ratio(entry: &ConfigLine) -> Result<f64, Problem> {
    let bad = || {
        let message = format!("`{}` is no ratio", entry.value);
        problem(entry.line, &entry.name(), message, "write 80:20")
    };
    let mut whole = 1.0;
    for pair in entry.value.split(',') {
        let (driven, driving) = pair.split_once(':').ok_or_else(bad)?;
        let [driven, driving] = [driven, driving].map(|text| text.trim().parse::<f64>());
        match (driven, driving) {
            (Ok(a), Ok(b)) if a > 0.0 && b > 0.0 && (a / b).is_finite() => whole *= a / b,
            _ => return Err(bad()),
        }
    }
    Ok(whole)
}
