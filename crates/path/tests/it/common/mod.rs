//! Random curves of every kind.
#![allow(clippy::unwrap_used, dead_code)]

use lostmotion_base::Coords;
use lostmotion_path::{Arc, ArcSpec, Curve, HermiteEnd, Line, Plane, Quintic};
use proptest::prelude::*;

pub(crate) fn coords(size: f64) -> impl Strategy<Value = Coords> {
    (
        prop::array::uniform3(-size..size),
        prop::array::uniform3(-3.0..3.0_f64),
        prop::array::uniform3(-size..size),
    )
        .prop_map(|([x, y, z], [a, b, c], [u, v, w])| Coords([x, y, z, a, b, c, u, v, w]))
}

pub(crate) fn plane() -> impl Strategy<Value = Plane> {
    prop_oneof![Just(Plane::Xy), Just(Plane::Zx), Just(Plane::Yz)]
}

pub(crate) fn line() -> impl Strategy<Value = Curve> {
    (coords(100.0), coords(100.0)).prop_map(|(a, b)| Curve::Line(Line::new(a, b)))
}

/// Circles, helices, spirals with radii that differ a little or a lot, up to three turns.
pub(crate) fn arc() -> impl Strategy<Value = Curve> {
    let radii = (
        0.5..40.0_f64,
        prop_oneof![Just(1.0), 0.999..1.001_f64, 0.3..3.0_f64],
    );
    let lift = prop_oneof![Just(0.0), -20.0..20.0_f64];
    let rotation = prop_oneof![1..4_i32, -3..0_i32];
    (
        coords(100.0),
        coords(100.0),
        plane(),
        radii,
        lift,
        prop::array::uniform2(-3.1..3.1_f64),
        rotation,
    )
        .prop_map(
            |(mut start, mut end, plane, (radius, ratio), lift, [from, to], rotation)| {
                use lostmotion_base::math::sin_cos;
                let [first, second, normal] = plane.axes();
                let center = [
                    start.0[first] - radius * sin_cos(from).1,
                    start.0[second] - radius * sin_cos(from).0,
                ];
                start.0[first] = center[0] + radius * sin_cos(from).1;
                start.0[second] = center[1] + radius * sin_cos(from).0;
                end.0[first] = center[0] + radius * ratio * sin_cos(to).1;
                end.0[second] = center[1] + radius * ratio * sin_cos(to).0;
                end.0[normal] = start.0[normal] + lift;
                Curve::Arc(
                    Arc::new(ArcSpec {
                        start,
                        end,
                        plane,
                        center,
                        rotation,
                    })
                    .unwrap(),
                )
            },
        )
}

pub(crate) fn quintic() -> impl Strategy<Value = Curve> {
    (
        coords(20.0),
        prop::array::uniform5(coords(10.0)),
        0.5..30.0_f64,
    )
        .prop_map(|(p, [dp, d1, d2, e1, e2], length)| {
            let start = HermiteEnd {
                p,
                d1: d1 * 0.2,
                d2: d2 * 0.05,
            };
            let end = HermiteEnd {
                p: p + dp,
                d1: e1 * 0.2,
                d2: e2 * 0.05,
            };
            Curve::Quintic(Quintic::hermite(start, end, length).unwrap())
        })
}

pub(crate) fn curve() -> impl Strategy<Value = Curve> {
    prop_oneof![line(), arc(), arc(), quintic()]
}
