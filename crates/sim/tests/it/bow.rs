//! How far the tool is off its way where joints go straight, against closed forms.
use lostmotion_base::math;
use lostmotion_base::units::rad;
use lostmotion_drive::config::Cycles;
use lostmotion_sim::results::PlanInfo;
use lostmotion_sim::{Machine, Program, SimulateOptions, Simulation};
use std::f64::consts::PI;

fn planned(machine: &Machine, text: &str) -> PlanInfo {
    let source = Program::from_str("bow.ngc", text);
    Simulation::new(&source, machine)
        .plan(&mut |_, _| Ok(()))
        .unwrap()
}

/// The way off the chord of an arc of radius r over an angle d, um.
fn sagitta_um(radius_mm: f64, angle: f64) -> f64 {
    1e3 * radius_mm * (1.0 - math::cos(0.5 * angle))
}

/// The tip stays where it is on the part while the table turns, so that X and Y follow a circle:
/// between two commands they go along its chord.
#[test]
fn between_two_commands_it_is_the_sagitta_of_a_cycle() {
    let machine = Machine::preset("trunnion5").unwrap();
    for (command_ms, servo_us) in [(1.0, 250.0), (8.0, 1000.0)] {
        let machine = machine.with_cycles(Cycles {
            command_ms,
            servo_us,
        });
        for (radius, degrees_min) in [(80.0, 3000.0), (40.0, 1500.0)] {
            let bow = planned(
                &machine,
                &format!("G21 G90 G61\nG0 X{radius} Y0 C0\nG1 C90 F{degrees_min}\nM2\n"),
            )
            .bow
            .unwrap();
            let expected = sagitta_um(radius, rad(degrees_min / 60.0) * command_ms * 1e-3);
            // The way to and from rest is slower, and its bend is that of the plan on both sides.
            assert!(
                (bow.max_um / expected - 1.0).abs() < 2e-3,
                "{command_ms} ms, {radius} mm: {} {expected}",
                bow.max_um
            );
            assert_eq!(bow.block.span.line, 3);
        }
    }
}

/// Z and C at once without tool-centre-point control: a helix on the part, off its chord by r (1 -
/// cos(d/2)) in the middle.
#[test]
fn over_a_block_it_is_that_of_the_block() {
    let machine = Machine::preset("swivel5").unwrap();
    for (radius, degrees) in [(80.0, 20.0), (30.0, 120.0)] {
        let info = planned(
            &machine,
            &format!(
                "G21 G90 G61\nG0 X{radius} Y0 C0\nG1 C1 F1000\nG1 Z-5 C{}\nG1 Z-6\nM2\n",
                degrees + 1.0
            ),
        );
        let block = info.unstraight.unwrap();
        let expected = sagitta_um(radius, rad(degrees));
        assert!(
            (block.max_um / expected - 1.0).abs() < 1e-6,
            "{radius} {degrees}: {} {expected}",
            block.max_um
        );
        assert_eq!(block.block.span.line, 4);
        // All joints of these moves go straight, so that only the place along the way is another.
        assert!(info.bow.unwrap().max_um < 1e-3, "{:?}", info.bow);
    }
}

/// Brute force over a block on which the tool tilts, too.
#[test]
fn over_a_block_of_two_turns_it_is_the_farthest_of_many_places() {
    let machine = Machine::preset("swivel5").unwrap();
    let info = planned(
        &machine,
        "G21 G90 G61\nG0 X50 Y10 B0 C0\nG1 X20 Y-30 B25 C70 F2000\nM2\n",
    );
    // C turns the tool about Z as the part sees it, B the tool about a point 200 mm above its tip.
    let tip = |part: f64| {
        let (b, c) = (rad(25.0 * part), rad(70.0 * part));
        let [x, y, z] = [
            50.0 - 30.0 * part - 200.0 * math::sin(b),
            10.0 - 40.0 * part,
            200.0 - 200.0 * math::cos(b),
        ];
        [
            math::cos(c) * x - math::sin(c) * y,
            math::cos(c) * y + math::sin(c) * x,
            z,
        ]
    };
    let (from, to) = (tip(0.0), tip(1.0));
    let way: [f64; 3] = std::array::from_fn(|n| to[n] - from[n]);
    let off = |part: f64| {
        let d: [f64; 3] = std::array::from_fn(|n| tip(part)[n] - from[n]);
        let (square, along) = (
            way.iter().map(|w| w * w).sum::<f64>(),
            way.iter().zip(&d).map(|(a, b)| a * b).sum::<f64>(),
        );
        (d.iter().map(|d| d * d).sum::<f64>() - along * along / square).sqrt()
    };
    let expected = 1e3
        * (0..=100_000)
            .map(|k| off(f64::from(k) * 1e-5))
            .fold(0.0, f64::max);
    let found = info.unstraight.unwrap().max_um;
    assert!((found / expected - 1.0).abs() < 1e-7, "{found} {expected}");
}

#[test]
fn a_bow_beyond_the_limit_is_warned_of_and_straight_machines_have_none() {
    let machine = Machine::preset("trunnion5").unwrap();
    let text = "G21 G90 G61\nG0 X80 Y0 C0\nG1 C30 F3000\nM2\n";
    let source = Program::from_str("bow.ngc", text);
    let warnings = |machine: &Machine, bow_limit_um: Option<f64>| {
        let options = SimulateOptions {
            bow_limit_um,
            ..SimulateOptions::default()
        };
        Simulation::new(&source, machine)
            .method("none")
            .options(options.clone())
            .run()
            .map(|run| run.into_single().unwrap())
            .unwrap()
            .program
            .warnings
    };
    assert!(warnings(&machine, None).is_empty());
    let told = planned(&machine, text).bow_warning(0.001).unwrap();
    assert!(
        told.starts_with("line 3:") && told.contains("limit 0.001 um"),
        "{told}"
    );
    assert!(sagitta_um(80.0, PI / 3600.0) > 1e-3);
    // A limit that somebody tells is kept, so that nothing is left to warn of.
    assert!(warnings(&machine, Some(0.001)).is_empty());
    let wide = Program::from_bytes(
        "wide.ngc",
        b"G21 G90 G61\nG0 X150 Y0 C0\nG1 C90 F12000\nM2\n".as_slice(),
    );
    let slow = machine.with_cycles(Cycles {
        command_ms: 8.0,
        servo_us: 1000.0,
    });
    let warned = Simulation::new(&wide, &slow)
        .method("none")
        .run()
        .map(|run| run.into_single().unwrap())
        .unwrap()
        .program
        .warnings;
    assert!(
        warned.len() == 1 && warned[0].starts_with("line 3:") && warned[0].contains("limit 5 um"),
        "{warned:?}"
    );
    let straight = planned(
        &Machine::preset("vmc3").unwrap(),
        "G21 G90\nG1 X10 F600\nM2\n",
    );
    assert_eq!((straight.bow, straight.unstraight), (None, None));
}
