//! A smooth curve inside the tube of the program, in place of many lines that meet at small angles.
//!
//! The curve is a cubic spline whose third derivative is least in the mean, at most P from every
//! point of the lines at the same parameter: so neither the sides nor the vertices are left by more.
//! Its breaks follow from the shape of the lines, not from their number: dense points are thinned,
//! and long lines get breaks inside. What is output is proven, all of it, by the hull of its control
//! points.

mod fit;
mod spline;
mod way;

use crate::piece::{Mark, Piece, Programmed};
use fit::{Problem, Site};
use lostmotion_base::Coords;
use lostmotion_base::vec::{Vec3, along, dot, norm, sub};
use lostmotion_path::{Curve, HermiteEnd, Quintic};
use spline::{Breaks, ORDER, combined};
pub(super) use way::Way;

/// Part of the tolerance that the curve is aimed at at its sites. A choice: what lies between two
/// sites needs the rest.
const AIMED_PART: f64 = 0.985;
/// Part of the tolerance within which the lines are proven to be followed: all but rounding.
const PROVEN_PART: f64 = 1.0 - 1e-9;
/// Part of the tolerance within which each vertex is proven to be passed: the chord between two
/// samples lies beside the curve. As for corners that are rounded in time.
const VERTEX_PART: f64 = 0.998;
/// How often the tube is narrowed where the curve leaves it between its sites.
const MAX_NARROWINGS: usize = 8;
/// Halvings of a stretch whose hull leaves the tube.
const HALVINGS: u32 = 3;
/// Sites within each interval.
const SITES: usize = 2;

/// How the curve begins or ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum End {
    /// At the programmed point, in any direction: the motion rests there, or it will be solved for
    /// again.
    Free,
    /// As what lies beyond says.
    Tied(HermiteEnd),
}

/// A curve that was found.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) pieces: Vec<Piece>,
    /// The state at the end of each piece.
    pub(super) ends: Vec<HermiteEnd>,
    /// Line and parameter on it at the end of each piece.
    pub(super) places: Vec<(usize, f64)>,
}

/// How many pieces the curve along a way will have; 0 where there will be none.
pub(super) fn pieces_of(way: &Way<'_>, start: End, end: End) -> usize {
    way.breaks([start.direction(), end.direction()])
        .map_or(0, |breaks| breaks.intervals())
}

impl End {
    fn direction(&self) -> Option<Vec3> {
        match self {
            End::Free => None,
            End::Tied(end) => Some(end.d1.linear()),
        }
    }
}

/// The curve along a way; `None` where none can be proven.
pub(super) fn curve(way: &Way<'_>, start: End, end: End) -> Option<Found> {
    let breaks = way.breaks([start.direction(), end.direction()])?;
    let count = breaks.coefficients();
    let mut coefficients: Vec<Vec3> = (0..count)
        .map(|j| way.place(breaks.greville(j)))
        .collect();
    // Vertices may share the parameter of an end.
    coefficients[0] = way.vertex(0);
    coefficients[count - 1] = way.vertex(way.lines());
    let (head, tail) = (
        tie(&breaks.0, &mut coefficients, start, 1.0),
        {
            let reversed: Vec<f64> = breaks.0.iter().rev().map(|t| -t).collect();
            coefficients.reverse();
            let tied = tie(&reversed, &mut coefficients, end, -1.0);
            coefficients.reverse();
            tied
        },
    );
    if head + tail >= count {
        return None;
    }
    let weights: Vec<f64> = breaks.0.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut sites = sites(way, &breaks);
    let problem = Problem {
        breaks: &breaks,
        free: head..count - tail,
        weights: &weights,
    };
    for round in 0..MAX_NARROWINGS {
        let good = problem.solve(&mut coefficients, &mut sites);
        if std::env::var("TUBE_DEBUG").is_ok() { eprintln!("solved {good} breaks {} sites {}", breaks.0.len(), sites.len()); }
        let knots = knots(&breaks, &coefficients);
        if narrow(way, &breaks, &knots, &mut sites, round) {
            return assembled(way, &breaks, &knots);
        }
        if !good && round > 0 {
            return None;
        }
    }
    None
}

/// Sets the coefficients that an end gives; returns how many.
fn tie(breaks: &[f64], coefficients: &mut [Vec3], end: End, sign: f64) -> usize {
    let End::Tied(HermiteEnd { p, d1, d2 }) = end else {
        return 1;
    };
    if breaks.len() < 3 {
        return coefficients.len();
    }
    let (h, g) = (breaks[1] - breaks[0], breaks[2] - breaks[1]);
    let (p, d1, d2) = (p.linear(), d1.linear(), d2.linear());
    // The first differences of the coefficients are those of the first derivative, over a third of
    // their spans.
    let second: Vec3 = std::array::from_fn(|axis| sign * d1[axis] + 0.5 * h * d2[axis]);
    coefficients[0] = p;
    coefficients[1] = along(p, d1, sign * h / 3.0);
    coefficients[2] = along(coefficients[1], second, (h + g) / 3.0);
    3
}

fn sites(way: &Way<'_>, breaks: &Breaks) -> Vec<Site> {
    let mut places: Vec<f64> = Vec::new();
    for pair in breaks.0.windows(2) {
        let n = crate::param("SITES", SITES as f64) as usize;
        let step = (pair[1] - pair[0]) / n as f64;
        places.extend((0..n).map(|k| pair[0] + step * k as f64));
    }
    places.extend(way.corners());
    places.sort_by(f64::total_cmp);
    let (first, last) = (breaks.0[0], breaks.0[breaks.intervals()]);
    places
        .into_iter()
        .filter(|w| *w > first && *w < last)
        .map(|w| Site::new(breaks, w, way.place(w), AIMED_PART * way.tolerance(w)))
        .collect()
}

/// State at a break, and the third derivative from there on.
#[derive(Clone, Copy, Debug)]
struct Knot {
    p: Vec3,
    d1: Vec3,
    d2: Vec3,
}

fn knots(breaks: &Breaks, coefficients: &[Vec3]) -> Vec<Knot> {
    (0..breaks.0.len())
        .map(|k| {
            let interval = k.min(breaks.intervals() - 1);
            let [d1, d2] = breaks.derivatives(coefficients, k);
            Knot {
                p: combined(
                    &coefficients[interval..interval + ORDER],
                    &breaks.basis(interval, breaks.0[k]),
                ),
                d1,
                d2,
            }
        })
        .collect()
}

/// Narrows the tube where the curve leaves it; returns whether it nowhere does.
fn narrow(way: &Way<'_>, breaks: &Breaks, knots: &[Knot], sites: &mut Vec<Site>, round: usize) -> bool {
    let mut excess = vec![0.0_f64; breaks.intervals()];
    // The vertex that is farthest from each interval.
    let mut missed = vec![(0.0_f64, 0); breaks.intervals()];
    let mut line = 0;
    let mut inside = true;
    for (k, pair) in knots.windows(2).enumerate() {
        let (a, b) = (breaks.0[k], breaks.0[k + 1]);
        let h = b - a;
        let third: Vec3 = std::array::from_fn(|axis| (pair[1].d2[axis] - pair[0].d2[axis]) / h);
        let at = |w: f64| -> [Vec3; 2] {
            let x = w - a;
            let Knot { p, d1, d2 } = pair[0];
            [
                std::array::from_fn(|i| {
                    p[i] + (d1[i] + (0.5 * d2[i] + third[i] / 6.0 * x) * x) * x
                }),
                std::array::from_fn(|i| d1[i] + (d2[i] + 0.5 * third[i] * x) * x),
            ]
        };
        let mut from = a;
        let mut left = at(a);
        loop {
            // Each line by itself.
            let to = way.end_of(line).min(b);
            let right = at(to);
            let tolerance = way.line_tolerance(line);
            let most = farthest(way, line, &at, [(from, left), (to, right)], PROVEN_PART * tolerance, HALVINGS);
            let mut part = most / tolerance;
            if to < b || way.end_of(line) <= b {
                // A vertex is passed within the tolerance, too.
                let near = VERTEX_PART * way.vertex_tolerance(line + 1);
                let off = norm(sub(right[0], way.vertex(line + 1))) / near;
                part = part.max(off);
                if off > missed[k].0 {
                    missed[k] = (off, line + 1);
                }
            }
            excess[k] = excess[k].max(part);
            inside &= part <= PROVEN_PART;
            if to >= b {
                break;
            }
            line += 1;
            from = to;
            left = right;
        }
        // The next interval may begin on the next line.
        while way.end_of(line) <= b && line + 1 < way.lines() {
            line += 1;
        }
    }
    if std::env::var("TUBE_DEBUG").is_ok() { eprintln!("   excess {:.4}", excess.iter().copied().fold(0.0, f64::max)); }
    if !inside {
        let multiplier = sites.iter().map(|site| site.multiplier).sum::<f64>() / sites.len() as f64;
        for (k, (off, vertex)) in missed.into_iter().enumerate() {
            let w = way.end_of(vertex.max(1) - 1);
            let known = |site: &Site| site.w == w && site.place == way.vertex(vertex);
            if off > PROVEN_PART && off >= excess[k] && !sites.iter().any(known) {
                let radius = AIMED_PART * way.vertex_tolerance(vertex);
                sites.push(Site::between(breaks, k, w, way.vertex(vertex), radius, multiplier));
                excess[k] = 0.0;
            }
        }
        for site in sites.iter_mut() {
            // What is narrowed in one place may come out in another: more and more at a time.
            let (k, reach) = (site.interval, round.min(2));
            let around = &excess[k.saturating_sub(reach)..excess.len().min(k + reach + 1)];
            let most = around.iter().copied().fold(0.0, f64::max);
            if most > PROVEN_PART {
                let factor = 1.2 + 0.4 * round as f64;
                site.narrow((1.0 - factor * (most - AIMED_PART)).clamp(0.5, 0.99));
            }
        }
    }
    inside
}

/// Bound of the distance from a line, by the hull of the control points between two places; that
/// of the halves is nearer to the curve.
fn farthest(way: &Way<'_>, line: usize, at: &impl Fn(f64) -> [Vec3; 2], [left, right]: [(f64, [Vec3; 2]); 2], enough: f64, halvings: u32) -> f64 {
    let part = (right.0 - left.0) / 3.0;
    let most = way.off(line, [left.1[0], along(left.1[0], left.1[1], part), along(right.1[0], right.1[1], -part), right.1[0]]);
    if most <= enough || halvings == 0 || part <= 0.0 {
        return most;
    }
    let middle = 0.5 * (left.0 + right.0);
    let middle = (middle, at(middle));
    farthest(way, line, at, [left, middle], enough, halvings - 1).max(farthest(way, line, at, [middle, right], enough, halvings - 1))
}

fn assembled(way: &Way<'_>, breaks: &Breaks, knots: &[Knot]) -> Option<Found> {
    let coords = |v: Vec3| Coords::xyz(v[0], v[1], v[2]);
    let ends: Vec<HermiteEnd> = knots
        .iter()
        .map(|knot| HermiteEnd {
            p: way.whole(coords(knot.p)),
            d1: coords(knot.d1),
            d2: coords(knot.d2),
        })
        .collect();
    let mut found = Found {
        pieces: Vec::with_capacity(breaks.intervals()),
        ends: ends[1..].to_vec(),
        places: Vec::with_capacity(breaks.intervals()),
    };
    let mut line = 0;
    for (pair, ends) in breaks.0.windows(2).zip(ends.windows(2)) {
        let (a, b) = (pair[0], pair[1]);
        let quintic = Quintic::hermite(ends[0], ends[1], b - a).ok()?;
        while way.end_of(line) <= a && line + 1 < way.lines() {
            line += 1;
        }
        let mut marks: Vec<Mark> = Vec::new();
        let first: &Programmed = way.line(line);
        let (mut feed, mut heeds) = (first.feed, first.heeds);
        let mut last = line;
        loop {
            let moved = way.line(last);
            feed = feed.min(moved.feed);
            heeds = heeds.max(moved.heeds);
            marks.push(way.mark(last, a));
            if way.end_of(last) >= b || last + 1 >= way.lines() {
                break;
            }
            last += 1;
        }
        let ends = [marks.first().copied()?, marks.last().copied()?];
        found.pieces.push(Piece {
            curve: Curve::Quintic(quintic),
            marks: ends,
            more: if marks.len() > 2 { marks.into() } else { Box::default() },
            feed,
            heeds,
            tool_mm: first.tool_mm,
        });
        found.places.push(way.parameter(last, b));
    }
    Some(found)
}

/// Square of the distance of a point from a stretch of line.
fn square_to(point: Vec3, from: Vec3, to: Vec3) -> f64 {
    let (ab, ap) = (sub(to, from), sub(point, from));
    let square = dot(ab, ab);
    let part = if square > 0.0 {
        (dot(ap, ab) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let off = sub(ap, ab.map(|c| c * part));
    dot(off, off)
}
