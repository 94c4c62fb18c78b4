//! Findings as documents.
use lostmotion_gcode::{InterpreterConfig, Program, catalog};
use lostmotion_gcode_tools::lint::{Levels, lint};
use lostmotion_report::findings::{
    BlockRecorder, Counts, Finding, MOST_BLOCKS, Origin, write_json, write_sarif,
};
use lostmotion_sim::results::BlockResult;
use serde_json::Value;
use std::fs;
use std::path::Path;

const PART: &str =
    "G21 G90\no<bad> sub\n  G2 X10.06 I5 F100\no<bad> endsub\no<bad> call\nG1 X?\nG4 P500\n";

fn findings(text: &[u8], name: &str) -> (Vec<Finding>, Counts) {
    let mut program = Program::new(text, InterpreterConfig::default());
    let found = lint(&mut program, Levels::default());
    let origin = Origin {
        program: name,
        provenance: program.diagnostics().provenance(),
    };
    let diagnostics = program.diagnostics();
    let mut list: Vec<Finding> = diagnostics
        .kept()
        .iter()
        .map(|diagnostic| Finding::from_diagnostic(diagnostic, &origin))
        .collect();
    list.extend(
        found
            .kept()
            .iter()
            .map(|finding| Finding::from_lint(finding, &origin)),
    );
    (
        list,
        Counts {
            errors: diagnostics.errors(),
            warnings: diagnostics.warnings() + found.warned(),
            notes: diagnostics.notes(),
        },
    )
}

fn sarif(findings: &[Finding]) -> Value {
    let mut out = Vec::new();
    write_sarif(&mut out, findings).unwrap();
    serde_json::from_slice(&out).unwrap()
}

#[test]
fn json_has_code_place_values_hint_and_calls() {
    let (list, counts) = findings(PART.as_bytes(), "a part.ngc");
    let mut out = Vec::new();
    write_json(&mut out, &list, counts).unwrap();
    let document: Value = serde_json::from_slice(&out).unwrap();
    assert_eq!(
        (&document["schema"], &document["errors"]),
        (&1.into(), &2.into())
    );
    let arc = document["findings"]
        .as_array()
        .unwrap()
        .iter()
        .find(|finding| finding["code"] == "arc-radii")
        .unwrap();
    assert_eq!(
        (&arc["severity"], &arc["file"]),
        (&"error".into(), &"a part.ngc".into())
    );
    assert_eq!(
        (
            &arc["span"]["line"],
            &arc["span"]["column"],
            &arc["span"]["len"]
        ),
        (&3.into(), &3.into(), &2.into())
    );
    assert_eq!(arc["values"]["start_radius"], 5.0);
    assert!((arc["values"]["end_radius"].as_f64().unwrap() - 5.06).abs() < 1e-9);
    assert_eq!(
        arc["hint"],
        "the nearest centre with equal radii is I5.03 J0"
    );
    assert_eq!(arc["values"]["place"]["end"][0], 10.06);
    assert_eq!(
        (&arc["calls"][0]["sub"], &arc["calls"][0]["span"]["line"]),
        (&"bad".into(), &5.into())
    );
    let dwell = document["findings"]
        .as_array()
        .unwrap()
        .iter()
        .find(|finding| finding["code"] == "dwell-milliseconds")
        .unwrap();
    assert_eq!(dwell["values"]["seconds"], 500.0);
}

/// What the schema of SARIF 2.1.0 requires of a log, a run, a driver, a rule, a result and what
/// lies in them.
fn check_sarif(log: &Value) {
    assert_eq!(log["version"], "2.1.0");
    assert!(
        log["$schema"]
            .as_str()
            .unwrap()
            .ends_with("sarif-schema-2.1.0.json")
    );
    let run = &log["runs"].as_array().unwrap()[0];
    let driver = &run["tool"]["driver"];
    assert_eq!(driver["name"], "lostmotion");
    let rules = driver["rules"].as_array().unwrap();
    for (index, rule) in rules.iter().enumerate() {
        let id = rule["id"].as_str().unwrap();
        assert!(
            rules.iter().take(index).all(|other| other["id"] != id),
            "{id} is listed twice"
        );
        assert!(
            rule["shortDescription"]["text"]
                .as_str()
                .is_some_and(|text| !text.is_empty()),
            "{id}"
        );
        assert!(
            rule["help"]["text"].is_string()
                && ["note", "warning", "error"]
                    .contains(&rule["defaultConfiguration"]["level"].as_str().unwrap())
        );
    }
    for result in run["results"].as_array().unwrap() {
        assert!(
            result["message"]["text"]
                .as_str()
                .is_some_and(|text| !text.is_empty())
        );
        assert!(["none", "note", "warning", "error"].contains(&result["level"].as_str().unwrap()));
        let index = usize::try_from(result["ruleIndex"].as_u64().unwrap()).unwrap();
        assert_eq!(rules[index]["id"], result["ruleId"]);
        check_location(&result["locations"][0]);
        for stack in result["stacks"].as_array().into_iter().flatten() {
            for frame in stack["frames"].as_array().unwrap() {
                check_location(&frame["location"]);
                assert!(frame["location"]["message"]["text"].is_string());
            }
        }
    }
}

fn check_location(location: &Value) {
    let place = &location["physicalLocation"];
    let uri = place["artifactLocation"]["uri"].as_str().unwrap();
    assert!(uri.bytes().all(|byte| byte.is_ascii_graphic()), "{uri}");
    if let Some(region) = place["region"].as_object() {
        let number = |name: &str| region[name].as_u64().unwrap();
        assert!(
            number("startLine") >= 1
                && number("startColumn") >= 1
                && number("endColumn") >= number("startColumn")
        );
        number("byteOffset");
        number("byteLength");
    }
}

#[test]
fn sarif_has_what_its_schema_requires() {
    let log = sarif(&findings(PART.as_bytes(), "dir/a part.ngc").0);
    check_sarif(&log);
    let results = log["runs"][0]["results"].as_array().unwrap();
    let arc = results
        .iter()
        .find(|result| result["ruleId"] == "arc-radii")
        .unwrap();
    assert_eq!(
        arc["locations"][0]["physicalLocation"]["artifactLocation"]["uri"],
        "dir/a%20part.ngc"
    );
    assert_eq!(
        arc["stacks"][0]["frames"][0]["location"]["physicalLocation"]["region"]["startLine"],
        5
    );
    check_sarif(&sarif(&[]));
    assert_eq!(sarif(&[])["runs"][0]["results"], Value::Array(Vec::new()));
}

#[test]
fn every_hostile_program_has_a_document() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gcode_samples/hostile");
    let mut tried = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read(&path).unwrap();
        // Endless ones are the interpreter's test.
        if text.len() < 2000 && !String::from_utf8_lossy(&text).to_lowercase().contains('o') {
            check_sarif(&sarif(&findings(&text, &path.display().to_string()).0));
            tried += 1;
        }
    }
    assert!(tried > 20, "{tried}");
}

#[test]
fn rules_are_known() {
    for finding in findings(PART.as_bytes(), "part").0 {
        let known = catalog::find(&finding.code).is_some()
            || lostmotion_gcode_tools::lint::rules::find(&finding.code).is_some();
        assert!(known, "{}", finding.code);
    }
}

fn row(line: u32, max_um: f64) -> BlockResult {
    let mut row = made!(BlockResult { max_um });
    row.block.span.line = line;
    row.block.span.start = u64::from(line) * 10;
    row
}

#[test]
fn of_many_blocks_outside_the_tolerance_the_worst_are_kept_whatever_the_chunks() {
    // Errors in an order of their own, each block in two passes of which one is the worse.
    let blocks = 5 * MOST_BLOCKS as u32;
    let error = |line: u32, pass: u32| {
        let size = f64::from((line * 7919) % blocks + 1);
        if (line + pass).is_multiple_of(2) {
            -size
        } else {
            0.5 * size
        }
    };
    let rows: Vec<BlockResult> = (0..2)
        .flat_map(|pass| (0..blocks).map(move |line| row(line, error(line, pass))))
        .collect();
    let tolerance = 10.0;
    let recorded = |chunk: usize| {
        let mut recorder = BlockRecorder::new(1, tolerance);
        for rows in rows.chunks(chunk) {
            recorder.push(0, rows);
        }
        recorder
    };
    // By sorting all of them: sizes are 1 to their number, so that the worst are the last thousand.
    let mut wanted: Vec<u32> = (0..blocks)
        .filter(|line| (line * 7919) % blocks + 1 > blocks - MOST_BLOCKS as u32)
        .collect();
    wanted.sort_unstable();
    for chunk in [1, 17, 4096, rows.len()] {
        let recorder = recorded(chunk);
        let kept = recorder.blocks(0);
        let lines: Vec<u32> = kept.iter().map(|block| block.block.span.line).collect();
        assert_eq!(lines, wanted, "chunks of {chunk}");
        assert!(kept.iter().all(|block| block.max_um < -tolerance));
        assert!(recorder.has_more(0));
    }
    // Rapids and what is within the tolerance are no findings.
    let mut recorder = BlockRecorder::new(1, tolerance);
    let mut rapid = row(1, 90.0);
    rapid.rapid = true;
    recorder.push(0, &[rapid, row(2, -10.0), row(3, 10.1)]);
    assert_eq!(recorder.blocks(0).len(), 1);
    assert!(!recorder.has_more(0) && recorder.blocks(7).is_empty());
}
