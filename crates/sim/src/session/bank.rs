//! All axes of all variants of the machine, stepped side by side.

use crate::error::SimError;
use crate::machine::{Machine, MachineAxis};
use lostmotion_axis::{AxisBatch, AxisConfig, AxisError, AxisOutput, AxisRunner, Setpoint, build_runner};
use lostmotion_base::{AxisId, Coords};
use lostmotion_plan::Sample;

/// How long the machine stands still before the program, CNC ticks: gravity pulls loads to their flank, drives settle.
const SETTLE_TICKS: usize = 500;

/// The machine in several variants (without a gap, and with each method), all on the same setpoints.
pub(crate) struct Bank {
    /// Variant by variant, each with one lane an axis.
    batch: AxisBatch,
    /// The axis of each lane.
    axis_of: Vec<usize>,
    setpoints: Vec<Vec<Setpoint>>,
    delay_ticks: u32,
    pub(crate) outputs: Outputs,
}

/// What all lanes did in the last chunk.
#[derive(Debug)]
pub(crate) struct Outputs {
    axes: Vec<AxisInfo>,
    lanes: Vec<AxisOutput>,
    /// Where each lane's load stands when its command is 0, in the axis' unit.
    datums: Vec<f64>,
}

/// What the rest of the session needs to know of an axis.
#[derive(Clone, Debug)]
pub(crate) struct AxisInfo {
    pub(crate) id: AxisId,
    /// Axis units for one joint unit (mm or rad).
    pub(crate) units: f64,
    /// Whether it turns.
    pub(crate) rotary: bool,
    /// Total gap in axis units.
    pub(crate) gap: f64,
    pub(crate) current_limit_a: f64,
}

/// A variant: whether its gaps are closed, and its compensator.
#[derive(Clone, Debug)]
pub(crate) struct Variant {
    pub(crate) method: String,
    pub(crate) without_gap: bool,
}

impl Bank {
    /// Every axis at rest at `start` (joint positions).
    pub(crate) fn new(machine: &Machine, variants: &[Variant], start: &Coords) -> Result<Bank, SimError> {
        let axes: Vec<AxisInfo> = machine.axes().iter().map(AxisInfo::of).collect();
        let (mut runners, mut axis_of, mut datums) = (Vec::new(), Vec::new(), Vec::new());
        for variant in variants {
            for (index, axis) in machine.axes().iter().enumerate() {
                let error = |source| SimError::Axis { axis: axis.id, source };
                let config = if variant.without_gap { axis.config.without_gap() } else { axis.config.clone() };
                let at = start[axis.id] * axis.axis_units_per_joint_unit();
                let mut runner = build_runner(&config, &variant.method, at).map_err(error)?;
                settle(runner.as_mut(), at).map_err(error)?;
                runners.push(runner);
                axis_of.push(index);
                datums.push(datum(&config, at).map_err(error)?);
            }
        }
        let delay_ticks = runners.iter().map(|runner| runner.delay_ticks()).max().unwrap_or(0);
        let outputs = Outputs { lanes: runners.iter().map(|_| AxisOutput::new(false)).collect(), axes, datums };
        Ok(Bank { setpoints: vec![Vec::new(); outputs.axes.len()], batch: AxisBatch::new(runners), axis_of, delay_ticks, outputs })
    }

    /// CNC periods by which references lag behind setpoints; the largest of all axes.
    pub(crate) fn delay_ticks(&self) -> u32 {
        self.delay_ticks
    }

    /// Steps every lane through a chunk of samples; the outputs of the chunk before are gone.
    pub(crate) fn run(&mut self, samples: &[Sample]) -> Result<(), SimError> {
        for (info, setpoints) in self.outputs.axes.iter().zip(&mut self.setpoints) {
            setpoints.clear();
            setpoints.extend(samples.iter().map(|sample| {
                let id = info.id;
                Setpoint::moving(sample.position[id] * info.units, sample.velocity[id] * info.units, sample.acceleration[id] * info.units)
            }));
        }
        let setpoints: Vec<&[Setpoint]> = self.axis_of.iter().map(|axis| self.setpoints[*axis].as_slice()).collect();
        self.outputs.lanes.iter_mut().for_each(AxisOutput::clear);
        let results = self.batch.push(&setpoints, &mut self.outputs.lanes);
        for (axis, result) in self.axis_of.iter().zip(results) {
            result.map_err(|source| SimError::Axis { axis: self.outputs.axes[*axis].id, source })?;
        }
        Ok(())
    }
}

/// Lets an axis stand still at a place until it has come to rest; gives where its load then is.
fn settle(runner: &mut dyn AxisRunner, at: f64) -> Result<f64, AxisError> {
    let rest = Setpoint::moving(at, 0.0, 0.0);
    let mut output = AxisOutput::new(false);
    runner.push(&[rest; SETTLE_TICKS], &mut output)?;
    Ok(output.load.last().copied().unwrap_or(at))
}

/// The machine's zero of an axis: where people set it. A load that gravity holds on one flank is set up there, gap and wind-up included; one
/// that may lie on either flank is set up in the middle of its gap.
fn datum(config: &AxisConfig, at: f64) -> Result<f64, AxisError> {
    if config.reflected_load().constant_nm == 0.0 {
        return Ok(0.0);
    }
    let mut runner = build_runner(config, "none", at)?;
    Ok(settle(runner.as_mut(), at)? - at)
}

impl AxisInfo {
    fn of(axis: &MachineAxis) -> AxisInfo {
        AxisInfo {
            id: axis.id,
            units: axis.axis_units_per_joint_unit(),
            rotary: axis.is_rotary(),
            gap: axis.config.gap_in_unit(),
            current_limit_a: axis.config.drive.current_limit_a,
        }
    }
}

impl Outputs {
    pub(crate) fn axes(&self) -> &[AxisInfo] {
        &self.axes
    }

    /// Output of an axis of a variant for the last chunk.
    pub(crate) fn of(&self, variant: usize, axis: usize) -> &AxisOutput {
        &self.lanes[variant * self.axes.len() + axis]
    }

    /// Load position of an axis of a variant at a servo sample of the last chunk, in the axis' unit.
    pub(crate) fn load_of(&self, variant: usize, axis: usize, servo_sample: usize) -> f64 {
        self.of(variant, axis).load[servo_sample] - self.datums[variant * self.axes.len() + axis]
    }

    /// Joint positions of the loads of a variant at a servo sample of the last chunk.
    pub(crate) fn load(&self, variant: usize, servo_sample: usize) -> Coords {
        self.joints(|axis| self.load_of(variant, axis, servo_sample))
    }

    /// Joint positions of the references at a servo sample of the last chunk; the same for every variant.
    pub(crate) fn reference(&self, servo_sample: usize) -> Coords {
        self.joints(|axis| self.of(0, axis).reference[servo_sample])
    }

    fn joints(&self, value: impl Fn(usize) -> f64) -> Coords {
        let mut joints = Coords::ZERO;
        for (index, info) in self.axes.iter().enumerate() {
            joints[info.id] = value(index) / info.units;
        }
        joints
    }
}
