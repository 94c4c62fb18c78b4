//! From G-code to contour error with a compensator and with kinematics that the library does not
//! know, built outside its workspace.

mod kinematics;

use kinematics::Skewed;
use lostmotion::drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use lostmotion::methods::AxisConfig;
use lostmotion::{Machine, Program, Simulation};
use serde::{Deserialize, Serialize};

/// Half the gap towards the commanded direction, reached with a low-pass.
struct Soft {
    half_gap_rad: f64,
    /// Part of the way that is left after a servo tick.
    keep: f64,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
struct SoftState {
    direction: f64,
    at_rad: f64,
}

impl Soft {
    fn new(axis: &AxisConfig) -> Soft {
        Soft {
            half_gap_rad: 0.5 * axis.reflected_load().gap_rad,
            keep: 0.9,
        }
    }
}

impl Compensator for Soft {
    type State = SoftState;

    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            name: "soft",
            summary: "half the gap at each reversal, through a low-pass",
            knows: Knowledge {
                load_scale: false,
                gap: true,
                load: false,
            },
            source: "this example",
        }
    }

    fn initial(&self, _motor_position: f64) -> SoftState {
        SoftState {
            direction: 0.0,
            at_rad: 0.0,
        }
    }

    fn step(&self, state: &mut SoftState, signals: &Signals) -> Correction {
        if signals.reference.velocity.abs() > 1e-6 {
            state.direction = signals.reference.velocity.signum();
        }
        let target = state.direction * self.half_gap_rad;
        state.at_rad = target + self.keep * (state.at_rad - target);
        Correction {
            position: state.at_rad,
            ..Correction::NONE
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let program = Program::from_str(
        "circle.ngc",
        "G21 G90 G17 G94\nG0 X20 Y0 Z5\nG3 I-20 P2 F1500\nM2\n",
    );
    let machine = Machine::preset("bench3")?.edit(|m| {
        m.axis("x").gap_um = 30.0;
        m.axis("y").gap_um = 30.0;
    })?;
    // Y stands half a degree off square to X, and the control knows it.
    let run = Simulation::new(&program, &machine)
        .kinematics(Skewed::of_degrees(0.5))
        .method("none")
        .compensator("soft", Soft::new)
        .run()?;
    for result in &run.results {
        println!(
            "{}: largest contour error {:.1} um, backlash RMS {:.2} um",
            result.method, result.cutting.max, result.backlash.rms
        );
    }
    let [none, soft] = ["none", "soft"].map(|name| run.result(name).map(|r| r.backlash.rms));
    if soft < none.map(|rms| 0.7 * rms) {
        Ok(())
    } else {
        Err(format!("the compensator should help: {soft:?} against {none:?}").into())
    }
}
