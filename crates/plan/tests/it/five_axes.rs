//! Joint limits under tool-centre-point control.

use crate::common::{assert_limits, continuous, run};
use lostmotion_base::units::rad;
use lostmotion_base::{AxisLimits, BlockRef, Coords, math};
use lostmotion_kinematics::{Kinematics, TrunnionAcSpec, build};
use lostmotion_path::Curve;
use lostmotion_plan::{FeedLimit, Move, PathControl, PlanItem, PlannerConfig};
use std::sync::Arc;

fn trunnion() -> Arc<dyn Kinematics> {
    let spec = TrunnionAcSpec {
        rotation_point_mm: [200.0, 150.0, -40.0],
        offset_y_mm: Some(3.0),
        offset_z_mm: Some(20.0),
        ..TrunnionAcSpec::default()
    };
    Arc::from(build(&spec.into()).unwrap())
}

fn config() -> PlannerConfig {
    let linear = AxisLimits {
        min: -2000.0,
        max: 2000.0,
        velocity: 200.0,
        acceleration: 2000.0,
        jerk: 50_000.0,
    };
    let rotary = AxisLimits {
        min: -100.0,
        max: 100.0,
        velocity: 1.0,
        acceleration: 8.0,
        jerk: 200.0,
    };
    let mut config = PlannerConfig::new([None; 9]);
    config.limits[..3].fill(Some(linear));
    config.limits[3] = Some(rotary);
    config.limits[5] = Some(AxisLimits {
        velocity: 2.0,
        acceleration: 15.0,
        jerk: 400.0,
        ..rotary
    });
    config
}

/// Tool tip and the angles of A and C in degrees.
fn pose(x: f64, y: f64, z: f64, a: f64, c: f64) -> Coords {
    Coords([x, y, z, rad(a), 0.0, rad(c), 0.0, 0.0, 0.0])
}

fn check(poses: &[Coords], control: PathControl) {
    let tool_mm = [0.0, 0.0, 80.0];
    let kinematics = trunnion();
    // The start is given without a tool: where the joints are under the first pose.
    let start = kinematics.forward(&kinematics.inverse(&poses[0], &tool_mm).unwrap(), &[0.0; 3]);
    let items = poses.windows(2).map(|ends| {
        let curve = Curve::line(ends[0], ends[1]);
        PlanItem::Move(Move {
            curve,
            feed: FeedLimit::PerSecond(80.0),
            control,
            tool_mm,
            block: BlockRef::default(),
        })
    });
    let samples = run(config(), kinematics.clone(), start, items);
    assert_limits(&samples, &config().limits);
    let last = kinematics
        .inverse(&poses[poses.len() - 1], &tool_mm)
        .unwrap();
    assert!((samples[samples.len() - 1].position - last).linear_norm() < 1e-8);
}

#[test]
fn a_turn_about_the_tip_keeps_the_linear_joints_in_their_limits() {
    check(
        &[
            pose(80.0, 0.0, 10.0, 0.0, 0.0),
            pose(80.0, 0.1, 10.0, 60.0, 170.0),
            pose(0.0, 60.0, 30.0, -20.0, 90.0),
        ],
        PathControl::ExactPath,
    );
}

#[test]
fn rotary_moves_alone_keep_the_limits() {
    check(
        &[
            pose(60.0, 20.0, 5.0, 10.0, 0.0),
            pose(60.0, 20.0, 5.0, 10.0, 300.0),
            pose(60.0, 20.0, 5.0, 80.0, 300.0),
        ],
        PathControl::ExactPath,
    );
}

#[test]
fn a_swarf_of_many_short_moves_keeps_the_limits() {
    let poses: Vec<Coords> = (0..160)
        .map(|i| {
            let u = f64::from(i) / 160.0;
            let turn = 6.0 * u;
            pose(
                50.0 * math::cos(turn),
                50.0 * math::sin(turn),
                10.0 * u,
                25.0 + 10.0 * math::sin(3.0 * turn),
                180.0 * u,
            )
        })
        .collect();
    check(&poses, continuous(0.02));
}
