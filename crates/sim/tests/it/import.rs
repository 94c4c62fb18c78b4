//! Descriptions of other programs become machine files that hold together, and bad ones say where
//! they are bad.
use lostmotion_base::units::rad;
use lostmotion_base::{AxisId, Coords};
use lostmotion_kinematics::KinematicsSpec;
use lostmotion_sim::control::Control;
use lostmotion_sim::import::{Fate, ImportFormat, ImportOptions, Imported, import};
use lostmotion_sim::recommend::{RecommendOptions, recommend};
use lostmotion_sim::rewrite::{RewriteOptions, rewrite};
use lostmotion_sim::{Machine, Program, SimulateOptions};

fn imported(name: &str, text: &str) -> (Imported, Machine) {
    let format = ImportFormat::recognise(name, text).unwrap();
    let imported = import(name, text, format, &ImportOptions::new("vmc3"))
        .unwrap_or_else(|error| panic!("{error}"));
    let machine = Machine::from_toml("imported.toml", &imported.toml)
        .unwrap_or_else(|error| panic!("{error}\n{}", imported.toml));
    (imported, machine)
}

fn refused(name: &str, text: &str) -> String {
    let format = ImportFormat::recognise(name, text).unwrap();
    import(name, text, format, &ImportOptions::new("vmc3"))
        .unwrap_err()
        .to_string()
}

const GRBL: &str = "$0=10\n$13=0\n$100=250.000 (x, step/mm)\n$101=250.000\n$102=250.000\n$110=1500.000 (x rate, mm/min)\n$111=1200\n$112=500.000\n$120=30.000\n$121=20\n$122=10.000\n$130=200.000\n$131=150.5\n$132=80\nok\n";

#[test]
fn grbl_settings() {
    let (imported, machine) = imported("dump.txt", GRBL);
    let limits = |axis| machine.axis(axis).unwrap().limits;
    assert_eq!(
        (limits(AxisId::X).velocity, limits(AxisId::Y).velocity),
        (25.0, 20.0)
    );
    assert_eq!(
        (
            limits(AxisId::Y).min,
            limits(AxisId::Y).max,
            limits(AxisId::Z).acceleration
        ),
        (-150.5, 0.0, 10.0)
    );
    let fate = |key: &str| {
        imported
            .rows
            .iter()
            .find(|row| row.key == key)
            .unwrap()
            .fate
    };
    assert_eq!(
        (
            fate("$110"),
            fate("$100"),
            fate("$0"),
            fate("axis.x.limits.jerk_mm_s3")
        ),
        (Fate::Used, Fate::Ignored, Fate::Ignored, Fate::Filled)
    );
    assert!(
        imported.toml.contains("velocity_mm_s = 25.0 # $110")
            && imported.toml.contains("# preset vmc3:x")
    );
    let bad = refused("dump.txt", "$110=fast\n$120=0\n");
    assert!(
        bad.contains("dump.txt:1:1: $110: `fast` is not a number")
            && bad.contains("dump.txt:2:1: $120: is 0; it has to be above 0"),
        "{bad}"
    );
}

/// The last of two counts, as on the machine; the one before it is told.
/// A gap that nobody told is not set, nor is a program rewritten for it.
#[test]
fn a_gap_that_is_a_guess_is_known_to_be_one() {
    // No machine is named that lends its gap.
    let usual = |name, text| {
        let format = ImportFormat::recognise(name, text).unwrap();
        let told = import(name, text, format, &ImportOptions::default()).unwrap();
        let machine = Machine::from_toml("imported.toml", &told.toml).unwrap();
        (told, machine)
    };
    let (told, machine) = usual("dump.txt", GRBL);
    let key = "axis.x.compensation.gap_uncertainty";
    assert!(
        told.rows
            .iter()
            .any(|row| row.key == key && row.fate == Fate::Guessed)
    );
    let part = Program::from_str("arc.ngc", "G21 G90\nG1 X9 Y-9 F600\nG3 X9 Y-9 I-2 J0\nM2\n");
    let options = SimulateOptions::default();
    let new = rewrite(&part, &machine, &options, &RewriteOptions::default()).unwrap();
    let reason = new.refused.unwrap();
    assert!(
        reason.contains("(that of X) is as good as unknown"),
        "{reason}"
    );
    let answer = recommend(
        &part,
        &machine,
        &options,
        Control::GrblHal,
        &RecommendOptions::default(),
    );
    let answer = answer.unwrap();
    assert_eq!(answer.gap_uncertainty, Some(0.9));
    let first = &answer.preconditions[0];
    assert!(
        first.contains("off by X 90 %, Y 90 %, Z 90 %): measure them"),
        "{first}"
    );
    // One that is told is what the control believes.
    let ini = "[KINS]\nKINEMATICS = trivkins coordinates=X\nJOINTS = 1\n[TRAJ]\nCOORDINATES = X\nLINEAR_UNITS = mm\n[JOINT_0]\nTYPE = LINEAR\nMAX_VELOCITY = 50\nMAX_ACCELERATION = 500\nBACKLASH = 0.02\nMIN_LIMIT = 0\nMAX_LIMIT = 300\n";
    let (_, machine) = usual("m.ini", ini);
    let x = &machine.axis(AxisId::X).unwrap().config;
    assert_eq!(x.compensation.gap_uncertainty, 0.0);
}

#[test]
fn a_grbl_setting_that_is_given_twice_is_told() {
    let text = GRBL.replace("$112=", "$110=3000\n$112=");
    let (imported, machine) = imported("dump.txt", &text);
    assert_eq!(machine.axis(AxisId::X).unwrap().limits.velocity, 50.0);
    let rows: Vec<_> = imported
        .rows
        .iter()
        .filter(|row| row.key == "$110")
        .collect();
    assert_eq!(rows.len(), 2);
    assert_eq!(
        (rows[0].fate, rows[0].value.as_str()),
        (Fate::Ignored, "1500.000")
    );
    assert_eq!(rows[0].note, "line 6: given again in line 8, which counts");
    assert_eq!((rows[1].fate, rows[1].value.as_str()), (Fate::Used, "3000"));
}

/// grblHAL: gaps, and an origin at the switches, of which X's and Z's are at the lower end.
#[test]
fn grblhal_settings() {
    let more =
        "> $$\n[VER:1.1f.20240330:]\n$22=9\n$23=5\n$11=0.01\n$160=0.025\n$161=0\n$150=16\n$341=0\n";
    let (imported, machine) = imported("hal.txt", &format!("{more}{GRBL}"));
    let axis = |axis| machine.axis(axis).unwrap();
    let travel = |id| (axis(id).limits.min, axis(id).limits.max);
    assert_eq!(
        (travel(AxisId::X), travel(AxisId::Y), travel(AxisId::Z)),
        ((0.0, 200.0), (-150.5, 0.0), (0.0, 80.0))
    );
    assert!(
        (axis(AxisId::X).config.gap_in_unit() - 0.025).abs() < 1e-12
            // Nothing is compensated on Y: what gap it has is not told.
            && axis(AxisId::Y).config.gap_in_unit() > 0.0
    );
    let row = |key: &str| imported.rows.iter().find(|row| row.key == key).unwrap();
    assert_eq!(
        (row("$22").fate, row("$160").fate, row("$150").fate),
        (Fate::Used, Fate::Used, Fate::Ignored)
    );
    assert!(row("$11").note.contains("corners"));
    // Without the bit, switches say nothing of the coordinates.
    let (_, machine) = self::imported("hal.txt", &format!("$22=1\n$23=5\n{GRBL}"));
    assert_eq!(machine.axis(AxisId::X).unwrap().limits.max, 0.0);
    let bad = refused("hal.txt", "$110=600\n$160=O.1\n$130=1e999\n$120\n");
    assert!(
        bad.contains("hal.txt:2:1: $160: `O.1` is not a number")
            && bad.contains("hal.txt:3:1: $130: `1e999` is not a number")
            && bad.contains("hal.txt:4:1: $120: has no value"),
        "{bad}"
    );
}

/// What $140 and $160 mean, firmware has in its own ways: what may be a backlash is told.
#[test]
fn grbl_settings_that_may_be_a_backlash_are_told() {
    let row = |more: &str, key: &str| {
        let (imported, machine) = imported("dump.txt", &format!("{GRBL}{more}"));
        let mut rows = imported.rows.iter();
        let row = rows.find(|row| row.key == key).unwrap().clone();
        let x = machine.axis(AxisId::X).unwrap();
        (row.fate, row.note, x.config.compensation.method.name())
    };
    for (more, says) in [
        ("$140=0.05\n", "if it is backlash"),
        ("$140=0.05 (X-axis backlash)\n", "backlash, not carried"),
        ("$140=500 (x current, mA)\n", "of the motor's driver"),
    ] {
        let (fate, note, method) = row(more, "$140");
        assert_eq!((fate, method), (Fate::Ignored, "none"), "{more}");
        assert!(note.contains(says), "{more}{note}");
    }
    // Microsteps are no gap of 16 mm.
    let (fate, note, method) = row("$160=16\n", "$160");
    assert_eq!((fate, method), (Fate::Ignored, "none"));
    assert!(note.contains("microsteps"), "{note}");
    for more in [
        "$160=0.050\n",
        "$160=1.000\n",
        "$160=1 (X-axis backlash, mm)\n",
    ] {
        let (fate, _, method) = row(more, "$160");
        assert_eq!((fate, method), (Fate::Used, "fixed"), "{more}");
    }
}

const INI: &str = "[EMC]\nMACHINE = Bench Mill\n[KINS]\nKINEMATICS = trivkins coordinates=XYZA\nJOINTS = 4\n[TRAJ]\nCOORDINATES = X Y Z A\nLINEAR_UNITS = inch\nANGULAR_UNITS = degree\n[AXIS_X]\nMAX_VELOCITY = 9.0\n[JOINT_0]\nTYPE = LINEAR\nMIN_LIMIT = -10\nMAX_LIMIT = 10\nMAX_VELOCITY = 2.0\nMAX_ACCELERATION = 30.0\nBACKLASH = 0.001\nFERROR = 0.05\n[JOINT_1]\nMIN_LIMIT = 0.5\nMAX_LIMIT = 8\nMAX_VELOCITY = 2.0\n[JOINT_2]\nMIN_LIMIT = -4\nMAX_LIMIT = 0\n[JOINT_3]\nTYPE = ANGULAR\nMAX_VELOCITY = 30\nMIN_LIMIT = -360\nMAX_LIMIT = 360\nBACKLASH = 0.02\n";

#[test]
fn linuxcnc_ini() {
    let (imported, machine) = imported("mill.ini", INI);
    assert_eq!(machine.name(), "Bench Mill");
    let x = machine.axis(AxisId::X).unwrap();
    assert!(
        (x.limits.max - 254.0).abs() < 1e-9
            && (x.limits.velocity - 50.8).abs() < 1e-9
            && (x.limits.acceleration - 762.0).abs() < 1e-9
    );
    assert!(
        (x.config.gap_in_unit() - 0.0254).abs() < 1e-9,
        "{}",
        x.config.gap_in_unit()
    );
    let a = machine.axis(AxisId::A).unwrap();
    assert!(
        (a.limits.velocity - rad(30.0)).abs() < 1e-9
            && (a.config.gap_in_unit() - 0.02).abs() < 1e-9
    );
    // Zero lies outside Y's travel: offset and homes are put into it.
    assert!((machine.start()[AxisId::Y] - 4.25 * 25.4).abs() < 1e-6);
    assert!(imported.rows.iter().any(|row| {
        row.key == "[AXIS_X] MAX_VELOCITY"
            && row.fate == Fate::Ignored
            && row.note == "axis X: [JOINT_0] MAX_VELOCITY counts"
    }));
    assert!(
        imported
            .rows
            .iter()
            .any(|row| row.key == "[JOINT_0] FERROR" && row.fate == Fate::Used)
    );
    // 0.05 inch at any speed: there is no MIN_FERROR.
    let following = x.monitor_limits().following.unwrap();
    assert!(
        [0.0, 50.8]
            .map(|v| following.at(v))
            .iter()
            .all(|limit| (limit - 1.27).abs() < 1e-9),
        "{following:?}"
    );
    let bad = refused(
        "mill.ini",
        "[KINS]\nKINEMATICS = genhexkins\n[JOINT_0]\nMAX_VELOCITY = 2 m/s\nMAX_VELOCITY 50\n",
    );
    assert!(
        bad.contains(":2:1: KINS.KINEMATICS: `genhexkins` is not known here\n  hint: ")
            && bad.contains(":4:1: [JOINT_0] MAX_VELOCITY: `2 m/s` is not a number")
            && bad.contains("mill.ini:5:1: `MAX_VELOCITY 50` is neither a section nor KEY = VALUE"),
        "{bad}"
    );
    assert!(refused("mill.ini", "[JOINT_0]\nMIN_LIMIT = 5\nMAX_LIMIT = 1\n").contains("travel"));
}

/// G-code has to keep what the axis may do and what its joint may do.
#[test]
fn of_an_axis_and_its_joint_the_tighter_limit_counts() {
    let axis =
        "[AXIS_X]\nMAX_VELOCITY = 1.5\nMAX_ACCELERATION = 90\nMIN_LIMIT = -8\nMAX_LIMIT = 12\n";
    let text = INI.replacen("[AXIS_X]\nMAX_VELOCITY = 9.0\n", axis, 1);
    let (_, machine) = imported("mill.ini", &text);
    let limits = machine.axis(AxisId::X).unwrap().limits;
    let inch = [limits.velocity, limits.acceleration, limits.min, limits.max]
        .map(|value| (value / 25.4 * 1e9).round() / 1e9);
    assert_eq!(inch, [1.5, 30.0, -8.0, 10.0]);
    // The order of the sections does not matter, and of two motors on an axis the wider gap counts.
    let gantry = "[KINS]\nKINEMATICS = trivkins coordinates=XYYZ\n[JOINT_1]\nBACKLASH = 0.04\nMAX_VELOCITY = 40\n[JOINT_2]\nBACKLASH = 0.01\nMAX_VELOCITY = 60\n[AXIS_Y]\nMAX_VELOCITY = 30\n";
    let (_, machine) = imported("router.ini", gantry);
    let y = machine.axis(AxisId::Y).unwrap();
    assert_eq!(y.limits.velocity, 30.0);
    assert!((y.config.gap_in_unit() - 0.04).abs() < 1e-12);
}

#[test]
fn included_files_are_read_in_their_line_s_place() {
    let files = |name: &str| match name {
        "axes.inc" => Ok("#INCLUDE x.inc\n[JOINT_1]\nMAX_VELOCITY = 20\n".to_owned()),
        "x.inc" => Ok("[JOINT_0]\nMAX_VELOCITY = \\\n 30\n".to_owned()),
        "bad.inc" => Ok("[JOINT_0]\nMAX_VELOCITY = fast\n".to_owned()),
        "open.inc" => Ok("\n[JOINT_0\n".to_owned()),
        "ring.inc" => Ok("#INCLUDE ring.inc\n".to_owned()),
        "heavy.inc" => Ok("# \n".repeat(1 << 20)),
        "core.hal" => Ok(
            "loadrt trivkins\nsetp pumakins.A2 [ARM](UPPER)\nsetp pumakins.D6 = 12 # hand\n"
                .to_owned(),
        ),
        _ => Err("no such file".to_owned()),
    };
    let options = ImportOptions {
        files: &files,
        ..ImportOptions::new("vmc3")
    };
    let read = |text: &str| import("mill.ini", text, ImportFormat::LinuxCnc, &options);
    let found = read("#INCLUDE axes.inc\n#INCLUDE gone.inc\nwords that mean nothing\n").unwrap();
    let machine = Machine::from_toml("mill.toml", &found.toml).unwrap();
    let speed = |axis| machine.axis(axis).unwrap().limits.velocity;
    assert_eq!((speed(AxisId::X), speed(AxisId::Y)), (30.0, 20.0));
    let note = |value: &str| {
        let row = found.rows.iter().find(|row| row.value == value).unwrap();
        (row.fate, row.note.as_str())
    };
    assert_eq!(note("x.inc"), (Fate::Used, "read in its place"));
    assert_eq!(note("gone.inc").0, Fate::Ignored);
    assert!(note("gone.inc").1.starts_with("not read (no such file)"));
    assert!(note("words that mean nothing").1.contains("passes over it"));
    for (text, told) in [
        (
            "\n#INCLUDE bad.inc\n",
            "mill.ini:2:1: [JOINT_0] MAX_VELOCITY: `fast` is not a number",
        ),
        (
            "#INCLUDE open.inc\n",
            "the section's name is not closed (line 2 of open.inc)",
        ),
        ("#INCLUDE ring.inc\n", "more than 16 deep"),
        (
            "#INCLUDE heavy.inc\n#INCLUDE heavy.inc\n",
            "more than 4194304 bytes",
        ),
        (
            "#INCLUDE gone.inc\n",
            "a file that it includes was not read: is it there?",
        ),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(told), "{text}: {error}");
    }
    // Pins of the kinematics stand in HAL files as well.
    let arm = "[KINS]\nKINEMATICS = pumakins\n[HAL]\nHALFILE = core.hal\n[ARM]\nUPPER = 250\n[JOINT_0]\nMAX_VELOCITY = 30\n";
    let found = read(arm).unwrap();
    let value = |key: &str| &found.rows.iter().find(|row| row.key == key).unwrap().value;
    assert_eq!(value("[HAL] setp pumakins.A2"), "250");
    assert_eq!(value("[HAL] setp pumakins.D6"), "12");
}

#[test]
fn freecad_machines() {
    let text = r#"{
  "machine": {
    "name": "Router", "units": "metric",
    "axes": {
      "X": {"type": "linear", "min": 0, "max": 1000, "max_velocity": 12000},
      "Y": {"type": "linear", "min": 0, "max": 600, "max_velocity": 6000},
      "Z": {"type": "linear", "min": -100, "max": 0, "max_velocity": 3000},
      "A": {"type": "angular", "min": -180, "max": 180, "max_velocity": 3600, "prefer_positive": true}
    },
    "spindles": []
  }
}"#;
    let (imported, machine) = imported("router.fcm", text);
    assert_eq!(machine.name(), "Router");
    assert!((machine.axis(AxisId::X).unwrap().limits.velocity - 200.0).abs() < 1e-9);
    assert!((machine.axis(AxisId::A).unwrap().limits.velocity - rad(60.0)).abs() < 1e-9);
    assert!(
        imported
            .rows
            .iter()
            .any(|row| row.key == "machine.spindles" && row.fate == Fate::Ignored)
    );
    assert!(refused("router.fcm", "{\n\"machine\": \n").contains("not JSON"));
    assert!(
        refused(
            "router.fcm",
            "{\"machine\": {\"axes\": {\"X\": {\"max_velocity\": -1}}}}"
        )
        .contains("machine.axes.X.max_velocity: is -1")
    );
}

fn arm() -> String {
    let joint = |index: usize, xyz: &str, axis: &str| {
        format!(
            "<joint name=\"joint_{index}\" type=\"revolute\"><origin xyz=\"{xyz}\" rpy=\"0 0 0\"/><parent link=\"l{}\"/><child link=\"l{index}\"/><axis xyz=\"{axis}\"/>\n<limit lower=\"-2.9\" upper=\"2.9\" velocity=\"1.5\" effort=\"100\"/></joint>\n",
            index - 1
        )
    };
    let joints = [
        ("0 0 0", "0 0 1"),
        ("0.15 0 0.45", "0 1 0"),
        ("0 0 0.6", "0 1 0"),
        ("0 0 0.13", "1 0 0"),
        ("0.64 0 0", "0 1 0"),
        ("0 0 0", "1 0 0"),
    ];
    let joints: String = joints
        .iter()
        .enumerate()
        .map(|(i, (xyz, axis))| joint(i + 1, xyz, axis))
        .collect();
    format!(
        "<robot name=\"arm\">\n<link name=\"l0\"/>\n{joints}<joint name=\"flange\" type=\"fixed\"><origin xyz=\"0.08 0 0\" rpy=\"0 1.5707963267948966 0\"/><parent link=\"l6\"/><child link=\"tool0\"/></joint>\n</robot>\n"
    )
}

#[test]
fn urdf_arms_are_the_preset_s() {
    let (imported, machine) = imported("arm.urdf", &arm());
    let (own, preset) = (
        machine.build_kinematics().unwrap(),
        Machine::preset("arm6").unwrap().build_kinematics().unwrap(),
    );
    // The same arm as the preset arm6, described by somebody else: the same tip and axis for any
    // joints.
    for k in 0..50 {
        let joints = Coords(std::array::from_fn(|i| {
            if i < 6 {
                0.4 * f64::from((k * (i as i32 + 3)) % 7 - 3)
            } else {
                0.0
            }
        }));
        let (a, b) = (
            own.tool_pose(&joints, &[0.0, 0.0, 50.0]),
            preset.tool_pose(&joints, &[0.0, 0.0, 50.0]),
        );
        assert!(
            (0..3).all(
                |i| (a.tip[i] - b.tip[i]).abs() < 1e-9 && (a.axis[i] - b.axis[i]).abs() < 1e-12
            ),
            "{a:?} {b:?}"
        );
    }
    assert!((machine.axis(AxisId::Z).unwrap().limits.velocity - 1.5).abs() < 1e-9);
    assert!(
        imported
            .rows
            .iter()
            .any(|row| row.key == "joint joint_1 limit effort" && row.fate == Fate::Ignored)
    );
    assert!(refused("arm.urdf", "<robot><joint").contains("not XML"));
    let reversed = refused(
        "arm.urdf",
        &arm().replacen(
            "lower=\"-2.9\" upper=\"2.9\"",
            "lower=\"2.9\" upper=\"1\"",
            1,
        ),
    );
    assert!(
        reversed.contains("arm.urdf:3:1: joint joint_1 limit upper: travel of X from 166"),
        "{reversed}"
    );
    assert!(refused("arm.urdf", &" ".repeat(5 << 20)).contains("has 5242880 bytes"));
    assert!(
        refused(
            "arm.urdf",
            &arm().replace("axis xyz=\"0 0 1\"", "axis xyz=\"0 0\"")
        )
        .contains("arm.urdf:3:")
    );
    // a word that is no number is not left out of the three
    assert!(
        refused(
            "arm.urdf",
            &arm().replace("axis xyz=\"0 0 1\"", "axis xyz=\"0 x 0 1\"")
        )
        .contains("`0 x 0 1` is not three numbers")
    );
    assert!(
        refused("arm.urdf", &arm().replacen("revolute", "floating", 1))
            .contains("joints of type `floating` are not known here")
    );
}

#[test]
fn the_tool_s_link_of_a_tree_with_many_ends_is_named() {
    let fixed = |name: &str, parent: &str| {
        format!(
            "<joint name=\"to_{name}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"{name}\"/></joint>\n"
        )
    };
    let finger = "<joint name=\"finger\" type=\"prismatic\"><parent link=\"tool0\"/><child link=\"left\"/><axis xyz=\"0 1 0\"/></joint>\n";
    // A frame at the foot moves with nothing, so it is no tool.
    let foot = arm().replace("</robot>", &format!("{}</robot>", fixed("base", "l0")));
    let (_, alone) = imported("arm.urdf", &foot);
    let more = format!(
        "{}{}{finger}</robot>",
        fixed("base", "l0"),
        fixed("sensor", "l6")
    );
    let many = arm().replace("</robot>", &more);
    let told = refused("arm.urdf", &many);
    assert!(
        told.contains("the tree ends in 3 links: base, sensor, left")
            && told.contains("--tip LINK"),
        "{told}"
    );
    let with = |tip| {
        let tip = Some(tip);
        let options = ImportOptions {
            tip,
            ..ImportOptions::new("vmc3")
        };
        import("arm.urdf", &many, ImportFormat::Urdf, &options)
    };
    let chosen = with("tool0").unwrap();
    let machine = Machine::from_toml("arm.toml", &chosen.toml).unwrap();
    assert_eq!(machine.kinematics(), alone.kinematics());
    let finger = chosen
        .rows
        .iter()
        .find(|row| row.key == "joint finger")
        .unwrap();
    assert_eq!(
        (finger.fate, finger.note.as_str()),
        (Fate::Ignored, "not on the way to tool0")
    );
    for (tip, message) in [
        ("hand", "there is no link `hand`"),
        ("base", "nothing moves the link `base`"),
    ] {
        let error = with(tip).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn urdf_machine_tools_have_a_table_and_a_tool() {
    let joint = |name: &str,
                 kind: &str,
                 parent: &str,
                 child: &str,
                 xyz: &str,
                 axis: &str,
                 limit: &str| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><origin xyz=\"{xyz}\"/><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"{axis}\"/>{limit}</joint>\n"
        )
    };
    let travel = "<limit lower=\"-0.3\" upper=\"0.3\" velocity=\"0.5\"/>";
    let text = [
        "<robot name=\"swivel\">\n".to_owned(),
        joint("axis_c", "continuous", "base", "table", "0 0 -0.42", "0 0 1", "<limit velocity=\"2\"/>"),
        joint("axis_x", "prismatic", "base", "slide", "0 0 0", "1 0 0", travel),
        joint("axis_y", "prismatic", "slide", "ram", "0 0 0", "0 1 0", travel),
        joint("axis_z", "prismatic", "ram", "head", "0 0 0", "0 0 1", travel),
        joint("axis_b", "revolute", "head", "spindle", "0 0 0.2", "0 1 0", "<limit lower=\"-1.9\" upper=\"1.9\" velocity=\"1\"/>"),
        "<joint name=\"nose\" type=\"fixed\"><origin xyz=\"0 0 -0.2\" rpy=\"3.141592653589793 0 0\"/><parent link=\"spindle\"/><child link=\"nose\"/></joint>\n</robot>".to_owned(),
    ]
    .concat();
    let (_, machine) = imported("swivel.urdf", &text);
    let (own, preset) = (
        machine.build_kinematics().unwrap(),
        Machine::preset("swivel5")
            .unwrap()
            .build_kinematics()
            .unwrap(),
    );
    assert_eq!(
        own.chain().unwrap().family(),
        preset.chain().unwrap().family()
    );
    let mut joints = Coords::xyz(30.0, -20.0, -100.0);
    // A positive turn of the URDF's table turns the part, so the tool goes the other way round than
    // with ISO 841.
    (joints[AxisId::B], joints[AxisId::C]) = (0.4, 0.7);
    let here = own.tool_pose(&joints, &[0.0, 0.0, 80.0]);
    joints[AxisId::C] = -0.7;
    let there = preset.tool_pose(&joints, &[0.0, 0.0, 80.0]);
    assert!(
        (0..3).all(|i| (here.tip[i] - there.tip[i]).abs() < 1e-9
            && (here.axis[i] - there.axis[i]).abs() < 1e-9),
        "{here:?} {there:?}"
    );
}

/// LinuxCNC's manual: at full speed FERROR, below it in proportion, never less than MIN_FERROR.
#[test]
fn linuxcnc_following_error() {
    let text = "[TRAJ]\nCOORDINATES = XYZA\nLINEAR_UNITS = mm\n[JOINT_0]\nMAX_VELOCITY = 50\nFERROR = 1.0\nMIN_FERROR = 0.2\n[JOINT_3]\nMAX_VELOCITY = 30\nMIN_FERROR = 0.5\nFERROR = 2\n";
    let (told, machine) = imported("mill.ini", text);
    let limit = |axis: AxisId, speed: f64| {
        let limits = machine.axis(axis).unwrap().monitor_limits();
        limits.following.unwrap().at(speed)
    };
    for (speed, allowed) in [(0.0, 0.2), (5.0, 0.2), (25.0, 0.5), (-50.0, 1.0)] {
        assert!((limit(AxisId::X, speed) - allowed).abs() < 1e-9, "{speed}");
    }
    // In degrees and degrees per second.
    for (speed, allowed) in [(0.0, 0.5), (15.0, 1.0)] {
        assert!((limit(AxisId::A, speed) - allowed).abs() < 1e-9, "{speed}");
    }
    assert_eq!(
        told.rows
            .iter()
            .filter(|row| row.key.contains("FERROR") && row.fate == Fate::Used)
            .count(),
        4
    );
    for wrong in ["FERROR = 0", "MIN_FERROR = -1"] {
        let bad = refused(
            "mill.ini",
            &format!("[JOINT_0]\nMAX_VELOCITY = 50\n{wrong}\n"),
        );
        assert!(bad.contains("it has to be above 0"), "{bad}");
    }
}

/// A trunnion's points and offsets as an INI file sets them, in its own unit; what it does not set
/// is told.
#[test]
fn linuxcnc_tells_of_files_that_it_does_not_read() {
    let (told, _) = imported("mill.ini", &format!("#INCLUDE axes.inc\n{INI}"));
    let row = told.rows.iter().find(|row| row.key == "#INCLUDE");
    assert!(
        row.is_some_and(|row| row.value == "axes.inc" && row.note.starts_with("not read")),
        "{row:?}"
    );
}

#[test]
fn linuxcnc_trunnion_pins() {
    let axes = "[TRAJ]\nCOORDINATES = XYZAC\nLINEAR_UNITS = inch\n[JOINT_0]\nMAX_VELOCITY = 2\n[JOINT_1]\nMAX_VELOCITY = 2\n[JOINT_2]\nMAX_VELOCITY = 2\n[JOINT_3]\nMAX_VELOCITY = 30\n[JOINT_4]\nMAX_VELOCITY = 30\n";
    let pins = "[HAL]\nHALCMD = setp xyzac-trt-kins.x-rot-point 1\nHALCMD = setp xyzac-trt-kins.z-rot-point -2.5\nHALCMD = setp xyzac-trt-kins.y-offset 0.5\nHALCMD = setp xyzac-trt-kins.z-offset 2\nHALCMD = setp xyzac-trt-kins.conventional-directions 1\nHALCMD = net on foo\n";
    let head = "[KINS]\nKINEMATICS = xyzac-trt-kins\n";
    let (told, machine) = imported("trt.ini", &format!("{head}{axes}{pins}"));
    let trunnion = |machine: &Machine| match machine.kinematics() {
        KinematicsSpec::TrunnionAc(spec) => *spec,
        other => panic!("{other:?}"),
    };
    let spec = trunnion(&machine);
    assert_eq!(spec.rotation_point_mm, [25.4, 0.0, -63.5]);
    assert_eq!(
        (
            spec.offset_y_mm,
            spec.offset_z_mm,
            spec.conventional_directions
        ),
        (Some(12.7), Some(50.8), Some(true))
    );
    let fates = |told: &Imported, key: &str| {
        told.rows
            .iter()
            .filter(|row| row.key.contains(key))
            .map(|row| row.fate)
            .collect::<Vec<_>>()
    };
    assert_eq!(fates(&told, "rot-point"), [Fate::Used; 2]);
    assert_eq!(fates(&told, "[HAL] HALCMD"), [Fate::Ignored]);
    assert!(fates(&told, "kinematics.rotation_point_mm").is_empty());
    let (untold, machine) = imported("trt.ini", &format!("{head}{axes}"));
    assert_eq!(trunnion(&machine).rotation_point_mm, [0.0; 3]);
    assert_eq!(
        fates(&untold, "kinematics.rotation_point_mm"),
        [Fate::Filled]
    );
    let bad = refused(
        "trt.ini",
        &format!("{head}{axes}[HAL]\nHALCMD = setp xyzac-trt-kins.x-rot-point far\n"),
    );
    assert!(
        bad.contains("trt.ini:17:1: xyzac-trt-kins.x-rot-point: `far` is not a number"),
        "{bad}"
    );
}
