//! What an INI file and its HAL files set on the pins of the kinematics:
//! `[HAL] HALCMD = setp xyzac-trt-kins.x-rot-point 12.5`, names and meaning as LinuxCNC's chapters
//! on kinematics have them.

use super::draft::{Draft, Fate};
use super::{number, problem};
use crate::machine::Problem;

/// One `setp` on a pin of the module.
struct Pin {
    line: usize,
    name: String,
    value: String,
    used: bool,
}

/// All pins that are set on a module.
pub(super) struct Pins<'a> {
    module: &'a str,
    /// Where the module is named.
    line: usize,
    pins: Vec<Pin>,
}

impl<'a> Pins<'a> {
    pub(super) fn new(module: &'a str, line: usize) -> Pins<'a> {
        Pins {
            module,
            line,
            pins: Vec::new(),
        }
    }

    /// Where the module is named.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// Takes one command of HAL; false if it is about something else. `look_up` puts the value in
    /// the place of `[SECTION]KEY`.
    pub(super) fn take(
        &mut self,
        line: usize,
        command: &str,
        look_up: impl Fn(&str) -> String,
    ) -> bool {
        let command = command
            .split_once('#')
            .map_or(command, |(before, _)| before);
        // Only `setp PIN VALUE`, or `setp PIN = VALUE`; nets and other commands carry no number.
        let mut words = command.split_whitespace().filter(|word| *word != "=");
        let (Some("setp"), Some(pin), Some(value), None) =
            (words.next(), words.next(), words.next(), words.next())
        else {
            return false;
        };
        let Some(name) = pin
            .strip_prefix(self.module)
            .and_then(|rest| rest.strip_prefix('.'))
        else {
            return false;
        };
        self.pins.push(Pin {
            line,
            name: name.to_owned(),
            value: look_up(value),
            used: false,
        });
        true
    }

    /// The value of a pin in `unit`s; `None` if it is not set.
    pub(super) fn told(
        &mut self,
        draft: &mut Draft,
        name: &str,
        unit: f64,
        key: &str,
    ) -> Result<Option<f64>, Problem> {
        let module = self.module;
        // The last command on a pin counts, as in HAL.
        let Some(pin) = self.pins.iter_mut().rev().find(|pin| pin.name == name) else {
            return Ok(None);
        };
        pin.used = true;
        let full = format!("{module}.{name}");
        draft.row(
            format!("[HAL] setp {full}"),
            pin.value.as_str(),
            Fate::Used,
            key,
        );
        Ok(Some(number(pin.line, &full, &pin.value)? * unit))
    }

    /// A length, mm: `missing_mm` where the pin is not set, which is reported with the reason.
    pub(super) fn length(
        &mut self,
        draft: &mut Draft,
        name: &str,
        mm: f64,
        missing_mm: f64,
        key: &str,
        why: &str,
    ) -> Result<f64, Problem> {
        let told = self.told(draft, name, mm, key)?;
        if told.is_none() {
            draft.row(
                key,
                format!("{missing_mm} mm ({}.{name})", self.module),
                Fate::Filled,
                why,
            );
        }
        Ok(told.unwrap_or(missing_mm))
    }

    /// A switch, off if it is not set.
    pub(super) fn bit(
        &mut self,
        draft: &mut Draft,
        name: &str,
        key: &str,
    ) -> Result<bool, Problem> {
        let module = self.module;
        // The last command on a pin counts, as in HAL.
        let Some(pin) = self.pins.iter_mut().rev().find(|pin| pin.name == name) else {
            return Ok(false);
        };
        pin.used = true;
        let full = format!("{module}.{name}");
        draft.row(
            format!("[HAL] setp {full}"),
            pin.value.as_str(),
            Fate::Used,
            key,
        );
        match pin.value.to_ascii_lowercase().as_str() {
            "1" | "true" => Ok(true),
            "0" | "false" => Ok(false),
            _ => Err(problem(
                pin.line,
                &full,
                format!("`{}` is neither 0 nor 1", pin.value),
                "",
            )),
        }
    }

    /// Tells the pins that nothing was made of.
    pub(super) fn rest(self, draft: &mut Draft) {
        for pin in self.pins.iter().filter(|pin| !pin.used) {
            draft.row(
                format!("[HAL] setp {}.{}", self.module, pin.name),
                pin.value.as_str(),
                Fate::Ignored,
                "",
            );
        }
    }
}
