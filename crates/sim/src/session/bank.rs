//! All axes of all variants of the machine, stepped side by side.

use super::crew::{Crew, Stint};
use super::guard::{Guard, Rehearsals};
use super::outputs::{AxisInfo, Beam, Kept, LaneLayout, Outputs};
use super::variant::Variant;
use crate::error::SimError;
use crate::machine::{Machine, Memory};
use crate::motion::Modes;
use crate::observer::ForeseenContour;
use lostmotion_base::{Clock, Coords, threads};
use lostmotion_contour::ContourTracker;
use lostmotion_drive::{
    AxisBatch, AxisError, AxisOutput, AxisRunner, BlockMotion, Learning, Setpoint, Tie, TiedAxes,
};
use lostmotion_methods::{AxisConfig, AxisMemory, MethodId, build_runner};
use lostmotion_plan::Sample;
use std::collections::VecDeque;
use std::sync::Arc;

/// How long the machine stands still before the program, s: gravity pulls loads to their flank,
/// drives settle. A choice: many times the slowest loop's time constant of the embedded machines.
pub const SETTLE_S: f64 = 0.5;

/// Lanes that are stepped as one crew. A choice: those of a rehearsal on most machines, whose vectors are
/// as long as that.
const ONE_CREW: usize = AxisBatch::GROUP / 2;

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
        let drives = machine.drives();
        let axes: Vec<AxisInfo> = machine.axes().iter().map(AxisInfo::of).collect();
        let gantry = machine.gantry().and_then(|gantry| Beam::of(gantry, &axes));
        // One lane for each drive of each variant, settled under gravity at the start.
        let (mut lanes, count): (Vec<Lane>, usize) = (Vec::new(), axes.len());
        for variant in variants {
            let firsts = machine
                .axes()
                .iter()
                .enumerate()
                .map(|(drive, axis)| (drive, axis, &axis.config));
            let second = gantry.iter().filter_map(|beam| {
                Some((
                    axes.len(),
                    machine.axes().get(beam.axis)?,
                    &beam.gantry.second,
                ))
            });
            // The drives of the axes, then the second motor of a gantry, which has the same axis
            // and its own description.
            for (drive, axis, config) in firsts.chain(second) {
                let error = |source| SimError::Axis {
                    axis: axis.id,
                    source,
                };
                let remembered = memory.zip(drives.get(drive));
                let remembered =
                    remembered.and_then(|(memory, name)| memory.axis.get(name).copied());
                let config = variant.config(config, remembered);
                // Joints count in mm and rad, axes in the unit of their file (mm, deg, rad).
                let at = start[axis.id] * axis.axis_units_per_joint_unit();
                let mut runner = variant.runner(&config, at).map_err(error)?;
                // A program starts from rest: gravity has chosen the flank, integrators hold the
                // load.
                settle(runner.as_mut(), &config, at).map_err(error)?;
                let datum = datum(&config, at).map_err(error)?;
                lanes.push(Lane {
                    runner,
                    config,
                    drive,
                    datum,
                });
            }
        }
        // The most delayed lane decides how long the end of the program is drained.
        let delay_ticks = lanes
            .iter()
            .map(|lane| lane.runner.delay_ticks())
            .max()
            .unwrap_or(0);
        // The ends of a stiff beam push on each other each current period: they are stepped in
        // pairs, behind the lanes that are free of each other.
        let stiff = gantry
            .as_ref()
            .and_then(|beam| Some((beam.axis, beam.gantry.beam?)));
        let in_beam =
            |lane: &Lane| stiff.is_some_and(|(axis, _)| lane.drive == axis || lane.drive == count);
        // Variants whose compensators heed each other are a crew each, the others one together; lanes
        // so few that one vector holds them stay together, too.
        let drives = count + usize::from(gantry.is_some());
        let heeds: Vec<bool> = lanes
            .chunks(drives.max(1))
            .map(|lanes| {
                let mut free = lanes.iter().filter(|lane| !in_beam(lane));
                free.any(|lane| lane.runner.heeds_others())
            })
            .collect();
        let mut crews = 1;
        let crew_of: Vec<usize> = heeds
            .iter()
            .map(|heeds| {
                if lanes.len() <= ONE_CREW || !heeds {
                    return 0;
                }
                crews += 1;
                crews - 1
            })
            .collect();
        let mut order: Vec<usize> = (0..lanes.len()).collect();
        // A stable sort: free lanes of a crew keep their order and come first, so that one split
        // separates batch and beams. Every variant has as many lanes, one behind the other.
        order.sort_by_key(|lane| (crew_of[lane / drives.max(1)], in_beam(&lanes[*lane])));
        // The inverse permutation, for readers who ask by variant and axis.
        let mut lane_of = vec![0; lanes.len()];
        order
            .iter()
            .enumerate()
            .for_each(|(place, lane)| lane_of[*lane] = place);
        let layout = Arc::new(LaneLayout {
            lane_of,
            variant_of: order.iter().map(|lane| lane / drives.max(1)).collect(),
            datums: order.iter().map(|lane| lanes[*lane].datum).collect(),
            axes,
            gantry,
        });
        let mut lanes: Vec<Option<Lane>> = lanes.into_iter().map(Some).collect();
        let mut bank = Bank {
            crews: Vec::with_capacity(crews),
            crew_of,
            threads,
            ended: vec![false; variants.len()],
            setpoints: vec![Vec::new(); drives],
            command: machine.cycles().command(),
            delay_ticks,
            layout: Arc::clone(&layout),
            kept,
        };
        let mut first_lane = 0;
        for crew in 0..crews {
            let variant_of: Vec<usize> = layout.variant_of[first_lane..]
                .iter()
                .copied()
                .take_while(|variant| bank.crew_of[*variant] == crew)
                .collect();
            let mine = &order[first_lane..first_lane + variant_of.len()];
            let mine = mine.iter().filter_map(|lane| lanes[*lane].take());
            let mine: Vec<Lane> = mine.collect();
            let drive_of = mine.iter().map(|lane| lane.drive).collect();
            let (tied, free): (Vec<Lane>, Vec<Lane>) = mine.into_iter().partition(in_beam);
            let runners = free.into_iter().map(|lane| lane.runner).collect();
            let count = variant_of.len();
            bank.crews.push(Crew {
                batch: AxisBatch::new(runners, threads),
                beams: tie(tied, stiff, machine)?,
                first_lane,
                drive_of,
                variant_of,
                guards: Vec::new(),
                since_exchange: 0,
                time_s: 0.0,
                pending: VecDeque::new(),
                command: bank.command,
                delay_ticks,
                threads,
                layout: Arc::clone(&layout),
            });
            first_lane += count;
        }
        // With a memory corrections are used from the start as far as a rehearsal says, without one as
        // soon as they certainly help.
        for variant in (0..variants.len()).filter(|variant| heeds[*variant]) {
            let said = rehearsals.zip(memory);
            let said = said.and_then(|(asked, memory)| (asked.rehearse)(variant, memory, None));
            let guard = match (variants[variant].rehearsal(), said) {
                (Some((part, skips)), _) => Guard::fixed(count, part, skips.clone()),
                (None, Some(said)) => Guard::rehearsed(count, said),
                (None, None) => Guard::new(count, false),
            };
            bank.crews[bank.crew_of[variant]]
                .guards
                .push((variant, guard));
        }
        // What was foreseen while the machine settled is nobody's contour.
        bank.crews.iter_mut().for_each(Crew::begin);
        Ok(bank)
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

/// An axis of a variant that is being set up.
struct Lane {
    runner: Box<dyn AxisRunner>,
    config: AxisConfig,
    drive: usize,
    datum: f64,
}

/// Ties the ends of a stiff beam, two and two, as they stand.
fn tie(
    ends: Vec<Lane>,
    stiff: Option<(usize, Tie)>,
    machine: &Machine,
) -> Result<Vec<TiedAxes>, SimError> {
    let Some((axis, tie)) = stiff else {
        return Ok(Vec::new());
    };
    let axis = machine.axes()[axis].id;
    let (mut beams, mut ends) = (Vec::new(), ends.into_iter());
    // The two ends of a variant come one behind the other.
    while let (Some(first), Some(second)) = (ends.next(), ends.next()) {
        let beam = TiedAxes::new(
            [first.runner, second.runner],
            [&first.config, &second.config],
            tie,
        );
        beams.push(beam.map_err(|source| SimError::Axis {
            axis,
            source: source.into(),
        })?);
    }
    Ok(beams)
}

/// Lets an axis stand still at a place until it has come to rest; gives where its load then is.
fn settle(runner: &mut dyn AxisRunner, config: &AxisConfig, at: f64) -> Result<f64, AxisError> {
    let rest = Setpoint::moving(at, 0.0, 0.0);
    let mut output = AxisOutput::new(false);
    // Command cycles in the time for settling.
    let ticks = (SETTLE_S / config.cycles.command().period_s()).round() as usize;
    runner.push(&vec![rest; ticks], &mut output)?;
    Ok(output.load.last().copied().unwrap_or(at))
}

/// The machine's zero of an axis: where people set it. A load that gravity holds on one flank is
/// set up there, gap and wind-up included; one that may lie on either flank is set up in the middle
/// of its gap.
fn datum(config: &AxisConfig, at: f64) -> Result<f64, AxisError> {
    if config.reflected_load().constant_nm == 0.0 {
        return Ok(0.0);
    }
    // The zero is set with the bare drive: a compensator would already shift the load.
    let mut runner = build_runner(config, MethodId::NONE, at)?;
    Ok(settle(runner.as_mut(), config, at)? - at)
}
