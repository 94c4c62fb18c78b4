//! `recommend` and `compensate`: settings of controls, and programs for controls without any.

use crate::bench::{Bench, CIRCLE};

#[test]
fn settings_of_a_control_are_ready_to_paste() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let arguments = [
        "recommend",
        "circle.ngc",
        "--for",
        "fanuc",
        "--gap-uncertainty",
        "20",
    ];
    let text = bench.expect(0, &arguments);
    for part in [
        "N1851 A1P11 A2P11 A3P11",
        "the reference position is established",
        "true gap 80 %, as set",
        "true gap 120 %, as set",
        "gap told 30 % too large",
        "a control with lookup",
        "simulations of the program",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    // The same bits whatever the number of threads.
    let json = [&arguments[..], &["--format", "json"]].concat();
    let with = |threads: &str| bench.expect(0, &[&json[..], &["--threads", threads]].concat());
    assert_eq!(with("1"), with("2"));
    let haas = bench.expect(1, &["recommend", "circle.ngc", "--for", "haas"]);
    assert!(haas.contains("no primary source"), "{haas}");
    assert!(haas.contains("\n1 simulation of the program"), "{haas}");
    bench.refuses(
        &["recommend", "circle.ngc"],
        &["does not say which control it has", "--for linuxcnc"],
    );
    bench.refuses(
        &["recommend", "circle.ngc", "--for", "fanux"],
        &["no control \"fanux\"", "did you mean `fanuc`"],
    );
    for (flag, value) in [("--gap-uncertainty", "nan"), ("--detection-unit-um", "0")] {
        bench.refuses(
            &["recommend", "circle.ngc", "--for", "fanuc", flag, value],
            &[flag],
        );
    }
}

#[test]
fn a_program_is_rewritten_only_where_it_helps() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let text = bench.expect(0, &["compensate", "circle.ngc", "--out", "new.ngc"]);
    assert!(
        text.contains("new.ngc is written, within tolerance"),
        "{text}"
    );
    let new = std::fs::read_to_string(bench.path("new.ngc")).unwrap();
    assert!(
        new.starts_with("(circle.ngc rewritten by lostmotion"),
        "{new}"
    );
    // As any other program.
    bench.expect(0, &["simulate", "new.ngc"]);
    // Not twice: a control that compensates.
    let set = "axis.x.compensation.method=fixed";
    bench.refuses(
        &["compensate", "circle.ngc", "--set", set, "--out", "b.ngc"],
        &["compensates already"],
    );
    // Known too badly: nothing is written, and it is no bad input.
    let arguments = [
        "compensate",
        "circle.ngc",
        "--gap-uncertainty",
        "95",
        "--out",
        "c.ngc",
    ];
    let text = bench.expect(1, &arguments);
    assert!(
        text.contains("nothing is written: it does not help enough"),
        "{text}"
    );
    assert!(!bench.names().contains(&"c.ngc".to_owned()));
    bench.file("far.ngc", "G21 G90\nG91\nG1 X1 F100\nM2\n");
    bench.refuses(
        &["compensate", "far.ngc", "--out", "d.ngc"],
        &["far.ngc: line 3, column 4: distances (G91) are not rewritten"],
    );
    bench.refuses(
        &["compensate", "circle.ngc", "--out", "circle.ngc"],
        &["circle.ngc"],
    );
    bench.refuses(
        &[
            "compensate",
            "circle.ngc",
            "--out",
            "e.ngc",
            "--most-um",
            "nan",
        ],
        &["--most-um is NaN"],
    );
}

/// LinuxCNC's own interpreter reads the new program as our front end does, where it is installed.
#[test]
fn rs274_reads_a_rewritten_program() {
    let is_there = std::process::Command::new("rs274")
        .arg("-h")
        .output()
        .is_ok();
    if !is_there {
        return;
    }
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    bench.expect(0, &["compensate", "circle.ngc", "--out", "new.ngc"]);
    let ours = bench.expect(0, &["gcode", "canon", "--like-rs274", "new.ngc"]);
    // Without a table of tools it carries out nothing.
    bench.file("tool.tbl", "T1 P1\n");
    let output = std::process::Command::new("rs274")
        .args(["-g", "-t", "tool.tbl", "new.ngc"])
        .current_dir(bench.path("."))
        .output()
        .unwrap();
    let theirs = String::from_utf8_lossy(&output.stdout).into_owned();
    let moves = |text: &str| -> Vec<String> {
        let kept = ["STRAIGHT_", "ARC_FEED"];
        let lines = text
            .lines()
            .filter(|line| kept.iter().any(|kind| line.contains(kind)));
        lines
            .filter_map(|line| {
                kept.iter()
                    .find_map(|kind| line.find(kind).map(|at| line[at..].to_owned()))
            })
            .collect()
    };
    assert_eq!(moves(&ours), moves(&theirs));
}
