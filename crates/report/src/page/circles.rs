//! Full circles of a program and the circular test on them (ISO 230-4).
//!
//! A circle is found by its foot points and normals: those of an arc all lead to one centre. Arcs
//! that go on around the same centre make a circle together.

use lostmotion_base::{Plane, math};
use lostmotion_contour::Circle;
use lostmotion_sim::ContourPoint;
use std::f64::consts::TAU;

/// Most groups of ticks that are held of an arc; twice as many just before they are joined.
const MOST_GROUPS: usize = 1024;
/// Circles that are kept of a method. A choice.
const MOST_CIRCLES: usize = 12;
/// Parts of a turn in a polar plot: half a degree.
const PARTS: usize = 720;
/// How far, as part of the radius, an arc may be off the circle that it is taken for. A choice:
/// above the rounding of coordinates in programs.
const OFF_CIRCLE: f64 = 1e-3;
/// Part of a turn that may be missing between the first and the last tick. A choice.
const MISSING: f64 = 0.02;
/// Radii of a circular test, mm. Choices: below lie the roundings of engravings, above straight
/// lines.
const RADII_MM: [f64; 2] = [0.5, 5000.0];

/// Ticks next to each other on an arc.
#[derive(Clone, Copy, Debug)]
struct Group {
    foot_mm: [f64; 3],
    normal: [f64; 3],
    low_um: f64,
    high_um: f64,
}

/// An arc, or several around one centre.
#[derive(Clone, Debug)]
struct Arc {
    center_mm: [f64; 3],
    /// Positive where the normal leads to the centre.
    radius_mm: f64,
    /// Angle, rad.
    sweep: f64,
    line: u32,
    time_s: f64,
    groups: Vec<Group>,
}

/// A full circle and how far the tool was off it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FullCircle {
    /// Line of its first block.
    pub(super) line: u32,
    /// Time of its first tick, s.
    pub(super) time_s: f64,
    pub(super) plane: Plane,
    pub(super) center_mm: [f64; 2],
    pub(super) radius_mm: f64,
    /// Whether it goes from the plane's first axis to its second.
    pub(super) counterclockwise: bool,
    /// Smallest and largest radial deviation in each part of the turn, um; NaN without a tick.
    pub(super) radial_um: Vec<[f32; 2]>,
    /// Circular deviation G, um.
    pub(super) g_um: f64,
    /// Smallest and largest radial deviation F, um.
    pub(super) f_um: [f64; 2],
    /// Circular hysteresis H against the same circle in the other sense, um.
    pub(super) h_um: Option<f64>,
}

/// Finds the full circles of one method.
#[derive(Clone, Debug, Default)]
pub(super) struct CircleRecorder {
    line: u32,
    file: u32,
    start_s: f64,
    last_normal: [f64; 3],
    group: u64,
    filled: u64,
    groups: Vec<Group>,
    chain: Option<Arc>,
    circles: Vec<FullCircle>,
}

impl CircleRecorder {
    /// Takes a servo tick.
    pub(super) fn push(&mut self, point: &ContourPoint) {
        if !point.moving {
            return;
        }
        let (file, line) = (point.block.span.file, point.block.span.line);
        if (file, line) != (self.file, self.line) || point.rapid {
            self.close();
            if point.rapid {
                self.chain = None;
                return;
            }
            (self.file, self.line) = (file, line);
            (self.group, self.filled) = (1, 1);
            self.start_s = point.time_s;
            self.last_normal = [0.0; 3];
        }
        // Along a straight line the normal stays: nothing to hold.
        if point.normal.map(f64::to_bits) == self.last_normal.map(f64::to_bits) {
            return;
        }
        self.last_normal = point.normal;
        // In the plane of the circle alone: the contour error has what is across the plane, too.
        let off_um = 1e3 * dot(sub(point.actual_mm, point.foot_mm), point.normal);
        if self.filled < self.group
            && let Some(last) = self.groups.last_mut()
        {
            last.low_um = last.low_um.min(off_um);
            last.high_um = last.high_um.max(off_um);
            self.filled += 1;
            return;
        }
        if self.groups.len() >= 2 * MOST_GROUPS {
            join(&mut self.groups);
            self.group *= 2;
        }
        self.groups.push(Group {
            foot_mm: point.foot_mm,
            normal: point.normal,
            low_um: off_um,
            high_um: off_um,
        });
        self.filled = 1;
    }

    /// A block has ended: if it is an arc it goes on with the one before or begins a new one.
    fn close(&mut self) {
        let groups = std::mem::take(&mut self.groups);
        // A line that no block has.
        let line = std::mem::replace(&mut self.line, u32::MAX);
        let Some(arc) = Arc::of(groups, line, self.start_s) else {
            return;
        };
        let mut chain = match self.chain.take() {
            Some(chain) if chain.goes_on(&arc) => chain.joined(arc),
            _ => arc,
        };
        if chain.sweep < TAU * (1.0 - MISSING) {
            self.chain = Some(chain);
            return;
        }
        while chain.groups.len() > 2 * MOST_GROUPS {
            join(&mut chain.groups);
        }
        if let Some(circle) = chain.circle() {
            self.circles.push(circle);
        }
        // Only the worst are kept of a program with thousands of holes.
        if self.circles.len() > 4 * MOST_CIRCLES {
            self.sort();
        }
    }

    fn sort(&mut self) {
        pair(&mut self.circles);
        self.circles.sort_by(|a, b| {
            let by_size = b.g_um.total_cmp(&a.g_um);
            by_size.then(a.time_s.total_cmp(&b.time_s))
        });
        self.circles.truncate(MOST_CIRCLES);
    }

    /// The circles with the largest circular deviation, worst first.
    pub(super) fn finish(mut self) -> Vec<FullCircle> {
        self.close();
        self.sort();
        self.circles
    }
}

/// Joins pairs of neighbours.
fn join(groups: &mut Vec<Group>) {
    *groups = groups
        .chunks(2)
        .filter_map(|pair| {
            let first = pair.first()?;
            let last = pair.last()?;
            Some(Group {
                low_um: first.low_um.min(last.low_um),
                high_um: first.high_um.max(last.high_um),
                ..*first
            })
        })
        .collect();
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn along(a: [f64; 3], by: f64, n: [f64; 3]) -> [f64; 3] {
    [a[0] + by * n[0], a[1] + by * n[1], a[2] + by * n[2]]
}

impl Arc {
    /// The circle that ticks lie on, if they do.
    fn of(groups: Vec<Group>, line: u32, time_s: f64) -> Option<Arc> {
        let first = *groups.first()?;
        let turned = |group: &Group| {
            let turn = sub(group.normal, first.normal);
            dot(turn, turn)
        };
        let far = groups
            .iter()
            .max_by(|a, b| turned(a).total_cmp(&turned(b)))?;
        let square = turned(far);
        // Less than half a degree: a line, or too little to tell.
        if square.is_nan() || square < 1e-4 || groups.len() < 4 {
            return None;
        }
        // foot + radius * normal is the centre for all: the radius by least squares of two of them.
        let turn = sub(far.normal, first.normal);
        let radius_mm = -dot(sub(far.foot_mm, first.foot_mm), turn) / square;
        let center_mm = along(first.foot_mm, radius_mm, first.normal);
        let off = OFF_CIRCLE * radius_mm.abs();
        let lies_on = |group: &Group| {
            let miss = sub(along(group.foot_mm, radius_mm, group.normal), center_mm);
            dot(miss, miss).sqrt() <= off
        };
        let inside = (RADII_MM[0]..=RADII_MM[1]).contains(&radius_mm.abs());
        if !inside || !groups.iter().all(lies_on) {
            return None;
        }
        let sweep = groups.windows(2).map(|pair| match pair {
            [a, b] => math::acos(dot(a.normal, b.normal).clamp(-1.0, 1.0)),
            _ => 0.0,
        });
        Some(Arc {
            center_mm,
            radius_mm,
            sweep: sweep.sum(),
            line,
            time_s,
            groups,
        })
    }

    /// Whether another arc goes on around the same centre in the same sense.
    fn goes_on(&self, next: &Arc) -> bool {
        let shift = sub(next.center_mm, self.center_mm);
        let off = 2.0 * OFF_CIRCLE * self.radius_mm.abs();
        dot(shift, shift).sqrt() <= off && (next.radius_mm - self.radius_mm).abs() <= off
    }

    fn joined(mut self, mut next: Arc) -> Arc {
        self.sweep += next.sweep;
        self.groups.append(&mut next.groups);
        self
    }

    /// The circular test, in a plane of two axes.
    fn circle(&self) -> Option<FullCircle> {
        let first = self.groups.first()?;
        let quarter = self
            .groups
            .iter()
            .min_by(|a, b| {
                let of = |group: &Group| dot(group.normal, first.normal).abs();
                of(a).total_cmp(&of(b))
            })?
            .normal;
        let [a, b] = [first.normal, quarter];
        let axis = [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ];
        let plane = [(Plane::Xy, 2), (Plane::Zx, 1), (Plane::Yz, 0)]
            .into_iter()
            .find(|(_, normal)| axis[*normal].abs() > 0.999)?
            .0;
        let [one, two, _] = plane.axes();
        // Towards the centre is inwards.
        let outwards = -self.radius_mm.signum();
        let radius_mm = self.radius_mm.abs();
        let center_mm = [self.center_mm[one], self.center_mm[two]];
        let mut radial_um = vec![[f32::NAN; 2]; PARTS];
        let mut tips = Vec::with_capacity(2 * self.groups.len());
        for group in &self.groups {
            let (x, y) = (
                group.foot_mm[one] - center_mm[0],
                group.foot_mm[two] - center_mm[1],
            );
            let angle = math::atan2(y, x);
            let part = (angle / TAU + 1.0) * PARTS as f64;
            let ends = [group.low_um * outwards, group.high_um * outwards];
            if let Some([low, high]) = radial_um.get_mut(part as usize % PARTS) {
                *low = low.min(ends[0] as f32).min(ends[1] as f32);
                *high = high.max(ends[0] as f32).max(ends[1] as f32);
            }
            let (sin, cos) = math::sin_cos(angle);
            for deviation_um in ends {
                let radius = radius_mm + 1e-3 * deviation_um;
                let mut tip = [0.0; 3];
                tip[one] = center_mm[0] + radius * cos;
                tip[two] = center_mm[1] + radius * sin;
                tips.push(tip);
            }
        }
        let nominal = Circle {
            plane,
            center_mm,
            radius_mm,
        };
        let found = nominal.deviation(&tips).ok()?;
        // Counter-clockwise the left of travel is inwards.
        Some(FullCircle {
            line: self.line,
            time_s: self.time_s,
            plane,
            center_mm,
            radius_mm,
            counterclockwise: self.is_counterclockwise(one, two),
            radial_um,
            g_um: 1e3 * found.circular_mm,
            f_um: [1e3 * found.radial_min_mm, 1e3 * found.radial_max_mm],
            h_um: None,
        })
    }

    /// By the turn of the first groups from the plane's first axis to its second.
    fn is_counterclockwise(&self, one: usize, two: usize) -> bool {
        let turn = |pair: &[Group]| match pair {
            [a, b] => a.normal[one] * b.normal[two] - a.normal[two] * b.normal[one],
            _ => 0.0,
        };
        self.groups.windows(2).map(turn).sum::<f64>() > 0.0
    }
}

/// The same circle in the other sense.
pub(super) fn partner<'a>(this: &FullCircle, all: &'a [FullCircle]) -> Option<&'a FullCircle> {
    let off = OFF_CIRCLE * this.radius_mm;
    let near = |a: f64, b: f64| (a - b).abs() <= off;
    all.iter().find(|other| {
        other.counterclockwise != this.counterclockwise
            && other.plane == this.plane
            && near(other.radius_mm, this.radius_mm)
            && near(other.center_mm[0], this.center_mm[0])
            && near(other.center_mm[1], this.center_mm[1])
    })
}

/// Circular hysteresis H of circles that are cut in both senses: the largest difference between the
/// two paths.
fn pair(circles: &mut [FullCircle]) {
    for index in 0..circles.len() {
        let this = &circles[index];
        let h = partner(this, circles).map(|other| {
            let parts = this.radial_um.iter().zip(&other.radial_um);
            parts
                .flat_map(|(a, b)| [(a[1] - b[0]).abs(), (b[1] - a[0]).abs()])
                .fold(0.0_f32, f32::max)
        });
        circles[index].h_um = h.map(f64::from).or(this.h_um);
    }
}
