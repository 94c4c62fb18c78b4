//! One axis: a second of a sine, every method. Elements are CNC periods, so a million elements a second are 1000 times real time.

#![allow(clippy::expect_used, clippy::unwrap_used, clippy::panic, reason = "a bench says what went wrong by panicking")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use lostmotion::axis::{AxisConfig, AxisOutput, METHODS, Setpoint, build_runner};
use lostmotion::base::math;
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
    for (name, config, setpoints) in [("paper", paper, sine(5.0, 6.0)), ("vmc3:x", mill, sine(20.0, 2.0 * std::f64::consts::PI))] {
        for method in METHODS {
            let start = build_runner(&config, method.info.name, 0.0).expect("an axis");
            group.bench_function(format!("{name} {}", method.info.name), |bencher| {
                let mut output = AxisOutput::new(false);
                bencher.iter(|| {
                    let mut runner = start.boxed_clone();
                    output.clear();
                    runner.push(&setpoints, &mut output).expect("finite setpoints");
                    output.load.last().copied()
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, axis);
criterion_main!(benches);
