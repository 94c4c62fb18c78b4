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
        "x.comp" | "tool.tbl" => Ok(table.to_owned()),
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
