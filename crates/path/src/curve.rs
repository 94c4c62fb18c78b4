//! A curve of any kind, with the operations that all kinds have.

use crate::derivs::within;
use crate::{Arc, Bounds, CurveDerivs, Foot, Line, Quintic};
use lostmotion_base::vec::{cross, norm};
use lostmotion_base::{AXES, Coords, Jet, Plane};
use serde::{Deserialize, Serialize};

/// How far the box may reach beyond the curve, mm or rad. A choice: a nanometre, far below the
/// accuracy of any travel limit.
const BOX_TOLERANCE: f64 = 1e-6;
/// Most halvings of a curve in the search for its box, which also bounds the recursion. A choice:
/// each quarters the bulge, so that 24 reduce a metre to far below [`BOX_TOLERANCE`].
const MAX_BOX_HALVINGS: u32 = 24;

/// A piece of path.
///
/// Large but `Copy`: curves lie in bounded windows, never in a list of a whole program.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Curve {
    /// Straight in all axes.
    Line(Line),
    /// Circular, helical or spiral in X Y Z, other axes linear.
    Arc(Arc),
    /// A polynomial piece of degree five in each axis (blends, smoothed runs).
    Quintic(Quintic),
}

impl From<Line> for Curve {
    fn from(line: Line) -> Curve {
        Curve::Line(line)
    }
}

impl From<Arc> for Curve {
    fn from(arc: Arc) -> Curve {
        Curve::Arc(arc)
    }
}

impl From<Quintic> for Curve {
    fn from(quintic: Quintic) -> Curve {
        Curve::Quintic(quintic)
    }
}

impl Curve {
    /// A straight move.
    pub fn line(start: Coords, end: Coords) -> Curve {
        Curve::Line(Line::new(start, end))
    }

    /// Range of `s`: mm, or degrees where only rotary axes move; 0 where nothing does.
    pub fn length(&self) -> f64 {
        match self {
            Curve::Line(line) => line.length(),
            Curve::Arc(arc) => arc.length(),
            Curve::Quintic(quintic) => quintic.length(),
        }
    }

    /// Where it begins, mm and rad.
    pub fn start(&self) -> Coords {
        match self {
            Curve::Line(line) => line.start(),
            Curve::Arc(arc) => arc.start(),
            Curve::Quintic(quintic) => quintic.start(),
        }
    }

    /// Where it ends, mm and rad.
    pub fn end(&self) -> Coords {
        match self {
            Curve::Line(line) => line.end(),
            Curve::Arc(arc) => arc.end(),
            Curve::Quintic(quintic) => quintic.end(),
        }
    }

    /// The point at s, mm and rad; an s outside of the curve gives the end there.
    pub fn point(&self, s: f64) -> Coords {
        match self {
            Curve::Line(line) => line.point(s),
            Curve::Arc(arc) => arc.point(s),
            Curve::Quintic(quintic) => quintic.point(s),
        }
    }

    /// Point and derivatives by s; an s outside of the curve gives those of the end there.
    pub fn eval(&self, s: f64) -> CurveDerivs {
        match self {
            Curve::Line(line) => line.eval(s),
            Curve::Arc(arc) => arc.eval(s),
            Curve::Quintic(quintic) => quintic.eval(s),
        }
    }

    /// Place, velocity and acceleration by time where s has the given speed and acceleration: mm or
    /// rad, per s, per s2.
    pub fn travel(&self, s: f64, v: f64, a: f64) -> [Coords; 3] {
        match self {
            Curve::Line(line) => [line.point(s), line.direction() * v, line.direction() * a],
            Curve::Arc(arc) => {
                // The chain rule by time: p' v, and p'' v^2 + p' a.
                let CurveDerivs { p, d1, d2, .. } = arc.eval(s);
                [p, d1 * v, d2 * v * v + d1 * a]
            }
            Curve::Quintic(quintic) => quintic.travel(s, v, a),
        }
    }

    /// The same as [`Curve::eval`], one jet per axis.
    ///
    /// ```
    /// use lostmotion_base::{Coords, Jet};
    /// use lostmotion_path::Curve;
    ///
    /// let line = Curve::line(Coords::ZERO, Coords::xyz(0.0, 0.0, -8.0));
    /// assert_eq!(line.jet(3.0)[2], Jet::new(-3.0, -1.0, 0.0, 0.0));
    /// ```
    pub fn jet(&self, s: f64) -> [Jet; AXES] {
        self.eval(s).jets()
    }

    /// Unit tangent in X Y Z; zero where X Y Z stand still.
    pub fn tangent(&self, s: f64) -> [f64; 3] {
        // A line has one direction: nothing else of it is wanted.
        let d1 = match self {
            Curve::Line(line) => line.direction().linear(),
            Curve::Arc(_) | Curve::Quintic(_) => self.eval(s).d1.linear(),
        };
        let speed = norm(d1);
        if speed > 0.0 {
            d1.map(|c| c / speed)
        } else {
            [0.0; 3]
        }
    }

    /// Curvature in X Y Z, 1/mm; zero where X Y Z stand still.
    pub fn curvature(&self, s: f64) -> f64 {
        let derivs = self.eval(s);
        let (d1, d2) = (derivs.d1.linear(), derivs.d2.linear());
        let speed = norm(d1);
        if speed > 0.0 {
            // |p' x p''| / |p'|^3 holds for any parameter, such as a quintic's nominal one.
            norm(cross(d1, d2)) / (speed * speed * speed)
        } else {
            0.0
        }
    }

    /// Whether X, Y or Z move at all.
    pub fn moves_tip(&self) -> bool {
        match self {
            Curve::Line(line) => line.direction().linear() != [0.0; 3],
            Curve::Arc(arc) => arc.length() > 0.0,
            Curve::Quintic(quintic) => quintic.relative().iter().any(|p| p.linear() != [0.0; 3]),
        }
    }

    /// The point in X Y Z nearest to `point` (mm) between two s: the global minimum, to within the
    /// tolerance in distance (closed form on lines and circles, whatever the tolerance). Of a curve
    /// on which X Y Z stand still, the first s.
    pub fn nearest(&self, point: [f64; 3], range: (f64, f64), tolerance_mm: f64) -> Foot {
        let low = within(range.0, 0.0, self.length());
        // Both ends are held within the curve, and the second not before the first.
        let range = (low, within(range.1, low, self.length()));
        match self {
            Curve::Line(line) => line.nearest(point, range),
            Curve::Arc(arc) => arc.nearest(point, range, tolerance_mm),
            Curve::Quintic(quintic) => quintic.nearest(point, range, tolerance_mm),
        }
    }

    /// The stretch from `s0` to `s1`, both held within the curve.
    #[must_use]
    pub fn sub(&self, s0: f64, s1: f64) -> Curve {
        match self {
            Curve::Line(line) => Curve::Line(line.sub(s0, s1)),
            Curve::Arc(arc) => Curve::Arc(arc.sub(s0, s1)),
            Curve::Quintic(quintic) => Curve::Quintic(quintic.sub(s0, s1)),
        }
    }

    /// The same curve from a start close to its own, mm and rad: a line to the same end, others
    /// moved as a whole.
    #[must_use]
    pub fn starting_at(&self, start: Coords) -> Curve {
        let by = start - self.start();
        match self {
            Curve::Line(line) => Curve::line(start, line.end()),
            Curve::Arc(arc) => Curve::Arc(arc.moved(by)),
            Curve::Quintic(quintic) => Curve::Quintic(quintic.moved(by)),
        }
    }

    /// The parts before and after `s`.
    pub fn split_at(&self, s: f64) -> (Curve, Curve) {
        (self.sub(0.0, s), self.sub(s, self.length()))
    }

    /// The smallest and largest value of each axis: exact for lines, circles and helices, at most
    /// 1e-6 mm or rad too large, never too small, for the others.
    pub fn bounds(&self) -> Bounds {
        match self {
            Curve::Line(line) => line.bounds(),
            Curve::Arc(arc) if arc.is_circular() => arc.circle_bounds(),
            _ => search_box(self),
        }
    }

    /// Upper bounds of the magnitude of each axis' first, second and third derivative by s from
    /// `s0` to `s1`.
    pub fn max_derivatives(&self, s0: f64, s1: f64) -> (Coords, Coords, Coords) {
        match self {
            Curve::Line(line) => (line.direction().map(f64::abs), Coords::ZERO, Coords::ZERO),
            Curve::Arc(arc) => arc.max_derivatives(s0, s1),
            Curve::Quintic(quintic) => quintic.max_derivatives(s0, s1),
        }
    }

    /// Upper bounds of the magnitude of each axis' fourth and fifth derivative by s from `s0` to
    /// `s1`; on spirals generous estimates.
    pub fn higher_derivatives(&self, s0: f64, s1: f64) -> (Coords, Coords) {
        match self {
            Curve::Line(_) => (Coords::ZERO, Coords::ZERO),
            Curve::Arc(arc) => arc.higher_derivatives(),
            Curve::Quintic(quintic) => quintic.higher_derivatives(s0, s1),
        }
    }

    /// The plane of an arc; G17 for the others, whose plane is what the program has in force.
    pub fn plane(&self) -> Plane {
        match self {
            Curve::Arc(arc) => arc.plane(),
            Curve::Line(_) | Curve::Quintic(_) => Plane::default(),
        }
    }
}

/// The box around a curve, never too small and at most a nanometre too large: a stretch of length h
/// lies within M h^2 / 8 of its chord, M bounding the second derivative; stretches that could
/// reach further out than the points known so far are halved.
fn search_box(curve: &Curve) -> Bounds {
    let mut bounds = Bounds::of(curve.start(), curve.end());
    // The box of points known to be on the curve, and how far the curve may reach beyond it.
    let mut slack = Coords::ZERO;
    grow(
        curve,
        (0.0, curve.length()),
        (curve.start(), curve.end()),
        MAX_BOX_HALVINGS,
        &mut bounds,
        &mut slack,
    );
    Bounds {
        min: bounds.min - slack,
        max: bounds.max + slack,
    }
}

fn grow(
    curve: &Curve,
    (s0, s1): (f64, f64),
    (p0, p1): (Coords, Coords),
    depth: u32,
    bounds: &mut Bounds,
    slack: &mut Coords,
) {
    let second = curve.max_derivatives(s0, s1).1;
    let h = s1 - s0;
    let mut halve = false;
    let mut reach = Coords::ZERO;
    for axis in 0..AXES {
        // Distance of the curve from its chord, at most.
        let bulge = second.0[axis] * h * h / 8.0;
        let (low, high) = (p0.0[axis].min(p1.0[axis]), p0.0[axis].max(p1.0[axis]));
        // How far this stretch could reach beyond the box so far.
        let beyond = (bounds.min.0[axis] - (low - bulge)).max(high + bulge - bounds.max.0[axis]);
        halve |= beyond > BOX_TOLERANCE;
        reach.0[axis] = beyond.max(0.0);
    }
    if halve && depth > 0 {
        // A point on the curve widens the box, and quarters the bulge of both halves.
        let middle = 0.5 * (s0 + s1);
        let p = curve.point(middle);
        bounds.include(p);
        grow(curve, (s0, middle), (p0, p), depth - 1, bounds, slack);
        grow(curve, (middle, s1), (p, p1), depth - 1, bounds, slack);
    } else {
        for axis in 0..AXES {
            // Short enough: what is left is allowed for.
            slack.0[axis] = slack.0[axis].max(reach.0[axis]);
        }
    }
}
