//! Values of imported files that are odd, half told or of another kind than usual: each is used, told as a
//! guess, told as ignored with the reason, or refused with its line.
use crate::import_controls::{fate, read, read_with, refused};
use lostmotion_base::AxisId;
use lostmotion_sim::Machine;
use lostmotion_sim::import::{Fate, ImportOptions, Imported};
use lostmotion_sim::machine::MachineAxis;

/// What the report says of a key, last row first.
fn note(told: &Imported, key: &str) -> String {
    let mut rows = told.rows.iter();
    let row = rows.rfind(|row| row.key == key);
    row.unwrap_or_else(|| panic!("{key} of {:?}", told.rows))
        .note
        .clone()
}

fn axis(machine: &Machine, id: AxisId) -> &MachineAxis {
    machine.axis(id).unwrap()
}

/// A LinuxCNC file of one axis with more lines, and what of the files it names.
fn linuxcnc(more: &str, table: &str) -> Result<(Imported, Machine), String> {
    let text = format!(
        "[EMC]\nMACHINE = m\n[KINS]\nKINEMATICS = trivkins coordinates=X\n[EMCIO]\nTOOL_TABLE = tool.tbl\n[JOINT_0]\nMIN_LIMIT = -100\nMAX_LIMIT = 100\nMAX_VELOCITY = 50\nMAX_ACCELERATION = 500\n{more}\n"
    );
    let files = |name: &str| match name {
        "x.comp" => Ok(table.to_owned()),
        "tool.tbl" if table.starts_with('T') => Ok(table.to_owned()),
        _ => Err("no such file".to_owned()),
    };
    let options = ImportOptions {
        files: &files,
        ..ImportOptions::default()
    };
    read_with("m.ini", &text, &options)
}

/// A table of trims is forward less backward, one of places backward less forward (LinuxCNC, control.c).
#[test]
fn the_gap_of_a_screw_s_table_has_a_sign() {
    let key = "[JOINT_0] COMP_FILE";
    let table = "-10 0.01 -0.01\n0 0.015 -0.015\n10 0.02 -0.02\n";
    let trims = "COMP_FILE = x.comp\nCOMP_FILE_TYPE = 1";
    let (told, machine) = linuxcnc(trims, table).unwrap();
    assert_eq!(fate(&told, key), Fate::Used);
    assert!((axis(&machine, AxisId::X).config.gap_in_unit() - 0.03).abs() < 1e-9);
    // The same machine by the places where it stands.
    let places = "-10 -10.01 -9.99\n0 -0.015 0.015\n10 9.98 10.02\n";
    for kind in ["", "COMP_FILE_TYPE = 0"] {
        let (_, machine) = linuxcnc(&format!("COMP_FILE = x.comp\n{kind}"), places).unwrap();
        assert!((axis(&machine, AxisId::X).config.gap_in_unit() - 0.03).abs() < 1e-9);
    }
    // The columns exchanged: a gap below 0 is none of the machine's.
    let (told, _) = linuxcnc(trims, "-10 -0.01 0.01\n10 -0.02 0.02\n").unwrap();
    assert_eq!(fate(&told, key), Fate::Ignored);
    assert!(
        note(&told, key).contains("negative"),
        "{}",
        note(&told, key)
    );
}

#[test]
fn a_line_that_ends_a_screw_s_table_is_told() {
    let trims = "COMP_FILE = x.comp\nCOMP_FILE_TYPE = 1";
    let (told, machine) = linuxcnc(trims, "0 0.01 -0.01 # zero\n5 O.02 -0.02\n9 1 -1\n\n").unwrap();
    let rows = told.rows.iter().filter(|row| row.fate == Fate::Ignored);
    let notes: Vec<&str> = rows.map(|row| row.note.as_str()).collect();
    assert!(
        notes.contains(&"line 2 of x.comp: not three numbers; LinuxCNC reads no further, which leaves 2 lines out: mend it"),
        "{notes:?}"
    );
    assert!((axis(&machine, AxisId::X).config.gap_in_unit() - 0.02).abs() < 1e-9);
    // Blank lines at the end are none.
    let (told, _) = linuxcnc(trims, "0 0.01 -0.01\n\n").unwrap();
    assert!(!told.rows.iter().any(|row| row.note.contains("no further")));
}

/// Every stepper that is guessed is sound: motors of 1.8 and 0.9 degrees, on screws and belts.
#[test]
fn steppers_of_all_steps_and_travels_are_sound() {
    let microsteps = [1, 2, 4, 8, 16, 32, 64, 128, 256];
    let travels = [
        1.0, 2.0, 4.0, 5.0, 8.0, 16.0, 20.0, 32.0, 40.0, 60.0, 72.0, 80.0,
    ];
    for (full, current, servo_us) in [
        (200, "", 125.0),
        (400, "", 62.5),
        (400, "0.6", 125.0),
        (200, "6", 125.0),
        (400, "1.8", 62.5),
    ] {
        for (at, travels) in travels.chunks(3).enumerate() {
            let mut text =
                "[printer]\nkinematics: cartesian\nmax_velocity: 200\nmax_accel: 3000\n".to_owned();
            for (index, (letter, travel)) in ['x', 'y', 'z'].iter().zip(travels).enumerate() {
                let micro = microsteps[(2 * at + index) % microsteps.len()];
                text += &format!(
                    "[stepper_{letter}]\nmicrosteps: {micro}\nfull_steps_per_rotation: {full}\nrotation_distance: {travel}\nposition_max: 200\n"
                );
                if !current.is_empty() {
                    text += &format!("[tmc2209 stepper_{letter}]\nrun_current: {current}\n");
                }
            }
            // Reading refuses a loop that is not sound.
            let (_, machine) = read("printer.cfg", &text);
            assert!(
                (machine.cycles().servo_us - servo_us).abs() < 1e-9,
                "{full} {current}"
            );
        }
    }
}

#[test]
fn a_further_motor_that_differs_is_told() {
    let printer = "[printer]\nkinematics: cartesian\nmax_velocity: 200\nmax_accel: 3000\n[stepper_x]\nmicrosteps: 16\nrotation_distance: 40\nposition_max: 200\n[stepper_y]\nmicrosteps: 16\nrotation_distance: 40\nposition_max: 200\n[stepper_z]\nmicrosteps: 16\nrotation_distance: 8\nposition_max: 200\n[stepper_z1]\nmicrosteps: 16\nrotation_distance: 4\n[tmc2209 stepper_z]\nrun_current: 0.8\n[tmc2209 stepper_z1]\nrun_current: 0.6\n";
    let (told, _) = read("printer.cfg", printer);
    assert_eq!(
        note(&told, "[stepper_z1] rotation_distance"),
        "a further motor of the axis, which differs from the first ([stepper_z] rotation_distance = 8): both are taken as that"
    );
    assert!(note(&told, "[stepper_z1] microsteps").contains("taken to be like the first"));
    assert!(note(&told, "[tmc2209 stepper_z1] run_current").contains("run_current = 0.8"));
    let fluid = "axes:\n  z:\n    steps_per_mm: 400\n    max_rate_mm_per_min: 1000\n    acceleration_mm_per_sec2: 100\n    max_travel_mm: 100\n    motor0:\n      tmc_2209:\n        microsteps: 16\n        run_amps: 1.0\n    motor1:\n      tmc_2208:\n        microsteps: 8\n        run_amps: 1.0\n";
    let (told, _) = read("c.yaml", fluid);
    assert!(
        note(&told, "axes.z.motor1.tmc_2208.microsteps")
            .contains("(axes.z.motor0.tmc_2209.microsteps = 16)")
    );
    assert!(note(&told, "axes.z.motor1.tmc_2208.run_amps").contains("taken to be like the first"));
    let hybrid = printer.replace("kinematics: cartesian", "kinematics: hybrid_corexy");
    let error = refused("printer.cfg", &hybrid);
    assert!(!error.contains("delta"), "{error}");
}

/// LinuxCNC reads the number in front of a comment.
#[test]
fn linuxcnc_numbers_stand_before_comments() {
    let text = "[KINS]\nKINEMATICS = trivkins coordinates=X\n[TRAJ]\nLINEAR_UNITS = 1.0 ; mm\n[JOINT_0]\nMIN_LIMIT = -100\nMAX_LIMIT = 100 ; mm\nMAX_VELOCITY = 40 # mm per s\nMAX_ACCELERATION = 500\nBACKLASH = 0.02# measured\nSTEPGEN_MAXACCEL = 1000 # room\nSTEP_SCALE = 400 # steps\n";
    let (_, machine) = read("m.ini", text);
    let x = axis(&machine, AxisId::X);
    assert_eq!((x.limits.max, x.limits.velocity), (100.0, 40.0));
    assert!((x.config.gap_in_unit() - 0.02).abs() < 1e-9);
    // Another sign behind it is no comment.
    let error = refused("m.ini", &text.replace("= 40 #", "= 40,5 #"));
    assert!(
        error.contains("m.ini:8:1: [JOINT_0] MAX_VELOCITY: `40,5` is not a number"),
        "{error}"
    );
}

/// The control counts the pulses of a stepper, which follow exactly: of lost steps it sees nothing.
#[test]
fn the_following_error_of_a_stepper_is_not_that_of_its_rotor() {
    let (told, machine) = linuxcnc(
        "STEP_SCALE = 400\nSTEPGEN_MAXACCEL = 1000\nFERROR = 0.2\nMIN_FERROR = 0.05",
        "",
    )
    .unwrap();
    for key in ["[JOINT_0] FERROR", "[JOINT_0] MIN_FERROR"] {
        assert_eq!(fate(&told, key), Fate::Ignored);
        assert!(
            note(&told, key).contains("loses a step"),
            "{}",
            note(&told, key)
        );
    }
    // A full step of 8 mm a turn.
    let limits = axis(&machine, AxisId::X).monitor_limits();
    assert!((limits.following.unwrap().at(0.0) - 0.04).abs() < 1e-9);
    // Of a servo they count.
    let (told, _) = linuxcnc("FERROR = 0.2", "").unwrap();
    assert_eq!(fate(&told, "[JOINT_0] FERROR"), Fate::Used);
}

#[test]
fn what_a_tool_table_has_besides_length_and_diameter_is_told() {
    let table = "T1 P1 X1.5 Y0 Z10 D6\nT2 P2 Z20 D-8\nT1 P3 Z12 D6\n";
    let (told, machine) = linuxcnc("", table).unwrap();
    let of = |tool: &str| -> Vec<String> {
        let key = format!("[EMCIO] TOOL_TABLE {tool}");
        let rows = told.rows.iter().filter(|row| row.key == key);
        rows.map(|row| format!("{}: {}", row.value, row.note))
            .collect()
    };
    assert_eq!(
        of("T1"),
        [
            "X1.5: not carried: a tool has a length and a diameter here",
            "before: given again in line 3 of tool.tbl, which counts",
        ]
    );
    assert!(of("T2")[0].starts_with("D-8: its sign"), "{:?}", of("T2"));
    assert_eq!(machine.tools().len(), 2);
    assert_eq!(
        machine
            .tools()
            .iter()
            .map(|tool| tool.diameter_mm)
            .fold(0.0, f64::max),
        8.0
    );
}

#[test]
fn a_negative_gap_is_not_taken_and_told() {
    let (told, machine) = linuxcnc("BACKLASH = -0.05", "").unwrap();
    assert_eq!(fate(&told, "[JOINT_0] BACKLASH"), Fate::Ignored);
    assert!(note(&told, "[JOINT_0] BACKLASH").contains("the load leads"));
    assert_eq!(
        axis(&machine, AxisId::X).config.compensation.method.name(),
        "none"
    );
    let (told, machine) = read("hal.txt", &format!("{GRBL}$160=-0.05\n"));
    assert_eq!(fate(&told, "$160"), Fate::Ignored);
    assert_eq!(
        axis(&machine, AxisId::X).config.compensation.method.name(),
        "none"
    );
}

const GRBL: &str = "$100=250\n$101=250\n$102=250\n$110=1500\n$111=1200\n$112=500\n$120=30\n$121=20\n$122=10\n$130=200\n$131=150.5\n$132=80\n";

/// Of a travel with one end the other lies as far away as that of the machine that lends.
#[test]
fn the_other_end_of_a_travel_goes_by_the_one_that_is_told() {
    let vmc3 = Machine::preset("vmc3").unwrap();
    let lent = axis(&vmc3, AxisId::X).limits;
    let length = lent.max - lent.min;
    let archive = "N10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\nN32000 $MA_MAX_AX_VELO[AX1]=30000\nN36100 $MA_POS_LIMIT_MINUS[0,AX1]=5\n";
    for (line, min) in [("MINUS[0,AX1]=5", 5.0), ("PLUS[0,AX1]=5", 5.0 - length)] {
        let (told, machine) = read("nc.arc", &archive.replace("MINUS[0,AX1]=5", line));
        let limits = axis(&machine, AxisId::X).limits;
        assert!((limits.min - min).abs() < 1e-9 && (limits.max - min - length).abs() < 1e-9);
        let lent = if min == 5.0 { "max" } else { "min" };
        assert_eq!(
            fate(&told, &format!("axis.x.limits.{lent}_mm")),
            Fate::Guessed
        );
    }
}

#[test]
fn velocities_of_a_sinumerik_that_are_none_are_refused() {
    let archive = "N10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\nN30300 $MA_IS_ROT_AX[AX1]='H0'\nN32000 $MA_MAX_AX_VELO[AX1]=30000 '2f\n";
    for (value, says) in [
        ("nan", "`nan` is not a number"),
        ("-5", "is -5; it has to be above 0"),
        ("0", "is 0; it has to be above 0"),
        ("'H0'", "is 0; it has to be above 0"),
    ] {
        let error = refused("nc.arc", &archive.replace("30000 '2f", value));
        let says = format!("nc.arc:3:1: $MA_MAX_AX_VELO[AX1]: {says}");
        assert!(error.contains(&says), "{error}");
    }
    // Hexadecimal and binary values, and a check sum behind a value.
    for value in ["30000 '2f", "'H7530'", "'B111010100110000' '2f"] {
        let (_, machine) = read("nc.arc", &archive.replace("30000 '2f", value));
        assert_eq!(axis(&machine, AxisId::X).limits.velocity, 500.0);
    }
}

const FLUIDNC: &str = "axes:\n  x:\n    steps_per_mm: 400\n    homing:\n      positive_direction: false\n  y:\n    max_rate_mm_per_min: 6000\n";

/// What a file leaves out, FluidNC runs with its own.
#[test]
fn fluidnc_runs_with_its_own_defaults() {
    let (told, machine) = read("c.yaml", FLUIDNC);
    let (x, y) = (
        axis(&machine, AxisId::X).limits,
        axis(&machine, AxisId::Y).limits,
    );
    assert!((x.velocity - 1000.0 / 60.0).abs() < 1e-9 && (y.velocity - 100.0).abs() < 1e-9);
    assert_eq!(
        (x.acceleration, x.min, x.max, y.min, y.max),
        (25.0, 0.0, 1000.0, -1000.0, 0.0)
    );
    for key in [
        "axes.x.max_rate_mm_per_min",
        "axes.y.steps_per_mm",
        "axes.y.homing.mpos_mm",
    ] {
        assert_eq!(fate(&told, key), Fate::Filled, "{key}");
    }
    // The file is whole, though its axes end it.
    assert!(
        !told
            .rows
            .iter()
            .any(|row| row.note.contains("whole?") && row.key == "axes")
    );
    let (told, _) = read("c.yaml", &format!("{FLUIDNC}    homing:\n"));
    assert!(note(&told, "axes").contains("is it whole?"));
    let error = refused("c.yaml", &FLUIDNC.replace("    max_rate", "\tmax_rate"));
    assert!(
        error.contains("c.yaml:7:1: ") && error.contains("a tab, which YAML forbids"),
        "{error}"
    );
}

#[test]
fn what_an_answer_of_grbl_lacks_is_a_guess_of_its_defaults() {
    let lacking = GRBL
        .replace("$111=1200\n", "")
        .replace("$121=20\n", "")
        .replace("$131=150.5\n", "");
    let (told, machine) = read("dump.txt", &lacking);
    let y = axis(&machine, AxisId::Y).limits;
    assert!((y.velocity - 500.0 / 60.0).abs() < 1e-9);
    assert_eq!((y.acceleration, y.min, y.max), (10.0, -200.0, 0.0));
    for key in ["$111", "$121", "$131"] {
        assert_eq!(fate(&told, key), Fate::Guessed);
    }
    // A machine that is named lends them.
    let named = ImportOptions::new("vmc3");
    let (_, machine) = read_with("dump.txt", &lacking, &named).unwrap();
    assert!(axis(&machine, AxisId::Y).limits.velocity > 100.0);
}

/// A gap wider than half a mm is mostly a unit that was mistaken: it is told, in every format.
#[test]
fn an_unlikely_gap_is_told() {
    let (told, _) = linuxcnc("BACKLASH = 1.5", "").unwrap();
    let said = note(&told, "[JOINT_0] BACKLASH");
    assert!(said.contains("a gap of 1.5 mm is unlikely"), "{said}");
    let (told, _) = read("hal.txt", &format!("{GRBL}$160=0.9\n"));
    assert!(note(&told, "$160").contains("a gap of 0.9 mm is unlikely"));
    let (told, _) = linuxcnc("BACKLASH = 0.3", "").unwrap();
    assert_eq!(fate(&told, "[JOINT_0] BACKLASH"), Fate::Used);
}
