//! The open set of compensators: what a registered one declares, and how an axis gets one by name.

use crate::shaft::Observed;
use crate::told::{Misled, Told};
use crate::{AxisConfig, METHODS, NAMES};
use lostmotion_base::names::did_you_mean;
use lostmotion_drive::config::check::AxisConfigError;
use lostmotion_drive::config::{Gap, Interpolator, Transmission};
use lostmotion_drive::{AxisError, AxisRunner, AxisSim, AxisStart, Compensator, MethodInfo};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// Settings of a method: a table `compensation.KEY` of an axis, every field with a default.
pub trait Settings: Default + PartialEq {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range, with its key.
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError>;

    /// The total gaps that it may be told, the one that a fit finds first; none for a method that
    /// knows no gap.
    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        Vec::new()
    }
}

/// A compensator that the registry can build from an axis' description.
pub trait Registered: Compensator + Sized {
    /// Its name, summary, knowledge and source.
    const INFO: &'static MethodInfo;

    /// Whether it has nothing to work with before a fit has told it the gap.
    const NEEDS_FIT: bool = false;

    /// Whether it closes the position loop over the load's scale instead of the motor's encoder.
    const CLOSES_ON_LOAD: bool = false;

    /// Whether it works on this axis, whose description has been checked.
    ///
    /// # Errors
    /// What does not fit, with a hint.
    fn suits(_config: &AxisConfig) -> Result<(), AxisConfigError> {
        Ok(())
    }

    /// With the settings in the description, which has been checked.
    fn from_axis(config: &AxisConfig) -> Self;
}

/// One registered method.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Its name, summary, knowledge and source.
    pub info: &'static MethodInfo,
    /// Name of its file, and of its table of settings if it has any.
    key: &'static str,
    passive: bool,
    needs_fit: bool,
    closes_on_load: bool,
    learns: bool,
    suits: fn(&AxisConfig) -> Result<(), AxisConfigError>,
    /// The axis, what the method is told of it, and how it begins.
    build: fn(&AxisConfig, &AxisConfig, &AxisStart) -> Box<dyn AxisRunner>,
}

impl Method {
    pub(crate) const fn of<C: Registered>(key: &'static str) -> Method {
        Method {
            info: C::INFO,
            key,
            passive: C::PASSIVE,
            needs_fit: C::NEEDS_FIT,
            closes_on_load: C::CLOSES_ON_LOAD,
            learns: C::LEARNS_LOAD,
            suits: C::suits,
            build: |config, told, start| boxed(config, C::from_axis(told), start),
        }
    }
}

/// A registered method: a name that has been parsed. Displayed, parsed, and written to files as the
/// name.
///
/// ```
/// use lostmotion_methods::MethodId;
///
/// let method: MethodId = "load-feedback".parse()?;
/// assert!(method.needs_load_scale() && !method.needs_fit());
/// assert_eq!(method.to_string(), "load-feedback");
/// let error = "fixd".parse::<MethodId>().unwrap_err();
/// assert_eq!(error.to_string(), "there is no method `fixd`; did you mean `fixed`?");
/// # Ok::<(), lostmotion_methods::UnknownMethod>(())
/// ```
#[derive(Clone, Copy)]
pub struct MethodId(&'static Method);

impl MethodId {
    /// The method of a row of [`METHODS`].
    pub(crate) const fn at(index: usize) -> MethodId {
        MethodId(&METHODS[index])
    }

    /// Every registered method, in the order of [`METHODS`].
    pub fn all() -> impl Iterator<Item = MethodId> {
        METHODS.iter().map(MethodId)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.0.info.name
    }

    /// Its name, summary, knowledge and source.
    pub fn info(self) -> &'static MethodInfo {
        self.0.info
    }

    /// Key of its settings in `[axis.x.compensation]`; `None` if it has none.
    pub fn settings_key(self) -> Option<&'static str> {
        crate::SETTINGS.contains(&self.0.key).then_some(self.0.key)
    }

    /// Whether it never corrects anything: what the others are compared with.
    pub fn is_baseline(self) -> bool {
        self.0.passive
    }

    /// Whether it has nothing to work with before a fit has told it the gap.
    pub fn needs_fit(self) -> bool {
        self.0.needs_fit
    }

    /// Whether it closes the position loop over the load's scale instead of the motor's encoder.
    pub fn closes_on_load(self) -> bool {
        self.0.closes_on_load
    }

    /// Whether it learns load and gap, and can start from what it learned
    /// ([`AxisMemory`](crate::AxisMemory)).
    pub fn learns(self) -> bool {
        self.0.learns
    }

    /// Whether it measures the load.
    pub fn needs_load_scale(self) -> bool {
        self.0.info.knows.load_scale
    }

    /// Whether it is told the gap.
    pub fn told_gap(self) -> bool {
        self.0.info.knows.gap
    }

    /// Whether it is told the load's inertia and friction.
    pub fn told_load(self) -> bool {
        self.0.info.knows.load
    }

    /// Whether it is told this quantity. One that learns does so with the stiffness of the
    /// description; what it remembers is told in another way ([`Misled::remembered`]).
    pub fn is_told(self, what: Told) -> bool {
        match what {
            Told::Gap => self.told_gap(),
            Told::Friction => self.told_load(),
            Told::Stiffness => self.told_load() || self.learns(),
        }
    }

    /// The description that it is made from: of a gap that is known to a part only
    /// (`compensation.gap_uncertainty`), the least that it may be.
    fn heeds(self, axis: &AxisConfig) -> Cow<'_, AxisConfig> {
        let uncertainty = axis.compensation.gap_uncertainty;
        if uncertainty == 0.0 || !self.told_gap() {
            return Cow::Borrowed(axis);
        }
        let least = Misled {
            what: Told::Gap,
            factor: 1.0 - uncertainty,
        };
        Cow::Owned(least.of(axis))
    }

    /// Whether it works on this axis, whose description has been checked.
    ///
    /// # Errors
    /// What does not fit, with a hint.
    pub fn suits(self, config: &AxisConfig) -> Result<(), AxisConfigError> {
        (self.0.suits)(config)
    }
}

impl Default for MethodId {
    fn default() -> MethodId {
        MethodId::NONE
    }
}

impl PartialEq for MethodId {
    fn eq(&self, other: &MethodId) -> bool {
        self.name() == other.name()
    }
}

impl Eq for MethodId {}

impl std::hash::Hash for MethodId {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.name().hash(state);
    }
}

impl fmt::Debug for MethodId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for MethodId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no registered method has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no method `{name}`; {hint}")]
pub struct UnknownMethod {
    /// The name asked for.
    pub name: String,
    /// The nearest name, or all of them.
    pub hint: String,
}

impl FromStr for MethodId {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<MethodId, UnknownMethod> {
        METHODS
            .iter()
            .find(|method| method.info.name == name)
            .map(MethodId)
            .ok_or_else(|| UnknownMethod {
                name: name.to_owned(),
                hint: did_you_mean(name, NAMES),
            })
    }
}

impl Serialize for MethodId {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for MethodId {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<MethodId, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse()
            .map_err(|_| de::Error::unknown_variant(&name, NAMES))
    }
}

/// The description of an axis that is stepped by itself: with `differences` positions alone are
/// enough, since the interpolator differentiates for itself.
pub fn alone(mut config: AxisConfig, differences: bool) -> AxisConfig {
    if differences && config.interpolator.needs_velocity() {
        config.interpolator = Interpolator::QuinticDifferences;
    }
    config
}

/// An axis with a registered method, standing still with its motor at `start_position` (mm, deg or
/// rad: the axis' unit).
///
/// # Errors
/// A description that makes no sense or that the method does not suit, a start position that is not
/// a finite number.
pub fn build_runner(
    config: &AxisConfig,
    method: MethodId,
    start_position: f64,
) -> Result<Box<dyn AxisRunner>, AxisError> {
    build_runner_from(config, method, &AxisStart::at(start_position))
}

/// An axis with a registered method that begins as told: moving, wound up, with its drive off.
///
/// ```
/// use lostmotion_methods::{AxisConfig, AxisOutput, AxisStart, MethodId, Setpoint, build_runner_from};
///
/// // Let go, and the shaft wound up by 0.01 rad: what one end wins of momentum the other loses.
/// let start = AxisStart { wind_up: Some(0.01), drive_off: true, ..AxisStart::at(0.0) };
/// let config = AxisConfig::paper().without_gap();
/// let mut axis = build_runner_from(&config, MethodId::NONE, &start)?;
/// let mut out = AxisOutput::new(true);
/// axis.push(&[Setpoint::moving(0.0, 0.0, 0.0)], &mut out)?;
/// let trace = out.trace.unwrap();
/// assert!(trace[0].shaft_torque > 0.0 && trace[1].current == 0.0);
/// assert!(trace[1].motor_velocity < 0.0);
/// # Ok::<(), lostmotion_drive::AxisError>(())
/// ```
///
/// # Errors
/// A description that makes no sense or that the method does not suit, a start that the axis cannot
/// have.
pub fn build_runner_from(
    config: &AxisConfig,
    method: MethodId,
    start: &AxisStart,
) -> Result<Box<dyn AxisRunner>, AxisError> {
    // the description first: methods rely on checked values
    config.check()?;
    method.suits(config)?;
    start.check(config)?;
    Ok((method.0.build)(config, &method.heeds(config), start))
}

/// As [`build_runner`], of a drive that was told another axis than it moves: the method is made
/// from the description `told`, everything else from `config`.
///
/// ```
/// use lostmotion_methods::{AxisConfig, AxisOutput, Misled, MethodId, Setpoint, Told, build_misled};
///
/// let axis = AxisConfig::paper();
/// let told = Misled { what: Told::Gap, factor: 1.3 }.of(&axis);
/// let mut runner = build_misled(&axis, &told, MethodId::LOOKUP, 0.0)?;
/// runner.push(&[Setpoint::moving(0.0, 0.0, 0.0)], &mut AxisOutput::new(false))?;
/// # Ok::<(), lostmotion_drive::AxisError>(())
/// ```
///
/// # Errors
/// As [`build_runner`], of either description.
pub fn build_misled(
    config: &AxisConfig,
    told: &AxisConfig,
    method: MethodId,
    start_position: f64,
) -> Result<Box<dyn AxisRunner>, AxisError> {
    // the descriptions first: methods rely on checked values
    config.check()?;
    told.check()?;
    method.suits(told)?;
    let start = AxisStart::at(start_position);
    start.check(config)?;
    Ok((method.0.build)(config, &method.heeds(told), &start))
}

/// An axis with your own compensator: the counterpart of [`build_runner`] for types
/// that are not registered.
///
/// ```
/// use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
/// use lostmotion_methods::{AxisConfig, AxisOutput, Setpoint, run_with};
///
/// /// Adds a constant to the position reference.
/// struct Offset(f64);
///
/// static INFO: MethodInfo = MethodInfo {
///     name: "offset",
///     summary: "a constant",
///     knows: Knowledge { load_scale: false, gap: false, load: false },
///     source: "an example",
/// };
///
/// impl Compensator for Offset {
///     type State = ();
///     fn info(&self) -> &'static MethodInfo { &INFO }
///     fn initial(&self, _motor_position: f64) {}
///     fn step(&self, _state: &mut (), _signals: &Signals) -> Correction {
///         Correction { position: self.0, ..Correction::NONE }
///     }
/// }
///
/// let mut axis = run_with(&AxisConfig::paper().without_gap(), Offset(0.5), 0.0)?;
/// let mut out = AxisOutput::new(false);
/// axis.push(&[Setpoint::moving(0.0, 0.0, 0.0); 1000], &mut out)?;
/// assert!((out.load[3999] - 0.5).abs() < 1e-6);
/// # Ok::<(), lostmotion_drive::AxisError>(())
/// ```
///
/// # Errors
/// A description that makes no sense, a start position that is not a finite number.
pub fn run_with<C: Compensator>(
    config: &AxisConfig,
    compensator: C,
    start_position: f64,
) -> Result<Box<dyn AxisRunner>, AxisError> {
    config.check()?;
    let start = AxisStart::at(start_position);
    start.check(config)?;
    Ok(boxed(config, compensator, &start))
}

fn boxed<C: Compensator>(
    config: &AxisConfig,
    compensator: C,
    start: &AxisStart,
) -> Box<dyn AxisRunner> {
    // a type of its own, so that axes without the estimator do not pay for it
    if config.compensation.estimate_shaft {
        let observed = Observed::new(compensator, config);
        return Box::new(AxisSim::begin(config, observed, start));
    }
    Box::new(AxisSim::begin(config, compensator, start))
}

/// Checks a gap that a method was told; an error is under `key`.
pub(crate) fn told(
    key: &str,
    gap: Option<Gap>,
    transmission: &Transmission,
) -> Result<(), AxisConfigError> {
    gap.map_or(Ok(()), |gap| {
        gap.check(transmission).map_err(|e| e.within(key))
    })
}

/// The total gap that a method was told, or the machine's true one; rad at the motor.
pub(crate) fn told_or_true_gap(gap: Option<Gap>, config: &AxisConfig) -> f64 {
    gap.map_or(config.reflected_load().gap_rad, |gap| {
        gap.motor_rad(&config.transmission)
    })
}
