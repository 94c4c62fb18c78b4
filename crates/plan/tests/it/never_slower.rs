//! Quality `optimal` takes no longer than `fast`, but for one program in fifty and half a per cent, on
//! programs drawn for this alone.
//!
//! The suite draws some; `PROGRAMS=10000` draws as many, `FROM=1000` others.

use crate::common::{LIMITS, Program, cartesian, continuous, peaks, run, three_axes};
use lostmotion_base::{Clock, Coords, Random, math};
use lostmotion_plan::{Dwell, PathControl, PlanItem, PlannerConfig, Quality, Sample};
use std::env;
use std::f64::consts::{PI, TAU};

/// Part by which a plan may be slower. A way from the nominal pace, or to it, is not always found where
/// that uses all of the jerk; the retimed motion plans for 0.982 of it, and the cube root of that is
/// 0.994.
const MOST_SLOWER: f64 = 6e-3;
/// Part of a limit of acceleration or jerk that a plan may take beyond that of `fast`: what is left
/// after the last round of retiming (`ROUND_EXCESS` less the margin of its tightening).
const MOST_BEYOND: f64 = 3e-4;

fn from_env(name: &str, usual: u64) -> u64 {
    env::var(name).map_or(usual, |value| value.parse().unwrap())
}

/// Where a program goes, and in which direction.
struct Pen {
    program: Program,
    heading: f64,
}

impl Pen {
    fn line(&mut self, length: f64, turn: f64, climb: f64) {
        self.heading += turn;
        let [x, y, z] = self.program.here.linear();
        let (sin, cos) = math::sin_cos(self.heading);
        self.program
            .line(x + length * cos, y + length * sin, z + climb);
    }

    fn arc(&mut self, radius: f64, sweep: f64) {
        let (sin, cos) = math::sin_cos(self.heading);
        let side = radius * sweep.signum();
        self.program.arc(-side * sin, side * cos, sweep);
        self.heading += sweep;
    }

    /// One of what programs consist of.
    fn part(&mut self, random: &mut Random) {
        match random.below(7) {
            0 => self.line(random.log_between(0.05, 200.0), PI * random.signed(), 0.0),
            1 => {
                for _ in 0..2 + random.below(10) {
                    let length = random.log_between(0.2, 60.0);
                    let climb = 0.3 * length * random.signed() * (random.below(2) as f64);
                    self.line(length, PI * random.signed(), climb);
                }
            }
            // Squares, stars and zigzags.
            2 => {
                let (length, turn) = (
                    random.log_between(0.5, 40.0),
                    [TAU / 4.0, TAU / 6.0, TAU / 2.5, random.between(2.0, 3.1)][random.below(4)],
                );
                let flips = random.below(2) == 0;
                for k in 0..4 + random.below(8) {
                    let way = if flips && k % 2 == 0 { -turn } else { turn };
                    self.line(length, way, 0.0);
                }
            }
            // Chords that bend to one side, or to both.
            3 => {
                let (length, bend) = (random.log_between(0.05, 2.0), random.between(0.0, 0.3));
                let mut side = 1.0;
                for _ in 0..10 + random.below(50) {
                    side = if random.below(20) == 0 { -side } else { side };
                    self.line(length, side * bend * random.unit(), 0.0);
                }
            }
            4 => {
                for _ in 0..1 + random.below(4) {
                    let sweep = random.between(0.3, 4.0) * [1.0, -1.0][random.below(2)];
                    self.arc(random.log_between(0.5, 30.0), sweep);
                }
            }
            5 => {
                for _ in 0..4 {
                    self.line(100.0, 0.5 * random.signed(), 0.0);
                }
            }
            _ => {
                for _ in 0..10 {
                    self.line(0.3, 2.0 * random.signed(), 0.0);
                }
            }
        }
    }
}

/// A program with dwells between its parts, and the machine's cycle.
fn drawn(seed: u64) -> (Program, Vec<PlanItem>, Clock) {
    let mut random = Random::new(seed ^ 0x0a11_da7a);
    let tolerance = random.log_between(0.001, 0.5);
    let control = [
        continuous(tolerance),
        continuous(tolerance),
        PathControl::ExactPath,
        PathControl::ExactStop,
    ][random.below(4)];
    let feed = [10.0, 25.0, 50.0, 100.0, 100.0][random.below(5)];
    let mut pen = Pen {
        program: Program::new(control, feed),
        heading: PI * random.signed(),
    };
    let mut items = Vec::new();
    for _ in 0..1 + random.below(4) {
        let known = pen.program.moves.len();
        pen.part(&mut random);
        items.extend(
            pen.program.moves[known..]
                .iter()
                .map(|m| PlanItem::Move(*m)),
        );
        if random.below(8) == 0 {
            items.push(PlanItem::Dwell(Dwell {
                seconds: random.between(0.0, 0.2),
                block: Default::default(),
            }));
        }
    }
    let period_ns = [250_000, 1_000_000, 1_000_000, 1_000_000, 4_000_000][random.below(5)];
    (pen.program, items, Clock::from_nanos(period_ns).unwrap())
}

fn plan(items: &[PlanItem], clock: Clock, quality: Quality) -> Vec<Sample> {
    let config = PlannerConfig {
        quality,
        clock,
        ..three_axes()
    };
    run(config, cartesian(), Coords::ZERO, items.iter().copied())
}

/// The largest part of a limit of acceleration or jerk that a plan uses.
fn used(plan: &[Sample]) -> f64 {
    (0..3)
        .map(|joint| peaks(plan, joint))
        .map(|[_, a, j]| (a / LIMITS.acceleration).max(j / LIMITS.jerk))
        .fold(0.0, f64::max)
}

/// Programs of 10,000 in which a window began in a state that led past a limit, by up to 0.08 %.
#[test]
fn what_begins_past_a_limit_begins_elsewhere() {
    for seed in [1623, 2431, 4447, 7268] {
        let (_, items, clock) = drawn(seed);
        let used = used(&plan(&items, clock, Quality::Optimal));
        assert!(used < 1.0 + MOST_BEYOND / 2.0, "{seed}: {used}");
    }
}

#[test]
fn optimal_takes_no_longer_than_fast() {
    let (from, count) = (from_env("FROM", 0), from_env("PROGRAMS", 150));
    let (mut slower, mut beyond, mut times) = (Vec::new(), Vec::new(), [0.0; 2]);
    for seed in from..from + count {
        let (program, items, clock) = drawn(seed);
        let [fast, optimal] =
            [Quality::Fast, Quality::Optimal].map(|quality| plan(&items, clock, quality));
        let [fast_s, optimal_s] =
            [&fast, &optimal].map(|plan| (plan.len() - 1) as f64 * clock.period_s());
        times = [times[0] + fast_s, times[1] + optimal_s];
        if optimal_s > fast_s * (1.0 + 1e-9) {
            let part = optimal_s / fast_s - 1.0;
            println!(
                "{seed}: {fast_s} {optimal_s} s, {part:.2e} slower, {:?}, {} moves, {} ns",
                program.control,
                program.moves.len(),
                clock.period_ns()
            );
            slower.push((seed, part));
        }
        let [used_by_fast, used] = [&fast, &optimal].map(|plan| used(plan));
        if clock.period_ns() == 1_000_000 && used > used_by_fast.max(1.0) + MOST_BEYOND {
            println!("{seed}: {used} of a limit");
            beyond.push(seed);
        }
    }
    println!("{} of {count} slower, {times:?} s", slower.len());
    let worst = slower.iter().map(|(_, part)| *part).fold(0.0, f64::max);
    assert!(
        slower.len() as u64 <= count / 50 && worst < MOST_SLOWER && times[1] < times[0],
        "slower {slower:?}"
    );
    assert!(beyond.is_empty(), "beyond limits {beyond:?}");
}
