//! Input by mistake: numbers that no machine has, options that contradict each other, outputs
//! that would destroy what is read.

use crate::bench::{Bench, CIRCLE};

#[test]
fn numbers_of_no_machine_are_refused_at_once() {
    let bench = Bench::new();
    bench.file("part.ngc", CIRCLE);
    // once a panic, an endless plan, or 300 digits
    for (command, option, value, said) in [
        ("simulate", "--bow-limit-um", "1e-300", "is 1e-300; it has"),
        ("time", "--bow-limit-um", "1e-9", "is 1e-9; it has"),
        ("simulate", "--tolerance-um", "1e300", "is 1e300; it has"),
        ("simulate", "--tolerance-um", "-1e300", "is -1e300; it has"),
        ("simulate", "--cutting-force-n", "1e300", "is 1e300; it has"),
        ("time", "--spline-tolerance-mm", "1e-300", "is 1e-300; it"),
        ("time", "--spindle-s", "1e308", "is 1e308; it has"),
        ("time", "--tool-change-s", "1e308", "is 1e308; it has"),
    ] {
        bench.refuses(
            &[command, "part.ngc", option, value],
            &[&format!("{option} {said}")],
        );
    }
    bench.refuses(
        &["plan", "part.ngc", "-o", "p.csv", "--command-ms", "1e-300"],
        &["command_ms is 1e-300; it has to be from 0.25 to 8"],
    );
    bench.refuses(
        &["simulate", "part.ngc", "--limit", "words=abc"],
        &["the limit `words` is `abc`; it has to be a whole number from 1"],
    );
    for gap in ["0", "nan", "1e-300"] {
        let coupler = ["--gap-rad", gap, "--stiffness-nm-per-rad", "100"];
        bench.refuses(
            &[&["study", "bench"], &coupler[..]].concat(),
            &["--gap-rad is", "it has to be from 0.000001 to 3"],
        );
    }
    // more force than a motor has throws the load out of any number
    bench.refuses(
        &["simulate", "part.ngc", "--cutting-force-n", "1e6"],
        &["is not finite", "hint: a simulated axis has run away"],
    );
    let deep = format!("{}=1", ["a"; 20_000].join("."));
    bench.refuses(
        &["simulate", "part.ngc", "--set", &deep],
        &["is not a key", "hint: a key is like axis.x"],
    );
    bench.file("far.csv", "t_s,position\n0,0\n0.001,1e300\n");
    bench.file("two.csv", "t_s,position,position\n0,0,1\n");
    for (file, said) in [
        (
            "far.csv",
            "far.csv, line 3, column `position`: `1e300` is beyond",
        ),
        (
            "two.csv",
            "two.csv, line 1: there are two columns `position`",
        ),
    ] {
        let run = ["axis", "run", "--setpoints", file, "--axis", "paper"];
        bench.refuses(&[&run[..], &["-o", "trace.csv"]].concat(), &[said]);
    }
}

#[test]
fn what_is_read_is_not_written_over() {
    let bench = Bench::new();
    bench
        .file("part.ngc", CIRCLE)
        .file("setpoints.csv", "t_s,position\n0,0\n0.001,0\n")
        .file("log.csv", "t_s,motor_mm,load_mm,current_a\n0,0,0,0\n")
        .file("grbl.txt", "$110=500\n");
    std::fs::create_dir(bench.path("folder")).unwrap();
    let run = ["axis", "run", "--axis", "paper", "--setpoints"];
    let cases: [(&[&str], &str, &str); 4] = [
        (&["plan", "part.ngc"], "part.ngc", "the part program"),
        (
            &[&run[..], &["setpoints.csv"]].concat(),
            "setpoints.csv",
            "the setpoint file",
        ),
        (&["axis", "fit", "log.csv"], "log.csv", "the log"),
        (
            &["machine", "import", "grbl.txt"],
            "grbl.txt",
            "the machine description",
        ),
    ];
    for (command, file, what) in cases {
        let before = std::fs::read(bench.path(file)).unwrap();
        let around = format!("folder/../{file}");
        for out in [file, around.as_str()] {
            bench.refuses(
                &[command, &["-o", out]].concat(),
                &[&format!("the output {out} is {what}"), "hint: "],
            );
        }
        assert_eq!(std::fs::read(bench.path(file)).unwrap(), before);
    }
    let cell = "circle5-f10000-ccw-g20-t10-v0-j1-e20-steady";
    bench.refuses(
        &["study", "cell", cell, "--out", "a", "--program", "a"],
        &["--out and --program are both a"],
    );
    // `-` is no folder, and is not made one
    bench.refuses(
        &["study", "matrix", "--cells", "1", "--out", "-"],
        &["the output is `-`; it has to be a folder"],
    );
}

#[test]
fn an_interpolator_of_an_axis_is_that_of_both_its_motors() {
    let bench = Bench::new();
    bench.file("part.ngc", CIRCLE);
    let run = |names: &[&str]| {
        let mut arguments = vec!["simulate", "part.ngc", "-m", "gantry3", "--format", "json"];
        for name in names {
            arguments.extend(["--interpolator", name]);
        }
        bench.expect(0, &arguments)
    };
    let both = run(&["y=b-spline"]);
    assert_eq!(both, run(&["y=b-spline", "y2=b-spline"]));
    // of two that speak of one motor the later one holds
    assert_eq!(both, run(&["y2=linear", "Y=b-spline"]));
    assert_ne!(both, run(&["y=b-spline", "y2=quintic-hermite"]));
    assert_eq!(run(&[]), run(&["y2=quintic-hermite"]));
    bench.refuses(
        &["simulate", "part.ngc", "--interpolator", "y2=linear"],
        &["\"vmc3\" has no axis \"y2\"", "its axes: x, y, z"],
    );
}

/// A result of `axis fit` for an axis in mm.
fn fit(gap_mm: &str) -> String {
    format!(
        r#"{{"schema": 1, "log": "log.csv", "unit": "mm", "gap": {gap_mm}, "gap_interval": [0, 1],
        "excited": true, "motor_rad_per_unit": null, "motor_only": false, "fit": FIT}}"#
    )
}

#[test]
fn fits_of_another_axis_and_two_of_one_are_refused() {
    let bench = Bench::new();
    bench.file("part.ngc", CIRCLE);
    let mut setpoints = String::from("t_s,position_mm\n");
    for tick in 0..2000_u32 {
        let phase = f64::from(tick % 250) / 250.0;
        let way = phase * phase * phase * (10.0 - 15.0 * phase + 6.0 * phase * phase);
        let position = 20.0 * if tick / 250 % 2 == 0 { way } else { 1.0 - way };
        setpoints.push_str(&format!("{:.3},{position:.9}\n", f64::from(tick) * 1e-3));
    }
    bench.file("setpoints.csv", &setpoints);
    let axis = ["--axis", "vmc3:x"];
    let run = ["axis", "run", "--setpoints", "setpoints.csv"];
    bench.expect(0, &[&run[..], &axis, &["-o", "trace.csv"]].concat());
    bench.expect(
        0,
        &[&["axis", "fit", "trace.csv", "-o", "fit.json"][..], &axis].concat(),
    );
    let text = std::fs::read_to_string(bench.path("fit.json")).unwrap();
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    for gap in ["1e300", "150.0"] {
        bench.file(
            "far.json",
            fit(gap).replace("FIT", &found["fit"].to_string()),
        );
        bench.refuses(
            &["simulate", "part.ngc", "--fitted", "x=far.json"],
            &["far.json: gap is", "mm, which the axis cannot have"],
        );
    }
    let twice = ["--fitted", "x=fit.json", "--fitted", "X=fit.json"];
    bench.refuses(
        &[&["simulate", "part.ngc"], &twice[..]].concat(),
        &["axis x has a fit already"],
    );
}
