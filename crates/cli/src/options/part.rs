//! A part program and how it is read.

use super::machine::MachineOptions;
use super::{Names, number};
use crate::findings::{Form, Voice};
use crate::output::Failure;
use clap::Args;
use lostmotion::gcode::dialect::LENIENCIES;
use lostmotion::gcode::{
    Code, Dialect, InterpreterConfig, Leniencies, Leniency, Limits, MCodeUse, SubroutineLoader,
};
use lostmotion::sim::program::Operations;
use lostmotion::sim::{Machine, Program, SimulateOptions, SubroutineFolders};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How a program is read.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Reading the program")]
pub(crate) struct Reading {
    /// Dialect of the program; the machine's, if left out
    #[arg(long, value_name = "NAME", value_parser = dialects())]
    pub(crate) dialect: Option<String>,
    /// Accept, with a warning, what the dialect does not: the code of that warning; may be repeated
    #[arg(long, value_name = "CODE", value_parser = leniencies(), hide_possible_values = true)]
    pub(crate) accept: Vec<String>,
    /// Refuse what the dialect accepts with a warning: the code of that warning; may be repeated
    #[arg(long, value_name = "CODE", value_parser = leniencies(), hide_possible_values = true)]
    pub(crate) refuse: Vec<String>,
    /// What an M code of the machine's builder does, or several of them (M100-M199=ignore): ignore
    /// it with its words, stop as M0, dwell:SECONDS, call:NUMBER as M98, macro:NUMBER as G65; may be
    /// repeated, the last counts
    #[arg(long, value_name = "CODE=WHAT")]
    pub(crate) m_code: Vec<String>,
    /// Skip the lines that begin with /N, `/` alone being /1; may be repeated
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=9))]
    pub(crate) block_skip: Vec<u8>,
    /// Folder with files of subroutines, besides the part's own; may be repeated
    #[arg(long, value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    pub(crate) subroutines: Vec<PathBuf>,
    /// Limit of the G-code interpreter, for example looped_blocks=1e6; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) limit: Vec<String>,
    /// Form of what is found in the part program, on stderr; JSON and SARIF are written even if
    /// nothing is found
    #[arg(long, value_enum, value_name = "FORM", default_value_t)]
    pub(crate) diagnostics: Form,
}

fn dialects() -> Names {
    Names::new("dialect", Dialect::ALL.map(|dialect| (dialect.name(), "")))
}

fn leniencies() -> Names {
    Names::new("code", LENIENCIES.map(|leniency| (leniency.name(), "")))
}

/// The number of an M code.
fn m_number(text: &str) -> Option<u16> {
    let digits = text.trim().strip_prefix(['M', 'm'])?;
    digits.parse().ok().filter(|number| *number <= 6_000)
}

impl Reading {
    /// How much to say, and in which form.
    pub(crate) fn voice(&self, quiet: bool) -> Voice {
        Voice {
            quiet,
            diagnostics: self.diagnostics,
        }
    }

    /// The dialect asked for.
    fn dialect(&self) -> Result<Option<Dialect>, Failure> {
        let Some(name) = &self.dialect else {
            return Ok(None);
        };
        let found = Dialect::from_name(name).ok_or_else(|| dialects().refusal(name));
        found.map(Some)
    }

    /// What the dialect accepts, with what is accepted and refused besides.
    fn leniencies(&self, dialect: Dialect) -> Result<Leniencies, Failure> {
        let named =
            |name: &String| Leniency::from_name(name).ok_or_else(|| leniencies().refusal(name));
        // The dialect first, then what is accepted and refused besides: --refuse has the last word.
        let mut accepted = dialect.leniencies();
        for name in &self.accept {
            accepted = accepted.with(named(name)?);
        }
        for name in &self.refuse {
            accepted = accepted.without(named(name)?);
        }
        Ok(accepted)
    }

    fn limits(&self, mut limits: Limits) -> Result<Limits, Failure> {
        for limit in &self.limit {
            let (name, value) = limit.split_once('=').ok_or_else(|| {
                Failure::with_hint(
                    format!("--limit {limit} is not of the form NAME=VALUE"),
                    "for example: --limit looped_blocks=1e6",
                )
            })?;
            limits
                .set(name.trim(), value.trim())
                .map_err(|error| Failure::message(error.to_string()))?;
        }
        Ok(limits)
    }

    /// What M codes of the machine's builder do.
    fn m_codes(&self) -> Result<BTreeMap<Code, MCodeUse>, Failure> {
        let mut codes = BTreeMap::new();
        for option in &self.m_code {
            let refused = |why: &str| {
                Failure::with_hint(
                    format!("--m-code {option}: {why}"),
                    "for example: --m-code M100-M199=ignore or --m-code M10=dwell:1.5",
                )
            };
            let (names, what) = option
                .split_once('=')
                .ok_or_else(|| refused("it is not of the form CODE=WHAT"))?;
            let what: MCodeUse = what.parse().map_err(|why: String| refused(&why))?;
            let (first, last) = names.split_once('-').unwrap_or((names, names));
            let (first, last) = m_number(first)
                .zip(m_number(last))
                .filter(|(first, last)| first <= last)
                .ok_or_else(|| refused("it does not name M codes from M0 to M6000"))?;
            codes.extend((first..=last).map(|number| (Code::m(10 * number), what.clone())));
        }
        Ok(codes)
    }

    /// Which block skips are on, if any is named.
    fn block_skips(&self) -> Option<Vec<u8>> {
        (!self.block_skip.is_empty()).then(|| self.block_skip.clone())
    }

    /// Where a part's subroutines come from.
    pub(crate) fn loader(&self, part: &Path) -> Result<Arc<dyn SubroutineLoader>, Failure> {
        let folders = SubroutineFolders::new(part, &self.subroutines)
            .map_err(|error| Failure::message(error.to_string()))?;
        Ok(Arc::new(folders))
    }

    /// An interpreter's settings with what was asked for.
    pub(crate) fn config(&self, config: InterpreterConfig) -> Result<InterpreterConfig, Failure> {
        // Another dialect brings its own leniencies: those of the machine's would not fit it.
        let dialect = self.dialect()?.unwrap_or(config.dialect);
        let limits = self.limits(config.limits.clone())?;
        Ok(InterpreterConfig {
            dialect,
            leniencies: self.leniencies(dialect)?,
            limits,
            m_codes: self.m_codes()?,
            block_skips: self.block_skips(),
            ..config
        })
    }

    /// A run's settings with what was asked for.
    fn options(
        &self,
        part: &Path,
        usual: Dialect,
        options: SimulateOptions,
    ) -> Result<SimulateOptions, Failure> {
        let dialect = self.dialect()?.unwrap_or(usual);
        Ok(SimulateOptions {
            dialect: Some(dialect),
            leniencies: Some(self.leniencies(dialect)?),
            limits: self.limits(options.limits.clone())?,
            loader: Some(self.loader(part)?),
            m_codes: self.m_codes()?,
            block_skips: self.block_skips(),
            ..options
        })
    }
}

/// A part program that is read, on a machine or without one.
#[derive(Clone, Debug, Args)]
pub(crate) struct Setup {
    /// The machine, from which tools, work offsets, the position at the start and the travel are
    /// taken
    #[command(flatten)]
    pub(crate) on: MachineOptions,
    #[command(flatten)]
    pub(crate) reading: Reading,
}

impl Setup {
    /// The machine, if one is named.
    pub(crate) fn machine(&self) -> Result<Option<Machine>, Failure> {
        self.on.named()
    }

    /// Settings of the interpreter with what was asked for: those of the machine, if there is one,
    /// else `alone`.
    pub(crate) fn config(
        &self,
        machine: Option<&Machine>,
        alone: InterpreterConfig,
    ) -> Result<InterpreterConfig, Failure> {
        let mut config = machine.map_or(alone, |machine| {
            lostmotion::sim::interpreter_config(machine, &SimulateOptions::default())
        });
        // The file replaces the machine's table as a whole; offsets and start stay.
        if let Some(tools) = self.on.tools()? {
            config.tool_table = Some(tools);
        }
        config.told = self.on.changes.told()?;
        self.reading.config(config)
    }

    /// Settings of a run on a machine.
    pub(crate) fn options(
        &self,
        part: &Path,
        machine: &Machine,
        options: SimulateOptions,
    ) -> Result<SimulateOptions, Failure> {
        let options = SimulateOptions {
            tool_table: self.on.tools()?,
            told: self.on.changes.told()?,
            ..options
        };
        self.reading.options(part, machine.dialect(), options)
    }
}

/// A part program that is run on a machine.
#[derive(Debug, Args)]
pub(crate) struct OnMachine {
    /// Part program; `-` is stdin
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) part: PathBuf,
    #[command(flatten)]
    pub(crate) setup: Setup,
    /// How far the planned curves may lie from the splines (G5, G5.1, G5.2) that they stand for, in
    /// millimetres
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) spline_tolerance_mm: Option<f64>,
}

impl OnMachine {
    /// The machine asked for, or the default one.
    pub(crate) fn machine(&self) -> Result<Machine, Failure> {
        self.setup.on.load()
    }

    /// A run's settings with what was asked for; the run itself refuses values out of range.
    pub(crate) fn options(
        &self,
        machine: &Machine,
        options: SimulateOptions,
    ) -> Result<SimulateOptions, Failure> {
        let spline_tolerance_mm = self
            .spline_tolerance_mm
            .unwrap_or(options.spline_tolerance_mm);
        let options = self.setup.options(&self.part, machine, options)?;
        Ok(SimulateOptions {
            spline_tolerance_mm,
            ..options
        })
    }
}

/// Opens a program for the interpreter.
pub(crate) fn interpret(
    source: &Program,
    config: InterpreterConfig,
    loader: Option<Arc<dyn SubroutineLoader>>,
) -> Result<Operations, Failure> {
    let program = source
        .operations(config)
        .map_err(|error| Failure::message(format!("cannot read {}: {error}", source.name())))?;
    Ok(match loader {
        Some(loader) => program.with_loader(loader),
        None => program,
    })
}
