//! The lanes of some variants, through a chunk of the plan side by side. Those of a variant whose
//! compensators heed each other are a crew of their own: they meet every 50 ms, and nobody else waits
//! for them.

use super::guard::{Guard, Rehearsals};
use super::outputs::LaneLayout;
use crate::error::SimError;
use crate::machine::{Machine, Memory};
use crate::motion::Modes;
use lostmotion_base::{Clock, threads};
use lostmotion_contour::ContourTracker;
use lostmotion_drive::{AxisBatch, AxisOutput, AxisRunner, Heeded, Learned, Setpoint, TiedAxes};
use lostmotion_methods::{AxisConfig, AxisMemory};
use lostmotion_plan::Sample;
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

/// Time between two exchanges of how ready the compensators of a machine's axes are, s. A choice:
/// shorter than it takes to change what is compensated on a flank.
const EXCHANGE_S: f64 = 0.05;

/// Lanes of some variants.
pub(super) struct Crew {
    /// Variant by variant, each with one lane an axis, and then one for the second motor of a
    /// gantry; without the ends of a stiff beam.
    pub(super) batch: AxisBatch,
    /// By variant, the ends of a stiff beam, whose lanes come last, two and two.
    pub(super) beams: Vec<TiedAxes>,
    /// Its first lane among all lanes.
    pub(super) first_lane: usize,
    /// The drive of each lane.
    pub(super) drive_of: Vec<usize>,
    /// The variant of each lane.
    pub(super) variant_of: Vec<usize>,
    /// The variants whose compensators heed each other, and whether they may correct.
    pub(super) guards: Vec<(usize, Guard)>,
    /// Command cycles since compensators told each other last how ready they are.
    pub(super) since_exchange: usize,
    /// Time of the motion so far, s.
    pub(super) time_s: f64,
    /// Samples of the plan that references have yet to reach, oldest first, as far as guards need
    /// them.
    pub(super) pending: VecDeque<Sample>,
    pub(super) command: Clock,
    /// Command cycles by which references lag behind setpoints.
    pub(super) delay_ticks: u32,
    /// Threads that the lanes are stepped on.
    pub(super) threads: usize,
    pub(super) layout: Arc<LaneLayout>,
}

/// What all crews take of a chunk.
#[derive(Clone, Copy)]
pub(super) struct Stint<'a> {
    pub(super) samples: &'a [Sample],
    /// By drive: the axes, and then the second motor of a gantry.
    pub(super) setpoints: &'a [Vec<Setpoint>],
    /// By variant, whether its machine has stopped: its lanes stay where they are.
    pub(super) ended: &'a [bool],
    /// The path on which guards measure.
    pub(super) path: (&'a ContourTracker, &'a Modes),
    pub(super) rehearsals: Option<&'a Rehearsals<'a>>,
}

impl Crew {
    /// Number of its lanes.
    pub(super) fn lanes(&self) -> usize {
        self.drive_of.len()
    }

    /// The guard of a variant.
    pub(super) fn guard(&self, variant: usize) -> Option<&Guard> {
        let mut guards = self.guards.iter();
        guards.find_map(|(guarded, guard)| (*guarded == variant).then_some(guard))
    }

    /// Tells each compensator how far it may correct: what the guard says of its variant.
    pub(super) fn begin(&mut self) {
        let shares: Vec<f64> = self
            .variant_of
            .iter()
            .map(|variant| self.share(*variant))
            .collect();
        for (allowed, axis) in shares.into_iter().zip(self.batch.axes_mut()) {
            axis.heed(Heeded {
                allowed,
                waits: false,
                aside: false,
                others: None,
            });
        }
    }

    fn share(&self, variant: usize) -> f64 {
        self.guard(variant).map_or(1.0, Guard::share)
    }

    /// Command cycles between two exchanges; `None` where no compensator asks.
    fn exchange_cycles(&self) -> Option<usize> {
        let cycles = (EXCHANGE_S / self.command.period_s()).round() as usize;
        (!self.guards.is_empty()).then_some(cycles.max(1))
    }

    /// Steps every lane through a chunk of samples and appends to its output.
    pub(super) fn run(
        &mut self,
        stint: Stint<'_>,
        outputs: &mut [AxisOutput],
    ) -> Result<(), SimError> {
        let count = stint.samples.len();
        let Some(cycles) = self.exchange_cycles() else {
            return self.step(&stint, 0..count, outputs);
        };
        // Stretches end where compensators tell each other how ready they are, at the same times
        // whatever the length of a chunk.
        let mut from = 0;
        while from < count {
            let to = count.min(from + cycles - self.since_exchange);
            self.step(&stint, from..to, outputs)?;
            self.since_exchange += to - from;
            self.time_s += (to - from) as f64 * self.command.period_s();
            self.pending.extend(&stint.samples[from..to]);
            if self.since_exchange == cycles {
                self.judge(cycles, &stint);
                if let Some(rehearsals) = stint.rehearsals {
                    self.ask(rehearsals, stint.ended);
                }
                self.exchange();
                self.since_exchange = 0;
            }
            from = to;
        }
        Ok(())
    }

    /// The samples that something may yet be asked of.
    pub(super) fn oldest_pending(&self) -> impl Iterator<Item = &Sample> {
        let held = self.guards.iter().filter_map(|(_, guard)| guard.oldest());
        held.chain(self.pending.front())
    }

    /// Shows each guard what the drives of its variant have foreseen since the last exchange.
    fn judge(&mut self, cycles: usize, stint: &Stint<'_>) {
        let (path, delay) = (stint.path, self.delay_ticks as usize);
        let foreseen: Vec<&[Option<[f64; 2]>]> =
            self.batch.axes().map(AxisRunner::foreseen).collect();
        // A cycle shows the axes under the command of the delay before; those before the first
        // command are left out.
        let first = (cycles + delay).saturating_sub(self.pending.len());
        for (variant, guard) in &mut self.guards {
            if stint.ended[*variant] {
                continue;
            }
            let lanes = self.layout.lanes_of(*variant);
            let lanes = lanes.iter().map(|lane| lane - self.first_lane);
            let axes = self.layout.axes.iter().zip(lanes);
            // What an axis foresees of the time before, now that it knows.
            for (info, lane) in axes.clone() {
                let places = foreseen.get(lane).copied().unwrap_or_default();
                let before = places.len().saturating_sub(cycles);
                guard.recall(info, &places[..before]);
            }
            guard.catch_up(self.command, path);
            for (sample, cycle) in self.pending.iter().zip(first..cycles) {
                let mut pair = [sample.position; 2];
                for (info, lane) in axes.clone() {
                    let places = foreseen
                        .get(lane)
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
    fn ask(&mut self, rehearsals: &Rehearsals<'_>, ended: &[bool]) {
        for index in 0..self.guards.len() {
            let (variant, guard) = &self.guards[index];
            if ended[*variant] || !guard.may_ask() {
                continue;
            }
            let memory = self.memory(*variant, rehearsals.machine, AxisMemory::so_far);
            if guard.asks(&memory) {
                let said = (rehearsals.rehearse)(*variant, &memory, Some(self.time_s));
                self.guards[index].1.told(memory, said);
            }
        }
    }

    /// Tells each compensator what the guard allows, and the least readiness of the other axes of its variant.
    fn exchange(&mut self) {
        let ready: Vec<(usize, Option<f64>)> = self
            .variant_of
            .iter()
            .zip(self.batch.axes())
            .map(|(variant, axis)| (*variant, axis.readiness()))
            .collect();
        let heeded = |lane: usize| {
            let variant = self.variant_of[lane];
            let others = ready.iter().enumerate();
            let others = others.filter(|(other, (theirs, _))| *other != lane && *theirs == variant);
            let guard = self.guard(variant);
            let mut lanes = self.layout.lanes_of(variant).iter();
            let axis = lanes.position(|of| *of == lane + self.first_lane);
            Heeded {
                allowed: guard.map_or(1.0, Guard::part),
                waits: guard.is_some_and(Guard::waits),
                aside: guard
                    .zip(axis)
                    .is_some_and(|(guard, axis)| guard.is_aside(axis)),
                others: others.filter_map(|(_, (_, ready))| *ready).reduce(f64::min),
            }
        };
        let heeded: Vec<Heeded> = (0..ready.len()).map(heeded).collect();
        for (heeded, axis) in heeded.into_iter().zip(self.batch.axes_mut()) {
            axis.heed(heeded);
        }
    }

    /// Steps every lane through a stretch of the chunk's setpoints.
    fn step(
        &mut self,
        stint: &Stint<'_>,
        stretch: Range<usize>,
        outputs: &mut [AxisOutput],
    ) -> Result<(), SimError> {
        // Variants differ in their lanes, never in their setpoints: lanes of one drive share a
        // slice. A lane without setpoints stays where it is.
        let setpoints: Vec<&[Setpoint]> = self
            .drive_of
            .iter()
            .zip(&self.variant_of)
            .map(|(drive, variant)| match stint.ended[*variant] {
                true => &[],
                false => &stint.setpoints[*drive][stretch.clone()],
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

    /// What the drives of a variant have learned, by name.
    pub(super) fn memory(
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

    /// What there is of each drive of one of its variants.
    pub(super) fn of_drives<T>(&self, variant: usize, of: impl Fn(&dyn AxisRunner) -> T) -> Vec<T> {
        // Free lanes first, then the ends of beams: the order of the outputs.
        let beams = self.beams.iter().flat_map(TiedAxes::axes);
        let runners: Vec<&dyn AxisRunner> = self.batch.axes().chain(beams).collect();
        let lanes = self.layout.lanes_of(variant).iter();
        lanes
            .filter_map(|lane| runners.get(lane.checked_sub(self.first_lane)?))
            .map(|runner| of(*runner))
            .collect()
    }
}
