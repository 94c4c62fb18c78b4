//! The motion as a part program, for the control of the machine itself.
//!
//! Strokes are straight moves at a feed, rests are G4. A swing is a chain of short moves at the mean
//! feed of each, which a control that looks ahead joins; its ends are gentle because the feed there
//! is low. Places are those of the machine (G53), whatever the work offset.

use super::motion::Segment;
use super::{Bounds, bounds};
use crate::machine::Machine;
use lostmotion_base::units::deg;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Short moves of a period of a swing. A choice: a fortieth of the amplitude apart from the sine.
const MOVES_PER_PERIOD: u32 = 24;

/// The program that commissions these drives of a machine, one after the other, for a control that
/// reads G53, G1, G4 and F in mm or degrees a minute.
///
/// The second motor of a gantry moves with the first: its name is left out.
///
/// # Errors
/// Kinematics whose axes are not those of the program, in words.
pub fn program(machine: &Machine, drives: &[String]) -> Result<String, String> {
    let kind = machine.kinematics().kind();
    if kind != "cartesian" {
        return Err(format!(
            "machine `{}` has kinematics \"{kind}\", whose joints a program does not move one by one",
            machine.name()
        ));
    }
    let mut out = format!(
        "(commissioning of {}: run without a tool and without a part, clear of the table)\nG21 G90 G94 G40 G49 G64\n",
        machine.name().replace(['(', ')'], "")
    );
    for drive in drives.iter().filter(|name| !name.ends_with('2')) {
        let Some(bounds) = bounds(machine, drive) else {
            continue;
        };
        // Joints count in mm and rad, the program in mm and degrees.
        let turns = machine.axes().iter().any(|axis| {
            axis.id.letter().to_ascii_lowercase().to_string() == *drive && axis.is_rotary()
        });
        let scale = if turns && bounds.is_in_rad() {
            deg(1.0)
        } else {
            1.0
        };
        let letter = drive.to_ascii_uppercase();
        axis(&mut out, &letter, &bounds, scale);
    }
    out.push_str("M2\n");
    Ok(out)
}

/// The moves of one axis.
fn axis(out: &mut String, letter: &str, bounds: &Bounds, scale: f64) {
    let start = bounds.start();
    let place = |at: f64| (start + at) * scale;
    let _ = writeln!(out, "(axis {letter})\nG53 G0 {letter}{:.4}", place(0.0));
    for segment in bounds.segments() {
        match segment {
            Segment::Rest(seconds) => {
                let _ = writeln!(out, "G4 P{seconds:.2}");
            }
            Segment::Stroke { to, speed } => {
                let _ = writeln!(
                    out,
                    "G53 G1 {letter}{:.4} F{:.1}",
                    place(to),
                    60.0 * speed * scale
                );
            }
            Segment::Swing {
                amplitude,
                rate,
                count,
            } => {
                let at = |step: u32| {
                    let angle = TAU * f64::from(step) / f64::from(MOVES_PER_PERIOD);
                    amplitude * (1.0 - lostmotion_base::math::cos(angle))
                };
                let move_s = TAU / rate / f64::from(MOVES_PER_PERIOD);
                for step in 1..=count * MOVES_PER_PERIOD {
                    let speed = (at(step) - at(step - 1)).abs() / move_s;
                    let _ = writeln!(
                        out,
                        "G53 G1 {letter}{:.4} F{:.1}",
                        place(at(step)),
                        60.0 * speed * scale
                    );
                }
            }
        }
    }
}
