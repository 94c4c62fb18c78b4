//! A first look at the gap through noise: torque against position difference.
//!
//! In contact the torque grows with the position difference `y` from the flank on, in the gap it is
//! zero: `T = k z(y - o)` with the dead zone `z(u) = sign(u) max(|u| - b, 0)`. The noise of a log is
//! nearly all in `T` (the current's), so that least squares of `T` on `y` (the reverse of the fit's
//! own regression) is not biased by it. The fit takes from here which flank a window presses on, no
//! figure.

use crate::window::WindowSample;
use lostmotion_base::math::quantile;

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
        let differences = || pairs.iter().map(|pair| pair.0).collect();
        let [low, high] =
            [SPIKE_SHARE, 1.0 - SPIKE_SHARE].map(|share| quantile(differences(), share));
        let mut best = Slope::of(&pairs, 0.0, 0.0);
        let mut reach = 0.25 * (high - low);
        let (mut half_gap, mut offset) = (reach, 0.5 * (high + low));
        // The cost is not convex in the edges: a coarse grid first, then ever finer ones.
        for _ in 0..GRIDS {
            let (about_gap, about_offset) = (half_gap, offset);
            best = Slope::of(&pairs, half_gap, offset);
            for i in -GRID_STEPS..=GRID_STEPS {
                for j in -GRID_STEPS..=GRID_STEPS {
                    let at = |about: f64, step: i32| {
                        about + reach * f64::from(step) / f64::from(GRID_STEPS)
                    };
                    let (b, o) = (at(about_gap, i).max(0.0), at(about_offset, j));
                    let slope = Slope::of(&pairs, b, o);
                    if slope.rest < best.rest {
                        (best, half_gap, offset) = (slope, b, o);
                    }
                }
            }
            reach *= GRID_SHRINK;
        }
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
