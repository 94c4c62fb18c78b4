//! Averages and speeds of columns over triangular windows.

/// Part of a column's second differences that its samples have to be changed by for their weighted sum
/// to be the average of the signal between them, too: 1/12, as sums and integrals of smooth signals
/// differ by (Gregory 1670). Without it averages of logs that are slow against the servo would be
/// larger than its speeds, by 4 % at 180 rad/s and 4 ms.
const BETWEEN_SAMPLES: f64 = 1.0 / 12.0;

/// A column with so many of its second differences added; the ends stay.
fn with_bends(column: &[f64], part: f64) -> Vec<f64> {
    let mut changed = column.to_vec();
    for (at, three) in column.windows(3).enumerate() {
        changed[at + 1] += part * (three[0] - 2.0 * three[1] + three[2]);
    }
    changed
}

/// Averages with a triangular window of `2 half` samples, with sums that are made once.
pub(crate) struct Averages {
    half: usize,
    /// Sums of the column up to each sample, and sums of those.
    twice: Vec<f64>,
    /// The first value, which is taken off before summing: large places would lose digits.
    base: f64,
}

impl Averages {
    pub(crate) fn new(column: &[f64], half: usize) -> Averages {
        Averages::between(column, half, 1.0)
    }

    /// Of a signal that has this part of what a smooth one has between its samples: none where it is held
    /// from one to the next.
    pub(crate) fn between(column: &[f64], half: usize, part: f64) -> Averages {
        let base = column.first().copied().unwrap_or(0.0);
        let (mut once, mut sum) = (0.0, 0.0);
        let mut twice = Vec::with_capacity(column.len() + 1);
        twice.push(0.0);
        for value in with_bends(column, part * BETWEEN_SAMPLES) {
            once += value - base;
            sum += once;
            twice.push(sum);
        }
        Averages { half, twice, base }
    }

    /// Average around sample `at`, which is at least `half` from either end: weights
    /// `(half - |j|) / half^2`.
    pub(crate) fn mean(&self, at: usize) -> f64 {
        let (h, s) = (self.half, &self.twice);
        // The second difference of the double sum is the triangle.
        (s[at + h] - 2.0 * s[at] + s[at - h]) / (h * h) as f64 + self.base
    }
}

/// Average velocity of a position column over the same window, from the trapezoids of the column:
/// the mean of the later half less that of the earlier one.
pub(crate) struct Rates<'a> {
    pub(crate) half: usize,
    period_s: f64,
    column: &'a [f64],
    /// Integral of the column, its first value taken off.
    integral: Vec<f64>,
}

impl<'a> Rates<'a> {
    pub(crate) fn new(column: &'a [f64], half: usize, period_s: f64) -> Rates<'a> {
        let base = column.first().copied().unwrap_or(0.0);
        let mut sum = 0.0;
        let mut integral = Vec::with_capacity(column.len());
        let mut before = 0.0;
        // The trapezoids of a bent column are too small.
        for value in with_bends(column, -BETWEEN_SAMPLES) {
            let value = value - base;
            sum += 0.5 * (before + value) * period_s;
            before = value;
            integral.push(sum);
        }
        Rates {
            half,
            period_s,
            column,
            integral,
        }
    }

    pub(crate) fn span_s(&self) -> f64 {
        self.half as f64 * self.period_s
    }

    pub(crate) fn velocity(&self, at: usize) -> f64 {
        let (h, p) = (self.half, &self.integral);
        (p[at + h] - 2.0 * p[at] + p[at - h]) / (self.span_s() * self.span_s())
    }

    pub(crate) fn acceleration(&self, at: usize) -> f64 {
        let (h, q) = (self.half, self.column);
        (q[at + h] - 2.0 * q[at] + q[at - h]) / (self.span_s() * self.span_s())
    }
}
