//! `study sweep`: planned, run in parts, killed and gone on with, collected.

use crate::bench::{Bench, CIRCLE};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Half a turn and back: a second of motion.
const BACK: &str = "G21 G90 G17 G64 P0.005\nG0 X10 Y0\nG1 X0 Y10 F2000\nG1 X10 Y0\nM2\n";

/// Two programs at six points.
const SWEEP: &str = r#"
programs = ["parts/*.ngc"]
machines = ["bench3"]
methods = ["none", "fixed"]

[[vary]]
name = "gap_um"
keys = ["axis.x.load.slide.gap_um", "axis.y.load.slide.gap_um"]
values = [0, 10.5, 40]

[[vary]]
keys = ["axis.x.drive.position_gain_per_s"]
from = 20
to = 60
steps = 2
"#;

/// A folder with the sweep and its programs.
fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("parts")).unwrap();
    bench
        .file("parts/a.ngc", CIRCLE.replace("F1000", "F4000"))
        .file("parts/b.ngc", BACK)
        .file("gaps.toml", SWEEP);
    bench
}

const PLAN: [&str; 6] = ["study", "sweep", "plan", "gaps.toml", "--out", "gaps.jsonl"];

fn sweep(bench: &Bench, code: i32, arguments: &[&str]) -> String {
    bench.expect(code, &[&["-q", "study", "sweep"], arguments].concat())
}

/// The table of some results.
fn table(bench: &Bench, results: &[&str]) -> String {
    let out = ["--out", "table.csv"];
    sweep(
        bench,
        0,
        &[&["collect", "gaps.jsonl"], results, &out].concat(),
    );
    std::fs::read_to_string(bench.path("table.csv")).unwrap()
}

fn lines(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().map(str::to_owned).collect()
}

/// Each row has the figures that `simulate` prints for its part, machine and settings.
#[test]
fn a_cell_has_the_figures_of_the_command_alone() {
    let bench = bench();
    bench.expect(0, &PLAN);
    sweep(&bench, 0, &["run", "gaps.jsonl"]);
    let table = table(&bench, &[]);
    let mut rows = table.lines();
    let header: Vec<&str> = rows.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let rows: Vec<Vec<&str>> = rows.map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 2 * 6 * 2);
    for row in rows.iter().step_by(7) {
        let of = |name: &str| row[column(name)];
        let gap = |axis: &str| format!("axis.{axis}.load.slide.gap_um={}", of("gap_um"));
        let gain = "axis.x.drive.position_gain_per_s";
        let text = bench.run(&[
            "simulate",
            of("program"),
            "-m",
            of("machine"),
            "--method",
            of("method"),
            "--set",
            &gap("x"),
            "--set",
            &gap("y"),
            "--set",
            &format!("{gain}={}", of(gain)),
            "--format",
            "json",
        ]);
        let run: serde_json::Value = serde_json::from_slice(&text.stdout).unwrap();
        let cutting = &run["result"]["cutting"];
        for (name, value) in [("max_um", &cutting["max"]), ("rms_um", &cutting["rms"])] {
            let value = value.as_f64().unwrap();
            assert_eq!(of(name), format!("{value:.4}"), "{row:?}");
        }
        assert_eq!(
            of("duration_s"),
            format!("{:.4}", run["plan"]["duration_s"].as_f64().unwrap())
        );
    }
}

#[test]
fn threads_shards_and_order_make_no_difference() {
    let bench = bench();
    bench.expect(0, &PLAN);
    sweep(
        &bench,
        0,
        &[
            "run",
            "gaps.jsonl",
            "--out",
            "whole.jsonl",
            "--threads",
            "1",
        ],
    );
    let whole = table(&bench, &["whole.jsonl"]);
    for shard in ["2/3", "3/3", "1/3"] {
        sweep(
            &bench,
            0,
            &["run", "gaps.jsonl", "--shard", shard, "--threads", "2"],
        );
    }
    // Named after the manifest, they are found.
    assert_eq!(table(&bench, &[]), whole);
    assert_eq!(
        table(&bench, &["gaps.results-3-of-3.jsonl", "whole.jsonl"]),
        whole
    );
    for ending in ["parquet", "jsonl"] {
        let [a, b] = ["a", "b"].map(|name| format!("{name}.{ending}"));
        sweep(
            &bench,
            0,
            &["collect", "gaps.jsonl", "--out", &a, "--html", "a.html"],
        );
        sweep(
            &bench,
            0,
            &[
                "collect",
                "gaps.jsonl",
                "whole.jsonl",
                "--out",
                &b,
                "--html",
                "b.html",
            ],
        );
        for [a, b] in [[a.as_str(), &b], ["a.html", "b.html"]] {
            let [a, b] = [a, b].map(|name| std::fs::read(bench.path(name)).unwrap());
            assert!(a == b && a.len() > 1000, "{ending}");
        }
    }
    // A run that finds all of its cells done runs none.
    let before = std::fs::read(bench.path("whole.jsonl")).unwrap();
    sweep(&bench, 0, &["run", "gaps.jsonl", "--out", "whole.jsonl"]);
    assert_eq!(std::fs::read(bench.path("whole.jsonl")).unwrap(), before);
}

/// Runs are killed at times of every kind. After each the file is a whole one but for its last
/// line, and in the end every cell was run once, but for those in flight at a kill.
#[test]
fn a_killed_run_loses_nothing() {
    const KILLS: u64 = 20;
    let bench = bench();
    bench.file("gaps.toml", SWEEP.replace("steps = 2", "steps = 12"));
    bench.expect(0, &PLAN);
    sweep(&bench, 0, &["run", "gaps.jsonl", "--out", "whole.jsonl"]);
    let whole = table(&bench, &["whole.jsonl"]);
    let run = [
        "-q",
        "study",
        "sweep",
        "run",
        "gaps.jsonl",
        "--out",
        "part.jsonl",
        "--threads",
        "1",
    ];
    let mut before = Vec::new();
    for kill in 0..KILLS {
        let mut child = bench.command(&run).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(20 + 37 * kill % 130));
        child.kill().unwrap();
        child.wait().unwrap();
        // What was there stays.
        let after = lines(&bench.path("part.jsonl"));
        assert!(after.starts_with(&before), "kill {kill}");
        before = after;
        // As a kill in the middle of writing leaves it.
        if kill % 2 == 0 {
            let path = bench.path("part.jsonl");
            let mut text = std::fs::read_to_string(&path).unwrap_or_default();
            text.push_str("{\"key\":\"8df0582e");
            std::fs::write(&path, text).unwrap();
        }
    }
    sweep(&bench, 0, &run[3..]);
    let finished = lines(&bench.path("part.jsonl"));
    let different: BTreeSet<_> = finished.iter().collect();
    assert_eq!((finished.len(), different.len()), (72, 72));
    assert_eq!(table(&bench, &["part.jsonl"]), whole);
}

#[test]
fn ctrl_c_ends_after_the_cells_in_flight() {
    let bench = bench();
    bench.file("gaps.toml", SWEEP.replace("steps = 2", "steps = 400"));
    bench.expect(0, &PLAN);
    let run = ["study", "sweep", "run", "gaps.jsonl", "--out", "part.jsonl"];
    let child = bench.command(&run).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while lines(&bench.path("part.jsonl")).is_empty() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let signal = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(signal.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(
        said.contains("ending after the cells in flight") && said.contains("run again to go on"),
        "{said}"
    );
    let text = std::fs::read_to_string(bench.path("part.jsonl")).unwrap();
    assert!(text.ends_with('\n') && text.lines().count() < 2400);
}

/// A part that is wrong, and settings that no machine takes together, are results.
#[test]
fn cells_that_cannot_be_run_are_results_with_their_reason() {
    let bench = bench();
    bench.file("parts/c.ngc", "G21 G90\nG1 X- F100\nM2\n");
    bench.expect(0, &PLAN);
    sweep(&bench, 1, &["run", "gaps.jsonl"]);
    let table = table(&bench, &[]);
    let wrong: Vec<&str> = table
        .lines()
        .filter(|row| row.contains("parts/c.ngc"))
        .collect();
    assert_eq!(wrong.len(), 12);
    assert!(
        wrong
            .iter()
            .all(|row| row.contains("program:2:") && row.contains("number is missing")),
        "{wrong:?}"
    );
    // They are not run again.
    sweep(&bench, 0, &["run", "gaps.jsonl"]);
    sweep(
        &bench,
        0,
        &[
            "collect",
            "gaps.jsonl",
            "--out",
            "t.csv",
            "--html",
            "t.html",
        ],
    );
    let page = std::fs::read_to_string(bench.path("t.html")).unwrap();
    assert!(page.contains("Cells that could not be run") && page.contains("Over gap_um"));
}

#[test]
fn missing_cells_are_named() {
    let bench = bench();
    bench.expect(0, &PLAN);
    sweep(&bench, 0, &["run", "gaps.jsonl", "--shard", "1/2"]);
    let output = bench.run(&["study", "sweep", "collect", "gaps.jsonl", "--out", "t.csv"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let second = lines(&bench.path("gaps.jsonl"))[2][8..40].to_owned();
    for text in [
        "6 of 12 cells",
        "missing: 6 cells",
        &format!("cell 1, key {second}: parts/a.ngc on bench3"),
    ] {
        assert!(said.contains(text), "{text}: {said}");
    }
    // Those that are there are in the table.
    assert_eq!(lines(&bench.path("t.csv")).len(), 1 + 6 * 2);
}

/// The same contents have the same key: two names of one program run once and have a row each, and
/// results of a smaller sweep are good for a larger one.
#[test]
fn results_belong_to_contents() {
    let bench = bench();
    bench.file("parts/b.ngc", CIRCLE.replace("F1000", "F4000"));
    bench.expect(0, &PLAN);
    sweep(&bench, 0, &["run", "gaps.jsonl", "--out", "r.jsonl"]);
    assert_eq!(lines(&bench.path("r.jsonl")).len(), 6);
    let rows = table(&bench, &["r.jsonl"]);
    let [a, b] = ["parts/a.ngc", "parts/b.ngc"]
        .map(|name| rows.lines().filter(|row| row.contains(name)).count());
    assert_eq!((a, b), (12, 12));
    // One more level: what is done stays done.
    bench.file("gaps.toml", SWEEP.replace("40]", "40, 80]"));
    bench.expect(0, &PLAN);
    sweep(&bench, 0, &["run", "gaps.jsonl", "--out", "r.jsonl"]);
    assert_eq!(lines(&bench.path("r.jsonl")).len(), 8);
}

#[test]
fn inputs_that_have_changed_are_refused() {
    let bench = bench();
    let mine = bench.expect(0, &["machine", "show", "bench3"]);
    bench.file("mine.toml", &mine);
    bench.file("gaps.toml", SWEEP.replace("\"bench3\"", "\"mine.toml\""));
    bench.expect(0, &PLAN);
    let key = lines(&bench.path("gaps.jsonl"))[7][8..40].to_owned();
    bench.file("parts/b.ngc", "G0 X1\nM2\n");
    let run = ["study", "sweep", "run", "gaps.jsonl", "--out", "r.jsonl"];
    let refused = |texts: &[&str]| {
        let output = bench.run(&run);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            texts.iter().all(|text| said.contains(text)),
            "{texts:?}: {said}"
        );
        assert!(lines(&bench.path("r.jsonl")).is_empty());
    };
    refused(&[
        "parts/b.ngc has changed since the plan",
        "6 cells",
        &key,
        "plan again",
    ]);
    bench
        .file("parts/b.ngc", BACK)
        .file("mine.toml", format!("{mine}\n"));
    refused(&["mine.toml has changed since the plan", "12 cells"]);
    std::fs::remove_file(bench.path("parts/a.ngc")).unwrap();
    refused(&["cannot read part program", "parts/a.ngc"]);
    bench
        .file("parts/a.ngc", CIRCLE.replace("F1000", "F4000"))
        .file("mine.toml", &mine);
    bench.expect(0, &run);
    // An edited result, and one that is none.
    let text = std::fs::read_to_string(bench.path("r.jsonl")).unwrap();
    bench.file(
        "other.jsonl",
        text.replacen("\"max_um\":", "\"max_um\":9", 1),
    );
    bench.file("broken.jsonl", format!("{{\"key\":1}}\n{text}"));
    let collect = |results: &[&'static str]| {
        [
            &["study", "sweep", "collect", "gaps.jsonl"],
            results,
            &["--out", "t.csv"],
        ]
        .concat()
    };
    bench.refuses(
        &collect(&["r.jsonl", "other.jsonl"]),
        &["two results of cell", "differ"],
    );
    bench.refuses(
        &collect(&["broken.jsonl"]),
        &["broken.jsonl, line 1", "take the line out"],
    );
    bench.refuses(
        &[&run[..4], &["--out", "broken.jsonl"]].concat(),
        &["line 1"],
    );
}

#[test]
fn what_is_wrong_with_a_sweep_is_told_before_it_runs() {
    let bench = bench();
    let gap = "axis.x.load.slide.gap_um";
    let vary = |rest: &str| {
        format!("programs = [\"parts/*.ngc\"]\n[[vary]]\nkeys = [\"{gap}\"]\n{rest}\n")
    };
    for (text, wrong) in [
        (
            SWEEP.replace("gap_um\",", "gap_mm\","),
            &["gap_mm", "did you mean"][..],
        ),
        (SWEEP.replace("40]", "-40]"), &["-40"]),
        (
            SWEEP.replace("bench3", "bench4"),
            &["there is no machine \"bench4\"", "bench3"],
        ),
        (SWEEP.replace("bench3", "no.toml"), &["no.toml"]),
        (SWEEP.replace("\"fixed\"", "\"magic\""), &["magic"]),
        (
            SWEEP.replace("\"fixed\"", "\"none\""),
            &["`methods` names \"none\" twice"],
        ),
        (
            SWEEP.replace("*.ngc", "*.nc"),
            &["fits no file", "patterns start"],
        ),
        (
            SWEEP.replace("parts/*.ngc", "parts/***"),
            &["is no pattern"],
        ),
        (
            SWEEP.replace("axis.x.drive.position_gain_per_s", gap),
            &["is varied twice"],
        ),
        (SWEEP.replace("10.5", "40"), &["`values` has 40 twice"]),
        (SWEEP.replace("[0, 10.5, 40]", "[]"), &["`values` is empty"]),
        (SWEEP.replace("steps = 2", ""), &["needs `steps`"]),
        (
            SWEEP.replace("steps = 2", "steps = 2\nscale = \"cubic\""),
            &["line", "cubic"],
        ),
        (
            SWEEP.replace("from = 20", "from = -1\nscale = \"log\""),
            &["has no logarithm"],
        ),
        (SWEEP.replace("machines", "machine"), &["machine", "line 3"]),
        (format!("points = 5\n{SWEEP}"), &["a grid has as many"]),
        (format!("seed = 5\n{SWEEP}"), &["only random points"]),
        (
            format!("design = \"sobol\"\n{SWEEP}"),
            &["`points` is missing"],
        ),
        (
            format!("design = \"random\"\npoints = 9\n{SWEEP}"),
            &["`steps` is of a grid"],
        ),
        (
            format!("most_cells = 11\n{SWEEP}"),
            &["more than 11 cells", "--most-cells"],
        ),
        (format!("{SWEEP}[run]\nthreads = 3\n"), &["`run.threads`"]),
        (
            format!("{SWEEP}[run]\ntolerance = 3\n"),
            &["[run]", "tolerance"],
        ),
        (
            format!("{SWEEP}[reading]\ndialect = \"fanuk\"\n"),
            &["fanuk", "did you mean"],
        ),
        (
            vary("from = 1"),
            &["needs either `values`, or `from` and `to`"],
        ),
        (vary("from = 1\nto = inf\nsteps = 3"), &["is no range"]),
        (
            vary("from = 0\nto = 1\nsteps = 99999999999"),
            &["more than 100000 cells"],
        ),
        ("programs = []\n".to_owned(), &["nothing to run"]),
        ("programs = [\n".to_owned(), &["gaps.toml", "line"]),
    ] {
        bench.file("gaps.toml", &text);
        bench.refuses(&PLAN, wrong);
    }
    bench.file("gaps.toml", SWEEP);
    bench.refuses(
        &[
            "study",
            "sweep",
            "plan",
            "gaps.toml",
            "--out",
            "no/gaps.jsonl",
        ],
        &["no does not exist"],
    );
    bench.refuses(
        &["study", "sweep", "plan", "gaps.toml", "--out", "gaps.toml"],
        &["is the sweep file"],
    );
    bench.expect(0, &PLAN);
    let manifest = std::fs::read_to_string(bench.path("gaps.jsonl")).unwrap();
    for (text, wrong) in [
        (SWEEP.to_owned(), &["line 1: this is no manifest"][..]),
        (
            manifest.replacen("20.0]", "21.0]", 1),
            &["line 2", "its inputs make"],
        ),
        (
            manifest.replacen("\"lostmotion\":\"", "\"lostmotion\":\"9", 1),
            &["was planned by lostmotion 9"],
        ),
        (manifest[..manifest.len() - 70].to_owned(), &["line 13"]),
        (
            manifest.lines().take(5).collect::<Vec<_>>().join("\n"),
            &["4 cells, but the header says 12"],
        ),
    ] {
        bench.file("wrong.jsonl", text);
        bench.refuses(&["study", "sweep", "run", "wrong.jsonl"], wrong);
    }
    for (shard, wrong) in [
        ("0/3", "from 1 to N"),
        ("4/3", "3/8"),
        ("1", "I/N"),
        ("-1/2", "I/N"),
    ] {
        bench.refuses(
            &["study", "sweep", "run", "gaps.jsonl", "--shard", shard],
            &[wrong],
        );
    }
    let collect = ["study", "sweep", "collect", "gaps.jsonl", "--out"];
    bench.refuses(
        &[&collect[..], &["t.csv"]].concat(),
        &["no results of gaps.jsonl"],
    );
    bench.refuses(
        &[&collect[..], &["t.txt", "gaps.jsonl"]].concat(),
        &["ends neither in"],
    );
    bench.refuses(
        &[&collect[..], &["t.csv", "none.jsonl"]].concat(),
        &["none.jsonl"],
    );
    bench.refuses(
        &[
            "study",
            "sweep",
            "emit",
            "slurm",
            "gaps.jsonl",
            "--shards",
            "0",
        ],
        &["1 to 100000"],
    );
}

/// Each script is short, and what reads it takes it; that of HyperQueue is run by a test of the Python package.
#[test]
fn scripts_are_short_and_sound() {
    let bench = bench();
    bench.file("gaps.toml", SWEEP);
    // A name that a shell would take apart.
    let name = "it's a $HOME.jsonl";
    bench.expect(0, &[&PLAN[..5], &[name]].concat());
    for scheduler in ["slurm", "hq", "dask", "k8s"] {
        let text = sweep(
            &bench,
            0,
            &["emit", scheduler, name, "--shards", "12", "--cores", "4"],
        );
        assert!(text.lines().count() <= 40 && text.contains("12"), "{text}");
        bench.file("script", &text);
        let checked = |program: &str, arguments: &[&str]| {
            let output = Command::new(program)
                .args(arguments)
                .arg(bench.path("script"))
                .output();
            // Without that program there is nothing to ask.
            if let Ok(output) = output {
                assert!(
                    output.status.success(),
                    "{}\n{text}",
                    String::from_utf8_lossy(&output.stderr)
                );
            }
        };
        match scheduler {
            "slurm" | "hq" => checked("bash", &["-n"]),
            "dask" => checked(
                "python3",
                &["-c", "import ast, sys; ast.parse(open(sys.argv[1]).read())"],
            ),
            _ => assert!(
                text.contains("completions: 12") && text.contains(r#"value: "it's a $HOME.jsonl""#)
            ),
        }
    }
    // As Slurm runs a task: the name reaches the command whole.
    let script = sweep(&bench, 0, &["emit", "slurm", name, "--shards", "12"]);
    let program = Path::new(env!("CARGO_BIN_EXE_lostmotion"))
        .parent()
        .unwrap()
        .to_owned();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let task = Command::new("bash")
        .args(["-c", &script])
        .current_dir(bench.path("."))
        .env("PATH", path)
        .env("SLURM_ARRAY_TASK_ID", "3")
        .status();
    assert!(task.unwrap().success());
    assert_eq!(
        lines(&bench.path("it's a $HOME.results-3-of-12.jsonl")).len(),
        1
    );
}
