//! Stage 6: how far the tool leaves the contour, measured on a machine that the library does not
//! know.
//!
//! The plan gives commands and the programmed path; the caller's machine moves (here each axis lags
//! by a first-order low-pass, nothing more); the tracker finds the foot of the tool on the path. A
//! circle shrinks by `v^2 T^2 / (2 R)`, which is what comes out.

use lostmotion::base::AxisId;
use lostmotion::contour::{ContourConfig, ContourInput, ContourTracker, FootState};
use lostmotion::{Machine, Program, Simulation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (radius, feed, lag_s) = (20.0, 3000.0, 0.010);
    let program = Program::from_str(
        "circle.ngc",
        format!("G21 G90 G17 G94\nG0 X{radius} Y0 Z5\nG3 I-{radius} P2 F{feed}\nM2\n"),
    );
    let machine = Machine::preset("bench3")?;

    let mut tracker = ContourTracker::new(ContourConfig::default());
    let mut foot = FootState::default();
    let mut slide: Option<[f64; 3]> = None;
    let mut errors = Vec::new();
    Simulation::new(&program, &machine).plan(&mut |samples, path| {
        for segment in path {
            tracker.push(*segment)?;
        }
        for sample in samples {
            // The machine: every axis goes after its command.
            let command = sample.position.linear();
            let at = slide.get_or_insert(command);
            for axis in 0..3 {
                at[axis] += (command[axis] - at[axis]) * (1e-3 / lag_s);
            }
            let measured = tracker.measure(
                &mut foot,
                &ContourInput {
                    tick: sample.tick,
                    segment: sample.segment,
                    s: sample.s,
                    actual_tip_mm: *at,
                    commanded_tip_mm: command,
                    actual_axis: [0.0, 0.0, 1.0],
                    commanded_axis: [0.0, 0.0, 1.0],
                },
            )?;
            if !measured.rapid && sample.velocity[AxisId::X] != 0.0 {
                errors.push(measured.error_mm);
            }
        }
        Ok(())
    })?;

    // Positive is left of the direction of travel: inside a circle that goes counter-clockwise.
    errors.sort_by(f64::total_cmp);
    let median_um = 1e3 * errors[errors.len() / 2];
    let v = feed / 60.0;
    let closed_form_um = 1e3 * v * v * lag_s * lag_s / (2.0 * radius);
    println!("measured {median_um:.1} um inside, the closed form says {closed_form_um:.1} um");
    Ok(())
}

// Prints:
// measured 5.6 um inside, the closed form says 6.2 um
