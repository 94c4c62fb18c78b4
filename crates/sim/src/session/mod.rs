//! The session: the whole chain, driven chunk by chunk.
//!
//! ```text
//! check    read everything once: diagnostics, travel            (check.rs, reader.rs, lower.rs)
//! feed     read again: motion -> moves -> samples, segments     (feed.rs, steer.rs, modes.rs)
//! paced    samples at another pace: hold, override, stop          (paced.rs)
//! cutting  samples -> forces on the loads                       (cutting.rs)
//! bow      samples, moves -> how far the tool is off where joints go straight (bow.rs)
//! bank     samples -> load positions, every axis, every variant (bank.rs)
//! frame    servo ticks paired with the commands they answer to  (frame.rs)
//! recorder load positions -> contour errors, added up           (recorder.rs)
//! collect  sums -> results                                      (collect.rs, rows.rs, text.rs)
//! ```

mod bank;
mod bow;
mod check;
mod collect;
mod cutting;
mod feed;
mod frame;
mod lower;
mod modes;
mod outputs;
mod paced;
mod reader;
mod recorder;
mod rows;
mod run;
mod steer;
mod text;

pub(crate) use bow::Bows;
pub(crate) use check::{Checked, check as check_program, planner_config};
pub(crate) use feed::{Feed, Note};
pub(crate) use modes::Modes;
pub use reader::interpreter_config;
pub(crate) use run::on_threads;
pub(crate) use text::fill as fill_texts;

use crate::error::{SimError, SinkError};
use crate::machine::Machine;
use crate::observer::Observer;
use crate::options::SimulateOptions;
use crate::results::{Comparison, PlanInfo, ProgramInfo, Simulation};
use crate::source::ProgramSource;
use lostmotion_contour::ProgrammedSegment;
use lostmotion_methods::{METHODS, find_method};
use lostmotion_plan::Sample;

/// Runs a part program on a machine with one compensator and judges its contour error.
///
/// The machine without a gap runs beside it, so that every error splits into command, servo and
/// backlash.
///
/// # Errors
/// Everything that is wrong with program, machine, method or options; see [`SimError`].
pub fn simulate(
    source: &ProgramSource,
    machine: &Machine,
    method: &str,
    options: &SimulateOptions,
    observer: &mut dyn Observer,
) -> Result<Simulation, SimError> {
    let comparison = compare(source, machine, &[method.to_owned()], options, observer)?;
    collect::simulation(comparison).ok_or_else(|| unknown_method(method))
}

/// One plan, all methods side by side.
///
/// # Errors
/// As [`simulate`]; also no method at all.
pub fn compare(
    source: &ProgramSource,
    machine: &Machine,
    methods: &[String],
    options: &SimulateOptions,
    observer: &mut dyn Observer,
) -> Result<Comparison, SimError> {
    for method in methods {
        find_method(method).map_err(|_| unknown_method(method))?;
    }
    if methods.is_empty() {
        return Err(unknown_method(""));
    }
    let checked = check::check(source, machine, options)?;
    let tally = run::run(source, machine, methods, options, observer)?;
    Ok(collect::comparison(
        source, machine, methods, options, checked, &tally,
    ))
}

/// Reads a part program to its end and holds it against a machine, without moving anything.
///
/// # Errors
/// As [`simulate`], apart from those of the method.
pub fn check(
    source: &ProgramSource,
    machine: &Machine,
    options: &SimulateOptions,
) -> Result<ProgramInfo, SimError> {
    Ok(check::check(source, machine, options)?.program)
}

/// Plans a part program and hands out the samples, chunk by chunk.
///
/// # Errors
/// As [`simulate`], and whatever the sink answers, as [`SimError::Sink`].
pub fn plan(
    source: &ProgramSource,
    machine: &Machine,
    options: &SimulateOptions,
    sink: &mut dyn FnMut(&[Sample]) -> Result<(), SinkError>,
) -> Result<PlanInfo, SimError> {
    plan_with_path(source, machine, options, &mut |samples, _| sink(samples))
}

/// Takes a chunk of samples and the programmed segments read for it.
pub type PathSink<'a> = dyn FnMut(&[Sample], &[ProgrammedSegment]) -> Result<(), SinkError> + 'a;

/// As [`plan`], with the programmed path: beside each chunk of samples come the segments read for
/// it, each once, in order and no later than the first sample that names it. So a caller can
/// measure contour errors of machines that are not described by a [`Machine`].
///
/// # Errors
/// As [`plan`].
pub fn plan_with_path(
    source: &ProgramSource,
    machine: &Machine,
    options: &SimulateOptions,
    sink: &mut PathSink<'_>,
) -> Result<PlanInfo, SimError> {
    let checked = check::check(source, machine, options)?;
    let mut feed = feed::Feed::new(source, machine, options)?;
    let (mut samples, mut segments) = (Vec::new(), Vec::new());
    let (mut count, command) = (0, machine.cycles().command());
    loop {
        segments.clear();
        feed.chunk(options.chunk_samples, &mut samples, &mut segments)?;
        if samples.is_empty() {
            let mut plan = PlanInfo {
                duration_s: command.seconds(count),
                ..checked.plan
            };
            feed.tell(&mut plan);
            return Ok(plan);
        }
        count += samples.len() as u64;
        if command.seconds(count) > options.max_duration_s {
            return Err(SimError::TooLong {
                limit_s: options.max_duration_s,
            });
        }
        sink(&samples, &segments).map_err(SimError::Sink)?;
    }
}

fn unknown_method(name: &str) -> SimError {
    let known = METHODS
        .iter()
        .map(|method| method.info.name)
        .collect::<Vec<_>>()
        .join(", ");
    SimError::Method {
        name: name.to_owned(),
        known,
    }
}
