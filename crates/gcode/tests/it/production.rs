//! What production programs for Fanuc, Haas and Klipper use. Positions are computed by hand from the
//! rules of the manuals (B-63944EN; Haas mill operator's manual; Klipper's documentation and its
//! `gcode_move.py`), machine coordinates in mm.

use crate::common::{codes, config, moves_with, ops_of};
use lostmotion_base::Coords;
use lostmotion_gcode::{
    Code, Diagnostic, Dialect, Feed, InterpreterConfig, Leniency, MCodeUse, Program, Tool,
    ToolTable,
};

const FANUC: Dialect = Dialect::Fanuc;
const HAAS: Dialect = Dialect::Haas;

/// Where the moves of a program without errors end.
fn ends(text: &str, config: InterpreterConfig) -> Vec<[f64; 3]> {
    let moves = moves_with(text, config);
    moves.iter().map(|motion| motion.end.linear()).collect()
}

fn close(found: &[[f64; 3]], expected: &[[f64; 3]]) -> bool {
    let near = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    found.len() == expected.len() && found.iter().zip(expected).all(near)
}

/// Where a program ends.
fn last(text: &str, config: InterpreterConfig) -> [f64; 3] {
    *ends(text, config).last().unwrap()
}

fn found(text: &str, config: InterpreterConfig) -> Vec<Diagnostic> {
    Program::new(text.as_bytes(), config)
        .finish()
        .kept()
        .to_vec()
}

/// The value of a variable after some blocks: it is moved to in machine coordinates.
fn value(before: &str, variable: &str, config: InterpreterConfig) -> f64 {
    let text = format!("{before}\n#100={variable}\nG80 G40 G21 G90 G17\nG53 G0 X#100\nM30\n");
    last(&text, config)[0]
}

/// A work offset G54 of (100, 50, -200), G55 of (300, 0, 0), tool 1 30 mm long, 10 mm thick.
fn set_up(dialect: Dialect) -> InterpreterConfig {
    let at = |x, y, z| Coords([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut tool = Tool {
        number: 1,
        diameter: 10.0,
        ..Tool::default()
    };
    tool.offset[2] = 30.0;
    let mut tools = ToolTable::default();
    tools.insert(tool);
    InterpreterConfig {
        tool_table: Some(tools),
        ..config(dialect)
    }
    .with_work_offset(1, at(100.0, 50.0, -200.0))
    .with_work_offset(2, at(300.0, 0.0, 0.0))
}

/// Groups of the lists of G codes in both manuals; letters as the arguments of a macro are numbered.
#[test]
fn modes_and_words_of_the_block_before_are_read() {
    for (dialect, before, variable, expected) in [
        (FANUC, "", "#4003", 90.0),
        (FANUC, "G91", "#4003", 91.0),
        (FANUC, "G91", "#4203", 91.0),
        (FANUC, "G18", "#4002", 18.0),
        (FANUC, "", "#4001", 0.0),
        (FANUC, "G1 X0 F5", "#4001", 1.0),
        (FANUC, "G95", "#4005", 95.0),
        (FANUC, "", "#4006", 21.0),
        (FANUC, "G20", "#4006", 20.0),
        (FANUC, "", "#4007", 40.0),
        (FANUC, "G41 D1", "#4007", 41.0),
        (FANUC, "G41 D1", "#4107", 1.0),
        (FANUC, "", "#4008", 49.0),
        (FANUC, "G43 H1", "#4008", 43.0),
        (FANUC, "G43 H1", "#4111", 1.0),
        (FANUC, "", "#4009", 80.0),
        (FANUC, "G81 Z-1. R1. F9. K0", "#4009", 81.0),
        // The manual: codes of group 01 are not affected by a code of a canned cycle.
        (FANUC, "G1 X0 F5\nG81 Z-1. R1. F9. K0", "#4001", 1.0),
        // A code of group 01 cancels the cycle as G80 does.
        (FANUC, "G81 Z-1. R1. F9. K0\nG0 X0", "#4009", 80.0),
        (FANUC, "G81 Z-1. R1. F9. K0\nG80", "#4009", 80.0),
        (FANUC, "", "#4010", 98.0),
        (FANUC, "G99", "#4010", 99.0),
        (FANUC, "", "#4012", 67.0),
        (FANUC, "", "#4014", 54.0),
        (FANUC, "G55", "#4014", 55.0),
        (FANUC, "G54.1 P3", "#4014", 54.1),
        (FANUC, "G54.1 P3", "#4130", 3.0),
        (FANUC, "G54.1 P3\nG55", "#4130", 0.0),
        (FANUC, "G61", "#4015", 61.0),
        (FANUC, "F250.", "#4109", 250.0),
        (FANUC, "S1200 M3", "#4119", 1200.0),
        (FANUC, "S1200 M3", "#4113", 3.0),
        (FANUC, "T1", "#4120", 1.0),
        (FANUC, "N35 G4 P1", "#4114", 35.0),
        (FANUC, "O1234\nG90", "#4115", 1234.0),
        (HAAS, "G91", "#4003", 91.0),
        (HAAS, "", "#4012", 54.0),
        (HAAS, "G55", "#4012", 55.0),
        (HAAS, "G154 P3", "#4012", 154.0),
        (HAAS, "T1", "#4120", 1.0),
    ] {
        let read = value(before, variable, set_up(dialect));
        assert_eq!(read, expected, "{dialect}: {variable} after {before:?}");
    }
    // The number of the program is that of the subroutine that runs.
    let called = "O1\nM98 P77\nG53 G0 X#100\nM30\nO77\n#100=#4115\nM99\n";
    assert_eq!(last(called, config(FANUC))[0], 77.0);
    // A block does not see its own modes.
    assert_eq!(last("G0 G91 X#4003\nM30\n", config(FANUC))[0], 90.0);
}

/// The program of the issue: a macro that leaves the distance mode as it was.
#[test]
fn a_macro_can_bring_the_mode_back() {
    let text = "G90 G0 X10.\n#3=#4003\nG91 X5.\nG#3\nX2.\nM30\n";
    for dialect in [FANUC, HAAS] {
        let expected = [[10.0, 0.0, 0.0], [15.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert!(close(&ends(text, config(dialect)), &expected), "{dialect}");
    }
    // B-63944EN and Yasnac's manual: the codes of group 01 are kept and restored.
    let motion = "G1 X1. F100\n#1=#4001\nG0 X2.\nG#1 X3.\nM30\n";
    let moves = moves_with(motion, config(FANUC));
    let rapids: Vec<bool> = moves
        .iter()
        .map(|motion| motion.feed == Feed::Rapid)
        .collect();
    assert_eq!(rapids, [false, true, false]);
}

/// #5001: end of the block without the tool's offset; #5021: machine; #5041: work coordinates with
/// the tool's offset; #5081: that offset.
#[test]
fn positions_are_read() {
    let before = "G54 G90 G0 X10. Y20.\nG43 H1 Z5.";
    for dialect in [FANUC, HAAS] {
        for (variable, expected) in [
            ("#5001", 10.0),
            ("#5002", 20.0),
            ("#5003", 5.0),
            ("#5021", 110.0),
            ("#5022", 70.0),
            ("#5023", -165.0),
            ("#5041", 10.0),
            ("#5043", 35.0),
            ("#5083", 30.0),
        ] {
            let read = value(before, variable, set_up(dialect));
            assert!(
                (read - expected).abs() < 1e-9,
                "{dialect}: {variable} is {read}"
            );
        }
    }
    // In the units of the program: going to where it is moves nothing.
    let inch = "G20 G54 G90 G0 X1. Y1.\n#1=#5021\n#2=#5001\nG53 G0 X#1\nX#2\nM30\n";
    let x = ends(inch, set_up(FANUC)).into_iter().map(|end| end[0]);
    for x in x {
        assert!((x - 125.4).abs() < 1e-9, "{x}");
    }
    // Under cutter compensation the end of the held move is not known yet.
    let held = "G41 D1\nG1 X20. F100\n#1=#5021\nG40\nM30\n";
    assert!(codes(held, set_up(FANUC)).contains(&"control-variable"));
}

#[test]
fn work_offsets_are_variables() {
    for (dialect, text, x) in [
        // Changed at once, whether by the number, the older number, or for another system.
        (FANUC, "#5221=40.\nG0 X1.", 41.0),
        (HAAS, "#5221=40.\nG0 X1.", 41.0),
        (FANUC, "#2501=45.\nG0 X1.", 46.0),
        (FANUC, "#5241=60.\nG0 X1.", 101.0),
        (FANUC, "#5241=60.\nG55\nG0 X1.", 61.0),
        (
            FANUC,
            "G0 X[#5221+#5241+#2502]",
            100.0 + 100.0 + 300.0 + 300.0,
        ),
        // The external offset shifts all systems; at Haas the number is the shift of G52.
        (FANUC, "#5201=5.\nG0 X1.", 106.0),
        (FANUC, "#5201=5.\nG55\nG0 X1.", 306.0),
        (FANUC, "#2500=5.\nG0 X1.", 106.0),
        (HAAS, "G52 X3.\nG0 X#5201", 106.0),
        (HAAS, "#5201=4.\nG0 X1.", 105.0),
        // Systems beyond G59.
        (FANUC, "#7001=60.\nG54.1 P1\nG0 X1.", 61.0),
        (FANUC, "#14021=70.\nG54.1 P2\nG0 X1.", 71.0),
        (FANUC, "#7941=75.\nG54.1 P48\nG0 X#14941", 150.0),
        (FANUC, "#19981=80.\nG54.1 P300\nG0 X1.", 81.0),
        (HAAS, "#7381=60.\nG154 P20\nG0 X1.", 61.0),
        (HAAS, "#7001=60.\nG110\nG0 X1.", 61.0),
        (HAAS, "#14001=60.\nG110\nG0 X1.", 61.0),
        (HAAS, "#15961=62.\nG154 P99\nG0 X1.", 63.0),
    ] {
        let end = last(&format!("{text}\nM30\n"), set_up(dialect));
        assert!((end[0] - x).abs() < 1e-9, "{dialect}: {text}: {end:?}");
    }
    for (dialect, text) in [
        (FANUC, "G54.1 P301"),
        (HAAS, "G154 P100"),
        (HAAS, "G154 P0"),
    ] {
        assert!(
            codes(&format!("{text}\nM30\n"), config(dialect)).contains(&"word-out-of-range"),
            "{text}"
        );
    }
}

/// "Programmable Data Input" of both manuals, and the two examples of Haas' page of offsets.
#[test]
fn g10_writes_the_offsets_of_the_control() {
    for (dialect, text, end) in [
        (
            FANUC,
            "G10 L2 P1 X10.\nG91 G10 L2 P1 X5.\nG90 G0 X1. Y0",
            [16.0, 50.0],
        ),
        (FANUC, "G10 L20 P1 X30.\nG0 X1. Y0", [101.0, 50.0]),
        (FANUC, "G10 L20 P1 X30.\nG54.1 P1\nG0 X1. Y0", [31.0, 0.0]),
        (FANUC, "G10 L20 P1 X30.\nG54 P1\nG0 X1. Y0", [31.0, 0.0]),
        (
            FANUC,
            "G10 L20 P1 X30.\nG91 G10 L20 P1 X4.\nG90 G54.1 P1\nG0 X1. Y0",
            [35.0, 0.0],
        ),
        (FANUC, "G10 L2 P0 X7.\nG0 X1. Y0", [108.0, 50.0]),
        (FANUC, "G10 L2 P0 X7.\nG55\nG0 X1. Y0", [308.0, 0.0]),
        (HAAS, "G10 L2 P0 X7.\nG0 X1. Y0", [108.0, 50.0]),
        (HAAS, "G10 L2 P1 G91 X60.\nG90 G0 X0 Y0", [160.0, 50.0]),
        (
            HAAS,
            "G10 L20 P2 G90 X100. Y80.\nG111\nG0 X0 Y0",
            [100.0, 80.0],
        ),
        (
            HAAS,
            "G10 L20 P2 G90 X100. Y80.\nG154 P2\nG0 X0 Y0",
            [100.0, 80.0],
        ),
        // LinuxCNC: L20 gives the place where the tool is the coordinates.
        (
            Dialect::LinuxCnc,
            "G0 X0 Y0\nG10 L20 P1 X30\nG0 X1 Y0",
            [71.0, 50.0],
        ),
    ] {
        let [x, y, _] = last(&format!("{text}\nM30\n"), set_up(dialect));
        assert!(
            (x - end[0]).abs() < 1e-9 && (y - end[1]).abs() < 1e-9,
            "{dialect}: {text}: {x} {y}"
        );
    }
}

#[test]
fn tool_memories_have_geometry_and_wear() {
    for (dialect, text, z) in [
        // A new wear takes the place of the old one; under G91 it is added.
        (
            FANUC,
            "G10 L10 P3 R100.\nG10 L11 P3 R.5\nG10 L11 P3 R.2\nG43 H3 G0 Z0",
            100.2,
        ),
        (
            FANUC,
            "G10 L10 P3 R100.\nG10 L11 P3 R.5\nG91 G10 L11 P3 R.2\nG90 G43 H3 G0 Z0",
            100.7,
        ),
        (
            FANUC,
            "G10 L10 P3 R100.\nG10 L1 P3 R.3\nG43 H3 G0 Z0",
            100.3,
        ),
        (FANUC, "#11003=100.\n#10003=.2\nG43 H3 G0 Z0", 100.2),
        (
            FANUC,
            "G10 L10 P3 R100.\nG10 L11 P3 R.5\nG0 Z[#11003+10.*#10003]",
            105.0,
        ),
        (HAAS, "#2003=100.\n#2203=.2\nG43 H3 G0 Z0", 100.2),
        (
            HAAS,
            "G10 L10 P3 R100.\nG10 L11 P3 R.5\nG0 Z[#2003+10.*#2203]",
            105.0,
        ),
        // D is a radius at Fanuc and a diameter at Haas.
        (FANUC, "G0 Z#13001", 5.0),
        (
            FANUC,
            "G10 L12 P1 R6.\nG10 L13 P1 R.1\nG0 Z[#13001+10.*#12001]",
            7.0,
        ),
        (HAAS, "G0 Z#2401", 10.0),
        (HAAS, "#2401=12.\n#2601=.1\nG0 Z[#2401+10.*#2601]", 13.0),
        (FANUC, "G0 Z#11001", 30.0),
        (HAAS, "G0 Z#2001", 30.0),
    ] {
        let config = InterpreterConfig {
            parameters: Vec::new(),
            ..set_up(dialect)
        };
        // Where the spindle stands: the move's end is the tool's.
        let moves = moves_with(&format!("{text}\nM30\n"), config);
        let motion = moves.last().unwrap();
        let spindle = motion.end.linear()[2] + motion.tool_offset.linear()[2];
        assert!((spindle - z).abs() < 1e-9, "{dialect}: {text}: {spindle}");
    }
    // What the number means depends on the memory that the control has: memory C is taken, and said
    // once, unless the other cell is 0.
    let old = "G0 Z#2201\nG0 Z#2001\nG0 Z#2001\nM30\n";
    assert_eq!(codes(old, set_up(FANUC)), ["tool-memory-assumed"]);
    assert_eq!(
        codes("#1=#11077\n#1=#11077\nM30\n", set_up(FANUC)),
        ["offset-unknown"]
    );
}

#[test]
fn an_alarm_of_the_program_ends_it_with_its_message() {
    for text in [
        "G0 X1.\n#3000=1 (NO TOOL)\nG0 X2.\nM30\n",
        "G0 X1.\nIF [#5001 GT .5] THEN #3000=1 (NO TOOL)\nG0 X2.\nM30\n",
    ] {
        let mut program = Program::new(text.as_bytes(), config(FANUC));
        let moves = program
            .by_ref()
            .filter(|sourced| sourced.op.to_string().contains("TRAVERSE"))
            .count();
        let found = program.diagnostics();
        assert_eq!(
            (moves, found.errors()),
            (1, 1),
            "{text}: {:?}",
            found.kept()
        );
        let alarm = found
            .kept()
            .iter()
            .find(|one| one.code() == "macro-alarm")
            .unwrap();
        assert!(alarm.to_string().contains("NO TOOL"), "{alarm}");
    }
    let passed = "G0 X1.\nIF [#5001 GT 5.] THEN #3000=1 (NO TOOL)\nG0 X2.\nM30\n";
    assert_eq!(last(passed, config(FANUC))[0], 2.0);
    let stops = |text: &str| {
        ops_of(text, config(FANUC))
            .iter()
            .filter(|sourced| sourced.op.to_string() == "PROGRAM_STOP()")
            .count()
    };
    assert_eq!(stops("#3006=1 (TURN THE PART)\nG0 X1.\nM30\n"), 1);
}

#[test]
fn what_only_the_control_knows_is_told_or_refused() {
    for number in [3001, 3002, 3011, 3012, 3901, 1005, 5101, 4501, 9999] {
        let text = format!("#1=#{number}\nM30\n");
        let found = found(&text, config(FANUC));
        let refused = found.iter().find(|one| one.code() == "control-variable");
        let hint = refused
            .and_then(|one| one.problem.hint())
            .unwrap_or_default();
        assert!(
            hint.contains(&format!("--set '#{number}=VALUE'")),
            "{number}: {found:?}"
        );
        let told = InterpreterConfig {
            told: vec![(number.to_string(), 7.0)],
            ..config(FANUC)
        };
        assert_eq!(value("", &format!("#{number}"), told), 7.0, "{number}");
    }
    // A clock cannot be set; a count can.
    assert!(codes("#3001=0\n#1=#3001\nM30\n", config(FANUC)).contains(&"control-variable"));
    assert_eq!(value("#3901=5", "#3901", config(FANUC)), 5.0);
    assert!(codes("#100001=5\nM30\n", config(FANUC)).contains(&"control-variable"));
    assert!(codes("#4003=91\nM30\n", config(FANUC)).contains(&"read-only-parameter"));
    assert!(codes("#5021=1\nM30\n", config(FANUC)).contains(&"read-only-parameter"));
    // Haas has further variables there, two names for the same.
    assert_eq!(value("#10150=3.", "#150", config(HAAS)), 3.0);
}

/// The X of each hole and how deep it is.
fn holes(text: &str, dialect: Dialect) -> Vec<[f64; 2]> {
    moves_with(text, config(dialect))
        .iter()
        .filter(|motion| motion.feed != Feed::Rapid)
        .map(|motion| [motion.end.linear()[0], motion.end.linear()[2]])
        .collect()
}

#[test]
fn canned_cycles_are_repeated_and_stored() {
    let expected = [[10.0, 3.0], [20.0, 3.0], [30.0, 3.0]];
    for (dialect, count) in [(FANUC, "K3"), (FANUC, "L3"), (HAAS, "L3")] {
        let text = format!("G0 X0 Z10.\nG91 G81 X10. Z-3. R-4. F100. {count}\nG80\nM30\n");
        assert_eq!(holes(&text, dialect), expected, "{count}");
        // The count is of its block alone.
        let next = text.replace("G80", "X5.");
        assert_eq!(holes(&next, dialect)[3..], [[35.0, 3.0]], "{count}");
    }
    // The words are kept, no hole is made and nothing moves.
    for (dialect, count) in [(FANUC, "K0"), (FANUC, "L0"), (HAAS, "L0")] {
        let text = format!("G0 X0 Z10.\nG81 X7. R2. Z-3. F100. {count}\nX1.\nX4.\nG80\nM30\n");
        assert_eq!(holes(&text, dialect), [[1.0, -3.0], [4.0, -3.0]], "{count}");
        assert_eq!(ends(&text, config(dialect))[1][0], 1.0, "{count}");
    }
    // G98 is the power-on state of both: back to the level before the cycle.
    let end = last("G0 Z10.\nG81 X1. R2. Z-3. F100.\nG80\nM30\n", config(FANUC));
    assert_eq!(end[2], 10.0);
    // Refused, K is no word of a cycle.
    let strict = InterpreterConfig {
        leniencies: FANUC.leniencies().without(Leniency::CycleRepeats),
        ..config(FANUC)
    };
    let text = "G0 Z10.\nG81 X1. R2. Z-3. F100. K2\nM30\n";
    assert!(codes(text, strict).contains(&"unused-word"));
}

/// B-63944EN, "Preparatory Function": a canned cycle leaves group 01 as it was.
#[test]
fn after_g80_the_mode_before_the_cycle_holds() {
    for (before, cancel, rapid) in [
        ("G0 X0", "G80", true),
        ("G1 X0 F50.", "G80", false),
        ("G0 X0", "G80 X5. Y5.", true),
        ("G1 X0 F50.", "G80 X5. Y5.", false),
    ] {
        for dialect in [FANUC, HAAS] {
            let next = if cancel == "G80" { "X5. Y5." } else { "Z9." };
            let text = format!("{before}\nG81 Z-1. R1. F100.\n{cancel}\n{next}\nM30\n");
            let moves = moves_with(&text, config(dialect));
            let last = moves.last().unwrap();
            assert_eq!(last.feed == Feed::Rapid, rapid, "{text}");
            assert_eq!(last.end.linear()[0], 5.0, "{text}");
        }
    }
    // A G80 of the first lines ends nothing.
    assert_eq!(last("G0 X1.\nG80\nX2.\nM30\n", config(FANUC))[0], 2.0);
    let linuxcnc = "G0 X0\nG81 Z-1 R1 F100\nG80\nX5\nM2\n";
    assert!(codes(linuxcnc, config(Dialect::LinuxCnc)).contains(&"axis-without-code"));
}

#[test]
fn rigid_tapping_turns_the_spindle_itself() {
    let tapped = |text: &str, dialect| -> Vec<String> {
        ops_of(text, config(dialect))
            .iter()
            .map(|sourced| sourced.op.to_string())
            .filter(|op| {
                op.contains("SPINDLE_C") || op.contains("STOP_SPINDLE") || op.contains("FEED(")
            })
            .map(|op| op.split('(').next().unwrap().to_owned())
            .collect()
    };
    for (dialect, text) in [
        (FANUC, "M29 S500\nG84 X1. Z-5. R2. F500.\nG80\nM30\n"),
        (FANUC, "G84 X1. Z-5. R2. F500. M29 S500\nG80\nM30\n"),
        (HAAS, "S500\nG84 X1. Z-5. R2. F500.\nG80\nM30\n"),
    ] {
        let ops = tapped(text, dialect);
        let down = ops.iter().position(|op| op == "STRAIGHT_FEED").unwrap();
        assert_eq!(ops[down - 1], "START_SPINDLE_CLOCKWISE", "{ops:?}");
        assert_eq!(ops[down + 2], "START_SPINDLE_COUNTERCLOCKWISE", "{ops:?}");
        assert_eq!(
            ops[down + 3..down + 5],
            ["STRAIGHT_FEED", "STOP_SPINDLE_TURNING"],
            "{ops:?}"
        );
    }
    // G80 ends it; without it the spindle has to turn already.
    for text in [
        "G84 X1. Z-5. R2. F500.\nG80\nM30\n",
        "M29 S500\nG84 X1. Z-5. R2. F500.\nG80\nG84 X1. Z-5. R2. F500.\nM30\n",
    ] {
        let found = found(text, config(FANUC));
        assert!(
            found.iter().any(|one| one.to_string().contains("M29")),
            "{found:?}"
        );
    }
}

#[test]
fn block_skips_have_numbers() {
    let text = "/2 G0 X1.\n/3G0X2.\n/ G0 X3.\n/2 N10 G0 X4.\nG0 X9.\nM30\n";
    let x = |config: InterpreterConfig| -> Vec<f64> {
        ends(text, config).iter().map(|end| end[0]).collect()
    };
    let with = |block_delete, skips: Option<Vec<u8>>| InterpreterConfig {
        block_delete,
        block_skips: skips,
        ..config(FANUC)
    };
    assert_eq!(x(with(false, None)), [1.0, 2.0, 3.0, 4.0, 9.0]);
    assert_eq!(x(with(true, None)), [9.0]);
    assert_eq!(x(with(false, Some(vec![2]))), [2.0, 3.0, 9.0]);
    assert_eq!(x(with(false, Some(vec![1]))), [1.0, 2.0, 4.0, 9.0]);
    assert_eq!(
        last("GOTO 10\nG0 X1.\n/2 N10 G0 X4.\nM30\n", config(FANUC))[0],
        4.0
    );
}

#[test]
fn a_colon_is_the_o_of_iso_code() {
    let text = "%\n:0001 (MAIN)\nM98 P2\nM30\n:0002\nG0 X3.\nM99\n%\n";
    for dialect in [FANUC, HAAS] {
        assert_eq!(last(text, config(dialect))[0], 3.0, "{dialect}");
    }
    assert_eq!(value(":0042\nG90", "#4115", config(FANUC)), 42.0);
}

#[test]
fn codes_of_the_builder_are_told_once_or_skipped() {
    let text = "M10 G0 X1.\nM110 P5 Q2.\nM10\nG0 X2. M10\nM30\n";
    for dialect in [FANUC, HAAS, Dialect::LinuxCnc] {
        let found = found(text, config(dialect));
        let unknown: Vec<_> = found
            .iter()
            .filter(|one| one.code() == "unsupported-code")
            .collect();
        assert_eq!(unknown.len(), 2, "{dialect}: {found:?}");
        let hint = unknown[0].problem.hint().unwrap();
        assert!(hint.contains("--m-code M10=ignore"), "{hint}");
        let told = InterpreterConfig {
            m_codes: [Code::m(100), Code::m(1100)]
                .map(|code| (code, MCodeUse::Ignore))
                .into(),
            ..config(dialect)
        };
        let x: Vec<f64> = ends(text, told).iter().map(|end| end[0]).collect();
        assert_eq!(x, [1.0, 2.0], "{dialect}");
    }
}

#[test]
fn values_of_hal_are_told_or_refused() {
    let text = "G0 X#<_hal[Spindle.load]>\nM2\n";
    let refused = found(text, config(Dialect::LinuxCnc));
    assert_eq!(refused[0].code(), "hal-value");
    let hint = refused[0].problem.hint().unwrap();
    assert!(
        hint.contains("--set '#<_hal[spindle.load]>=VALUE'"),
        "{hint}"
    );
    let told = InterpreterConfig {
        told: vec![("_hal[spindle.load]".to_owned(), 1.5)],
        ..config(Dialect::LinuxCnc)
    };
    assert_eq!(last(text, told)[0], 1.5);
}

/// Ends and speeds, mm/min; `None` for a rapid.
fn klipper(text: &str) -> Vec<([f64; 3], Option<f64>)> {
    moves_with(&format!("{text}\nM30\n"), config(Dialect::Klipper))
        .iter()
        .map(|motion| {
            let feed = match motion.feed {
                Feed::Rapid => None,
                Feed::MmPerMin(feed) => Some(feed),
                ref other => panic!("{other:?}"),
            };
            (motion.end.linear(), feed)
        })
        .collect()
}

/// `gcode_move.py`: base += change of the offset; MOVE=1 moves by the change at MOVE_SPEED, mm/s.
#[test]
fn klippers_offset_moves_the_coordinates() {
    for (text, end) in [
        (
            "G1 X10 F600\nSET_GCODE_OFFSET X=2\nG1 X10",
            [12.0, 0.0, 0.0],
        ),
        (
            "G1 X10 F600\nset_gcode_offset x=2 ; again\nSET_GCODE_OFFSET X=2\nG1 X10",
            [12.0, 0.0, 0.0],
        ),
        (
            "G1 X10 F600\nSET_GCODE_OFFSET X=2\nSET_GCODE_OFFSET X_ADJUST=1 Y_ADJUST=-4\nG1 X10 Y0",
            [13.0, -4.0, 0.0],
        ),
        // In relative coordinates the offset changes nothing.
        (
            "G91\nG1 X10 F600\nSET_GCODE_OFFSET X=2\nG1 X10",
            [20.0, 0.0, 0.0],
        ),
        // G92 and the offset add up.
        (
            "G1 X10 F600\nG92 X0\nSET_GCODE_OFFSET X=1\nG1 X5",
            [16.0, 0.0, 0.0],
        ),
    ] {
        assert_eq!(klipper(text).last().unwrap().0, end, "{text}");
    }
    let moved = klipper("G1 Z5 F600\nSET_GCODE_OFFSET Z=0.25 MOVE=1 MOVE_SPEED=5\nG1 X1");
    assert_eq!(
        moved,
        [
            ([0.0, 0.0, 5.0], Some(600.0)),
            ([0.0, 0.0, 5.25], Some(300.0)),
            ([1.0, 0.0, 5.25], Some(600.0)),
        ]
    );
}

/// `gcode_move.py`: a state is the distance mode, the base, the offset and the speed; MOVE=1 goes to
/// the place where it was saved.
#[test]
fn klippers_states_come_back() {
    let saved =
        "G1 X10 Y5 F600\nSAVE_GCODE_STATE NAME=a\nG91\nG1 X3 F1200\nG92 X0\nSET_GCODE_OFFSET Y=7\n";
    let end = |after: &str| klipper(&format!("{saved}{after}")).last().copied().unwrap();
    assert_eq!(
        end("RESTORE_GCODE_STATE NAME=a\nG1 X1"),
        ([1.0, 5.0, 0.0], Some(600.0))
    );
    assert_eq!(
        end("RESTORE_GCODE_STATE NAME=a MOVE=1 MOVE_SPEED=50"),
        ([10.0, 5.0, 0.0], Some(3000.0))
    );
    assert_eq!(
        end("RESTORE_GCODE_STATE NAME=a MOVE=1"),
        ([10.0, 5.0, 0.0], Some(600.0))
    );
    // The offset is that of the state again: adjusting counts from 0.
    assert_eq!(
        end("RESTORE_GCODE_STATE NAME=a\nSET_GCODE_OFFSET Y_ADJUST=1\nG1 X1 Y5").0,
        [1.0, 6.0, 0.0]
    );
    let found = |text: &str| codes(&format!("{text}\nM30\n"), config(Dialect::Klipper));
    assert!(found("RESTORE_GCODE_STATE NAME=b").contains(&"klipper-command"));
    assert!(found("SET_GCODE_OFFSET Z=high").contains(&"klipper-command"));
    assert!(found("SET_GCODE_OFFSET Z=1 MOVE=1 MOVE_SPEED=0").contains(&"klipper-command"));
    assert!(found("SET_VELOCITY_LIMIT ACCEL=3000").contains(&"velocity-limit"));
    // Without a name it is the state `default`.
    let unnamed = "G1 X10 F600\nSAVE_GCODE_STATE\nG91\nRESTORE_GCODE_STATE\nG1 X1";
    assert_eq!(klipper(unnamed).last().unwrap().0[0], 1.0);
}
