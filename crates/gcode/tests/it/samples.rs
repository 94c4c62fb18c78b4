//! Every row of the code table has a sample program that uses its code, runs without errors, and
//! means what its snapshot says.
use lostmotion_gcode::{
    Diagnostic, InterpreterConfig, Leniencies, Leniency, Program, Tool, ToolTable, codes,
};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gcode_samples/codes")
}

/// Tools 1 to 9, each 10 mm longer and 2 mm thicker than the last.
fn tools() -> ToolTable {
    let mut table = ToolTable::default();
    for number in 1..10 {
        let mut tool = Tool {
            number,
            pocket: number,
            diameter: 2.0 * f64::from(number),
            ..Tool::default()
        };
        tool.offset[2] = 10.0 * f64::from(number);
        table.insert(tool);
    }
    table
}

/// A program and what it does.
fn shown(name: &str, leniency: Option<Leniency>) -> String {
    let text = fs::read(folder().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let mut config = InterpreterConfig {
        tool_table: Some(tools()),
        ..InterpreterConfig::default()
    };
    config.leniencies = leniency
        .into_iter()
        .fold(config.leniencies, Leniencies::with);
    let mut program = Program::new(&text[..], config);
    // The first four operations tell the initial state, which is the same for all.
    let ops: Vec<String> = program
        .by_ref()
        .skip(4)
        .map(|sourced| format!("{:>3} {}", sourced.block.span.line, sourced.op))
        .collect();
    let diagnostics = program.diagnostics();
    let told: Vec<&str> = diagnostics.kept().iter().map(Diagnostic::code).collect();
    assert_eq!(
        told,
        leniency
            .iter()
            .map(|leniency| leniency.name())
            .collect::<Vec<_>>(),
        "{name}: {:?}",
        diagnostics.kept()
    );
    format!(
        "{}\n---\n{}\n",
        String::from_utf8(text).unwrap().trim_end(),
        ops.join("\n")
    )
}

#[test]
fn every_code_has_a_sample_with_a_snapshot() {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for row in codes::rows() {
            insta::assert_snapshot!(
                row.sample.replace(".ngc", ""),
                shown(row.sample, row.leniency)
            );
        }
    });
}

#[test]
fn every_sample_uses_its_code() {
    for row in codes::rows() {
        let text = fs::read_to_string(folder().join(row.sample)).unwrap();
        let code = row.code.to_string();
        let used = text
            .split(|c: char| c.is_whitespace())
            .any(|word| word == code);
        assert!(used, "{} does not use {code}", row.sample);
    }
}

#[test]
fn every_sample_belongs_to_a_code() {
    let known: BTreeSet<&str> = codes::rows().map(|row| row.sample).collect();
    for entry in fs::read_dir(folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(
            known.contains(name.as_str()),
            "no code has {name} as its sample"
        );
    }
}
