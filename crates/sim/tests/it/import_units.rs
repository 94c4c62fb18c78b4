//! How a LinuxCNC machine counts: its units, those in which programs start, its joints, and what its
//! code at start says. Machines and figures are worked out by hand.

use lostmotion_base::AxisId;
use lostmotion_gcode::{CanonicalOp, Units};
use lostmotion_sim::control::Control;
use lostmotion_sim::import::{Fate, ImportFormat, ImportOptions, Imported, import};
use lostmotion_sim::recommend::{RecommendOptions, recommend};
use lostmotion_sim::rewrite::{RewriteOptions, rewrite};
use lostmotion_sim::{Machine, Program, SimulateOptions, Simulation, interpreter_config};

/// A router of inches with a motor on either side of its gantry, and a code at start.
fn router(units: &str, startup: &str) -> String {
    let (mm, mut text) = (
        if units == "inch" { 1.0 } else { 25.4 },
        format!(
            "[EMC]\nMACHINE = Router\n[KINS]\nKINEMATICS = trivkins coordinates=XYYZ kinstype=BOTH\nJOINTS = 4\n[TRAJ]\nCOORDINATES = XYYZ\nLINEAR_UNITS = {units}\n{startup}\n"
        ),
    );
    for (joint, backlash) in [0.002, 0.003, 0.003, 0.001].into_iter().enumerate() {
        let value = |inches: f64| inches * mm;
        text += &format!(
            "[JOINT_{joint}]\nMIN_LIMIT = {}\nMAX_LIMIT = {}\nMAX_VELOCITY = {}\nMAX_ACCELERATION = {}\nBACKLASH = {}\n",
            value(-10.0),
            value(10.0),
            value(4.0),
            value(40.0),
            value(backlash)
        );
    }
    text
}

fn format() -> ImportFormat {
    ImportFormat::recognise("router.ini", "[EMC]\n").unwrap()
}

fn read(text: &str) -> (Imported, Machine) {
    let options = ImportOptions::new("vmc3-worn");
    let imported = import("router.ini", text, format(), &options).unwrap();
    let machine = Machine::from_toml("router.toml", &imported.toml)
        .unwrap_or_else(|error| panic!("{error}\n{}", imported.toml));
    (imported, machine)
}

fn startup(code: &str) -> (Imported, Machine) {
    read(&router(
        "inch",
        &format!("[RS274NGC]\nRS274NGC_STARTUP_CODE = {code}"),
    ))
}

fn run(machine: &Machine, text: &str) -> (f64, f64) {
    let part = Program::from_str("part.ngc", text);
    let run = Simulation::new(&part, machine)
        .method("none")
        .run()
        .unwrap();
    (run.plan.duration_s, run.results[0].cutting.rms)
}

/// LinuxCNC's interpreter starts in the units of the machine, and the code at start comes after.
#[test]
fn programs_start_in_the_units_of_the_machine() {
    let of = |machine: &Machine| (machine.control_units(), machine.program_units());
    let (_, inch) = read(&router("inch", ""));
    assert_eq!(of(&inch), (Units::Inch, Units::Inch));
    let (_, mm) = read(&router("mm", ""));
    assert_eq!(of(&mm), (Units::Mm, Units::Mm));
    assert_eq!(of(&startup("G17 G21").1), (Units::Inch, Units::Mm));
    let code = "[RS274NGC]\nRS274NGC_STARTUP_CODE = G20";
    let (told, started) = read(&router("mm", code));
    assert_eq!(of(&started), (Units::Mm, Units::Inch));
    assert!(
        told.toml
            .contains("program_units = \"inch\" # [RS274NGC] RS274NGC_STARTUP_CODE")
    );
    // It is written and read again.
    let again = Machine::from_toml("again.toml", &inch.to_toml().unwrap()).unwrap();
    assert_eq!(again, inch);

    let part = "G17 G90 G64 P0.0002\nG0 X0.4 Y0\nG1 F30 X0.5\nG3 X0.5 Y0 I-0.5\nM2\n";
    let told = format!("G20\n{part}");
    assert_eq!(run(&inch, part), run(&inch, &told));
    assert_eq!(run(&started, part), run(&started, &told));
    assert_ne!(run(&inch, part), run(&inch, &format!("G21\n{part}")));
    // Rewritten programs stay in the units in which they started.
    let rewritten = |text: &str| {
        let text = text.replace("G3 X0.5 Y0 I-0.5\n", "X0.2\n");
        let part = Program::from_str("part.ngc", &text);
        let bare = inch.edit(|m| {
            for axis in ["x", "y", "z"] {
                m.axis(axis).compensation.method = "none".parse().unwrap();
            }
        });
        let wanted = RewriteOptions::default();
        rewrite(&part, &bare.unwrap(), &SimulateOptions::default(), &wanted).unwrap()
    };
    let (bare, told) = (rewritten(part), rewritten(&told));
    let lines = |text: &str| -> Vec<String> {
        let lines = text.lines().filter(|line| line.starts_with(['G', 'X']));
        lines
            .filter(|line| *line != "G20")
            .map(str::to_owned)
            .collect()
    };
    assert_eq!(lines(&bare.text), lines(&told.text));
    assert!((bare.shift_mm[0] - 0.5 * 0.0508).abs() < 1e-9);
}

/// Tools, offsets and homes are in the file in mm, and the same places for a control of either unit;
/// programs read them in the control's.
#[test]
fn tools_offsets_and_homes_are_the_same_places() {
    let mill = |units| {
        let preset = Machine::preset("vmc3-worn").unwrap();
        preset.edit(|m| {
            m.control_units = units;
            m.tool.clear();
            m.tool.push(lostmotion_sim::machine::ToolEntry {
                number: 1,
                length_mm: 50.8,
                diameter_mm: 12.7,
            });
        })
    };
    let ends = |machine: &Machine, text: &str| -> Vec<f64> {
        let part = Program::from_str("part.ngc", text);
        let config = interpreter_config(machine, &SimulateOptions::default());
        let mut operations = part.operations(config).unwrap();
        let mut ends = Vec::new();
        for op in operations.by_ref() {
            match op.op {
                CanonicalOp::StraightFeed(end) | CanonicalOp::StraightTraverse(end) => {
                    ends.extend(&end[..3]);
                }
                _ => {}
            }
        }
        assert_eq!(operations.diagnostics().errors(), 0);
        ends
    };
    let (mm, inch) = (mill(Units::Mm).unwrap(), mill(Units::Inch).unwrap());
    let text = "G21 G90 G17 T1 M6\nG43 H1\nG0 X0 Y0 Z0\nG41 D1\nG1 X10 F500\nY30\nG40 X0\nG28 Z0\nG55 X1\nM2\n";
    let (of_mm, of_inch) = (ends(&mm, text), ends(&inch, text));
    assert_eq!(of_mm.len(), of_inch.len());
    let pairs = of_mm.iter().zip(&of_inch);
    assert!(
        pairs.clone().all(|(a, b)| (a - b).abs() < 1e-9),
        "{of_mm:?}\n{of_inch:?}"
    );
    // The origin of G54 as a parameter.
    let origin = mm.work_offsets()[0][AxisId::X];
    let read = "G21 G90 G53 G0 X0\nG92 X0\nG0 X#5221\nM2\n";
    let [.., x, _, _] = ends(&inch, read)[..] else {
        panic!()
    };
    assert!((x - origin / 25.4).abs() < 1e-9, "{x} {origin}");
}

/// Of the code at start units and tolerance are carried, in whatever order; the rest is named.
#[test]
fn the_code_at_start() {
    let key = "[RS274NGC] RS274NGC_STARTUP_CODE";
    let rows = |told: &Imported| -> Vec<(Fate, String, String)> {
        let rows = told.rows.iter().filter(|row| row.key == key);
        rows.map(|row| (row.fate, row.value.clone(), row.note.clone()))
            .collect()
    };
    for (code, tolerance_mm) in [
        ("G64 P0.01 G21", 0.01),
        ("G21 G64 P0.01", 0.01),
        ("(metric) G21 (G20) G64P.01", 0.01),
        ("G64 P0.001 G20", 0.0254),
        ("G64 P0.001", 0.0254),
    ] {
        let (told, machine) = startup(code);
        let found = machine.planner().default_tolerance_mm;
        assert!((found - tolerance_mm).abs() < 1e-9, "{code}: {found}");
        assert_eq!(rows(&told).len(), 1, "{code}: {:?}", rows(&told));
        assert_eq!(rows(&told)[0].0, Fate::Used);
    }
    let (told, _) =
        startup("F10 S300 G20 G18 G40 G49 G54 G64 P0.001 G80 G90 G91.1 G92.1 G94 G97 G98");
    let found = rows(&told);
    assert_eq!(
        found[0].2,
        "units in which programs start, tolerance of G64"
    );
    assert_eq!(
        (found[1].0, found[1].1.as_str(), found[1].2.as_str()),
        (
            Fate::Ignored,
            "F10 S300 G18",
            "not carried: write it into the program"
        )
    );
    let (told, _) = startup("G17 G40 G90 M5");
    assert_eq!(rows(&told)[0].2, "programs start so anyway");
    // P0 is no tolerance.
    for code in ["G64", "G64 P0"] {
        let found = rows(&startup(code).0);
        assert!(found[0].2.contains("without a bound"), "{code}: {found:?}");
    }
    let both = router("mm", "[RS274NGC]\nRS274NGC_STARTUP_CODE = G20 G21");
    let error = import("router.ini", &both, format(), &ImportOptions::default()).unwrap_err();
    assert!(
        error.to_string().contains("has both G20 and G21"),
        "{error}"
    );
}

/// What is printed is set in the units of the INI file and at the joints that it numbers.
#[test]
fn settings_are_those_of_the_file_s_joints_and_units() {
    let part = "G90 G17 G64 P0.0002\nG0 X0.4 Y-0.1\nG1 F30 Y0\nG3 X0.4 Y0 I-0.4\nG1 Y0.1\nM2\n";
    let answer = |machine: &Machine, text: &str| {
        let part = Program::from_str("part.ngc", text);
        let options = SimulateOptions::default();
        recommend(
            &part,
            machine,
            &options,
            Control::LinuxCnc,
            &RecommendOptions::default(),
        )
        .unwrap()
    };
    let (told, inch) = read(&router("inch", ""));
    assert!(told.toml.contains("joint_axes = \"XYYZ\""), "{}", told.toml);
    let found = answer(&inch, part);
    assert!(found.refused.is_none(), "{:?}", found.refused);
    let sections: Vec<&str> = found
        .paste
        .iter()
        .filter(|line| line.starts_with('['))
        .map(String::as_str)
        .collect();
    assert_eq!(
        sections,
        [
            "[JOINT_0]    # X, inch",
            "[JOINT_1]    # Y, inch",
            "[JOINT_2]    # Y, inch",
            "[JOINT_3]    # Z, inch"
        ]
    );
    let values: Vec<f64> = found
        .settings
        .iter()
        .map(|setting| setting.value.parse().unwrap())
        .collect();
    // The gap, and up to 20 um of wind-up.
    for (value, gap) in values.iter().zip([0.002, 0.003, 0.003, 0.001]) {
        assert!((0.0..0.0008).contains(&(value - gap)), "{values:?}");
    }
    assert_eq!(values[1], values[2]);
    assert!(found.settings.iter().all(|setting| setting.unit == "inch"));
    let needs = found.preconditions.join("\n");
    assert!(needs.contains("LINEAR_UNITS = inch"), "{needs}");
    // 1.5 times 40 inch/s2 and 4 inch/s.
    assert!(needs.contains("of 60.0 to 80.0 inch/s2"), "{needs}");
    assert!(needs.contains("STEPGEN_MAXVEL of 6.0 inch/s"), "{needs}");
    assert!(found.notes.iter().any(|note| note.contains("as XYYZ")));
    // The description has one motor for both joints of Y.
    let one_gap = |note: &&String| note.starts_with("Y: more than one joint moves it");
    assert_eq!(found.notes.iter().filter(one_gap).count(), 1);
    // Both joints of Y need the same, which is said once.
    assert_eq!(needs.matches("Y: with stepgen").count(), 1);

    // The same machine described in mm.
    let (_, mm) = read(&router("mm", ""));
    let same = answer(&mm, &format!("G20\n{part}"));
    for (inches, setting) in values.iter().zip(&same.settings) {
        let mm: f64 = setting.value.parse().unwrap();
        assert!((mm - 25.4 * inches).abs() < 4e-4, "{mm} {inches}");
        assert_eq!(setting.unit, "mm");
    }
    assert_eq!(same.settings[3].name, "[JOINT_3]BACKLASH");
}

/// LinuxCNC reads names in any case, and units per mm or degree; what it refuses is refused.
#[test]
fn units_are_read_as_linuxcnc_reads_them() {
    let text = |linear: &str| router(linear, "");
    for (linear, mm) in [
        ("mm", 101.6),
        ("Metric", 101.6),
        ("1.0", 101.6),
        ("INCH", 2580.64),
        ("In", 2580.64),
        ("imperial", 2580.64),
        ("0.03937007874", 2580.64),
    ] {
        // The helper counts everything but `inch` in mm.
        let (_, machine) = read(&text(linear));
        let velocity = machine
            .axis(AxisId::X)
            .unwrap()
            .limits_table()
            .limits()
            .velocity;
        assert!((velocity - mm).abs() < 1e-9 * mm, "{linear}: {velocity}");
    }
    for wrong in ["Inches", "25.4", "cm", "furlong", ""] {
        let options = ImportOptions::new("vmc3-worn");
        let error = import("router.ini", &text(wrong), format(), &options).unwrap_err();
        let said = error.to_string();
        assert!(
            said.contains("router.ini:8:1: [TRAJ] LINEAR_UNITS: is "),
            "{said}"
        );
    }
    let degrees = |name: &str| {
        let (_, machine) = read(&format!(
            "[EMC]\nMACHINE = Table\n[TRAJ]\nCOORDINATES = XA\nANGULAR_UNITS = {name}\n[JOINT_0]\nMAX_VELOCITY = 50\n[JOINT_1]\nTYPE = ANGULAR\nMAX_VELOCITY = 0.5\n"
        ));
        machine
            .axis(AxisId::A)
            .unwrap()
            .limits_table()
            .limits()
            .velocity
            .to_degrees()
    };
    assert!((degrees("Deg") - 0.5).abs() < 1e-9);
    assert!(
        (degrees("RAD") - 28.6479).abs() < 1e-3 && (degrees("0.01745329") - 28.6479).abs() < 1e-3
    );
}

/// Joints of no axis are counted, a second motor that is described has its own gap, and letters that are
/// no axis are refused.
#[test]
fn joints_are_counted_as_the_file_numbers_them() {
    let vmc3 = Machine::preset("vmc3-worn").unwrap();
    let set = |letters: &str| vmc3.edit(|m| m.joint_axes = Some(letters.to_owned()));
    let joints = set("X-YZ").unwrap().joint_axes();
    let (x, y, z) = (Some(AxisId::X), Some(AxisId::Y), Some(AxisId::Z));
    assert_eq!(joints, [x, None, y, z]);
    assert_eq!(vmc3.joint_axes(), [x, y, z]);
    for (letters, says) in [
        ("XY", "without a joint of axis Z"),
        ("XYZA", "the machine has no axis `A`"),
        ("XYZ?", "the machine has no axis `?`"),
        ("XYZ--------------", "17 joints, more than 16"),
    ] {
        let error = set(letters).unwrap_err();
        assert_eq!(error.problems[0].key, "joint_axes");
        assert!(error.to_string().contains(says), "{error}");
    }
}

/// LinuxCNC does not use BACKLASH beside a table of the same joint.
#[test]
fn a_table_counts_before_backlash() {
    let text = router("inch", "").replace(
        "BACKLASH = 0.002\n",
        "BACKLASH = 0.002\nCOMP_FILE = screw.comp\nCOMP_FILE_TYPE = 1\n",
    );
    // The second joint of Y has a gap of its own by its table.
    let text = text.replacen(
        "[JOINT_3]",
        "COMP_FILE = screw.comp\nCOMP_FILE_TYPE = 1\n[JOINT_3]",
        1,
    );
    // Set by HAL it is passed over, too.
    let text = format!("{text}[HAL]\nHALCMD = setp ini.0.backlash 0.004\n");
    let files = |_: &str| Ok("-1 0.001 0\n0 0.001 0\n1 0.001 0\n".to_owned());
    let options = ImportOptions {
        files: &files,
        ..ImportOptions::new("vmc3-worn")
    };
    let told = import("router.ini", &text, format(), &options).unwrap();
    let machine = Machine::from_toml("router.toml", &told.toml).unwrap();
    let gap = |id| machine.axis(id).unwrap().config.gap_in_unit();
    assert!((gap(AxisId::X) - 0.0254).abs() < 1e-9);
    assert!((gap(AxisId::Y) - 0.0762).abs() < 1e-9);
    let row = |key: &str| told.rows.iter().find(|row| row.key == key).unwrap();
    assert_eq!(row("[JOINT_0] BACKLASH").fate, Fate::Ignored);
    let notes: Vec<&str> = told.rows.iter().map(|row| row.note.as_str()).collect();
    let beside = "LinuxCNC does not use it beside a COMP_FILE";
    // That of HAL, and of the second joint of Y.
    assert_eq!(notes.iter().filter(|note| **note == beside).count(), 2);
    assert_eq!(row("[JOINT_0] COMP_FILE").fate, Fate::Used);
    assert_eq!(row("[JOINT_1] BACKLASH").fate, Fate::Used);
    assert_eq!(row("[JOINT_2] COMP_FILE").fate, Fate::Used);
    let second = &machine.gantry().unwrap().second;
    assert!((second.gap_in_unit() - 0.0254).abs() < 1e-9);
}
