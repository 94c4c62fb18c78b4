//! A worst place enlarged: what the tool does there beside the programmed path.

use super::picture::{Drawing, Frame, color, ruler};
use super::places::{Near, Place};
use crate::number::{fixed, plain};
use crate::svg::{Plane, keep, round_down};
use lostmotion_base::math;

/// Part of the picture that the largest error takes. A choice.
const PLACE_SHARE: f64 = 0.28;

/// Points nearer than this to the line without them are not drawn, px. As in the drawing of the path.
const LEAST_DETAIL_PX: f64 = 0.12;

/// The programmed path, the tool's with its errors magnified, and the tolerance to both sides, in a
/// square. `None` without any length.
pub(super) fn place(place: &Place, tolerance_um: f64, frame: Frame) -> Option<Drawing> {
    let near = &place.near;
    let side = frame.width;
    let worst = near.iter().min_by(|a, b| {
        let off = |n: &Near| (n.time_s - place.time_s).abs();
        off(a).total_cmp(&off(b))
    })?;
    let plane = plane(near, worst);
    let center = plane.project(worst.foot_mm);
    let reach = near
        .iter()
        .map(|n| plane.project(n.foot_mm))
        .map(|[u, v]| (u - center[0]).abs().max((v - center[1]).abs()))
        .fold(0.0, f64::max);
    // Standing still there is no path to draw.
    if reach < 1e-6 {
        return None;
    }
    let scale = 0.5 * side / reach;
    let largest = near
        .iter()
        .map(|n| f64::from(n.error_um.abs()))
        .fold(0.0, f64::max);
    let shown = largest
        .max((1.3 * tolerance_um).min(3.0 * largest))
        .max(1e-6);
    let times = round_down(PLACE_SHARE * side / (shown * 1e-3 * scale)).max(1.0);
    let at = |[u, v]: [f64; 2]| {
        let [u, v] = [(u - center[0]) * scale, (v - center[1]) * scale];
        [0.5 * side + u, 0.5 * side - v]
    };
    let foot_of = |n: &Near| plane.project(n.foot_mm);
    let tool_of = |n: &Near| {
        let (foot, off) = (foot_of(n), plane.project(n.off_mm.map(f64::from)));
        [0, 1].map(|axis| foot[axis] + times * off[axis])
    };
    let limits = |sign: f64| {
        let across = |(foot, left): ([f64; 2], [f64; 2])| {
            let by = sign * tolerance_um * 1e-3 * times;
            [0, 1].map(|axis| foot[axis] + by * left[axis])
        };
        let feet: Vec<[f64; 2]> = near.iter().map(foot_of).collect();
        line(
            feet.iter().copied().zip(lefts(&feet)).map(across).map(at),
            None,
        )
    };
    let worst_at = near
        .iter()
        .position(|n| n.time_s.to_bits() == worst.time_s.to_bits());
    let [foot, tip] = [at(foot_of(worst)), at(tool_of(worst))];
    let hue = color(f64::from(worst.error_um), tolerance_um);
    let ruler_mm = round_down(0.3 * side / scale).max(1e-9);
    let height = side + 1.7 * frame.font;
    let ruler = ruler(
        [0.07 * side, height - 0.9 * frame.font],
        ruler_mm * scale,
        &format!("{} mm", plain(ruler_mm)),
    );
    let [left, right] = [limits(1.0), limits(-1.0)];
    let programmed = line(near.iter().map(foot_of).map(at), None);
    let tool = line(near.iter().map(tool_of).map(at), worst_at);
    let [fx, fy, tx, ty] = [foot[0], foot[1], tip[0], tip[1]].map(|c| fixed(c, 1));
    Some(Drawing {
        size: [side, height],
        body: format!(
            "<g class=\"place\"><path class=\"limit\" d=\"{left}\"/><path class=\"limit\" d=\"{right}\"/><path class=\"programmed\" d=\"{programmed}\"/><path class=\"tool\" d=\"{tool}\"/><path class=\"e{hue}\" d=\"M{fx} {fy}L{tx} {ty}\"/></g>{ruler}"
        ),
        label: format!("errors {}\u{d7}, dashed: tolerance", plain(times)),
        points: 5 * near.len(),
    })
}

/// The plane in which both the way and the error at the worst tick are seen best; that of X and Y if
/// it shows nearly as much.
fn plane(near: &[Near], worst: &Near) -> Plane {
    let (Some(first), Some(last)) = (near.first(), near.last()) else {
        return Plane::Xy;
    };
    let way = [0, 1, 2].map(|axis| last.foot_mm[axis] - first.foot_mm[axis]);
    let off = worst.off_mm.map(f64::from);
    // Of the area between way and error, how much is seen. A way back has no direction: its error
    // alone counts.
    let seen = |plane: Plane| {
        let [w, o] = [way, off].map(|v| plane.project(v));
        (w[0] * o[1] - w[1] * o[0]).abs() + 1e-3 * math::hypot(o[0], o[1])
    };
    let most = [Plane::Xz, Plane::Yz]
        .into_iter()
        .max_by(|a, b| seen(*a).total_cmp(&seen(*b)))
        .unwrap_or(Plane::Xy);
    if seen(Plane::Xy) >= 0.7 * seen(most) {
        Plane::Xy
    } else {
        most
    }
}

/// Unit vectors to the left of a way; where it stands still those of before.
fn lefts(way: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut left = None;
    let mut lefts: Vec<Option<[f64; 2]>> = way
        .iter()
        .enumerate()
        .map(|(index, at)| {
            let next = way.get(index + 1).unwrap_or(at);
            let step = [next[0] - at[0], next[1] - at[1]];
            let length = math::hypot(step[0], step[1]);
            if length > 1e-9 {
                left = Some([-step[1] / length, step[0] / length]);
            }
            left
        })
        .collect();
    // At the start there is no before.
    let first = lefts.iter().flatten().next().copied().unwrap_or([0.0; 2]);
    lefts
        .iter_mut()
        .map(|left| left.take().unwrap_or(first))
        .collect()
}

/// A line without points that are not seen, but with the one that must not be left out.
fn line(points: impl Iterator<Item = [f64; 2]>, whole: Option<usize>) -> String {
    let points: Vec<[f64; 2]> = points.collect();
    let (before, after) = points.split_at(whole.map_or(0, |at| (at + 1).min(points.len())));
    let mut data = String::new();
    for part in [before, after] {
        for at in keep(part, LEAST_DETAIL_PX) {
            data.push(if data.is_empty() { 'M' } else { 'L' });
            let [x, y] = part[at].map(|c| fixed(c, 1));
            data.push_str(&format!("{x} {y}"));
        }
    }
    data
}
