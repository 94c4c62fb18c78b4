//! The loop: a chunk of plan, all axes of all variants, all contour errors, and again.

use super::bank::{Bank, Variant};
use super::cutting::Cutting;
use super::feed::Feed;
use super::frame::{Aligner, Frame, contour_input};
use super::modes::Modes;
use super::recorder::Recorder;
use super::rows;
use crate::error::SimError;
use crate::machine::Machine;
use crate::observer::Observer;
use crate::options::SimulateOptions;
use crate::results::PlanInfo;
use crate::source::ProgramSource;
use lostmotion_base::{Coords, Tick};
use lostmotion_contour::{ContourTracker, FootState, Place, Statistics};
use lostmotion_drive::config::Cycles;
use lostmotion_plan::Sample;
use rayon::prelude::*;

/// The variant that runs beside every method: no gap, no compensator.
pub(crate) const WITHOUT_GAP: usize = 0;

/// Everything that a run adds up.
pub(crate) struct Tally {
    pub(crate) cycles: Cycles,
    pub(crate) bank: Bank,
    /// The machine without a gap, then one per method.
    pub(crate) recorders: Vec<Recorder>,
    /// Contour error of the command itself on cutting moves.
    pub(crate) command: Statistics,
    /// Number of samples planned.
    pub(crate) samples: Tick,
    /// Largest commanded speed of each joint.
    pub(crate) peak_velocity: Coords,
    /// How straight the tool goes.
    pub(crate) straightness: PlanInfo,
    /// Range of each joint.
    pub(crate) range: [Coords; 2],
}

/// A run on its way.
pub(crate) struct Run {
    threads: usize,
    modes: Modes,
    cutting: Option<Cutting>,
    tracker: ContourTracker,
    aligner: Aligner,
    command_foot: FootState,
    without_gap_foot: FootState,
    frames: Vec<Frame>,
    tally: Tally,
}

/// Plans and simulates a checked program for the machine without a gap and for every method.
pub(crate) fn run(
    source: &ProgramSource,
    machine: &Machine,
    methods: &[String],
    options: &SimulateOptions,
    observer: &mut dyn Observer,
) -> Result<Tally, SimError> {
    on_threads(options.threads, |threads| {
        run_on(threads, source, machine, methods, options, observer)
    })
}

/// Calls `work` with a number of threads: with 1 on the caller's thread, without rayon; else inside
/// a pool of its own with that many (0: one per core), entered once.
///
/// # Errors
/// A pool that cannot be made; what the work answers.
pub(crate) fn on_threads<T: Send>(
    threads: usize,
    work: impl FnOnce(usize) -> Result<T, SimError> + Send,
) -> Result<T, SimError> {
    if threads == 1 {
        return work(1);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|why| SimError::Threads {
        threads,
        why: why.to_string(),
    })?;
    let inside = || pool.install(|| work(pool.current_num_threads()));
    if rayon::current_thread_index().is_none() {
        return inside();
    }
    // A worker of another pool that waits for this one runs further jobs of its own pool on top of
    // its stack, each of which may do the same. A plain thread in between only waits.
    std::thread::scope(|scope| match scope.spawn(inside).join() {
        Ok(result) => result,
        Err(panic) => std::panic::resume_unwind(panic),
    })
}

fn run_on(
    threads: usize,
    source: &ProgramSource,
    machine: &Machine,
    methods: &[String],
    options: &SimulateOptions,
    observer: &mut dyn Observer,
) -> Result<Tally, SimError> {
    let mut feed = Feed::new(source, machine, options)?;
    let mut run = Run::new(
        threads,
        machine,
        methods,
        options,
        observer.wants_contour(),
        &feed,
    )?;
    let (total, command) = (source.len().unwrap_or(0), machine.cycles().command());
    let (mut samples, mut segments) = (Vec::new(), Vec::new());
    loop {
        feed.chunk(options.chunk_samples, &mut samples, &mut segments)?;
        for segment in segments.drain(..) {
            run.tracker.push(segment)?;
        }
        run.modes.clone_from(feed.modes());
        let last = samples.is_empty();
        if last {
            run.drain(&mut samples, feed.last());
        }
        run.chunk(&samples)?;
        run.report(observer);
        observer.progress(feed.bytes_done(), total, command.seconds(run.tally.samples));
        if last {
            break;
        }
        if command.seconds(run.tally.samples) > options.max_duration_s {
            return Err(SimError::TooLong {
                limit_s: options.max_duration_s,
            });
        }
    }
    feed.tell(&mut run.tally.straightness);
    for recorder in &mut run.tally.recorders {
        recorder.close();
    }
    run.report_rows(observer);
    Ok(run.tally)
}

impl Run {
    fn new(
        threads: usize,
        machine: &Machine,
        methods: &[String],
        options: &SimulateOptions,
        with_records: bool,
        feed: &Feed,
    ) -> Result<Run, SimError> {
        let mut variants = vec![Variant {
            method: "none".to_owned(),
            without_gap: true,
        }];
        variants.extend(methods.iter().map(|method| Variant {
            method: method.clone(),
            without_gap: false,
        }));
        let start = feed.start_joints();
        let bank = Bank::new(machine, &variants, &start, threads)?;
        let (axes, cycles) = (bank.outputs.axes().len(), machine.cycles());
        let recorder = |variant| {
            Recorder::new(
                variant,
                axes,
                cycles,
                options,
                with_records && variant != WITHOUT_GAP,
            )
        };
        let letters = machine.axes().iter().map(|axis| axis.id).collect();
        Ok(Run {
            threads,
            cutting: Cutting::new(
                options
                    .cutting_force_n
                    .unwrap_or(machine.simulate().cutting_force_n),
                machine.rotary_joints(),
                letters,
            ),
            modes: feed.modes().clone(),
            tracker: ContourTracker::new(options.contour),
            aligner: Aligner::new(bank.delay_ticks(), cycles.servo_ticks()),
            command_foot: FootState::default(),
            without_gap_foot: FootState::default(),
            frames: Vec::new(),
            tally: Tally {
                cycles,
                recorders: (0..variants.len()).map(recorder).collect(),
                bank,
                command: Statistics::default(),
                samples: 0,
                peak_velocity: Coords::ZERO,
                straightness: PlanInfo::default(),
                range: [start, start],
            },
        })
    }

    /// At the end, so many samples at rest that the delayed reference gets there too.
    fn drain(&self, samples: &mut Vec<Sample>, last: Option<Sample>) {
        let rest = last.map(|last| Sample {
            velocity: Coords::ZERO,
            acceleration: Coords::ZERO,
            path_speed: 0.0,
            ..last
        });
        samples
            .extend(rest.into_iter().flat_map(|rest| {
                std::iter::repeat_n(rest, self.tally.bank.delay_ticks() as usize)
            }));
    }

    fn chunk(&mut self, samples: &[Sample]) -> Result<(), SimError> {
        self.note_commands(samples);
        let forces = self.cutting.as_ref().map_or(Vec::new(), |cutting| {
            cutting.forces(samples, &self.tracker, &self.modes)
        });
        self.tally.bank.run(samples, &forces)?;
        let outputs = &self.tally.bank.outputs;
        self.aligner.frames(
            samples,
            &self.modes,
            |at| outputs.reference(at),
            &mut self.frames,
        );
        self.measure_references()?;
        let (frames, tracker, modes) = (&self.frames, &self.tracker, &self.modes);
        let outputs = &self.tally.bank.outputs;
        let record = |recorder: &mut Recorder| recorder.chunk(frames, outputs, tracker, modes);
        let recorders = &mut self.tally.recorders;
        let results: Vec<Result<(), SimError>> = if self.threads > 1 {
            recorders.par_iter_mut().map(record).collect()
        } else {
            recorders.iter_mut().map(record).collect()
        };
        results.into_iter().collect::<Result<(), SimError>>()?;
        if let Some(frame) = self.frames.last()
            && let Some(oldest) = self.tracker.release(frame.sample.segment, frame.sample.s)
        {
            for recorder in &mut self.tally.recorders {
                recorder.close_before(oldest);
            }
        }
        Ok(())
    }

    fn note_commands(&mut self, samples: &[Sample]) {
        let tally = &mut self.tally;
        for sample in samples {
            for axis in 0..tally.peak_velocity.0.len() {
                tally.peak_velocity.0[axis] =
                    tally.peak_velocity.0[axis].max(sample.velocity.0[axis].abs());
                tally.range[0].0[axis] = tally.range[0].0[axis].min(sample.position.0[axis]);
                tally.range[1].0[axis] = tally.range[1].0[axis].max(sample.position.0[axis]);
            }
        }
        tally.samples += samples.len() as Tick;
    }

    /// Contour errors of the command itself and of the machine without a gap: what every method is
    /// held against.
    fn measure_references(&mut self) -> Result<(), SimError> {
        let outputs = &self.tally.bank.outputs;
        for frame in &mut self.frames {
            let command = self
                .tracker
                .measure(&mut self.command_foot, &contour_input(frame, &frame.pose))?;
            let joints = outputs.load(WITHOUT_GAP, frame.servo_sample);
            let actual = self
                .modes
                .at(frame.sample.segment)
                .tool_pose(&joints, &frame.sample.tool_mm);
            frame.command_mm = command.error_mm;
            let origin = self
                .tracker
                .segment(frame.sample.segment)
                .map_or([0.0; 3], |segment| segment.origin_mm);
            frame.tip_mm = std::array::from_fn(|axis| frame.pose.tip[axis] - origin[axis]);
            frame.without_gap = self
                .tracker
                .measure(&mut self.without_gap_foot, &contour_input(frame, &actual))?;
            if frame.moving && !command.rapid {
                let place = Place {
                    tick: frame.tick,
                    segment: command.segment,
                    s: command.s,
                };
                self.tally.command.push(command.error_mm, place);
            }
        }
        Ok(())
    }

    fn report(&mut self, observer: &mut dyn Observer) {
        self.report_rows(observer);
        let servo = self.tally.cycles.servo();
        for (method, recorder) in self.tally.recorders.iter().skip(1).enumerate() {
            if let Some(records) = &recorder.records {
                let points: Vec<_> = records
                    .iter()
                    .filter_map(|record| rows::contour_point(&self.tracker, record, servo))
                    .collect();
                observer.contour(method, &points);
            }
        }
    }

    fn report_rows(&mut self, observer: &mut dyn Observer) {
        let servo = self.tally.cycles.servo();
        for (method, recorder) in self.tally.recorders.iter().skip(1).enumerate() {
            if !recorder.finished_blocks.is_empty() {
                observer.blocks(
                    method,
                    &recorder
                        .finished_blocks
                        .iter()
                        .map(|row| rows::block(row, servo))
                        .collect::<Vec<_>>(),
                );
            }
            if !recorder.finished_turns.is_empty() {
                observer.reversals(
                    method,
                    &recorder
                        .finished_turns
                        .iter()
                        .map(|row| rows::reversal(row, servo))
                        .collect::<Vec<_>>(),
                );
            }
        }
    }
}
