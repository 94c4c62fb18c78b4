//! Programs made to hurt: each ends under the limits as they are by default and keeps motion
//! finite; the snapshot shows what it is told.
use lostmotion_gcode::{Diagnostic, InterpreterConfig, MotionFold, Program};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// What is found in a program: how much, and what kinds.
fn found(text: &[u8]) -> String {
    let mut fold = MotionFold::new(InterpreterConfig::default().start);
    let mut program = Program::new(text, InterpreterConfig::default());
    for op in program.by_ref() {
        let _ = fold.push(&op);
        assert!(fold.position().is_finite());
    }
    let diagnostics = program.diagnostics();
    let kinds: BTreeSet<&str> = diagnostics.kept().iter().map(Diagnostic::code).collect();
    let kinds = kinds.into_iter().collect::<Vec<_>>().join(" ");
    format!(
        "{} errors, {} warnings: {kinds}",
        diagnostics.errors(),
        diagnostics.warnings()
    )
}

#[test]
fn every_hostile_program_ends() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gcode_samples/hostile");
    let mut names: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    names.retain(|path| path.extension().is_some_and(|ending| ending == "ngc"));
    names.sort();
    assert!(names.len() >= 60);
    let mut lines = Vec::new();
    for path in names {
        let found = found(&fs::read(&path).unwrap());
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        lines.push(format!("{name}: {found}"));
    }
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!("hostile", lines.join("\n")));
}
