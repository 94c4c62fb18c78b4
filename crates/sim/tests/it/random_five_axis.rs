//! Random programs under tool-centre-point control on every family: limits of all joints, the tip
//! on its straight way, no jumps, also past the poles.

use lostmotion_base::Coords;
use lostmotion_base::Random;
use lostmotion_plan::Sample;
use lostmotion_sim::machine::presets;
use lostmotion_sim::{Machine, Program, SimError, Simulation};
use std::fmt::Write;

/// A machine with the letter of the axis that tilts, and from where to where programs tilt it,
/// degrees.
fn families() -> Vec<(Machine, char, [f64; 2])> {
    let text = presets()
        .iter()
        .find(|preset| preset.name == "trunnion5")
        .unwrap()
        .toml;
    let bc = text
        .replace("trunnion-ac", "trunnion-bc")
        .replace("[axis.a.", "[axis.b.")
        .replace("a_deg", "b_deg");
    let preset = |name: &str| Machine::preset(name).unwrap();
    vec![
        (preset("trunnion5"), 'A', [-70.0, 70.0]),
        (
            Machine::from_toml("bc.toml", &bc).unwrap(),
            'B',
            [-70.0, 70.0],
        ),
        (preset("fork5"), 'B', [-60.0, 60.0]),
        (preset("swivel5"), 'B', [-60.0, 60.0]),
        (preset("nutating5"), 'B', [0.0, 120.0]),
    ]
}

/// Samples of a program; none where it is refused before anything moves, since joints would leave
/// the travel or have to change over.
fn planned(machine: &Machine, text: &str) -> Option<Vec<Sample>> {
    let mut samples = Vec::new();
    let source = Program::from_bytes("random.ngc", text.as_bytes());
    match Simulation::new(&source, machine).plan(&mut |chunk, _| {
        samples.extend_from_slice(chunk);
        Ok(())
    }) {
        Ok(_) => Some(samples),
        Err(SimError::Travel { .. }) => None,
        Err(SimError::Program { diagnostics, .. })
            if diagnostics
                .kept()
                .iter()
                .any(|found| found.to_string().contains("change over")) =>
        {
            None
        }
        Err(error) => panic!("{}: {error}\n{text}", machine.name()),
    }
}

/// Every joint's limits on differences of its positions, as an outsider takes them.
fn keeps_limits(machine: &Machine, samples: &[Sample], text: &str) {
    for axis in machine.axes() {
        let mut series: Vec<f64> = samples
            .iter()
            .map(|sample| sample.position[axis.id])
            .collect();
        assert!(
            series.iter().all(|p| axis.limits.contains(*p, 1e-6)),
            "{}: travel of {}\n{text}",
            machine.name(),
            axis.id
        );
        for limit in [
            axis.limits.velocity,
            axis.limits.acceleration,
            axis.limits.jerk,
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
                "{}: {} reaches {peak} of {limit}\n{text}",
                machine.name(),
                axis.id
            );
        }
    }
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

/// Straight lines of the tip with the rotary axes given by words: the tip stays on its line
/// whatever the joints do.
#[test]
fn words_under_tip_control() {
    for (machine, tilt, [low, high]) in families() {
        let kinematics = machine.build_kinematics().unwrap();
        let zero: Coords = machine.work_offsets()[0];
        let mut random = Random::new(31);
        let mut driven = 0;
        for _ in 0..RUNS {
            let mut text = String::from("G21 G17 G90 G94 G61\nG43.4 H0\n");
            if machine.kinematics().tip_control() == lostmotion_kinematics::TipControl::Always {
                text = String::from("G21 G17 G90 G94 G61\n(the tip, always)\n");
            }
            let mut ends: Vec<[f64; 3]> = Vec::new();
            for move_number in 0..6 {
                let end = [
                    40.0 * random.signed(),
                    40.0 * random.signed(),
                    40.0 + 20.0 * random.signed(),
                ];
                let angle = 0.5 * (low + high) + 0.5 * (high - low) * random.signed();
                // Half of the moves pass through the upright or near it.
                let turn = 180.0 * random.signed();
                let feed = if move_number == 0 {
                    "G0".to_owned()
                } else {
                    format!("G1 F{:.0}", 3000.0 + 2500.0 * random.signed())
                };
                let _ = writeln!(
                    text,
                    "{feed} X{:.4} Y{:.4} Z{:.4} {tilt}{angle:.4} C{turn:.4}",
                    end[0], end[1], end[2]
                );
                ends.push(end);
            }
            text.push_str("M2\n");
            let Some(samples) = planned(&machine, &text) else {
                continue;
            };
            driven += 1;
            keeps_limits(&machine, &samples, &text);
            for sample in &samples {
                let line = sample.block.span.line as usize;
                let Some(index) = line.checked_sub(4).filter(|index| index + 1 < ends.len()) else {
                    continue;
                };
                let tip = kinematics.tool_pose(&sample.position, &sample.tool_mm).tip;
                let part: [f64; 3] = std::array::from_fn(|i| tip[i] - zero.0[i]);
                let rounded = |end: [f64; 3]| end.map(|c| (c * 1e4).round() / 1e4);
                let off = distance(part, rounded(ends[index]), rounded(ends[index + 1]));
                assert!(off < 1e-6, "{} line {line}: {off}\n{text}", machine.name());
            }
        }
        assert!(driven >= RUNS / 3, "{}: {driven} of {RUNS}", machine.name());
    }
}

/// Programs on each machine.
const RUNS: usize = 12;

/// Directions by vectors, many of them across the pole or hardly beside it: within the orientation
/// tolerance, or slowed down, never jumped.
#[test]
fn directions_past_the_pole() {
    for (machine, ..) in families().into_iter().filter(|(machine, ..)| {
        machine.kinematics().tip_control() != lostmotion_kinematics::TipControl::Always
    }) {
        let kinematics = machine.build_kinematics().unwrap();
        let mut random = Random::new(32);
        let mut driven = 0;
        for _ in 0..RUNS {
            let mut text = String::from("G21 G17 G90 G94 G61\nG0 X0 Y0 Z60\nG43.5 H0\n");
            let mut directions = Vec::new();
            for step in 0..5 {
                // From one side of the pole to the other, off it by anything from nothing to a
                // tenth.
                let side = if step % 2 == 0 { 1.0 } else { -1.0 };
                let off = 0.1 * random.signed() * (1.0 + random.signed()).powi(4) / 16.0;
                let v: [f64; 3] = [side * (0.25 + 0.1 * random.signed()), off, 1.0];
                let size = v.iter().map(|c| c * c).sum::<f64>().sqrt();
                let [i, j, k] = v.map(|c| c / size);
                let _ = writeln!(
                    text,
                    "G1 X{:.3} Y{:.3} I{i:.9} J{j:.9} K{k:.9} F2000",
                    20.0 * random.signed(),
                    20.0 * random.signed()
                );
                directions.push([i, j, k]);
            }
            text.push_str("M2\n");
            let Some(samples) = planned(&machine, &text) else {
                continue;
            };
            driven += 1;
            keeps_limits(&machine, &samples, &text);
            let tolerance = kinematics.orientation().unwrap().tolerance_rad();
            for (index, direction) in directions.iter().enumerate() {
                let last = samples
                    .iter()
                    .rfind(|sample| sample.block.span.line as usize == index + 4)
                    .unwrap();
                let axis = kinematics.tool_pose(&last.position, &last.tool_mm).axis;
                let off = (0..3)
                    .map(|i| (axis[i] - direction[i]).powi(2))
                    .sum::<f64>()
                    .sqrt();
                assert!(
                    off <= tolerance * 1.05 + 1e-3,
                    "{} move {index}: {off} of {tolerance}\n{text}",
                    machine.name()
                );
            }
        }
        assert_eq!(driven, RUNS, "{}", machine.name());
    }
}
