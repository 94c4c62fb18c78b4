//! When an estimated half gap may be used: after three changes of flank, once the estimates there
//! agree and the filter itself is sure.

use serde::{Deserialize, Serialize};

/// Changes of flank that are compared.
const CHANGES: usize = 3;
/// How far the estimates at these changes may differ, over the largest.
const AGREE: f64 = 0.2;
/// Standard deviation over half gap, at most.
const SURE: f64 = 0.2;

/// The half gaps at the last changes of flank, oldest first, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Trust {
    side: i8,
    readings: [f64; CHANGES],
    seen: u32,
}

impl Trust {
    /// Takes the flank that is pressed now (0 for none) and the estimate with its standard
    /// deviation; gives the half gap to use, 0 if unsure.
    pub(super) fn step(&mut self, flank: i8, half_gap: f64, spread: f64) -> f64 {
        if flank != 0 && flank != self.side {
            if self.side != 0 {
                self.readings.rotate_left(1);
                self.readings[CHANGES - 1] = half_gap;
                self.seen = self.seen.saturating_add(1);
            }
            self.side = flank;
        }
        let most = self
            .readings
            .iter()
            .fold(half_gap, |most, reading| most.max(*reading));
        let least = self
            .readings
            .iter()
            .fold(half_gap, |least, reading| least.min(*reading));
        let sure = self.seen >= CHANGES as u32
            && most - least <= AGREE * most
            && spread <= SURE * half_gap;
        if sure { half_gap } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_changes_that_agree_are_trusted_and_a_jump_ends_it() {
        let mut trust = Trust::default();
        let mut used = Vec::new();
        for (n, half_gap) in [1.0, 1.0, 0.9, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]
            .into_iter()
            .enumerate()
        {
            let flank = if n % 2 == 0 { 1 } else { -1 };
            used.push(trust.step(flank, half_gap, 0.1 * half_gap));
        }
        assert_eq!(used, [0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 2.0]);
        assert_eq!(trust.step(0, 2.0, 0.5), 0.0);
        assert_eq!(trust.step(0, 2.0, 0.1), 2.0);
    }
}
