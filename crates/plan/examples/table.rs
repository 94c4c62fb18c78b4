//! Scratch: times of the cases that matter.
#![allow(clippy::unwrap_used, clippy::all, missing_docs)]
#[path = "../tests/it/common/mod.rs"]
mod common;
use common::generate::Dice;
use common::*;
use lostmotion_base::{Coords, math};
use lostmotion_plan::PlanItem;

fn circle(r: f64, n: usize, turns: f64, p: f64, digits: Option<f64>) -> Program {
    let mut program = Program::new(continuous(p), 100.0);
    let steps = (n as f64 * turns) as usize;
    for k in 1..=steps {
        let a = std::f64::consts::TAU * k as f64 / n as f64;
        let (x, y) = (r * math::sin(a), r * (1.0 - math::cos(a)));
        let q = |v: f64| digits.map_or(v, |d| (v / d).round() * d);
        program.line(q(x), q(y), 0.0);
    }
    program
}
fn zigzag(l: f64, turn: f64, n: usize, p: f64) -> Program {
    let mut program = Program::new(continuous(p), 100.0);
    let a = turn.to_radians() / 2.0;
    let (mut x, mut y) = (0.0, 0.0);
    for k in 0..n {
        x += l * math::cos(a);
        y += l * math::sin(a) * if k % 2 == 0 { 1.0 } else { -1.0 };
        program.line(x, y, 0.0);
    }
    program
}
fn polygon(l: f64, turn: f64, n: usize, p: f64) -> Program {
    let mut program = Program::new(continuous(p), 100.0);
    let (mut x, mut y, mut a) = (0.0, 0.0, 0.0);
    for _ in 0..n {
        x += l * math::cos(a);
        y += l * math::sin(a);
        a += turn.to_radians();
        program.line(x, y, 0.0);
    }
    program
}
fn corner(l: f64, turn: f64, p: f64) -> Program {
    let mut program = Program::new(continuous(p), 100.0);
    let a = turn.to_radians();
    program.line(l, 0.0, 0.0);
    program.line(l + l * math::cos(a), l * math::sin(a), 0.0);
    program
}
fn scallops(p: f64) -> Program {
    let mut program = Program::new(continuous(p), 100.0);
    for _ in 0..10 {
        program.arc(2.5, 0.0, -std::f64::consts::PI);
    }
    program
}
fn sine(noise: f64, step: f64) -> Program {
    let (mut dice, mut program) = (Dice::seeded(7), Program::new(continuous(0.01), 100.0));
    for i in 1..=(120.0 / step) as usize {
        let x = step * i as f64;
        program.line(
            x,
            0.0,
            2.0 * math::sin(0.314 * x) + noise * dice.between(-1.0, 1.0),
        );
    }
    program
}
fn cpu() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap();
    let fields: Vec<&str> = text
        .rsplit(')')
        .next()
        .unwrap()
        .split_whitespace()
        .collect();
    fields[11].parse::<f64>().unwrap() * 0.01
}
fn surfacing() -> Program {
    let mut program = Program::new(continuous(0.02), 50.0);
    let height = |x: f64, y: f64| 2.0 * math::sin(x / 9.0) * math::cos(y / 13.0) - 5.0;
    let q = |v: f64| (v * 1e4).round() * 1e-4;
    let mut y = -75.0;
    for row in 0..20 {
        for i in 1..=300 {
            let along = -75.0 + 0.5 * i as f64;
            let x = if row % 2 == 0 { along } else { -along };
            program.line(x, y, q(height(x, y)));
        }
        y += 0.4;
        let [x, _, z] = program.here.linear();
        program.line(x, y, z);
    }
    program
}
fn drawn(seed: u64) -> Program {
    let mut dice = Dice::seeded(seed ^ 0x7A11);
    let p = dice.spread(0.002, 0.1);
    let mut program = Program::new(continuous(p), dice.between(20.0, 100.0));
    let mut heading = 0.0;
    for _ in 0..4 {
        let kind = dice.roll();
        let (l, turn) = (dice.spread(0.005, 5.0), dice.spread(0.005, 0.7));
        let n = (dice.spread(5.0, 60.0)) as usize;
        let grid = dice.one_of(&[0.0, 0.0, 1e-3, 2.54e-3]);
        let q = |v: f64| {
            if grid > 0.0 {
                (v / grid).round() * grid
            } else {
                v
            }
        };
        let side = dice.one_of(&[-1.0, 1.0]);
        for k in 0..n {
            heading += match kind {
                k2 if k2 < 0.3 => side * turn,
                k2 if k2 < 0.6 => turn * if k % 2 == 0 { 1.0 } else { -1.0 },
                _ => dice.between(-turn, turn),
            };
            let [x, y, z] = program.here.linear();
            let (sin, cos) = math::sin_cos(heading);
            program.line(q(x + l * cos), q(y + l * sin), z);
        }
        if dice.roll() < 0.3 {
            heading += dice.between(-2.0, 2.0);
        }
    }
    program
}
fn main() {
    let repeat: usize = std::env::var("REPEAT").map_or(1, |v| v.parse().unwrap());
    let filter = std::env::args().nth(1).unwrap_or_default();
    let mut cases: Vec<(String, Program)> = Vec::new();
    for (r, n) in [
        (5.0, 79),
        (5.0, 70),
        (5.0, 55),
        (5.0, 50),
        (2.0, 45),
        (20.0, 140),
        (20.0, 100),
    ] {
        let sag = r * (1.0 - math::cos(std::f64::consts::PI / n as f64)) / 0.01;
        cases.push((
            format!("chords R{r} n{n} sag/P {sag:.2}"),
            circle(r, n, 3.0, 0.01, None),
        ));
    }
    for (step, digits) in [
        (0.1, 1e-3),
        (0.02, 1e-3),
        (0.01, 1e-3),
        (0.005, 1e-3),
        (0.005, 2.54e-3),
    ] {
        let n = (20.0 * std::f64::consts::TAU / step) as usize;
        cases.push((
            format!("dense R20 step {step} digits {digits}"),
            circle(20.0, n, 1.0, 0.01, Some(digits)),
        ));
    }
    for turn in [6.0, 10.0, 20.0, 30.0] {
        cases.push((format!("zigzag 2 mm {turn}"), zigzag(2.0, turn, 60, 0.01)));
    }
    for (l, turn) in [
        (0.2, 5.0),
        (0.5, 5.0),
        (0.5, 10.0),
        (1.0, 5.0),
        (1.0, 10.0),
        (2.0, 5.0),
        (2.0, 10.0),
        (5.0, 5.0),
        (5.0, 10.0),
    ] {
        cases.push((format!("polygon {l} mm {turn}"), polygon(l, turn, 72, 0.01)));
    }
    for (turn, p) in [
        (10.0, 0.01),
        (30.0, 0.01),
        (60.0, 0.01),
        (10.0, 0.1),
        (30.0, 0.1),
        (60.0, 0.1),
        (30.0, 0.5),
        (60.0, 0.5),
        (120.0, 0.5),
    ] {
        cases.push((format!("corner {turn} P {p}"), corner(5.0, turn, p)));
    }
    cases.push(("scallops".into(), scallops(0.01)));
    for (noise, step) in [(0.0, 0.2), (0.005, 0.2), (0.0, 0.05), (0.002, 0.05)] {
        cases.push((format!("sine noise {noise} step {step}"), sine(noise, step)));
    }
    for p in [
        0.001, 0.002, 0.003, 0.005, 0.007, 0.01, 0.014, 0.02, 0.03, 0.05, 0.1,
    ] {
        let (radius, chord) = (5.0, 0.5);
        let mut program = Program::new(continuous(p), 100.0);
        program.line(20.0, 0.0, 0.0);
        let chords = (radius * std::f64::consts::FRAC_PI_2 / chord) as u32;
        for k in 1..=chords {
            let angle = std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(chords);
            program.line(
                20.0 + radius * math::sin(angle),
                radius * (1.0 - math::cos(angle)),
                0.0,
            );
        }
        program.line(20.0 + radius, radius + 20.0, 0.0);
        cases.push((format!("elbow {p}"), program));
    }
    cases.push(("surfacing".into(), surfacing()));
    if filter.starts_with("random") {
        for seed in 0..400 {
            cases.push((
                format!("random plain {seed}"),
                common::generate::plain(seed).program,
            ));
        }
        for seed in 0..400 {
            cases.push((format!("random drawn {seed}"), drawn(seed)));
        }
    }
    for (turn, rotation) in [
        (60.0, 0.0),
        (60.0, 20.0),
        (60.0, 45.0),
        (45.0, 0.0),
        (45.0, 20.0),
        (30.0, 0.0),
        (30.0, 20.0),
    ] {
        let mut program = Program::new(continuous(0.01), 60.0);
        let a = f64::to_radians(rotation);
        program.line(30.0 * math::cos(a), 30.0 * math::sin(a), 0.0);
        let b = f64::to_radians(rotation + turn);
        program.line(
            30.0 * (math::cos(a) + math::cos(b)),
            30.0 * (math::sin(a) + math::sin(b)),
            0.0,
        );
        cases.push((format!("any {turn} {rotation}"), program));
    }
    for p in [0.001, 0.01, 0.1] {
        for l in [1.0, 10.0, 40.0] {
            for turn in [5.0, 15.0, 25.0, 35.0, 45.0, 60.0] {
                for rotation in [0.0, 15.0] {
                    let mut program = Program::new(continuous(p), 100.0);
                    let a = f64::to_radians(rotation);
                    program.line(l * math::cos(a), l * math::sin(a), 0.0);
                    let b = f64::to_radians(rotation + turn);
                    program.line(
                        l * (math::cos(a) + math::cos(b)),
                        l * (math::sin(a) + math::sin(b)),
                        0.0,
                    );
                    cases.push((format!("single {p} {l} {turn} {rotation}"), program));
                }
            }
        }
    }
    for (name, program) in cases.into_iter().filter(|(name, _)| name.contains(&filter)) {
        let begin = cpu();
        for _ in 1..repeat {
            run(
                three_axes(),
                cartesian(),
                Coords::ZERO,
                program.moves.iter().map(|m| PlanItem::Move(*m)),
            );
        }
        let samples = run(
            three_axes(),
            cartesian(),
            Coords::ZERO,
            program.moves.iter().map(|m| PlanItem::Move(*m)),
        );
        let spent = (cpu() - begin) / repeat as f64;
        let mut over = 0.0_f64;
        for joint in 0..3 {
            let [v, a, j] = peaks(&samples, joint);
            over = over.max(v / 100.0).max(a / 1000.0).max(j / 30000.0);
        }
        let dev = deviation(&samples, &program.moves);
        println!(
            "{name:36} {:8.3} s  used {over:.4}  off {:.2} um  moves {} spent {:.2} us/move",
            (samples.len() - 1) as f64 * 1e-3,
            dev * 1e3,
            program.moves.len(),
            spent * 1e6 / program.moves.len() as f64
        );
    }
}
