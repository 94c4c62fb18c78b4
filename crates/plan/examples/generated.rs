//! Judges generated programs: `generated plain|varied FROM TO [CYCLE_NS]`. Prints the seeds that
//! break a limit or a tolerance.
#![allow(clippy::unwrap_used)]

#[path = "../tests/it/common/mod.rs"]
mod common;

use common::generate::{plain, varied};
use lostmotion_base::Clock;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [kind, from, to, rest @ ..] = args.as_slice() else {
        return Err("usage: generated plain|varied FROM TO [CYCLE_NS]".into());
    };
    let cycle = rest
        .first()
        .map(|ns| ns.parse())
        .transpose()?
        .and_then(Clock::from_nanos);
    let (mut programs, mut moves, mut samples, mut bad) = (0_u64, 0, 0, 0);
    for seed in from.parse()?..to.parse::<u64>()? {
        let case = if kind == "plain" {
            plain(seed)
        } else {
            varied(seed)
        };
        let clock = cycle.unwrap_or(case.config.clock);
        let plan = case.run(clock);
        let faults = case.faults(clock, &plan);
        (programs, moves, samples) = (
            programs + 1,
            moves + case.program.moves.len(),
            samples + plan.len(),
        );
        bad += u64::from(!faults.is_empty());
        for fault in faults {
            println!("{seed}: {fault}");
        }
    }
    println!("{programs} programs, {moves} moves, {samples} samples, {bad} with faults");
    Ok(())
}
