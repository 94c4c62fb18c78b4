//! Part programs.

use crate::border::{call, list, maybe_text, out, text};
use crate::failure::{Failure, LmStatus};
use crate::handle::{free, insert, look, opaque};
use crate::machine::{LmMachine, maybe_machine};
use crate::text::{LmFindings, LmText, findings, text_of};
use lostmotion::gcode_tools::explain::explain;
use lostmotion::gcode_tools::format::{FormatOptions, format};
use lostmotion::gcode_tools::lint::Levels;
use lostmotion::report::refusal::{Refusal, findings_of, operations_of, placed};
use lostmotion::sim::request::ReadingRequest;
use std::ffi::c_char;
use std::path::PathBuf;

/// A part program: a text, or a file that is read where it stands.
#[derive(Debug)]
pub struct LmProgram(());

opaque!(LmProgram(3, "program") is Part);

/// A part program.
pub struct Part {
    pub(crate) program: lostmotion::Program,
    /// Where it stands, if it is a file.
    pub(crate) path: PathBuf,
}

/// A program of `length` bytes of G-code, which are copied; `name` is for messages.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `name` is null or ends with a zero; `code` is null or has `length` bytes; `program` is null or has
/// room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_from_text(
    name: *const c_char,
    code: *const c_char,
    length: usize,
    program: *mut *mut LmProgram,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(program, "program") }?;
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "name") }?;
        // SAFETY: the caller's promise; a character is a byte.
        let code = unsafe { list(code.cast::<u8>(), length, "code") }?;
        room.write(insert(Part {
            program: lostmotion::Program::from_bytes(name, code),
            path: PathBuf::new(),
        })?);
        Ok(())
    })
}

/// A program in a file, which is read again by each run.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `path` is null or ends with a zero; `program` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_from_file(
    path: *const c_char,
    program: *mut *mut LmProgram,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(program, "program") }?;
        // SAFETY: the caller's promise.
        let path = PathBuf::from(unsafe { text(path, "path") }?);
        let program = lostmotion::Program::from_path(&path);
        program
            .len()
            .map_err(|error| Refusal::unread(&program, &error))?;
        room.write(insert(Part { program, path })?);
        Ok(())
    })
}

/// Frees a program; nothing for a null. Simulations of it go on.
///
/// Threads: any, when no other uses it. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_program_free(program: *mut LmProgram) -> LmStatus {
    call(|| free(program))
}

impl Part {
    /// Settings as `lm_simulation_set` has them, in a JSON object; the usual ones without it.
    pub(crate) fn reading(&self, settings: Option<&str>) -> Result<ReadingRequest, Failure> {
        let mut reading: ReadingRequest =
            serde_json::from_str(settings.unwrap_or("{}")).map_err(|error| {
                let hint = "a JSON object, for example {\"dialect\": \"fanuc\"}";
                Failure::option(format!("settings are not understood: {error}"), hint)
            })?;
        reading.part.clone_from(&self.path);
        Ok(reading)
    }
}

/// What is wrong with a program, with `lints` also what is allowed and may break something.
///
/// `machine` may be null; its dialect, tools and parameters are used otherwise. `settings` may be
/// null, or is a JSON object with the settings of `lm_simulation_set` that say how a program is read.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `settings` is null or ends with a zero; `found` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_findings(
    program: *const LmProgram,
    machine: *const LmMachine,
    settings: *const c_char,
    lints: bool,
    found: *mut *mut LmFindings,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(found, "found") }?;
        // SAFETY: the caller's promise.
        let settings = unsafe { maybe_text(settings, "settings") }?;
        let machine = maybe_machine(machine)?;
        let all = look(program, |part| {
            let (config, loader) = part.reading(settings)?.config(machine.as_ref())?;
            let levels = lints.then(Levels::default);
            let all = findings_of(&part.program, config, loader, levels)?.into_iter();
            Ok(all
                .map(|finding| placed(finding, &part.program))
                .collect::<Vec<_>>())
        })?;
        room.write(findings(&all)?);
        Ok(())
    })
}

/// What a line does, for people. `machine` and `settings` as for `lm_program_findings`.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `settings` is null or ends with a zero; `explanation` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_explain(
    program: *const LmProgram,
    machine: *const LmMachine,
    settings: *const c_char,
    line: u32,
    explanation: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(explanation, "explanation") }?;
        // SAFETY: the caller's promise.
        let settings = unsafe { maybe_text(settings, "settings") }?;
        let machine = maybe_machine(machine)?;
        let told = look(program, |part| {
            let (config, loader) = part.reading(settings)?.config(machine.as_ref())?;
            let mut reader = operations_of(&part.program, config, loader)?;
            explain(&mut reader, line).ok_or_else(|| {
                let message = format!("{} has no line {line}", part.program.name());
                Failure::option(message, "lines count from 1")
            })
        })?;
        room.write(text_of(&told.to_string())?);
        Ok(())
    })
}

/// The program in one style: words in upper case, apart from each other, subroutines indented.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `formatted` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_program_format(
    program: *const LmProgram,
    formatted: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(formatted, "formatted") }?;
        let text = look(program, |part| {
            let unread = |error: std::io::Error| Refusal::unread(&part.program, &error);
            let mut text = Vec::new();
            let reader = part.program.open().map_err(unread)?;
            format(reader, &FormatOptions::default(), &mut text).map_err(unread)?;
            Ok(String::from_utf8_lossy(&text).into_owned())
        })?;
        room.write(text_of(&text)?);
        Ok(())
    })
}
