//! Machines.

use crate::border::{call, list, maybe_text, out, text};
use crate::error::beyond;
use crate::failure::{Failure, LmStatus, Reason, c_text};
use crate::handle::{free, insert, look, opaque};
use crate::text::{LmFindings, LmText, findings, text_of};
use lostmotion::report::refusal::{Refusal, RefusalKind};
use lostmotion::sim::files;
use lostmotion::sim::import::{ImportFormat, ImportOptions, import};
use lostmotion::sim::machine::{AxisReview, Change, MachineFile, PresetInfo, presets};
use serde_json::Value;
use std::ffi::{CString, c_char};
use std::path::Path;
use std::sync::OnceLock;

/// A machine: checked, and never changed.
#[derive(Debug)]
pub struct LmMachine(());

opaque!(LmMachine(4, "machine") is lostmotion::Machine);

/// The machine of a handle, or none for a null.
pub(crate) fn maybe_machine(
    machine: *const LmMachine,
) -> Result<Option<lostmotion::Machine>, Failure> {
    if machine.is_null() {
        return Ok(None);
    }
    look(machine, |machine| Ok(Some(machine.clone())))
}

/// A machine that comes with the library: "vmc3", "vmc3-worn", "bench3" and others.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `name` is null or ends with a zero; `machine` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_preset(
    name: *const c_char,
    machine: *mut *mut LmMachine,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(machine, "machine") }?;
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "name") }?;
        room.write(insert(lostmotion::Machine::preset(name)?)?);
        Ok(())
    })
}

/// Name of a machine that comes with the library, and a line about it for people, by its number from
/// 0; `LM_STATUS_SIZE` behind the last one. The texts are constant.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `name` and `summary` are null or have room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_preset(
    index: usize,
    name: *mut *const c_char,
    summary: *mut *const c_char,
) -> LmStatus {
    static PRESETS: OnceLock<Vec<[CString; 2]>> = OnceLock::new();
    call(|| {
        // SAFETY: the caller's promise.
        let name = unsafe { out(name, "name") }?;
        // SAFETY: the caller's promise.
        let summary = unsafe { out(summary, "summary") }?;
        let all = PRESETS.get_or_init(|| {
            let texts = |preset: &PresetInfo| [preset.name, preset.summary].map(c_text);
            presets().iter().map(texts).collect()
        });
        let found = all.get(index);
        let [known, line] = found.ok_or_else(|| beyond("index", index, all.len()))?;
        name.write(known.as_ptr());
        summary.write(line.as_ptr());
        Ok(())
    })
}

/// A machine from the text of a machine file; `name` is for messages.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `name` and `toml` are null or end with a zero; `machine` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_from_toml(
    name: *const c_char,
    toml: *const c_char,
    machine: *mut *mut LmMachine,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(machine, "machine") }?;
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "name") }?;
        // SAFETY: the caller's promise.
        let toml = unsafe { text(toml, "toml") }?;
        room.write(insert(lostmotion::Machine::from_toml(name, toml)?)?);
        Ok(())
    })
}

/// A machine from a JSON object with the keys of machine files, as a program makes it.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `json` is null or ends with a zero; `machine` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_from_json(
    json: *const c_char,
    machine: *mut *mut LmMachine,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(machine, "machine") }?;
        // SAFETY: the caller's promise.
        let json = unsafe { text(json, "json") }?;
        let file: MachineFile = serde_json::from_str(json).map_err(|error| {
            let message = format!("this is no description of a machine: {error}");
            let hint = "keys are those of machine files";
            Refusal::new(RefusalKind::Machine, "machine", message, hint)
        })?;
        room.write(insert(file.check()?)?);
        Ok(())
    })
}

/// A machine from a file.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `path` is null or ends with a zero; `machine` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_from_file(
    path: *const c_char,
    machine: *mut *mut LmMachine,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(machine, "machine") }?;
        // SAFETY: the caller's promise.
        let path = unsafe { text(path, "path") }?;
        let toml = files::text(Path::new(path)).map_err(|error| {
            let message = format!("cannot read {path}: {error}");
            Refusal::new(RefusalKind::Machine, "read", message, "")
        })?;
        room.write(insert(lostmotion::Machine::from_toml(path, &toml)?)?);
        Ok(())
    })
}

/// Another machine, with `count` keys of the first one changed: `keys[i]` is a key of machine files,
/// for example "axis.x.load.slide.gap_um", `values[i]` its value as it stands in one, for example
/// "25.0" or "\"quintic\"".
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `keys` and `values` are null or have `count` texts that end with a zero; `edited` is null or has
/// room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_edit(
    machine: *const LmMachine,
    keys: *const *const c_char,
    values: *const *const c_char,
    count: usize,
    edited: *mut *mut LmMachine,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(edited, "edited") }?;
        // SAFETY: the caller's promise.
        let keys = unsafe { list(keys, count, "keys") }?;
        // SAFETY: the caller's promise.
        let values = unsafe { list(values, count, "values") }?;
        let change = |(key, value): (&*const c_char, &*const c_char)| {
            // SAFETY: the caller's promise.
            let key = unsafe { text(*key, "a key") }?.to_owned();
            // SAFETY: the caller's promise.
            let value = unsafe { text(*value, "a value") }?.to_owned();
            let name = format!("{key} = {value}");
            Ok(Change { name, key, value })
        };
        let changes: Result<Vec<Change>, Failure> = keys.iter().zip(values).map(change).collect();
        let changes = changes?;
        let machine = look(machine, |machine| {
            let name = machine.name();
            let changed = lostmotion::Machine::from_changed_toml(name, &toml(machine)?, &changes);
            Ok(changed?)
        })?;
        room.write(insert(machine)?);
        Ok(())
    })
}

fn toml(machine: &lostmotion::Machine) -> Result<String, Failure> {
    machine
        .to_toml()
        .map_err(|error| Failure::internal(error.to_string()))
}

/// A machine from what a control is configured with or another program knows: LinuxCNC's INI
/// ("linuxcnc"), grbl's settings ("grbl"), a machine of FreeCAD ("freecad"), URDF ("urdf") and others;
/// an unknown `format` is answered with the list. `format` may be null where name or text tell it; what
/// is not described is taken from `preset`, or from the usual machine if that is null; `tip` is the link
/// of the tool in a URDF, or null. `file` becomes the machine's file, in which every value says where it is from; it may be
/// null.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// The texts are null or end with a zero; `machine` and `file` are null or have room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_import(
    name: *const c_char,
    description: *const c_char,
    format: *const c_char,
    preset: *const c_char,
    tip: *const c_char,
    machine: *mut *mut LmMachine,
    file: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(machine, "machine") }?;
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "name") }?;
        // SAFETY: the caller's promise.
        let description = unsafe { text(description, "description") }?;
        // SAFETY: the caller's promise.
        let format = unsafe { maybe_text(format, "format") }?;
        // SAFETY: the caller's promise.
        let preset = unsafe { maybe_text(preset, "preset") }?;
        // SAFETY: the caller's promise.
        let tip = unsafe { maybe_text(tip, "tip") }?;
        let found = match format {
            Some(wanted) => ImportFormat::NAMES
                .iter()
                .find(|(name, _)| *name == wanted)
                .map(|(_, format)| *format),
            None => ImportFormat::recognise(name, description),
        };
        let found = found.ok_or_else(|| {
            let known = ImportFormat::NAMES.map(|(name, _)| name).join(", ");
            let message = format!("{name}: the format is not known");
            Refusal::new(
                RefusalKind::Machine,
                "format",
                message,
                &format!("name it: {known}"),
            )
        })?;
        let options = ImportOptions {
            preset,
            tip,
            ..ImportOptions::default()
        };
        let imported = import(name, description, found, &options)?;
        let made = insert(lostmotion::Machine::from_toml(name, &imported.toml)?)?;
        if !file.is_null() {
            // SAFETY: the caller's promise.
            let room = unsafe { out(file, "file") }?;
            room.write(text_of(&imported.toml)?);
        }
        room.write(made);
        Ok(())
    })
}

/// All that is wrong with the text of a machine file, tuning included; an empty list for one that
/// holds.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `name` and `toml` are null or end with a zero; `found` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_problems(
    name: *const c_char,
    toml: *const c_char,
    found: *mut *mut LmFindings,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(found, "found") }?;
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "name") }?;
        // SAFETY: the caller's promise.
        let toml = unsafe { text(toml, "toml") }?;
        let all = match lostmotion::Machine::check_toml(name, toml) {
            Ok(_) => Vec::new(),
            Err(error) => Refusal::from(error).findings,
        };
        room.write(findings(&all)?);
        Ok(())
    })
}

/// The machine as the text of a machine file.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `text` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_toml(
    machine: *const LmMachine,
    text: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(text, "text") }?;
        room.write(text_of(&look(machine, toml)?)?);
        Ok(())
    })
}

/// The machine as a JSON object with the keys of machine files, which `lm_machine_from_json` takes.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `document` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_json(
    machine: *const LmMachine,
    document: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(document, "document") }?;
        let text = look(machine, |machine| {
            serde_json::to_string(&machine.file())
                .map_err(|error| Failure::internal(error.to_string()))
        })?;
        room.write(text_of(&text)?);
        Ok(())
    })
}

/// What a commissioning engineer would object to, a line each; empty where there is nothing.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `remarks` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_remarks(
    machine: *const LmMachine,
    remarks: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(remarks, "remarks") }?;
        let lines: Vec<String> = look(machine, |machine| {
            let reviews = machine.review();
            Ok(reviews.iter().flat_map(AxisReview::remarks).collect())
        })?;
        room.write(text_of(&lines.join("\n"))?);
        Ok(())
    })
}

/// A number of the machine's file, by its key: "axis.x.load.slide.gap_um".
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `key` is null or ends with a zero; `number` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_machine_number(
    machine: *const LmMachine,
    key: *const c_char,
    number: *mut f64,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(number, "number") }?;
        // SAFETY: the caller's promise.
        let key = unsafe { text(key, "key") }?;
        let file = look(machine, |machine| {
            serde_json::to_value(machine.file())
                .map_err(|error| Failure::internal(error.to_string()))
        })?;
        let found = key
            .split('.')
            .try_fold(&file, |table: &Value, part| table.get(part));
        let found = found.and_then(Value::as_f64).ok_or_else(|| {
            let hint = "keys are those of machine files (`lostmotion machine keys`)";
            Failure::option(format!("the machine has no number \"{key}\""), hint)
        })?;
        room.write(found);
        Ok(())
    })
}

/// Frees a machine; nothing for a null. Simulations and axes of it go on.
///
/// Threads: any, when no other uses it. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_machine_free(machine: *mut LmMachine) -> LmStatus {
    call(|| free(machine))
}

/// A drive of a machine by its name.
pub(crate) fn drive_of(
    machine: &lostmotion::Machine,
    drive: &str,
) -> Result<lostmotion::methods::AxisConfig, Failure> {
    machine.drive(drive).cloned().ok_or_else(|| {
        let hint = format!("its drives: {}", machine.drives().join(", "));
        Failure::option(format!("the machine has no axis \"{drive}\""), &hint)
    })
}

/// Number of a size that does not fit.
pub(crate) fn wrong_size(what: &'static str, given: usize, needed: usize) -> Failure {
    Failure::brief(what, Reason::Size(given, needed))
}
