//! The whole chain: from a part program to its contour error on a real machine, block by block.
//!
//! Every error splits into what the command does itself (rounded corners), what a machine without a
//! gap would add (servo), and what the gap adds (backlash).

use lostmotion::{Machine, Program, Simulation};
use std::ops::ControlFlow;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let program = Program::from_str(
        "part.ngc",
        "G21 G90 G17 G94 G64 P0.005\nG0 X15 Y0 Z5\nG3 I-15 F1800\nG1 X0 Y15\nG1 X-15 Y0\nM2\n",
    );
    let machine = Machine::preset("vmc3")?;

    // A run stays on this thread unless `.threads(n)` asks for more; `on_progress` may end it.
    let run = Simulation::new(&program, &machine)
        .method("none")
        .tolerance_um(10.0)
        .on_progress(|progress| {
            if progress.simulated_s > 3600.0 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        })
        .run()?;

    let verdict = if run.is_within_tolerance() {
        "within"
    } else {
        "outside"
    };
    println!("{verdict} {} um", run.tolerance_um);
    for block in run.blocks() {
        println!(
            "line {} `{}`: {:+.1} um = command {:+.1}, servo {:+.1}, backlash {:+.1}; {}",
            block.line,
            block.text,
            block.max_um,
            block.parts_um.command,
            block.parts_um.servo,
            block.parts_um.backlash,
            block.cause
        );
    }
    Ok(())
}

// Prints:
// outside 10 um
// line 3 `G3 I-15 F1800`: -15.1 um = command -0.0, servo -8.1, backlash -7.0; reversal of Y
// line 4 `G1 X0 Y15`: +10.4 um = command +0.6, servo +0.8, backlash +9.1; reversal of Y
// line 5 `G1 X-15 Y0`: +10.3 um = command -0.0, servo +0.9, backlash +9.3; gap
