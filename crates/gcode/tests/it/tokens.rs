//! Spans: every byte of a source belongs to exactly one token, however the bytes arrive.
use crate::generate::line;
use lostmotion_gcode::syntax::TokenKind;
use lostmotion_gcode::{Blocks, InterpreterConfig, Limits, Program};
use proptest::prelude::*;
use std::io::{BufRead, BufReader, Read};

/// Walks the tokens of a source and checks that nothing lies between them but the ends of lines.
fn tiled(source: &[u8], reader: impl BufRead) -> Result<Vec<(TokenKind, u64, u32)>, TestCaseError> {
    let mut blocks = Blocks::new(reader, Limits::default());
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(parsed) = blocks.read().unwrap() {
        let start = parsed.place.start;
        let gap = &source[at as usize..start as usize];
        let expected: &[&[u8]] = if parsed.place.line == 1 {
            &[b""]
        } else {
            &[b"\n", b"\r\n", b"\r"]
        };
        prop_assert!(expected.contains(&gap), "{}", gap.escape_ascii());
        at = start;
        for token in parsed.tokens() {
            let span = parsed.span(token.text);
            prop_assert_eq!((span.start, u64::from(span.column) - 1), (at, at - start));
            prop_assert!(span.len > 0);
            prop_assert!(token.kind != TokenKind::Unread || parsed.fault.is_some());
            at += u64::from(span.len);
            tokens.push((token.kind, span.start, span.len));
        }
        prop_assert_eq!(at, start + parsed.line.len() as u64);
    }
    prop_assert!([&b""[..], b"\n", b"\r\n", b"\r"].contains(&&source[at as usize..]));
    Ok(tokens)
}

fn source() -> impl Strategy<Value = Vec<u8>> {
    let ended = (
        line(),
        prop::sample::select(vec!["\n", "\r\n", "\r", "\n\n"]),
    )
        .prop_map(|(line, end)| line + end);
    (prop::collection::vec(ended, 0..12), line())
        .prop_map(|(lines, last)| (lines.concat() + &last).into_bytes())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn pieces_tile_a_program(source in source(), capacity in 1usize..50) {
        let tokens = tiled(&source, &source[..])?;
        prop_assert_eq!(tiled(&source, BufReader::with_capacity(capacity, &source[..]))?, tokens);
    }

    #[test]
    fn pieces_tile_any_bytes(source in prop::collection::vec(prop_oneof![any::<u8>(), prop::sample::select(b"GX1.-[]#<>(); \r\n/%No=".to_vec())], 0..80)) {
        tiled(&source, &source[..])?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    #[test]
    fn where_the_input_is_split_does_not_matter(source in source()) {
        let limits = Limits { looped_blocks: 100, idle_blocks: 50, cycle_moves: 100, ..Limits::default() };
        let config = InterpreterConfig { limits, ..InterpreterConfig::default() };
        let mut whole = Program::new(&source[..], config.clone());
        let expected: Vec<_> = whole.by_ref().collect();
        let tokens = tiled(&source, &source[..])?;
        let diagnostics = whole.finish();
        for at in 0..=source.len() {
            let (head, tail) = source.split_at(at);
            prop_assert_eq!(&tiled(&source, head.chain(tail))?, &tokens);
            let mut parts = Program::new(head.chain(tail), config.clone());
            prop_assert_eq!(&parts.by_ref().collect::<Vec<_>>(), &expected);
            prop_assert_eq!(&parts.finish(), &diagnostics);
        }
    }
}

#[test]
fn each_kind_of_piece_is_told() {
    let source = b"%\n/ n10 g1 x[1+2] #1=3 (a) ;b\no<up> call [1] [#2] (c)\nG1 (d\n";
    let kinds: Vec<_> = tiled(source, &source[..])
        .unwrap()
        .into_iter()
        .filter(|token| token.0 != TokenKind::Blank)
        .collect();
    use TokenKind as K;
    let expected = [
        (K::Percent, 0, 1),
        (K::Delete, 2, 1),
        (K::LineNumber, 4, 3),
        (K::Word(0), 8, 2),
        (K::Word(1), 11, 6),
        (K::Setting(0), 18, 4),
        (K::Comment, 23, 3),
        (K::Comment, 27, 2),
        (K::Flow, 30, 19),
        (K::Comment, 50, 3),
        (K::Word(0), 54, 2),
        (K::Unread, 57, 2),
    ];
    assert_eq!(kinds, expected);
}
