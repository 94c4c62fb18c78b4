//! Stage 1: from the text of a part program to canonical operations and diagnostics.
//!
//! An operation is what remains of a block when everything modal is resolved: each has all its
//! coordinates and needs no memory of what was before. Diagnostics have a place, and the program
//! gives the text there.

use lostmotion::Program;
use lostmotion::gcode::{CanonicalOp, InterpreterConfig};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let program = Program::from_str(
        "pocket.ngc",
        "G21 G90 G17 G64 P0.01\nG0 X10 Y0\n#1 = 4\nG1 X[#1 * 5] F600\nG2 Y10 J5\nG1 X\nM2\n",
    );

    // The settings of the interpreter: dialect, work offsets, tools, limits. A machine has its own
    // (`sim::interpreter_config`); the defaults do for a first look.
    let mut operations = program.operations(InterpreterConfig::default())?;
    for found in operations.by_ref() {
        let line = found.block.span.line;
        match found.op {
            CanonicalOp::StraightTraverse(to) => println!("line {line}: rapid to {:?}", &to[..2]),
            CanonicalOp::StraightFeed(to) => println!("line {line}: feed to {:?}", &to[..2]),
            CanonicalOp::ArcFeed(arc) => println!("line {line}: arc, {} turns", arc.turns),
            _ => {}
        }
    }

    // All errors of the program at once, each with the text of its block.
    for found in operations.diagnostics().kept() {
        let text = program.block_text(found.place.span)?;
        println!("{found} in `{text}`");
    }
    Ok(())
}

// Prints:
// line 2: rapid to [10.0, 0.0]
// line 4: feed to [20.0, 0.0]
// line 5: arc, -1 turns
// error[missing-number]: line 6, column 5: a number is missing after X in `G1 X`
