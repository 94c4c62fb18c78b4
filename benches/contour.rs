//! Contour stage and kinematics: foot points on a path of short lines and on an arc; joints and
//! their derivatives.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench says what went wrong by panicking"
)]

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use lostmotion::base::{BlockRef, Coords, math};
use lostmotion::contour::{
    ContourConfig, ContourInput, ContourTracker, FootState, ProgrammedSegment,
};
use lostmotion::kinematics::{TrunnionAcSpec, build};
use lostmotion::path::{Arc, ArcSpec, Curve, Plane};

const SAMPLES: u64 = 1000;

/// A tracker and the commands along its path, each with a tool a hundredth of a millimetre off.
fn along(curves: &[Curve]) -> (ContourTracker, Vec<ContourInput>) {
    let mut tracker = ContourTracker::new(ContourConfig::default());
    let mut inputs = Vec::new();
    for (index, curve) in (0..).zip(curves) {
        let block = BlockRef::default();
        let segment = ProgrammedSegment {
            index,
            curve: *curve,
            plane: Plane::Xy,
            rapid: false,
            origin_mm: [0.0; 3],
            block,
        };
        tracker.push(segment).expect("segments in order");
    }
    for tick in 0..SAMPLES {
        let along = tick as f64 / SAMPLES as f64 * curves.len() as f64;
        let curve = &curves[along as usize];
        let s = (along - along.floor()) * curve.length();
        let [x, y, z] = curve.point(s).linear();
        inputs.push(ContourInput {
            tick,
            segment: along as u64,
            s,
            actual_tip_mm: [x + 0.01, y, z],
            commanded_tip_mm: [x, y, z],
            actual_axis: [0.0, 0.0, 1.0],
            commanded_axis: [0.0, 0.0, 1.0],
        });
    }
    (tracker, inputs)
}

fn lines() -> Vec<Curve> {
    let at = |n: i32| Coords::xyz(0.5 * f64::from(n), math::sin(0.05 * f64::from(n)), 0.0);
    (0..100).map(|n| Curve::line(at(n), at(n + 1))).collect()
}

fn circle() -> Vec<Curve> {
    let start = Coords::xyz(25.0, 0.0, 0.0);
    vec![Curve::Arc(
        Arc::new(ArcSpec {
            start,
            end: start,
            plane: Plane::Xy,
            center: [0.0, 0.0],
            rotation: 1,
        })
        .expect("a circle"),
    )]
}

fn contour(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("contour");
    group.throughput(Throughput::Elements(SAMPLES));
    for (name, curves) in [("short lines", lines()), ("circle", circle())] {
        let (tracker, inputs) = along(&curves);
        group.bench_function(name, |bencher| {
            bencher.iter_batched(
                FootState::default,
                |mut foot| {
                    inputs
                        .iter()
                        .map(|input| tracker.measure(&mut foot, input).expect("a foot").error_mm)
                        .sum::<f64>()
                },
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

fn kinematics(criterion: &mut Criterion) {
    let spec = TrunnionAcSpec {
        rotation_point_mm: [0.0, 0.0, -50.0],
        ..TrunnionAcSpec::default()
    };
    let trunnion = build(&spec.into()).expect("a trunnion");
    let mut pose = Coords::xyz(10.0, 20.0, 30.0);
    (pose.0[3], pose.0[5]) = (0.3, 1.1);
    let jets = Curve::line(pose, pose + Coords([1.0; 9])).jet(0.5);
    let mut group = criterion.benchmark_group("kinematics");
    group.bench_function("trunnion inverse", |bencher| {
        bencher.iter(|| trunnion.inverse(&pose, &[0.0, 0.0, 80.0]));
    });
    group.bench_function("trunnion inverse with three derivatives", |bencher| {
        bencher.iter(|| trunnion.inverse_jet(&jets, &[0.0, 0.0, 80.0]));
    });
    group.finish();
}

criterion_group!(benches, contour, kinematics);
criterion_main!(benches);
