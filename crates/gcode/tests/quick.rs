//! Plain straight moves take a short way through the interpreter: the same programs written so that they cannot take it give
//! the same operations and the same findings.
#![allow(clippy::unwrap_used)]

use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::{InterpreterConfig, Program};
use proptest::prelude::*;

/// A word of a straight move, rarely one that does not belong there.
fn word() -> impl Strategy<Value = (char, String)> {
    let letters = prop_oneof![20 => "[XYZ]", 4 => "[ABC]", 1 => "[UVWFIRSN]"];
    let number = prop_oneof![20 => -2e5..2e5_f64, 1 => Just(1e9), 1 => Just(-1.0), 1 => Just(0.0)];
    (letters, number).prop_map(|(letter, number)| (letter.chars().next().unwrap(), format!("{number:.3}")))
}

/// A block: a code or none, and words.
fn block() -> impl Strategy<Value = (&'static str, Vec<(char, String)>)> {
    let codes = prop_oneof![
        30 => prop::sample::select(vec!["", "G0", "G1", "G0 ", "G1 "]),
        8 => prop::sample::select(vec![
            "F100", "F0", "F2000000", "G20", "G21", "G90", "G91", "G93", "G94", "G95", "G7", "G8", "G18", "G17", "G80", "G41.1 D2", "G40", "G54",
            "G92 X1", "G61", "M3 S100", "G2 R5", "G81 R1", "G68", "G43.4", "G5 P1 Q1", "G99999", "G1 G0", "G53 G0", "T1 M6"
        ]),
    ];
    (codes, prop::collection::vec(word(), 0..5))
}

/// All operations without their spans, and the codes of what was found with their lines.
fn run(text: &str) -> (Vec<CanonicalOp>, Vec<(&'static str, u32)>) {
    let mut program = Program::new(text.as_bytes(), InterpreterConfig::default());
    let ops = program.by_ref().map(|sourced| sourced.op).collect();
    let found = program.diagnostics().kept().iter().map(|one| (one.code(), one.place.span.line)).filter(|(code, _)| *code != "no-blanks");
    (ops, found.collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn plain_moves_mean_the_same_by_both_ways(blocks in prop::collection::vec(block(), 1..30)) {
        let (mut plain, mut bracketed) = (String::from("F100\nG1\n"), String::from("F100\nG1\n"));
        for (code, words) in &blocks {
            plain += code;
            bracketed += code;
            for (letter, number) in words {
                // N takes no expression.
                plain += &format!(" {letter}{number}");
                bracketed += &if *letter == 'N' { format!(" {letter}{number}") } else { format!(" {letter}[{number}]") };
            }
            plain.push('\n');
            bracketed.push('\n');
        }
        prop_assert_eq!(run(&(plain + "M2\n")), run(&(bracketed + "M2\n")));
    }
}
