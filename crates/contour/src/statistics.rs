//! Distribution of an error in constant memory.

use crate::histogram::Histogram;
use lostmotion_base::Tick;
use serde::{Deserialize, Serialize};

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
    /// Takes a sample. One that is not finite is counted apart and changes nothing else.
    pub fn push(&mut self, value: f64, at: Place) {
        if !value.is_finite() {
            self.not_finite += 1;
            return;
        }
        if value.abs() > self.max.abs() || self.samples == 0 {
            (self.max, self.max_at) = (value, at);
        }
        self.samples += 1;
        self.sum_of_squares += value * value;
        self.histogram.count(value.abs());
    }

    /// Adds another's samples; of two equal maxima the earlier stays.
    pub fn merge(&mut self, other: &Statistics) {
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
        let rank = (part * self.samples as f64)
            .ceil()
            .max(1.0)
            .min(self.samples as f64) as u64;
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
