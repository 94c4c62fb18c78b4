//! All methods on one plan. Elements are CNC periods of the program.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench says what went wrong by panicking"
)]

mod support;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use lostmotion::methods::MethodId;
use lostmotion::sim::{Machine, Program, SimulateOptions, Simulation};

fn comparing(criterion: &mut Criterion) {
    let machine = Machine::preset("vmc3").expect("an embedded machine");
    let source = Program::from_bytes("circles", support::circles().into_bytes());
    let methods: Vec<String> = MethodId::all().map(|method| method.to_string()).collect();
    let options = SimulateOptions {
        threads: 0,
        ..SimulateOptions::default()
    };
    let run = || {
        Simulation::new(&source, &machine)
            .methods(&methods)
            .options(options.clone())
            .run()
            .expect("a comparison")
            .plan
            .duration_s
    };
    let mut group = criterion.benchmark_group("compare");
    group.sample_size(10);
    group.throughput(Throughput::Elements((run() * 1e3) as u64));
    group.bench_function("all methods", |bencher| bencher.iter(run));
    group.finish();
}

criterion_group!(benches, comparing);
criterion_main!(benches);
