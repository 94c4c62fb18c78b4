//! Cycles of command and servo, and interpolators, through the whole chain.

use lostmotion_base::AxisId;
use lostmotion_contour::ProgrammedSegment;
use lostmotion_drive::config::{Cycles, Interpolator};
use lostmotion_methods::{AxisConfig, MethodId};
use lostmotion_plan::Sample;
use lostmotion_sim::machine::Machine;
use lostmotion_sim::{Program, Simulation, results::SingleRun};

/// Two turns of a circle; enough of it is steady.
const CIRCLE: &str = "G21 G90 G17 G64 P0.001\nG0 X10 Y0\nG4 P0.2\nG3 I-10 J0 P2 F6000\nM2\n";

fn machine(command_ms: f64, servo_us: f64) -> Machine {
    Machine::preset("vmc3").expect("vmc3").with_cycles(Cycles {
        command_ms,
        servo_us,
    })
}

fn run(machine: &Machine, program: &str, method: &str) -> SingleRun {
    let source = Program::from_bytes("part.ngc", program.as_bytes());
    Simulation::new(&source, machine)
        .method(method)
        .run()
        .map(|run| run.into_single().unwrap())
        .expect("a result")
}

fn samples(machine: &Machine, program: &str) -> Vec<Sample> {
    let source = Program::from_bytes("part.ngc", program.as_bytes());
    let mut all = Vec::new();
    let mut sink = |samples: &[Sample], _: &[ProgrammedSegment]| {
        all.extend_from_slice(samples);
        Ok(())
    };
    Simulation::new(&source, machine)
        .plan(&mut sink)
        .expect("a plan");
    all
}

/// The plan is a function of time: a finer command cycle takes it at more places.
#[test]
fn finer_samples_hold_the_coarser_ones_to_the_last_bit() {
    let fine = samples(&machine(0.25, 250.0), CIRCLE);
    for (command_ms, step) in [(0.5, 2), (1.0, 4), (2.0, 8), (8.0, 32)] {
        let coarse = samples(&machine(command_ms, 250.0), CIRCLE);
        assert!(
            coarse.len() * step >= fine.len() && (coarse.len() - 2) * step < fine.len(),
            "{command_ms}"
        );
        for (sample, same) in coarse.iter().zip(fine.iter().step_by(step)) {
            let (a, b) = (Sample { tick: 0, ..*sample }, Sample { tick: 0, ..*same });
            assert_eq!(a, b, "{command_ms} ms, tick {}", sample.tick);
        }
    }
}

/// The default interpolator hides the command cycle: what the axes do differs by less and less.
#[test]
fn results_converge_as_the_command_cycle_shrinks() {
    let rms = |command_ms: f64| {
        run(&machine(command_ms, 250.0), CIRCLE, "none")
            .result
            .cutting
            .rms
    };
    let finest = rms(0.25);
    let off: Vec<f64> = [8.0, 2.0, 0.5]
        .into_iter()
        .map(|ms| (rms(ms) / finest - 1.0).abs())
        .collect();
    assert!(
        off[0] < 0.02 && off[1] < 0.005 && off[2] < 0.002,
        "{finest} um, {off:?}"
    );
}

/// Gains are those for 250 us: what is left is the loops' dead time, which shrinks with the cycle.
#[test]
fn results_converge_as_the_servo_cycle_shrinks() {
    let rms = |servo_us: f64| {
        run(&machine(1.0, servo_us), CIRCLE, "fixed")
            .without_gap
            .rms
    };
    let finest = rms(31.25);
    let off: Vec<f64> = [250.0, 125.0, 62.5]
        .into_iter()
        .map(|us| (rms(us) - finest).abs())
        .collect();
    assert!(
        off[0] > off[1] && off[1] > off[2] && off[2] < 0.1 * finest,
        "{finest} um, {off:?}"
    );
}

#[test]
fn every_method_runs_in_other_cycles() {
    let short = "G21 G90 G17 G64 P0.001\nG1 X2 Y1 F3000\nG1 X0 Y0\nG1 X2 Y1\nG1 X0 Y0\nM2\n";
    for (command_ms, servo_us) in [(0.25, 31.25), (2.0, 125.0), (8.0, 500.0)] {
        let machine = machine(command_ms, servo_us);
        for method in MethodId::all()
            .filter(|method| !method.needs_fit() && *method != MethodId::ADAPTIVE)
            .map(MethodId::name)
        {
            let result = run(&machine, short, method);
            let [max, none] = [result.result.cutting.max, result.without_gap.max];
            assert!(
                max.is_finite() && max > 0.0 && none < 60.0,
                "{command_ms} ms, {servo_us} us, {method}: {max} um, {none} um"
            );
        }
    }
}

/// On a line at 45 degrees an axis that is a cycle late leaves the contour by v T/2; all axes late
/// alike leave none.
#[test]
fn unequal_delays_leave_the_contour_by_half_the_way_of_a_cycle() {
    let line = "G21 G90 G17 G61\nG1 X60 Y60 F6000\nM2\n";
    let with = |x, y| {
        let machine = machine(1.0, 250.0);
        let put = |machine: Machine, id: AxisId, interpolator| {
            let config = AxisConfig {
                interpolator,
                ..machine.axis(id).expect("axis").config.clone()
            };
            machine.with_axis_config(id, &config)
        };
        let command = run(&put(put(machine, AxisId::X, x), AxisId::Y, y), line, "none")
            .plan
            .command;
        [command.max, command.p50]
    };
    let [max, p50] = with(Interpolator::QuinticHermite, Interpolator::CatmullRom);
    assert!(
        (max - 50.0).abs() < 0.5 && (p50 - 50.0).abs() < 0.5,
        "{max} um, {p50} um"
    );
    let [max, _] = with(Interpolator::CatmullRom, Interpolator::CatmullRom);
    assert!(max < 5e-3, "{max} um");
}

/// The B-spline cuts a circle by v^2 T^2/(6 r).
#[test]
fn a_b_spline_cuts_circles_by_its_closed_form() {
    for (interpolator, command_ms, expected_um) in [
        (Interpolator::BSpline, 1.0, 1e4 * 1e-6 / 60.0 * 1e3),
        (Interpolator::BSpline, 2.0, 1e4 * 4e-6 / 60.0 * 1e3),
        (Interpolator::CompensatedBSpline, 2.0, 0.0),
    ] {
        let machine = machine(command_ms, 250.0).map_axes(|axis| AxisConfig {
            interpolator,
            ..axis.clone()
        });
        let median = run(&machine, CIRCLE, "none").plan.command.p50;
        assert!(
            (median - expected_um).abs() < 0.03 * expected_um + 2e-3,
            "{interpolator}, {command_ms} ms: {median} um, {expected_um} um"
        );
    }
}

#[test]
fn a_machine_file_says_its_cycles_once() {
    let text = Machine::preset("vmc3")
        .expect("vmc3")
        .to_toml()
        .expect("writes");
    let with = |table: &str| {
        Machine::from_toml(
            "m.toml",
            &text.replacen("[kinematics]", &format!("{table}\n[kinematics]"), 1),
        )
    };
    let machine = with("[cycles]\ncommand_ms = 2.0\nservo_us = 125\n")
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        machine.cycles(),
        Cycles {
            command_ms: 2.0,
            servo_us: 125.0
        }
    );
    assert!(
        machine
            .axes()
            .iter()
            .all(|axis| axis.config.cycles == machine.cycles())
    );
    let again = Machine::from_toml("again", &machine.to_toml().expect("writes"))
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(again, machine);
    let refused = |table: &str| with(table).expect_err(table);
    let error = refused("[cycles]\nservo_us = 300.0\n");
    assert_eq!(
        (error.problems.len(), error.problems[0].key.as_str()),
        (1, "cycles.servo_us"),
        "{error}"
    );
    assert!(
        error
            .to_string()
            .contains("a whole fraction of the command's 1000 us"),
        "{error}"
    );
    assert!(
        refused("[cycles]\nservo_ms = 1.0\n")
            .to_string()
            .contains("servo_us"),
        "an unknown key"
    );
    let error = refused("[axis.x.cycles]\ncommand_ms = 2.0\n");
    assert!(error.to_string().contains("[cycles] at the top"), "{error}");
}

/// A machine's own words for its interpolators.
#[test]
fn interpolators_are_named_in_the_machine_file() {
    let text = Machine::preset("vmc3")
        .expect("vmc3")
        .to_toml()
        .expect("writes");
    let text = text.replacen(
        "interpolator = \"quintic-hermite\"",
        "interpolator = \"linear\"",
        1,
    );
    let machine = Machine::from_toml("m.toml", &text).unwrap_or_else(|error| panic!("{error}"));
    let linear = machine
        .axes()
        .iter()
        .filter(|axis| axis.config.interpolator == Interpolator::Linear)
        .count();
    assert_eq!(linear, 1);
    let error = Machine::from_toml("m.toml", &text.replace("\"linear\"", "\"lineal\""))
        .expect_err("unknown")
        .to_string();
    assert!(
        error.contains("`lineal` is not known") && error.contains("did you mean `linear`?"),
        "{error}"
    );
}
