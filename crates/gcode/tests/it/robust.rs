//! No input makes the interpreter panic, hang or lose its place.
use crate::generate::line;
use lostmotion_gcode::{
    Diagnostics, Interpreter, InterpreterConfig, Limits, MotionFold, Place, Program, Step,
};
use proptest::prelude::*;
use std::io::BufReader;

fn config() -> InterpreterConfig {
    let limits = Limits {
        looped_blocks: 20_000,
        idle_blocks: 2_000,
        cycle_moves: 2_000,
        ..Limits::default()
    };
    InterpreterConfig {
        limits,
        ..InterpreterConfig::default()
    }
}

/// Runs to the end with motion; every span has to lie within the source.
fn run(source: &[u8]) -> Diagnostics {
    let mut program = Program::new(source, config());
    let mut fold = MotionFold::new(config().start);
    for op in program.by_ref() {
        let span = op.block.span;
        assert!(span.start + u64::from(span.len) <= source.len() as u64);
        let _ = fold.push(&op);
        assert!(fold.position().is_finite());
    }
    for diagnostic in program.diagnostics().kept() {
        let span = diagnostic.place.span;
        assert!(
            span.start + u64::from(span.len) <= source.len() as u64,
            "{diagnostic}"
        );
    }
    program.finish()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn random_bytes_end_in_an_answer(source in prop::collection::vec(any::<u8>(), 0..300)) {
        run(&source);
    }

    #[test]
    fn random_programs_end_in_an_answer(lines in prop::collection::vec(line(), 0..40)) {
        run(lines.join("\n").as_bytes());
    }

    #[test]
    fn the_size_of_the_pieces_read_does_not_matter(lines in prop::collection::vec(line(), 0..12), capacity in 1usize..8, terminator in 0usize..3) {
        let source = lines.join(["\n", "\r\n", "\r"][terminator]);
        let mut whole = Program::new(source.as_bytes(), config());
        let mut pieces = Program::new(BufReader::with_capacity(capacity, source.as_bytes()), config());
        prop_assert_eq!(whole.by_ref().collect::<Vec<_>>(), pieces.by_ref().collect::<Vec<_>>());
        prop_assert_eq!(whole.finish(), pieces.finish());
    }

    #[test]
    fn block_by_block_is_the_same_as_all_at_once(lines in prop::collection::vec(line(), 0..12)) {
        let source: String = lines.iter().map(|line| format!("{line}\n")).collect();
        let mut program = Program::new(source.as_bytes(), config());
        let expected: Vec<_> = program.by_ref().collect();
        let mut interpreter = Interpreter::new(config());
        let mut ops = Vec::new();
        interpreter.begin(&mut ops);
        let mut start = 0;
        let mut lines = lines.iter().zip(1..);
        loop {
            match interpreter.step(&mut ops) {
                Step::Ran => {}
                Step::Ended => break,
                Step::NeedsLine => match lines.next() {
                    Some((text, line)) => {
                        interpreter.push_line(text.as_bytes(), Place { file: 0, line, start });
                        start += text.len() as u64 + 1;
                    }
                    None => interpreter.end_of_source(),
                },
            }
        }
        prop_assert_eq!(ops, expected);
        prop_assert_eq!(interpreter.into_diagnostics(), program.finish());
    }
}

#[test]
fn deep_nesting_is_an_error_and_not_a_crash() {
    for text in ["[", "#", "-", "sin[", "exists[#"] {
        let source = format!("G0 X{}1\nM2\n", text.repeat(100_000 / text.len()));
        let limits = Limits {
            line_bytes: 1 << 20,
            ..Limits::default()
        };
        let diagnostics = Program::new(
            source.as_bytes(),
            InterpreterConfig {
                limits,
                ..InterpreterConfig::default()
            },
        )
        .finish();
        assert_eq!(
            diagnostics
                .kept()
                .first()
                .map(lostmotion_gcode::Diagnostic::code),
            Some("too-deep"),
            "{text}"
        );
    }
}

#[test]
fn diagnostics_are_bounded_and_all_are_counted() {
    let source = "G39 X1\n".repeat(5000) + "M2\n";
    let diagnostics = Program::new(source.as_bytes(), InterpreterConfig::default()).finish();
    assert_eq!(
        (
            diagnostics.errors(),
            diagnostics.kept().len(),
            diagnostics.dropped()
        ),
        (5000, 100, 4900)
    );
}

#[test]
fn endless_loops_end_with_their_line() {
    for (source, code) in [
        ("o1 while [1]\no1 endwhile\nM2\n", "idle-loop"),
        ("o1 while [1]\n#1=[#1+1]\no1 endwhile\nM2\n", "idle-loop"),
        (
            "o1 sub\no1 call\no1 endsub\no1 call\nM2\n",
            "calls-too-deep",
        ),
        (
            "o1 while [1]\nG0 X1\no1 endwhile\nM2\n",
            "too-many-looped-blocks",
        ),
    ] {
        let diagnostics = Program::new(source.as_bytes(), config()).finish();
        let found = diagnostics
            .kept()
            .iter()
            .find(|d| d.code() == code)
            .unwrap();
        assert!((1..=3).contains(&found.place.span.line), "{found}");
    }
}

#[test]
fn memory_does_not_grow_with_the_program() {
    let limits = Limits {
        held_bytes: 1000,
        line_bytes: 100,
        ..Limits::default()
    };
    let config = InterpreterConfig {
        limits,
        ..InterpreterConfig::default()
    };
    // A branch that is open over all lines must not hold them: the limit of held bytes is far below
    // the source.
    let branch = "o1 if [1]\n".to_owned() + &"G0 X1 Y2\n".repeat(5000) + "o1 endif\nM2\n";
    assert_eq!(
        Program::new(branch.as_bytes(), config.clone())
            .finish()
            .errors(),
        0
    );
    let repeat = "o1 repeat [2]\n".to_owned() + &"G0 X1 Y2\n".repeat(5000) + "o1 endrepeat\nM2\n";
    let diagnostics = Program::new(repeat.as_bytes(), config).finish();
    assert!(
        diagnostics
            .kept()
            .iter()
            .any(|d| d.code() == "too-much-held")
    );
}

#[test]
fn what_stays_open_is_bounded() {
    let source: String = (0..5000)
        .map(|label| format!("o{label} if [1]\n"))
        .collect();
    let diagnostics = Program::new(source.as_bytes(), config()).finish();
    let codes: Vec<_> = diagnostics
        .kept()
        .iter()
        .map(|found| (found.code(), found.place.span.line))
        .collect();
    assert_eq!(codes, [("too-many-open", 1001)]);
}

#[test]
fn what_subroutines_hold_is_bounded_together() {
    let limits = Limits {
        held_bytes: 100_000,
        ..Limits::default()
    };
    let config = InterpreterConfig {
        limits,
        ..InterpreterConfig::default()
    };
    let held = |source: &str| {
        let diagnostics = Program::new(source.as_bytes(), config.clone()).finish();
        diagnostics
            .kept()
            .iter()
            .any(|found| found.code() == "too-much-held")
    };
    let subs = |count: usize, names: usize| -> String {
        (0..count)
            .map(|i| format!("o{0} sub\nG0 X1\no{0} endsub\n", i % names))
            .collect()
    };
    assert!(!held(&(subs(200, 200) + "M2\n")));
    assert!(held(&(subs(400, 400) + "M2\n")));
    assert!(!held(&(subs(2000, 1) + "M2\n")));
}

#[test]
fn a_name_of_blanks_is_none() {
    for line in ["o< > sub", "#< >=1", "G0 X#< >"] {
        let diagnostics = Program::new(format!("{line}\nM2\n").as_bytes(), config()).finish();
        assert_eq!(
            diagnostics
                .kept()
                .first()
                .map(lostmotion_gcode::Diagnostic::code),
            Some("syntax"),
            "{line}"
        );
    }
}

#[test]
fn jumps_that_search_a_long_program_again_and_again_end() {
    let lines = 20_000;
    let source: String = (1..=lines)
        .map(|line| format!("N{line} GOTO {}\n", lines + 1 - line))
        .collect();
    let config = InterpreterConfig::default().with_dialect(lostmotion_gcode::Dialect::Fanuc);
    let diagnostics = Program::new(source.as_bytes(), config).finish();
    assert!(
        diagnostics
            .kept()
            .iter()
            .any(|d| d.code() == "too-many-looped-blocks"),
        "{:?}",
        diagnostics.kept()
    );
}
