//! The machine in all its variants, stepped through the program chunk by chunk: plan, forces, axes,
//! servo ticks. What is made of the ticks is others' business: the judge of a run, or a
//! [`TickSink`].
//!
//! While the axes take a chunk whoever judges looks at the one before, and the plan goes on ahead (`ahead`):
//! three jobs that share nothing, side by side where there are threads, in turn where there is one.

use super::ahead::Ahead;
use super::bank::Bank;
use super::cutting::Cutting;
use super::frame::{Aligner, Frame};
use super::guard::Rehearsals;
use super::monitor::{Monitor, Stop};
use super::outputs::{Kept, Outputs};
use super::variant::Variant;
use crate::error::{SimError, SinkError};
use crate::limiter::{Along, Limiter};
use crate::motion::{Feed, Modes};
use crate::observer::{ForeseenContour, Progress};
use crate::results::{LimitsUsed, PlanInfo};
use crate::setup::Setup;
use lostmotion_base::{AxisId, Clock, Coords, Tick, threads};
use lostmotion_contour::{ContourError, ContourInput, ContourSample, ContourTracker, FootState};
use lostmotion_drive::{AxisSample, Learning};
use lostmotion_plan::Sample;

/// A chunk of the plan, and what the axes have made of it.
pub(crate) struct Chunk {
    samples: Vec<Sample>,
    /// By sample, what limits the motion up to it; empty where nobody asks.
    limiters: Vec<Option<Limiter>>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) modes: Modes,
    pub(crate) outputs: Outputs,
    /// Whether the plan is over, so that only the delayed reference is still under way.
    over: bool,
    /// How far the program is at its end.
    pub(crate) progress: Progress,
    /// By variant, what its drives know at its end, in the order of
    /// [`Machine::drives`](crate::Machine::drives); empty where nobody asks.
    pub(crate) learning: Vec<Vec<Option<Learning>>>,
    /// By variant, what the control foresees at its end; empty where nobody asks.
    pub(crate) foreseen: Vec<Option<ForeseenContour>>,
    /// By variant, whether its machine stops in it.
    pub(crate) stops: Vec<Option<Stop>>,
}

impl Chunk {
    fn new(modes: &Modes, bank: &Bank) -> Chunk {
        Chunk {
            samples: Vec::new(),
            limiters: Vec::new(),
            frames: Vec::new(),
            modes: modes.clone(),
            outputs: bank.outputs(),
            over: false,
            progress: Progress::default(),
            learning: Vec::new(),
            foreseen: Vec::new(),
            stops: Vec::new(),
        }
    }

    /// Segment and place on it at its end.
    pub(crate) fn place(&self) -> Option<(u64, f64)> {
        let last = self.frames.last()?;
        Some((last.sample.segment, last.sample.s))
    }
}

/// A machine on its way through a program.
pub(crate) struct Stepper {
    ahead: Ahead,
    /// Whether there is a chunk before.
    begun: bool,
    cutting: Option<Cutting>,
    pub(crate) tracker: ContourTracker,
    aligner: Aligner,
    pub(crate) bank: Bank,
    /// The last chunk that the axes took, and the one before, which is judged meanwhile.
    pub(crate) chunk: Chunk,
    before: Chunk,
    total_bytes: u64,
    command: Clock,
    max_duration_s: f64,
    threads: usize,
    /// Whether what the drives know is kept with each chunk.
    with_learning: bool,
    /// By variant, what watches its motors, if anything does.
    monitors: Vec<Option<Monitor>>,
    /// Number of samples planned.
    pub(crate) count: Tick,
    /// Largest commanded speed of each joint.
    pub(crate) peak_velocity: Coords,
    /// Range of each joint.
    pub(crate) range: [Coords; 2],
}

impl Stepper {
    /// At rest at the start of the program.
    pub(crate) fn new(
        setup: &Setup<'_>,
        variants: &[Variant<'_>],
        threads: usize,
        kept: Kept,
        rehearsals: Option<&Rehearsals<'_>>,
    ) -> Result<Stepper, SimError> {
        let (machine, options) = (setup.machine, setup.options);
        let feed = if kept.limiters {
            Feed::timed(setup)?
        } else {
            Feed::new(setup)?
        }
        .on_threads(threads);
        let start = feed.start_joints();
        // The axes settle at the first position before any sample comes.
        let memory = options.learned.as_deref();
        let bank = Bank::new(
            machine,
            variants,
            &start,
            (threads, kept),
            memory,
            rehearsals,
        )?;
        let along = kept.limiters.then(|| Along::new(setup, feed.modes()));
        let letters = machine.axes().iter().map(|axis| axis.id).collect();
        Ok(Stepper {
            cutting: Cutting::new(
                options
                    .cutting_force_n
                    .unwrap_or(machine.simulate().cutting_force_n),
                machine.rotary_joints(),
                letters,
            ),
            begun: false,
            tracker: ContourTracker::new(options.contour),
            aligner: Aligner::new(bank.delay_ticks(), machine.cycles().servo_ticks()),
            chunk: Chunk::new(feed.modes(), &bank),
            before: Chunk::new(feed.modes(), &bank),
            total_bytes: setup.program.len().unwrap_or(0),
            command: machine.cycles().command(),
            max_duration_s: options.max_duration_s,
            threads,
            with_learning: kept.learning,
            monitors: variants
                .iter()
                .map(|variant| {
                    let choice = variant.choice().filter(|_| kept.stops)?;
                    Some(Monitor::new(machine, choice))
                })
                .collect(),
            count: 0,
            peak_velocity: Coords::ZERO,
            range: [start, start],
            bank,
            ahead: Ahead::new(feed, along, options.chunk_samples, threads),
        })
    }

    /// Takes the next chunk of the plan through all axes; the answer is false once the plan is over
    /// and the delayed references have arrived, too. `beside` looks at the chunk before meanwhile,
    /// if there is one.
    ///
    /// # Errors
    /// Those of the planner and the axes; a program that runs longer than allowed.
    pub(crate) fn step<T: Send>(
        &mut self,
        rehearsals: Option<&Rehearsals<'_>>,
        beside: impl FnOnce(&mut Chunk, &ContourTracker) -> T + Send,
    ) -> (Option<T>, Result<bool, SimError>) {
        std::mem::swap(&mut self.chunk, &mut self.before);
        let is_first = !self.begun;
        self.begun = true;
        let begun = self.begin();
        let Stepper {
            tracker,
            aligner,
            bank,
            chunk,
            before,
            monitors,
            ..
        } = self;
        // Read by those who judge and by those who guard.
        let tracker = &*tracker;
        let look = || (!is_first).then(|| beside(before, tracker));
        let forces = match begun {
            Ok(forces) => forces,
            Err(error) => return (look(), Err(error)),
        };
        let (over, with_learning) = (chunk.over, self.with_learning);
        let axes = || {
            let path = (tracker, &chunk.modes);
            bank.run(
                &chunk.samples,
                &forces,
                &mut chunk.outputs,
                path,
                rehearsals,
            )?;
            let outputs = &chunk.outputs;
            // Each servo tick is paired with the command that it answers to, the delay taken out.
            aligner.frames(
                (&chunk.samples, &chunk.limiters),
                &chunk.modes,
                |at| outputs.reference(at),
                &mut chunk.frames,
            );
            chunk.stops.clear();
            for (variant, monitor) in monitors.iter_mut().enumerate() {
                let running = monitor.as_mut().filter(|_| !bank.has_ended(variant));
                let stop = running
                    .and_then(|monitor| monitor.chunk(&chunk.frames, &chunk.outputs, variant));
                // A machine that has stopped does nothing more that counts.
                if stop.is_some() {
                    bank.end(variant);
                }
                chunk.stops.push(stop);
            }
            if with_learning {
                chunk.learning.clear();
                let variants = 0..bank.variants();
                chunk
                    .learning
                    .extend(variants.clone().map(|n| bank.learning(n)));
                chunk.foreseen.clear();
                chunk.foreseen.extend(variants.map(|n| bank.foreseen(n)));
            }
            Ok(())
        };
        let (axes, looked) = threads::join(self.threads, axes, look);
        (looked, axes.map(|()| !over))
    }

    /// Makes the planned samples the chunk at work; gives the forces on the loads.
    fn begin(&mut self) -> Result<Vec<Coords>, SimError> {
        // Endless programs end here: every other resource of a run is bounded by the chunk.
        if self.command.seconds(self.count) > self.max_duration_s {
            return Err(SimError::TooLong {
                limit_s: self.max_duration_s,
            });
        }
        let mut planned = self.ahead.next();
        if let Some(error) = planned.error.take() {
            return Err(error);
        }
        // The tracker has to know a segment before the first sample that names it.
        for segment in planned.segments.drain(..) {
            self.tracker.push(segment)?;
        }
        let chunk = &mut self.chunk;
        std::mem::swap(&mut chunk.samples, &mut planned.samples);
        std::mem::swap(&mut chunk.limiters, &mut planned.limiters);
        chunk.modes.clone_from(&planned.modes);
        chunk.outputs.go_on_from(&self.before.outputs);
        // The reference lags behind the plan by the interpolator's delay: as many samples at rest
        // as the slowest axis' is late push the last setpoints through.
        chunk.over = chunk.samples.is_empty();
        if chunk.over {
            let rest = planned.last.map(|last| Sample {
                velocity: Coords::ZERO,
                acceleration: Coords::ZERO,
                path_speed: 0.0,
                ..last
            });
            let delay = self.bank.delay_ticks() as usize;
            let late = |rest| std::iter::repeat_n(rest, delay);
            chunk.samples.extend(rest.into_iter().flat_map(late));
        }
        self.count += chunk.samples.len() as Tick;
        let bytes_done = planned.bytes_done;
        self.ahead.done_with(planned);
        chunk.progress = Progress {
            // What stands behind the program's end is not read.
            done_bytes: if chunk.over {
                bytes_done.max(self.total_bytes)
            } else {
                bytes_done
            },
            total_bytes: self.total_bytes,
            simulated_s: self.command.seconds(self.count),
        };
        for sample in &chunk.samples {
            for axis in 0..self.peak_velocity.0.len() {
                self.peak_velocity.0[axis] =
                    self.peak_velocity.0[axis].max(sample.velocity.0[axis].abs());
                self.range[0].0[axis] = self.range[0].0[axis].min(sample.position.0[axis]);
                self.range[1].0[axis] = self.range[1].0[axis].max(sample.position.0[axis]);
            }
        }
        // Forces from the commanded motion, not from the simulated one: the same for every variant,
        // so that methods are compared under one load.
        Ok(self.cutting.as_ref().map_or(Vec::new(), |cutting| {
            cutting.forces(&chunk.samples, &self.tracker, &chunk.modes)
        }))
    }

    /// The last chunk that was looked at: the one before that which the axes took last, or at the
    /// end that one.
    pub(crate) fn looked_at(&self, is_end: bool) -> &Chunk {
        if is_end { &self.chunk } else { &self.before }
    }

    /// The largest parts of its limits that a motor of a variant has used, by its place among the
    /// drives.
    pub(crate) fn limits_used(&self, variant: usize, drive: usize) -> Option<LimitsUsed> {
        self.monitors.get(variant)?.as_ref()?.used(drive)
    }

    /// Tells how straight the tool goes, what the plan falls short of, and which interventions came after the
    /// end of the motion.
    pub(crate) fn tell(&self, plan: &mut PlanInfo) {
        self.ahead.tell(plan);
    }

    /// Forgets segments that no sample behind a place can touch, and no guard; gives the first that is
    /// kept.
    pub(crate) fn release(&mut self, place: Option<(u64, f64)>) -> Option<u64> {
        let judged = place?;
        let pending = self.bank.oldest_pending();
        let (segment, s) = pending
            .map(|sample| (sample.segment, sample.s))
            .filter(|(segment, _)| *segment < judged.0)
            .unwrap_or(judged);
        self.tracker.release(segment, s)
    }
}

/// Takes the servo ticks of all axes, chunk by chunk, before anything is made of them: for studies
/// that measure in another way than [`crate::Simulation::run`].
pub trait TickSink: Send {
    /// Takes a chunk.
    ///
    /// # Errors
    /// Ends the run with [`SimError::Sink`].
    fn chunk(&mut self, ticks: &Ticks<'_>) -> Result<(), SinkError>;
}

/// The servo ticks of a chunk of the plan. Variant 0 is the machine without a gap and without a
/// compensator, variant n the nth method.
pub struct Ticks<'a> {
    stepper: &'a Stepper,
}

impl<'a> Ticks<'a> {
    /// Those of the stepper's last chunk.
    pub(crate) fn of(stepper: &'a Stepper) -> Ticks<'a> {
        Ticks { stepper }
    }

    /// Samples of the plan in this chunk, a command cycle each.
    pub fn samples(&self) -> &'a [Sample] {
        &self.stepper.chunk.samples
    }

    /// Whether the plan is over: the samples are the last one at rest, repeated until the delayed
    /// reference has arrived.
    pub fn is_over(&self) -> bool {
        self.stepper.chunk.over
    }

    /// The servo ticks, each with the command that it answers to.
    pub fn frames(&self) -> &'a [Frame] {
        &self.stepper.chunk.frames
    }

    /// Joint positions of the loads of a variant, mm and rad.
    pub fn load(&self, variant: usize, frame: &Frame) -> Coords {
        self.stepper.chunk.outputs.load(variant, frame.servo_sample)
    }

    /// All signals of an axis of a variant; `None` where the run keeps no trace or the machine has
    /// no such axis.
    pub fn trace(&self, variant: usize, axis: AxisId, frame: &Frame) -> Option<&'a AxisSample> {
        let outputs = &self.stepper.chunk.outputs;
        let index = outputs.axes().iter().position(|info| info.id == axis)?;
        let trace = outputs.of(variant, index).trace.as_ref()?;
        trace.get(frame.servo_sample)
    }

    /// What the drives of a variant know at the end of the chunk, in the order of
    /// [`Machine::drives`](crate::Machine::drives).
    pub fn learning(&self, variant: usize) -> Vec<Option<Learning>> {
        self.stepper.bank.learning(variant)
    }

    /// Servo ticks since the start at which a drive of a variant was at its current or voltage
    /// limit: of the axis with most of them.
    pub fn saturated(&self, variant: usize) -> u64 {
        let outputs = &self.stepper.chunk.outputs;
        (0..outputs.axes().len())
            .map(|axis| outputs.of(variant, axis).saturated_samples)
            .max()
            .unwrap_or(0)
    }

    /// The contour error of a tip, mm, that should be at a frame's command; `commanded` is where it
    /// should be, and `foot` the place on the path found last for this tip.
    ///
    /// # Errors
    /// A tip that is not a number; frames of a chunk before.
    pub fn measure(
        &self,
        foot: &mut FootState,
        frame: &Frame,
        [commanded, actual]: [[f64; 3]; 2],
    ) -> Result<ContourSample, ContourError> {
        // The direction of the tool is not judged here: both are the command's.
        self.stepper.tracker.measure(
            foot,
            &ContourInput {
                tick: frame.tick,
                segment: frame.sample.segment,
                s: frame.sample.s,
                actual_tip_mm: actual,
                commanded_tip_mm: commanded,
                actual_axis: frame.pose.axis,
                commanded_axis: frame.pose.axis,
            },
        )
    }
}
