//! Descriptions whose lines depend on conditions, that are two files, or in which two axes have one
//! name; and marks before texts.

use crate::import_controls::{fate, near, read, read_with, refused};
use lostmotion_base::AxisId;
use lostmotion_sim::Machine;
use lostmotion_sim::import::{Fate, ImportOptions, Imported};

/// A header with a travel that is worked out; what is put in stands before its end.
fn header(more: &str) -> String {
    format!(
        "#define X_BED_SIZE 200\n#define X_MIN_POS -10\n#define X_MAX_POS (X_BED_SIZE + X_MIN_POS)\n#define DEFAULT_AXIS_STEPS_PER_UNIT {{ 80, 80, 400, 93 }}\n#define DEFAULT_MAX_FEEDRATE {{ 300, 300, 5, 25 }}\n#define DEFAULT_MAX_ACCELERATION {{ 500, 500, 100, 5000 }}\n{more}"
    )
}

fn velocity(machine: &Machine) -> f64 {
    machine.axis(AxisId::X).unwrap().limits.velocity
}

fn note<'a>(told: &'a Imported, key: &str) -> &'a str {
    let mut rows = told.rows.iter().filter(|row| row.key == key);
    &rows.next_back().unwrap_or_else(|| panic!("{key}")).note
}

/// The compensation that a stock header has switched off.
const BACKLASH: &str = "#if ENABLED(BACKLASH_COMPENSATION)\n  #define BACKLASH_DISTANCE_MM { 0.15, 0.2, 0 }\n  #define BACKLASH_CORRECTION 0.5\n#endif\n";

#[test]
fn marlin_conditions_that_are_not_met() {
    let off = header(&format!("//#define BACKLASH_COMPENSATION\n{BACKLASH}"));
    let (told, machine) = read("Configuration.h", &off);
    let x = machine.axis(AxisId::X).unwrap();
    assert!(x.config.compensation.method.is_baseline());
    assert!(!near(x.config.gap_in_unit(), 0.15));
    assert_eq!((x.limits.min, x.limits.max), (-10.0, 190.0));
    for key in ["BACKLASH_DISTANCE_MM", "BACKLASH_CORRECTION"] {
        assert_eq!(fate(&told, key), Fate::Ignored);
        let said = note(&told, key);
        assert!(said.contains("`ENABLED(BACKLASH_COMPENSATION)` (line 8) is not met"));
    }
    let on = header(&format!("#define BACKLASH_COMPENSATION\n{BACKLASH}"));
    let (_, machine) = read("Configuration.h", &on);
    let x = machine.axis(AxisId::X).unwrap();
    assert!(near(x.config.gap_in_unit(), 0.15));
    assert_eq!(x.config.compensation.method.name(), "fixed-by-travel");
    // A gap alone: the control does nothing about it.
    let alone = header("#define BACKLASH_DISTANCE_MM { 0.15, 0.2, 0 }\n");
    let (told, machine) = read("Configuration.h", &alone);
    let x = machine.axis(AxisId::X).unwrap();
    assert!(near(x.config.gap_in_unit(), 0.15));
    assert!(x.config.compensation.method.is_baseline());
    assert_eq!(fate(&told, "BACKLASH_COMPENSATION"), Fate::Ignored);
}

#[test]
fn marlin_conditions_are_those_of_c() {
    let feed = |condition: &str| {
        header(&format!(
            "#define ON\n#define OFF 0\n#define THREE 3\n#define CHAIN THREE\n{condition}\n#define DEFAULT_MAX_FEEDRATE {{ 7, 7, 7 }}\n#endif\n"
        ))
    };
    let met = [
        "#if 1",
        "#ifdef ON",
        "#ifndef NOT_THERE",
        "#if defined(ON) && !defined NOT_THERE",
        "#if ANY(NOT_THERE, ON) && ALL(ON) && NONE(OFF, NOT_THERE)",
        "#if EITHER(OFF, ON) && DISABLED(OFF)",
        "#if THREE > 2 && (CHAIN == 3 || 0)",
        "#if ENABLED(ON) || MB(SOME_BOARD)",
        "#if 0\n#elif THREE <= \\\n 3",
        "#if ENABLED(OFF)\n#else",
        "#if /* 0 */ 1 // 0",
    ];
    for condition in met {
        let (_, machine) = read("m.h", &feed(condition));
        assert_eq!(velocity(&machine), 7.0, "{condition}");
    }
    let not_met = [
        "#if 0",
        "#ifdef NOT_THERE",
        "#ifndef ON",
        "#if BOTH(ON, OFF)",
        "#if THREE != 3 || CHAIN < 3",
        "#if DISABLED(ON) && MB(SOME_BOARD)",
        "#if 1\n#elif 1",
        "#if 0\n#if 1\n#endif\n#elif 0",
    ];
    for condition in not_met {
        let (told, machine) = read("m.h", &feed(condition));
        assert_eq!(velocity(&machine), 300.0, "{condition}");
        assert!(note(&told, "DEFAULT_MAX_FEEDRATE").contains("is not met"));
    }
    // Only the board, or Marlin, knows.
    let unknown = [
        "#if MB(SOME_BOARD)",
        "#if HAS_SOMETHING",
        "#if ENABLED(ON) && HAS_SOMETHING",
        "#if NOT_THERE > 3",
        "#if MB(SOME_BOARD)\n#else",
        "#if MB(A)\n#define B\n#endif\n#ifdef B",
    ];
    for condition in unknown {
        let (told, machine) = read("m.h", &feed(condition));
        assert_eq!(velocity(&machine), 300.0, "{condition}");
        let said = note(&told, "DEFAULT_MAX_FEEDRATE");
        assert!(said.contains("cannot be told from the file"), "{said}");
    }
    // A value that such a condition decides.
    let board =
        "#if MB(A)\n#define SIZE 100\n#else\n#define SIZE 300\n#endif\n#define Z_MAX_POS SIZE\n";
    let (told, _) = read("m.h", &header(board));
    assert_eq!(fate(&told, "Z_MAX_POS"), Fate::Ignored);
    // Drivers of Trinamic have their current; others do not.
    let driver = |kind: &str| {
        header(&format!(
            "#define X_DRIVER_TYPE {kind}\n#if HAS_TRINAMIC_CONFIG || HAS_TMC26X\n#if AXIS_IS_TMC_CONFIG(X)\n#define X_CURRENT 800\n#endif\n#endif\n"
        ))
    };
    let (told, _) = read("m.h", &driver("TMC2209"));
    assert_eq!(fate(&told, "X_CURRENT"), Fate::Used);
    let (told, _) = read("m.h", &driver("A4988"));
    assert_eq!(fate(&told, "X_CURRENT"), Fate::Ignored);
}

#[test]
fn marlin_conditions_that_do_not_hold_together() {
    let deep = "#if 1\n".repeat(65) + &"#endif\n".repeat(65);
    for (more, said) in [
        ("#if 1\n", "m.h:7:1: #if: does not end"),
        ("#endif\n", "m.h:7:1: #endif: there is no #if before it"),
        ("#else\n", "m.h:7:1: #else: there is no #if before it"),
        (
            "#if 1\n#else\n#else\n#endif\n",
            "m.h:9:1: #else: there is an #else before it",
        ),
        (deep.as_str(), "conditions nest more than 64 deep"),
    ] {
        let bad = refused("m.h", &header(more));
        assert!(bad.contains(said), "{bad}");
    }
}

#[test]
fn marlin_has_two_headers() {
    let first = header("#define X_DRIVER_TYPE TMC2209\n");
    let second = format!(
        "#define CONFIGURATION_ADV_H_VERSION 02010200\n#define BACKLASH_COMPENSATION\n{BACKLASH}#if AXIS_IS_TMC_CONFIG(X)\n#define X_CURRENT 800\n#endif\n"
    );
    let files = |name: &str| match name {
        "Configuration_adv.h" => Ok(second.clone()),
        _ => Err("there is no such file".to_owned()),
    };
    let options = ImportOptions {
        files: &files,
        ..ImportOptions::default()
    };
    let (told, machine) = read_with("some/Configuration.h", &first, &options).unwrap();
    let x = machine.axis(AxisId::X).unwrap();
    assert!(near(x.config.gap_in_unit(), 0.15));
    assert_eq!(x.config.compensation.method.name(), "fixed-by-travel");
    let key = "X_CURRENT (line 8 of Configuration_adv.h)";
    assert_eq!(fate(&told, key), Fate::Used);
    assert_eq!(fate(&told, "Configuration_adv.h"), Fate::Used);
    // Without it, and of a header of another name.
    let (told, _) = read("Configuration.h", &first);
    assert_eq!(fate(&told, "Configuration_adv.h"), Fate::Ignored);
    let (told, _) = read_with("m.h", &first, &options).unwrap();
    assert!(told.rows.iter().all(|row| row.key != "Configuration_adv.h"));
    let bad = refused("Configuration_adv.h", &second);
    assert!(
        bad.contains("without its Configuration.h") && bad.contains("hint: import"),
        "{bad}"
    );
    let cut = |_: &str| Ok("#define A\n#if 1\n".to_owned());
    let options = ImportOptions {
        files: &cut,
        ..ImportOptions::default()
    };
    let bad = read_with("Configuration.h", &first, &options).unwrap_err();
    assert!(bad.contains("does not end (line 2 of Configuration_adv.h)"));
}

const DUET: &str = "M584 X0 Y1 Z2\nM92 X80 Y80 Z400\nM208 X0:200 Y0:200 Z0:100\nM203 X6000 Y6000 Z600\nM201 X400 Y400 Z100\n";

#[test]
fn duet_conditions() {
    let with = |more: &str| read("config.g", &format!("{DUET}{more}"));
    let (told, machine) =
        with("if {exists(global.a)}\n\tM203 X60\n\n  ; word\n  M98 P\"x.g\"\nM201 Y300\n");
    assert_eq!(velocity(&machine), 100.0);
    assert_eq!(fate(&told, "line 7"), Fate::Ignored);
    assert_eq!(note(&told, "line 7"), "depends on the condition in line 6");
    assert_eq!(fate(&told, "line 10"), Fate::Ignored);
    assert_eq!(machine.axis(AxisId::Y).unwrap().limits.acceleration, 300.0);
    for (more, velocity_mm_s) in [
        ("if true\n  M203 X60\nelse\n  M203 X120\n", 1.0),
        ("if {false}\n  M203 X60\nelse\n  M203 X120\n", 2.0),
        (
            "if false\n  M203 X60\nelif true\n  M203 X120\nelse\n  M203 X180\n",
            2.0,
        ),
        (
            "if global.a\n  M203 X60\nelif true\n  M203 X120\nelse\n  M203 X180\n",
            100.0,
        ),
        ("if true\n  if global.a\n    M203 X60\n  M203 X120\n", 2.0),
        ("while iterations < 3\n  M203 X60\n", 100.0),
        ("while false\n  M203 X60\nM203 X120\n", 2.0),
    ] {
        assert_eq!(velocity(&with(more).1), velocity_mm_s, "{more}");
    }
}

#[test]
fn a_duet_file_that_calls_itself_is_refused() {
    let text = format!("{DUET}M98 P\"config.g\"\nM98 P\"config.g\"\n");
    let files = |_: &str| Ok(text.clone());
    let options = ImportOptions {
        files: &files,
        ..ImportOptions::default()
    };
    let bad = read_with("config.g", &text, &options).unwrap_err();
    assert!(
        bad.contains("config.g:6:1: M98: files call each other") && bad.contains("call itself?"),
        "{bad}"
    );
    assert_eq!(bad.matches("files call each other").count(), 1);
}

/// As 30i and 31i punch them out.
const FANUC: &str = "%\nN01001Q1L1P00000000\nN01006Q1A1P00000000A2P00000000\nN01013Q1A1P00000010A2P00000010\nN01020Q1A1P88A2P89\nN01320Q1A1M250.0A2I10.0\nN01321Q1A1M-250.0A2I-10.0\nN01420Q1A1M24000.0A2I100.0\nN01620Q1A1P100A2P100\nN01851Q1A1P8A2P6\nN01851Q0A1P9\nN01001Q1L2P00000001\nN24000Q1T1P1002\nN03716Q1S1M5.0\nN05555Q1X?\n%\n";

#[test]
fn fanuc_values_with_their_unit() {
    let (told, machine) = read("p.txt", FANUC);
    let axis = |id| machine.axis(id).unwrap().limits;
    let (x, y) = (axis(AxisId::X), axis(AxisId::Y));
    assert_eq!((x.min, x.max, x.velocity), (-250.0, 250.0, 400.0));
    assert!(near(y.min, -254.0) && near(y.max, 254.0));
    assert!(near(y.velocity, 100.0 * 25.4 / 60.0));
    for (key, why) in [
        ("line 11", "pitch error"),
        ("line 12", "another path"),
        ("line 13", "machine group"),
        ("line 15", "of no axis"),
    ] {
        assert_eq!(fate(&told, key), Fate::Ignored);
        assert!(note(&told, key).contains(why), "{key}");
    }
    let bad = refused(
        "p.txt",
        &FANUC.replace("N01420Q1A1M24000.0", "N01420Q1A1W24000.0"),
    );
    assert!(
        bad.contains("p.txt:8:1:") && bad.contains("is no parameter"),
        "{bad}"
    );
}

#[test]
fn fanuc_axes_of_one_name_are_refused() {
    let twice = FANUC.replace("A1P88A2P89", "A1P88A2P88");
    let bad = refused("p.txt", &twice);
    assert!(
        bad.contains("p.txt:5:1: N1020: A1 and A2 are both named X"),
        "{bad}"
    );
    // One that follows the other may have its name.
    let follows = twice.replace("N01851Q1A1", "N08311Q1A1P0A2P1\nN01851Q1A1");
    let (_, machine) = read("p.txt", &follows);
    assert_eq!(machine.axes().len(), 1);
}

#[test]
fn twincat_axes_of_one_letter_are_not_blended() {
    let axis = |name: &str, velocity: u32| {
        format!(
            "<Axis><Name>{name}</Name><AxisPara><Velo Maximum=\"{velocity}\"/></AxisPara></Axis>"
        )
    };
    let text = format!(
        "<TcSmProject><NC>{}{}</NC></TcSmProject>",
        axis("X-Axis", 500),
        axis("X2", 450)
    );
    let (told, machine) = read("m.tsproj", &text);
    assert_eq!(velocity(&machine), 500.0);
    assert_eq!(fate(&told, "Axis X2"), Fate::Ignored);
    assert!(note(&told, "Axis X2").contains("X is `X-Axis` already"));
}

/// Editors of Windows put a mark before a text, which is none of its first line.
#[test]
fn a_mark_before_a_text_is_none_of_it() {
    let ini = "[TRAJ]\nLINEAR_UNITS = inch\nCOORDINATES = X\n[KINS]\nKINEMATICS = trivkins coordinates=X\nJOINTS = 1\n[JOINT_0]\nTYPE = LINEAR\nMAX_VELOCITY = 2\nMAX_ACCELERATION = 20\nMIN_LIMIT = 0\nMAX_LIMIT = 10\n";
    let (_, plain) = read("m.ini", ini);
    let (_, marked) = read("m.ini", &format!("\u{feff}{ini}"));
    assert!(near(velocity(&plain), 50.8));
    assert_eq!(velocity(&marked), velocity(&plain));
    let (_, machine) = read("p.txt", &format!("\u{feff}{FANUC}"));
    assert_eq!(velocity(&machine), 400.0);
    let printer =
        "[include x.cfg]\n[printer]\nkinematics: cartesian\nmax_velocity: 250\nmax_accel: 2000\n";
    let files = |_: &str| {
        Ok(
            "\u{feff}[stepper_x]\nmicrosteps: 16\nrotation_distance: 40\nposition_max: 235\n"
                .to_owned(),
        )
    };
    let options = ImportOptions {
        files: &files,
        ..ImportOptions::default()
    };
    let (_, machine) = read_with("printer.cfg", printer, &options).unwrap();
    assert_eq!(machine.axis(AxisId::X).unwrap().limits.max, 235.0);
}
