//! What all axes of all variants did in the last chunk, as the rest of the session asks for it.

use crate::machine::{Gantry, MachineAxis};
use crate::observer::MotorPoint;
use lostmotion_base::{AxisId, Coords};
use lostmotion_drive::config::AxisUnit;
use lostmotion_drive::{AxisOutput, Setpoint};
use lostmotion_plan::Sample;
use std::sync::Arc;

/// What all lanes did in a chunk.
#[derive(Clone, Debug)]
pub(crate) struct Outputs {
    pub(super) layout: Arc<LaneLayout>,
    pub(super) lanes: Vec<AxisOutput>,
}

/// Which lane is which.
#[derive(Debug)]
pub(crate) struct LaneLayout {
    pub(super) axes: Vec<AxisInfo>,
    /// Lane of each axis of each variant, and behind them that of the second motor of a gantry.
    pub(super) lane_of: Vec<usize>,
    /// The variant of each lane.
    pub(super) variant_of: Vec<usize>,
    /// Where each lane's load stands when its command is 0, in the axis' unit.
    pub(super) datums: Vec<f64>,
    pub(super) gantry: Option<Beam>,
}

/// A gantry among the lanes.
#[derive(Debug)]
pub(super) struct Beam {
    pub(super) gantry: Gantry,
    pub(super) axis: usize,
    pub(super) along: usize,
}

impl Beam {
    pub(super) fn of(gantry: &Gantry, axes: &[AxisInfo]) -> Option<Beam> {
        let index = |id| axes.iter().position(|axis| axis.id == id);
        Some(Beam {
            gantry: gantry.clone(),
            axis: index(gantry.axis)?,
            along: index(gantry.along)?,
        })
    }

    /// Gives the second motor the setpoints of the first, and each its part of the force by the
    /// place of the tool along the beam.
    pub(super) fn share_forces(&self, samples: &[Sample], setpoints: &mut [Vec<Setpoint>]) {
        let (Some(first), count) = (setpoints.get(self.axis).cloned(), setpoints.len()) else {
            return;
        };
        let [axis, second] = [self.axis, count - 1];
        setpoints[second] = first;
        for (n, sample) in samples.iter().enumerate() {
            // Lever rule: the nearer end takes the larger part, both together the whole.
            let share = self.gantry.share(sample.position[self.gantry.along]);
            for (drive, part) in [(axis, 1.0 - share), (second, share)] {
                let force = &mut setpoints[drive][n].load_force;
                *force = force.map(|force| force * part);
            }
        }
    }
}

/// What is kept with each chunk.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Kept {
    /// All signals of every axis.
    pub(crate) trace: bool,
    /// The motors of so many methods: those of the variants from 1 on.
    pub(crate) motors: usize,
    /// What the drives know.
    pub(crate) learning: bool,
    /// What limits the motion.
    pub(crate) limiters: bool,
    /// Where the machine of a method stops: nothing of it is simulated from the next chunk on.
    pub(crate) stops: bool,
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
    /// Unit of its description.
    pub(crate) unit: AxisUnit,
    /// Axis units for one radian of its motor.
    pub(crate) units_per_rad: f64,
}

impl AxisInfo {
    pub(super) fn of(axis: &MachineAxis) -> AxisInfo {
        AxisInfo {
            id: axis.id,
            units: axis.axis_units_per_joint_unit(),
            rotary: axis.is_rotary(),
            gap: axis.config.gap_in_unit(),
            current_limit_a: axis.config.drive.current_limit_a,
            unit: axis.config.unit(),
            units_per_rad: 1.0 / axis.config.transmission.motor_rad_per_unit(),
        }
    }
}

impl LaneLayout {
    /// The lanes of all drives of a variant, in their order.
    pub(super) fn lanes_of(&self, variant: usize) -> &[usize] {
        let drives = self.axes.len() + usize::from(self.gantry.is_some());
        self.lane_of
            .get(variant * drives..(variant + 1) * drives)
            .unwrap_or_default()
    }
}

impl Outputs {
    /// Forgets the samples; counts and peaks go on from those of another chunk.
    pub(super) fn go_on_from(&mut self, before: &Outputs) {
        for (lane, before) in self.lanes.iter_mut().zip(&before.lanes) {
            lane.go_on_from(before);
        }
    }

    pub(crate) fn axes(&self) -> &[AxisInfo] {
        &self.layout.axes
    }

    /// Output of an axis of a variant for the last chunk.
    pub(crate) fn of(&self, variant: usize, axis: usize) -> &AxisOutput {
        &self.lanes[self.lane(variant, axis)]
    }

    /// Lane of an axis of a variant; that of the second motor of a gantry follows those of the
    /// axes.
    #[inline]
    fn lane(&self, variant: usize, axis: usize) -> usize {
        self.layout.lane_of
            [variant * (self.layout.axes.len() + usize::from(self.layout.gantry.is_some())) + axis]
    }

    /// Output of the second motor of an axis of a variant, if it has one, and the current limit of
    /// its drive, A.
    pub(crate) fn second_of(&self, variant: usize, axis: usize) -> Option<(&AxisOutput, f64)> {
        let beam = self
            .layout
            .gantry
            .as_ref()
            .filter(|beam| beam.axis == axis)?;
        let limit_a = beam.gantry.second.drive.current_limit_a;
        // Its lane follows those of the axes.
        Some((self.of(variant, self.layout.axes.len()), limit_a))
    }

    /// How far the first end of a gantry is ahead of the second, in its unit; and its axis.
    pub(crate) fn skew(&self, variant: usize, servo_sample: usize) -> Option<f64> {
        let beam = self.layout.gantry.as_ref()?;
        Some(
            self.end(variant, beam.axis, servo_sample)
                - self.end(variant, self.layout.axes.len(), servo_sample),
        )
    }

    /// Signals of all motors of a variant at servo samples of the last chunk, with their times, sample
    /// by sample, in place of what was there; none where the lanes keep none.
    pub(crate) fn motors(
        &self,
        variant: usize,
        samples: impl Iterator<Item = (usize, f64)>,
        points: &mut Vec<MotorPoint>,
    ) {
        // The second motor of a gantry has its axis' unit and, as its lane, the place behind all
        // axes; its transmission may be its own.
        let second = self.layout.gantry.as_ref().and_then(|beam| {
            let per_rad = 1.0 / beam.gantry.second.transmission.motor_rad_per_unit();
            let info = self.layout.axes.get(beam.axis)?;
            Some((info, per_rad, self.layout.axes.len(), true))
        });
        let firsts = self.layout.axes.iter().enumerate();
        let firsts = firsts.map(|(index, info)| (info, info.units_per_rad, index, false));
        let motors: Vec<_> = firsts
            .chain(second)
            .filter_map(|(info, per_rad, place, second)| {
                let lane = self.lane(variant, place);
                let (output, datum) = (&self.lanes[lane], self.layout.datums[lane]);
                let motor = output.motor.as_ref()?;
                Some((info, per_rad, second, output, motor, datum))
            })
            .collect();
        points.clear();
        for (servo_sample, time_s) in samples {
            for (info, per_rad, second, output, motor, datum) in &motors {
                let Some(sample) = motor.get(servo_sample) else {
                    continue;
                };
                points.push(MotorPoint {
                    time_s,
                    axis: info.id,
                    second: *second,
                    unit: info.unit,
                    reference: output.reference[servo_sample],
                    motor: sample.position * per_rad,
                    load: output.load[servo_sample] - datum,
                    current_a: sample.current,
                    torque_nm: sample.torque,
                    engagement: sample.engagement,
                });
            }
        }
    }

    /// The axis of a gantry.
    pub(crate) fn gantry_axis(&self) -> Option<usize> {
        self.layout.gantry.as_ref().map(|beam| beam.axis)
    }

    /// Load position of one motor.
    #[inline]
    fn end(&self, variant: usize, axis: usize, servo_sample: usize) -> f64 {
        let lane = self.lane(variant, axis);
        self.lanes[lane].load[servo_sample] - self.layout.datums[lane]
    }

    /// Load position of an axis of a variant at a servo sample of the last chunk, in the axis'
    /// unit.
    #[inline]
    pub(crate) fn load_of(&self, variant: usize, axis: usize, servo_sample: usize) -> f64 {
        let first = self.end(variant, axis, servo_sample);
        match &self.layout.gantry {
            Some(beam) if beam.axis == axis => self.on_beam(beam, first, variant, servo_sample),
            _ => first,
        }
    }

    /// Where the tool is between the ends of a gantry, of which the first is here. Apart, so that
    /// the other axes' loads are read in place.
    #[inline(never)]
    fn on_beam(&self, beam: &Beam, first: f64, variant: usize, servo_sample: usize) -> f64 {
        // The tool sits on the beam like on a lever between its ends.
        let share = beam
            .gantry
            .share(self.end(variant, beam.along, servo_sample));
        // Linear between the ends: the beam itself is taken to be straight.
        first + share * (self.end(variant, self.layout.axes.len(), servo_sample) - first)
    }

    /// Joint positions of the loads of a variant at a servo sample of the last chunk.
    pub(crate) fn load(&self, variant: usize, servo_sample: usize) -> Coords {
        self.joints(|axis| self.load_of(variant, axis, servo_sample))
    }

    /// Joint positions of the references at a servo sample of the last chunk; the same for every
    /// variant.
    pub(crate) fn reference(&self, servo_sample: usize) -> Coords {
        self.joints(|axis| self.of(0, axis).reference[servo_sample])
    }

    fn joints(&self, value: impl Fn(usize) -> f64) -> Coords {
        let mut joints = Coords::ZERO;
        for (index, info) in self.layout.axes.iter().enumerate() {
            // Axis units to mm and rad.
            joints[info.id] = value(index) / info.units;
        }
        joints
    }
}
