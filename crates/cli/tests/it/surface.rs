//! Every command: what it says to bad input, its man page, its completions, its former name.

use crate::bench::{Bench, CIRCLE, names};
use std::io::Write;
use std::process::Stdio;

/// Commands of the help, with the words behind them that make them run on a file FILE.
const ON_FILES: [(&[&str], &str); 16] = [
    (&["simulate", "FILE"], "part program"),
    (
        &["simulate", "FILE", "--methods", "none,fixed"],
        "part program",
    ),
    (&["time", "FILE"], "part program"),
    (&["check", "FILE"], "part program"),
    (&["plan", "FILE", "-o", "plan.csv"], "part program"),
    (&["gcode", "explain", "FILE:1"], "part program"),
    (&["gcode", "format", "FILE"], "part program"),
    (&["gcode", "write", "FILE"], "part program"),
    (&["gcode", "canon", "FILE"], "part program"),
    (&["gcode", "lint", "FILE"], "part program"),
    (
        &["gcode", "canon", "part.ngc", "--tool-table", "FILE"],
        "tool table",
    ),
    (&["simulate", "part.ngc", "-m", "./FILE"], "machine file"),
    (&["machine", "check", "./FILE"], "machine file"),
    (&["machine", "import", "FILE"], "machine description"),
    (&["axis", "fit", "FILE", "-o", "fit.json"], "log"),
    (
        &[
            "axis",
            "run",
            "--setpoints",
            "FILE",
            "--axis",
            "paper",
            "-o",
            "axis.csv",
        ],
        "setpoint file",
    ),
];

#[test]
fn every_command_refuses_files_that_it_cannot_read() {
    let bench = Bench::new();
    bench.file("part.ngc", CIRCLE).file("empty", "").file(
        "binary",
        [0x7f, b'E', b'L', b'F', 2, 1, 1, 0, 0, 0xff, b'\n', 0],
    );
    std::fs::create_dir(bench.path("folder")).unwrap();
    for (command, what) in ON_FILES {
        for (file, said) in [
            ("missing", "does not exist"),
            ("folder", "is a folder"),
            ("empty", ""),
            ("binary", ""),
        ] {
            // any bytes are lines to a formatter, and a line of a bad program can be explained
            let takes_any = ["format", "explain"]
                .iter()
                .any(|name| command.contains(name));
            if file == "binary" && takes_any {
                continue;
            }
            let arguments: Vec<String> = command
                .iter()
                .map(|word| word.replace("FILE", file))
                .collect();
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let before = bench.names();
            let output = bench.run(&arguments);
            let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
            let told = stderr.clone() + &String::from_utf8_lossy(&output.stdout);
            assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
            assert!(
                told.contains("error") && !told.contains("panicked"),
                "{arguments:?}: {told}"
            );
            assert!(told.contains(said), "{arguments:?}: {told}");
            if !said.is_empty() {
                assert_eq!(
                    stderr.matches("error").count(),
                    1,
                    "{arguments:?}: {stderr}"
                );
                assert!(stderr.contains(what), "{arguments:?}: {stderr}");
            }
            assert_eq!(bench.names(), before, "{arguments:?} left something behind");
        }
    }
}

#[test]
fn unknown_names_are_answered_with_the_nearest() {
    let bench = Bench::new();
    bench.file("part.ngc", CIRCLE);
    let cases: [(&[&str], &[&str]); 12] = [
        (
            &["simulate", "part.ngc", "--method", "fixd"],
            &["no method \"fixd\"", "did you mean `fixed`?"],
        ),
        (
            &["simulate", "part.ngc", "--methods", "none,lokup"],
            &["did you mean `lookup`?"],
        ),
        (
            &["method", "show", "adaptiv"],
            &["did you mean `adaptive`?"],
        ),
        (
            &["simulate", "part.ngc", "-m", "vmc33"],
            &["no machine \"vmc33\"", "vmc3", ".toml"],
        ),
        (
            &["simulate", "part.ngc", "--dialect", "fanuk"],
            &["did you mean `fanuc`?"],
        ),
        (
            &[
                "simulate",
                "part.ngc",
                "--set",
                "axis.x.drive.position_gian_per_s=30",
            ],
            &[
                "error: --set axis.x.drive.position_gian_per_s=30: ",
                "did you mean `position_gain_per_s`?",
            ],
        ),
        (
            &[
                "simulate",
                "part.ngc",
                "--set",
                "axis.x.load.slide.gap_um=-3",
            ],
            &["is -3; it has to be"],
        ),
        (
            &["simulate", "part.ngc", "--set", "tolerance"],
            &["KEY=VALUE", "hint"],
        ),
        (
            &["simulate", "part.ngc", "--offset", "g60=1,2,3"],
            &["no work coordinate system g60", "did you mean"],
        ),
        (
            &["simulate", "part.ngc", "--offset", "g54=1,b"],
            &["`b` is not a finite number", "hint"],
        ),
        (
            &["gcode", "lint", "part.ngc", "--offset", "g54=1,2,3"],
            &["needs a machine", "-m vmc3"],
        ),
        (
            &[
                "axis",
                "run",
                "--setpoints",
                "part.ngc",
                "--axis",
                "papr",
                "-o",
                "x",
            ],
            &["did you mean `paper`?"],
        ),
    ];
    for (arguments, texts) in cases {
        bench.refuses(arguments, texts);
    }
}

#[test]
fn every_message_has_one_prefix_with_place_values_and_hint() {
    let bench = Bench::new();
    bench
        .file("part.ngc", CIRCLE)
        .file("bad.toml", "name = 3\nfoo = 1\n")
        .file("dump.txt", "$110=fast\n$120=0\n");
    let cases: [(&[&str], &[&str]); 18] = [
        (
            &["simulate", "part.ngc", "--method", ""],
            &["no method \"\"", "hint: known methods"],
        ),
        (&["method", "show", ""], &["no method \"\""]),
        (
            &["simulate", "part.ngc", "--tolerance-um", "abc"],
            &["'abc'", "it is not a number"],
        ),
        (
            &["simulate", "part.ngc", "--tolerance-um", "-1"],
            &["--tolerance-um is -1", "positive"],
        ),
        (
            &["simulate", "part.ngc", "--tolerance-um", "NaN"],
            &["--tolerance-um is NaN"],
        ),
        (
            &["simulate", "part.ngc", "--threads", "99999999"],
            &["99999999", "1 to 1024", "hint: "],
        ),
        (
            &["time", "part.ngc", "--threads", "-1"],
            &["'-1'", "a whole number"],
        ),
        (
            &["time", "part.ngc", "--top", "1.5"],
            &["'1.5'", "a whole number"],
        ),
        (
            &["simulate", "part.ngc", "--at", "-1s=hold"],
            &["--at -1s=hold", "hint: "],
        ),
        (
            &["simulate", "part.ngc", "--offset", "g54=nan"],
            &["`nan` is not a finite number"],
        ),
        (
            &["simulate", "part.ngc", "--offset", "g54=1e300"],
            &["would stand at 1e300 mm"],
        ),
        (
            &["machine", "check", "bad.toml"],
            &[
                "error: bad.toml:1:8: name: found",
                "error: bad.toml:2:1: foo: unknown key\nhint: ",
            ],
        ),
        (
            &["machine", "import", "dump.txt", "--from", "grbl"],
            &[
                "error: dump.txt:1:1: $110: `fast`",
                "error: dump.txt:2:1: $120: is 0",
            ],
        ),
        (
            &["machine", "new", "mine", "--gap", "-1"],
            &["gap_um", "is -1"],
        ),
        (
            &["gcode", "format", "part.ngc", "--indent", "99"],
            &["--indent is 99", "0 to 16"],
        ),
        (
            &["plan", "part.ngc", "-o", "-"],
            &["the output is `-`", "hint: "],
        ),
        (
            &["simulate", "part.ngc", "-o", "-"],
            &["the output is `-`", "a folder"],
        ),
        (
            &["gcode", "explain", "part.ngc:0"],
            &["PART:LINE", "lines count from 1"],
        ),
    ];
    for (arguments, texts) in cases {
        bench.refuses(arguments, texts);
        let output = bench.run(arguments);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(told.starts_with("error: "), "{arguments:?}: {told}");
        assert!(!told.contains("error: error"), "{arguments:?}: {told}");
        assert!(
            told.lines().all(|line| line.len() < 600),
            "{arguments:?}: {told}"
        );
    }
}

#[test]
fn check_lists_its_lints_and_tells_them_beside_what_the_machine_refuses() {
    let bench = Bench::new();
    bench.file("rotary.ngc", "G21 G0 B5\nM2\n");
    let help = bench.expect(0, &["check", "--help"]);
    for said in [
        "unset-units",
        "outside-travel",
        "every axis moved is on the machine",
    ] {
        assert!(help.contains(said), "{said}: {help}");
    }
    let told = bench.expect(2, &["check", "rotary.ngc"]);
    assert!(
        told.contains("error[no-axis]") && told.contains("warning[unset-distance]"),
        "{told}"
    );
}

#[test]
fn lists_are_folded_not_cut() {
    let bench = Bench::new();
    for command in ["machine", "method"] {
        let list = bench.expect(0, &[command, "list"]);
        assert!(!list.contains("..."), "{list}");
    }
}

#[test]
fn offsets_keys_and_tool_tables_are_taken_by_every_command_on_a_machine() {
    let bench = Bench::new();
    bench
        .file(
            "part.ngc",
            "G21 G90 G94 G54\nT1 M6\nG43 H1\nG0 X0 Y0\nG1 X5 F500\nM2\n",
        )
        .file("tools.tbl", "T1 P1 Z55.5 D6\n");
    let json = |more: &[&str]| {
        let arguments = [&["simulate", "part.ngc", "--format", "json"], more].concat();
        bench.expect(0, &arguments)
    };
    let softer = "axis.x.drive.position_gain_per_s=30";
    let usual = json(&[]);
    assert_ne!(json(&["--set", softer]), usual);
    assert_eq!(
        json(&["--set", "axis.x.drive.position_gain_per_s=62.8"]),
        usual
    );
    for command in [&["simulate"][..], &["time", "--no-what-if"], &["check"]] {
        let far = [command, &["part.ngc", "--offset", "g54=2,0,0"]].concat();
        let output = bench.run(&far);
        let told =
            String::from_utf8_lossy(&output.stderr) + String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(2), "{far:?}: {told}");
    }
    bench.expect(
        0,
        &[
            "plan",
            "part.ngc",
            "--offset",
            "g54=-300,y-200,z-280",
            "-o",
            "plan.csv",
        ],
    );
    let plan = std::fs::read_to_string(bench.path("plan.csv")).unwrap();
    assert!(plan.lines().any(|row| row.contains(",-300.0000")), "{plan}");
    // the same table means the same lengths, with a machine and without
    for more in [&[][..], &["-m", "vmc3"]] {
        let arguments = [
            &["gcode", "canon", "part.ngc", "--tool-table", "tools.tbl"],
            more,
        ]
        .concat();
        let text = bench.expect(0, &arguments);
        assert!(text.contains("55.5000"), "{text}");
    }
    assert!(
        bench
            .expect(0, &["canon", "part.ngc", "--tool-table", "tools.tbl"])
            .contains("1409.7000"),
    );
}

#[test]
fn every_visible_command_has_a_man_page_and_a_heading() {
    let bench = Bench::new();
    bench.expect(0, &["man", "-o", "man"]);
    let pages = names(&bench.path("man"));
    let help = bench.expect(0, &["--help"]);
    let options = help.find("Options:").unwrap();
    let listed: Vec<&str> = help[..options]
        .lines()
        .filter_map(|line| line.strip_prefix("  "))
        .filter(|line| !line.starts_with(' '))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(listed.len() >= 11, "{help}");
    for name in &listed {
        assert!(
            pages.contains(&format!("lostmotion-{name}.1")),
            "{name}: {pages:?}"
        );
    }
    for page in &pages {
        let text = std::fs::read_to_string(bench.path("man").join(page)).unwrap();
        assert!(
            text.contains(".SH NAME") && text.contains(".SH SYNOPSIS"),
            "{page}"
        );
        let command = page.trim_end_matches(".1").replace('-', " ");
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        if let Some(first) = words.first() {
            assert!(listed.contains(first), "{page} is under no heading");
        }
        bench.expect(0, &[words.as_slice(), &["--help"]].concat());
    }
    for heading in [
        "Parts:",
        "Machines and methods:",
        "Drives and measured data:",
        "Research:",
    ] {
        assert!(help.contains(heading), "{help}");
    }
    for former in ["compare", "canon", "fit", "reproduce"] {
        assert!(!listed.contains(&former), "{former}");
    }
    bench.refuses(
        &["man", "machine", "chek"],
        &["no command \"chek\"", "check"],
    );
}

#[test]
fn completions_are_made_for_every_shell_and_bash_reads_its_own() {
    let bench = Bench::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let text = bench.expect(0, &["completions", shell]);
        assert!(text.contains("endurance"), "{shell}");
        let has_values = matches!(shell, "bash" | "fish" | "zsh");
        assert!(!has_values || text.contains("fixed-linuxcnc"), "{shell}");
    }
    let script = bench.expect(0, &["completions", "bash"]);
    let bash = std::process::Command::new("bash")
        .arg("-n")
        .stdin(Stdio::piped())
        .spawn();
    if let Ok(mut bash) = bash {
        bash.stdin
            .take()
            .unwrap()
            .write_all(script.as_bytes())
            .unwrap();
        assert!(bash.wait().unwrap().success());
    }
}

#[test]
fn a_part_may_come_from_stdin() {
    let bench = Bench::new();
    for (arguments, code) in [
        (&["simulate", "-", "--tolerance-um", "1000"][..], 0),
        (&["time", "-", "--no-what-if"], 0),
        (&["gcode", "format", "-"], 0),
        (&["gcode", "canon", "-"], 0),
        (&["check", "-"], 1),
    ] {
        let mut child = bench
            .command(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child
            .stdin
            .take()
            .unwrap()
            .write_all(CIRCLE.as_bytes())
            .unwrap();
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
        assert!(!output.stdout.is_empty(), "{arguments:?}");
    }
    bench.refuses(&["simulate", "-"], &["part program stdin is empty"]);
}

#[test]
fn tables_fit_the_terminal() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    for columns in ["70", "80", "120"] {
        for arguments in [
            &["simulate", "circle.ngc"][..],
            &["simulate", "circle.ngc", "--methods", "none,fixed"],
            &["machine", "check", "vmc3"],
            &["machine", "list"],
            &["method", "list"],
        ] {
            let output = bench
                .command(arguments)
                .env("COLUMNS", columns)
                .output()
                .unwrap();
            let text = String::from_utf8(output.stdout).unwrap();
            let width: usize = columns.parse().unwrap();
            // tables have two blanks between columns; other lines are sentences
            for line in text.lines().filter(|line| line.trim().contains("  ")) {
                assert!(
                    line.chars().count() <= width,
                    "{arguments:?} {columns}: {line}"
                );
            }
        }
    }
}

#[test]
fn a_warning_of_the_program_has_one_prefix() {
    let bench = Bench::new();
    bench.file(
        "part.ngc",
        "G21 G90 G17\nG41 D2 G1 X10 F500\nX20\nY20\nG40 X30\nM2\n",
    );
    let told = bench.expect(0, &["simulate", "part.ngc", "--at", "900s=hold"]);
    assert!(
        told.contains("\nwarning[no-tool-radius]: line 2")
            && told.contains("\nwarning: the intervention at 900 s"),
        "{told}"
    );
}
