//! `--learned`, `--save-learned`, `axis commission` and `study cell` of a drawn cell, from the outside.

use crate::bench::{Bench, CIRCLE};

#[test]
fn an_axis_is_commissioned_and_the_part_starts_from_what_it_learned() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let commission = [
        "axis",
        "commission",
        "vmc3-worn",
        "--learned-out",
        "worn.toml",
        "--gcode",
        "commission.ngc",
    ];
    let said = bench.expect(0, &commission);
    for piece in [
        "axis x:",
        "gap, um",
        "load inertia",
        "95 %",
        "axis file",
        "good enough",
    ] {
        assert!(said.contains(piece), "{piece}: {said}");
    }
    let memory = std::fs::read_to_string(bench.path("worn.toml")).unwrap();
    for piece in [
        "version = 1",
        "[axis.z.learned]",
        "half_gap_rad",
        "[axis.x.learned_on]",
    ] {
        assert!(memory.contains(piece), "{piece}: {memory}");
    }
    // The program is one that the machine can run.
    bench.expect(0, &["gcode", "canon", "commission.ngc"]);
    let simulate = |more: &[&str]| -> f64 {
        let mut arguments = vec![
            "simulate",
            "circle.ngc",
            "-m",
            "vmc3-worn",
            "--method",
            "adaptive",
            "--tolerance-um",
            "500",
            "--format",
            "json",
        ];
        arguments.extend(more);
        let json: serde_json::Value = serde_json::from_str(&bench.expect(0, &arguments)).unwrap();
        json["result"]["backlash"]["rms"].as_f64().unwrap()
    };
    let cold = simulate(&["--save-learned", "after.toml"]);
    let warm = simulate(&["--learned", "worn.toml"]);
    assert!(warm < 0.5 * cold, "{warm} {cold}");
    // A run hands on what it knows; the first of a row has nothing to read.
    assert!(bench.path("after.toml").exists());
    let row = ["--learned", "row.toml", "--save-learned", "row.toml"];
    let first = simulate(&row);
    assert_eq!(first, cold);
    assert!(simulate(&row) < cold);
    // Two spellings of one file.
    let same = ["--learned", "./new.toml", "--save-learned", "new.toml"];
    assert_eq!(simulate(&same), cold);
}

#[test]
fn one_axis_alone_is_commissioned_by_its_setpoints_too() {
    let bench = Bench::new();
    bench.expect(
        0,
        &[
            "axis",
            "commission",
            "vmc3-worn:x",
            "--out",
            "x.csv",
            "--learned-out",
            "x.toml",
        ],
    );
    let run = [
        "axis",
        "run",
        "--setpoints",
        "x.csv",
        "--axis",
        "vmc3-worn:x",
        "--method",
        "adaptive",
        "--out",
        "trace.csv",
        "--learned",
        "x.toml",
        "--save-learned",
        "again.toml",
    ];
    bench.expect(0, &run);
    let gap = |name: &str| -> f64 {
        let text = std::fs::read_to_string(bench.path(name)).unwrap();
        let line = text
            .lines()
            .find(|line| line.starts_with("half_gap_rad"))
            .unwrap();
        line.split('=').nth(1).unwrap().trim().parse().unwrap()
    };
    assert!((gap("again.toml") / gap("x.toml") - 1.0).abs() < 0.02);
}

#[test]
fn an_axis_without_a_gap_is_commissioned_well() {
    let bench = Bench::new();
    let none = ["--set", "axis.x.load.slide.gap_um=0"];
    let said = bench.expect(0, &[&["axis", "commission", "vmc3:x"], &none[..]].concat());
    assert!(said.contains("\ngood enough"), "{said}");
}

#[test]
fn a_machine_that_stops_leaves_the_memory_as_it_was() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    bench.file("kept.toml", "version = 1\n");
    let stops = "axis.x.monitoring.following_error_units=0.001";
    let run = [
        "simulate",
        "circle.ngc",
        "-m",
        "vmc3-worn",
        "--method",
        "adaptive",
        "--set",
        stops,
        "--save-learned",
        "kept.toml",
    ];
    let out = bench.run(&run);
    let told = String::from_utf8_lossy(&out.stderr);
    assert!(
        told.contains("kept.toml is not written: the machine stops"),
        "{told}"
    );
    let kept = std::fs::read_to_string(bench.path("kept.toml")).unwrap();
    assert_eq!(kept, "version = 1\n");
}

#[test]
fn what_cannot_be_learned_from_is_refused_with_place_value_and_hint() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    bench.expect(
        0,
        &[
            "axis",
            "commission",
            "vmc3-worn:x",
            "--learned-out",
            "x.toml",
            "-q",
        ],
    );
    let text = std::fs::read_to_string(bench.path("x.toml")).unwrap();
    bench.file("other.toml", text.replace("lead_mm = ", "lead_mm = 1"));
    bench.file(
        "word.toml",
        text.replace("gap_readings = ", "gap_readings = -"),
    );
    bench.file("syntax.toml", "version = 1\n[axis.x.learned\n");
    let simulate = |more: &[&'static str]| {
        let mut arguments = vec!["simulate", "circle.ngc", "-m", "vmc3-worn"];
        arguments.extend(more);
        arguments
    };
    let adaptive = |file: &'static str| simulate(&["--method", "adaptive", "--learned", file]);
    bench.refuses(
        &adaptive("other.toml"),
        &[
            "other.toml:",
            "axis.x.learned_on.lead_mm",
            "it was learned on an axis with a lead of 1",
            "hint:",
        ],
    );
    bench.refuses(
        &adaptive("word.toml"),
        &["word.toml:", "axis.x.learned.gap_readings"],
    );
    bench.refuses(&adaptive("syntax.toml"), &["syntax.toml:2:"]);
    bench.refuses(&adaptive("missing.toml"), &["missing.toml does not exist"]);
    bench.refuses(
        &simulate(&["--method", "fixed", "--save-learned", "y.toml"]),
        &[
            "--save-learned y.toml: no method of this run learns",
            "--method adaptive",
        ],
    );
    bench.refuses(
        &simulate(&["--method", "fixed", "--learned", "x.toml"]),
        &["--learned x.toml: no method of this run learns"],
    );
    // A gap of 30 mm, which nobody looks for.
    let (head, tail) = text.split_once("half_gap_rad = ").unwrap();
    let (_, rest) = tail.split_once('\n').unwrap();
    bench.file("wide.toml", format!("{head}half_gap_rad = 3.0\n{rest}"));
    bench.refuses(
        &adaptive("wide.toml"),
        &["wide.toml:", "axis.x.learned.half_gap_rad", "from 0 to 0.3"],
    );
    // The memory of another axis.
    let run = [
        "axis",
        "run",
        "--setpoints",
        "x.csv",
        "--method",
        "adaptive",
    ];
    let of = |axis: &'static str| {
        let more = ["--axis", axis, "--out", "t.csv", "--learned", "x.toml"];
        [&run[..], &more].concat()
    };
    let setpoints = ["axis", "commission", "vmc3-worn:x", "--out", "x.csv", "-q"];
    bench.expect(0, &setpoints);
    bench.refuses(
        &of("vmc3-worn:y"),
        &[
            "x.toml: nothing of axis \"y\" has been learned",
            "its axes: x",
        ],
    );
    bench.expect(0, &of("vmc3-worn:x"));
    // An hour and a half that nobody asked for.
    let slow = ["--set", "axis.x.limits.velocity_mm_s=0.5"];
    bench.refuses(
        &[&["axis", "commission", "vmc3:x"], &slow[..]].concat(),
        &[
            "axis x: the motion takes 5239 s",
            "--at-most 600",
            "at 0.5 mm/s",
        ],
    );
    for wrong in ["nan", "-1"] {
        let at_most = format!("--at-most={wrong}");
        bench.refuses(
            &["axis", "commission", "vmc3:x", &at_most],
            &["--at-most is", "it has to be 0 s or more"],
        );
    }
    bench.refuses(
        &["axis", "commission", "vmc3-worn:q"],
        &["has no axis \"q\"", "x, y, z"],
    );
    bench.refuses(
        &["axis", "commission", "vmc3-worn", "--out", "all.csv"],
        &[
            "--out all.csv holds the setpoints of one axis",
            "vmc3-worn:x",
        ],
    );
    bench.refuses(
        &["axis", "commission", "scara", "--gcode", "arm.ngc"],
        &["--gcode arm.ngc", "kinematics \"scara\"", "--out"],
    );
}

#[test]
fn a_drawn_cell_says_what_was_known_and_when() {
    let bench = Bench::new();
    let said = bench.expect(0, &["study", "cell", "1-5", "--out", "cell.csv"]);
    for piece in [
        "1-5-circle43-f4525: ",
        "practical limit",
        "\nnone: backlash",
        "\nadaptive: backlash",
        "\nadaptive, warm: backlash",
        "gap not known: gap ",
        "control  lets the drives correct: foresees",
        "cause: ",
        "load known: inertia",
        "reading 1: ",
        "uses ",
    ] {
        assert!(said.contains(piece), "{piece}: {said}");
    }
    // The last line of each start names the cause.
    let last = said.lines().last().unwrap_or_default();
    assert!(last.starts_with("cause: "), "{said}");
    // A row every 50 ms of the cold and of the warm start: what is believed and what is true, a second before
    // the end.
    let rows = std::fs::read_to_string(bench.path("cell.csv")).unwrap();
    let mut rows = rows.lines();
    let columns: Vec<&str> = rows.next().unwrap().split(',').collect();
    let column = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    let starts = ["cold", "warm"].map(|start| {
        let of = rows
            .clone()
            .filter(|row| row.split(',').nth(1) == Some(start));
        let row: Vec<&str> = of.clone().nth_back(20).unwrap().split(',').collect();
        assert_eq!(row.len(), columns.len());
        let value = |name: &str| row[column(name)].parse::<f64>().unwrap();
        assert!(
            (value("x_gap_um") / value("x_gap_true_um") - 1.0).abs() < 0.02,
            "{row:?}"
        );
        assert!((value("x_inertia_over_true") - 1.0).abs() < 0.1, "{row:?}");
        assert_eq!(row[column("x_missing")], "while correcting");
        of.count()
    });
    assert!(starts[0] == starts[1] && starts[0] > 100, "{starts:?}");
    bench.refuses(
        &["study", "cell", "1-5-circle44-f4525"],
        &["1-5-circle44-f4525", "1-5-circle43-f4525"],
    );
    bench.refuses(&["study", "cell", "--seed", "1"], &["--cell"]);
    bench.expect(0, &["study", "drawn", "--cells", "1", "--export", "cells"]);
    let names = crate::bench::names(&bench.path("cells"));
    assert_eq!(names.len(), 3, "{names:?}");
    let of = |ending: &str| {
        let name = names.iter().find(|name| name.ends_with(ending)).unwrap();
        format!("cells/{name}")
    };
    let learned = of("learned.toml");
    let machine = learned.replace(".learned.toml", ".toml");
    // The part comes out outside its tolerance with either method.
    bench.expect(
        1,
        &[
            "simulate",
            &of(".ngc"),
            "-m",
            &machine,
            "--methods",
            "none,adaptive",
            "--learned",
            &learned,
            "--sensitivity",
            "0",
        ],
    );
}
