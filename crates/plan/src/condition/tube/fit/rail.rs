//! An end of a spline with direction and curvature given, and the pace open.

use super::banded::SystemRow;
use super::share::Share;
use crate::condition::tube::spline::ORDER;
use lostmotion_base::vec::{Vec3, along, dot, scale, sub};

/// Stiffness of a rail, in units of what else holds the coefficient. A choice: it is put on the rail
/// afterwards, and has to be near it.
const STIFFNESS: f64 = 1e5;

/// An end at a place, in a direction and with a curvature, but at any pace. The coefficient next to
/// that of the end lies on a ray from there; the third one lies aside of that ray as the square of the pace,
/// on a parabola.
#[derive(Clone, Copy, Debug)]
pub(in crate::condition::tube) struct Rail {
    /// The coefficient next to that of the end.
    pub(in crate::condition::tube) next: usize,
    pub(in crate::condition::tube) third: usize,
    /// That of the end.
    pub(in crate::condition::tube) place: Vec3,
    /// Of unit length.
    pub(in crate::condition::tube) direction: Vec3,
    /// How far the third coefficient lies aside, over the square of how far the next one is ahead.
    pub(in crate::condition::tube) aside: Vec3,
}

/// How far the coefficients are off their rail.
#[derive(Clone, Copy, Debug)]
struct OffRail {
    next: Vec3,
    third: Vec3,
    /// How far the third one has to move aside where the next one moves ahead.
    slope: Vec3,
}

impl Rail {
    /// Puts the coefficients on the rail; each stays where it is along the direction.
    pub(in crate::condition::tube) fn put_on(&self, coefficients: &mut [Vec3]) {
        let off = self.off(coefficients);
        for (at, off) in [(self.next, off.next), (self.third, off.third)] {
            coefficients[at] = sub(coefficients[at], off);
        }
    }

    fn off(&self, coefficients: &[Vec3]) -> OffRail {
        let across = |at: usize| {
            let off = sub(coefficients[at], self.place);
            along(off, self.direction, -dot(off, self.direction))
        };
        let ahead = dot(sub(coefficients[self.next], self.place), self.direction);
        OffRail {
            next: across(self.next),
            third: along(across(self.third), self.aside, -ahead * ahead),
            slope: scale(self.aside, 2.0 * ahead),
        }
    }

    /// Whether an interval of so many is the one at the end that has all three coefficients.
    pub(super) fn is_in(&self, k: usize, intervals: usize) -> bool {
        if self.next < self.third {
            k == 0
        } else {
            k + 1 == intervals
        }
    }

    /// Holds the coefficients on the rail, in the rows of the interval k that has both, of which the first
    /// has a number: half of the square of how far they are off, times a stiffness, by Gauss and Newton.
    pub(super) fn hold<const N: usize, const M: usize>(
        &self,
        share: &Share<N>,
        axes: [usize; N],
        (k, first): (usize, usize),
        coefficients: &[Vec3],
        rows: &mut [[SystemRow<M>; N]],
        right: &mut [[f64; N]],
    ) {
        let off = self.off(coefficients);
        let [p, q] = [self.next - k, self.third - k];
        let [next, third] = [p, q].map(|p| STIFFNESS * share.held(p));
        let slope = axes.map(|axis| off.slope[axis]);
        let direction = axes.map(|axis| self.direction[axis]);
        let square = third * dot(off.slope, off.slope);
        let pull = third * dot(off.slope, off.third);
        // A block lies in the rows of the coefficient that comes first.
        let mut add = |[p, q]: [usize; 2], [i, j]: [usize; 2], value: f64| {
            let ([p, q], [i, j]) = if p <= q {
                ([p, q], [i, j])
            } else {
                ([q, p], [j, i])
            };
            rows[p][i][(first + q) % ORDER][j] += value;
        };
        for i in 0..N {
            for j in 0..N {
                let own = if i == j { 1.0 } else { 0.0 };
                let across = own - direction[i] * direction[j];
                add(
                    [p, p],
                    [i, j],
                    next * across + square * direction[i] * direction[j],
                );
                add([q, q], [i, j], third * across);
                add([p, q], [i, j], -third * direction[i] * slope[j]);
            }
            right[p][i] += pull * direction[i] - next * off.next[axes[i]];
            right[q][i] -= third * off.third[axes[i]];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::tube::fit::{Fit, Site, Squared};
    use crate::condition::tube::spline::{Breaks, combined};

    /// From a bend, with whatever pace bends least: no other pace that was tried does so by more.
    #[test]
    fn the_pace_is_the_one_that_bends_least() {
        let breaks = Breaks((0..=16).map(|k| 0.5 * f64::from(k)).collect());
        let count = breaks.coefficients();
        let begun = || -> (Vec<Vec3>, Vec<Site>) {
            let coefficients = (0..count).map(|j| [breaks.greville(j), 0.0, 0.0]);
            let sites = [2.1, 4.3, 6.2].map(|w| {
                let k = breaks.interval(w);
                Site::new(&breaks, k, w, [w, 0.0, 0.0], 0.05)
            });
            (coefficients.collect(), sites.to_vec())
        };
        let rail = Rail {
            next: 1,
            third: 2,
            place: [0.0; 3],
            direction: [1.0, 0.0, 0.0],
            aside: [0.0, 4.0, 0.0],
        };
        let bent = |free: std::ops::Range<usize>, pace: f64, rails: Vec<Rail>| {
            let (mut coefficients, mut sites) = begun();
            coefficients[1][0] *= pace;
            rail.put_on(&mut coefficients);
            let fit = Fit::new(&breaks, Squared, free)
                .roughly(0.01)
                .on_rails(rails);
            assert!(fit.solve(&mut coefficients, &mut sites));
            let off = rail.off(&coefficients);
            assert!(
                off.third
                    .iter()
                    .chain(&off.next)
                    .all(|off| off.abs() < 1e-4)
            );
            rail.put_on(&mut coefficients);
            let thirds = (0..breaks.intervals())
                .map(|k| combined(&coefficients[k..k + ORDER], &breaks.third(k)));
            (
                thirds.map(|third| dot(third, third)).sum::<f64>(),
                coefficients[1][0],
            )
        };
        let (least, ahead) = bent(1..count - 1, 1.0, vec![rail]);
        let tried: Vec<(f64, f64)> = (0..60)
            .map(|k| 0.4 + 0.02 * f64::from(k))
            .map(|pace| bent(2..count - 1, pace, vec![Rail { next: 1, ..rail }]))
            .collect();
        let best = tried
            .iter()
            .copied()
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap();
        assert!(least < 1.001 * best.0, "{least} at {ahead}, {best:?}");
        assert!((ahead / best.1 - 1.0).abs() < 0.05, "{ahead} {best:?}");
        // and from another pace
        let other = bent(1..count - 1, 0.6, vec![rail]);
        assert!((other.0 / least - 1.0).abs() < 1e-3, "{other:?} {least}");
    }
}
