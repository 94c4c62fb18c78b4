//! Planning: program in, 1 ms samples out.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench says what went wrong by panicking"
)]

mod support;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use lostmotion::sim::{Machine, Program, SimulateOptions, Simulation};

fn planning(criterion: &mut Criterion) {
    let machine = Machine::preset("vmc3").expect("an embedded machine");
    let mut group = criterion.benchmark_group("plan");
    group.sample_size(10);
    for (name, text) in [
        ("surfacing, 1 minute", support::surfacing(1.0)),
        ("circles", support::circles()),
    ] {
        let source = Program::from_bytes(name, text.into_bytes());
        let options = SimulateOptions::default();
        let run = || {
            let mut samples = 0;
            Simulation::new(&source, &machine)
                .options(options.clone())
                .plan(&mut |chunk, _| {
                    samples += chunk.len() as u64;
                    Ok(())
                })
                .expect("a plan");
            samples
        };
        group.throughput(Throughput::Elements(run()));
        group.bench_function(name, |bencher| bencher.iter(run));
    }
    group.finish();
}

criterion_group!(benches, planning);
criterion_main!(benches);
