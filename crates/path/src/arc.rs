//! Circular, helical or spiral.

use crate::arc_length::Spiral;
use crate::derivs::within;
use crate::error::finite;
use crate::{CurveDerivs, PathError, Plane};
use lostmotion_base::{Coords, Jet, math};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A difference of radii below this is rounding of the numbers that describe a circle, mm. A
/// choice: above the rounding of coordinates of 100 m, far below any programmed spiral.
const SAME_RADIUS_MM: f64 = 1e-10;

/// An arc whose end is nearer than this to its start, along the circle, is a full turn, mm. Offsets
/// and inches leave the two ends of a programmed circle some 1e-12 mm apart; a programmed
/// arc is longer than a nanometre.
const SAME_POINT_MM: f64 = 1e-6;

/// An arc as RS274 describes it.
///
/// ```
/// use lostmotion_base::{Coords, Plane};
/// use lostmotion_path::{Arc, ArcSpec, Curve};
///
/// // G2 X10 Y0 I5 with the tool at zero: half a circle, clockwise, 4 mm deep.
/// let arc = Arc::new(ArcSpec {
///     start: Coords::ZERO,
///     end: Coords::xyz(10.0, 0.0, -4.0),
///     plane: Plane::Xy,
///     center: [5.0, 0.0],
///     rotation: -1,
/// })?;
/// assert!((arc.sweep() + std::f64::consts::PI).abs() < 1e-12);
/// let helix = Curve::from(arc);
/// let middle = helix.point(0.5 * helix.length());
/// assert!((middle.linear()[1] - 5.0).abs() < 1e-12 && (middle.linear()[2] + 2.0).abs() < 1e-12);
/// # Ok::<(), lostmotion_path::PathError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcSpec {
    /// Where it begins, mm and rad.
    pub start: Coords,
    /// Where it ends, mm and rad. It need not lie on the circle through the start: the radius then
    /// changes linearly in angle.
    pub end: Coords,
    /// Plane of the circle.
    pub plane: Plane,
    /// Centre, in the order of the plane's axes ([`Plane::axes`]), mm.
    pub center: [f64; 2],
    /// Positive: counter-clockwise about the plane's normal. 1: at most one turn, 2: one turn more,
    /// and so on; negative numbers clockwise. Equal start and end angle make a full turn.
    pub rotation: i32,
}

/// Circular, helical or spiral in X Y Z by exact arc length: radius and lift along the normal are
/// linear in angle, all other axes linear in arc length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arc {
    pub(crate) start: Coords,
    pub(crate) end: Coords,
    pub(crate) plane: Plane,
    pub(crate) center: [f64; 2],
    pub(crate) start_angle: f64,
    pub(crate) sweep: f64,
    pub(crate) start_radius: f64,
    pub(crate) radius_change: f64,
    pub(crate) length: f64,
}

impl Arc {
    /// An arc between two points.
    ///
    /// # Errors
    /// Numbers that are not finite, no rotation, a start or end on the centre.
    pub fn new(spec: ArcSpec) -> Result<Arc, PathError> {
        if spec.rotation == 0 {
            return Err(PathError::NoRotation);
        }
        check(&spec)?;
        let from = from_center(&spec.start, spec.plane, spec.center);
        let to = from_center(&spec.end, spec.plane, spec.center);
        let (start_radius, end_radius) = (math::hypot(from[0], from[1]), math::hypot(to[0], to[1]));
        // A point on the centre has no angle, and so no sweep.
        for (end, radius) in [("start", start_radius), ("end", end_radius)] {
            if radius == 0.0 {
                return Err(PathError::OnCenter {
                    end,
                    first_mm: spec.center[0],
                    second_mm: spec.center[1],
                });
            }
        }
        let sweep = sweep_between(from, to, spec.rotation, start_radius);
        let change = end_radius - start_radius;
        let arc = Arc {
            start: spec.start,
            end: spec.end,
            plane: spec.plane,
            center: spec.center,
            start_angle: math::atan2(from[1], from[0]),
            sweep,
            start_radius,
            // Within rounding it is a circle or helix, whose length and bounds have closed forms.
            radius_change: if change.abs() <= SAME_RADIUS_MM {
                0.0
            } else {
                change
            },
            length: 0.0,
        };
        arc.measured()
    }

    /// With its length computed.
    fn measured(mut self) -> Result<Arc, PathError> {
        self.length = self.spiral().length(1.0);
        finite("the length of the arc", &[self.length])?;
        Ok(self)
    }

    pub(crate) fn moved(&self, by: Coords) -> Arc {
        let [first, second, _] = self.plane.axes();
        let center = [self.center[0] + by.0[first], self.center[1] + by.0[second]];
        Arc {
            start: self.start + by,
            end: self.end + by,
            center,
            ..*self
        }
    }

    /// Where it begins.
    pub const fn start(&self) -> Coords {
        self.start
    }

    /// Where it ends.
    pub const fn end(&self) -> Coords {
        self.end
    }

    /// Its length in X Y Z, mm.
    pub const fn length(&self) -> f64 {
        self.length
    }

    /// Its plane.
    pub const fn plane(&self) -> Plane {
        self.plane
    }

    /// Its centre in the order of the plane's axes, mm.
    pub const fn center(&self) -> [f64; 2] {
        self.center
    }

    /// Its signed sweep, rad; positive is counter-clockwise about the plane's normal.
    pub const fn sweep(&self) -> f64 {
        self.sweep
    }

    /// Its radius at the start, mm.
    pub const fn start_radius(&self) -> f64 {
        self.start_radius
    }

    /// Its radius at the end, mm.
    pub fn end_radius(&self) -> f64 {
        self.start_radius + self.radius_change
    }

    /// Its rise along the plane's normal, mm.
    pub fn lift(&self) -> f64 {
        let normal = self.plane.axes()[2];
        self.end.0[normal] - self.start.0[normal]
    }

    /// Whether it lies on a circle: neither spiral nor helix.
    pub fn is_circle(&self) -> bool {
        self.radius_change == 0.0 && self.lift() == 0.0
    }

    /// Whether its radius is constant: circle or helix.
    pub fn is_circular(&self) -> bool {
        self.radius_change == 0.0
    }

    pub(crate) fn spiral(&self) -> Spiral {
        let lift = self.lift();
        Spiral {
            r0: self.start_radius,
            b: self.radius_change,
            k: self.sweep.abs(),
            c2: self.radius_change * self.radius_change + lift * lift,
        }
    }

    /// Fraction of the sweep at s.
    pub(crate) fn fraction(&self, s: f64) -> f64 {
        self.spiral().fraction(s, self.length)
    }

    /// The point at s; s is held within the arc.
    pub fn point(&self, s: f64) -> Coords {
        if s <= 0.0 {
            return self.start;
        }
        if s >= self.length {
            return self.end;
        }
        self.point_at(self.fraction(s), s)
    }

    fn point_at(&self, u: f64, s: f64) -> Coords {
        let [first, second, normal] = self.plane.axes();
        let radius = self.start_radius + self.radius_change * u;
        let (sin, cos) = math::sin_cos(self.start_angle + self.sweep * u);
        // All axes linear in s, then the three of the plane by angle.
        let mut p = self.start.lerp(self.end, s / self.length);
        p.0[first] = self.center[0] + radius * cos;
        p.0[second] = self.center[1] + radius * sin;
        p.0[normal] = self.start.0[normal] + self.lift() * u;
        p
    }

    /// Point and derivatives by s.
    pub fn eval(&self, s: f64) -> CurveDerivs {
        if self.length <= 0.0 {
            return CurveDerivs {
                p: self.start,
                ..CurveDerivs::default()
            };
        }
        let u = self.fraction(s);
        let [v, a, j] = self.rates(u);
        // Derivatives of the plane's axes by u, changed to s; the other axes are linear in s.
        let jets = self.plane_jets(u);
        let slope = (self.end - self.start).map(|c| c / self.length);
        let mut derivs = CurveDerivs {
            p: self.point(s),
            d1: slope,
            ..CurveDerivs::default()
        };
        for (axis, jet) in self.plane.axes().into_iter().zip(jets) {
            let Jet([_, d1, d2, d3]) = jet.reparametrize(v, a, j);
            derivs.d1.0[axis] = d1;
            derivs.d2.0[axis] = d2;
            derivs.d3.0[axis] = d3;
        }
        derivs
    }

    /// First, second and third derivative of the fraction u by s.
    fn rates(&self, u: f64) -> [f64; 3] {
        let spiral = self.spiral();
        let w = 1.0 / spiral.speed(u);
        if spiral.b == 0.0 {
            return [w, 0.0, 0.0];
        }
        // du/ds = w(u): the further ones are w_u w and (w_uu w + w_u^2) w.
        let k2 = spiral.k * spiral.k;
        let w3 = w * w * w;
        let slope = k2 * spiral.radius(u) * spiral.b;
        let w_u = -slope * w3;
        let w_uu = -k2 * spiral.b * spiral.b * w3 + 3.0 * slope * slope * w3 * w * w;
        [w, w_u * w, (w_uu * w + w_u * w_u) * w]
    }

    /// The plane's two axes and its normal with their derivatives by u.
    pub(crate) fn plane_jets(&self, u: f64) -> [Jet; 3] {
        let (r, b, k) = (
            self.start_radius + self.radius_change * u,
            self.radius_change,
            self.sweep,
        );
        let (sin, cos) = math::sin_cos(self.start_angle + k * u);
        // Along the radius and across it; d/du turns (radial, across) into (radial' - k across,
        // across' + k radial).
        let along = [r, b, -r * k * k, -3.0 * b * k * k];
        let across = [0.0, r * k, 2.0 * b * k, -r * k * k * k];
        let mut jets = [
            Jet::default(),
            Jet::default(),
            Jet::new(self.lift() * u, self.lift(), 0.0, 0.0),
        ];
        for i in 0..4 {
            jets[0].0[i] = along[i] * cos - across[i] * sin;
            jets[1].0[i] = along[i] * sin + across[i] * cos;
        }
        let normal = self.plane.axes()[2];
        jets[0].0[0] += self.center[0];
        jets[1].0[0] += self.center[1];
        jets[2].0[0] += self.start.0[normal];
        jets
    }

    /// The stretch from `s0` to `s1`.
    pub fn sub(&self, s0: f64, s1: f64) -> Arc {
        let s0 = within(s0, 0.0, self.length);
        let s1 = within(s1, s0, self.length);
        // Radius and lift are linear in u, so that a part of a spiral is a spiral.
        let (u0, u1) = (self.fraction(s0), self.fraction(s1));
        Arc {
            start: self.point(s0),
            end: self.point(s1),
            start_angle: self.start_angle + self.sweep * u0,
            sweep: self.sweep * (u1 - u0),
            start_radius: self.start_radius + self.radius_change * u0,
            radius_change: self.radius_change * (u1 - u0),
            length: s1 - s0,
            ..*self
        }
    }
}

/// Offset from the centre in the plane: first and second axis.
fn from_center(point: &Coords, plane: Plane, center: [f64; 2]) -> [f64; 2] {
    let [first, second, _] = plane.axes();
    [point.0[first] - center[0], point.0[second] - center[1]]
}

/// Signed sweep from one offset to another, rad.
fn sweep_between(from: [f64; 2], to: [f64; 2], rotation: i32, radius: f64) -> f64 {
    let sign = if rotation > 0 { 1.0 } else { -1.0 };
    // Angle between the offsets in the sense of rotation, in (-pi, pi].
    let between = math::atan2(
        from[0] * to[1] - from[1] * to[0],
        from[0] * to[0] + from[1] * to[1],
    ) * sign;
    let smallest = SAME_POINT_MM / radius.max(SAME_POINT_MM);
    // Within one turn: the smallest angles of either sign count as the full turn that they are
    // meant to be.
    let first = if between <= smallest {
        between + TAU
    } else {
        between
    };
    // A rotation of n adds n - 1 full turns.
    sign * (first + TAU * f64::from(rotation.unsigned_abs() - 1))
}

/// Refuses numbers that are not finite.
fn check(spec: &ArcSpec) -> Result<(), PathError> {
    finite("the start of the arc", &spec.start.0)?;
    finite("the end of the arc", &spec.end.0)?;
    finite("the centre of the arc", &spec.center)
}
