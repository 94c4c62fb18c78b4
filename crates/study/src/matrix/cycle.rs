//! Detection of limit cycles: turning points of the load's deviation that its own motion does not
//! explain.
//!
//! Reversals of an axis and changes of flank of its load are found from the plan alone.
//! The deviation of the load from that of the machine without a gap turns a few times at every
//! change of flank. In windows of half a second those turns are counted (a turn needs a step back
//! by [`step_um`]); those of `none` in the same window and [`TURNS_AN_EVENT`] for every reversal
//! and change of flank in this window and the one before are subtracted. Five turns or more that
//! remain, in two windows running, are an oscillation above 5 Hz that lasts for a second: a limit
//! cycle.

use super::limit::Physics;
use lostmotion_base::Clock;

/// Servo ticks of a window: 0.5 s. A choice.
const WINDOW_TICKS: usize = 2000;
/// Turns that one change of flank or one reversal explains. A choice: three periods of ringing.
const TURNS_AN_EVENT: u32 = 6;
/// Turns that no event explains, from which a window oscillates. Tuned on the matrix: fewer are
/// found without any limit cycle.
const UNEXPLAINED_TURNS: u32 = 5;
/// Oscillating windows in a row that make a limit cycle: 1 s. A choice.
const WINDOWS_IN_A_ROW: usize = 2;

/// The least step back that counts as a turn, um: 0.2 um, two counts of the encoder, or a hundredth
/// of the gap, whichever is most. A choice.
pub(super) fn step_um(count_um: f64, gap_um: f64) -> f64 {
    0.2_f64.max(2.0 * count_um).max(0.01 * gap_um)
}

/// Counts by window.
#[derive(Clone, Debug, Default)]
pub(super) struct Windows(Vec<u32>);

impl Windows {
    /// Counts one at a servo tick since the start of measuring.
    pub(super) fn count(&mut self, tick: usize) {
        // Windows that were not reached yet count zero.
        let window = tick / WINDOW_TICKS;
        if self.0.len() <= window {
            self.0.resize(window + 1, 0);
        }
        if let Some(count) = self.0.get_mut(window) {
            *count += 1;
        }
    }

    fn get(&self, window: usize) -> u32 {
        self.0.get(window).copied().unwrap_or(0)
    }
}

/// Turning points of a signal.
#[derive(Clone, Debug, Default)]
pub(super) struct Turns {
    extreme: f64,
    falling: bool,
    pub(super) windows: Windows,
}

impl Turns {
    /// Takes the signal at a servo tick since the start of measuring.
    pub(super) fn push(&mut self, tick: usize, value: f64, step: f64) {
        // Follow the extreme; a step back from it by more than the threshold is a turn
        // (hysteresis).
        let beyond = if self.falling {
            value < self.extreme
        } else {
            value > self.extreme
        };
        if beyond {
            self.extreme = value;
        } else if (value - self.extreme).abs() > step {
            self.falling = !self.falling;
            self.extreme = value;
            self.windows.count(tick);
        }
    }
}

/// Whether a signal oscillates beyond what another one and the motion's own events explain.
pub(super) fn hunts(turns: &Windows, none: &Windows, events: &Windows) -> bool {
    let mut running = 0;
    for window in 0..turns.0.len() {
        // Ringing after an event may reach into the next window.
        let recent = events.get(window)
            + if window > 0 {
                events.get(window - 1)
            } else {
                0
            };
        let explained = none.get(window) + TURNS_AN_EVENT * recent;
        running = if turns.get(window) >= explained + UNEXPLAINED_TURNS {
            running + 1
        } else {
            0
        };
        if running >= WINDOWS_IN_A_ROW {
            return true;
        }
    }
    false
}

/// Speed up to which an axis stands still, rad/s at the motor: above rounding. A choice.
const STILL_RAD_S: f64 = 1e-6;
/// Torque below which a need has no sign, N m: above rounding. A choice.
const NO_TORQUE_NM: f64 = 1e-6;

/// One axis' watch over its commands.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch {
    direction: f64,
    need: f64,
    acceleration: f64,
}

/// What happened at a CNC tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Event {
    /// The velocity changed its sign.
    pub(crate) reversal: bool,
    /// The flank changed; the least error that this can leave, rad.
    pub(crate) flank_rad: Option<f64>,
}

impl Watch {
    /// Takes the command of a CNC tick: rad/s and rad/s2 at the motor.
    pub(crate) fn step(&mut self, physics: &Physics, velocity: f64, acceleration: f64) -> Event {
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

    fn turns(signal: impl Fn(f64) -> f64) -> Turns {
        let mut turns = Turns::default();
        for tick in 0..16_000 {
            turns.push(tick, signal(tick as f64 * 250e-6), 0.2);
        }
        turns
    }

    #[test]
    fn eight_hertz_are_a_limit_cycle_and_what_events_explain_is_none() {
        let quiet = turns(|_| 0.0).windows;
        let hunting = turns(|t| math::sin(50.0 * t)).windows;
        assert!(hunts(&hunting, &quiet, &quiet));
        assert!(!hunts(&hunting, &hunting, &quiet));
        let mut events = Windows::default();
        for window in 0..8 {
            events.count(window * WINDOW_TICKS);
        }
        assert!(!hunts(&hunting, &quiet, &events));
        assert!(!hunts(
            &turns(|t| 0.09 * math::sin(50.0 * t)).windows,
            &quiet,
            &quiet
        ));
    }

    #[test]
    fn a_decaying_oscillation_is_none() {
        let ringing = turns(|t| math::exp(-8.0 * t) * math::sin(200.0 * t)).windows;
        assert!(!hunts(&ringing, &Windows::default(), &Windows::default()));
    }

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
