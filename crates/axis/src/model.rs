//! What an axis shares with its copies, and how its compensator is asked.

use crate::compensation::{Compensator, Correction, Signals};
use crate::plant::Plant;
use crate::reference::Spline;
use crate::runner::Seen;
use crate::servo::Servo;
use crate::signal::Reference;

/// Description of an axis with its compensator.
#[derive(Debug)]
pub(super) struct Model<C> {
    pub(super) spline: Spline,
    pub(super) servo_ticks: u32,
    pub(super) servo: Servo,
    pub(super) plant: Plant,
    pub(super) compensator: C,
    pub(super) units_per_motor_rad: f64,
    pub(super) load_per_motor_rad: f64,
    pub(super) has_scale: bool,
}

impl<C: Compensator> Model<C> {
    /// What a compensator sees.
    #[inline]
    pub(super) fn signals(
        &self,
        [reference, next_reference]: [Reference; 2],
        seen: &Seen,
    ) -> Signals {
        Signals {
            reference,
            next_reference,
            motor_position: seen.motor_position,
            motor_velocity: seen.motor_velocity,
            current: seen.current,
            mean_current: seen.mean_current,
            saturated: seen.saturated,
            load_position: if self.has_scale {
                Some(self.servo.read_scale(seen.load_position))
            } else {
                None
            },
        }
    }

    /// What the compensator answers; without its output if a drive could not act on that.
    #[inline]
    pub(super) fn correct(
        &self,
        state: &mut C::State,
        references: [Reference; 2],
        seen: &Seen,
    ) -> Correction {
        usable(
            self.compensator
                .step(state, &self.signals(references, seen)),
        )
    }
}

pub(super) fn usable(wanted: Correction) -> Correction {
    if wanted.is_usable() {
        wanted
    } else {
        wanted.without_output()
    }
}
