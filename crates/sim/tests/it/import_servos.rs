//! Parameters of controls with servos: limits in their units, gaps, and what is told and not carried.
//! Expected values are worked out by hand.

use crate::import_controls::{fate, guesses, near, read, refused};
use lostmotion_base::AxisId;
use lostmotion_base::units::rad;
use lostmotion_sim::control::Control;
use lostmotion_sim::import::{Fate, Imported};

const SINUMERIK: &str = "CHANDATA(1)\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[1]=\"C1\"\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[2]=\"SP\"\nN30300 $MA_IS_ROT_AX[AX2]=1\nN32000 $MA_MAX_AX_VELO[AX1]=30000 '2f\nN32300 $MA_MAX_AX_ACCEL[0,AX1]=4\nN32300 $MA_MAX_AX_ACCEL[1,AX1]=1\nN32431 $MA_MAX_AX_JERK[0,AX1]=50\nN32450 $MA_BACKLASH[0,AX1]=0.012\nN36100 $MA_POS_LIMIT_MINUS[0,AX1]=-700\nN36110 $MA_POS_LIMIT_PLUS[0,AX1]=10\nN32000 $MA_MAX_AX_VELO[AX2]=50\nN32300 $MA_MAX_AX_ACCEL[0,AX2]=2\nN36110 $MA_POS_LIMIT_PLUS[0,AX2]=100000000\nN35000 $MA_SPIND_ASSIGN_TO_MACHAX[AX3]=1\nN32000 $MA_MAX_AX_VELO[AX3]=9000\n";

#[test]
fn sinumerik_machine_data() {
    let (told, machine) = read("nc.arc", SINUMERIK);
    let (x, c) = (
        machine.axis(AxisId::X).unwrap(),
        machine.axis(AxisId::C).unwrap(),
    );
    assert_eq!(machine.axes().len(), 2);
    // mm/min, m/s2, m/s3; rev/min, rev/s2.
    assert_eq!(
        (x.limits.velocity, x.limits.acceleration, x.limits.jerk),
        (500.0, 4000.0, 50000.0)
    );
    assert_eq!((x.limits.min, x.limits.max), (-700.0, 10.0));
    assert!(near(c.limits.velocity, rad(300.0)) && near(c.limits.acceleration, rad(720.0)));
    assert!(near(x.config.gap_in_unit(), 0.012));
    assert_eq!(x.config.compensation.method.name(), "actual-value");
    assert_eq!(machine.simulate().control, Some(Control::Siemens));
    assert_eq!(fate(&told, "$MA_POS_LIMIT_PLUS[0,AX2]"), Fate::Ignored);
    // Of an encoder at the load, or of a control that compensates nothing: the gap is not told.
    for other in ["=-0.012", "=0"] {
        let (told, machine) = read("nc.arc", &SINUMERIK.replace("=0.012", other));
        assert_eq!(fate(&told, "$MA_BACKLASH[0,AX1]"), Fate::Ignored);
        let x = machine.axis(AxisId::X).unwrap();
        assert!(x.config.compensation.method.is_baseline() && x.config.gap_in_unit() > 0.0);
    }
    let bad = refused(
        "nc.arc",
        &format!("$MN_SCALING_SYSTEM_IS_METRIC=0\n{SINUMERIK}"),
    );
    assert!(bad.contains("in inches"), "{bad}");
}

/// Compensations that are not carried are named, with what they are here.
/// A rotary axis without an end turns as often as it likes: it has not the ends of a tilting table.
#[test]
fn endless_rotary_axes_have_no_ends() {
    let ends = |told: &(Imported, lostmotion_sim::Machine), id| {
        let limits = told.1.axis(id).unwrap().limits;
        assert!(limits.max >= rad(36_000.0) - 1e-6 && limits.min <= -rad(36_000.0) + 1e-6);
        let letter = id.letter().to_ascii_lowercase();
        assert_eq!(
            fate(&told.0, &format!("axis.{letter}.limits.max_deg")),
            Fate::Guessed
        );
    };
    let both = "N36100 $MA_POS_LIMIT_MINUS[0,AX2]=-100000000\n";
    let siemens = read("nc.arc", &format!("{SINUMERIK}{both}"));
    assert_eq!(
        fate(&siemens.0, "$MA_POS_LIMIT_MINUS[0,AX2]"),
        Fate::Ignored
    );
    ends(&siemens, AxisId::C);
    let grbl = "$110=500\n$111=500\n$112=500\n$113=3600\n$120=100\n$121=100\n$122=100\n$123=200\n$130=400\n$131=300\n$132=100\n$133=0\n";
    let hal = read("settings.txt", grbl);
    assert_eq!(fate(&hal.0, "$133"), Fate::Ignored);
    ends(&hal, AxisId::A);
    // A slide of no travel is a mistake.
    let slide = grbl.replace("$132=100", "$132=0");
    assert!(refused("settings.txt", &slide).contains("$132: is 0"));
}

#[test]
fn sinumerik_compensations_that_are_left_out_are_named() {
    let data = |enable: u32| {
        format!(
            "{SINUMERIK}N32456 $MA_BACKLASH_DYN[0,AX1]=0.004\nN32490 $MA_FRICT_COMP_MODE[0,AX1]=1\nN32500 $MA_FRICT_COMP_ENABLE[AX1]={enable}\nN32520 $MA_FRICT_COMP_CONST_MAX[0,AX1]=30\nN32540 $MA_FRICT_COMP_TIME[0,AX1]=0.015\nN32550 $MA_FRICT_COMP_ACCEL1[0,AX1]=0.02\nN32520 $MA_FRICT_COMP_CONST_MAX[0,AX2]=6\n"
        )
    };
    let (told, machine) = read("nc.arc", &data(1));
    let note = |told: &Imported, key: &str| -> String {
        let row = told.rows.iter().find(|row| row.key == key).unwrap();
        assert_eq!(row.fate, Fate::Ignored, "{key}");
        row.note.clone()
    };
    // The method of the gap is the one that is carried.
    let x = machine.axis(AxisId::X).unwrap();
    assert_eq!(x.config.compensation.method.name(), "actual-value");
    for (key, says) in [
        ("$MA_FRICT_COMP_ENABLE[AX1]", "at work, and not carried"),
        // 30 mm/min, 0.015 s, 0.02 m/s2.
        ("$MA_FRICT_COMP_CONST_MAX[0,AX1]", "height_units_s = 0.5 "),
        ("$MA_FRICT_COMP_TIME[0,AX1]", "time_ms = 15.0 "),
        (
            "$MA_FRICT_COMP_ACCEL1[0,AX1]",
            "20.0 of acceleration_units_s2",
        ),
        // Nothing switches that of the other axis on.
        ("$MA_FRICT_COMP_CONST_MAX[0,AX2]", "which is off"),
        ("$MA_BACKLASH_DYN[0,AX1]", "not carried"),
    ] {
        let found = note(&told, key);
        assert!(found.contains(says), "{key}: {found}");
    }
    let (told, _) = read("nc.arc", &data(0));
    let found = note(&told, "$MA_FRICT_COMP_CONST_MAX[0,AX1]");
    assert!(found.contains("which is off"), "{found}");
    // It is not carried anyway: a value that is none is told.
    let (told, _) = read("nc.arc", &data(1).replace("=0.015", "=soon"));
    let found = note(&told, "$MA_FRICT_COMP_TIME[0,AX1]");
    assert!(found.contains("`soon` is not a number"), "{found}");
}

const FANUC: &str = "%\nN01001P00000000\nN01006Q1A1P00000000A2P00000001\nN01020Q1A1P88A2P65\nN01320Q1A1P10000A2P99999999\nN01321Q1A1P-762000A2P-99999999\nN01420Q1A1P30000A2P7200\nN01620Q1A1P125A2P100\nN01800P00010000\nN01828Q1A1P8000A2P8000\nN01829Q1A1P500A2P500\nN01851Q1A1P12A2P4\nN01852Q1A1P20A2P4\nN01851Q2A1P99\nN02020Q1A1P300\n%\n";

/// The backlash acceleration of the servo is told, not carried.
#[test]
fn fanuc_backlash_acceleration_is_told() {
    let more = "N02003Q1A1P00101000A2P00001000\nN02048Q1A1P100A2P100\n%\n";
    let (told, _) = read("params.txt", &FANUC.replace("N02020Q1A1P300\n%\n", more));
    let notes: Vec<(&str, Fate)> = told
        .rows
        .iter()
        .filter(|row| row.key.contains("2003") || row.key.contains("2048"))
        .map(|row| (row.note.as_str(), row.fate))
        .collect();
    assert_eq!(
        notes,
        [
            (
                "backlash acceleration (2003#5) is on, and not carried",
                Fate::Ignored
            ),
            ("", Fate::Ignored),
            (
                "of the backlash acceleration (2003#5), which is not carried",
                Fate::Ignored
            ),
            (
                "of the backlash acceleration (2003#5), which is not carried",
                Fate::Ignored
            ),
        ]
    );
}

#[test]
fn fanuc_parameters() {
    let (told, machine) = read("CNC-PARA.TXT", FANUC);
    let (x, a) = (
        machine.axis(AxisId::X).unwrap(),
        machine.axis(AxisId::A).unwrap(),
    );
    assert_eq!(
        (x.limits.min, x.limits.max, x.limits.velocity),
        (-762.0, 10.0, 500.0)
    );
    // 500 mm/s in 125 ms.
    assert_eq!(x.limits.acceleration, 4000.0);
    assert!(near(a.limits.velocity, rad(120.0)));
    // 12 detection units of 1 um; the second path does not count.
    assert!(near(x.config.gap_in_unit(), 0.012) && near(a.config.gap_in_unit(), 0.004));
    let own = &x.config.compensation;
    assert_eq!(own.method.name(), "fixed-fanuc");
    let transmission = &x.config.transmission;
    let um = |gap: Option<lostmotion_drive::config::Gap>| {
        gap.unwrap().motor_rad(transmission) / transmission.motor_rad_per_unit() * 1e3
    };
    assert!(near(um(own.fixed_fanuc.cutting), 12.0) && near(um(own.fixed_fanuc.rapid), 20.0));
    let following = x.monitor_limits().following.unwrap();
    assert!(near(following.at(500.0), 8.0) && near(following.at(0.0), 0.5));
    assert!(guesses(&told).contains(&"N1851 A1"));
    // Half an increment where the command multiplier is 2 (told as 4), three where it is 1/3 (103).
    let multiplied = FANUC.replace("N01851Q1A1P12", "N01820Q1A1P4A2P103\nN01851Q1A1P12");
    let (told, machine) = read("CNC-PARA.TXT", &multiplied);
    let gap = |id| machine.axis(id).unwrap().config.gap_in_unit();
    assert!(near(gap(AxisId::X), 0.006) && near(gap(AxisId::A), 0.012));
    let x = machine.axis(AxisId::X).unwrap();
    assert!(near(x.monitor_limits().following.unwrap().at(0.0), 0.25));
    assert!(!guesses(&told).contains(&"N1851 A1"));
    assert_eq!(fate(&told, "N1820 A1"), Fate::Used);
    // What is no multiplier leaves the guess.
    let none = FANUC.replace("N01851Q1A1P12", "N01820Q1A1P0A2P2\nN01851Q1A1P12");
    let (told, machine) = read("CNC-PARA.TXT", &none);
    assert!(near(
        machine.axis(AxisId::X).unwrap().config.gap_in_unit(),
        0.012
    ));
    assert!(guesses(&told).contains(&"N1851 A1"));
    // 0.01 1/s, and listed only.
    let gains = FANUC.replace("N01851Q1A1P12", "N01825Q1A1P3000A2P5000\nN01851Q1A1P12");
    let (told, _) = read("CNC-PARA.TXT", &gains);
    let row = told.rows.iter().find(|row| row.key == "N1825 A2").unwrap();
    assert!(
        row.note.starts_with("position_gain_per_s = 50.0: "),
        "{row:?}"
    );
    let bad = refused("p.txt", &FANUC.replace("N01851Q1A1P12", "N01851Q1A1P1e"));
    assert!(
        bad.contains("p.txt:12:1: N01851Q1A1P1eA2P4: is no parameter"),
        "{bad}"
    );
    let bad = refused(
        "p.txt",
        &FANUC.replace("N01001P00000000", "N01001P00000001"),
    );
    assert!(bad.contains("in inches"), "{bad}");
}

/// An axis of TwinCAT NC as TwinCAT saves it: the file's name is the axis' name, and attributes with
/// their usual value are not there.
#[test]
fn twincat_axes() {
    let axis = |name: &str, para: &str, soft: &str| {
        format!(
            "<Axis Id=\"1\" AxisType=\"1\"><Name>{name}</Name><AxisPara>{para}</AxisPara><Encoder><EncPara ScaleFactorNumerator=\"5\">{soft}</EncPara></Encoder><Controller><CtrPara PriorControlFactor=\"1\"/></Controller></Axis>"
        )
    };
    let soft = "<SoftEndMinControl Enable=\"true\" Range=\"-5\"/>\n<SoftEndMaxControl Enable=\"true\" Range=\"310\"/>";
    let one = format!(
        "<?xml version=\"1.0\"?>\n<TcSmItem ClassName=\"CNcAxisDef\">{}</TcSmItem>\n",
        axis(
            "__FILENAME__",
            "<Dynamic AccelerationMaximum=\"3000\" Acceleration=\"1500\" Jerk=\"40000\"/><Velo Maximum=\"400\"/>",
            soft
        )
    );
    let (told, machine) = read("folder/Axis X.xti", &one);
    let x = machine.axis(AxisId::X).unwrap().limits;
    assert_eq!((x.min, x.max, x.velocity), (-5.0, 310.0, 400.0));
    assert_eq!((x.acceleration, x.jerk), (3000.0, 40_000.0));
    assert_eq!(machine.axes().len(), 1);
    assert_eq!(fate(&told, "X EncPara ScaleFactorNumerator"), Fate::Ignored);
    let said = refused("Axis 1.xti", &one);
    assert!(
        said.contains("1 axes, none with a name that tells its letter"),
        "{said}"
    );
    // a project with several; an end that is switched off is none
    let off = "<SoftEndMaxControl Range=\"7\"/>";
    let project = format!(
        "<TcSmProject><NC>{}{}{}</NC></TcSmProject>",
        axis("X1", "<Velo Maximum=\"200\"/>", off),
        axis("Drehachse C", "<Velo Maximum=\"90\"/>", ""),
        axis("Conveyor", "", "")
    );
    let (told, machine) = read("m.tsproj", &project);
    assert_eq!(machine.axes().len(), 2);
    let c = machine.axis(AxisId::C).unwrap().limits;
    assert_eq!(c.velocity, std::f64::consts::FRAC_PI_2);
    assert!(machine.axis(AxisId::X).unwrap().limits.max != 7.0);
    assert_eq!(fate(&told, "Axis Conveyor"), Fate::Ignored);
    assert_eq!(fate(&told, "X SoftEndMaxControl Range"), Fate::Ignored);
    // Limits in words that are not known are told.
    let other = one
        .replace("SoftEndMinControl", "SoftEndMin")
        .replace("AccelerationMaximum", "MaxAcceleration");
    let (told, _) = read("Axis X.xti", &other);
    for key in ["X SoftEndMin Range", "X Dynamic MaxAcceleration"] {
        assert_eq!(fate(&told, key), Fate::Ignored);
    }
    // So is every other parameter, and nothing that is none.
    let more = one
        .replace(
            "</AxisPara>",
            "<OtherSettings PulseDistancePos=\"0.5\"/></AxisPara>",
        )
        .replace("<Encoder>", "<Encoder EncType=\"4\">");
    let (told, _) = read("Axis X.xti", &more);
    assert_eq!(
        fate(&told, "X OtherSettings PulseDistancePos"),
        Fate::Ignored
    );
    assert!(told.rows.iter().all(|row| !row.key.contains("EncType")));
    // So is backlash, of which no source tells how it is written.
    let gap = one.replace("<EncPara ", "<EncPara Backlash=\"0.02\" ");
    let (told, _) = read("Axis X.xti", &gap);
    assert_eq!(fate(&told, "X EncPara Backlash"), Fate::Ignored);
    let said = refused("X.xti", &one.replace("\"400\"", "\"-4\""));
    assert!(
        said.contains("X Velo Maximum") && said.contains("above 0"),
        "{said}"
    );
    let said = refused("X.xti", &one.replace("310\"/>", "310"));
    assert!(said.contains("not XML"), "{said}");
}

#[test]
fn mtconnect_devices() {
    let text = "<?xml version=\"1.0\"?>\n<m:MTConnectDevices xmlns:m=\"urn:mtconnect.org:MTConnectDevices:1.8\" xmlns=\"urn:mtconnect.org:MTConnectDevices:1.8\"><Devices><Device name=\"Mill\"><Components><Axes><Components>\n<Linear name=\"X1\" id=\"x\"><Specifications><Specification type=\"POSITION\" units=\"MILLIMETER\"><Maximum>400</Maximum><Minimum>-20</Minimum></Specification></Specifications></Linear>\n<Linear name=\"Table\" nativeName=\"Y\" id=\"y\"><DataItems><DataItem type=\"AXIS_FEEDRATE\" units=\"MILLIMETER/SECOND\"><Constraints><Maximum>250</Maximum></Constraints></DataItem></DataItems></Linear>\n<Rotary name=\"C\" id=\"c\"><DataItems><DataItem type=\"ROTARY_MODE\"><Constraints><Value>SPINDLE</Value></Constraints></DataItem></DataItems></Rotary>\n</Components></Axes></Components></Device></Devices></m:MTConnectDevices>\n";
    let (told, machine) = read("devices.xml", text);
    let (x, y) = (
        machine.axis(AxisId::X).unwrap(),
        machine.axis(AxisId::Y).unwrap(),
    );
    assert_eq!(
        (x.limits.min, x.limits.max, y.limits.velocity),
        (-20.0, 400.0, 250.0)
    );
    assert_eq!(machine.axes().len(), 2);
    assert_eq!(fate(&told, "Rotary C"), Fate::Ignored);
    let bad = refused(
        "devices.xml",
        &text.replace("<Maximum>400<", "<Maximum>NaN<"),
    );
    assert!(
        bad.contains("devices.xml:3:1: X Specification POSITION Maximum: `NaN` is not a number"),
        "{bad}"
    );
    let bad = refused(
        "devices.xml",
        &text.replace("MILLIMETER\"><Max", "FURLONG\"><Max"),
    );
    assert!(bad.contains("unit `FURLONG` is not known here"), "{bad}");
}

#[test]
fn a_value_that_is_none_is_left_out_of_an_archive_and_told() {
    // A jerk that is no number, and a line that was cut.
    let bad = SINUMERIK
        .replace("JERK[0,AX1]=50", "JERK[0,AX1]=5O")
        .replace("MA_POS_LIMIT_PLUS[0,AX1]=10", "MA_POS_LIMIT_PLUS[0,AX1");
    let (told, machine) = read("nc.arc", &bad);
    let row = |key: &str| told.rows.iter().find(|row| row.key.contains(key)).unwrap();
    let jerk = row("MA_MAX_AX_JERK[0,AX1]");
    assert_eq!((jerk.value.as_str(), jerk.fate), ("5O", Fate::Ignored));
    assert!(
        jerk.note.contains("line 9: `5O` is not a number"),
        "{}",
        jerk.note
    );
    let cut = row("MA_POS_LIMIT_PLUS[0,AX1");
    assert!(cut.note.contains("line 12: is no datum"), "{}", cut.note);
    // The rest is what it was.
    let x = machine.axis(AxisId::X).unwrap();
    assert!(near(x.config.gap_in_unit(), 0.012) && near(x.limits.acceleration, 4000.0));
    // What is needed is not made up.
    for (from, to, what) in [
        (
            "BACKLASH[0,AX1]=0.012",
            "BACKLASH[0,AX1]=O.012",
            "MA_BACKLASH[0,AX1]",
        ),
        ("IS_ROT_AX[AX2]=1", "IS_ROT_AX[AX2]=l", "MA_IS_ROT_AX[AX2]"),
        (
            "BACKLASH[0,AX1]=0.012",
            "BACKLASH[0,AX1",
            "MA_BACKLASH[0,AX1",
        ),
    ] {
        let error = refused("nc.arc", &SINUMERIK.replace(from, to));
        assert!(error.contains(what), "{error}");
    }
}
