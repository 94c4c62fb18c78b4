//! Which compensator each axis runs in a simulation: a registered one by its name, the one that the
//! machine file names, or one of the caller's own.

use crate::error::SimError;
use crate::machine::names_of_axes;
use lostmotion_drive::{AxisError, AxisRunner, Compensator};
use lostmotion_methods::{AxisConfig, MethodId, Misled, build_misled, build_runner, run_with};
use std::fmt;
use std::sync::Arc;

/// Makes an axis with a caller's own compensator, standing still at a place (the axis' unit).
type Build = dyn Fn(&AxisConfig, f64) -> Result<Box<dyn AxisRunner>, AxisError> + Send + Sync;

/// A choice of compensator for all axes of a machine.
#[derive(Clone)]
pub(crate) enum Choice {
    /// That which each axis' description names (`compensation.method`).
    OfAxes,
    /// A registered one.
    Registered(MethodId),
    /// A caller's own.
    Own {
        name: String,
        build: Arc<Build>,
        needs_load_scale: bool,
        told_gap: bool,
    },
}

impl fmt::Debug for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Choice::OfAxes => "of the axes",
            Choice::Registered(method) => method.name(),
            Choice::Own { name, .. } => name,
        })
    }
}

impl Choice {
    /// The registered method of a name.
    pub(crate) fn registered(name: &str) -> Result<Choice, SimError> {
        Ok(Choice::Registered(name.parse()?))
    }

    /// A caller's own compensator, made for each axis from its description.
    pub(crate) fn own<C: Compensator>(
        name: String,
        make: impl Fn(&AxisConfig) -> C + Send + Sync + 'static,
        example: &AxisConfig,
    ) -> Choice {
        // Asked of one: a method knows the same on every axis.
        let knows = make(example).info().knows;
        Choice::Own {
            name,
            needs_load_scale: knows.load_scale,
            told_gap: knows.gap,
            build: Arc::new(move |config, start| run_with(config, make(config), start)),
        }
    }

    /// A registered method with its settings changed on each axis.
    pub(crate) fn set(
        name: String,
        method: MethodId,
        change: impl Fn(&mut AxisConfig) + Send + Sync + 'static,
    ) -> Choice {
        Choice::Own {
            name,
            build: Arc::new(move |config, start| {
                let mut config = config.clone();
                change(&mut config);
                build_runner(&config, method, start)
            }),
            needs_load_scale: method.needs_load_scale(),
            told_gap: method.told_gap(),
        }
    }

    /// An axis with the compensator, standing still at a place (the axis' unit).
    pub(crate) fn runner(
        &self,
        config: &AxisConfig,
        start: f64,
    ) -> Result<Box<dyn AxisRunner>, AxisError> {
        match self {
            Choice::OfAxes => build_runner(config, config.compensation.method, start),
            Choice::Registered(method) => build_runner(config, *method, start),
            Choice::Own { build, .. } => build(config, start),
        }
    }

    /// The same, of a drive that is told something wrong; of registered methods alone.
    pub(crate) fn misled(
        &self,
        config: &AxisConfig,
        misled: Misled,
        start: f64,
    ) -> Result<Box<dyn AxisRunner>, AxisError> {
        match self {
            Choice::Registered(method) => build_misled(config, &misled.of(config), *method, start),
            Choice::OfAxes | Choice::Own { .. } => self.runner(config, start),
        }
    }

    /// Name of the method in results. Where the axes name different ones, all of them: `x fixed, y
    /// none`.
    pub(crate) fn name<'a>(&self, axes: impl Iterator<Item = (char, &'a AxisConfig)>) -> String {
        match self {
            Choice::Registered(method) => method.name().to_owned(),
            Choice::Own { name, .. } => name.clone(),
            Choice::OfAxes => names_of_axes(axes),
        }
    }

    /// The registered method of an axis, if it is one.
    pub(crate) fn method(&self, config: &AxisConfig) -> Option<MethodId> {
        match self {
            Choice::OfAxes => Some(config.compensation.method),
            Choice::Registered(method) => Some(*method),
            Choice::Own { .. } => None,
        }
    }

    /// Whether the method of an axis is told the gap.
    pub(crate) fn told_gap(&self, config: &AxisConfig) -> bool {
        match self {
            Choice::OfAxes => config.compensation.method.told_gap(),
            Choice::Registered(method) => method.told_gap(),
            Choice::Own { told_gap, .. } => *told_gap,
        }
    }

    /// Whether a drive has all that the method needs: none measures the load.
    pub(crate) fn needs_load_scale<'a>(
        &self,
        mut axes: impl Iterator<Item = (char, &'a AxisConfig)>,
    ) -> bool {
        match self {
            Choice::Registered(method) => method.needs_load_scale(),
            Choice::Own {
                needs_load_scale, ..
            } => *needs_load_scale,
            Choice::OfAxes => axes.any(|(_, config)| config.compensation.method.needs_load_scale()),
        }
    }
}
