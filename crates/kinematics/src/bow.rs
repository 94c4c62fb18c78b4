//! How far the tool is off the straight way where joints go straight.

use crate::Kinematics;
use crate::vector::{add, dot, norm, scale, sub};
use lostmotion_base::Coords;

/// Places between the ends that are looked at, and halvings of the steps around the farthest.
const PARTS: u32 = 64;
const HALVINGS: usize = 40;

/// How far the tip leaves the straight way in the part's frame when all joints go linearly from one place to another (a line without
/// tool-centre-point control), mm: at most r (1 - cos(dtheta / 2)) for one rotary joint at a distance r.
pub fn bow_mm(kinematics: &dyn Kinematics, from: &Coords, to: &Coords, tool: &[f64; 3]) -> f64 {
    let tip = |joints: &Coords| kinematics.tool_pose(joints, tool).tip;
    let (start, end) = (tip(from), tip(to));
    let way = sub(end, start);
    let square = dot(way, way);
    let at = |part: f64| {
        let away = sub(tip(&from.lerp(*to, part)), start);
        let along = if square > 0.0 { (dot(away, way) / square).clamp(0.0, 1.0) } else { 0.0 };
        norm(add(away, scale(way, -along)))
    };
    let step = 1.0 / f64::from(PARTS);
    let places = (1..PARTS).map(|part| f64::from(part) * step).map(|part| (at(part), part));
    let Some((most, top)) = places.max_by(|a, b| a.0.total_cmp(&b.0)) else { return 0.0 };
    let (mut low, mut high) = (top - step, top + step);
    for _ in 0..HALVINGS {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(a) < at(b) { low = a } else { high = b }
    }
    most.max(at(0.5 * (low + high)))
}
