//! Segments and samples a second: `speed [THOUSANDS] [finish|rough|sine|noisy ...]`. Times are processor-bound and of this run only; the
//! first column is what later changes are compared with.

use lostmotion_base::{AxisLimits, BlockRef, Coords, math};
use lostmotion_kinematics::{KinematicsSpec, build};
use lostmotion_path::Curve;
use lostmotion_plan::{FeedLimit, Move, PathControl, PlanItem, Planner, PlannerConfig, Sample};
use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Samples taken at once.
const CHUNK: usize = 8192;

/// A point of a program and the feed to it, mm/s.
fn point(kind: &str, i: u64, noise: &mut u64) -> (Coords, f64) {
    let mut roll = || {
        *noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*noise >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let t = i as f64;
    match kind {
        // Rows of 100 mm over a gently waved surface, as CAM writes them, with three decimals.
        "finish" | "rough" => {
            let (step, feed) = if kind == "finish" { (0.3, 33.0) } else { (0.8, 80.0) };
            let (row, along) = ((t * step / 100.0).floor(), (t * step) % 100.0);
            let x = if row % 2.0 == 0.0 { along } else { 100.0 - along };
            let (y, round) = (0.2 * row, |v: f64| (v * 1e3).round() * 1e-3);
            (Coords::xyz(round(x + 0.02 * roll()), round(y % 200.0), round(4.0 * math::sin(0.07 * x) * math::cos(0.05 * y))), feed)
        }
        _ => {
            let noise = if kind == "noisy" { 0.01 } else { 0.0 };
            (Coords::xyz((0.2 * t) % 9000.0, 0.0, 2.0 * math::sin(0.314 * 0.2 * t) + noise * roll()), 100.0)
        }
    }
}

struct Run {
    push: Duration,
    take: Duration,
    samples: u64,
    held: usize,
}

fn run(kind: &str, count: u64) -> Result<Run, Box<dyn Error>> {
    let mut config = PlannerConfig::new([None; 9]);
    config.limits[..3].fill(Some(AxisLimits { min: -1e6, max: 1e6, velocity: 100.0, acceleration: 1e3, jerk: 3e4 }));
    let kinematics = Arc::from(build(&KinematicsSpec { kind: "cartesian".into(), ..KinematicsSpec::default() })?);
    let (mut here, mut noise) = (Coords::ZERO, 1);
    let mut planner = Planner::new(config, kinematics, here)?;
    let control = PathControl::Continuous { tolerance_mm: Some(0.01), merge_tolerance_mm: None };
    let mut run = Run { push: Duration::ZERO, take: Duration::ZERO, samples: 0, held: 0 };
    let mut samples: Vec<Sample> = Vec::with_capacity(CHUNK);
    let mut drain = |planner: &mut Planner, run: &mut Run| {
        let begin = Instant::now();
        loop {
            samples.clear();
            if planner.take(CHUNK, &mut samples) == 0 {
                break;
            }
            run.samples += samples.len() as u64;
        }
        run.take += begin.elapsed();
    };
    for thousand in 0..count {
        let moves: Vec<PlanItem> = (1..=1000)
            .map(|i| {
                let (end, feed) = point(kind, thousand * 1000 + i, &mut noise);
                let curve = Curve::line(here, end);
                here = end;
                let mut block = BlockRef::default();
                block.span.line = i as u32;
                PlanItem::Move(Move { curve, feed: FeedLimit::PerSecond(feed), control, tool_mm: [0.0; 3], block })
            })
            .collect();
        let begin = Instant::now();
        for item in moves {
            planner.push(item)?;
        }
        run.push += begin.elapsed();
        run.held = run.held.max(planner.held_pieces());
        drain(&mut planner, &mut run);
    }
    let begin = Instant::now();
    planner.finish()?;
    run.push += begin.elapsed();
    drain(&mut planner, &mut run);
    Ok(run)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let count: u64 = args.next().map_or(Ok(20), |text| text.parse())?;
    let mut kinds: Vec<String> = args.collect();
    if kinds.is_empty() {
        kinds = ["finish", "rough", "sine", "noisy"].map(String::from).to_vec();
    }
    for kind in kinds {
        let Run { push, take, samples, held } = run(&kind, count)?;
        let segments = (count * 1000) as f64;
        println!(
            "{kind:8} {:9.0} segments/s ({:6.0} ns each), {:6.2} M samples/s ({samples} samples, {:.3} s of motion), {held} pieces held",
            segments / push.as_secs_f64(),
            push.as_secs_f64() / segments * 1e9,
            samples as f64 / take.as_secs_f64() * 1e-6,
            samples as f64 * 1e-3,
        );
    }
    Ok(())
}
