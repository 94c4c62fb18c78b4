//! The programmed moves under a curve, and a parameter along them that does not depend on how finely
//! they are cut.
//!
//! An arc is taken as chords so short that a small part of the tolerance makes up for them.
//! The lines are thinned to a polyline that passes within a part of the tolerance of their vertices.
//! Its length is the parameter: that of the lines themselves grows with the rounding of their ends.
//! Breaks of the spline lie near each other where the thinned polyline turns much.

use super::spline::Breaks;
use super::square_to;
use crate::piece::{Mark, Programmed};
use lostmotion_base::vec::{Vec3, dot, norm, sub};
use lostmotion_path::{Curve, HermiteEnd, Quintic};

/// Part of the tolerance within which the vertices are thinned.
const THINNED_PART: f64 = 0.5;
/// The same of a rough way, whose vertices lie about the tolerance beside what they stand for. A choice: nearly
/// all of it, so that no corner of what is left is one of theirs.
const ROUGH_PART: f64 = 0.98;
/// A way is rough where that leaves less than one leg of so many. A choice: along a smooth curve it leaves one of
/// 1.4, two at most where halves are halved.
const ROUGH_LEGS: usize = 2;
/// Vertices of a way that may be rough, at least.
const LEAST_ROUGH: usize = 8;
/// Distance of breaks at a corner, in units of the tolerance over the angle. Measured.
const CORNER_STEP: f64 = 1.0;
/// The same where the curve begins or ends in a given direction.
const END_STEP: f64 = 1.0;
/// Part of the tolerance by which the chords of an arc may lie beside it. A choice: less makes more
/// chords, more leaves less to the curve.
const SAGITTA_PART: f64 = 1.0 / 32.0;
/// Most chords of one arc. A choice: bounds memory, and the arcs of a section have far fewer.
const MAX_CHORDS: f64 = 4096.0;
/// Part of the way between its neighbours that a break keeps from either when it is moved. A choice:
/// less makes the spline ill-conditioned.
const LEAST_ROOM: f64 = 0.15;
/// Growth of the distance of breaks with the way from the corner. Measured.
const STEP_GROWTH: f64 = 0.35;

/// A straight stretch of the way: a line or a chord of an arc.
#[derive(Clone, Copy, Debug)]
struct TubeLeg {
    /// The move under it, and the parameters on that at its ends.
    line: usize,
    from: f64,
    to: f64,
}

/// Moves with the parts of the first and the last one that belong to the curve.
#[derive(Debug)]
pub(crate) struct Way<'a> {
    lines: &'a [Programmed],
    legs: Vec<TubeLeg>,
    /// First place, ends of the legs, last place.
    vertices: Vec<Vec3>,
    /// The parameter at each of them; never falls.
    w: Vec<f64>,
    /// Which of them are left when thinned.
    kept: Vec<usize>,
    /// Of each leg.
    tolerances: Vec<f64>,
    is_rough: bool,
}

impl<'a> Way<'a> {
    /// The moves from a parameter on the first to one on the last, each with its tolerance; `None`
    /// where there are none, or an arc is too long.
    pub(crate) fn new(
        lines: &'a [Programmed],
        from: f64,
        to: f64,
        allowed: &[f64],
    ) -> Option<Way<'a>> {
        let first = lines.first()?;
        let mut legs = Vec::with_capacity(lines.len());
        let mut vertices = Vec::with_capacity(lines.len() + 1);
        let mut tolerances = Vec::with_capacity(lines.len());
        vertices.push(first.curve.point(from).linear());
        for (k, (line, allowed)) in lines.iter().zip(allowed).enumerate() {
            let from = if k == 0 { from } else { 0.0 };
            let to = if k + 1 == lines.len() {
                to
            } else {
                line.length
            };
            let chords = chords(line, [from, to], SAGITTA_PART * allowed);
            if chords > MAX_CHORDS {
                return None;
            }
            let tolerance = if chords > 1.0 {
                (1.0 - SAGITTA_PART) * allowed
            } else {
                *allowed
            };
            let place = |j: usize| from + (to - from) * (j as f64 / chords);
            for j in 0..chords as usize {
                let to = if j + 1 == chords as usize {
                    to
                } else {
                    place(j + 1)
                };
                legs.push(TubeLeg {
                    line: k,
                    from: place(j),
                    to,
                });
                vertices.push(if to == line.length {
                    line.curve.end().linear()
                } else {
                    line.curve.point(to).linear()
                });
                tolerances.push(tolerance);
            }
        }
        let least = tolerances.iter().copied().fold(f64::INFINITY, f64::min);
        let mut is_rough = false;
        let mut kept = thinned(&vertices, THINNED_PART * least);
        if kept.len() > LEAST_ROUGH {
            let smooth = thinned(&vertices, ROUGH_PART * least);
            is_rough = kept.len() > ROUGH_LEGS * smooth.len();
            if is_rough {
                kept = smooth;
            }
        }
        Some(Way {
            lines,
            legs,
            w: projected(&vertices, &kept),
            vertices,
            kept,
            tolerances,
            is_rough,
        })
    }

    /// The way between two parameters, each with the move under it there and the parameter on that
    /// where they are known; its own parameter begins at 0.
    pub(super) fn part(
        &self,
        [start, end]: [f64; 2],
        [from, to]: [Option<(usize, f64)>; 2],
    ) -> Way<'a> {
        let first = self.at(start);
        let last = self
            .w
            .partition_point(|w| *w < end)
            .clamp(first + 1, self.legs.len())
            - 1;
        let mut legs = self.legs[first..=last].to_vec();
        let on = |leg: &TubeLeg, given: Option<(usize, f64)>| {
            let (line, at) = given?;
            (line == leg.line).then(|| at.clamp(leg.from, leg.to))
        };
        let count = legs.len();
        if let Some(from) = on(&legs[0], from) {
            legs[0].from = from;
        }
        if let Some(to) = on(&legs[count - 1], to) {
            legs[count - 1].to = to;
        }
        let mut vertices = self.vertices[first..=last + 1].to_vec();
        let on_line = |leg: &TubeLeg, at: f64| self.lines[leg.line].curve.point(at).linear();
        vertices[0] = on_line(&legs[0], legs[0].from);
        vertices[count] = on_line(&legs[count - 1], legs[count - 1].to);
        let mut w: Vec<f64> = self.w[first..=last + 1]
            .iter()
            .map(|w| w.clamp(start, end) - start)
            .collect();
        (w[0], w[count]) = (0.0, end - start);
        let inner = self.kept.iter().filter(|k| (first + 1..=last).contains(k));
        let mut kept = vec![0];
        kept.extend(inner.map(|k| k - first));
        kept.push(count);
        Way {
            lines: self.lines,
            legs,
            vertices,
            w,
            kept,
            tolerances: self.tolerances[first..=last].to_vec(),
            is_rough: self.is_rough,
        }
    }

    pub(super) fn legs(&self) -> usize {
        self.legs.len()
    }

    /// The move under leg k.
    pub(super) fn line(&self, k: usize) -> &Programmed {
        &self.lines[self.legs[k].line]
    }

    /// Whether a move ends where leg k begins.
    pub(super) fn is_programmed(&self, k: usize) -> bool {
        k == 0 || self.legs[k].line != self.legs[k - 1].line
    }

    /// The parameter where leg k ends.
    pub(super) fn end_of(&self, k: usize) -> f64 {
        self.w[k + 1]
    }

    /// The parameter at each vertex, the ends among them.
    pub(super) fn parameters(&self) -> &[f64] {
        &self.w
    }

    /// The same way with another parameter at each vertex.
    pub(super) fn with_parameters(&self, w: Vec<f64>) -> Way<'a> {
        Way {
            lines: self.lines,
            legs: self.legs.clone(),
            vertices: self.vertices.clone(),
            w,
            kept: self.kept.clone(),
            tolerances: self.tolerances.clone(),
            is_rough: self.is_rough,
        }
    }

    pub(super) fn least_tolerance(&self) -> f64 {
        self.tolerances
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min)
    }

    /// The same way thinned as if it were not rough.
    pub(in crate::condition) fn finely_thinned(self) -> Way<'a> {
        let kept = thinned(&self.vertices, THINNED_PART * self.least_tolerance());
        Way {
            w: projected(&self.vertices, &kept),
            kept,
            is_rough: false,
            ..self
        }
    }

    /// Whether its vertices lie about the tolerance beside what they stand for, so that a smooth curve inside the
    /// tube may pass them elsewhere than their parameters say.
    pub(in crate::condition) fn is_rough(&self) -> bool {
        self.is_rough
    }

    /// The thinned vertices between the ends.
    pub(super) fn inner_corners(&self) -> &[usize] {
        match self.kept.as_slice() {
            [_, inner @ .., _] => inner,
            _ => &[],
        }
    }

    /// Goes along it from its start.
    pub(super) fn walk(&self) -> WayWalk<'_, 'a> {
        WayWalk {
            way: self,
            w: 0.0,
            leg: 0,
            corner: 0,
            heading: self.thinned_leg(0),
        }
    }

    /// Where the thinned way leads to past a vertex, of unit length: at one that is left the mean of
    /// before and after.
    pub(super) fn passing(&self, vertex: usize) -> Vec3 {
        let before = self.thinned_leg(self.kept.partition_point(|k| *k < vertex));
        let next = self.thinned_leg(self.kept.partition_point(|k| *k <= vertex));
        unit(std::array::from_fn(|i| before[i] + next[i]))
    }

    /// Direction of the leg of the thinned way that ends at its vertex `end`, or the nearest there is; of
    /// unit length, or zero.
    fn thinned_leg(&self, end: usize) -> Vec3 {
        let end = end.clamp(1, self.kept.len() - 1);
        let [a, b] = [self.kept[end - 1], self.kept[end]].map(|k| self.vertices[k]);
        unit(sub(b, a))
    }

    pub(super) fn vertex(&self, k: usize) -> Vec3 {
        self.vertices[k]
    }

    pub(super) fn leg_tolerance(&self, k: usize) -> f64 {
        self.tolerances[k]
    }

    pub(super) fn vertex_tolerance(&self, k: usize) -> f64 {
        let before = self.tolerances[k.saturating_sub(1)];
        self.tolerances
            .get(k)
            .map_or(before, |next| next.min(before))
    }

    /// Distance of the farthest of some points from leg k.
    pub(super) fn off(&self, k: usize, points: &[Vec3]) -> f64 {
        let (a, b) = (self.vertices[k], self.vertices[k + 1]);
        points
            .iter()
            .map(|p| square_to(*p, a, b))
            .fold(0.0, f64::max)
            .sqrt()
    }

    /// The leg that holds a parameter.
    fn at(&self, w: f64) -> usize {
        self.w
            .partition_point(|at| *at <= w)
            .clamp(1, self.legs.len())
            - 1
    }

    /// The thinned vertices between the ends.
    pub(super) fn corners(&self) -> impl Iterator<Item = f64> + '_ {
        self.kept.iter().map(|k| self.w[*k])
    }

    /// A state with the coordinates that no line changes.
    pub(super) fn whole(&self, state: &HermiteEnd) -> HermiteEnd {
        let mut p = self.lines[0].curve.start();
        p.0[..3].copy_from_slice(&state.p.0[..3]);
        HermiteEnd { p, ..*state }
    }

    /// The move under leg k as it lies under a piece of curve, given the parameters of the piece's
    /// ends; and which move that is, with the parameter on it where the leg or the piece ends.
    pub(super) fn under(
        &self,
        k: usize,
        curve: &Quintic,
        [start, end]: [f64; 2],
    ) -> (Mark, (usize, f64)) {
        let TubeLeg { line, from, to } = self.legs[k];
        let (a, b) = (self.w[k].max(start), self.w[k + 1].min(end));
        // The foot of what is on the curve there.
        let foot = |w: f64| {
            let point = curve.point((w - start).min(curve.length())).linear();
            let (a, b) = (self.vertices[k], self.vertices[k + 1]);
            let ab = sub(b, a);
            let square = dot(ab, ab).max(f64::MIN_POSITIVE);
            from + (to - from) * (dot(sub(point, a), ab) / square).clamp(0.0, 1.0)
        };
        let first = if self.w[k] >= start { from } else { foot(a) };
        let last = if self.w[k + 1] <= end { to } else { foot(b) };
        let rate = if b > a {
            (last - first).max(0.0) / (b - a)
        } else {
            0.0
        };
        let mark = Mark {
            rate,
            ..self.line(k).mark(a - start, first)
        };
        (mark, (line, last))
    }

    /// Breaks of the spline; `None` where the way is too short to have any.
    pub(super) fn breaks(&self, ends: [Option<Vec3>; 2]) -> Option<Breaks> {
        let end = *self.w.last()?;
        // The distance of breaks that each corner asks for.
        let turned = |d: Vec3, e: Vec3| {
            let (x, y) = (norm(d), norm(e));
            norm(sub(d.map(|v| v / x), e.map(|v| v / y)))
        };
        let mut corners: Vec<[f64; 2]> = Vec::with_capacity(self.kept.len());
        if let (Some(given), [a, b, ..]) = (ends[0], self.kept.as_slice()) {
            let turn = turned(given, sub(self.vertices[*b], self.vertices[*a]));
            corners.push([0.0, END_STEP * self.vertex_tolerance(0) / turn]);
        }
        let inner = self.kept.windows(3).filter_map(|three| {
            let [a, b, c] = [three[0], three[1], three[2]].map(|k| self.vertices[k]);
            let (d, e) = (sub(b, a), sub(c, b));
            let turn = turned(d, e);
            let step = CORNER_STEP * self.vertex_tolerance(three[1]) / turn;
            (turn > 0.0).then(|| [self.w[three[1]], step])
        });
        corners.extend(inner);
        if let (Some(given), [.., a, b]) = (ends[1], self.kept.as_slice()) {
            let turn = turned(given, sub(self.vertices[*b], self.vertices[*a]));
            corners.push([end, END_STEP * self.vertex_tolerance(*b) / turn]);
        }
        if end <= 0.0 {
            return None;
        }
        // Density 1 / h is integrated over a fine walk: h is the least of cones around the corners.
        let mut walk: Vec<[f64; 2]> = Vec::new();
        let mut next = 0;
        let mut w = 0.0;
        let mut cone = |w: f64| {
            while next + 1 < corners.len() && corners[next + 1][0] <= w {
                next += 1;
            }
            let from = next.saturating_sub(3);
            corners[from..corners.len().min(next + 5)]
                .iter()
                .map(|[at, step]| step + STEP_GROWTH * (w - at).abs())
                .fold(0.25 * end, f64::min)
        };
        while w < end {
            let h = cone(w);
            walk.push([w, h]);
            if walk.len() > MAX_BREAKS {
                return None;
            }
            w += h;
        }
        if walk.len() < 4 {
            return Some(Breaks((0..=4).map(|k| 0.25 * end * f64::from(k)).collect()));
        }
        // No stub at the end.
        while walk.len() > 4 && walk.last().is_some_and(|[w, h]| end - w < 0.5 * h) {
            walk.pop();
        }
        let mut breaks: Vec<f64> = walk.iter().map(|[w, _]| *w).collect();
        breaks.push(end);
        self.snap(&mut breaks);
        Some(Breaks(breaks))
    }

    /// Moves breaks to where the feed changes: a piece goes at the least feed under it.
    fn snap(&self, breaks: &mut [f64]) {
        let mut k = 1;
        for (pair, w) in self.legs.windows(2).zip(&self.w[1..]) {
            let pair = [pair[0], pair[1]].map(|leg| &self.lines[leg.line]);
            if pair[0].feed == pair[1].feed && pair[0].heeds == pair[1].heeds {
                continue;
            }
            while k + 1 < breaks.len() && breaks[k] < *w {
                k += 1;
            }
            // The nearer one of the two around it, but for the ends, where that leaves room.
            let near = if w - breaks[k - 1] < breaks[k] - w {
                k - 1
            } else {
                k
            };
            if near > 0
                && near + 1 < breaks.len()
                && (w - breaks[near - 1]).min(breaks[near + 1] - w)
                    > LEAST_ROOM * (breaks[near + 1] - breaks[near - 1])
            {
                breaks[near] = *w;
            }
        }
    }
}

/// A place on a way, from which one goes on to larger parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct WayWalk<'w, 'a> {
    way: &'w Way<'a>,
    /// The parameter.
    w: f64,
    /// The leg that holds it.
    leg: usize,
    /// How many of the thinned vertices lie before it or at it.
    corner: usize,
    /// Where the thinned way leads to.
    heading: Vec3,
}

impl WayWalk<'_, '_> {
    /// Goes on to a parameter.
    pub(super) fn to(&mut self, w: f64) -> &Self {
        let Way { w: ends, kept, .. } = self.way;
        self.w = w;
        while self.leg + 1 < self.way.legs() && ends[self.leg + 1] <= w {
            self.leg += 1;
        }
        let before = self.corner;
        while self.corner < kept.len() && ends[kept[self.corner]] <= w {
            self.corner += 1;
        }
        if self.corner > before {
            self.heading = self.way.thinned_leg(self.corner);
        }
        self
    }

    /// Largest speed there.
    pub(super) fn feed(&self) -> f64 {
        self.way.line(self.leg).feed
    }

    /// Where the thinned way leads to, of unit length, or zero.
    pub(super) fn heading(&self) -> Vec3 {
        self.heading
    }

    /// The programmed place.
    pub(super) fn place(&self) -> Vec3 {
        let (way, k) = (self.way, self.leg);
        let (a, b) = (way.vertices[k], way.vertices[k + 1]);
        let span = way.w[k + 1] - way.w[k];
        let part = if span > 0.0 {
            ((self.w - way.w[k]) / span).clamp(0.0, 1.0)
        } else {
            0.0
        };
        std::array::from_fn(|i| a[i] + (b[i] - a[i]) * part)
    }

    /// The tolerance: the lesser one at a vertex.
    pub(super) fn tolerance(&self) -> f64 {
        let (way, k) = (self.way, self.leg);
        if way.w[k] == self.w {
            way.vertex_tolerance(k)
        } else {
            way.tolerances[k]
        }
    }
}

/// Most breaks of one curve.
const MAX_BREAKS: usize = 4096;

/// Of unit length, or zero.
pub(super) fn unit(vector: Vec3) -> Vec3 {
    let length = norm(vector);
    if length > 0.0 {
        vector.map(|value| value / length)
    } else {
        [0.0; 3]
    }
}

/// Number of chords between two parameters of a move that lie within a distance of it.
fn chords(line: &Programmed, [from, to]: [f64; 2], distance: f64) -> f64 {
    if !matches!(line.curve, Curve::Arc(_)) {
        return 1.0;
    }
    // The sagitta of a chord c is c^2 k / 8; the curvature of a spiral is largest at an end.
    let bend = [from, to].map(|s| norm(line.curve.eval(s).d2.linear()));
    let chord = (8.0 * distance / bend[0].max(bend[1])).sqrt();
    ((to - from) / chord).ceil().max(1.0)
}

/// How far along the thinned polyline each vertex lies; never falls.
fn projected(vertices: &[Vec3], kept: &[usize]) -> Vec<f64> {
    let mut w = vec![0.0; vertices.len()];
    for pair in kept.windows(2) {
        let (a, b) = (vertices[pair[0]], vertices[pair[1]]);
        let delta = sub(b, a);
        let length = norm(delta);
        let start = w[pair[0]];
        for k in pair[0] + 1..pair[1] {
            let along = dot(sub(vertices[k], a), delta) / length.max(f64::MIN_POSITIVE);
            w[k] = (start + along.clamp(0.0, length)).max(w[k - 1]);
        }
        w[pair[1]] = start + length;
    }
    w
}

/// Which vertices are left so that the others lie within a distance (Douglas and Peucker).
fn thinned(vertices: &[Vec3], distance: f64) -> Vec<usize> {
    let square = distance * distance;
    let mut kept = vec![0];
    let mut open = vec![(0, vertices.len() - 1)];
    while let Some((a, b)) = open.pop() {
        let (mut worst, mut at) = (square, None);
        for k in a + 1..b {
            let off = square_to(vertices[k], vertices[a], vertices[b]);
            if off > worst {
                (worst, at) = (off, Some(k));
            }
        }
        match at {
            // The first half comes first.
            Some(k) => open.extend([(k, b), (a, k)]),
            None => kept.push(b),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Legs of one length and of none: on a walk each parameter finds the leg that a search finds, with the place on
    /// it, where the thinned way leads to, and the lesser tolerance at a vertex.
    #[test]
    fn a_walk_finds_what_a_search_finds() {
        let leg = TubeLeg {
            line: 0,
            from: 0.0,
            to: 1.0,
        };
        let way = Way {
            lines: &[],
            legs: vec![leg; 4],
            vertices: vec![
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [1.0, 3.0, 0.0],
            ],
            w: vec![0.0, 1.0, 1.0, 2.0, 4.0],
            kept: vec![0, 1, 4],
            tolerances: vec![0.4, 0.1, 0.3, 0.2],
            is_rough: false,
        };
        let mut walk = way.walk();
        for step in 0..=18 {
            let w = 0.25 * f64::from(step);
            let at = walk.to(w);
            assert_eq!(at.leg, way.at(w), "{w}");
            let past = w.clamp(1.0, 4.0) - 1.0;
            assert_eq!(at.place(), [w.min(1.0), past, 0.0], "{w}");
            let ahead = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            assert_eq!(at.heading(), ahead[usize::from(w >= 1.0)], "{w}");
            let tolerance = match w {
                w if w < 1.0 => 0.4,
                1.0 => 0.1,
                w if w < 2.0 => 0.3,
                _ => 0.2,
            };
            assert_eq!(at.tolerance(), tolerance, "{w}");
        }
    }
}
