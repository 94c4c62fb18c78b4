//! Programs of other controls: what they mean and what is said about them.
use crate::common::{codes, config};
use lostmotion_gcode::{Dialect, InterpreterConfig, Leniency, Program, dialect::LENIENCIES};
use std::fs;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gcode_samples/dialects")
}

fn run(text: &[u8], config: InterpreterConfig) -> (Vec<String>, Vec<String>, u64) {
    let mut program = Program::new(text, config);
    let ops = program
        .by_ref()
        .skip(4)
        .map(|sourced| format!("{:>3} {}", sourced.block.span.line, sourced.op))
        .collect();
    let told = program
        .diagnostics()
        .kept()
        .iter()
        .map(ToString::to_string)
        .collect();
    (ops, told, program.diagnostics().errors())
}

/// Only the moves, without zeros at the end.
fn moves(text: &str, dialect: Dialect) -> Vec<String> {
    let (ops, told, errors) = run(text.as_bytes(), config(dialect));
    assert_eq!(errors, 0, "{text}\n{told:?}");
    let motion =
        |op: &String| op.contains("STRAIGHT") || op.contains("ARC") || op.contains("DWELL");
    ops.into_iter()
        .filter(motion)
        .map(|op| op.trim_start().split_once(' ').unwrap().1.to_owned())
        .collect()
}

#[test]
fn every_sample_means_what_its_snapshot_says() {
    let mut names: Vec<String> = fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert!(names.len() >= 10);
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for name in names {
            let dialect = Dialect::ALL
                .into_iter()
                .find(|dialect| name.starts_with(dialect.name()))
                .unwrap_or_default();
            let text = fs::read(folder().join(&name)).unwrap();
            let (ops, told, _) = run(&text, config(dialect));
            let shown = format!(
                "{}\n---\n{}\n---\n{}\n",
                String::from_utf8(text).unwrap().trim_end(),
                ops.join("\n"),
                told.join("\n")
            );
            insta::assert_snapshot!(
                format!("dialect_{}", name.split('.').next().unwrap()),
                shown
            );
        }
    });
}

/// A line of 300 bytes.
const LONG_LINE: &str = "G0 X1 (................................................................................................................................................................................................................................................................................................)\nM30\n";

/// A program that takes one leniency, and the dialect that has it.
const DETOUR: &str = "G18 G8 F100\nO1 SUB\nG0 X2 Z3\nG1 X4 Z-1\nX8 Z-12\nO1 ENDSUB\nG0 X10 Z-20\nG42.1 D0.4\nG70 Q1 X10 Z3\nG0 X20 Z5\nG40\nM30\n";

const TAKES: [(Leniency, Dialect, &str); 37] = [
    (Leniency::MissingEnd, Dialect::LinuxCnc, "G0 X1\n"),
    (
        Leniency::ByteOrderMark,
        Dialect::LinuxCnc,
        "\u{feff}G0 X1\nM2\n",
    ),
    (Leniency::Exponents, Dialect::LinuxCnc, "G0 X1.5E-3\nM2\n"),
    (Leniency::ExtraMotion, Dialect::LinuxCnc, "G0 G28 Z0\nM2\n"),
    (
        Leniency::OffPlaneZero,
        Dialect::LinuxCnc,
        "G2 X2 I1 K0 F100\nM2\n",
    ),
    (
        Leniency::PeckDwell,
        Dialect::LinuxCnc,
        "G83 X1 Z-1 R1 Q1 P5 F100\nM2\n",
    ),
    (
        Leniency::BareReturns,
        Dialect::LinuxCnc,
        "G0 X1\rG0 X2\rM2\r",
    ),
    (Leniency::LowerCase, Dialect::Fanuc, "g0 X1\nM30\n"),
    (
        Leniency::PlainSiemens,
        Dialect::Siemens,
        "G90 G54\nG1 X1 F100\nM30\n",
    ),
    (
        Leniency::NoBlanks,
        Dialect::LinuxCnc,
        "G0X1\nG0 Y1Z1\nM30\n",
    ),
    (Leniency::CrLf, Dialect::LinuxCnc, "G0 X1\r\nM30\r\n"),
    (
        Leniency::SecondaryAxes,
        Dialect::LinuxCnc,
        "G0 X1 W2\nM30\n",
    ),
    (Leniency::LongLines, Dialect::LinuxCnc, LONG_LINE),
    (
        Leniency::IgnoredCodes,
        Dialect::Fanuc,
        "G5.1 Q1\nG0 X1\nM30\n",
    ),
    (Leniency::BareArithmetic, Dialect::Fanuc, "#1=2*3\nM30\n"),
    (Leniency::MacroFlow, Dialect::Fanuc, "GOTO 5\nN5 M30\n"),
    (
        Leniency::MacroCalls,
        Dialect::Fanuc,
        "G65 P10 A1.\nM30\nO10\nM99\n",
    ),
    (Leniency::Vacant, Dialect::Fanuc, "#1=#0\nM30\n"),
    (
        Leniency::PackedCalls,
        Dialect::Fanuc,
        "M98 P20010\nM30\nO10\nM99\n",
    ),
    (
        Leniency::CornerWords,
        Dialect::Fanuc,
        "G1 X9 ,R1 F10\nY9\nM30\n",
    ),
    (
        Leniency::LocalCalls,
        Dialect::Haas,
        "M97 P7\nM30\nN7 G0 X1\nM99\n",
    ),
    (
        Leniency::CircularPockets,
        Dialect::Haas,
        "G12 I5 F100\nM30\n",
    ),
    (
        Leniency::HolePatterns,
        Dialect::Haas,
        "G81 Z-1 R1 F100\nG70 I5 L3\nM30\n",
    ),
    (
        Leniency::ExtruderWords,
        Dialect::Marlin,
        "G1 X1 E1 F100\nM2\n",
    ),
    (Leniency::PrinterCodes, Dialect::Marlin, "M104 S200\nM30\n"),
    (
        Leniency::StringCommands,
        Dialect::Klipper,
        "M117 Hello there\nM30\n",
    ),
    (Leniency::Checksums, Dialect::Marlin, "N1G0*8\nM30\n"),
    (Leniency::BareLetters, Dialect::Marlin, "G28 X Y\nM30\n"),
    (
        Leniency::ToolMemory,
        Dialect::Fanuc,
        "G10 L10 P1 R25.\nM30\n",
    ),
    (Leniency::FinishDetour, Dialect::LinuxCnc, DETOUR),
    (
        Leniency::ReadBeforeSet,
        Dialect::LinuxCnc,
        "#<n>=[#<n>+1]\nG0 X#<n>\nM30\n",
    ),
    (
        Leniency::ExtraSystems,
        Dialect::Fanuc,
        "G54.1 P1\nG0 X1.\nM30\n",
    ),
    (
        Leniency::CycleRepeats,
        Dialect::Fanuc,
        "G81 Z-1. R1. F100. K2\nM30\n",
    ),
    (Leniency::NumberedSkip, Dialect::Fanuc, "/2 G0 X1.\nM30\n"),
    (Leniency::ColonNumbers, Dialect::Fanuc, ":0001\nM30\n"),
    (Leniency::NegativeLength, Dialect::Fanuc, "G44 H1\nM30\n"),
    (
        Leniency::GcodeStates,
        Dialect::Klipper,
        "SAVE_GCODE_STATE\nM30\n",
    ),
];

#[test]
fn every_leniency_has_its_own_warning_and_its_own_switch() {
    for (leniency, dialect, text) in TAKES {
        let accepted = config(dialect);
        assert!(accepted.leniencies.has(leniency), "{leniency:?}");
        let mut program = Program::new(text.as_bytes(), accepted.clone());
        for _ in program.by_ref() {}
        let found = program.diagnostics();
        assert_eq!(found.errors(), 0, "{leniency:?}: {:?}", found.kept());
        let told: Vec<_> = found
            .kept()
            .iter()
            .filter(|one| one.code() == leniency.name())
            .collect();
        assert!(
            told.len() == 1 && told[0].severity() == leniency.severity(),
            "{leniency:?}: {:?}",
            found.kept()
        );
        let refused = InterpreterConfig {
            leniencies: accepted.leniencies.without(leniency),
            ..accepted
        };
        // These mean something else without it.
        if !matches!(
            leniency,
            Leniency::ToolMemory | Leniency::FinishDetour | Leniency::GcodeStates
        ) {
            let mut program = Program::new(text.as_bytes(), refused);
            for _ in program.by_ref() {}
            assert!(
                program.diagnostics().errors() > 0,
                "{leniency:?} cannot be denied"
            );
        }
    }
    assert_eq!(
        TAKES.len() + 1,
        LENIENCIES.len(),
        "G43.4 and the like have tests of their own"
    );
}

#[test]
fn a_program_in_macro_b_moves_as_the_same_one_in_o_words() {
    let fanuc = "#1=0\nWHILE [#1 LT 4] DO 1\n#2=#1*#1+1\nG1 X#2 F100\n#1=#1+1\nEND 1\nM30\n";
    let words =
        "#1=0\no1 while [#1 lt 4]\n#2=[#1*#1+1]\nG1 X#2 F100\n#1=[#1+1]\no1 endwhile\nM30\n";
    assert_eq!(
        moves(fanuc, Dialect::Fanuc),
        moves(words, Dialect::LinuxCnc)
    );
}

#[test]
fn a_rounded_corner_touches_both_sides() {
    let expected = moves(
        "G1 X8 F100\nG3 X10 Y2 I0 J2\nG1 Y10\nM30\n",
        Dialect::LinuxCnc,
    );
    assert_eq!(
        moves("G1 X10 ,R2 F100\nY10\nM30\n", Dialect::Fanuc),
        expected
    );
    let chamfered = moves("G1 X8 F100\nX10 Y2\nY10\nM30\n", Dialect::LinuxCnc);
    assert_eq!(
        moves("G1 X10 ,C2 F100\nY10\nM30\n", Dialect::Fanuc),
        chamfered
    );
    // A blunt corner in incremental distances.
    let sixty = moves("G91 G1 X10 ,R1 F100\nX5 Y8.660254\nM30\n", Dialect::Fanuc);
    let distance = 10.0 - 1.0 / 3f64.sqrt();
    assert!(sixty[0].contains(&format!("{distance:.4}")), "{sixty:?}");
    assert!(sixty[2].contains("15.0000, 8.6603"), "{sixty:?}");
}

#[test]
fn corners_that_cannot_be_are_refused() {
    for text in [
        "G1 X1 ,R5 F100\nY1\nM30\n",
        "G1 X9 ,R1 F100\nM3\nM30\n",
        "G1 X9 ,R1 F100\nX18\nM30\n",
        "G1 X9 Z1 ,R1 F100\nY9\nM30\n",
    ] {
        assert!(
            codes(text, config(Dialect::Fanuc)).contains(&"corner"),
            "{text}"
        );
    }
}

#[test]
fn jumps_to_lines_that_are_not_there_are_told_and_jumping_forever_ends() {
    assert_eq!(
        codes("GOTO 77\nM30\n", config(Dialect::Fanuc)),
        ["macro-flow", "no-such-line", "no-program-end"]
    );
    assert!(codes("N1 #1=1\nGOTO 1\nM30\n", config(Dialect::Fanuc)).contains(&"idle-loop"));
}

/// Firmware of printers has no code for the end of a program.
#[test]
fn programs_of_printers_end_with_their_last_line() {
    let text = "G90\nG1 X10 F600\n";
    for dialect in [Dialect::Marlin, Dialect::Klipper] {
        assert!(codes(text, config(dialect)).is_empty(), "{dialect}");
    }
    assert_eq!(codes(text, config(Dialect::Fanuc)), ["no-program-end"]);
}

#[test]
fn siemens_is_refused_by_name_in_every_dialect() {
    for line in [
        "R1=5",
        "G1 X=10 F100",
        "TRANS X10",
        "CYCLE83(1,2,3)",
        "N10 MCALL CYCLE81(1,2)",
    ] {
        for dialect in Dialect::ALL {
            if dialect.is_printer() {
                continue;
            }
            let text = format!("{line}\nM30\n");
            assert_eq!(
                codes(&text, config(dialect))[0],
                "siemens",
                "{line} in {dialect}"
            );
        }
    }
}

/// A control of Siemens runs plain G-code, too: blocks are refused where something is of its own.
#[test]
fn plain_blocks_for_siemens_are_read() {
    let plain = "G90 G54\nG1 X10 F100\nG2 X0 I-5\nM30\n";
    assert_eq!(
        moves(plain, Dialect::Siemens),
        moves(plain, Dialect::LinuxCnc)
    );
    assert_eq!(codes(plain, config(Dialect::Siemens)), ["plain-siemens"]);
    let own = plain.replace("G2 X0 I-5", "G2 X0 CR=5");
    let (_, told, _) = run(own.as_bytes(), config(Dialect::Siemens));
    let refusal = told
        .iter()
        .find(|it| it.contains("an address with ="))
        .unwrap();
    assert!(refusal.contains("--dialect linuxcnc"), "{refusal}");
}

#[test]
fn the_base_refuses_what_other_dialects_accept() {
    for (leniency, dialect, text) in TAKES {
        let other = matches!(
            leniency,
            Leniency::LowerCase
                | Leniency::HolePatterns
                | Leniency::ToolMemory
                | Leniency::PlainSiemens
        );
        if !Dialect::LinuxCnc.leniencies().has(leniency) && !other {
            let (_, told, errors) = run(text.as_bytes(), config(Dialect::LinuxCnc));
            assert!(errors > 0, "{leniency:?} of {dialect}: {told:?}");
        }
    }
}

#[test]
fn a_return_can_name_its_line() {
    let returns = moves(
        "M98 P10\nG0 X1\nN50 G0 X2\nM30\nO10\nG0 Y3\nM99 P50\n",
        Dialect::Fanuc,
    );
    assert_eq!(returns, moves("G0 Y3\nG0 X2\nM30\n", Dialect::Fanuc));
    // In the main program it is a jump; rounds that are left are not made.
    assert_eq!(
        moves("M99 P7\nG0 X1\nN7 G0 X2\nM30\n", Dialect::Fanuc),
        moves("G0 X2\nM30\n", Dialect::Fanuc)
    );
    let packed = moves(
        "M98 P30010\nN50 G0 X2\nM30\nO10\nG0 Y3\nM99 P50\n",
        Dialect::Fanuc,
    );
    assert_eq!(packed, returns);
    assert!(
        codes("M98 P10\nM30\nO10\nM99 P77\n", config(Dialect::Fanuc)).contains(&"no-such-line")
    );
    assert!(codes("M99 P7\nN7 M2\n", config(Dialect::LinuxCnc)).contains(&"unused-word"));
}

#[test]
fn what_is_vacant_is_no_zero() {
    let run = |text: &str| moves(text, Dialect::Fanuc);
    // A word with a vacant parameter is left out; in a sum the parameter counts as 0.
    assert_eq!(run("G0 X1 Y#5\nX[#5+2]\nM30\n"), run("G0 X1\nX2\nM30\n"));
    // Equality tells it from 0, order does not.
    let chosen = |condition: &str| {
        run(&format!(
            "#2=0\nIF [{condition}] GOTO 5\nG0 X1\nN5 G0 Y1\nM30\n"
        ))
        .len()
            == 1
    };
    for (condition, holds) in [
        ("#1 EQ #0", true),
        ("#1 EQ 0", false),
        ("#1 NE 0", true),
        ("#2 EQ #0", false),
        ("#2 NE #0", true),
        ("#1 GE 0", true),
        ("#1 LT #0", false),
    ] {
        assert_eq!(chosen(condition), holds, "{condition}");
    }
    // Assigned, passed as an argument, and taken away again.
    assert_eq!(run("#3=4\n#3=#0\nG0 X1 Y#3\nM30\n"), run("G0 X1\nM30\n"));
    let called = "G65 P10 A1.\nZ#1\nX9\nM30\nO10\nG0 X#1 Y#2\nM99\n";
    assert_eq!(run(called), run("G0 X1\nX9\nM30\n"));
}

/// What rs274 of LinuxCNC 2.9 answers; other names still have to be set first.
#[test]
fn a_name_counts_from_0_in_its_first_setting() {
    for (line, x) in [
        ("#<n>=[#<n>+1]", "1.0000"),
        ("#<n>=2 #<m>=[#<n>+1]\n#<n>=#<m>", "1.0000"),
        ("#<_n>=[#<_n>+3] #<n>=2", "2.0000"),
    ] {
        let text = format!("G21\n{line}\nG0 X#<n>\nM2\n");
        let (ops, told, errors) = run(text.as_bytes(), config(Dialect::LinuxCnc));
        assert!(
            errors == 0
                && ops
                    .iter()
                    .any(|op| op.contains(&format!("STRAIGHT_TRAVERSE({x},"))),
            "{line}: {ops:?} {told:?}"
        );
        assert_eq!(
            codes(&text, config(Dialect::LinuxCnc)),
            ["read-before-set"],
            "{line}"
        );
        let strict = InterpreterConfig {
            leniencies: Dialect::LinuxCnc
                .leniencies()
                .without(Leniency::ReadBeforeSet),
            ..config(Dialect::LinuxCnc)
        };
        assert_eq!(codes(&text, strict)[0], "unknown-parameter", "{line}");
    }
    for line in ["#<n>=[#<m>+1]", "#<n>=#<m> #<m>=1", "G0 X#<n> #<n>=1"] {
        let text = format!("G21\n{line}\nM2\n");
        assert_eq!(
            codes(&text, config(Dialect::LinuxCnc))[0],
            "unknown-parameter",
            "{line}"
        );
    }
}
