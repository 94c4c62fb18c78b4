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
