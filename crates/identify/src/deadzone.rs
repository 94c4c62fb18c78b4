//! A first look at the gap through noise: torque against position difference.
//!
//! In contact the torque grows with the position difference `y` from the flank on, in the gap it is
//! zero: `T = k z(y - o)` with the dead zone `z(u) = sign(u) max(|u| - b, 0)`. The noise of a log is
//! nearly all in `T` (the current's), so that least squares of `T` on `y` (the reverse of the fit's
//! own regression) is not biased by it. The fit takes from here which flank a window presses on, no
//! figure.

use crate::{huber::Regression, window::WindowSample};
use lostmotion_base::{math::quantile, vec::dot};

/// Most windows that are looked at. A choice: the edges of the gap are needed to a few parts in a
/// hundred of the wind-up only.
const MAX_WINDOWS: usize = 4000;
/// Shares of the windows outside the span that is searched, on either end: spikes.
const SPIKE_SHARE: f64 = 2e-3;
/// Grid steps to either side of the best point of the grid before.
const GRID_STEPS: i32 = 3;
/// Grids, each finer than the one before by [`GRID_SHRINK`]: in all by a factor of a thousand.
const GRIDS: usize = 14;
/// Size of a grid over that of the one before. A choice: more than a step of the one before, so that
/// a valley between two grid points is not lost.
const GRID_SHRINK: f64 = 0.6;
/// Fewest windows from which a zone is taken. A choice: a quarter of a second of a usual log.
const MIN_WINDOWS: usize = 100;
/// Least value of Student's t of the slope for which the zone is believed. A choice: pure noise
/// reaches some 4 where the edges are chosen for it.
const MIN_SLOPE_T: f64 = 8.0;

/// Dead zone in the torque over the position difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deadzone {
    half_gap_rad: f64,
    offset_rad: f64,
    stiffness_nm_per_rad: f64,
    /// Sum of squares of the torque that it leaves, (N m)^2.
    rest: f64,
}

impl Deadzone {
    /// The zone that explains most of the torque; `None` if none explains any.
    pub(crate) fn fit(windows: &[WindowSample]) -> Option<Self> {
        let certain = windows
            .iter()
            .filter(|window| window.one_way && window.whole);
        let step = windows.len().div_ceil(MAX_WINDOWS).max(1);
        let pairs: Vec<(f64, f64)> = certain
            .step_by(step)
            .map(|window| (window.difference_rad, window.torque_nm))
            .collect();
        if pairs.len() < MIN_WINDOWS {
            return None;
        }
        let differences: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
        let (half_gap, offset) = search(&differences, |b, o| Slope::of(&pairs, b, o).rest);
        let best = Slope::of(&pairs, half_gap, offset);
        (best.value > 0.0 && best.student_t > MIN_SLOPE_T).then_some(Self {
            half_gap_rad: half_gap,
            offset_rad: offset,
            stiffness_nm_per_rad: best.value,
            rest: best.rest,
        })
    }

    /// Whether this zone leaves less of the same torques than another.
    pub(crate) fn explains_more_than(&self, other: &Self) -> bool {
        self.rest < other.rest
    }

    /// Contact torque that goes with a position difference, N m.
    pub(crate) fn torque(&self, difference_rad: f64) -> f64 {
        self.stiffness_nm_per_rad * beyond(difference_rad - self.offset_rad, self.half_gap_rad)
    }
}

/// The half gap and the offset of least cost, over zones within the span of these position
/// differences.
fn search(differences: &[f64], cost: impl Fn(f64, f64) -> f64) -> (f64, f64) {
    let [low, high] =
        [SPIKE_SHARE, 1.0 - SPIKE_SHARE].map(|share| quantile(differences.to_vec(), share));
    let mut reach = 0.25 * (high - low);
    let (mut half_gap, mut offset) = (reach, 0.5 * (high + low));
    // The cost is not convex in the edges: a coarse grid first, then ever finer ones.
    for _ in 0..GRIDS {
        let (about_gap, about_offset) = (half_gap, offset);
        let mut least = cost(half_gap, offset);
        for i in -GRID_STEPS..=GRID_STEPS {
            for j in -GRID_STEPS..=GRID_STEPS {
                let at =
                    |about: f64, step: i32| about + reach * f64::from(step) / f64::from(GRID_STEPS);
                let (b, o) = (at(about_gap, i).max(0.0), at(about_offset, j));
                let rest = cost(b, o);
                if rest < least {
                    (least, half_gap, offset) = (rest, b, o);
                }
            }
        }
        reach *= GRID_SHRINK;
    }
    (half_gap, offset)
}

/// What a log tells of the motor before anything is known of it, torques in parts of the torque
/// constant: `i = k z(y - o) + J alpha + b w + f sign(w) + constant` over all windows. In the gap
/// the shaft carries nothing, so that the current there is the motor's own. Its noise is in the
/// target alone, so that nothing is biased by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotorGuess {
    /// J over the torque constant.
    pub(crate) inertia_kgm2: f64,
    /// b over the torque constant.
    pub(crate) viscous_nm_s_per_rad: f64,
    /// f over the torque constant.
    pub(crate) coulomb_nm: f64,
}

impl MotorGuess {
    /// The motor that explains most of the current, with windows whose torque is the current;
    /// `None` if there are too few.
    pub(crate) fn of(windows: &[WindowSample]) -> Option<Self> {
        let step = windows.len().div_ceil(MAX_WINDOWS).max(1);
        let certain: Vec<&WindowSample> = windows
            .iter()
            .filter(|window| window.one_way && window.whole)
            .step_by(step)
            .collect();
        if certain.len() < MIN_WINDOWS {
            return None;
        }
        let own = |w: &WindowSample| {
            [
                w.acceleration_rad_s2,
                w.velocity_rad_s,
                w.velocity_rad_s.signum(),
                1.0,
            ]
        };
        // The motor's own columns are the same for every zone: made orthonormal and taken out once
        // (Frisch and Waugh 1933), each zone costs a few sums.
        let mut columns: Vec<[f64; 4]> = certain.iter().map(|w| own(w)).collect();
        orthonormalise(&mut columns);
        let mut torques: Vec<f64> = certain.iter().map(|w| w.torque_nm).collect();
        let mut overlap = [0.0; 4];
        for (row, torque) in columns.iter().zip(&torques) {
            (0..4).for_each(|j| overlap[j] += row[j] * torque);
        }
        for (row, torque) in columns.iter().zip(&mut torques) {
            *torque -= dot(overlap, *row);
        }
        let cost = |half_gap: f64, offset: f64| {
            let (mut xx, mut xy, mut overlap) = (0.0, 0.0, [0.0; 4]);
            for ((window, torque), row) in certain.iter().zip(&torques).zip(&columns) {
                let depth = beyond(window.difference_rad - offset, half_gap);
                xx += depth * depth;
                xy += depth * torque;
                (0..4).for_each(|j| overlap[j] += row[j] * depth);
            }
            let left = xx - dot(overlap, overlap);
            // What the motor's own columns explain of the zone is none of its merit.
            if left > 1e-9 * xx && xy > 0.0 {
                -xy * xy / left
            } else {
                0.0
            }
        };
        let differences: Vec<f64> = certain.iter().map(|w| w.difference_rad).collect();
        let (half_gap, offset) = search(&differences, cost);
        let [_, inertia, viscous, coulomb, _] = Regression {
            rows: certain
                .iter()
                .map(|w| {
                    let [a, b, c, d] = own(w);
                    [beyond(w.difference_rad - offset, half_gap), a, b, c, d]
                })
                .collect(),
            targets: certain.iter().map(|w| w.torque_nm).collect(),
            nonnegative: [true, true, true, true, false],
        }
        .least_squares();
        Some(Self {
            inertia_kgm2: inertia,
            viscous_nm_s_per_rad: viscous,
            coulomb_nm: coulomb,
        })
    }
}

/// Gram and Schmidt over the columns, an empty one left out.
fn orthonormalise(rows: &mut [[f64; 4]]) {
    for j in 0..4 {
        for i in 0..j {
            let overlap: f64 = rows.iter().map(|row| row[i] * row[j]).sum();
            rows.iter_mut().for_each(|row| row[j] -= overlap * row[i]);
        }
        let norm = rows.iter().map(|row| row[j] * row[j]).sum::<f64>().sqrt();
        rows.iter_mut()
            .for_each(|row| row[j] = if norm > 0.0 { row[j] / norm } else { 0.0 });
    }
}

/// The dead zone function.
fn beyond(difference: f64, half_gap: f64) -> f64 {
    difference - difference.clamp(-half_gap, half_gap)
}

/// Least squares of the torque on the dead zone's output.
struct Slope {
    value: f64,
    /// Sum of squares that it leaves.
    rest: f64,
    student_t: f64,
}

impl Slope {
    fn of(pairs: &[(f64, f64)], half_gap: f64, offset: f64) -> Self {
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (difference, torque) in pairs {
            let depth = beyond(difference - offset, half_gap);
            xx += depth * depth;
            xy += depth * torque;
            yy += torque * torque;
        }
        // A shaft does not pull where it is pushed.
        let value = if xx > 0.0 { (xy / xx).max(0.0) } else { 0.0 };
        let rest = (yy - value * xy).max(0.0);
        Slope {
            value,
            rest,
            student_t: value * (xx * pairs.len() as f64 / rest.max(f64::MIN_POSITIVE)).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::Random;

    fn windows(k: f64, half_gap: f64) -> Vec<WindowSample> {
        let mut random = Random::new(5);
        (0..3000)
            .map(|_| {
                let difference_rad = 0.3 + random.between(-2.0, 2.0);
                WindowSample {
                    position_rad: 0.0,
                    difference_rad,
                    rate_rad_s: 0.0,
                    acceleration_rad_s2: 0.0,
                    velocity_rad_s: 0.0,
                    torque_nm: k * beyond(difference_rad - 0.3, half_gap) + random.normal(),
                    one_way: true,
                    whole: true,
                }
            })
            .collect()
    }

    #[test]
    fn the_edges_are_found_through_noise() {
        let zone = Deadzone::fit(&windows(2.0, 1.0)).unwrap();
        assert!((zone.half_gap_rad - 1.0).abs() < 0.1, "{zone:?}");
        assert!((zone.offset_rad - 0.3).abs() < 0.1, "{zone:?}");
        assert!(zone.torque(0.3).abs() < 1e-300 && zone.torque(2.3) > 1.0);
    }

    #[test]
    fn noise_alone_is_no_zone() {
        assert_eq!(Deadzone::fit(&windows(0.0, 1.0)), None);
        assert_eq!(Deadzone::fit(&[]), None);
    }
}
