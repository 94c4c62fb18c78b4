//! The loop: all axes of all variants through a chunk of the plan, all contour errors of the one
//! before, and again.

use super::guard::Rehearsals;
use super::outputs::Kept;
use super::recorder::Recorder;
use super::references::CommandContour;
use super::rehearsal::Rehearser;
use super::rows;
use super::stepper::{Chunk, Stepper};
use super::variant::Variant;
use crate::error::SimError;
use crate::machine::Memory;
use crate::method::Choice;
use crate::observer::{Audience, MotorPoint, Observer};
use crate::program::BlockTexts;
use crate::results::PlanInfo;
use crate::setup::Setup;
use lostmotion_base::{Clock, Tick, threads};
use lostmotion_contour::{ContourTracker, Statistics};
use lostmotion_drive::config::Cycles;
use lostmotion_gcode::SourceFiles;
use lostmotion_methods::Misled;

/// The variant that runs beside every method: no gap, no compensator.
pub(crate) const WITHOUT_GAP: usize = 0;

/// Everything that a run adds up.
pub(crate) struct Tally {
    pub(crate) cycles: Cycles,
    pub(crate) stepper: Stepper,
    /// The machine without a gap, then one per method.
    /// Behind these the methods that are told something wrong.
    pub(crate) recorders: Vec<Recorder>,
    /// Which method is told what wrong, in the order of the recorders.
    pub(crate) misled: Vec<(usize, Misled)>,
    /// Contour error of the command itself on cutting moves.
    pub(crate) command: Statistics,
    /// How straight the tool goes.
    pub(crate) straightness: PlanInfo,
}

/// Plans and simulates a checked program for the machine without a gap, for every method, and for
/// methods (by their place) that are told something wrong.
pub(crate) fn run(
    setup: &Setup<'_>,
    choices: &[Choice],
    misled: &[(usize, Misled)],
    files: &SourceFiles,
    audience: &mut Audience<'_>,
) -> Result<Tally, SimError> {
    setup.on_threads(|threads| run_on(threads, setup, (choices, misled), files, audience))
}

fn run_on(
    threads: usize,
    setup: &Setup<'_>,
    (choices, misled): (&[Choice], &[(usize, Misled)]),
    files: &SourceFiles,
    audience: &mut Audience<'_>,
) -> Result<Tally, SimError> {
    let mut variants = vec![Variant::without_gap()];
    // Variant 0 is the reference: what servo and command leave without a gap. Every method's error
    // is split against it.
    variants.extend(choices.iter().map(Variant::with_gap));
    let methods = choices.len();
    // Behind them the runs that a recommendation rests on, which nobody watches.
    variants.extend(
        misled
            .iter()
            .filter_map(|(index, misled)| Some(Variant::misled(choices.get(*index)?, *misled))),
    );
    let kept = Kept {
        trace: false,
        motors: if audience.wants_motors() { methods } else { 0 },
        learning: audience.wants_learning(),
        limiters: audience.wants_limiters(),
        stops: true,
    };
    let rehearser = Rehearser::new(setup, &variants, threads);
    let rehearse = |variant: usize, memory: &Memory, so_far_s: Option<f64>| {
        rehearser.rehearse(variant, memory, so_far_s)
    };
    let rehearsals = Rehearsals {
        machine: setup.machine,
        rehearse: &rehearse,
    };
    let mut stepper = Stepper::new(setup, &variants, threads, kept, Some(&rehearsals))?;
    let points_of = if audience.wants_contour() { methods } else { 0 };
    let mut judge = Judge::new(setup, &stepper, variants.len(), methods, points_of);
    let mut texts = audience
        .observer
        .as_ref()
        .map(|_| BlockTexts::new(setup.program, files.clone()));
    // The chunk before is judged while the axes take one.
    let mut more = true;
    while more {
        let look =
            |chunk: &mut Chunk, tracker: &ContourTracker| judge.chunk(chunk, tracker, threads);
        let (judged, stepped) = stepper.step(Some(&rehearsals), look);
        if let Some(judged) = judged {
            judged?;
            told(&mut judge, &mut stepper, false, (audience, &mut texts))?;
        }
        more = stepped?;
    }
    judge.chunk(&stepper.chunk, &stepper.tracker, threads)?;
    told(&mut judge, &mut stepper, true, (audience, &mut texts))?;
    // Rows of the last blocks and reversals stay open until the end of the program.
    for recorder in &mut judge.recorders {
        recorder.close();
    }
    if let (Some(observer), Some(texts)) = (&mut audience.observer, &mut texts) {
        judge.report_rows(*observer, texts);
    }
    let mut straightness = PlanInfo::default();
    stepper.tell(&mut straightness);
    Ok(Tally {
        misled: misled.to_vec(),
        cycles: setup.machine.cycles(),
        stepper,
        recorders: judge.recorders,
        command: judge.command.cutting,
        straightness,
    })
}

/// Hands out what is final of the chunk that was judged last; at the end that is the last one.
fn told(
    judge: &mut Judge,
    stepper: &mut Stepper,
    is_end: bool,
    (audience, texts): (&mut Audience<'_>, &mut Option<BlockTexts>),
) -> Result<(), SimError> {
    // A row is final once no foot point can fall back on its segment.
    if let Some(oldest) = stepper.release(stepper.looked_at(is_end).place()) {
        judge.close_before(oldest);
    }
    let chunk = stepper.looked_at(is_end);
    // All variants are measured on the same ticks, then rows that no later tick can change are
    // handed out: memory stays constant.
    if let (Some(observer), Some(texts)) = (&mut audience.observer, texts) {
        judge.report_rows(*observer, texts);
        judge.report_contour(*observer);
        if observer.wants_motors() {
            judge.report_motors(*observer, chunk);
        }
        if observer.wants_learning() {
            let variants = chunk.learning.iter().zip(&chunk.foreseen);
            for (method, (known, foreseen)) in variants.skip(1).take(judge.methods).enumerate() {
                let time_s = chunk.progress.simulated_s;
                observer.learning(method, time_s, known);
                observer.foreseen(method, time_s, foreseen.as_ref());
            }
        }
    }
    let progress = chunk.progress;
    // After the rows, so that a caller who cancels here has seen what was finished.
    audience.progress(progress)
}

/// Measures the contour error of the command, of the machine without a gap, and of every variant.
struct Judge {
    servo: Clock,
    command: CommandContour,
    recorders: Vec<Recorder>,
    /// How many of the variants are methods: those behind the machine without a gap.
    methods: usize,
    /// Room for the signals of motors.
    motors: Vec<MotorPoint>,
}

/// Frames that are measured before they are recorded. A choice: what is kept of them in between takes 200 kB a
/// variant, and threads have enough to share.
const MEASURED_FRAMES: usize = 1000;
/// Frames whose motors are handed out together. A choice: what they take stays in the processor's
/// cache until it is read.
const MOTOR_FRAMES: usize = 128;

impl Judge {
    /// Points are kept of the first `points_of` methods.
    fn new(
        setup: &Setup<'_>,
        stepper: &Stepper,
        variants: usize,
        methods: usize,
        points_of: usize,
    ) -> Judge {
        let (axes, cycles) = (stepper.chunk.outputs.axes().len(), setup.machine.cycles());
        let recorder = |variant| {
            // Observers see methods alone; the reference variant needs no points.
            let with_points = variant != WITHOUT_GAP && variant <= points_of;
            Recorder::new(variant, axes, cycles, setup.options, with_points)
        };
        Judge {
            servo: cycles.servo(),
            command: CommandContour::default(),
            recorders: (0..variants).map(recorder).collect(),
            methods,
            motors: Vec::new(),
        }
    }

    /// Measures a chunk.
    fn chunk(
        &mut self,
        chunk: &Chunk,
        tracker: &ContourTracker,
        threads: usize,
    ) -> Result<(), SimError> {
        self.recorders.iter_mut().for_each(Recorder::begin);
        for frames in chunk.frames.chunks(MEASURED_FRAMES) {
            let Judge {
                command, recorders, ..
            } = self;
            // Collected in the order of the variants, so that the first error does not depend on the
            // number of threads.
            let measure = |recorder: &mut Recorder| recorder.measure(frames, chunk, tracker);
            let (commanded, moved) = threads::join(
                threads,
                || command.measure(frames, tracker),
                || threads::map(threads, recorders.iter_mut(), measure),
            );
            commanded?;
            moved.into_iter().collect::<Result<(), SimError>>()?;
            // All are held against the first.
            let without_gap = recorders[WITHOUT_GAP].measured();
            let record = |recorder: &mut Recorder| {
                let references = command.beside(&without_gap);
                recorder.record(frames.iter().zip(references), chunk, tracker);
            };
            threads::map(threads, recorders.iter_mut(), record);
        }
        Ok(())
    }

    /// Closes the rows of segments that no later sample can touch.
    fn close_before(&mut self, segment: u64) {
        for recorder in &mut self.recorders {
            recorder.close_before(segment);
        }
    }

    /// The recorders of the methods, by their number.
    fn of_methods(&self) -> impl Iterator<Item = (usize, &Recorder)> {
        self.recorders
            .iter()
            .skip(WITHOUT_GAP + 1)
            .take(self.methods)
            .enumerate()
    }

    fn report_contour(&self, observer: &mut dyn Observer) {
        for (method, recorder) in self.of_methods() {
            if let Some(points) = &recorder.points {
                observer.contour(method, points);
            }
        }
    }

    /// Hands out the signals of all motors of the last chunk, method by method, up to the tick at
    /// which the machine has stopped.
    fn report_motors(&mut self, observer: &mut dyn Observer, chunk: &Chunk) {
        let mut points = std::mem::take(&mut self.motors);
        // Recorder 0 is the machine without a gap, which is no method.
        for (method, recorder) in self.of_methods() {
            let end = recorder.stop.as_ref().map_or(Tick::MAX, |stop| stop.tick);
            // Frames are in the order of time.
            let upto = chunk.frames.partition_point(|frame| frame.tick < end);
            for frames in chunk.frames[..upto].chunks(MOTOR_FRAMES) {
                let samples = frames
                    .iter()
                    .map(|frame| (frame.servo_sample, self.servo.seconds(frame.tick)));
                chunk.outputs.motors(method + 1, samples, &mut points);
                observer.motors(method, &points);
            }
        }
        self.motors = points;
    }

    fn report_rows(&self, observer: &mut dyn Observer, texts: &mut BlockTexts) {
        for (method, recorder) in self.of_methods() {
            let mut blocks: Vec<_> = recorder
                .finished_blocks
                .iter()
                .map(|row| rows::block(row, self.servo))
                .collect();
            // Texts of blocks are read from the program again, for the rows that are reported
            // alone.
            for row in &mut blocks {
                row.text = texts.at(row.block.span);
            }
            if !blocks.is_empty() {
                observer.blocks(method, &blocks);
            }
            let reversals: Vec<_> = recorder
                .finished_turns
                .iter()
                .map(|row| rows::reversal(row, self.servo))
                .collect();
            if !reversals.is_empty() {
                observer.reversals(method, &reversals);
            }
        }
    }
}
