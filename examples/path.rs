//! Stage 2: from a program on a machine to curves in machine coordinates.
//!
//! Every move is a line, an arc or helix, or a piece of a spline, in mm and rad from the machine's
//! zero, with the feed, plane and tool that were in force. Curves know their length, their points
//! by arc length, and the foot of a point.

use lostmotion::{Machine, Program, Simulation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let program = Program::from_str(
        "slot.ngc",
        "G21 G90 G17 G94\nG0 X20 Y0 Z1\nG1 Z-2 F300\nG3 X0 Y20 Z-4 I-20 J0 F900\nG0 Z10\nM2\n",
    );
    let machine = Machine::preset("vmc3")?;

    // The machine brings the work offset of G54, so the curves lie in its own coordinates.
    for item in Simulation::new(&program, &machine).curves()? {
        let item = item?;
        let curve = &item.motion.curve;
        let [x, y, z] = curve.end().linear();
        println!(
            "line {}: {} {:.3} mm to X{x:.1} Y{y:.1} Z{z:.1}",
            item.motion.block.span.line,
            if item.is_rapid() { "rapid" } else { "cut" },
            curve.length(),
        );
    }

    // Half way along the helix, seen from the program's zero: at 45 degrees and 1 mm down.
    let helix = Simulation::new(&program, &machine).curves()?.nth(2);
    let helix = helix.ok_or("a third move")??;
    let middle = helix.motion.curve.point(0.5 * helix.motion.curve.length());
    let [x, y, z] = std::array::from_fn(|axis| middle.linear()[axis] - helix.origin_mm[axis]);
    println!("middle of the helix: X{x:.3} Y{y:.3} Z{z:.3}");
    Ok(())
}

// Prints:
// line 2: rapid 20.025 mm to X-361.0 Y-203.0 Z-299.0
// line 3: cut 3.000 mm to X-361.0 Y-203.0 Z-302.0
// line 4: cut 31.480 mm to X-381.0 Y-183.0 Z-304.0
// line 5: rapid 14.000 mm to X-381.0 Y-183.0 Z-290.0
// middle of the helix: X14.142 Y14.142 Z-3.000
