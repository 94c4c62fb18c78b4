//! Studies and reproductions from the outside.

use crate::bench::{Bench, names};

#[test]
fn a_study_that_was_stopped_goes_on_and_ends_the_same() {
    let bench = Bench::new();
    let study = |out: &str| {
        [
            "study",
            "matrix",
            "--cells",
            "3",
            "--seed",
            "36",
            "--methods",
            "none,fixed",
            "--out",
            out,
        ]
        .map(str::to_owned)
    };
    let run = |out: &str| bench.expect(0, &study(out).each_ref().map(String::as_str));
    let whole = run("a");
    assert!(whole.contains("| `fixed` |"), "{whole}");
    let kept = std::fs::read_to_string(bench.path("a/cells.jsonl")).unwrap();
    let lines: Vec<&str> = kept.lines().collect();
    assert_eq!(lines.len(), 4);
    // the page of the folder is the one that is asked for, with a dot a cell
    let pages = ["a/matrix.html", "page.html"].map(|name| bench.path(name));
    let mut page = study("a").to_vec();
    page.extend(["--html".to_owned(), pages[1].display().to_string()]);
    assert_eq!(
        bench.expect(0, &page.iter().map(String::as_str).collect::<Vec<_>>()),
        whole
    );
    let pages = pages.map(|page| std::fs::read_to_string(page).unwrap());
    assert_eq!(pages[0], pages[1]);
    assert_eq!(pages[0].matches("<circle").count(), 3);
    // killed while the third cell was being written
    std::fs::create_dir(bench.path("b")).unwrap();
    bench.file(
        "b/cells.jsonl",
        format!("{}\n{}\n{}", lines[0], lines[1], &lines[2][..50]),
    );
    assert_eq!(run("b"), whole);
    assert_eq!(
        std::fs::read(bench.path("b/matrix.csv")).unwrap(),
        std::fs::read(bench.path("a/matrix.csv")).unwrap()
    );
    assert!(
        std::fs::read_to_string(bench.path("b/cells.jsonl"))
            .unwrap()
            .starts_with(&format!("{}\n{}\n", lines[0], lines[1]))
    );

    let other = [
        "study",
        "matrix",
        "--cells",
        "4",
        "--seed",
        "36",
        "--methods",
        "none,fixed",
        "--out",
        "a",
    ];
    bench.refuses(
        &other,
        &["cells.jsonl", "the number of cells is 3, now 4", "--fresh"],
    );
    bench.file(
        "b/cells.jsonl",
        format!("{}\nnonsense\n{}\n", lines[0], lines[1]),
    );
    bench.refuses(
        &study("b").each_ref().map(String::as_str),
        &["line 2", "--fresh"],
    );
}

#[test]
fn studies_refuse_what_makes_no_sense() {
    let bench = Bench::new();
    bench.file("file", "x");
    bench.refuses(
        &["study", "matrix", "--cells", "0"],
        &["0 cells", "1 to 20000"],
    );
    bench.refuses(
        &["study", "matrix", "--cells", "99999999"],
        &["99999999 cells", "full factorial"],
    );
    bench.refuses(
        &["study", "matrix", "--cells", "1", "--methods", "magic"],
        &["magic", "known methods"],
    );
    bench.refuses(
        &[
            "study",
            "matrix",
            "--cells",
            "1",
            "--methods",
            "fixed,fixed",
        ],
        &["twice"],
    );
    bench.refuses(
        &["study", "matrix", "--cells", "1", "--out", "file"],
        &["not a folder"],
    );
    bench.refuses(
        &["study", "matrix", "--cells", "1", "--threads", "0"],
        &["--threads is 0"],
    );
    bench.refuses(
        &["study", "cell", "circle7-f300"],
        &["circle7-f300", "parts"],
    );
    bench.refuses(
        &["study", "endurance", "--minutes", "0"],
        &["--minutes is 0", "1440"],
    );
    bench.refuses(
        &["study", "endurance", "--method", "magic"],
        &["magic", "known methods"],
    );
}

#[test]
fn an_axis_runs_for_a_minute() {
    let table = Bench::new().expect(0, &["study", "endurance", "--minutes", "1"]);
    assert_eq!(
        table.lines().filter(|line| line.starts_with("| ")).count(),
        1 + 12,
        "{table}"
    );
    assert!(
        table.contains("| 1.0 |") && table.contains("`adaptive`"),
        "{table}"
    );
}

#[test]
fn a_stretch_without_motion_says_so() {
    let table = Bench::new().expect(0, &["study", "endurance", "--minutes", "0.01"]);
    assert!(
        table.contains("| 0.000 | 0.000 | no motion |") && !table.contains("- %"),
        "{table}"
    );
}

#[test]
fn a_cell_is_traced() {
    let bench = Bench::new();
    let cell = "circle5-f10000-ccw-g20-t10-v0-j1-e20-steady";
    let table = bench.expect(
        0,
        &[
            "study",
            "cell",
            cell,
            "--method",
            "fixed",
            "--out",
            "trace.csv",
            "--program",
            "cell.ngc",
        ],
    );
    assert_eq!(table.lines().count(), 3, "{table}");
    let trace = std::fs::read_to_string(bench.path("trace.csv")).unwrap();
    let header: Vec<&str> = trace.lines().next().unwrap().split(',').collect();
    assert!(header.contains(&"x_gap_estimate_rad") && header.contains(&"y_engagement"));
    assert!(
        trace
            .lines()
            .all(|line| line.split(',').count() == header.len())
    );
    bench.expect(0, &["canon", "cell.ngc"]);
}

#[test]
fn the_paper_is_reproduced_into_a_folder() {
    let bench = Bench::new();
    bench.file("file", "x");
    bench.refuses(&["reproduce", "paper", "--out", "file"], &["not a folder"]);
    let text = bench.expect(0, &["reproduce", "paper", "--out", "paper"]);
    assert!(text.contains("Not given, and chosen here"), "{text}");
    let files = names(&bench.path("paper"));
    for name in [
        "paper.md",
        "scan.csv",
        "figure_03.svg",
        "figure_11_inertia.svg",
        "scan_published.svg",
    ] {
        assert!(files.iter().any(|file| file == name), "{files:?}");
    }
}
