//! Machines and axes by name or file, and what options change about them.

use super::{Names, number};
use crate::fits;
use crate::input;
use crate::output::Failure;
use clap::Args;
use lostmotion::base::AxisId;
use lostmotion::base::names::did_you_mean;
use lostmotion::drive::config::{Cycles as CyclesConfig, Interpolator};
use lostmotion::gcode::ToolTable;
use lostmotion::methods::AxisConfig;
use lostmotion::sim::Machine;
use lostmotion::sim::machine::{
    AxisTuning, Change, DEFAULT_MACHINE, MachineError, WorkOffsets, axis_from_changed_toml,
    axis_preset_toml, axis_presets, presets,
};
use std::path::{Path, PathBuf};

/// The machine and what is changed about it.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Machine")]
pub(crate) struct MachineOptions {
    /// Machine: a name from `machine list`, or a machine file
    #[arg(long, short, value_name = "NAME|FILE.toml", value_hint = clap::ValueHint::FilePath)]
    pub(crate) machine: Option<String>,
    /// Tool table in LinuxCNC's format (.tbl), in place of the machine's tools; lengths in the
    /// control's units, millimetres unless `control_units` of the machine says inch
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    pub(crate) tool_table: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) changes: Changes,
}

/// Values in place of those of a machine file.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Machine")]
pub(crate) struct Changes {
    /// Origin of a work coordinate system in machine coordinates, X,Y,Z,A,B,C in mm and deg, for
    /// example g54=220,85,-150 or g54=x220,c90; may be repeated
    #[arg(long, value_name = "SYSTEM=X,Y,Z", allow_hyphen_values = true)]
    pub(crate) offset: Vec<String>,
    /// Any key of the machine file, for example axis.x.drive.position_gain_per_s=30 (`machine keys`
    /// lists them), or a value that the program reads and only the machine knows, for example
    /// '#3011=20260101' or '#<_hal[spindle.load]>=1.5'; may be repeated
    #[arg(long, value_name = "KEY=VALUE", allow_hyphen_values = true)]
    pub(crate) set: Vec<String>,
}

impl MachineOptions {
    /// The machine asked for, or the default one.
    pub(crate) fn load(&self) -> Result<Machine, Failure> {
        load(self.machine.as_deref(), &self.changes.of_machine()?)
    }

    /// The machine asked for, if one is named.
    ///
    /// # Errors
    /// Changes without a machine.
    pub(crate) fn named(&self) -> Result<Option<Machine>, Failure> {
        if self.machine.is_some() {
            return self.load().map(Some);
        }
        match self.changes.of_machine()?.first() {
            None => Ok(None),
            Some(change) => Err(Failure::with_hint(
                format!("{} needs a machine to change", change.name),
                format!("name one, for example -m {DEFAULT_MACHINE}"),
            )),
        }
    }

    /// The files that are read, which no output may replace.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = (&Path, &'static str)> {
        let machine = self.machine.as_deref().map(Path::new);
        let tools = self.tool_table.as_deref();
        let machine = machine.map(|path| (path, "machine file"));
        machine
            .into_iter()
            .chain(tools.map(|path| (path, "tool table")))
    }

    /// The tool table of the file asked for.
    pub(crate) fn tools(&self) -> Result<Option<ToolTable>, Failure> {
        self.tool_table.as_deref().map(tool_table).transpose()
    }
}

/// The tool table of a file.
fn tool_table(path: &Path) -> Result<ToolTable, Failure> {
    let text = input::text(path, "tool table")?;
    ToolTable::parse(&text)
        .map_err(|problem| Failure::message(format!("{}: {problem}", path.display())))
}

/// The parameter that a key of `--set` names: `#3011` or `#<_hal[name]>`, the name in lower case
/// without blanks as programs have it; `None` for a key of the machine.
fn parameter(key: &str) -> Option<String> {
    let name = key.trim().strip_prefix('#')?.trim();
    let name = name
        .strip_prefix('<')
        .and_then(|name| name.strip_suffix('>'))
        .unwrap_or(name);
    let mut name = name.to_ascii_lowercase();
    name.retain(|letter| !letter.is_whitespace());
    Some(name)
}

impl Changes {
    /// Those that are keys of the machine.
    fn of_machine(&self) -> Result<Vec<Change>, Failure> {
        let mut changes = self.read()?;
        changes.retain(|change| parameter(&change.key).is_none());
        Ok(changes)
    }

    /// Values of parameters and system variables that the program is told.
    pub(crate) fn told(&self) -> Result<Vec<(String, f64)>, Failure> {
        let mut told = Vec::new();
        for change in set_changes(&self.set)? {
            let Some(name) = parameter(&change.key) else {
                continue;
            };
            let value = change.value.parse::<f64>().ok();
            let value = value.filter(|value| value.is_finite()).ok_or_else(|| {
                Failure::with_hint(
                    format!("{}: `{}` is not a finite number", change.name, change.value),
                    "for example: --set '#3011=20260101'",
                )
            })?;
            if name.is_empty() {
                return Err(Failure::with_hint(
                    format!("{}: the parameter has no number or name", change.name),
                    "for example: --set '#3011=20260101' or --set '#<_hal[name]>=1.5'",
                ));
            }
            told.push((name, value));
        }
        Ok(told)
    }

    /// As the machine's reader takes them.
    ///
    /// # Errors
    /// An option that is not understood.
    pub(crate) fn read(&self) -> Result<Vec<Change>, Failure> {
        // Of two changes of one key the later one holds: --set goes over --offset.
        let mut changes = Vec::new();
        for option in &self.offset {
            changes.extend(offset(option)?);
        }
        changes.extend(set_changes(&self.set)?);
        Ok(changes)
    }
}

/// Changes as `--set` gives them.
pub(crate) fn set_changes(options: &[String]) -> Result<Vec<Change>, Failure> {
    let change = |option: &String| {
        let (key, value) = option.split_once('=').ok_or_else(|| {
            Failure::with_hint(
                format!("--set {option} is not of the form KEY=VALUE"),
                "for example: --set axis.x.drive.position_gain_per_s=30",
            )
        })?;
        Ok(Change {
            key: key.trim().to_owned(),
            value: value.trim().to_owned(),
            name: format!("--set {option}"),
        })
    };
    options.iter().map(change).collect()
}

/// Axes of a work offset in the order of its numbers.
const OFFSET_AXES: [AxisId; 6] = [
    AxisId::X,
    AxisId::Y,
    AxisId::Z,
    AxisId::A,
    AxisId::B,
    AxisId::C,
];

/// A change for each coordinate of `g54=220,85,-150`.
fn offset(option: &str) -> Result<Vec<Change>, Failure> {
    let refused = |why: String| {
        Failure::with_hint(
            format!("--offset {option}: {why}"),
            "for example: --offset g54=220,85,-150 or --offset g54=x220,c90 (mm and deg)",
        )
    };
    let (system, coordinates) = option
        .split_once('=')
        .ok_or_else(|| refused("it is not of the form SYSTEM=X,Y,Z".to_owned()))?;
    // G59.1 is written with a point by people and with _ in keys.
    let system = system.trim().to_ascii_lowercase().replace('.', "_");
    if !WorkOffsets::KEYS.contains(&system.as_str()) {
        let why = format!(
            "there is no work coordinate system {system}; {}",
            did_you_mean(&system, &WorkOffsets::KEYS)
        );
        return Err(refused(why));
    }
    let mut changes: Vec<Change> = Vec::new();
    for (index, text) in coordinates.split(',').map(str::trim).enumerate() {
        // A letter names its axis; numbers without one go by their order.
        let lettered = text.chars().next().and_then(AxisId::from_letter);
        let axis = lettered.or_else(|| OFFSET_AXES.get(index).copied());
        let Some(axis) = axis else {
            return Err(refused(format!(
                "it has more than {} numbers",
                OFFSET_AXES.len()
            )));
        };
        let number = if lettered.is_some() {
            text.get(1..).unwrap_or_default()
        } else {
            text
        };
        // Parsed first: the value goes into the text of a machine file, where other text would be
        // read as TOML.
        let value = number
            .trim()
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite())
            .ok_or_else(|| refused(format!("`{text}` is not a finite number")))?;
        let key = format!("work_offset.{system}.{}", axis.column());
        // A letter may name an axis that a number without one has taken already.
        if changes.iter().any(|change| change.key == key) {
            return Err(refused(format!("it names {axis} twice")));
        }
        changes.push(Change {
            key,
            value: format!("{value:?}"),
            name: format!("--offset {option}"),
        });
    }
    Ok(changes)
}

/// Whether an argument means a file rather than a name.
fn is_file(name: &str) -> bool {
    name.ends_with(".toml") || name.contains(['/', '\\'])
}

/// Names of the machines that come with the program.
pub(crate) fn machine_names() -> Names {
    Names::new(
        "machine",
        presets().iter().map(|preset| (preset.name, preset.summary)),
    )
}

/// The machine asked for, or the default one, with changes.
fn load(name: Option<&str>, changes: &[Change]) -> Result<Machine, Failure> {
    let (name, text) = description(name.unwrap_or(DEFAULT_MACHINE))?;
    Machine::from_changed_toml(&name, &text, changes).map_err(|error| failure(&error))
}

/// Name and text of a machine file, or of a machine that comes with the program.
pub(crate) fn description(name: &str) -> Result<(String, String), Failure> {
    if is_file(name) {
        let text = input::text(Path::new(name), "machine file")?;
        return Ok((name.to_owned(), text));
    }
    match presets().iter().find(|preset| preset.name == name) {
        Some(preset) => Ok((format!("{name}.toml"), preset.toml.to_owned())),
        None => Err(unknown(name)),
    }
}

/// There is no machine of a name.
fn unknown(name: &str) -> Failure {
    match machine_names().refusal(name) {
        Failure::Message { text, hint } => {
            Failure::with_hint(text, format!("{hint}; a machine file's name ends in .toml"))
        }
        failure => failure,
    }
}

/// The machine of a file or a name, with its tuning; refused if that is not good enough.
pub(crate) fn check(name: &str, changes: &[Change]) -> Result<(Machine, Vec<AxisTuning>), Failure> {
    // What exists is a file, whatever its name ends in.
    let (_, text) = if Path::new(name).is_file() {
        (String::new(), input::text(Path::new(name), "machine file")?)
    } else {
        description(name)?
    };
    Machine::check_changed_toml(name, &text, changes).map_err(|error| failure(&error))
}

/// All that is wrong with a machine, with the count.
pub(crate) fn failure(error: &MachineError) -> Failure {
    let mut text = String::new();
    for problem in &error.problems {
        text.push_str(&format!("error: {}\n", error.text_of(problem)));
        if !problem.hint.is_empty() {
            text.push_str(&format!("hint: {}\n", problem.hint));
        }
    }
    let count = error.problems.len();
    Failure::Rendered(format!(
        "{text}{count} error{}",
        if count == 1 { "" } else { "s" }
    ))
}

/// The files that the name of an axis may stand for: FILE.toml, or FILE.toml:x.
pub(crate) fn axis_files(name: Option<&str>) -> impl Iterator<Item = (&Path, &'static str)> {
    let machine = name.and_then(|name| Some(name.rsplit_once(':')?.0));
    let files = name.into_iter().chain(machine);
    files.map(|file| (Path::new(file), "file of the axis"))
}

/// The axis of a preset (`paper`, `vmc3:x`), of a machine file (`FILE.toml:x`), or of a file with
/// the tables of one axis; changes are keys of the machine file or of the axis file.
pub(crate) fn axis(name: &str, changes: &[Change]) -> Result<AxisConfig, Failure> {
    // The last colon: paths may hold colons themselves.
    let of_machine = name.rsplit_once(':').filter(|(machine, _)| {
        machine.ends_with(".toml") || presets().iter().any(|preset| preset.name == *machine)
    });
    if let Some((machine, letter)) = of_machine {
        // The whole machine is read, so that the axis has the machine's cycles and checks.
        let machine_of_axis = load(Some(machine), changes)?;
        return machine_of_axis.drive(letter).cloned().ok_or_else(|| {
            Failure::with_hint(
                format!("{machine} has no axis \"{letter}\""),
                format!("its axes: {}", machine_of_axis.drives().join(", ")),
            )
        });
    }
    let text = match axis_preset_toml(name) {
        Some(text) => text,
        None if is_file(name) => input::text(Path::new(name), "axis file")?,
        None => {
            let known = axis_presets();
            let names: Vec<&str> = known.iter().map(String::as_str).collect();
            // The hint goes on with how an axis of a machine file is named: that may be what was
            // meant.
            let nearest = did_you_mean(name, &names).replace("known here", "known axes");
            let and = if nearest.ends_with('?') { "" } else { ";" };
            return Err(Failure::with_hint(
                format!("there is no axis \"{name}\""),
                format!("{nearest}{and} an axis of a machine file is FILE.toml:x"),
            ));
        }
    };
    axis_from_changed_toml(name, &text, changes).map_err(|error| failure(&error))
}

/// The machine with fitted gaps and loads, each given as `AXIS=FILE.json`, told to the methods that
/// may know them; `y2` is the second motor of a gantry's Y.
pub(crate) fn with_fits(mut machine: Machine, options: &[String]) -> Result<Machine, Failure> {
    let mut told_before: Vec<String> = Vec::new();
    for option in options {
        let (name, file) = option.split_once('=').ok_or_else(|| {
            Failure::with_hint(
                format!("--fitted {option} is not of the form AXIS=FILE.json"),
                "for example: --fitted x=x-axis.json",
            )
        })?;
        let drive = machine.drive(name).ok_or_else(|| {
            Failure::with_hint(
                format!(
                    "--fitted {option}: machine \"{}\" has no axis {}",
                    machine.name(),
                    name.to_ascii_uppercase()
                ),
                format!("its axes: {}", machine.drives().join(", ")),
            )
        })?;
        // An axis has one gap: which of two fits is meant cannot be known.
        let axis = name.to_ascii_lowercase();
        if told_before.contains(&axis) {
            return Err(Failure::with_hint(
                format!("--fitted {option}: axis {axis} has a fit already"),
                "give one result of `axis fit` for each axis",
            ));
        }
        told_before.push(axis);
        // Each fit is told to the drive that it was measured on, the second motor of a gantry by
        // itself.
        let told = fits::with_fit(Path::new(file), drive)?;
        machine = match letter_of(name) {
            Some(id) => machine.with_axis_config(id, &told),
            None => machine.with_second_config(&told),
        };
    }
    Ok(machine)
}

fn letter_of(text: &str) -> Option<AxisId> {
    let mut letters = text.chars();
    match (letters.next(), letters.next()) {
        (Some(letter), None) => AxisId::from_letter(letter),
        _ => None,
    }
}

/// How the drives are commanded.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Drives")]
pub(crate) struct Drives {
    /// How the drives go from setpoint to setpoint: linear, cubic-differences, catmull-rom,
    /// cubic-hermite, quintic-hermite, b-spline, compensated-b-spline or quintic-differences, for
    /// all axes or for one (x=linear; y2 is the second motor of a gantry's Y, y means both); may be
    /// repeated
    #[arg(long, value_name = "[AXIS=]NAME")]
    pub(crate) interpolator: Vec<String>,
    #[command(flatten)]
    pub(crate) cycles: Cycles,
}

/// Cycles of command and servo.
#[derive(Clone, Copy, Debug, Default, Args)]
#[command(next_help_heading = "Drives")]
pub(crate) struct Cycles {
    /// Time from setpoint to setpoint, 0.25 to 8 ms; the machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) command_ms: Option<f64>,
    /// Time from servo tick to servo tick, 31.25 to 1000 us, a whole fraction of the command's; the
    /// machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) servo_us: Option<f64>,
}

impl Cycles {
    /// The cycles asked for; those left out are the drive's own.
    ///
    /// # Errors
    /// Cycles that do not go together.
    pub(crate) fn over(self, own: CyclesConfig) -> Result<CyclesConfig, Failure> {
        let cycles = CyclesConfig {
            command_ms: self.command_ms.unwrap_or(own.command_ms),
            servo_us: self.servo_us.unwrap_or(own.servo_us),
        };
        cycles.check().map_err(|error| {
            Failure::with_hint(
                error.to_string(),
                "--command-ms and --servo-us set them; one has to divide the other",
            )
        })?;
        Ok(cycles)
    }
}

/// Names of interpolators.
pub(crate) fn interpolators() -> Names {
    Names::new(
        "interpolator",
        Interpolator::ALL.map(|known| (known.name(), "")),
    )
}

/// The interpolator of a name.
pub(crate) fn interpolator(name: &str) -> Result<Interpolator, Failure> {
    Interpolator::from_name(name).ok_or_else(|| interpolators().refusal(name))
}

impl Drives {
    /// The machine with the cycles and interpolators asked for.
    ///
    /// # Errors
    /// Unknown names, and values that do not go together, with their axis.
    pub(crate) fn of(&self, machine: &Machine) -> Result<Machine, Failure> {
        let mut machine = machine.with_cycles(self.cycles.over(machine.cycles())?);
        // In the order of the command line: a name for all axes replaces what came before it.
        for word in &self.interpolator {
            let Some((letter, name)) = word.split_once('=') else {
                let interpolator = interpolator(word)?;
                machine = machine.map_axes(|axis| AxisConfig {
                    interpolator,
                    ..axis.clone()
                });
                continue;
            };
            let drive = machine.drive(letter).ok_or_else(|| {
                Failure::with_hint(
                    format!(
                        "--interpolator {word}: machine \"{}\" has no axis \"{letter}\"",
                        machine.name()
                    ),
                    format!(
                        "its axes: {}; for example: --interpolator linear --interpolator x=quintic-hermite",
                        machine.drives().join(", ")
                    ),
                )
            })?;
            let interpolator = interpolator(name)?;
            let with = |config: &AxisConfig| AxisConfig {
                interpolator,
                ..config.clone()
            };
            let config = with(drive);
            machine = match letter_of(letter) {
                // Both motors of a gantry follow one axis: its letter means them both.
                Some(id) => {
                    let second = machine.gantry().filter(|gantry| gantry.axis == id);
                    let second = second.map(|gantry| with(&gantry.second));
                    let machine = machine.with_axis_config(id, &config);
                    second.map_or_else(
                        || machine.clone(),
                        |second| machine.with_second_config(&second),
                    )
                }
                None => machine.with_second_config(&config),
            };
        }
        // Interpolator and cycles may each be right and still not go together.
        for name in machine.drives() {
            if let Some(Err(error)) = machine.drive(&name).map(AxisConfig::check) {
                let name = name.to_ascii_uppercase();
                return Err(Failure::message(format!("axis {name}: {error}")));
            }
        }
        Ok(machine)
    }
}
