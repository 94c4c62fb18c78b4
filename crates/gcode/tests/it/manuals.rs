//! Rules of manuals about locals, tool lengths, calls by M codes and homing, each quoted in short with
//! its place. Positions are computed by hand from them, machine coordinates in mm.

use crate::common::{codes, config, moves_with};
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::{
    Code, Diagnostic, Dialect, InterpreterConfig, MCodeUse, Program, Severity, Tool, ToolTable,
};

const FANUC: Dialect = Dialect::Fanuc;
const HAAS: Dialect = Dialect::Haas;

fn x_ends(text: &str, config: InterpreterConfig) -> Vec<f64> {
    let moves = moves_with(text, config);
    moves.iter().map(|motion| motion.end.linear()[0]).collect()
}

/// Haas 96-8000 Rev AC, p. 93: "Local variables range between #1 and #33"; a G65 saves them and gives
/// a new set. RS274/NGC has #1 to #30.
#[test]
fn a_macro_has_33_variables_of_its_own() {
    let text = "#30=1.\n#31=2.\n#33=3.\n#100=9.\nG65 P7\nG0 X[#30+10.*#31+100.*#33]\nG0 X#100\nM30\n\
        O7\n#30=5.\n#31=5.\n#33=5.\n#100=4.\nM99\n";
    for dialect in [FANUC, HAAS] {
        assert_eq!(x_ends(text, config(dialect)), [321.0, 4.0], "{dialect}");
    }
    // The new set is vacant.
    let vacant = "#33=3.\nG65 P7\nM30\nO7\nIF [#33 EQ #0] THEN #101=8.\nG0 X#101\nM99\n";
    assert_eq!(x_ends(vacant, config(FANUC)), [8.0]);
    // M98 shares them (96-8000, "Calling a subroutine via M98").
    let shared = "#33=3.\nM98 P7\nG0 X#33\nM30\nO7\n#33=6.\nM99\n";
    assert_eq!(x_ends(shared, config(HAAS)), [6.0]);
    // RS274/NGC: #31 is the same everywhere.
    let linuxcnc = "o7 sub\n#30=5\n#31=5\no7 endsub\n#30=1\n#31=2\no7 call\nG0 X[#30+10*#31]\nM2\n";
    assert_eq!(x_ends(linuxcnc, config(Dialect::LinuxCnc)), [51.0]);
}

/// 96-8000 Rev AC, p. 93, column "Alternate": ten sets of I, J and K, the last one being #31 to #33.
#[test]
fn ten_sets_of_i_j_k_reach_33() {
    let sets: Vec<String> = (0..10)
        .map(|set| format!("I{}. J{}. K{}.", 3 * set + 1, 3 * set + 2, 3 * set + 3))
        .collect();
    let text = format!(
        "G65 P7 {}\nM30\nO7\nG0 X#4\nX#13\nX#31\nX#33\nM99\n",
        sets.join(" ")
    );
    assert_eq!(x_ends(&text, config(FANUC)), [1.0, 10.0, 28.0, 30.0]);
    let eleven = text.replace("\nM30", " I31.\nM30");
    assert!(codes(&eleven, config(FANUC)).contains(&"repeated-word"));
}

/// B-63944EN, "Tool Length Offset": G43 adds the value of the memory, G44 subtracts it; #4008 shows
/// the code.
#[test]
fn g44_subtracts_the_length() {
    let mut tool = Tool {
        number: 1,
        ..Tool::default()
    };
    tool.offset[2] = 30.0;
    let mut tools = ToolTable::default();
    tools.insert(tool);
    let with = |dialect| InterpreterConfig {
        tool_table: Some(tools.clone()),
        ..config(dialect)
    };
    let spindle = |text: &str, dialect| {
        let moves = moves_with(text, with(dialect));
        let motion = moves.last().unwrap();
        motion.end.linear()[2] + motion.tool_offset.linear()[2]
    };
    for dialect in [FANUC, HAAS] {
        assert_eq!(spindle("G43 H1\nG0 Z5.\nM30\n", dialect), 35.0);
        assert_eq!(spindle("G44 H1\nG0 Z5.\nM30\n", dialect), -25.0);
        assert_eq!(spindle("G44 H1\nG49\nG0 Z5.\nM30\n", dialect), 5.0);
        assert_eq!(
            x_ends("G44 H1\n#1=#4008\nG0 X#1\nM30\n", with(dialect)),
            [44.0]
        );
        assert_eq!(
            codes("G44 H1\nG0 Z5.\nM30\n", with(dialect)),
            ["negative-length"]
        );
    }
    let refused = codes("G44 H1\nG0 Z5\nM2\n", with(Dialect::LinuxCnc));
    assert_eq!(refused, ["unsupported-code"]);
}

/// Haas' Setting 40: D is a radius or a diameter. A diameter is taken, which is told.
#[test]
fn the_size_that_a_haas_program_sets_is_told_to_be_a_diameter() {
    for text in ["G10 L12 P1 R6.\nM30\n", "#2401=6.\nM30\n"] {
        assert!(
            codes(text, config(HAAS)).contains(&"diameter-assumed"),
            "{text}"
        );
        let fanuc = text.replace("#2401", "#13001");
        assert!(!codes(&fanuc, config(FANUC)).contains(&"diameter-assumed"));
    }
}

fn with_codes(dialect: Dialect, codes: &[(u16, MCodeUse)]) -> InterpreterConfig {
    InterpreterConfig {
        m_codes: codes
            .iter()
            .map(|(number, what)| (Code::m(10 * number), what.clone()))
            .collect(),
        ..config(dialect)
    }
}

/// B-62093E, p. 32: a subprogram call by an M code branches after the other commands of the block
/// have been carried out; a macro call branches without doing anything, and takes arguments.
#[test]
fn an_m_code_calls_a_subprogram_or_a_macro() {
    let sub = "#1=7.\nG0 X1. M21\nX3.\nM30\nO9001\nX[2.+#1]\nM99\n";
    let config = with_codes(FANUC, &[(21, MCodeUse::Call(9001))]);
    assert_eq!(x_ends(sub, config), [1.0, 9.0, 3.0]);
    let called = "#1=7.\nG0 X1.\nM22 A5. X4.\nX#1\nM30\nO9020\nG0 X[#1+10.*#24]\nM99\n";
    let config = with_codes(FANUC, &[(22, MCodeUse::Macro(9020))]);
    assert_eq!(x_ends(called, config.clone()), [1.0, 45.0, 7.0]);
    // A line number is no argument; a G code cannot stand on the line of a macro call.
    let numbered = called.replace("M22", "N5 M22");
    assert_eq!(x_ends(&numbered, config.clone()), [1.0, 45.0, 7.0]);
    let mixed = called.replace("M22 A5.", "G1 M22 A5.");
    assert!(codes(&mixed, config.clone()).contains(&"unused-word"));
    // One that is nowhere is told as any other.
    assert!(codes("M22 A1.\nM30\n", config).contains(&"no-such-sub"));
    // A code that has a meaning takes the new one.
    let coolant = "G0 X1. M8\nM30\nO9001\nX2.\nM99\n";
    let config = with_codes(FANUC, &[(8, MCodeUse::Call(9001))]);
    assert_eq!(x_ends(coolant, config), [1.0, 2.0]);
}

/// B-63944EN, "Macro Call Using an M Code": in a program that an M code has called, an M code is an
/// ordinary one. So a tool change of one's own may change the tool.
#[test]
fn in_what_an_m_code_has_called_m_codes_are_ordinary() {
    let text =
        "G0 X1. T1\nM6\nX4.\nM6\nM30\nO9001\nG53 G0 X2.\nM6\nM22\nM98 P5\nM99\nO5\nX3. M6\nM99\n";
    let config = with_codes(
        FANUC,
        &[(6, MCodeUse::Call(9001)), (22, MCodeUse::Macro(9001))],
    );
    assert_eq!(x_ends(text, config.clone()), [1.0, 2.0, 3.0, 4.0, 2.0, 3.0]);
    let changes = Program::new(text.as_bytes(), config)
        .filter(|sourced| matches!(sourced.op, CanonicalOp::ChangeTool(_)))
        .count();
    assert_eq!(changes, 4);
}

/// A code that stops does as M0, one that takes its time as G4, after the move of its line.
#[test]
fn an_m_code_stops_or_waits() {
    let ops = |text: &str, config: InterpreterConfig| -> Vec<String> {
        Program::new(text.as_bytes(), config)
            .skip(4)
            .map(|sourced| sourced.op.to_string())
            .collect()
    };
    for dialect in [Dialect::LinuxCnc, FANUC] {
        let config = with_codes(
            dialect,
            &[(101, MCodeUse::Stop), (102, MCodeUse::Dwell(1.5))],
        );
        for (own, known) in [
            ("G1 X1. F100 M101\nM30\n", "G1 X1. F100 M0\nM30\n"),
            ("M101\nM30\n", "M0\nM30\n"),
            ("G1 X1. F100 M102 P3\nM30\n", "G1 X1. F100\nG4 P1.5\nM30\n"),
            ("M102\nM30\n", "G4 P1.5\nM30\n"),
        ] {
            assert_eq!(
                ops(own, config.clone()),
                ops(known, config.clone()),
                "{own}"
            );
        }
    }
}

/// `gcode_move.py`, `_handle_home_rails_end`: the base of the homed axes becomes the offset of
/// SET_GCODE_OFFSET; G28 takes letters, not places. Marlin's `set_axis_is_at_home` sets
/// `position_shift` to 0.
#[test]
fn homing_of_printers_forgets_g92_of_the_homed_axes() {
    let ends = |text: &str, dialect| -> Vec<[f64; 3]> {
        let moves = moves_with(&format!("{text}\nM30\n"), config(dialect));
        moves.iter().map(|motion| motion.end.linear()).collect()
    };
    let (klipper, marlin) = (Dialect::Klipper, Dialect::Marlin);
    for dialect in [klipper, marlin] {
        let before = "G1 X10 Y20 Z5 F600\nG92 X0 Y0 Z0\n";
        // All axes home: the coordinates are the machine's again.
        let all = ends(&format!("{before}G28\nG1 X1 Y1 Z1"), dialect);
        assert_eq!(all[1..], [[0.0; 3], [1.0; 3]], "{dialect}");
        // X alone: Y keeps its shift, and stays where it is; the number says nothing.
        for home in ["G28 X", "G28 X0", "G28 X50"] {
            let one = ends(&format!("{before}{home}\nG1 X1 Y1"), dialect);
            assert_eq!(
                one[1..],
                [[0.0, 20.0, 5.0], [1.0, 21.0, 5.0]],
                "{dialect}: {home}"
            );
        }
    }
    let offset = ends(
        "G1 X10 Y20 F600\nSET_GCODE_OFFSET X=2\nG92 X0\nG28 X\nG1 X1",
        klipper,
    );
    assert_eq!(offset[1..], [[0.0, 20.0, 0.0], [3.0, 20.0, 0.0]]);
}

/// A number of 300 digits fills a message: it is cut, and its length is told.
#[test]
fn numbers_that_nobody_can_read_are_cut() {
    let found = Program::new(
        format!("G0 X1{}\nG0 Y[10**300]\nM2\n", "0".repeat(300)).as_bytes(),
        config(Dialect::LinuxCnc),
    )
    .finish();
    assert_eq!(found.errors(), 2, "{found:?}");
    let is_error = |one: &&Diagnostic| one.severity() == Severity::Error;
    for one in found.kept().iter().filter(is_error) {
        let text = one.to_string();
        assert!(text.len() < 300 && text.contains("(301 digits)"), "{text}");
    }
}
