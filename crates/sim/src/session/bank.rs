//! All axes of all variants of the machine, stepped side by side.

use super::crew::{Crew, Stint};
use super::guard::{Guard, Rehearsals};
use super::lane::{Grouping, StiffBeam, lanes};
use super::outputs::{AxisInfo, Beam, Kept, LaneLayout, Outputs};
use super::variant::Variant;
use crate::error::SimError;
use crate::machine::{Machine, Memory};
use crate::motion::Modes;
use crate::observer::ForeseenContour;
use lostmotion_base::{Clock, Coords, threads};
use lostmotion_contour::ContourTracker;
use lostmotion_drive::{AxisBatch, AxisOutput, AxisRunner, BlockMotion, Learning, Setpoint};
use lostmotion_methods::AxisMemory;
use lostmotion_plan::Sample;
use std::collections::VecDeque;
use std::sync::Arc;

/// The machine in several variants (without a gap, and with each method), all on the same
/// setpoints.
pub(crate) struct Bank {
    /// The variants whose compensators heed nobody, and one for each of the others.
    crews: Vec<Crew>,
    /// The crew of each variant.
    crew_of: Vec<usize>,
    threads: usize,
    /// By variant, whether its machine has stopped: its lanes stay where they are.
    ended: Vec<bool>,
    /// By drive: the axes, and then the second motor of a gantry.
    setpoints: Vec<Vec<Setpoint>>,
    command: Clock,
    delay_ticks: u32,
    layout: Arc<LaneLayout>,
    kept: Kept,
}

impl Bank {
    /// Every axis at rest at `start` (joint positions).
    pub(crate) fn new(
        machine: &Machine,
        variants: &[Variant<'_>],
        start: &Coords,
        (threads, kept): (usize, Kept),
        memory: Option<&Memory>,
        rehearsals: Option<&Rehearsals<'_>>,
    ) -> Result<Bank, SimError> {
        let axes: Vec<AxisInfo> = machine.axes().iter().map(AxisInfo::of).collect();
        let gantry = machine.gantry().and_then(|gantry| Beam::of(gantry, &axes));
        let lanes = lanes(machine, variants, start, memory, gantry.as_ref())?;
        // The most delayed lane decides how long the end of the program is drained.
        let delay_ticks = lanes
            .iter()
            .map(|lane| lane.runner.delay_ticks())
            .max()
            .unwrap_or(0);
        let (drives, count) = (machine.drives().len(), axes.len());
        let stiff = StiffBeam::of(gantry.as_ref(), &axes);
        let grouping = Grouping::of(&lanes, drives, stiff);
        let layout = Arc::new(grouping.layout(&lanes, axes, gantry));
        let command = machine.cycles().command();
        let mut crews: Vec<Crew> = Vec::with_capacity(grouping.crews);
        for members in grouping.divide(lanes, machine)? {
            crews.push(Crew {
                first_lane: crews.iter().map(Crew::lanes).sum(),
                batch: AxisBatch::new(members.free, threads),
                beams: members.beams,
                drive_of: members.drive_of,
                variant_of: members.variant_of,
                guards: Vec::new(),
                since_exchange: 0,
                time_s: 0.0,
                pending: VecDeque::new(),
                command,
                delay_ticks,
                threads,
                layout: Arc::clone(&layout),
            });
        }
        // With a memory corrections are used from the start as far as a rehearsal says, without one as
        // soon as they certainly help.
        for variant in (0..variants.len()).filter(|variant| grouping.heeds[*variant]) {
            let said = rehearsals.zip(memory);
            let said = said.and_then(|(asked, memory)| (asked.rehearse)(variant, memory, None));
            let guard = match (variants[variant].rehearsal(), said) {
                (Some((part, skips)), _) => Guard::fixed(count, part, skips.clone()),
                (None, Some(said)) => Guard::rehearsed(count, said),
                (None, None) => Guard::new(count, false),
            };
            crews[grouping.crew_of[variant]]
                .guards
                .push((variant, guard));
        }
        // What was foreseen while the machine settled is nobody's contour.
        crews.iter_mut().for_each(Crew::begin);
        Ok(Bank {
            crews,
            crew_of: grouping.crew_of,
            threads,
            ended: vec![false; variants.len()],
            setpoints: vec![Vec::new(); drives],
            command,
            delay_ticks,
            layout,
            kept,
        })
    }

    /// Number of variants.
    pub(crate) fn variants(&self) -> usize {
        self.ended.len()
    }

    /// The crew of a variant.
    fn crew(&self, variant: usize) -> Option<&Crew> {
        self.crews.get(*self.crew_of.get(variant)?)
    }

    /// What the drives of a variant have learned, by their number.
    pub(crate) fn learning(&self, variant: usize) -> Vec<Option<Learning>> {
        let of = |runner: &dyn AxisRunner| runner.learning();
        self.crew(variant)
            .map_or_else(Vec::new, |crew| crew.of_drives(variant, of))
    }

    /// What the control foresees of a variant.
    pub(crate) fn foreseen(&self, variant: usize) -> Option<ForeseenContour> {
        let guard = self.crew(variant)?.guard(variant)?;
        Some(guard.foreseen(self.command))
    }

    /// What the drives of a variant have learned for good.
    pub(crate) fn learned(&self, variant: usize, machine: &Machine) -> Memory {
        self.crew(variant).map_or_else(Memory::default, |crew| {
            crew.memory(variant, machine, AxisMemory::new)
        })
    }

    /// Command cycles by which references lag behind setpoints; the largest of all axes.
    pub(crate) fn delay_ticks(&self) -> u32 {
        self.delay_ticks
    }

    /// Whether a variant's machine has stopped.
    pub(crate) fn has_ended(&self, variant: usize) -> bool {
        self.ended.get(variant).is_some_and(|ended| *ended)
    }

    /// Ends a variant whose machine has stopped: nothing of it is simulated from the next chunk on.
    pub(crate) fn end(&mut self, variant: usize) {
        if let Some(ended) = self.ended.get_mut(variant) {
            *ended = true;
        }
    }

    /// Outputs of all lanes, empty.
    pub(crate) fn outputs(&self) -> Outputs {
        let empty = |variant: &usize| match (1..=self.kept.motors).contains(variant) {
            true => AxisOutput::with_motor(),
            false => AxisOutput::new(self.kept.trace),
        };
        Outputs {
            layout: Arc::clone(&self.layout),
            lanes: self.layout.variant_of.iter().map(empty).collect(),
        }
    }

    /// Steps every lane through a chunk of samples and appends to its output. `forces` has the force
    /// on each joint's load (N or N m) for each sample, or is empty. On the path guards measure.
    pub(crate) fn run(
        &mut self,
        samples: &[Sample],
        forces: &[Coords],
        outputs: &mut Outputs,
        path: (&ContourTracker, &Modes),
        rehearsals: Option<&Rehearsals<'_>>,
    ) -> Result<(), SimError> {
        let blocks: Vec<BlockMotion> = samples
            .iter()
            .map(|sample| BlockMotion {
                // A segment that is not known any more has been left behind at rest.
                rapid: path
                    .0
                    .segment(sample.segment)
                    .is_some_and(|segment| segment.rapid),
                path_speed_mm_s: sample.path_speed,
            })
            .collect();
        // Joint units of the plan to axis units, with the load's share of the cutting force.
        for (info, setpoints) in self.layout.axes.iter().zip(&mut self.setpoints) {
            setpoints.clear();
            setpoints.extend(samples.iter().enumerate().map(|(n, sample)| {
                let (id, units) = (info.id, info.units);
                let load_force = forces.get(n).map(|force| force[id]);
                let moving = Setpoint::moving(
                    sample.position[id] * units,
                    sample.velocity[id] * units,
                    sample.acceleration[id] * units,
                );
                Setpoint {
                    load_force,
                    block: blocks.get(n).copied(),
                    ..moving
                }
            }));
        }
        // Both motors follow one command; the cutting force is divided by the lever rule of the
        // tool's place on the beam.
        if let Some(beam) = &self.layout.gantry {
            beam.share_forces(samples, &mut self.setpoints);
        }
        let stint = Stint {
            samples,
            setpoints: &self.setpoints,
            ended: &self.ended,
            path,
            rehearsals,
        };
        let mut rest = outputs.lanes.as_mut_slice();
        let crews: Vec<(&mut Crew, &mut [AxisOutput])> = self
            .crews
            .iter_mut()
            .map(|crew| {
                let (mine, others) = std::mem::take(&mut rest).split_at_mut(crew.lanes());
                rest = others;
                (crew, mine)
            })
            .collect();
        let run = |(crew, outputs): (&mut Crew, &mut [AxisOutput])| crew.run(stint, outputs);
        // In the order of the crews, so that the first error does not depend on the number of threads.
        let results = threads::map(self.threads, crews.into_iter(), run);
        results.into_iter().collect()
    }

    /// The oldest command that something may yet be asked of: of the segments before its own nothing
    /// is needed any more.
    pub(crate) fn oldest_pending(&self) -> Option<&Sample> {
        let pending = self.crews.iter().flat_map(Crew::oldest_pending);
        pending.min_by_key(|sample| sample.tick)
    }
}
