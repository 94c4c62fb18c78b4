//! Stage 7: the gap of an axis from a log of motor and load.
//!
//! A real log comes from a drive's trace (`logs::read_axis`); here the simulated axis
//! writes one. The fit answers with a value and the interval that the log supports.

use lostmotion::Machine;
use lostmotion::base::{AxisId, Clock, math};
use lostmotion::drive::{AxisOutput, Setpoint};
use lostmotion::identify::{BacklashLog, FitSettings, fit_backlash};
use lostmotion::methods::{MethodId, build_runner};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::preset("vmc3-worn")?;
    let axis = machine.axis(AxisId::Y).ok_or("no axis Y")?;

    // Ten seconds of a sine, every servo tick traced.
    let rate = 3.0;
    let setpoints: Vec<Setpoint> = (0..10_000)
        .map(|n| {
            let (sin, cos) = math::sin_cos(rate * f64::from(n) * 1e-3);
            Setpoint::moving(8.0 * sin, 8.0 * rate * cos, -8.0 * rate * rate * sin)
        })
        .collect();
    let mut output = AxisOutput::new(true);
    build_runner(&axis.config, MethodId::NONE, 0.0)?.push(&setpoints, &mut output)?;
    let trace = output.trace.unwrap_or_default();

    // The fit knows the motor's data sheet and what turns with it; the gap is what it looks for.
    let log = BacklashLog::from_samples(Clock::SERVO.period_s(), &trace)?;
    let motor = &axis.config.motor;
    let mut settings = FitSettings::new(
        motor.torque_constant_nm_per_a,
        Some(axis.config.motor_side_inertia_kgm2()),
    );
    settings.motor_coulomb_nm = motor.coulomb_nm;
    settings.motor_viscous_nm_s_per_rad = motor.viscous_nm_s_per_rad;
    let fit = fit_backlash(&log, &settings)?;

    let um = 2e3 / axis.config.transmission.motor_rad_per_unit();
    let [low, high] = fit.half_gap_interval_rad.map(|half| half * um);
    println!(
        "true gap {:.1} um, fitted {:.1} um (95 %: {low:.1} to {high:.1})",
        axis.config.gap_in_unit() * 1e3,
        fit.half_gap_rad * um
    );
    Ok(())
}

// Prints:
// true gap 40.0 um, fitted 40.0 um (95 %: 40.0 to 40.0)
