//! The memory of a machine's axes as a file: read with the place of everything that is wrong, held
//! against the machine, written.
//!
//! ```toml
//! version = 1
//!
//! [axis.x.learned]            # at the motor, SI
//! half_gap_rad = 0.0024
//! half_gap_deviation_rad = 0.00002
//! gap_readings = 8
//! # ...
//!
//! [axis.x.learned_on]         # what must not change
//! rotor_inertia_kgm2 = 0.0021
//! # ...
//! ```

use super::document::{ChangedText, Document};
use super::problem::{MachineError, Problem};
use super::read::{non_finite_numbers, spanned};
use super::{Machine, section};
use lostmotion_base::names::did_you_mean;
use lostmotion_drive::config::AxisConfigError;
use lostmotion_methods::AxisMemory;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the file's form.
const VERSION: u32 = 1;

/// What was learned of the axes of a machine, by the name of each drive: `x`, and `y2` for the
/// second motor of a gantry's Y.
///
/// ```
/// use lostmotion_sim::machine::Memory;
/// use lostmotion_sim::{Machine, Program, Simulation};
///
/// let program = Program::from_str("slot.ngc", "G21 G90\nG1 X30 F2000\nX0\nX30\nX0\nM2\n");
/// let machine = Machine::preset("vmc3-worn")?;
/// let cold = Simulation::new(&program, &machine).method("adaptive").run()?;
/// let memory = cold.results[0].learned.clone();
/// let text = memory.to_toml()?;
/// let memory = Memory::from_toml("vmc3-worn.learned.toml", &text)?;
/// let warm = Simulation::new(&program, &machine)
///     .method("adaptive")
///     .learned(memory)
///     .run()?;
/// assert!(warm.results[0].backlash.rms <= cold.results[0].backlash.rms);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// Version of the form: 1.
    pub version: u32,
    /// The axes.
    #[serde(default)]
    pub axis: BTreeMap<String, AxisMemory>,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            version: VERSION,
            axis: BTreeMap::new(),
        }
    }
}

impl Memory {
    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.axis.is_empty()
    }

    /// Reads a file and checks its values. `name` is the file's name, for messages only.
    ///
    /// # Errors
    /// Everything that is wrong, with its place: syntax, unknown, missing and mistyped keys, another
    /// version, values out of range.
    pub fn from_toml(name: &str, text: &str) -> Result<Memory, MachineError> {
        Memory::read(name, text, |_| Vec::new())
    }

    /// The same for a machine: also refuses axes that it does not have, and what was learned on
    /// other ones.
    ///
    /// # Errors
    /// As [`Memory::from_toml`] and [`Memory::check`], with the place in the file.
    pub fn from_toml_for(
        machine: &Machine,
        name: &str,
        text: &str,
    ) -> Result<Memory, MachineError> {
        Memory::read(name, text, |memory| memory.differences(machine))
    }

    fn read(
        name: &str,
        text: &str,
        faults: impl Fn(&Memory) -> Vec<Fault>,
    ) -> Result<Memory, MachineError> {
        let changed = ChangedText::new(text, &[]);
        let document =
            Document::parse(&changed).map_err(|problems| MachineError::new(name, problems))?;
        let mut problems = non_finite_numbers(&document);
        // Of another version nothing else is told: its keys may all be other ones.
        let version = document.root.get("version").map(toml::Spanned::get_ref);
        let version = version.and_then(|value| value.as_integer());
        let version = version.map(|number| number.as_str().to_owned());
        if let Some(version) = version.filter(|version| *version != VERSION.to_string()) {
            let message = format!("is {version}; this program reads version {VERSION}");
            let hint = "let the axes learn anew: `lostmotion axis commission`";
            return Err(MachineError::new(
                name,
                vec![document.problem("version", message, hint)],
            ));
        }
        let root = spanned(document.root.clone(), 0..0);
        let memory: Option<Memory> = section::read(&document, "", &root, &[], &mut problems);
        if let Some(memory) = &memory {
            let found = memory.out_of_range().into_iter().chain(faults(memory));
            problems
                .extend(found.map(|(key, message, hint)| document.problem(&key, message, hint)));
        }
        match memory {
            Some(memory) if problems.is_empty() => Ok(memory),
            _ => Err(MachineError::new(name, problems)),
        }
    }

    /// Whether it is of a machine: every axis is one of it, and is what it was learned on.
    ///
    /// # Errors
    /// Every axis for which that is not so, with the key that differs.
    pub fn check(&self, machine: &Machine) -> Result<(), MachineError> {
        let faults = self.out_of_range().into_iter();
        let problems: Vec<Problem> = faults
            .chain(self.differences(machine))
            .map(|(key, message, hint)| Problem {
                line: 0,
                column: 0,
                key,
                message,
                hint,
                option: None,
            })
            .collect();
        if problems.is_empty() {
            return Ok(());
        }
        Err(MachineError::new("what was learned", problems))
    }

    /// Values that cannot be.
    fn out_of_range(&self) -> Vec<Fault> {
        let axes = self.axis.iter();
        axes.filter_map(|(name, memory)| {
            let error = memory.learned.check().err()?;
            Some(fault(&error.within(&format!("axis.{name}.learned"))))
        })
        .collect()
    }

    /// Axes that the machine does not have, or that are other ones.
    fn differences(&self, machine: &Machine) -> Vec<Fault> {
        let names = machine.drives();
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let of_axis = |(name, memory): (&String, &AxisMemory)| {
            let Some(config) = machine
                .drive(name)
                .filter(|_| known.contains(&name.as_str()))
            else {
                return Some((
                    format!("axis.{name}"),
                    format!("the machine `{}` has no such axis", machine.name()),
                    did_you_mean(name, &known),
                ));
            };
            // Out of range has been told.
            memory.learned.check().ok()?;
            let error = memory.check(config).err()?;
            Some(fault(&error.within(&format!("axis.{name}"))))
        };
        self.axis.iter().filter_map(of_axis).collect()
    }

    /// As a file.
    ///
    /// # Errors
    /// A number that TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        Ok(format!("{HEAD}{}", toml::to_string_pretty(self)?))
    }
}

/// Says what the file is.
const HEAD: &str = "# What the axes of a machine have learned of themselves: `lostmotion simulate --learned FILE`\n# starts from it. At the motor, SI units; `learned_on` is what must not change of an axis.\n";

/// Key, message, hint.
type Fault = (String, String, String);

/// An error of an axis without the key in its message.
fn fault(error: &AxisConfigError) -> Fault {
    match error {
        AxisConfigError::Mismatch { key, reason, hint } => {
            (key.clone(), reason.clone(), hint.clone())
        }
        AxisConfigError::Range {
            key,
            value,
            allowed,
        } => (
            key.clone(),
            format!(
                "is {}; it has to be {allowed}",
                lostmotion_base::units::number(*value)
            ),
            "let the axis learn anew: `lostmotion axis commission`".to_owned(),
        ),
        other => (String::new(), other.to_string(), String::new()),
    }
}
