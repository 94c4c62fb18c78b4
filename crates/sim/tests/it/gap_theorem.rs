//! What gaps can do, as the page on the contour error derives it: an identity of the shaft that holds
//! on every machine, and the bound of a machine without friction, which is a number of its loops times
//! the gap and may be many gaps.

use lostmotion_base::AxisId;
use lostmotion_drive::config::Load;
use lostmotion_drive::{AxisOutput, Setpoint};
use lostmotion_methods::{MethodId, build_runner};
use lostmotion_sim::{Machine, Program, Simulation, SinkError, TickSink, Ticks};

/// A shaft as the motor sees it.
#[derive(Clone, Copy, Debug)]
struct Shaft {
    half_gap: f64,
    stiffness: f64,
    damping: f64,
}

/// Holds each axis, tick by tick, against the one without a gap.
struct Held {
    axes: Vec<(AxisId, Shaft)>,
    /// The largest difference of the loads, rad at the motor.
    apart: Vec<f64>,
    /// The largest part of the bound that it was.
    closest: f64,
    ticks: usize,
}

impl TickSink for Held {
    fn chunk(&mut self, ticks: &Ticks<'_>) -> Result<(), SinkError> {
        for frame in ticks.frames() {
            for (index, (axis, shaft)) in self.axes.iter().enumerate() {
                let [ideal, real] =
                    [0, 1].map(|variant| *ticks.trace(variant, *axis, frame).unwrap());
                let apart = (real.load_position - ideal.load_position).abs();
                let motors = (real.motor_position - ideal.motor_position).abs();
                // T = k w + d (w_M - w_L) on a flank; 0 in the gap, which it leaves with what the
                // damping holds.
                let [wound, wound_ideal] = [real, ideal].map(|sample| {
                    let slip = (sample.motor_velocity - sample.load_velocity).abs();
                    (sample.shaft_torque.abs() + shaft.damping * slip) / shaft.stiffness
                });
                let bound = motors + wound + wound_ideal + shaft.half_gap;
                assert!(
                    apart <= bound * (1.0 + 1e-9) + 1e-12,
                    "{axis} at {}: {apart:e} of {bound:e}",
                    frame.tick
                );
                self.apart[index] = self.apart[index].max(apart);
                self.closest = self.closest.max(apart / bound);
            }
            self.ticks += 1;
        }
        Ok(())
    }
}

fn held(machine: &Machine, text: &str) -> Held {
    let axes: Vec<(AxisId, Shaft)> = machine
        .axes()
        .iter()
        .map(|axis| {
            let load = axis.config.reflected_load();
            let shaft = Shaft {
                half_gap: 0.5 * load.gap_rad,
                stiffness: load.stiffness_nm_per_rad,
                damping: load.damping_nm_s_per_rad,
            };
            (axis.id, shaft)
        })
        .collect();
    let mut held = Held {
        apart: vec![0.0; axes.len()],
        axes,
        closest: 0.0,
        ticks: 0,
    };
    let program = Program::from_str("gap.ngc", text);
    Simulation::new(&program, machine)
        .ticks(true, &mut held)
        .unwrap();
    held
}

/// `l - l0 = (m - m0) - (w - w0) - c` with `|c| <= g/2`: on a sound mill, on a worn one, and on one
/// whose drive nobody has tuned.
#[test]
fn loads_differ_by_the_gap_the_wind_up_and_the_motors() {
    let text = "G21 G17 G90 G64 P0.01\nG0 X0 Y0 Z0\nG1 X12 Y5 Z-3 F3000\nX3 Y-4\nG3 I-6 J0 F2000\nG0 X0 Z0\nM2\n";
    let mut closest: f64 = 0.0;
    for (name, gain) in [
        ("vmc3", None),
        ("vmc3-worn", None),
        ("vmc3-worn", Some(10.0)),
    ] {
        let machine = Machine::preset(name)
            .unwrap()
            .edit(|m| {
                if let Some(gain) = gain {
                    m.axis("x").drive.velocity_gain_a_s_per_rad = gain;
                }
            })
            .unwrap();
        let held = held(&machine, text);
        assert!(held.ticks > 4000, "{}", held.ticks);
        closest = closest.max(held.closest);
    }
    assert!(closest > 0.9, "a loose bound: {closest}");
}

/// The L1 norm of the response of a load to an offset of its shaft, its motor held: that of
/// `(2 z w s + w^2) / (s^2 + 2 z w s + w^2)`, by a sum over its impulse response.
fn peak_gain(omega: f64, zeta: f64) -> f64 {
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let step = 1e-3 / omega;
    (0..1_000_000)
        .map(|n| {
            let t = (f64::from(n) + 0.5) * step;
            let (sine, cosine) = (damped * t).sin_cos();
            let response = 2.0 * zeta * omega * cosine
                + omega * omega * (1.0 - 2.0 * zeta * zeta) / damped * sine;
            ((-zeta * omega * t).exp() * response).abs() * step
        })
        .sum()
}

/// A load on a shaft whose motor stands, pushed by a force: the gap is an offset of the shaft of at
/// most half of it, so the load is off by at most the peak gain times that; and more than the gap
/// itself, where the force meets the resonance.
#[test]
fn without_friction_the_peak_gain_of_the_loop_bounds_what_the_gap_does() {
    let machine = Machine::preset("vmc3").unwrap();
    let mut config = machine.axis(AxisId::X).unwrap().config.clone();
    // Held by its inertia.
    config.motor.inertia_kgm2 = 1e6;
    config.motor.coulomb_nm = 0.0;
    config.drive.encoder_counts_per_rev = None;
    if let Load::Slide(slide) = &mut config.load {
        (slide.coulomb_n, slide.viscous_n_s_per_m) = (0.0, 0.0);
    }
    let load = config.reflected_load();
    let (k, d) = (load.stiffness_nm_per_rad, load.damping_nm_s_per_rad);
    let omega = (k / load.inertia_kgm2).sqrt();
    let zeta = 0.5 * d * omega / k;
    let gain = peak_gain(omega, zeta);
    let half_gap = 0.5 * load.gap_rad;
    let mut most: f64 = 0.0;
    for (of_resonance, force_n) in [(0.3, 3e3), (0.8, 3e3), (0.95, 6e3), (1.0, 3e3), (1.0, 2e4)] {
        let setpoints: Vec<Setpoint> = (0..2000)
            .map(|n| Setpoint {
                load_force: Some(force_n * (of_resonance * omega * 1e-3 * f64::from(n)).sin()),
                ..Setpoint::moving(0.0, 0.0, 0.0)
            })
            .collect();
        let [real, ideal] = [config.clone(), config.without_gap()].map(|config| {
            let mut output = AxisOutput::new(true);
            let mut runner = build_runner(&config, MethodId::NONE, 0.0).unwrap();
            runner.push(&setpoints, &mut output).unwrap();
            output.trace.unwrap()
        });
        let (mut apart, mut slip): (f64, f64) = (0.0, 0.0);
        for (real, ideal) in real.iter().zip(&ideal) {
            apart = apart.max((real.load_position - ideal.load_position).abs());
            slip = slip.max((real.motor_velocity - real.load_velocity).abs());
        }
        // A flank lets go while the damping still holds `d slip` of the spring back.
        let offset = half_gap + d * slip / k;
        let part = apart / offset;
        eprintln!("{of_resonance} of the resonance, {force_n} N: {part:.2} of {gain:.2}");
        assert!(part <= gain, "{part} of {gain}");
        most = most.max(apart / load.gap_rad);
    }
    eprintln!("at most {most:.2} gaps");
    assert!(most > 1.5, "a loose example: {most} gaps");
}
