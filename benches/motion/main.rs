//! The planner by segments, samples and nodes; single moves beside ruckig's Rust port; kinematics
//! by family.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench says what went wrong by panicking"
)]

mod surfaces;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use lostmotion::base::{AxisLimits, BlockRef, Coords, Jet, math};
use lostmotion::kinematics::{CartesianSpec, Kinematics, build};
use lostmotion::path::Curve;
use lostmotion::plan::{FeedLimit, Move, PathControl, PlanItem, Planner, PlannerConfig, Quality};
use lostmotion::sim::Machine;
use rsruckig::prelude::{
    DataArrayOrVec, InputParameter, Ruckig, RuckigResult, ThrowErrorHandler, Trajectory,
};
use std::sync::Arc;

const SEGMENTS: usize = 20_000;

fn cartesian() -> Arc<dyn Kinematics> {
    Arc::from(build(&CartesianSpec {}.into()).expect("kinematics"))
}

fn planned(config: &PlannerConfig, moves: &[Move]) -> Planner {
    let mut planner = Planner::new(config.clone(), cartesian(), Coords::ZERO).expect("a planner");
    for item in moves {
        planner.push(PlanItem::Move(*item)).expect("a move");
    }
    planner.finish().expect("an end");
    planner
}

/// Moves to a finished profile; samples from a finished profile.
fn segments(criterion: &mut Criterion) {
    let config = surfaces::config();
    for kind in ["finish", "rough", "sine", "noisy"] {
        let moves: Vec<Move> = surfaces::moves(kind).take(SEGMENTS).collect();
        let mut group = criterion.benchmark_group("segments to profile");
        group
            .sample_size(10)
            .throughput(Throughput::Elements(SEGMENTS as u64));
        group.bench_function(kind, |bencher| {
            bencher.iter(|| planned(&config, &moves).held_pieces());
        });
        group.finish();
        let ready = planned(&config, &moves);
        let sampled = |planner: &mut Planner| {
            let (mut count, mut samples) = (0, Vec::with_capacity(8192));
            while planner.take(8192, &mut samples) > 0 {
                count += samples.len() as u64;
                samples.clear();
            }
            count
        };
        let mut group = criterion.benchmark_group("profile to samples");
        group
            .sample_size(10)
            .throughput(Throughput::Elements(sampled(&mut ready.clone())));
        group.bench_function(kind, |bencher| {
            bencher.iter_batched(
                || ready.clone(),
                |mut planner| sampled(&mut planner),
                BatchSize::LargeInput,
            );
        });
        group.finish();
    }
}

/// Nodes of the optimiser: two to a sample of the nominal motion, which is at most as slow as that
/// of `fast`.
fn optimal(criterion: &mut Criterion) {
    let config = surfaces::config();
    let moves: Vec<Move> = surfaces::moves("sine").take(2000).collect();
    let mut samples = Vec::new();
    let nodes = 2 * planned(&config, &moves).take(usize::MAX, &mut samples) as u64;
    let config = PlannerConfig {
        quality: Quality::Optimal,
        ..config
    };
    let mut group = criterion.benchmark_group("optimal, nodes");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(nodes));
    group.bench_function("sine", |bencher| {
        bencher.iter(|| {
            samples.clear();
            planned(&config, &moves).take(usize::MAX, &mut samples)
        });
    });
    group.finish();
}

const LIMITS: AxisLimits = AxisLimits {
    min: -1e6,
    max: 1e6,
    velocity: 100.0,
    acceleration: 1e3,
    jerk: 3e4,
};

/// Joints that go from rest to rest together: by parts of a distance.
fn goal<const N: usize>(k: usize) -> [f64; N] {
    std::array::from_fn(|joint| 0.01 * math::pow(1.3, (k % 40) as f64) * (1.0 - 0.1 * joint as f64))
}

/// The time of a move by ruckig's port, s.
fn ruckig<const N: usize>(otg: &mut Ruckig<N, ThrowErrorHandler>, k: usize) -> f64 {
    let all = |value: f64| DataArrayOrVec::Stack([value; N]);
    let mut input = InputParameter::<N>::new(None);
    input.target_position = DataArrayOrVec::Stack(goal::<N>(k));
    input.max_velocity = all(LIMITS.velocity);
    input.max_acceleration = all(LIMITS.acceleration);
    input.max_jerk = all(LIMITS.jerk);
    let mut trajectory = Trajectory::new(None);
    let result = otg
        .calculate(&input, &mut trajectory)
        .expect("a trajectory");
    assert!(matches!(
        result,
        RuckigResult::Working | RuckigResult::Finished
    ));
    trajectory.get_duration()
}

/// The same move through the planner, on a straight line.
fn line<const N: usize>(
    config: &PlannerConfig,
    kinematics: &Arc<dyn Kinematics>,
    k: usize,
) -> Planner {
    let mut end = Coords::ZERO;
    end.0[..N].copy_from_slice(&goal::<N>(k));
    let item = Move {
        curve: Curve::line(Coords::ZERO, end),
        feed: FeedLimit::Rapid,
        control: PathControl::ExactPath,
        tool_mm: [0.0; 3],
        block: BlockRef::default(),
    };
    let mut planner =
        Planner::new(config.clone(), Arc::clone(kinematics), Coords::ZERO).expect("a planner");
    planner.push(PlanItem::Move(item)).expect("a move");
    planner.finish().expect("an end");
    planner
}

fn state_to_state<const N: usize>(criterion: &mut Criterion) {
    let mut config = PlannerConfig::new([None; 9]);
    config.limits[..N].fill(Some(LIMITS));
    let kinematics = cartesian();
    let mut otg = Ruckig::<N, ThrowErrorHandler>::new(None, 1e-3);
    for k in 0..40 {
        let mut samples = Vec::new();
        let cycles = line::<N>(&config, &kinematics, k).take(usize::MAX, &mut samples) - 1;
        let (ours, theirs) = (cycles as f64 * 1e-3, ruckig::<N>(&mut otg, k));
        assert!(
            (theirs - 1e-6..theirs * (1.0 + 1e-5) + 1e-3 + 1e-6).contains(&ours),
            "{k}: {ours} s, ruckig {theirs} s"
        );
    }
    let mut group = criterion.benchmark_group(format!("rest to rest, {N} joints"));
    let mut k = 0;
    group.bench_function("lostmotion", |bencher| {
        bencher.iter(|| {
            k += 1;
            line::<N>(&config, &kinematics, k)
        });
    });
    group.bench_function("rsruckig", |bencher| {
        bencher.iter(|| {
            k += 1;
            ruckig::<N>(&mut otg, k)
        });
    });
    group.finish();
}

fn kinematics(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("joints and three derivatives of a pose");
    for name in [
        "vmc3",
        "trunnion5",
        "fork5",
        "swivel5",
        "nutating5",
        "corexy",
        "delta",
        "scara",
        "arm6",
    ] {
        let machine = Machine::preset(name).expect("an embedded machine");
        let kinematics = machine.build_kinematics().expect("kinematics");
        let jets = machine
            .start()
            .0
            .map(|word| Jet::new(word, 0.1, 0.01, 0.001));
        kinematics
            .inverse_jet(&jets, &[0.0; 3])
            .expect("a pose within reach");
        group.bench_function(name, |bencher| {
            bencher.iter(|| kinematics.inverse_jet(&jets, &[0.0; 3]));
        });
    }
    group.finish();
}

criterion_group!(
    benches,
    segments,
    optimal,
    state_to_state::<1>,
    state_to_state::<3>,
    state_to_state::<6>,
    kinematics
);
criterion_main!(benches);
