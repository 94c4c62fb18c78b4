//! One method on the axes of a cell.

use super::machine::AXES;
use crate::error::StudyError;
use lostmotion_base::{AxisId, Coords};
use lostmotion_contour::FootState;
use lostmotion_drive::{AxisOutput, AxisRunner, AxisSample, Setpoint};
use lostmotion_methods::{AxisConfig, build_runner};
use lostmotion_plan::Sample;

/// How long the machine stands still before the program, CNC ticks, so that drives settle.
pub(super) const SETTLE_TICKS: usize = 500;

/// X and Y, and Z where the program moves it, with one compensator.
pub(super) struct Lane {
    axes: Vec<(AxisId, Box<dyn AxisRunner>, AxisOutput)>,
    pub(super) foot: FootState,
}

impl Lane {
    /// At rest at `start`, mm; with a real Z or without one.
    pub(super) fn new(
        config: &AxisConfig,
        method: &str,
        start: &Coords,
        with_z: bool,
    ) -> Result<Lane, StudyError> {
        let mut axes = Vec::with_capacity(AXES.len() + 1);
        for id in AXES.into_iter().chain(with_z.then_some(AxisId::Z)) {
            let mut runner = build_runner(config, method, start[id])?;
            let rest = Setpoint::moving(start[id], 0.0, 0.0);
            runner.push(&[rest; SETTLE_TICKS], &mut AxisOutput::new(false))?;
            axes.push((id, runner, AxisOutput::new(true)));
        }
        Ok(Lane {
            axes,
            foot: FootState::default(),
        })
    }

    /// Steps all axes through a chunk of the plan; what the chunk before left is gone.
    pub(super) fn run(
        &mut self,
        samples: &[Sample],
        setpoints: &mut Vec<Setpoint>,
    ) -> Result<(), StudyError> {
        for (id, runner, output) in &mut self.axes {
            setpoints.clear();
            setpoints.extend(samples.iter().map(|sample| {
                Setpoint::moving(
                    sample.position[*id],
                    sample.velocity[*id],
                    sample.acceleration[*id],
                )
            }));
            output.clear();
            runner.push(setpoints, output)?;
        }
        Ok(())
    }

    /// Where the loads are at a servo sample of the chunk, mm; an ideal Z is at `z`.
    pub(super) fn load(&self, servo_sample: usize, z: f64) -> [f64; 3] {
        self.tip(z, |output| &output.load, servo_sample)
    }

    /// The references at a servo sample of the chunk, mm.
    pub(super) fn reference(&self, servo_sample: usize, z: f64) -> [f64; 3] {
        self.tip(z, |output| &output.reference, servo_sample)
    }

    fn tip(
        &self,
        z: f64,
        list: impl Fn(&AxisOutput) -> &Vec<f64>,
        servo_sample: usize,
    ) -> [f64; 3] {
        let at = |axis: usize| {
            self.axes
                .get(axis)
                .map(|(_, _, output)| list(output).get(servo_sample).copied().unwrap_or(f64::NAN))
        };
        [
            at(0).unwrap_or(f64::NAN),
            at(1).unwrap_or(f64::NAN),
            at(2).unwrap_or(z),
        ]
    }

    /// The trace of an axis at a servo sample of the chunk.
    pub(super) fn sample(&self, axis: usize, servo_sample: usize) -> AxisSample {
        self.axes
            .get(axis)
            .and_then(|(_, _, output)| output.trace.as_ref()?.get(servo_sample))
            .copied()
            .unwrap_or_default()
    }

    /// Part of so many servo ticks for which the drive was at a limit, the worst axis.
    pub(super) fn saturated(&self, ticks: u64) -> f64 {
        self.axes
            .iter()
            .map(|(_, _, output)| output.saturated_samples as f64 / (ticks.max(1) as f64))
            .fold(0.0, f64::max)
    }
}
