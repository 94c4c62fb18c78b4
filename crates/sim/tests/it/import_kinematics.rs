//! LinuxCNC's kinematics modules become machines that go where its manual says: against its
//! formulas, written here once more. FreeCAD's axes become chains.
use lostmotion_base::units::rad;
use lostmotion_base::{AxisId, Coords, math};
use lostmotion_kinematics::KinematicsSpec;
use lostmotion_sim::Machine;
use lostmotion_sim::import::{Fate, ImportFormat, ImportOptions, Imported, import};
use std::fmt::Write;

/// An INI file with so many joints, of which these turn; the numbers of others move.
fn ini(
    module: &str,
    coordinates: &str,
    joints: usize,
    turning: &[usize],
    pins: &[(&str, f64)],
) -> String {
    let mut text = format!(
        "[EMC]\nMACHINE = {module}\n[KINS]\nKINEMATICS = {module}\n[TRAJ]\nCOORDINATES = {coordinates}\n[HAL]\n"
    );
    let name = module.split(' ').next().unwrap();
    for (pin, value) in pins {
        let _ = writeln!(text, "HALCMD = setp {name}.{pin} {value:?}");
    }
    for joint in 0..joints {
        let (kind, most) = if turning.contains(&joint) {
            ("ANGULAR", 150)
        } else {
            ("LINEAR", 400)
        };
        let _ = writeln!(
            text,
            "[JOINT_{joint}]\nTYPE = {kind}\nMIN_LIMIT = -{most}\nMAX_LIMIT = {most}\nMAX_VELOCITY = {}\nMAX_ACCELERATION = 500\nMAX_JERK = 9000",
            joint + 30
        );
    }
    text
}

fn imported(text: &str) -> (Imported, Machine) {
    read(text, ImportFormat::LinuxCnc)
}

fn freecad(text: &str) -> (Imported, Machine) {
    read(text, ImportFormat::FreeCad)
}

fn read(text: &str, format: ImportFormat) -> (Imported, Machine) {
    let imported = import("machine.txt", text, format, &ImportOptions::new("vmc3"))
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    let machine = Machine::from_toml("imported.toml", &imported.toml)
        .unwrap_or_else(|error| panic!("{error}\n{}", imported.toml));
    (imported, machine)
}

fn filled<'a>(imported: &'a Imported, key: &str) -> Vec<&'a str> {
    imported
        .rows
        .iter()
        .filter(|row| row.fate == Fate::Filled && row.key == key)
        .map(|row| row.value.as_str())
        .collect()
}

/// Words that vary with k.
fn pose(k: i32) -> Coords {
    let mut words = Coords::xyz(
        f64::from(17 * k % 31),
        f64::from(-11 * k % 29),
        f64::from(7 * k % 23),
    );
    (words[AxisId::B], words[AxisId::C], words[AxisId::W]) = (
        rad(f64::from(13 * k % 80)),
        rad(f64::from(29 * k % 120)),
        f64::from(3 * k % 10),
    );
    words
}

fn joints(machine: &Machine, words: &Coords) -> Coords {
    machine
        .build_kinematics()
        .unwrap()
        .inverse(words, &[0.0; 3])
        .unwrap()
}

fn near(found: &Coords, meant: [f64; 3], what: &str) {
    let off = found
        .linear()
        .iter()
        .zip(meant)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(off < 1e-9, "{what}: {found:?} {meant:?}");
}

#[test]
fn bridge_mills_are_five_axis_kinematics() {
    for (pins, pivot) in [(&[("pivot-length", 180.0)][..], 180.0), (&[][..], 250.0)] {
        let (told, machine) = imported(&ini("5axiskins", "XYZBCW", 6, &[3, 4], pins));
        assert_eq!(
            filled(&told, "kinematics.joint.point_mm").len(),
            usize::from(pins.is_empty())
        );
        assert_eq!(
            machine.axis(AxisId::W).unwrap().limits.jerk.to_bits(),
            9000.0_f64.to_bits()
        );
        for k in -8..9 {
            let words = pose(k);
            let (l, f, c) = (
                pivot + words[AxisId::W],
                std::f64::consts::PI - words[AxisId::B],
                words[AxisId::C],
            );
            let meant = [
                words[AxisId::X] - l * math::sin(f) * math::cos(c),
                words[AxisId::Y] - l * math::sin(f) * math::sin(c),
                words[AxisId::Z] - l * math::cos(f) - pivot,
            ];
            near(&joints(&machine, &words), meant, "5axiskins");
        }
    }
}

#[test]
fn max_is_a_table_under_a_tilting_head() {
    for conventional in [0.0, 1.0] {
        let pins = [
            ("pivot-length", 120.0),
            ("conventional-directions", conventional),
        ];
        let text = ini("maxkins", "XYZBC", 9, &[3, 4, 5], &pins)
            .replace("-directions 0.0", "-directions 0")
            .replace("-directions 1.0", "-directions 1");
        let (told, machine) = imported(&text);
        // Joints 3, 6, 7 and 8 (A, U, V, W) have no place in it.
        assert_eq!(
            told.rows
                .iter()
                .filter(|row| row.key.starts_with("axis ") && row.fate == Fate::Ignored)
                .count(),
            4
        );
        assert!((machine.axis(AxisId::C).unwrap().limits.velocity - rad(35.0)).abs() < 1e-12);
        let sign = if conventional > 0.5 { 1.0 } else { -1.0 };
        for k in -8..9 {
            let mut words = pose(k);
            words[AxisId::W] = 0.0;
            let ((sin, cos), b) = (math::sin_cos(words[AxisId::C]), words[AxisId::B]);
            let [x, y, z] = words.linear();
            // Rz(-C) P: the table has turned the part.
            let meant = [
                cos * x + sin * y + sign * 120.0 * math::sin(b),
                cos * y - sin * x,
                z + 120.0 * math::cos(b) - 120.0,
            ];
            near(&joints(&machine, &words), meant, "maxkins");
        }
    }
}

#[test]
fn linear_deltas_have_joint_0_at_the_back() {
    let (told, machine) = imported(&ini(
        "lineardeltakins",
        "XYZ",
        3,
        &[],
        &[("R", 131.25), ("L", 269.0)],
    ));
    assert!(filled(&told, "kinematics.rod_mm").is_empty());
    for k in -8..9 {
        let words = Coords(std::array::from_fn(
            |i| if i < 3 { pose(k).0[i] } else { 0.0 },
        ));
        let [x, y, z] = words.linear();
        let height = |tower: usize| {
            let angle = rad(90.0 - 120.0 * tower as f64);
            let (dx, dy) = (x - 131.25 * math::cos(angle), y - 131.25 * math::sin(angle));
            z + (269.0_f64 * 269.0 - dx * dx - dy * dy).sqrt()
        };
        near(
            &joints(&machine, &words),
            [height(0), height(1), height(2)],
            "lineardeltakins",
        );
    }
    let (untold, _) = imported(&ini("lineardeltakins", "XYZ", 3, &[], &[]));
    assert_eq!(
        (
            filled(&untold, "kinematics.rod_mm").len(),
            filled(&untold, "kinematics.tower_radius_mm").len()
        ),
        (1, 1)
    );
}

#[test]
fn scaras_have_arms_by_their_pins_and_a_quill_turned_round() {
    let pins = [
        ("D1", 490.0),
        ("D2", 340.0),
        ("D3", 50.0),
        ("D4", 250.0),
        ("D5", 40.0),
        ("D6", 0.0),
    ];
    let text = ini("scarakins", "XYZC", 4, &[0, 1, 3], &pins).replace(
        "[JOINT_2]\nTYPE = LINEAR\nMIN_LIMIT = -400\nMAX_LIMIT = 400",
        "[JOINT_2]\nTYPE = LINEAR\nMIN_LIMIT = 100\nMAX_LIMIT = 400",
    );
    let (_, machine) = imported(&text);
    let kinematics = machine.build_kinematics().unwrap();
    let quill = machine.axis(AxisId::Z).unwrap().limits;
    // z = D1 + D3 - joint 2 - D5, from 500 - 400 to 500 - 100.
    assert!(
        (quill.min - 100.0).abs() < 1e-9 && (quill.max - 400.0).abs() < 1e-9,
        "{quill:?}"
    );
    assert!((machine.axis(AxisId::A).unwrap().limits.velocity - rad(30.0)).abs() < 1e-12);
    assert!((machine.axis(AxisId::B).unwrap().limits.velocity - rad(31.0)).abs() < 1e-12);
    for (a, b, c) in [(10.0, 40.0, -20.0), (-50.0, 90.0, 30.0), (80.0, 20.0, 0.0)] {
        let mut joints = Coords::ZERO;
        (
            joints[AxisId::A],
            joints[AxisId::B],
            joints[AxisId::C],
            joints[AxisId::Z],
        ) = (rad(a), rad(b), rad(c), 250.0);
        let words = kinematics.forward(&joints, &[0.0; 3]);
        let meant = [
            340.0 * math::cos(rad(a)) + 250.0 * math::cos(rad(a + b)),
            340.0 * math::sin(rad(a)) + 250.0 * math::sin(rad(a + b)),
            250.0,
        ];
        near(&words, meant, "scarakins");
        assert!((words[AxisId::C] - rad(a + b + c)).abs() < 1e-12);
    }
}

/// Frames by four-by-four matrices, as textbooks have them.
#[test]
fn serial_arms_follow_their_denavit_hartenberg_table() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let table = [
        [0.0, 0.0, 400.0],
        [25.0, -quarter, 0.0],
        [455.0, 0.0, 0.0],
        [35.0, -quarter, 420.0],
        [0.0, quarter, 0.0],
        [0.0, -quarter, 80.0],
    ];
    let mut pins: Vec<(String, f64)> = Vec::new();
    for (n, row) in table.iter().enumerate() {
        pins.extend(
            [("A", row[0]), ("ALPHA", row[1]), ("D", row[2])]
                .map(|(name, value)| (format!("{name}-{n}"), value)),
        );
    }
    let pins: Vec<(&str, f64)> = pins
        .iter()
        .map(|(name, value)| (name.as_str(), *value))
        .collect();
    let (_, machine) = imported(&ini("genserkins", "XYZABC", 6, &[0, 1, 2, 3, 4, 5], &pins));
    let kinematics = machine.build_kinematics().unwrap();
    type Frame = [[f64; 4]; 4];
    let times = |a: &Frame, b: &Frame| -> Frame {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
    };
    for k in 0..20 {
        let angles: [f64; 6] =
            std::array::from_fn(|i| 0.3 * f64::from((k * (i as i32 + 3)) % 7 - 3));
        let mut frame: Frame =
            std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
        for ([a, alpha, d], theta) in table.into_iter().zip(angles) {
            let ((sa, ca), (st, ct)) = (math::sin_cos(alpha), math::sin_cos(theta));
            let link = [
                [ct, -st, 0.0, a],
                [st * ca, ct * ca, -sa, -sa * d],
                [st * sa, ct * sa, ca, ca * d],
                [0.0, 0.0, 0.0, 1.0],
            ];
            frame = times(&frame, &link);
        }
        let joints = Coords(std::array::from_fn(|i| if i < 6 { angles[i] } else { 0.0 }));
        let pose = kinematics.tool_pose(&joints, &[0.0; 3]);
        for i in 0..3 {
            assert!(
                (pose.tip[i] - frame[i][3]).abs() < 1e-9
                    && (pose.axis[i] + frame[i][2]).abs() < 1e-12,
                "{pose:?} {frame:?}"
            );
        }
    }
    let less: Vec<(&str, f64)> = pins
        .iter()
        .filter(|(name, _)| *name != "D-3")
        .copied()
        .collect();
    let text = ini("genserkins", "XYZABC", 6, &[0, 1, 2, 3, 4, 5], &less);
    let refused = import(
        "arm.ini",
        &text,
        ImportFormat::LinuxCnc,
        &ImportOptions::new("vmc3"),
    )
    .unwrap_err()
    .to_string();
    assert!(
        refused.contains("arm.ini:4:1: genserkins.D-3: is not set in the INI file")
            && refused.contains("hint: an arm has A-0"),
        "{refused}"
    );
}

/// Tip and tool of the arm in Craig's book, in closed form.
#[test]
fn pumakins_is_the_arm_of_the_book() {
    let lengths = [
        ("A2", 431.8),
        ("A3", 20.3),
        ("D3", 125.4),
        ("D4", 431.8),
        ("D6", 56.2),
    ];
    let text = ini("pumakins", "XYZABC", 6, &[0, 1, 2, 3, 4, 5], &lengths);
    let (_, machine) = imported(&text);
    let kinematics = machine.build_kinematics().unwrap();
    let [a2, a3, d3, d4, d6] = lengths.map(|(_, mm)| mm);
    for k in 0..20 {
        let angles: [f64; 6] =
            std::array::from_fn(|i| 0.3 * f64::from((k * (i as i32 + 3)) % 7 - 3));
        let [(s1, c1), (s2, c2), (s23, c23), (s4, c4), (s5, c5)] = [
            angles[0],
            angles[1],
            angles[1] + angles[2],
            angles[3],
            angles[4],
        ]
        .map(math::sin_cos);
        let reach = a2 * c2 + a3 * c23 - d4 * s23;
        let level = c23 * c4 * s5 + s23 * c5;
        let out = [
            -c1 * level - s1 * s4 * s5,
            -s1 * level + c1 * s4 * s5,
            s23 * c4 * s5 - c23 * c5,
        ];
        let wrist = [
            c1 * reach - d3 * s1,
            s1 * reach + d3 * c1,
            -a3 * s23 - a2 * s2 - d4 * c23,
        ];
        let joints = Coords(std::array::from_fn(|i| if i < 6 { angles[i] } else { 0.0 }));
        let pose = kinematics.tool_pose(&joints, &[0.0; 3]);
        for i in 0..3 {
            assert!(
                (pose.tip[i] - wrist[i] - d6 * out[i]).abs() < 1e-9,
                "{pose:?}"
            );
            assert!((pose.axis[i] + out[i]).abs() < 1e-12, "{pose:?} {out:?}");
        }
    }
}

/// A table C on a cradle A, as FreeCAD 1.2 writes it: the chain of the preset trunnion5 in its home
/// position.
const TRUNNION: &str = r#"{
  "freecad_version": "1.2.0",
  "machine": {
    "name": "Five",
    "axes": {
      "A": {"joint": [[0, 0, -370], [1.0, 0.0, 0.0]], "limits": {"min": -110, "max": 110}, "max_velocity": 3600, "parent": "Y", "role": "table_rotary", "type": "angular"},
      "C": {"joint": [[0, 0, -420], [0.0, 0.0, 1.0]], "limits": {"min": -360, "max": 360}, "max_velocity": 7200, "parent": "A", "role": "table_rotary", "type": "angular"},
      "X": {"joint": [[1.0, 0.0, 0.0], [0, 0, 0]], "limits": {"min": -400, "max": 400}, "max_velocity": 12000, "parent": null, "role": "head_linear", "type": "linear"},
      "Y": {"joint": [[0, 0, 0], [0.0, 1.0, 0.0]], "limits": {"min": -250, "max": 250}, "max_velocity": 12000, "parent": null, "role": "table_linear", "type": "linear"},
      "Z": {"joint": [[0, 0, 0], [0.0, 0.0, 1.0]], "limits": {"min": -500, "max": 0}, "max_velocity": 12000, "parent": "X", "role": "head_linear", "type": "linear"}
    },
    "toolheads": [], "units": "metric"
  },
  "output": {"units": "metric"},
  "postprocessor": {"file_name": "fanuc"},
  "version": 1
}"#;

#[test]
fn freecad_machines_with_rotary_axes_are_chains() {
    let (imported, machine) = freecad(TRUNNION);
    let KinematicsSpec::Chain(chain) = machine.kinematics() else {
        panic!("{:?}", machine.kinematics());
    };
    let order: Vec<&str> = chain
        .joint
        .iter()
        .map(|joint| joint.axis.as_str())
        .collect();
    assert_eq!(order, ["c", "a", "y", "x", "z"]);
    assert_eq!(machine.dialect().name(), "fanuc");
    let (own, preset) = (
        machine.build_kinematics().unwrap(),
        Machine::preset("trunnion5")
            .unwrap()
            .build_kinematics()
            .unwrap(),
    );
    for k in 0..20 {
        let mut joints = Coords::xyz(f64::from(k % 7), f64::from(-k % 5), f64::from(-3 * k));
        (joints[AxisId::A], joints[AxisId::C]) =
            (0.08 * f64::from(k % 9 - 4), 0.3 * f64::from(k % 11 - 5));
        let (a, b) = (
            own.tool_pose(&joints, &[0.0, 0.0, 60.0]),
            preset.tool_pose(&joints, &[0.0, 0.0, 60.0]),
        );
        assert!(
            (0..3).all(
                |i| (a.tip[i] - b.tip[i]).abs() < 1e-9 && (a.axis[i] - b.axis[i]).abs() < 1e-12
            ),
            "{a:?} {b:?}"
        );
    }
    assert!(
        imported
            .rows
            .iter()
            .any(|row| row.key == "machine.axes.A.limits.min" && row.fate == Fate::Used)
    );
    // Joints by name, as FreeCAD's own files have them, say the same.
    let named = TRUNNION
        .replace("\"joint\": [[", "\"joint\": {\"origin\": [")
        .replace("], [", "], \"axis\": [")
        .replace("]]", "]}");
    assert!(named.contains("\"joint\": {\"origin\": [0, 0, -370], \"axis\": [1.0, 0.0, 0.0]}"));
    assert_eq!(freecad(&named).1, machine);
    let untold = TRUNNION.replace("\"parent\": \"A\"", "\"parent\": \"Y\"");
    let (imported, machine) = freecad(&untold);
    assert_eq!(machine.kinematics().kind(), "cartesian");
    assert!(
        imported.rows.iter().any(|row| row.key == "kinematics.kind"
            && row.note.contains("which of A and C carries the other")),
        "{:?}",
        imported.rows
    );
    let refused = |name: &str, text: &str, format| {
        import(name, text, format, &ImportOptions::new("vmc3"))
            .unwrap_err()
            .to_string()
    };
    let told = refused(
        "five.fcm",
        &TRUNNION.replace(
            "[[0, 0, -370], [1.0, 0.0, 0.0]]",
            "[[0, 0, -370], [0, 0, 0]]",
        ),
        ImportFormat::FreeCad,
    );
    assert!(
        told.contains(
            "five.fcm:6:1: machine.axes.A.joint: has no direction\n  hint: write [[0, 0, 50]"
        ),
        "{told}"
    );
    let told = refused(
        "five.fcm",
        &named.replace("\"axis\": [1.0, 0.0, 0.0]", "\"axes\": [1.0, 0.0, 0.0]"),
        ImportFormat::FreeCad,
    );
    assert!(
        told.contains("machine.axes.A.joint: is {") && told.contains("not two vectors"),
        "{told}"
    );
    let told = refused(
        "five.fcm",
        &TRUNNION.replace("\"min\": -500", "\"min\": 500"),
        ImportFormat::FreeCad,
    );
    let expected = "five.fcm:10:1: machine.axes.Z.limits.max: travel of Z from 500 (machine.axes.Z.limits.min) to 0\n  hint: the first";
    assert!(told.contains(expected), "{told}");
    let arm = ini("scarakins", "XYZC", 4, &[0, 1, 3], &[]).replacen(
        "MIN_LIMIT = -150\nMAX_LIMIT = 150",
        "MIN_LIMIT = 90\nMAX_LIMIT = -90",
        2,
    );
    let told = refused("arm.ini", &arm, ImportFormat::LinuxCnc);
    assert!(
        told.contains("[JOINT_1] MAX_LIMIT: travel of B from 90 ([JOINT_1] MIN_LIMIT) to -90"),
        "{told}"
    );
}
