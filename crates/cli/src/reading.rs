//! How a program is read: dialect, leniencies, limits, folders of subroutines.

use crate::args::part::{OnMachine, Reading};
use crate::failure::Failure;
use crate::machines;
use crate::subroutines::Folders;
use lostmotion::gcode::dialect::LENIENCIES;
use lostmotion::gcode::{
    Dialect, InterpreterConfig, Leniencies, Leniency, Limits, SubroutineLoader,
};
use lostmotion::sim::{Machine, SimulateOptions};
use std::path::Path;
use std::sync::Arc;

impl Reading {
    /// The dialect asked for.
    fn dialect(&self) -> Result<Option<Dialect>, Failure> {
        let Some(name) = &self.dialect else {
            return Ok(None);
        };
        let known = || Dialect::ALL.map(Dialect::name).join(", ");
        let found = Dialect::from_name(name);
        found.map(Some).ok_or_else(|| {
            Failure::with_hint(
                format!("there is no dialect \"{name}\""),
                format!("known dialects: {}", known()),
            )
        })
    }

    /// What the dialect accepts, with what is accepted and refused besides.
    fn leniencies(&self, dialect: Dialect) -> Result<Leniencies, Failure> {
        let mut accepted = dialect.leniencies();
        for name in &self.accept {
            accepted = accepted.with(leniency(name)?);
        }
        for name in &self.refuse {
            accepted = accepted.without(leniency(name)?);
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

    /// Where a part's subroutines come from.
    pub(crate) fn loader(&self, part: &Path) -> Result<Arc<dyn SubroutineLoader>, Failure> {
        Ok(Arc::new(Folders::new(part, &self.subroutines)?))
    }

    /// An interpreter's settings with what was asked for.
    pub(crate) fn config(&self, config: InterpreterConfig) -> Result<InterpreterConfig, Failure> {
        let dialect = self.dialect()?.unwrap_or(config.dialect);
        let limits = self.limits(config.limits.clone())?;
        Ok(InterpreterConfig {
            dialect,
            leniencies: self.leniencies(dialect)?,
            limits,
            ..config
        })
    }

    /// A run's settings with what was asked for.
    pub(crate) fn options(
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
            ..options
        })
    }
}

impl OnMachine {
    /// The machine asked for.
    pub(crate) fn machine(&self) -> Result<Machine, Failure> {
        machines::load(self.machine.as_deref())
    }

    /// A run's settings with what was asked for; the run itself refuses what cannot be.
    pub(crate) fn options(
        &self,
        machine: &Machine,
        options: SimulateOptions,
    ) -> Result<SimulateOptions, Failure> {
        let spline_tolerance_mm = self
            .spline_tolerance_mm
            .unwrap_or(options.spline_tolerance_mm);
        let options = self
            .reading
            .options(&self.part, machine.dialect(), options)?;
        Ok(SimulateOptions {
            spline_tolerance_mm,
            ..options
        })
    }
}

fn leniency(name: &str) -> Result<Leniency, Failure> {
    let known = || LENIENCIES.map(Leniency::name).join(", ");
    Leniency::from_name(name).ok_or_else(|| {
        Failure::with_hint(
            format!("\"{name}\" is nothing that can be accepted or refused"),
            format!("known codes: {}", known()),
        )
    })
}
