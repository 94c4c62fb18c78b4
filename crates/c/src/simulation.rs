//! Simulations: a program on a machine, what is to be done with it, and who looks on.

use crate::border::{call, out, text};
use crate::compensator::{LmCompensator, Own};
use crate::error::beyond;
use crate::failure::{Failure, LmStatus, c_text};
use crate::handle::{change, free, insert, look, opaque};
use crate::machine::LmMachine;
use crate::planned::{Callback, Choice, Planned};
use crate::program::{LmProgram, Part};
use crate::rows::{
    LmOnBlocks, LmOnContour, LmOnMotors, LmOnPlan, LmOnProgress, LmOnReversals, LmPlan,
};
use crate::run::LmRun;
use lostmotion::methods::MethodId;
use lostmotion::sim::request::{ReadingRequest, RunRequest};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::ffi::{CString, c_char, c_void};
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

/// A program on a machine, and how the one is to run on the other.
#[derive(Debug)]
pub struct LmSimulation(());

opaque!(LmSimulation(6, "simulation") is Planned);

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
    call(|| look(simulation, Planned::check))
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
