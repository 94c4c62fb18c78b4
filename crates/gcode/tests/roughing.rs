//! Roughing comes as near to the finished profile as what is to be left on it, and nowhere nearer.
#![allow(clippy::unwrap_used)]

use lostmotion_base::math;
use lostmotion_gcode::{CanonicalOp, InterpreterConfig, Program};
use proptest::prelude::*;

/// Z and X.
type Place = [f64; 2];

/// What LinuxCNC takes for the same place while it moves a profile sideways, and rounding.
const SLACK_MM: f64 = 2e-3;

fn distance(point: Place, from: Place, to: Place) -> f64 {
    let (along, offset) = ([to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]);
    let share = (along[0] * offset[0] + along[1] * offset[1]) / (along[0] * along[0] + along[1] * along[1]);
    let share = share.clamp(0.0, 1.0);
    math::hypot(offset[0] - share * along[0], offset[1] - share * along[1])
}

/// How far a place is outside of the part, whose profile falls in Z and rises in X; negative inside.
fn clearance(point: Place, profile: &[Place]) -> f64 {
    let nearest = profile.windows(2).map(|pair| distance(point, pair[0], pair[1])).fold(f64::INFINITY, f64::min);
    let surface = |pair: &[Place]| pair[0][1] + (pair[1][1] - pair[0][1]) * (pair[0][0] - point[0]) / (pair[0][0] - pair[1][0]);
    let side = profile.windows(2).find(|pair| pair[1][0] <= point[0] && point[0] <= pair[0][0]);
    let inside = side.is_some_and(|pair| point[1] < surface(pair)) || point[0] < profile[profile.len() - 1][0];
    if inside { -nearest } else { nearest }
}

/// The least clearance along an arc from Z to X, sampled.
fn along_arc(from: Place, to: Place, center: Place, counter_clockwise: bool, profile: &[Place]) -> f64 {
    let angle = |place: Place| math::atan2(place[1] - center[1], place[0] - center[0]);
    let radius = math::hypot(from[0] - center[0], from[1] - center[1]);
    let sweep = (angle(to) - angle(from)).rem_euclid(std::f64::consts::TAU);
    let sweep = if counter_clockwise { sweep } else { sweep - std::f64::consts::TAU };
    let place = |step: u32| {
        let (sin, cos) = math::sin_cos(angle(from) + sweep * f64::from(step) / 50.0);
        clearance([center[0] + radius * cos, center[1] + radius * sin], profile)
    };
    (0..=50).map(place).fold(f64::INFINITY, f64::min)
}

fn program(cycle: &str, places: impl Iterator<Item = Place>, depth: f64, leave: f64) -> String {
    let lines: Vec<String> = places.enumerate().map(|(at, [z, x])| format!("  G{} X{x:.4} Z{z:.4}", at.min(1))).collect();
    format!("o100 sub\n{}\no100 endsub\nG18 F200\nG0 X60 Z5\n{cycle} Q100 D{leave} I{depth} R0.3\nM2\n", lines.join("\n"))
}

/// The least clearance of all moves, sampled, and how many straight feeds there were.
fn least_clearance(text: &str, profile: &[Place]) -> (f64, usize) {
    let mut run = Program::new(text.as_bytes(), InterpreterConfig::default());
    let (mut at, mut least, mut feeds) = ([5.0, 60.0], f64::INFINITY, 0);
    for sourced in run.by_ref() {
        let (end, feed) = match sourced.op {
            CanonicalOp::StraightFeed(end) => ([end[2], end[0]], true),
            CanonicalOp::StraightTraverse(end) => ([end[2], end[0]], false),
            CanonicalOp::ArcFeed(arc) => {
                least = least.min(along_arc(at, arc.end, arc.center, arc.turns > 0, profile));
                at = arc.end;
                continue;
            }
            _ => continue,
        };
        for step in 0..=200 {
            let share = f64::from(step) / 200.0;
            least = least.min(clearance([at[0] + share * (end[0] - at[0]), at[1] + share * (end[1] - at[1])], profile));
        }
        feeds += usize::from(feed);
        at = end;
    }
    assert_eq!(run.diagnostics().errors(), 0, "{text}{:?}", run.diagnostics().kept());
    (least, feeds)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn the_allowance_stays(steps in prop::collection::vec((0.5f64..6.0, 0.5f64..5.0), 2..8), depth in 0.3f64..3.0, leave in 0.0f64..0.3) {
        let mut profile = vec![[0.0, 4.0]];
        for (down, up) in steps {
            let [z, x] = profile[profile.len() - 1];
            let round = |value: f64| (value * 1e4).round() / 1e4;
            profile.push([round(z - down), round(x + up)]);
        }
        let top = profile[profile.len() - 1][1];
        let along = program("G71", profile.iter().copied(), depth, leave);
        let (least, feeds) = least_clearance(&along, &profile);
        prop_assert!(least >= leave - SLACK_MM && least <= leave + SLACK_MM, "{least} {along}");
        prop_assert!(feeds as f64 >= (60.0 - top) / depth);
        let across = program("G72", profile.iter().rev().copied(), depth, leave);
        let (least, feeds) = least_clearance(&across, &profile);
        prop_assert!(least >= leave - SLACK_MM && least <= leave + SLACK_MM, "{least} {across}");
        prop_assert!(feeds > 2);
    }
}
