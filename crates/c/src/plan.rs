//! Samples of a plan as C reads them.

use crate::run::stats;
use crate::simulation::{LmPlan, LmPlanSample};
use lostmotion::base::{AxisId, AxisSet, Clock, Coords, units};
use lostmotion::plan::Sample;
use lostmotion::sim::results::PlanInfo;

/// A sample in mm and deg, as the command's table has it.
pub(crate) fn row(sample: &Sample, rotary: AxisSet, clock: Clock) -> LmPlanSample {
    let shown = |of: &Coords| {
        AxisId::ALL.map(|axis| {
            if rotary.contains(axis) {
                units::deg(of[axis])
            } else {
                of[axis]
            }
        })
    };
    LmPlanSample {
        time_s: sample.tick.saturating_mul(clock.period_ns()) as f64 / 1e9,
        position: shown(&sample.position),
        velocity: shown(&sample.velocity),
        acceleration: shown(&sample.acceleration),
        line: sample.block.span.line,
    }
}

/// What is known of a plan.
pub(crate) fn told(plan: &PlanInfo) -> LmPlan {
    LmPlan {
        duration_s: plan.duration_s,
        cutting_mm: plan.cutting_mm,
        rapid_mm: plan.rapid_mm,
        command: stats(&plan.command),
    }
}
