//! What the tests of several subjects do with a program.

use lostmotion_gcode::{
    Diagnostic, Dialect, InterpreterConfig, Motion, MotionFold, MotionItem, Program, SourcedOp,
};

/// Settings of a dialect.
pub(crate) fn config(dialect: Dialect) -> InterpreterConfig {
    InterpreterConfig::default().with_dialect(dialect)
}

/// Codes of the findings that were kept.
pub(crate) fn codes(text: &str, config: InterpreterConfig) -> Vec<&'static str> {
    let found = Program::new(text.as_bytes(), config).finish();
    found.kept().iter().map(Diagnostic::code).collect()
}

/// Operations of a program without errors.
pub(crate) fn ops(text: &str) -> Vec<SourcedOp> {
    ops_of(text, InterpreterConfig::default())
}

pub(crate) fn ops_of(text: &str, config: InterpreterConfig) -> Vec<SourcedOp> {
    let mut program = Program::new(text.as_bytes(), config);
    let all = program.by_ref().collect();
    assert_eq!(
        program.diagnostics().errors(),
        0,
        "{:?}",
        program.diagnostics().kept()
    );
    all
}

/// Moves of a program without errors.
pub(crate) fn moves_with(text: &str, config: InterpreterConfig) -> Vec<Motion> {
    let mut fold = MotionFold::new(config.start);
    let mut items = Vec::new();
    for op in ops_of(text, config) {
        fold.push_all(&op, &mut items).unwrap();
    }
    let moves = items.into_iter().filter_map(|item| match item {
        MotionItem::Move(motion) => Some(motion),
        _ => None,
    });
    moves.collect()
}
