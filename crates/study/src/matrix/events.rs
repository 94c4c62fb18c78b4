//! Reversals of an axis and changes of flank of its load, from the plan alone.

use super::limit::Physics;
use lostmotion_base::Clock;

/// Speed up to which an axis stands still, rad/s at the motor: above rounding. A choice.
const STILL_RAD_S: f64 = 1e-6;
/// Torque below which a need has no sign, N m: above rounding. A choice.
const NO_TORQUE_NM: f64 = 1e-6;

/// One axis' watch over its commands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Watch {
    direction: f64,
    need: f64,
    acceleration: f64,
}

/// What happened at a CNC tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Event {
    /// The velocity changed its sign.
    pub(super) reversal: bool,
    /// The flank changed; the least error that this can leave, rad.
    pub(super) flank_rad: Option<f64>,
}

impl Watch {
    /// Takes the command of a CNC tick: rad/s and rad/s2 at the motor.
    pub(super) fn step(&mut self, physics: &Physics, velocity: f64, acceleration: f64) -> Event {
        // A rest keeps the direction, so that a stop between two strokes of one direction is no
        // reversal.
        let before = self.direction;
        if velocity.abs() > STILL_RAD_S {
            self.direction = velocity.signum();
        }
        let reversal = before != 0.0 && self.direction != before;
        // Flank: the sign of the torque that the load needs.
        let need = physics.need_nm(self.direction, velocity, acceleration);
        let jerk = (acceleration - self.acceleration) / Clock::CNC.period_s();
        self.acceleration = acceleration;
        let mut event = Event {
            reversal,
            flank_rad: None,
        };
        if need.abs() > NO_TORQUE_NM {
            let sign = need.signum();
            if self.need != 0.0 && sign != self.need {
                // Where friction changes the sign the reversal is the cause; elsewhere the
                // acceleration passes through zero.
                let friction_turns = reversal && physics.coulomb_nm > 0.0;
                event.flank_rad = Some(if friction_turns {
                    physics.at_reversal_rad(acceleration)
                } else {
                    physics.elsewhere_rad(jerk)
                });
            }
            self.need = sign;
        }
        event
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::math;

    fn events(coulomb_nm: f64) -> (Vec<u32>, Vec<u32>, f64) {
        let physics = Physics {
            load_inertia_kgm2: 0.01,
            viscous_nm_s_per_rad: 0.0,
            coulomb_nm,
            gap_rad: 0.01,
            traverse_s: 0.005,
            rated_nm: 10.0,
        };
        let (mut watch, mut reversals, mut flanks, mut most) =
            (Watch::default(), Vec::new(), Vec::new(), 0.0_f64);
        // position -40 cos(5 t): velocity changes sign at multiples of pi/5, acceleration half-way
        // between
        for tick in 0..2000_u32 {
            let (s, c) = math::sin_cos(5e-3 * f64::from(tick));
            let event = watch.step(&physics, 200.0 * s, 1000.0 * c);
            if event.reversal {
                reversals.push(tick);
            }
            if let Some(e) = event.flank_rad {
                flanks.push(tick);
                most = most.max(e);
            }
        }
        (reversals, flanks, most)
    }

    #[test]
    fn without_friction_flanks_change_with_the_acceleration() {
        let (reversals, flanks, most) = events(0.0);
        assert_eq!(reversals, [629, 1257, 1885]);
        assert_eq!(flanks, [315, 943, 1571]);
        assert!(
            (most / (5000.0 * 1.25e-7 / 12.0) - 1.0).abs() < 0.01,
            "{most}"
        );
    }

    #[test]
    fn with_much_friction_they_change_with_the_velocity() {
        let (reversals, flanks, most) = events(40.0);
        assert_eq!(reversals, flanks);
        assert!(
            (most / (1000.0 * 25e-6 / 8.0 * 0.75) - 1.0).abs() < 0.01,
            "{most}"
        );
    }
}
