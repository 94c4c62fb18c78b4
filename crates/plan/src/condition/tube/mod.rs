//! A smooth curve inside the tube of the program, in place of lines and arcs that meet at small angles.
//!
//! The curve is a cubic spline with the least integral of its squared third derivative that stays
//! within P of the lines and passes every vertex within P. Its breaks follow from the shape of the
//! lines, not from their number: dense points are thinned, and long lines get breaks inside. The fit
//! knows the tube at its sites alone; what is output is proven, all of it, by the hull of its control
//! points, and narrowed where that leaves the tube.

mod fit;
mod found;
mod paced;
mod passage;
mod spline;
mod swing;
mod way;

use crate::piece::Piece;
use fit::{Fit, Site, Squared};
pub(super) use found::Found;
use lostmotion_base::vec::{Vec3, along, dot, norm, scale, sub};
use lostmotion_base::{Coords, threads};
use lostmotion_path::{Curve, HermiteEnd, Quintic};
use paced::Paced;
use spline::Breaks;
use std::ops::Range;
pub(crate) use swing::LinearJoint;
pub(super) use way::Way;

/// Part of the tolerance that the curve is aimed at at its sites. A choice: what lies between two
/// sites needs the rest.
const AIMED_PART: f64 = 0.985;
/// Part of the tolerance within which the lines are proven to be followed: all but rounding.
const PROVEN_PART: f64 = 1.0 - 1e-9;
/// Part of the tolerance within which each vertex is proven to be passed: the chord between two
/// samples lies beside the curve, as for corners that are rounded in time.
const VERTEX_PART: f64 = 0.998;
/// How often the tube is narrowed where the curve leaves it between its sites. A choice: one to four
/// times are needed.
const MAX_NARROWINGS: usize = 8;
/// Factor on the excess by which the tube is narrowed, and what is added to it each time: what is
/// narrowed in one place may come out in another.
const NARROWED: [f64; 2] = [1.2, 0.4];
/// Bounds of the factor on a radius.
const NARROW_FACTORS: [f64; 2] = [0.5, 0.99];
/// Intervals to either side of what is narrowed that are found again. A choice: the smoothest curve forgets
/// what lies farther away than two turns from side to side, of about eight pieces each.
const NARROWED_REACH: usize = 16;
/// Halvings of a stretch whose hull leaves the tube. A choice: each quarters the hull's distance
/// from the curve.
const HULL_HALVINGS: u32 = 3;
/// Sites in each interval, besides the vertices that are left when the lines are thinned. A choice:
/// three cost a quarter more and change no time by more than 1 %.
const SITES: usize = 2;
/// How roughly the smoothest curve is found before the tube is narrowed. A choice: with 1 the fits take a
/// fifth more steps, and times are 0.03 % shorter; with 4 or more some are 1 % longer.
const FIRST_ROUGH: f64 = 3.2;

/// Difference of a rate from one that is rounding.
const LENGTH_ROUNDING: f64 = 1e-9;

/// How the curve begins or ends.
// On the stack for a moment, twice a curve.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug)]
pub(super) enum Tie {
    /// At the programmed point, in any direction: the motion rests there, or the curve will be found
    /// again with what follows.
    Place,
    /// With the derivatives of what lies beyond.
    State(HermiteEnd),
}

impl Tie {
    /// The same with a parameter that goes as the length does.
    fn by_length(self) -> Tie {
        let Tie::State(state) = self else {
            return self;
        };
        let (d1, d2) = (state.d1.linear(), state.d2.linear());
        let square = dot(d1, d1);
        let d1 = scale(d1, 1.0 / square.sqrt());
        Tie::State(HermiteEnd {
            d1: linear(d1),
            d2: linear(scale(along(d2, d1, -dot(d1, d2)), 1.0 / square)),
            ..state
        })
    }

    /// Whether the parameter goes as the length does, but for rounding.
    fn is_by_length(&self) -> bool {
        let Tie::State(state) = self else {
            return true;
        };
        let (d1, d2) = (state.d1.linear(), state.d2.linear());
        (dot(d1, d1) - 1.0).abs() < LENGTH_ROUNDING
            && dot(d1, d2).abs() < LENGTH_ROUNDING * norm(d2)
    }

    fn direction(&self) -> Option<Vec3> {
        match self {
            Tie::Place => None,
            Tie::State(end) => Some(end.d1.linear()),
        }
    }
}

/// The smoothest curve at a steady pace.
#[derive(Debug)]
struct Steady<'a> {
    /// The way with other parameters, where the curve passes its vertices elsewhere than they said.
    passed: Option<Way<'a>>,
    /// `None` where it could not be proven: it may still lead to one that can.
    found: Option<Found>,
    breaks: Breaks,
    /// Its states at the breaks, by the length.
    states: Vec<HermiteEnd>,
}

/// How many pieces the curve along a way will have; 0 where there will be none.
pub(super) fn pieces(way: &Way<'_>, ties: [Tie; 2]) -> usize {
    way.breaks(ties.map(|tie| tie.direction()))
        .map_or(0, |breaks| breaks.intervals())
}

/// The curve along a way: the fastest one that is found, or the smoothest one; `None` where none can
/// be proven. On so many threads its motions are found side by side.
pub(super) fn curve(
    way: &Way<'_>,
    ties: [Tie; 2],
    joints: &[LinearJoint],
    threads: usize,
) -> Option<Found> {
    let Steady {
        passed,
        found,
        breaks,
        states,
    } = steady(way, ties)?;
    let way = passed.as_ref().unwrap_or(way);
    let motion = |way: &Way<'_>, ties, start: (&Breaks, &[HermiteEnd]), is_proven| {
        let (paced, speeds) = swing::curve(way, ties, start, joints, is_proven)?;
        let found = assembled(&paced.way, &paced.breaks, &paced.states)?;
        let speeds = speeds.windows(2).map(|pair| Some([pair[0], pair[1]]));
        Some(Found {
            speeds: speeds.collect(),
            ..found
        })
    };
    let Some(mut found) = found else {
        return motion(way, ties, (&breaks, &states), false);
    };
    let busy = swing::busy(way, (&breaks, &states), joints);
    // Each begins and ends as the steady curve goes on, so that none needs another one.
    let find = |stretch: Range<usize>| {
        let Range { start, end } = stretch;
        if stretch.len() == breaks.intervals() {
            return (stretch, motion(way, ties, (&breaks, &states), true));
        }
        let under = |k: usize| Some(*found.places.get(k.checked_sub(1)?)?);
        let part = way.part([breaks.0[start], breaks.0[end]], [under(start), under(end)]);
        let inner = |k: usize| Tie::State(found.ends[k - 1]);
        let from = if start == 0 { ties[0] } else { inner(start) };
        let to = if end == breaks.intervals() {
            ties[1]
        } else {
            inner(end)
        };
        let of_part = Breaks(
            breaks.0[start..=end]
                .iter()
                .map(|w| w - breaks.0[start])
                .collect(),
        );
        let states = &states[start..=end];
        (stretch, motion(&part, [from, to], (&of_part, states), true))
    };
    let motions = threads::map(threads, busy.into_iter(), find);
    // From the last one, so that the places of those before it stay.
    for (stretch, motion) in motions.into_iter().rev() {
        if let Some(motion) = motion {
            found.replace(stretch, motion);
        }
    }
    Some(found)
}

/// The smoothest curve along a way; `None` where it is too short to have any.
fn steady<'a>(way: &Way<'a>, given: [Tie; 2]) -> Option<Steady<'a>> {
    let ties = given.map(Tie::by_length);
    let breaks = way.breaks(ties.map(|tie| tie.direction()))?;
    let count = breaks.coefficients();
    let mut walk = way.walk();
    let mut coefficients: Vec<Vec3> = (0..count)
        .map(|j| walk.to(breaks.greville(j)).place())
        .collect();
    // Other vertices may share the parameter of an end.
    coefficients[0] = way.vertex(0);
    coefficients[count - 1] = way.vertex(way.legs());
    let head = tie(
        ties[0],
        1.0,
        breaks.first_widths()?,
        coefficients.iter_mut(),
    );
    let tail = tie(
        ties[1],
        -1.0,
        breaks.last_widths()?,
        coefficients.iter_mut().rev(),
    );
    if head + tail >= count {
        return None;
    }
    let mut fit = Fit::new(&breaks, Squared, head..count - tail).roughly(FIRST_ROUGH);
    let mut sites = sites(way, &breaks);
    let (mut found, mut passed) = (None, None);
    let mut narrowed: Vec<usize> = Vec::new();
    // Before the first time that parts were found again; nothing once that did not help.
    let mut whole = Some(None);
    let mut round = 0;
    while round < MAX_NARROWINGS {
        // What lies far from what was narrowed stays as it is.
        let near = around(&narrowed, breaks.intervals());
        let settled = match &mut whole {
            Some(before) if !near.is_empty() => {
                before.get_or_insert_with(|| (round, coefficients.clone(), sites.clone()));
                near.into_iter()
                    .all(|part| fit.solve_part(part, &mut coefficients, &mut sites))
            }
            _ => fit.solve(&mut coefficients, &mut sites),
        };
        let states = breaks.states(&coefficients);
        let (mut paced, mut excess) = looked_at(way, &given, (&breaks, &states))?;
        passed = None;
        if !excess.is_none() && way.is_rough() {
            // It may pass its vertices elsewhere than their parameters say.
            let ahead = |vertex| way.passing(vertex);
            let w = passage::passed(way, (&breaks, &states), ahead, way.parameters(), |_, _| ());
            let elsewhere = way.with_parameters(w);
            let other = looked_at(&elsewhere, &given, (&breaks, &states))?;
            if other.1.misses() < excess.misses() {
                (paced, excess) = other;
                passed = Some(elsewhere);
            }
        }
        let way = passed.as_ref().unwrap_or(way);
        if excess.is_none() {
            found = match &paced {
                Some(paced) => assembled(&paced.way, &paced.breaks, &paced.states),
                None => assembled(way, &breaks, &states),
            };
            break;
        }
        round += 1;
        fit = fit.roughly(1.0);
        // A fit that does not settle again will not.
        if (!settled && round > 1) || round == MAX_NARROWINGS {
            // All of it may have more freedom than the parts have.
            let Some(Some(before)) = whole.take() else {
                break;
            };
            (round, coefficients, sites) = before;
            narrowed.clear();
            continue;
        }
        narrowed = excess.narrow(&mut sites, round - 1, |k, vertex| {
            let w = way.end_of(vertex.max(1) - 1);
            let radius = AIMED_PART * way.vertex_tolerance(vertex);
            Site::new(&breaks, k, w, way.vertex(vertex), radius)
        });
    }
    let states = breaks.states(&coefficients);
    Some(Steady {
        passed,
        found,
        breaks,
        states,
    })
}

/// Where a curve leaves the tube; and the curve by its parameter, where that does not go as the length does since
/// that of what lies beyond does not. `None` where a piece has no length.
fn looked_at<'a>(
    way: &Way<'a>,
    given: &[Tie; 2],
    (breaks, states): (&Breaks, &[HermiteEnd]),
) -> Option<(Option<Paced<'a>>, TubeExcess)> {
    if given.iter().all(Tie::is_by_length) {
        let cubic =
            |k: usize| Cubic::new(&states[k], &states[k + 1], breaks.0[k + 1] - breaks.0[k]);
        return Some((None, TubeExcess::new(way, breaks, cubic)));
    }
    let paced = Paced::new(way, given, (breaks, states), way.parameters())?;
    let excess = paced.excess()?;
    Some((Some(paced), excess))
}

/// The parts of a curve of so many intervals that are found again where some of them were narrowed, in
/// order; none where that is all of it.
fn around(narrowed: &[usize], all: usize) -> Vec<Range<usize>> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    for k in narrowed {
        let part = k.saturating_sub(NARROWED_REACH)..(k + 1 + NARROWED_REACH).min(all);
        match parts.last_mut() {
            Some(last) if part.start <= last.end => last.end = last.end.max(part.end),
            _ => parts.push(part),
        }
    }
    if parts.first() == Some(&(0..all)) {
        parts.clear();
    }
    parts
}

/// Sets the coefficients that an end gives, from the end inwards; returns how many. `sign` is that
/// of the direction inwards.
fn tie<'a>(
    tie: Tie,
    sign: f64,
    [h, g]: [f64; 2],
    mut coefficients: impl Iterator<Item = &'a mut Vec3>,
) -> usize {
    let Tie::State(HermiteEnd { p, d1, d2 }) = tie else {
        return 1;
    };
    let (p, d1, d2) = (p.linear(), d1.linear(), d2.linear());
    // Differences of the coefficients are the first derivative's coefficients, over a third of
    // their spans; the first of these is d1, and d2 leads to the second one.
    let second: Vec3 = std::array::from_fn(|axis| sign * d1[axis] + 0.5 * h * d2[axis]);
    let first = along(p, d1, sign * h / 3.0);
    let given = [p, first, along(first, second, (h + g) / 3.0)];
    for value in given {
        if let Some(coefficient) = coefficients.next() {
            *coefficient = value;
        }
    }
    given.len()
}

fn sites(way: &Way<'_>, breaks: &Breaks) -> Vec<Site> {
    let (first, last) = (breaks.0[0], breaks.0[breaks.intervals()]);
    let even = breaks.0.windows(2).flat_map(|pair| {
        let step = (pair[1] - pair[0]) / SITES as f64;
        (0..SITES).map(move |k| pair[0] + step * k as f64)
    });
    let mut places: Vec<f64> = even.chain(way.corners()).collect();
    places.sort_by(f64::total_cmp);
    let mut walk = way.walk();
    places
        .into_iter()
        .filter(|w| *w > first && *w < last)
        .map(|w| {
            let at = walk.to(w);
            let radius = AIMED_PART * at.tolerance();
            Site::new(breaks, breaks.interval(w), w, at.place(), radius)
        })
        .collect()
}

/// Where a curve leaves the tube, by intervals, in parts of what is allowed.
#[derive(Debug)]
struct TubeExcess {
    sides: Vec<f64>,
    /// The vertex that is missed by most.
    vertices: Vec<(f64, usize)>,
}

impl TubeExcess {
    fn new<S: TubeStretch>(
        way: &Way<'_>,
        breaks: &Breaks,
        stretch: impl Fn(usize) -> S,
    ) -> TubeExcess {
        let mut excess = TubeExcess {
            sides: vec![0.0; breaks.intervals()],
            vertices: vec![(0.0, 0); breaks.intervals()],
        };
        let mut line = 0;
        for k in 0..breaks.intervals() {
            let (a, b) = (breaks.0[k], breaks.0[k + 1]);
            let curve = stretch(k);
            let mut left = curve.place(0.0);
            // Each line by itself.
            loop {
                let to = way.end_of(line).min(b);
                let right = curve.place(to - a);
                let tolerance = way.leg_tolerance(line);
                let enough = PROVEN_PART * tolerance;
                let most = curve.farthest(way, line, [left, right], enough, HULL_HALVINGS);
                excess.sides[k] = excess.sides[k].max(most / enough);
                left = right;
                if way.end_of(line) > b || line + 1 == way.legs() {
                    break;
                }
                line += 1;
                if !way.is_programmed(line) {
                    continue;
                }
                let near = VERTEX_PART * way.vertex_tolerance(line);
                let off = norm(sub(curve.point(&right), way.vertex(line))) / near;
                if off > excess.vertices[k].0 {
                    excess.vertices[k] = (off, line);
                }
            }
        }
        excess
    }

    fn is_none(&self) -> bool {
        self.sides.iter().all(|part| *part <= 1.0)
            && self.vertices.iter().all(|(part, _)| *part <= 1.0)
    }

    /// In how many intervals a side or a vertex is missed.
    fn misses(&self) -> usize {
        let sides = self.sides.iter().filter(|part| **part > 1.0).count();
        sides + self.vertices.iter().filter(|(part, _)| *part > 1.0).count()
    }

    /// Makes sites of the vertices that are missed, given interval and vertex, and narrows the tube
    /// where that is not enough; returns the intervals with sites that are new or narrowed, in order.
    fn narrow(
        mut self,
        sites: &mut Vec<Site>,
        round: usize,
        site_at: impl Fn(usize, usize) -> Site,
    ) -> Vec<usize> {
        let mut changed = Vec::new();
        for (k, (part, vertex)) in self.vertices.into_iter().enumerate() {
            let is_known = |new: &Site| {
                sites
                    .iter()
                    .any(|site| site.w == new.w && site.place == new.place)
            };
            let new = (part > 1.0 && part >= self.sides[k]).then(|| site_at(k, vertex));
            if let Some(new) = new.filter(|new| !is_known(new)) {
                sites.push(new);
                changed.push(k);
                self.sides[k] = 0.0;
            } else {
                self.sides[k] = self.sides[k].max(part);
            }
        }
        // In the order of their intervals, as the fit takes them.
        sites.sort_by_key(|site| site.interval);
        let factor = NARROWED[0] + NARROWED[1] * round as f64;
        let reach = round.min(2);
        for site in sites {
            let k = site.interval;
            let around = &self.sides[k.saturating_sub(reach)..self.sides.len().min(k + reach + 1)];
            let most = around.iter().copied().fold(0.0, f64::max);
            if most > 1.0 {
                let [least, longest] = NARROW_FACTORS;
                site.narrow((1.0 - factor * (most - AIMED_PART)).clamp(least, longest));
                changed.push(k);
            }
        }
        changed.sort_unstable();
        changed
    }
}

/// One interval of a curve.
trait TubeStretch {
    /// A place on it.
    type Place: Copy;

    fn place(&self, x: f64) -> Self::Place;
    fn point(&self, place: &Self::Place) -> Vec3;

    /// Bound of its distance from a line between two places, by the hull of the control points
    /// there; that of the halves is nearer to the curve.
    fn farthest(
        &self,
        way: &Way<'_>,
        line: usize,
        ends: [Self::Place; 2],
        enough: f64,
        halvings: u32,
    ) -> f64;
}

/// An interval of a cubic spline.
#[derive(Clone, Copy, Debug)]
struct Cubic {
    p: Vec3,
    d1: Vec3,
    d2: Vec3,
    d3: Vec3,
}

/// A place on it, with the first derivative.
#[derive(Clone, Copy, Debug)]
struct CubicPlace {
    x: f64,
    p: Vec3,
    d1: Vec3,
}

impl Cubic {
    fn new(from: &HermiteEnd, to: &HermiteEnd, width: f64) -> Cubic {
        let (first, last) = (from.d2.linear(), to.d2.linear());
        Cubic {
            p: from.p.linear(),
            d1: from.d1.linear(),
            d2: first,
            d3: std::array::from_fn(|axis| (last[axis] - first[axis]) / width),
        }
    }

    fn at(&self, x: f64) -> CubicPlace {
        let Cubic { p, d1, d2, d3 } = self;
        CubicPlace {
            x,
            p: std::array::from_fn(|i| p[i] + (d1[i] + (0.5 * d2[i] + d3[i] / 6.0 * x) * x) * x),
            d1: std::array::from_fn(|i| d1[i] + (d2[i] + 0.5 * d3[i] * x) * x),
        }
    }
}

impl TubeStretch for Cubic {
    type Place = CubicPlace;

    fn place(&self, x: f64) -> CubicPlace {
        self.at(x)
    }

    fn point(&self, place: &CubicPlace) -> Vec3 {
        place.p
    }

    fn farthest(
        &self,
        way: &Way<'_>,
        line: usize,
        [left, right]: [CubicPlace; 2],
        enough: f64,
        halvings: u32,
    ) -> f64 {
        let third = (right.x - left.x) / 3.0;
        let hull = [
            left.p,
            along(left.p, left.d1, third),
            along(right.p, right.d1, -third),
            right.p,
        ];
        let most = way.off(line, &hull);
        if most <= enough || halvings == 0 || third <= 0.0 {
            return most;
        }
        let middle = self.at(0.5 * (left.x + right.x));
        [[left, middle], [middle, right]]
            .map(|half| self.farthest(way, line, half, enough, halvings - 1))
            .into_iter()
            .fold(0.0, f64::max)
    }
}

impl TubeStretch for Quintic {
    type Place = f64;

    fn place(&self, x: f64) -> f64 {
        x
    }

    fn point(&self, x: &f64) -> Vec3 {
        Quintic::point(self, x.min(self.length())).linear()
    }

    fn farthest(
        &self,
        way: &Way<'_>,
        line: usize,
        [left, right]: [f64; 2],
        enough: f64,
        halvings: u32,
    ) -> f64 {
        let hull = self
            .sub(left, right.min(self.length()))
            .control_points()
            .map(|point| point.linear());
        let most = way.off(line, &hull);
        if most <= enough || halvings == 0 || right <= left {
            return most;
        }
        let middle = 0.5 * (left + right);
        [[left, middle], [middle, right]]
            .map(|half| self.farthest(way, line, half, enough, halvings - 1))
            .into_iter()
            .fold(0.0, f64::max)
    }
}

/// The pieces of a curve with the moves under them.
fn assembled(way: &Way<'_>, breaks: &Breaks, states: &[HermiteEnd]) -> Option<Found> {
    let count = breaks.intervals();
    let states: Vec<HermiteEnd> = states.iter().map(|state| way.whole(state)).collect();
    let mut found = Found {
        pieces: Vec::with_capacity(count),
        ends: states[1..].to_vec(),
        places: Vec::with_capacity(count),
        speeds: vec![None; count],
    };
    let mut leg = 0;
    for (w, ends) in breaks.0.windows(2).zip(states.windows(2)) {
        while way.end_of(leg) <= w[0] && leg + 1 < way.legs() {
            leg += 1;
        }
        let curve = Quintic::hermite(ends[0], ends[1], w[1] - w[0]).ok()?;
        let first = way.line(leg);
        let (mut feed, mut heeds) = (first.feed, first.heeds);
        let (mark, mut place) = way.under(leg, &curve, [w[0], w[1]]);
        let mut marks = vec![mark];
        while way.end_of(leg) < w[1] && leg + 1 < way.legs() {
            leg += 1;
            let next = way.line(leg);
            (feed, heeds) = (feed.min(next.feed), heeds.max(next.heeds));
            let mark;
            (mark, place) = way.under(leg, &curve, [w[0], w[1]]);
            marks.push(mark);
        }
        found.places.push(place);
        found.pieces.push(Piece {
            curve: Curve::Quintic(curve),
            marks: [*marks.first()?, *marks.last()?],
            more: if marks.len() > 2 {
                marks.into()
            } else {
                Box::default()
            },
            feed,
            heeds,
            tool_mm: first.tool_mm,
        });
    }
    Some(found)
}

/// Square of the distance of a point from a straight stretch.
fn square_to(point: Vec3, from: Vec3, to: Vec3) -> f64 {
    let (ab, ap) = (sub(to, from), sub(point, from));
    let square = dot(ab, ab);
    let part = if square > 0.0 {
        (dot(ap, ab) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let off = along(ap, ab, -part);
    dot(off, off)
}

/// Coordinates of X Y Z.
fn linear(place: Vec3) -> Coords {
    Coords::xyz(place[0], place[1], place[2])
}
