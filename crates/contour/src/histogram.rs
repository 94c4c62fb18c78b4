//! Counts of magnitudes in bins of almost constant relative width, of fixed size.
//!
//! Each octave is cut into 128 equal bins, so that a bin's middle is within 1/256 = 0.4 % of every
//! value in it. A bin's number is the top of the value's own bit pattern: exact, fast and the same
//! everywhere.

use serde::{Deserialize, Serialize};

/// Leading bits of the mantissa that tell bins apart: 128 bins an octave, 0.8 % wide.
const MANTISSA_BITS: u32 = 7;
/// Exponents of the smallest and largest octave: 6e-8 to 1024 in the unit of the values.
const LOWEST_EXPONENT: i64 = -24;
const HIGHEST_EXPONENT: i64 = 10;
const BINS: usize = ((HIGHEST_EXPONENT - LOWEST_EXPONENT) as usize) << MANTISSA_BITS;
const SHIFT: u32 = 52 - MANTISSA_BITS;
const FIRST_BIN_BITS: u64 = ((1023 + LOWEST_EXPONENT) as u64) << MANTISSA_BITS;

/// Bins are made with the first count.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Histogram {
    /// Values below the smallest bin.
    below: u64,
    bins: Vec<u64>,
}

impl Histogram {
    /// Counts a magnitude.
    pub(crate) fn count(&mut self, magnitude: f64) {
        let Some(bin) = (magnitude.to_bits() >> SHIFT).checked_sub(FIRST_BIN_BITS) else {
            self.below += 1;
            return;
        };
        if self.bins.len() < BINS {
            self.bins.resize(BINS, 0);
        }
        if let Some(count) = self.bins.get_mut((bin as usize).min(BINS - 1)) {
            *count += 1;
        }
    }

    pub(crate) fn merge(&mut self, other: &Histogram) {
        self.below += other.below;
        if self.bins.len() < other.bins.len() {
            self.bins.resize(other.bins.len(), 0);
        }
        for (count, more) in self.bins.iter_mut().zip(&other.bins) {
            *count += more;
        }
    }

    /// The middle of the bin in which the value of a rank lies (1 is the smallest), 0 below the
    /// smallest bin.
    pub(crate) fn value_of_rank(&self, rank: u64) -> f64 {
        let mut seen = self.below;
        if rank <= seen {
            return 0.0;
        }
        for (bin, count) in self.bins.iter().enumerate() {
            seen += count;
            if rank <= seen {
                let edge = |bin: u64| f64::from_bits((FIRST_BIN_BITS + bin) << SHIFT);
                return 0.5 * (edge(bin as u64) + edge(bin as u64 + 1));
            }
        }
        f64::INFINITY
    }
}
