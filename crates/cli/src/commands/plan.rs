//! `lostmotion plan`.

use super::{DONE, accepted, failure, with_spline_tolerance};
use crate::args::Plan;
use crate::failure::Failure;
use crate::voice::Voice;
use crate::{args, input, machines};
use lostmotion::base::Clock;
use lostmotion::plan::{Quality, Sample};
use lostmotion::report::atomic::AtomicFile;
use lostmotion::report::csv::PlanWriter;
use lostmotion::report::{WriteError, number};
use lostmotion::sim::{SimError, SimulateOptions};

/// Writes the plan of a program as CSV.
pub(crate) fn run(args: &Plan, voice: Voice) -> Result<u8, Failure> {
    let program = input::program(&args.part)?;
    let machine = machines::load(args.on.machine.as_deref())?;
    let unwritten = |error| Failure::from(WriteError::io("write", &args.out, error));
    let mut writer =
        PlanWriter::new(AtomicFile::create(&args.out)?, machine.axis_set(), machine.rotary_joints(), Clock::CNC).map_err(unwritten)?;
    let mut sink = |samples: &[Sample]| writer.push(samples).map_err(Into::into);
    let options = args.reading.options(&args.part, machine.dialect(), SimulateOptions::default())?;
    let quality = match args.quality {
        args::Quality::Fast => Quality::Fast,
        args::Quality::Optimal => Quality::Optimal,
    };
    let options = SimulateOptions { quality, ..with_spline_tolerance(options, args.spline_tolerance_mm) };
    let info = lostmotion::sim::plan(&program, &machine, &options, &mut sink).map_err(|error| match error {
        SimError::Sink(why) => Failure::message(format!("cannot write {}: {why}", args.out.display())),
        other => failure(&program, &other, voice),
    })?;
    accepted(&program, &machine, &options, voice)?;
    writer.finish().map_err(unwritten)?.commit()?;
    if !voice.quiet {
        crate::output::print(&format!(
            "{}: {}, {} mm cutting, {} mm rapid\n",
            args.out.display(),
            number::duration(info.duration_s),
            number::fixed(info.cutting_mm, 1),
            number::fixed(info.rapid_mm, 1)
        ))?;
    }
    Ok(DONE)
}
