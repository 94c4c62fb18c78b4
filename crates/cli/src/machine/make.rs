//! `lostmotion machine import` and `machine new`: machine files from other programs' descriptions,
//! and from a preset.

use crate::input;
use crate::options::machine::{failure, machine_names};
use crate::options::{Names, number};
use crate::output::{self, Failure, is_standard, write_text};
use clap::{Args, ValueHint};
use lostmotion::base::AxisId;
use lostmotion::report::text::{Align, Table};
use lostmotion::sim::Machine;
use lostmotion::sim::import::{ImportFormat, Row, import as imported};
use lostmotion::sim::machine::presets;
use std::path::PathBuf;

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
    /// gaps, jerk
    #[arg(long, value_name = "NAME", default_value = "vmc3", value_parser = machine_names())]
    preset: String,
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
    let machine = imported(&name, &text, format, &args.preset).map_err(|error| failure(&error))?;
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

fn report(rows: &[Row]) -> String {
    let mut table = Table::new(&[
        ("key", Align::Left),
        ("value", Align::Left),
        ("", Align::Left),
        ("", Align::Left),
    ]);
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
    /// Travel of an axis in machine coordinates, mm or deg, for example x=-500,0; may be repeated
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
    let mut draft = Draft::new(preset.toml);
    let known = |letter: char| {
        let axis = AxisId::from_letter(letter).and_then(|id| like.axis(id));
        axis.ok_or_else(|| {
            Failure::with_hint(
                format!("preset {} has no axis {letter}", preset.name),
                format!("its axes: {}", like.drives().join(", ")),
            )
        })
    };
    // All letters are checked before anything is changed.
    for letter in &args.axes {
        known(*letter)?;
    }
    if !args.axes.is_empty() {
        for axis in like.axes() {
            let letter = axis.id.letter().to_ascii_lowercase();
            if !args.axes.contains(&letter) {
                draft.remove_axis(letter);
            }
        }
    }
    // The `{:?}` form of text is quoted and escaped, as TOML wants it; that of numbers keeps their
    // point.
    draft.set("", "name", &format!("{:?}", args.name));
    let described = format!("as {}, with what was given", preset.name);
    draft.set("", "description", &format!("{described:?}"));
    if let Some(um) = args.tolerance_um {
        draft.set("simulate", "tolerance_um", &format!("{um:?}"));
    }
    // A value without a letter is in mm: it cannot mean the rotary axes.
    let linear: Vec<char> = like
        .axes()
        .iter()
        .filter(|axis| !axis.is_rotary())
        .map(|axis| axis.id.letter().to_ascii_lowercase())
        .filter(|letter| args.axes.is_empty() || args.axes.contains(letter))
        .collect();
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
        for (letter, value) in values(option, given, &linear)? {
            let key = if known(letter)?.is_rotary() { deg } else { mm };
            draft.set(&format!("axis.{letter}.limits"), key, &format!("{value:?}"));
        }
    }
    for (letter, value) in values("--gap", &args.gap, &linear)? {
        known(letter)?;
        draft.set_gap(letter, value);
    }
    for option in &args.travel {
        let (letter, [min, max]) = travel(option)?;
        let unit = if known(letter)?.is_rotary() {
            "deg"
        } else {
            "mm"
        };
        let limits = format!("axis.{letter}.limits");
        draft.set(&limits, &format!("min_{unit}"), &format!("{min:?}"));
        draft.set(&limits, &format!("max_{unit}"), &format!("{max:?}"));
        // Part zero (G54) goes to the middle; the places that the machine goes to by itself are
        // moved into the travel. Ends in the wrong order are left for the check below to refuse:
        // `clamp` would panic on them.
        let coordinate = format!("{letter}_{unit}");
        draft.set(
            "work_offset.g54",
            &coordinate,
            &format!("{:?}", 0.5 * (min + max)),
        );
        for home in ["home.g28", "home.g30"] {
            draft.set(
                home,
                &coordinate,
                &format!("{:?}", 0.0_f64.clamp(min, max.max(min))),
            );
        }
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

/// What `x=500` or `500` means: a value for an axis, or for each of all.
fn values(option: &str, given: &[String], all: &[char]) -> Result<Vec<(char, f64)>, Failure> {
    let mut found = Vec::new();
    for text in given {
        let (axes, number) = match text.split_once('=') {
            Some((axis, number)) => (letter(option, text, axis).map(|axis| vec![axis])?, number),
            None => (all.to_vec(), text.as_str()),
        };
        let value = number.trim().parse::<f64>().map_err(|_| {
            Failure::with_hint(
                format!("{option} {text}: `{number}` is not a number"),
                format!("for example: {option} x=25"),
            )
        })?;
        found.extend(axes.into_iter().map(|axis| (axis, value)));
    }
    Ok(found)
}

/// The axis letter in `x=500`.
fn letter(option: &str, given: &str, axis: &str) -> Result<char, Failure> {
    let mut letters = axis.trim().chars();
    match (letters.next(), letters.next()) {
        (Some(letter), None) => Ok(letter.to_ascii_lowercase()),
        _ => Err(Failure::with_hint(
            format!("{option} {given}: `{axis}` is not the letter of an axis"),
            format!("for example: {option} x=25"),
        )),
    }
}

/// Axis and ends of `x=-500,0`.
fn travel(option: &str) -> Result<(char, [f64; 2]), Failure> {
    let wrong = || {
        Failure::with_hint(
            format!("--travel {option} is not of the form AXIS=MIN,MAX"),
            "for example: --travel x=-500,0",
        )
    };
    let (axis, ends) = option.split_once('=').ok_or_else(wrong)?;
    let (min, max) = ends.split_once(',').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| wrong());
    Ok((
        letter("--travel", option, axis)?,
        [number(min)?, number(max)?],
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

    /// The gap of an axis, under the key that its load has. The second end of a gantry keeps its
    /// own, `second_gap_um`.
    fn set_gap(&mut self, axis: char, value: f64) {
        let below = format!("axis.{axis}.load");
        // The load's table is named by its kind (slide, table, joint); the one with a gap is looked
        // for.
        let load = self
            .tables
            .iter()
            .find(|table| {
                table.name.starts_with(&below)
                    && table
                        .lines
                        .iter()
                        .any(|line| key_of(line).starts_with("gap_"))
            })
            .map(|table| (table.name.clone(), table.lines.clone()));
        // An axis whose file gives no gap is taken for a slide.
        let (table, lines) = load.unwrap_or_else(|| (format!("{below}.slide"), Vec::new()));
        let key = lines
            .iter()
            .map(|line| key_of(line))
            .find(|key| key.starts_with("gap_"));
        let key = key.unwrap_or("gap_um").to_owned();
        let value = match key.as_str() {
            // Given in arc seconds; 3.6 of them are a millidegree.
            "gap_mdeg" => value / 3.6,
            "gap_deg" => value / 3600.0,
            _ => value,
        };
        self.set(&table, &key, &format!("{value:?}"));
    }

    /// Takes an axis and its coordinates away.
    fn remove_axis(&mut self, axis: char) {
        let below = format!("axis.{axis}.");
        self.tables.retain(|table| !table.name.starts_with(&below));
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
