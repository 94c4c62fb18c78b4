//! `lostmotion axis`.

use super::DONE;
use crate::args::machine::Axis;
use crate::failure::Failure;
use crate::{drives, input, machines, output};
use lostmotion::analysis::CycleDetector;
use lostmotion::drive::config::Interpolator;
use lostmotion::drive::{AxisOutput, AxisRunner, Setpoint};
use lostmotion::methods::{AxisConfig, MethodId, UnknownMethod, build_runner};
use lostmotion::report::WriteError;
use lostmotion::report::atomic::AtomicFile;
use lostmotion::report::csv::{AxisTraceWriter, SetpointReader, SetpointSource};
use std::io::Read;

/// Setpoints that go to the axis at once.
const CHUNK: usize = 1024;

/// Smallest swing (peak to peak) of a standing load that counts as a limit cycle, in parts of the
/// gap.
const LEAST_SWING: f64 = 0.02;

/// Runs an axis alone and writes its trace; says so if its load does not come to rest at the end.
pub(crate) fn run(args: &Axis) -> Result<u8, Failure> {
    let axis = machines::axis(&args.axis)?;
    let cycles = drives::cycles(args.cycles, axis.cycles)?;
    let file = input::open(&args.setpoints, "setpoint file")?;
    let source = args
        .column
        .as_deref()
        .map_or(SetpointSource::Position, SetpointSource::Column);
    let mut setpoints = SetpointReader::new(
        file,
        &args.setpoints.display().to_string(),
        source,
        cycles.command(),
    )?;
    let mut config = AxisConfig {
        cycles,
        interpolator: interpolator(args, &axis, &setpoints)?,
        ..axis
    };
    let method: MethodId = args
        .method
        .parse()
        .map_err(|error: UnknownMethod| Failure::message(error.to_string()))?;
    // a trace shows all that is estimated
    config.compensation.estimate_shaft = true;
    check_unit(args, &config, &setpoints)?;
    let first = setpoints.next().transpose()?.unwrap_or_default();
    let mut runner = build_runner(&config, method, first.position)
        .map_err(|error| Failure::message(error.to_string()))?;
    let units_per_rad = 1.0 / config.transmission.motor_rad_per_unit();
    let unwritten = |error| Failure::from(WriteError::io("write", &args.out, error));
    let mut writer = AxisTraceWriter::new(
        AtomicFile::create(&args.out)?,
        config.unit(),
        units_per_rad,
        cycles.servo(),
    )
    .map_err(unwritten)?;
    let mut out = AxisOutput::new(true);
    let mut detector = CycleDetector::new(
        cycles.servo().period_s(),
        LEAST_SWING * config.reflected_load().gap_rad,
    );
    let mut tick = 0;
    let mut chunk = vec![first];
    loop {
        let full = fill(&mut chunk, &mut setpoints)?;
        push(&mut *runner, &chunk, &mut out)?;
        for sample in out.trace.iter().flatten() {
            writer.push(tick, sample).map_err(unwritten)?;
            detector.push(sample.reference.position, sample.load_position);
            tick += 1;
        }
        out.clear();
        chunk.clear();
        if !full {
            break;
        }
    }
    writer.finish().map_err(unwritten)?.commit()?;
    if let Some(cycle) = detector.cycle() {
        let (amplitude, unit) = (cycle.amplitude * units_per_rad, config.unit().symbol());
        output::remark(&format!(
            "limit cycle: at the end the load swings by +-{amplitude:.3e} {unit} at {:.1} Hz",
            cycle.frequency_hz
        ));
    }
    Ok(DONE)
}

/// The interpolator asked for; else the axis' own where the table has what it needs, else one for
/// positions alone.
fn interpolator(
    args: &Axis,
    axis: &AxisConfig,
    setpoints: &SetpointReader<impl Read>,
) -> Result<Interpolator, Failure> {
    let Some(name) = &args.interpolator else {
        let own = axis.interpolator;
        return Ok(if setpoints.serves(own) {
            own
        } else {
            Interpolator::QuinticDifferences
        });
    };
    let wanted = drives::interpolator(name)?;
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
    while chunk.len() < CHUNK {
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

/// Refuses a position column that names another unit than the axis'.
fn check_unit(
    args: &Axis,
    config: &AxisConfig,
    setpoints: &SetpointReader<impl Read>,
) -> Result<(), Failure> {
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
