//! `lostmotion machine import` and `machine new`: machine files from other programs' descriptions,
//! and from a preset.

use crate::input;
use crate::options::machine::{failure, machine_names};
use crate::options::{Names, number};
use crate::output::{self, Failure, is_standard, write_text};
use clap::{Args, ValueHint};
use lostmotion::base::AxisId;
use lostmotion::report::text::{Align, Table};
use lostmotion::sim::files;
use lostmotion::sim::import::{
    FileSource, ImportFormat, ImportOptions, MAX_BYTES, Row, import as imported,
};
use lostmotion::sim::machine::presets;
use lostmotion::sim::{Machine, machine::MachineAxis};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// `machine import`.
#[derive(Debug, Args)]
pub(crate) struct Import {
    /// The description
    #[arg(value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// Format of the description; recognised if left out
    #[arg(long, value_name = "FORMAT", value_parser = formats())]
    from: Option<String>,
    /// Machine from which everything is taken that the description does not say: drives, loads,
    /// gaps, jerk; if left out vmc3, and axes that steppers move get a stepper's drive, open loop
    #[arg(long, value_name = "NAME", value_parser = machine_names())]
    preset: Option<String>,
    /// Longest description that is read, with all files that it names, bytes
    #[arg(long, value_name = "N", default_value_t = MAX_BYTES)]
    max_bytes: usize,
    /// Link that holds the tool, of a URDF tree that ends in several
    #[arg(long, value_name = "LINK")]
    tip: Option<String>,
    /// Write the machine file here, and the report of every key to stdout; without it the file goes
    /// to stdout and the report to stderr
    #[arg(long, short, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,
}

/// Names of formats.
fn formats() -> Names {
    Names::new("format", ImportFormat::NAMES.map(|(name, _)| (name, "")))
}

/// Turns a description into a machine file and reports what became of every key.
pub(super) fn import(args: &Import, quiet: bool) -> Result<(), Failure> {
    let text = input::text(&args.file, "machine description")?;
    let name = args.file.display().to_string();
    if let Some(out) = &args.out {
        output::refuse_input(out, &args.file, "machine description")?;
    }
    // The user's word goes before what the text looks like.
    let format = match &args.from {
        Some(from) => ImportFormat::NAMES
            .iter()
            .find(|(name, _)| name == from)
            .map(|(_, format)| *format),
        None => ImportFormat::recognise(&name, &text),
    };
    let format = format.ok_or_else(|| {
        let known = ImportFormat::NAMES.map(|(name, _)| name).join(", ");
        Failure::with_hint(
            format!("{name}: the format is not recognised"),
            format!("name it with --from: {known}"),
        )
    })?;
    let beside = Beside {
        file: &args.file,
        named: RefCell::default(),
    };
    let options = ImportOptions {
        preset: args.preset.as_deref(),
        max_bytes: args.max_bytes,
        tip: args.tip.as_deref(),
        files: &beside,
    };
    let machine = imported(&name, &text, format, &options).map_err(|error| failure(&error))?;
    if let Some(out) = &args.out {
        let named = beside.named.borrow();
        let what = "file that the description names";
        output::refuse_inputs(out, named.iter().map(|path| (path.as_path(), what)))?;
    }
    let report = report(&machine.rows);
    // Without a file the answer is the machine file itself, and stdout may hold nothing else.
    match args.out.as_ref().filter(|path| !is_standard(path)) {
        Some(path) => {
            write_text(path, &machine.toml)?;
            output::print(&report)
        }
        None => {
            output::print(&machine.toml)?;
            if !quiet {
                output::remark(&report);
            }
            Ok(())
        }
    }
}

/// Files that a description names: in its own folder, or below the user's where the name begins with `~`.
struct Beside<'a> {
    /// The description.
    file: &'a Path,
    /// What it names, in the order in which it was asked for: nothing may be written over it.
    named: RefCell<Vec<PathBuf>>,
}

impl Beside<'_> {
    fn path(&self, name: &str) -> Result<PathBuf, String> {
        if is_standard(self.file) {
            return Err("it would be beside a file, and this is stdin".to_owned());
        }
        Ok(match name.strip_prefix("~/") {
            Some(rest) => {
                let home = std::env::var_os("HOME").ok_or("there is no home folder")?;
                PathBuf::from(home).join(rest)
            }
            None => self.file.parent().unwrap_or(Path::new("")).join(name),
        })
    }
}

impl FileSource for Beside<'_> {
    fn text(&self, name: &str) -> Result<String, String> {
        let path = self.path(name)?;
        self.named.borrow_mut().push(path.clone());
        input::text(&path, "file").map_err(|failure| {
            let text = failure.text();
            let message = text.lines().next().unwrap_or_default();
            message.trim_start_matches("error: ").to_owned()
        })
    }

    fn names(&self, folder: &str) -> Result<Vec<String>, String> {
        files::names(&self.path(folder)?).map_err(|error| error.to_string())
    }
}

fn report(rows: &[Row]) -> String {
    let mut table = Table::new(&[
        ("key", Align::Left),
        ("value", Align::Left),
        ("", Align::Left),
        ("", Align::Left),
    ])
    .folded();
    for row in rows {
        table.row([
            row.key.as_str().into(),
            row.value.as_str().into(),
            row.fate.name().into(),
            row.note.as_str().into(),
        ]);
    }
    table.render_within(output::stdout_columns())
}

/// `machine new`.
#[derive(Debug, Args)]
pub(crate) struct New {
    /// Name of the machine
    #[arg(value_name = "NAME")]
    name: String,
    /// Machine that the new one is like: kinematics, drives, loads and whatever is not given
    #[arg(long, value_name = "NAME", default_value = "vmc3", value_parser = machine_names())]
    preset: String,
    /// Axes that the machine has, of those of the preset, for example x,z; all, if left out
    #[arg(long, value_name = "AXES", value_delimiter = ',')]
    axes: Vec<char>,
    /// Travel of an axis in machine coordinates, mm or deg, for example x=-500,0; part zero (G54)
    /// goes to its middle; may be repeated
    #[arg(long, value_name = "AXIS=MIN,MAX", allow_hyphen_values = true)]
    travel: Vec<String>,
    /// Gap of an axis, um or arc seconds, for example x=25, or one value for all linear axes; may
    /// be repeated
    #[arg(long, value_name = "[AXIS=]N", allow_hyphen_values = true)]
    gap: Vec<String>,
    /// Largest velocity of an axis, mm/s or deg/s, for example x=500, or one value for all linear
    /// axes; may be repeated
    #[arg(long, value_name = "[AXIS=]N", allow_hyphen_values = true)]
    velocity: Vec<String>,
    /// Largest acceleration, mm/s2 or deg/s2, given like --velocity; may be repeated
    #[arg(long, value_name = "[AXIS=]N", allow_hyphen_values = true)]
    acceleration: Vec<String>,
    /// Largest jerk, mm/s3 or deg/s3, given like --velocity; may be repeated
    #[arg(long, value_name = "[AXIS=]N", allow_hyphen_values = true)]
    jerk: Vec<String>,
    /// Tolerance of the contour error, um
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    tolerance_um: Option<f64>,
    /// File to write; stdout, if left out or `-`
    #[arg(long, short, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,
}

/// Writes a machine file with the comments of its preset and what was given; it is checked before.
pub(super) fn new(args: &New) -> Result<(), Failure> {
    let preset = presets().iter().find(|preset| preset.name == args.preset);
    let (Some(preset), Ok(like)) = (preset, Machine::preset(&args.preset)) else {
        return Err(machine_names().refusal(&args.preset));
    };
    let axes = Axes::new(args, &like)?;
    let mut draft = Draft::new(preset.toml);
    for letter in axes.left_out() {
        draft.remove_axis(letter);
    }
    // Without the axis that two motors drive there is no beam.
    if like.gantry().is_some_and(|gantry| !axes.keeps(gantry.axis)) {
        draft.remove_tables("gantry");
    }
    // A name is told in messages and tables, a line each.
    if args.name.chars().any(char::is_control) {
        return Err(Failure::with_hint(
            format!("the name is {:?}; it has to be one line of text", args.name),
            "leave out line ends, tabs and other control characters",
        ));
    }
    draft.set("", "name", &quoted(&args.name));
    let described = format!("as {}, with what was given", preset.name);
    draft.set("", "description", &quoted(&described));
    // The `{:?}` form of numbers keeps their point, which TOML wants.
    if let Some(um) = args.tolerance_um {
        let um = finite("--tolerance-um", um)?;
        draft.set("simulate", "tolerance_um", &format!("{um:?}"));
    }
    // The unit is in the key: one option means mm on a slide and degrees on a turntable.
    for (option, given, mm, deg) in [
        (
            "--velocity",
            &args.velocity,
            "velocity_mm_s",
            "velocity_deg_s",
        ),
        (
            "--acceleration",
            &args.acceleration,
            "acceleration_mm_s2",
            "acceleration_deg_s2",
        ),
        ("--jerk", &args.jerk, "jerk_mm_s3", "jerk_deg_s3"),
    ] {
        for (axis, value) in axes.values(option, given)? {
            let key = if axis.is_rotary() { deg } else { mm };
            let limits = format!("axis.{}.limits", lower(axis.id));
            draft.set(&limits, key, &format!("{value:?}"));
        }
    }
    for (axis, value) in axes.values("--gap", &args.gap)? {
        draft.set_gap(lower(axis.id), value);
        // Both ends of a beam, which may have a gap each.
        if like.gantry().is_some_and(|gantry| gantry.axis == axis.id) {
            draft.set("gantry", "second_gap_um", &format!("{value:?}"));
        }
    }
    for option in &args.travel {
        let (axis, ends) = axes.travel(option)?;
        draft.set_travel(axis, ends, moves_alone(&like, axis.id));
    }
    let head = format!(
        "# Made by `lostmotion machine new` like the preset {}. Lines that end in `# given` are what was\n# asked for; everything else is the preset's, with its comments.\n\n",
        preset.name
    );
    // Checked as a whole before it is written: a file made here is one that runs.
    let text = head + &draft.text();
    let name = args.out.as_ref().map_or_else(
        || format!("{}.toml", args.name),
        |path| path.display().to_string(),
    );
    Machine::check_toml(&name, &text).map_err(|error| failure(&error))?;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("-"));
    write_text(&out, &text)
}

/// A text without control characters as TOML has it.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The letter of an axis as keys have it.
fn lower(axis: AxisId) -> char {
    axis.letter().to_ascii_lowercase()
}

/// Whether a program's word for an axis is the place of the joint of that letter: not on a machine
/// whose joints are towers, belts or an arm.
fn moves_alone(machine: &Machine, axis: AxisId) -> bool {
    let Ok(kinematics) = machine.build_kinematics() else {
        return false;
    };
    // The start is within reach of a checked machine. Seen from two places, so that a joint that
    // happens to stand where the word says is not taken for it.
    let is_same = |step: f64| {
        let mut at = machine.start();
        at[axis] += step;
        let joints = kinematics.inverse(&at, &[0.0; 3]);
        joints.is_ok_and(|joints| (joints[axis] - at[axis]).abs() < 1e-9)
    };
    is_same(0.0) && is_same(0.01)
}

/// Axes of a preset, and which of them the new machine keeps.
struct Axes<'a> {
    preset: &'a str,
    like: &'a Machine,
    /// All, if empty.
    kept: Vec<AxisId>,
}

impl<'a> Axes<'a> {
    fn new(args: &'a New, like: &'a Machine) -> Result<Axes<'a>, Failure> {
        let mut axes = Axes {
            preset: &args.preset,
            like,
            kept: Vec::new(),
        };
        // All letters are checked before anything is changed.
        for letter in &args.axes {
            let id = axes.known(*letter)?.id;
            axes.kept.push(id);
        }
        Ok(axes)
    }

    fn keeps(&self, axis: AxisId) -> bool {
        self.kept.is_empty() || self.kept.contains(&axis)
    }

    /// Letters of the axes that the new machine does not have.
    fn left_out(&self) -> impl Iterator<Item = char> {
        let axes = self.like.axes().iter();
        axes.filter(|axis| !self.keeps(axis.id))
            .map(|axis| lower(axis.id))
    }

    /// The preset's axis of a letter in either case.
    fn known(&self, letter: char) -> Result<&'a MachineAxis, Failure> {
        let axis = AxisId::from_letter(letter).and_then(|id| self.like.axis(id));
        axis.ok_or_else(|| {
            Failure::with_hint(
                format!("preset {} has no axis {letter}", self.preset),
                format!("its axes: {}", self.like.drives().join(", ")),
            )
        })
    }

    /// The axis that an option names, which has to be one that is kept.
    fn named(&self, option: &str, given: &str, name: &str) -> Result<&'a MachineAxis, Failure> {
        let mut letters = name.trim().chars();
        let (Some(letter), None) = (letters.next(), letters.next()) else {
            let example = if option == "--travel" { "-500,0" } else { "25" };
            return Err(Failure::with_hint(
                format!("{option} {given}: `{name}` is not the letter of an axis"),
                format!("for example: {option} x={example}"),
            ));
        };
        let axis = self.known(letter)?;
        if self.keeps(axis.id) {
            return Ok(axis);
        }
        Err(Failure::with_hint(
            format!("{option} {given}: --axes leaves axis {letter} out"),
            "name it in --axes, too, or leave the option out",
        ))
    }

    /// What `x=500` or `500` means: a value for an axis, or for each linear one. A value without a
    /// letter is in mm: it cannot mean the rotary axes.
    fn values(
        &self,
        option: &str,
        given: &[String],
    ) -> Result<Vec<(&'a MachineAxis, f64)>, Failure> {
        let mut found = Vec::new();
        for text in given {
            let (axes, number) = match text.split_once('=') {
                Some((axis, number)) => (vec![self.named(option, text, axis)?], number),
                None => {
                    let axes = self.like.axes().iter();
                    let linear = axes.filter(|axis| !axis.is_rotary() && self.keeps(axis.id));
                    (linear.collect(), text.as_str())
                }
            };
            let value = number.trim().parse().map_err(|_| {
                Failure::with_hint(
                    format!("{option} {text}: `{number}` is not a number"),
                    format!("for example: {option} x=25"),
                )
            })?;
            let value = finite(&format!("{option} {text}"), value)?;
            found.extend(axes.into_iter().map(|axis| (axis, value)));
        }
        Ok(found)
    }

    /// Axis and ends of `x=-500,0`.
    fn travel(&self, option: &str) -> Result<(&'a MachineAxis, [f64; 2]), Failure> {
        let wrong = || {
            Failure::with_hint(
                format!("--travel {option} is not of the form AXIS=MIN,MAX"),
                "for example: --travel x=-500,0",
            )
        };
        let (axis, ends) = option.split_once('=').ok_or_else(wrong)?;
        let (min, max) = ends.split_once(',').ok_or_else(wrong)?;
        let number = |text: &str| {
            let value = text.trim().parse().map_err(|_| wrong())?;
            finite(&format!("--travel {option}"), value)
        };
        Ok((
            self.named("--travel", option, axis)?,
            [number(min)?, number(max)?],
        ))
    }
}

/// Refuses a value that a machine file cannot have: not a number, or without end.
fn finite(place: &str, value: f64) -> Result<f64, Failure> {
    if value.is_finite() {
        // Without the sign of a zero, which would go into the file.
        return Ok(value + 0.0);
    }
    Err(Failure::with_hint(
        format!("{place}: the value is {value}; it has to be a finite number"),
        "leave the option out to keep the preset's value",
    ))
}

/// A machine file that is changed line by line, so that its comments stay.
struct Draft {
    /// Each table with the comments before its header; the first is the top of the file.
    tables: Vec<DraftTable>,
}

/// A table of a [`Draft`].
struct DraftTable {
    name: String,
    lines: Vec<String>,
}

impl DraftTable {
    /// The value of a key, if it stands there as a number.
    fn number(&self, key: &str) -> Option<f64> {
        let line = self.lines.iter().find(|line| key_of(line) == key)?;
        let (_, value) = line.split_once('=')?;
        value.split('#').next()?.trim().parse().ok()
    }
}

impl Draft {
    fn new(text: &str) -> Draft {
        let mut tables = vec![DraftTable {
            name: String::new(),
            lines: Vec::new(),
        }];
        // Comments stand before what they are about: they go with the next header or key.
        let mut pending = Vec::new();
        for line in text.lines() {
            let trimmed = line.trim();
            if trimmed.is_empty() || trimmed.starts_with('#') {
                pending.push(line.to_owned());
                continue;
            }
            // `[table]` and `[[list]]` alike; a comment behind the bracket is no part of the name.
            if let Some(name) = trimmed
                .strip_prefix('[')
                .and_then(|rest| rest.split(']').next())
            {
                tables.push(DraftTable {
                    name: name.trim_start_matches('[').to_owned(),
                    lines: Vec::new(),
                });
            }
            if let Some(table) = tables.last_mut() {
                table.lines.append(&mut pending);
                table.lines.push(line.to_owned());
            }
        }
        Draft { tables }
    }

    /// Puts a key into a table; both are made if they are missing.
    fn set(&mut self, table: &str, key: &str, value: &str) {
        let line = format!("{key} = {value}  # given");
        // In place where the key stands, so that the comment above it stays true to its line.
        let index = self.tables.iter().position(|known| known.name == table);
        let Some(found) = index.and_then(|index| self.tables.get_mut(index)) else {
            self.tables.push(DraftTable {
                name: table.to_owned(),
                lines: vec![String::new(), format!("[{table}]"), line],
            });
            return;
        };
        match found.lines.iter_mut().find(|line| key_of(line) == key) {
            Some(stands) => *stands = line,
            None => found.lines.push(line),
        }
    }

    /// The gap of an axis, under the key that its load has.
    fn set_gap(&mut self, axis: char, value: f64) {
        let below = format!("axis.{axis}.load.");
        // The load's table is named by its kind (slide, table, joint); the one with a gap is looked
        // for.
        let gap = self.tables.iter().find_map(|table| {
            let keys = table.lines.iter().map(|line| key_of(line));
            let key = keys.into_iter().find(|key| key.starts_with("gap_"))?;
            let found = table.name.starts_with(&below);
            found.then(|| (table.name.clone(), key.to_owned()))
        });
        // An axis whose file gives no gap is taken for a slide.
        let (table, key) = gap.unwrap_or_else(|| (format!("{below}slide"), "gap_um".to_owned()));
        // Given in arc seconds, where it is an angle; 3.6 of them are a millidegree.
        let value = if key == "gap_mdeg" {
            value / 3.6
        } else {
            value
        };
        self.set(&table, &key, &format!("{value:?}"));
    }

    /// The travel of an axis. Where the axis' word in a program is its joint's place, part zero
    /// (G54) goes to the middle, other work offsets that would lie outside, too, and the places
    /// that the machine goes to by itself are moved into the travel.
    fn set_travel(&mut self, axis: &MachineAxis, [min, max]: [f64; 2], moves_alone: bool) {
        let letter = lower(axis.id);
        let unit = if axis.is_rotary() { "deg" } else { "mm" };
        let limits = format!("axis.{letter}.limits");
        self.set(&limits, &format!("min_{unit}"), &format!("{min:?}"));
        self.set(&limits, &format!("max_{unit}"), &format!("{max:?}"));
        // Ends in the wrong order are left for the check of the whole file to refuse: there is no
        // place between them.
        if !moves_alone || min >= max {
            return;
        }
        let key = format!("{letter}_{unit}");
        let middle = 0.5 * (min + max);
        self.set("work_offset.g54", &key, &format!("{middle:?}"));
        // The homes are there whether the file has their tables or not.
        let homes = ["home.g28", "home.g30"].map(str::to_owned);
        let others = self.tables.iter().map(|table| table.name.clone());
        let others = others.filter(|name| name.starts_with("work_offset.") || name == "start");
        for name in others.chain(homes).collect::<Vec<_>>() {
            let table = self.tables.iter().find(|table| table.name == name);
            // A coordinate that is left out is 0.
            let at = table.and_then(|table| table.number(&key));
            let at = at.unwrap_or_default();
            if (min..=max).contains(&at) {
                continue;
            }
            let to = if name.starts_with("work_offset.") {
                middle
            } else {
                at.clamp(min, max)
            };
            self.set(&name, &key, &format!("{to:?}"));
        }
    }

    /// Takes a table and all below it away.
    fn remove_tables(&mut self, name: &str) {
        let below = format!("{name}.");
        self.tables
            .retain(|table| table.name != name && !table.name.starts_with(&below));
    }

    /// Takes an axis and its coordinates away.
    fn remove_axis(&mut self, axis: char) {
        self.remove_tables(&format!("axis.{axis}"));
        let coordinates = [format!("{axis}_mm"), format!("{axis}_deg")];
        for table in &mut self.tables {
            // Positions name axes by their letters, and an axis that is gone must not be named.
            let is_position = ["work_offset.", "home.", "start"]
                .iter()
                .any(|name| table.name.starts_with(name));
            if is_position {
                table
                    .lines
                    .retain(|line| !coordinates.iter().any(|key| key_of(line) == key));
            }
        }
    }

    fn text(&self) -> String {
        let lines = self.tables.iter().flat_map(|table| &table.lines);
        lines.map(|line| format!("{line}\n")).collect()
    }
}

/// The key of a line, empty for a comment or a header.
fn key_of(line: &str) -> &str {
    let key = line.split_once('=').map_or("", |(key, _)| key.trim());
    if key.starts_with(['#', '[']) { "" } else { key }
}
