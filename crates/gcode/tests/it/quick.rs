//! Plain moves take a short way through the interpreter: the same programs written so that they
//! cannot take it give the same operations and the same findings.
use lostmotion_base::math;
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::{InterpreterConfig, Program};
use proptest::prelude::*;

/// A word of a move, rarely one that does not belong there.
fn word() -> impl Strategy<Value = (char, String)> {
    let letters = prop_oneof![20 => "[XYZ]", 4 => "[ABC]", 1 => "[UVWFIJKRSN]"];
    let number = prop_oneof![20 => -2e5..2e5_f64, 1 => Just(1e9), 1 => Just(-1.0), 1 => Just(0.0)];
    (letters, number)
        .prop_map(|(letter, number)| (letter.chars().next().unwrap(), format!("{number:.3}")))
}

/// A block: a code or none, and words.
fn block() -> impl Strategy<Value = (&'static str, Vec<(char, String)>)> {
    let codes = prop_oneof![
        30 => prop::sample::select(vec!["", "G0", "G1", "G0 ", "G1 "]),
        8 => prop::sample::select(vec![
            "F100", "F0", "F2000000", "G20", "G21", "G90", "G91", "G93", "G94", "G95", "G7", "G8", "G18", "G17", "G80", "G41.1 D2", "G40", "G54",
            "G92 X1", "G61", "M3 S100", "G2 R5", "G2 I5", "G3 J-1 K2", "G90.1", "G91.1", "G19", "G81 R1", "G68", "G43.4", "G5 P1 Q1", "G99999", "G1 G0", "G53 G0", "T1 M6"
        ]),
    ];
    (codes, prop::collection::vec(word(), 0..5))
}

/// A move to a place, and an arc from there about a centre beside it, to any end of the same radius
/// or of another.
fn arc() -> impl Strategy<Value = Vec<(&'static str, Vec<(char, String)>)>> {
    let place = prop::array::uniform2(-50.0..50.0_f64);
    let misses = prop_oneof![6 => Just(0.0), 1 => -2.0..2.0_f64];
    let axes = prop::sample::select(vec!["XYIJZ", "ZXKIY", "YZJKX", "XYIKZ"]);
    (
        place.clone(),
        place,
        0.0..7.0_f64,
        misses,
        axes,
        prop::bool::ANY,
        prop::bool::ANY,
    )
        .prop_map(|([x, y], [i, j], angle, miss, axes, clockwise, rises)| {
            let (sin, cos) = math::sin_cos(angle);
            let end = [x + i - i * cos + j * sin + miss, y + j - i * sin - j * cos];
            let word = |letter: usize, value: f64| {
                (axes.chars().nth(letter).unwrap(), format!("{value:.4}"))
            };
            let mut words = vec![word(0, end[0]), word(1, end[1]), word(2, i), word(3, j)];
            if rises {
                words.push(word(4, angle));
            }
            vec![
                ("G1", vec![word(0, x), word(1, y)]),
                (if clockwise { "G2" } else { "G3" }, words),
            ]
        })
}

/// All operations without their spans, and the codes of what was found with their lines.
fn run(text: &str) -> (Vec<CanonicalOp>, Vec<(&'static str, u32)>) {
    let mut program = Program::new(text.as_bytes(), InterpreterConfig::default());
    let ops = program.by_ref().map(|sourced| sourced.op).collect();
    let found = program
        .diagnostics()
        .kept()
        .iter()
        .map(|one| (one.code(), one.place.span.line))
        .filter(|(code, _)| *code != "no-blanks");
    (ops, found.collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn plain_moves_mean_the_same_by_both_ways(
        parts in prop::collection::vec(prop_oneof![4 => block().prop_map(|block| vec![block]), 1 => arc()], 1..30),
    ) {
        let blocks: Vec<_> = parts.into_iter().flatten().collect();
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
