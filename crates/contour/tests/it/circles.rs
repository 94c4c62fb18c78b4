//! The circular test on paths whose deviations are known.

use lostmotion_base::{AxisId, math};
use lostmotion_contour::Circle;
use lostmotion_path::Plane;
use std::f64::consts::{FRAC_PI_2, TAU};

const CIRCLE: Circle = Circle {
    plane: Plane::Xy,
    center_mm: [100.0, -50.0],
    radius_mm: 50.0,
};

/// Tips whose radial deviation is a function of the angle, run in either sense from an angle off
/// the axes.
fn run(sense: f64, deviation: impl Fn(f64) -> f64) -> Vec<[f64; 3]> {
    (0..7200)
        .map(|i| {
            let angle = 0.3 + sense * (f64::from(i) + 0.5) * TAU / 7200.0;
            let (sin, cos) = math::sin_cos(angle);
            let radius = CIRCLE.radius_mm + deviation(angle);
            [
                CIRCLE.center_mm[0] + radius * cos,
                CIRCLE.center_mm[1] + radius * sin,
                3.0,
            ]
        })
        .collect()
}

#[test]
fn harmonics_separate() {
    // Radius 3 um small, centre off by (5, -2) um, ovality of 4 um amplitude.
    let path = run(1.0, |a| {
        -3e-3 + 5e-3 * math::cos(a) - 2e-3 * math::sin(a) + 4e-3 * math::cos(2.0 * a + 0.4)
    });
    let found = CIRCLE.deviation(&path).unwrap();
    assert!((found.mean_mm + 3e-3).abs() < 1e-9);
    assert!(
        (found.center_shift_mm[0] - 5e-3).abs() < 1e-9
            && (found.center_shift_mm[1] + 2e-3).abs() < 1e-9
    );
    assert!(
        (found.circular_mm - 8e-3).abs() < 1e-8,
        "{}",
        found.circular_mm
    );
    let meant = |fold: fn(f64, f64) -> f64, first| {
        CIRCLE
            .profile(&path)
            .map(|p| p.deviation_mm)
            .fold(first, fold)
    };
    assert!(
        (found.radial_max_mm - meant(f64::max, -1.0)).abs() < 1e-15
            && (found.radial_min_mm - meant(f64::min, 1.0)).abs() < 1e-15
    );
}

#[test]
fn both_senses_together() {
    // Half of a 10 um play opens the circle one way and closes it the other.
    let (one, other) = (run(1.0, |_| 5e-3), run(-1.0, |_| -5e-3));
    assert!(CIRCLE.deviation(&one).unwrap().circular_mm < 1e-9);
    let both = CIRCLE.bidirectional(&one, &other).unwrap();
    assert!((both.circular_mm - 10e-3).abs() < 1e-9 && both.mean_mm.abs() < 1e-9);
}

#[test]
fn glitches_at_the_reversals() {
    // A spike of a decaying exponential behind each reversal, of its own height, in both senses.
    for sense in [1.0, -1.0] {
        let heights = [7e-3, -4e-3, 2e-3, 9e-3];
        let path = run(sense, |angle| {
            let mut sum = 1e-3;
            for (quarter, height) in heights.iter().enumerate() {
                let turns = sense * (angle - quarter as f64 * FRAC_PI_2) / TAU;
                let past = (turns - turns.floor()) * TAU;
                sum += height * math::exp(-past / 0.03);
            }
            sum
        });
        let found = CIRCLE.glitches(&path, 0.2);
        assert_eq!(found.len(), 4);
        for (quarter, glitch) in found.iter().enumerate() {
            assert_eq!(
                glitch.axis,
                if quarter % 2 == 0 {
                    AxisId::X
                } else {
                    AxisId::Y
                }
            );
            assert!((glitch.angle_deg - 90.0 * quarter as f64).abs() < 1e-12);
            // The first sample after the reversal is at most one step past it.
            assert!(
                (glitch.amplitude_mm / heights[quarter] - 1.0).abs() < 0.04,
                "{sense} {quarter}: {}",
                glitch.amplitude_mm
            );
        }
    }
}

#[test]
fn too_little_is_refused() {
    let path = run(1.0, |_| 0.0);
    assert!(
        CIRCLE
            .deviation(&path[..5])
            .unwrap_err()
            .to_string()
            .contains("at least 8 samples, not 5")
    );
    assert!(
        CIRCLE
            .deviation(&path[..40])
            .unwrap_err()
            .to_string()
            .contains("all around")
    );
    let flat = Circle {
        radius_mm: 0.0,
        ..CIRCLE
    };
    assert!(
        flat.deviation(&path)
            .unwrap_err()
            .to_string()
            .contains("not 0 mm")
    );
    assert!(CIRCLE.glitches(&[], 0.1).is_empty());
}
