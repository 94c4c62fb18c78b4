//! Directions into rotary axes: both solutions, the shortest way through many, and poles that
//! nothing jumps at.

use crate::common::{FIVE, machines};
use lostmotion_base::Random;
use lostmotion_base::units::rad;
use lostmotion_kinematics::orient::Angles;
use lostmotion_kinematics::{Kinematics, OrientError, Reach, bow_mm, build_within};
use std::f64::consts::{PI, TAU};

fn named(name: &str, travel_deg: &[(usize, f64, f64)]) -> Box<dyn Kinematics> {
    let spec = machines()
        .into_iter()
        .find(|m| m.name == name)
        .unwrap()
        .spec;
    let mut reach = Reach::default();
    for (axis, min, max) in travel_deg {
        reach.0[*axis] = Some((rad(*min), rad(*max)));
    }
    build_within(&spec, &reach).unwrap()
}

fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    let size = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
    size.atan2((0..3).map(|i| a[i] * b[i]).sum())
}

#[test]
fn both_solutions_give_the_direction() {
    for name in FIVE {
        let machine = named(name, &[]);
        let orientation = machine.orientation().unwrap();
        let mut random = Random::new(5);
        let mut reached = 0;
        for _ in 0..2_000 {
            let direction = random.direction();
            let solutions = orientation.solutions(direction);
            reached += u32::from(!solutions.is_empty());
            assert!(solutions.is_empty() || solutions.len() == 2);
            for (first, second) in &solutions {
                let there = orientation.direction([first.unwrap_or(0.3), *second]);
                assert!(
                    angle(there, direction) < 2e-9,
                    "{name} {direction:?} {first:?} {second} {}",
                    angle(there, direction)
                );
            }
        }
        // A tilting axis across the other reaches all directions, one that leans by 45 degrees half
        // of them.
        assert!(
            reached == 2_000 || name.starts_with("nutating") && (950..1050).contains(&reached),
            "{name} {reached}"
        );
    }
}

#[test]
fn near_a_pole_solutions_stay_exact() {
    for name in FIVE {
        let machine = named(name, &[]);
        let orientation = machine.orientation().unwrap();
        for exponent in 1..12 {
            for turn in 0..12 {
                let tilt = 10f64.powi(-exponent);
                let from = [TAU * f64::from(turn) / 12.0, tilt];
                let direction = orientation.direction(from);
                let found = orientation.solutions(direction);
                let nearest = found.iter().map(|(a, b)| {
                    let a = a.map_or(0.0, |a| (a - from[0] + PI).rem_euclid(TAU) - PI);
                    // A direction in doubles cannot tell the turn about a pole better than its
                    // rounding over the tilt.
                    (a.abs() * tilt).max((b - from[1]).abs())
                });
                assert!(
                    nearest.fold(f64::INFINITY, f64::min) < 3e-14,
                    "{name} {tilt} {found:?} {from:?}"
                );
            }
        }
    }
}

/// Least sum of turns through a list, by trying everything.
fn brute_force(choices: &[Vec<Angles>], from: Angles) -> f64 {
    let Some((first, rest)) = choices.split_first() else {
        return 0.0;
    };
    first
        .iter()
        .map(|angles| {
            (angles[0] - from[0]).abs() + (angles[1] - from[1]).abs() + brute_force(rest, *angles)
        })
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn the_way_through_many_directions_turns_least() {
    for name in ["table-table AC", "head-head CA", "nutating head"] {
        let travel = [(3, -110.0, 110.0), (4, -360.0, 360.0), (5, -400.0, 400.0)];
        let machine = named(name, &travel);
        let orientation = machine.orientation().unwrap();
        let limits: Vec<(f64, f64)> = orientation
            .axes()
            .map(|axis| {
                travel
                    .iter()
                    .find(|t| t.0 == axis.index())
                    .map(|t| (rad(t.1), rad(t.2)))
                    .unwrap()
            })
            .collect();
        let (first, second) = (limits[0], limits[1]);
        let mut random = Random::new(6);
        for _ in 0..60 {
            let mut at = [random.signed(), random.signed()];
            let from = [at[0], at[1]];
            let directions: Vec<[f64; 3]> = (0..4)
                .map(|_| {
                    at = [
                        at[0] + 3.0 * random.signed(),
                        (at[1] + 1.2 * random.signed()).clamp(-1.8, 1.8),
                    ];
                    orientation.direction(at)
                })
                .collect();
            let chosen = orientation.choose(from, &directions).unwrap();
            let choices: Vec<Vec<Angles>> = directions
                .iter()
                .map(|direction| {
                    let found = orientation.solutions(*direction);
                    let turns = |angle: f64, limits: (f64, f64)| {
                        (-3..=3)
                            .map(move |k| angle + TAU * f64::from(k))
                            .filter(move |a| *a >= limits.0 && *a <= limits.1)
                    };
                    found
                        .iter()
                        .flat_map(|(a, b)| {
                            turns(a.unwrap(), first)
                                .flat_map(move |a| turns(*b, second).map(move |b| [a, b]))
                        })
                        .collect()
                })
                .collect();
            let mut sum = 0.0;
            let mut before = from;
            for (angles, direction) in chosen.iter().zip(&directions) {
                assert!(angle(orientation.direction(*angles), *direction) < 1e-8);
                assert!((0..2).all(|i| angles[i] >= limits[i].0 - 1e-9 && angles[i] <= limits[i].1 + 1e-9));
                sum += (angles[0] - before[0]).abs() + (angles[1] - before[1]).abs();
                before = *angles;
            }
            let least = brute_force(&choices, from);
            assert!(
                (sum - least).abs() < 1e-7,
                "{name}: {sum} instead of {least}"
            );
        }
    }
}

/// Follows random turns and looks at every step: the joints go no farther than the directions ask,
/// the tool stays on its way.
#[test]
fn turns_are_followed_within_the_tolerance_and_without_jumps() {
    for name in FIVE {
        let machine = named(name, &[]);
        let orientation = machine.orientation().unwrap();
        let mut random = Random::new(8);
        let pole = orientation.direction([0.0, 0.0]);
        for _ in 0..30 {
            let from = [2.0 * random.signed(), random.between(0.1, 0.7)];
            let here = orientation.direction(from);
            // Half of the turns pass near the pole.
            let away = 10f64.powf(random.between(-7.0, -0.5));
            let mut there = random.direction();
            if random.signed() > 0.0 {
                there = std::array::from_fn(|i| {
                    2.0 * pole[i] * (0..3).map(|k| pole[k] * here[k]).sum::<f64>() - here[i]
                        + away * there[i]
                });
            }
            let size = there.iter().map(|c| c * c).sum::<f64>().sqrt();
            let there = there.map(|c| c / size);
            if orientation.solutions(there).is_empty()
                || angle(here, there) > 2.5
                || orientation
                    .solutions(std::array::from_fn(|i| here[i] + there[i]))
                    .is_empty()
            {
                continue;
            }
            let steps = match orientation.follow(from, &[there]) {
                Ok(steps) => steps,
                Err(OrientError::Unreachable { .. }) => continue,
                Err(error) => panic!("{name}: {error}"),
            };
            let mut before = from;
            for step in &steps {
                for part in 0..=8 {
                    let u = f64::from(part) / 8.0;
                    let direction = orientation
                        .direction([0, 1].map(|i| before[i] + u * (step.angles[i] - before[i])));
                    // How far it lies off the plane of the great circle.
                    let normal: [f64; 3] = [1, 2, 0]
                        .map(|i| here[i] * there[(i + 1) % 3] - here[(i + 1) % 3] * there[i]);
                    let size = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
                    let off = ((0..3).map(|i| normal[i] * direction[i]).sum::<f64>() / size)
                        .asin()
                        .abs();
                    assert!(
                        off < 1.05 * orientation.tolerance_rad(),
                        "{name}: {off} off the way"
                    );
                }
                before = step.angles;
            }
            assert!(
                angle(orientation.direction(before), there) < 1.01 * orientation.tolerance_rad()
            );
            assert!((steps[steps.len() - 1].part - 1.0).abs() < 1e-15);
        }
    }
}

#[test]
fn a_pole_is_crossed_by_tilting_to_the_other_side() {
    let machine = named("table-table AC", &[]);
    let orientation = machine.orientation().unwrap();
    let (from, to) = ([0.7, rad(20.0)], orientation.direction([0.7, rad(-20.0)]));
    let steps = orientation.follow(from, &[to]).unwrap();
    assert!(
        steps.iter().all(|step| (step.angles[0] - 0.7).abs() < 1e-6),
        "C stays"
    );
    assert!((steps[steps.len() - 1].angles[1] - rad(-20.0)).abs() < 1e-9);
    // Where the tilt cannot go to the other side, C has to turn, and the tool cannot stay on its
    // way meanwhile.
    let half = named("table-table AC", &[(3, 0.0, 100.0)]);
    let refused = half.orientation().unwrap().follow(from, &[to]);
    assert!(
        refused.is_ok() || matches!(refused, Err(OrientError::Jump { .. })),
        "{refused:?}"
    );
    if let Ok(steps) = refused {
        let mut before = from;
        for step in steps {
            assert!((step.angles[1]) >= -1e-9 && (step.angles[0] - before[0]).abs() < 3.2);
            before = step.angles;
        }
    }
}

#[test]
fn what_cannot_be_had_is_refused() {
    let machine = named("nutating head", &[]);
    let down = machine
        .orientation()
        .unwrap()
        .choose([0.0; 2], &[[0.0, 0.0, -1.0]]);
    assert!(matches!(down, Err(OrientError::Unreachable { .. })));
    let machine = named("head-head CA", &[(3, -30.0, 30.0)]);
    let orientation = machine.orientation().unwrap();
    assert!(matches!(
        orientation.choose([0.0; 2], &[[0.0, 1.0, 0.0]]),
        Err(OrientError::Travel { .. })
    ));
    let one = named("rotary table A", &[]);
    let orientation = one.orientation().unwrap();
    let quarter = orientation.choose([0.0; 2], &[[0.0, -1.0, 0.0]]).unwrap();
    assert!((quarter[0][0] - 0.5 * PI).abs() < 1e-12);
    assert!(orientation.choose([0.0; 2], &[[0.5, -0.5, 0.7]]).is_err());
}

#[test]
fn a_line_without_tip_control_bows_as_far_as_geometry_says() {
    let machine = named("rotary table A", &[]);
    // The tip 80 mm from the axis of A; one degree.
    let mut from = lostmotion_base::Coords::xyz(40.0, -25.0, 140.0);
    let mut to = from;
    (from.0[3], to.0[3]) = (rad(10.0), rad(11.0));
    let bow = bow_mm(machine.as_ref(), &from, &to, &[0.0; 3]);
    assert!((bow - 80.0 * (1.0 - rad(0.5).cos())).abs() < 1e-9, "{bow}");
}
