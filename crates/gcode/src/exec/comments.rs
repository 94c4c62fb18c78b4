//! Comments: plain ones, messages to the operator, and texts with values in them.

use super::Exec;
use crate::ops::{CanonicalOp, TextKind};
use crate::parameters::View;
use crate::syntax::evaluate::evaluate;
use crate::syntax::{Block, parse_block};

/// Prefixes of comments that do something, and whether values are filled in.
const ACTIVE: [(&str, TextKind, bool); 5] = [
    ("msg,", TextKind::Message, false),
    ("debug,", TextKind::Message, true),
    ("print,", TextKind::Print, true),
    ("log,", TextKind::Log, true),
    ("probeopen", TextKind::Log, false),
];

impl Exec<'_> {
    /// Carries a comment out.
    pub(crate) fn comment(&mut self, inside: &[u8]) {
        let text = String::from_utf8_lossy(inside).into_owned();
        let start = text.trim_start();
        for (prefix, kind, fill) in ACTIVE {
            if start
                .get(..prefix.len())
                .is_some_and(|head| head.eq_ignore_ascii_case(prefix))
            {
                let rest = start.get(prefix.len()..).unwrap_or_default();
                let text = if fill {
                    self.fill(rest)
                } else {
                    rest.to_owned()
                };
                self.emit(CanonicalOp::Text { kind, text });
                return;
            }
        }
        self.emit(CanonicalOp::Text {
            kind: TextKind::Comment,
            text,
        });
    }

    /// The text with every `#parameter` replaced by its value; what is no parameter stays as it is.
    fn fill(&mut self, text: &str) -> String {
        let mut filled = String::new();
        let mut rest = text;
        while let Some(at) = rest.find('#') {
            let (before, from) = rest.split_at(at);
            filled.push_str(before);
            let reference = reference(from);
            match self.value_of(reference) {
                Some(value) => filled.push_str(&format!("{value:.6}")),
                None => filled.push_str(reference),
            }
            rest = from.get(reference.len()..).unwrap_or_default();
        }
        filled + rest
    }

    fn value_of(&mut self, reference: &str) -> Option<f64> {
        let mut block = Block::default();
        parse_block(
            format!("X{reference}").as_bytes(),
            &mut block,
            &self.config.limits,
        )
        .ok()?;
        let value = block.words.first()?.value;
        let mut view = View {
            parameters: self.parameters,
            state: self.state,
        };
        let value = evaluate(&block, value, &mut view, &mut Vec::new()).ok()?;
        Some(value)
    }
}

/// The `#1` or `#<name>` at the start of a text.
fn reference(text: &str) -> &str {
    let end = match text.as_bytes() {
        [_, b'<', ..] => text.find('>').map_or(text.len(), |at| at + 1),
        bytes => {
            1 + bytes
                .iter()
                .skip(1)
                .take_while(|byte| byte.is_ascii_digit())
                .count()
        }
    };
    text.get(..end).unwrap_or(text)
}
