//! The program from the outside: exit codes, messages, files that appear or do not.

use crate::bench::{Bench, CIRCLE, names};
use std::process::Stdio;

#[test]
fn simulate_judges_against_the_tolerance() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let text = bench.expect(0, &["simulate", "circle.ngc", "--tolerance-um", "1000"]);
    assert!(
        text.contains("circle.ngc on vmc3, method none\nwithin tolerance: largest contour error"),
        "{text}"
    );
    assert!(
        text.contains("tolerance 1000 um")
            && text.contains("reversals, um")
            && !text.contains('\x1b')
    );
    let text = bench.expect(1, &["simulate", "circle.ngc", "--tolerance-um", "0.01"]);
    assert!(
        text.contains("OUTSIDE tolerance") && text.contains("line 3"),
        "{text}"
    );
    let json = bench.expect(
        1,
        &[
            "simulate",
            "circle.ngc",
            "--tolerance-um",
            "0.01",
            "--format",
            "json",
            "--threads",
            "1",
        ],
    );
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["schema"], 1);
    assert_eq!(value["result"]["method"], "none");
    assert_eq!(
        json,
        bench.expect(
            1,
            &[
                "simulate",
                "circle.ngc",
                "--tolerance-um",
                "0.01",
                "--format",
                "json",
                "--threads",
                "2"
            ]
        )
    );
}

#[test]
fn results_of_a_run_go_into_a_folder_together() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let shown = bench.expect(
        0,
        &[
            "simulate",
            "circle.ngc",
            "--tolerance-um",
            "1000",
            "--out",
            "a/b",
            "--trace",
            "--format",
            "json",
        ],
    );
    let expected = [
        "blocks.csv",
        "contour.csv",
        "contour.svg",
        "page.html",
        "reversals.csv",
        "simulation.json",
        "simulation.txt",
    ];
    assert_eq!(names(&bench.path("a/b")), expected);
    assert_eq!(
        std::fs::read_to_string(bench.path("a/b/simulation.json")).unwrap(),
        shown
    );
    let contour = std::fs::read_to_string(bench.path("a/b/contour.csv")).unwrap();
    assert!(contour.starts_with("method,t_s,foot_x_mm") && contour.lines().count() > 1000);
    assert!(
        std::fs::read_to_string(bench.path("a/b/contour.svg"))
            .unwrap()
            .contains(">method none: within the tolerance of 1000 \u{b5}m</text>")
    );
    bench.refuses(&["simulate", "circle.ngc", "--trace"], &["--out"]);
}

#[test]
fn a_page_is_one_file_and_no_input() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let run = ["simulate", "circle.ngc", "--tolerance-um", "1000"];
    bench.expect(0, &[&run[..], &["--html", "page.html"]].concat());
    let page = std::fs::read_to_string(bench.path("page.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
    assert!(page.contains("within tolerance") && page.contains("circle.ngc on "));
    // Nothing is fetched: the only addresses are names of the SVG standard.
    assert_eq!(
        page.matches("http").count(),
        page.matches("http://www.w3.org/2000/svg").count() + page.matches("http-equiv").count()
    );
    // A method that learns has a signal more: what it holds the gap to be.
    let learns = ["--methods", "none,adaptive", "--html", "learns.html"];
    bench.expect(0, &[&run[..], &learns].concat());
    let learns = std::fs::read_to_string(bench.path("learns.html")).unwrap();
    let (_, data) = learns.split_once("id=\"data\">").unwrap();
    let (data, _) = data.split_once("</script>").unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    let signals = |method: usize| {
        let motor = &data["methods"][method]["motors"][0];
        motor["signals"].as_array().unwrap().len()
    };
    assert_eq!(signals(1), signals(0) + 1);
    // In a folder it is the same.
    let methods = ["--methods", "none,fixed"];
    bench.expect(
        0,
        &[&run[..], &methods, &["--out", "out", "--html", "two.html"]].concat(),
    );
    let two = std::fs::read(bench.path("two.html")).unwrap();
    assert!(two == std::fs::read(bench.path("out/page.html")).unwrap());
    bench.refuses(
        &[&run[..], &["--html", "circle.ngc"]].concat(),
        &["part program"],
    );
    bench.refuses(&[&run[..], &["--html", "-"]].concat(), &["`-`"]);
    // What `adaptive` starts from is read, too.
    bench.file("worn.toml", "kept");
    bench.refuses(
        &[&run[..], &["--learned", "worn.toml", "--html", "worn.toml"]].concat(),
        &["file of --learned"],
    );
    assert_eq!(
        std::fs::read_to_string(bench.path("worn.toml")).unwrap(),
        "kept"
    );
    assert_eq!(
        std::fs::read_to_string(bench.path("circle.ngc")).unwrap(),
        CIRCLE
    );
}

#[test]
fn a_recommendation_is_tested_and_is_what_the_control_can_do() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let run = [
        "simulate",
        "circle.ngc",
        "--methods",
        "none,fixed,fixed-fanuc",
    ];
    let text = bench.expect(0, &[&run[..], &["--control", "fanuc"]].concat());
    assert!(
        text.contains("fixed: not recommended: a fanuc control has no such function"),
        "{text}"
    );
    assert!(text.contains("told 30 % too small and too large"), "{text}");
    let table = bench.expect(0, &[&run[..], &["--sensitivity", "20"]].concat());
    assert!(
        table.contains("gap x 0.80") && table.contains("gap x 1.20"),
        "{table}"
    );
    let plain = bench.expect(0, &[&run[..], &["--sensitivity", "0"]].concat());
    assert!(!plain.contains("told"), "{plain}");
    bench.refuses(
        &["simulate", "circle.ngc", "--sensitivity", "120"],
        &["--sensitivity", "95"],
    );
    bench.refuses(&[&run[..], &["--control", "fanux"]].concat(), &["fanuc"]);
}

#[test]
fn compare_has_a_row_a_method() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let text = bench.expect(
        0,
        &[
            "compare",
            "circle.ngc",
            "--methods",
            "none,fixed,load-feedback",
            "--out",
            "out",
        ],
    );
    for start in [
        "none ",
        "fixed ",
        "load-feedback ",
        "(no gap) ",
        "recommended:",
    ] {
        assert!(
            text.lines().any(|line| line.starts_with(start)),
            "{start}\n{text}"
        );
    }
    assert_eq!(
        names(&bench.path("out")),
        [
            "blocks.csv",
            "comparison.json",
            "comparison.txt",
            "contour.svg",
            "page.html",
            "reversals.csv"
        ]
    );
    bench.refuses(
        &["compare", "circle.ngc", "--methods", "none,none"],
        &["names \"none\" twice"],
    );
    bench.refuses(
        &["compare", "circle.ngc", "--methods", "none,magic"],
        &["magic", "load-feedback"],
    );
}

#[test]
fn canon_prints_operations_and_all_errors() {
    let bench = Bench::new();
    bench
        .file("circle.ngc", CIRCLE)
        .file("bad.ngc", "G21 G90\nG1 X10\nG2 X20 I15 J0\nM2\n")
        .file("tools.tbl", "T1 P1 Z5\n");
    let text = bench.expect(0, &["canon", "circle.ngc", "--tool-table", "tools.tbl"]);
    assert!(
        text.contains(
            "\nARC_FEED(10.0000, 0.0000, 0.0000, 0.0000, 1, 0.0000, 0.0000, 0.0000, 0.0000)\n"
        ),
        "{text}"
    );
    let output = bench.run(&["canon", "bad.ngc"]);
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8(output.stderr).unwrap();
    for text in [
        "error[no-feed]",
        "--> bad.ngc:2:1",
        "2 | G1 X10",
        "error[arc-radii]",
        "--> bad.ngc:3:1",
        "G90.1",
        "2 errors",
    ] {
        assert!(stderr.contains(text), "`{text}` is not in\n{stderr}");
    }
    bench.refuses(
        &["canon", "circle.ngc", "--tool-table", "none.tbl"],
        &["tool table none.tbl does not exist"],
    );
}

/// What is read would be lost. `gcode format --write` changes a file in place, since that is asked for.
#[test]
fn no_command_writes_over_what_it_reads() {
    let bench = Bench::new();
    let machine = bench.expect(0, &["machine", "show", "bench3"]);
    bench
        .file("circle.ngc", CIRCLE)
        .file("bench.toml", &machine)
        .file("tools.tbl", "T1 P1 Z10 D6\n");
    for (arguments, what) in [
        (
            &["gcode", "write", "circle.ngc", "-o", "circle.ngc"][..],
            "the part program",
        ),
        (
            &["gcode", "write", "circle.ngc", "-o", "./circle.ngc"],
            "the part program",
        ),
        (
            &[
                "gcode",
                "write",
                "circle.ngc",
                "-m",
                "bench.toml",
                "-o",
                "bench.toml",
            ],
            "the machine file",
        ),
        (
            &[
                "gcode",
                "write",
                "circle.ngc",
                "--tool-table",
                "tools.tbl",
                "-o",
                "tools.tbl",
            ],
            "the tool table",
        ),
        (
            &["plan", "circle.ngc", "-o", "circle.ngc"],
            "the part program",
        ),
        (
            &["plan", "circle.ngc", "-m", "bench.toml", "-o", "bench.toml"],
            "the machine file",
        ),
    ] {
        bench.refuses(arguments, &["the output", what, "name another file"]);
    }
    assert_eq!(
        std::fs::read_to_string(bench.path("circle.ngc")).unwrap(),
        CIRCLE
    );
    assert_eq!(
        std::fs::read_to_string(bench.path("bench.toml")).unwrap(),
        machine
    );
    bench.expect(0, &["gcode", "write", "circle.ngc", "-o", "plain.ngc"]);
}

#[test]
fn plan_writes_a_row_a_millisecond() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    bench.expect(
        0,
        &[
            "plan",
            "circle.ngc",
            "--machine",
            "bench3",
            "--out",
            "plan.csv",
        ],
    );
    let plan = std::fs::read_to_string(bench.path("plan.csv")).unwrap();
    let mut lines = plan.lines();
    assert_eq!(lines.next(), Some("t_s,x_mm,y_mm,z_mm,line"));
    assert!(lines.next().unwrap().starts_with("0.000,0.0000"));
    assert!(
        plan.lines().last().unwrap().ends_with(",3"),
        "{}",
        plan.lines().last().unwrap()
    );
    assert_eq!(bench.names(), ["circle.ngc", "plan.csv"]);
}

/// Bad input of every kind, for every command that reads a program.
#[test]
fn bad_programs_end_with_a_clear_message_and_write_nothing() {
    let bench = Bench::new();
    bench.file("empty.ngc", "").file(
        "binary.ngc",
        [0x7f, b'E', b'L', b'F', 2, 1, 1, 0, 0, 0xff, b'\n', 0],
    );
    bench
        .file("blank.ngc", "\n\n(only a comment)\nM2\n")
        .file("far.ngc", "G21 G90 G0 X9000\nM2\n");
    bench
        .file("arc.ngc", "G21 G90 F100\nG1 X1\nG2 X20 I3\nM2\n")
        .file("feed.ngc", "G21 G90\nG1 X1\nM2\n");
    std::fs::create_dir(bench.path("folder")).unwrap();
    let cases: [(&str, &[&str]); 7] = [
        ("missing.ngc", &["missing.ngc does not exist"]),
        ("folder", &["folder is a folder"]),
        ("empty.ngc", &["empty.ngc is empty"]),
        ("binary.ngc", &["binary.ngc:1", "error"]),
        ("far.ngc", &["far.ngc:1", "axis X", "beyond its limit of"]),
        ("arc.ngc", &["arc.ngc:3", "radius to start", "16.0000"]),
        ("feed.ngc", &["feed.ngc:2", "without a feed", "set F first"]),
    ];
    for (program, texts) in cases {
        bench.refuses(&["simulate", program, "--out", "out"], texts);
        bench.refuses(
            &[
                "compare",
                program,
                "--methods",
                "none,fixed",
                "--out",
                "out/deeper",
            ],
            texts,
        );
        bench.refuses(&["plan", program, "--out", "plan.csv"], texts);
    }
    for program in [
        "missing.ngc",
        "folder",
        "empty.ngc",
        "binary.ngc",
        "arc.ngc",
        "feed.ngc",
    ] {
        let output = bench.run(&["canon", program]);
        assert_eq!(output.status.code(), Some(2), "{program}");
    }
    bench.refuses(&["simulate", "blank.ngc"], &["blank.ngc", "moves nothing"]);
    bench.file("rotary.ngc", "G21 G90\nG0 A10\nM2\n");
    bench.refuses(
        &["simulate", "rotary.ngc"],
        &[
            "rotary.ngc:2",
            "machine \"vmc3\" has no axis A",
            "machine list",
        ],
    );
}

#[test]
fn bad_arguments_end_with_code_2() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE).file("taken", "x");
    bench.refuses(&[], &["Usage"]);
    bench.refuses(&["sumulate", "circle.ngc"], &["unrecognized subcommand"]);
    bench.refuses(
        &["simulate", "circle.ngc", "--machine", "vmc9"],
        &["no machine \"vmc9\"", "vmc3-worn"],
    );
    bench.refuses(
        &["simulate", "circle.ngc", "--machine", "vmc9.toml"],
        &["machine file vmc9.toml does not exist"],
    );
    bench.refuses(
        &[
            "simulate",
            "circle.ngc",
            "--method",
            "magic",
            "--out",
            "out",
        ],
        &["magic", "load-feedback"],
    );
    for tolerance in ["0", "-1", "nan", "inf"] {
        bench.refuses(
            &["simulate", "circle.ngc", "--tolerance-um", tolerance],
            &["--tolerance-um is", "positive finite"],
        );
    }
    bench.refuses(
        &["simulate", "circle.ngc", "--threads", "0"],
        &["--threads is 0"],
    );
    bench.refuses(
        &["simulate", "circle.ngc", "--out", "taken"],
        &["taken: it is not a folder"],
    );
    bench.refuses(
        &["plan", "circle.ngc", "--out", "no/plan.csv"],
        &["no/plan.csv: its folder does not exist"],
    );
    bench.refuses(&["plan", "circle.ngc", "--out", "."], &["it is a folder"]);
}

/// A reader that goes away early (`| head`) is no failure and no panic.
#[test]
fn a_closed_stdout_ends_quietly() {
    let bench = Bench::new();
    let mut long = String::from("G21 G90 F1000\n");
    for line in 0..100_000 {
        long.push_str(&format!("G1 X{}\n", line % 7));
    }
    bench.file("long.ngc", long + "M2\n");
    let mut child = bench
        .command(&["canon", "long.ngc"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(
        output.stderr.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[cfg(unix)]
#[test]
fn a_program_may_come_from_a_pipe() {
    use std::io::Write;
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_lostmotion"))
        .args(["simulate", "/dev/stdin", "--machine", "bench3"])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(b"G21 F500\nG1 X5\nG1 Y5\nM2\n")
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("2 moves") && text.contains("G1 Y5"), "{text}");
}

#[test]
fn subroutines_come_from_the_part_s_folder_and_those_named_and_mistakes_show_their_file() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("lib")).unwrap();
    bench
        .file("lib/hole.ngc", "o<hole> sub\nG0 X#1\no<hole> endsub\n")
        .file("part.ngc", "o<hole> call [5]\nM2\n");
    bench.refuses(&["canon", "part.ngc"], &["no-such-sub"]);
    assert!(
        bench
            .expect(0, &["canon", "part.ngc", "--subroutines", "lib"])
            .contains("STRAIGHT_TRAVERSE(5.0000")
    );
    bench.file("lib/hole.ngc", "o<hole> sub\nG0 X[1/0]\no<hole> endsub\n");
    let output = bench.run(&["canon", "part.ngc", "--subroutines", "lib"]);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr.contains("hole.ngc:2:4") && stderr.contains("G0 X[1/0]"),
        "{stderr}"
    );
    bench
        .file("part.ngc", "o<../secret> call\nM2\n")
        .file("secret.ngc", "o<../secret> sub\no<../secret> endsub\n");
    bench.refuses(&["canon", "part.ngc"], &["sub-file"]);
}

#[test]
fn dialects_leniencies_and_limits_are_switched_on_the_command_line() {
    let bench = Bench::new();
    bench.file("part.nc", "%\nO1\n#1=2+3\nG0 X#1\nM30\n%\n");
    bench.refuses(&["canon", "part.nc"], &["error"]);
    assert!(
        bench
            .expect(0, &["canon", "part.nc", "--dialect", "fanuc"])
            .contains("STRAIGHT_TRAVERSE(5.0000")
    );
    bench.expect(0, &["canon", "part.nc", "--accept", "bare-arithmetic"]);
    assert_eq!(
        bench
            .run(&[
                "canon",
                "part.nc",
                "--dialect",
                "fanuc",
                "--refuse",
                "bare-arithmetic"
            ])
            .status
            .code(),
        Some(2)
    );
    bench.refuses(
        &["canon", "part.nc", "--dialect", "heidenhain"],
        &["known dialects", "fanuc"],
    );
    bench.refuses(
        &["canon", "part.nc", "--accept", "anything"],
        &["known codes", "five-axis"],
    );
    bench.refuses(
        &["canon", "part.nc", "--limit", "word=3"],
        &["there is no limit `word`"],
    );
    bench.refuses(&["canon", "part.nc", "--limit", "words"], &["NAME=VALUE"]);
    bench.refuses(
        &[
            "canon",
            "part.nc",
            "--dialect",
            "fanuc",
            "--limit",
            "line_bytes=3",
        ],
        &["line-too-long"],
    );
}

#[test]
fn what_only_the_machine_knows_is_told_by_options() {
    let bench = Bench::new();
    bench.file(
        "part.nc",
        "M10 P3\nG0 X#3011\nM120\n/2 G0 Y1.\n/3 G0 Y2.\nM30\n",
    );
    let run = ["gcode", "canon", "part.nc", "--dialect", "fanuc"];
    let refused = bench.expect(2, &run);
    assert!(!refused.contains("X2"), "{refused}");
    let told = [
        "--m-code",
        "M10=ignore",
        "--m-code",
        "M100-M199=ignore",
        "--set",
        "#3011=20",
        "--block-skip",
        "2",
    ];
    let text = bench.expect(0, &[&run[..], &told[..]].concat());
    let moves: Vec<&str> = text
        .lines()
        .filter(|line| line.contains("TRAVERSE"))
        .collect();
    assert!(
        moves.len() == 2 && moves[0].contains("(20.0000, 0.0000") && moves[1].contains("2.0000"),
        "{text}"
    );
    // A name of LinuxCNC's HAL, in any case, on a machine too.
    bench.file("hal.ngc", "G21 G0 X#<_hal[Load]>\nM2\n");
    let hal = ["gcode", "canon", "hal.ngc", "-m", "vmc3", "--set"];
    let text = bench.expect(0, &[&hal[..], &["#<_HAL[load]>=1.5"]].concat());
    assert!(text.contains("STRAIGHT_TRAVERSE(1.5000"), "{text}");
    for wrong in [
        ["--m-code", "M10"],
        ["--m-code", "M10=wait"],
        ["--m-code", "M10=dwell"],
        ["--m-code", "M10=dwell:-1"],
        ["--m-code", "M10=dwell:inf"],
        ["--m-code", "M10=call:main"],
        ["--m-code", "M10=macro:0"],
        ["--m-code", "M199-M100=ignore"],
        ["--m-code", "G10=ignore"],
        ["--set", "#3011=today"],
        ["--block-skip", "10"],
    ] {
        bench.expect(2, &[&run[..], &wrong[..]].concat());
    }
}

#[test]
fn codes_of_the_builder_stop_wait_and_call() {
    let bench = Bench::new();
    bench.file("9001.nc", "O9001\nG0 X3.\nM99\n");
    bench.file("part.nc", "G21 G90\nG0 X1. M21\nM22\nM23\nM30\n");
    let run = ["gcode", "canon", "part.nc", "--dialect", "fanuc"];
    let told = [
        "--m-code",
        "M21=dwell:1.5",
        "--m-code",
        "M22-M23=stop",
        "--m-code",
        "M23=call:9001",
    ];
    let text = bench.expect(0, &[&run[..], &told[..]].concat());
    let ops: Vec<&str> = text
        .lines()
        .filter_map(|line| {
            [
                "STRAIGHT_TRAVERSE(1",
                "DWELL(1.5",
                "PROGRAM_STOP",
                "STRAIGHT_TRAVERSE(3",
            ]
            .into_iter()
            .find(|op| line.contains(op))
        })
        .collect();
    assert_eq!(
        ops,
        [
            "STRAIGHT_TRAVERSE(1",
            "DWELL(1.5",
            "PROGRAM_STOP",
            "STRAIGHT_TRAVERSE(3"
        ],
        "{text}"
    );
}

#[test]
fn blocks_outside_the_tolerance_are_sarif_where_asked_for() {
    let bench = Bench::new();
    // A note of the front end, and a circle in a subroutine, run twice.
    bench.file(
        "twice.ngc",
        "G21 G90 G17\no<circle> sub\n  g3 i-9 f900\no<circle> endsub\nG0 X9\no<circle> call\no<circle> call\nM2\n",
    );
    let tight = ["--tolerance-um", "0.01", "--machine", "vmc3-worn"];
    let arguments = |form| [&["simulate", "twice.ngc", "--format", form][..], &tight].concat();
    let sarif: serde_json::Value =
        serde_json::from_str(&bench.expect(1, &arguments("sarif"))).unwrap();
    let json: serde_json::Value =
        serde_json::from_str(&bench.expect(1, &arguments("json"))).unwrap();
    let results = sarif["runs"][0]["results"].as_array().unwrap();
    let outside: Vec<_> = results
        .iter()
        .filter(|result| result["ruleId"] == "contour-error")
        .collect();
    // The circle once for each of its calls, with the error that the run tells.
    assert_eq!(outside.len(), 2, "{sarif:#}");
    let worst = json["result"]["cutting"]["max"].as_f64().unwrap();
    let told = outside.iter().map(|result| {
        let region = &result["locations"][0]["physicalLocation"]["region"];
        assert_eq!(
            (&region["startLine"], &result["level"]),
            (&3.into(), &"error".into())
        );
        assert_eq!(region["snippet"]["text"], "  g3 i-9 f900");
        assert!(result["stacks"][0]["frames"].is_array());
        result["properties"]["values"]["max_um"]
            .as_f64()
            .unwrap()
            .abs()
    });
    assert!((told.fold(0.0, f64::max) - worst).abs() < 1e-3);
    assert!(
        results
            .iter()
            .any(|result| result["ruleId"] == "lower-case")
    );
    // Within the tolerance nothing but the note is left.
    let wide = [
        "simulate",
        "twice.ngc",
        "--format",
        "sarif",
        "--tolerance-um",
        "1000",
    ];
    assert!(!bench.expect(0, &wide).contains("contour-error"));
}

#[test]
fn of_several_methods_the_recommended_one_decides_about_the_exit_code() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let compare = |methods, tolerance| {
        [
            "simulate",
            "circle.ngc",
            "-m",
            "vmc3-worn",
            "--format",
            "json",
            "--sensitivity",
            "0",
            "--methods",
            methods,
            "--tolerance-um",
            tolerance,
        ]
    };
    let parsed = |text: String| serde_json::from_str::<serde_json::Value>(&text).unwrap();
    let wide = parsed(bench.expect(0, &compare("none,lookup", "1000")));
    let largest = |name: &str| {
        let mut results = wide["results"].as_array().unwrap().iter();
        let result = results.find(|result| result["method"] == name).unwrap();
        result["cutting"]["max"].as_f64().unwrap()
    };
    let (none, lookup) = (largest("none"), largest("lookup"));
    assert!(lookup + 0.2 < none, "{lookup} {none}");
    // Between the two the recommended one keeps the tolerance that the first one does not.
    let between = format!("{:.3}", 0.5 * (none + lookup));
    let judged = parsed(bench.expect(0, &compare("none,lookup", &between)));
    assert_eq!(judged["recommended"], "lookup");
    assert_eq!(judged["results"][0]["within_tolerance"], false);
    bench.expect(1, &compare("none,lookup", "0.01"));
    // Methods that need a scale on the load are never recommended: nothing decides for the part.
    let none = parsed(bench.expect(1, &compare("load-feedback,adaptive-inverse", "1000")));
    assert_eq!(none["recommended"], serde_json::Value::Null);
}

#[test]
fn answers_of_several_runs_are_set_side_by_side() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    for (machine, folder) in [("vmc3", "out/good"), ("vmc3-worn", "out/worn")] {
        bench.run(&["simulate", "circle.ngc", "-m", machine, "-o", folder]);
    }
    let both = [
        "simulate",
        "circle.ngc",
        "--methods",
        "none,fixed",
        "--format",
        "json",
    ];
    bench.file("both.json", bench.run(&both).stdout);
    let (good, worn) = ("out/good/simulation.json", "out/worn/simulation.json");
    let text = bench.expect(0, &["report", good, worn, "--html", "side.html"]);
    // Told apart by what their names do not share.
    for part in [
        "2 runs side by side",
        "\ngood ",
        "\nworn ",
        "G3 X10 Y0 I-10 J0 F1000",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let page = std::fs::read_to_string(bench.path("side.html")).unwrap();
    // The figures are those of the answers.
    for path in [good, worn] {
        let answer = std::fs::read_to_string(bench.path(path)).unwrap();
        let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
        let max = answer["result"]["cutting"]["max"].as_f64().unwrap();
        let shown = lostmotion::report::number::error(max);
        assert!(
            page.contains(&format!("<td class=\"n\">{shown}<td")),
            "{shown}"
        );
    }
    assert!(!page.contains("<script"));
    let text = bench.expect(0, &["report", good, "both.json"]);
    assert!(text.contains("\nboth.json "), "{text}");
    // What is no answer is refused, and nothing is written over what is read.
    bench
        .file("other.json", "{\"schema\": 1}")
        .file("no.json", "G1 X0");
    bench.file("newer.json", "{\"schema\": 2, \"results\": []}");
    bench.refuses(
        &["report", good, "other.json"],
        &["other.json", "neither `result` nor"],
    );
    bench.refuses(&["report", "no.json"], &["no.json", "line 1 column 1"]);
    bench.refuses(&["report", "newer.json"], &["`schema` is 2"]);
    bench.refuses(&["report", "missing.json"], &["missing.json"]);
    bench.refuses(&["report", good, "--html", good], &["is the result"]);
}
