//! The words of a ballbar's sheet for a circle of a program: reversal spikes and lost motion of each
//! axis, and with the same circle in the other sense squareness, servo mismatch and scale mismatch.

use super::circles::{FullCircle, partner};
use lostmotion_contour::ballbar::{CircleWords, words};

/// The sheet of a circle among all of a method.
pub(super) fn sheet(circle: &FullCircle, all: &[FullCircle]) -> CircleWords {
    let other = partner(circle, all).map(middles);
    words(
        &middles(circle),
        circle.counterclockwise,
        other.as_deref(),
        circle.radius_mm,
    )
}

/// Radial deviation in the middle of what each part of the turn has, um.
fn middles(circle: &FullCircle) -> Vec<f64> {
    let middle = |[low, high]: &[f32; 2]| 0.5 * (f64::from(*low) + f64::from(*high));
    circle.radial_um.iter().map(middle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::{Plane, math};
    use std::f64::consts::TAU;

    const RADIUS_MM: f64 = 50.0;

    /// A circle whose tip is off by what the functions say of the angle, in both axes, um.
    fn circle(counterclockwise: bool, off: impl Fn(f64) -> [f64; 2]) -> FullCircle {
        let radial = (0..720).map(|part| {
            let angle = (f64::from(part) + 0.5) / 720.0 * TAU;
            let (sin, cos) = math::sin_cos(angle);
            let [x, y] = off(angle);
            [(x * cos + y * sin) as f32; 2]
        });
        FullCircle {
            line: 1,
            time_s: 0.0,
            plane: Plane::Xy,
            center_mm: [0.0; 2],
            radius_mm: RADIUS_MM,
            counterclockwise,
            radial_um: radial.collect(),
            g_um: 0.0,
            f_um: [0.0; 2],
            h_um: None,
        }
    }

    /// A machine whose axes are out of square, of different scale and of different lag.
    #[test]
    fn two_senses_tell_geometry_from_servos() {
        let (square, scale, lag) = (80.0, -30.0, 6.0);
        let of = |sense: f64| {
            circle(sense > 0.0, move |angle| {
                let (sin, cos) = math::sin_cos(angle);
                let (x, y) = (1e-3 * RADIUS_MM * cos, 1e-3 * RADIUS_MM * sin);
                // The first axis is behind by its way, which is -sin of the angle.
                [square * y + scale * x + lag * sense * sin, 0.0]
            })
        };
        let both = [of(1.0), of(-1.0)];
        for circle in &both {
            let found = sheet(circle, &both).both.unwrap();
            for (value, expected) in found.into_iter().zip([square, lag, scale]) {
                assert!((value - expected).abs() < 0.1, "{found:?}");
            }
        }
        assert_eq!(sheet(&both[0], &both[..1]).both, None);
    }

    /// The load of one axis stays behind by its gap: a step at its reversals, and none at the other's.
    #[test]
    fn lost_motion_is_a_step_and_a_spike_is_none() {
        for (counterclockwise, axis) in [(true, 0), (false, 0), (true, 1), (false, 1)] {
            let gap = 10.0;
            let off = move |angle: f64| {
                let sense = if counterclockwise { 1.0 } else { -1.0 };
                // Against the velocity by half the gap.
                let velocity = [
                    -math::sin_cos(angle).0 * sense,
                    math::sin_cos(angle).1 * sense,
                ];
                let mut off = [0.0; 2];
                off[axis] = -0.5 * gap * velocity[axis].signum();
                off
            };
            let found = sheet(&circle(counterclockwise, off), &[]);
            assert!((found.step_um[axis] - gap).abs() < 1e-4, "{found:?}");
            assert!(found.step_um[1 - axis].abs() < 1e-4, "{found:?}");
            assert!(found.spike_um.iter().all(|um| *um < 1e-4), "{found:?}");
            // A spike of 4 um for some degrees behind one reversal.
            let spiked = circle(counterclockwise, move |angle| {
                let mut of = off(angle);
                let at = if axis == 0 { 0.0 } else { 0.25 * TAU };
                let sense = if counterclockwise { 1.0 } else { -1.0 };
                if ((angle - at) * sense).rem_euclid(TAU) < 0.1 {
                    of[axis] += 4.0;
                }
                of
            });
            let found = sheet(&spiked, &[]);
            assert!((found.spike_um[axis] - 4.0).abs() < 0.01, "{found:?}");
            assert!((found.step_um[axis] - gap).abs() < 1e-4, "{found:?}");
        }
    }
}
