//! Machines and single axes from the outside: what is listed, checked, run and fitted.

use crate::bench::{Bench, CIRCLE};

/// A line of a trace without the column of the load's position.
fn without_load(trace: &str, line: &str) -> String {
    let column = trace
        .lines()
        .next()
        .unwrap()
        .split(',')
        .position(|name| name == "load_mm")
        .unwrap();
    let cells: Vec<&str> = line
        .split(',')
        .enumerate()
        .filter(|(n, _)| *n != column)
        .map(|(_, cell)| cell)
        .collect();
    cells.join(",") + "\n"
}

#[test]
fn axis_runs_a_plan_and_fit_finds_its_gap() {
    let bench = Bench::new();
    let mut setpoints = String::from("t_s,position_mm\n");
    for tick in 0..4000_u32 {
        // 20 mm to and fro in 250 ms each, so that acceleration torque outweighs friction and
        // varies.
        let phase = f64::from(tick % 250) / 250.0;
        let way = phase * phase * phase * (10.0 - 15.0 * phase + 6.0 * phase * phase);
        let position = 20.0 * if tick / 250 % 2 == 0 { way } else { 1.0 - way };
        setpoints.push_str(&format!("{:.3},{position:.9}\n", f64::from(tick) * 1e-3));
    }
    bench.file("setpoints.csv", &setpoints);
    bench.expect(
        0,
        &[
            "axis",
            "--setpoints",
            "setpoints.csv",
            "--axis",
            "vmc3:x",
            "--method",
            "none",
            "--out",
            "trace.csv",
        ],
    );
    let trace = std::fs::read_to_string(bench.path("trace.csv")).unwrap();
    assert_eq!(trace.lines().count(), 1 + 4 * 4000);
    assert!(trace.lines().nth(2).unwrap().starts_with("0.000250,"));
    let text = bench.expect(
        0,
        &["fit", "trace.csv", "--axis", "vmc3:x", "--out", "fit.json"],
    );
    assert!(text.starts_with("gap "), "{text}");
    let fit: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(bench.path("fit.json")).unwrap()).unwrap();
    let gap = fit["gap"].as_f64().unwrap();
    assert!((gap - 0.010).abs() < 0.000_05, "{gap}");
    // the same without the load's column
    let motor: String = trace
        .lines()
        .map(|line| without_load(&trace, line))
        .collect();
    bench.file("motor.csv", &motor);
    let text = bench.expect(
        0,
        &[
            "fit",
            "motor.csv",
            "--motor-only",
            "--axis",
            "vmc3:x",
            "--out",
            "motor.json",
        ],
    );
    assert!(
        text.contains("\nload ") && text.contains("\nstiffness "),
        "{text}"
    );
    let found: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(bench.path("motor.json")).unwrap()).unwrap();
    let gap = found["gap"].as_f64().unwrap();
    assert!(
        (gap - 0.010).abs() < 0.000_2 && found["motor_only"] == true,
        "{gap}"
    );
    bench.refuses(
        &["fit", "motor.csv", "--axis", "vmc3:x", "--out", "x.json"],
        &["no column `load_mm`"],
    );
    bench.refuses(
        &["fit", "motor.csv", "--motor-only", "--out", "x.json"],
        &["--axis"],
    );
    bench.file("circle.ngc", CIRCLE);
    let told = [
        "compare",
        "circle.ngc",
        "--methods",
        "none,fixed",
        "--fitted",
        "x=fit.json",
    ];
    assert!(bench.expect(0, &told).contains("fixed"));
    let told = [
        "compare",
        "circle.ngc",
        "--methods",
        "fitted-lookup",
        "--fitted",
        "x=motor.json",
    ];
    assert!(bench.expect(0, &told).contains("fitted-lookup"));
    bench.refuses(
        &["compare", "circle.ngc", "--methods", "fitted-lookup"],
        &["needs a fitted gap", "--fitted AXIS=FILE.json"],
    );
    bench.refuses(
        &["simulate", "circle.ngc", "--method", "fitted-lookup"],
        &["needs a fitted gap"],
    );
    bench.refuses(
        &[
            "compare",
            "circle.ngc",
            "--methods",
            "none,fixed",
            "--fitted",
            "c=fit.json",
        ],
        &["has no axis C"],
    );
    bench.refuses(
        &[
            "axis",
            "--setpoints",
            "setpoints.csv",
            "--axis",
            "paper",
            "--out",
            "x.csv",
        ],
        &["are in mm", "is in rad"],
    );
    bench.refuses(
        &[
            "axis",
            "--setpoints",
            "setpoints.csv",
            "--axis",
            "vmc3:q",
            "--out",
            "x.csv",
        ],
        &["vmc3 has no axis \"q\"", "its axes: x, y, z"],
    );
    bench.refuses(
        &[
            "axis",
            "--setpoints",
            "setpoints.csv",
            "--axis",
            "vmc3:x",
            "--method",
            "m",
            "--out",
            "x.csv",
        ],
        &["\"m\"", "published"],
    );
    bench.file("gap.csv", "t_s,position\n0,1\n0.001,2\n0.003,x\n");
    bench.refuses(
        &[
            "axis",
            "--setpoints",
            "gap.csv",
            "--axis",
            "paper",
            "--out",
            "x.csv",
        ],
        &["gap.csv, line 4", "`x`", "not a number"],
    );
    bench.refuses(
        &["fit", "gap.csv", "--out", "x.json"],
        &["no column `motor_mm`"],
    );
}

#[test]
fn machines_are_listed_shown_and_checked() {
    let bench = Bench::new();
    let list = bench.expect(0, &["machine", "list"]);
    assert!(list.contains("vmc3-worn") && list.contains("trunnion5") && list.contains("paper"));
    let shown = bench.expect(0, &["machine", "show", "vmc3"]);
    bench.file("mine.toml", &shown);
    assert!(
        bench
            .expect(0, &["machine", "check", "mine.toml"])
            .contains("\"vmc3\" is sound")
    );
    bench.file("circle.ngc", CIRCLE);
    bench.expect(
        0,
        &[
            "simulate",
            "circle.ngc",
            "--machine",
            "mine.toml",
            "--tolerance-um",
            "1000",
        ],
    );
    bench.file("bad.toml", shown.replace("gap_um", "gap_umm"));
    bench.refuses(
        &["machine", "check", "bad.toml"],
        &["bad.toml:", "gap_umm", "did you mean `gap_um`?"],
    );
    bench.file(
        "nan.toml",
        shown.replacen("tolerance_um = 20.0", "tolerance_um = nan", 1),
    );
    bench.refuses(
        &["simulate", "circle.ngc", "--machine", "nan.toml"],
        &["nan.toml:", "simulate.tolerance_um", "nan"],
    );
    let loops = bench.expect(0, &["machine", "check", "mine.toml"]);
    assert!(
        loops.contains("velocity loop")
            && loops.contains("in the gap")
            && loops.contains("none predicted, none simulated"),
        "{loops}"
    );
    let gain = "velocity_gain_a_s_per_rad = ";
    bench.file("wild.toml", shown.replacen(gain, &format!("{gain}3"), 1));
    bench.refuses(
        &["machine", "check", "wild.toml"],
        &[
            "wild.toml:",
            "axis.x.drive.velocity_gain",
            "unstable",
            "gain margin -",
            "has to be less than",
        ],
    );
    bench.refuses(
        &["machine", "show", "vmc9"],
        &["no machine \"vmc9\"", "vmc3-worn", "robot-joint"],
    );
}

#[test]
fn a_new_machine_keeps_the_comments_of_its_preset_and_is_checked() {
    let bench = Bench::new();
    bench.expect(
        0,
        &[
            "machine",
            "new",
            "mine",
            "--travel",
            "x=-500,0",
            "--travel",
            "z=10,200",
            "--gap",
            "25",
            "--gap",
            "z=4",
            "--velocity",
            "x=300",
            "--tolerance-um",
            "15",
            "-o",
            "mine.toml",
        ],
    );
    let text = std::fs::read_to_string(bench.path("mine.toml")).unwrap();
    for line in [
        "name = \"mine\"  # given",
        "min_mm = -500.0  # given",
        "gap_um = 25.0  # given",
        "gap_um = 4.0  # given",
        "velocity_mm_s = 300.0  # given",
        "tolerance_um = 15.0  # given",
        "# table on the saddle; screw 40 x 16 mm",
    ] {
        assert!(text.lines().any(|found| found == line), "{line}\n{text}");
    }
    bench.expect(0, &["machine", "check", "mine.toml"]);
    for preset in [
        "vmc4",
        "gantry3",
        "trunnion5",
        "corexy",
        "delta",
        "scara",
        "arm6",
        "bench3",
    ] {
        let text = bench.expect(
            0,
            &["machine", "new", "other", "--preset", preset, "--gap", "7"],
        );
        assert!(text.contains("name = \"other\"  # given"), "{preset}");
    }
    let plane = bench.expect(0, &["machine", "new", "plane", "--axes", "x,z"]);
    assert!(
        !plane.contains("[axis.y") && !plane.contains("\ny_mm"),
        "{plane}"
    );
    bench.refuses(
        &["machine", "new", "m", "--preset", "vmc9"],
        &["no machine \"vmc9\"", "vmc3"],
    );
    bench.refuses(
        &["machine", "new", "m", "--axes", "x,q"],
        &["has no axis q", "x, y, z"],
    );
    bench.refuses(
        &["machine", "new", "m", "--travel", "x=5"],
        &["AXIS=MIN,MAX", "hint"],
    );
    bench.refuses(
        &["machine", "new", "m", "--gap", "x=wide"],
        &["`wide` is not a number"],
    );
    bench.refuses(
        &["machine", "new", "m", "--travel", "x=5,-5"],
        &["axis.x.limits.max_mm", "the travel begins at 5"],
    );
}
