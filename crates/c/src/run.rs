//! What came of a run.

use crate::border::{Texts, call, out, text};
use crate::error::beyond;
use crate::failure::{Failure, LmStatus, c_text};
use crate::handle::{free, look, opaque};
use crate::rows::{LmBlock, LmErrorStats, LmPlan, block, plan_told, stats};
use crate::text::{LmText, text_of};
use lostmotion::report::page::{Gathered, page};
use lostmotion::report::refusal::Refusal;
use lostmotion::report::{json, text as tables};
use lostmotion::sim::machine::Memory;
use lostmotion::sim::results::{self, MethodResult};
use serde_json::Value;
use std::ffi::{CString, c_char};
use std::sync::OnceLock;

/// What came of a run. It does not change.
#[derive(Debug)]
pub struct LmRun(());

opaque!(LmRun(7, "run") is Done);

/// How one method did.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmMethodResult {
    /// Its name.
    pub method: *const c_char,
    /// Contour error of cutting moves.
    pub cutting: LmErrorStats,
    /// Contour error of rapids.
    pub rapid: LmErrorStats,
    /// What backlash adds to the error on cutting moves.
    pub backlash: LmErrorStats,
    /// Blocks that the list of the worst has (`lm_run_worst_block`).
    pub worst_blocks: usize,
    /// Number of all reversals.
    pub reversals: u64,
    /// Whether the largest error of cutting moves is within the tolerance, and the machine not
    /// stopped.
    pub within_tolerance: bool,
    /// Whether the control stops the machine.
    pub stopped: bool,
}

/// The answer of a run.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmRunInfo {
    /// Name of the method that is recommended; null where none is.
    pub recommended: *const c_char,
    /// Tolerance of the verdict, um.
    pub tolerance_um: f64,
    /// The plan.
    pub plan: LmPlan,
    /// The same machine without any gap and without compensation.
    pub without_gap: LmErrorStats,
    /// Number of methods.
    pub results: usize,
    /// Whether the method that decides keeps the tolerance: of several the recommended one.
    pub within_tolerance: bool,
}

/// A run.
pub struct Done {
    run: results::Run,
    compared: bool,
    page: Option<String>,
    recommended: Option<CString>,
    /// Name of each method, and its worst blocks.
    methods: Vec<(CString, Blocks)>,
    /// All figures as data.
    figures: OnceLock<Value>,
}

/// Blocks with the texts that they point to.
struct Blocks {
    blocks: Vec<LmBlock>,
    _texts: Texts,
}

// SAFETY: the pointers of the blocks are into texts that are kept with them and never change.
unsafe impl Send for Blocks {}
// SAFETY: as above.
unsafe impl Sync for Blocks {}

impl Blocks {
    fn of(result: &MethodResult) -> Blocks {
        let mut texts = Texts::default();
        let blocks = result.worst_blocks.iter();
        Blocks {
            blocks: blocks.map(|row| block(row, &mut texts)).collect(),
            _texts: texts,
        }
    }
}

impl Done {
    pub(crate) fn new(
        run: results::Run,
        compared: bool,
        recorded: Option<&Gathered>,
        machine: &lostmotion::Machine,
        program: &lostmotion::Program,
    ) -> Result<Done, Failure> {
        let page = recorded
            .map(|recorded| page(&run, machine, program, recorded))
            .transpose()
            .map_err(|error| Refusal::unread(program, &error))?;
        let of = |result: &MethodResult| (c_text(&result.method), Blocks::of(result));
        Ok(Done {
            page,
            compared,
            recommended: run.recommended.as_deref().map(c_text),
            methods: run.results.iter().map(of).collect(),
            figures: OnceLock::new(),
            run,
        })
    }
}

/// The answer of a run; its texts are valid until the run is freed.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `info` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_run_info(run: *const LmRun, info: *mut LmRunInfo) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(info, "info") }?;
        room.write(look(run, |done| {
            let recommended = done.recommended.as_ref();
            Ok(LmRunInfo {
                recommended: recommended.map_or(std::ptr::null(), |name| name.as_ptr()),
                tolerance_um: done.run.tolerance_um,
                plan: plan_told(&done.run.plan),
                without_gap: stats(&done.run.without_gap),
                results: done.run.results.len(),
                within_tolerance: done.run.is_within_tolerance(),
            })
        })?);
        Ok(())
    })
}

/// How a method did, by its number in the order of the methods; its name is valid until the run is
/// freed.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `result` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_run_result(
    run: *const LmRun,
    index: usize,
    result: *mut LmMethodResult,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(result, "result") }?;
        room.write(look(run, |done| {
            let found = done.run.results.get(index).zip(done.methods.get(index));
            let (result, (name, _)) =
                found.ok_or_else(|| beyond("index", index, done.methods.len()))?;
            Ok(LmMethodResult {
                method: name.as_ptr(),
                cutting: stats(&result.cutting),
                rapid: stats(&result.rapid),
                backlash: stats(&result.backlash),
                worst_blocks: result.worst_blocks.len(),
                reversals: result.reversal_count,
                within_tolerance: result.within_tolerance,
                stopped: result.stop.is_some(),
            })
        })?);
        Ok(())
    })
}

/// One of a method's blocks with the largest errors, worst first; its texts are valid until the run
/// is freed.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `block` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_run_worst_block(
    run: *const LmRun,
    method: usize,
    index: usize,
    block: *mut LmBlock,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(block, "block") }?;
        room.write(look(run, |done| {
            let found = done.methods.get(method);
            let (_, blocks) = found.ok_or_else(|| beyond("method", method, done.methods.len()))?;
            let found = blocks.blocks.get(index).copied();
            found.ok_or_else(|| beyond("index", index, blocks.blocks.len()))
        })?);
        Ok(())
    })
}

/// Any figure of the run in full, by its place in the document as a JSON pointer:
/// "/results/0/cutting/max", "/plan/duration_s". NaN for one that is not known (null).
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `pointer` is null or ends with a zero; `number` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_run_number(
    run: *const LmRun,
    pointer: *const c_char,
    number: *mut f64,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(number, "number") }?;
        // SAFETY: the caller's promise.
        let pointer = unsafe { text(pointer, "pointer") }?;
        room.write(look(run, |done| {
            let figures = done
                .figures
                .get_or_init(|| serde_json::to_value(&done.run).unwrap_or_default());
            let found = match figures.pointer(pointer) {
                Some(Value::Null) => Some(f64::NAN),
                Some(value) => value.as_f64(),
                None => None,
            };
            found.ok_or_else(|| {
                let hint = "a JSON pointer, for example /results/0/cutting/max";
                Failure::option(format!("the run has no number at \"{pointer}\""), hint)
            })
        })?);
        Ok(())
    })
}

/// The document that the command prints with `--format json`.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `document` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_run_json(run: *const LmRun, document: *mut *mut LmText) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(document, "document") }?;
        let text = look(run, |done| {
            let mut text = Vec::new();
            json::write_answer(&mut text, &done.run, done.compared)
                .map_err(|error| Failure::internal(error.to_string()))?;
            Ok(String::from_utf8_lossy(&text).into_owned())
        })?;
        room.write(text_of(&text)?);
        Ok(())
    })
}

/// The answer for people, as the command prints it.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `answer` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_run_text(run: *const LmRun, answer: *mut *mut LmText) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(answer, "answer") }?;
        let options = tables::TextOptions::default();
        let text = look(run, |done| {
            Ok(tables::answer(&done.run, done.compared, &options))
        })?;
        room.write(text_of(&text)?);
        Ok(())
    })
}

/// The page of the run for a browser, where `lm_simulation_keep_page` asked for it.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `html` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_run_page(run: *const LmRun, html: *mut *mut LmText) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(html, "html") }?;
        let text = look(run, |done| {
            done.page.clone().ok_or_else(|| {
                let hint = "lm_simulation_keep_page before the run";
                Failure::option("the run has kept no page", hint)
            })
        })?;
        room.write(text_of(&text)?);
        Ok(())
    })
}

/// What the last method that learns has learned of the axes, as the text of a file for the setting
/// `learned`; empty where none has.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `toml` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_run_learned(run: *const LmRun, toml: *mut *mut LmText) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(toml, "toml") }?;
        let text = look(run, |done| {
            let mut memory = done.run.results.iter().map(|result| &result.learned);
            let text = memory
                .rfind(|memory| !memory.is_empty())
                .map(Memory::to_toml)
                .transpose();
            text.map_err(|error| Failure::internal(error.to_string()))
        })?;
        room.write(text_of(&text.unwrap_or_default())?);
        Ok(())
    })
}

/// Frees a run; nothing for a null.
///
/// Threads: any, when no other uses it. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_run_free(run: *mut LmRun) -> LmStatus {
    call(|| free(run))
}
