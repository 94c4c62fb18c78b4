//! The offline fit of the gap from a log of ten seconds.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench says what went wrong by panicking"
)]

use criterion::{Criterion, criterion_group, criterion_main};
use lostmotion::base::{Clock, math};
use lostmotion::drive::{AxisOutput, AxisSample, Setpoint};
use lostmotion::identify::{BacklashLog, FitSettings, fit_backlash};
use lostmotion::methods::{AxisConfig, MethodId, build_runner};

const SECONDS: usize = 10;

fn log(config: &AxisConfig) -> Vec<AxisSample> {
    let rate = 3.0;
    let at = |n: usize| {
        let (sin, cos) = math::sin_cos(rate * n as f64 * 1e-3);
        Setpoint::moving(8.0 * sin, 8.0 * rate * cos, -8.0 * rate * rate * sin)
    };
    let setpoints: Vec<Setpoint> = (0..1000 * SECONDS).map(at).collect();
    let mut output = AxisOutput::new(true);
    let mut runner = build_runner(config, MethodId::NONE, 0.0).expect("an axis");
    runner
        .push(&setpoints, &mut output)
        .expect("finite setpoints");
    output.trace.unwrap_or_default()
}

fn fit(criterion: &mut Criterion) {
    let config = AxisConfig::paper();
    let log = BacklashLog::from_samples(Clock::SERVO.period_s(), &log(&config)).expect("a log");
    let settings = FitSettings::for_axis(&config);
    let mut group = criterion.benchmark_group("fit");
    group.sample_size(10);
    group.bench_function("10 s at 250 us", |bencher| {
        bencher.iter(|| fit_backlash(&log, &settings).expect("a fit").half_gap_rad);
    });
    group.finish();
}

criterion_group!(benches, fit);
criterion_main!(benches);
