//! What the load's scale says beside the motor whatever the shaft does: lengths that differ a little
//! from the motor's (pitch of the screw, warmth, the scale's own error), and a reading that comes later
//! or earlier than the motor's.
//!
//! Both would be taken for gap and wind-up, since an axis slows down at the ends of its strokes and is
//! fast in one direction at a time. They are told while the motor drives the load on one flank:
//!
//! ```text
//! motor - load = of this stretch - scale x + late v + compliance (drive - inertia a)
//! ```
//!
//! Of the drive the motor keeps what speeds up its own inertia. In strokes that are sines place and acceleration are
//! one: there a scale is told only where it is more than what acceleration winds up the softest shaft by, as on the
//! wide and slow circle of a ballbar.

use super::squares::{Squares, left_alone};
use super::{Averages, Motion, Rates};
use crate::even::lagrange;
use crate::settings::LATENESS_S;
use lostmotion_base::math::quantile;
use serde::{Deserialize, Serialize};

/// Half windows for which the motor has to have driven the load in a stretch until its rows count. A
/// choice: behind a reversal the shaft winds up and the load bounces.
const SETTLES_WINDOWS: usize = 4;
/// Fewest rows of a stretch that counts.
const MIN_ROWS: usize = 4;
/// Part of the top acceleration that the motor may slow down with while it drives the load. A choice.
const DRIVES_SHARE: f64 = 0.02;
/// Part of the motor's speed that the load's may be off by while it follows. A choice.
const FOLLOWS_SHARE: f64 = 0.2;
/// Scatter of the speed within the stretches, in parts of the speed, from which on lateness is told. A choice:
/// at one speed it is the same as a gap, and what is left of settling would pass for it.
pub(crate) const VARIES_SHARE: f64 = 0.06;
/// Part of a column that the others have to leave for its coefficient to be told. A choice: in a motion of
/// one frequency place and acceleration are the same.
pub(crate) const ALONE_SHARE: f64 = 0.1;
/// The same below which two columns are one. A choice.
const SAME_SHARE: f64 = 1e-4;
/// Half intervals that a value has to be off zero by. A choice: nothing is taken off by chance.
const CERTAINLY: f64 = 2.0;
/// What it makes of the difference of motor and load, in parts of that difference's span, from which on it
/// matters. A choice.
pub(crate) const MATTERS_SHARE: f64 = 0.02;
/// The same of the scale, whose interval is narrow: a choice, about what intervals of large gaps are wide.
const SCALE_MATTERS_SHARE: f64 = 0.004;
/// Least lateness that is told, s. A choice: a row of an ordinary log is twice that.
const LEAST_LATE_S: f64 = LATENESS_S;
/// How far lateness may be off beside its scatter, s: viscous friction winds up the softest shafts as if the load
/// were so late.
const WIND_UP_S: f64 = 250e-6;
/// Part of the wind-up that may go with the place whatever it is from. A choice, of twice what damping does in clean
/// logs of short strokes.
const WIND_UP_SHARE: f64 = 0.02;
/// What an acceleration winds the shaft up by at most, s^2: a load on its shaft swings with 10 Hz at least. A choice:
/// large machines do with 20 to 40 Hz.
pub(crate) const MOST_GIVE_S2: f64 = 2.5e-4;
/// Rounds: what is found is taken off, and what is left is found.
const ROUNDS: usize = 3;

/// Times of four rows, in rows.
const FOUR_ROWS: [f64; 4] = [0.0, 1.0, 2.0, 3.0];

const PLACE: usize = 0;
const SPEED: usize = 1;
const ACCELERATION: usize = 2;
const DRIVE: usize = 3;
const COLUMNS: usize = 4;

/// How a load's scale is off the motor's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LoadOff {
    /// How much more than the motor it reads, in parts of the travel; zero where it is not told.
    pub scale: f64,
    /// 95 % interval.
    pub scale_interval: [f64; 2],
    /// How much later than the motor it is read, s; zero where it is not told.
    pub late_s: f64,
    /// 95 % interval.
    pub late_interval_s: [f64; 2],
}

/// Columns at even times in which the load is looked at.
pub(crate) struct Pair<'a> {
    pub(crate) period_s: f64,
    pub(crate) motor: &'a [f64],
    pub(crate) load: &'a [f64],
    /// Empty where it was not logged.
    pub(crate) drive: &'a [f64],
    /// Samples in the place of missing rows; empty for a whole log.
    pub(crate) lost: &'a [bool],
}

/// A load that has been looked at.
pub(crate) struct Looked {
    /// The load put right; `None` where it certainly is not off, or that cannot be told.
    pub(crate) right: Option<PutRight>,
    /// How large a scale may be that was not taken off, either way, in parts of the travel; zero where one was,
    /// and where the motion does not tell it.
    pub(crate) unseen_scale: f64,
}

/// A load that has been put right.
pub(crate) struct PutRight {
    pub(crate) off: LoadOff,
    pub(crate) load: Vec<f64>,
    pub(crate) lost: Vec<bool>,
}

impl Pair<'_> {
    /// Finds how the load is off and takes it off where that is certain and matters.
    pub(crate) fn put_right(&self, motion: &Motion) -> Looked {
        let mut off = LoadOff::default();
        let mut right: Option<PutRight> = None;
        let mut unseen_scale = 0.0;
        for _ in 0..ROUNDS {
            let (found, unseen) = match &right {
                None => self.find(motion),
                Some(before) => Pair {
                    load: &before.load,
                    lost: &before.lost,
                    ..*self
                }
                .find(motion),
            };
            if off.scale == 0.0 {
                unseen_scale = unseen;
            }
            if found == LoadOff::default() {
                break;
            }
            off = off.and(&found);
            let (load, lost) = self.without(&off);
            right = Some(PutRight { off, load, lost });
        }
        Looked {
            right,
            unseen_scale,
        }
    }

    /// How the load is off where that is certain and matters, and how large a scale may be that is not among it.
    fn find(&self, motion: &Motion) -> (LoadOff, f64) {
        let none = (LoadOff::default(), 0.0);
        let difference: Vec<f64> = self
            .motor
            .iter()
            .zip(self.load)
            .map(|(m, l)| m - l)
            .collect();
        let stretches = self.stretches(motion, &difference);
        let mut squares = Squares::<COLUMNS>::new(self.motor.len());
        let mut sums = [[0.0; COLUMNS]; COLUMNS];
        let (mut count, mut speeds) = (0.0, 0.0);
        for (at, rows) in &stretches {
            let size = rows.len() as f64;
            // Each stretch has its own flank: only what changes within it counts.
            let mean: [f64; COLUMNS + 1] =
                std::array::from_fn(|i| rows.iter().map(|row| row[i]).sum::<f64>() / size);
            for row in rows {
                let own: [f64; COLUMNS] = std::array::from_fn(|i| row[i] - mean[i]);
                squares.add(*at, own, row[COLUMNS] - mean[COLUMNS]);
                for i in 0..COLUMNS {
                    (0..COLUMNS).for_each(|j| sums[i][j] += own[i] * own[j]);
                }
                count += 1.0;
                speeds += row[SPEED] * row[SPEED];
            }
        }
        if count == 0.0 {
            return none;
        }
        let stands_alone = |column: usize, used: &[bool; COLUMNS], share: f64| {
            let own = sums[column][column];
            own > 0.0 && left_alone(&sums, column, used) > share * own
        };
        let mut used = [false; COLUMNS];
        used[DRIVE] = sums[DRIVE][DRIVE] > 0.0;
        used[ACCELERATION] = stands_alone(ACCELERATION, &used, SAME_SHARE);
        used[PLACE] = sums[PLACE][PLACE] > 0.0;
        // The motor's viscous friction is in the drive, too, so that the speed belongs to the fit even where it tells
        // no lateness.
        used[SPEED] = stands_alone(SPEED, &used, SAME_SHARE);
        used[PLACE] = used[PLACE] && stands_alone(PLACE, &used, ALONE_SHARE);
        let bare = [true, used[SPEED], false, false];
        let is_of_one_frequency = !used[PLACE] && stands_alone(PLACE, &bare, ALONE_SHARE);
        if is_of_one_frequency {
            used = bare;
        }
        let tells_late = sums[SPEED][SPEED] > VARIES_SHARE * VARIES_SHARE * speeds
            && stands_alone(SPEED, &used, ALONE_SHARE);
        let Some(fit) = squares.solve(&used) else {
            return none;
        };
        let mut figures = fit.figures;
        let [low, high] = figures[PLACE].interval;
        let mut unseen_at_most = low.abs().max(high.abs());
        if is_of_one_frequency {
            // The place has what the acceleration makes, too.
            let rate_square = (sums[ACCELERATION][ACCELERATION] / sums[PLACE][PLACE]).sqrt();
            figures[PLACE] = figures[PLACE].widened(MOST_GIVE_S2 * rate_square);
        } else if used[PLACE] {
            // What the shaft's damping and the load's bouncing do beside the wind-up would pass for a scale where
            // little of the place stands alone.
            let wind_up = [ACCELERATION, DRIVE].map(|i| {
                [ACCELERATION, DRIVE]
                    .map(|j| fit.x[i] * fit.x[j] * sums[i][j])
                    .iter()
                    .sum::<f64>()
            });
            let wind_up = wind_up.iter().sum::<f64>().max(0.0);
            let alone = left_alone(&sums, PLACE, &used);
            figures[PLACE] = figures[PLACE].widened(WIND_UP_SHARE * (wind_up / alone).sqrt());
            let [low, high] = figures[PLACE].interval;
            unseen_at_most = low.abs().max(high.abs());
        }
        // Lateness of 0.3 ms at 300 mm/s makes more than most gaps: a scale that hides beside it matters all the
        // same.
        let left = self.without_part(
            &difference,
            motion,
            [fit.x[PLACE], if tells_late { fit.x[SPEED] } else { 0.0 }],
        );
        let width = span(&difference).min(span(&left));
        let is_told = |at: usize, size: f64, floor: f64, share: f64| {
            let figure = figures[at];
            let half = 0.5 * (figure.interval[1] - figure.interval[0]);
            used[at]
                && figure.value.abs() > CERTAINLY * half
                && figure.value.abs() > floor
                && figure.value.abs() * size > share * width
        };
        let (mut off, mut unseen) = none;
        let [low, high] = figures[PLACE].interval;
        if is_told(PLACE, span(self.motor), 0.0, SCALE_MATTERS_SHARE) {
            (off.scale, off.scale_interval) = (-fit.x[PLACE], [-high, -low]);
        } else if used[PLACE] {
            unseen = unseen_at_most;
        }
        if tells_late && is_told(SPEED, motion.top_speed, LEAST_LATE_S, MATTERS_SHARE) {
            let late = figures[SPEED].widened(WIND_UP_S);
            (off.late_s, off.late_interval_s) = (late.value, late.interval);
        }
        (off, unseen)
    }

    /// The position difference less what so much for each unit of place and of speed makes of it.
    fn without_part(&self, difference: &[f64], motion: &Motion, of: [f64; 2]) -> Vec<f64> {
        let half = motion.half;
        let rates = Rates::new(self.motor, half, self.period_s);
        let inner = half..self.motor.len().saturating_sub(half);
        inner
            .map(|at| difference[at] - of[0] * self.motor[at] - of[1] * rates.velocity(at))
            .collect()
    }

    /// Rows of each stretch in which the motor drives the load one way, with its first sample.
    fn stretches(
        &self,
        motion: &Motion,
        difference: &[f64],
    ) -> Vec<(usize, Vec<[f64; COLUMNS + 1]>)> {
        let half = motion.half;
        let [motor, load] = [self.motor, self.load].map(|of| Rates::new(of, half, self.period_s));
        let places = Averages::new(self.motor, half);
        let apart = Averages::new(difference, half);
        let drive = (!self.drive.is_empty()).then(|| Averages::new(self.drive, half));
        let mut stretches: Vec<(usize, Vec<[f64; COLUMNS + 1]>)> = Vec::new();
        let (mut side, mut driven) = (0.0, 0);
        for at in (half..self.motor.len().saturating_sub(half)).step_by(half) {
            let (speed, acceleration) = (motor.velocity(at), motor.acceleration(at));
            let is_whole = self
                .lost
                .get(at - half..=at + half)
                .is_none_or(|lost| !lost.contains(&true));
            let drives = speed.abs() > motion.rest_speed
                && acceleration * speed.signum() >= -DRIVES_SHARE * motion.top_acceleration
                && (load.velocity(at) - speed).abs() < FOLLOWS_SHARE * speed.abs();
            if !drives || !is_whole || speed * side < 0.0 {
                (side, driven) = (if drives && is_whole { speed } else { 0.0 }, 0);
                continue;
            }
            side = speed;
            driven += 1;
            if driven < SETTLES_WINDOWS {
                continue;
            }
            if driven == SETTLES_WINDOWS {
                stretches.push((at, Vec::new()));
            }
            if let Some((_, rows)) = stretches.last_mut() {
                let drive = drive.as_ref().map_or(0.0, |drive| drive.mean(at));
                rows.push([places.mean(at), speed, acceleration, drive, apart.mean(at)]);
            }
        }
        // The last row of a stretch already reaches into what ends it.
        stretches.iter_mut().for_each(|(_, rows)| {
            rows.pop();
        });
        stretches.retain(|(_, rows)| rows.len() >= MIN_ROWS);
        stretches
    }

    /// The load as the motor's clock and lengths have it, and the samples that are then lost.
    pub(crate) fn without(&self, off: &LoadOff) -> (Vec<f64>, Vec<bool>) {
        let base = self.motor.first().copied().unwrap_or(0.0);
        let own = |value: f64| base + (value - base) / (1.0 + off.scale);
        let rows = off.late_s / self.period_s;
        if rows == 0.0 || self.load.len() < 4 {
            return (
                self.load.iter().map(|value| own(*value)).collect(),
                self.lost.to_vec(),
            );
        }
        let last = self.load.len() - 4;
        let (mut load, mut lost) = (Vec::new(), Vec::new());
        for at in 0..self.load.len() {
            let place = at as f64 + rows;
            // A float-to-int cast saturates at zero.
            let first = ((place - 1.0).floor() as usize).min(last);
            let beyond = place < 0.0 || place > (self.load.len() - 1) as f64;
            let touched = self
                .lost
                .get(first..first + 4)
                .is_some_and(|lost| lost.contains(&true));
            lost.push(beyond || touched);
            let four = &self.load[first..first + 4];
            load.push(own(lagrange(
                &FOUR_ROWS,
                four,
                1,
                (place - first as f64).clamp(0.0, 3.0),
            )));
        }
        (load, lost)
    }
}

impl LoadOff {
    /// The same with the lateness of another.
    #[must_use]
    pub(crate) fn read_as(self, late: &LoadOff) -> LoadOff {
        LoadOff {
            late_s: late.late_s,
            late_interval_s: late.late_interval_s,
            ..self
        }
    }

    /// What is found of a load that has already been put right by this.
    fn and(&self, more: &LoadOff) -> LoadOff {
        let add = |value: f64, interval: [f64; 2], by: f64, of: [f64; 2]| {
            // The last round tells how certain the sum is.
            if by == 0.0 {
                (value, interval)
            } else {
                (value + by, of.map(|end| end + value))
            }
        };
        let (scale, scale_interval) = add(
            self.scale,
            self.scale_interval,
            more.scale,
            more.scale_interval,
        );
        let (late_s, late_interval_s) = add(
            self.late_s,
            self.late_interval_s,
            more.late_s,
            more.late_interval_s,
        );
        LoadOff {
            scale,
            scale_interval,
            late_s,
            late_interval_s,
        }
    }
}

/// Width of a column without its outer hundredths.
fn span(values: &[f64]) -> f64 {
    quantile(values.to_vec(), 0.99) - quantile(values.to_vec(), 0.01)
}
