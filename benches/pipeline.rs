//! The whole chain for one method, on one thread and on all. Elements are CNC periods.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench says what went wrong by panicking"
)]

mod support;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use lostmotion::sim::{Machine, Program, SimulateOptions, Simulation};

fn pipeline(criterion: &mut Criterion) {
    let machine = Machine::preset("vmc3").expect("an embedded machine");
    let source = Program::from_bytes("surfacing", support::surfacing(0.25).into_bytes());
    let mut group = criterion.benchmark_group("simulate");
    group.sample_size(10);
    for threads in [1, 0] {
        let options = SimulateOptions {
            threads,
            ..SimulateOptions::default()
        };
        let run = || {
            Simulation::new(&source, &machine)
                .method("none")
                .options(options.clone())
                .run()
                .map(|run| run.into_single().unwrap())
                .expect("a simulation")
                .plan
                .duration_s
        };
        group.throughput(Throughput::Elements((run() * 1e3) as u64));
        group.bench_function(
            if threads == 1 {
                "one thread"
            } else {
                "all threads"
            },
            |bencher| bencher.iter(run),
        );
    }
    group.finish();
}

criterion_group!(benches, pipeline);
criterion_main!(benches);
