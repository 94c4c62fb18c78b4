//! Values of expressions against the rules of RS274/NGC.
use lostmotion_gcode::{CanonicalOp, InterpreterConfig, Program};

/// X of the last traverse.
fn value(expression: &str) -> f64 {
    let source = format!("#1=2 #2=7\n#<_g>=4 #<a b>=3\nG0 X{expression}\nM2\n");
    let mut program = Program::new(source.as_bytes(), InterpreterConfig::default());
    let mut x = f64::NAN;
    for sourced in program.by_ref() {
        if let CanonicalOp::StraightTraverse(end) = sourced.op {
            x = end[0];
        }
    }
    assert_eq!(
        program.diagnostics().errors(),
        0,
        "{expression}: {:?}",
        program.diagnostics().kept()
    );
    x
}

#[test]
fn operators_and_functions() {
    for (expression, expected) in [
        ("[2**3**2]", 64.0),
        ("[-2**2]", 4.0),
        ("-[1+2]", -3.0),
        ("--3", 3.0),
        ("[10-2-3]", 5.0),
        ("[1+2*3]", 7.0),
        ("[8/4/2]", 1.0),
        ("[7 MOD 3]", 1.0),
        ("[-7 mod 3]", 2.0),
        ("[1 LT 2 AND 3 GT 2]", 1.0),
        ("[1 OR 0 AND 0]", 0.0),
        ("[1 xor 1]", 0.0),
        ("[2*3 EQ 6]", 1.0),
        ("[0.1+0.2 EQ 0.3]", 1.0),
        ("[1 NE 1.000002]", 0.0),
        ("[2 ge 2]", 1.0),
        ("[2 le 1]", 0.0),
        ("FIX[-2.8]", -3.0),
        ("FUP[-2.8]", -2.0),
        ("ROUND[-2.5]", -3.0),
        ("ROUND[2.5]", 3.0),
        ("ABS[-1.5]", 1.5),
        ("SQRT[16]", 4.0),
        ("LN[EXP[2]]", 2.0),
        ("SIN[30]", 0.5),
        ("COS[60]", 0.5),
        ("TAN[45]", 1.0),
        ("ASIN[0.5]", 30.0),
        ("ACOS[0.5]", 60.0),
        ("ATAN[1]/[-1]", 135.0),
        ("[ATAN[1]/[0]/2]", 45.0),
        ("##1", 7.0),
        ("#[1+1]", 7.0),
        ("-#1", -2.0),
        ("#<_g>", 4.0),
        ("#< AB >", 3.0),
        ("EXISTS[#<ab>]", 1.0),
        ("EXISTS[#<b>]", 0.0),
        ("EXISTS[#99999]", 0.0),
        ("#<_metric>", 1.0),
        ("#5220", 1.0),
        ("[#1 EQ 2 AND #2 EQ 7]", 1.0),
    ] {
        let actual = value(expression);
        assert!(
            (actual - expected).abs() < 1e-12,
            "{expression} is {actual}, not {expected}"
        );
    }
}

#[test]
fn settings_take_effect_after_their_line() {
    let source = "#1=5\nG0 X#1 #1=7\nX#1\n#3=15 #3=6\nX#3\nM2\n";
    let program = Program::new(source.as_bytes(), InterpreterConfig::default());
    let ends: Vec<f64> = program
        .filter_map(|sourced| match sourced.op {
            CanonicalOp::StraightTraverse(end) => Some(end[0]),
            _ => None,
        })
        .collect();
    assert_eq!(ends, [5.0, 7.0, 6.0]);
}
