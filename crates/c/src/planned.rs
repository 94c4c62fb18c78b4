//! What a simulation of the interface is: its program, machine, methods, settings and callbacks, and
//! how it is run.

use crate::border::Texts;
use crate::compensator::Own;
use crate::failure::{Failure, Reason};
use crate::rows::{
    LmBlock, LmContourSample, LmMotorSample, LmOnBlocks, LmOnContour, LmOnMotors, LmOnPlan,
    LmOnProgress, LmOnReversals, LmPlan, LmProgress, LmReversal, block, letter, plan_sample,
    plan_told,
};
use crate::run::Done;
use lostmotion::drive::Learning;
use lostmotion::report::page::PageRecorder;
use lostmotion::report::refusal::{Refusal, RefusalKind};
use lostmotion::sim::MotorPoint;
use lostmotion::sim::request::{ReadingRequest, RunRequest};
use lostmotion::sim::results::{BlockResult, ReversalResult};
use lostmotion::{ContourPoint, Observer, SimulateOptions};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::ffi::c_void;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

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
    pub(crate) fn of(function: Option<F>, user: *mut c_void) -> Option<Callback<F>> {
        function.map(|function| Callback { function, user })
    }
}

/// The function inside a callback's type.
pub(crate) type Inner<T> = <T as IntoIterator>::Item;

/// A simulation.
pub(crate) struct Planned {
    pub(crate) program: lostmotion::Program,
    pub(crate) machine: lostmotion::Machine,
    pub(crate) path: std::path::PathBuf,
    pub(crate) methods: Vec<Choice>,
    pub(crate) reading: Map<String, Value>,
    pub(crate) running: Map<String, Value>,
    pub(crate) keeps_page: bool,
    pub(crate) on_progress: Option<Callback<Inner<LmOnProgress>>>,
    pub(crate) on_contour: Option<Callback<Inner<LmOnContour>>>,
    pub(crate) on_motors: Option<Callback<Inner<LmOnMotors>>>,
    pub(crate) on_blocks: Option<Callback<Inner<LmOnBlocks>>>,
    pub(crate) on_reversals: Option<Callback<Inner<LmOnReversals>>>,
    pub(crate) on_plan: Option<Callback<Inner<LmOnPlan>>>,
    pub(crate) running_now: AtomicBool,
    pub(crate) cancelled: AtomicBool,
}

/// A method.
pub(crate) enum Choice {
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

    pub(crate) fn options(&self) -> Result<SimulateOptions, Failure> {
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

    pub(crate) fn cancel(&self) {
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

    pub(crate) fn run(&self) -> Result<Done, Failure> {
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

    /// Checks the program on the machine without moving.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let _running = self.begun()?;
        let checked = self.simulation()?.check();
        checked.map(drop).map_err(|error| self.refused(&error))
    }

    /// Plans the program.
    pub(crate) fn plan(&self) -> Result<LmPlan, Failure> {
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
