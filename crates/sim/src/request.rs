//! How a program is read and run, as data: what bindings to other languages take, by the names of the
//! command's options.
//!
//! Values are checked when they are used, so that a message names the value and what may be given.

use crate::control::Control;
use crate::machine::{Machine, MachineError, Memory};
use crate::motion::interpreter_config;
use crate::options::{Intervention, SimulateOptions};
use crate::subroutines::SubroutineFolders;
use lostmotion_base::names::did_you_mean;
use lostmotion_gcode::dialect::LENIENCIES;
use lostmotion_gcode::{
    Code, Dialect, InterpreterConfig, Leniencies, Leniency, Limits, MCodeUse, SubroutineLoader,
    ToolTable,
};
use lostmotion_plan::{Action, Quality};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// A value of a request that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
    /// A value that means nothing.
    #[error("{message}")]
    Value {
        /// What is wrong, with the value.
        message: String,
        /// What may be given.
        hint: String,
    },
    /// What was learned does not hold.
    #[error(transparent)]
    Machine(#[from] MachineError),
}

impl RequestError {
    fn new(message: impl Into<String>, hint: &str) -> RequestError {
        RequestError::Value {
            message: message.into(),
            hint: hint.to_owned(),
        }
    }
}

/// How a program is read.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadingRequest {
    dialect: Option<String>,
    accept: Vec<String>,
    refuse: Vec<String>,
    m_codes: BTreeMap<String, String>,
    block_skips: Option<Vec<u8>>,
    told: BTreeMap<String, f64>,
    subroutines: Vec<PathBuf>,
    limits: BTreeMap<String, f64>,
    tool_table: Option<String>,
    /// Where the program stands, if it is a file: its subroutines are looked for beside it.
    #[serde(skip)]
    pub part: PathBuf,
}

/// How it is run.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RunRequest {
    tolerance_um: Option<f64>,
    cutting_force_n: Option<f64>,
    bow_limit_um: Option<f64>,
    sensitivity: Option<f64>,
    control: Option<String>,
    quality: Option<Quality>,
    interventions: Vec<(f64, String, Option<f64>)>,
    learned: Option<String>,
    max_duration_s: Option<f64>,
    keep_blocks: Option<usize>,
    keep_reversals: Option<usize>,
    spline_tolerance_mm: Option<f64>,
    threads: usize,
}

/// One of a list of names, or the nearest to it.
fn unknown<'a>(what: &str, name: &str, known: impl IntoIterator<Item = &'a str>) -> RequestError {
    let known: Vec<&str> = known.into_iter().collect();
    let all = format!("known: {}", known.join(", "));
    let nearest = did_you_mean(name, &known);
    let hint = if nearest.starts_with("did") {
        format!("{nearest} {all}")
    } else {
        all
    };
    RequestError::new(format!("there is no {what} \"{name}\""), &hint)
}

impl ReadingRequest {
    fn dialect(&self, usual: Dialect) -> Result<Dialect, RequestError> {
        let Some(name) = &self.dialect else {
            return Ok(usual);
        };
        Dialect::from_name(name)
            .ok_or_else(|| unknown("dialect", name, Dialect::ALL.map(Dialect::name)))
    }

    /// What the dialect accepts, with what is accepted and refused besides.
    fn leniencies(&self, dialect: Dialect) -> Result<Leniencies, RequestError> {
        let named = |name: &String| {
            Leniency::from_name(name)
                .ok_or_else(|| unknown("leniency", name, LENIENCIES.map(Leniency::name)))
        };
        let mut accepted = dialect.leniencies();
        for name in &self.accept {
            accepted = accepted.with(named(name)?);
        }
        for name in &self.refuse {
            accepted = accepted.without(named(name)?);
        }
        Ok(accepted)
    }

    fn limits(&self) -> Result<Limits, RequestError> {
        let mut limits = Limits::default();
        for (name, value) in &self.limits {
            limits
                .set(name, &format!("{value:?}"))
                .map_err(|error| RequestError::new(error.to_string(), ""))?;
        }
        Ok(limits)
    }

    fn m_codes(&self) -> Result<BTreeMap<Code, MCodeUse>, RequestError> {
        let code = |(name, what): (&String, &String)| {
            let number = name
                .strip_prefix(['M', 'm'])
                .and_then(|digits| digits.parse::<u16>().ok())
                .filter(|number| *number <= 6_000);
            let hint = "for example {\"M100\": \"ignore\", \"M10\": \"dwell:1.5\"}";
            let number = number.ok_or_else(|| {
                RequestError::new(format!("\"{name}\" is no M code from M0 to M6000"), hint)
            })?;
            let what: MCodeUse = what
                .parse()
                .map_err(|why: String| RequestError::new(format!("{name}: {why}"), hint))?;
            Ok((Code::m(10 * number), what))
        };
        self.m_codes.iter().map(code).collect()
    }

    fn tool_table(&self) -> Result<Option<ToolTable>, RequestError> {
        let parsed = |text: &String| {
            ToolTable::parse(text)
                .map_err(|problem| RequestError::new(format!("tool table: {problem}"), ""))
        };
        self.tool_table.as_ref().map(parsed).transpose()
    }

    fn loader(&self) -> Result<Arc<dyn SubroutineLoader>, RequestError> {
        let folders = SubroutineFolders::new(&self.part, &self.subroutines)
            .map_err(|error| RequestError::new(error.to_string(), ""))?;
        Ok(Arc::new(folders))
    }

    /// Settings of the interpreter, with those of a machine where there is one.
    pub fn config(
        &self,
        machine: Option<&Machine>,
    ) -> Result<(InterpreterConfig, Arc<dyn SubroutineLoader>), RequestError> {
        let config = machine.map_or_else(InterpreterConfig::default, |machine| {
            interpreter_config(machine, &SimulateOptions::default())
        });
        let dialect = self.dialect(config.dialect)?;
        let config = InterpreterConfig {
            dialect,
            leniencies: self.leniencies(dialect)?,
            limits: self.limits()?,
            m_codes: self.m_codes()?,
            block_skips: self.block_skips.clone(),
            told: self.told.clone().into_iter().collect(),
            // In place of the machine's as a whole.
            tool_table: self.tool_table()?.or(config.tool_table),
            ..config
        };
        Ok((config, self.loader()?))
    }

    /// A run's settings.
    pub fn options(
        &self,
        machine: &Machine,
        options: SimulateOptions,
    ) -> Result<SimulateOptions, RequestError> {
        let dialect = self.dialect(machine.dialect())?;
        Ok(SimulateOptions {
            dialect: Some(dialect),
            leniencies: Some(self.leniencies(dialect)?),
            limits: self.limits()?,
            loader: Some(self.loader()?),
            m_codes: self.m_codes()?,
            block_skips: self.block_skips.clone(),
            told: self.told.clone().into_iter().collect(),
            tool_table: self.tool_table()?,
            ..options
        })
    }
}

impl RunRequest {
    /// A run's settings.
    pub fn options(&self) -> Result<SimulateOptions, RequestError> {
        let usual = SimulateOptions::default();
        let control = |name: &String| {
            name.parse::<Control>()
                .map_err(|error| RequestError::new(error.to_string(), ""))
        };
        let memory = |text: &String| Memory::from_toml("learned", text).map_err(RequestError::from);
        let learned = self.learned.as_ref().map(memory).transpose()?;
        let mut interventions = self
            .interventions
            .iter()
            .map(|(at_s, action, part)| intervention(*at_s, action, *part))
            .collect::<Result<Vec<_>, _>>()?;
        interventions.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        Ok(SimulateOptions {
            tolerance_um: self.tolerance_um,
            cutting_force_n: self.cutting_force_n,
            bow_limit_um: self.bow_limit_um,
            misled_share: self.sensitivity.map(|percent| percent / 100.0),
            control: self.control.as_ref().map(control).transpose()?,
            quality: self.quality.unwrap_or_default(),
            interventions,
            learned: learned.map(Arc::new),
            max_duration_s: self.max_duration_s.unwrap_or(usual.max_duration_s),
            keep_blocks: self.keep_blocks.unwrap_or(usual.keep_blocks),
            keep_reversals: self.keep_reversals.unwrap_or(usual.keep_reversals),
            spline_tolerance_mm: self
                .spline_tolerance_mm
                .unwrap_or(usual.spline_tolerance_mm),
            threads: self.threads,
            ..usual
        })
    }
}

/// What an operator does at a time; the part is of the feed or of the rapid.
fn intervention(at_s: f64, action: &str, part: Option<f64>) -> Result<Intervention, RequestError> {
    let action = match (action, part) {
        ("hold", None) => Action::Hold,
        ("resume", None) => Action::Resume,
        ("stop", None) => Action::Stop,
        ("override", Some(part)) => Action::Override(part),
        ("rapid", Some(part)) => Action::Rapid(part),
        _ => {
            let hint = "an action is (at_s, \"hold\"), (at_s, \"resume\"), (at_s, \"stop\"), (at_s, \"override\", part) or (at_s, \"rapid\", part)";
            return Err(RequestError::new(
                format!("\"{action}\" at {at_s} s is no action"),
                hint,
            ));
        }
    };
    Ok(Intervention { at_s, action })
}
