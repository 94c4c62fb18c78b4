//! A line as tokens that lie side by side: every byte belongs to exactly one.

use super::block::{Block, Text};
use super::parse;

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenKind {
    /// Blanks and tabs between other tokens.
    Blank,
    /// `%`.
    Percent,
    /// `/`.
    Delete,
    /// N with its number.
    LineNumber,
    /// An O-word with its keyword and arguments.
    Flow,
    /// The word of this index in [`Block::words`].
    Word(usize),
    /// The setting of this index in [`Block::settings`].
    Setting(usize),
    /// A comment with its parentheses or semicolon; what follows a percent sign, too.
    Comment,
    /// What a line with a fault has from the fault's item on.
    Unread,
}

/// A stretch of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// Where it is.
    pub text: Text,
}

/// The tokens of a line in its order.
#[derive(Clone, Debug)]
pub struct Tokens<'a> {
    line: &'a [u8],
    block: &'a Block,
    at: usize,
    words: usize,
    settings: usize,
    deleted: bool,
    percent: bool,
}

impl<'a> Tokens<'a> {
    /// Tokens of a line and the block that it was parsed to.
    pub fn new(line: &'a [u8], block: &'a Block) -> Tokens<'a> {
        Tokens {
            line,
            block,
            at: 0,
            words: 0,
            settings: 0,
            deleted: false,
            percent: false,
        }
    }

    /// The kind and length of the token that the rest of the line begins with.
    fn first(&mut self, rest: &[u8], first: u8) -> (TokenKind, usize) {
        let all = rest.len();
        let here = |text: Text| text.len > 0 && text.start as usize == self.at;
        let length = |text: Text| text.len as usize;
        // The first byte decides; words and settings are recognised by the places that the parser
        // has noted.
        match first {
            b' ' | b'\t' => (
                TokenKind::Blank,
                rest.iter()
                    .take_while(|byte| matches!(byte, b' ' | b'\t'))
                    .count(),
            ),
            b'(' | b';' if self.percent => (TokenKind::Comment, all),
            b'%' if self.block.percent && !self.percent => {
                self.percent = true;
                (TokenKind::Percent, 1)
            }
            b'/' if self.block.deletable && !self.deleted => {
                self.deleted = true;
                (TokenKind::Delete, 1)
            }
            b'(' => parse::parenthesis(rest).map_or((TokenKind::Unread, all), |(after, _)| {
                (TokenKind::Comment, all - after.len())
            }),
            b';' => parse::semicolon(rest).map_or((TokenKind::Unread, all), |(after, _)| {
                (TokenKind::Comment, all - after.len())
            }),
            _ if here(self.block.line_number_text) => {
                (TokenKind::LineNumber, length(self.block.line_number_text))
            }
            _ if here(self.block.flow_text) => (TokenKind::Flow, length(self.block.flow_text)),
            _ => {
                // Words and settings come in the order of the line, so that one index each is
                // enough.
                if let Some(word) = self
                    .block
                    .words
                    .get(self.words)
                    .filter(|word| here(word.text))
                {
                    self.words += 1;
                    return (TokenKind::Word(self.words - 1), length(word.text));
                }
                if let Some(setting) = self
                    .block
                    .settings
                    .get(self.settings)
                    .filter(|setting| here(setting.text))
                {
                    self.settings += 1;
                    return (TokenKind::Setting(self.settings - 1), length(setting.text));
                }
                (TokenKind::Unread, all)
            }
        }
    }
}

impl Iterator for Tokens<'_> {
    type Item = Token;

    fn next(&mut self) -> Option<Token> {
        let line = self.line;
        let rest = line.get(self.at..)?;
        let (kind, length) = self.first(rest, *rest.first()?);
        let text = Text {
            start: self.at as u32,
            len: length as u32,
        };
        self.at += length;
        Some(Token { kind, text })
    }
}
