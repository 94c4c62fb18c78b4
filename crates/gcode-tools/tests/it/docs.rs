//! The page of diagnostics and lints is as its tables are.
//!
//! `UPDATE_DOCS=1 cargo test -p lostmotion-gcode-tools docs` writes the page.

use lostmotion_gcode::catalog;
use lostmotion_gcode_tools::lint::rules;
use std::fs;
use std::path::Path;

#[test]
fn the_page_of_diagnostics_is_in_step() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/src/reference/diagnostics.md");
    let page = catalog::page() + &rules::page();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(&path, &page).unwrap();
    }
    assert!(
        fs::read_to_string(&path).unwrap_or_default() == page,
        "docs/book/src/reference/diagnostics.md is not what its tables say: run with UPDATE_DOCS=1"
    );
}

#[test]
fn no_lint_has_the_code_of_a_diagnostic() {
    for rule in rules::all() {
        assert!(catalog::find(rule.code).is_none(), "{}", rule.code);
    }
}
