//! Programs made from numbers, and their judge.

use super::{LIMITS, Program, cartesian, continuous, deviation, run, three_axes};
use lostmotion_base::{AxisLimits, Clock, Coords, math};
use lostmotion_plan::{Dwell, FeedLimit, PathControl, PlanItem, PlannerConfig, Sample};
use std::f64::consts::{PI, TAU};

/// The generator that the programs of these tests have had from the start (PCG's multiplier and
/// increment): the seeds that the tests name once broke a limit, so its sequence stays. Anything new
/// takes [`lostmotion_base::Random`].
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn seeded(seed: u64) -> Dice {
        Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15))
    }

    /// From 0 to 1.
    pub(crate) fn roll(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }

    /// Between two positive numbers, every factor alike.
    pub(crate) fn spread(&mut self, low: f64, high: f64) -> f64 {
        low * math::pow(high / low, self.roll())
    }

    pub(crate) fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[(self.roll() * all.len() as f64) as usize]
    }
}

/// Short runs, arcs, long and tiny lines, near reversals, what does not move; about 20 moves.
pub(crate) fn program(seed: u64, control: PathControl, feed: f64) -> Program {
    let mut dice = Dice::seeded(seed);
    let mut program = Program::new(control, feed);
    let mut heading = 0.0;
    for _ in 0..5 {
        let kind = dice.roll();
        let [x, y, z] = program.here.linear();
        let (sin, cos) = math::sin_cos(heading);
        if kind < 0.4 {
            let (h, bend, noise) = (
                dice.between(0.02, 0.6),
                dice.between(-0.05, 0.05),
                dice.between(0.0, 0.003),
            );
            for _ in 0..12 {
                heading += bend * dice.roll();
                let [x, y, z] = program.here.linear();
                let (sin, cos) = math::sin_cos(heading);
                program.line(
                    x + h * cos - noise * sin * dice.roll(),
                    y + h * sin + noise * cos * dice.roll(),
                    z + 0.1 * h,
                );
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
            heading += dice.between(-PI, PI);
            let (sin, cos) = math::sin_cos(heading);
            program.line(x + 12.0 * cos, y + 12.0 * sin, z + dice.between(-4.0, 4.0));
        }
    }
    program
}

/// A program with a machine to plan it for.
pub(crate) struct Case {
    pub(crate) config: PlannerConfig,
    pub(crate) program: Program,
}

/// Three axes with limits like each other.
pub(crate) fn plain(seed: u64) -> Case {
    let tolerance = [0.002, 0.01, 0.05][(seed % 3) as usize];
    Case {
        config: three_axes(),
        program: program(seed, continuous(tolerance), 20.0 + (seed % 7) as f64 * 20.0),
    }
}

fn control(dice: &mut Dice) -> PathControl {
    match dice.roll() {
        part if part < 0.7 => continuous(dice.spread(0.0005, 1.0)),
        part if part < 0.85 => PathControl::ExactPath,
        part if part < 0.95 => PathControl::ExactStop,
        _ => PathControl::Continuous {
            tolerance_mm: None,
            merge_tolerance_mm: Some(dice.one_of(&[0.0, 0.003])),
        },
    }
}

fn machine(dice: &mut Dice) -> PlannerConfig {
    let mut config = three_axes();
    let (v, a, build_up_s) = (
        dice.spread(10.0, 800.0),
        dice.spread(100.0, 15_000.0),
        dice.spread(0.002, 0.3),
    );
    for limits in config.limits.iter_mut().flatten() {
        let (velocity, acceleration) = (v * dice.spread(0.4, 1.0), a * dice.spread(0.3, 1.0));
        *limits = AxisLimits {
            velocity,
            acceleration,
            jerk: acceleration / (build_up_s * dice.spread(0.4, 1.0)),
            ..LIMITS
        };
    }
    let period_ns = dice.one_of(&[
        250_000, 500_000, 1_000_000, 1_000_000, 2_000_000, 4_000_000, 8_000_000,
    ]);
    config.clock = Clock::from_nanos(period_ns).unwrap();
    config
}

/// Machines of all kinds, tolerances, feeds, and modes that change; moves from nothing to a metre.
pub(crate) fn varied(seed: u64) -> Case {
    let mut dice = Dice::seeded(seed ^ 0x5EED_0000_0000);
    let config = machine(&mut dice);
    let (mixed, first, feed) = (
        dice.roll() < 0.3,
        control(&mut dice),
        dice.spread(0.5, 400.0),
    );
    let mut program = Program::new(first, feed);
    let mut heading = dice.between(-PI, PI);
    for _ in 0..dice.between(2.0, 9.0) as usize {
        if mixed {
            program.control = control(&mut dice);
            program.feed = if dice.roll() < 0.2 {
                FeedLimit::Rapid
            } else {
                FeedLimit::PerSecond(dice.spread(0.5, 400.0))
            };
        }
        part(&mut program, &mut dice, &mut heading);
    }
    Case { config, program }
}

fn part(program: &mut Program, dice: &mut Dice, heading: &mut f64) {
    let ahead = |program: &mut Program, heading: f64, length: f64, off: [f64; 3]| {
        let [x, y, z] = program.here.linear();
        let (sin, cos) = math::sin_cos(heading);
        program.line(
            x + length * cos + off[0],
            y + length * sin + off[1],
            z + off[2],
        );
    };
    // About a second at the feed, so that slow programs do not last for hours.
    let slow = if let FeedLimit::PerSecond(feed) = program.feed {
        feed
    } else {
        400.0
    };
    let kind = dice.roll();
    if kind < 0.35 {
        let (h, bend, noise) = (
            dice.spread(0.001, 2.0).min(0.1 * slow),
            dice.spread(1e-4, 0.4),
            dice.one_of(&[0.0, 0.0005, 0.003, 0.02]),
        );
        let (turning, uneven, climb) = (
            dice.one_of(&[-1.0, 0.0, 1.0]),
            dice.one_of(&[0.0, 0.9]),
            dice.between(-0.3, 0.3),
        );
        for _ in 0..dice.between(3.0, 40.0) as usize {
            *heading += bend * (turning + dice.between(-0.2, 0.2));
            let length = h * (1.0 - uneven * dice.roll());
            let off = [
                noise * dice.between(-1.0, 1.0),
                noise * dice.between(-1.0, 1.0),
                climb * h,
            ];
            ahead(program, *heading, length, off);
        }
    } else if kind < 0.55 {
        let (r, turn) = (dice.spread(0.01, 80.0).min(slow), dice.one_of(&[1.0, -1.0]));
        let sweep = turn
            * if dice.roll() < 0.2 {
                TAU
            } else {
                dice.spread(0.01, 6.2)
            };
        let (sin, cos) = math::sin_cos(*heading + dice.one_of(&[0.0, 0.0, 0.0, 0.0005, 0.1, 2.0]));
        program.arc(-r * sin * turn, r * cos * turn, sweep);
        *heading += sweep;
    } else if kind < 0.75 {
        let length = dice.one_of(&[0.0, 1e-10, 3e-9, 1e-7, 1e-5, 0.004, 0.3]);
        ahead(program, *heading, length, [0.0; 3]);
    } else if kind < 0.85 {
        *heading += PI - dice.one_of(&[0.0, 1e-9, 1e-5, 0.01, 0.1]) * dice.between(-1.0, 1.0);
        ahead(
            program,
            *heading,
            dice.spread(0.01, 20.0).min(slow),
            [0.0; 3],
        );
    } else {
        *heading += dice.between(-PI, PI) * dice.one_of(&[0.01, 1.0]);
        ahead(
            program,
            *heading,
            dice.spread(1.0, 1000.0).min(2.0 * slow),
            [0.0, 0.0, dice.between(-4.0, 4.0)],
        );
    }
}

fn tolerance(config: &PlannerConfig, control: PathControl) -> f64 {
    match control {
        PathControl::Continuous { tolerance_mm, .. } => {
            tolerance_mm.unwrap_or(config.default_tolerance_mm)
        }
        PathControl::ExactPath | PathControl::ExactStop => config.exact_path_tolerance_mm,
    }
}

impl Case {
    /// Plans it with a dwell at the end.
    pub(crate) fn run(&self, clock: Clock) -> Vec<Sample> {
        let moves = self.program.moves.iter().map(|m| PlanItem::Move(*m));
        let dwell = PlanItem::Dwell(Dwell {
            seconds: 1e-3,
            block: Default::default(),
        });
        run(
            PlannerConfig {
                clock,
                ..self.config.clone()
            },
            cartesian(),
            Coords::ZERO,
            moves.chain([dwell]),
        )
    }

    /// What an outsider finds wrong with its samples.
    pub(crate) fn faults(&self, clock: Clock, samples: &[Sample]) -> Vec<String> {
        let mut faults = Vec::new();
        let (dt, last) = (clock.period_s(), samples[samples.len() - 1]);
        for (joint, limits) in self.config.limits[..3].iter().enumerate() {
            let limits = [
                limits.unwrap().velocity,
                limits.unwrap().acceleration,
                limits.unwrap().jerk,
            ];
            let mut q: Vec<f64> = samples
                .iter()
                .map(|sample| sample.position.0[joint])
                .collect();
            // The ends of an arc lie beside its circle by the rounding of the numbers that describe
            // it.
            let rounding =
                2e-12 + 4.0 * f64::EPSILON * q.iter().fold(1.0_f64, |most, q| most.max(q.abs()));
            let (first, end) = (q[0], q[q.len() - 1]);
            q.splice(0..0, [first; 4]);
            q.extend([end; 4]);
            for (order, limit) in limits.into_iter().enumerate() {
                q = q.windows(2).map(|pair| (pair[1] - pair[0]) / dt).collect();
                let slack = 1e-5 * limit + rounding * math::pow(2.0 / dt, (order + 1) as f64);
                if let Some((at, value)) = q
                    .iter()
                    .enumerate()
                    .find(|(_, value)| value.abs() > limit + slack)
                {
                    faults.push(format!(
                        "joint {joint}: derivative {} is {value} of {limit} at {} s",
                        order + 1,
                        (at as f64 - 4.0) * dt
                    ));
                }
            }
        }
        let moves = &self.program.moves;
        for sample in samples {
            let (low, high) = (
                (sample.segment as usize).saturating_sub(3),
                (sample.segment as usize + 4).min(moves.len()),
            );
            let allowed = moves[low..high]
                .iter()
                .map(|m| tolerance(&self.config, m.control))
                .fold(0.0, f64::max);
            let off = deviation(&[*sample], moves);
            if off > allowed + 1e-8 {
                faults.push(format!(
                    "{off} mm off the path of {allowed} at {} s",
                    sample.tick as f64 * dt
                ));
                break;
            }
        }
        if (last.position - self.program.here).linear_norm() > 1e-7 {
            faults.push(format!(
                "ends at {:?} instead of {:?}",
                last.position, self.program.here
            ));
        }
        if !samples
            .windows(2)
            .all(|pair| pair[0].segment <= pair[1].segment)
        {
            faults.push("goes back".into());
        }
        faults
    }
}
