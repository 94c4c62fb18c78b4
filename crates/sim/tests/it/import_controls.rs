//! Configurations of controls: limits in their units, steppers as steppers, what the control does
//! about the gap, and what is a guess. Expected values are worked out by hand.
use lostmotion_base::AxisId;
use lostmotion_base::units::rad;
use lostmotion_kinematics::KinematicsSpec;
use lostmotion_sim::control::Control;
use lostmotion_sim::import::{
    Fate, FileSource, ImportFormat, ImportOptions, Imported, Row, import,
};
use lostmotion_sim::{Machine, Program, Simulation};

pub(crate) fn read_with(
    name: &str,
    text: &str,
    options: &ImportOptions<'_>,
) -> Result<(Imported, Machine), String> {
    let format = ImportFormat::recognise(name, text).unwrap_or_else(|| panic!("{name}: unknown"));
    let imported = import(name, text, format, options).map_err(|error| error.to_string())?;
    let machine = Machine::from_toml("imported.toml", &imported.toml)
        .unwrap_or_else(|error| panic!("{error}\n{}", imported.toml));
    Ok((imported, machine))
}

pub(crate) fn read(name: &str, text: &str) -> (Imported, Machine) {
    read_with(name, text, &ImportOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn refused(name: &str, text: &str) -> String {
    read_with(name, text, &ImportOptions::default())
        .err()
        .unwrap_or_else(|| panic!("{name} is read"))
}

pub(crate) fn fate(imported: &Imported, key: &str) -> Fate {
    let mut rows = imported.rows.iter();
    rows.rfind(|row| row.key == key)
        .unwrap_or_else(|| panic!("{key}"))
        .fate
}

pub(crate) fn guesses(imported: &Imported) -> Vec<&str> {
    let rows = imported.rows.iter();
    rows.filter(|row| row.fate == Fate::Guessed)
        .map(|row| row.key.as_str())
        .collect()
}

/// Both sides equal up to rounding.
pub(crate) fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * b.abs().max(1e-9)
}

const KLIPPER: &str = "[stepper_x]\nmicrosteps: 32\nrotation_distance: 40 # belt\nposition_max: 235\n[stepper_y]\nmicrosteps = 16\nrotation_distance = 80\ngear_ratio: 2:1\nposition_min: -5\nposition_max: 230\n[stepper_z]\nmicrosteps: 16\nrotation_distance: 8\nposition_max: 200\n[stepper_z1]\nmicrosteps: 8\n[tmc2209 stepper_x]\nrun_current: 0.8\n[printer]\nkinematics: cartesian\nmax_velocity: 250\nmax_accel: 2000\nmax_z_velocity: 12\nmax_z_accel: 100\n[gcode_macro A]\ngcode:\n  G28\n";

#[test]
fn klipper_and_what_a_stepper_is() {
    let (told, machine) = read("printer.cfg", KLIPPER);
    let axis = |id| machine.axis(id).unwrap();
    let (x, y, z) = (axis(AxisId::X), axis(AxisId::Y), axis(AxisId::Z));
    assert_eq!((x.limits.min, x.limits.max), (0.0, 235.0));
    assert_eq!((y.limits.min, y.limits.velocity), (-5.0, 250.0));
    assert_eq!((z.limits.velocity, z.limits.acceleration), (12.0, 100.0));
    // The way of a turn: 40 mm, 80 mm behind 2 to 1, 8 mm; 200 full steps of a turn.
    let turn = |id| std::f64::consts::TAU / axis(id).config.transmission.motor_rad_per_unit();
    assert!(near(turn(AxisId::X), 40.0) && near(turn(AxisId::Y), 40.0));
    assert!(near(turn(AxisId::Z), 8.0));
    let counts = |id| axis(id).config.drive.encoder_counts_per_rev;
    assert_eq!(
        (counts(AxisId::X), counts(AxisId::Z)),
        (Some(6400), Some(3200))
    );
    // 0.8 A effective are 1.131 A at the crest, of the 2.404 A at which a motor of that class holds
    // 0.40 N m: 0.188 N m. On 50 pole pairs that is a spring of 9.41 N m/rad.
    let drive = &x.config.drive;
    let constant = x.config.motor.torque_constant_nm_per_a;
    assert!((drive.current_limit_a - 1.1314).abs() < 1e-4);
    assert!((constant * drive.current_limit_a - 0.1882).abs() < 1e-4);
    let spring = drive.position_gain_per_s * drive.velocity_gain_a_s_per_rad * constant;
    assert!((spring - 9.41).abs() < 0.01, "{spring}");
    // Beyond a full step of 0.2 mm it loses steps.
    let following = x.monitor_limits().following.unwrap();
    assert!(near(following.at(0.0), 0.2));
    // A carriage of a printer, not the 300 kg table of a mill.
    let radius_m = 0.04 / std::f64::consts::TAU;
    assert!(x.config.reflected_load().inertia_kgm2 / (radius_m * radius_m) < 2.0);
    assert_eq!(fate(&told, "[tmc2209 stepper_x] run_current"), Fate::Used);
    assert_eq!(fate(&told, "[stepper_z1] microsteps"), Fate::Ignored);
    let guessed = guesses(&told);
    for key in [
        "axis.x.motor",
        "axis.x.load.slide",
        "axis.x.load.slide.gap_um",
        "axis.x.limits.jerk_mm_s3",
    ] {
        assert!(guessed.contains(&key), "{key}: {guessed:?}");
    }
    assert_eq!(machine.simulate().control, Some(Control::Klipper));
    for bad in [
        (
            KLIPPER.replace("max_accel: 2000", "max_accel: nan"),
            "printer.cfg:22:1: [printer] max_accel: `nan` is not a number",
        ),
        (
            KLIPPER.replace("gear_ratio: 2:1", "gear_ratio: 2"),
            "`2` is no ratio",
        ),
        (
            KLIPPER.replace("cartesian", "polar"),
            "`polar` is not known here",
        ),
        (
            KLIPPER.replace("rotation_distance: 8", "rotation_distance: 0"),
            "[stepper_z] rotation_distance: is 0; it has to be above 0",
        ),
        (
            "[printer]\nmax_velocity: 3\n[stepper_x\n".to_owned(),
            "printer.cfg:3:1: [stepper_x: the section's name is not closed",
        ),
    ] {
        let error = refused("printer.cfg", &bad.0);
        assert!(error.contains(bad.1), "{error}");
    }
}

/// A force against the rotor turns it by the force's torque over the spring, and one above the
/// pull-out torque makes it lose steps: independent of how the gains came about.
#[test]
fn a_stepper_gives_as_its_field_does_and_loses_steps() {
    let (told, _) = read("printer.cfg", KLIPPER);
    let part = Program::from_str("p.ngc", "G21 G90\nG1 X10 F600\nG1 X20\nM2\n");
    let run = |force: f64| {
        let toml = told.toml.replacen(
            "coulomb_n =",
            &format!("constant_n = {force:?}\ncoulomb_n ="),
            1,
        );
        let machine = Machine::from_toml("m.toml", &toml).unwrap();
        Simulation::new(&part, &machine)
            .run()
            .unwrap()
            .results
            .remove(0)
    };
    assert!(run(5.0).stop.is_none());
    // 0.188 N m on 40 mm a turn are 29.6 N.
    let stop = run(45.0).stop.unwrap();
    assert_eq!(stop.axis, AxisId::X);
}

#[test]
fn corexy_limits_are_those_of_the_belts() {
    let (_, machine) = read("printer.cfg", &KLIPPER.replace("cartesian", "corexy"));
    assert!(matches!(machine.kinematics(), KinematicsSpec::CoreXy(_)));
    let limits = |id| machine.axis(id).unwrap().limits;
    // x + y from 0 - 5 to 235 + 230; x - y from 0 - 230 to 235 + 5.
    let (a, b) = (limits(AxisId::X), limits(AxisId::Y));
    assert_eq!((a.min, a.max, b.min, b.max), (-5.0, 465.0, -230.0, 240.0));
    assert!(near(a.velocity, 250.0 * std::f64::consts::SQRT_2));
}

#[test]
fn klipper_includes() {
    let files = |name: &str| match name {
        "motors.cfg" => Ok(KLIPPER.to_owned()),
        "ring.cfg" => Ok("[include ring.cfg]\n".to_owned()),
        _ => Err("no such file".to_owned()),
    };
    let options = ImportOptions {
        files: &files,
        ..ImportOptions::default()
    };
    let text = "[printer]\n[include motors.cfg]\n[include gone.cfg]\n#*# [stepper_x]\n#*# position_max = 220\n";
    let (told, machine) = read_with("p.cfg", text, &options).unwrap();
    // What SAVE_CONFIG wrote counts.
    assert_eq!(machine.axis(AxisId::X).unwrap().limits.max, 220.0);
    assert!(
        told.rows
            .iter()
            .any(|row| row.value == "gone.cfg" && row.fate == Fate::Ignored)
    );
    let error = read_with("p.cfg", "[printer]\n[include ring.cfg]\n", &options).unwrap_err();
    assert!(error.contains("more than 16 deep"), "{error}");
}

/// A folder with files, as the description names them.
struct Folder(&'static [(&'static str, &'static str)]);

impl FileSource for Folder {
    fn text(&self, name: &str) -> Result<String, String> {
        let found = self.0.iter().find(|(own, _)| *own == name);
        found.map_or_else(
            || Err("no such file".to_owned()),
            |(_, text)| Ok((*text).to_owned()),
        )
    }

    fn names(&self, folder: &str) -> Result<Vec<String>, String> {
        let stroke = if folder.is_empty() { "" } else { "/" };
        let within = self.0.iter().filter_map(|(name, _)| {
            let name = name.strip_prefix(folder)?.strip_prefix(stroke)?;
            (!name.contains('/')).then(|| name.to_owned())
        });
        Ok(within.collect())
    }
}

/// A file of 60 bytes.
const HEAVY: &str = "# 3456789 123456789 123456789 123456789 123456789 123456789\n";

/// In the order of names, whatever the folder's own; names begin in the folder of their file.
#[test]
fn klipper_includes_with_wildcards() {
    let folder = Folder(&[
        ("extra/b.cfg", "[include c.inc]\n"),
        ("extra/a.cfg", "[stepper_x]\nposition_max: 100\n"),
        ("extra/c.inc", "[stepper_x]\nposition_max: 200\n"),
        ("extra/.hidden.cfg", "[stepper_x]\nposition_max: 7\n"),
        ("m1.cfg", "[stepper_y]\nposition_max: 11\n"),
        ("m2.cfg", "[stepper_y]\nposition_max: 12\n"),
        ("mx.cfg", "[stepper_y]\nposition_max: 13\n"),
        ("ring/r.cfg", "[include *.cfg]\n"),
        ("heavy/1.cfg", HEAVY),
        ("heavy/2.cfg", HEAVY),
    ]);
    let options = ImportOptions {
        files: &folder,
        ..ImportOptions::default()
    };
    let read = |more: &str, options: &ImportOptions<'_>| {
        read_with("p.cfg", &format!("{KLIPPER}{more}"), options)
    };
    let more =
        "[include extra/*.cfg]\n[include m[!a-z].c?g]\n[include none/*]\n[include */a.cfg]\n";
    let (told, machine) = read(more, &options).unwrap();
    let most = |axis| machine.axis(axis).unwrap().limits.max;
    assert_eq!((most(AxisId::X), most(AxisId::Y)), (200.0, 12.0));
    let rows = told.rows.iter().filter(|row| row.key == "[include]");
    let rows: Vec<_> = rows
        .map(|row| (row.value.as_str(), row.note.as_str()))
        .collect();
    assert_eq!(
        rows,
        [
            ("extra/a.cfg", "read in its place"),
            ("extra/b.cfg", "read in its place"),
            ("extra/c.inc", "read in its place"),
            ("m1.cfg", "read in its place"),
            ("m2.cfg", "read in its place"),
            ("none/*", "matches no file"),
            ("*/a.cfg", "not read (wildcards in the name of a folder)"),
        ]
    );
    let error = read("[include ring/*]\n", &options).unwrap_err();
    assert!(error.contains("more than 16 deep"), "{error}");
    let few = ImportOptions {
        max_bytes: 1000,
        ..options
    };
    let error = read(&"[include heavy/*.cfg]\n".repeat(9), &few).unwrap_err();
    assert!(
        error.contains("included files have more than 1000 bytes"),
        "{error}"
    );
    // A source that only knows names says so.
    let (told, _) = read("[include extra/*.cfg]\n", &ImportOptions::default()).unwrap();
    assert!(told.rows.iter().any(|row| {
        row.value == "extra/*.cfg" && row.note == "not read (folders are not looked into here)"
    }));
}

const FLUIDNC: &str = "name: Router # mine\nboard: X\naxes:\n  x:\n    steps_per_mm: 400\n    max_rate_mm_per_min: 6000\n    acceleration_mm_per_sec2: 200\n    max_travel_mm: 300\n    homing:\n      positive_direction: false\n      mpos_mm: 2\n    motor0:\n      tmc_2209:\n        microsteps: 16\n        run_amps: 1.2\n    motor1:\n      tmc_2209:\n        microsteps: 8\n  Z:\n    steps_per_mm: 800\n    max_rate_mm_per_min: 1200\n    max_rate_mm_per_min: 1500\n    max_travel_mm: 100\n    motor0:\n      standard_stepper:\n        step_pin: gpio.1\n  a:\n    steps_per_mm: 17.7778\n    max_rate_mm_per_min: 3600\n";

#[test]
fn fluidnc() {
    let (told, machine) = read("config.yaml", FLUIDNC);
    assert_eq!(machine.name(), "Router");
    let axis = |id| machine.axis(id).unwrap();
    let (x, z, a) = (axis(AxisId::X), axis(AxisId::Z), axis(AxisId::A));
    assert_eq!(
        (x.limits.min, x.limits.max, x.limits.velocity),
        (2.0, 302.0, 100.0)
    );
    assert_eq!(
        (z.limits.min, z.limits.max, z.limits.velocity),
        (-100.0, 0.0, 25.0)
    );
    assert!(near(a.limits.velocity, rad(60.0)));
    // 200 16/400 = 8 mm; 800 steps of a mm are 4 mm at 16 microsteps, which is a guess.
    let turn = |id| std::f64::consts::TAU / axis(id).config.transmission.motor_rad_per_unit();
    assert!(near(turn(AxisId::X), 8.0) && near(turn(AxisId::Z), 4.0));
    let guessed = guesses(&told);
    assert!(!guessed.contains(&"axis.x.transmission") && guessed.contains(&"axis.z.transmission"));
    assert_eq!(
        fate(&told, "axes.x.motor1.tmc_2209.microsteps"),
        Fate::Ignored
    );
    let bad = refused(
        "c.yaml",
        &FLUIDNC.replace("max_travel_mm: 300", "max_travel_mm: -3"),
    );
    assert!(
        bad.contains("c.yaml:8:1: axes.x.max_travel_mm: is -3; it has to be above 0"),
        "{bad}"
    );
    let bad = refused(
        "c.yaml",
        &format!("kinematics:\n  parallel_delta:\n{FLUIDNC}"),
    );
    assert!(
        bad.contains("c.yaml:2:1: kinematics: `parallel_delta` is not known here"),
        "{bad}"
    );
}

const DUET: &str = "; config.g\nM550 P\"mill; one\"\nM584 X0.0 Y0.1:0.2 Z0.3\nM350 X16 Y16 Z8 I1\nM906 X2400 Y2400:2400 Z1000 I30\nM92 X80 Y80 Z400 E420\nM208 X0:600 Y0:500\nM208 S1 Z-2\nM208 S0 Z120\nM203 X6000 Y6000 Z600 I0.1\nM201 X400 Y400 Z100\nM669 K0\nM425 X0.05 Y0.08 Z0 S12\nG28\n";

#[test]
fn reprapfirmware() {
    let (told, machine) = read("config.g", DUET);
    assert_eq!(machine.name(), "mill; one");
    let axis = |id| machine.axis(id).unwrap();
    let (x, z) = (axis(AxisId::X), axis(AxisId::Z));
    // mm/min.
    assert_eq!((x.limits.velocity, x.limits.acceleration), (100.0, 400.0));
    assert_eq!((z.limits.min, z.limits.max), (-2.0, 120.0));
    // mA at the crest.
    assert!(near(x.config.drive.current_limit_a, 2.4));
    assert!(near(x.config.gap_in_unit(), 0.05));
    assert_eq!(x.config.compensation.method.name(), "fixed-by-travel");
    assert!(near(x.config.compensation.fixed_by_travel.multiple, 12.0));
    // Nothing is done about a gap of 0, and how large it is, is not told.
    assert!(z.config.gap_in_unit() > 0.0);
    assert!(z.config.compensation.method.is_baseline());
    assert_eq!(fate(&told, "M92 E"), Fate::Ignored);
    let bad = refused("config.g", &DUET.replace("X6000 ", "X{var.v} "));
    assert!(
        bad.contains("config.g:10:1: M203 X: `{var.v}` is an expression"),
        "{bad}"
    );
    let bad = refused("config.g", &DUET.replace("M669 K0", "M669 K4"));
    assert!(bad.contains("kinematics 4 are not known here"), "{bad}");
}

#[test]
fn marlin_answers_and_headers_say_the_same() {
    let dump = "Recv: echo:; Steps per unit:\nRecv: echo:  M92 X80.00 Y80.00 Z400.00 E93.00\nRecv: echo: M203 X300.00 Y300.00 Z5.00 E25.00\nRecv: echo:  M201 X500.00 Y500.00 Z100.00 E5000.00\nRecv: echo:  M205 J0.01\nRecv: echo:  M425 F0.50 S3.00 X0.20 Y0.36 Z0.02\nRecv: ok\n";
    let header = "#define X_BED_SIZE 220\n#define DEFAULT_AXIS_STEPS_PER_UNIT   { 80, 80, 400, 93 } // mm\n#define DEFAULT_MAX_FEEDRATE { 300, 300, 5, 25 }\n#define DEFAULT_MAX_ACCELERATION { 500, 500, 100, 5000 }\n//#define COREXY\n#define X_MIN_POS 0\n#define X_MAX_POS X_BED_SIZE\n#define BACKLASH_COMPENSATION\n#define BACKLASH_DISTANCE_MM { 0.20, 0.36, 0.02 }\n#define BACKLASH_CORRECTION 0.5\n#define BACKLASH_SMOOTHING_MM 3\n#define X_CURRENT 800\n";
    let (_, a) = read("dump.gcode", dump);
    let (_, b) = read("Configuration.h", header);
    for machine in [&a, &b] {
        let axis = |id| machine.axis(id).unwrap();
        let (x, y, z) = (axis(AxisId::X), axis(AxisId::Y), axis(AxisId::Z));
        // mm/s here.
        assert_eq!((x.limits.velocity, z.limits.velocity), (300.0, 5.0));
        assert_eq!(y.limits.acceleration, 500.0);
        assert!(near(y.config.gap_in_unit(), 0.36));
        let own = &y.config.compensation;
        assert_eq!(own.method.name(), "fixed-by-travel");
        assert!(
            near(own.fixed_by_travel.correction, 0.5)
                && near(own.fixed_by_travel.smoothing_mm, 3.0)
        );
    }
    assert_eq!(b.axis(AxisId::X).unwrap().limits.max, 220.0);
    // M503 tells no travel: a printer's begins at zero.
    for axis in a.axes() {
        assert!(axis.limits.min == 0.0 && axis.limits.max > 100.0);
    }
    assert!((b.axis(AxisId::X).unwrap().config.drive.current_limit_a - 1.1314).abs() < 1e-4);
    let inches = format!("echo:  G20 ; (in)\n{dump}");
    let bad = refused("dump.gcode", &inches);
    assert!(
        bad.contains("dump.gcode:1:1: G20: the settings are in inches")
            && bad.contains("hint: send G21 before M503"),
        "{bad}"
    );
    let (told, _) = read("dump.gcode", &inches.replace("G20 ; (in)", "G21"));
    assert_eq!(fate(&told, "G21"), Fate::Used);
    let bad = refused("dump.gcode", &dump.replace("Z5.00", "Z-5"));
    assert!(
        bad.contains("dump.gcode:3:1: M203 Z: is -5; it has to be above 0"),
        "{bad}"
    );
    let bad = refused(
        "Configuration.h",
        &header.replace("X_MAX_POS X_BED_SIZE", "X_MAX_POS X_BED"),
    );
    assert!(
        bad.contains("Configuration.h:7:1: X_MAX_POS: `X_BED` is not a number"),
        "{bad}"
    );
}

#[test]
fn grbl_is_a_stepper_unless_a_machine_is_named() {
    let text = "$100=400\n$101=160\n$110=3000\n$111=3000\n$120=200\n$121=200\n$130=300\n$131=300\n";
    let (told, machine) = read("dump.txt", text);
    let turn = |id| {
        std::f64::consts::TAU
            / machine
                .axis(id)
                .unwrap()
                .config
                .transmission
                .motor_rad_per_unit()
    };
    // The first usual pair: 8 mm at 16 microsteps; 160 steps of a mm are 20 mm.
    assert!(near(turn(AxisId::X), 8.0) && near(turn(AxisId::Y), 20.0));
    assert_eq!(fate(&told, "$100"), Fate::Used);
    let named = ImportOptions::new("vmc3-worn");
    let (told, machine) = read_with("dump.txt", text, &named).unwrap();
    assert!(near(
        machine.axis(AxisId::X).unwrap().config.gap_in_unit(),
        0.04
    ));
    assert_eq!(fate(&told, "$100"), Fate::Ignored);
    // Nothing of steppers; of Z, which every grbl has, and of where zero lies nothing is told.
    assert_eq!(guesses(&told), ["$22", "axis Z"]);
}

const STEPGEN: &str = "[EMC]\nMACHINE = Router\n[KINS]\nKINEMATICS = trivkins coordinates=XZ\n[TRAJ]\nLINEAR_UNITS = inch\n[EMCMOT]\nSERVO_PERIOD = 500000\n[RS274NGC]\nPARAMETER_FILE = linuxcnc.var\nRS274NGC_STARTUP_CODE = G21 G40 G64 P0.02\n[EMCIO]\nTOOL_TABLE = tool.tbl\n[JOINT_0]\nMIN_LIMIT = -10\nMAX_LIMIT = 10\nMAX_VELOCITY = 2\nMAX_ACCELERATION = 20\nSTEPGEN_MAXACCEL = 22\nSTEP_SCALE = -5080\nBACKLASH = 0.002\n[JOINT_1]\nMIN_LIMIT = -5\nMAX_LIMIT = 5\nMAX_VELOCITY = 1\nMAX_ACCELERATION = 10\nENCODER_SCALE = 20000\nCOMP_FILE = screw.comp\nCOMP_FILE_TYPE = 1\n";

#[test]
fn linuxcnc_steppers_and_its_files() {
    let files = |name: &str| match name {
        "linuxcnc.var" => Ok("5161\t0.5\n5220 1\n5221 1.0\n5223 -2\n5241 99\n5242 3\n".to_owned()),
        "tool.tbl" => Ok("T1 P1 D0.25 Z+1.5 ;mill\nT2 P2 Z-0.1\n; none\n".to_owned()),
        "screw.comp" => {
            Ok("-1 0.001 0.000\n0 0.003 0.001\n1 0.0045 0.002\nend\n2 9 0\n".to_owned())
        }
        _ => Err("no such file".to_owned()),
    };
    let options = ImportOptions {
        files: &files,
        ..ImportOptions::default()
    };
    let (told, machine) = read_with("mill.ini", STEPGEN, &options).unwrap();
    let axis = |id| machine.axis(id).unwrap();
    let (x, z) = (axis(AxisId::X), axis(AxisId::Z));
    // 5080 steps of an inch are 200 of a mm: 16 mm at 16 microsteps.
    assert!(near(
        std::f64::consts::TAU / x.config.transmission.motor_rad_per_unit(),
        16.0
    ));
    assert!(near(machine.cycles().command_ms, 0.5) && near(machine.cycles().servo_us, 125.0));
    assert!(near(machine.planner().default_tolerance_mm, 0.02));
    // A length below 0 is none.
    assert_eq!(machine.tools().len(), 1);
    assert_eq!(fate(&told, "[EMCIO] TOOL_TABLE T2"), Fate::Ignored);
    assert!(near(machine.tools()[0].length_mm, 38.1) && near(machine.tools()[0].diameter_mm, 6.35));
    let [g54, g55, ..] = machine.work_offsets();
    assert!(near(g54[AxisId::X], 25.4) && near(g54[AxisId::Z], -50.8));
    // 99 inch lie outside the travel; Y has no axis.
    assert_eq!(g55[AxisId::X], 0.0);
    assert!(near(machine.home_g28()[AxisId::X], 12.7));
    // The control does it already, within its limits.
    assert!(near(x.config.gap_in_unit(), 0.0508));
    let own = &x.config.compensation;
    assert_eq!(own.method.name(), "fixed-linuxcnc");
    assert!(
        own.fixed_linuxcnc
            .velocity_units_s
            .is_some_and(|v| near(v, 50.8))
    );
    // The middle of 0.001, 0.002, 0.0025 inch, up to the first line that is no triplet.
    assert!(near(z.config.gap_in_unit(), 0.0508));
    // Not a stepper: the mill's servo.
    assert!(near(
        std::f64::consts::TAU / z.config.transmission.motor_rad_per_unit(),
        16.0
    ));
    assert!(z.config.drive.velocity_time_s < 1.0 && x.config.drive.velocity_time_s > 100.0);
    let note = |key: &str| &told.rows.iter().find(|row| row.key == key).unwrap().note;
    assert!(note("[JOINT_0] STEPGEN_MAXACCEL").starts_with("1.10 times MAX_ACCELERATION"));
    for (file, text, says) in [
        (
            "tool.tbl",
            "T1 Z1..2\n",
            "`1..2` is not a number (line 1 of tool.tbl)",
        ),
        (
            "linuxcnc.var",
            "5221 far\n",
            "`far` is not a number (line 1 of linuxcnc.var)",
        ),
        (
            "screw.comp",
            "1 0 0\n0 0 0\n",
            "positions have to rise (line 2 of screw.comp)",
        ),
        ("screw.comp", "\u{1}\u{2}\n", "the first line is no triplet"),
    ] {
        let bad = |name: &str| {
            if name == file {
                Ok(text.to_owned())
            } else {
                files(name)
            }
        };
        let options = ImportOptions {
            files: &bad,
            ..ImportOptions::default()
        };
        let error = read_with("mill.ini", STEPGEN, &options).unwrap_err();
        assert!(error.contains(says), "{error}");
    }
}

/// A lathe whose module is not told its coordinates: Z is joint 2, whatever [TRAJ] says, and joint 1 of
/// nobody.
#[test]
fn a_lathe_has_its_z_on_joint_2() {
    let joint = |index: usize, velocity: f64| {
        format!(
            "[JOINT_{index}]\nMIN_LIMIT = -10\nMAX_LIMIT = 100\nMAX_VELOCITY = {velocity}\nMAX_ACCELERATION = 300\nSTEP_SCALE = 400\nBACKLASH = 0.0{index}\n"
        )
    };
    let text = format!(
        "[KINS]\nKINEMATICS = trivkins\nJOINTS = 3\n[TRAJ]\nCOORDINATES = X Z\n{}{}{}",
        joint(0, 20.0),
        joint(1, 7.0),
        joint(2, 30.0)
    );
    let (told, machine) = read("lathe.ini", &text);
    let ids: Vec<AxisId> = machine.axes().iter().map(|axis| axis.id).collect();
    assert_eq!(ids, [AxisId::X, AxisId::Z]);
    let z = machine.axis(AxisId::Z).unwrap();
    assert_eq!(z.limits.velocity, 30.0);
    assert!(near(z.config.gap_in_unit(), 0.02));
    assert_eq!(fate(&told, "[JOINT_1] MAX_VELOCITY"), Fate::Ignored);
    // A BACKLASH of 0 says that nothing is compensated, and nothing of the machine.
    assert_eq!(fate(&told, "[JOINT_0] BACKLASH"), Fate::Ignored);
    let x = machine.axis(AxisId::X).unwrap();
    assert!(x.config.gap_in_unit() > 0.0 && x.config.compensation.method.is_baseline());
}

/// Generators that only HAL has, limits that it sets, and what of it is not read.
#[test]
fn linuxcnc_steppers_of_hal() {
    let joint = |index: usize, more: &str| {
        format!(
            "[JOINT_{index}]\nMIN_LIMIT = 0\nMAX_LIMIT = 300\nMAX_VELOCITY = 30\nMAX_ACCELERATION = 300\nBACKLASH = 0.02\n{more}"
        )
    };
    let ini = |more: &str| {
        let joints: String = (0..3).map(|index| joint(index, more)).collect();
        format!(
            "[KINS]\nKINEMATICS = trivkins\n[HAL]\nHALCMD = setp ini.1.backlash 0.07\nHALCMD = setp ini.1.jerk 7\nHALFILE = x.hal\nHALFILE = gone.hal\n{joints}"
        )
    };
    let with = |text: &str, hal: &str| {
        let files = |name: &str| match name {
            "x.hal" => Ok(hal.to_owned()),
            _ => Err("no such file".to_owned()),
        };
        let options = ImportOptions {
            files: &files,
            ..ImportOptions::default()
        };
        read_with("mill.ini", text, &options).unwrap()
    };
    let turn = |machine: &Machine, id| {
        let config = &machine.axis(id).unwrap().config;
        // Open loop: no integral part.
        (config.drive.velocity_time_s > 100.0)
            .then(|| std::f64::consts::TAU / config.transmission.motor_rad_per_unit())
    };
    let all = |machine: &Machine| [AxisId::X, AxisId::Y, AxisId::Z].map(|id| turn(machine, id));
    let loaded = "loadrt stepgen step_type=0,0\nsetp stepgen.0.position-scale   400\nsetp ini.1.backlash 9 # a command counts more\n";
    let (told, machine) = with(&ini(""), loaded);
    let [x, y, z] = all(&machine);
    assert!(near(x.unwrap(), 8.0) && y.is_some() && z.is_none());
    assert!(guesses(&told).contains(&"axis.y.transmission"));
    assert_eq!(
        fate(&told, "[HAL] setp stepgen.0.position-scale"),
        Fate::Used
    );
    let gap = |id| machine.axis(id).unwrap().config.gap_in_unit();
    assert!(near(gap(AxisId::X), 0.02) && near(gap(AxisId::Y), 0.07));
    let rows = |key: &str| -> Vec<_> {
        let rows = told.rows.iter().filter(|row| row.key == key);
        rows.map(|row| (row.value.as_str(), row.fate, row.note.as_str()))
            .collect()
    };
    assert_eq!(
        rows("[JOINT_1] BACKLASH"),
        [("0.02", Fate::Ignored, "[HAL] setp ini.1.backlash counts")]
    );
    assert_eq!(
        rows("[HAL] setp ini.1.jerk"),
        [("7", Fate::Ignored, "no limit that is read")]
    );
    let note = "read for step generators, their joints, limits and pins of kinematics";
    assert_eq!(
        rows("[HAL] HALFILE"),
        [
            ("x.hal", Fate::Used, note),
            ("gone.hal", Fate::Ignored, "not read (no such file)")
        ]
    );
    // The INI file's steps by HAL's reference, those of a card, and a pin alone.
    let card =
        "setp hm2_7i76e.0.stepgen.00.position-scale [JOINT_0]MY_STEPS\nnet on stepgen.2.enable\n";
    let (told, machine) = with(&ini("MY_STEPS = 160\n"), card);
    let [x, y, z] = all(&machine);
    assert!(near(x.unwrap(), 20.0) && y.is_none() && z.is_some());
    assert_eq!(fate(&told, "[JOINT_0] MY_STEPS"), Fate::Used);
    // What HAL sets itself goes before the INI file's.
    let (told, machine) = with(&ini("SCALE = 50\n"), loaded);
    assert!(near(turn(&machine, AxisId::X).unwrap(), 8.0));
    let row = told
        .rows
        .iter()
        .find(|row| row.key == "[JOINT_0] SCALE")
        .unwrap();
    assert_eq!(row.note, "[HAL] setp stepgen.0.position-scale counts");
    // Whose a generator is, the nets tell: a lathe's second is that of joint 2, and a servo has none.
    let nets = "loadrt stepgen step_type=0,0\nsetp stepgen.0.position-scale 400\nsetp stepgen.1.position-scale 800\nnet x joint.0.motor-pos-cmd => stepgen.0.position-cmd\nnet z joint.2.motor-pos-cmd => pid.z.command\nnet z-out pid.z.output => stepgen.1.velocity-cmd\nnet y joint.1.motor-pos-cmd => pid.y.command\nnet y-out pid.y.output => pwmgen.0.value\n";
    for more in ["", "SCALE = 50\n"] {
        let (told, machine) = with(&ini(more), nets);
        let [x, y, z] = all(&machine);
        assert!(near(x.unwrap(), 8.0) && y.is_none() && near(z.unwrap(), 4.0));
        assert_eq!(
            fate(&told, "[HAL] setp stepgen.1.position-scale"),
            Fate::Used
        );
    }
    // Files that others source, and one that sources itself; what is set once the screen has begun.
    let nested = |name: &str| match name {
        "x.hal" => Ok("source y.hal\n".to_owned()),
        "y.hal" => Ok(format!("{loaded}source y.hal\n")),
        "late.hal" => Ok("setp stepgen.0.position-scale 160\n".to_owned()),
        _ => Err("no such file".to_owned()),
    };
    let options = ImportOptions {
        files: &nested,
        ..ImportOptions::default()
    };
    let text = ini("").replace("[JOINT_0]", "[HAL]\nPOSTGUI_HALFILE = late.hal\n[JOINT_0]");
    let (told, machine) = read_with("mill.ini", &text, &options).unwrap();
    assert!(near(turn(&machine, AxisId::X).unwrap(), 20.0));
    let deep = told.rows.iter().filter(|row| row.key == "[HAL] source");
    let deep: Vec<_> = deep.map(|row| (row.value.as_str(), row.fate)).collect();
    assert_eq!(deep.first(), Some(&("y.hal", Fate::Used)));
    assert_eq!(deep.last().map(|row| row.1), Some(Fate::Ignored));
    assert_eq!(fate(&told, "[HAL] POSTGUI_HALFILE"), Fate::Used);
    // Of one name twice in a section LinuxCNC finds the first.
    let twice = ini("BACKLASH = 0.5\nMAX_ACCELERATION = 900\n");
    let (told, machine) = with(&twice, "");
    let x = machine.axis(AxisId::X).unwrap();
    assert!(near(x.config.gap_in_unit(), 0.02) && near(x.limits.acceleration, 300.0));
    let is_second =
        |row: &&Row| (row.key.as_str(), row.value.as_str()) == ("[JOINT_0] BACKLASH", "0.5");
    let row = told.rows.iter().find(is_second).unwrap();
    assert_eq!(row.note, "axis X: LinuxCNC takes the first of one name");
    // The INI file alone: a generator whose steps it does not tell.
    let (told, machine) = with(&ini("STEPGEN_MAXACCEL = 400\n"), "");
    assert!(all(&machine).iter().all(Option::is_some));
    assert!(guesses(&told).contains(&"axis.x.transmission"));
}

/// A bound is settable.
#[test]
fn a_description_that_is_too_long_is_refused() {
    let short = ImportOptions {
        max_bytes: 100,
        ..ImportOptions::default()
    };
    let error = read_with("printer.cfg", KLIPPER, &short).unwrap_err();
    assert!(
        error.contains("more than 100 are no description of a machine"),
        "{error}"
    );
}

/// Files as long as they may be, of lines that look further back each: no time that grows with the
/// square of the length, which would be hours.
#[test]
fn long_descriptions_end() {
    let long = |line: &dyn Fn(usize) -> String| -> String {
        let mut text = String::new();
        let mut index = 0;
        while text.len() < 2_000_000 {
            text.push_str(&line(index));
            index += 1;
        }
        text
    };
    let texts = [
        ("klipper", long(&|n| format!("[a{n}]\nb: 1\n"))),
        (
            "klipper",
            format!("[printer]\n{}", long(&|_| "max_velocity: 9\n".to_owned())),
        ),
        (
            "fluidnc",
            format!("axes:\n x:\n{}", long(&|n| format!("  k{n}: 1\n"))),
        ),
        ("duet", long(&|n| format!("M92 X{n}1\n"))),
        ("marlin", long(&|n| format!("#define X_MAX_POS A{n}\n"))),
        // Names that stand for twice themselves, and conditions on them.
        (
            "marlin",
            long(&|n| format!("#define A{} A{n} + A{n}\n#if A{n}\n#endif\n", n + 1)),
        ),
        ("grbl", long(&|n| format!("${}=1\n", n + 1000))),
        (
            "linuxcnc",
            format!("[JOINT_0]\n{}", long(&|_| "MAX_VELOCITY=9\n".to_owned())),
        ),
        (
            "linuxcnc",
            format!("[JOINT_0]\n{}", long(&|_| "SCALE=9\n".to_owned())),
        ),
        (
            "sinumerik",
            long(&|n| format!("$MA_MAX_AX_VELO[AX{n}]=1\n")),
        ),
        ("fanuc", long(&|n| format!("N01420Q1A1P{n}\n"))),
        ("twincat", long(&|_| "<Axis><Name>X</Name>".to_owned())),
        ("mtconnect", long(&|_| "<Linear name=\"X\">".to_owned())),
    ];
    for (name, text) in texts {
        let (_, format) = ImportFormat::NAMES
            .into_iter()
            .find(|(own, _)| *own == name)
            .unwrap();
        let _ = import("long", &text, format, &ImportOptions::default());
    }
}
