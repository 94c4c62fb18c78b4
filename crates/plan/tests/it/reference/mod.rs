//! The optimal quality beside a reference optimiser that shares nothing with it but the path.

mod optimiser;
mod solver;

use crate::common::{LIMITS, Program, optimal};
use lostmotion_plan::PathControl;
use optimiser::{Reference, best};
use std::f64::consts::TAU;

/// Time of the optimal quality on a program, s.
fn planned(program: &Program) -> f64 {
    (program.run_with(optimal()).len() - 1) as f64 * 1e-3
}

/// On a straight line from rest to rest the best time is known: d / v + v / a + a / j.
#[test]
fn a_line_takes_the_time_of_the_plain_s_curve() {
    let mut program = Program::new(PathControl::ExactPath, 100.0);
    program.line(60.0, 0.0, 0.0);
    let closed = 60.0 / LIMITS.velocity
        + LIMITS.velocity / LIMITS.acceleration
        + LIMITS.acceleration / LIMITS.jerk;
    let Reference {
        time,
        bound,
        without_jerk,
    } = best(&program.moves[0].curve, 100.0, 300);
    assert!((time / closed - 1.0).abs() < 4e-3, "{time} {closed}");
    assert!(
        bound <= time && bound > 0.999 * time && without_jerk < bound,
        "{bound} {time} {without_jerk}"
    );
    let planned = planned(&program);
    assert!(
        planned >= closed - 1e-9 && planned < 1.003 * closed,
        "{planned} {closed}"
    );
}

/// Circles on which speed, acceleration and jerk limit, and one on which the feed does.
#[test]
fn circles_take_hardly_longer_than_the_optimum() {
    for (radius, feed) in [(2.0, 100.0), (5.0, 100.0), (12.0, 50.0)] {
        let mut program = Program::new(PathControl::ExactPath, feed);
        program.arc(radius, 0.0, TAU);
        let Reference {
            time,
            bound,
            without_jerk,
        } = best(&program.moves[0].curve, feed, 300);
        assert!(
            bound <= time && bound > 0.999 * time && without_jerk < bound,
            "{radius}: {bound} {time} {without_jerk}"
        );
        let planned = planned(&program);
        println!(
            "radius {radius} feed {feed}: planned {planned} reference {time} bound {bound} without jerk {without_jerk}"
        );
        assert!(planned < 1.005 * time + 1e-3, "{radius}: {planned} {time}");
        assert!(
            planned > 0.995 * bound,
            "{radius}: {planned} is better than the best, {bound}"
        );
    }
}
