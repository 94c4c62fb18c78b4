//! Speed, acceleration and jerk of a recorded position, each with a bound of its error.
//!
//! A divided difference of `n + 1` samples times `n!` is the mean of the `n`th derivative over the
//! samples, weighted by a spline that is positive and has the area 1; so the derivative itself is as
//! large somewhere between them. What rounding and noise of the samples can make of it is taken off:
//! what is then left over a limit is certain. Wide stencils are told better, narrow ones miss less
//! of a short peak; each sample is looked at with all of them, and the one that proves most counts.

use lostmotion_base::math;

/// Steps between the samples of a stencil.
const SCALES: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// Rows of the longest stencil: the third derivative at the widest scale.
pub(super) const LONGEST_ROWS: usize = 3 * SCALES[SCALES.len() - 1];
/// Longest stencil, s. A choice: longer ones average over whole moves.
const LONGEST_S: f64 = 0.2;
/// Finest decimal that values are looked at for.
const MOST_DECIMALS: i32 = 8;
/// Steps of an encoder that have to be seen to tell that there are steps.
const FEWEST_STEPS: usize = 20;
/// Share of steps that have to be whole.
const WHOLE_SHARE: f64 = 0.98;
/// Most steps between two samples that are looked at: beyond, every number is nearly whole.
const MOST_STEPS: f64 = 1000.0;
/// Norm of the fourth difference 1, -4, 6, -4, 1.
const FOURTH_NORM: f64 = 8.366_600_265_340_756;
/// Median of the magnitude of a normal deviate, in standard deviations.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_081_7;
/// Noise below this part of the rounding is the rounding: its own is 0.29.
const ROUNDING_SHARE: f64 = 0.6;
/// Spread of the time between rows from which times are taken for uneven, in parts of it.
const UNEVEN: f64 = 1e-3;

/// How well a channel tells a position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Fineness {
    /// Step of the values; 0 where none is seen.
    pub(super) step: f64,
    /// Standard deviation of the noise; 0 where the steps explain all.
    pub(super) noise: f64,
}

impl Fineness {
    /// Of a channel that is recorded evenly, for the most part.
    pub(super) fn of(values: &[f64]) -> Fineness {
        let moved: Vec<f64> = values
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .filter(|moved| *moved > 0.0)
            .collect();
        // Few changes do not tell a rounding: whatever moved may be one step of it.
        let step = if moved.len() < FEWEST_STEPS {
            let least = moved.iter().copied().reduce(f64::min);
            least.unwrap_or_default()
        } else {
            decimal_step(values).max(counted_step(&moved))
        };
        let fourth: Vec<f64> = values
            .windows(5)
            .filter(|w| w.iter().any(|value| *value != w[0]))
            .map(|w| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs())
            .collect();
        // Most of a motion has no fourth difference to speak of; the median is that of the noise. At
        // rest there is none of a rounding.
        let noise = math::quantile(fourth, 0.5) / (NORMAL_MEDIAN * FOURTH_NORM);
        let is_step = noise <= ROUNDING_SHARE * step || noise < 1e-12;
        Fineness {
            step,
            noise: if is_step { 0.0 } else { noise },
        }
    }

    /// How far one of `count` values may be off, all but certainly.
    pub(super) fn bound(&self, count: usize) -> f64 {
        0.5 * self.step + deviations(count) * self.noise
    }
}

/// Standard deviations that none of `count` normal deviates exceeds, 19 times of 20 or more.
fn deviations(count: usize) -> f64 {
    (2.0 * math::log(20.0 * count.max(1) as f64)).sqrt()
}

/// The decimal that all values are rounded to; 0 where there is none.
fn decimal_step(values: &[f64]) -> f64 {
    let mut scale = 1.0;
    for _ in 0..=MOST_DECIMALS {
        let is_whole = |value: &f64| {
            let scaled = value * scale;
            (scaled - scaled.round()).abs() <= 1e-6 + 1e-12 * scaled.abs()
        };
        if values.iter().all(is_whole) {
            return 1.0 / scale;
        }
        scale *= 10.0;
    }
    0.0
}

/// The step of a counter or of a rounding in another unit, from the changes of its values; 0 where
/// none is seen.
fn counted_step(moved: &[f64]) -> f64 {
    let moved = moved.iter().filter(|step| **step > 1e-9);
    let least = moved.clone().copied().fold(f64::INFINITY, f64::min);
    let counts: Vec<f64> = moved
        .map(|step| step / least)
        .filter(|count| *count < MOST_STEPS)
        .collect();
    let whole = counts
        .iter()
        .filter(|count| (*count - count.round()).abs() < 0.02)
        .count();
    let mut kinds: Vec<i64> = counts.iter().map(|count| count.round() as i64).collect();
    kinds.sort_unstable();
    kinds.dedup();
    // A steady speed has one step, which is none of the channel's.
    let is_counted = counts.len() >= FEWEST_STEPS
        && kinds.len() > 2
        && whole as f64 >= WHOLE_SHARE * counts.len() as f64;
    if is_counted { least } else { 0.0 }
}

/// How far the time of a row may be off, s: half the decimal that uneven times are rounded to.
pub(super) fn time_bound_s(time_s: &[f64]) -> f64 {
    let steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = math::quantile(steps.clone(), 0.5);
    // Missing rows do not make times uneven.
    let is_uneven = steps.iter().any(|step| {
        let parts = step / usual;
        (parts - parts.round().max(1.0)).abs() > UNEVEN
    });
    if is_uneven {
        0.5 * decimal_step(time_s)
    } else {
        0.0
    }
}

/// What of a motion is limited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Order(pub(super) usize);

/// A derivative at a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rate {
    /// Row in the middle.
    pub(super) row: usize,
    /// Signed, and how far it may be off.
    pub(super) value: f64,
    pub(super) error: f64,
    /// From the first sample of the stencil to the last, s.
    pub(super) over_s: f64,
}

impl Rate {
    /// The least magnitude that is certain.
    pub(super) fn certain(&self) -> f64 {
        self.value.abs() - self.error
    }
}

/// A channel with its times.
#[derive(Clone, Copy, Debug)]
pub(super) struct Channel<'a> {
    pub(super) time_s: &'a [f64],
    pub(super) values: &'a [f64],
    pub(super) fineness: Fineness,
    pub(super) time_bound_s: f64,
}

impl Channel<'_> {
    /// At each scale the usual error of a derivative and the length of its stencil.
    pub(super) fn errors(&self, order: Order) -> Vec<(f64, f64)> {
        let rows = self.time_s.len();
        SCALES
            .iter()
            .filter_map(|&scale| {
                let middle = rows.checked_sub(scale * order.0 + 1)? / 2;
                let rate = self.rate(order, scale, middle)?;
                Some((rate.over_s, rate.error))
            })
            .collect()
    }

    /// Of each row the derivative that proves most, over stencils that are no shorter than `least_s`.
    pub(super) fn rates(&self, order: Order, least_s: f64) -> impl Iterator<Item = Rate> + '_ {
        let rows = self.time_s.len();
        // Times are rounded.
        let least_s = least_s * (1.0 - UNEVEN);
        (0..rows).filter_map(move |row| {
            SCALES
                .iter()
                .filter_map(|&scale| {
                    // The row in the middle of the stencil, or just before it.
                    let first = row.checked_sub(scale * order.0 / 2)?;
                    self.rate(order, scale, first)
                })
                .filter(|rate| rate.over_s >= least_s)
                .reduce(|a, b| if b.certain() > a.certain() { b } else { a })
                .map(|rate| Rate { row, ..rate })
        })
    }

    /// The derivative over the samples from a row on.
    fn rate(&self, order: Order, scale: usize, first: usize) -> Option<Rate> {
        let last = first + scale * order.0;
        let over_s = self.time_s.get(last)? - self.time_s.get(first)?;
        if over_s > LONGEST_S && scale > 1 {
            return None;
        }
        let (mut value, mut sum, mut square) = (0.0, 0.0, 0.0);
        let factorial: f64 = (1..=order.0).map(|factor| factor as f64).product();
        for node in (first..=last).step_by(scale) {
            // Weight of a node of the divided difference.
            let product: f64 = (first..=last)
                .step_by(scale)
                .filter(|&other| other != node)
                .map(|other| self.time_s[node] - self.time_s[other])
                .product();
            let weight = factorial / product;
            // Against the first value: positions far from zero would cost digits.
            value += weight * (self.values[node] - self.values[first]);
            sum += weight.abs();
            square += weight * weight;
        }
        let speed = (self.values[last] - self.values[first]).abs() / over_s;
        let count = 3 * SCALES.len() * self.time_s.len();
        let error = sum * (0.5 * self.fineness.step + speed * self.time_bound_s)
            + deviations(count) * self.fineness.noise * square.sqrt();
        Some(Rate {
            row: first,
            value,
            error,
            over_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::random::Random;

    fn times(rows: usize) -> Vec<f64> {
        (0..rows).map(|row| row as f64 * 1e-3).collect()
    }

    /// Polynomials have constant derivatives, whatever the stencil.
    #[test]
    fn derivatives_of_polynomials_are_exact() {
        let time_s: Vec<f64> = times(200)
            .iter()
            .map(|t| t + 2e-4 * math::sin(40.0 * t))
            .collect();
        for (order, expected) in [(1, 300.0), (2, 40.0), (3, 60.0)] {
            let of = |t: &f64| match order {
                1 => 300.0 * t,
                2 => 20.0 * t * t,
                _ => 10.0 * t * t * t,
            };
            let values: Vec<f64> = time_s.iter().map(of).collect();
            let channel = Channel {
                time_s: &time_s,
                values: &values,
                fineness: Fineness::default(),
                time_bound_s: 0.0,
            };
            for scale in SCALES {
                let rate = channel.rate(Order(order), scale, 20).unwrap();
                assert!((rate.value - expected).abs() < 1e-4 * expected, "{rate:?}");
            }
        }
    }

    #[test]
    fn roundings_and_noise_are_seen() {
        let smooth = |t: f64| 20.0 * math::sin(3.0 * t) + 5.0 * math::cos(11.0 * t);
        let time_s = times(4000);
        let exact: Vec<f64> = time_s.iter().map(|&t| smooth(t)).collect();
        assert_eq!(Fineness::of(&exact).step.to_bits(), 0.0_f64.to_bits());
        assert!(Fineness::of(&exact).noise < 1e-8);
        for step in [1e-3, 1e-4, 25.4e-5, 1.0 / 8192.0] {
            let rounded: Vec<f64> = exact.iter().map(|v| (v / step).round() * step).collect();
            let found = Fineness::of(&rounded);
            assert!((found.step / step - 1.0).abs() < 1e-3, "{step}: {found:?}");
            assert_eq!(found.noise.to_bits(), 0.0_f64.to_bits(), "{step}");
        }
        let mut random = Random::new(5);
        let noisy: Vec<f64> = exact.iter().map(|v| v + 2e-3 * random.normal()).collect();
        let found = Fineness::of(&noisy);
        assert!((found.noise / 2e-3 - 1.0).abs() < 0.05, "{found:?}");
        // A steady speed is no encoder.
        let steady: Vec<f64> = time_s.iter().map(|t| 33.3 * t / 7.0).collect();
        assert!(Fineness::of(&steady).step < 1e-7);
    }

    /// What is certain is never more than what is: sines of known peaks, rounded or noisy.
    #[test]
    fn what_is_certain_is_true() {
        let time_s = times(3000);
        let mut random = Random::new(11);
        for frequency in [3.0, 20.0, 80.0] {
            for (step, noise) in [
                (0.0, 0.0),
                (1e-3, 0.0),
                (1e-4, 0.0),
                (0.0, 1e-3),
                (0.0, 2e-4),
            ] {
                let values: Vec<f64> = time_s
                    .iter()
                    .map(|t| 10.0 * math::sin(frequency * t) + noise * random.normal())
                    .map(|v| {
                        if step > 0.0 {
                            (v / step).round() * step
                        } else {
                            v
                        }
                    })
                    .collect();
                let channel = Channel {
                    time_s: &time_s,
                    values: &values,
                    fineness: Fineness::of(&values),
                    time_bound_s: time_bound_s(&time_s),
                };
                for order in 1..=3 {
                    let peak = 10.0 * math::pow(frequency, order as f64);
                    let certain = channel
                        .rates(Order(order), 0.0)
                        .map(|rate| rate.certain())
                        .fold(0.0, f64::max);
                    assert!(
                        certain <= peak * (1.0 + 1e-6),
                        "{frequency} {step} {noise} {order}"
                    );
                    // And not much less, where the channel is exact and no motion so fast that it
                    // looks like noise.
                    if step == 0.0 && noise == 0.0 && frequency < 50.0 {
                        assert!(
                            certain > 0.99 * peak,
                            "{frequency} {order}: {certain} {peak}"
                        );
                    }
                }
            }
        }
    }
}
