//! G-code: bytes to words with spans, to canonical operations, and on to motion in machine
//! coordinates, beside loops that do less and published parsers. `LOSTMOTION_BENCH_MB` sets the
//! size of the programs (default 8, the published figures are of 100).

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench says what went wrong by panicking"
)]

mod generate;
mod limit;
mod others;

use criterion::{
    BenchmarkGroup, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
    measurement::WallTime,
};
use lostmotion::base::Coords;
use lostmotion::gcode::syntax::Value;
use lostmotion::gcode::{Blocks, InterpreterConfig, Limits, MotionFold, Program};
use std::hint::black_box;
use std::time::Duration;

/// The sum of all literals and of the offsets of their words.
fn words(text: &[u8]) -> (f64, u64) {
    let mut blocks = Blocks::new(text, Limits::default());
    let (mut sum, mut offsets) = (0.0, 0);
    while let Some(parsed) = blocks.read().unwrap() {
        for word in &parsed.block.words {
            if let Value::Number(value) = word.value {
                sum += value;
            }
            offsets += parsed.span(word.text).start;
        }
    }
    (sum, offsets)
}

fn canonical(text: &[u8]) -> usize {
    Program::new(text, InterpreterConfig::default()).count()
}

fn motion(text: &[u8]) -> usize {
    let mut fold = MotionFold::new(Coords::ZERO);
    Program::new(text, InterpreterConfig::default())
        .filter(|op| fold.push(op).is_ok_and(|item| item.is_some()))
        .count()
}

fn run(group: &mut BenchmarkGroup<'_, WallTime>, text: &str) {
    let bytes = text.as_bytes();
    group
        .throughput(Throughput::Bytes(bytes.len() as u64))
        .sampling_mode(SamplingMode::Flat);
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3));
    group.bench_function("limit: loop by hand", |bencher| {
        bencher.iter(|| limit::by_hand(black_box(bytes)));
    });
    group.bench_function("limit: nom, fast-float2", |bencher| {
        bencher.iter(|| limit::nom_fast_float(black_box(bytes)));
    });
    group.bench_function("limit: nom, its own numbers", |bencher| {
        bencher.iter(|| limit::nom_double(black_box(bytes)));
    });
    group.bench_function("words with spans", |bencher| {
        bencher.iter(|| words(black_box(bytes)));
    });
    group.bench_function("words: gcode", |bencher| {
        bencher.iter(|| others::gcode_visitor(black_box(text)));
    });
    group.bench_function("words: async-gcode", |bencher| {
        bencher.iter(|| others::async_gcode(black_box(text)));
    });
    group.bench_function("canonical operations", |bencher| {
        bencher.iter(|| canonical(black_box(bytes)));
    });
    group.bench_function("motion", |bencher| {
        bencher.iter(|| motion(black_box(bytes)));
    });
}

fn parse(criterion: &mut Criterion) {
    let megabytes: usize = std::env::var("LOSTMOTION_BENCH_MB")
        .ok()
        .and_then(|size| size.parse().ok())
        .unwrap_or(8);
    for (name, program) in [
        ("surfacing", generate::surfacing as fn(usize) -> String),
        ("mixed", generate::mixed),
    ] {
        let text = program(megabytes * 1_000_000);
        let diagnostics = Program::new(text.as_bytes(), InterpreterConfig::default()).finish();
        assert_eq!(diagnostics.errors(), 0, "{:?}", diagnostics.kept().first());
        let mut group = criterion.benchmark_group(format!("parse {name}"));
        run(&mut group, &text);
        group.finish();
    }
}

criterion_group!(benches, parse);
criterion_main!(benches);
