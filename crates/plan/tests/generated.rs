//! Generated programs: every limit, and that more freedom is not slower.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{LIMITS, Program, assert_limits, cartesian, continuous, deviation, optimal, peaks, run, three_axes};
use lostmotion_base::{Coords, math};
use lostmotion_plan::{PathControl, PlanItem, Sample};

/// Numbers that look random (PCG's multiplier and increment).
struct Dice(u64);

impl Dice {
    /// From 0 to 1.
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }
}

/// Short runs, arcs, long and tiny lines, near reversals, what does not move; about 20 moves.
fn program(seed: u64, control: PathControl, feed: f64) -> Program {
    let mut dice = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let mut program = Program::new(control, feed);
    let mut heading = 0.0;
    for _ in 0..5 {
        let kind = dice.roll();
        let [x, y, z] = program.here.linear();
        let (sin, cos) = math::sin_cos(heading);
        if kind < 0.4 {
            let (h, bend, noise) = (dice.between(0.02, 0.6), dice.between(-0.05, 0.05), dice.between(0.0, 0.003));
            for _ in 0..12 {
                heading += bend * dice.roll();
                let [x, y, z] = program.here.linear();
                let (sin, cos) = math::sin_cos(heading);
                program.line(x + h * cos - noise * sin * dice.roll(), y + h * sin + noise * cos * dice.roll(), z + 0.1 * h);
            }
        } else if kind < 0.6 {
            let (r, sweep) = (dice.between(0.1, 15.0), dice.between(0.2, 3.0));
            program.arc(-r * sin, r * cos, sweep);
            heading += sweep;
        } else if kind < 0.8 {
            let length = [1e-7, 0.004, 0.3, 8.0][(dice.roll() * 4.0) as usize];
            program.line(x + length * cos, y + length * sin, z);
            program.line(x + length * cos, y + length * sin, z);
        } else {
            heading += dice.between(-std::f64::consts::PI, std::f64::consts::PI);
            let (sin, cos) = math::sin_cos(heading);
            program.line(x + 12.0 * cos, y + 12.0 * sin, z + dice.between(-4.0, 4.0));
        }
    }
    program
}

fn seconds(samples: &[Sample]) -> f64 {
    (samples.len() - 1) as f64 * 1e-3
}

/// Judges the plans of some programs from the outside; returns how many samples there were.
fn judge(seeds: std::ops::Range<u64>) -> u64 {
    let mut count = 0;
    for seed in seeds {
        let tolerance = [0.002, 0.01, 0.05][(seed % 3) as usize];
        let program = program(seed, continuous(tolerance), 20.0 + (seed % 7) as f64 * 20.0);
        let samples = program.run();
        count += samples.len() as u64;
        assert_limits(&samples, &[Some(LIMITS); 3]);
        let worst = deviation(&samples, &program.moves);
        assert!(worst <= tolerance + 1e-8, "program {seed}: {worst} of {tolerance}");
    }
    count
}

#[test]
fn every_limit_holds() {
    assert!(judge(0..60) > 10_000);
}

#[test]
#[ignore = "minutes; for changes of the planner"]
fn every_limit_holds_on_many() {
    println!("{} samples", judge(1000..41_000));
}

/// Times with more freedom by those with less, the largest.
fn worst_ratio(seeds: std::ops::Range<u64>, pair: impl Fn(u64) -> [f64; 2]) -> f64 {
    // Times are whole samples.
    seeds.map(pair).map(|[less, more]| (more - 1.001e-3) / less).fold(0.0, f64::max)
}

fn time(seed: u64, control: PathControl, feed: f64) -> f64 {
    seconds(&program(seed, control, feed).run())
}

#[test]
fn more_freedom_is_hardly_slower() {
    let seeds = 100..125;
    let feed = worst_ratio(seeds.clone(), |seed| [50.0, 62.5].map(|feed| time(seed, continuous(0.01), feed)));
    let tolerance = worst_ratio(seeds.clone(), |seed| [0.005, 0.02].map(|p| time(seed, continuous(p), 80.0)));
    let exact = worst_ratio(seeds.clone(), |seed| [PathControl::ExactPath, continuous(0.01)].map(|control| time(seed, control, 80.0)));
    let limits = worst_ratio(seeds, |seed| {
        [1.0, 1.3].map(|factor| {
            let mut config = three_axes();
            for limits in config.limits.iter_mut().flatten() {
                limits.acceleration *= factor;
                limits.jerk *= factor;
            }
            let items = program(seed, continuous(0.01), 80.0).moves.into_iter().map(PlanItem::Move);
            seconds(&run(config, cartesian(), Coords::ZERO, items))
        })
    });
    assert!(feed < 1.01 && tolerance < 1.02 && exact < 1.01 && limits < 1.02, "{feed} {tolerance} {exact} {limits}");
}

#[test]
fn noise_hardly_costs_time() {
    let sine = |noise: f64| {
        let (mut dice, mut program) = (Dice(7), Program::new(continuous(0.01), 100.0));
        for i in 1..=600 {
            let x = 0.2 * f64::from(i);
            program.line(x, 0.0, 2.0 * math::sin(0.314 * x) + noise * dice.between(-1.0, 1.0));
        }
        let samples = program.run();
        assert_limits(&samples, &[Some(LIMITS); 3]);
        assert!(deviation(&samples, &program.moves) <= 0.01 + 1e-8);
        seconds(&samples)
    };
    let (clean, noisy) = (sine(0.0), sine(0.005));
    assert!(noisy <= 1.03 * clean, "{clean} s, with noise {noisy} s");
}

/// Largest part of the limits of acceleration and jerk that any joint takes.
fn used(samples: &[Sample]) -> f64 {
    (0..3).map(|joint| peaks(samples, joint)).map(|[_, a, j]| (a / LIMITS.acceleration).max(j / LIMITS.jerk)).fold(0.0, f64::max)
}

/// Programs, those whose plans of quality `optimal` pass a limit, and how long those and the plans of `fast` take in all, s.
fn optimal_plans(seeds: std::ops::Range<u64>) -> (usize, [f64; 2]) {
    let (mut beyond, mut time_s) = (0, [0.0; 2]);
    for seed in seeds {
        let program = program(seed, continuous([0.002, 0.01, 0.05][(seed % 3) as usize]), 20.0 + (seed % 7) as f64 * 20.0);
        let (fast, samples) = (program.run(), program.run_with(optimal()));
        time_s = [time_s[0] + seconds(&fast), time_s[1] + seconds(&samples)];
        let used = used(&samples);
        // Rounding of positions of some hundred mm makes differences of about 1e-5 of the limit.
        if used > 1.0 + 1e-4 {
            println!("program {seed}: {used}");
            beyond += 1;
        }
    }
    (beyond, time_s)
}

#[test]
fn optimal_plans_keep_every_limit_and_are_faster() {
    let (beyond, [fast, optimal]) = optimal_plans(0..25);
    assert!(beyond == 0 && optimal < fast, "{beyond}: {fast} {optimal}");
}

#[test]
#[ignore = "minutes; for changes of the planner"]
fn optimal_plans_keep_every_limit_on_many() {
    let (beyond, time_s) = optimal_plans(2000..4000);
    println!("{beyond} beyond, {time_s:?}");
    assert_eq!(beyond, 0);
}
