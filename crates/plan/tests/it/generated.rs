//! Generated programs: every limit, and that more freedom is not slower.

use crate::common::generate::{Case, Dice, plain, program, varied};
use crate::common::{
    LIMITS, Program, assert_limits, cartesian, continuous, deviation, run, three_axes,
};
use lostmotion_base::{Clock, Coords, math};
use lostmotion_plan::{PathControl, PlanItem, Sample};

fn seconds(samples: &[Sample]) -> f64 {
    (samples.len() - 1) as f64 * 1e-3
}

/// Judges the plans of some programs from the outside; returns how many samples there were.
fn judge(cases: impl Iterator<Item = Case>, clock: Option<Clock>) -> usize {
    let judged = cases.enumerate().map(|(number, case)| {
        let clock = clock.unwrap_or(case.config.clock);
        let samples = case.run(clock);
        assert_eq!(
            case.faults(clock, &samples),
            Vec::<String>::new(),
            "program {number}"
        );
        samples.len()
    });
    judged.sum()
}

#[test]
fn every_limit_holds() {
    assert!(judge((0..6000).map(plain), None) > 3_000_000);
}

/// Where motion nearly stands still between two stops, a time law in the square of the speed had no
/// motion to give.
#[test]
fn every_limit_holds_near_a_standstill() {
    assert!(
        judge(
            [1055, 1209, 1451, 1865, 2329, 2605, 2713]
                .into_iter()
                .map(plain),
            None
        ) > 1000
    );
}

#[test]
fn every_limit_holds_on_machines_of_all_kinds() {
    assert!(judge((0..600).map(varied), None) > 100_000);
}

/// Between the samples, too: the same motion sampled twenty times as often.
#[test]
fn every_limit_holds_between_the_samples() {
    let clock = Clock::from_nanos(50_000);
    assert!(judge((300..310).map(plain), clock) > 50_000);
}

/// Times with more freedom by those with less, the largest.
fn worst_ratio(seeds: std::ops::Range<u64>, pair: impl Fn(u64) -> [f64; 2]) -> f64 {
    // Times are whole samples.
    seeds
        .map(pair)
        .map(|[less, more]| (more - 1.001e-3) / less)
        .fold(0.0, f64::max)
}

fn time(seed: u64, control: PathControl, feed: f64) -> f64 {
    seconds(&program(seed, control, feed).run())
}

#[test]
fn more_freedom_is_hardly_slower() {
    let seeds = 100..125;
    let feed = worst_ratio(seeds.clone(), |seed| {
        [50.0, 62.5].map(|feed| time(seed, continuous(0.01), feed))
    });
    let tolerance = worst_ratio(seeds.clone(), |seed| {
        [0.005, 0.02].map(|p| time(seed, continuous(p), 80.0))
    });
    let exact = worst_ratio(seeds.clone(), |seed| {
        [PathControl::ExactPath, continuous(0.01)].map(|control| time(seed, control, 80.0))
    });
    let limits = worst_ratio(seeds, |seed| {
        [1.0, 1.3].map(|factor| {
            let mut config = three_axes();
            for limits in config.limits.iter_mut().flatten() {
                limits.acceleration *= factor;
                limits.jerk *= factor;
            }
            let items = program(seed, continuous(0.01), 80.0)
                .moves
                .into_iter()
                .map(PlanItem::Move);
            seconds(&run(config, cartesian(), Coords::ZERO, items))
        })
    });
    println!(
        "feed {feed:.4}, tolerance {tolerance:.4}, G64 after G61 {exact:.4}, limits {limits:.4}"
    );
    assert!(
        feed < 1.0 && tolerance < 1.003 && exact < 1.0 && limits < 1.0,
        "{feed} {tolerance} {exact} {limits}"
    );
}

#[test]
fn noise_hardly_costs_time() {
    let sine = |noise: f64| {
        let (mut dice, mut program) = (Dice::seeded(7), Program::new(continuous(0.01), 100.0));
        for i in 1..=600 {
            let x = 0.2 * f64::from(i);
            program.line(
                x,
                0.0,
                2.0 * math::sin(0.314 * x) + noise * dice.between(-1.0, 1.0),
            );
        }
        let samples = program.run();
        assert_limits(&samples, &[Some(LIMITS); 3]);
        assert!(deviation(&samples, &program.moves) <= 0.01 + 1e-8);
        seconds(&samples)
    };
    let (clean, noisy) = (sine(0.0), sine(0.005));
    assert!(noisy <= 1.03 * clean, "{clean} s, with noise {noisy} s");
}
