//! Circular test on recorded tool tips, with the quantities of ISO 230-4.

use crate::ContourError;
use lostmotion_base::{AxisId, math};
use lostmotion_path::Plane;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Fewest samples of a circular test. A choice: two a quadrant.
const MIN_SAMPLES: usize = 8;
/// Determinant of the normal equations over n^3 below which the samples do not determine a centre.
/// A choice: a full turn has 1/4, an arc of 26 degrees about this.
const MIN_DETERMINANT: f64 = 1e-6;

/// The nominal circle.
///
/// ```
/// use lostmotion_base::{Plane, math};
/// use lostmotion_contour::Circle;
///
/// let circle = Circle { plane: Plane::Xy, center_mm: [0.0; 2], radius_mm: 50.0 };
/// // A tool that runs round a centre 10 um off in X: the circle is round all the same.
/// let tips: Vec<[f64; 3]> = (0..360)
///     .map(|degrees| math::sin_cos(f64::from(degrees).to_radians()))
///     .map(|(sin, cos)| [0.01 + 50.0 * cos, 50.0 * sin, 0.0])
///     .collect();
/// let found = circle.deviation(&tips)?;
/// assert!((found.radial_max_mm - 0.01).abs() < 1e-6 && found.circular_mm < 1e-5);
/// # Ok::<(), lostmotion_contour::ContourError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Circle {
    /// Plane of the circle.
    pub plane: Plane,
    /// Centre in the order of the plane's axes, mm.
    pub center_mm: [f64; 2],
    /// Nominal radius, mm.
    pub radius_mm: f64,
}

/// Radial deviation at an angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RadialPoint {
    /// From the plane's first axis to its second, in (-pi, pi], rad.
    pub angle_rad: f64,
    /// Actual minus nominal radius, mm.
    pub deviation_mm: f64,
}

/// The error spike where one axis of the circle reverses (quadrant glitch).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Glitch {
    /// Which axis reverses.
    pub axis: AxisId,
    /// Angle of the reversal: 0, 90, 180, 270 degrees.
    pub angle_deg: f64,
    /// Largest change of the radial deviation in the window after it against the mean of the window
    /// before, signed, mm.
    pub amplitude_mm: f64,
}

/// Deviations of one actual path around the circle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CircularDeviation {
    /// Radial deviation F: smallest, about the nominal centre, mm.
    pub radial_min_mm: f64,
    /// Radial deviation F: largest, about the nominal centre, mm.
    pub radial_max_mm: f64,
    /// Mean radial deviation about the least-squares centre, mm.
    pub mean_mm: f64,
    /// Least-squares centre minus nominal centre, in the order of the plane's axes, mm.
    pub center_shift_mm: [f64; 2],
    /// Circular deviation G: separation of the two circles about the least-squares centre between
    /// which the path lies, mm.
    pub circular_mm: f64,
}

impl Circle {
    /// Radial deviations of recorded tips, in their order.
    pub fn profile<'a>(
        &'a self,
        tips_mm: impl IntoIterator<Item = &'a [f64; 3]> + 'a,
    ) -> impl Iterator<Item = RadialPoint> + 'a {
        let [first, second, _] = self.plane.axes();
        tips_mm.into_iter().map(move |tip| {
            let (x, y) = (
                tip[first] - self.center_mm[0],
                tip[second] - self.center_mm[1],
            );
            RadialPoint {
                angle_rad: math::atan2(y, x),
                deviation_mm: math::hypot(x, y) - self.radius_mm,
            }
        })
    }

    /// Deviations of one path (one sense of rotation, at least a full turn in samples of about
    /// equal spacing).
    ///
    /// # Errors
    /// A radius that is not positive, fewer than eight samples or samples on too small a part of
    /// the circle.
    pub fn deviation(&self, tips_mm: &[[f64; 3]]) -> Result<CircularDeviation, ContourError> {
        self.deviation_of(&self.profile(tips_mm).collect::<Vec<_>>())
    }

    /// The same of radial deviations, as a ballbar reads them.
    ///
    /// # Errors
    /// As [`Circle::deviation`].
    pub fn deviation_of(&self, points: &[RadialPoint]) -> Result<CircularDeviation, ContourError> {
        self.check(points)?;
        let (mean, shift) = least_squares(points)?;
        Ok(envelope(points, mean, shift))
    }

    /// Bi-directional circular deviation G(b): both senses of rotation about one least-squares
    /// centre. The mean is the mean bi-directional radial deviation D.
    ///
    /// # Errors
    /// As [`Circle::deviation`].
    pub fn bidirectional(
        &self,
        one_mm: &[[f64; 3]],
        other_mm: &[[f64; 3]],
    ) -> Result<CircularDeviation, ContourError> {
        // One centre for both senses: a centre for each would take out part of what differs between
        // them.
        let both = one_mm.iter().chain(other_mm);
        self.deviation_of(&self.profile(both).collect::<Vec<_>>())
    }

    fn check(&self, points: &[RadialPoint]) -> Result<(), ContourError> {
        if !(self.radius_mm.is_finite() && self.radius_mm > 0.0) {
            return Err(ContourError::Circle {
                what: format!("a positive radius, not {} mm", self.radius_mm),
            });
        }
        if points.len() < MIN_SAMPLES {
            return Err(ContourError::Circle {
                what: format!("at least {MIN_SAMPLES} samples, not {}", points.len()),
            });
        }
        Ok(())
    }

    /// The error spikes at the four reversals of a path in one sense of rotation. `window_rad` is
    /// how far before and after a reversal to look; a reversal without samples on both sides is
    /// left out. Of several turns the largest spike counts.
    pub fn glitches(&self, tips_mm: &[[f64; 3]], window_rad: f64) -> Vec<Glitch> {
        let points: Vec<_> = self.profile(tips_mm).collect();
        // Sense of rotation: the sign of all steps of angle together.
        let sense = if points
            .windows(2)
            .map(|pair| wrap(pair[1].angle_rad - pair[0].angle_rad))
            .sum::<f64>()
            < 0.0
        {
            -1.0
        } else {
            1.0
        };
        let [first, second, _] = self.plane.axes();
        let mut glitches = Vec::new();
        // An axis reverses where its coordinate is largest or smallest: the first at 0 and 180
        // degrees.
        for (quarter, axis) in [(0.0, first), (1.0, second), (2.0, first), (3.0, second)] {
            // Angle since the reversal in the direction of travel.
            let past = |point: &RadialPoint| sense * wrap(point.angle_rad - quarter * FRAC_PI_2);
            let before: Vec<_> = points
                .iter()
                .filter(|point| (-window_rad..0.0).contains(&past(point)))
                .collect();
            let after = points
                .iter()
                .filter(|point| (0.0..=window_rad).contains(&past(point)));
            // The spike is told against the level before it: radius errors of the servo fall out.
            let level = before.iter().map(|point| point.deviation_mm).sum::<f64>()
                / before.len().max(1) as f64;
            let peak = after
                .map(|point| point.deviation_mm - level)
                .reduce(|a, b| if b.abs() > a.abs() { b } else { a });
            if let (Some(amplitude_mm), Some(axis), false) =
                (peak, AxisId::from_index(axis), before.is_empty())
            {
                glitches.push(Glitch {
                    axis,
                    angle_deg: 90.0 * quarter,
                    amplitude_mm,
                });
            }
        }
        glitches
    }
}

/// An angle brought to [-pi, pi).
fn wrap(angle: f64) -> f64 {
    angle - TAU * ((angle + PI) / TAU).floor()
}

/// Mean and first harmonic of the deviations by least squares: radius error and shift of the
/// centre, to first order in their ratio to the radius.
fn least_squares(points: &[RadialPoint]) -> Result<(f64, [f64; 2]), ContourError> {
    // Normal equations of deviation = m + a cos + b sin, one row for each unknown, right side last.
    let mut rows = [[0.0; 4]; 3];
    for point in points {
        let (sin, cos) = math::sin_cos(point.angle_rad);
        let basis = [1.0, cos, sin];
        for (row, factor) in rows.iter_mut().zip(basis) {
            for (sum, value) in row.iter_mut().zip([1.0, cos, sin, point.deviation_mm]) {
                *sum += factor * value;
            }
        }
    }
    // Cramer's rule: the determinant with one column replaced by the right side.
    let determinant = |column: Option<usize>| {
        let entry = |i: usize, j: usize| rows[i][if column == Some(j) { 3 } else { j }];
        let minor = |a: usize, b: usize| entry(1, a) * entry(2, b) - entry(1, b) * entry(2, a);
        entry(0, 0) * minor(1, 2) - entry(0, 1) * minor(0, 2) + entry(0, 2) * minor(0, 1)
    };
    let whole = determinant(None);
    let count = points.len() as f64;
    // A full turn gives n^3/4. Far less: an arc on which shift and radius look alike.
    if whole.is_nan() || whole < MIN_DETERMINANT * count * count * count {
        return Err(ContourError::Circle {
            what: "samples all around the circle".to_owned(),
        });
    }
    Ok((
        determinant(Some(0)) / whole,
        [determinant(Some(1)) / whole, determinant(Some(2)) / whole],
    ))
}

fn envelope(points: &[RadialPoint], mean_mm: f64, shift: [f64; 2]) -> CircularDeviation {
    // Radial deviation about the nominal centre, circular deviation about the fitted one.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut inner, mut outer) = (f64::INFINITY, f64::NEG_INFINITY);
    for point in points {
        let (sin, cos) = math::sin_cos(point.angle_rad);
        let rest = point.deviation_mm - shift[0] * cos - shift[1] * sin;
        (low, high) = (low.min(point.deviation_mm), high.max(point.deviation_mm));
        (inner, outer) = (inner.min(rest), outer.max(rest));
    }
    CircularDeviation {
        radial_min_mm: low,
        radial_max_mm: high,
        mean_mm,
        center_shift_mm: shift,
        circular_mm: outer - inner,
    }
}
