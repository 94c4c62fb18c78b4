//! All axes of all variants of the machine, stepped side by side.

use crate::error::SimError;
use crate::machine::{Gantry, Machine, MachineAxis};
use lostmotion_axis::{AxisBatch, AxisConfig, AxisError, AxisOutput, AxisRunner, Setpoint, build_runner};
use lostmotion_base::{AxisId, Coords};
use lostmotion_plan::Sample;

/// How long the machine stands still before the program, s: gravity pulls loads to their flank, drives settle.
const SETTLE_S: f64 = 0.5;

/// The machine in several variants (without a gap, and with each method), all on the same setpoints.
pub(crate) struct Bank {
    /// Variant by variant, each with one lane an axis, and then one for the second motor of a gantry.
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
    gantry: Option<Beam>,
}

/// A gantry among the lanes.
#[derive(Debug)]
struct Beam {
    gantry: Gantry,
    axis: usize,
    along: usize,
}

impl Beam {
    fn of(gantry: &Gantry, axes: &[AxisInfo]) -> Option<Beam> {
        let index = |id| axes.iter().position(|axis| axis.id == id);
        Some(Beam { gantry: gantry.clone(), axis: index(gantry.axis)?, along: index(gantry.along)? })
    }
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
        let gantry = machine.gantry().and_then(|gantry| Beam::of(gantry, &axes));
        let (mut runners, mut axis_of, mut datums) = (Vec::new(), Vec::new(), Vec::new());
        for variant in variants {
            let firsts = machine.axes().iter().enumerate().map(|(index, axis)| (index, axis, &axis.config));
            let second = gantry.iter().filter_map(|beam| Some((beam.axis, machine.axes().get(beam.axis)?, &beam.gantry.second)));
            for (index, axis, config) in firsts.chain(second) {
                let error = |source| SimError::Axis { axis: axis.id, source };
                let config = if variant.without_gap { config.without_gap() } else { config.clone() };
                let at = start[axis.id] * axis.axis_units_per_joint_unit();
                let mut runner = build_runner(&config, &variant.method, at).map_err(error)?;
                settle(runner.as_mut(), &config, at).map_err(error)?;
                runners.push(runner);
                axis_of.push(index);
                datums.push(datum(&config, at).map_err(error)?);
            }
        }
        let delay_ticks = runners.iter().map(|runner| runner.delay_ticks()).max().unwrap_or(0);
        let outputs = Outputs { lanes: runners.iter().map(|_| AxisOutput::new(false)).collect(), axes, datums, gantry };
        Ok(Bank { setpoints: vec![Vec::new(); outputs.axes.len()], batch: AxisBatch::new(runners), axis_of, delay_ticks, outputs })
    }

    /// Command cycles by which references lag behind setpoints; the largest of all axes.
    pub(crate) fn delay_ticks(&self) -> u32 {
        self.delay_ticks
    }

    /// Steps every lane through a chunk of samples, with a force on each joint's load (N or N m) for each, or with none; the outputs of the chunk before
    /// are gone.
    pub(crate) fn run(&mut self, samples: &[Sample], forces: &[Coords]) -> Result<(), SimError> {
        for (info, setpoints) in self.outputs.axes.iter().zip(&mut self.setpoints) {
            // the motors of a gantry share it
            let motors = self.outputs.axes.iter().filter(|other| other.id == info.id).count() as f64;
            setpoints.clear();
            setpoints.extend(samples.iter().enumerate().map(|(n, sample)| {
                let (id, units) = (info.id, info.units);
                let load_force = forces.get(n).map(|force| force[id] / motors);
                let moving = Setpoint::moving(sample.position[id] * units, sample.velocity[id] * units, sample.acceleration[id] * units);
                Setpoint { load_force, ..moving }
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
fn settle(runner: &mut dyn AxisRunner, config: &AxisConfig, at: f64) -> Result<f64, AxisError> {
    let rest = Setpoint::moving(at, 0.0, 0.0);
    let mut output = AxisOutput::new(false);
    let ticks = (SETTLE_S / config.cycles.command().period_s()).round() as usize;
    runner.push(&vec![rest; ticks], &mut output)?;
    Ok(output.load.last().copied().unwrap_or(at))
}

/// The machine's zero of an axis: where people set it. A load that gravity holds on one flank is set up there, gap and wind-up included; one
/// that may lie on either flank is set up in the middle of its gap.
fn datum(config: &AxisConfig, at: f64) -> Result<f64, AxisError> {
    if config.reflected_load().constant_nm == 0.0 {
        return Ok(0.0);
    }
    let mut runner = build_runner(config, "none", at)?;
    Ok(settle(runner.as_mut(), config, at)? - at)
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
        &self.lanes[self.lane(variant, axis)]
    }

    /// Lane of an axis of a variant; that of the second motor of a gantry follows those of the axes.
    fn lane(&self, variant: usize, axis: usize) -> usize {
        variant * (self.axes.len() + usize::from(self.gantry.is_some())) + axis
    }

    /// Output of the second motor of an axis of a variant, if it has one.
    pub(crate) fn second_of(&self, variant: usize, axis: usize) -> Option<&AxisOutput> {
        self.gantry.as_ref().filter(|beam| beam.axis == axis).map(|_| self.of(variant, self.axes.len()))
    }

    /// How far the first end of a gantry is ahead of the second, in its unit; and its axis.
    pub(crate) fn skew(&self, variant: usize, servo_sample: usize) -> Option<f64> {
        let beam = self.gantry.as_ref()?;
        Some(self.end(variant, beam.axis, servo_sample) - self.end(variant, self.axes.len(), servo_sample))
    }

    /// The axis of a gantry.
    pub(crate) fn gantry_axis(&self) -> Option<usize> {
        self.gantry.as_ref().map(|beam| beam.axis)
    }

    /// Load position of one motor.
    fn end(&self, variant: usize, axis: usize, servo_sample: usize) -> f64 {
        let lane = self.lane(variant, axis);
        self.lanes[lane].load[servo_sample] - self.datums[lane]
    }

    /// Load position of an axis of a variant at a servo sample of the last chunk, in the axis' unit.
    pub(crate) fn load_of(&self, variant: usize, axis: usize, servo_sample: usize) -> f64 {
        let first = self.end(variant, axis, servo_sample);
        let Some(beam) = self.gantry.as_ref().filter(|beam| beam.axis == axis) else { return first };
        let share = beam.gantry.share(self.end(variant, beam.along, servo_sample));
        first + share * (self.end(variant, self.axes.len(), servo_sample) - first)
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
