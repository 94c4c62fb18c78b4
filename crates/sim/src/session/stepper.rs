//! The machine in all its variants, stepped through the program chunk by chunk: plan, forces, axes,
//! servo ticks. What is made of the ticks is others' business: the judge of a run, or a
//! [`TickSink`].

use super::bank::{Bank, Variant};
use super::cutting::Cutting;
use super::frame::{Aligner, Frame};
use crate::error::{SimError, SinkError};
use crate::motion::{Feed, Modes};
use crate::observer::Progress;
use crate::setup::Setup;
use lostmotion_base::{AxisId, Clock, Coords, Tick};
use lostmotion_contour::{
    ContourError, ContourInput, ContourSample, ContourTracker, FootState, ProgrammedSegment,
};
use lostmotion_drive::{AxisSample, Learning};
use lostmotion_plan::Sample;

/// A machine on its way through a program.
pub(crate) struct Stepper {
    pub(crate) feed: Feed,
    pub(crate) modes: Modes,
    cutting: Option<Cutting>,
    pub(crate) tracker: ContourTracker,
    aligner: Aligner,
    pub(crate) bank: Bank,
    pub(crate) frames: Vec<Frame>,
    samples: Vec<Sample>,
    segments: Vec<ProgrammedSegment>,
    total_bytes: u64,
    command: Clock,
    chunk_samples: usize,
    max_duration_s: f64,
    /// Whether the plan is over, so that only the delayed reference is still under way.
    over: bool,
    /// Number of samples planned.
    pub(crate) count: Tick,
    /// Largest commanded speed of each joint.
    pub(crate) peak_velocity: Coords,
    /// Range of each joint.
    pub(crate) range: [Coords; 2],
}

impl Stepper {
    /// At rest at the start of the program; with a trace of all signals of every axis if asked.
    pub(crate) fn new(
        setup: &Setup<'_>,
        variants: &[Variant<'_>],
        threads: usize,
        with_trace: bool,
    ) -> Result<Stepper, SimError> {
        let (machine, options) = (setup.machine, setup.options);
        let feed = Feed::new(setup)?;
        let start = feed.start_joints();
        // The axes settle at the first position before any sample comes.
        let memory = options.learned.as_deref();
        let bank = Bank::new(machine, variants, &start, (threads, with_trace), memory)?;
        let letters = machine.axes().iter().map(|axis| axis.id).collect();
        Ok(Stepper {
            cutting: Cutting::new(
                options
                    .cutting_force_n
                    .unwrap_or(machine.simulate().cutting_force_n),
                machine.rotary_joints(),
                letters,
            ),
            modes: feed.modes().clone(),
            tracker: ContourTracker::new(options.contour),
            aligner: Aligner::new(bank.delay_ticks(), machine.cycles().servo_ticks()),
            frames: Vec::new(),
            samples: Vec::new(),
            segments: Vec::new(),
            total_bytes: setup.program.len().unwrap_or(0),
            command: machine.cycles().command(),
            chunk_samples: options.chunk_samples,
            max_duration_s: options.max_duration_s,
            over: false,
            count: 0,
            peak_velocity: Coords::ZERO,
            range: [start, start],
            bank,
            feed,
        })
    }

    /// Takes the next chunk of the plan through all axes. False once the plan is over and the
    /// delayed references have arrived, too.
    ///
    /// # Errors
    /// Those of the planner and the axes; a program that runs longer than allowed.
    pub(crate) fn step(&mut self) -> Result<bool, SimError> {
        // Endless programs end here: every other resource of a run is bounded by the chunk.
        if self.command.seconds(self.count) > self.max_duration_s {
            return Err(SimError::TooLong {
                limit_s: self.max_duration_s,
            });
        }
        self.feed
            .chunk(self.chunk_samples, &mut self.samples, &mut self.segments)?;
        // The tracker has to know a segment before the first sample that names it.
        for segment in self.segments.drain(..) {
            self.tracker.push(segment)?;
        }
        self.modes.clone_from(self.feed.modes());
        // The reference lags behind the plan by the interpolator's delay: samples at rest push the
        // last setpoints through.
        self.over = self.samples.is_empty();
        if self.over {
            self.drain();
        }
        self.note_commands();
        // Forces from the commanded motion, not from the simulated one: the same for every variant,
        // so that methods are compared under one load.
        let forces = self.cutting.as_ref().map_or(Vec::new(), |cutting| {
            cutting.forces(&self.samples, &self.tracker, &self.modes)
        });
        self.bank
            .run(&self.samples, &forces, (&self.tracker, &self.modes))?;
        let outputs = &self.bank.outputs;
        // Each servo tick is paired with the command that it answers to, the delay taken out.
        self.aligner.frames(
            &self.samples,
            &self.modes,
            |at| outputs.reference(at),
            &mut self.frames,
        );
        Ok(!self.over)
    }

    /// Samples at rest at the end, as many as the reference is delayed by.
    fn drain(&mut self) {
        let rest = self.feed.last().map(|last| Sample {
            velocity: Coords::ZERO,
            acceleration: Coords::ZERO,
            path_speed: 0.0,
            ..last
        });
        // As many command cycles as the slowest axis' reference is late.
        let delay = self.bank.delay_ticks() as usize;
        self.samples.extend(
            rest.into_iter()
                .flat_map(|rest| std::iter::repeat_n(rest, delay)),
        );
    }

    fn note_commands(&mut self) {
        for sample in &self.samples {
            for axis in 0..self.peak_velocity.0.len() {
                self.peak_velocity.0[axis] =
                    self.peak_velocity.0[axis].max(sample.velocity.0[axis].abs());
                self.range[0].0[axis] = self.range[0].0[axis].min(sample.position.0[axis]);
                self.range[1].0[axis] = self.range[1].0[axis].max(sample.position.0[axis]);
            }
        }
        self.count += self.samples.len() as Tick;
    }

    /// Forgets segments that no later sample can touch; gives the first that is kept.
    pub(crate) fn release(&mut self) -> Option<u64> {
        let frame = &self.frames.last()?.sample;
        let oldest = self.bank.oldest_pending().map_or(frame, |pending| {
            if pending.segment < frame.segment {
                pending
            } else {
                frame
            }
        });
        self.tracker.release(oldest.segment, oldest.s)
    }

    /// How far it is.
    pub(crate) fn progress(&self) -> Progress {
        Progress {
            done_bytes: self.feed.bytes_done(),
            total_bytes: self.total_bytes,
            simulated_s: self.command.seconds(self.count),
        }
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
        &self.stepper.samples
    }

    /// Whether the plan is over: the samples are the last one at rest, repeated until the delayed
    /// reference has arrived.
    pub fn is_over(&self) -> bool {
        self.stepper.over
    }

    /// The servo ticks, each with the command that it answers to.
    pub fn frames(&self) -> &'a [Frame] {
        &self.stepper.frames
    }

    /// Joint positions of the loads of a variant, mm and rad.
    pub fn load(&self, variant: usize, frame: &Frame) -> Coords {
        self.stepper.bank.outputs.load(variant, frame.servo_sample)
    }

    /// All signals of an axis of a variant; `None` where the run keeps no trace or the machine has
    /// no such axis.
    pub fn trace(&self, variant: usize, axis: AxisId, frame: &Frame) -> Option<&'a AxisSample> {
        let outputs = &self.stepper.bank.outputs;
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
        let outputs = &self.stepper.bank.outputs;
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
