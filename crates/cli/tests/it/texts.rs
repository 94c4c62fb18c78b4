//! Commands that are about the text of a part program: lint, format, explain, write, and the forms
//! of diagnostics.

use std::path::Path;
use std::process::{Command, Stdio};

/// Exit code, stdout and stderr of a run in a folder.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lostmotion"));
    let output = command
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code().unwrap(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

const CLEAN: &str = "G21 G90 G17 G94 G54\nG0 X1\nM2\n";
const DWELLS: &str = "G21 G90 G17 G94 G54\nG4 P500\nG4 P7200\nM2\n";

#[test]
fn lint_has_exit_codes_for_nothing_warnings_and_errors() {
    let at = folder(&[
        ("clean.ngc", CLEAN),
        ("dwells.ngc", DWELLS),
        ("bad.ngc", "G1 X\nM2\n"),
    ]);
    assert_eq!(
        run(at.path(), &["lint", "clean.ngc"]),
        (0, String::new(), String::new())
    );
    let (code, out, _) = run(at.path(), &["lint", "dwells.ngc"]);
    assert_eq!(code, 1);
    assert!(
        out.contains(
            "warning[dwell-milliseconds]: a dwell of 500 s (8.3 min)\n --> dwells.ngc:2:1\n"
        ),
        "{out}"
    );
    assert!(
        out.contains("help: P is in seconds; 500 ms are P0.5\n") && out.ends_with("2 warnings\n"),
        "{out}"
    );
    let (code, out, _) = run(
        at.path(),
        &[
            "lint",
            "dwells.ngc",
            "--deny",
            "dwell-endless",
            "--allow",
            "dwell-milliseconds",
        ],
    );
    assert_eq!(code, 2);
    assert!(
        out.contains("error[dwell-endless]") && out.ends_with("1 error\n"),
        "{out}"
    );
    assert_eq!(
        run(at.path(), &["lint", "dwells.ngc", "--allow", "all"]).0,
        0
    );
    assert_eq!(
        run(
            at.path(),
            &[
                "lint",
                "dwells.ngc",
                "--warn",
                "dwell-endless",
                "--allow",
                "all"
            ]
        )
        .0,
        1
    );
    assert_eq!(run(at.path(), &["lint", "bad.ngc"]).0, 2);
    let (code, _, err) = run(at.path(), &["lint", "clean.ngc", "--deny", "dwel"]);
    assert!(
        code == 2
            && err.contains("there is no lint \"dwel\"")
            && err.contains("known lints: unset-units"),
        "{err}"
    );
}

#[test]
fn lint_holds_a_program_against_a_machine() {
    let at = folder(&[
        ("far.ngc", "G21 G90 G17 G94 G54\nG0 X5000\nM2\n"),
        ("clean.ngc", CLEAN),
    ]);
    let (code, out, _) = run(at.path(), &["lint", "far.ngc", "--machine", "vmc3"]);
    assert!(
        code == 1 && out.contains("warning[outside-travel]: 1 move goes beyond the travel of machine \"vmc3\": axis X to"),
        "{out}"
    );
    assert_eq!(
        run(
            at.path(),
            &[
                "lint",
                "far.ngc",
                "--machine",
                "vmc3",
                "--deny",
                "outside-travel"
            ]
        )
        .0,
        2
    );
    assert_eq!(
        run(
            at.path(),
            &[
                "lint",
                "far.ngc",
                "--machine",
                "vmc3",
                "--allow",
                "outside-travel"
            ]
        )
        .0,
        0
    );
    assert_eq!(
        run(at.path(), &["lint", "clean.ngc", "--machine", "vmc3"]).0,
        0
    );
}

#[test]
fn findings_are_documents_where_asked_for() {
    let at = folder(&[
        ("bad.ngc", "F100\nG2 X10.06 I5\nM2\n"),
        ("dwells.ngc", DWELLS),
        ("clean.ngc", CLEAN),
    ]);
    let json = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    let (code, out, _) = run(at.path(), &["lint", "dwells.ngc", "--format", "json"]);
    assert_eq!(
        (
            code,
            &json(&out)["findings"][0]["code"],
            &json(&out)["warnings"]
        ),
        (1, &"dwell-milliseconds".into(), &2.into())
    );
    let (_, out, _) = run(at.path(), &["lint", "dwells.ngc", "--format", "sarif"]);
    assert_eq!(
        json(&out)["runs"][0]["results"][1]["ruleId"],
        "dwell-endless"
    );
    for command in [
        &["canon"][..],
        &["simulate"],
        &["compare"],
        &["plan", "--out", "plan.csv"],
        &["write"],
    ] {
        let arguments = |part, form| [command, &[part, "--diagnostics", form]].concat();
        let (code, _, err) = run(at.path(), &arguments("bad.ngc", "json"));
        assert_eq!(
            (code, &json(&err)["findings"][0]["code"]),
            (2, &"arc-radii".into()),
            "{command:?}: {err}"
        );
        let (code, _, err) = run(at.path(), &arguments("bad.ngc", "sarif"));
        assert_eq!(
            (code, &json(&err)["runs"][0]["results"][0]["ruleId"]),
            (2, &"arc-radii".into()),
            "{command:?}: {err}"
        );
    }
    let (code, _, err) = run(
        at.path(),
        &["simulate", "clean.ngc", "--diagnostics", "json"],
    );
    assert_eq!(
        (code, &json(&err)["findings"]),
        (0, &serde_json::json!([])),
        "{err}"
    );
}

#[test]
fn a_finding_in_a_subroutine_knows_who_called_it() {
    let text = "G21 G90 G17 G94 F100 G54\nO<pocket> sub\nG0 X1\nG2 X10.06 I5\nO<pocket> endsub\nO<pocket> call\nM2\n";
    let at = folder(&[("sub.ngc", text)]);
    for command in [
        &["canon"][..],
        &["simulate"],
        &["compare"],
        &["plan", "--out", "plan.csv"],
        &["time"],
        &["write"],
        &["lint"],
    ] {
        let (code, out, err) = run(at.path(), &[command, &["sub.ngc"]].concat());
        let told = out + &err;
        assert!(
            code == 2
                && told.contains("sub.ngc:4:1")
                && told.contains("in pocket, called from sub.ngc, line 6"),
            "{command:?}: {told}"
        );
        let (_, out, err) = run(
            at.path(),
            &[command, &["sub.ngc", "--diagnostics", "json"]].concat(),
        );
        let text = if command == ["lint"] { out } else { err };
        let finding = &serde_json::from_str::<serde_json::Value>(&text).unwrap()["findings"][0];
        assert_eq!(
            (&finding["code"], &finding["excerpt"]),
            (&"arc-radii".into(), &"G2 X10.06 I5".into()),
            "{command:?}"
        );
        assert_eq!(
            (
                &finding["calls"][0]["sub"],
                &finding["calls"][0]["span"]["line"]
            ),
            (&"pocket".into(), &6.into()),
            "{command:?}"
        );
    }
}

#[test]
fn format_prints_checks_and_writes() {
    let at = folder(&[
        ("part.ngc", "g0x1\r\n(a)G1  x2 f5\r\nM2\r\n"),
        ("clean.ngc", CLEAN),
        ("goto.ngc", "N1 G0 X1\nGOTO 1\nM2\n"),
    ]);
    let styled = "G0 X1\r\n(a) G1 X2 F5\r\nM2\r\n";
    assert_eq!(
        run(at.path(), &["format", "part.ngc"]),
        (0, styled.to_owned(), String::new())
    );
    let (code, out, _) = run(at.path(), &["format", "part.ngc", "--check"]);
    assert_eq!(
        (code, out.as_str()),
        (
            1,
            "part.ngc:1\n- g0x1\n+ G0 X1\npart.ngc:2\n- (a)G1  x2 f5\n+ (a) G1 X2 F5\npart.ngc: 2 of 3 lines would change\n"
        )
    );
    assert_eq!(
        run(at.path(), &["format", "clean.ngc", "--check"]),
        (0, String::new(), String::new())
    );
    assert_eq!(
        run(at.path(), &["format", "part.ngc", "--write"]),
        (
            0,
            "part.ngc: 2 of 3 lines changed\n".to_owned(),
            String::new()
        )
    );
    assert_eq!(
        std::fs::read_to_string(at.path().join("part.ngc")).unwrap(),
        styled
    );
    assert_eq!(
        run(
            at.path(),
            &[
                "format",
                "clean.ngc",
                "--line-numbers",
                "10",
                "--case",
                "lower"
            ]
        )
        .1,
        CLEAN
            .to_lowercase()
            .replace("g21", "n10 g21")
            .replace("\ng0", "\nn20 g0")
            .replace("\nm2", "\nn30 m2")
    );
    let (code, _, err) = run(
        at.path(),
        &["format", "goto.ngc", "--line-numbers", "remove"],
    );
    assert!(
        code == 2 && err.contains("goto.ngc, line 2: the program refers to its line numbers"),
        "{err}"
    );
    assert_eq!(
        run(at.path(), &["format", "clean.ngc", "--line-numbers", "0"]).0,
        2
    );
}

#[test]
fn explain_tells_a_line() {
    let at = folder(&[(
        "part.ngc",
        "G21 G90\no1 repeat [3]\nG0 X5\no1 endrepeat\nM2\n",
    )]);
    let (code, out, _) = run(at.path(), &["explain", "part.ngc:3"]);
    assert!(
        code == 0
            && out.starts_with("line 3: G0 X5\n  G0  traverse in a straight line (motion mode)\n"),
        "{out}"
    );
    assert!(
        out.contains("carried out 3 times")
            && out.contains("the first time:")
            && out.contains("the last time:"),
        "{out}"
    );
    let (_, out, _) = run(at.path(), &["explain", "part.ngc:3", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(
        (&json["executions"], &json["first"]["after"]["position"][0]),
        (&3.into(), &5.0.into())
    );
    let (code, _, err) = run(at.path(), &["explain", "part.ngc:9"]);
    assert!(code == 2 && err.contains("part.ngc has no line 9"), "{err}");
    assert!(
        run(at.path(), &["explain", "part.ngc"])
            .2
            .contains("not of the form PART:LINE")
    );
}

#[test]
fn write_saves_a_resolved_program() {
    let at = folder(&[
        (
            "part.ngc",
            "#1=2 F100\no1 repeat [2]\nG91 G1 X#1\no1 endrepeat\nG55 G90 G1 X0\nM2\n",
        ),
        ("bad.ngc", "G0 X1\nG1 X\nM2\n"),
    ]);
    let (code, out, _) = run(at.path(), &["write", "part.ngc"]);
    assert_eq!(
        (code, out.lines().skip(3).collect::<Vec<_>>()),
        (0, vec!["G1 X2 F100", "G1 X4", "G1 X0", "M2"])
    );
    assert_eq!(
        run(at.path(), &["write", "part.ngc", "--out", "new.ngc"]).1,
        "new.ngc: 7 blocks\n"
    );
    assert_eq!(
        std::fs::read_to_string(at.path().join("new.ngc")).unwrap(),
        out
    );
    let (code, out, err) = run(at.path(), &["write", "bad.ngc", "--out", "none.ngc"]);
    assert!(
        code == 2
            && out.is_empty()
            && err.contains("error[missing-number]")
            && !at.path().join("none.ngc").exists(),
        "{err}"
    );
    assert!(
        run(at.path(), &["write", "part.ngc", "--system", "10"])
            .2
            .contains("work coordinate system 10 does not exist")
    );
}
