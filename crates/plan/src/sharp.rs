//! How fast a sharp corner is passed at most, by any curve within the tolerance.
//!
//! Before the corner the tool moves towards it, behind it away from it: along the difference of both
//! directions the velocity turns round within the tolerance, and jerk alone needs so much way for that
//! that the speed there is a multiple of (P^2 J)^(1/3).

use crate::condition::LinearJoint;
use crate::piece::PathStep;
use lostmotion_base::math;
use lostmotion_base::vec::{Vec3, add, along, dot, norm, scale, sub, unit};

/// That multiple. Measured: 2.2 to 2.4 in the motions that are found at corners of 65 to 120 degrees
/// within 10 and 100 um; the rest is room.
const SPEED_FACTOR: f64 = 3.5;
/// How far from the corner the directions are taken, in units of the tolerance. A choice: what turns back
/// within that a curve may cut.
const REACH: f64 = 20.0;
/// Least difference of both directions. A choice: a path that turns by less than 30 degrees within that
/// reach may have a shorter way inside the tube.
const LEAST_TURN: f64 = 0.5;
/// By how much the way past a corner is shorter than the lines at most, in units of the tolerance: 2.3 where
/// they turn by 125 degrees, as sharp as a curve may.
pub(crate) const CUT: f64 = 3.0;

/// Most speed along the path at a stop, which is step k, mm/s; `None` where there is no corner within the
/// tolerance.
pub(crate) fn speed(
    steps: &[PathStep],
    k: usize,
    tolerance: f64,
    joints: &[LinearJoint],
) -> Option<f64> {
    let reach = REACH * tolerance;
    let ends = |step: &PathStep| match step {
        PathStep::Piece(piece) => {
            Some([piece.curve.start(), piece.curve.end()].map(|p| p.linear()))
        }
        PathStep::Stop(_) => None,
    };
    let back = steps[..k].iter().rev().filter_map(ends);
    let back = leads(back.map(|[start, end]| [end, start]), reach)?;
    let ahead = leads(steps[k..].iter().filter_map(ends), reach)?;
    // The direction before the stop is that towards it, against the one back.
    let difference = add(ahead, back);
    let size = norm(difference);
    if size < LEAST_TURN {
        return None;
    }
    let turned = scale(difference, 1.0 / size);
    let jerk = joints
        .iter()
        .map(|joint| joint.jerk / dot(joint.per_mm, turned).abs())
        .fold(f64::INFINITY, f64::min);
    let most = SPEED_FACTOR * math::cbrt(tolerance * tolerance * jerk);
    // Each direction has half of the difference along it.
    Some(most / (0.5 * size))
}

/// The direction in which a path leads from where it begins, as far away as is asked for or as it goes.
fn leads(pieces: impl Iterator<Item = [Vec3; 2]>, reach: f64) -> Option<Vec3> {
    let mut gone = 0.0;
    let mut ends: Option<[Vec3; 2]> = None;
    for [start, end] in pieces {
        let length = norm(sub(end, start));
        let part = ((reach - gone) / length).min(1.0);
        let at = along(start, sub(end, start), part);
        ends = Some([ends.map_or(start, |[from, _]| from), at]);
        gone += length;
        if gone >= reach {
            break;
        }
    }
    let [from, to] = ends?;
    unit(sub(to, from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::item::Heeds;
    use crate::piece::{Mark, Piece, Stop};
    use lostmotion_base::{BlockRef, Coords};
    use lostmotion_path::Curve;
    use std::sync::Arc;

    const TOLERANCE: f64 = 0.01;

    /// Lines through places, with a stop at one of them.
    fn steps(places: &[[f64; 2]], stop: usize) -> Vec<PathStep> {
        let mark = Mark {
            from: 0.0,
            segment: 0,
            s: 0.0,
            rate: 1.0,
            block: BlockRef::default(),
        };
        let mut steps = Vec::new();
        for (k, ends) in places.windows(2).enumerate() {
            if k == stop {
                steps.push(PathStep::Stop(Stop::default()));
            }
            let [from, to] = [ends[0], ends[1]].map(|[x, y]| Coords::xyz(x, y, 0.0));
            steps.push(PathStep::Piece(Arc::new(Piece {
                curve: Curve::line(from, to),
                marks: [mark; 2],
                more: Box::default(),
                feed: 100.0,
                heeds: Heeds::Feed,
                tool_mm: [0.0; 3],
            })));
        }
        steps
    }

    fn at(places: &[[f64; 2]], stop: usize) -> Option<f64> {
        let joints = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|per_mm| LinearJoint {
            per_mm,
            velocity: 100.0,
            acceleration: 1e3,
            jerk: 3e4,
        });
        speed(&steps(places, stop), stop, TOLERANCE, &joints)
    }

    /// At a right angle both axes turn round together: the jerk along the difference is 1.41 times theirs.
    #[test]
    fn a_right_angle_has_its_closed_form() {
        let right = at(&[[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]], 1).unwrap();
        let jerk = 3e4 * std::f64::consts::SQRT_2;
        let expected = SPEED_FACTOR * math::cbrt(TOLERANCE * TOLERANCE * jerk)
            / std::f64::consts::FRAC_1_SQRT_2;
        assert!((right - expected).abs() < 1e-9, "{right} {expected}");
        // The same of points that lie dense.
        let dense: Vec<[f64; 2]> = (0..=100)
            .map(|k| 0.01 * f64::from(k))
            .map(|s| if s <= 0.5 { [s, 0.0] } else { [0.5, s - 0.5] })
            .collect();
        let same = at(&dense, 50).unwrap();
        assert!((right - same).abs() < 1e-6, "{right} {same}");
    }

    #[test]
    fn sharper_is_slower() {
        let of = |y: f64| at(&[[0.0, 0.0], [5.0, 0.0], [4.0, y]], 1).unwrap();
        assert!(of(1.0) < of(2.0) && of(2.0) < of(5.0));
    }

    /// Corners to both sides that lie near each other are none within the tolerance.
    #[test]
    fn a_jog_is_no_corner() {
        let jog = [[0.0, 0.0], [5.0, 0.0], [5.0, 0.02], [10.0, 0.02]];
        assert_eq!(at(&jog, 1), None);
        assert_eq!(at(&jog, 2), None);
    }
}
