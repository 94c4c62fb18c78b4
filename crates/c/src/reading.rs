//! What can be said of a part program without moving anything, beyond its findings: lints by level,
//! canonical operations, a style, everything computed.

use crate::border::{Texts, call, maybe_text, out};
use crate::failure::{Failure, LmStatus};
use crate::handle::{change, free, insert, look, opaque};
use crate::machine::{LmMachine, maybe_machine};
use crate::program::LmProgram;
use crate::text::{LmFindings, LmText, findings, text_of};
use lostmotion::report::json;
use lostmotion::report::reading::{
    Style, explained, formatted, found_in, levels_of, reader_of, resolved,
};
use lostmotion::report::refusal::{Refusal, placed};
use lostmotion::sim::program::Operations;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::ffi::c_char;
use std::sync::{Mutex, PoisonError};

/// The canonical operations of a program, made as they are asked for.
#[derive(Debug)]
pub struct LmOperations(());

// What reads a program may go to another thread, and is not for two at a time.
opaque!(LmOperations(8, "list of operations") is Mutex<Reading>);

/// A program as it is read.
pub struct Reading {
    reader: Operations,
    program: lostmotion::Program,
    /// Text of the last operation.
    shown: Texts,
}

/// A canonical operation, and the block that it comes from.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmOperation {
    /// The operation: `STRAIGHT_FEED(10.0000, ...)`.
    pub text: *const c_char,
    /// Line, from 1; 0 for what holds before the first block.
    pub line: u32,
    /// Column in bytes, from 1; 0 for what holds before the first block.
    pub column: u32,
    /// 0 for the program, n for the nth file of subroutines.
    pub file: u32,
}

/// A JSON object of the caller's; the usual values without it.
fn given<T: DeserializeOwned>(text: Option<&str>, what: &str, example: &str) -> Result<T, Failure> {
    serde_json::from_str(text.unwrap_or("{}")).map_err(|error| {
        let hint = format!("a JSON object, for example {example}");
        Failure::option(format!("{what} is not understood: {error}"), &hint)
    })
}

/// What interpreter and lints find in a program, in the order of its text. `levels` is a JSON object of
/// levels ("allow", "warn", "deny") by the code of a lint, for example {"all": "deny"}; null for the
/// usual ones. `machine` and `settings` as for `lm_program_findings`.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `settings` and `levels` are null or end with a zero; `found` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_lint(
    program: *const LmProgram,
    machine: *const LmMachine,
    settings: *const c_char,
    levels: *const c_char,
    found: *mut *mut LmFindings,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(found, "found") }?;
        // SAFETY: the caller's promise.
        let settings = unsafe { maybe_text(settings, "settings") }?;
        // SAFETY: the caller's promise.
        let levels = unsafe { maybe_text(levels, "levels") }?;
        let levels: BTreeMap<String, String> = given(levels, "levels", "{\"all\": \"deny\"}")?;
        // `all` first: a level for a lint itself goes before it.
        let all = levels.iter().filter(|(code, _)| *code == "all");
        let others = levels.iter().filter(|(code, _)| *code != "all");
        let levels = levels_of(
            all.chain(others)
                .map(|(code, level)| (code.as_str(), level.as_str())),
        )?;
        let machine = maybe_machine(machine)?;
        let all = look(program, |part| {
            let reading = part.reading(settings)?;
            let all = found_in(&part.program, &reading, machine.as_ref(), Some(levels))?;
            Ok(all
                .into_iter()
                .map(|finding| placed(finding, &part.program))
                .collect::<Vec<_>>())
        })?;
        room.write(findings(&all)?);
        Ok(())
    })
}

/// Starts to read a program's canonical operations, which `lm_operations_next` gives. `machine` and
/// `settings` as for `lm_program_findings`.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `settings` is null or ends with a zero; `operations` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_operations(
    program: *const LmProgram,
    machine: *const LmMachine,
    settings: *const c_char,
    operations: *mut *mut LmOperations,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(operations, "operations") }?;
        // SAFETY: the caller's promise.
        let settings = unsafe { maybe_text(settings, "settings") }?;
        let machine = maybe_machine(machine)?;
        let reading = look(program, |part| {
            let reading = part.reading(settings)?;
            let (reader, _) = reader_of(&part.program, &reading, machine.as_ref())?;
            Ok(Mutex::new(Reading {
                reader,
                program: part.program.clone(),
                shown: Texts::default(),
            }))
        })?;
        room.write(insert(reading)?);
        Ok(())
    })
}

/// The next operation. Its text is valid until the next call with these operations; null at the end.
/// Where there was something wrong on the way, the end is answered with `LM_STATUS_PROGRAM`.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// `operation` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_operations_next(
    operations: *mut LmOperations,
    operation: *mut LmOperation,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(operation, "operation") }?;
        room.write(change(operations, |reading| {
            let reading = reading.get_mut();
            reading.unwrap_or_else(PoisonError::into_inner).next()
        })?);
        Ok(())
    })
}

impl Reading {
    fn next(&mut self) -> Result<LmOperation, Failure> {
        if let Some(found) = self.reader.next() {
            self.shown = Texts::default();
            let span = found.block.span;
            return Ok(LmOperation {
                text: self.shown.of(&found.op.to_string()),
                line: span.line,
                column: span.column,
                file: span.file,
            });
        }
        let diagnostics = self.reader.diagnostics();
        if diagnostics.errors() == 0 {
            return Ok(LmOperation {
                text: std::ptr::null(),
                line: 0,
                column: 0,
                file: 0,
            });
        }
        let error = lostmotion::SimError::Program {
            name: self.program.name().to_owned(),
            diagnostics: Box::new(diagnostics.clone()),
        };
        Err(Refusal::of_run(&error, &self.program).into())
    }
}

/// Frees operations; nothing for a null.
///
/// Threads: any, when no other uses it. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_operations_free(operations: *mut LmOperations) -> LmStatus {
    call(|| free(operations))
}

/// The program in a style of one's own: `style` is a JSON object with "case" ("upper", "lower",
/// "keep"), "indent" (blanks for each level of O-words) and "line_numbers" ("keep", "remove", or the
/// step of new ones as a text); what is left out is as in `lm_program_format`.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `style` is null or ends with a zero; `formatted_text` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_format_as(
    program: *const LmProgram,
    style: *const c_char,
    formatted_text: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(formatted_text, "formatted_text") }?;
        // SAFETY: the caller's promise.
        let style = unsafe { maybe_text(style, "style") }?;
        let style: Style = given(style, "style", "{\"line_numbers\": \"10\"}")?;
        let text = look(program, |part| Ok(formatted(&part.program, &style)?))?;
        room.write(text_of(&text)?);
        Ok(())
    })
}

/// The program with everything computed: no parameters, loops, calls, cycles, offsets. `system` is the
/// work coordinate system of the coordinates, 1 for G54 to 9 for G59.3; `machine` and `settings` as for
/// `lm_program_findings`.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `settings` is null or ends with a zero; `resolved_text` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_resolved(
    program: *const LmProgram,
    machine: *const LmMachine,
    settings: *const c_char,
    system: u8,
    resolved_text: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(resolved_text, "resolved_text") }?;
        // SAFETY: the caller's promise.
        let settings = unsafe { maybe_text(settings, "settings") }?;
        let machine = maybe_machine(machine)?;
        let text = look(program, |part| {
            let reading = part.reading(settings)?;
            Ok(resolved(&part.program, &reading, machine.as_ref(), system)?)
        })?;
        room.write(text_of(&text)?);
        Ok(())
    })
}

/// What a line does, as data: the JSON document of `lostmotion gcode explain`. `machine` and `settings`
/// as for `lm_program_findings`.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `settings` is null or ends with a zero; `document` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_explain_json(
    program: *const LmProgram,
    machine: *const LmMachine,
    settings: *const c_char,
    line: u32,
    document: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(document, "document") }?;
        // SAFETY: the caller's promise.
        let settings = unsafe { maybe_text(settings, "settings") }?;
        let machine = maybe_machine(machine)?;
        let text = look(program, |part| {
            let reading = part.reading(settings)?;
            let told = explained(&part.program, &reading, machine.as_ref(), line)?;
            let mut text = Vec::new();
            json::write(&mut text, &told).map_err(|error| Failure::internal(error.to_string()))?;
            Ok(String::from_utf8_lossy(&text).into_owned())
        })?;
        room.write(text_of(&text)?);
        Ok(())
    })
}
