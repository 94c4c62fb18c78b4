//! What went wrong last in a thread.

use crate::border::{call, out};
use crate::failure::{Failure, LmFinding, LmStatus, Reason, Told, forget, with_last};
use std::ffi::c_char;

/// What went wrong in the last call of this thread that did not answer `LM_STATUS_OK`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmError {
    /// What that call answered; `LM_STATUS_OK` where none has failed.
    pub status: LmStatus,
    /// Stable name of the reason.
    pub code: *const c_char,
    /// What is wrong, with place and values.
    pub message: *const c_char,
    /// What to do; may be empty.
    pub hint: *const c_char,
    /// File of the first finding; empty without one.
    pub file: *const c_char,
    /// Its line, from 1; 0 without a place.
    pub line: u32,
    /// Its column in bytes, from 1; 0 without a place.
    pub column: u32,
    /// How many findings there are (`lm_error_finding`).
    pub findings: usize,
}

/// What went wrong last in this thread. The texts are valid until the next call of this thread that
/// fails, or `lm_error_clear`.
///
/// Threads: any; each has its own. Real time: no.
///
/// # Safety
/// `error` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_error(error: *mut LmError) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(error, "error") }?;
        let told = with_last(|kept| {
            let first = kept.findings.first().map(Told::shown);
            LmError {
                status: kept.status.unwrap_or(LmStatus::Ok),
                code: kept.code.as_ptr(),
                message: kept.message.as_ptr(),
                hint: kept.hint.as_ptr(),
                file: first.map_or(c"".as_ptr(), |first| first.file),
                line: first.map_or(0, |first| first.line),
                column: first.map_or(0, |first| first.column),
                findings: kept.findings.len(),
            }
        });
        room.write(told.ok_or_else(ending)?);
        Ok(())
    })
}

fn ending() -> Failure {
    Failure::internal("the thread is ending")
}

/// A finding of what went wrong last in this thread; its texts are valid as those of `lm_error`.
///
/// Threads: any; each has its own. Real time: no.
///
/// # Safety
/// `finding` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_error_finding(index: usize, finding: *mut LmFinding) -> LmStatus {
    // A wrong index answers without being kept: it would take the place of what is being read.
    let found = with_last(|kept| kept.findings.get(index).map(Told::shown)).flatten();
    let Some(found) = found else {
        return LmStatus::Size;
    };
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(finding, "finding") }?;
        room.write(found);
        Ok(())
    })
}

/// Forgets what went wrong last in this thread. A thread that has called it once has all that its
/// errors need: call it before a real-time loop.
///
/// Threads: any; each has its own. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_error_clear() {
    forget();
}

/// Number of an index that is too large.
pub(crate) fn beyond(what: &'static str, index: usize, count: usize) -> Failure {
    Failure::brief(what, Reason::Size(index, count.saturating_sub(1)))
}
