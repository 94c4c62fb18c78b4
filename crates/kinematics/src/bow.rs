//! How far the tool is off its way where joints go straight.

use crate::Kinematics;
use lostmotion_base::Coords;
use lostmotion_base::vec::{Vec3, add, dot, norm, scale, sub};

/// Places between the ends at which the bow is evaluated, and rounds of ternary search around the
/// largest: 40 narrow a step by (2/3)^40 = 1e-7.
const BOW_PLACES: u32 = 64;
const TERNARY_ROUNDS: usize = 40;

/// Way of the joint that goes farthest, mm or rad, over which the tip's derivatives are
/// differenced: the rest of the difference is below 1e-7 of it.
const DIFFERENCE_STEP: f64 = 1e-4;
/// The tip stands still, and has no direction, where it goes less than this for each mm or rad of
/// that joint, mm.
const STILL_TIP: f64 = 1e-6;

/// What draws the tip away from the chord of its joints, in the part's frame: the part square to
/// the tip's way of the second derivative that the joints' own second derivatives give it. Between
/// two places at a parameter's distance T the middle of the joints' chord is off the way by T2/8 of
/// it. Derivatives by any parameter (path length, time), in mm and rad over its square.
pub fn chord_bend(
    kinematics: &dyn Kinematics,
    [joints, first, second]: [&Coords; 3],
    tool: &[f64; 3],
) -> f64 {
    let (way, bend) = (
        tip_derivative(kinematics, joints, first, tool),
        tip_derivative(kinematics, joints, second, tool),
    );
    // The part along the tip's way only changes its speed; the part square to it bends the way.
    let square = dot(way, way);
    let still = STILL_TIP * largest(first);
    let along = if square > still * still {
        dot(bend, way) / square
    } else {
        0.0
    };
    norm(sub(bend, scale(way, along)))
}

/// How fast the tip goes if the joints do, by central differences.
fn tip_derivative(
    kinematics: &dyn Kinematics,
    joints: &Coords,
    speeds: &Coords,
    tool: &[f64; 3],
) -> Vec3<f64> {
    let largest = largest(speeds);
    if largest == 0.0 {
        return [0.0; 3];
    }
    // The joint that goes farthest goes the same way, whatever the parameter and its unit.
    let step = DIFFERENCE_STEP / largest;
    let tip = |step: f64| kinematics.tool_pose(&(*joints + *speeds * step), tool).tip;
    scale(sub(tip(step), tip(-step)), 0.5 / step)
}

fn largest(coords: &Coords) -> f64 {
    coords.0.iter().fold(0.0, |most, c| f64::max(most, c.abs()))
}

/// How far the tip leaves the straight way in the part's frame when all joints go linearly from one
/// place to another (a line without tool-centre-point control), mm: at most r (1 - cos(dtheta / 2))
/// for one rotary joint at a distance r.
///
/// ```
/// use lostmotion_base::{Coords, units::rad};
/// use lostmotion_kinematics::{TrunnionAcSpec, bow_mm, build};
///
/// let table = build(&TrunnionAcSpec::default().into())?;
/// let at = |c_deg| Coords([100.0, 0.0, 0.0, 0.0, 0.0, rad(c_deg), 0.0, 0.0, 0.0]);
/// // A turn of 2 degrees, 100 mm off the axis.
/// let bow = bow_mm(table.as_ref(), &at(0.0), &at(2.0), &[0.0; 3]);
/// assert!((bow - 100.0 * (1.0 - lostmotion_base::math::cos(rad(1.0)))).abs() < 1e-6);
/// # Ok::<(), lostmotion_kinematics::KinematicsError>(())
/// ```
pub fn bow_mm(kinematics: &dyn Kinematics, from: &Coords, to: &Coords, tool: &[f64; 3]) -> f64 {
    let tip = |joints: &Coords| kinematics.tool_pose(joints, tool).tip;
    let (start, end) = (tip(from), tip(to));
    let way = sub(end, start);
    let square = dot(way, way);
    // Distance of the tip from the straight way when the joints have gone a part of theirs.
    let at = |part: f64| {
        let away = sub(tip(&from.lerp(*to, part)), start);
        let along = if square > 0.0 {
            (dot(away, way) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        norm(add(away, scale(way, -along)))
    };
    let step = 1.0 / f64::from(BOW_PLACES);
    let places = (1..BOW_PLACES)
        .map(|part| f64::from(part) * step)
        .map(|part| (at(part), part));
    // Coarse search for the largest distance, then ternary search in the two steps beside it.
    let Some((most, top)) = places.max_by(|a, b| a.0.total_cmp(&b.0)) else {
        return 0.0;
    };
    let (mut low, mut high) = (top - step, top + step);
    for _ in 0..TERNARY_ROUNDS {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(a) < at(b) { low = a } else { high = b }
    }
    most.max(at(0.5 * (low + high)))
}
