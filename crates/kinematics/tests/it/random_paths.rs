//! Random paths of directions on every family of five-axis machine, against all sequences of
//! solutions.

use crate::common::{FIVE, machines};
use lostmotion_base::Random;
use lostmotion_base::units::rad;
use lostmotion_kinematics::orient::{Angles, Orientation};
use lostmotion_kinematics::{Kinematics, Reach, build_within};
use std::f64::consts::TAU;

/// A, B and C, degrees.
const TRAVEL: [(usize, f64, f64); 3] = [(3, -110.0, 110.0), (4, -200.0, 200.0), (5, -400.0, 400.0)];

fn named(name: &str) -> Box<dyn Kinematics> {
    let spec = machines()
        .into_iter()
        .find(|m| m.name == name)
        .unwrap()
        .spec;
    let mut reach = Reach::default();
    for (axis, min, max) in TRAVEL {
        reach.0[axis] = Some((rad(min), rad(max)));
    }
    build_within(&spec, &reach).unwrap()
}

fn limits(orientation: &Orientation) -> Vec<(f64, f64)> {
    let of = |axis: usize| {
        TRAVEL
            .iter()
            .find(|travel| travel.0 == axis)
            .map(|(_, min, max)| (rad(*min), rad(*max)))
            .unwrap()
    };
    orientation.axes().map(|axis| of(axis.index())).collect()
}

/// Every position within the travel that gives a direction.
fn positions(orientation: &Orientation, direction: [f64; 3]) -> Vec<Angles> {
    let limits = limits(orientation);
    let turns = |angle: f64, (min, max): (f64, f64)| -> Vec<f64> {
        (-3..=3)
            .map(|k| angle + TAU * f64::from(k))
            .filter(|a| *a >= min && *a <= max)
            .collect()
    };
    let mut found = Vec::new();
    for (first, second) in orientation.solutions(direction) {
        let seconds = turns(second, limits[1]);
        for a in first.map_or_else(Vec::new, |first| turns(first, limits[0])) {
            found.extend(seconds.iter().map(|b| [a, *b]));
        }
    }
    found
}

fn turned(a: Angles, b: Angles) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).abs()
}

/// Least sum of turns, by trying every sequence.
fn brute_force(choices: &[Vec<Angles>], from: Angles) -> f64 {
    let Some((first, rest)) = choices.split_first() else {
        return 0.0;
    };
    first
        .iter()
        .map(|angles| turned(*angles, from) + brute_force(rest, *angles))
        .fold(f64::INFINITY, f64::min)
}

/// Of all sequences of solutions and whole turns within the travel, none turns less; where there is
/// none, that is said.
#[test]
fn the_choice_turns_least_of_all_sequences() {
    for name in FIVE {
        let machine = named(name);
        let orientation = machine.orientation().unwrap();
        let mut random = Random::new(21);
        let (mut had, mut refused, mut poles) = (0, 0, 0);
        for _ in 0..120 {
            let mut at = [random.signed(), random.signed()];
            let from = at;
            let directions: Vec<[f64; 3]> = (0..4)
                .map(|_| {
                    at = [
                        at[0] + 3.0 * random.signed(),
                        (at[1] + 1.2 * random.signed()).clamp(-1.8, 1.8),
                    ];
                    orientation.direction(at)
                })
                .collect();
            let choices: Vec<Vec<Angles>> = directions
                .iter()
                .map(|direction| positions(orientation, *direction))
                .collect();
            let least = brute_force(&choices, from);
            let Ok(chosen) = orientation.choose(from, &directions) else {
                assert!(least.is_infinite(), "{name}: refused, but {least} would do");
                refused += 1;
                continue;
            };
            let mut before = from;
            let (mut sum, mut farthest) = (0.0, 0.0_f64);
            for (angles, direction) in chosen.iter().zip(&directions) {
                let there = orientation.direction(*angles);
                farthest = farthest.max(
                    (0..3)
                        .map(|i| (there[i] - direction[i]).powi(2))
                        .sum::<f64>()
                        .sqrt(),
                );
                assert!(
                    angles
                        .iter()
                        .zip(limits(orientation))
                        .all(|(a, (min, max))| *a >= min - 1e-9 && *a <= max + 1e-9),
                    "{name}"
                );
                sum += turned(*angles, before);
                before = *angles;
            }
            // Within half of the tolerance of a pole the first joint may stay, which turns less
            // than any exact way.
            let near = farthest > 1e-8;
            assert!(
                farthest <= 0.5 * orientation.tolerance_rad(),
                "{name}: {farthest}"
            );
            assert!(
                sum <= least + 1e-7 && (near || sum >= least - 1e-7),
                "{name}: {sum} instead of {least}"
            );
            poles += u32::from(near);
            had += 1;
        }
        assert!(
            had >= 20 && poles <= had / 10,
            "{name}: {had} had, {refused} refused, {poles} near a pole"
        );
    }
}

/// A path of great circles that stays away from the poles leaves no choice but the solution that it
/// begins with: the joints turn exactly as far as that one does.
#[test]
fn a_path_away_from_the_poles_turns_no_farther_than_it_has_to() {
    const PARTS: u32 = 400;
    for name in FIVE {
        let machine = named(name);
        let orientation = machine.orientation().unwrap();
        let mut random = Random::new(22);
        let mut seen = 0;
        for _ in 0..200 {
            let from = [random.signed(), random.between(0.4, 0.9)];
            let to = [
                from[0] + 1.2 * random.signed(),
                (from[1] + 0.5 * random.signed()).clamp(0.3, 1.2),
            ];
            let (here, there) = (orientation.direction(from), orientation.direction(to));
            let Ok(steps) = orientation.follow(from, &[there]) else {
                continue;
            };
            // The great circle in small parts, each with the position nearest to the one before.
            let at = |part: f64| -> [f64; 3] {
                std::array::from_fn(|i| here[i] + part * (there[i] - here[i]))
            };
            let nearest = |near: Angles, direction: [f64; 3]| {
                positions(orientation, direction)
                    .into_iter()
                    .min_by(|a, b| turned(*a, near).total_cmp(&turned(*b, near)))
            };
            let (mut before, mut least, mut widest) = (from, 0.0, 0.0_f64);
            for part in 1..=PARTS {
                let Some(next) = nearest(before, at(f64::from(part) / f64::from(PARTS))) else {
                    break;
                };
                widest = widest.max(turned(next, before));
                least += turned(next, before);
                before = next;
            }
            if widest > 0.1 || turned(before, to) > 1e-6 {
                continue;
            }
            let (mut last, mut sum) = (from, 0.0);
            for step in &steps {
                sum += turned(step.angles, last);
                last = step.angles;
            }
            assert!(
                sum <= least * 1.001 + 1e-6,
                "{name}: {sum} instead of {least}"
            );
            assert!(
                turned(last, to) < 1e-6,
                "{name}: {last:?} instead of {to:?}"
            );
            seen += 1;
        }
        assert!(seen >= 60, "{name}: {seen}");
    }
}
