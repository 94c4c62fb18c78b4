//! Stage 4: from the tool in the part to the joints of the machine, and back.
//!
//! A trunnion table tilts the part about A and turns it about C. With tool-centre-point control a
//! program names the tool's tip in the part and the two angles; the linear joints have to follow
//! the part round.

use lostmotion::Machine;
use lostmotion::base::{AxisId, Coords};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::preset("trunnion5")?;
    let kinematics = machine.build_kinematics()?;
    let tool_mm = [0.0, 0.0, 80.0];

    // The tip stays at one place of the part while C turns; the joints X and Y go round with it.
    for degrees in [0.0, 30.0, 60.0, 90.0] {
        let mut program = Coords::xyz(40.0, 0.0, 10.0);
        program[AxisId::A] = (-20.0_f64).to_radians();
        program[AxisId::C] = f64::to_radians(degrees);

        let joints = kinematics.inverse(&program, &tool_mm)?;
        let [x, y, z] = joints.linear();
        println!("C{degrees}: joints X{x:.3} Y{y:.3} Z{z:.3}");

        // And back: the pose of the tool in the part's frame is the one that was asked for.
        let pose = kinematics.tool_pose(&joints, &tool_mm);
        let off = pose
            .tip
            .iter()
            .zip(program.linear())
            .map(|(found, asked)| (found - asked).abs())
            .fold(0.0, f64::max);
        assert!(off < 1e-9, "the tip is {off} mm off");
    }
    Ok(())
}

// Prints:
// C0: joints X40.000 Y-129.968 Z67.083
// C30: joints X34.641 Y-148.762 Z60.243
// C60: joints X20.000 Y-162.520 Z55.235
// C90: joints X0.000 Y-167.555 Z53.402
