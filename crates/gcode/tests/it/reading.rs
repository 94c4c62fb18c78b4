//! Blocks as a dialect reads them, without carrying anything out.

use lostmotion_gcode::syntax::{CORNER_RADIUS, Value};
use lostmotion_gcode::{Blocks, Dialect, Limits};

/// Letters and literal values of each line; `None` for a fault.
fn read(text: &str, dialect: Dialect) -> Vec<Option<Vec<(u8, f64)>>> {
    let mut blocks =
        Blocks::new(text.as_bytes(), Limits::default()).accepting(dialect, dialect.leniencies());
    let mut all = Vec::new();
    while let Some(parsed) = blocks.read().unwrap() {
        let words = parsed.block.words.iter().map(|word| match word.value {
            Value::Number(value) => (word.letter, value),
            Value::Ops(..) => (word.letter, f64::NAN),
        });
        let words = words.collect();
        all.push(parsed.fault.is_none().then_some(words));
    }
    all
}

#[test]
fn lines_are_those_of_the_dialect() {
    let g1 = |more: &[(u8, f64)]| Some([&[(b'G', 1.0)], more].concat());
    // Checksums, texts and codes of printers; in RS274/NGC the first two are faults.
    let text = "N3 T0*57\nM117 go to X5\nM104 S200\nG1 X1 E.5\n";
    let marlin = read(text, Dialect::Marlin);
    assert_eq!(marlin[0], Some(vec![(b'T', 0.0)]));
    assert_eq!((&marlin[1], &marlin[2]), (&Some(vec![]), &Some(vec![])));
    assert_eq!(marlin[3], g1(&[(b'X', 1.0), (b'E', 0.5)]));
    let plain = read(text, Dialect::LinuxCnc);
    assert_eq!((&plain[0], &plain[1]), (&None, &None));
    // Exponents: with a sign everywhere, without one at Fanuc's.
    let text = "G1 X1.5E+1\nG1 X1.5E1\nG1 X1,R2\n";
    let fanuc = read(text, Dialect::Fanuc);
    assert_eq!(
        (&fanuc[0], &fanuc[1]),
        (&g1(&[(b'X', 15.0)]), &g1(&[(b'X', 15.0)]))
    );
    assert_eq!(fanuc[2], g1(&[(b'X', 1.0), (CORNER_RADIUS, 2.0)]));
    let plain = read(text, Dialect::LinuxCnc);
    assert_eq!(plain[0], g1(&[(b'X', 15.0)]));
    assert_eq!(plain[1], g1(&[(b'X', 1.5), (b'E', 1.0)]));
}
