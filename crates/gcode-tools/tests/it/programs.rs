//! Generated programs as people and post processors write them.

use proptest::prelude::*;

/// Lines as people and post processors write them, good ones for the most part.
pub(crate) fn line() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        "[+-]?[0-9]{1,3}",
        "-?[0-9]{1,2}\\.[0-9]{1,4}",
        "-?\\.[0-9]{1,3}",
        "[0-9] \\. [0-9]"
    ];
    let axes = prop::collection::vec(("[xyzXYZaA]", number.clone(), " ?"), 1..4);
    let axes = axes.prop_map(|words| {
        let mut seen = String::new();
        let mut text = String::new();
        for (letter, value, blank) in words {
            let upper = letter.to_uppercase();
            if !seen.contains(&upper) {
                text += &format!("{letter}{value}{blank}");
                seen += &upper;
            }
        }
        text
    });
    prop_oneof![
        8 => ("(n[0-9]{1,4} ?)?", "[gG]0?[01] ?", axes.clone(), "( ?\\([a-z ,]{0,8}\\))?").prop_map(|(n, g, axes, c)| format!("{n}{g}{axes}{c}")),
        2 => number.clone().prop_map(|x| format!("g02 x{x} r500")),
        2 => ("[1-9]", "[1-9]").prop_map(|(i, j)| format!("G3I{i} J-{j}")),
        1 => number.clone().prop_map(|x| format!("G91 G3 X.01 I{x} J.5 G90")),
        1 => number.clone().prop_map(|value| format!("#1 = [ {value}+ 2 ] ; set")),
        1 => Just("x #1 y[ sin[#1] * 2 ]".to_owned()),
        1 => "[fF][1-9][0-9]{0,3}(\\.[0-9])?",
        1 => prop_oneof![
            Just("g20".to_owned()), Just("g21".to_owned()), Just("G18".to_owned()), Just("G17".to_owned()), Just("g91".to_owned()),
            Just("g90".to_owned()), Just("G55".to_owned()), Just("G54".to_owned()), Just("g92 x1 y2".to_owned()), Just("G92.1".to_owned()),
            Just("m3 s1000".to_owned()), Just("M5".to_owned()), Just("m8".to_owned()), Just("M9".to_owned()), Just("G4P.5".to_owned()),
            Just("T1M6".to_owned()), Just("g43.1 z5.5".to_owned()), Just("G49".to_owned()), Just("G10 L2 P2 X1 Y-2 Z.5".to_owned()),
            Just("G64P.01".to_owned()), Just("g61".to_owned()), Just("G81 X1 Y1 Z-3 R2 F50".to_owned()), Just("G83 X2 Z-3 R2 Q1".to_owned()),
            Just("G80".to_owned()), Just("G93 G1 X7 F2".to_owned()), Just("G94 F300".to_owned()), Just("(msg, hello)".to_owned()),
            Just("/g0 x0".to_owned()), Just(String::new()), Just("  ; nothing".to_owned()), Just("G52 Z1".to_owned()), Just("G5 I1 J2 P-1 Q2 X9 Y9".to_owned()),
            Just("m3 s200 G33 Z-2 K.5".to_owned()), Just("G41.1 D1 G1 X50".to_owned()), Just("G40 G1 X60 Y60".to_owned()), Just("M64 P1 M8".to_owned()),
        ],
        1 => ("[1-4]", line_simple()).prop_map(|(n, body)| format!("o1 repeat [ {n} ]\n{body}\no1 endrepeat")),
        1 => line_simple().prop_map(|body| format!("O<s> Sub\n{body}\nO<s> endsub\no<s>  call [ 1 ]")),
    ]
}

fn line_simple() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("g1x#1 F99".to_owned()),
        Just("g91 g0 y.125\ng90".to_owned()),
        Just("(in)".to_owned())
    ]
}

/// A program of such lines.
pub(crate) fn program() -> impl Strategy<Value = String> {
    (
        prop::collection::vec(line(), 1..25),
        prop_oneof![Just("\n"), Just("\r\n"), Just("\r")],
        any::<bool>(),
    )
        .prop_map(|(lines, end, m2)| {
            let mut text = lines.join("\n") + "\n";
            if m2 {
                text += "m2\n";
            }
            text.replace('\n', end)
        })
}
