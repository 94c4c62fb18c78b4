//! `lostmotion axis`: one axis alone, and fits to what was logged of one.

use crate::commission::{self, Commission, LearnedFiles};
use crate::identify::{self, Identify};
use crate::input;
use crate::log_overview::{LogOverview, overview};
use crate::logs::{LogInput, axis_unit};
use crate::options::machine::{Cycles, axis, axis_files, interpolator, interpolators, set_changes};
use crate::options::start::Start;
use crate::options::{Lateness, methods};
use crate::output::{self, DONE, Failure};
use crate::testpart::{self, Testpart};
use clap::{Args, Subcommand, ValueHint};
use lostmotion::analysis::CycleDetector;
use lostmotion::drive::config::Interpolator;
use lostmotion::drive::{AxisOutput, AxisRunner, Setpoint};
use lostmotion::identify::{AxisRows, BacklashFit, FitResult, LoadStiffness, fit_axis};
use lostmotion::logs::{DriveSignal, Role};
use lostmotion::methods::{AxisConfig, AxisMemory, MethodId, UnknownMethod, build_runner_from};
use lostmotion::report::atomic::AtomicFile;
use lostmotion::report::csv::{AxisTraceWriter, SetpointReader, SetpointSource};
use lostmotion::report::{WriteError, json, number};
use lostmotion::sim::machine::Memory;
use std::io::Read;
use std::path::PathBuf;

/// `axis`.
#[derive(Debug, Subcommand)]
pub(crate) enum AxisCommand {
    /// Run one axis alone on setpoints from a CSV
    Run(RunAxis),
    /// Move an axis for a minute so that `adaptive` learns its load and gap before the part
    Commission(Commission),
    /// Fit the gap of an axis to a log of motor position, load position and current
    Fit(Fit),
    /// Find what a log tells of an axis: lost motion, gap, inertia, friction, servo gains; or check
    /// a description against it
    Identify(Identify),
    /// Say what is in a measured log: format, channels, units, clocks, what is missing
    Log(LogOverview),
    /// Write the program to run on a machine in order to measure it: circles, a ballbar, reversals,
    /// friction, commissioning; simulated before it is written
    Testpart(Testpart),
}

/// `axis run`.
#[derive(Debug, Args)]
pub(crate) struct RunAxis {
    /// CSV with the columns t_s and position, a row a command cycle; velocity and acceleration
    /// where the interpolator needs them; load_force_n (load_torque_nm of an axis that turns), a
    /// force on the load against the positive direction, held from its row to the next
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) setpoints: PathBuf,
    /// Axis: a name from `machine list`, or a file with the tables of one axis
    #[arg(long, value_name = "FILE.toml|PRESET")]
    pub(crate) axis: String,
    /// Compensation method
    #[arg(long, value_name = "NAME", default_value = MethodId::NONE.name(), value_parser = methods())]
    pub(crate) method: String,
    /// Column of the setpoints that holds the position, such as x_mm of a plan
    #[arg(long, value_name = "NAME")]
    pub(crate) column: Option<String>,
    /// How the drive goes from setpoint to setpoint; quintic-differences, or the axis' own where
    /// the setpoints bring velocity and acceleration
    #[arg(long, value_name = "NAME", value_parser = interpolators())]
    pub(crate) interpolator: Option<String>,
    /// Any key of the machine file (FILE.toml:x, vmc3:x) or of the axis file, for example
    /// drive.position_gain_per_s=30; may be repeated
    #[arg(long, value_name = "KEY=VALUE", allow_hyphen_values = true)]
    pub(crate) set: Vec<String>,
    /// CSV to write, a row a servo tick
    #[arg(long, short, value_name = "FILE.csv", value_hint = ValueHint::FilePath)]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) learning: LearnedFiles,
    #[command(flatten)]
    pub(crate) begins: Start,
    #[command(flatten)]
    pub(crate) cycles: Cycles,
}

/// `axis fit`.
#[derive(Debug, Args)]
pub(crate) struct Fit {
    #[command(flatten)]
    pub(crate) log: LogInput,
    /// Use motor position and current alone: for a log without the load's position (needs --axis
    /// for the motor's inertia)
    #[arg(long, requires = "axis")]
    pub(crate) motor_only: bool,
    /// The axis that was logged; without it the motor's inertia and friction are found from the
    /// log, too, or the fit says that they cannot be told
    #[arg(long, value_name = "FILE.toml|PRESET")]
    pub(crate) axis: Option<String>,
    #[command(flatten)]
    pub(crate) lateness: Lateness,
    /// JSON to write
    #[arg(long, short, value_name = "FILE.json", value_hint = ValueHint::FilePath)]
    pub(crate) out: PathBuf,
}

/// Setpoints that go to the axis at once. A choice: about a second of motion.
const SETPOINTS_PER_CHUNK: usize = 1024;

/// Smallest swing (peak to peak) of a standing load that counts as a limit cycle, in parts of the
/// gap. A choice: above the creep of a load that settles, below any swing from flank to flank.
const LEAST_CYCLE_SWING_SHARE: f64 = 0.02;

/// Runs the command asked for.
pub(crate) fn run(command: &AxisCommand, quiet: bool) -> Result<u8, Failure> {
    match command {
        AxisCommand::Run(args) => run_axis(args, quiet),
        AxisCommand::Commission(args) => commission::run(args, quiet),
        AxisCommand::Fit(args) => fit(args, quiet),
        AxisCommand::Identify(args) => identify::run(args, quiet),
        AxisCommand::Log(args) => overview(args),
        AxisCommand::Testpart(args) => testpart::run(args, quiet),
    }
}

/// What a memory calls an axis: the letter behind the machine's name, or `axis` where it stands
/// alone.
fn letter_of(name: &str) -> &str {
    match name.rsplit_once(':') {
        Some((_, letter)) if !letter.contains(['/', '\\', '.']) => letter,
        _ => NAMELESS,
    }
}

/// What an axis is called in a memory that has a file of its own.
const NAMELESS: &str = "axis";

/// Runs an axis alone and writes its trace; says so if its load does not come to rest at the end.
fn run_axis(args: &RunAxis, quiet: bool) -> Result<u8, Failure> {
    let axis = axis(&args.axis, &set_changes(&args.set)?)?;
    let cycles = args.cycles.over(axis.cycles)?;
    let file = input::open(&args.setpoints, "setpoint file")?;
    output::refuse_input(&args.out, &args.setpoints, "setpoint file")?;
    output::refuse_inputs(&args.out, axis_files(Some(&args.axis)))?;
    let source = args
        .column
        .as_deref()
        .map_or(SetpointSource::Position, SetpointSource::Column);
    // The reader holds the time of every row against the command cycle.
    let mut setpoints = SetpointReader::new(
        file,
        &args.setpoints.display().to_string(),
        source,
        cycles.command(),
    )?;
    let mut config = AxisConfig {
        cycles,
        interpolator: usable_interpolator(args, &axis, &setpoints)?,
        ..axis
    };
    // A trace shows all that can be estimated; the estimator changes nothing of the motion.
    config.compensation.estimate_shaft = true;
    check_unit(args, &config, &setpoints)?;
    // The axis begins at the first setpoint, at rest unless told otherwise: a jump there would be
    // the table's, not the axis'.
    let first = setpoints.next().transpose()?.unwrap_or_default();
    let (mut config, start) = args.begins.of(config, first.position)?;
    let method: MethodId = args
        .method
        .parse()
        .map_err(|error: UnknownMethod| Failure::message(error.to_string()))?;
    args.learning.check(&[method])?;
    let letter = letter_of(&args.axis);
    let memory = args.learning.of_axis(letter, letter == NAMELESS, quiet)?;
    // That of its name, or the only one.
    let remembered = memory.as_ref().and_then(|memory| {
        let of_name = memory.axis.get(letter);
        of_name.or_else(|| memory.axis.values().next())
    });
    config.compensation.learned = remembered.copied();
    let mut runner = build_runner_from(&config, method, &start)
        .map_err(|error| Failure::message(error.to_string()))?;
    // Samples are in radians of the motor; people read the axis' unit at the load.
    let units_per_rad = 1.0 / config.transmission.motor_rad_per_unit();
    let unwritten = |error| Failure::from(WriteError::io("write", &args.out, error));
    let mut writer = AxisTraceWriter::new(
        output::create(&args.out)?,
        config.unit(),
        units_per_rad,
        cycles.servo(),
    )
    .map_err(unwritten)?;
    let mut out = AxisOutput::new(true);
    let mut detector = CycleDetector::new(
        cycles.servo().period_s(),
        LEAST_CYCLE_SWING_SHARE * config.reflected_load().gap_rad,
    );
    let mut tick = 0;
    // The row that told where the axis begins is the first of the motion, too.
    let mut chunk = vec![first];
    loop {
        // In chunks: tables may be longer than memory.
        let full = fill(&mut chunk, &mut setpoints)?;
        push(&mut *runner, &chunk, &mut out)?;
        for sample in out.trace.iter().flatten() {
            writer.push(tick, sample).map_err(unwritten)?;
            // Watches for swings that go on while the reference stands.
            detector.push(sample.reference.position, sample.load_position);
            tick += 1;
        }
        out.clear();
        chunk.clear();
        if !full {
            break;
        }
    }
    // The file takes its name only now: an error above leaves none behind.
    writer.finish().map_err(unwritten)?.commit()?;
    let mut learned = Memory::default();
    if let Some(found) = runner.learned() {
        let axis = AxisMemory::new(found, &config);
        learned.axis.insert(letter.to_owned(), axis);
    }
    args.learning.save(memory.as_ref(), &learned, false)?;
    // A limit cycle is a finding about the axis, not a failure of the run.
    if let Some(cycle) = detector.cycle().filter(|_| !quiet) {
        let (amplitude, unit) = (cycle.amplitude * units_per_rad, config.unit().symbol());
        output::remark(&format!(
            "warning: limit cycle: at the end the load swings by +-{amplitude:.3e} {unit} at {:.1} Hz",
            cycle.frequency_hz
        ));
    }
    Ok(DONE)
}

/// The interpolator asked for; else the axis' own where the table has what it needs, else one for
/// positions alone.
fn usable_interpolator(
    args: &RunAxis,
    axis: &AxisConfig,
    setpoints: &SetpointReader<impl Read>,
) -> Result<Interpolator, Failure> {
    let Some(name) = &args.interpolator else {
        // Tables of positions alone are run with an interpolator that differentiates for itself.
        let own = axis.interpolator;
        return Ok(if setpoints.serves(own) {
            own
        } else {
            Interpolator::QuinticDifferences
        });
    };
    // One asked for by name is not replaced: the figures would be those of another drive.
    let wanted = interpolator(name)?;
    if setpoints.serves(wanted) {
        return Ok(wanted);
    }
    let missing = if wanted.needs_velocity() && !setpoints.has_velocity() {
        "velocity"
    } else {
        "acceleration"
    };
    let hint = "for positions alone: linear, cubic-differences, catmull-rom, b-spline, quintic-differences";
    Err(Failure::with_hint(
        format!(
            "{}: interpolator \"{name}\" needs a column `{missing}`",
            args.setpoints.display()
        ),
        hint,
    ))
}

/// Fills a chunk; false at the end of the table.
fn fill(
    chunk: &mut Vec<Setpoint>,
    setpoints: &mut SetpointReader<impl Read>,
) -> Result<bool, Failure> {
    while chunk.len() < SETPOINTS_PER_CHUNK {
        match setpoints.next().transpose()? {
            Some(setpoint) => chunk.push(setpoint),
            None => return Ok(false),
        }
    }
    Ok(true)
}

fn push(
    runner: &mut dyn AxisRunner,
    chunk: &[Setpoint],
    out: &mut AxisOutput,
) -> Result<(), Failure> {
    runner
        .push(chunk, out)
        .map_err(|error| Failure::message(error.to_string()))
}

/// Refuses a position column, or one of the force on the load, that has another unit than the axis.
fn check_unit(
    args: &RunAxis,
    config: &AxisConfig,
    setpoints: &SetpointReader<impl Read>,
) -> Result<(), Failure> {
    if let Some((column, suits)) = setpoints.load_force(config.unit())
        && column != suits
    {
        return Err(Failure::with_hint(
            format!(
                "{}: axis \"{}\" is in {} and has no `{column}`",
                args.setpoints.display(),
                args.axis,
                config.unit().symbol()
            ),
            format!("call the column {suits}"),
        ));
    }
    match setpoints.unit() {
        Some(unit) if unit != config.unit() => Err(Failure::message(format!(
            "{}: the positions are in {}, but axis \"{}\" is in {}",
            args.setpoints.display(),
            unit.symbol(),
            args.axis,
            config.unit().symbol()
        ))),
        _ => Ok(()),
    }
}

/// Fits the gap of a log and writes it as JSON.
pub(crate) fn fit(args: &Fit, quiet: bool) -> Result<u8, Failure> {
    let axis = args
        .axis
        .as_deref()
        .map(|name| axis(name, &[]))
        .transpose()?;
    let name = args.log.name();
    output::refuse_input(&args.out, &args.log.log, "log")?;
    output::refuse_inputs(&args.out, axis_files(args.axis.as_deref()))?;
    args.log.exists()?;
    // A file that cannot be written is found before the fit, not after it.
    let file = output::create(&args.out)?;
    // Motor data are known by current: a torque or a force has no lag of the drive's to allow for.
    let without = [Role::Command, Role::Torque, Role::Force];
    let log = if args.motor_only {
        let without = [&without[..], &[Role::Load]].concat();
        args.log.read(&[Role::Current], &without, quiet)?
    } else {
        args.log
            .read(&[Role::Load, Role::Current], &without, quiet)?
    };
    let rows = AxisRows {
        name: &name,
        unit: axis_unit(&log),
        time_s: &log.time_s,
        motor: &log.motor,
        load: (!args.motor_only).then_some(&log.load),
        current_a: log.drive.as_ref().map_or(&[], DriveSignal::values),
        lateness_s: args.lateness.seconds(),
    };
    let result = fit_axis(&rows, axis.as_ref())
        .map_err(|error| Failure::message(format!("{name}: {error}")))?;
    write(file, &result)?;
    output::print(&summary(&result))?;
    Ok(DONE)
}

fn write(mut file: AtomicFile, result: &FitResult) -> Result<(), Failure> {
    let path = file.path().to_path_buf();
    json::write_significant(&mut file, result)
        .map_err(|error| WriteError::io("write", &path, error))?;
    file.commit()?;
    Ok(())
}

fn summary(result: &FitResult) -> String {
    let unit = &result.unit;
    let [low, high] = result
        .gap_interval
        .map(|v| number::plain(number::round_to(v, 6)));
    let gap = number::plain(number::round_to(result.gap, 6));
    let fit = &result.fit;
    let used = format!(
        "{} of {} samples, {} traversals",
        fit.samples_used, fit.samples_logged, fit.traversals
    );
    // A log on one flank only bounds the gap: the figure must not be read as a value.
    let doubt = fit
        .reason
        .as_ref()
        .map(|reason| format!("the log does not tell the gap from zero: {reason}\n"))
        .unwrap_or_default();
    // Without the axis they are in units of the log, which their labels would misname.
    let more = match &result.stiffness {
        Some(stiffness) => found_beside(fit, stiffness),
        None => "without --axis inertia and friction (Coulomb, viscous) of the motor were found from the log, too; with it the interval is narrower\n".to_owned(),
    };
    format!("gap {gap} {unit} (95 %: {low} to {high} {unit}) from {used}\n{doubt}{more}")
}

/// What was found beside the gap: the shaft as the load feels it, the load at the motor's shaft.
fn found_beside(fit: &BacklashFit, stiffness: &LoadStiffness) -> String {
    let shown = |value: f64| format!("{value:.3e}");
    let LoadStiffness {
        unit,
        value,
        interval,
    } = stiffness;
    let stiffness = match (*value, *interval) {
        (Some(value), [Some(low), Some(high)]) => Some(format!(
            "stiffness {} {unit} (95 %: {} to {})\n",
            shown(value),
            shown(low),
            shown(high)
        )),
        // The log bends too little to tell it from a rigid shaft: a bound, not a value.
        (_, [Some(low), _]) => Some(format!(
            "stiffness at least {} {unit}: more cannot be told from this log\n",
            shown(low)
        )),
        _ => None,
    };
    let milliseconds = |seconds: f64| number::plain(number::round_to(1e3 * seconds, 3));
    let [low, high] = fit.damping_time_interval_s.map(milliseconds);
    let damping = (fit.damping_time_interval_s[1] > 0.0).then(|| {
        let time = milliseconds(fit.damping_time_s);
        format!("damping time {time} ms (95 %: {low} to {high} ms)\n")
    });
    // A lag whose interval holds zero is none.
    let [least, most] = fit.current_late_interval_s;
    let late = (least > 0.0).then(|| {
        let [late, least, most] = [fit.current_late_s, least, most].map(milliseconds);
        format!(
            "the current lags behind the positions by {late} ms or more (95 %: {least} to {most} ms)\n"
        )
    });
    let load = fit.load.map(|load| {
        let (inertia, viscous) = (shown(load.inertia_kgm2), shown(load.viscous_nm_s_per_rad));
        let (coulomb, constant) = (shown(load.coulomb_nm), shown(load.constant_nm));
        format!("load {inertia} kg m2, friction {coulomb} N m and {viscous} N m s/rad, constant {constant} N m\n")
    });
    [stiffness, damping, late, load]
        .into_iter()
        .flatten()
        .collect()
}
