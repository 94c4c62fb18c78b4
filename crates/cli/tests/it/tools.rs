//! One tool table means the same length and the same radius in every command that reads a program,
//! held by the places of tip and joints that follow from it by hand.

use crate::bench::Bench;

/// Pockets that are the numbers of other tools: T and H name tools. D is a diameter.
const TABLE: &str = "T3 P7 Z42.5 D8 ; drill\nT7 P3 Z99 D12 ; mill, its radius is 6\n";
/// The same tools in a machine file.
const ENTRIES: &str = "\n[[tool]]\nnumber = 3\nlength_mm = 42.5\ndiameter_mm = 8.0\n\
    \n[[tool]]\nnumber = 7\nlength_mm = 99.0\ndiameter_mm = 12.0\n";
/// The length of one tool and the radius of the other.
const PART: &str = "G21 G90 G94 G17 G54 G61\nT3 M6\nG43 H3\nG0 X-20 Y-10 Z30\n\
    G41 D7 G1 X0 Y0 F1200\nY40\nX30\nG40 X60\nM2\n";
/// The same in inches: the table stays in millimetres.
const INCHES: &str = "G20 G90 G94 G17 G54 G61\nT3 M6\nG43 H3\n\
    G0 X[-20/25.4] Y[-10/25.4] Z[30/25.4]\nG41 D7 G1 X0 Y0 F[1200/25.4]\nY[40/25.4]\n\
    X[30/25.4]\nG40 X[60/25.4]\nM2\n";
const ZERO: [&str; 2] = ["--offset", "g54=-300,-200,-280"];
const ON: [&str; 4] = ["-m", "vmc3", ZERO[0], ZERO[1]];
const WITH: [&str; 2] = ["--tool-table", "tools.tbl"];

fn bench() -> Bench {
    let bench = Bench::new();
    bench
        .file("tools.tbl", TABLE)
        .file("part.ngc", PART)
        .file("inches.ngc", INCHES);
    bench
}

/// Numbers of the named columns in the rows of a line of the program.
fn rows<const N: usize>(table: &str, line: &str, names: [&str; N]) -> Vec<[f64; N]> {
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| {
        header
            .iter()
            .position(|column| *column == name)
            .unwrap_or_else(|| panic!("no column {name} in {header:?}"))
    };
    let (of_line, places) = (place("line"), names.map(place));
    lines
        .map(|row| row.split(',').collect::<Vec<&str>>())
        .filter(|cells| cells[of_line] == line)
        .map(|cells| places.map(|column| cells[column].parse().unwrap()))
        .collect()
}

/// Joints of a plan: on the first leg the tip's path is 6 mm to the left of X0, on the second 6 mm
/// above Y40, and the spindle 42.5 mm above the tip.
fn holds_plan(table: &str) {
    let first = rows(table, "6", ["x_mm", "y_mm", "z_mm"]);
    assert!(first.len() > 100, "{}", first.len());
    let last = rows(table, "7", ["x_mm", "y_mm", "z_mm"]);
    let [x, y, z] = last[last.len() - 1];
    for [.., z] in first.iter().chain(&last) {
        assert!((z + 207.5).abs() < 1e-9, "{z}");
    }
    let [x_middle, ..] = first[first.len() / 2];
    assert!((x_middle + 306.0).abs() < 1e-9, "{x_middle}");
    assert!(
        (y + 154.0).abs() < 1e-9 && (x + 270.0).abs() < 0.1,
        "{x} {y} {z}"
    );
}

fn plan(bench: &Bench, part: &str, more: &[&str]) -> String {
    let fixed = ["plan", part, "-q", "-o", "plan.csv"];
    bench.expect(0, &[&fixed[..], more].concat());
    std::fs::read_to_string(bench.path("plan.csv")).unwrap()
}

#[test]
fn one_tool_table_means_the_same_in_every_command() {
    let bench = bench();
    let on = [&ON[..], &WITH].concat();
    let planned = plan(&bench, "part.ngc", &on);
    holds_plan(&planned);
    holds_plan(&plan(&bench, "inches.ngc", &on));

    // The machine's own tools.
    let machine = bench.expect(0, &["machine", "show", "vmc3"]);
    bench.file("own.toml", machine + ENTRIES);
    let own = plan(&bench, "part.ngc", &["-m", "own.toml", ZERO[0], ZERO[1]]);
    assert!(own == planned, "the machine file's tools are others");

    // The tip as it is simulated, from the program's zero.
    let simulate = ["simulate", "part.ngc", "-q", "--trace", "--out", "run"];
    let told = bench.run(&[&simulate[..], &on].concat());
    assert!(told.status.code() != Some(2), "{told:?}");
    let trace = std::fs::read_to_string(bench.path("run/contour.csv")).unwrap();
    for kind in ["commanded", "tool"] {
        let names = ["x", "y", "z"].map(|axis| format!("{kind}_{axis}_mm"));
        let at = rows(&trace, "6", [&names[0], &names[1], &names[2]]);
        let [x, _, z] = at[at.len() / 2];
        assert!(
            (x + 6.0).abs() < 0.02 && (z - 30.0).abs() < 0.02,
            "{kind}: {x} {z}"
        );
    }

    // As operations, explained, and resolved, on the machine and without one.
    for more in [&on[..], &WITH] {
        let canon = bench.expect(0, &[&["gcode", "canon", "part.ngc"], more].concat());
        for said in [
            "USE_TOOL_LENGTH_OFFSET(0.0000 0.0000 42.5000",
            "STRAIGHT_FEED(-6.0000, 40.0000, 30.0000",
            "STRAIGHT_FEED(30.0000, 46.0000, 30.0000",
        ] {
            assert!(canon.contains(said), "{said}: {canon}");
        }
        let explained = bench.expect(0, &[&["gcode", "explain", "part.ngc:6"], more].concat());
        assert!(explained.contains("Z42.5"), "{explained}");
        assert!(explained.contains("X-6"), "{explained}");
        let written = bench.expect(0, &[&["gcode", "write", "part.ngc"], more].concat());
        assert!(
            written.contains("Z42.5") && written.contains("X-6 "),
            "{written}"
        );
        // The written program has it all in it: no table, the same joints.
        bench.file("written.ngc", &written);
        let again = plan(&bench, "written.ngc", &ON);
        let last = |table: &str| {
            let row = table.lines().last().unwrap();
            let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            [cells[1], cells[2], cells[3]]
        };
        for (a, b) in last(&again).into_iter().zip(last(&planned)) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    // The cycle time is that of the plan.
    let time = ["time", "part.ngc", "--format", "json", "--no-what-if"];
    let json = bench.expect(0, &[&time[..], &on].concat());
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let end = planned.lines().last().unwrap().split(',').next().unwrap();
    let (end_s, cycle_s) = (
        end.parse::<f64>().unwrap(),
        report["total_s"].as_f64().unwrap(),
    );
    assert!((end_s - cycle_s).abs() < 2e-3, "{end_s} {cycle_s}");
}

/// The spindle's travel ends at 0: -280 + 237 + 42.5 is within it, 240 for 237 is not. Every command
/// on the machine says so, with the table and with the machine's own tools.
#[test]
fn the_travel_counts_with_the_length_of_the_table() {
    let bench = bench();
    let machine = bench.expect(0, &["machine", "show", "vmc3"]);
    bench.file("own.toml", machine + ENTRIES);
    for (z, fits) in [("237", true), ("240", false)] {
        bench.file(
            "high.ngc",
            format!("G21 G90 G94 G17 G54\nT3 M6\nG43 H3\nG0 Z{z}\nG1 X5 F500\nM2\n"),
        );
        let table = [&ON[..], &WITH].concat();
        let own = ["-m", "own.toml", ZERO[0], ZERO[1]];
        for on in [&table[..], &own] {
            for command in [
                &["check"][..],
                &["plan", "-o", "high.csv"],
                &["time", "--no-what-if"],
                &["simulate"],
            ] {
                let output = bench.run(&[command, &["high.ngc"], on].concat());
                let told = String::from_utf8_lossy(&output.stderr)
                    + String::from_utf8_lossy(&output.stdout);
                assert_eq!(
                    output.status.code() != Some(2),
                    fits,
                    "Z{z}, {command:?} {on:?}: {told}"
                );
            }
        }
    }
}

/// A plan says what is missing, too: it would be that of a tool without radius.
#[test]
fn a_plan_without_a_tool_table_warns() {
    let bench = Bench::new();
    bench.file(
        "comp.ngc",
        "G21 G17 G90 G54\nG0 X0 Y0\nG41 D2 G1 X20 F600\nX60\nY30\nG40 X80 Y50\nM2\n",
    );
    let run = |more: &[&str]| {
        let plan = ["plan", "comp.ngc", "-o", "plan.csv"];
        let done = bench.command(&[&plan[..], more].concat()).output().unwrap();
        assert_eq!(done.status.code(), Some(0));
        String::from_utf8(done.stderr).unwrap()
    };
    let told = run(&[]);
    assert!(
        told.contains("no-tool-radius") && told.contains("name a tool table"),
        "{told}"
    );
    assert_eq!(run(&["-q"]), "");
}
