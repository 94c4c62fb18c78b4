//! Levels of O-words.

use lostmotion_gcode::syntax::{Block, Keyword, Label, Value};

/// What is open.
#[derive(Clone, Debug, Default)]
pub(super) struct Indent {
    open: Vec<(String, bool)>,
}

/// Deeper levels are not shown.
const DEEPEST: usize = 40;

impl Indent {
    /// The level of a line; what it opens counts for the next.
    pub(super) fn level(&mut self, block: &Block) -> usize {
        let Some((label, keyword)) = block.flow else {
            return self.shown();
        };
        let name = match label {
            Label::Name(text) => String::from_utf8_lossy(block.name(text)).into_owned(),
            Label::Number(Value::Number(number)) => format!("{number}"),
            Label::Number(Value::Ops(..)) => String::new(),
        };
        let ends_do = keyword == Keyword::While
            && self
                .open
                .last()
                .is_some_and(|(open, is_do)| *is_do && *open == name);
        match keyword {
            Keyword::EndSub | Keyword::EndIf | Keyword::EndWhile | Keyword::EndRepeat => {
                self.open.pop();
                self.shown()
            }
            Keyword::While if ends_do => {
                self.open.pop();
                self.shown()
            }
            Keyword::Else | Keyword::ElseIf => self.shown().saturating_sub(1),
            Keyword::Sub | Keyword::If | Keyword::While | Keyword::Do | Keyword::Repeat => {
                let level = self.shown();
                self.open.push((name, keyword == Keyword::Do));
                level
            }
            _ => self.shown(),
        }
    }

    fn shown(&self) -> usize {
        self.open.len().min(DEEPEST)
    }
}
