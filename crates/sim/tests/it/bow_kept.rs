//! A limit of the tool's bow between two commands is kept by slowing down: against the closed form
//! of a turning table, and from outside, by the tool of joints that go straight from command to
//! command against the programmed lines, densely.

use lostmotion_base::Random;
use lostmotion_base::math;
use lostmotion_drive::config::{Cycles, Interpolator};
use lostmotion_kinematics::Kinematics;
use lostmotion_methods::AxisConfig;
use lostmotion_plan::{Action, Quality, Sample};
use lostmotion_sim::results::PlanInfo;
use lostmotion_sim::time::TimeOptions;
use lostmotion_sim::{Intervention, Machine, Program, SimulateOptions, Simulation};
use std::fmt::Write;

fn planned(machine: &Machine, text: &str, options: &SimulateOptions) -> (PlanInfo, Vec<Sample>) {
    let mut samples = Vec::new();
    let source = Program::from_str("bow.ngc", text);
    let info = Simulation::new(&source, machine)
        .options(options.clone())
        .plan(&mut |chunk, _| {
            samples.extend_from_slice(chunk);
            Ok(())
        });
    (
        info.unwrap_or_else(|error| panic!("{error}\n{text}")),
        samples,
    )
}

fn limited(um: f64) -> SimulateOptions {
    SimulateOptions {
        bow_limit_um: Some(um),
        ..SimulateOptions::default()
    }
}

/// The tip stays where it is on the part while C turns: X and Y go along chords of their circle, r
/// (1 - cos(d/2)) off it.
#[test]
fn a_table_turns_as_fast_as_its_chords_allow() {
    let machine = Machine::preset("trunnion5").unwrap().with_cycles(Cycles {
        command_ms: 8.0,
        servo_us: 1000.0,
    });
    let turn = std::f64::consts::TAU * 300.0 / 360.0;
    for (radius, um, quality) in [
        (80.0, 0.5, Quality::Fast),
        (80.0, 0.1, Quality::Fast),
        (40.0, 0.2, Quality::Optimal),
    ] {
        let text = format!("G21 G90 G61\nG0 X{radius} Y0 C-150\nG1 C150 F12000\nM2\n");
        let options = SimulateOptions {
            quality,
            ..limited(um)
        };
        let (info, samples) = planned(&machine, &text, &options);
        let found = info.bow.unwrap();
        assert!(
            found.max_um <= um && found.max_um > 0.97 * um,
            "{radius} {um}: {}",
            found.max_um
        );
        assert_eq!(info.bow_limit_um, Some(um));
        assert_eq!(info.bow_warning(um), None);
        let speed = 2.0 * math::acos(1.0 - 1e-3 * um / radius) / 8e-3;
        let cutting = samples
            .iter()
            .filter(|sample| sample.block.span.line == 3)
            .count() as f64
            * 8e-3;
        // At least the time at that speed, and hardly more than a start and a stop above it.
        assert!(
            cutting >= turn / speed && cutting < 1.006 * turn / speed + 0.25,
            "{radius} {um}: {cutting} {}",
            turn / speed
        );
        let source = Program::from_str("bow.ngc", text);
        let told = Simulation::new(&source, &machine)
            .options(options.clone())
            .time(
                &TimeOptions {
                    what_if: false,
                    ..TimeOptions::default()
                },
                &mut |_| Ok(()),
            )
            .unwrap();
        let block = told
            .blocks
            .iter()
            .find(|block| block.block.span.line == 3)
            .unwrap();
        assert!(
            block.limits[0].limit == "chord" && block.limits[0].share > 0.9,
            "{:?}",
            block.limits
        );
    }
}

/// On any machine arcs have chords: r (1 - cos(v T / 2 r)) off. Corners rounded in time keep the
/// limit, too, or are not rounded.
#[test]
fn arcs_and_corners_of_straight_machines_keep_it() {
    let machine = Machine::preset("vmc3").unwrap().with_cycles(Cycles {
        command_ms: 8.0,
        servo_us: 1000.0,
    });
    let circle = "G21 G90 G61\nG0 X5 Y0\nG3 I-5 J0 P8 F20000\nM2\n";
    let corners =
        "G21 G90 G64 P0.05\nG0 X0 Y0\nG1 X20 F6000\nG1 X20 Y20\nG1 X0 Y20 Z5\nG1 X10 Y0\nM2\n";
    for quality in [Quality::Fast, Quality::Optimal] {
        let options = SimulateOptions {
            quality,
            ..limited(0.5)
        };
        let (info, samples) = planned(&machine, circle, &options);
        let speed = 2.0 * 5.0 * math::acos(1.0 - 0.5e-3 / 5.0) / 8e-3;
        let fastest = samples
            .iter()
            .filter(|sample| sample.block.span.line == 3)
            .map(|sample| sample.path_speed)
            .fold(0.0, f64::max);
        assert!(
            fastest <= speed && fastest > 0.985 * speed && info.bow.unwrap().max_um <= 0.5,
            "{fastest} {speed} {:?}",
            info.bow
        );
        let (free, _) = planned(
            &machine,
            corners,
            &SimulateOptions {
                quality,
                ..SimulateOptions::default()
            },
        );
        let (loose, _) = planned(
            &machine,
            corners,
            &SimulateOptions {
                quality,
                ..limited(100.0)
            },
        );
        let (kept, _) = planned(&machine, corners, &options);
        assert!(
            loose.bow.unwrap().max_um > 4.0
                && loose.duration_s.to_bits() == free.duration_s.to_bits(),
            "{loose:?}"
        );
        assert!(
            kept.bow.unwrap().max_um <= 0.5 && kept.duration_s > free.duration_s,
            "{kept:?}"
        );
    }
}

/// A drive that goes straight keeps the limit of the machine; where there is nothing to keep, or no
/// limit reached, nothing changes by a bit.
#[test]
fn what_has_no_bow_is_planned_as_before() {
    let linear = |machine: &Machine| {
        machine.map_axes(|axis| AxisConfig {
            interpolator: Interpolator::Linear,
            ..axis.clone()
        })
    };
    let text =
        "G21 G90 G64 P0.01\nG0 X30 Y0\nG1 X10 Y20 F3000\nG2 X-10 Y0 I-10 J-10\nG1 Y-30\nM2\n";
    for name in ["vmc3", "trunnion5", "corexy"] {
        let machine = Machine::preset(name).unwrap();
        let (info, own) = planned(&machine, text, &SimulateOptions::default());
        assert_eq!(info.bow_limit_um, None);
        let (info, same) = planned(&linear(&machine), text, &SimulateOptions::default());
        assert_eq!(info.bow_limit_um, Some(5.0));
        let places = |samples: &[Sample]| {
            samples
                .iter()
                .map(|sample| sample.position)
                .collect::<Vec<_>>()
        };
        assert_eq!(places(&own), places(&same), "{name}");
    }
    let slow = Machine::preset("trunnion5").unwrap().with_cycles(Cycles {
        command_ms: 8.0,
        servo_us: 1000.0,
    });
    let turn = "G21 G90 G61\nG0 X150 Y0 C0\nG1 C90 F12000\nM2\n";
    let (free, _) = planned(&slow, turn, &SimulateOptions::default());
    let (kept, _) = planned(&linear(&slow), turn, &SimulateOptions::default());
    assert!(
        free.bow.unwrap().max_um > 5.0
            && kept.bow.unwrap().max_um <= 5.0
            && kept.duration_s > free.duration_s
    );
}

fn distance(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let less = |u: [f64; 3], v: [f64; 3]| [u[0] - v[0], u[1] - v[1], u[2] - v[2]];
    let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let (way, away) = (less(b, a), less(p, a));
    let along = if dot(way, way) > 0.0 {
        (dot(way, away) / dot(way, way)).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let rest = less(away, way.map(|w| w * along));
    dot(rest, rest).sqrt()
}

/// How far the tool of joints that go straight from command to command is off the lines of a
/// program, um.
fn off_um(
    kinematics: &dyn Kinematics,
    samples: &[Sample],
    ends: &[[f64; 3]],
    first_line: u32,
) -> f64 {
    let mut most = 0.0_f64;
    for pair in samples.windows(2) {
        let lines = [&pair[0], &pair[1]].map(|sample| sample.block.span.line);
        let Some(index) = lines[0].checked_sub(first_line).map(|index| index as usize) else {
            continue;
        };
        if lines[0] != lines[1] || index == 0 || index >= ends.len() {
            continue;
        }
        for part in 1..8 {
            let joints = pair[0]
                .position
                .lerp(pair[1].position, f64::from(part) / 8.0);
            most = most.max(distance(
                kinematics.tool_pose(&joints, &pair[0].tool_mm).tip,
                ends[index - 1],
                ends[index],
            ));
        }
    }
    1e3 * most
}

/// Five axes at once on lines of the tip: the bow stays within its limit in either quality, under
/// an override and with a hold.
#[test]
fn random_programs_keep_it_from_outside() {
    let families = [
        ("trunnion5", 'A', 50.0),
        ("swivel5", 'B', 45.0),
        ("fork5", 'B', 45.0),
        ("delta", ' ', 0.0),
        ("scara", ' ', 0.0),
    ];
    for (name, tilt, most) in families {
        let machine = Machine::preset(name).unwrap().with_cycles(Cycles {
            command_ms: 4.0,
            servo_us: 500.0,
        });
        let (kinematics, zero) = (
            machine.build_kinematics().unwrap(),
            machine.work_offsets()[0],
        );
        let scale = if name == "scara" { 0.3 } else { 1.0 };
        for seed in 0..2 {
            let (mut random, mut ends) = (Random::new(seed), Vec::new());
            let mut text = String::from("G21 G17 G90 G94 G61\n");
            let tip =
                machine.kinematics().tip_control() == lostmotion_kinematics::TipControl::Programmed;
            text.push_str(if tip {
                "G43.4 H0\n"
            } else {
                "(the tip, always)\n"
            });
            for number in 0..5 {
                let end = [30.0, 30.0, 10.0]
                    .map(|range| (range * scale * random.signed() * 1e3).round() / 1e3);
                let _ = write!(
                    text,
                    "{} X{} Y{} Z{}",
                    if number == 0 { "G0" } else { "G1 F20000" },
                    end[0],
                    end[1],
                    end[2]
                );
                if tilt != ' ' {
                    let _ = write!(
                        text,
                        " {tilt}{:.3} C{:.3}",
                        most * random.signed(),
                        120.0 * random.signed()
                    );
                }
                text.push('\n');
                ends.push(std::array::from_fn(|i| zero.0[i] + end[i]));
            }
            text.push_str("M2\n");
            let (free, samples) = planned(&machine, &text, &SimulateOptions::default());
            let own = off_um(kinematics.as_ref(), &samples, &ends, 3);
            let um = 0.3 * free.bow.unwrap().max_um;
            assert!(own > 2.0 * um, "{name} {seed}: {own} of {um}\n{text}");
            let act = |at_s: f64, action| Intervention { at_s, action };
            let held = vec![
                act(0.4, Action::Override(1.5)),
                act(0.7, Action::Hold),
                act(1.5, Action::Resume),
            ];
            for (quality, interventions) in [
                (Quality::Fast, vec![]),
                (Quality::Optimal, vec![]),
                (Quality::Fast, held),
            ] {
                let options = SimulateOptions {
                    quality,
                    interventions,
                    ..limited(um)
                };
                let (info, samples) = planned(&machine, &text, &options);
                let off = off_um(kinematics.as_ref(), &samples, &ends, 3);
                assert!(
                    off <= um && info.bow.unwrap().max_um <= um,
                    "{name} {seed} {quality:?}: {off} of {um}, {:?}\n{text}",
                    info.bow
                );
                assert!(info.duration_s > free.duration_s, "{name} {seed}");
            }
        }
    }
}
