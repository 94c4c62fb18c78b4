//! Where an axis moves, rests and turns round in a log.

use super::{BodyLog, Rates};
use lostmotion_base::math::quantile;

/// Half of the window that velocities are averaged with, s. A choice: shorter than any stroke.
const HALF_WINDOW_S: f64 = 0.005;
/// Fewest samples of half a window.
const MIN_HALF: usize = 4;
/// Share of the largest speed below which the axis counts as resting. A choice.
const REST_SHARE: f64 = 0.01;
/// Shortest rest, s: a reversal passes through zero faster.
const MIN_REST_S: f64 = 0.03;
/// Share of the accelerations' variance that noise of the encoder may have: so much too small does
/// the inertia come out. A choice.
const NOISE_SHARE: f64 = 5e-4;
/// Longest half window, s.
const MAX_HALF_WINDOW_S: f64 = 0.08;

/// One stroke: motion in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// First sample.
    pub from: usize,
    /// The sample behind the last one.
    pub to: usize,
    /// 1 forwards, -1 backwards.
    pub direction: f64,
    /// Largest speed, per s.
    pub speed: f64,
}

/// How the axis moves in a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Samples in half a window of averages.
    pub half: usize,
    /// Speed below which the axis counts as resting, per s.
    pub rest_speed: f64,
    /// Largest speed, per s.
    pub top_speed: f64,
    /// Largest acceleration, averaged, per s^2.
    pub top_acceleration: f64,
    /// The largest acceleration of a stroke in the median, per s^2: a log that begins or ends with a jolt has a
    /// top acceleration that nothing else in it has.
    pub usual_acceleration: f64,
    /// Strokes in order.
    pub strokes: Vec<Stroke>,
    /// Reversals: neighbouring strokes of opposite direction.
    pub reversals: usize,
    /// Rests of at least 30 ms.
    pub rests: usize,
    /// Standard deviation of the position's noise.
    pub noise: f64,
}

impl Motion {
    /// Finds strokes, reversals and rests in the motor's position.
    pub fn of(log: &BodyLog) -> Motion {
        Motion::in_positions(&log.motor, log.period_s)
    }

    /// The same in positions alone, at even times.
    pub(crate) fn in_positions(motor: &[f64], period_s: f64) -> Motion {
        let noise = noise_of(motor);
        let longest = ((MAX_HALF_WINDOW_S / period_s) as usize).max(MIN_HALF);
        let mut half = ((HALF_WINDOW_S / period_s).round() as usize).max(MIN_HALF);
        // The window grows until the encoder's noise no longer counts in the accelerations.
        loop {
            let rates = Rates::new(motor, half, period_s);
            let span = rates.span_s() * rates.span_s();
            let mut square = 0.0;
            let mut count = 0.0;
            for at in (half..motor.len().saturating_sub(half)).step_by(half) {
                let acceleration = rates.acceleration(at);
                square += acceleration * acceleration;
                count += 1.0;
            }
            // Three samples with weights 1, -2, 1.
            let of_noise = 6.0 * noise * noise / (span * span);
            if 2 * half > longest || of_noise <= NOISE_SHARE * square / f64::max(count, 1.0) {
                break;
            }
            half = half * 3 / 2;
        }
        let rates = Rates::new(motor, half, period_s);
        let places = half..motor.len().saturating_sub(half);
        let velocity: Vec<f64> = places.clone().map(|at| rates.velocity(at)).collect();
        let top = |values: &mut dyn Iterator<Item = f64>| {
            values.fold(0.0, |top: f64, value| top.max(value.abs()))
        };
        let top_speed = top(&mut velocity.iter().copied());
        let top_acceleration = top(&mut places.map(|at| rates.acceleration(at)));
        // Noise of an average velocity over two half windows of so many samples.
        let of_noise = noise * (2.0 / half as f64).sqrt() / rates.span_s();
        let rest_speed = (REST_SHARE * top_speed).max(5.0 * of_noise);
        let mut motion = Motion {
            half,
            rest_speed,
            top_speed,
            top_acceleration,
            usual_acceleration: top_acceleration,
            strokes: Vec::new(),
            reversals: 0,
            rests: 0,
            noise,
        };
        motion.strokes(&velocity, period_s);
        let tops = motion
            .strokes
            .iter()
            .map(|stroke| top(&mut (stroke.from..stroke.to).map(|at| rates.acceleration(at))));
        let tops: Vec<f64> = tops.collect();
        if !tops.is_empty() {
            motion.usual_acceleration = quantile(tops, 0.5);
        }
        motion
    }

    fn strokes(&mut self, velocity: &[f64], period_s: f64) {
        let state = |speed: f64| {
            if speed > self.rest_speed {
                1.0
            } else if speed < -self.rest_speed {
                -1.0
            } else {
                0.0
            }
        };
        let mut first = 0;
        let mut strokes: Vec<Stroke> = Vec::new();
        let mut rests = 0;
        for run in velocity.chunk_by(|a, b| state(*a) == state(*b)) {
            let direction = state(run[0]);
            let (from, to) = (first + self.half, first + run.len() + self.half);
            first += run.len();
            if direction == 0.0 {
                rests += usize::from(run.len() as f64 * period_s >= MIN_REST_S);
                continue;
            }
            let speed = run.iter().fold(0.0, |top: f64, value| top.max(value.abs()));
            strokes.push(Stroke {
                from,
                to,
                direction,
                speed,
            });
        }
        self.rests = rests;
        self.reversals = strokes
            .windows(2)
            .filter(|pair| pair[0].direction != pair[1].direction)
            .count();
        self.strokes = strokes;
    }
}

/// Third differences below this part of a column's range, or of its largest value, are those of its numbers. Choices:
/// tables have eight digits, of which a count of a machine's encoder is more; and each of four is off by half the
/// last digit, times its weight.
const OF_DIGITS: f64 = 2e-8;
const OF_ARITHMETIC: f64 = 8.0 * f64::EPSILON;

/// Standard deviation of a position's noise, from its third differences: motion is smooth, noise is
/// not.
pub(crate) fn noise_of(column: &[f64]) -> f64 {
    let mut thirds: Vec<f64> = column
        .windows(4)
        .map(|four| (four[3] - 3.0 * four[2] + 3.0 * four[1] - four[0]).abs())
        .collect();
    // Axes that rest for most of a log tell nothing of rounding there but that of the numbers.
    let ends = column
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(*value), high.max(*value)]
        });
    let least = (OF_DIGITS * (ends[1] - ends[0])).max(OF_ARITHMETIC * ends[1].max(-ends[0]));
    thirds.retain(|third| *third > least);
    if thirds.is_empty() {
        return 0.0;
    }
    // Weights 1, 3, 3, 1 make 20 variances of one; the median of a normal's size is 0.6745.
    quantile(thirds, 0.5) / (0.674_489_750_196_082 * 20.0_f64.sqrt())
}

/// Variance of a position's noise over the windows that a fit uses, from its fourth differences: so little
/// is left of motion in them. Counts of a motion that is even to the count have none.
pub(crate) struct Noise {
    /// Sums of their squares up to each sample.
    squares: Vec<f64>,
    sum: f64,
    windows: usize,
}

/// Sum of the squares of the weights 1, -4, 6, -4, 1.
const OF_FOURTH: f64 = 70.0;

impl Noise {
    pub(crate) fn of(column: &[f64]) -> Noise {
        let mut sum = 0.0;
        let fourth = |w: &[f64]| w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4];
        let squares = column.windows(5).map(|five| {
            sum += fourth(five) * fourth(five) / OF_FOURTH;
            sum
        });
        Noise {
            squares: squares.collect(),
            sum: 0.0,
            windows: 0,
        }
    }

    /// Counts the window from one sample to another.
    pub(crate) fn add(&mut self, from: usize, to: usize) {
        let last = to.saturating_sub(4);
        if let (Some(first), Some(last_sum)) = (self.squares.get(from), self.squares.get(last))
            && last > from
        {
            self.sum += (last_sum - first) / (last - from) as f64;
            self.windows += 1;
        }
    }

    /// The mean over the windows.
    pub(crate) fn mean(&self) -> f64 {
        self.sum / self.windows.max(1) as f64
    }
}
