//! The limit cycle of the simulated axis, beside the one that is predicted.

use super::cycle::{Cycle, CycleDetector};
use super::model::Feedback;
use crate::axis::AxisSim;
use crate::compensation::load_feedback::LoadFeedback;
use crate::compensation::none::Uncompensated;
use crate::config::{AxisConfig, ReferenceSource};
use crate::runner::{AxisOutput, AxisRunner};
use crate::signal::Setpoint;
use lostmotion_base::Clock;

/// Length of the run, CNC ticks.
const TICKS: u32 = 4000;
/// Length of the push, CNC ticks.
const PUSH: u32 = 40;

/// What an axis that has been checked does after a quick move of one and a half gaps: the limit cycle it is in four seconds later, in its own
/// unit, if it is in one. The position loop is closed on the motor or on the load.
pub fn simulated_cycle(config: &AxisConfig, feedback: Feedback) -> Option<Cycle> {
    let config = AxisConfig { reference: ReferenceSource::SentAlong, ..config.clone() };
    match feedback {
        Feedback::Motor => watch(&config, AxisSim::new(&config, Uncompensated, 0.0)),
        Feedback::Load => watch(&config, AxisSim::new(&config, LoadFeedback, 0.0)),
    }
}

fn watch(config: &AxisConfig, mut axis: impl AxisRunner) -> Option<Cycle> {
    let gap = config.gap_in_unit();
    let mut detector = CycleDetector::new(Clock::SERVO.period_s(), 0.02 * gap);
    let mut out = AxisOutput::new(false);
    for tick in 0..TICKS {
        out.clear();
        axis.push(&[push(1.5 * gap, tick)], &mut out).ok()?;
        for (reference, load) in out.reference.iter().zip(&out.load) {
            detector.push(*reference, *load);
        }
    }
    detector.cycle()
}

/// A quintic from rest to rest.
fn push(distance: f64, tick: u32) -> Setpoint {
    let duration = f64::from(PUSH) * Clock::CNC.period_s();
    let u = f64::from(tick.min(PUSH)) / f64::from(PUSH);
    let v = 1.0 - u;
    Setpoint {
        position: distance * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
        velocity: Some(distance * 30.0 * u * u * v * v / duration),
        acceleration: Some(distance * 60.0 * u * v * (1.0 - 2.0 * u) / (duration * duration)),
        ..Setpoint::default()
    }
}
