//! What a log tells of an axis: its gap, and what it is as one body.

use crate::border::{call, item, list, maybe_text, out};
use crate::failure::{Failure, LmStatus};
use crate::handle::look;
use crate::machine::{LmMachine, drive_of, wrong_size};
use crate::text::{LmText, text_of};
use lostmotion::drive::config::AxisUnit;
use lostmotion::identify::body::{BodyRows, Identified};
use lostmotion::identify::{AxisRows, LATENESS_S, fit_axis};
use lostmotion::report::json;
use lostmotion::report::refusal::Refusal;
use std::ffi::c_char;

/// A log of an axis: columns of equal length, positions in its unit at the load.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmLog {
    /// Unit of the positions: "mm", "deg" or "rad".
    pub unit: *const c_char,
    /// Rows.
    pub count: usize,
    /// Times, s, all the same step apart.
    pub time_s: *const f64,
    /// Motor.
    pub motor: *const f64,
    /// Load; null to do without it.
    pub load: *const f64,
    /// Torque-forming current, A.
    pub current_a: *const f64,
}

/// What a log tells of the gap, in the unit of the log.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmFit {
    /// Total gap at the load.
    pub gap: f64,
    /// Lower end of its interval of 95 %.
    pub gap_low: f64,
    /// Upper end.
    pub gap_high: f64,
    /// Whether the log tells the gap from zero.
    pub excited: bool,
}

/// A log of an axis and of what drives it: columns of equal length, positions in its unit at the load.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmBodyLog {
    /// Unit of the positions: "mm", "deg" or "rad".
    pub unit: *const c_char,
    /// Rows.
    pub count: usize,
    /// Times, s.
    pub time_s: *const f64,
    /// Motor.
    pub motor: *const f64,
    /// Load; null where it was not logged.
    pub load: *const f64,
    /// Commanded position; null where it was not logged.
    pub command: *const f64,
    /// What drives the axis, force, torque, current or voltage in any unit; null where it was not
    /// logged.
    pub drive: *const f64,
}

fn unit_of(symbol: &str) -> Result<AxisUnit, Failure> {
    let units = [AxisUnit::Mm, AxisUnit::Deg, AxisUnit::Rad];
    let found = units.into_iter().find(|unit| unit.symbol() == symbol);
    found.ok_or_else(|| {
        let hint = "units of positions are mm, deg and rad; convert others before";
        Refusal::data(format!("\"{symbol}\" is no unit of an axis"), hint).into()
    })
}

/// Finds the gap in a log. With `machine` and `drive` motor data are known and the interval is
/// narrower; `machine` may be null. `document` becomes all that was found, as the command writes it;
/// it may be null.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `log` is null or a log whose columns are null or have `count` numbers; `drive` is null or ends with
/// a zero; `fit` and `document` are null or have room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_fit(
    log: *const LmLog,
    machine: *const LmMachine,
    drive: *const c_char,
    fit: *mut LmFit,
    document: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(fit, "fit") }?;
        // SAFETY: the caller's promise.
        let log = unsafe { item(log, "log") }?;
        // SAFETY: the caller's promise.
        let unit = unsafe { maybe_text(log.unit, "log.unit") }?.unwrap_or_default();
        // SAFETY: the caller's promise.
        let drive = unsafe { maybe_text(drive, "drive") }?.unwrap_or_default();
        if log.count == 0 {
            return Err(wrong_size("log.count", 0, 2));
        }
        // SAFETY: the caller's promise.
        let time_s = unsafe { list(log.time_s, log.count, "log.time_s") }?;
        // SAFETY: the caller's promise.
        let motor = unsafe { list(log.motor, log.count, "log.motor") }?;
        // SAFETY: the caller's promise.
        let current_a = unsafe { list(log.current_a, log.count, "log.current_a") }?;
        let load = if log.load.is_null() {
            None
        } else {
            // SAFETY: the caller's promise.
            Some(unsafe { list(log.load, log.count, "log.load") }?)
        };
        let columns = [
            ("time_s", Some(time_s)),
            ("motor", Some(motor)),
            ("load", load),
            ("current_a", Some(current_a)),
        ];
        for (name, column) in columns {
            finite(name, column.unwrap_or_default())?;
        }
        let config = if machine.is_null() {
            None
        } else {
            Some(look(machine, |machine| drive_of(machine, drive))?)
        };
        let rows = AxisRows {
            name: "columns",
            unit: unit_of(unit)?,
            time_s,
            motor,
            load,
            current_a,
            lateness_s: LATENESS_S,
        };
        let found = fit_axis(&rows, config.as_ref())
            .map_err(|error| Refusal::data(error.to_string(), ""))?;
        if !document.is_null() {
            // SAFETY: the caller's promise.
            let room = unsafe { out(document, "document") }?;
            let mut text = Vec::new();
            json::write_significant(&mut text, &found)
                .map_err(|error| Failure::internal(error.to_string()))?;
            room.write(text_of(&String::from_utf8_lossy(&text))?);
        }
        let [gap_low, gap_high] = found.gap_interval;
        room.write(LmFit {
            gap: found.gap,
            gap_low,
            gap_high,
            excited: found.excited,
        });
        Ok(())
    })
}

/// Refuses numbers that are none.
fn finite(name: &str, column: &[f64]) -> Result<(), Failure> {
    match column.iter().position(|value| !value.is_finite()) {
        Some(row) => {
            let hint = "leave such rows out, or fill them from their neighbours";
            Err(Refusal::data(format!("{name} is not finite in row {row}"), hint).into())
        }
        None => Ok(()),
    }
}

/// Finds what a log tells of an axis as one body: inertia, friction, gains of the servo, how position
/// is lost after a reversal. `document` becomes a JSON object of what was found, in m or rad and the
/// log's unit of what drives the axis; `untold` in it says what is not told, and why.
///
/// Threads: any. Real time: no.
///
/// # Safety
/// `log` is null or a log whose columns are null or have `count` numbers; `document` is null or has
/// room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_identify(
    log: *const LmBodyLog,
    document: *mut *mut LmText,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(document, "document") }?;
        // SAFETY: the caller's promise.
        let log = unsafe { item(log, "log") }?;
        // SAFETY: the caller's promise.
        let unit = unsafe { maybe_text(log.unit, "log.unit") }?.unwrap_or_default();
        if log.count == 0 {
            return Err(wrong_size("log.count", 0, 3));
        }
        let column =
            |name: &'static str, numbers: *const f64, needed: bool| -> Result<&[f64], Failure> {
                if numbers.is_null() && !needed {
                    return Ok(&[][..]);
                }
                // SAFETY: the caller's promise.
                let numbers = unsafe { list(numbers, log.count, name) }?;
                finite(name, numbers)?;
                Ok(numbers)
            };
        let rows = BodyRows {
            unit: unit_of(unit)?,
            time_s: column("log.time_s", log.time_s, true)?,
            motor: column("log.motor", log.motor, true)?,
            load: column("log.load", log.load, false)?,
            command: column("log.command", log.command, false)?,
            drive: column("log.drive", log.drive, false)?,
            lateness_s: LATENESS_S,
        };
        let found = Identified::of(&rows).map_err(|error| Refusal::data(error.to_string(), ""))?;
        let text =
            serde_json::to_string(&found).map_err(|error| Failure::internal(error.to_string()))?;
        room.write(text_of(&text)?);
        Ok(())
    })
}
