//! What an INI file and its HAL files tell: `[HAL] HALCMD = setp xyzac-trt-kins.x-rot-point 12.5`
//! sets a pin of the kinematics, `setp ini.0.backlash 0.02` what [JOINT_0] BACKLASH says,
//! `loadrt stepgen step_type=0,0` makes step generators, `setp stepgen.0.position-scale 400` their
//! steps, and `net x-pos joint.0.motor-pos-cmd => stepgen.0.position-cmd` says whose they are. Names
//! and meaning as LinuxCNC's chapters on kinematics, stepgen and the INI's pins
//! have them.

use super::draft::{Draft, Fate};
use super::ini::{Entry, Ini};
use super::{ImportOptions, number, problem};
use crate::machine::Problem;
use std::collections::{BTreeMap, BTreeSet};

/// How deep files of HAL may `source` each other.
const MOST_DEEP: usize = 8;

/// A command of HAL.
struct Command {
    /// Line of the INI file that holds it or names its file.
    line: usize,
    /// Whether the INI file itself holds it.
    is_own: bool,
    words: Vec<String>,
}

impl Command {
    /// Pin and value of `setp PIN VALUE`, or `setp PIN = VALUE`; nets and other commands carry no
    /// number.
    fn set(&self) -> Option<(&str, &str)> {
        match self.words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            ["setp", pin, value] | ["setp", pin, "=", value] => Some((pin, value)),
            _ => None,
        }
    }
}

/// Commands of HAL, in the order in which LinuxCNC runs them.
pub(super) struct Hal {
    commands: Vec<Command>,
    /// For each joint whose command is wired: the step generator that it reaches, if it reaches one.
    wired: BTreeMap<usize, Option<usize>>,
}

impl Hal {
    /// Reads the lines of files and commands, those for after the start of the screen last; reports
    /// every file, read or not.
    pub(super) fn read(ini: &Ini, draft: &mut Draft, options: &ImportOptions<'_>) -> Hal {
        let mut reader = HalReader {
            commands: Vec::new(),
            left: *options,
        };
        for (files, commands) in [("HALFILE", "HALCMD"), ("POSTGUI_HALFILE", "POSTGUI_HALCMD")] {
            let of = |key: &'static str| {
                let entries = ini.entries.iter();
                entries.filter(move |entry| entry.section == "HAL" && entry.key == key)
            };
            // All files before all commands, wherever they stand.
            for entry in of(files) {
                reader.file(entry, draft, 0);
            }
            for entry in of(commands) {
                let own = command(&entry.value, entry.line, true);
                reader.commands.extend(own);
            }
        }
        Hal {
            wired: wired(&reader.commands),
            commands: reader.commands,
        }
    }

    /// What is set, the last command on a pin last: line, pin and value as it stands.
    fn set(&self) -> impl DoubleEndedIterator<Item = (usize, &str, &str)> {
        let commands = self.commands.iter();
        commands.filter_map(|it| it.set().map(|(pin, value)| (it.line, pin, value)))
    }

    /// Whether a HALCMD of a line sets something that is read.
    pub(super) fn takes(&self, entry: &Entry, module: &str) -> bool {
        let mut own = self.commands.iter().filter(|command| command.is_own);
        own.any(|command| {
            command.line == entry.line
                && command.set().is_some_and(|(pin, _)| {
                    pin.strip_prefix(module)
                        .is_some_and(|rest| rest.starts_with('.'))
                        || pin_of_ini(pin).is_some()
                        || scaled(pin).is_some()
                })
        })
    }

    /// Values that HAL sets in the place of those of joints and axes.
    pub(super) fn replaced(&self, ini: &Ini) -> Vec<Entry> {
        let all = self.set().filter_map(|(line, pin, value)| {
            let (section, key) = pin_of_ini(pin)?;
            Some(Entry {
                line,
                section,
                key,
                value: ini.value(value),
                pin: Some(pin.to_owned()),
            })
        });
        all.collect()
    }

    /// Whether anything is about step generators.
    pub(super) fn has_generators(&self) -> bool {
        let mut words = self.commands.iter().flat_map(|command| &command.words);
        words.any(|word| word.contains("stepgen"))
    }

    /// The step generator of a joint: the one that its command is wired to, or where that is not
    /// told the one of its number, if there is one and no other joint has it.
    pub(super) fn generator(&self, joint: usize) -> Option<usize> {
        if let Some(Some(number)) = self.wired.get(&joint) {
            return Some(*number);
        }
        let is_anothers = self.wired.values().any(|number| *number == Some(joint));
        (!is_anothers && self.has_generator(joint)).then_some(joint)
    }

    /// Whether a joint's command is wired to something else than a step generator, where others'
    /// lead to one.
    pub(super) fn is_no_stepper(&self, joint: usize) -> bool {
        self.wired.get(&joint) == Some(&None) && self.wired.values().any(Option::is_some)
    }

    /// Whether there is a step generator of this number: one of those that are loaded, or one whose
    /// pins are used.
    fn has_generator(&self, number: usize) -> bool {
        self.commands.iter().any(|command| {
            let mut words = command.words.iter().map(String::as_str);
            if words.next() == Some("loadrt") && words.next() == Some("stepgen") {
                // A type for each: `step_type=0,0,0`.
                let types = words.find_map(|word| word.strip_prefix("step_type="));
                types.is_some_and(|types| number < types.split(',').count())
            } else {
                command
                    .words
                    .iter()
                    .any(|word| generator(word).is_some_and(|(own, _)| own == number))
            }
        })
    }

    /// Line, pin and value of the steps that a joint's generator makes for a unit of the machine.
    pub(super) fn steps(&self, joint: usize) -> Option<(usize, &str, &str)> {
        let number = self.generator(joint)?;
        self.set().rfind(|(_, pin, _)| scaled(pin) == Some(number))
    }
}

/// Files of HAL as they are read.
struct HalReader<'a> {
    commands: Vec<Command>,
    /// What may still be read.
    left: ImportOptions<'a>,
}

impl HalReader<'_> {
    /// Reads a file, and in their places those that it sources.
    fn file(&mut self, entry: &Entry, draft: &mut Draft, deep: usize) {
        if deep > MOST_DEEP {
            let note = format!("not read: files that source each other, {MOST_DEEP} deep");
            draft.row(entry.name(), entry.value.as_str(), Fate::Ignored, note);
            return;
        }
        // Files of the system's library, and missing ones, are told as not read.
        let Some(text) = entry.text(draft, &self.left) else {
            return;
        };
        // All of them are kept: together they have no more bytes than one may have.
        self.left.max_bytes -= text.len();
        let note = "read for step generators, their joints, limits and pins of kinematics";
        draft.row(entry.name(), entry.value.as_str(), Fate::Used, note);
        for line in text.lines() {
            let Some(command) = command(line, entry.line, false) else {
                continue;
            };
            if let [word, file] = &command.words[..]
                && word == "source"
            {
                let inner = Entry {
                    line: entry.line,
                    section: "HAL".to_owned(),
                    key: "source".to_owned(),
                    value: file.clone(),
                    pin: None,
                };
                self.file(&inner, draft, deep + 1);
            } else {
                self.commands.push(command);
            }
        }
    }
}

/// For each joint whose command is wired, the step generator at the other end: through signals and
/// through components with one output, as `pid` has it between them.
fn wired(commands: &[Command]) -> BTreeMap<usize, Option<usize>> {
    let (mut pins, mut signals) = (BTreeMap::<&str, Vec<&str>>::new(), BTreeMap::new());
    for command in commands {
        let words: Vec<&str> = command.words.iter().map(String::as_str).collect();
        let (signal, joined) = match &words[..] {
            ["net", signal, joined @ ..] => (*signal, joined),
            ["linksp", signal, .., pin] => (*signal, std::slice::from_ref(pin)),
            ["linkps", pin, .., signal] => (*signal, std::slice::from_ref(pin)),
            _ => continue,
        };
        for pin in joined.iter().filter(|pin| !pin.contains(['<', '>'])) {
            pins.entry(signal).or_default().push(pin);
            signals
                .entry(*pin)
                .or_insert_with(BTreeSet::new)
                .insert(signal);
        }
    }
    let of = |pin: &str| signals.get(pin).into_iter().flatten().copied();
    let starts = signals.keys().filter_map(|pin| {
        let place = ["joint.", "axis."]
            .iter()
            .find_map(|kind| pin.strip_prefix(kind))?;
        let joint = place
            .strip_suffix(".motor-pos-cmd")?
            .parse::<usize>()
            .ok()?;
        Some((joint, *pin))
    });
    starts
        .map(|(joint, pin)| {
            let mut ahead: Vec<&str> = of(pin).collect();
            let mut seen: BTreeSet<&str> = ahead.iter().copied().collect();
            while let Some(signal) = ahead.pop() {
                for pin in pins.get(signal).into_iter().flatten() {
                    if let Some((number, "position-cmd" | "velocity-cmd")) = generator(pin) {
                        return (joint, Some(number));
                    }
                    let Some((component, _)) = pin.rsplit_once('.') else {
                        continue;
                    };
                    for out in ["output", "out"] {
                        for next in of(&format!("{component}.{out}")) {
                            if seen.insert(next) {
                                ahead.push(next);
                            }
                        }
                    }
                }
            }
            (joint, None)
        })
        .collect()
}

/// A line without its comment; `None` if nothing is left.
fn command(text: &str, line: usize, is_own: bool) -> Option<Command> {
    let told = text.split('#').next().unwrap_or_default();
    let words: Vec<String> = told.split_whitespace().map(str::to_owned).collect();
    (!words.is_empty()).then_some(Command {
        line,
        is_own,
        words,
    })
}

/// Section and key for which a pin `ini.0.backlash` or `ini.x.max_velocity` stands.
fn pin_of_ini(pin: &str) -> Option<(String, String)> {
    let (place, key) = pin.strip_prefix("ini.")?.split_once('.')?;
    let kind = if place.parse::<usize>().is_ok() {
        "JOINT"
    } else {
        "AXIS"
    };
    let section = format!("{kind}_{}", place.to_ascii_uppercase());
    Some((section, key.to_ascii_uppercase()))
}

/// Number and pin of a step generator: `stepgen.0.enable`, `hm2_7i76e.0.stepgen.00.enable`.
fn generator(pin: &str) -> Option<(usize, &str)> {
    let (before, behind) = pin.split_once("stepgen.")?;
    let (number, pin) = behind.split_once('.')?;
    let number = number.parse::<usize>().ok()?;
    (before.is_empty() || before.ends_with('.')).then_some((number, pin))
}

/// The generator whose steps a pin tells.
fn scaled(pin: &str) -> Option<usize> {
    generator(pin).and_then(|(number, pin)| (pin == "position-scale").then_some(number))
}

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
    /// Those that HAL sets on a module.
    pub(super) fn new(module: &'a str, line: usize, hal: &Hal, ini: &Ini) -> Pins<'a> {
        let of_module = hal.set().filter_map(|(line, pin, value)| {
            let name = pin.strip_prefix(module)?.strip_prefix('.')?;
            Some(Pin {
                line,
                name: name.to_owned(),
                value: ini.value(value),
                used: false,
            })
        });
        Pins {
            module,
            line,
            pins: of_module.collect(),
        }
    }

    /// Where the module is named.
    pub(super) fn line(&self) -> usize {
        self.line
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
