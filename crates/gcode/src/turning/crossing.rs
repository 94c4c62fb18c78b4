//! Where the lines and circles of pieces cross.

use super::piece::{Circle, Piece, Point, along, cross, direction, distance, dot, left_of, minus};

/// Where two pieces cross, prolonged without end: both places where circles are concerned. Circles
/// and lines that miss each other by no more than `forgiven` are taken to touch.
pub(crate) fn crossings(a: &Piece, b: &Piece, forgiven: f64) -> Option<[Point; 2]> {
    between((a, a.radius()), (b, b.radius()), forgiven)
}

/// The same for pieces of which the second follows the first. Where the ends of an arc have
/// slightly different radii, the one that counts is that of the end which stays where it is (as
/// recorded).
pub(crate) fn joints(a: &Piece, b: &Piece, forgiven: f64) -> Option<[Point; 2]> {
    between(
        (a, a.radius()),
        (b, b.circle.map(|circle| distance(circle.center, b.end))),
        forgiven,
    )
}

fn between(
    (a, a_radius): (&Piece, Option<f64>),
    (b, b_radius): (&Piece, Option<f64>),
    forgiven: f64,
) -> Option<[Point; 2]> {
    match (a.circle, b.circle) {
        (None, None) => {
            let (u, v) = (direction(a.start, a.end), direction(b.start, b.end));
            let slope = cross(u, v);
            if slope.abs() < 1e-12 {
                return None;
            }
            Some([along(a.start, u, cross(minus(b.start, a.start), v) / slope); 2])
        }
        (None, Some(circle)) => line_circle(a, circle, b_radius?, forgiven),
        (Some(circle), None) => line_circle(b, circle, a_radius?, forgiven),
        (Some(c), Some(d)) => circles((c.center, a_radius?), (d.center, b_radius?), forgiven),
    }
}

fn line_circle(line: &Piece, circle: Circle, radius: f64, forgiven: f64) -> Option<[Point; 2]> {
    let u = direction(line.start, line.end);
    let foot = along(line.start, u, dot(minus(circle.center, line.start), u));
    let away = distance(foot, circle.center);
    if away > radius + forgiven {
        return None;
    }
    let half = (radius * radius - away * away).max(0.0).sqrt();
    Some([along(foot, u, -half), along(foot, u, half)])
}

fn circles((c, r): (Point, f64), (d, s): (Point, f64), forgiven: f64) -> Option<[Point; 2]> {
    let gap = distance(c, d);
    if gap < 1e-12 || gap > r + s + forgiven || gap < (r - s).abs() - forgiven {
        return None;
    }
    let u = direction(c, d);
    let to_foot = ((gap * gap + r * r - s * s) / (2.0 * gap)).clamp(-r, r);
    let half = (r * r - to_foot * to_foot).max(0.0).sqrt();
    let foot = along(c, u, to_foot);
    Some([
        along(foot, left_of(u), half),
        along(foot, left_of(u), -half),
    ])
}
