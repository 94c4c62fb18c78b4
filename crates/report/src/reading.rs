//! What can be said of a part program without moving anything, for bindings to other languages: what
//! is found in it, what a line does, how it looks in one style or with everything computed.

use crate::findings::Finding;
use crate::refusal::{Refusal, RefusalKind, findings_of, operations_of};
use lostmotion_gcode::{InterpreterConfig, Severity};
use lostmotion_gcode_tools::explain::{Explanation, explain};
use lostmotion_gcode_tools::format::{
    Case, FormatOptions, LineNumbers, format, refers_to_line_numbers,
};
use lostmotion_gcode_tools::lint::{Level, Levels, rules};
use lostmotion_gcode_tools::writer::write_program;
use lostmotion_sim::Program;
use lostmotion_sim::machine::Machine;
use lostmotion_sim::program::Operations;
use lostmotion_sim::request::ReadingRequest;
use serde::Deserialize;

/// Steps of new line numbers.
const STEPS: std::ops::RangeInclusive<u32> = 1..=10_000;

/// Levels of lints by the name of each and of its level; the later one of a name counts, `all` stands
/// for every lint.
///
/// # Errors
/// A lint or a level that there is not.
pub fn levels_of<'a>(
    given: impl IntoIterator<Item = (&'a str, &'a str)>,
) -> Result<Levels, Refusal> {
    let mut levels = Levels::default();
    for (code, level) in given {
        let level = match level {
            "allow" => Level::Allow,
            "warn" => Level::Warn,
            "deny" => Level::Deny,
            other => {
                let hint = "levels are allow, warn and deny";
                return Err(Refusal::option(format!("\"{other}\" is no level"), hint));
            }
        };
        if rules::find(code).is_none() && code != "all" {
            let hint = "`lostmotion check --help` lists them";
            return Err(Refusal::option(
                format!("there is no lint \"{code}\""),
                hint,
            ));
        }
        levels.set(code, level);
    }
    Ok(levels)
}

/// A style by names.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Style {
    /// `upper`, `lower` or `keep`.
    pub case: String,
    /// Blanks for each level of O-words.
    pub indent: usize,
    /// `keep`, `remove`, or the step of new ones.
    pub line_numbers: String,
}

impl Default for Style {
    fn default() -> Style {
        Style {
            case: "upper".to_owned(),
            indent: 2,
            line_numbers: "keep".to_owned(),
        }
    }
}

impl Style {
    fn options(&self) -> Result<FormatOptions, Refusal> {
        let case = match self.case.as_str() {
            "upper" => Case::Upper,
            "lower" => Case::Lower,
            "keep" => Case::Keep,
            other => {
                let hint = "cases are upper, lower and keep";
                return Err(Refusal::option(format!("\"{other}\" is no case"), hint));
            }
        };
        let line_numbers = match self.line_numbers.as_str() {
            "keep" => LineNumbers::Keep,
            "remove" => LineNumbers::Remove,
            step => match step.parse() {
                Ok(step) if STEPS.contains(&step) => LineNumbers::Renumber { step },
                _ => {
                    let hint = "keep, remove, or a step from 1 to 10000";
                    let text = format!("line_numbers is \"{step}\"");
                    return Err(Refusal::option(text, hint));
                }
            },
        };
        Ok(FormatOptions {
            case,
            indent: self.indent,
            line_numbers,
            ..FormatOptions::default()
        })
    }
}

/// A program in one style.
///
/// # Errors
/// A style that there is not, a program that cannot be read, new line numbers for a program that
/// refers to its own.
pub fn formatted(program: &Program, style: &Style) -> Result<String, Refusal> {
    let options = style.options()?;
    let unread = |error: std::io::Error| Refusal::unread(program, &error);
    let open = || program.open().map_err(unread);
    // GOTO and M99 P jump to N numbers: a new numbering would change what the program does.
    if options.line_numbers != LineNumbers::Keep
        && let Some(line) = refers_to_line_numbers(open()?).map_err(unread)?
    {
        let text = format!("line {line}: the program refers to its line numbers");
        return Err(Refusal::option(text, "use line_numbers=\"keep\""));
    }
    let mut out = Vec::new();
    format(open()?, &options, &mut out).map_err(unread)?;
    Ok(String::from_utf8_lossy(&out).into_owned())
}

/// The interpreter of a program, and how it reads.
///
/// # Errors
/// Settings that do not fit, a program that cannot be read.
pub fn reader_of(
    program: &Program,
    reading: &ReadingRequest,
    machine: Option<&Machine>,
) -> Result<(Operations, InterpreterConfig), Refusal> {
    let (config, loader) = reading.config(machine)?;
    Ok((operations_of(program, config.clone(), loader)?, config))
}

/// What interpreter and, with levels, lints find in a program, in the order of the text.
///
/// # Errors
/// As [`reader_of`].
pub fn found_in(
    program: &Program,
    reading: &ReadingRequest,
    machine: Option<&Machine>,
    levels: Option<Levels>,
) -> Result<Vec<Finding>, Refusal> {
    let (config, loader) = reading.config(machine)?;
    findings_of(program, config, loader, levels)
}

/// What a line of a program does.
///
/// # Errors
/// As [`reader_of`], and a line that there is not.
pub fn explained(
    program: &Program,
    reading: &ReadingRequest,
    machine: Option<&Machine>,
    line: u32,
) -> Result<Explanation, Refusal> {
    let (mut reader, _) = reader_of(program, reading, machine)?;
    explain(&mut reader, line).ok_or_else(|| {
        let text = format!("{} has no line {line}", program.name());
        Refusal::option(text, "lines count from 1")
    })
}

/// A program with everything computed: no parameters, loops, calls, cycles, offsets. `system` is the
/// work coordinate system of the coordinates, 1 for G54 to 9 for G59.3.
///
/// # Errors
/// As [`reader_of`], a program with errors, a system that there is not.
pub fn resolved(
    program: &Program,
    reading: &ReadingRequest,
    machine: Option<&Machine>,
    system: u8,
) -> Result<String, Refusal> {
    let wrong: Vec<Finding> = found_in(program, reading, machine, None)?
        .into_iter()
        .filter(|finding| finding.severity == Severity::Error)
        .collect();
    if let Some(first) = wrong.first() {
        let text = format!("{}:{}: {}", first.file, first.span.line, first.message);
        return Err(Refusal::of_findings(text, wrong, program));
    }
    let (mut reader, config) = reader_of(program, reading, machine)?;
    let mut out = Vec::new();
    write_program(&mut reader, &config, system, &mut out)
        .map_err(|error| Refusal::new(RefusalKind::Program, "write", error.to_string(), ""))?;
    Ok(String::from_utf8_lossy(&out).into_owned())
}
