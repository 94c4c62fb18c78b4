//! The way in: a program on a machine, what is to be done with it, and the answer.

use crate::error::{SimError, SinkError};
use crate::machine::{Machine, Memory};
use crate::method::Choice;
use crate::motion::{self, Curves, Feed};
use crate::observer::{Audience, Observer, OnProgress, Progress};
use crate::options::{Intervention, SimulateOptions};
use crate::program::Program;
use crate::recorded::results::RecordCheck;
use crate::recorded::{self, RecordOptions, Recorded};
use crate::results::{PlanInfo, ProgramInfo, Run};
use crate::session::{self, Ahead, Kept, Rehearsals, Rehearser, Stepper, TickSink, Ticks, Variant};
use crate::setup::Setup;
use crate::time::results::CycleTime;
use crate::time::{self, BlockSink, TimeOptions};
use lostmotion_contour::ProgrammedSegment;
use lostmotion_drive::Compensator;
use lostmotion_gcode::{Code, Dialect, Leniencies, Limits, MCodeUse, SubroutineLoader, ToolTable};
use lostmotion_kinematics::Kinematics;
use lostmotion_methods::AxisConfig;
use lostmotion_plan::{Quality, Sample};
use std::ops::ControlFlow;
use std::sync::Arc;

/// A part program on a machine.
///
/// The methods up to [`Simulation::on_progress`] say how; the last one says what: [`run`] for the
/// contour error, [`plan`] for the motion alone, [`time`] for where the time goes, [`check`] for
/// what can be said without moving, [`curves`] for the programmed geometry.
///
/// ```
/// use lostmotion_sim::{Machine, Program, Simulation};
///
/// let program = Program::from_str("circle.ngc", "G21 G0 X25 Y0\nG3 I-25 F2000\nM2\n");
/// let machine = Machine::preset("vmc3")?;
/// let run = Simulation::new(&program, &machine).method("fixed").run()?;
/// for block in run.blocks() {
///     println!("{}: {:+.1} um, {}", block.line, block.max_um, block.cause);
/// }
/// assert!(run.is_within_tolerance());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// The run stays on the caller's thread unless [`Simulation::threads`] asks for more, so that any
/// number of them may go on side by side.
///
/// [`run`]: Simulation::run
/// [`plan`]: Simulation::plan
/// [`time`]: Simulation::time
/// [`check`]: Simulation::check
/// [`curves`]: Simulation::curves
#[must_use = "nothing happens before `run`, `plan`, `time`, `check` or `curves`"]
pub struct Simulation<'a> {
    program: &'a Program,
    machine: &'a Machine,
    options: SimulateOptions,
    kinematics: Option<Arc<dyn Kinematics>>,
    choices: Vec<Result<Choice, SimError>>,
    audience: Audience<'a>,
}

/// Takes a chunk of the plan: samples, a command cycle each, and the programmed segments that were
/// read for it, each once, in order and no later than the first sample that names it.
pub type PlanSink<'a> =
    dyn FnMut(&[Sample], &[ProgrammedSegment]) -> Result<(), SinkError> + Send + 'a;

impl<'a> Simulation<'a> {
    /// A program on a machine, each axis with the method that the machine names for it (none, for
    /// the machines that come with the library), everything else as the machine has it.
    pub fn new(program: &'a Program, machine: &'a Machine) -> Simulation<'a> {
        Simulation {
            program,
            machine,
            options: SimulateOptions::default(),
            kinematics: None,
            choices: Vec::new(),
            audience: Audience::default(),
        }
    }

    /// Adds a registered compensation method, by its name, for all axes. Several are compared on
    /// one plan. A name that is not registered is an error of [`Simulation::run`].
    pub fn method(mut self, name: &str) -> Simulation<'a> {
        self.choices.push(Choice::registered(name));
        self
    }

    /// Adds several registered methods.
    ///
    /// ```
    /// # use lostmotion_sim::{Machine, Program, Simulation};
    /// let program = Program::from_str("arc.ngc", "G21 G90 G17\nG0 X9 Y0\nG3 I-9 F900\nM2\n");
    /// let machine = Machine::preset("vmc3-worn")?;
    /// let run = Simulation::new(&program, &machine)
    ///     .methods(["none", "fixed"])
    ///     .run()?;
    /// assert_eq!(run.results.len(), 2);
    /// assert_eq!(run.recommended.as_deref(), Some("fixed"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn methods<N: AsRef<str>>(self, names: impl IntoIterator<Item = N>) -> Simulation<'a> {
        names
            .into_iter()
            .fold(self, |simulation, name| simulation.method(name.as_ref()))
    }

    /// Adds a compensator of one's own under a name for the results; `make` makes it for each axis
    /// from the axis' description.
    pub fn compensator<C: Compensator>(
        mut self,
        name: impl Into<String>,
        make: impl Fn(&AxisConfig) -> C + Send + Sync + 'static,
    ) -> Simulation<'a> {
        if let Some(axis) = self.machine.axes().first() {
            self.choices
                .push(Ok(Choice::own(name.into(), make, &axis.config)));
        }
        self
    }

    /// Adds a method with settings of its own.
    pub(crate) fn choice(mut self, choice: Choice) -> Simulation<'a> {
        self.choices.push(Ok(choice));
        self
    }

    /// Kinematics of one's own in place of the machine's. When X Y Z are the tool's tip stays as
    /// the machine says it (`kinematics.tip_control`).
    pub fn kinematics(mut self, kinematics: impl Kinematics + 'static) -> Simulation<'a> {
        self.kinematics = Some(Arc::new(kinematics));
        self
    }

    /// All settings at once; those that are set afterwards go before them.
    pub fn options(mut self, options: SimulateOptions) -> Simulation<'a> {
        self.options = options;
        self
    }

    /// Tolerance of the verdict, um, in place of the machine's.
    pub fn tolerance_um(mut self, tolerance_um: f64) -> Simulation<'a> {
        self.options.tolerance_um = Some(tolerance_um);
        self
    }

    /// Size of the cutting force on feed moves, N, in place of the machine's.
    pub fn cutting_force_n(mut self, cutting_force_n: f64) -> Simulation<'a> {
        self.options.cutting_force_n = Some(cutting_force_n);
        self
    }

    /// What methods that learn (`adaptive`) start from, as an earlier run has learned it
    /// ([`MethodResult::learned`](crate::results::MethodResult::learned)).
    pub fn learned(mut self, memory: Memory) -> Simulation<'a> {
        self.options.learned = Some(Arc::new(memory));
        self
    }

    /// Tools in place of the machine's.
    pub fn tool_table(mut self, tools: ToolTable) -> Simulation<'a> {
        self.options.tool_table = Some(tools);
        self
    }

    /// Dialect of the program, in place of the machine's.
    pub fn dialect(mut self, dialect: Dialect) -> Simulation<'a> {
        self.options.dialect = Some(dialect);
        self
    }

    /// What is accepted with a warning, in place of what the dialect accepts.
    pub fn leniencies(mut self, leniencies: Leniencies) -> Simulation<'a> {
        self.options.leniencies = Some(leniencies);
        self
    }

    /// Bounds of the G-code front end.
    pub fn limits(mut self, limits: Limits) -> Simulation<'a> {
        self.options.limits = limits;
        self
    }

    /// Where subroutines come from that the program does not define.
    pub fn subroutines(mut self, loader: impl SubroutineLoader + 'static) -> Simulation<'a> {
        self.options.loader = Some(Arc::new(loader));
        self
    }

    /// Whether blocks that begin with `/` are skipped.
    pub fn block_delete(mut self, on: bool) -> Simulation<'a> {
        self.options.block_delete = on;
        self
    }

    /// Which of `/1` to `/9` are skipped, `/` being `/1`.
    pub fn block_skips(mut self, numbers: impl IntoIterator<Item = u8>) -> Simulation<'a> {
        self.options.block_skips = Some(numbers.into_iter().collect());
        self
    }

    /// What M codes of the machine's builder do.
    pub fn m_codes(mut self, codes: impl IntoIterator<Item = (Code, MCodeUse)>) -> Simulation<'a> {
        self.options.m_codes = codes.into_iter().collect();
        self
    }

    /// Values that only the machine knows, by the number of a parameter or system variable
    /// (`3011`) or by its name (`_hal[spindle.load]`).
    pub fn told(mut self, values: impl IntoIterator<Item = (String, f64)>) -> Simulation<'a> {
        self.options.told = values.into_iter().collect();
        self
    }

    /// How much work the planner puts into a shorter time.
    pub fn quality(mut self, quality: Quality) -> Simulation<'a> {
        self.options.quality = quality;
        self
    }

    /// What an operator does while the program runs, in the order of the times.
    pub fn interventions(
        mut self,
        interventions: impl IntoIterator<Item = Intervention>,
    ) -> Simulation<'a> {
        self.options.interventions = interventions.into_iter().collect();
        self
    }

    /// Longest motion, s; a program that runs longer is an error.
    pub fn max_duration_s(mut self, max_duration_s: f64) -> Simulation<'a> {
        self.options.max_duration_s = max_duration_s;
        self
    }

    /// Number of threads: 1, the default, is the caller's; others make a pool for this run, 0 one
    /// with a thread per core. The result does not depend on it.
    pub fn threads(mut self, threads: usize) -> Simulation<'a> {
        self.options.threads = threads;
        self
    }

    /// Takes rows and points as they are finished.
    pub fn observer(mut self, observer: &'a mut dyn Observer) -> Simulation<'a> {
        self.audience.observer = Some(observer);
        self
    }

    /// Is told how far the run is, once a chunk of the plan (a second of motion), and may end it:
    /// [`ControlFlow::Break`] makes the run answer [`SimError::Cancelled`].
    ///
    /// ```
    /// # use lostmotion_sim::{Machine, Program, SimError, Simulation};
    /// use std::ops::ControlFlow;
    ///
    /// let program = Program::from_str("slot.ngc", "G21 G90\nG1 X90 F900\nM2\n");
    /// let machine = Machine::preset("bench3")?;
    /// let run = Simulation::new(&program, &machine)
    ///     .on_progress(|progress| {
    ///         if progress.simulated_s > 1.5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    ///     })
    ///     .run();
    /// assert!(matches!(run, Err(SimError::Cancelled)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn on_progress(
        mut self,
        tell: impl FnMut(Progress) -> ControlFlow<()> + Send + 'a,
    ) -> Simulation<'a> {
        let tell: OnProgress<'a> = Box::new(tell);
        self.audience.on_progress = Some(tell);
        self
    }

    /// Simulates the program with every method on one plan and judges the contour error of each.
    ///
    /// The machine without a gap runs beside them, so that every error splits into command, servo
    /// and backlash.
    ///
    /// # Errors
    /// Everything that is wrong with program, machine, method or options; see [`SimError`].
    pub fn run(mut self) -> Result<Run, SimError> {
        let choices = self.take_choices()?;
        let mut audience = std::mem::take(&mut self.audience);
        let setup = self.setup()?;
        // The whole program is read before anything moves, so that all its errors come at once.
        let checked = motion::check(&setup)?;
        session::run(&setup, &choices, checked, &mut audience)
    }

    /// Hands the servo ticks of all axes to `sink` in place of judging them: for studies that
    /// measure in another way. With `with_trace`, [`Ticks::trace`] has all signals.
    ///
    /// # Errors
    /// As [`Simulation::run`], and whatever the sink answers, as [`SimError::Sink`].
    pub fn ticks(mut self, with_trace: bool, sink: &mut dyn TickSink) -> Result<(), SimError> {
        let choices = self.take_choices()?;
        let mut audience = std::mem::take(&mut self.audience);
        let setup = self.setup()?;
        motion::check(&setup)?;
        let (setup, audience) = (&setup, &mut audience);
        setup.on_threads(|threads| {
            let mut variants = vec![Variant::without_gap()];
            variants.extend(choices.iter().map(Variant::with_gap));
            let kept = Kept {
                trace: with_trace,
                ..Kept::default()
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
            loop {
                let (_, more) = stepper.step(Some(&rehearsals), |_, _| ());
                let more = more?;
                sink.chunk(&Ticks::of(&stepper)).map_err(SimError::Sink)?;
                // Segments that no later sample touches are forgotten, so that memory stays
                // bounded.
                stepper.release(stepper.chunk.place());
                audience.progress(stepper.chunk.progress)?;
                if !more {
                    return Ok(());
                }
            }
        })
    }

    /// Reads the program to its end and holds it against the machine, without moving anything.
    ///
    /// ```
    /// # use lostmotion_sim::{Machine, Program, Simulation};
    /// let machine = Machine::preset("vmc3")?;
    /// let far = Program::from_str("far.ngc", "G21 G90\nG0 X400\nM2\n");
    /// let error = Simulation::new(&far, &machine).check().unwrap_err().to_string();
    /// assert!(error.contains("axis X to 19.000 mm, beyond its limit of 0.000 mm"));
    /// assert!(error.contains("move the origin of G54: X by -19.000 mm or more"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Simulation::run`], apart from those of the methods.
    pub fn check(&self) -> Result<ProgramInfo, SimError> {
        Ok(motion::check(&self.setup()?)?.program)
    }

    /// The moves of the program: curves in machine coordinates, with the feed, plane and tool in
    /// force. Made as they are asked for.
    ///
    /// ```
    /// # use lostmotion_sim::{Machine, Program, Simulation};
    /// let program = Program::from_str("arc.ngc", "G21 G0 X10 Y0\nG3 X0 Y10 I-10 F600\nM2\n");
    /// let machine = Machine::preset("bench3")?;
    /// let mut cutting_mm = 0.0;
    /// for item in Simulation::new(&program, &machine).curves()? {
    ///     let item = item?;
    ///     if !item.is_rapid() {
    ///         cutting_mm += item.motion.curve.length();
    ///     }
    /// }
    /// assert!((cutting_mm - 5.0 * std::f64::consts::PI).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The program cannot be opened, the kinematics cannot be built.
    pub fn curves(&self) -> Result<Curves, SimError> {
        Curves::new(&self.setup()?)
    }

    /// Plans the program and hands out the samples, chunk by chunk, with the programmed path: so a
    /// caller can measure contour errors of machines that are not described by a [`Machine`].
    ///
    /// ```
    /// # use lostmotion_sim::{Machine, Program, Simulation};
    /// let machine = Machine::preset("bench3")?;
    /// let program = Program::from_str("line.ngc", "G21 G90\nG1 X50 F3000\nM2\n");
    /// let mut last = None;
    /// let plan = Simulation::new(&program, &machine).plan(&mut |samples, _path| {
    ///     last = samples.last().copied();
    ///     Ok(())
    /// })?;
    /// assert_eq!(plan.cutting_mm, 50.0);
    /// assert!((last.ok_or("no sample")?.position.linear()[0] - 50.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Simulation::run`], and whatever the sink answers, as [`SimError::Sink`].
    pub fn plan(mut self, sink: &mut PlanSink<'_>) -> Result<PlanInfo, SimError> {
        let mut audience = std::mem::take(&mut self.audience);
        let setup = self.setup()?;
        let checked = motion::check(&setup)?;
        let total_bytes = self.program.len().unwrap_or(0);
        let (setup, audience) = (&setup, &mut audience);
        setup.on_threads(|threads| {
            let feed = Feed::new(setup)?.on_threads(threads);
            let options = setup.options;
            let mut ahead = Ahead::new(feed, None, options.chunk_samples, threads);
            let (mut count, command) = (0, setup.machine.cycles().command());
            loop {
                let mut planned = ahead.next();
                if let Some(error) = planned.error.take() {
                    return Err(error);
                }
                if planned.samples.is_empty() {
                    let mut plan = PlanInfo {
                        duration_s: command.seconds(count),
                        ..checked.plan
                    };
                    ahead.tell(&mut plan);
                    // What stands behind the program's end is not read.
                    audience.progress(Progress {
                        done_bytes: planned.bytes_done.max(total_bytes),
                        total_bytes,
                        simulated_s: plan.duration_s,
                    })?;
                    return Ok(plan);
                }
                count += planned.samples.len() as u64;
                // A loop without end would plan for ever.
                if command.seconds(count) > options.max_duration_s {
                    return Err(SimError::TooLong {
                        limit_s: options.max_duration_s,
                    });
                }
                sink(&planned.samples, &planned.segments).map_err(SimError::Sink)?;
                audience.progress(Progress {
                    done_bytes: planned.bytes_done,
                    total_bytes,
                    simulated_s: command.seconds(count),
                })?;
                ahead.done_with(planned);
            }
        })
    }

    /// Plans the program and tells where its time goes; `sink` takes the blocks as they are
    /// finished.
    ///
    /// Time is counted in command cycles, so that the parts sum to the whole; memory does not grow
    /// with the program.
    ///
    /// ```
    /// # use lostmotion_sim::{Machine, Program, Simulation};
    /// # use lostmotion_sim::time::TimeOptions;
    /// let machine = Machine::preset("bench3")?;
    /// let program = Program::from_str("line.ngc", "G21 G90\nG1 X50 F3000\nG4 P2\nM2\n");
    /// let time = Simulation::new(&program, &machine).time(&TimeOptions::default(), &mut |_| Ok(()))?;
    /// assert!((time.kinds.dwell_s - 2.0).abs() < 0.01);
    /// assert_eq!(time.kinds.cutting_s + time.kinds.rapid_s + time.kinds.dwell_s, time.plan_s);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Simulation::plan`].
    pub fn time(
        self,
        options: &TimeOptions,
        sink: &mut BlockSink<'_>,
    ) -> Result<CycleTime, SimError> {
        time::time(&self.setup()?, options, sink)
    }

    /// Holds a recorded motion against the program and the limits of the machine; where in the program
    /// it was recorded, and by which clock, is found.
    ///
    /// ```
    /// # use lostmotion_sim::{Machine, Program, Simulation};
    /// use lostmotion_sim::recorded::{RecordOptions, Recorded, RecordedAxis};
    /// use lostmotion_base::AxisId;
    ///
    /// let machine = Machine::preset("bench3")?;
    /// let program = Program::from_str("corner.ngc", "G21 G90 G61\nG1 X40 F3000\nY30\nM2\n");
    /// // Its own plan, from somewhere on the first move on, by another clock.
    /// let (mut time_s, mut values) = (Vec::new(), [const { Vec::new() }; 3]);
    /// Simulation::new(&program, &machine).plan(&mut |samples, _path| {
    ///     for sample in samples.iter().filter(|sample| sample.tick > 300) {
    ///         time_s.push(17.0 + 1e-3 * sample.tick as f64);
    ///         for (values, at) in values.iter_mut().zip(sample.position.linear()) {
    ///             values.push(at);
    ///         }
    ///     }
    ///     Ok(())
    /// })?;
    /// let axes = [AxisId::X, AxisId::Y, AxisId::Z].into_iter().zip(values);
    /// let recorded = Recorded {
    ///     time_s,
    ///     axes: axes.map(|(axis, values)| RecordedAxis { axis, values }).collect(),
    ///     kind: Default::default(),
    ///     of_tool: false,
    /// };
    /// let check = Simulation::new(&program, &machine).check_record(&recorded, &RecordOptions::default())?;
    /// assert!(check.is_within());
    /// assert_eq!((check.place.first.span.line, check.place.last.span.line), (2, 3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Simulation::check`] but for travel, and [`SimError::Refused`] for a record that is none of
    /// this machine or does not follow the program.
    pub fn check_record(
        &self,
        recorded: &Recorded,
        options: &RecordOptions,
    ) -> Result<RecordCheck, SimError> {
        recorded::check(&self.setup()?, recorded, options)
    }

    /// As [`Simulation::check_record`], of a record that is larger than memory: `next` gives its parts
    /// in order, each with how many rows of the part before it begins with
    /// ([`SHARED_ROWS`](crate::recorded::SHARED_ROWS)). The place is found in the first part that
    /// moves; the others go on behind it.
    ///
    /// # Errors
    /// As [`Simulation::check_record`], and what `next` says.
    pub fn check_record_parts<E: From<SimError>>(
        &self,
        next: &mut dyn FnMut() -> Result<Option<(Recorded, usize)>, E>,
        options: &RecordOptions,
    ) -> Result<RecordCheck, E> {
        recorded::check_parts(&self.setup()?, next, options)
    }

    fn setup(&self) -> Result<Setup<'_>, SimError> {
        Setup::new(
            self.program,
            self.machine,
            &self.options,
            self.kinematics.as_ref(),
        )
    }

    fn take_choices(&mut self) -> Result<Vec<Choice>, SimError> {
        // Each axis then runs the method that its own table names.
        if self.choices.is_empty() {
            return Ok(vec![Choice::OfAxes]);
        }
        std::mem::take(&mut self.choices).into_iter().collect()
    }
}
