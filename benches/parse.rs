//! G-code: bytes to canonical operations, and on to motion in machine coordinates.

#![allow(clippy::expect_used, clippy::unwrap_used, clippy::panic, reason = "a bench says what went wrong by panicking")]

mod support;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use lostmotion::base::Coords;
use lostmotion::gcode::{InterpreterConfig, MotionFold, Program};

fn parse(criterion: &mut Criterion) {
    let text = support::surfacing(2.0);
    let mut group = criterion.benchmark_group("parse");
    group.throughput(Throughput::Bytes(text.len() as u64));
    group.bench_function("canonical operations", |bencher| {
        bencher.iter_batched(|| Program::new(text.as_bytes(), InterpreterConfig::default()), Iterator::count, BatchSize::SmallInput);
    });
    group.bench_function("motion", |bencher| {
        bencher.iter_batched(
            || (Program::new(text.as_bytes(), InterpreterConfig::default()), MotionFold::new(Coords::ZERO)),
            |(program, mut fold)| program.filter(|op| fold.push(op).is_ok_and(|item| item.is_some())).count(),
            BatchSize::SmallInput,
        );
    });
    group.finish();
}

criterion_group!(benches, parse);
criterion_main!(benches);
