//! What was measured on a machine: logs of programs, ballbar's sheets, and the programs to run.

use crate::bench::Bench;
use lostmotion::base::math;

const PART: &str = "G21 G90 G17 G64 P0.02\nG0 X0 Y0 Z5\nG1 Z0 F600\nG1 X40 F3000\nG1 Y25\nG3 X20 Y45 I-20 J0\nG1 X-10\nG1 X-25 Y10\nG0 Z20\nM2\n";

/// A ballbar's sheet of both senses: 10 um of lost motion in X, 40 um/m out of square.
pub(crate) fn sheet() -> String {
    let mut text = "angle_deg,radius_mm\n".to_owned();
    let there = (0..=720).map(|n| (n, 1.0));
    let back = (0..=720).rev().map(|n| (n, -1.0));
    for (half, sense) in there.chain(back) {
        let deg = 0.5 * f64::from(half);
        let (sin, cos) = math::sin_cos((deg + 0.01 * sense).to_radians());
        let off_mm = 0.005 * sense * sin.signum() * cos + 100.0 * 40e-6 * sin * cos;
        text += &format!("{deg},{:.5}\n", 100.0 + off_mm);
    }
    text
}

/// A bench with the part, and its plan as a log.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.file("part.ngc", PART);
    bench.expect(
        0,
        &["plan", "part.ngc", "-m", "bench3", "--out", "log.csv", "-q"],
    );
    bench
}

/// Columns of a log as text, changed: time in s, positions in mm.
fn rows(bench: &Bench) -> Vec<[f64; 4]> {
    let text = std::fs::read_to_string(bench.path("log.csv")).unwrap();
    text.lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<f64> = line
                .split(',')
                .take(4)
                .map(|cell| cell.parse().unwrap())
                .collect();
            [cells[0], cells[1], cells[2], cells[3]]
        })
        .collect()
}

/// The axis whose motion [`driven`] has.
const WORN: &str = "vmc3-worn:x";

/// A bench with the motion of a worn axis on two sines, as `run.csv`.
fn driven() -> Bench {
    let bench = Bench::new();
    let mut setpoints = "t_s,position_mm\n".to_owned();
    for tick in 0..16_000 {
        let t = 1e-3 * f64::from(tick);
        let place = 60.0 * math::sin(1.3 * t) + 20.0 * math::sin(4.1 * t);
        setpoints += &format!("{t:.3},{place:.6}\n");
    }
    bench.file("setpoints.csv", &setpoints);
    let run = ["axis", "run", "--setpoints", "setpoints.csv"];
    let rest = ["--out", "run.csv", "--axis", WORN];
    bench.expect(0, &[run, rest].concat());
    bench
}

/// A log of it: motor, load, and one more column of the run, by its number from 0, times a factor.
fn log_with(bench: &Bench, name: &str, column: usize, factor: f64) {
    let text = std::fs::read_to_string(bench.path("run.csv")).unwrap();
    let mut log = format!("t_s,motor_mm,load_mm,{name}\n");
    for line in text.lines().skip(1).step_by(4) {
        let cells: Vec<&str> = line.split(',').collect();
        let value = factor * cells[column].parse::<f64>().unwrap();
        log += &format!("{},{},{},{value}\n", cells[0], cells[4], cells[6]);
    }
    bench.file("log.csv", &log);
}

/// The gap is found from a torque as from a current, and written with how well it is known: what a guess said
/// of that before is gone. A fit prints its result though it is quiet.
#[test]
fn a_gap_is_told_with_its_interval() {
    let bench = driven();
    let shown = bench.expect(0, &["machine", "show", "vmc3-worn"]);
    let guessed = format!("{shown}\n[axis.x.compensation]\ngap_uncertainty = 0.9\n");
    bench.file("guessed.toml", guessed);
    let guess = ["--axis", "guessed.toml:x"];
    for (name, column) in [("current_a", 8), ("torque_nm", 9)] {
        log_with(&bench, name, column, 1.0);
        let identify = ["axis", "identify", "log.csv", "--out", "found.toml"];
        bench.expect(0, &[&identify[..], &guess].concat());
        let found = std::fs::read_to_string(bench.path("found.toml")).unwrap();
        let of = |key: &str| {
            let line = found.lines().find(|line| line.starts_with(key)).unwrap();
            let (_, value) = line.split_once(" = ").unwrap();
            value.split(' ').next().unwrap().parse::<f64>().unwrap()
        };
        assert!((of("gap_um") - 40.0).abs() < 0.1, "{found}");
        let uncertainty = of("gap_uncertainty");
        assert!((1e-4..0.02).contains(&uncertainty), "{found}");
    }
    log_with(&bench, "current_a", 8, 1.0);
    let fit = ["axis", "fit", "log.csv", "-q", "--out", "fit.json"];
    let told = bench.expect(0, &[&fit[..], &["--axis", WORN]].concat());
    assert!(
        told.contains("gap 0.0399") || told.contains("gap 0.0400"),
        "{told}"
    );
}

/// All that is lost holds the described gap where the gap itself is not told; a motor in another unit than its
/// command is none of a thousand tons.
#[test]
fn what_no_gap_and_no_unit_explains_is_said() {
    let bench = driven();
    let shown = bench.expect(0, &["machine", "show", "vmc3-worn"]);
    assert!(shown.contains("gap_um = 40.0"), "{shown}");
    bench.file(
        "wide.toml",
        shown.replace("gap_um = 40.0", "gap_um = 400.0"),
    );
    log_with(&bench, "current_a", 8, 1.0);
    let log = std::fs::read_to_string(bench.path("log.csv")).unwrap();
    let rows = |row: &dyn Fn(&[&str]) -> String| -> String {
        let rows = log.lines().skip(1);
        rows.map(|line| row(&line.split(',').collect::<Vec<&str>>()))
            .collect()
    };
    let still = rows(&|cells| format!("{},{},{}\n", cells[0], cells[1], cells[2]));
    bench.file("still.csv", format!("t_s,motor_mm,load_mm\n{still}"));
    let check = ["axis", "identify", "still.csv", "--check", "--axis"];
    let told = bench.expect(1, &[&check[..], &["wide.toml:x"]].concat());
    assert!(
        told.contains("gap: described 400 um, of which a lost motion of at most")
            && told.contains("DIFFERS"),
        "{told}"
    );
    let told = bench.expect(1, &[&check[..], &[WORN]].concat());
    assert!(!told.contains("DIFFERS"), "{told}");
    let metres = rows(&|cells| {
        let motor: f64 = cells[1].parse().unwrap();
        format!("{},{},{:.9}\n", cells[0], cells[1], 1e-3 * motor)
    });
    bench.file("metres.csv", format!("t_s,command_mm,motor_mm\n{metres}"));
    bench.refuses(
        &["axis", "identify", "metres.csv"],
        &["0.001000 times as far as its command", "in different units"],
    );
}

/// A current that looks like percent, or is off by any factor, is said to, and nothing of it is written; as it
/// is, it is.
#[test]
fn what_is_in_doubtful_units_is_not_written() {
    let bench = driven();
    let axis = ["--axis", WORN];
    for (factor, doubt) in [
        (1.0, None),
        (9.0, Some("the current looks like percent of the rated")),
        (
            3.6,
            Some("the current looks like percent of the drive's largest"),
        ),
        (1.95, Some("inertia and friction are off alike")),
    ] {
        log_with(&bench, "current_a", 8, factor);
        let identify = ["axis", "identify", "log.csv", "--out", "found.toml"];
        let told = bench.expect(0, &[&identify[..], &axis].concat());
        let found = std::fs::read_to_string(bench.path("found.toml")).unwrap();
        assert_eq!(
            found.contains("measured: log.csv"),
            doubt.is_none(),
            "{found}"
        );
        let said = "not written: what was measured, since ";
        assert_eq!(told.contains(said), doubt.is_some(), "{told}");
        assert!(
            doubt.is_none_or(|doubt| told.contains(&format!("{said}{doubt}"))),
            "{told}"
        );
    }
}

#[test]
fn a_log_is_found_in_its_program_and_judged() {
    let bench = bench();
    let whole = bench.expect(0, &["check-log", "log.csv", "part.ngc", "-m", "bench3"]);
    for part in [
        "log.csv in part.ngc on bench3, commanded positions\nwithin limits and tolerance",
        "place: lines 2 to 9, ",
        "a row every 1 ms",
        "coordinates: those of the machine",
        "worst blocks (8 of 8)",
    ] {
        assert!(whole.contains(part), "{part}: {whole}");
    }
    // As LinuxCNC's HALscope writes it, from the middle on, in inches, with another zero.
    let rows = rows(&bench);
    let mut scope = "# Sampling period is 2000000 ns\njoint.0.motor-pos-cmd;joint.1.motor-pos-cmd;joint.2.motor-pos-cmd\n".to_owned();
    for row in rows.iter().skip(1200).step_by(2) {
        let [x, y, z] = [row[1] + 12.5, row[2] - 3.25, row[3] + 7.0].map(|mm| mm / 25.4);
        scope += &format!("{x:.7};{y:.7};{z:.7}\n");
    }
    bench.file("scope.csv", scope);
    let found = bench.expect(
        0,
        &[
            "check-log",
            "scope.csv",
            "part.ngc",
            "-m",
            "bench3",
            "--unit",
            "inch",
        ],
    );
    assert!(
        found.contains("shifted against those of the machine by X 12.5000 Y -3.2500 Z 7.0000 mm"),
        "{found}"
    );
    assert!(
        found.contains("to 9, 0.000 to ") && found.contains("a row every 2 ms"),
        "{found}"
    );
    bench.refuses(
        &[
            "check-log",
            "scope.csv",
            "part.ngc",
            "-m",
            "bench3",
            "--unit",
            "inch",
            "--no-shift",
        ],
        &[
            "does not follow the program in the coordinates of the machine",
            "hint: leave out --no-shift",
        ],
    );
}

#[test]
fn limits_and_tolerance_that_are_exceeded_are_named_with_their_block() {
    let bench = bench();
    // The plan keeps 1000 mm/s2: 8.1 times what is allowed here.
    let text = bench.expect(
        1,
        &[
            "check-log",
            "log.csv",
            "part.ngc",
            "-m",
            "bench3",
            "--set",
            "axis.y.limits.acceleration_mm_s2=123.4568",
        ],
    );
    let verdict = text.lines().nth(1).unwrap();
    assert!(
        verdict.starts_with("OUTSIDE: acceleration of Y 8.1"),
        "{verdict}"
    );
    assert!(
        verdict.contains(" in line 5")
            || verdict.contains(" in line 6")
            || verdict.contains(" in line 8"),
        "{verdict}"
    );
    // The same log against a program that allows less.
    bench.file("tight.ngc", PART.replace("P0.02", "P0.008"));
    let text = bench.expect(
        1,
        &[
            "check-log",
            "log.csv",
            "tight.ngc",
            "-m",
            "bench3",
            "--top",
            "3",
        ],
    );
    let verdict = text.lines().nth(1).unwrap();
    assert!(
        verdict.contains("um off the path, 2.") && verdict.contains("times the 8.00 um allowed"),
        "{verdict}"
    );
    let json = bench.expect(
        1,
        &[
            "check-log",
            "log.csv",
            "tight.ngc",
            "-m",
            "bench3",
            "--format",
            "json",
        ],
    );
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["schema"], 1);
    assert_eq!(value["blocks"][0]["is_outside"], true);
    assert!(value["at_fault"].as_u64().unwrap() >= 1);
    // Measured positions may be off by the tolerance of the verdict as well.
    let measured = [
        "check-log",
        "log.csv",
        "tight.ngc",
        "-m",
        "bench3",
        "--kind",
        "measured",
    ];
    assert!(bench.expect(0, &measured).contains("measured positions"));
}

/// A beam that two motors drive has one position in the check; a single row that is off is left out.
#[test]
fn a_second_motor_is_not_told_and_a_row_that_is_off_is_left_out() {
    let bench = Bench::new();
    bench.file("part.ngc", PART);
    let plan = [
        "plan", "part.ngc", "-m", "gantry3", "--out", "log.csv", "-q",
    ];
    bench.expect(0, &plan);
    let mut text = "t_s,x_mm,y_mm,z_mm,y2_mm\n".to_owned();
    for (row, [t, x, y, z]) in rows(&bench).into_iter().enumerate() {
        let off = if row == 1000 { 5.0 } else { 0.0 };
        text += &format!("{t},{x},{},{z},{y}\n", y + off);
    }
    bench.file("two.csv", &text);
    let said = bench.expect(0, &["check-log", "two.csv", "part.ngc", "-m", "gantry3"]);
    assert!(
        said.contains("not told: what the second motor of axis Y does"),
        "{said}"
    );
}

#[test]
fn logs_that_cannot_be_checked_are_refused() {
    let bench = bench();
    bench.file("two.csv", "t_s,x_mm,y_mm\n0,0,0\n0.001,0,0\n0.002,0,1\n");
    bench.refuses(
        &["check-log", "two.csv", "part.ngc"],
        &[
            "no column is known to be the position of axis Z",
            "--column z=NAME,unit=mm",
        ],
    );
    bench.file(
        "still.csv",
        "t_s,x_mm,y_mm,z_mm\n0,0,0,0\n0.001,0,0,0\n0.002,0,0,0\n",
    );
    bench.refuses(
        &["check-log", "still.csv", "part.ngc"],
        &["the log hardly moves"],
    );
    bench.refuses(&["check-log", "none.csv", "part.ngc"], &["none.csv"]);
    bench.refuses(&["check-log", "log.csv", "none.ngc"], &["none.ngc"]);
    bench.refuses(
        &["check-log", "log.csv", "part.ngc", "--column", "motor=x_mm"],
        &["this log is of several axes"],
    );
    bench.refuses(
        &[
            "check-log",
            "log.csv",
            "part.ngc",
            "-m",
            "bench3",
            "--column",
            "x=x_mm,unit=deg",
        ],
        &["the position of axis X is an angle"],
    );
    bench.file(
        "other.ngc",
        "G21 G90\nG1 X5 Y80 F900\nX-30 Y-4\nG2 X-50 Y-24 I0 J-20\nM2\n",
    );
    bench.refuses(
        &["check-log", "log.csv", "other.ngc", "-m", "bench3"],
        &["does not follow the program anywhere"],
    );
    bench.file("bad.ngc", "G1 X1 Q\n");
    bench.refuses(&["check-log", "log.csv", "bad.ngc"], &["bad.ngc"]);
}

#[test]
fn a_sheet_tells_what_explains_it() {
    let bench = Bench::new();
    bench.file("bar.csv", sheet());
    let text = bench.expect(0, &["ballbar", "bar.csv"]);
    assert!(
        text.starts_with("bar.csv: circle of 100 mm in XY\n"),
        "{text}"
    );
    let value = |name: &str| -> f64 {
        let line = text.lines().find(|line| line.starts_with(name)).unwrap();
        line[name.len()..]
            .split_whitespace()
            .next()
            .unwrap()
            .parse()
            .unwrap()
    };
    assert!((value("lost motion of X") - 10.0).abs() < 0.1, "{text}");
    assert!(
        value("lost motion of Y").abs() < 0.1 && value("servo mismatch, X behind Y").abs() < 0.1,
        "{text}"
    );
    assert!(
        (value("squareness, Y towards X") - 40.0).abs() < 0.5,
        "{text}"
    );
    // Rows sorted by their angle whatever the sense.
    let rows = sheet();
    let rows: Vec<&str> = rows.lines().collect();
    let table = |rows: &mut dyn Iterator<Item = &&str>| {
        let rows: String = rows.map(|row| format!("{row}\n")).collect();
        format!("angle_deg,radius_mm\n{rows}")
    };
    bench.file("one.csv", table(&mut rows[1..722].iter()));
    bench.file("two.csv", table(&mut rows[722..].iter().rev()));
    bench.refuses(
        &["ballbar", "one.csv", "two.csv"],
        &["2 of them counter-clockwise", "--sense ccw,cw"],
    );
    let sorted = bench.expect(
        0,
        &["ballbar", "one.csv", "two.csv", "--sense", "ccw,cw", "-q"],
    );
    let explained = |text: &str| {
        text.split_once("what explains it")
            .map(|parts| parts.1.to_owned())
    };
    assert_eq!(explained(&sorted), explained(&text));
    bench.refuses(
        &["ballbar", "one.csv", "two.csv", "--sense", "cw"],
        &["2 circles, and --sense has 1"],
    );
    // One sense: deviations, with their radius told.
    let half = sheet()
        .lines()
        .take(722)
        .map(|line| format!("{line}\n"))
        .collect::<String>();
    bench.file("ccw.csv", half);
    let text = bench.expect(0, &["ballbar", "ccw.csv"]);
    assert!(
        text.contains("not told: squareness and servo mismatch: one sense of rotation"),
        "{text}"
    );
    // Beside a machine.
    let text = bench.expect(0, &["ballbar", "bar.csv", "-m", "bench3", "--feed", "500"]);
    assert!(
        text.contains("beside it bench3 as simulated at 500 mm/min")
            && text.contains("um RMS apart"),
        "{text}"
    );
}

#[test]
fn sheets_that_are_none_are_refused() {
    let bench = Bench::new();
    bench.file("bar.csv", sheet());
    bench.file(
        "dev.csv",
        (0..360).fold("angle_deg,deviation_um\n".to_owned(), |text, deg| {
            text + &format!("{deg},1\n")
        }),
    );
    bench.refuses(
        &["ballbar", "dev.csv"],
        &["do not tell the radius", "--radius-mm 150"],
    );
    // 100 mm in inches under a column of mm.
    bench.file(
        "inch.csv",
        (0..360).fold("angle_deg,radius_mm\n".to_owned(), |text, deg| {
            text + &format!("{deg},3.93737\n")
        }),
    );
    bench.refuses(
        &["ballbar", "inch.csv"],
        &["-63 um off 4 mm", "in inches 100.009 mm", "unit=in"],
    );
    bench.expect(
        0,
        &[
            "ballbar",
            "inch.csv",
            "--column",
            "radius=radius_mm,unit=in",
        ],
    );
    bench.file(
        "um.csv",
        (0..360).fold("angle_deg,radius_mm\n".to_owned(), |text, deg| {
            text + &format!("{deg},{}\n", 150_002 + deg % 2)
        }),
    );
    bench.refuses(
        &["ballbar", "um.csv"],
        &["longer than any ballbar", "radius=NAME,unit=um"],
    );
    bench.expect(
        0,
        &["ballbar", "um.csv", "--column", "radius=radius_mm,unit=um"],
    );
    bench.refuses(
        &["ballbar", "bar.csv", "--radius-mm", "150"],
        &["mm off the nominal 150 mm, farther than a ballbar travels"],
    );
    bench.refuses(
        &["ballbar", "bar.csv", "dev.csv", "--radius-mm", "100"],
        &["3 circles", "one circle of each sense"],
    );
    bench.refuses(
        &["ballbar", "bar.csv", "--radius-mm", "-1"],
        &["has to be positive"],
    );
    bench.refuses(
        &["ballbar", "bar.csv", "-m", "vmc3", "--plane", "zx"],
        &["in the plane XY alone"],
    );
    bench.refuses(
        &["ballbar", "bar.csv", "-m", "vmc3", "--feed", "90000"],
        &["takes more than half of the limits"],
    );
    bench.refuses(&["ballbar", "bar.csv", "--feed", "500"], &["--machine"]);
    bench.refuses(
        &["ballbar", "bar.csv", "--column", "time=1"],
        &["this is a ballbar's sheet"],
    );
    bench.file("empty.csv", "");
    bench.refuses(&["ballbar", "empty.csv"], &["the file is empty"]);
}

#[test]
fn test_programs_are_simulated_before_they_are_written() {
    let bench = Bench::new();
    bench.expect(
        0,
        &[
            "axis",
            "testpart",
            "--for",
            "ballbar",
            "-m",
            "bench3",
            "--dialect",
            "fanuc",
            "--out",
            "bar.nc",
        ],
    );
    bench.expect(
        0,
        &[
            "axis",
            "testpart",
            "--for",
            "circle",
            "-m",
            "bench3",
            "--dialect",
            "siemens",
            "--out",
            "circle.mpf",
        ],
    );
    let text = std::fs::read_to_string(bench.path("circle.mpf")).unwrap();
    assert!(text.starts_with("; circles of bench3"), "{text}");
    let text = std::fs::read_to_string(bench.path("bar.nc")).unwrap();
    assert!(
        text.starts_with("%\nO0001\n(") && text.ends_with("M30\n%\n"),
        "{text}"
    );
    // What is written is what `ballbar` simulates, and what a log of it is found in.
    let text = bench.expect(
        0,
        &[
            "axis", "testpart", "--for", "ballbar", "-m", "vmc3", "--feed", "1500",
        ],
    );
    assert!(text.contains("F1500") && text.ends_with("M2\n"), "{text}");
    bench.file("bar.ngc", &text);
    bench.expect(0, &["plan", "bar.ngc", "--out", "bar.csv", "-q"]);
    bench.expect(0, &["check-log", "bar.csv", "bar.ngc"]);
    bench.refuses(
        &["axis", "testpart", "--for", "ballbar"],
        &["name it: --machine"],
    );
    bench.refuses(
        &[
            "axis",
            "testpart",
            "--for",
            "ballbar",
            "-m",
            "vmc3",
            "--radius-mm",
            "900",
        ],
        &["the largest has 162.4 mm"],
    );
    bench.refuses(
        &["axis", "testpart", "--for", "friction", "-m", "delta"],
        &["one by one"],
    );
    bench.refuses(
        &[
            "axis",
            "testpart",
            "--for",
            "commission",
            "-m",
            "vmc3",
            "--dialect",
            "fanuc",
        ],
        &["LinuxCNC alone"],
    );
}

/// The commands that a drive interpolates between those of the control are no faster than the control's.
#[test]
fn a_trace_of_the_motors_keeps_the_limits_of_the_plan() {
    let bench = Bench::new();
    bench.file("part.ngc", PART);
    let simulate = ["simulate", "part.ngc", "-m", "vmc3", "-q"];
    // the part is out of tolerance
    bench.expect(
        1,
        &[&simulate[..], &["--trace-motors", "--out", "run"]].concat(),
    );
    let check = ["check-log", "run/motors.csv", "part.ngc", "-m", "vmc3"];
    let told = bench.expect(0, &check);
    assert!(!told.contains("OUTSIDE"), "{told}");
}

/// The last row of a recording that was cut, and lines that end as those of old Macs.
#[test]
fn ends_of_lines_are_told_or_read() {
    let bench = Bench::new();
    let mut log = "t_s,motor_mm,load_mm,current_a\n".to_owned();
    for tick in 0..200 {
        let t = 1e-3 * f64::from(tick);
        log += &format!("{t:.3},{t},{t},{}\n", 0.1 * t);
    }
    bench.file("cut.csv", format!("{log}0.2,0.2"));
    bench.refuses(
        &["axis", "identify", "cut.csv"],
        &[
            "line 202: 2 cells where the header has 4",
            "the file ends within a line",
        ],
    );
    bench.file("lf.csv", &log);
    bench.file("cr.csv", log.replace('\n', "\r"));
    let [lf, cr] = ["lf.csv", "cr.csv"].map(|name| {
        let told = bench.expect(0, &["axis", "log", name]);
        told.replace(name, "")
    });
    assert_eq!(lf, cr);
}
