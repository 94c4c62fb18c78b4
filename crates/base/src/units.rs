//! Conversions between what people write and what the project computes in.
//!
//! ```
//! use lostmotion_base::units::{MM_PER_INCH, deg, mm_per_s, rad};
//!
//! assert_eq!(mm_per_s(6000.0), 100.0);
//! assert_eq!(2.0 * MM_PER_INCH, 50.8);
//! assert!((deg(rad(30.0)) - 30.0).abs() < 1e-12);
//! ```

use std::f64::consts::PI;

/// Millimetres per inch, exact by definition.
pub const MM_PER_INCH: f64 = 25.4;
/// Micrometres per millimetre.
pub const UM_PER_MM: f64 = 1e3;

/// Degrees to radians.
pub fn rad(degrees: f64) -> f64 {
    degrees * (PI / 180.0)
}

/// Radians to degrees.
pub fn deg(radians: f64) -> f64 {
    radians * (180.0 / PI)
}

/// mm/min to mm/s.
pub fn mm_per_s(mm_per_min: f64) -> f64 {
    mm_per_min / 60.0
}

/// A number as people write it: with an exponent where it is very large or small.
///
/// ```
/// use lostmotion_base::units::number;
///
/// assert_eq!(number(-0.25), "-0.25");
/// assert_eq!(number(1e300), "1e300");
/// ```
pub fn number(value: f64) -> String {
    let size = value.abs();
    if size.is_finite() && size > 0.0 && !(1e-4..1e7).contains(&size) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}
