//! Stage 5: one axis from setpoints to where its load really is.
//!
//! Drive, motor, screw with a gap, and slide, every 62.5 us, with a compensator in the drive. A slow
//! sine reverses often, and at each reversal the slide stays behind by what the method leaves of
//! the gap.

use lostmotion::Machine;
use lostmotion::base::{AxisId, math};
use lostmotion::drive::{AxisOutput, Setpoint};
use lostmotion::methods::build_runner;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::preset("vmc3-worn")?;
    let axis = machine.axis(AxisId::X).ok_or("no axis X")?;
    println!("gap of X: {:.0} um", axis.config.gap_in_unit() * 1e3);

    // 5 mm to either side, 0.4 Hz: commanded position, velocity, acceleration each millisecond.
    let rate = 2.5;
    let setpoints: Vec<Setpoint> = (0..6000)
        .map(|n| {
            let (sin, cos) = math::sin_cos(rate * f64::from(n) * 1e-3);
            Setpoint::moving(5.0 * sin, 5.0 * rate * cos, -5.0 * rate * rate * sin)
        })
        .collect();

    for method in ["none", "fixed", "adaptive"] {
        let mut runner = build_runner(&axis.config, method.parse()?, 0.0)?;
        let mut output = AxisOutput::new(false);
        runner.push(&setpoints, &mut output)?;

        // Lost motion: reference minus load at each servo tick, after the first second.
        let worst = output
            .reference
            .iter()
            .zip(&output.load)
            .skip(4000)
            .map(|(reference, load)| (reference - load).abs())
            .fold(0.0, f64::max);
        println!("{method}: largest following error {:.0} um", worst * 1e3);
    }
    Ok(())
}

// Prints:
// gap of X: 40 um
// none: largest following error 54 um
// fixed: largest following error 33 um
// adaptive: largest following error 42 um
