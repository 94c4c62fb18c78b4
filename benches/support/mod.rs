//! Programs of any length, generated: what benches and memory tests run on.

#![allow(dead_code, reason = "each bench uses a part of it")]

use lostmotion::base::math;
use std::fmt::Write;

/// A three-axis finishing raster over a wavy surface: rows along X at 0.5 mm points, stepping over
/// in Y, back and forth.
///
/// `minutes` is the cutting time at the programmed feed of 3000 mm/min.
pub(crate) fn surfacing(minutes: f64) -> String {
    const FEED_MM_MIN: f64 = 3000.0;
    const STEP_MM: f64 = 0.5;
    const HALF_MM: f64 = 75.0;
    const STEP_OVER_MM: f64 = 0.4;
    let height = |x: f64, y: f64| 2.0 * math::sin(x / 9.0) * math::cos(y / 13.0) - 5.0;
    let mut text = String::from(
        "(three-axis finishing raster)\nG21 G17 G90 G94 G40 G49 G80 G54\nG64 P0.02 Q0.005\nM3 S12000\nG0 Z10\n",
    );
    let mut travelled = 0.0;
    let (mut y, mut forward) = (-HALF_MM, true);
    let _ = writeln!(
        text,
        "G0 X{:.3} Y{y:.3}\nG1 Z{:.4} F600\nF{FEED_MM_MIN}",
        -HALF_MM,
        height(-HALF_MM, y)
    );
    let points = (2.0 * HALF_MM / STEP_MM) as i64;
    while travelled < minutes * FEED_MM_MIN {
        for i in 1..=points {
            let along = -HALF_MM + STEP_MM * i as f64;
            let x = if forward { along } else { -along };
            let _ = writeln!(text, "X{x:.3} Z{:.4}", height(x, y));
        }
        travelled += 2.0 * HALF_MM;
        y = if y > HALF_MM {
            -HALF_MM
        } else {
            y + STEP_OVER_MM
        };
        forward = !forward;
        let _ = writeln!(text, "Y{y:.3}");
    }
    text.push_str("G0 Z10\nM5\nM2\n");
    text
}

/// Full circles of several radii and feeds.
pub(crate) fn circles() -> String {
    let mut text = String::from("G21 G17 G90 G64 P0.005\nG0 Z5\n");
    for (radius, feed) in [(5, 600), (10, 1200), (25, 3000), (50, 6000)] {
        let _ = writeln!(
            text,
            "G0 X{radius} Y0\nG3 I-{radius} F{feed}\nG2 I-{radius}"
        );
    }
    text.push_str("M2\n");
    text
}
