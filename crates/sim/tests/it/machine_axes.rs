//! The axes of the machines that come with the library, run through the axis simulation.

use lostmotion_base::math::sin_cos;
use lostmotion_drive::{AxisOutput, Setpoint};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};
use lostmotion_sim::machine::{Machine, MachineAxis, presets};
use lostmotion_sim::{Program, Simulation};

fn all_axes() -> Vec<(String, MachineAxis)> {
    let of = |machine: Machine| {
        machine
            .axes()
            .iter()
            .map(|axis| (format!("{}:{}", machine.name(), axis.id), axis.clone()))
            .collect::<Vec<_>>()
    };
    presets()
        .iter()
        .filter_map(|info| Machine::preset(info.name).ok())
        .flat_map(of)
        .collect()
}

/// Reference and load in the axis' unit (mm or deg) at every servo tick, and the number of
/// saturated ones.
fn run(config: &AxisConfig, seconds: f64, motion: &dyn Fn(f64) -> [f64; 3]) -> AxisOutput {
    let points: Vec<Setpoint> = (0..(seconds * 1e3) as u32)
        .map(|tick| motion(f64::from(tick) * 1e-3))
        .map(|[position, v, a]| Setpoint::moving(position, v, a))
        .collect();
    let mut out = AxisOutput::default();
    let mut runner = build_runner(config, MethodId::NONE, motion(0.0)[0])
        .unwrap_or_else(|error| panic!("{error}"));
    runner
        .push(&points, &mut out)
        .unwrap_or_else(|error| panic!("{error}"));
    out
}

/// Rest to rest over `distance` in the shortest time in which a quintic keeps all three limits:
/// peaks 15/8 D/T, 10/sqrt(3) D/T2, 60 D/T3.
fn quintic(axis: &MachineAxis, distance: f64) -> (f64, impl Fn(f64) -> [f64; 3]) {
    let unit = axis.axis_units_per_joint_unit();
    let (v, a, j) = (
        axis.limits.velocity * unit,
        axis.limits.acceleration * unit,
        axis.limits.jerk * unit,
    );
    let duration = (1.875 * distance / v)
        .max((5.7735 * distance / a).sqrt())
        .max(lostmotion_base::math::cbrt(60.0 * distance / j));
    let motion = move |t: f64| {
        let u = (t / duration).clamp(0.0, 1.0);
        let position = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let velocity = 30.0 * u * u * (1.0 - u) * (1.0 - u);
        let acceleration = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u);
        [
            distance * position,
            distance * velocity / duration,
            distance * acceleration / (duration * duration),
        ]
    };
    (duration, motion)
}

fn peak(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |peak, value| peak.max(value.abs()))
}

#[test]
fn fastest_moves_do_not_saturate_and_end_at_rest() {
    for (name, axis) in all_axes() {
        let (duration, motion) = quintic(&axis, 300.0);
        let out = run(&axis.config, duration + 1.0, &motion);
        assert_eq!(out.saturated_samples, 0, "{name}");
        assert!(
            out.peak_current_a < 0.8 * axis.config.drive.current_limit_a,
            "{name}: {} A",
            out.peak_current_a
        );
        let gap = axis.config.gap_in_unit();
        let last = out.load.len() - 1000;
        let (low, high) = out.load[last..]
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        // standing still means standing still: no limit cycle through the gap
        assert!(
            high - low < 0.02 * gap,
            "{name} moves by {} of its gap of {gap} while it stands",
            high - low
        );
        // the motor stands where it should; the load lies anywhere in the gap, the shaft wound up
        // by what holds the load
        let load = axis.config.reflected_load();
        let unit_per_rad = 1.0 / axis.config.transmission.motor_rad_per_unit();
        let wind_up =
            (load.coulomb_nm + load.constant_nm.abs()) / load.stiffness_nm_per_rad * unit_per_rad;
        let encoder = std::f64::consts::TAU
            / f64::from(axis.config.drive.encoder_counts_per_rev.unwrap_or(u32::MAX))
            * unit_per_rad;
        let behind = 300.0 - high;
        assert!(
            behind.abs() < 0.5 * gap + wind_up + encoder,
            "{name} ends {behind} behind, {wind_up} of wind-up"
        );
    }
}

#[test]
fn without_gap_a_circle_is_followed_to_micrometres_and_the_gap_adds_its_half() {
    // one axis of a circle of radius 25 mm at 3000 mm/min (or 25 deg at 50 deg/s)
    let (radius, w) = (25.0, 2.0);
    let motion = |t: f64| {
        let (sin, cos) = sin_cos(w * t);
        [radius * cos, -radius * w * sin, -radius * w * w * cos]
    };
    for (name, axis) in all_axes() {
        let gap = axis.config.gap_in_unit();
        let error = |config: &AxisConfig| {
            let out = run(config, 8.0, &motion);
            peak(
                out.load
                    .iter()
                    .zip(&out.reference)
                    .skip(16_000)
                    .map(|(load, reference)| load - reference),
            )
        };
        let (with, without) = (error(&axis.config), error(&axis.config.without_gap()));
        assert!(
            without
                < if name.starts_with("vmc3-worn") {
                    0.05
                } else {
                    0.02
                },
            "{name}: {without} without a gap"
        );
        let share = (with - without) / gap;
        assert!(
            (0.35..0.65).contains(&share),
            "{name}: the gap of {gap} adds {share} of itself"
        );
    }
}

#[test]
fn a_run_that_names_no_method_uses_that_of_each_axis() {
    let program = Program::from_str("circle", "G21 G90 G17 G0 X2 Y0\nG3 I-2 F1200\nM2\n");
    let machine = |x: &str, y: &str| {
        Machine::preset("vmc3")
            .unwrap()
            .edit(|m| {
                m.axis("x").config.compensation.method = x.parse().unwrap();
                m.axis("y").config.compensation.method = y.parse().unwrap();
            })
            .unwrap()
    };
    let backlash = |machine: &Machine, method: Option<&str>| {
        let run = Simulation::new(&program, machine);
        let run = match method {
            Some(name) => run.method(name),
            None => run,
        };
        let run = run.run().unwrap();
        let result = run.results.first().unwrap();
        (result.method.clone(), result.backlash.rms)
    };
    let both = machine("fixed", "fixed");
    let (none, fixed) = (
        backlash(&both, Some("none")),
        backlash(&both, Some("fixed")),
    );
    // An axis that lags by half its gap adds that times the sine of the angle to the error of the
    // circle: one axis alone sqrt(1/2) of half a gap. (Two equal gaps cancel in part, so that one
    // axis set right is worse than none.)
    let one_gap = 0.5 * 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    assert!(fixed.1 < 0.3 * one_gap, "{fixed:?}");
    for (x, y, name) in [
        ("fixed", "none", "x fixed, y none, z none"),
        ("none", "fixed", "x none, y fixed, z none"),
    ] {
        let (used, rms) = backlash(&machine(x, y), None);
        assert_eq!(used, name);
        assert!((rms / one_gap - 1.0).abs() < 0.1, "{name}: {rms}");
    }
    // one named for the run replaces those of all axes
    assert_eq!(backlash(&machine("fixed", "adaptive"), Some("none")), none);
}
