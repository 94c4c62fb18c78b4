//! What has to hold for every input: shared by the fuzz targets and by the test that replays their corpus.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a check fails by panicking")]

use lostmotion_gcode::syntax::{Block, PieceKind, Pieces, Value, parse_block};
use lostmotion_gcode::{InterpreterConfig, Limits, MotionFold, Program};

/// Lines of the data as blocks: words lie within their line, in its order and apart from each other, and every literal is
/// the f64 nearest to its decimal.
pub fn parser(data: &[u8]) {
    let (mut block, mut again) = (Block::default(), Block::default());
    let limits = Limits { words: 16, expression_depth: 8, ..Limits::default() };
    for line in data.split(|&byte| byte == b'\n') {
        let parsed = parse_block(line, &mut block, &limits);
        if let Err(fault) = &parsed {
            assert!(fault.rest <= line.len(), "the fault lies within the line");
        }
        let mut end = 0;
        for word in &block.words {
            let (from, to) = (word.text.start as usize, (word.text.start + word.text.len) as usize);
            assert!(end <= from && from < to && to <= line.len(), "words follow each other within the line");
            assert_eq!(line[from].to_ascii_uppercase(), word.letter);
            if let Value::Number(number) = word.value {
                nearest(&line[from + 1..to], number);
            }
            end = to;
        }
        tiled(line, &block, parsed.is_err());
        assert_eq!(parse_block(line, &mut again, &limits), parsed, "the same line gives the same answer");
        assert_eq!(again, block, "buffers that are used again change nothing");
    }
}

/// Every byte of a line belongs to exactly one piece, and every item of the block has one.
fn tiled(line: &[u8], block: &Block, has_fault: bool) {
    let (mut at, mut words, mut settings) = (0, 0, 0);
    for piece in Pieces::new(line, block) {
        assert_eq!(piece.text.start as usize, at);
        assert!(piece.text.len > 0);
        let bytes = &line[at..at + piece.text.len as usize];
        at += bytes.len();
        match piece.kind {
            PieceKind::Blank => assert!(bytes.iter().all(|byte| matches!(byte, b' ' | b'\t'))),
            PieceKind::Word(_) => words += 1,
            PieceKind::Setting(_) => settings += 1,
            PieceKind::Unread => assert!(has_fault, "{} of a line without a fault is not read", bytes.escape_ascii()),
            _ => {}
        }
    }
    assert_eq!((at, words, settings), (line.len(), block.words.len(), block.settings.len()));
}

/// Literals that the standard library reads, too, have the same bits.
fn nearest(text: &[u8], number: f64) {
    assert!(number.is_finite());
    let text: String = text.iter().filter(|byte| !matches!(byte, b' ' | b'\t')).map(|&byte| char::from(byte)).collect();
    if let Ok(expected) = text.parse::<f64>() {
        assert_eq!(expected.to_bits(), number.to_bits(), "{text}");
    }
}

/// Words written with the fewest digits that tell their f64 apart are read as the same words.
pub fn round_trip(data: &[u8]) {
    let (mut block, mut again) = (Block::default(), Block::default());
    let limits = Limits::default();
    for line in data.split(|&byte| byte == b'\n') {
        if parse_block(line, &mut block, &limits).is_err() {
            continue;
        }
        let mut text = String::new();
        let mut expected = Vec::new();
        for word in &block.words {
            if let Value::Number(number) = word.value {
                text += &format!("{}{number} ", char::from(word.letter));
                expected.push((word.letter, number.to_bits()));
            }
        }
        parse_block(text.as_bytes(), &mut again, &limits).unwrap_or_else(|fault| panic!("{text}: {fault:?}"));
        let bits = |value| if let Value::Number(number) = value { number.to_bits() } else { panic!("{text}: a literal is one") };
        let found: Vec<_> = again.words.iter().map(|word| (word.letter, bits(word.value))).collect();
        assert_eq!(found, expected, "{text}");
    }
}

/// The data as a program: it ends, its spans lie within it, the machine stays at a finite place.
pub fn interpreter(data: &[u8]) {
    let limits = Limits { looped_blocks: 100, idle_blocks: 50, cycle_moves: 50, curve_points: 50, ..Limits::default() };
    let config = InterpreterConfig { limits, ..InterpreterConfig::default() };
    let mut fold = MotionFold::new(config.start);
    let mut program = Program::new(data, config);
    for op in program.by_ref() {
        let span = op.block.span;
        assert!(span.start + u64::from(span.len) <= data.len() as u64, "a span lies within the source");
        let _ = fold.push(&op);
        assert!(fold.position().is_finite());
    }
    for diagnostic in program.diagnostics().kept() {
        let span = diagnostic.place.span;
        assert!(span.start + u64::from(span.len) <= data.len() as u64, "{diagnostic}");
    }
}
