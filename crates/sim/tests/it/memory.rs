//! The memory of a machine's axes as a file, and commissioning, which makes it.

use lostmotion_sim::machine::Memory;
use lostmotion_sim::{Machine, Program, Simulation, commission, presets};

const CIRCLE: &str =
    "G21 G90 G17 G64 P0.01\nG0 X10 Y0\nG3 X10 Y0 I-10 J0 F1500\nG3 X10 Y0 I-10 J0\nM2\n";

fn worn() -> (Machine, Memory) {
    let machine = Machine::preset("vmc3-worn").unwrap();
    let memory = commission::memory(&commission::all(&machine).unwrap());
    (machine, memory)
}

#[test]
fn what_commissioning_taught_is_in_force_from_the_first_block_on() {
    let (machine, memory) = worn();
    let names: Vec<&str> = memory.axis.keys().map(String::as_str).collect();
    assert_eq!(names, ["x", "y", "z"]);
    for (name, axis) in &memory.axis {
        let truth = machine.drive(name).unwrap().gap_in_unit();
        let gap = axis.gap_in_unit(machine.drive(name).unwrap());
        assert!((gap / truth - 1.0).abs() < 0.03, "{name}: {gap} {truth}");
        // The interval says how sure it is: four deviations hold.
        let deviation = gap * axis.learned.half_gap_deviation_rad / axis.learned.half_gap_rad;
        assert!(
            (gap - truth).abs() < 4.0 * deviation + 0.01 * truth,
            "{name}: {gap} +- {deviation}, {truth}"
        );
    }
    let program = Program::from_str("circle.ngc", CIRCLE);
    let run = |memory: Option<Memory>| {
        let simulation = Simulation::new(&program, &machine).methods(["none", "adaptive"]);
        match memory {
            Some(memory) => simulation.learned(memory),
            None => simulation,
        }
        .run()
        .unwrap()
    };
    let (cold, warm) = (run(None), run(Some(memory.clone())));
    let rms = |run: &lostmotion_sim::Run, method: usize| run.results[method].backlash.rms;
    assert!(rms(&warm, 1) < 0.05 * rms(&warm, 0), "{}", rms(&warm, 1));
    assert!(rms(&cold, 1) > rms(&warm, 1), "{}", rms(&cold, 1));
    // Nothing else changes, and what it knows at the end is at least what it knew.
    assert_eq!(rms(&cold, 0).to_bits(), rms(&warm, 0).to_bits());
    assert!(warm.results[0].learned.is_empty());
    assert_eq!(warm.results[1].learned.axis.len(), 3);
    // An empty memory is none.
    let empty = run(Some(Memory::default()));
    assert_eq!(rms(&empty, 1).to_bits(), rms(&cold, 1).to_bits());
}

/// A small fast circle, four times over, of two motors that both carry the head: a crossing begins before
/// the one before is over. (Record 125 of the decisions.)
#[test]
fn a_crossing_that_begins_in_another_one_does_no_harm() {
    let lap = "G0 Z5\nG0 X5 Y0\nG1 Z-1 F300\nG3 I-5 F3000\n".repeat(4);
    let text = format!("G21 G90 G17\nG64 P0.01\n{lap}G0 Z5\nM2\n");
    let program = Program::from_str("laps.ngc", &text);
    let machine = Machine::preset("corexy").unwrap();
    let run = Simulation::new(&program, &machine)
        .methods(["none", "adaptive"])
        .run()
        .unwrap();
    let [none, adaptive] = [0, 1].map(|index: usize| run.results[index].cutting);
    assert!(
        adaptive.max <= 1.02 * none.max + 0.5,
        "{} {}",
        adaptive.max,
        none.max
    );
    assert!(
        adaptive.rms <= 1.02 * none.rms,
        "{} {}",
        adaptive.rms,
        none.rms
    );
    // and it helps
    assert!(run.results[1].backlash.rms < run.results[0].backlash.rms);
}

#[test]
fn a_file_comes_back_to_the_bit_and_says_where_it_is_wrong() {
    let (machine, memory) = worn();
    let text = memory.to_toml().unwrap();
    assert_eq!(Memory::from_toml_for(&machine, "m.toml", &text), Ok(memory));
    let line_of = |text: &str, piece: &str| {
        let line = text.lines().position(|line| line.contains(piece)).unwrap();
        format!("m.toml:{}:", line + 1)
    };
    let first = |key: &str| {
        let line = text.lines().find(|line| line.starts_with(key)).unwrap();
        line.to_owned()
    };
    // A change of the text, the place, and pieces of what is said.
    let version = text.replace("version = 1", "version = 2");
    let unknown = text.replacen("half_gap_rad", "half_gap_um", 1);
    let negative = text.replacen(&first("load_inertia_kgm2"), "load_inertia_kgm2 = -1.0", 1);
    let other = text.replacen(&first("rotor_inertia_kgm2"), "rotor_inertia_kgm2 = 0.5", 1);
    let infinite = text.replacen(&first("coulomb_nm"), "coulomb_nm = inf", 1);
    let axis = text.replace("axis.x.", "axis.u.");
    let word = text.replacen(&first("gap_readings"), "gap_readings = \"many\"", 1);
    for (text, place, pieces) in [
        (
            &version,
            "version",
            &["is 2", "reads version 1", "hint"][..],
        ),
        (
            &unknown,
            "half_gap_um",
            &["half_gap_um", "unknown", "half_gap_rad"],
        ),
        (
            &negative,
            "= -1.0",
            &["axis.x.learned.load_inertia_kgm2", "is -1", "hint"],
        ),
        (
            &other,
            "= 0.5",
            &[
                "axis.x.learned_on.rotor_inertia_kgm2",
                "learned on an axis with a rotor inertia of 0.5, this one has 0.00",
                "hint",
            ],
        ),
        (&infinite, "= inf", &["axis.x.learned.coulomb_nm", "inf"]),
        (&axis, "axis.u.", &["axis.u", "has no such axis", "hint"]),
        (&word, "many", &["axis.x.learned.gap_readings", "many"]),
    ] {
        let error = Memory::from_toml_for(&machine, "m.toml", text).unwrap_err();
        let said = error.to_string();
        assert!(said.contains(&line_of(text, place)), "{place}: {said}");
        for piece in pieces {
            assert!(said.contains(piece), "{piece}: {said}");
        }
        // One message a cause.
        assert_eq!(error.problems.len(), 1, "{said}");
    }
    // Not for a machine that it was not learned on, however it is given.
    let another = Machine::preset("bench3").unwrap();
    let program = Program::from_str("line.ngc", "G21 G90\nG1 X5 F900\nM2\n");
    let memory = Memory::from_toml("m.toml", &text).unwrap();
    let error = Simulation::new(&program, &another).learned(memory).run();
    assert!(error.unwrap_err().to_string().contains("learned_on"));
}

/// Speed, acceleration and jerk by differences of the positions alone: limits and travel hold, the
/// motion is a minute's, and what the setpoints say of themselves is what they do.
#[test]
fn the_motion_keeps_every_limit_of_every_axis() {
    for preset in presets() {
        let machine = Machine::preset(preset.name).unwrap();
        for drive in machine.drives() {
            let bounds = commission::bounds(&machine, &drive).unwrap();
            let (limits, cycle, of) = (
                bounds.limits,
                bounds.cycle_s,
                format!("{}:{drive}", preset.name),
            );
            let points = bounds.setpoints();
            let seconds = points.len() as f64 * cycle;
            assert!((25.0..150.0).contains(&seconds), "{of}: {seconds} s");
            let mut reversals = 0;
            for window in points.windows(4) {
                let p = [0, 1, 2, 3].map(|n: usize| window[n].position);
                assert!(p[0] >= limits.min && p[0] <= limits.max, "{of}: {}", p[0]);
                let v = [0, 1, 2].map(|n: usize| (p[n + 1] - p[n]) / cycle);
                let a = [0, 1].map(|n: usize| (v[n + 1] - v[n]) / cycle);
                let jerk = (a[1] - a[0]) / cycle;
                assert!(v[0].abs() <= 1.001 * limits.velocity, "{of}: {}", v[0]);
                assert!(a[0].abs() <= 1.01 * limits.acceleration, "{of}: {}", a[0]);
                assert!(jerk.abs() <= 1.05 * limits.jerk, "{of}: jerk {jerk}");
                let told = window[1].velocity.unwrap();
                let seen = 0.5 * (v[0] + v[1]);
                assert!(
                    (told - seen).abs() <= 0.2 * limits.jerk * cycle * cycle + 1e-9,
                    "{of}: {told} {seen}"
                );
                reversals += u32::from(v[0] * v[1] < 0.0);
            }
            assert!(reversals > 10, "{of}: {reversals}");
        }
    }
}

#[test]
fn the_program_for_the_control_fits_every_machine_that_it_is_written_for() {
    let mut written = 0;
    for preset in presets() {
        let machine = Machine::preset(preset.name).unwrap();
        let Ok(text) = commission::program(&machine, &machine.drives()) else {
            assert_ne!(machine.kinematics().kind(), "cartesian", "{}", preset.name);
            continue;
        };
        written += 1;
        let program = Program::from_str("commission.ngc", text);
        let mut range = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let plan = Simulation::new(&program, &machine)
            .plan(&mut |samples, _| {
                for sample in samples {
                    for (axis, value) in sample.position.linear().into_iter().enumerate() {
                        range[0][axis] = range[0][axis].min(value);
                        range[1][axis] = range[1][axis].max(value);
                    }
                }
                Ok(())
            })
            .unwrap_or_else(|error| panic!("{}: {error}", preset.name));
        assert!(plan.duration_s > 60.0, "{}", preset.name);
        // Each axis really makes its strokes.
        for (least, most) in range[0].iter().zip(&range[1]).take(3) {
            assert!(most - least > 1.0, "{}", preset.name);
        }
    }
    assert!(written > 2);
}
