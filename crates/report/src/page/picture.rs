//! Still pictures of a page: the path coloured by its error, a panel a level of Z, and the worst
//! places enlarged. They need no script, print, and are drawn in the colours of the style sheet.

use super::data::escape;
use super::path::{Path, Stretch};
use super::places::{Near, Place};
use crate::number::{error, fixed, plain};
use crate::svg::{Plane, round_down};
use lostmotion_base::math;
use std::collections::BTreeMap;

/// Errors, as parts of the tolerance, at which the colour changes. Symmetric; beyond 1 is outside.
pub(super) const BOUNDS: [f64; 8] = [-1.0, -0.6, -0.3, -0.1, 0.1, 0.3, 0.6, 1.0];
/// Width of a panel, px of its own scale.
const WIDTH: f64 = 640.0;
/// Around the path, px.
const MARGIN: f64 = 22.0;
/// Most panels. A choice.
const MOST_LEVELS: usize = 6;
/// Most points of all panels: a picture of some 300 kB.
const MOST_POINTS: usize = 16_000;
/// Steps by which levels are told apart, mm.
const LEVEL_MM: f64 = 1e-3;
/// Part of the cutting that has to be level for panels by level. A choice.
const LEVEL_SHARE: f64 = 0.6;

/// Number of the colour of an error.
pub(super) fn color(error_um: f64, tolerance_um: f64) -> usize {
    let part = error_um / tolerance_um.max(1e-9);
    BOUNDS.iter().filter(|bound| part >= **bound).count()
}

/// A panel: which stretches, and what is said of them.
struct LevelPanel {
    caption: String,
    /// Its Z in steps of [`LEVEL_MM`]; `None` for one panel of everything.
    level: Option<i64>,
    stretches: Vec<usize>,
}

/// A place that is marked in the pictures.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mark {
    pub(super) at_mm: [f64; 3],
    pub(super) name: String,
}

/// Figures with the path of a method; empty where nothing is cut.
pub(super) fn path(path: &Path, method: usize, tolerance_um: f64, marks: &[Mark]) -> String {
    let cutting: Vec<usize> = (0..path.stretches.len().saturating_sub(1))
        .filter(|index| {
            let of = |index: usize| path.stretches.get(index);
            of(*index).is_some_and(|stretch| !stretch.rapid)
                && of(index + 1).is_some_and(|next| !next.broken)
        })
        .collect();
    if cutting.is_empty() {
        return String::new();
    }
    let plane = plane(path, &cutting);
    let peaks = path.peaks.get(method).map_or(&[][..], Vec::as_slice);
    let panels = panels(path, &cutting, plane);
    // Coarser and coarser until all panels together have few enough points.
    let mut least_px = 0.4;
    loop {
        let drawn: Vec<(String, usize)> = panels
            .iter()
            .map(|panel| {
                let marks = marks.iter().filter(|mark| panel.shows(mark, &panels));
                let marks: Vec<&Mark> = marks.collect();
                draw(path, peaks, panel, plane, tolerance_um, least_px, &marks)
            })
            .collect();
        if drawn.iter().map(|(_, points)| points).sum::<usize>() <= MOST_POINTS || least_px > 100.0
        {
            return drawn.into_iter().map(|(figure, _)| figure).collect();
        }
        least_px *= 1.6;
    }
}

impl LevelPanel {
    /// Whether a place is on its level, or nearer to it than to any other.
    fn shows(&self, mark: &Mark, panels: &[LevelPanel]) -> bool {
        let at = (mark.at_mm[2] / LEVEL_MM).round() as i64;
        let off = |panel: &LevelPanel| panel.level.map_or(0, |level| level.abs_diff(at));
        let nearest = panels.iter().map(off).min().unwrap_or(0);
        off(self) == nearest
    }
}

/// The plane that shows most of what is cut.
fn plane(path: &Path, cutting: &[usize]) -> Plane {
    let extent = |axis: usize| {
        let along = || {
            let of = |index: &usize| path.stretches.get(*index).map(|s| s.from_mm[axis]);
            cutting.iter().filter_map(of)
        };
        along().fold(f32::NEG_INFINITY, f32::max) - along().fold(f32::INFINITY, f32::min)
    };
    Plane::of_extents([0, 1, 2].map(|axis| f64::from(extent(axis))))
}

/// One panel, or one a level of Z where most of the cutting is level and seen from above.
fn panels(path: &Path, cutting: &[usize], plane: Plane) -> Vec<LevelPanel> {
    let all = || LevelPanel {
        caption: "All cutting moves".to_owned(),
        level: None,
        stretches: cutting.to_vec(),
    };
    if plane != Plane::Xy {
        return vec![all()];
    }
    let z_of = |stretch: &Stretch| (f64::from(stretch.from_mm[2]) / LEVEL_MM).round() as i64;
    let ends = |index: usize| {
        let (from, to) = (path.stretches.get(index)?, path.stretches.get(index + 1)?);
        Some((z_of(from), z_of(to), f64::from(from.length_mm)))
    };
    let (mut levels, mut whole): (BTreeMap<i64, f64>, f64) = (BTreeMap::new(), 0.0);
    for (from, to, length) in cutting.iter().filter_map(|index| ends(*index)) {
        whole += length;
        if from == to {
            *levels.entry(from).or_default() += length;
        }
    }
    let mut longest: Vec<(i64, f64)> = levels.into_iter().collect();
    longest.sort_by(|a, b| b.1.total_cmp(&a.1).then(b.0.cmp(&a.0)));
    longest.truncate(MOST_LEVELS);
    // A level with next to nothing on it is a plunge or an approach.
    longest.retain(|(_, length)| *length > 0.02 * whole);
    let covered: f64 = longest.iter().map(|(_, length)| length).sum();
    if covered < LEVEL_SHARE * whole || longest.len() < 2 {
        return vec![all()];
    }
    // From the top down, as they are cut.
    longest.sort_by_key(|level| std::cmp::Reverse(level.0));
    let mut panels: Vec<LevelPanel> = longest
        .iter()
        .map(|(z, _)| LevelPanel {
            caption: format!("Z {} mm", plain(*z as f64 * LEVEL_MM)),
            level: Some(*z),
            stretches: Vec::new(),
        })
        .collect();
    // What is not level goes to the level that it is nearest to: nothing is left out.
    for index in cutting {
        let Some((from, to, _)) = ends(*index) else {
            continue;
        };
        let low = from.min(to);
        let nearest = (0..longest.len()).min_by_key(|at| longest[*at].0.abs_diff(low));
        if let Some(panel) = nearest.and_then(|at| panels.get_mut(at)) {
            panel.stretches.push(*index);
        }
    }
    panels
}

/// Lines of one colour.
#[derive(Clone, Default)]
struct Strokes {
    data: String,
    points: usize,
}

/// A panel as a figure, and how many points it has.
fn draw(
    path: &Path,
    peaks: &[f32],
    panel: &LevelPanel,
    plane: Plane,
    tolerance_um: f64,
    least_px: f64,
    marks: &[&Mark],
) -> (String, usize) {
    let at = |index: usize| {
        let place = path.stretches.get(index).map_or([0.0; 3], |s| s.from_mm);
        plane.project(place.map(f64::from))
    };
    let ends = || {
        panel
            .stretches
            .iter()
            .flat_map(|index| [at(*index), at(index + 1)])
    };
    let range = |axis: usize| {
        let low = ends().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
        let high = ends().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
        [low, high]
    };
    let (x, y) = (range(0), range(1));
    let span = (x[1] - x[0]).max(y[1] - y[0]).max(1e-6);
    let wide = (x[1] - x[0]).max(0.4 * span);
    let scale = ((WIDTH - 2.0 * MARGIN) / wide).min(1.1 * WIDTH / span);
    let height = (y[1] - y[0]) * scale + 2.0 * MARGIN + 26.0;
    let left = 0.5 * (WIDTH - (x[1] - x[0]) * scale);
    let px = |[u, v]: [f64; 2]| [left + (u - x[0]) * scale, MARGIN + (y[1] - v) * scale];

    let mut strokes = vec![Strokes::default(); BOUNDS.len() + 1];
    let (mut worst, mut pen): (f32, Option<(usize, usize, [f64; 2])>) = (0.0, None);
    let mut held: Option<(usize, [f64; 2])> = None;
    for index in &panel.stretches {
        let peak = peaks.get(*index).copied().unwrap_or(f32::NAN);
        // The machine has stopped before.
        if peak.is_nan() {
            continue;
        }
        if peak.abs() > worst.abs() {
            worst = peak;
        }
        let (from, to) = (px(at(*index)), px(at(index + 1)));
        let mut hue = color(f64::from(peak), tolerance_um);
        // Stretches too short to be seen go on with the next; the colour farthest from the middle
        // stays.
        let mut start = from;
        if let Some((waiting, since)) = held.take() {
            let middle = BOUNDS.len() / 2;
            if waiting.abs_diff(middle) > hue.abs_diff(middle) {
                hue = waiting;
            }
            start = since;
        }
        let goes_on = pen.is_some_and(|(last, ..)| last + 1 == *index);
        if !goes_on {
            start = from;
        }
        let length = math::hypot(to[0] - start[0], to[1] - start[1]);
        let more = panel.stretches.binary_search(&(index + 1)).is_ok();
        if length < least_px && more {
            held = Some((hue, start));
            pen = Some(match pen {
                Some((_, last, end)) if goes_on => (*index, last, end),
                _ => (*index, usize::MAX, start),
            });
            continue;
        }
        let Some(stroke) = strokes.get_mut(hue) else {
            continue;
        };
        let joined = goes_on && pen.is_some_and(|(_, last, end)| last == hue && end == start);
        if !joined {
            stroke
                .data
                .push_str(&format!("M{} {}", fixed(start[0], 1), fixed(start[1], 1)));
            stroke.points += 1;
        }
        stroke
            .data
            .push_str(&format!("L{} {}", fixed(to[0], 1), fixed(to[1], 1)));
        stroke.points += 1;
        pen = Some((*index, hue, to));
    }
    let points = strokes.iter().map(|stroke| stroke.points).sum();
    // The largest errors last: they lie on top.
    let mut order: Vec<usize> = (0..strokes.len()).collect();
    order.sort_by_key(|hue| hue.abs_diff(BOUNDS.len() / 2));
    let lines: String = order
        .into_iter()
        .filter_map(|hue| strokes.get(hue).map(|stroke| (hue, stroke)))
        .filter(|(_, stroke)| stroke.points > 0)
        .map(|(hue, stroke)| format!("<path class=\"e{hue}\" d=\"{}\"/>", stroke.data))
        .collect();
    let marks: String = marks
        .iter()
        .map(|mark| {
            let at = px(plane.project(mark.at_mm));
            // The name is where there is room: away from the nearer edge.
            let (side, anchor) = if at[0] > 0.5 * WIDTH {
                (-11.0, "end")
            } else {
                (11.0, "start")
            };
            let [x, y, text, base] =
                [at[0], at[1], at[0] + side, at[1] + 4.5].map(|c| fixed(c, 1));
            format!(
                "<circle class=\"mark\" cx=\"{x}\" cy=\"{y}\" r=\"8\"/><text class=\"mark\" x=\"{text}\" y=\"{base}\" text-anchor=\"{anchor}\">{}</text>",
                escape(&mark.name)
            )
        })
        .collect();
    let ruler_mm = round_down(0.3 * wide).max(1e-6);
    let [h, v] = plane.labels();
    let (h, v) = (h.trim_end_matches(", mm"), v.trim_end_matches(", mm"));
    let caption = format!(
        "{}: worst {} \u{b5}m",
        panel.caption,
        signed(f64::from(worst))
    );
    let figure = format!(
        "<figure class=\"panel\"><svg viewBox=\"0 0 {w} {t}\" role=\"img\" aria-label=\"{label}\"><g class=\"path\">{lines}</g>{marks}{ruler}</svg><figcaption>{label}; {h} to the right, {v} up</figcaption></figure>\n",
        w = fixed(WIDTH, 0),
        t = fixed(height, 0),
        label = escape(&caption),
        ruler = ruler(
            height - 12.0,
            ruler_mm * scale,
            &format!("{} mm", plain(ruler_mm))
        ),
    );
    (figure, points)
}

/// A length with its name, in the lower left corner.
fn ruler(y: f64, length: f64, name: &str) -> String {
    let [x0, x1, y0, y1, text] = [
        MARGIN,
        MARGIN + length,
        y - 4.0,
        y + 4.0,
        MARGIN + length + 8.0,
    ]
    .map(|c| fixed(c, 1));
    format!(
        "<path class=\"ruler\" d=\"M{x0} {y0}V{y1}M{x0} {mid}H{x1}M{x1} {y0}V{y1}\"/><text x=\"{text}\" y=\"{base}\">{name}</text>",
        mid = fixed(y, 1),
        base = fixed(y + 4.5, 1),
    )
}

/// An error with its sign.
pub(super) fn signed(um: f64) -> String {
    let text = error(um);
    if um > 0.0 {
        format!("+{text}")
    } else {
        text.replace('-', "\u{2212}")
    }
}

/// Side of an enlarged place, px of its own scale.
const PLACE_SIDE: f64 = 300.0;
/// Part of the picture that the largest error takes. A choice.
const PLACE_SHARE: f64 = 0.28;

/// A worst place enlarged: the programmed path, the tool's with its errors magnified, and the
/// tolerance to both sides. `None` without any length.
pub(super) fn place(place: &Place, tolerance_um: f64) -> Option<String> {
    let near = &place.near;
    let plane = {
        let extent = |axis: usize| {
            let along = || near.iter().map(|n| n.foot_mm[axis]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        Plane::of_extents([0, 1, 2].map(extent))
    };
    let worst = near.iter().min_by(|a, b| {
        let off = |n: &Near| (n.time_s - place.time_s).abs();
        off(a).total_cmp(&off(b))
    })?;
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
    let scale = 0.5 * PLACE_SIDE / reach;
    let largest = near
        .iter()
        .map(|n| f64::from(n.error_um.abs()))
        .fold(0.0, f64::max);
    let shown = largest
        .max((1.3 * tolerance_um).min(3.0 * largest))
        .max(1e-6);
    let times = round_down(PLACE_SHARE * PLACE_SIDE / (shown * 1e-3 * scale)).max(1.0);
    let point = |n: &Near, um: f64| {
        let foot = plane.project(n.foot_mm);
        let normal = plane.project(n.normal.map(f64::from));
        let off = um * 1e-3 * times;
        let at = [0, 1].map(|axis| (foot[axis] + normal[axis] * off - center[axis]) * scale);
        [0.5 * PLACE_SIDE + at[0], 0.5 * PLACE_SIDE - at[1]]
    };
    let line = |of: &dyn Fn(&Near) -> f64| {
        let mut data = String::new();
        let mut last: Option<[f64; 2]> = None;
        for n in near {
            let at = point(n, of(n));
            // Half a pixel is not seen, but the worst tick always is drawn.
            let moved = last.is_none_or(|l| math::hypot(at[0] - l[0], at[1] - l[1]) > 0.5);
            if moved || n.time_s.to_bits() == worst.time_s.to_bits() {
                data.push(if last.is_none() { 'M' } else { 'L' });
                data.push_str(&format!("{} {}", fixed(at[0], 1), fixed(at[1], 1)));
                last = Some(at);
            }
        }
        data
    };
    let [foot, tip] = [point(worst, 0.0), point(worst, f64::from(worst.error_um))];
    let hue = color(f64::from(worst.error_um), tolerance_um);
    let ruler_mm = round_down(0.3 * PLACE_SIDE / scale).max(1e-9);
    Some(format!(
        "<svg viewBox=\"0 0 {s} {t}\" role=\"img\" aria-label=\"The tool's path near line {number}, errors {times} times\"><g class=\"place\"><path class=\"limit\" d=\"{left}\"/><path class=\"limit\" d=\"{right}\"/><path class=\"programmed\" d=\"{programmed}\"/><path class=\"tool\" d=\"{tool}\"/><path class=\"e{hue}\" d=\"M{fx} {fy}L{tx} {ty}\"/></g>{ruler}</svg><p class=\"note\">errors {times}\u{d7}, dashed: tolerance</p>",
        s = fixed(PLACE_SIDE, 0),
        t = fixed(PLACE_SIDE + 24.0, 0),
        number = place.block.span.line,
        times = plain(times),
        left = line(&|_| tolerance_um),
        right = line(&|_| -tolerance_um),
        programmed = line(&|_| 0.0),
        tool = line(&|n| f64::from(n.error_um)),
        fx = fixed(foot[0], 1),
        fy = fixed(foot[1], 1),
        tx = fixed(tip[0], 1),
        ty = fixed(tip[1], 1),
        ruler = ruler(
            PLACE_SIDE + 10.0,
            ruler_mm * scale,
            &format!("{} mm", plain(ruler_mm))
        ),
    ))
}
