//! All axes of all variants of the machine, stepped side by side.

use super::guard::{Guard, Rehearsals};
use super::outputs::{AxisInfo, Beam, Kept, LaneLayout, Outputs};
use super::skips::Skips;
use crate::error::SimError;
use crate::machine::{Machine, Memory};
use crate::method::Choice;
use crate::motion::Modes;
use crate::observer::ForeseenContour;
use lostmotion_base::{Clock, Coords, threads};
use lostmotion_contour::ContourTracker;
use lostmotion_drive::config::{Load, Reflected};
use lostmotion_drive::{
    AxisBatch, AxisError, AxisOutput, AxisRunner, BlockMotion, Learned, Learning, Setpoint, Tie,
    TiedAxes,
};
use lostmotion_methods::{AxisConfig, AxisMemory, MethodId, Misled, build_runner};
use lostmotion_plan::Sample;
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

/// How long the machine stands still before the program, s: gravity pulls loads to their flank,
/// drives settle. A choice: many times the slowest loop's time constant of the embedded machines.
pub const SETTLE_S: f64 = 0.5;

/// Time between two exchanges of how ready the compensators of a machine's axes are, s. A choice:
/// shorter than it takes to change what is compensated on a flank.
const EXCHANGE_S: f64 = 0.05;

/// The machine in several variants (without a gap, and with each method), all on the same
/// setpoints.
pub(crate) struct Bank {
    /// Variant by variant, each with one lane an axis, and then one for the second motor of a
    /// gantry; without the ends of a stiff beam.
    batch: AxisBatch,
    /// By variant, the ends of a stiff beam, whose lanes come last, two and two.
    beams: Vec<TiedAxes>,
    /// Threads that the lanes are stepped on.
    threads: usize,
    /// The drive of each lane.
    drive_of: Vec<usize>,
    /// The variant of each lane.
    variant_of: Vec<usize>,
    /// By variant, whether its machine has stopped: its lanes stay where they are.
    ended: Vec<bool>,
    /// By drive: the axes, and then the second motor of a gantry.
    setpoints: Vec<Vec<Setpoint>>,
    /// Command cycles between two exchanges of how ready the axes' compensators are; 0 where none
    /// asks.
    exchange_cycles: usize,
    /// Command cycles since the last one.
    since_exchange: usize,
    /// Time of the motion so far, s.
    time_s: f64,
    /// By variant, whether its compensators may correct; `None` where none asks.
    guards: Vec<Option<Guard>>,
    /// Samples of the plan that references have yet to reach, oldest first, as far as guards need
    /// them.
    pending: VecDeque<Sample>,
    command: Clock,
    delay_ticks: u32,
    layout: Arc<LaneLayout>,
    kept: Kept,
}

/// A variant of the machine: its compensator, or the machine without a gap and without one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Variant<'a> {
    choice: Option<&'a Choice>,
    misled: Option<Misled>,
    /// Of a machine that is rehearsed: its loads and gaps are those of the memory, and this part of
    /// the correction is used, but for these stretches.
    rehearsed: Option<(f64, &'a Skips)>,
}

impl<'a> Variant<'a> {
    /// Closed gaps, no compensator.
    pub(crate) fn without_gap() -> Variant<'a> {
        Variant {
            choice: None,
            misled: None,
            rehearsed: None,
        }
    }

    /// The machine as it is, with a compensator.
    pub(crate) fn with_gap(choice: &'a Choice) -> Variant<'a> {
        Variant {
            choice: Some(choice),
            misled: None,
            rehearsed: None,
        }
    }

    /// The machine as its drives have learned it, with a part of the correction of a compensator, but for
    /// some stretches.
    pub(super) fn rehearsed(choice: &'a Choice, part: f64, skips: &'a Skips) -> Variant<'a> {
        Variant {
            rehearsed: Some((part, skips)),
            ..Variant::with_gap(choice)
        }
    }

    /// Its compensator.
    pub(super) fn choice(&self) -> Option<&'a Choice> {
        self.choice
    }

    /// The same, whose drives are told something wrong.
    pub(crate) fn misled(choice: &'a Choice, misled: Misled) -> Variant<'a> {
        Variant {
            choice: Some(choice),
            misled: Some(misled),
            rehearsed: None,
        }
    }

    /// Whether its control watches the motors: the machine without a gap is there for comparison
    /// alone.
    pub(crate) fn is_watched(&self) -> bool {
        self.choice.is_some()
    }

    /// The description of a drive in this variant, with what it starts from.
    fn config(&self, config: &AxisConfig, learned: Option<AxisMemory>) -> AxisConfig {
        let mut config = match (self.choice, self.rehearsed) {
            (None, _) => config.without_gap(),
            (Some(_), None) => config.clone(),
            (Some(_), Some(_)) => as_learned(config, learned.map(|memory| memory.learned)),
        };
        config.compensation.learned = learned;
        config
    }

    /// A drive of this variant, from its description.
    fn runner(&self, config: &AxisConfig, at: f64) -> Result<Box<dyn AxisRunner>, AxisError> {
        match (self.choice, self.misled) {
            (None, _) => build_runner(config, MethodId::NONE, at),
            (Some(choice), None) => choice.runner(config, at),
            (Some(choice), Some(misled)) => choice.misled(config, misled, at),
        }
    }
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
        let mut order: Vec<usize> = (0..lanes.len()).collect();
        // A stable sort: free lanes keep their order and come first, so that one split separates
        // batch and beams.
        order.sort_by_key(|lane| in_beam(&lanes[*lane]));
        // The inverse permutation, for readers who ask by variant and axis.
        let mut lane_of = vec![0; lanes.len()];
        order
            .iter()
            .enumerate()
            .for_each(|(place, lane)| lane_of[*lane] = place);
        let layout = LaneLayout {
            lane_of,
            datums: order.iter().map(|lane| lanes[*lane].datum).collect(),
            axes,
            gantry,
        };
        let drive_of = order.iter().map(|lane| lanes[*lane].drive).collect();
        // Every variant has as many lanes, one behind the other.
        let drives = count + usize::from(layout.gantry.is_some());
        let variant_of: Vec<usize> = order.iter().map(|lane| lane / drives.max(1)).collect();
        let (tied, free): (Vec<Lane>, Vec<Lane>) = lanes.into_iter().partition(in_beam);
        let beams = tie(tied, stiff, machine)?;
        let mut batch = AxisBatch::new(free.into_iter().map(|lane| lane.runner).collect(), threads);
        // With a memory corrections are used from the start as far as a rehearsal says, without one as
        // soon as they certainly help.
        let mut guards: Vec<Option<Guard>> = variants.iter().map(|_| None).collect();
        for (lane, axis) in batch.axes().enumerate() {
            let variant = variant_of[lane];
            if axis.heeds_others() && guards[variant].is_none() {
                let said = rehearsals.zip(memory);
                let said = said.and_then(|(asked, memory)| (asked.rehearse)(variant, memory, None));
                guards[variant] = Some(match (variants[variant].rehearsed, said) {
                    (Some((part, skips)), _) => Guard::fixed(count, part, skips.clone()),
                    (None, Some(said)) => Guard::rehearsed(count, said),
                    (None, None) => Guard::new(count, false),
                });
            }
        }
        let heeded = guards.iter().any(Option::is_some);
        for (lane, axis) in batch.axes_mut().enumerate() {
            // What was foreseen while the machine settled is nobody's contour.
            let share = guards[variant_of[lane]].as_ref().map_or(1.0, Guard::share);
            axis.heed(share);
        }
        Ok(Bank {
            exchange_cycles: if heeded {
                ((EXCHANGE_S / machine.cycles().command().period_s()).round() as usize).max(1)
            } else {
                0
            },
            guards,
            pending: VecDeque::new(),
            command: machine.cycles().command(),
            since_exchange: 0,
            time_s: 0.0,
            setpoints: vec![Vec::new(); drives],
            batch,
            beams,
            threads,
            drive_of,
            variant_of,
            ended: vec![false; variants.len()],
            delay_ticks,
            layout: Arc::new(layout),
            kept,
        })
    }

    /// Number of variants.
    pub(crate) fn variants(&self) -> usize {
        self.ended.len()
    }

    /// What the drives of a variant have learned, by their number.
    pub(crate) fn learning(&self, variant: usize) -> Vec<Option<Learning>> {
        let of = |runner: &dyn AxisRunner| runner.learning();
        self.of_drives(variant, of)
    }

    /// What the control foresees of a variant.
    pub(crate) fn foreseen(&self, variant: usize) -> Option<ForeseenContour> {
        let guard = self.guards.get(variant)?.as_ref()?;
        Some(guard.foreseen(self.command))
    }

    /// What the drives of a variant have learned for good.
    pub(crate) fn learned(&self, variant: usize, machine: &Machine) -> Memory {
        self.memory(variant, machine, AxisMemory::new)
    }

    /// What the drives of a variant have learned, by name.
    fn memory(
        &self,
        variant: usize,
        machine: &Machine,
        keep: fn(Learned, &AxisConfig) -> AxisMemory,
    ) -> Memory {
        let of = |runner: &dyn AxisRunner| runner.learned();
        let mut memory = Memory::default();
        for (name, learned) in machine
            .drives()
            .into_iter()
            .zip(self.of_drives(variant, of))
        {
            if let Some((learned, config)) = learned.zip(machine.drive(&name)) {
                memory.axis.insert(name, keep(learned, config));
            }
        }
        memory
    }

    fn of_drives<T>(&self, variant: usize, of: impl Fn(&dyn AxisRunner) -> T) -> Vec<T> {
        // Free lanes first, then the ends of beams: the order of the outputs.
        let beams = self.beams.iter().flat_map(TiedAxes::axes);
        let runners: Vec<&dyn AxisRunner> = self.batch.axes().chain(beams).collect();
        let lanes = self.layout.lanes_of(variant).iter();
        lanes
            .filter_map(|lane| runners.get(*lane))
            .map(|runner| of(*runner))
            .collect()
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
            lanes: self.variant_of.iter().map(empty).collect(),
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
        // Stretches end where compensators tell each other how ready they are, at the same times
        // whatever the length of a chunk.
        let (count, mut from) = (samples.len(), 0);
        while from < count {
            let to = match self.exchange_cycles {
                0 => count,
                cycles => count.min(from + cycles - self.since_exchange),
            };
            self.step(from..to, &mut outputs.lanes)?;
            self.since_exchange += to - from;
            self.time_s += (to - from) as f64 * self.command.period_s();
            if self.exchange_cycles > 0 {
                self.pending.extend(&samples[from..to]);
            }
            if self.since_exchange == self.exchange_cycles {
                self.judge(path);
                if let Some(rehearsals) = rehearsals {
                    self.ask(rehearsals);
                }
                self.exchange();
                self.since_exchange = 0;
            }
            from = to;
        }
        Ok(())
    }

    /// The oldest command that something may yet be asked of: of the segments before its own nothing
    /// is needed any more.
    pub(crate) fn oldest_pending(&self) -> Option<&Sample> {
        let held = self.guards.iter().flatten().filter_map(Guard::oldest);
        held.chain(self.pending.front())
            .min_by_key(|sample| sample.tick)
    }

    /// Shows each guard what the drives of its variant have foreseen since the last exchange.
    fn judge(&mut self, path: (&ContourTracker, &Modes)) {
        let (cycles, delay) = (self.exchange_cycles, self.delay_ticks as usize);
        let foreseen: Vec<&[Option<[f64; 2]>]> =
            self.batch.axes().map(AxisRunner::foreseen).collect();
        // A cycle shows the axes under the command of the delay before; those before the first
        // command are left out.
        let first = (cycles + delay).saturating_sub(self.pending.len());
        for (variant, guard) in self.guards.iter_mut().enumerate() {
            let Some(guard) = guard.as_mut().filter(|_| !self.ended[variant]) else {
                continue;
            };
            let lanes = self.layout.lanes_of(variant);
            // What an axis foresees of the time before, now that it knows.
            for (info, lane) in self.layout.axes.iter().zip(lanes) {
                let places = foreseen.get(*lane).copied().unwrap_or_default();
                let before = places.len().saturating_sub(cycles);
                guard.recall(info, &places[..before]);
            }
            guard.catch_up(self.command, path);
            for (sample, cycle) in self.pending.iter().zip(first..cycles) {
                let mut pair = [sample.position; 2];
                for (info, lane) in self.layout.axes.iter().zip(lanes) {
                    let places = foreseen
                        .get(*lane)
                        .and_then(|places| places.get(cycle + places.len().saturating_sub(cycles)));
                    // An axis that foresees nothing counts as if it were where it has to be.
                    let Some(places) = places else { continue };
                    // What is not known is not a number.
                    let places = places.unwrap_or([f64::NAN; 2]);
                    for (joints, place) in pair.iter_mut().zip(places) {
                        joints[info.id] = place * info.units_per_rad / info.units;
                    }
                }
                guard.take(sample, &pair, (&self.layout.axes, self.command), path);
            }
            guard.decide();
            if let Some(newest) = self.pending.back() {
                guard.reach((newest.segment, newest.s));
            }
        }
        let answered = self.pending.len().saturating_sub(delay);
        self.pending.drain(..answered);
    }

    /// Has variants rehearsed whose drives have learned more.
    fn ask(&mut self, rehearsals: &Rehearsals<'_>) {
        for variant in 0..self.guards.len() {
            let may_ask = |guard: &Guard| guard.may_ask();
            if self.ended[variant] || !self.guards[variant].as_ref().is_some_and(may_ask) {
                continue;
            }
            let memory = self.memory(variant, rehearsals.machine, AxisMemory::so_far);
            if let Some(guard) = &mut self.guards[variant]
                && guard.asks(&memory)
            {
                let said = (rehearsals.rehearse)(variant, &memory, Some(self.time_s));
                guard.told(memory, said);
            }
        }
    }

    /// Tells each compensator the least readiness of the other axes of its variant.
    fn exchange(&mut self) {
        let ready: Vec<(usize, Option<f64>)> = self
            .variant_of
            .iter()
            .zip(self.batch.axes())
            .map(|(variant, axis)| (*variant, axis.readiness()))
            .collect();
        for (lane, axis) in self.batch.axes_mut().enumerate() {
            let others = ready
                .iter()
                .enumerate()
                .filter_map(|(other, (variant, ready))| {
                    if other != lane && *variant == self.variant_of[lane] {
                        *ready
                    } else {
                        None
                    }
                });
            let guard = self.guards[self.variant_of[lane]].as_ref();
            axis.heed(others.fold(guard.map_or(1.0, Guard::share), f64::min));
        }
    }

    /// Steps every lane through a stretch of the chunk's setpoints.
    fn step(&mut self, stretch: Range<usize>, outputs: &mut [AxisOutput]) -> Result<(), SimError> {
        // Variants differ in their lanes, never in their setpoints: lanes of one drive share a
        // slice. A lane without setpoints stays where it is.
        let setpoints: Vec<&[Setpoint]> = self
            .drive_of
            .iter()
            .zip(&self.variant_of)
            .map(|(drive, variant)| match self.ended[*variant] {
                true => &[],
                false => &self.setpoints[*drive][stretch.clone()],
            })
            .collect();
        let free = self.batch.len();
        let (lanes, ends) = outputs.split_at_mut(free);
        let (drive_of, infos) = (&self.drive_of, (&self.layout.axes, &self.layout.gantry));
        // An error names the axis; the second motor counts as the gantry's axis.
        let named = |lane: usize, source| {
            let (axes, gantry) = infos;
            let second = gantry.as_ref().map_or(0, |beam| beam.axis);
            SimError::Axis {
                axis: axes.get(drive_of[lane]).unwrap_or(&axes[second]).id,
                source,
            }
        };
        for (lane, result) in self
            .batch
            .push(&setpoints[..free], lanes)
            .into_iter()
            .enumerate()
        {
            result.map_err(|source| named(lane, source))?;
        }
        // The ends of a beam exchange force each current period and cannot run in separate lanes of
        // the batch.
        type Ends<'a> = (
            (&'a mut TiedAxes, &'a mut [AxisOutput]),
            &'a [&'a [Setpoint]],
        );
        let step = |((beam, ends), setpoints): Ends<'_>| match (ends, setpoints) {
            ([first, second], [a, b]) => beam
                .push([a, b], [first, second])
                .map_err(|(_, source)| source),
            _ => Ok(()),
        };
        let tied = &setpoints[free..];
        let beams = self
            .beams
            .iter_mut()
            .zip(ends.chunks_mut(2))
            .zip(tied.chunks(2));
        let results = threads::map(self.threads, beams, step);
        results
            .into_iter()
            .enumerate()
            .try_for_each(|(beam, result)| result.map_err(|source| named(free + 2 * beam, source)))
    }
}

/// An axis as its drive has learned it: what it has not is a load as heavy as the motor, without
/// friction and gap.
fn as_learned(config: &AxisConfig, learned: Option<Learned>) -> AxisConfig {
    let told = config.reflected_load();
    let learned = learned.unwrap_or(Learned {
        load_inertia_kgm2: config.motor_side_inertia_kgm2(),
        ..Learned::default()
    });
    AxisConfig {
        load: Load::Reflected(Reflected {
            inertia_kgm2: learned.load_inertia_kgm2,
            viscous_nm_s_per_rad: learned.viscous_nm_s_per_rad,
            coulomb_nm: learned.coulomb_nm,
            constant_nm: learned.constant_nm,
            gap_rad: 2.0 * learned.half_gap_rad,
            ..told
        }),
        drift: Default::default(),
        ..config.clone()
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
