//! The whole chain on a machine that is made in code: no file, checked like one.
//!
//! A plotter of two axes, first with a tight gap, then edited to a wide one. A description that
//! makes no sense is refused with the keys of a machine file.

use lostmotion::base::AxisId;
use lostmotion::kinematics::CartesianSpec;
use lostmotion::sim::machine::{AxisFile, LimitsTable, LinearLimits, MachineFile};
use lostmotion::{Machine, Program, Simulation};

fn plotter() -> Result<Machine, Box<dyn std::error::Error>> {
    let limits = LimitsTable::Linear(LinearLimits {
        min_mm: -200.0,
        max_mm: 200.0,
        velocity_mm_s: 150.0,
        acceleration_mm_s2: 1500.0,
        jerk_mm_s3: 30_000.0,
    });
    // The X axis of an embedded mill is a good start; every field of it may be changed.
    let mill = Machine::preset("vmc3")?;
    let x = &mill.axis(AxisId::X).ok_or("the mill has no X")?.config;
    let mut file = MachineFile::new("plotter", CartesianSpec {});
    for letter in ["x", "y"] {
        let config = x.with_gap(0.005);
        file.axis
            .insert(letter.to_owned(), AxisFile { limits, config });
    }
    Ok(file.check()?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let program = Program::from_str(
        "circle.ngc",
        "G21 G90 G17 G94\nG0 X30 Y0\nG3 I-30 P2 F2400\nM2\n",
    );
    let tight = plotter()?;
    let wide = tight.edit(|m| {
        m.name = "worn plotter".to_owned();
        m.axis("x").gap_um = 40.0;
    })?;
    for machine in [&tight, &wide] {
        let run = Simulation::new(&program, machine).run()?;
        let first = run.first().ok_or("a method")?;
        println!(
            "{}: {} leaves {:.1} um of backlash at most",
            machine.name(),
            first.method,
            first.backlash.max
        );
    }

    let refused = wide.edit(|m| m.axis("y").drive.position_gain_per_s = -1.0);
    for problem in refused.err().iter().flat_map(|error| &error.problems) {
        println!("{}: {}", problem.key, problem.message);
    }
    Ok(())
}

// Prints:
// plotter: none leaves 3.2 um of backlash at most
// worn plotter: none leaves 22.7 um of backlash at most
// axis.y.drive.position_gain_per_s: is -1; it has to be a finite number, 0 or above
