//! One axis: a second of a sine, every method. Elements are CNC periods, so a million elements a
//! second are 1000 times real time.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench says what went wrong by panicking"
)]

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use lostmotion::base::math;
use lostmotion::drive::{AxisBatch, AxisOutput, AxisRunner, Setpoint};
use lostmotion::methods::{AxisConfig, MethodId, build_runner};
use lostmotion::sim::machine::axis_preset;

const TICKS: usize = 1000;

/// A sine of `amplitude` at `rate` rad/s, at 1 ms.
fn sine(amplitude: f64, rate: f64) -> Vec<Setpoint> {
    let at = |n: usize| {
        let (sin, cos) = math::sin_cos(rate * n as f64 * 1e-3);
        let (velocity, acceleration) = (amplitude * rate * cos, -amplitude * rate * rate * sin);
        Setpoint::moving(amplitude * sin, velocity, acceleration)
    };
    (0..TICKS).map(at).collect()
}

fn axis(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("axis");
    group.throughput(Throughput::Elements(TICKS as u64));
    let mill = axis_preset("vmc3:x").expect("an embedded axis");
    let paper = AxisConfig::paper();
    for (name, config, setpoints) in [
        ("paper", paper, sine(5.0, 6.0)),
        ("vmc3:x", mill, sine(20.0, 2.0 * std::f64::consts::PI)),
    ] {
        for method in MethodId::all() {
            let start = build_runner(&config, method, 0.0).expect("an axis");
            group.bench_function(format!("{name} {method}"), |bencher| {
                let mut output = AxisOutput::new(false);
                bencher.iter(|| {
                    let mut runner = start.boxed_clone();
                    output.clear();
                    runner
                        .push(&setpoints, &mut output)
                        .expect("finite setpoints");
                    output.load.last().copied()
                });
            });
        }
    }
    group.finish();
}

/// Variants of one axis (gaps and gains) one after another, and as a batch on one thread and on
/// all. Elements are CNC periods of one axis, so the ratio of the throughputs is what a batch
/// gains.
fn batch(criterion: &mut Criterion) {
    const VARIANTS: usize = 32;
    let mut group = criterion.benchmark_group("axis-batch");
    group
        .throughput(Throughput::Elements((TICKS * VARIANTS) as u64))
        .sample_size(20);
    let mill = axis_preset("vmc3:x").expect("an embedded axis");
    for (name, base, setpoints) in [
        ("paper", AxisConfig::paper(), sine(5.0, 6.0)),
        ("vmc3:x", mill, sine(20.0, 2.0 * std::f64::consts::PI)),
    ] {
        for method in ["none", "lookup", "adaptive"] {
            let start = || -> Vec<Box<dyn AxisRunner>> {
                (0..VARIANTS)
                    .map(|index| {
                        build_runner(
                            &variant(&base, index),
                            method.parse().expect("a method"),
                            0.0,
                        )
                        .expect("an axis")
                    })
                    .collect()
            };
            let mut outputs = vec![AxisOutput::new(false); VARIANTS];
            let singles = start();
            group.bench_function(format!("{name} {method}, single runs"), |bencher| {
                bencher.iter(|| {
                    for (runner, output) in singles.iter().zip(&mut outputs) {
                        output.clear();
                        runner
                            .boxed_clone()
                            .push(&setpoints, output)
                            .expect("finite setpoints");
                    }
                });
            });
            for threads in [1, 0] {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .expect("threads");
                let label = if threads == 1 {
                    "one thread"
                } else {
                    "all threads"
                };
                group.bench_function(format!("{name} {method}, batch, {label}"), |bencher| {
                    let fresh = || {
                        AxisBatch::new(
                            singles.iter().map(|runner| runner.boxed_clone()).collect(),
                            pool.current_num_threads(),
                        )
                    };
                    bencher.iter_batched(
                        fresh,
                        |mut batch| {
                            outputs.iter_mut().for_each(AxisOutput::clear);
                            pool.install(|| {
                                batch.push(&[setpoints.as_slice(); VARIANTS], &mut outputs)
                            })
                        },
                        BatchSize::LargeInput,
                    );
                });
            }
        }
    }
    group.finish();
}

/// An axis with another gap and another gain.
fn variant(base: &AxisConfig, index: usize) -> AxisConfig {
    let share = index as f64 / 32.0;
    let mut axis = base.with_gap(base.gap_in_unit() * (1.0 + share));
    axis.drive.velocity_gain_a_s_per_rad *= 1.0 - 0.2 * share;
    axis
}

criterion_group!(benches, axis, batch);
criterion_main!(benches);
