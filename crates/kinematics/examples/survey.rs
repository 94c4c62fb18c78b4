//! Worst error of forward after inverse, and time of each, for every family:
//! `cargo run --release -p lostmotion-kinematics --example survey [POSES]` (a million poses if not
//! given).
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../tests/it/common/mod.rs"]
mod common;

use common::{difference, machines};
use lostmotion_base::Jet;
use lostmotion_base::Random;
use std::time::Instant;

const SPEED_POSES: usize = 20_000;
const BATCH: usize = 100;

fn main() {
    let poses: usize = std::env::args()
        .nth(1)
        .map_or(1_000_000, |text| text.parse().unwrap());
    println!(
        "{:36} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "machine", "worst mm", "worst rad", "refused", "inverse", "jets", "fwd ns", ""
    );
    for described in machines() {
        let machine = described.build();
        let mut random = Random::new(7);
        let (mut linear, mut angular, mut refused) = (0.0_f64, 0.0_f64, 0);
        for _ in 0..poses {
            let (words, tool) = described.pose(machine.as_ref(), &mut random);
            let Ok(joints) = machine.inverse(&words, &tool) else {
                refused += 1;
                continue;
            };
            let (mm, rad) = difference(&described, &words, &machine.forward(&joints, &tool));
            (linear, angular) = (linear.max(mm), angular.max(rad));
        }
        let list: Vec<_> = (0..SPEED_POSES)
            .map(|_| described.pose(machine.as_ref(), &mut random))
            .collect();
        let joints: Vec<_> = list
            .iter()
            .map(|(words, tool)| machine.inverse(words, tool).unwrap_or_default())
            .collect();
        let mut sum = 0.0;
        // The quickest of many short batches: other work on the machine makes the rest slower.
        let mut time = |work: &mut dyn FnMut(usize) -> f64| {
            let mut quickest = f64::INFINITY;
            for batch in 0..list.len() / BATCH {
                let start = Instant::now();
                for index in batch * BATCH..(batch + 1) * BATCH {
                    sum += work(index);
                }
                quickest = quickest.min(start.elapsed().as_secs_f64() * 1e9 / BATCH as f64);
            }
            quickest
        };
        let inverse = time(&mut |i| {
            machine
                .inverse(&list[i].0, &list[i].1)
                .map_or(0.0, |joints| joints.0[0])
        });
        let jets = time(&mut |i| {
            let jets = list[i].0.0.map(|word| Jet::new(word, 0.1, 0.01, 0.001));
            machine
                .inverse_jet(&jets, &list[i].1)
                .map_or(0.0, |joints| joints[0].0[3])
        });
        let forward = time(&mut |i| machine.forward(&joints[i], &list[i].1).0[0]);
        println!(
            "{:36} {linear:9.1e} {angular:9.1e} {refused:9} {inverse:9.0} {jets:9.0} {forward:9.0} {:>9}",
            described.name,
            if sum.is_finite() { "" } else { "?" }
        );
    }
}
