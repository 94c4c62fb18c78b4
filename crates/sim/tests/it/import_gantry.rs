//! Descriptions of machines with two motors on an axis: a gantry where their gaps are told apart, one
//! motor where it moves alike.

use lostmotion_base::AxisId;
use lostmotion_sim::import::{Fate, ImportFormat, ImportOptions, Imported, import};
use lostmotion_sim::{Machine, Program, Simulation};

/// A LinuxCNC router with two motors on Y and a gap of each, mm.
fn router(first: &str, second: &str) -> String {
    let mut text = "[EMC]\nMACHINE = Router\n[KINS]\nKINEMATICS = trivkins coordinates=XYYZ kinstype=BOTH\nJOINTS = 4\n[TRAJ]\nCOORDINATES = XYYZ\nLINEAR_UNITS = mm\n".to_owned();
    for (joint, gap) in ["0.002", first, second, "0.01"].into_iter().enumerate() {
        text += &format!(
            "[JOINT_{joint}]\nMIN_LIMIT = -200\nMAX_LIMIT = 300\nMAX_VELOCITY = 100\nMAX_ACCELERATION = 900\n{}",
            if gap.is_empty() {
                String::new()
            } else {
                format!("BACKLASH = {gap}\n")
            }
        );
    }
    text
}

fn read(name: &str, text: &str) -> (Imported, Machine) {
    let format = ImportFormat::recognise(name, text).unwrap();
    let options = ImportOptions::new("vmc3-worn");
    let imported =
        import(name, text, format, &options).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let machine = Machine::from_toml("machine.toml", &imported.toml)
        .unwrap_or_else(|error| panic!("{error}\n{}", imported.toml));
    (imported, machine)
}

/// What is said of the motors of an axis.
fn said(imported: &Imported) -> Vec<(Fate, String)> {
    let rows = imported.rows.iter();
    rows.filter(|row| row.value.contains("motors"))
        .map(|row| {
            (
                row.fate,
                format!("{}: {}: {}", row.key, row.value, row.note),
            )
        })
        .collect()
}

fn gap_of_y(machine: &Machine) -> f64 {
    machine.axis(AxisId::Y).unwrap().config.gap_in_unit()
}

#[test]
fn joints_with_gaps_of_their_own_are_a_gantry() {
    let (imported, machine) = read("router.ini", &router("0.04", "0.01"));
    let gantry = machine
        .gantry()
        .unwrap_or_else(|| panic!("{}", imported.toml));
    assert_eq!((gantry.axis, gantry.along), (AxisId::Y, AxisId::X));
    assert_eq!(gantry.at_mm, [-200.0, 300.0]);
    assert!((gap_of_y(&machine) - 0.04).abs() < 1e-12);
    assert!((gantry.second.gap_in_unit() - 0.01).abs() < 1e-12);
    // The smaller gap may be the first one's.
    let (_, other) = read("router.ini", &router("0.01", "0.04"));
    assert!((gap_of_y(&other) - 0.01).abs() < 1e-12);
    assert!((other.gantry().unwrap().second.gap_in_unit() - 0.04).abs() < 1e-12);
    // Both values count, and the places are listed as guesses.
    for joint in [1, 2] {
        let key = format!("[JOINT_{joint}] BACKLASH");
        let row = imported.rows.iter().find(|row| row.key == key).unwrap();
        assert_eq!(row.fate, Fate::Used, "{row:?}");
    }
    let guess = imported
        .rows
        .iter()
        .find(|row| row.key.starts_with("gantry.first_at_mm"));
    assert_eq!(guess.unwrap().fate, Fate::Guessed);
    // The control compensates both.
    assert_eq!(
        machine
            .axis(AxisId::Y)
            .unwrap()
            .config
            .compensation
            .method
            .name(),
        "fixed-linuxcnc"
    );
    assert_eq!(gantry.second.compensation.method.name(), "fixed-linuxcnc");
}

/// A line along X behind a stroke of Y is off by half of the gap of the motor beside the tool.
#[test]
fn an_imported_gantry_runs_and_its_gaps_count_where_the_tool_is() {
    let (_, machine) = read("router.ini", &router("0.04", "0.01"));
    let worst = |from: f64, to: f64| {
        let text = format!("G90 G17 G61\nG0 X{from} Y0\nG1 F600 Y20\nY0\nG4 P0.5\nX{to}\nM2\n");
        let part = Program::from_str("part.ngc", &text);
        let run = Simulation::new(&part, &machine)
            .method("none")
            .run()
            .unwrap();
        run.results[0].backlash.max
    };
    let (first, second) = (worst(-199.0, -197.0), worst(299.0, 297.0));
    assert!(first > 2.0 * second, "{first} {second}");
}

#[test]
fn round_trips_keep_both_gaps() {
    let (_, machine) = read("router.ini", &router("0.04", "0.01"));
    let again = Machine::from_toml("again.toml", &machine.to_toml().unwrap()).unwrap();
    assert_eq!(machine.gantry(), again.gantry());
    assert!((gap_of_y(&again) - 0.04).abs() < 1e-12);
}

#[test]
fn motors_that_move_alike_are_one() {
    for (first, second, fate, words) in [
        ("0.03", "0.03", Fate::Used, "they have one gap"),
        ("0.03", "", Fate::Guessed, "the gap that is told of one"),
        ("0", "0.03", Fate::Guessed, "the gap that is told of one"),
        ("", "", Fate::Guessed, "of which none is told"),
    ] {
        let (imported, machine) = read("router.ini", &router(first, second));
        assert!(machine.gantry().is_none());
        let said = said(&imported);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(
            said[0].0 == fate && said[0].1.contains(words),
            "{first} {second} {said:?}"
        );
        if !second.is_empty() {
            assert!(
                (gap_of_y(&machine) - 0.03).abs() < 1e-12,
                "{first} {second}"
            );
        }
    }
}

/// What the description of one machine cannot hold is said.
#[test]
fn more_motors_than_a_machine_has_here_take_the_widest_gap() {
    let three = router("0.03", "0.01")
        .replace("XYYZ", "XYYYZ")
        .replace("JOINTS = 4", "JOINTS = 5")
        + "[JOINT_4]\nMIN_LIMIT = -50\nMAX_LIMIT = 0\n";
    let (imported, machine) = read("router.ini", &three);
    assert!(machine.gantry().is_none());
    assert!((gap_of_y(&machine) - 0.03).abs() < 1e-12);
    let said = said(&imported);
    assert!(said[0].1.contains("more than two motors"), "{said:?}");
    let belts = router("0.01", "0.03").replace("trivkins", "corexykins");
    let (imported, machine) = read("router.ini", &belts);
    assert!(machine.gantry().is_none());
    assert!((gap_of_y(&machine) - 0.03).abs() < 1e-12);
    let row = imported
        .rows
        .iter()
        .find(|row| row.key == "[JOINT_1] BACKLASH")
        .unwrap();
    assert!(
        row.fate == Fate::Ignored && row.note.contains("[JOINT_2] BACKLASH counts"),
        "{row:?}"
    );
}

/// A gantry of two groups of data, whose second axis has a name that is no letter.
#[test]
fn a_gantry_of_a_sinumerik_has_the_gap_of_its_second_axis() {
    let mut text = String::from("%_N_COMPLETE_TEA\n");
    for (at, name) in ["X1", "Y1", "YF1", "Z1"].iter().enumerate() {
        text += &format!("N10000 $MN_AXCONF_MACHAX_NAME_TAB[{at}]=\"{name}\"\n");
    }
    for (axis, gap, kind) in [(1, 0.02, 0), (2, 0.012, 1), (3, 0.03, 11), (4, 0.01, 0)] {
        text += &format!(
            "N32000 $MA_MAX_AX_VELO[AX{axis}]=30000\nN32450 $MA_BACKLASH[0,AX{axis}]={gap}\nN37100 $MA_GANTRY_AXIS_TYPE[AX{axis}]={kind}\nN36100 $MA_POS_LIMIT_MINUS[AX{axis}]=-100\nN36110 $MA_POS_LIMIT_PLUS[AX{axis}]=400\n"
        );
    }
    text += "M17\n";
    let (imported, machine) = read("archive.txt", &text);
    let gantry = machine
        .gantry()
        .unwrap_or_else(|| panic!("{}", imported.toml));
    assert_eq!(gantry.at_mm, [-100.0, 400.0]);
    assert!((gap_of_y(&machine) - 0.012).abs() < 1e-12);
    assert!((gantry.second.gap_in_unit() - 0.03).abs() < 1e-12);
    assert_eq!(gantry.second.compensation.method.name(), "actual-value");
    // The same where both have the letter, and where no axis leads nothing is a gantry.
    let (_, lettered) = read("archive.txt", &text.replace("YF1", "Y2"));
    assert_eq!(lettered.gantry(), machine.gantry());
    let alone = text.replace("TYPE[AX2]=1", "TYPE[AX2]=0");
    assert!(read("archive.txt", &alone).1.gantry().is_none());
}

/// Axis synchronous control: the axis that follows has a number, a name, an increment and a gap of its own.
#[test]
fn an_axis_of_a_fanuc_that_follows_another_is_its_second_motor() {
    let text = "%\nN01013Q1A1P00000000A2P00000000A3P00000000A4P00000010\nN01020Q1A1P88A2P89A3P90A4P65\nN01320Q1A1P500000A2P400000A3P100000A4P4000000\nN01321Q1A1P-500000A2P-400000A3P-100000A4P-4000000\nN01420Q1A1P24000A2P24000A3P24000A4P24000\nN01851Q1A1P20A2P12A3P10A4P300\nN08311Q1A1P0A2P0A3P0A4P2\n%\n";
    let (imported, machine) = read("parameters.txt", text);
    let gantry = machine
        .gantry()
        .unwrap_or_else(|| panic!("{}", imported.toml));
    assert_eq!(gantry.axis, lostmotion_base::AxisId::Y);
    assert_eq!(gantry.at_mm, [-500.0, 500.0]);
    assert!((gap_of_y(&machine) - 0.012).abs() < 1e-12);
    assert!((gantry.second.gap_in_unit() - 0.03).abs() < 1e-12);
    assert_eq!(gantry.second.compensation.method.name(), "fixed-fanuc");
    // The follower is no axis of its own, whatever its name.
    assert_eq!(machine.drives(), ["x", "y", "z", "y2"]);
    let row = |key: &str| {
        let mut rows = imported.rows.iter();
        rows.find(|row| row.key == key)
            .map(|row| (row.fate, row.note.as_str()))
    };
    assert_eq!(row("N8311 A4"), Some((Fate::Used, "second motor of Y")));
    let like = "of the second motor of Y, taken to be like the first";
    assert_eq!(row("N1420 A4"), Some((Fate::Ignored, like)));
    // Where both motors have one gap they are one, and what follows nothing is an axis.
    let equal = text.replace("A4P300", "A4P120");
    let (imported, machine) = read("parameters.txt", &equal);
    assert!(machine.gantry().is_none());
    assert!(said(&imported).iter().any(|it| it.1.contains("axis Y")));
    for alone in ["A4P0\n%", "A4P4\n%", "A4P9\n%"] {
        let text = text.replace("A4P2\n%", alone).replace("A4P65", "A4P86");
        let (_, machine) = read("parameters.txt", &text);
        assert_eq!(machine.drives(), ["x", "y", "z", "v"], "{alone}");
    }
}

/// Controls that have one gap for an axis, or none, move all of its motors alike.
#[test]
fn controls_with_one_gap_an_axis_say_that_its_motors_are_one() {
    let klipper = "[printer]\nkinematics: cartesian\nmax_velocity: 100\nmax_accel: 900\n[stepper_x]\nposition_max: 300\nrotation_distance: 40\n[stepper_y]\nposition_max: 300\nrotation_distance: 40\n[stepper_y1]\nrotation_distance: 40\n[stepper_z]\nposition_max: 100\nrotation_distance: 8\n";
    let rrf = "M584 X0 Y1:4 Z2 E3\nM92 X80 Y80 Z400\nM203 X6000 Y6000 Z600\nM201 X900 Y900 Z100\nM208 X0:300 Y0:300 Z0:100\nM425 Y0.05\n";
    let fluidnc = "axes:\n  x:\n    max_rate_mm_per_min: 6000\n  y:\n    max_rate_mm_per_min: 6000\n    steps_per_mm: 80\n    motor0:\n      limit_neg_pin: gpio.1\n    motor1:\n      limit_neg_pin: gpio.2\n  z:\n    max_rate_mm_per_min: 600\nend: 1\n";
    let grbl = "$22=0\n$100=80\n$101=80\n$102=400\n$110=6000\n$111=6000\n$112=600\n$161=0.050\n$171=0.120\n";
    let marlin = "M92 X80 Y80 Z400\nM203 X100 Y100 Z10\nM906 X800 Y800 Z800\nM906 I1 Y800\n";
    for (name, text) in [
        ("printer.cfg", klipper),
        ("config.g", rrf),
        ("config.yaml", fluidnc),
        ("settings.txt", grbl),
        ("m503.txt", marlin),
    ] {
        let (imported, machine) = read(name, text);
        assert!(machine.gantry().is_none(), "{name}");
        let said = said(&imported);
        let two = |said: &(Fate, String)| said.1.contains("2 motors as one");
        assert!(said.iter().any(two), "{name} {said:?}");
        assert!(
            said.iter().all(|said| said.1.starts_with("axis Y")),
            "{name} {said:?}"
        );
    }
}
