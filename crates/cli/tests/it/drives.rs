//! `time`, and drives that are commanded in other ways, from the outside.

use std::path::Path;
use std::process::{Command, Output, Stdio};

const LINE: &str = "G21 G90 G61\nG0 X50\nG4 P0.25\nS500 M3\nG1 X0 F3000\nM5\nM2\n";

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lostmotion"));
    command
        .args(arguments)
        .current_dir(folder)
        // wide enough for every column, as in files
        .env("COLUMNS", "500")
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn part() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("line.ngc"), LINE).unwrap();
    folder
}

fn text(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
    if code == 2 {
        stderr
    } else {
        String::from_utf8(output.stdout).unwrap()
    }
}

/// G0 50 mm at 100 mm/s, 1 m/s2, 30 m/s3: 0.633 s; back at 50 mm/s: 1.083 s.
#[test]
fn time_is_told_as_text_json_and_tables() {
    let folder = part();
    let at = folder.path();
    let said = text(
        at,
        0,
        &[
            "time",
            "line.ngc",
            "--machine",
            "bench3",
            "--spindle-s",
            "1.5",
            "--out",
            "out",
        ],
    );
    for piece in [
        "cycle time: 4.967 s",
        "rapid     0.634",
        "dwell     0.249",
        "2 x 1.5 s, as told",
        "velocity limits +20 %",
        "G1 X0 F3000",
    ] {
        assert!(said.contains(piece), "`{piece}` is not in\n{said}");
    }
    assert_eq!(
        std::fs::read_to_string(at.join("out/time.txt")).unwrap(),
        said
    );
    let rows = std::fs::read_to_string(at.join("out/blocks.csv")).unwrap();
    assert!(
        rows.starts_with("segment,file,line,kind,start_s,time_s,limit,limit_share\n"),
        "{rows}"
    );
    assert_eq!(
        rows.lines()
            .skip(1)
            .map(|row| row.split(',').nth(3).unwrap())
            .collect::<Vec<_>>(),
        ["rapid", "dwell", "cutting"]
    );
    let json = text(
        at,
        0,
        &[
            "time",
            "line.ngc",
            "--machine",
            "bench3",
            "--format",
            "json",
            "--no-what-if",
            "--top",
            "1",
        ],
    );
    assert!(
        json.contains("\"what_if\": []") && json.contains("\"block_count\": 3"),
        "{json}"
    );
    assert_eq!(json.matches("\"start_s\"").count(), 1, "{json}");
    assert!(
        text(at, 2, &["time", "line.ngc", "--tool-change-s", "-1"])
            .contains("--tool-change-s is -1; it has to be a finite number, 0 or above")
    );
}

#[test]
fn drives_are_commanded_as_asked() {
    let folder = part();
    let at = folder.path();
    let simulate = |more: &[&str]| {
        let mut arguments = vec![
            "simulate",
            "line.ngc",
            "--machine",
            "bench3",
            "--format",
            "json",
        ];
        arguments.extend(more);
        text(at, 0, &arguments)
    };
    let usual = simulate(&[]);
    assert_eq!(
        simulate(&[
            "--interpolator",
            "quintic-hermite",
            "--command-ms",
            "1",
            "--servo-us",
            "250"
        ]),
        usual
    );
    assert_ne!(simulate(&["--interpolator", "x=linear"]), usual);
    assert_ne!(simulate(&["--servo-us", "125"]), usual);
    let refused = |more: &[&str]| {
        let mut arguments = vec!["simulate", "line.ngc", "--machine", "bench3"];
        arguments.extend(more);
        text(at, 2, &arguments)
    };
    assert!(refused(&["--interpolator", "lineal"]).contains("known interpolators: linear, "));
    assert!(refused(&["--interpolator", "w=linear"]).contains("has no axis \"w\""));
    assert!(refused(&["--servo-us", "300"]).contains("a whole fraction of the command's 1000 us"));
}

#[test]
fn plans_and_axes_take_other_cycles() {
    let folder = part();
    let at = folder.path();
    text(
        at,
        0,
        &[
            "plan",
            "line.ngc",
            "--machine",
            "bench3",
            "--command-ms",
            "2",
            "--out",
            "plan.csv",
        ],
    );
    let plan = std::fs::read_to_string(at.join("plan.csv")).unwrap();
    assert!(plan.lines().nth(2).unwrap().starts_with("0.002,"), "{plan}");
    let axis = |more: &[&str], code| {
        let mut arguments = vec![
            "axis",
            "--setpoints",
            "plan.csv",
            "--axis",
            "bench3:x",
            "--column",
            "x_mm",
            "--out",
            "axis.csv",
        ];
        arguments.extend(more);
        text(at, code, &arguments)
    };
    axis(
        &[
            "--command-ms",
            "2",
            "--servo-us",
            "62.5",
            "--interpolator",
            "catmull-rom",
        ],
        0,
    );
    let trace = std::fs::read_to_string(at.join("axis.csv")).unwrap();
    assert!(
        trace.lines().nth(2).unwrap().starts_with("0.000062500,"),
        "{}",
        trace.lines().nth(2).unwrap()
    );
    assert_eq!(trace.lines().count() - 1, (plan.lines().count() - 1) * 32);
    assert!(axis(&[], 2).contains("rows have to be 1 ms apart"));
    assert!(
        axis(&["--command-ms", "2", "--interpolator", "cubic-hermite"], 2)
            .contains("needs a column `velocity`")
    );
}

/// Back at 50 mm/s from 50 mm: held for good on the way there, the tool has not come back.
#[test]
fn the_operator_interferes() {
    let folder = part();
    let at = folder.path();
    let plan = |more: &[&str]| {
        let mut arguments = vec![
            "plan",
            "line.ngc",
            "--machine",
            "bench3",
            "--out",
            "plan.csv",
            "--quiet",
        ];
        arguments.extend(more);
        text(at, 0, &arguments);
        let rows = std::fs::read_to_string(at.join("plan.csv")).unwrap();
        let last: Vec<f64> = rows
            .lines()
            .last()
            .unwrap()
            .split(',')
            .take(2)
            .map(|cell| cell.parse().unwrap())
            .collect();
        (last[0], last[1])
    };
    let alone = plan(&[]);
    let held = plan(&["--at", "200ms=hold", "--at", "1.2s=resume"]);
    assert!(
        (held.0 - alone.0 - 1.0).abs() < 0.01 && held.1 == alone.1,
        "{held:?} {alone:?}"
    );
    let stopped = plan(&["--at", "200ms=stop"]);
    assert!(
        stopped.0 < 0.4 && (5.0..30.0).contains(&stopped.1),
        "{stopped:?}"
    );
    let optimal = plan(&["--quality", "optimal", "--at", "0=override:50"]);
    assert!(optimal.0 > 1.5 * alone.0, "{optimal:?}");
    assert!(
        text(
            at,
            0,
            &[
                "time",
                "line.ngc",
                "--machine",
                "bench3",
                "--at",
                "0.2=hold",
                "--at",
                "1=resume"
            ]
        )
        .contains("feed hold")
    );
    assert!(text(at, 2, &["simulate", "line.ngc", "--at", "soon=hold"]).contains("--at 3.2s=hold"));
}

#[test]
fn embedded_machines_are_checked_by_name() {
    let folder = part();
    let said = text(folder.path(), 0, &["machine", "check", "vmc3"]);
    assert!(
        said.starts_with("vmc3: machine \"vmc3\" is sound") && said.contains("Kv 1/s"),
        "{said}"
    );
    assert!(text(folder.path(), 2, &["machine", "check", "vmc9"]).contains("vmc9"));
}

/// Cells of a column of a table, by its name.
fn column(table: &str, name: &str) -> Vec<f64> {
    let mut lines = table.lines();
    let at = lines
        .next()
        .and_then(|header| header.split(',').position(|cell| cell == name))
        .unwrap();
    lines
        .map(|line| line.split(',').nth(at).unwrap().parse().unwrap())
        .collect()
}

#[test]
fn traces_have_every_tick_or_a_window_or_the_peaks() {
    let folder = part();
    let at = folder.path();
    let traces = |out: &str, more: &[&str]| {
        let mut arguments = vec![
            "simulate",
            "line.ngc",
            "-m",
            "bench3",
            "--trace",
            "--trace-motors",
            "--out",
            out,
        ];
        arguments.extend(more);
        text(at, 0, &arguments);
        ["contour.csv", "motors.csv"]
            .map(|name| std::fs::read_to_string(at.join(out).join(name)).unwrap())
    };
    let [contour, motors] = traces("all", &[]);
    let times = column(&contour, "t_s");
    assert!(
        times
            .windows(2)
            .all(|pair| (pair[1] - pair[0] - 250e-6).abs() < 1e-9)
    );
    assert_eq!(times, column(&motors, "t_s"));
    // Half of a gap of 20 um is missing on the way back; the tool is where error and foot say.
    let (load, reference) = (
        column(&motors, "x_load_mm"),
        column(&motors, "x_reference_mm"),
    );
    let last = load.len() - 1;
    assert!((load[last] - reference[last]).abs() < 0.05 && load[last].abs() < 0.05);
    assert!((column(&contour, "tool_x_mm")[last] - load[last]).abs() < 1e-6);
    // A window: the same rows and no others.
    let [window, _] = traces("window", &["--from", "0.5", "--to", "0.75"]);
    let inside = |time: &&f64| (0.5..=0.75).contains(*time);
    assert_eq!(
        column(&window, "t_s"),
        times.iter().filter(inside).copied().collect::<Vec<_>>()
    );
    // Thinned out: few rows, and the peaks of the full table.
    let [few, few_motors] = traces("few", &["--every", "400"]);
    let peak = |table: &str, name: &str| {
        column(table, name)
            .into_iter()
            .fold(0.0, |most: f64, value| most.max(value.abs()))
    };
    // Two sizes of the contour, three of each of the three motors.
    for (name, table, thin, sizes) in [
        ("error_um", &contour, &few, 2),
        ("backlash_um", &contour, &few, 2),
        ("x_current_a", &motors, &few_motors, 9),
    ] {
        assert_eq!(
            peak(table, name).to_bits(),
            peak(thin, name).to_bits(),
            "{name}"
        );
        assert!(thin.lines().count() <= 1 + sizes * times.len().div_ceil(400));
    }
}

/// Where three motors move at their own times, each one's peaks are in the thinned table.
#[test]
fn a_thinned_trace_keeps_the_peaks_of_every_motor() {
    let folder = part();
    let at = folder.path();
    let program = "G21 G17 G90 G94 G54\nG61.1\nG1 X6 F1500\nG1 Y4\nG1 Z-3 F600\n\
                   G1 X1 Y3 Z-1 F2000\nG1 Z0\nG1 X0 Y0\nM2\n";
    std::fs::write(at.join("space.ngc"), program).unwrap();
    let motors = |out: &str, more: &[&str]| {
        let mut arguments = vec!["simulate", "space.ngc", "--trace-motors", "--out", out];
        arguments.extend(more);
        text(at, 0, &arguments);
        std::fs::read_to_string(at.join(out).join("motors.csv")).unwrap()
    };
    let (full, thin) = (motors("all", &[]), motors("few", &["--every", "250"]));
    let groups = column(&full, "t_s").len().div_ceil(250);
    assert!(thin.lines().count() <= 1 + 9 * groups);
    for motor in ["x", "y", "z"] {
        let peaks = |table: &str| {
            let [reference, turned, load, current] =
                ["reference_mm", "motor_mm", "load_mm", "current_a"]
                    .map(|name| column(table, &format!("{motor}_{name}")));
            let largest = |values: &mut dyn Iterator<Item = f64>| {
                values.fold(0.0, |most: f64, value| most.max(value.abs()))
            };
            let apart =
                |a: &[f64], b: &[f64]| largest(&mut a.iter().zip(b).map(|(a, b)| a - b)).to_bits();
            [
                apart(&reference, &turned),
                apart(&reference, &load),
                largest(&mut current.into_iter()).to_bits(),
            ]
        };
        assert_eq!(peaks(&full), peaks(&thin), "{motor}");
    }
}

#[test]
fn what_thins_a_trace_out_needs_one() {
    let folder = part();
    let refused = |more: &[&str]| {
        let mut arguments = vec!["simulate", "line.ngc", "-m", "bench3"];
        arguments.extend(more);
        text(folder.path(), 2, &arguments)
    };
    assert!(refused(&["--from", "1"]).contains("--from is for --trace"));
    for (wrong, told) in [
        (["--every", "0"], "--every is 0; it has to be 1 or above"),
        (
            ["--to", "-1"],
            "--to is -1; it has to be at least --from, 0",
        ),
    ] {
        let mut more = vec!["--trace", "--out", "o"];
        more.extend(wrong);
        assert!(refused(&more).contains(told), "{}", refused(&more));
    }
    assert!(!folder.path().join("o").exists());
}
