//! Signals over time as the smallest and largest value of equal parts of it, what limits the motion in
//! such parts, and how often an error comes, all in bounded memory.

use lostmotion_sim::Limiter;

/// Smallest and largest value of several signals in equal parts of the time. No peak is lost: parts
/// begin with one tick and double whenever the memory is full.
#[derive(Clone, Debug)]
pub(super) struct Envelope {
    signals: usize,
    capacity: usize,
    /// Ticks of a part.
    group: u64,
    /// Ticks in the last part.
    filled: u64,
    /// Row by row; a signal without a value in a part has its ends the wrong way round.
    low: Vec<f32>,
    high: Vec<f32>,
}

impl Envelope {
    /// Of this many signals, holding at most `2 * capacity` parts.
    pub(super) fn new(signals: usize, capacity: usize) -> Envelope {
        Envelope {
            signals: signals.max(1),
            capacity: capacity.max(2),
            group: 1,
            filled: 1,
            low: Vec::new(),
            high: Vec::new(),
        }
    }

    /// Parts so far.
    pub(super) fn len(&self) -> usize {
        self.low.len() / self.signals
    }

    /// Takes the values of a tick; NaN is no value.
    pub(super) fn push(&mut self, values: &[f32]) {
        if self.filled >= self.group || self.low.is_empty() {
            if self.len() >= 2 * self.capacity {
                self.halve();
            }
            // After halving, the last part may have room again.
            if self.filled >= self.group || self.low.is_empty() {
                let rows = self.low.len() + self.signals;
                self.low.resize(rows, f32::INFINITY);
                self.high.resize(rows, f32::NEG_INFINITY);
                self.filled = 0;
            }
        }
        let from = self.low.len() - self.signals;
        let (low, high) = (&mut self.low[from..], &mut self.high[from..]);
        for ((low, high), value) in low.iter_mut().zip(high).zip(values.iter().copied()) {
            // A comparison with NaN is false: it changes nothing.
            *low = if value < *low { value } else { *low };
            *high = if value > *high { value } else { *high };
        }
        self.filled += 1;
    }

    /// Two neighbouring parts become one.
    fn halve(&mut self) {
        let (signals, rows) = (self.signals, self.len());
        // The last part of an odd number has no partner and is full of its own ticks only.
        if rows % 2 == 0 {
            self.filled += self.group;
        }
        for row in 0..rows.div_ceil(2) {
            for signal in 0..signals {
                let [to, one, other] =
                    [row, 2 * row, 2 * row + 1].map(|row| row * signals + signal);
                let pick = |values: &[f32], merge: fn(f32, f32) -> f32| {
                    let value = values[one];
                    values
                        .get(other)
                        .map_or(value, |other| merge(value, *other))
                };
                self.low[to] = pick(&self.low, f32::min);
                self.high[to] = pick(&self.high, f32::max);
            }
        }
        let rows = rows.div_ceil(2) * signals;
        self.low.truncate(rows);
        self.high.truncate(rows);
        self.group *= 2;
    }

    /// Halves until at most `limit` parts are left.
    pub(super) fn fit(&mut self, limit: usize) {
        while self.len() > limit.max(1) {
            self.halve();
        }
    }

    /// Ticks of a part.
    pub(super) const fn ticks(&self) -> u64 {
        self.group
    }

    /// Smallest and largest value of a signal in each part; NaN where it has none.
    pub(super) fn signal(&self, signal: usize) -> impl Iterator<Item = [f32; 2]> + Clone + '_ {
        let every = |values| <[f32]>::iter(values).skip(signal).step_by(self.signals);
        every(&self.low)
            .zip(every(&self.high))
            .map(|(low, high)| match low <= high {
                true => [*low, *high],
                false => [f32::NAN; 2],
            })
    }
}

/// What keeps the motion from going faster in equal parts of the time: parts begin with one tick and
/// double whenever the memory is full.
#[derive(Clone, Debug)]
pub(super) struct Limits {
    capacity: usize,
    /// Ticks of a part.
    group: u64,
    /// Ticks so far.
    ticks: u64,
    /// Ticks of each part that each limiter has, by its index.
    counts: Vec<[u32; Limiter::COUNT]>,
}

impl Limits {
    /// Holding at most `2 * capacity` parts.
    pub(super) fn new(capacity: usize) -> Limits {
        Limits {
            capacity: capacity.max(2),
            group: 1,
            ticks: 0,
            counts: Vec::new(),
        }
    }

    /// Ticks so far.
    pub(super) const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Takes what limits a tick.
    pub(super) fn push(&mut self, limiter: Option<Limiter>) {
        if self.ticks.is_multiple_of(self.group) {
            if self.counts.len() >= 2 * self.capacity {
                self.halve();
            }
            // After halving, the last part has room again if its partner is missing.
            if self.ticks.is_multiple_of(self.group) {
                self.counts.push([0; Limiter::COUNT]);
            }
        }
        let count = self.counts.last_mut().zip(limiter);
        if let Some(count) = count.and_then(|(part, limiter)| part.get_mut(limiter.index())) {
            *count += 1;
        }
        self.ticks += 1;
    }

    /// Two neighbouring parts become one.
    fn halve(&mut self) {
        let joined = self.counts.chunks(2).map(|parts| {
            let mut sum = [0; Limiter::COUNT];
            for part in parts {
                for (sum, count) in sum.iter_mut().zip(part) {
                    *sum += count;
                }
            }
            sum
        });
        self.counts = joined.collect();
        self.group *= 2;
    }

    /// Halves until at most `limit` parts are left.
    pub(super) fn fit(&mut self, limit: usize) {
        while self.counts.len() > limit.max(1) {
            self.halve();
        }
    }

    /// Ticks of a part.
    pub(super) const fn group(&self) -> u64 {
        self.group
    }

    /// Parts.
    pub(super) fn len(&self) -> usize {
        self.counts.len()
    }

    /// Part of the whole time that a limiter has, 0 to 1.
    pub(super) fn share(&self, limiter: Limiter) -> f64 {
        let of = |part: &[u32; Limiter::COUNT]| u64::from(part[limiter.index()]);
        self.counts.iter().map(of).sum::<u64>() as f64 / self.ticks.max(1) as f64
    }

    /// Part of each part that a limiter has, 0 to 1; the last part may be shorter than others.
    pub(super) fn shares(&self, limiter: Limiter) -> impl Iterator<Item = f64> + '_ {
        self.counts.iter().enumerate().map(move |(index, part)| {
            let ticks = self
                .group
                .min(self.ticks.saturating_sub(index as u64 * self.group));
            f64::from(part[limiter.index()]) / ticks.max(1) as f64
        })
    }
}

/// Bins of a histogram, half of them below 0.
const BINS: usize = 240;
/// Width of a bin before anything is counted, um: below what any machine repeats.
const FIRST_WIDTH_UM: f64 = 0.01;

/// How often which error came: bins of equal width around 0 that double when an error lies outside.
#[derive(Clone, Debug)]
pub(super) struct Histogram {
    /// Width of a bin, um.
    pub(super) width_um: f64,
    /// Samples of each bin; 0 lies between the two in the middle.
    pub(super) counts: Vec<u64>,
}

impl Default for Histogram {
    fn default() -> Histogram {
        Histogram {
            width_um: FIRST_WIDTH_UM,
            counts: vec![0; BINS],
        }
    }
}

impl Histogram {
    /// Counts an error.
    pub(super) fn push(&mut self, error_um: f64) {
        if !error_um.is_finite() {
            return;
        }
        const HALF: f64 = (BINS / 2) as f64;
        while error_um.abs() >= HALF * self.width_um {
            self.widen();
        }
        let bin = (error_um / self.width_um + HALF).floor() as usize;
        if let Some(count) = self.counts.get_mut(bin) {
            *count += 1;
        }
    }

    /// Two bins become one; 0 stays in the middle.
    fn widen(&mut self) {
        let mut wide = vec![0; BINS];
        for (bin, count) in self.counts.iter().enumerate() {
            if let Some(sum) = wide.get_mut(BINS / 4 + bin / 2) {
                *sum += count;
            }
        }
        self.counts = wide;
        self.width_um *= 2.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_is_the_extremes_of_its_parts() {
        let value = |tick: u64| ((tick * 7919) % 1013) as f32 - 500.0;
        for ticks in [1, 7, 64, 65, 1000, 4097] {
            let mut envelope = Envelope::new(2, 16);
            for tick in 0..ticks {
                envelope.push(&[value(tick), f32::NAN]);
                assert!(envelope.len() <= 32);
            }
            envelope.fit(20);
            let group = envelope.ticks();
            assert_eq!(envelope.len() as u64, ticks.div_ceil(group));
            for (part, [low, high]) in envelope.signal(0).enumerate() {
                let from = part as u64 * group;
                let all = || (from..(from + group).min(ticks)).map(value);
                assert!(all().fold(f32::INFINITY, f32::min) == low, "{ticks} {part}");
                assert!(
                    all().fold(f32::NEG_INFINITY, f32::max) == high,
                    "{ticks} {part}"
                );
            }
            assert!(
                envelope
                    .signal(1)
                    .all(|[low, high]| low.is_nan() && high.is_nan())
            );
        }
    }

    #[test]
    fn limits_are_counted_in_their_parts() {
        let of = |tick: u64| match tick * 7919 % 5 {
            0 => None,
            1 => Some(Limiter::Tolerance),
            _ => Some(Limiter::Feed),
        };
        for ticks in [1, 7, 64, 65, 1000, 4097] {
            let mut limits = Limits::new(16);
            for tick in 0..ticks {
                limits.push(of(tick));
                assert!(limits.len() <= 32);
            }
            limits.fit(20);
            let group = limits.group();
            assert_eq!(limits.ticks(), ticks);
            assert_eq!(limits.len() as u64, ticks.div_ceil(group));
            for limiter in [Limiter::Feed, Limiter::Tolerance, Limiter::Chord] {
                let share = |from: u64, to: u64| {
                    let has = (from..to).filter(|tick| of(*tick) == Some(limiter));
                    has.count() as f64 / (to - from) as f64
                };
                assert!((limits.share(limiter) - share(0, ticks)).abs() < 1e-12);
                for (part, found) in limits.shares(limiter).enumerate() {
                    let from = part as u64 * group;
                    let expected = share(from, (from + group).min(ticks));
                    assert!((found - expected).abs() < 1e-12, "{ticks} {part}");
                }
            }
        }
    }

    #[test]
    fn a_histogram_counts_all_and_puts_them_where_they_belong() {
        let errors: Vec<f64> = (0..5000_i32)
            .map(|n| f64::from(n * 37 % 4001 - 2000) * 0.013 + 7e-4)
            .collect();
        let mut histogram = Histogram::default();
        errors.iter().for_each(|error| histogram.push(*error));
        let width = histogram.width_um;
        for (bin, count) in histogram.counts.iter().enumerate() {
            let from = (bin as f64 - 120.0) * width;
            let inside = errors
                .iter()
                .filter(|e| (from..from + width).contains(*e))
                .count();
            assert_eq!(*count, inside as u64, "{bin}");
        }
        assert_eq!(histogram.counts.iter().sum::<u64>(), 5000);
    }
}
