//! Pages that are made from tables are as the tables are, and the tables have everything.
//!
//! `UPDATE_DOCS=1 cargo test -p lostmotion-gcode docs` writes the pages.
use lostmotion_gcode::{InterpreterConfig, Limits, Program, Severity, catalog, codes};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn check_page(name: &str, page: &str) {
    let path = root().join("docs/book/src/reference").join(name);
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(&path, page).unwrap();
    }
    assert!(
        fs::read_to_string(&path).unwrap_or_default() == page,
        "docs/book/src/reference/{name} is not what its table says: run with UPDATE_DOCS=1"
    );
}

#[test]
fn the_page_of_codes_is_in_step() {
    check_page("codes.md", &codes::page());
}

#[test]
fn severities_are_those_that_are_reported() {
    let limits = Limits {
        looped_blocks: 1000,
        idle_blocks: 1000,
        cycle_moves: 1000,
        ..Limits::default()
    };
    let config = InterpreterConfig {
        limits,
        ..InterpreterConfig::default()
    };
    let mut seen: BTreeMap<&'static str, Severity> = BTreeMap::new();
    for folder in ["hostile", "parts", "codes"] {
        for entry in fs::read_dir(root().join("gcode_samples").join(folder)).unwrap() {
            let text = fs::read(entry.unwrap().path()).unwrap();
            let found = Program::new(&text[..], config.clone()).finish();
            seen.extend(
                found
                    .kept()
                    .iter()
                    .map(|diagnostic| (diagnostic.code(), diagnostic.severity())),
            );
        }
    }
    assert!(seen.len() > 40);
    for (code, severity) in seen {
        assert_eq!(
            catalog::find(code).map(|row| row.severity),
            Some(severity),
            "{code}"
        );
    }
}
