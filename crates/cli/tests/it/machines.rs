//! Machines and single axes from the outside: what is listed, checked, run and fitted.

use crate::bench::{Bench, CIRCLE};

/// A line of a trace without the column of the load's position.
fn without_load(trace: &str, line: &str) -> String {
    let column = trace
        .lines()
        .next()
        .unwrap()
        .split(',')
        .position(|name| name == "load_mm")
        .unwrap();
    let cells: Vec<&str> = line
        .split(',')
        .enumerate()
        .filter(|(n, _)| *n != column)
        .map(|(_, cell)| cell)
        .collect();
    cells.join(",") + "\n"
}

#[test]
fn axis_runs_a_plan_and_fit_finds_its_gap() {
    let bench = Bench::new();
    let mut setpoints = String::from("t_s,position_mm\n");
    for tick in 0..4000_u32 {
        // 20 mm to and fro in 250 ms each, so that acceleration torque outweighs friction and
        // varies.
        let phase = f64::from(tick % 250) / 250.0;
        let way = phase * phase * phase * (10.0 - 15.0 * phase + 6.0 * phase * phase);
        let position = 20.0 * if tick / 250 % 2 == 0 { way } else { 1.0 - way };
        setpoints.push_str(&format!("{:.3},{position:.9}\n", f64::from(tick) * 1e-3));
    }
    bench.file("setpoints.csv", &setpoints);
    bench.expect(
        0,
        &[
            "axis",
            "--setpoints",
            "setpoints.csv",
            "--axis",
            "vmc3:x",
            "--method",
            "none",
            "--out",
            "trace.csv",
        ],
    );
    let trace = std::fs::read_to_string(bench.path("trace.csv")).unwrap();
    assert_eq!(trace.lines().count(), 1 + 4 * 4000);
    assert!(trace.lines().nth(2).unwrap().starts_with("0.000250,"));
    let text = bench.expect(
        0,
        &["fit", "trace.csv", "--axis", "vmc3:x", "--out", "fit.json"],
    );
    assert!(text.starts_with("gap "), "{text}");
    let fit: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(bench.path("fit.json")).unwrap()).unwrap();
    let gap = fit["gap"].as_f64().unwrap();
    assert!((gap - 0.010).abs() < 0.000_05, "{gap}");
    // the same without the load's column
    let motor: String = trace
        .lines()
        .map(|line| without_load(&trace, line))
        .collect();
    bench.file("motor.csv", &motor);
    let text = bench.expect(
        0,
        &[
            "fit",
            "motor.csv",
            "--motor-only",
            "--axis",
            "vmc3:x",
            "--out",
            "motor.json",
        ],
    );
    assert!(
        text.contains("\nload ") && text.contains("\nstiffness "),
        "{text}"
    );
    let found: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(bench.path("motor.json")).unwrap()).unwrap();
    let gap = found["gap"].as_f64().unwrap();
    assert!(
        (gap - 0.010).abs() < 0.000_2 && found["motor_only"] == true,
        "{gap}"
    );
    bench.refuses(
        &["fit", "motor.csv", "--axis", "vmc3:x", "--out", "x.json"],
        &["no column `load_mm`"],
    );
    bench.refuses(
        &["fit", "motor.csv", "--motor-only", "--out", "x.json"],
        &["--axis"],
    );
    bench.file("circle.ngc", CIRCLE);
    let told = [
        "compare",
        "circle.ngc",
        "--methods",
        "none,fixed",
        "--fitted",
        "x=fit.json",
    ];
    assert!(bench.expect(0, &told).contains("fixed"));
    let told = [
        "compare",
        "circle.ngc",
        "--methods",
        "fitted-lookup",
        "--fitted",
        "x=motor.json",
    ];
    assert!(bench.expect(0, &told).contains("fitted-lookup"));
    bench.refuses(
        &["compare", "circle.ngc", "--methods", "fitted-lookup"],
        &["needs a fitted gap", "--fitted AXIS=FILE.json"],
    );
    bench.refuses(
        &["simulate", "circle.ngc", "--method", "fitted-lookup"],
        &["needs a fitted gap"],
    );
    bench.refuses(
        &[
            "compare",
            "circle.ngc",
            "--methods",
            "none,fixed",
            "--fitted",
            "c=fit.json",
        ],
        &["has no axis C"],
    );
    bench.refuses(
        &[
            "axis",
            "--setpoints",
            "setpoints.csv",
            "--axis",
            "paper",
            "--out",
            "x.csv",
        ],
        &["are in mm", "is in rad"],
    );
    bench.refuses(
        &[
            "axis",
            "--setpoints",
            "setpoints.csv",
            "--axis",
            "vmc3:q",
            "--out",
            "x.csv",
        ],
        &["vmc3 has no axis \"q\"", "its axes: x, y, z"],
    );
    bench.refuses(
        &[
            "axis",
            "--setpoints",
            "setpoints.csv",
            "--axis",
            "vmc3:x",
            "--method",
            "m",
            "--out",
            "x.csv",
        ],
        &["\"m\"", "published"],
    );
    bench.file("gap.csv", "t_s,position\n0,1\n0.001,2\n0.003,x\n");
    bench.refuses(
        &[
            "axis",
            "--setpoints",
            "gap.csv",
            "--axis",
            "paper",
            "--out",
            "x.csv",
        ],
        &["gap.csv, line 4", "`x`", "not a number"],
    );
    bench.refuses(
        &["fit", "gap.csv", "--out", "x.json"],
        &["no column `motor_mm`"],
    );
}

/// A part's own motion is gentle and its strokes are few: what the fit finds has to hold the gap of
/// the preset, 10 um, or say why it cannot be told.
#[test]
fn the_log_of_a_part_tells_the_gap_or_why_not() {
    let bench = Bench::new();
    let part = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../gcode_samples/parts/inch_bracket.ngc"
    );
    bench.expect(0, &["plan", part, "-m", "vmc3", "-o", "plan.csv", "-q"]);
    for axis in ["x", "y"] {
        let (column, preset) = (format!("{axis}_mm"), format!("vmc3:{axis}"));
        bench.expect(
            0,
            &[
                "axis",
                "run",
                "--setpoints",
                "plan.csv",
                "--column",
                &column,
                "--axis",
                &preset,
                "-o",
                "trace.csv",
                "-q",
            ],
        );
        let fit = [
            "axis",
            "fit",
            "trace.csv",
            "-o",
            "fit.json",
            "--axis",
            &preset,
        ];
        let output = bench.run(&fit);
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            assert!(text.contains("cannot be told, because"), "{text}");
            continue;
        }
        let text = std::fs::read_to_string(bench.path("fit.json")).unwrap();
        let fit: serde_json::Value = serde_json::from_str(&text).unwrap();
        let [low, high] = [0, 1].map(|end| fit["gap_interval"][end].as_f64().unwrap());
        assert!(low <= 0.010 && 0.010 <= high, "{axis}: {low} to {high}");
        assert!(high - low < 0.001, "{axis}: {low} to {high}");
    }
}

/// The same from the motor alone: gap and stiffness of the preset, or why they cannot be told.
#[test]
fn the_log_of_a_part_tells_the_gap_from_the_motor_or_why_not() {
    let bench = Bench::new();
    let part = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../gcode_samples/parts/inch_bracket.ngc"
    );
    bench.expect(0, &["plan", part, "-m", "vmc3", "-o", "plan.csv", "-q"]);
    let run = ["axis", "run", "--setpoints", "plan.csv", "--column", "x_mm"];
    let run = [&run[..], &["--axis", "vmc3:x", "-o", "trace.csv", "-q"]].concat();
    bench.expect(0, &run);
    let fit = ["axis", "fit", "trace.csv", "-o", "fit.json", "--motor-only"];
    let output = bench.run(&[&fit[..], &["--axis", "vmc3:x"]].concat());
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains("cannot be told"), "{text}");
        return;
    }
    let text = std::fs::read_to_string(bench.path("fit.json")).unwrap();
    let fit: serde_json::Value = serde_json::from_str(&text).unwrap();
    let [low, high] = [0, 1].map(|end| fit["gap_interval"][end].as_f64().unwrap());
    assert!(low <= 0.010 && 0.010 <= high, "{low} to {high}");
    // The preset's shaft has 238 N/um.
    let [low, high] = [0, 1].map(|end| fit["stiffness"]["interval"][end].as_f64());
    assert!(
        low.is_none_or(|low| low <= 238.0) && high.is_none_or(|high| 238.0 <= high),
        "{low:?} to {high:?}"
    );
}

#[test]
fn machines_are_listed_shown_and_checked() {
    let bench = Bench::new();
    let list = bench.expect(0, &["machine", "list"]);
    assert!(list.contains("vmc3-worn") && list.contains("trunnion5") && list.contains("paper"));
    let shown = bench.expect(0, &["machine", "show", "vmc3"]);
    bench.file("mine.toml", &shown);
    assert!(
        bench
            .expect(0, &["machine", "check", "mine.toml"])
            .contains("\"vmc3\" is sound")
    );
    bench.file("circle.ngc", CIRCLE);
    bench.expect(
        0,
        &[
            "simulate",
            "circle.ngc",
            "--machine",
            "mine.toml",
            "--tolerance-um",
            "1000",
        ],
    );
    bench.file("bad.toml", shown.replace("gap_um", "gap_umm"));
    bench.refuses(
        &["machine", "check", "bad.toml"],
        &["bad.toml:", "gap_umm", "did you mean `gap_um`?"],
    );
    bench.file(
        "nan.toml",
        shown.replacen("tolerance_um = 20.0", "tolerance_um = nan", 1),
    );
    bench.refuses(
        &["simulate", "circle.ngc", "--machine", "nan.toml"],
        &["nan.toml:", "simulate.tolerance_um", "nan"],
    );
    let loops = bench.expect(0, &["machine", "check", "mine.toml"]);
    assert!(
        loops.contains("velocity loop")
            && loops.contains("in the gap")
            && loops.contains("none predicted, none simulated"),
        "{loops}"
    );
    let gain = "velocity_gain_a_s_per_rad = ";
    bench.file("wild.toml", shown.replacen(gain, &format!("{gain}3"), 1));
    bench.refuses(
        &["machine", "check", "wild.toml"],
        &[
            "wild.toml:",
            "axis.x.drive.velocity_gain",
            "unstable",
            "gain margin -",
            "has to be less than",
        ],
    );
    bench.refuses(
        &["machine", "show", "vmc9"],
        &["no machine \"vmc9\"", "vmc3-worn", "robot-joint"],
    );
}

#[test]
fn a_new_machine_keeps_the_comments_of_its_preset_and_is_checked() {
    let bench = Bench::new();
    bench.expect(
        0,
        &[
            "machine",
            "new",
            "mine",
            "--travel",
            "x=-500,0",
            "--travel",
            "z=10,200",
            "--gap",
            "25",
            "--gap",
            "z=4",
            "--velocity",
            "x=300",
            "--tolerance-um",
            "15",
            "-o",
            "mine.toml",
        ],
    );
    let text = std::fs::read_to_string(bench.path("mine.toml")).unwrap();
    for line in [
        "name = \"mine\"  # given",
        "min_mm = -500.0  # given",
        "gap_um = 25.0  # given",
        "gap_um = 4.0  # given",
        "velocity_mm_s = 300.0  # given",
        "tolerance_um = 15.0  # given",
        "# table on the saddle; screw 40 x 16 mm",
    ] {
        assert!(text.lines().any(|found| found == line), "{line}\n{text}");
    }
    bench.expect(0, &["machine", "check", "mine.toml"]);
    for preset in [
        "vmc4",
        "gantry3",
        "trunnion5",
        "corexy",
        "delta",
        "scara",
        "arm6",
        "bench3",
    ] {
        let text = bench.expect(
            0,
            &["machine", "new", "other", "--preset", preset, "--gap", "7"],
        );
        assert!(text.contains("name = \"other\"  # given"), "{preset}");
    }
    let plane = bench.expect(0, &["machine", "new", "plane", "--axes", "x,z"]);
    assert!(
        !plane.contains("[axis.y") && !plane.contains("\ny_mm"),
        "{plane}"
    );
    bench.refuses(
        &["machine", "new", "m", "--preset", "vmc9"],
        &["no machine \"vmc9\"", "vmc3"],
    );
    bench.refuses(
        &["machine", "new", "m", "--axes", "x,q"],
        &["has no axis q", "x, y, z"],
    );
    bench.refuses(
        &["machine", "new", "m", "--travel", "x=5"],
        &["AXIS=MIN,MAX", "hint"],
    );
    bench.refuses(
        &["machine", "new", "m", "--gap", "x=wide"],
        &["`wide` is not a number"],
    );
    bench.refuses(
        &["machine", "new", "m", "--travel", "x=5,-5"],
        &["axis.x.limits.max_mm", "the travel begins at 5"],
    );
}

#[test]
fn a_new_machine_refuses_numbers_that_are_none_and_axes_that_it_does_not_have() {
    let bench = Bench::new();
    for (option, value) in [
        ("--travel", "x=nan,0"),
        ("--travel", "x=0,nan"),
        ("--travel", "x=-inf,0"),
        ("--travel", "x=0,1e400"),
        ("--gap", "x=nan"),
        ("--gap", "inf"),
        ("--velocity", "nan"),
        ("--acceleration", "x=-inf"),
        ("--jerk", "x=1e400"),
    ] {
        bench.refuses(
            &["machine", "new", "m", option, value],
            &[
                &format!("error: {option} {value}: the value is "),
                "it has to be a finite number",
                "hint: ",
            ],
        );
    }
    bench.refuses(
        &["machine", "new", "m", "--tolerance-um", "nan"],
        &["--tolerance-um: the value is NaN", "a finite number"],
    );
    for option in [["--gap", "y=5"], ["--jerk", "Y=5"], ["--travel", "y=-5,5"]] {
        bench.refuses(
            &["machine", "new", "m", "--axes", "X,z", option[0], option[1]],
            &["--axes leaves axis", "name it in --axes"],
        );
    }
    for name in ["a\nb", "a\u{1}b", "a\u{7f}b"] {
        bench.refuses(
            &["machine", "new", name],
            &["the name is \"a\\", "one line of text"],
        );
    }
}

/// The lines of a new machine that were asked for, its name and description left out.
fn given(bench: &Bench, options: &[&str]) -> Vec<String> {
    let text = bench.expect(0, &[&["machine", "new", "m"], options].concat());
    bench.file("m.toml", &text);
    bench.expect(0, &["check", "empty.ngc", "-q", "-m", "m.toml"]);
    let lines = text
        .lines()
        .filter_map(|line| line.strip_suffix("  # given"));
    lines.skip(2).map(str::to_owned).collect()
}

#[test]
fn a_new_machine_takes_letters_in_either_case_and_moves_what_would_lie_outside() {
    let bench = Bench::new();
    bench.file("empty.ngc", "G21 G90 G17 G94 G54\nM2\n");
    assert_eq!(
        given(&bench, &["--axes", "X,Z"]),
        given(&bench, &["--axes", "x,z"])
    );
    // what a name may hold
    let name = "my \"mill\" \\ 2\u{200b}e\u{301}";
    let text = bench.expect(0, &["machine", "new", name]);
    bench.file("named.toml", &text);
    let said = bench.expect(0, &["check", "empty.ngc", "-m", "named.toml"]);
    assert!(said.contains(name), "{said}");
    // G54 to the middle, G55 at -321 too, and the tool change to the nearer end
    let short = ["--travel", "X=-300,0", "--gap", "X=3"];
    let expected = [
        "x_mm = -150.0",
        "x_mm = -150.0",
        "x_mm = -300.0",
        "min_mm = -300.0",
        "max_mm = 0.0",
        "gap_um = 3.0",
    ];
    assert_eq!(given(&bench, &short), expected);
    // G55 and the homes stay where they are inside
    assert_eq!(
        given(&bench, &["--travel", "x=-500,0"]),
        ["x_mm = -250.0", "min_mm = -500.0", "max_mm = 0.0"]
    );
    // towers, belts and arms: a word of the program is not the place of a joint
    for options in [
        ["--preset", "delta", "--travel", "x=0,900"],
        ["--preset", "corexy", "--travel", "x=-10,900"],
        ["--preset", "scara", "--travel", "a=-90,90"],
        ["--preset", "arm6", "--travel", "x=-90,90"],
    ] {
        let lines = given(&bench, &options);
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert!(lines[0].starts_with("min_") && lines[1].starts_with("max_"));
    }
}

#[test]
fn the_gap_of_a_beam_is_that_of_both_its_ends() {
    let bench = Bench::new();
    bench.file("empty.ngc", "G21 G90 G17 G94 G54\nM2\n");
    let like = |options: &[&str]| given(&bench, &[&["--preset", "gantry3"], options].concat());
    assert_eq!(
        like(&["--gap", "y=5"]),
        ["second_gap_um = 5.0", "gap_um = 5.0"]
    );
    assert_eq!(like(&["--gap", "x=5"]), ["gap_um = 5.0"]);
    // without its axis there is no beam
    assert_eq!(like(&["--axes", "x,z"]), [""; 0]);
    // arc seconds of a table
    let table = given(&bench, &["--preset", "vmc4", "--gap", "A=36"]);
    assert_eq!(table, ["gap_mdeg = 10.0"]);
}

/// The two commands agree on a drive that is unstable: the check refuses its file, and a run says
/// that the machine stops.
#[test]
fn an_unstable_drive_is_refused_by_the_check_and_stops_the_machine() {
    let bench = Bench::new();
    let shown = bench.expect(0, &["machine", "show", "vmc3"]);
    let gain = "velocity_gain_a_s_per_rad = 2.702";
    bench.file(
        "wild.toml",
        shown.replacen(gain, "velocity_gain_a_s_per_rad = 20.0", 1),
    );
    // Twice as slow: the motor is overloaded after 5 s.
    bench.file("circle.ngc", CIRCLE.replace("F1000", "F500"));
    let unstable = "the velocity loop is unstable";
    bench.refuses(&["machine", "check", "wild.toml"], &[unstable]);
    let simulate = ["simulate", "circle.ngc", "--machine", "wild.toml"];
    let text = bench.expect(1, &simulate);
    let verdict = text.lines().nth(1).unwrap_or_default();
    assert!(
        verdict.starts_with("the machine stops in line ")
            && verdict.contains("the motor of X is overloaded")
            && verdict.contains(unstable),
        "{text}"
    );
    let json = bench.expect(1, &[&simulate[..], &["--format", "json"]].concat());
    assert!(
        json.contains("\"stop\": {") && json.contains("\"within_tolerance\": false"),
        "{json}"
    );
    // Watched no more, the same axis goes on.
    let free = bench.expect(
        0,
        &[
            &simulate[..],
            &[
                "--tolerance-um",
                "100000",
                "--set",
                "axis.x.monitoring.following_error_units=0",
                "--set",
                "axis.x.monitoring.overtravel_units=0",
                "--set",
                "axis.x.monitoring.continuous_current_a=0",
                "--set",
                "axis.x.monitoring.at_limit_s=0",
            ],
        ]
        .concat(),
    );
    assert!(
        free.contains("within tolerance") && !free.contains("stops"),
        "{free}"
    );
    bench.refuses(
        &[
            &simulate[..],
            &["--set", "axis.x.monitoring.standstill_error_units=-1"],
        ]
        .concat(),
        &[
            "monitoring.standstill_error_units",
            "a finite number above 0",
        ],
    );
}

/// An imported printer runs, says what is a guess, and what to measure first.
#[test]
fn a_printer_is_imported_checked_and_measured() {
    let bench = Bench::new();
    bench
        .file("printer.cfg", "[stepper_x]\nmicrosteps: 16\nrotation_distance: 40\nposition_max: 200\n[stepper_y]\nmicrosteps: 16\nrotation_distance: 40\nposition_max: 200\n[printer]\nmax_velocity: 200\nmax_accel: 1000\n")
        .file("arc.ngc", "G21 G90 G17\nG0 X109 Y100\nG3 I-9 F900\nM2\n")
        .file("odd.txt", "nothing of a machine\n");
    let report = bench.expect(0, &["machine", "import", "printer.cfg", "--out", "m.toml"]);
    assert!(report.contains("guess") && report.contains("axis.x.motor"));
    let machine = std::fs::read_to_string(bench.path("m.toml")).unwrap();
    assert!(machine.contains("lead_mm = 40.0 # [stepper_x] rotation_distance"));
    let check = ["machine", "check", "m.toml", "--measure", "arc.ngc"];
    let text = bench.expect(0, &check);
    assert!(text.contains("what to measure first, for arc.ngc") && text.contains("guess"));
    let json = bench.expect(0, &[&check[..], &["--json"]].concat());
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(found["measure"].as_array().unwrap().len(), 5);
    bench.refuses(
        &[&check[..], &["--max-motion-s", "1"]].concat(),
        &["are more than 1 s of motion", "hint: "],
    );
    // Included files by a pattern.
    std::fs::create_dir(bench.path("parts")).unwrap();
    bench
        .file(
            "all.cfg",
            "[include parts/*.cfg]\n[printer]\nmax_velocity: 200\nmax_accel: 1000\n",
        )
        .file(
            "parts/x.cfg",
            "[stepper_x]\nmicrosteps: 16\nrotation_distance: 32\nposition_max: 200\n",
        )
        .file(
            "parts/y.cfg",
            "[stepper_y]\nmicrosteps: 16\nrotation_distance: 40\nposition_max: 200\n",
        )
        .file("parts/z.txt", "no description\n");
    bench.expect(0, &["machine", "import", "all.cfg", "--out", "all.toml"]);
    let machine = std::fs::read_to_string(bench.path("all.toml")).unwrap();
    assert!(machine.contains("lead_mm = 32.0 # [stepper_x] rotation_distance"));
    // Nor may the machine file take the place of one of them.
    bench.refuses(
        &["machine", "import", "all.cfg", "--out", "parts/x.cfg"],
        &["parts/x.cfg is the file that the description names"],
    );
    let part = std::fs::read_to_string(bench.path("parts/x.cfg")).unwrap();
    assert!(part.starts_with("[stepper_x]"));
    bench.refuses(
        &["machine", "import", "odd.txt"],
        &["the format is not recognised", "klipper, fluidnc, duet"],
    );
    bench.refuses(
        &["machine", "import", "printer.cfg", "--max-bytes", "9"],
        &["more than 9 are no description of a machine"],
    );
}
