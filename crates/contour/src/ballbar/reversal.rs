//! What a reversal leaves on a circle: the step of the level and the spike.

use lostmotion_base::math;
use std::f64::consts::TAU;

/// Degrees next to a reversal in which its spike is looked for. A choice: a spike has passed by then
/// on circles that are not much smaller than they are fast.
pub(super) const SPIKE_DEG: f64 = 15.0;
/// Degrees before and behind a reversal over which the offsets are taken. A choice: beyond the spike,
/// and before the next octant.
const LEVEL_DEG: [f64; 2] = [15.0, 30.0];

/// Step and spike at a reversal, by its angle in degrees, in the unit of the deviations; `None` where
/// the circle has a gap there.
pub(super) fn reversal(
    points: &[(f64, f64)],
    at_deg: f64,
    counterclockwise: bool,
) -> Option<(f64, f64)> {
    let sense = if counterclockwise { 1.0 } else { -1.0 };
    let at = at_deg.to_radians();
    // From one angle to another, as they are travelled from the reversal on: cosine and sine of the
    // angle, and the deviation.
    let stretch = |from_deg: f64, to_deg: f64| {
        let range = from_deg.to_radians()..to_deg.to_radians();
        points.iter().filter_map(move |&(angle, off)| {
            let along = sense * (angle - at);
            let along = along - TAU * (along / TAU).round();
            let (sin, cos) = math::sin_cos(along);
            range.contains(&along).then_some([cos, sin, off])
        })
    };
    let [near, far] = LEVEL_DEG;
    let before = offset(stretch(-far, -near))?;
    let behind = offset(stretch(near, far))?;
    let outside = |[cos, sin, off]: [f64; 3]| {
        let [one, other] = [before, behind].map(|[a, b]| a * cos + b * sin);
        (off - one.max(other)).max(one.min(other) - off).max(0.0)
    };
    let spike = stretch(0.0, SPIKE_DEG).map(outside).fold(0.0, f64::max);
    Some((behind[0] - before[0], spike))
}

/// By how much a tip is off along the axis that reverses and along the other one, which makes the
/// deviations over a stretch, by least squares.
fn offset(stretch: impl Iterator<Item = [f64; 3]>) -> Option<[f64; 2]> {
    let (mut cc, mut cs, mut ss, mut cu, mut su) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for [cos, sin, off] in stretch {
        cc += cos * cos;
        cs += cos * sin;
        ss += sin * sin;
        cu += cos * off;
        su += sin * off;
    }
    let determinant: f64 = cc * ss - cs * cs;
    // Too few samples.
    (determinant > 1e-6).then(|| {
        [
            (ss * cu - cs * su) / determinant,
            (cc * su - cs * cu) / determinant,
        ]
    })
}
