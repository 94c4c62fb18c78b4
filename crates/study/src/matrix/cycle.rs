//! Detection of limit cycles: turning points of the load's deviation that its own motion does not
//! explain.
//!
//! The deviation of the load from that of the machine without a gap turns a few times at every
//! change of flank. In windows of half a second those turns are counted (a turn needs a step back
//! by [`step_um`]); those of `none` in the same window and [`TURNS_AN_EVENT`] for every reversal
//! and change of flank in this window and the one before are subtracted. Five turns or more that
//! remain, in two windows running, are an oscillation above 5 Hz that lasts for a second: a limit
//! cycle.

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
}
