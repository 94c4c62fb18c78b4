//! Texts and lists of findings that the caller owns.

use crate::border::{call, out};
use crate::error::beyond;
use crate::failure::{Failure, LmFinding, LmStatus, Told, c_text};
use crate::handle::{free, insert, look, opaque};
use lostmotion::report::findings::Finding;
use std::ffi::{CString, c_char};

/// A text: UTF-8 with a zero at its end.
#[derive(Debug)]
pub struct LmText(());

opaque!(LmText(1, "text") is CString);

/// A list of findings.
#[derive(Debug)]
pub struct LmFindings(());

opaque!(LmFindings(2, "list of findings") is Findings);

/// Findings as C reads them.
pub struct Findings(Vec<Told>);

pub(crate) fn findings(found: &[Finding]) -> Result<*mut LmFindings, Failure> {
    insert(Findings(found.iter().map(Told::of).collect()))
}

/// A handle of a text.
pub(crate) fn text_of(text: &str) -> Result<*mut LmText, Failure> {
    insert(c_text(text))
}

/// The characters of a text, valid until it is freed, and how many bytes they are without the zero
/// at their end; `length` may be null.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `characters` is null or has room; so has `length`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_text(
    text: *const LmText,
    characters: *mut *const c_char,
    length: *mut usize,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(characters, "characters") }?;
        let (pointer, bytes) = look(text, |text| Ok((text.as_ptr(), text.as_bytes().len())))?;
        room.write(pointer);
        if !length.is_null() {
            // SAFETY: the caller's promise.
            let room = unsafe { out(length, "length") }?;
            room.write(bytes);
        }
        Ok(())
    })
}

/// Frees a text; nothing for a null.
///
/// Threads: any, when no other uses it. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_text_free(text: *mut LmText) -> LmStatus {
    call(|| free(text))
}

/// How many findings there are.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `count` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_findings_count(
    findings: *const LmFindings,
    count: *mut usize,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(count, "count") }?;
        room.write(look(findings, |findings| Ok(findings.0.len()))?);
        Ok(())
    })
}

/// A finding; its texts are valid until the list is freed.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `finding` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_findings_get(
    findings: *const LmFindings,
    index: usize,
    finding: *mut LmFinding,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(finding, "finding") }?;
        room.write(look(findings, |findings| {
            let found = findings.0.get(index);
            found
                .map(Told::shown)
                .ok_or_else(|| beyond("index", index, findings.0.len()))
        })?);
        Ok(())
    })
}

/// Frees a list of findings; nothing for a null.
///
/// Threads: any, when no other uses it. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_findings_free(findings: *mut LmFindings) -> LmStatus {
    call(|| free(findings))
}
