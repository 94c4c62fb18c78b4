//! Simulations: a program on a machine, what is to be done with it, and who looks on.

use crate::border::{Texts, call, out, text};
use crate::compensator::{LmCompensator, Own};
use crate::error::beyond;
use crate::failure::{Failure, LmStatus, Reason, c_text};
use crate::handle::{change, free, insert, look, opaque};
use crate::machine::LmMachine;
use crate::program::{LmProgram, Part};
use crate::rows::{
    LmBlock, LmContourSample, LmMotorSample, LmOnBlocks, LmOnContour, LmOnMotors, LmOnPlan,
    LmOnProgress, LmOnReversals, LmPlan, LmProgress, LmReversal, block, letter, plan_sample,
    plan_told,
};
use crate::run::{Done, LmRun};
use lostmotion::drive::Learning;
use lostmotion::methods::MethodId;
use lostmotion::report::page::PageRecorder;
use lostmotion::report::refusal::{Refusal, RefusalKind};
use lostmotion::sim::MotorPoint;
use lostmotion::sim::request::{ReadingRequest, RunRequest};
use lostmotion::sim::results::{BlockResult, ReversalResult};
use lostmotion::{ContourPoint, Observer, SimulateOptions};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::ffi::{CString, c_char, c_void};
use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// A program on a machine, and how the one is to run on the other.
#[derive(Debug)]
pub struct LmSimulation(());

opaque!(LmSimulation(6, "simulation") is Planned);

/// A function of the caller's with what is handed to it.
#[derive(Clone, Copy)]
pub(crate) struct Callback<F> {
    pub(crate) function: F,
    pub(crate) user: *mut c_void,
}

// SAFETY: the interface says that a callback may come from a thread of the run, one at a time.
unsafe impl<F: Send> Send for Callback<F> {}
// SAFETY: as above: whoever shares it calls it from one thread at a time.
unsafe impl<F: Sync> Sync for Callback<F> {}

impl<F> Callback<F> {
    fn of(function: Option<F>, user: *mut c_void) -> Option<Callback<F>> {
        function.map(|function| Callback { function, user })
    }
}

/// The function inside a callback's type.
type Inner<T> = <T as IntoIterator>::Item;

/// A simulation.
pub struct Planned {
    pub(crate) program: lostmotion::Program,
    pub(crate) machine: lostmotion::Machine,
    path: std::path::PathBuf,
    methods: Vec<Choice>,
    reading: Map<String, Value>,
    running: Map<String, Value>,
    keeps_page: bool,
    on_progress: Option<Callback<Inner<LmOnProgress>>>,
    on_contour: Option<Callback<Inner<LmOnContour>>>,
    on_motors: Option<Callback<Inner<LmOnMotors>>>,
    on_blocks: Option<Callback<Inner<LmOnBlocks>>>,
    on_reversals: Option<Callback<Inner<LmOnReversals>>>,
    pub(crate) on_plan: Option<Callback<Inner<LmOnPlan>>>,
    running_now: AtomicBool,
    cancelled: AtomicBool,
}

/// A method.
enum Choice {
    Named(String),
    Own(Own),
}

/// Holds a simulation for a run, and lets it go however the run ends.
struct Running<'a>(&'a Planned);

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.0.running_now.store(false, Ordering::Release);
    }
}

impl Planned {
    /// For one run at a time, which others may cancel meanwhile.
    fn begun(&self) -> Result<Running<'_>, Failure> {
        if self.running_now.swap(true, Ordering::Acquire) {
            return Err(Failure::brief("simulation", Reason::Busy));
        }
        self.cancelled.store(false, Ordering::Relaxed);
        Ok(Running(self))
    }

    fn options(&self) -> Result<SimulateOptions, Failure> {
        let mut reading: ReadingRequest = understood(&self.reading)?;
        reading.part.clone_from(&self.path);
        let running: RunRequest = understood(&self.running)?;
        Ok(reading.options(&self.machine, running.options()?)?)
    }

    fn simulation(&self) -> Result<lostmotion::Simulation<'_>, Failure> {
        let options = self.options()?;
        Ok(lostmotion::Simulation::new(&self.program, &self.machine).options(options))
    }

    /// Tells how far a run is, and breaks where somebody wants its end.
    fn told(&self, progress: lostmotion::Progress) -> ControlFlow<()> {
        if let Some(Callback { function, user }) = self.on_progress {
            let told = LmProgress {
                done_bytes: progress.done_bytes,
                total_bytes: progress.total_bytes,
                simulated_s: progress.simulated_s,
                share: progress.share(),
            };
            // SAFETY: the caller's function with its own pointer; what is told lives through the call.
            if !unsafe { function(user, &told) } {
                self.cancel();
            }
        }
        let failed = |choice: &Choice| match choice {
            Choice::Named(_) => false,
            Choice::Own(own) => own.failed.load(Ordering::Relaxed),
        };
        if self.cancelled.load(Ordering::Relaxed) || self.methods.iter().any(failed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Hands rows to a callback of the caller's; nothing once the run is to end.
    fn hand<T>(&self, rows: &[T], callback: impl FnOnce(*const T, usize) -> bool) {
        if rows.is_empty() || self.cancelled.load(Ordering::Relaxed) {
            return;
        }
        if !callback(rows.as_ptr(), rows.len()) {
            self.cancel();
        }
    }

    fn refused(&self, error: &lostmotion::SimError) -> Failure {
        for choice in &self.methods {
            if let Choice::Own(own) = choice
                && own.failed.swap(false, Ordering::Relaxed)
            {
                let name = &own.name;
                let message = format!(
                    "the compensator \"{name}\" has failed, or answered what no drive can follow"
                );
                let hint = "answer finite angles (rad), speeds (rad/s) and torques (N m)";
                return Refusal::new(RefusalKind::Method, "correction", message, hint).into();
            }
        }
        Refusal::of_run(error, &self.program).into()
    }

    fn run(&self) -> Result<Done, Failure> {
        let _running = self.begun()?;
        let mut simulation = self.simulation()?;
        for choice in &self.methods {
            simulation = match choice {
                Choice::Named(name) => simulation.method(name),
                Choice::Own(own) => {
                    own.failed.store(false, Ordering::Relaxed);
                    let own = own.clone();
                    simulation.compensator(own.name.clone(), move |config| own.for_axis(config))
                }
            };
        }
        let count = self.methods.len().max(1);
        let mut watcher = Watcher {
            planned: self,
            texts: Texts::default(),
            page: self.keeps_page.then(|| PageRecorder::new(count)),
        };
        let run = simulation.observer(&mut watcher).run();
        let run = run.map_err(|error| self.refused(&error))?;
        let page = watcher.page.map(|recorder| recorder.finish(&run));
        Done::new(run, count > 1, page.as_ref(), &self.machine, &self.program)
    }

    /// Plans the program.
    fn plan(&self) -> Result<LmPlan, Failure> {
        let _running = self.begun()?;
        let rotary = self.machine.rotary_joints();
        let clock = self.machine.cycles().command();
        let mut rows = Vec::new();
        let mut sink = |samples: &[lostmotion::plan::Sample],
                        _: &[lostmotion::contour::ProgrammedSegment]| {
            if let Some(Callback { function, user }) = self.on_plan {
                rows.clear();
                rows.extend(
                    samples
                        .iter()
                        .map(|sample| plan_sample(sample, rotary, clock)),
                );
                // SAFETY: the caller's function with its own pointer; the rows live through the call.
                self.hand(&rows, |rows, count| unsafe { function(user, rows, count) });
            }
            Ok(())
        };
        let simulation = self.simulation()?;
        let plan = simulation
            .on_progress(|progress| self.told(progress))
            .plan(&mut sink)
            .map_err(|error| self.refused(&error))?;
        Ok(plan_told(&plan))
    }
}

fn understood<T: DeserializeOwned>(settings: &Map<String, Value>) -> Result<T, Failure> {
    serde_json::from_value(Value::Object(settings.clone()))
        .map_err(|error| Failure::option(error.to_string(), ""))
}

/// Hands rows to the caller as they are finished.
struct Watcher<'a> {
    planned: &'a Planned,
    /// Texts of the blocks at hand.
    texts: Texts,
    page: Option<PageRecorder>,
}

impl Observer for Watcher<'_> {
    fn progress(&mut self, progress: lostmotion::Progress) -> ControlFlow<()> {
        self.planned.told(progress)
    }

    fn blocks(&mut self, method: usize, rows: &[BlockResult]) {
        if let Some(Callback { function, user }) = self.planned.on_blocks {
            self.texts = Texts::default();
            let texts = &mut self.texts;
            let rows: Vec<LmBlock> = rows.iter().map(|row| block(row, texts)).collect();
            self.planned.hand(&rows, |rows, count| {
                // SAFETY: the caller's function with its own pointer; the rows live through the call.
                unsafe { function(user, method, rows, count) }
            });
        }
    }

    fn reversals(&mut self, method: usize, rows: &[ReversalResult]) {
        if let Some(Callback { function, user }) = self.planned.on_reversals {
            let row = |row: &ReversalResult| LmReversal {
                time_s: row.time_s,
                peak_um: row.peak_um,
                backlash_um: row.backlash_um,
                line: row.block.span.line,
                direction: row.direction.into(),
                axis: letter(row.axis),
                rapid: row.rapid,
            };
            let rows: Vec<LmReversal> = rows.iter().map(row).collect();
            self.planned.hand(&rows, |rows, count| {
                // SAFETY: as for blocks.
                unsafe { function(user, method, rows, count) }
            });
        }
    }

    fn contour(&mut self, method: usize, points: &[ContourPoint]) {
        if let Some(page) = &mut self.page {
            page.contour(method, points);
        }
        if let Some(Callback { function, user }) = self.planned.on_contour {
            let row = |point: &ContourPoint| LmContourSample {
                time_s: point.time_s,
                error_um: point.error_um,
                backlash_um: point.backlash_um,
                foot_mm: point.foot_mm,
                normal: point.normal,
                commanded_mm: point.commanded_mm,
                actual_mm: point.actual_mm,
                tool: point.tool,
                line: point.block.span.line,
                moving: point.moving,
                rapid: point.rapid,
            };
            let rows: Vec<LmContourSample> = points.iter().map(row).collect();
            self.planned.hand(&rows, |rows, count| {
                // SAFETY: as for blocks.
                unsafe { function(user, method, rows, count) }
            });
        }
    }

    fn wants_contour(&self) -> bool {
        let page = self.page.as_ref().is_some_and(Observer::wants_contour);
        page || self.planned.on_contour.is_some()
    }

    fn wants_limiters(&self) -> bool {
        self.page.as_ref().is_some_and(Observer::wants_limiters)
    }

    fn motors(&mut self, method: usize, points: &[MotorPoint]) {
        if let Some(page) = &mut self.page {
            page.motors(method, points);
        }
        if let Some(Callback { function, user }) = self.planned.on_motors {
            let row = |point: &MotorPoint| LmMotorSample {
                time_s: point.time_s,
                reference: point.reference,
                motor: point.motor,
                load: point.load,
                current_a: point.current_a,
                torque_nm: point.torque_nm,
                engagement: point.engagement.sign().into(),
                axis: letter(point.axis),
                second: point.second,
            };
            let rows: Vec<LmMotorSample> = points.iter().map(row).collect();
            self.planned.hand(&rows, |rows, count| {
                // SAFETY: as for blocks.
                unsafe { function(user, method, rows, count) }
            });
        }
    }

    fn wants_motors(&self) -> bool {
        let page = self.page.as_ref().is_some_and(Observer::wants_motors);
        page || self.planned.on_motors.is_some()
    }

    fn learning(&mut self, method: usize, time_s: f64, drives: &[Option<Learning>]) {
        if let Some(page) = &mut self.page {
            page.learning(method, time_s, drives);
        }
    }

    fn wants_learning(&self) -> bool {
        self.page.as_ref().is_some_and(Observer::wants_learning)
    }
}

/// A program on a machine, each axis with the method that the machine names for it, everything else
/// as the machine has it. Both may be freed afterwards.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `simulation` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_new(
    program: *const LmProgram,
    machine: *const LmMachine,
    simulation: *mut *mut LmSimulation,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(simulation, "simulation") }?;
        let (program, path) = look(program, |part: &Part| {
            Ok((part.program.clone(), part.path.clone()))
        })?;
        room.write(insert(Planned {
            program,
            machine: look(machine, |machine| Ok(machine.clone()))?,
            path,
            methods: Vec::new(),
            reading: Map::new(),
            // An embedding program decides how many threads there are.
            running: Map::from_iter([("threads".to_owned(), Value::from(1))]),
            keeps_page: false,
            on_progress: None,
            on_contour: None,
            on_motors: None,
            on_blocks: None,
            on_reversals: None,
            on_plan: None,
            running_now: AtomicBool::new(false),
            cancelled: AtomicBool::new(false),
        })?);
        Ok(())
    })
}

/// Name of a registered compensation method, and a line about it for people, by its number from 0;
/// `LM_STATUS_SIZE` behind the last one. The texts are constant.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `name` and `summary` are null or have room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_method(
    index: usize,
    name: *mut *const c_char,
    summary: *mut *const c_char,
) -> LmStatus {
    static METHODS: OnceLock<Vec<[CString; 2]>> = OnceLock::new();
    call(|| {
        // SAFETY: the caller's promise.
        let name = unsafe { out(name, "name") }?;
        // SAFETY: the caller's promise.
        let summary = unsafe { out(summary, "summary") }?;
        let methods = METHODS.get_or_init(|| {
            let texts = |method: MethodId| [method.name(), method.info().summary].map(c_text);
            MethodId::all().map(texts).collect()
        });
        let found = methods.get(index);
        let [known, line] = found.ok_or_else(|| beyond("index", index, methods.len()))?;
        name.write(known.as_ptr());
        summary.write(line.as_ptr());
        Ok(())
    })
}

/// Adds a registered compensation method for all axes; several are compared on one plan.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// `name` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_method(
    simulation: *mut LmSimulation,
    name: *const c_char,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "name") }?.to_owned();
        change(simulation, |planned| {
            planned.methods.push(Choice::Named(name));
            Ok(())
        })
    })
}

/// Adds a compensator of the caller's own for all axes.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// `compensator` is null or as `LmCompensator` says; its functions and `user` outlive the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_compensator(
    simulation: *mut LmSimulation,
    compensator: *const LmCompensator,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let own = unsafe { Own::of(compensator) }?;
        change(simulation, |planned| {
            planned.methods.push(Choice::Own(own));
            Ok(())
        })
    })
}

/// Whether settings of this kind have the key with such a value.
fn try_setting<T: DeserializeOwned>(key: &str, value: &Value) -> Result<(), String> {
    let settings = Map::from_iter([(key.to_owned(), value.clone())]);
    serde_json::from_value::<T>(Value::Object(settings))
        .map(drop)
        .map_err(|error| error.to_string())
}

/// The beginning of serde's message for a key that there is not.
const UNKNOWN: &str = "unknown field";

fn set(simulation: *mut LmSimulation, key: &str, value: Value) -> Result<(), Failure> {
    let run = try_setting::<RunRequest>(key, &value);
    let read = try_setting::<ReadingRequest>(key, &value);
    let is_of_run = match (run, read) {
        (Ok(()), _) => true,
        (_, Ok(())) => false,
        (Err(run), Err(read)) => {
            let known = [&run, &read]
                .into_iter()
                .find(|why| !why.starts_with(UNKNOWN));
            return Err(match known {
                Some(why) => Failure::option(format!("{key}: {why}"), ""),
                None => Failure::option(
                    format!("there is no setting \"{key}\""),
                    &format!("{run}; {read}"),
                ),
            });
        }
    };
    change(simulation, |planned| {
        let settings = if is_of_run {
            &mut planned.running
        } else {
            &mut planned.reading
        };
        settings.insert(key.to_owned(), value);
        Ok(())
    })
}

/// Sets a setting that is a number: `tolerance_um`, `cutting_force_n`, `bow_limit_um`, `sensitivity`
/// (percent), `max_duration_s`, `keep_blocks`, `keep_reversals`, `spline_tolerance_mm`, `threads` (1,
/// the default: the calling thread alone; 0: one per core).
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// `key` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_set(
    simulation: *mut LmSimulation,
    key: *const c_char,
    number: f64,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let key = unsafe { text(key, "key") }?;
        // Counts are whole numbers; so are many others.
        let whole = number as u64;
        let value = if whole as f64 == number && number < 9e15 {
            Value::from(whole)
        } else {
            serde_json::Number::from_f64(number)
                .map(Value::Number)
                .ok_or_else(|| {
                    Failure::option(format!("{key} is {number}"), "it has to be a finite number")
                })?
        };
        set(simulation, key, value)
    })
}

/// Sets a setting that is a text: `dialect`, `control`, `quality` ("fast", "optimal"), `tool_table`
/// and `learned` (the texts of the files).
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// `key` and `value` are null or end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_set_text(
    simulation: *mut LmSimulation,
    key: *const c_char,
    value: *const c_char,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let key = unsafe { text(key, "key") }?;
        // SAFETY: the caller's promise.
        let value = unsafe { text(value, "value") }?;
        set(simulation, key, Value::from(value))
    })
}

/// Sets a setting that is a list or a table, in JSON: `accept`, `refuse`, `subroutines` (lists of
/// texts), `m_codes` ({"M10": "dwell:1.5"}), `block_skips` ([1, 2]), `told` ({"3011": 20260101}),
/// `limits` ({"nesting": 20}), `interventions` ([[3.2, "hold", null], [4.0, "override", 0.5]]).
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// `key` and `json` are null or end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_set_json(
    simulation: *mut LmSimulation,
    key: *const c_char,
    json: *const c_char,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let key = unsafe { text(key, "key") }?;
        // SAFETY: the caller's promise.
        let json = unsafe { text(json, "json") }?;
        let value = serde_json::from_str(json)
            .map_err(|error| Failure::option(format!("{key} is no JSON: {error}"), ""))?;
        set(simulation, key, value)
    })
}

/// Whether the run keeps what its page needs (`lm_run_page`).
///
/// Threads: one at a time. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_simulation_keep_page(simulation: *mut LmSimulation, keep: bool) -> LmStatus {
    call(|| {
        change(simulation, |planned| {
            planned.keeps_page = keep;
            Ok(())
        })
    })
}

/// Sets who is told the progress; null for nobody. Callbacks of a run come one at a time: on the
/// calling thread where the setting `threads` is 1, which it is by default, else on one of the run's.
/// They must return: no `longjmp`, no C++ exception.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// The function takes `user` from any thread, as long as the simulation lives.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_on_progress(
    simulation: *mut LmSimulation,
    function: LmOnProgress,
    user: *mut c_void,
) -> LmStatus {
    let callback = Callback::of(function, user);
    call(|| {
        change(simulation, |planned| {
            planned.on_progress = callback;
            Ok(())
        })
    })
}

/// Sets who takes contour errors of all servo ticks; as `lm_simulation_on_progress`.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// As for `lm_simulation_on_progress`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_on_contour(
    simulation: *mut LmSimulation,
    function: LmOnContour,
    user: *mut c_void,
) -> LmStatus {
    let callback = Callback::of(function, user);
    call(|| {
        change(simulation, |planned| {
            planned.on_contour = callback;
            Ok(())
        })
    })
}

/// Sets who takes the signals of all motors at all servo ticks; as `lm_simulation_on_progress`.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// As for `lm_simulation_on_progress`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_on_motors(
    simulation: *mut LmSimulation,
    function: LmOnMotors,
    user: *mut c_void,
) -> LmStatus {
    let callback = Callback::of(function, user);
    call(|| {
        change(simulation, |planned| {
            planned.on_motors = callback;
            Ok(())
        })
    })
}

/// Sets who takes all blocks as they are finished; as `lm_simulation_on_progress`.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// As for `lm_simulation_on_progress`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_on_blocks(
    simulation: *mut LmSimulation,
    function: LmOnBlocks,
    user: *mut c_void,
) -> LmStatus {
    let callback = Callback::of(function, user);
    call(|| {
        change(simulation, |planned| {
            planned.on_blocks = callback;
            Ok(())
        })
    })
}

/// Sets who takes all reversals as they are finished; as `lm_simulation_on_progress`.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// As for `lm_simulation_on_progress`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_on_reversals(
    simulation: *mut LmSimulation,
    function: LmOnReversals,
    user: *mut c_void,
) -> LmStatus {
    let callback = Callback::of(function, user);
    call(|| {
        change(simulation, |planned| {
            planned.on_reversals = callback;
            Ok(())
        })
    })
}

/// Sets who takes the samples of `lm_simulation_plan`; as `lm_simulation_on_progress`.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// As for `lm_simulation_on_progress`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_on_plan(
    simulation: *mut LmSimulation,
    function: LmOnPlan,
    user: *mut c_void,
) -> LmStatus {
    let callback = Callback::of(function, user);
    call(|| {
        change(simulation, |planned| {
            planned.on_plan = callback;
            Ok(())
        })
    })
}

/// Runs the program and judges the contour error of each method. The simulation may run again.
///
/// Threads: any, one run at a time; others may cancel it. Real time: no.
///
/// # Safety
/// `run` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_run(
    simulation: *const LmSimulation,
    run: *mut *mut LmRun,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(run, "run") }?;
        room.write(insert(look(simulation, Planned::run)?)?);
        Ok(())
    })
}

/// Plans the motion alone; samples go to `lm_simulation_on_plan`.
///
/// Threads: as `lm_simulation_run`. Real time: no.
///
/// # Safety
/// `plan` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_simulation_plan(
    simulation: *const LmSimulation,
    plan: *mut LmPlan,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(plan, "plan") }?;
        room.write(look(simulation, Planned::plan)?);
        Ok(())
    })
}

/// Reads the program to its end and holds it against the machine, without moving anything.
///
/// Threads: as `lm_simulation_run`. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_simulation_check(simulation: *const LmSimulation) -> LmStatus {
    call(|| {
        look(simulation, |planned| {
            let _running = planned.begun()?;
            let checked = planned.simulation()?.check();
            checked.map(drop).map_err(|error| planned.refused(&error))
        })
    })
}

/// Ends the run that is going on, at its next second of motion; nothing where there is none.
///
/// Threads: any. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn lm_simulation_cancel(simulation: *const LmSimulation) -> LmStatus {
    call(|| {
        look(simulation, |planned| {
            planned.cancel();
            Ok(())
        })
    })
}

/// Frees a simulation; nothing for a null. Its runs stay.
///
/// Threads: any, when it does not run. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_simulation_free(simulation: *mut LmSimulation) -> LmStatus {
    call(|| free(simulation))
}
