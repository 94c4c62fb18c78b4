//! The fast half of an axis.

use crate::plant::{Plant, PlantInput, PlantState};
use crate::runner::AxisOutput;
use crate::servo::{Servo, ServoState};
use crate::signal::Reference;

/// What runs at the rate of the current loop: the drive's fast half and the plant.
#[derive(Debug)]
pub struct CurrentLoop<'a> {
    pub(crate) servo: &'a Servo,
    pub(crate) plant: &'a Plant,
    pub(crate) servo_state: &'a mut ServoState,
    pub(crate) plant_state: &'a mut PlantState,
    pub(crate) load_torque: f64,
    /// Whether the plant's parameters change from setpoint to setpoint.
    pub(crate) drifting: bool,
    /// Whether the compensator never does anything.
    pub(crate) passive: bool,
    /// References at the servo ticks of the setpoint taken last, and at the next one's first.
    pub(crate) references: &'a [Reference],
    pub(crate) units_per_motor_rad: f64,
}

impl CurrentLoop<'_> {
    /// Periods in a servo tick.
    pub fn periods(&self) -> u32 {
        self.servo.current_steps()
    }

    /// One period; raises the peak of the current, A, to what it reaches.
    #[inline(always)]
    pub fn period(&mut self, peak_current_a: &mut f64) {
        let voltages = self.servo.voltage(self.servo_state, self.plant_state);
        self.plant.step(
            self.plant_state,
            &PlantInput {
                load_torque: self.load_torque,
                ..voltages
            },
        );
        *peak_current_a = peak_current_a.max(self.plant_state.current_q.abs());
    }

    /// The end of a servo tick: counts it if the drive was at a limit.
    #[inline]
    pub fn finish(&self, out: &mut AxisOutput) {
        out.saturated_samples += u64::from(self.servo_state.saturated);
    }
}
