//! Line by line it is the same as in one piece.
use lostmotion_gcode::{Feeder, InterpreterConfig, Program};
use proptest::prelude::*;

const LINES: [&str; 16] = [
    "G1 X1 F100",
    "X2",
    "o1 repeat [2]",
    "Y[#1+1]",
    "o1 endrepeat",
    "o<a> sub",
    "o<a> endsub",
    "o<a> call",
    "G2 X5 I1",
    "?",
    "(note)",
    "G91",
    "M98 P5",
    "",
    "o2 if [0]",
    "o2 endif",
];

proptest! {
    #[test]
    fn lines_give_what_the_program_gives(picks in prop::collection::vec(0usize..LINES.len(), 0..30)) {
        let text: String = picks.iter().map(|pick| format!("{}\n", LINES[*pick])).collect();
        let mut program = Program::new(text.as_bytes(), InterpreterConfig::default());
        program.take_pending();
        let expected: Vec<_> = program.by_ref().collect();
        let mut feeder = Feeder::new(InterpreterConfig::default());
        let (mut ops, mut diagnostics) = (Vec::new(), Vec::new());
        for line in text.split_inclusive('\n') {
            let fed = feeder.feed(line.as_bytes());
            ops.extend(fed.ops);
            diagnostics.extend(fed.diagnostics);
        }
        let fed = feeder.finish();
        ops.extend(fed.ops);
        diagnostics.extend(fed.diagnostics);
        prop_assert_eq!(ops, expected);
        prop_assert!(fed.ended);
        let counts = |list: &[lostmotion_gcode::Diagnostic]| list.iter().filter(|d| d.severity() == lostmotion_gcode::Severity::Error).count();
        prop_assert_eq!(counts(&diagnostics) > 0, program.diagnostics().errors() > 0);
    }
}

#[test]
fn a_loop_runs_when_it_is_closed() {
    let mut feeder = Feeder::new(InterpreterConfig::default());
    assert!(feeder.feed(b"o1 while [#1 lt 3]").ops.is_empty());
    assert_eq!(feeder.feed(b"G0 X#1 #1=[#1+1]\r\n").ops.len(), 1);
    assert_eq!(feeder.feed(b"o1 endwhile\n").ops.len(), 2);
    assert!(feeder.feed(b"o<s> sub").waits);
    assert!(!feeder.feed(b"o<s> endsub").waits);
    let fed = feeder.feed(b"G0 X");
    assert_eq!(
        (
            fed.diagnostics[0].code(),
            fed.diagnostics[0].place.span.line,
            fed.ended
        ),
        ("missing-number", 6, false)
    );
    assert!(feeder.feed(b"M2").ended);
    assert!(feeder.feed(b"G0 X5").ops.is_empty());
}

#[test]
fn findings_do_not_run_out() {
    let mut feeder = Feeder::new(InterpreterConfig::default());
    for _ in 0..500 {
        assert_eq!(feeder.feed(b"G99.9").diagnostics.len(), 1);
    }
    assert_eq!(feeder.interpreter().diagnostics().errors(), 500);
    assert_eq!(feeder.interpreter().diagnostics().dropped(), 0);
}
