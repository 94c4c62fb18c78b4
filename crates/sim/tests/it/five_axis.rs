//! Programs of the other machines as motion: tilted planes, directions, tool-centre-point control
//! on and off, arms.
use lostmotion_base::{AxisId, Coords};
use lostmotion_gcode::Severity;
use lostmotion_plan::Sample;
use lostmotion_sim::{Machine, Program, SimError, Simulation};
use std::path::PathBuf;

fn part(name: &str) -> Program {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../gcode_samples/parts")
        .join(name);
    Program::from_bytes(name, std::fs::read(path).unwrap())
}

fn planned(source: &Program, machine: &Machine) -> Vec<Sample> {
    let mut samples = Vec::new();
    Simulation::new(source, machine)
        .plan(&mut |chunk, _| {
            samples.extend_from_slice(chunk);
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{error}"));
    samples
}

fn text(text: &str) -> Program {
    Program::from_bytes("test.nc", text.as_bytes().to_vec())
}

/// Every limit of every joint, on differences of positions as an outsider would take them; and
/// joints never jump.
fn judge(name: &str, machine: &Machine, samples: &[Sample]) {
    for axis in machine.axes() {
        let mut series: Vec<f64> = samples
            .iter()
            .map(|sample| sample.position[axis.id])
            .collect();
        assert!(
            series.iter().all(|p| axis.limits.contains(*p, 1e-6)),
            "{name}: travel of {}",
            axis.id
        );
        for (what, limit) in [
            ("velocity", axis.limits.velocity),
            ("acceleration", axis.limits.acceleration),
            ("jerk", axis.limits.jerk),
        ] {
            series = series
                .windows(2)
                .map(|pair| (pair[1] - pair[0]) * 1e3)
                .collect();
            let peak = series
                .iter()
                .fold(0.0_f64, |most, value| most.max(value.abs()));
            assert!(
                peak <= limit * 1.001,
                "{name} on {}: {what} of {} reaches {peak} of {limit}",
                machine.name(),
                axis.id
            );
        }
    }
}

#[test]
fn parts_of_every_machine_keep_all_joint_limits() {
    for (name, on) in [
        ("fork_bevels.ngc", "fork5"),
        ("swivel_dome.ngc", "swivel5"),
        ("nutating_ring.ngc", "nutating5"),
        ("scara_star.ngc", "scara"),
        ("arm_panel.ngc", "arm6"),
        ("circle_r10.ngc", "corexy"),
        ("circle_r50.ngc", "delta"),
    ] {
        let machine = Machine::preset(on).unwrap();
        judge(name, &machine, &planned(&part(name), &machine));
    }
}

#[test]
fn a_tilted_plane_is_cut_flat() {
    let machine = Machine::preset("fork5").unwrap();
    let kinematics = machine.build_kinematics().unwrap();
    let (zero, mut cuts) = (machine.work_offsets()[0], 0);
    let mut turn = 0.0;
    let source = part("fork_bevels.ngc");
    let lines: Vec<String> = String::from_utf8(
        source
            .clone()
            .open()
            .map(|mut reader| {
                let mut bytes = Vec::new();
                std::io::Read::read_to_end(&mut reader, &mut bytes).unwrap();
                bytes
            })
            .unwrap(),
    )
    .unwrap()
    .lines()
    .map(str::to_owned)
    .collect();
    for sample in planned(&source, &machine) {
        let line = sample.block.span.line as usize;
        let Some(tilt) = lines[..line]
            .iter()
            .rev()
            .find(|line| line.starts_with("G68.2"))
        else {
            continue;
        };
        if lines[line - 1].starts_with("G1 Y") || lines[line - 1].starts_with("G1 X-24") {
            turn = tilt
                .split_once('I')
                .unwrap()
                .1
                .split(' ')
                .next()
                .unwrap()
                .parse::<f64>()
                .unwrap()
                .to_radians();
            let normal = [0.5 * turn.sin(), -0.5 * turn.cos(), 0.75_f64.sqrt()];
            let pose = kinematics.tool_pose(&sample.position, &sample.tool_mm);
            let height: f64 = (0..3)
                .map(|i| (pose.tip[i] - zero.0[i] - if i == 2 { 30.0 } else { 0.0 }) * normal[i])
                .sum();
            assert!((height + 1.0).abs() < 0.011, "line {line}: {height}");
            assert!(
                (0..3).all(|i| (pose.axis[i] - normal[i]).abs() < 1e-9),
                "{:?} {normal:?}",
                pose.axis
            );
            cuts += 1;
        }
    }
    assert!(cuts > 1000 && turn > 4.0, "{cuts}");
}

#[test]
fn the_tool_stands_upright_on_a_dome() {
    let machine = Machine::preset("swivel5").unwrap();
    let kinematics = machine.build_kinematics().unwrap();
    let zero = machine.work_offsets()[0];
    let samples = planned(&part("swivel_dome.ngc"), &machine);
    let (mut on_top, mut worst) = (0, 0.0_f64);
    let mut c: Vec<f64> = Vec::new();
    for sample in samples
        .iter()
        .filter(|sample| (13..=42).contains(&sample.block.span.line))
    {
        let pose = kinematics.tool_pose(&sample.position, &sample.tool_mm);
        let from_center: [f64; 3] =
            std::array::from_fn(|i| pose.tip[i] - zero.0[i] + if i == 2 { 20.0 } else { 0.0 });
        let size = from_center.iter().map(|c| c * c).sum::<f64>().sqrt();
        let cosine: f64 = (0..3).map(|i| from_center[i] * pose.axis[i] / size).sum();
        worst = worst.max(cosine.clamp(-1.0, 1.0).acos().to_degrees());
        on_top += i32::from(from_center[0].abs() < 1.0);
        c.push(sample.position[AxisId::C]);
    }
    // The chords of 2.5 mm on a sphere of 60 mm are off by 1.2 degrees where two meet, blending
    // included.
    assert!(on_top > 10 && worst < 1.3, "{on_top} {worst}");
    let (least, most) = c
        .iter()
        .fold((f64::MAX, f64::MIN), |(a, b), c| (a.min(*c), b.max(*c)));
    assert!(
        most - least < 1e-3,
        "C stays while B tilts through the pole: {least} {most}"
    );
}

#[test]
fn without_tip_control_the_linear_joints_stand_still() {
    let machine = Machine::preset("swivel5").unwrap();
    let samples = planned(
        &text("G21 G90 G54 G61.1 G0 X10 Y20 Z50\nG1 B30 F600\nG43.4 H1\nG1 B-20 F600\nG49\nM30\n"),
        &machine,
    );
    let at = |line: u32| {
        samples
            .iter()
            .filter(move |sample| sample.block.span.line == line)
            .map(|sample| sample.position)
    };
    let spread = |line: u32| {
        let first: Coords = at(line).next().unwrap();
        at(line)
            .map(|p| (p - first).linear_norm())
            .fold(0.0, f64::max)
    };
    assert!(spread(2) < 1e-9, "{}", spread(2));
    // The tip stays, so the joints go round it: 250 mm and more from the pivot, over 50 degrees.
    assert!(spread(4) > 100.0, "{}", spread(4));
    let kinematics = machine.build_kinematics().unwrap();
    let tips: Vec<[f64; 3]> = at(4)
        .map(|joints| kinematics.tool_pose(&joints, &[0.0; 3]).tip)
        .collect();
    assert!(
        tips.iter()
            .all(|tip| (0..3).all(|i| (tip[i] - tips[0][i]).abs() < 1e-6)),
        "the tip stands"
    );
}

#[test]
fn a_sample_is_simulated_in_part_space_on_every_machine() {
    for (name, on, most_um) in [
        ("scara_star.ngc", "scara", 300.0),
        ("arm_panel.ngc", "arm6", 600.0),
        ("circle_r10.ngc", "corexy", 40.0),
        ("swivel_dome.ngc", "swivel5", 150.0),
    ] {
        let machine = Machine::preset(on).unwrap();
        let result = Simulation::new(&part(name), &machine)
            .method("none")
            .run()
            .map(|run| run.into_single().unwrap())
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let worst = result.result.cutting.max;
        assert!(worst > 1.0 && worst < most_um, "{name} on {on}: {worst} um");
    }
}

#[test]
fn an_arm_that_would_have_to_change_over_is_refused() {
    let machine = Machine::preset("arm6").unwrap();
    // Through the axis of joint 1 and out behind the arm.
    let refused = Simulation::new(&text("G21 G90 G54\nG1 X-1600 F3000\nM2\n"), &machine)
        .plan(&mut |_, _| Ok(()));
    assert!(refused.is_err());
}

/// Directions wait for those behind them; the one that cannot be had is still told by its own line.
#[test]
fn a_direction_out_of_reach_is_told_at_its_block() {
    let machine = Machine::preset("fork5").unwrap();
    for (end, waits) in [("M2\n", 0), ("G49\nM2\n", 0), ("M2\n", 70)] {
        let mut program = String::from("G21 G90 G54\nG43.5 H0\nG0 X0 Y0 Z50 I0 J0 K1\n");
        program.push_str("G1 F1000 X10 I0.2 J0 K1\nG1 X20 I0 J1 K-1\nG1 X30 I0 J0 K1\n");
        for step in 0..waits {
            program.push_str(&format!("G1 X{}\n", 31 + step));
        }
        program.push_str(end);
        let refused = Simulation::new(&text(&program), &machine).plan(&mut |_, _| Ok(()));
        let Some(SimError::Program { diagnostics, .. }) = refused.err() else {
            panic!("{waits} moves and {end:?}: not refused by the program");
        };
        let lines: Vec<u32> = diagnostics
            .kept()
            .iter()
            .filter(|found| found.severity() == Severity::Error)
            .map(|error| error.place.span.line)
            .collect();
        assert_eq!(lines, [5], "{waits} moves and {end:?}");
    }
}

#[test]
fn a_tool_may_be_taken_up_while_it_leans() {
    let machine = Machine::preset("trunnion5").unwrap();
    let samples = planned(
        &text("G21 G90 G54 G61.1 G0 X10 Y20 Z50\nG0 A30 C40\nG43.1 Z60\nG1 X15 F900\nM2\n"),
        &machine,
    );
    judge("tool", &machine, &samples);
    let kinematics = machine.build_kinematics().unwrap();
    let tip = |line: u32| {
        let sample = samples
            .iter()
            .rfind(|sample| sample.block.span.line == line)
            .unwrap();
        (
            kinematics.tool_pose(&sample.position, &sample.tool_mm),
            sample.tool_mm,
        )
    };
    let ((before, _), (after, tool)) = (tip(2), tip(4));
    assert_eq!(tool[2], 60.0);
    // The tip comes 60 mm before the spindle along the leaning tool, and X goes where it was told.
    let zero = machine.work_offsets()[0];
    assert!((after.tip[0] - zero.0[0] - 15.0).abs() < 1e-6);
    assert!(
        (1..3).all(|i| (after.tip[i] - before.tip[i] + 60.0 * before.axis[i]).abs() < 1e-6),
        "{before:?} {after:?}"
    );
}
