//! What the motion inside the tube is to have least of: a power of the jerk and the acceleration of
//! each joint.

use super::LinearJoint;
use crate::condition::tube::fit::Bending;
use lostmotion_base::vec::{Vec3, dot, scale};

/// Weight of the square beside the power. A choice: keeps what has no jerk regular.
const SQUARE_PART: f64 = 1e-3;

/// A power of the jerk and the acceleration of each joint.
#[derive(Clone, Debug)]
pub(super) struct Jerks {
    /// Of each joint in units of its limit, per mm/s3 along X, Y and Z.
    rows: Vec<Vec3>,
    /// The same of the acceleration.
    seconds: Vec<Vec3>,
    /// Half of the power.
    pub(super) half_power: u32,
}

impl Jerks {
    pub(super) fn new(joints: &[LinearJoint], half_power: u32) -> Jerks {
        let rows = |limit: fn(&LinearJoint) -> f64| {
            joints
                .iter()
                .map(|joint| scale(joint.per_mm, 1.0 / limit(joint)))
                .collect()
        };
        Jerks {
            rows: rows(|joint| joint.jerk),
            seconds: rows(|joint| joint.acceleration),
            half_power,
        }
    }

    /// The power, and the jerk to it but two.
    #[inline(always)]
    fn power(&self, jerk: f64) -> (f64, f64) {
        let square = jerk * jerk;
        let mut but_two = 1.0;
        for _ in 1..self.half_power {
            but_two *= square;
        }
        let power = f64::from(2 * self.half_power);
        (power, but_two)
    }

    /// The powers of the jerk and of the acceleration.
    #[inline(always)]
    pub(super) fn powers(&self, third: &Vec3, second: &Vec3) -> [f64; 2] {
        [self.of(&self.rows, third), self.of(&self.seconds, second)]
    }

    #[inline(always)]
    fn of(&self, rows: &[Vec3], derivative: &Vec3) -> f64 {
        rows.iter()
            .map(|row| {
                let part = dot(*row, *derivative);
                let (power, but_two) = self.power(part);
                (but_two / power + 0.5 * SQUARE_PART) * part * part
            })
            .sum()
    }

    #[inline(always)]
    fn slopes_of<const N: usize>(
        &self,
        rows: &[Vec3],
        axes: [usize; N],
        derivative: &Vec3,
    ) -> ([f64; N], [[f64; N]; N]) {
        let (mut gradient, mut second) = ([0.0; N], [[0.0; N]; N]);
        for row in rows {
            let part = dot(*row, *derivative);
            let (power, but_two) = self.power(part);
            let (slope, bend) = (
                (but_two + SQUARE_PART) * part,
                (power - 1.0) * but_two + SQUARE_PART,
            );
            let row = axes.map(|axis| row[axis]);
            for i in 0..N {
                gradient[i] += slope * row[i];
                for j in i..N {
                    second[i][j] += bend * row[i] * row[j];
                }
            }
        }
        (gradient, second)
    }
}

impl Bending for &Jerks {
    #[inline(always)]
    fn value(&self, third: &Vec3) -> f64 {
        self.of(&self.rows, third)
    }

    #[inline(always)]
    fn slopes<const N: usize>(&self, axes: [usize; N], third: &Vec3) -> ([f64; N], [[f64; N]; N]) {
        self.slopes_of(&self.rows, axes, third)
    }

    const HEEDS_SECOND: bool = true;

    #[inline(always)]
    fn second_value(&self, second: &Vec3) -> f64 {
        self.of(&self.seconds, second)
    }

    #[inline(always)]
    fn second_slopes<const N: usize>(
        &self,
        axes: [usize; N],
        second: &Vec3,
    ) -> ([f64; N], [[f64; N]; N]) {
        self.slopes_of(&self.seconds, axes, second)
    }

    const IS_SQUARE: bool = false;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gradient and second derivatives from the diagonal on against differences of the value, on joints that are no axes.
    #[test]
    fn slopes_are_those_of_the_value() {
        let joint = |per_mm: Vec3| LinearJoint {
            per_mm,
            velocity: 100.0,
            acceleration: 2.0,
            jerk: 1.5,
        };
        let joints = [joint([1.0, 1.0, 0.0]), joint([1.0, -1.0, 0.2])];
        for half_power in [2, 3, 6] {
            let jerks = &Jerks::new(&joints, half_power);
            let at = [0.7, -0.4, 0.9];
            let (gradient, second) = jerks.slopes([0, 1, 2], &at);
            let moved = |axis: usize, by: f64| {
                let mut moved = at;
                moved[axis] += by;
                moved
            };
            for axis in 0..3 {
                let h = 1e-5;
                let (up, down) = (moved(axis, h), moved(axis, -h));
                let slope = (jerks.value(&up) - jerks.value(&down)) / (2.0 * h);
                assert!(
                    (gradient[axis] - slope).abs() < 1e-7,
                    "{slope} {gradient:?}"
                );
                let [above, below] = [up, down].map(|at| jerks.slopes([0, 1, 2], &at).0);
                for (other, bend) in second[axis].iter().enumerate().skip(axis) {
                    let slope = (above[other] - below[other]) / (2.0 * h);
                    assert!(
                        (bend - slope).abs() < 1e-6 * bend.abs().max(1.0),
                        "{slope} {bend}"
                    );
                }
            }
        }
    }
}
