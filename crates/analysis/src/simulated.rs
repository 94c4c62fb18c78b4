//! The limit cycle of the simulated axis, beside the one that is predicted.

use super::cycle::{Cycle, CycleDetector};
use super::model::Feedback;
use lostmotion_drive::AxisSim;
use lostmotion_drive::config::Interpolator;
use lostmotion_drive::runner::{AxisOutput, AxisRunner};
use lostmotion_drive::signal::Setpoint;
use lostmotion_methods::AxisConfig;
use lostmotion_methods::load_feedback::LoadFeedback;
use lostmotion_methods::none::Uncompensated;

/// Length of the run, s.
const RUN_S: f64 = 4.0;
/// Length of the push, s.
const PUSH_S: f64 = 0.04;

/// What an axis that has been checked does after a quick move of one and a half gaps: the limit
/// cycle it is in four seconds later, in its own unit, if it is in one. The position loop is closed
/// on the motor or on the load.
pub fn simulated_cycle(config: &AxisConfig, feedback: Feedback) -> Option<Cycle> {
    let config = AxisConfig {
        interpolator: Interpolator::QuinticHermite,
        ..config.clone()
    };
    match feedback {
        Feedback::Motor => watch(&config, AxisSim::new(&config, Uncompensated, 0.0)),
        Feedback::Load => watch(&config, AxisSim::new(&config, LoadFeedback, 0.0)),
    }
}

fn watch(config: &AxisConfig, mut axis: impl AxisRunner) -> Option<Cycle> {
    let gap = config.gap_in_unit();
    let mut detector = CycleDetector::new(config.servo_period_s(), 0.02 * gap);
    let period = config.cycles.command().period_s();
    let mut out = AxisOutput::new(false);
    for tick in 0..(RUN_S / period).round() as u32 {
        out.clear();
        axis.push(&[push(1.5 * gap, tick, period)], &mut out).ok()?;
        for (reference, load) in out.reference.iter().zip(&out.load) {
            detector.push(*reference, *load);
        }
    }
    detector.cycle()
}

/// A quintic from rest to rest.
fn push(distance: f64, tick: u32, period: f64) -> Setpoint {
    let ticks = (PUSH_S / period).round() as u32;
    let duration = f64::from(ticks) * period;
    let u = f64::from(tick.min(ticks)) / f64::from(ticks);
    let v = 1.0 - u;
    Setpoint {
        position: distance * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
        velocity: Some(distance * 30.0 * u * u * v * v / duration),
        acceleration: Some(distance * 60.0 * u * v * (1.0 - 2.0 * u) / (duration * duration)),
        ..Setpoint::default()
    }
}
