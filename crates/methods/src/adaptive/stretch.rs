//! What a steady stretch says of the load behind an elastic shaft.
//!
//! A load of some hundred kilograms on a screw rings at 20 to 150 Hz, and in the 8 ms of a mean it
//! does not accelerate as its motor does:
//! ```text
//! T = J_L (alpha - T''/k) + b_L w + T_f sign(w) + T_const        T: torque behind the motor, N m;   k: shaft, N m/rad
//! ```
//! Averaged once more with the same triangle, of which the second difference of three means in a row
//! is exact, no derivative has to be taken. Means at the ends of a stretch have no neighbours and do not
//! count, nor do those beside one without contact, of a load that has just come or is about to go: a
//! mass that a soft shaft takes along overshoots to twice the torque. A shaft that rings so fast that the
//! triangle takes the ringing away counts as stiff; short ramps are all of their load's inertia then.

use super::load_filter::{LoadVector, VISCOUS_SPEED};
use super::watch::Motor;
use serde::{Deserialize, Serialize};

/// Standard deviations by which an acceleration has to exceed the encoder's noise. A choice.
const CLEAR_DEVIATIONS: f64 = 4.0;

/// Frequency of the load on its shaft below which what it winds up counts, rad/s: 80 Hz, of which the
/// triangle leaves two thirds. Tuned: with it for all shafts loads above 100 Hz were learned later and less
/// well (the fixed sample: 3.2 % of `none` in the median, 1.4 before).
const SOFT_RAD_S: f64 = 500.0;

/// Means over two blocks: torque behind the motor (N m), speed (rad/s), acceleration (rad/s2) of
/// the motor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Mean {
    pub(super) torque: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
}

/// What the load filter takes: its regressors, the torque over the rated one, the variance of the
/// first regressor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) regressors: LoadVector,
    pub(super) torque: f64,
    pub(super) noise: f64,
}

/// The shaft, and the time between two means.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shaft {
    /// N m/rad.
    pub(super) stiffness: f64,
    /// s.
    pub(super) span: f64,
    /// Of the load as it is known, kg m2.
    pub(super) inertia: f64,
}

impl Shaft {
    fn is_soft(&self) -> bool {
        self.stiffness < SOFT_RAD_S * SOFT_RAD_S * self.inertia
    }
}

/// The last means of a stretch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Stretch {
    /// The last two, the latest last.
    means: [Option<Mean>; 2],
    /// What waits until the mean after it shows a load in contact, too.
    next: Option<Row>,
    /// Whether the mean that comes is the first after one without contact.
    meets: bool,
}

impl Stretch {
    /// A mean without contact.
    pub(super) fn lose(&mut self) {
        *self = Stretch {
            meets: true,
            ..Stretch::default()
        };
    }

    /// Ends, with the load in contact; what is left to be learned of it.
    pub(super) fn end(&mut self) -> Option<Row> {
        std::mem::take(self).next
    }

    /// A mean of a load in contact; what is to be learned.
    pub(super) fn take(&mut self, now: Mean, motor: &Motor, shaft: Shaft) -> Option<Row> {
        if !shaft.is_soft() {
            *self = Stretch::default();
            return Some(now.alone(motor, shaft));
        }
        let ready = self.next.take();
        if std::mem::replace(&mut self.meets, false) {
            return None;
        }
        let means = self.means;
        self.means = [means[1], Some(now)];
        if let [Some(first), Some(middle)] = means {
            self.next = Some(Mean::of_three([&first, &middle, &now], motor, shaft));
        }
        ready
    }
}

impl Mean {
    /// As of a stiff shaft.
    fn alone(&self, motor: &Motor, shaft: Shaft) -> Row {
        // the variance of a second difference is six times that of a position
        self.row(6.0 * per_s4(motor, shaft), motor)
    }

    /// The middle one of three in a row, averaged once more with their triangle.
    fn of_three([first, middle, last]: [&Mean; 3], motor: &Motor, shaft: Shaft) -> Row {
        // of what the triangle leaves of a mean the second difference is a twelfth
        let twice = |of: fn(&Mean) -> f64| (of(first) + 10.0 * of(middle) + of(last)) / 12.0;
        let square = shaft.span * shaft.span;
        let winds = (first.torque - 2.0 * middle.torque + last.torque) / (square * shaft.stiffness);
        let mean = Mean {
            torque: twice(|mean| mean.torque),
            speed: middle.speed,
            acceleration: twice(|mean| mean.acceleration) - winds,
        };
        // the motor's own acceleration is in the torque: a fourth difference, seventy times
        let twisted = motor.inertia / (shaft.stiffness * square);
        mean.row(
            (6.0 + 70.0 * twisted * twisted) * per_s4(motor, shaft),
            motor,
        )
    }

    /// `noise`: variance of the acceleration, which counts as zero where it does not exceed it.
    fn row(&self, noise: f64, motor: &Motor) -> Row {
        let square = self.acceleration * self.acceleration;
        let seen = if square > CLEAR_DEVIATIONS * CLEAR_DEVIATIONS * noise {
            self.acceleration
        } else {
            0.0
        };
        // regressors in parts of the rated torque
        let unit = motor.inertia / motor.rated_torque;
        Row {
            regressors: [
                seen * unit,
                self.speed / VISCOUS_SPEED,
                self.speed.signum(),
                1.0,
            ],
            torque: self.torque / motor.rated_torque,
            noise: noise * unit * unit,
        }
    }
}

/// Variance of a position over the fourth power of the time between two means.
fn per_s4(motor: &Motor, shaft: Shaft) -> f64 {
    let square = shaft.span * shaft.span;
    motor.noise * motor.noise / (square * square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::math::sin;

    const MOTOR: Motor = Motor {
        torque_constant: 1.0,
        inertia: 0.002,
        viscous: 0.0,
        rated_torque: 10.0,
        noise: 1e-9,
    };

    /// A load of 0.006 kg m2 with friction of 0.5 N m that rings at `frequency` Hz behind a motor at a steady
    /// 50 rad/s; `count` means of it, in closed form.
    fn ringing(frequency: f64, count: u32) -> (Shaft, Vec<Mean>) {
        let (inertia, friction, ringing_nm) = (0.006, 0.5, 0.3);
        let rate = std::f64::consts::TAU * frequency;
        let shaft = Shaft {
            stiffness: inertia * rate * rate,
            span: 4e-3,
            inertia,
        };
        // a triangle over twice the span leaves of a sine the square of this
        let half = 0.5 * rate * shaft.span;
        let left = sin(half) / half;
        let means = (0..count)
            .map(|n| Mean {
                torque: friction
                    + left * left * ringing_nm * sin(rate * shaft.span * f64::from(n) + 0.3),
                speed: 50.0,
                acceleration: 0.0,
            })
            .collect();
        (shaft, means)
    }

    /// How far torque is from inertia times acceleration and friction, N m.
    fn misses(row: &Row) -> f64 {
        let [acceleration, ..] = row.regressors;
        MOTOR.rated_torque * (row.torque - acceleration * 0.006 / MOTOR.inertia) - 0.5
    }

    #[test]
    fn what_the_shaft_winds_up_is_taken_off() {
        for (frequency, most) in [(18.0, 2e-4), (40.0, 3e-3), (79.0, 0.02)] {
            let (shaft, means) = ringing(frequency, 30);
            let mut stretch = Stretch::default();
            let worst = means
                .iter()
                .filter_map(|mean| stretch.take(*mean, &MOTOR, shaft))
                .map(|row| misses(&row).abs())
                .fold(0.0, f64::max);
            let stiff = means
                .iter()
                .map(|mean| misses(&mean.alone(&MOTOR, shaft)).abs())
                .fold(0.0, f64::max);
            assert!(
                worst < most && worst > 0.0 && stiff > 5.0 * worst,
                "{frequency} Hz: {worst} {stiff}"
            );
        }
    }

    #[test]
    fn means_beside_one_without_contact_do_not_count() {
        let (shaft, means) = ringing(18.0, 10);
        let mut stretch = Stretch::default();
        let mut take = |n: usize| stretch.take(means[n], &MOTOR, shaft).is_some();
        // the middle one of three once the fourth is in contact
        assert_eq!([0, 1, 2, 3].map(&mut take), [false, false, false, true]);
        stretch.lose();
        let mut take = |n: usize| stretch.take(means[n], &MOTOR, shaft).is_some();
        assert_eq!(
            [4, 5, 6, 7, 8].map(&mut take),
            [false, false, false, false, true]
        );
        // a reversal ends it: what waits
        assert!(stretch.end().is_some() && stretch.end().is_none());
        // each of a stiff one
        let (shaft, means) = ringing(90.0, 3);
        let mut take = |n: usize| stretch.take(means[n], &MOTOR, shaft).is_some();
        assert_eq!([0, 1, 2].map(&mut take), [true; 3]);
    }
}
