//! No compensation: the axis as it is, the baseline of every comparison.
//!
//! Law: every correction is zero. Signals: none. Settings: none. Fails: leaves the whole effect of
//! the gap.

use crate::AxisConfig;
use crate::registry::Registered;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};

/// The method `none`.
#[derive(Clone, Copy, Debug)]
pub struct Uncompensated;

impl Registered for Uncompensated {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "none",
        summary: "no compensation",
        knows: Knowledge {
            load_scale: false,
            gap: false,
            load: false,
        },
        source: "baseline",
    };

    fn from_axis(_config: &AxisConfig) -> Uncompensated {
        Uncompensated
    }
}

impl Compensator for Uncompensated {
    type State = ();

    const PASSIVE: bool = true;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) {}

    #[inline]
    fn step(&self, _state: &mut (), _signals: &Signals) -> Correction {
        Correction::NONE
    }
}
