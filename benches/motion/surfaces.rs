//! Generated lines of the kinds that CAM systems write, any number of them.

use lostmotion::base::{AxisLimits, BlockRef, Coords, Random, math};
use lostmotion::path::Curve;
use lostmotion::plan::{FeedLimit, Move, PathControl, PlannerConfig};

/// A point of a program and the feed to it, mm/s.
fn point(kind: &str, i: u64, random: &mut Random) -> (Coords, f64) {
    let mut roll = || random.unit() - 0.5;
    let t = i as f64;
    match kind {
        // Rows of 100 mm over a gently waved surface, as CAM writes them, with three decimals.
        "finish" | "rough" => {
            let (step, feed) = if kind == "finish" {
                (0.3, 33.0)
            } else {
                (0.8, 80.0)
            };
            let (row, along) = ((t * step / 100.0).floor(), (t * step) % 100.0);
            let x = if row % 2.0 == 0.0 {
                along
            } else {
                100.0 - along
            };
            let (y, round) = (0.2 * row, |v: f64| (v * 1e3).round() * 1e-3);
            (
                Coords::xyz(
                    round(x + 0.02 * roll()),
                    round(y % 200.0),
                    round(4.0 * math::sin(0.07 * x) * math::cos(0.05 * y)),
                ),
                feed,
            )
        }
        _ => {
            let noise = if kind == "noisy" { 0.01 } else { 0.0 };
            (
                Coords::xyz(
                    (0.2 * t) % 9000.0,
                    0.0,
                    2.0 * math::sin(0.314 * 0.2 * t) + noise * roll(),
                ),
                100.0,
            )
        }
    }
}

/// The moves of a kind of program, one after the other without an end: `finish`, `rough`, `sine` or
/// `noisy`.
pub(crate) fn moves(kind: &str) -> impl Iterator<Item = Move> + '_ {
    let (mut here, mut random) = (Coords::ZERO, Random::new(1));
    let control = PathControl::Continuous {
        tolerance_mm: Some(0.01),
        merge_tolerance_mm: None,
    };
    (1..).map(move |i| {
        let (end, feed) = point(kind, i, &mut random);
        let curve = Curve::line(here, end);
        here = end;
        let mut block = BlockRef::default();
        block.span.line = i as u32;
        Move {
            curve,
            feed: FeedLimit::PerSecond(feed),
            control,
            tool_mm: [0.0; 3],
            block,
        }
    })
}

/// Three linear axes.
pub(crate) fn config() -> PlannerConfig {
    let mut config = PlannerConfig::new([None; 9]);
    config.limits[..3].fill(Some(AxisLimits {
        min: -1e6,
        max: 1e6,
        velocity: 100.0,
        acceleration: 1e3,
        jerk: 3e4,
    }));
    config
}
