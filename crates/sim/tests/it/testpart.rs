//! Test programs: every machine and dialect runs them within travel and limits, and the ballbar's
//! circle of a simulated machine tells what the machine was described with.

use lostmotion_contour::ballbar::sheet;
use lostmotion_gcode::Dialect;
use lostmotion_sim::machine::presets;
use lostmotion_sim::testpart::{BallbarTest, TestKind, TestOptions, program, simulate_ballbar};
use lostmotion_sim::time::TimeOptions;
use lostmotion_sim::{Machine, Program, Simulation};

const WRITTEN: [Dialect; 5] = [
    Dialect::LinuxCnc,
    Dialect::Fanuc,
    Dialect::Haas,
    Dialect::Marlin,
    Dialect::Klipper,
];

fn options(dialect: Dialect) -> TestOptions {
    TestOptions {
        dialect: Some(dialect),
        ..TestOptions::default()
    }
}

/// Time of dwells and of cutting moves, s.
fn times(text: &str, machine: &Machine, dialect: Dialect) -> (f64, f64) {
    let program = Program::from_str("test", text);
    let wanted = TimeOptions {
        what_if: false,
        ..TimeOptions::default()
    };
    let time = Simulation::new(&program, machine)
        .dialect(dialect)
        .time(&wanted, &mut |_| Ok(()))
        .unwrap_or_else(|error| panic!("{} {}: {error}\n{text}", machine.name(), dialect.name()));
    // Printers have no code for the end of a program.
    let is_printer = matches!(dialect, Dialect::Marlin | Dialect::Klipper);
    let mut warnings = time.program.warnings.clone();
    warnings.retain(|warning| !(is_printer && warning.starts_with("warning[no-program-end]")));
    assert!(warnings.is_empty(), "{warnings:?}\n{text}");
    (time.kinds.dwell_s, time.kinds.cutting_s)
}

/// Controls read the same program in their own words: as long dwells, as long cuts.
#[test]
fn every_dialect_means_the_same() {
    for name in ["vmc3", "bench3", "vmc4"] {
        let machine = Machine::preset(name).unwrap();
        for kind in [
            TestKind::Circle,
            TestKind::Reversal,
            TestKind::Ballbar,
            TestKind::Friction,
        ] {
            let of = |dialect| {
                times(
                    &program(&machine, kind, &options(dialect)).unwrap(),
                    &machine,
                    dialect,
                )
            };
            let (dwell, cutting) = of(Dialect::LinuxCnc);
            assert!(dwell > 3.0 && cutting > 5.0, "{name} {kind}");
            for dialect in &WRITTEN[1..] {
                let (other_dwell, other_cutting) = of(*dialect);
                assert!(
                    (other_dwell - dwell).abs() < 0.05,
                    "{name} {kind} {}: {dwell} {other_dwell}",
                    dialect.name()
                );
                // Blending is another where G64 P is not known.
                assert!(
                    (other_cutting / cutting - 1.0).abs() < 0.02,
                    "{name} {kind} {}: {cutting} {other_cutting}",
                    dialect.name()
                );
            }
        }
    }
}

/// Programs for Siemens are not read: its words differ in what stands around the same moves.
#[test]
fn siemens_has_the_same_moves_in_its_own_words() {
    let machine = Machine::preset("vmc3").unwrap();
    for kind in TestKind::ALL {
        let of = |dialect| program(&machine, kind, &options(dialect));
        if kind == TestKind::Commission {
            let error = of(Dialect::Siemens).unwrap_err().to_string();
            assert!(error.contains("not for siemens"), "{error}");
            continue;
        }
        let (own, other) = (
            of(Dialect::Siemens).unwrap(),
            of(Dialect::LinuxCnc).unwrap(),
        );
        assert_eq!(own.lines().count(), other.lines().count());
        assert!(own.ends_with("\nM30\n"), "{own}");
        for (own, other) in own.lines().zip(other.lines()) {
            match (own.as_bytes()[0], own.get(..3)) {
                (b';', _) => assert_eq!(own[2..], other[1..other.len() - 1]),
                (_, Some("G4 ")) => assert_eq!(own.replace("G4 F", "G4 P"), other),
                (_, Some("G71")) => assert_eq!(own, "G710 G90 G17 G40 D0 G94 G54 G64"),
                (_, Some("M30")) => assert_eq!(other, "M2"),
                _ => assert_eq!(own, other),
            }
        }
    }
}

#[test]
fn every_machine_has_its_tests_or_says_why_not() {
    for preset in presets() {
        let machine = Machine::preset(preset.name).unwrap();
        let is_cartesian = machine.kinematics().kind() == "cartesian";
        for kind in TestKind::ALL {
            match program(&machine, kind, &options(Dialect::LinuxCnc)) {
                Ok(text) if is_cartesian => {
                    Simulation::new(&Program::from_str("test", &text), &machine)
                        .check()
                        .unwrap_or_else(|error| panic!("{} {kind}: {error}", preset.name));
                }
                // Around the program's zero, where the travel of the joints tells nothing.
                Ok(text) => {
                    assert!(matches!(kind, TestKind::Circle | TestKind::Ballbar));
                    Simulation::new(&Program::from_str("test", &text), &machine)
                        .dialect(Dialect::LinuxCnc)
                        .check()
                        .unwrap_or_else(|error| panic!("{} {kind}: {error}", preset.name));
                }
                Err(error) => {
                    assert!(!is_cartesian, "{} {kind}: {error}", preset.name);
                    assert!(error.to_string().contains("one by one"), "{error}");
                }
            }
        }
    }
}

/// The largest usual circle is the largest that the machine runs: 300 mm on none of these.
#[test]
fn usual_circles_are_those_that_the_machine_runs() {
    for (name, radius_mm) in [("trunnion5", 150.0), ("corexy", 150.0), ("scara", 150.0)] {
        let machine = Machine::preset(name).unwrap();
        let test = BallbarTest::new(&machine, &TestOptions::default()).unwrap();
        assert_eq!(test.circle.radius_mm, radius_mm, "{name}");
        let text = program(&machine, TestKind::Circle, &options(Dialect::Marlin)).unwrap();
        assert!(
            text.contains(&format!("; radius {radius_mm:.0} mm")),
            "{text}"
        );
    }
    // Where none fits, the refusal of the smallest, in plain numbers.
    let scara = presets().iter().find(|preset| preset.name == "scara");
    let far = scara.unwrap().toml.replace("x_mm = 450.0", "x_mm = 680.0");
    let machine = Machine::from_toml("far.toml", &far).unwrap();
    let error = program(&machine, TestKind::Ballbar, &TestOptions::default()).unwrap_err();
    let error = error.to_string();
    assert!(
        error.contains("cannot reach X 699.134 mm, Y -46.194 mm, Z -150.000 mm: the arms reach"),
        "{error}"
    );
}

/// The lost motion of a simulated machine is its gap and the wind-up of its friction, and the axis
/// with less gain is behind.
#[test]
fn the_ballbar_of_a_simulated_machine_tells_its_gaps() {
    let quiet = |gap: [f64; 2]| {
        Machine::preset("bench3")
            .unwrap()
            .edit(|machine| {
                machine.axis("x").gap_um = gap[0];
                machine.axis("y").gap_um = gap[1];
            })
            .unwrap()
    };
    let told = |machine: &Machine| {
        let test = BallbarTest::new(machine, &TestOptions::default()).unwrap();
        let traces = simulate_ballbar(machine, &test).unwrap();
        assert!(traces[0].counterclockwise && !traces[1].counterclockwise);
        let found = sheet(&test.circle, &traces).unwrap();
        assert!(found.untold.is_empty(), "{:?}", found.untold);
        [0, 1].map(|axis| found.lost_motion_um[axis].unwrap().value)
    };
    let none = told(&quiet([0.0, 0.0]));
    for gap in [[20.0, 0.0], [0.0, 12.0], [30.0, 15.0]] {
        let found = told(&quiet(gap));
        for axis in 0..2 {
            // Without a gap the wind-up is left; with one it comes on top.
            let by_gap = found[axis] - none[axis];
            assert!(
                (by_gap - gap[axis]).abs() < 0.05 * gap[axis] + 0.3,
                "{gap:?}: {found:?} {none:?}"
            );
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_with_what_would() {
    let machine = Machine::preset("vmc3").unwrap();
    let refused = |kind, options: TestOptions, part: &str| {
        let error = program(&machine, kind, &options).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    let usual = TestOptions::default();
    refused(
        TestKind::Ballbar,
        TestOptions {
            radius_mm: Some(300.0),
            ..usual
        },
        "the largest has 162.4 mm",
    );
    refused(
        TestKind::Ballbar,
        TestOptions {
            feed_mm_min: Some(50_000.0),
            ..usual
        },
        "up to ",
    );
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(
            TestKind::Circle,
            TestOptions {
                radius_mm: Some(bad),
                ..usual
            },
            "radius",
        );
        refused(
            TestKind::Circle,
            TestOptions {
                feed_mm_min: Some(bad),
                ..usual
            },
            "mm/min",
        );
    }
    refused(
        TestKind::Friction,
        TestOptions {
            feed_mm_min: Some(500.0),
            ..usual
        },
        "`friction` has none",
    );
    refused(
        TestKind::Commission,
        options(Dialect::Fanuc),
        "LinuxCNC alone",
    );
}
