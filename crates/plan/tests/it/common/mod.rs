//! Machines, programs and an outside judge for the planner's tests.
#![allow(dead_code, clippy::unwrap_used)]

pub(crate) mod generate;
pub(crate) mod paced;

use lostmotion_base::{AxisLimits, BlockRef, Coords, math};
use lostmotion_kinematics::{CartesianSpec, Kinematics, build};
use lostmotion_path::{Arc as PathArc, ArcSpec, Curve, Plane};
use lostmotion_plan::{
    FeedLimit, Move, PathControl, PlanItem, Planner, PlannerConfig, Quality, Sample,
};
use std::sync::Arc;

pub(crate) const LIMITS: AxisLimits = AxisLimits {
    min: -1e4,
    max: 1e4,
    velocity: 100.0,
    acceleration: 1000.0,
    jerk: 30_000.0,
};

pub(crate) fn cartesian() -> Arc<dyn Kinematics> {
    Arc::from(build(&CartesianSpec {}.into()).unwrap())
}

pub(crate) fn three_axes() -> PlannerConfig {
    let mut config = PlannerConfig::new([None; 9]);
    config.limits[..3].fill(Some(LIMITS));
    config
}

pub(crate) fn optimal() -> PlannerConfig {
    PlannerConfig {
        quality: Quality::Optimal,
        ..three_axes()
    }
}

pub(crate) fn continuous(tolerance_mm: f64) -> PathControl {
    PathControl::Continuous {
        tolerance_mm: Some(tolerance_mm),
        merge_tolerance_mm: None,
    }
}

/// Moves one after the other from a start.
pub(crate) struct Program {
    pub(crate) here: Coords,
    pub(crate) feed: FeedLimit,
    pub(crate) control: PathControl,
    pub(crate) moves: Vec<Move>,
}

impl Program {
    pub(crate) fn new(control: PathControl, feed_mm_s: f64) -> Program {
        Program {
            here: Coords::ZERO,
            feed: FeedLimit::PerSecond(feed_mm_s),
            control,
            moves: Vec::new(),
        }
    }

    pub(crate) fn add(&mut self, curve: Curve) {
        let mut block = BlockRef::default();
        block.span.line = self.moves.len() as u32 + 1;
        self.here = curve.end();
        self.moves.push(Move {
            curve,
            feed: self.feed,
            control: self.control,
            tool_mm: [0.0; 3],
            block,
        });
    }

    pub(crate) fn line(&mut self, x: f64, y: f64, z: f64) {
        self.add(Curve::line(self.here, Coords::xyz(x, y, z)));
    }

    /// An arc about a centre relative to the start, to an end at the same distance, given by its
    /// sweep in rad.
    pub(crate) fn arc(&mut self, i: f64, j: f64, sweep: f64) {
        let [x, y, z] = self.here.linear();
        let (center, radius) = ([x + i, y + j], math::hypot(i, j));
        let angle = math::atan2(-j, -i) + sweep;
        let full = (sweep.abs() - std::f64::consts::TAU).abs() < 1e-12;
        let end = if full {
            self.here
        } else {
            Coords::xyz(
                center[0] + radius * math::cos(angle),
                center[1] + radius * math::sin(angle),
                z,
            )
        };
        let rotation = if sweep > 0.0 { 1 } else { -1 };
        self.add(Curve::Arc(
            PathArc::new(ArcSpec {
                start: self.here,
                end,
                plane: Plane::Xy,
                center,
                rotation,
            })
            .unwrap(),
        ));
    }

    pub(crate) fn run(&self) -> Vec<Sample> {
        self.run_with(three_axes())
    }

    pub(crate) fn run_with(&self, config: PlannerConfig) -> Vec<Sample> {
        run(
            config,
            cartesian(),
            Coords::ZERO,
            self.moves.iter().map(|m| PlanItem::Move(*m)),
        )
    }
}

pub(crate) fn run(
    config: PlannerConfig,
    kinematics: Arc<dyn Kinematics>,
    start: Coords,
    items: impl Iterator<Item = PlanItem>,
) -> Vec<Sample> {
    let mut planner = Planner::new(config, kinematics, start).unwrap();
    let mut samples = Vec::new();
    for item in items {
        planner.push(item).unwrap();
        planner.take(usize::MAX, &mut samples);
    }
    planner.finish().unwrap();
    planner.take(usize::MAX, &mut samples);
    samples
}

/// Largest velocity, acceleration and jerk of a joint by differences of the samples, padded with
/// rest.
pub(crate) fn peaks(samples: &[Sample], joint: usize) -> [f64; 3] {
    let mut q: Vec<f64> = samples
        .iter()
        .map(|sample| sample.position.0[joint])
        .collect();
    let (first, last) = (q[0], *q.last().unwrap());
    q.splice(0..0, [first; 4]);
    q.extend([last; 4]);
    let mut out = [0.0; 3];
    for peak in &mut out {
        q = q
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) / 1e-3)
            .collect();
        *peak = q.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    }
    out
}

/// Panics where a joint passes its limits.
pub(crate) fn assert_limits(samples: &[Sample], limits: &[Option<AxisLimits>]) {
    for (joint, limits) in limits.iter().enumerate() {
        let Some(limits) = limits else { continue };
        let [v, a, j] = peaks(samples, joint);
        // Differences of positions of some hundred mm have a jerk of about 1e-4 of the limit from
        // rounding alone.
        let good = v <= limits.velocity * 1.0001
            && a <= limits.acceleration * 1.0005
            && j <= limits.jerk * 1.001;
        assert!(good, "joint {joint}: v {v} a {a} j {j}");
    }
}

/// Largest distance of a sample from the programmed moves near the one that the sample names, in
/// mm.
pub(crate) fn deviation(samples: &[Sample], moves: &[Move]) -> f64 {
    let mut worst = 0.0_f64;
    for sample in samples {
        let (low, high) = (
            (sample.segment as usize).saturating_sub(3),
            (sample.segment as usize + 4).min(moves.len()),
        );
        let distance = |m: &Move| {
            m.curve
                .nearest(sample.position.linear(), (0.0, m.curve.length()), 1e-9)
                .distance
        };
        worst = worst.max(
            moves[low..high]
                .iter()
                .map(distance)
                .fold(f64::INFINITY, f64::min),
        );
    }
    worst
}
