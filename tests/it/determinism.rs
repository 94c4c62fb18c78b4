//! Same input, same bits: whatever the number of threads and the size of chunks.

use crate::common::{machine, part, program};
use lostmotion::sim::{SimulateOptions, Simulation};
use rayon::prelude::*;

#[test]
fn results_do_not_depend_on_threads_or_chunks() {
    let (source, machine) = (part("engraving.ngc"), machine("vmc3"));
    let methods = ["none".to_owned(), "published".to_owned()];
    let run = |threads, chunk_samples| {
        let options = SimulateOptions {
            threads,
            chunk_samples,
            ..SimulateOptions::default()
        };
        let comparison = Simulation::new(&source, &machine)
            .methods(&methods)
            .options(options.clone())
            .run()
            .unwrap();
        serde_json::to_string(&comparison).unwrap()
    };
    let first = run(1, 1000);
    for (threads, chunk) in [(2, 1000), (3, 77), (1, 1)] {
        assert!(
            run(threads, chunk) == first,
            "{threads} threads, chunks of {chunk}"
        );
    }
}

#[test]
fn plans_do_not_depend_on_chunks() {
    let (source, machine) = (part("lissajous.ngc"), machine("vmc3"));
    let run = |chunk_samples| {
        let options = SimulateOptions {
            chunk_samples,
            ..SimulateOptions::default()
        };
        let mut all = Vec::new();
        let info = Simulation::new(&source, &machine)
            .options(options.clone())
            .plan(&mut |samples, _| {
                all.extend_from_slice(samples);
                Ok(())
            });
        (info.unwrap(), all)
    };
    let (info, samples) = run(1000);
    assert_eq!(samples.len() as f64, (info.duration_s * 1000.0).round());
    assert!(run(13) == (info, samples));
}

/// What 200 simulations answer that are jobs of a rayon pool with small stacks: each stays on the
/// thread it was called on, or makes its own pool if it is told to.
fn many_in_a_pool(count: usize, threads: usize) -> Vec<String> {
    let (source, machine) = (
        program("G21 G0 X2 Y0\nG3 I-2 F2000\nM2\n"),
        machine("bench3"),
    );
    let options = SimulateOptions {
        threads,
        ..SimulateOptions::default()
    };
    let methods = ["none".to_owned()];
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(2)
        .stack_size(2 << 20)
        .build()
        .unwrap();
    pool.install(|| {
        (0..count)
            .into_par_iter()
            .map(|_| {
                let result = Simulation::new(&source, &machine)
                    .methods(&methods)
                    .options(options.clone())
                    .run();
                serde_json::to_string(&result.unwrap()).unwrap()
            })
            .collect()
    })
}

#[test]
fn two_hundred_simulations_run_inside_a_rayon_iterator() {
    let all = many_in_a_pool(200, 1);
    assert!(all.iter().all(|result| *result == all[0]));
    let nested = many_in_a_pool(50, 2);
    assert!(nested.iter().all(|result| *result == all[0]));
}
