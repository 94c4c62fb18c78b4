//! Formatting changes nothing that a program does; what is written is read as the same.
use crate::programs::{line, program};
use lostmotion_gcode::syntax::{Block, parse_block};
use lostmotion_gcode::{
    CanonicalOp, Dialect, InterpreterConfig, Limits, MotionFold, MotionItem, Program,
};
use lostmotion_gcode_tools::document::{Document, EditError, block_text};
use lostmotion_gcode_tools::format::{
    Case, FormatOptions, LineNumbers, format, refers_to_line_numbers,
};
use lostmotion_gcode_tools::writer::{Frame, Resolver, WriterError, write_program};
use proptest::prelude::*;

fn ops(text: &[u8], config: &InterpreterConfig) -> Vec<CanonicalOp> {
    Program::new(text, config.clone())
        .map(|sourced| sourced.op)
        .collect()
}

fn formatted(text: &str, options: &FormatOptions) -> String {
    let mut out = Vec::new();
    format(text.as_bytes(), options, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn resolved(text: &[u8], config: &InterpreterConfig, system: u8) -> Vec<CanonicalOp> {
    let mut resolver = Resolver::new(config, Frame::of(config, system).unwrap());
    let mut all: Vec<CanonicalOp> = Program::new(text, config.clone())
        .flat_map(|sourced| resolver.push(&sourced).unwrap())
        .map(|sourced| sourced.op)
        .collect();
    all.extend(resolver.finish());
    all
}

fn written(text: &[u8], config: &InterpreterConfig, system: u8) -> Result<String, WriterError> {
    let mut out = Vec::new();
    write_program(
        &mut Program::new(text, config.clone()),
        config,
        system,
        &mut out,
    )?;
    Ok(String::from_utf8(out).unwrap())
}

fn config() -> InterpreterConfig {
    let parameters = vec![
        (5221, 10.0),
        (5222, -3.25),
        (5243, 0.1),
        (5241, 1.0 / 3.0),
        (5242, 7.7),
    ];
    InterpreterConfig {
        parameters,
        ..InterpreterConfig::default()
    }
}

fn styles() -> Vec<FormatOptions> {
    let style = |case, indent, line_numbers| FormatOptions {
        case,
        indent,
        line_numbers,
        ..FormatOptions::default()
    };
    vec![
        FormatOptions::default(),
        style(Case::Lower, 0, LineNumbers::Remove),
        style(Case::Keep, 4, LineNumbers::Renumber { step: 10 }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn formatting_keeps_the_meaning_and_is_done_once(text in program()) {
        let before = ops(text.as_bytes(), &config());
        for style in styles() {
            let once = formatted(&text, &style);
            prop_assert_eq!(&ops(once.as_bytes(), &config()), &before, "{}", once);
            prop_assert_eq!(formatted(&once, &style), once);
        }
    }

    #[test]
    fn any_bytes_can_be_formatted(bytes in prop::collection::vec(prop_oneof![any::<u8>(), Just(b'\n'), Just(b'G'), Just(b'('), Just(b' ')], 0..200)) {
        let (mut once, mut twice) = (Vec::new(), Vec::new());
        let summary = format(&bytes[..], &FormatOptions::default(), &mut once).unwrap();
        format(&once[..], &FormatOptions::default(), &mut twice).unwrap();
        prop_assert_eq!(&once, &twice);
        prop_assert!(summary.changed <= summary.lines);
        prop_assert_eq!(ops(&once, &config()), ops(&bytes, &config()));
        prop_assert_eq!(Document::parse(&bytes).to_bytes(), bytes);
    }

    #[test]
    fn what_is_written_is_read_as_the_same(text in program(), system in 1u8..3) {
        let refused = Program::new(text.as_bytes(), config()).finish().errors() > 0;
        match written(text.as_bytes(), &config(), system) {
            Err(WriterError::Program { .. }) => prop_assert!(refused),
            // An arc in G18 has no rotation here, and everything else has its block.
            Err(error) => prop_assert!(false, "{}", error),
            Ok(again) => {
                prop_assert!(!refused);
                let expected = resolved(text.as_bytes(), &config(), system);
                let mut got = resolved(again.as_bytes(), &config(), system);
                got.remove(0);
                // In inverse time the rate follows from lengths in the frame.
                let rough = |op: &CanonicalOp| match op {
                    CanonicalOp::SetFeedRate { rate, inverse_time: Some(f) } => format!("{rate:.6} {f}"),
                    op => format!("{op:?}"),
                };
                prop_assert_eq!(got.iter().map(rough).collect::<Vec<_>>(), expected.iter().map(rough).collect::<Vec<_>>(), "{}", again);
                // Written again, it is the same text but for the comment that the head has become.
                let twice = written(again.as_bytes(), &config(), system).unwrap();
                prop_assert_eq!(twice.lines().skip(4).collect::<Vec<_>>(), again.lines().skip(3).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn the_machine_moves_as_before(text in program()) {
        let moves = |text: &[u8]| {
            let mut fold = MotionFold::new(config().start);
            let folded: Vec<_> = Program::new(text, config()).filter_map(|sourced| fold.push(&sourced).transpose()).collect();
            folded.into_iter().filter_map(Result::ok).filter_map(|item| if let MotionItem::Move(motion) = item { Some(motion) } else { None }).collect::<Vec<_>>()
        };
        if let Ok(again) = written(text.as_bytes(), &config(), 1) {
            let (before, after) = (moves(text.as_bytes()), moves(again.as_bytes()));
            prop_assert_eq!(before.len(), after.len());
            for (one, other) in before.iter().zip(&after) {
                let apart = one.end.0.iter().zip(&other.end.0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                prop_assert!(apart < 1e-9, "{:?} {:?}", one.end, other.end);
                prop_assert_eq!(one.path, other.path);
            }
        }
    }

    #[test]
    fn blocks_are_written_as_they_were_parsed(text in line(), extra in "x\\[-#[1-3] ?[*+/-] ?\\[[1-9] (mod|and|\\*\\*|gt) -[1-9]\\] ?[+*-] ?(sin|fup)\\[#<a_b>\\]\\]( (#<q>|##2)=exists\\[#<q>\\])?") {
        for line in text.lines().chain([extra.as_str()]) {
            let (mut block, mut again) = (Block::default(), Block::default());
            if parse_block(line.as_bytes(), &mut block, &Limits::default()).is_err() {
                continue;
            }
            let comment = block.comment.map(|text| line[text.start as usize..(text.start + text.len) as usize].to_owned());
            let shown = block_text(&block, comment.as_deref());
            parse_block(shown.as_bytes(), &mut again, &Limits::default()).unwrap();
            let bare = |block: &Block| {
                let words: Vec<_> = block.words.iter().map(|word| (word.letter, word.value)).collect();
                let settings: Vec<_> = block.settings.iter().map(|setting| (setting.target, setting.value)).collect();
                (words, settings, block.ops.clone(), block.names.clone(), block.flow, block.arguments.clone(), block.line_number, block.deletable)
            };
            prop_assert_eq!(bare(&again), bare(&block), "{}", shown);
        }
    }
}

#[test]
fn a_program_in_style() {
    let text = "  %\nn5   g1x10Y - 2 . 5( rough )f200;  end \n\n o1 IF [#1  gt 2]\n#<Depth>=[ 1+#<Depth> ]g0 z#<Depth>\no1 else\n/ m8\no1 endif\nG1 X\nm2\n%";
    let expected = "%\nN5 G1 X10 Y-2.5 ( rough ) F200 ;  end \n\no1 IF [#1 gt 2]\n  #<Depth> = [ 1+#<Depth> ] G0 Z#<Depth>\no1 else\n  /M8\no1 endif\nG1 X\nM2\n%";
    assert_eq!(formatted(text, &FormatOptions::default()), expected);
    let renumbered = FormatOptions {
        case: Case::Lower,
        indent: 0,
        line_numbers: LineNumbers::Renumber { step: 5 },
        ..FormatOptions::default()
    };
    assert_eq!(
        formatted(
            "N1 G0 X1\n(c)\nN1\nN7 O1 repeat [2]\nY2 #1=3\n",
            &renumbered
        ),
        "n5 g0 x1\n(c)\n\nn7 o1 repeat [2]\nn10 y2 #1 = 3\n"
    );
}

#[test]
fn references_to_line_numbers_are_seen() {
    let refers = |text: &str| refers_to_line_numbers(text.as_bytes()).unwrap();
    assert_eq!(refers("N1 G0 X1\n(GOTO 5)\nM99\n"), None);
    assert_eq!(
        (
            refers("\nGO TO 10"),
            refers("IF [#1 EQ 2] goto5"),
            refers("M99 P7"),
            refers("G71 P1 Q2")
        ),
        (Some(2), Some(1), Some(1), Some(1))
    );
}

#[test]
fn a_resolved_program_is_clean() {
    let text = "G20 G91 F10\n#1=2\no1 repeat [2]\nG1 X#1\no1 endrepeat\nG55 G90 G1 X1 Y0\nG2 X3 I1\nG2 I1 J0 P2\nM3 S500\nG10 L20 P2 X0\nG81 X1 Z-1 R1\nG80 M5\nM2\n";
    let config = InterpreterConfig {
        parameters: vec![(5241, 25.4)],
        ..InterpreterConfig::default()
    };
    let body: Vec<String> = written(text.as_bytes(), &config, 1)
        .unwrap()
        .lines()
        .skip(3)
        .map(str::to_owned)
        .collect();
    let expected = [
        "F10",
        "G20",
        "G1 X2",
        "G1 X4",
        "G1 X2 Y0",
        "G2 X4 I1 J0",
        "G2 I1 J0 P2",
        "M3 S500",
        "G0 Z1",
        "G61",
        "G0 X5",
        "G1 Z-1",
        "G0 Z1",
        "G64 P0 Q0",
        "M5",
        "M2",
    ];
    assert_eq!(body, expected);
}

#[test]
fn what_has_no_block_is_refused_by_name() {
    let error = written(
        b"G10 L2 P1 R30\nG18 F100\nG2 X10 I5\nM2\n",
        &InterpreterConfig::default(),
        1,
    )
    .unwrap_err();
    assert!(
        matches!(error, WriterError::RotatedArc { degrees: 30.0, .. }),
        "{error}"
    );
    let turning = InterpreterConfig::default().with_dialect(Dialect::Fanuc);
    let error = written(b"G21 G90 F100\nG68 X0 Y0 R30\nG1 X9\nM30\n", &turning, 1).unwrap_err();
    assert!(
        matches!(error, WriterError::Turned { .. }) && error.to_string().contains("line 2"),
        "{error}"
    );
    let error = written(b"G1 X1\nM2\n", &InterpreterConfig::default(), 1).unwrap_err();
    assert!(
        matches!(error, WriterError::Program { errors: 1 }),
        "{error}"
    );
    let rotated = InterpreterConfig {
        parameters: vec![(5230, 5.0)],
        ..InterpreterConfig::default()
    };
    assert!(matches!(
        written(b"M2\n", &rotated, 1).unwrap_err(),
        WriterError::RotatedFrame { system: 1, .. }
    ));
    assert!(matches!(
        written(b"M2\n", &rotated, 10).unwrap_err(),
        WriterError::NoSuchSystem { system: 10 }
    ));
}

#[test]
fn rates_stay_what_they_are_where_modes_change() {
    let text = "S9\nF100 G1 X1\nG93 X2 F2\nX3 F4\nG94 X4 F100\nG95 X5 F.1\nG94 X6 F100\nG94 X7 F100\nG93 G41.1 D1 G1 X8 Y9 F3\nY20 F3\nG40 X20 F1\nM2\n";
    let out = written(text.as_bytes(), &InterpreterConfig::default(), 1).unwrap();
    let feeds: Vec<&str> = out
        .lines()
        .filter(|line| line.contains('F') || line.contains("G9"))
        .skip(2)
        .collect();
    let expected = [
        "G1 X1 F100",
        "G93 G1 X2 F2",
        "G1 X3 F4",
        "G94 G1 X4 F100",
        "G95",
        "G1 X5 F0.1",
        "G94",
        "G1 X6 F100",
    ];
    assert_eq!(feeds[..expected.len()], expected, "{out}");
    // Under compensation it is the rate of the programmed length that holds: 3 sqrt(82) here,
    // whatever the path is.
    assert!(
        feeds
            .iter()
            .any(|line| line.ends_with(&format!("F{}", 82f64.sqrt() * 3.0))),
        "{out}"
    );
}

#[test]
fn an_oriented_stop_of_a_boring_cycle_is_written() {
    let text = "F100 S500 M4\nG87 X1 Y2 Z-5 R1 I0.5 J0 K-3\nM19 R90 P1 Q2\nM4\nG33 Z-6 K1\nM2\n";
    let out = written(text.as_bytes(), &InterpreterConfig::default(), 1).unwrap();
    assert_eq!(out.matches("M19 R0 P2\n").count(), 2, "{out}");
    assert!(out.contains("M19 R90 P1 Q2\nM4\n"), "{out}");
}

#[test]
fn edits_leave_the_rest_alone() {
    let text = b"\xef\xbb\xbfg1  X 1 0 (a)\r\n\tnot g code ((\rM2";
    let mut document = Document::parse(text);
    assert_eq!((document.len(), document.to_bytes()), (3, text.to_vec()));
    assert!(matches!(
        document.block(2),
        Err(EditError::Unreadable { line: 2, .. })
    ));
    assert_eq!(
        document.set_word(3, 'x', 1.0),
        Err(EditError::NoSuchWord {
            line: 3,
            letter: 'x'
        })
    );
    document.set_line(1, b"g1  X 1 0 (a)").unwrap();
    document.set_word(1, 'x', -0.125).unwrap();
    document.insert_line(4, b"(end)").unwrap();
    document.remove_line(2).unwrap();
    assert_eq!(document.to_bytes(), b"g1  X-0.125 (a)\r\nM2\r\n(end)\r\n");
    assert_eq!(
        document.insert_line(9, b""),
        Err(EditError::NoSuchLine { line: 9, lines: 3 })
    );
    assert_eq!(document.set_line(1, b"a\nb"), Err(EditError::SeveralLines));
    assert!(document.set_word(1, 'X', f64::NAN).is_err());
}

/// Machines without U V W refuse these words.
#[test]
fn a_tool_offset_is_written_for_the_axes_that_it_has() {
    let config = InterpreterConfig::default();
    let text = written(
        b"G21\nG43.1 Z50\nG0 Z5\nG43.1 X2 Z0\nG0 X1\nG49\nM2\n",
        &config,
        1,
    )
    .unwrap();
    let lines: Vec<&str> = text
        .lines()
        .filter(|line| line.starts_with("G43.1"))
        .collect();
    assert_eq!(lines, ["G43.1 Z50", "G43.1 X2 Z0"], "{text}");
    assert!(
        !text.contains('U') && !text.contains('V') && !text.contains('W'),
        "{text}"
    );
}

/// The moves of a written program, without head, modes and feeds.
fn written_moves(text: &str) -> Vec<String> {
    let again = written(text.as_bytes(), &InterpreterConfig::default(), 1).unwrap();
    let moves = again
        .lines()
        .skip(3)
        .filter(|line| line.contains(['X', 'Y', 'Z']));
    moves.map(str::to_owned).collect()
}

/// Nobody knows where the machine stands at the start, behind a change, a pause or a way home.
#[test]
fn a_word_of_an_axis_is_never_left_out() {
    let text = "G21 G90 G17\nG0 Z10\nG0 X0 Y0\nG1 Z-1 F100\nG1 X10 Y5\nG0 Z10\nM2\n";
    assert_eq!(
        written_moves(text),
        ["G0 Z10", "G0 X0 Y0", "G1 Z-1 F100", "G1 X10 Y5", "G0 Z10"]
    );
    let text =
        "G0 X5 Y5 Z5\nT1 M6\nG0 X5 Y5\nM0\nZ5\nG43.1 Z0\nG0 X5 Z5\nG92 X0\nG0 X0 (here)\nM2\n";
    assert_eq!(
        written_moves(text),
        ["G0 X5 Y5 Z5", "G0 X5 Y5", "G0 Z5", "G0 X5 Z5", "G0 X5"]
    );
}

#[test]
fn axes_that_a_program_does_not_name_are_not_sent_anywhere() {
    // The first half of the way home goes nowhere; the second says where it leads.
    assert_eq!(
        written_moves("G91 G28 Z0\nG90\nG28\nG81 X0 Y0 Z-2 R1 F100\nG80\nM2\n"),
        [
            "G0 Z0",
            "G0 X0 Y0 Z0",
            "G0 Z1",
            "G0 X0 Y0",
            "G1 Z-2",
            "G0 Z1"
        ]
    );
    assert_eq!(
        written_moves("G91 G1 X0 F100\nG90 G1 Y0\nG2 I5\nM2\n"),
        ["G91 G1 X0 F100", "G1 Y0"]
    );
}
