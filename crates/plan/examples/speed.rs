//! Segments and samples a second: `speed [THOUSANDS] [finish|rough|sine|noisy ...]`. Times are
//! processor-bound and of this run only; the first column is what later changes are compared with.

mod surfaces;

use lostmotion_base::Coords;
use lostmotion_kinematics::{KinematicsSpec, build};
use lostmotion_plan::{PlanItem, Planner, Sample};
use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Samples taken at once.
const CHUNK: usize = 8192;

#[derive(Default)]
struct Run {
    push: Duration,
    take: Duration,
    samples: u64,
    held: usize,
}

impl Run {
    fn drain(&mut self, planner: &mut Planner, samples: &mut Vec<Sample>) {
        let begin = Instant::now();
        loop {
            samples.clear();
            if planner.take(CHUNK, samples) == 0 {
                break;
            }
            self.samples += samples.len() as u64;
        }
        self.take += begin.elapsed();
    }
}

fn run(kind: &str, count: u64) -> Result<Run, Box<dyn Error>> {
    let kinematics = Arc::from(build(&KinematicsSpec {
        kind: "cartesian".into(),
        ..KinematicsSpec::default()
    })?);
    let mut planner = Planner::new(surfaces::config(), kinematics, Coords::ZERO)?;
    let (mut moves, mut run, mut samples) = (
        surfaces::moves(kind),
        Run::default(),
        Vec::with_capacity(CHUNK),
    );
    for _ in 0..count {
        let thousand: Vec<PlanItem> = moves.by_ref().take(1000).map(PlanItem::Move).collect();
        let begin = Instant::now();
        for item in thousand {
            planner.push(item)?;
        }
        run.push += begin.elapsed();
        run.held = run.held.max(planner.held_pieces());
        run.drain(&mut planner, &mut samples);
    }
    let begin = Instant::now();
    planner.finish()?;
    run.push += begin.elapsed();
    run.drain(&mut planner, &mut samples);
    Ok(run)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let count: u64 = args.next().map_or(Ok(20), |text| text.parse())?;
    let mut kinds: Vec<String> = args.collect();
    if kinds.is_empty() {
        kinds = ["finish", "rough", "sine", "noisy"]
            .map(String::from)
            .to_vec();
    }
    for kind in kinds {
        let Run {
            push,
            take,
            samples,
            held,
        } = run(&kind, count)?;
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
