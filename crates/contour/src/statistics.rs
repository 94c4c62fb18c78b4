//! Distribution of an error in constant memory.

use lostmotion_base::Tick;
use serde::{Deserialize, Serialize};

/// Leading bits of the mantissa that tell bins apart: 128 bins an octave, 0.8 % wide.
const MANTISSA_BITS: u32 = 7;
/// Exponents of the smallest and largest octave: 6e-8 to 1024 in the unit of the values.
const LOWEST_EXPONENT: i64 = -24;
const HIGHEST_EXPONENT: i64 = 10;
/// All bins, 35 kB of counters.
const BINS: usize = ((HIGHEST_EXPONENT - LOWEST_EXPONENT) as usize) << MANTISSA_BITS;
/// Bits of the mantissa (52) that do not tell bins apart.
const DROPPED_BITS: u32 = 52 - MANTISSA_BITS;
/// Leading bits of the smallest bin's lower edge; 1023 is the exponents' bias.
const FIRST_BIN_BITS: u64 = ((1023 + LOWEST_EXPONENT) as u64) << MANTISSA_BITS;

/// Where a sample was taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// When, on the caller's clock.
    pub tick: Tick,
    /// Programmed segment.
    pub segment: u64,
    /// Parameter on it.
    pub s: f64,
}

/// Maximum, RMS and percentiles of the magnitude of a signed quantity, of one unit throughout (mm,
/// rad).
///
/// Maximum and RMS are exact. Percentiles come from a histogram of about 35 kB: within 0.4 % of the
/// value of their rank between 6e-8 and 1024 of the unit; smaller values count as 0. Merging the
/// statistics of two halves gives the statistics of the whole.
///
/// ```
/// use lostmotion_contour::{Place, Statistics};
///
/// let mut errors = Statistics::default();
/// for (tick, error_mm) in (0..).zip([0.001, -0.004, 0.002]) {
///     errors.push(error_mm, Place { tick, segment: 0, s: 0.0 });
/// }
/// let (worst_mm, place) = errors.max();
/// assert_eq!((worst_mm, place.tick), (-0.004, 1));
/// assert!((errors.percentile(0.5) / 0.002 - 1.0).abs() < 0.004);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    samples: u64,
    not_finite: u64,
    sum_of_squares: f64,
    max: f64,
    max_at: Place,
    histogram: Histogram,
}

/// The figures of [`Statistics`], in its unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Number of samples.
    pub samples: u64,
    /// Largest magnitude, with its sign.
    pub max: f64,
    /// Where.
    pub max_at: Place,
    /// Root mean square.
    pub rms: f64,
    /// Median of the magnitude.
    pub p50: f64,
    /// 95th percentile of the magnitude.
    pub p95: f64,
    /// 99th percentile of the magnitude.
    pub p99: f64,
    /// 99.9th percentile of the magnitude.
    pub p999: f64,
}

impl Statistics {
    /// Adds a sample. One that is not finite is counted apart and changes nothing else.
    pub fn push(&mut self, value: f64, at: Place) {
        if !value.is_finite() {
            self.not_finite += 1;
            return;
        }
        // The first sample is a maximum even if it is zero, so that it has a place.
        if value.abs() > self.max.abs() || self.samples == 0 {
            (self.max, self.max_at) = (value, at);
        }
        self.samples += 1;
        self.sum_of_squares += value * value;
        self.histogram.count(value.abs());
    }

    /// Adds another's samples; of two equal maxima the earlier stays.
    pub fn merge(&mut self, other: &Statistics) {
        // On a tie the earlier tick, as one pass over both halves would have kept it.
        let (mine, theirs) = (self.max.abs(), other.max.abs());
        let earlier = other.max_at.tick < self.max_at.tick;
        if other.samples > 0 && (self.samples == 0 || theirs > mine || (theirs >= mine && earlier))
        {
            (self.max, self.max_at) = (other.max, other.max_at);
        }
        self.samples += other.samples;
        self.not_finite += other.not_finite;
        self.sum_of_squares += other.sum_of_squares;
        self.histogram.merge(&other.histogram);
    }

    /// Number of finite samples.
    pub const fn samples(&self) -> u64 {
        self.samples
    }

    /// Number of samples that were not finite.
    pub const fn not_finite(&self) -> u64 {
        self.not_finite
    }

    /// The largest magnitude with its sign, and where it was; 0 without samples.
    pub const fn max(&self) -> (f64, Place) {
        (self.max, self.max_at)
    }

    /// Root mean square; 0 without samples.
    pub fn rms(&self) -> f64 {
        if self.samples == 0 {
            0.0
        } else {
            (self.sum_of_squares / self.samples as f64).sqrt()
        }
    }

    /// The smallest magnitude that a part of all samples does not exceed (nearest rank); `part`
    /// from 0 to 1. 0 without samples.
    pub fn percentile(&self, part: f64) -> f64 {
        if self.samples == 0 {
            return 0.0;
        }
        // Nearest rank, counted from 1.
        let rank = (part * self.samples as f64)
            .ceil()
            .max(1.0)
            .min(self.samples as f64) as u64;
        // A bin's middle may lie above the largest value seen.
        self.histogram.value_of_rank(rank).min(self.max.abs())
    }

    /// All figures.
    pub fn summary(&self) -> Summary {
        Summary {
            samples: self.samples,
            max: self.max,
            max_at: self.max_at,
            rms: self.rms(),
            p50: self.percentile(0.5),
            p95: self.percentile(0.95),
            p99: self.percentile(0.99),
            p999: self.percentile(0.999),
        }
    }
}

/// Counts of magnitudes in bins of almost constant relative width, of fixed size.
///
/// Each octave is cut into 128 equal bins, so that a bin's middle is within 1/256 = 0.4 % of every
/// value in it. A bin's number is the top of the value's own bit pattern: exact, fast and the same
/// everywhere. The bins are allocated with the first count.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Histogram {
    /// Values below the smallest bin.
    below: u64,
    bins: Vec<u64>,
}

impl Histogram {
    /// Counts a magnitude.
    fn count(&mut self, magnitude: f64) {
        // The bits of a positive number grow with it: exponent and leading mantissa bits number the
        // bins.
        let Some(bin) = (magnitude.to_bits() >> DROPPED_BITS).checked_sub(FIRST_BIN_BITS) else {
            self.below += 1;
            return;
        };
        // Allocated with the first count: a statistic without samples costs nothing.
        if self.bins.len() < BINS {
            self.bins.resize(BINS, 0);
        }
        // Values above the largest octave are counted in the last bin.
        if let Some(count) = self.bins.get_mut((bin as usize).min(BINS - 1)) {
            *count += 1;
        }
    }

    fn merge(&mut self, other: &Histogram) {
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
    fn value_of_rank(&self, rank: u64) -> f64 {
        // Counts from the smallest value upwards until the rank is reached.
        let mut seen = self.below;
        if rank <= seen {
            return 0.0;
        }
        for (bin, count) in self.bins.iter().enumerate() {
            seen += count;
            if rank <= seen {
                // The middle of the bin: its edges are the bit patterns of its number and of the
                // next.
                let edge = |bin: u64| f64::from_bits((FIRST_BIN_BITS + bin) << DROPPED_BITS);
                return 0.5 * (edge(bin as u64) + edge(bin as u64 + 1));
            }
        }
        f64::INFINITY
    }
}
