//! What methods that learn start from and what they learn: `--learned`, `--save-learned`, and
//! `lostmotion axis commission`, which teaches them.

use crate::options::machine::{Changes, MachineOptions, failure};
use crate::output::{self, DONE, FOUND, Failure, remark};
use crate::{input, options};
use clap::{Args, ValueHint};
use lostmotion::drive::Learned;
use lostmotion::drive::config::AxisUnit;
use lostmotion::methods::{AxisConfig, AxisMemory, MethodId};
use lostmotion::report::WriteError;
use lostmotion::report::number::{self, fixed, percent};
use lostmotion::report::text::{Align, Table};
use lostmotion::sim::commission::{self, Bounds, Commissioned};
use lostmotion::sim::machine::Memory;
use lostmotion::sim::{Machine, machine::MachineError};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What methods that learn start from, and where it goes.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Learning")]
pub(crate) struct LearnedFiles {
    /// What `adaptive` starts from: a file of `axis commission` or --save-learned. It has to be of
    /// these axes: motor, transmission, stiffness and encoder must be those that it was learned on
    #[arg(long, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    pub(crate) learned: Option<PathBuf>,
    /// Write what `adaptive` has learned by the end; may be the file of --learned, which then need
    /// not exist yet
    #[arg(long, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    pub(crate) save_learned: Option<PathBuf>,
}

impl LearnedFiles {
    /// The files that hold what was learned, which no other output may replace.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = (&Path, &'static str)> {
        let read = self.learned.as_deref();
        let read = read.map(|path| (path, "file of --learned"));
        let written = self.save_learned.as_deref();
        let written = written.map(|path| (path, "file of --save-learned"));
        read.into_iter().chain(written)
    }

    /// Whether what a run learns goes to the file from which it starts.
    fn is_passed_on(&self) -> bool {
        // Of a name of its own: `./b` is `b`.
        let whole = |path: &Option<PathBuf>| std::path::absolute(path.as_ref()?).ok();
        self.learned.is_some() && whole(&self.learned) == whole(&self.save_learned)
    }

    /// What --learned tells of a machine; checked by whoever knows its axes.
    fn read(
        &self,
        of: impl Fn(&str, &str) -> Result<Memory, MachineError>,
        quiet: bool,
    ) -> Result<Option<Memory>, Failure> {
        let Some(path) = &self.learned else {
            return Ok(None);
        };
        // The first of a row of runs that pass on what they learn has nothing to read yet. Elsewhere
        // a file that is not there is a misspelt name.
        if self.is_passed_on() && !path.exists() {
            if !quiet {
                remark(&format!(
                    "note: {} does not exist yet: nothing is known before this run",
                    path.display()
                ));
            }
            return Ok(None);
        }
        let text = input::text(path, "file of --learned")?;
        of(&path.display().to_string(), &text)
            .map(Some)
            .map_err(|error| failure(&error))
    }

    /// What a machine's axes start from.
    pub(crate) fn of_machine(
        &self,
        machine: &Machine,
        quiet: bool,
    ) -> Result<Option<Memory>, Failure> {
        self.read(
            |name, text| Memory::from_toml_for(machine, name, text),
            quiet,
        )
    }

    /// What an axis alone starts from: that of its name; for one that is `nameless`, in a file of its
    /// own, the only one of the file.
    pub(crate) fn of_axis(
        &self,
        name: &str,
        nameless: bool,
        quiet: bool,
    ) -> Result<Option<Memory>, Failure> {
        let Some(memory) = self.read(Memory::from_toml, quiet)? else {
            return Ok(None);
        };
        if memory.axis.contains_key(name) || nameless && memory.axis.len() == 1 {
            return Ok(Some(memory));
        }
        let names: Vec<&str> = memory.axis.keys().map(String::as_str).collect();
        let path = self.learned.as_deref().unwrap_or(Path::new("")).display();
        Err(Failure::with_hint(
            format!("{path}: nothing of axis \"{name}\" has been learned"),
            format!("its axes: {}", names.join(", ")),
        ))
    }

    /// Refuses --learned and --save-learned where no method learns: nothing could be read or written.
    pub(crate) fn check(&self, methods: &[MethodId]) -> Result<(), Failure> {
        if let Some(path) = self
            .save_learned
            .as_ref()
            .filter(|path| output::is_standard(path))
        {
            output::refuse_standard(path, "a file")?;
        }
        let saved = self
            .save_learned
            .as_ref()
            .map(|path| ("--save-learned", path));
        let read = self.learned.as_ref().map(|path| ("--learned", path));
        let Some((option, path)) = saved.or(read) else {
            return Ok(());
        };
        if methods.iter().any(|method| method.learns()) {
            return Ok(());
        }
        let learning: Vec<&str> = MethodId::all()
            .filter(|method| method.learns())
            .map(MethodId::name)
            .collect();
        Err(Failure::with_hint(
            format!("{option} {}: no method of this run learns", path.display()),
            format!("add --method {}", learning.join(" or ")),
        ))
    }

    /// Writes what was learned; axes of which nothing was learned keep what they started from. A
    /// machine that `stops` was no longer what it learned of: the file stays as it is.
    pub(crate) fn save(
        &self,
        before: Option<&Memory>,
        learned: &Memory,
        stops: bool,
    ) -> Result<(), Failure> {
        let Some(path) = &self.save_learned else {
            return Ok(());
        };
        if stops {
            remark(&format!(
                "note: {} is not written: the machine stops, and what its axes learned until then is not to be trusted",
                path.display()
            ));
            return Ok(());
        }
        let mut memory = before.cloned().unwrap_or_default();
        memory.axis.extend(
            learned
                .axis
                .iter()
                .map(|(name, axis)| (name.clone(), *axis)),
        );
        write(path, &memory)
    }
}

/// Writes a memory.
fn write(path: &Path, memory: &Memory) -> Result<(), Failure> {
    let text = memory
        .to_toml()
        .map_err(|error| Failure::message(error.to_string()))?;
    output::refuse_standard(path, "a file")?;
    output::write_text(path, &text)
}

/// `axis commission`.
#[derive(Debug, Args)]
pub(crate) struct Commission {
    /// Machine (FILE.toml, or a name from `machine list`): all of its axes, one after the other; or
    /// one axis of it (FILE.toml:x, vmc3:x)
    #[arg(value_name = "MACHINE[:AXIS]")]
    pub(crate) axis: String,
    /// Any key of the machine file, for example axis.x.load.slide.gap_um=30; may be repeated
    #[arg(long, value_name = "KEY=VALUE", allow_hyphen_values = true)]
    pub(crate) set: Vec<String>,
    /// Refuse an axis whose motion takes longer than this
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0, allow_negative_numbers = true, value_parser = options::number)]
    pub(crate) at_most: f64,
    /// Write what was learned, for --learned
    #[arg(long, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    pub(crate) learned_out: Option<PathBuf>,
    /// Write the motion of the one axis as setpoints, for `axis run --setpoints`
    #[arg(long, short, value_name = "FILE.csv", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// Write the motion as a part program, for the control of the machine; `-` is stdout
    #[arg(long, value_name = "FILE.ngc", value_hint = ValueHint::FilePath)]
    pub(crate) gcode: Option<PathBuf>,
}

/// Commissions one axis of a machine or all of them. Exit code 0 where all of them have learned
/// well enough, 1 otherwise.
pub(crate) fn run(args: &Commission, quiet: bool) -> Result<u8, Failure> {
    let (machine, drives) = asked(args)?;
    refuse_long(&machine, &drives, args.at_most)?;
    let one = drives.first().filter(|_| drives.len() == 1);
    if let Some(path) = &args.out {
        let Some(bounds) = one.and_then(|drive| commission::bounds(&machine, drive)) else {
            return Err(Failure::with_hint(
                format!("--out {} holds the setpoints of one axis", path.display()),
                format!("name one: {}:{}", args.axis, machine.drives().join(" or :")),
            ));
        };
        write_setpoints(path, &bounds)?;
    }
    if let Some(path) = &args.gcode {
        let program = commission::program(&machine, &drives).map_err(|why| {
            Failure::with_hint(
                format!("--gcode {}: {why}", path.display()),
                "take the setpoints of each joint: --out FILE.csv",
            )
        })?;
        output::write_text(path, &program)?;
    }
    let found: Vec<Commissioned> = drives
        .iter()
        .filter_map(|drive| commission::one(&machine, drive))
        .collect::<Result<_, _>>()
        .map_err(|error| Failure::message(error.to_string()))?;
    if let Some(path) = &args.learned_out {
        write(path, &commission::memory(&found))?;
    }
    let to_stdout = args.gcode.as_deref().is_some_and(output::is_standard);
    if !quiet && !to_stdout {
        let texts: Vec<String> = found.iter().map(shown).collect();
        output::print(&texts.join("\n"))?;
    }
    let good = found.iter().all(|drive| fault(drive).is_none());
    Ok(if good { DONE } else { FOUND })
}

/// Refuses a motion that takes longer than somebody waits who did not ask for it.
fn refuse_long(machine: &Machine, drives: &[String], at_most_s: f64) -> Result<(), Failure> {
    if !(0.0..).contains(&at_most_s) {
        return Err(Failure::message(format!(
            "--at-most is {at_most_s}; it has to be 0 s or more"
        )));
    }
    for drive in drives {
        let Some(bounds) = commission::bounds(machine, drive) else {
            continue;
        };
        let duration_s = bounds.duration_s();
        if duration_s > at_most_s {
            return Err(Failure::with_hint(
                format!(
                    "axis {drive}: the motion takes {} s, more than --at-most {}: at {} {}/s the axis is slow beside the largest gap that is looked for",
                    fixed(duration_s, 0),
                    number::plain(at_most_s),
                    number::plain(bounds.limits.velocity),
                    bounds.unit.symbol(),
                ),
                format!(
                    "--at-most {}, or another axis alone",
                    fixed(duration_s.ceil(), 0)
                ),
            ));
        }
    }
    Ok(())
}

/// The machine, and which of its drives.
fn asked(args: &Commission) -> Result<(Machine, Vec<String>), Failure> {
    let load = |name: &str| {
        let options = MachineOptions {
            machine: Some(name.to_owned()),
            changes: Changes {
                set: args.set.clone(),
                ..Changes::default()
            },
            ..MachineOptions::default()
        };
        options.load()
    };
    // The last colon: paths may hold colons themselves.
    if let Some((name, drive)) = args.axis.rsplit_once(':')
        && !Path::new(&args.axis).is_file()
    {
        let machine = load(name)?;
        let drive = drive.to_ascii_lowercase();
        if machine.drive(&drive).is_none() {
            return Err(Failure::with_hint(
                format!("{name} has no axis \"{drive}\""),
                format!("its axes: {}", machine.drives().join(", ")),
            ));
        }
        return Ok((machine, vec![drive]));
    }
    let machine = load(&args.axis)?;
    let drives = machine.drives();
    Ok((machine, drives))
}

/// Writes setpoints as `axis run` reads them.
fn write_setpoints(path: &Path, bounds: &Bounds) -> Result<(), Failure> {
    let unwritten = |error| Failure::from(WriteError::io("write", path, error));
    let mut file = output::create(path)?;
    let unit = bounds.unit.symbol();
    writeln!(file, "t_s,position_{unit},velocity,acceleration").map_err(unwritten)?;
    for (index, setpoint) in bounds.setpoints().iter().enumerate() {
        let [velocity, acceleration] =
            [setpoint.velocity, setpoint.acceleration].map(|value| value.unwrap_or(0.0));
        writeln!(
            file,
            "{:.6},{:.7},{velocity:.6},{acceleration:.5}",
            index as f64 * bounds.cycle_s,
            setpoint.position,
        )
        .map_err(unwritten)?;
    }
    Ok(file.commit()?)
}

/// Largest standard deviation of a gap that is good enough, part of its value. A choice: what is
/// then left is about as much.
const GOOD_GAP_DOUBT: f64 = 0.05;
/// Standard deviations of a 95 % interval.
const INTERVAL_DEVIATIONS: f64 = 1.96;

/// Why what was learned is not good enough; `None` where it is.
fn fault(found: &Commissioned) -> Option<String> {
    let Some(learned) = found.learned else {
        return Some("the load was not learned: its motion does not show it".to_owned());
    };
    let memory = AxisMemory::new(learned, &found.config);
    if !memory.is_believed(&found.config) {
        return Some(
            "the load bounces: its friction is hardly known, and nothing of it is used".to_owned(),
        );
    }
    let truth = found.truth().half_gap_rad;
    if learned.gap_readings == 0 && truth == 0.0 {
        return None;
    }
    if learned.gap_readings == 0 {
        return Some("the gap was not learned: no contact showed, or there is none".to_owned());
    }
    // A gap too small to matter is known well.
    if !memory.has_gap(&found.config) {
        return None;
    }
    if learned.floats {
        return Some("the load may float: the gap is known and not used".to_owned());
    }
    let doubt = learned.half_gap_deviation_rad / learned.half_gap_rad;
    if doubt > GOOD_GAP_DOUBT {
        return Some(format!("the gap is known to {} only", percent(doubt)));
    }
    if learned.gap_readings < 2 {
        return Some("the gap was read only once".to_owned());
    }
    // Sure, and yet another value: the drive believes what is not so.
    let off = learned.half_gap_rad - truth;
    let is_beside = off.abs() > INTERVAL_DEVIATIONS * learned.half_gap_deviation_rad;
    (is_beside && off.abs() > GOOD_GAP_DOUBT * truth).then(|| {
        format!(
            "the gap is {} off that of the axis file, which lies outside the interval",
            percent(off / truth)
        )
    })
}

/// What was learned of an axis beside what its description says.
fn shown(found: &Commissioned) -> String {
    let mut out = format!(
        "axis {}: {} s of motion\n",
        found.drive,
        fixed(found.duration_s, 0)
    );
    if let Some(learned) = &found.learned {
        let mut table = Table::new(&[
            ("", Align::Left),
            ("learned", Align::Right),
            ("95 %", Align::Left),
            ("axis file", Align::Right),
            ("off by", Align::Right),
        ]);
        for row in rows(learned, &found.truth(), &found.config) {
            table.row(row.map(Into::into));
        }
        out.push_str(&table.render());
    }
    let verdict = fault(found).map_or("good enough: --learned starts from it".to_owned(), |why| {
        format!("not good enough: {why}")
    });
    out.push_str(&format!("{verdict}\n"));
    out
}

/// A value of an axis in SI, which may be of any size.
fn of_any_size(value: f64) -> String {
    if (0.1..1e4).contains(&value.abs()) {
        fixed(value, 3)
    } else if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.3e}")
    }
}

/// A row for each quantity: name with unit, value, interval, what the description says, difference.
fn rows(learned: &Learned, truth: &Learned, config: &AxisConfig) -> Vec<[String; 5]> {
    let per_rad = 2.0 / config.transmission.motor_rad_per_unit();
    let (gap_unit, gap_scale) = match config.unit() {
        AxisUnit::Mm => ("um", 1e3 * per_rad),
        AxisUnit::Deg => ("mdeg", 1e3 * per_rad),
        AxisUnit::Rad => ("rad", per_rad),
    };
    let row = |name: String, text: fn(f64) -> String, [value, deviation, truth]: [f64; 3]| {
        let half = INTERVAL_DEVIATIONS * deviation;
        [
            name,
            text(value),
            format!("{} to {}", text(value - half), text(value + half)),
            text(truth),
            if truth == 0.0 {
                "-".to_owned()
            } else {
                percent(value / truth - 1.0)
            },
        ]
    };
    let mut rows = Vec::new();
    if learned.gap_readings > 0 {
        let of = [
            learned.half_gap_rad,
            learned.half_gap_deviation_rad,
            truth.half_gap_rad,
        ];
        rows.push(row(
            format!("gap, {gap_unit}"),
            number::error,
            of.map(|half| half * gap_scale),
        ));
    }
    rows.extend([
        row(
            "load inertia, kg m2".to_owned(),
            of_any_size,
            [
                learned.load_inertia_kgm2,
                learned.load_inertia_deviation_kgm2,
                truth.load_inertia_kgm2,
            ],
        ),
        row(
            "viscous friction, N m s/rad".to_owned(),
            of_any_size,
            [
                learned.viscous_nm_s_per_rad,
                learned.viscous_deviation_nm_s_per_rad,
                truth.viscous_nm_s_per_rad,
            ],
        ),
        row(
            "Coulomb friction, N m".to_owned(),
            of_any_size,
            [
                learned.coulomb_nm,
                learned.coulomb_deviation_nm,
                truth.coulomb_nm,
            ],
        ),
        row(
            "constant torque, N m".to_owned(),
            of_any_size,
            [
                learned.constant_nm,
                learned.constant_deviation_nm,
                truth.constant_nm,
            ],
        ),
    ]);
    rows
}
