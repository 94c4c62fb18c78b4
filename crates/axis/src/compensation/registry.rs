//! The open set of compensators. Adding one is one file beside this and one line in [`METHODS`].

use super::adaptive::Adaptive;
use super::adaptive_inverse::AdaptiveInverse;
use super::disturbance_observer::DisturbanceObserver;
use super::fitted_lookup::FittedLookup;
use super::fixed::Fixed;
use super::fixed_fanuc::FixedFanuc;
use super::fixed_linuxcnc::FixedLinuxcnc;
use super::iterative_learning::IterativeLearning;
use super::kalman::Kalman;
use super::load_feedback::LoadFeedback;
use super::lookup::Lookup;
use super::multiple_models::MultipleModels;
use super::none::Uncompensated;
use super::observed::Observed;
use super::published::Published;
use super::reversal_pulse::ReversalPulse;
use super::{Compensator, MethodInfo};
use crate::axis::AxisSim;
use crate::config::{AxisConfig, AxisConfigError};
use crate::error::AxisError;
use crate::runner::AxisRunner;
use lostmotion_base::Clock;

/// A compensator that the registry can build from an axis' description.
pub trait Registered: Compensator + Sized {
    /// What it says of itself.
    const INFO: &'static MethodInfo;

    /// With the settings in the description, which has been checked.
    fn from_axis(config: &AxisConfig) -> Self;
}

/// One registered method.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// What it says of itself.
    pub info: &'static MethodInfo,
    build: fn(&AxisConfig, f64) -> Box<dyn AxisRunner>,
}

impl Method {
    const fn of<C: Registered>() -> Method {
        Method {
            info: C::INFO,
            build: built::<C>,
        }
    }
}

fn built<C: Registered>(config: &AxisConfig, start: f64) -> Box<dyn AxisRunner> {
    let compensator = C::from_axis(config);
    if config.compensation.estimate_shaft {
        return Box::new(AxisSim::new(
            config,
            Observed::new(compensator, config),
            start,
        ));
    }
    Box::new(AxisSim::new(config, compensator, start))
}

/// Every method there is.
pub static METHODS: &[Method] = &[
    Method::of::<Uncompensated>(),
    Method::of::<Fixed>(),
    Method::of::<Published<false>>(),
    Method::of::<Published<true>>(),
    Method::of::<LoadFeedback>(),
    Method::of::<ReversalPulse>(),
    Method::of::<Lookup>(),
    Method::of::<FixedLinuxcnc>(),
    Method::of::<FixedFanuc>(),
    Method::of::<AdaptiveInverse>(),
    Method::of::<DisturbanceObserver>(),
    Method::of::<Kalman>(),
    Method::of::<MultipleModels>(),
    Method::of::<IterativeLearning>(),
    Method::of::<FittedLookup>(),
    Method::of::<Adaptive>(),
];

/// The method of a name.
///
/// # Errors
/// [`AxisError::UnknownMethod`] with the names there are.
pub fn find_method(name: &str) -> Result<&'static Method, AxisError> {
    METHODS
        .iter()
        .find(|method| method.info.name == name)
        .ok_or_else(|| AxisError::UnknownMethod {
            name: name.to_owned(),
            known: METHODS
                .iter()
                .map(|method| method.info.name)
                .collect::<Vec<_>>()
                .join(", "),
        })
}

/// An axis with a compensator, standing still with its motor at `start_position` (mm, deg or rad:
/// the axis' unit).
///
/// # Errors
/// A description that makes no sense, an unknown method, a start position that is not a finite
/// number.
pub fn build_runner(
    config: &AxisConfig,
    method: &str,
    start_position: f64,
) -> Result<Box<dyn AxisRunner>, AxisError> {
    let method = find_method(method)?;
    config.check()?;
    if method.info.name == Adaptive::INFO.name {
        usual_servo(config)?;
    }
    if !start_position.is_finite() {
        return Err(AxisError::StartPosition {
            value: start_position,
        });
    }
    Ok((method.build)(config, start_position))
}

/// The windows and filters of `adaptive` count in servo ticks of 250 us.
fn usual_servo(config: &AxisConfig) -> Result<(), AxisConfigError> {
    if config.cycles.servo() == Clock::SERVO {
        return Ok(());
    }
    Err(AxisConfigError::Mismatch {
        key: "cycles.servo_us".to_owned(),
        reason: format!(
            "it is {}, and `adaptive` works at 250 only",
            config.cycles.servo_us
        ),
        hint: "leave servo_us out, or take another method".to_owned(),
    })
}
