//! G70 as LinuxCNC's stand-alone interpreter carries it out, held against its recordings: which way
//! a profile is gone along, on which side it is offset, and where the tool strays to under cutter
//! compensation.
use lostmotion_gcode::dialect::Leniency;
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::{InterpreterConfig, Program};

/// Name, profile, what comes before the cycle and the cycle, and the moves: T rapid, F feed, A arc,
/// with the end as Z,X.
const RECORDED: [(&str, &str, &str, &str); 14] = [
    (
        "inside corner: both rapids end where the corner is taken to be",
        "G0 X2 Z3\nG1 X4 Z-1\nG1 X4 Z-10\nG1 X8 Z-12",
        "G0 X10 Z-20\nG42.1 D0.4\nG70 Q1 X10 Z3",
        "T-20.0000,10.0000 T-12.0018,8.0132 T-12.0018,8.0132 T2.8000,2.3236 F-0.9106,4.1789 A-1.0000,4.2000 F-9.8764,4.2000 F-11.7443,7.9357 T5.1153,19.8366",
    ),
    (
        "lathe orientation",
        "G0 X2 Z3\nG1 X4 Z-1\nG1 X4 Z-10\nG1 X8 Z-12",
        "G0 X10 Z-20\nG42.1 D0.4 L2\nG70 Q1 X10 Z3",
        "T-20.0000,10.0000 T-12.2018,7.8132 T-12.2018,7.8132 T2.6000,2.1236 F-1.1106,3.9789 A-1.2000,4.0000 F-10.0764,4.0000 F-11.9443,7.7357 T4.9153,19.6366",
    ),
    (
        "the end of the profile on the level of the start",
        "G0 X2 Z3\nG1 X4 Z-1\nG1 X4 Z-10\nG1 X10 Z-12",
        "G0 X10 Z-20\nG42.1 D0.4\nG70 Q1 X10 Z3",
        "T-20.0000,10.0000 T3.0000,9.8000 T-12.0000,10.0000 T2.8000,2.3236 F-0.9106,4.1789 A-1.0000,4.2000 F-9.8558,4.2000 F-11.7591,9.9097 T5.1014,19.8276",
    ),
    (
        "outside corner",
        "G0 X2 Z3\nG1 X4 Z-1\nG1 X4 Z-10\nG1 X8 Z-12",
        "G0 X10 Z-20\nG42.1 D0.4\nG70 Q1 X10 Z2",
        "T-20.0000,10.0000 T-12.0000,8.0000 T2.0000,9.8000 T2.8000,9.8000 T2.8000,2.3236 F-0.9106,4.1789 A-1.0000,4.2000 F-9.8764,4.2000 F-11.7443,7.9357 T5.1153,19.8366",
    ),
    (
        "a move before the cycle",
        "G0 X2 Z3\nG1 X4 Z-1\nG1 X4 Z-10\nG1 X8 Z-12",
        "G0 X20 Z-30\nG42.1 D0.4\nG0 X15 Z-20\nG70 Q1 X10 Z3",
        "T-30.0000,20.0000 T-20.0894,14.8211 T-20.0425,14.8046 T-12.0018,8.0132 T-12.0018,8.0132 T2.8000,2.3236 F-0.9106,4.1789 A-1.0000,4.2000 F-9.8764,4.2000 F-11.7443,7.9357 T5.1153,19.8366",
    ),
    (
        "the cycle names no axis",
        "G0 X2 Z3\nG1 X4 Z-1\nG1 X4 Z-10\nG1 X8 Z-12",
        "G0 X10 Z-20\nG42.1 D0.4\nG0 X10 Z3\nG70 Q1",
        "T-20.0000,10.0000 T-12.0018,8.0132 T-12.0018,8.0132 T2.8000,9.8000 T2.8000,2.3236 F-0.9106,4.1789 A-1.0000,4.2000 F-9.8764,4.2000 F-11.7443,7.9357 T5.1153,19.8366",
    ),
    (
        "a stop before the cycle",
        "G0 X2 Z3\nG1 X4 Z-1\nG1 X4 Z-10\nG1 X8 Z-12",
        "G0 X10 Z-20\nG42.1 D0.4\nG0 X10 Z3\nM0\nG70 Q1 X10 Z3",
        "T-20.0000,10.0000 T3.0000,9.8000 T-12.0018,8.0132 T-12.0018,8.0132 T2.8000,2.3236 F-0.9106,4.1789 A-1.0000,4.2000 F-9.8764,4.2000 F-11.7443,7.9357 T5.1153,19.8366",
    ),
    (
        "the wrong side of the move of entry",
        "G0 X2 Z3\nG1 X4 Z-1\nG1 X4 Z-10\nG1 X8 Z-12",
        "G0 X5 Z-20\nG42.1 D0.4\nG70 Q1 X10 Z3",
        "refused",
    ),
    (
        "without compensation",
        "G0 X2 Z3\nG1 X4 Z-1\nG1 X4 Z-10\nG1 X8 Z-12",
        "G0 X10 Z-20\nG40\nG70 Q1 X10 Z3",
        "T-20.0000,10.0000 T3.0000,10.0000 T3.0000,10.0000 T3.0000,2.0000 F-1.0000,4.0000 F-10.0000,4.0000 F-12.0000,8.0000 T5.0000,20.0000",
    ),
    (
        "a profile of one move towards larger Z is finished along X",
        "G0 X1 Z-2\nG1 X3 Z0.5",
        "G0 X20 Z20\nG40\nG70 Q1 X8.5 Z3 E0.1",
        "T20.0000,20.0000 T3.0000,8.5000 T3.0000,1.0000 T-1.9375,0.9219 F0.5625,2.9219 T5.0000,20.0000",
    ),
    (
        "larger Z after the first move: along Z",
        "G0 X1 Z-2\nG1 X2 Z-2\nG1 X3 Z0.5",
        "G0 X20 Z20\nG40\nG70 Q1 X8.5 Z3 E0.1",
        "T20.0000,20.0000 T3.0000,8.5000 T-2.0000,8.5000 T-2.1000,1.0000 F-2.1000,2.0000 A-2.0371,2.0928 F0.4629,3.0928 T5.0000,20.0000",
    ),
    (
        "one move, tool below",
        "G0 X3 Z0\nG1 X3.5 Z-1.5",
        "G0 X20 Z20\nG40\nG70 Q1 X1.6 Z-4.2 E0.1",
        "T20.0000,20.0000 T-4.2000,1.6000 T0.0000,1.6000 T0.0316,3.0949 F-1.4684,3.5949 T5.0000,20.0000",
    ),
    (
        "two moves, tool below the first",
        "G0 X3 Z0\nG1 X3.5 Z-1\nG1 X3.5 Z-2",
        "G0 X20 Z20\nG40\nG70 Q1 X1.6 Z-4.2 E0.1",
        "T20.0000,20.0000 T-4.2000,1.6000 T0.0000,1.6000 T-0.0447,2.9106 F-1.0236,3.4000 F-2.0000,3.4000 T5.0000,20.0000",
    ),
    (
        "two moves, tool before the line of the first",
        "G0 X3 Z0\nG1 X3.5 Z-1\nG1 X3.5 Z-2",
        "G0 X20 Z20\nG40\nG70 Q1 X2.4 Z2 E0.1",
        "T20.0000,20.0000 T2.0000,2.4000 T2.0000,2.4000 T0.0447,3.0894 F-0.9553,3.5894 A-1.0000,3.6000 F-2.0000,3.6000 T5.0000,20.0000",
    ),
];

fn program(profile: &str, cycle: &str) -> String {
    format!(
        "G54 G18 G21 G8 G40 G94 F400\nO1 SUB\n{profile}\nO1 ENDSUB\n{cycle}\nG0 X20 Z5\nG40\nM2\n"
    )
}

/// The moves of a program as they are written above, or the codes of what was found if that
/// includes an error.
fn moves(
    text: &str,
    config: InterpreterConfig,
) -> (Result<String, Vec<&'static str>>, Vec<&'static str>) {
    let mut program = Program::new(text.as_bytes(), config);
    let mut moves = Vec::new();
    for sourced in program.by_ref() {
        match sourced.op {
            CanonicalOp::StraightTraverse(end) => {
                moves.push(format!("T{:.4},{:.4}", end[2], end[0]));
            }
            CanonicalOp::StraightFeed(end) => moves.push(format!("F{:.4},{:.4}", end[2], end[0])),
            CanonicalOp::ArcFeed(arc) => {
                moves.push(format!("A{:.4},{:.4}", arc.end[0], arc.end[1]));
            }
            _ => {}
        }
    }
    let found: Vec<_> = program
        .diagnostics()
        .kept()
        .iter()
        .map(lostmotion_gcode::Diagnostic::code)
        .collect();
    let errors = program.diagnostics().errors() > 0;
    (
        if errors {
            Err(found.clone())
        } else {
            Ok(moves.join(" "))
        },
        found,
    )
}

#[test]
fn finishing_does_what_was_recorded() {
    for (name, profile, cycle, recorded) in RECORDED {
        let (found, told) = moves(&program(profile, cycle), InterpreterConfig::default());
        match found {
            Ok(found) => assert_eq!(
                found.replace("-0.0000", "0.0000"),
                recorded.replace("-0.0000", "0.0000"),
                "{name}"
            ),
            Err(found) => assert!(
                recorded == "refused" && found.contains(&"compensation"),
                "{name}: {found:?}"
            ),
        }
        assert_eq!(
            told.contains(&"finish-detour"),
            cycle.contains("G42"),
            "{name}: {told:?}"
        );
    }
}

#[test]
fn without_the_detour_the_tool_goes_straight_to_the_profile() {
    let config = InterpreterConfig::default();
    let config = InterpreterConfig {
        leniencies: config.leniencies.without(Leniency::FinishDetour),
        ..config
    };
    let (_, profile, cycle, _) = RECORDED[0];
    let (found, told) = moves(&program(profile, cycle), config.clone());
    // The inner corner between the way to the start and the way to the profile, 0.2 from both.
    assert!(
        found
            .unwrap()
            .starts_with("T-20.0000,10.0000 T2.8000,9.8000 T2.8000,9.8000 T2.8000,2.3236 "),
        "{profile}"
    );
    assert!(told.is_empty(), "{told:?}");
    // Nor does it stray without compensation, or with a tool of no size.
    for off in ["G40", "G42.1 D0"] {
        let cycle = cycle.replace("G42.1 D0.4", off);
        assert_eq!(
            moves(&program(profile, &cycle), InterpreterConfig::default()),
            moves(&program(profile, &cycle), config.clone())
        );
    }
}
