//! The open set of compensators. Adding one is one file beside this and one line in [`METHODS`].

use crate::AxisConfig;
use crate::adaptive::Adaptive;
use crate::adaptive_inverse::AdaptiveInverse;
use crate::disturbance_observer::DisturbanceObserver;
use crate::fitted_lookup::FittedLookup;
use crate::fixed::Fixed;
use crate::fixed_fanuc::FixedFanuc;
use crate::fixed_linuxcnc::FixedLinuxcnc;
use crate::iterative_learning::IterativeLearning;
use crate::kalman::Kalman;
use crate::load_feedback::LoadFeedback;
use crate::lookup::Lookup;
use crate::multiple_models::MultipleModels;
use crate::none::Uncompensated;
use crate::observed::Observed;
use crate::published::Published;
use crate::reversal_pulse::ReversalPulse;
use lostmotion_base::Clock;
use lostmotion_drive::AxisSim;
use lostmotion_drive::config::AxisConfigError;
use lostmotion_drive::error::AxisError;
use lostmotion_drive::runner::AxisRunner;
use lostmotion_drive::{Compensator, MethodInfo};

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
