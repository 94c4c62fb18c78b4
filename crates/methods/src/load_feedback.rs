//! Position loop closed on the load's own scale: what a better machine would have.
//!
//! ```text
//! feedback = theta_M - theta_L, rad: the velocity loop stays on the motor's encoder, the position loop sees the scale
//! ```
//! Signals: motor position (rad), load position (rad at the motor). Settings: none; the scale's
//! resolution belongs to the load. A machine without a scale gets an ideal one, so that the method
//! can serve as a reference on any machine.
//!
//! Fails: inside the gap the loop has no hold on the load, and the velocity integral winds up. With
//! little load friction it can settle into a limit cycle across the gap (about 8 Hz with the gains
//! of the preset `paper`). The wind-up of the shaft is compensated as well.
//!
//! Source: common practice (linear scales, "full closed loop").

use crate::AxisConfig;
use crate::registry::Registered;
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};

/// The method `load-feedback`.
#[derive(Clone, Copy, Debug)]
pub struct LoadFeedback;

impl Registered for LoadFeedback {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "load-feedback",
        summary: "position loop closed on a scale at the load",
        knows: Knowledge {
            load_scale: true,
            gap: false,
            load: false,
        },
        source: "common practice: linear scale, full closed loop",
    };

    const CLOSES_ON_LOAD: bool = true;

    fn from_axis(_config: &AxisConfig) -> LoadFeedback {
        LoadFeedback
    }
}

impl Compensator for LoadFeedback {
    type State = ();

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) {}

    #[inline]
    fn step(&self, _state: &mut (), signals: &Signals) -> Correction {
        let Some(load) = signals.load_position else {
            return Correction::NONE;
        };
        let gap_angle = signals.motor_position - load;
        // without the half gap the scale only tells the side, not contact
        let engagement = match gap_angle {
            a if a > 0.0 => Engagement::Positive,
            a if a < 0.0 => Engagement::Negative,
            _ => Engagement::Gap,
        };
        Correction {
            feedback: gap_angle,
            gap_angle_estimate: gap_angle,
            engagement_estimate: engagement,
            ..Correction::NONE
        }
    }
}
