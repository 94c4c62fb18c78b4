//! A line as pieces that lie side by side: every byte belongs to exactly one.

use super::block::{Block, Text};
use super::parse;

/// What a piece is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceKind {
    /// Blanks and tabs between other pieces.
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
pub struct Piece {
    /// What it is.
    pub kind: PieceKind,
    /// Where it is.
    pub text: Text,
}

/// The pieces of a line in its order.
#[derive(Clone, Debug)]
pub struct Pieces<'a> {
    line: &'a [u8],
    block: &'a Block,
    at: usize,
    words: usize,
    settings: usize,
    deleted: bool,
    percent: bool,
}

impl<'a> Pieces<'a> {
    /// Pieces of a line and the block that it was parsed to.
    pub fn new(line: &'a [u8], block: &'a Block) -> Pieces<'a> {
        Pieces {
            line,
            block,
            at: 0,
            words: 0,
            settings: 0,
            deleted: false,
            percent: false,
        }
    }

    /// The kind and length of the piece that the rest of the line begins with.
    fn first(&mut self, rest: &[u8], first: u8) -> (PieceKind, usize) {
        let all = rest.len();
        let here = |text: Text| text.len > 0 && text.start as usize == self.at;
        let length = |text: Text| text.len as usize;
        match first {
            b' ' | b'\t' => (
                PieceKind::Blank,
                rest.iter()
                    .take_while(|byte| matches!(byte, b' ' | b'\t'))
                    .count(),
            ),
            b'(' | b';' if self.percent => (PieceKind::Comment, all),
            b'%' if self.block.percent && !self.percent => {
                self.percent = true;
                (PieceKind::Percent, 1)
            }
            b'/' if self.block.deletable && !self.deleted => {
                self.deleted = true;
                (PieceKind::Delete, 1)
            }
            b'(' => parse::parenthesis(rest).map_or((PieceKind::Unread, all), |(after, _)| {
                (PieceKind::Comment, all - after.len())
            }),
            b';' => parse::semicolon(rest).map_or((PieceKind::Unread, all), |(after, _)| {
                (PieceKind::Comment, all - after.len())
            }),
            _ if here(self.block.line_number_text) => {
                (PieceKind::LineNumber, length(self.block.line_number_text))
            }
            _ if here(self.block.flow_text) => (PieceKind::Flow, length(self.block.flow_text)),
            _ => {
                if let Some(word) = self
                    .block
                    .words
                    .get(self.words)
                    .filter(|word| here(word.text))
                {
                    self.words += 1;
                    return (PieceKind::Word(self.words - 1), length(word.text));
                }
                if let Some(setting) = self
                    .block
                    .settings
                    .get(self.settings)
                    .filter(|setting| here(setting.text))
                {
                    self.settings += 1;
                    return (PieceKind::Setting(self.settings - 1), length(setting.text));
                }
                (PieceKind::Unread, all)
            }
        }
    }
}

impl Iterator for Pieces<'_> {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        let line = self.line;
        let rest = line.get(self.at..)?;
        let (kind, length) = self.first(rest, *rest.first()?);
        let text = Text {
            start: self.at as u32,
            len: length as u32,
        };
        self.at += length;
        Some(Piece { kind, text })
    }
}
