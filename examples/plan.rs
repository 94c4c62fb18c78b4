//! Stage 3: from curves to samples of every joint, one each command cycle (1 ms), within all limits
//! of velocity, acceleration and jerk.
//!
//! A corner under G64 is rounded within its tolerance; under G61 the tool comes to rest in it. The
//! difference in time is what the tolerance buys.

use lostmotion::base::AxisId;
use lostmotion::{Machine, Program, Simulation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::preset("vmc3")?;
    for mode in ["G61", "G64 P0.005", "G64 P0.05"] {
        let program = Program::from_str(
            "corner.ngc",
            format!("G21 G90 G94 {mode}\nG0 X0 Y0 Z5\nG1 X30 F6000\nG1 Y30\nM2\n"),
        );

        // The sink takes the samples as they are made: a program of any length takes no memory.
        let mut peak = 0.0_f64;
        let plan = Simulation::new(&program, &machine).plan(&mut |samples, _path| {
            for sample in samples {
                peak = peak.max(sample.acceleration[AxisId::X].abs());
            }
            Ok(())
        })?;
        println!(
            "{mode}: {:.3} s for {:.1} mm of cutting, X accelerates with up to {:.0} mm/s2",
            plan.duration_s, plan.cutting_mm, peak
        );
    }
    Ok(())
}

// Prints:
// G61: 0.928 s for 60.0 mm of cutting, X accelerates with up to 2232 mm/s2
// G64 P0.005: 0.898 s for 60.0 mm of cutting, X accelerates with up to 2233 mm/s2
// G64 P0.05: 0.863 s for 60.0 mm of cutting, X accelerates with up to 2222 mm/s2
