//! One method on both axes of a cell.

use super::machine::AXES;
use crate::error::StudyError;
use lostmotion_axis::{AxisConfig, AxisOutput, AxisRunner, AxisSample, Setpoint, build_runner};
use lostmotion_base::Coords;
use lostmotion_contour::FootState;
use lostmotion_plan::Sample;

/// How long the machine stands still before the program, CNC ticks, so that drives settle.
pub(super) const SETTLE_TICKS: usize = 500;

/// Both axes with one compensator.
pub(super) struct Lane {
    runners: [Box<dyn AxisRunner>; 2],
    outputs: [AxisOutput; 2],
    pub(super) foot: FootState,
}

impl Lane {
    /// At rest at `start`, mm.
    pub(super) fn new(config: &AxisConfig, method: &str, start: &Coords) -> Result<Lane, StudyError> {
        let runner = |axis: usize| -> Result<Box<dyn AxisRunner>, StudyError> {
            let at = AXES.get(axis).map_or(0.0, |id| start[*id]);
            let mut runner = build_runner(config, method, at)?;
            let rest = Setpoint::moving(at, 0.0, 0.0);
            runner.push(&[rest; SETTLE_TICKS], &mut AxisOutput::new(false))?;
            Ok(runner)
        };
        let outputs = [AxisOutput::new(true), AxisOutput::new(true)];
        Ok(Lane { runners: [runner(0)?, runner(1)?], outputs, foot: FootState::default() })
    }

    /// Steps both axes through a chunk of the plan; what the chunk before left is gone.
    pub(super) fn run(&mut self, samples: &[Sample], setpoints: &mut Vec<Setpoint>) -> Result<(), StudyError> {
        for ((id, runner), output) in AXES.iter().zip(&mut self.runners).zip(&mut self.outputs) {
            setpoints.clear();
            setpoints.extend(
                samples.iter().map(|sample| Setpoint::moving(sample.position[*id], sample.velocity[*id], sample.acceleration[*id])),
            );
            output.clear();
            runner.push(setpoints, output)?;
        }
        Ok(())
    }

    /// Where the loads of both axes are at a servo sample of the chunk, mm.
    pub(super) fn load(&self, servo_sample: usize) -> [f64; 2] {
        self.outputs.each_ref().map(|output| output.load.get(servo_sample).copied().unwrap_or(f64::NAN))
    }

    /// References of both axes at a servo sample of the chunk, mm.
    pub(super) fn reference(&self, servo_sample: usize) -> [f64; 2] {
        self.outputs.each_ref().map(|output| output.reference.get(servo_sample).copied().unwrap_or(f64::NAN))
    }

    /// The trace of an axis at a servo sample of the chunk.
    pub(super) fn sample(&self, axis: usize, servo_sample: usize) -> AxisSample {
        self.outputs.get(axis).and_then(|output| output.trace.as_ref()?.get(servo_sample)).copied().unwrap_or_default()
    }

    /// Part of so many servo ticks for which the drive was at a limit, the worse axis.
    pub(super) fn saturated(&self, ticks: u64) -> f64 {
        self.outputs.iter().map(|output| output.saturated_samples as f64 / (ticks.max(1) as f64)).fold(0.0, f64::max)
    }
}
