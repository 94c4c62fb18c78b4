//! Long lines that run into curves made of short ones, as CAM systems write them.

use crate::common::{LIMITS, Program, assert_limits, continuous, deviation};
use lostmotion_base::math;
use lostmotion_plan::Sample;
use std::f64::consts::FRAC_PI_2;

fn seconds(samples: &[Sample]) -> f64 {
    (samples.len() - 1) as f64 * 1e-3
}

/// A line, a quarter of a circle and a line, the circle as chords of about a length or, without
/// one, as an arc.
fn elbow(radius: f64, chord: Option<f64>, tolerance: f64) -> Program {
    let mut program = Program::new(continuous(tolerance), 100.0);
    program.line(20.0, 0.0, 0.0);
    match chord {
        None => program.arc(0.0, radius, FRAC_PI_2),
        Some(chord) => {
            let chords = (radius * FRAC_PI_2 / chord) as u32;
            for k in 1..=chords {
                let angle = FRAC_PI_2 * f64::from(k) / f64::from(chords);
                program.line(
                    20.0 + radius * math::sin(angle),
                    radius * (1.0 - math::cos(angle)),
                    0.0,
                );
            }
        }
    }
    program.line(20.0 + radius, radius + 20.0, 0.0);
    program
}

#[test]
fn chords_take_little_more_time_than_the_arc_that_they_stand_for() {
    for (radius, chord, tolerance) in [
        (10.0, 0.5, 0.01),
        (5.0, 0.5, 0.02),
        (10.0, 0.2, 0.002),
        (3.0, 0.5, 0.05),
        (20.0, 1.0, 0.02),
    ] {
        let arc = seconds(&elbow(radius, None, tolerance).run());
        let program = elbow(radius, Some(chord), tolerance);
        let samples = program.run();
        assert_limits(&samples, &[Some(LIMITS); 3]);
        assert!(deviation(&samples, &program.moves) <= tolerance + 1e-9);
        assert!(
            seconds(&samples) <= 1.15 * arc,
            "R{radius} in {chord} mm: {} for {arc} s",
            seconds(&samples)
        );
    }
}

/// Which vertices are rounded one by one and which are taken together depends on the tolerance.
#[test]
fn a_larger_tolerance_costs_such_a_path_little() {
    for (radius, chord) in [
        (10.0, 0.5),
        (5.0, 0.5),
        (10.0, 0.2),
        (3.0, 0.5),
        (20.0, 1.0),
    ] {
        let mut best = f64::INFINITY;
        for tolerance in [
            0.001, 0.002, 0.003, 0.005, 0.007, 0.01, 0.014, 0.02, 0.03, 0.05, 0.1,
        ] {
            let time = seconds(&elbow(radius, Some(chord), tolerance).run());
            assert!(
                time <= 1.05 * best,
                "R{radius} in {chord} mm within {tolerance} mm: {time} after {best} s"
            );
            best = best.min(time);
        }
    }
}
