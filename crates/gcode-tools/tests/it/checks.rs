//! What has to hold for every input: shared by the fuzz targets and by the test that replays their
//! corpus.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a check fails by panicking"
)]

use lostmotion_gcode::syntax::{Block, TokenKind, Tokens, Value, parse_block};
use lostmotion_gcode::{CanonicalOp, Dialect, InterpreterConfig, Limits, MotionFold, Program};
use lostmotion_gcode_tools::document::block_text;
use lostmotion_gcode_tools::writer::{Frame, Resolver, write_program};

/// Lines of the data as blocks: words lie within their line, in its order and apart from each
/// other, and every literal is the f64 nearest to its decimal.
pub fn parser(data: &[u8]) {
    let (mut block, mut again) = (Block::default(), Block::default());
    let limits = Limits {
        words: 16,
        expression_depth: 8,
        ..Limits::default()
    };
    for line in data.split(|&byte| byte == b'\n') {
        let parsed = parse_block(line, &mut block, &limits);
        if let Err(fault) = &parsed {
            assert!(fault.rest <= line.len(), "the fault lies within the line");
        }
        let mut end = 0;
        for word in &block.words {
            let (from, to) = (
                word.text.start as usize,
                (word.text.start + word.text.len) as usize,
            );
            assert!(
                end <= from && from < to && to <= line.len(),
                "words follow each other within the line"
            );
            assert_eq!(line[from].to_ascii_uppercase(), word.letter);
            if let Value::Number(number) = word.value {
                nearest(&line[from + 1..to], number);
            }
            end = to;
        }
        tiled(line, &block, parsed.is_err());
        assert_eq!(
            parse_block(line, &mut again, &limits),
            parsed,
            "the same line gives the same answer"
        );
        assert_eq!(again, block, "buffers that are used again change nothing");
    }
}

/// Every byte of a line belongs to exactly one token, and every item of the block has one.
fn tiled(line: &[u8], block: &Block, has_fault: bool) {
    let (mut at, mut words, mut settings) = (0, 0, 0);
    for token in Tokens::new(line, block) {
        assert_eq!(token.text.start as usize, at);
        assert!(token.text.len > 0);
        let bytes = &line[at..at + token.text.len as usize];
        at += bytes.len();
        match token.kind {
            TokenKind::Blank => assert!(bytes.iter().all(|byte| matches!(byte, b' ' | b'\t'))),
            TokenKind::Word(_) => words += 1,
            TokenKind::Setting(_) => settings += 1,
            TokenKind::Unread => assert!(
                has_fault,
                "{} of a line without a fault is not read",
                bytes.escape_ascii()
            ),
            _ => {}
        }
    }
    assert_eq!(
        (at, words, settings),
        (line.len(), block.words.len(), block.settings.len())
    );
}

/// Literals that the standard library reads, too, have the same bits.
fn nearest(text: &[u8], number: f64) {
    assert!(number.is_finite());
    let text: String = text
        .iter()
        .filter(|byte| !matches!(byte, b' ' | b'\t'))
        .map(|&byte| char::from(byte))
        .collect();
    if let Ok(expected) = text.parse::<f64>() {
        assert_eq!(expected.to_bits(), number.to_bits(), "{text}");
    }
}

/// Blocks written as text are read as blocks that are written as the same text; words with literals
/// keep them to the bit.
pub fn round_trip(data: &[u8]) {
    let (mut block, mut again) = (Block::default(), Block::default());
    let limits = Limits::default();
    for line in data.split(|&byte| byte == b'\n') {
        if parse_block(line, &mut block, &limits).is_err() {
            continue;
        }
        let text = block_text(&block, None);
        if text.len() > limits.line_bytes {
            continue;
        }
        parse_block(text.as_bytes(), &mut again, &limits)
            .unwrap_or_else(|fault| panic!("{text}: {fault:?}"));
        assert_eq!(block_text(&again, None), text);
        assert_eq!(literals(&again), literals(&block), "{text}");
    }
}

/// Words with a literal.
fn literals(block: &Block) -> Vec<(u8, Option<u64>)> {
    let bits = |value| {
        if let Value::Number(number) = value {
            Some(number.to_bits())
        } else {
            None
        }
    };
    block
        .words
        .iter()
        .map(|word| (word.letter, bits(word.value)))
        .collect()
}

fn config() -> InterpreterConfig {
    let limits = Limits {
        looped_blocks: 100,
        idle_blocks: 50,
        cycle_moves: 50,
        curve_points: 50,
        ..Limits::default()
    };
    InterpreterConfig {
        limits,
        ..InterpreterConfig::default()
    }
}

/// A program that can be written gives a program without an error, which does the same.
pub fn writer(data: &[u8]) {
    let mut out = Vec::new();
    if write_program(&mut Program::new(data, config()), &config(), 1, &mut out).is_ok() {
        let (expected, mut found) = (resolved(data), resolved(&out));
        // The remark that the writer begins with.
        assert!(matches!(found.remove(0), CanonicalOp::Text { .. }));
        assert_eq!(found, expected, "{}", out.escape_ascii());
    }
}

/// What a program does, in one frame.
fn resolved(text: &[u8]) -> Vec<CanonicalOp> {
    let frame = Frame::of(&config(), 1).expect("the first system always is");
    let mut resolver = Resolver::new(&config(), frame);
    let mut program = Program::new(text, config());
    let mut ops = Vec::new();
    for sourced in program.by_ref() {
        let all = resolver.push(&sourced).expect("it has been written");
        ops.extend(all.into_iter().map(|sourced| sourced.op));
    }
    ops.extend(resolver.finish());
    assert_eq!(program.diagnostics().errors(), 0);
    ops
}

/// The data as a program: it ends, its spans lie within it, the machine stays at a finite place.
pub fn interpreter(data: &[u8]) {
    runs(data, config());
}

/// The same in the dialect that the first byte chooses.
pub fn dialects(data: &[u8]) {
    if let Some((first, text)) = data.split_first() {
        let dialect = Dialect::ALL[usize::from(*first) % Dialect::ALL.len()];
        runs(text, config().with_dialect(dialect));
    }
}

fn runs(data: &[u8], config: InterpreterConfig) {
    let mut fold = MotionFold::new(config.start);
    let mut program = Program::new(data, config);
    for op in program.by_ref() {
        let span = op.block.span;
        assert!(
            span.start + u64::from(span.len) <= data.len() as u64,
            "a span lies within the source"
        );
        let _ = fold.push(&op);
        assert!(fold.position().is_finite());
    }
    for diagnostic in program.diagnostics().kept() {
        let span = diagnostic.place.span;
        assert!(
            span.start + u64::from(span.len) <= data.len() as u64,
            "{diagnostic}"
        );
    }
}
