//! Ranges, ticks and round numbers.

use lostmotion_base::math;

/// The largest of 1, 2, 5 times a power of ten that is not above `value`; 0 unless it is positive
/// and finite.
pub(super) fn round_down(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 0.0;
    }
    let decade = math::pow(10.0, math::log10(value).floor());
    // The logarithm of a power of ten can come out just below the integer.
    let decade = if decade * 10.0 <= value * (1.0 + 1e-12) {
        decade * 10.0
    } else {
        decade
    };
    [5.0, 2.0]
        .into_iter()
        .map(|digit| digit * decade)
        .find(|v| *v <= value * (1.0 + 1e-12))
        .unwrap_or(decade)
}

/// A range of values on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) min: f64,
    pub(super) max: f64,
}

impl Range {
    /// The smallest range that holds all finite values; none without any.
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Option<Range> {
        values
            .filter(|v| v.is_finite())
            .fold(None, |range: Option<Range>, v| {
                Some(range.map_or(Range { min: v, max: v }, |r| Range {
                    min: r.min.min(v),
                    max: r.max.max(v),
                }))
            })
    }

    pub(super) fn span(&self) -> f64 {
        self.max - self.min
    }

    pub(super) fn middle(&self) -> f64 {
        0.5 * (self.min + self.max)
    }

    /// Wider by a part of its span at both ends, and never empty.
    pub(super) fn padded(&self, part: f64) -> Range {
        let pad = if self.span() > 0.0 {
            self.span() * part
        } else {
            self.max.abs().max(1.0) * 0.5
        };
        Range {
            min: self.min - pad,
            max: self.max + pad,
        }
    }

    /// Round values inside, about `count` of them, with the decimals they need.
    pub(super) fn ticks(&self, count: usize) -> (Vec<f64>, usize) {
        let step = round_down(self.span() / count.max(1) as f64);
        if step <= 0.0 {
            return (Vec::new(), 0);
        }
        let first = (self.min / step).ceil() as i64;
        let last = (self.max / step).floor() as i64;
        let decimals = (-math::log10(step).floor()).clamp(0.0, 9.0) as usize;
        ((first..=last).map(|k| k as f64 * step).collect(), decimals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers() {
        for (value, round) in [
            (1.0, 1.0),
            (0.999, 0.5),
            (1000.0, 1000.0),
            (4.9, 2.0),
            (5.0, 5.0),
            (0.001, 0.001),
            (73.0, 50.0),
        ] {
            assert!(
                (round_down(value) - round).abs() < 1e-12 * round,
                "{value} {}",
                round_down(value)
            );
        }
        assert_eq!(round_down(0.0).to_bits(), 0.0_f64.to_bits());
        assert_eq!(round_down(f64::NAN).to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn ticks_lie_inside() {
        let (ticks, decimals) = Range {
            min: -0.31,
            max: 0.42,
        }
        .ticks(5);
        assert_eq!(decimals, 1);
        assert_eq!(ticks.len(), 8);
        assert!(ticks.iter().all(|t| (-0.31..=0.42).contains(t)));
        assert_eq!(Range { min: 1.0, max: 1.0 }.ticks(4).0, [0.0; 0]);
    }
}
