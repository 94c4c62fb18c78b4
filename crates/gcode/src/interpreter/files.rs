//! Subroutines from files.

use super::Interpreter;
use super::tape::{Place, Tape};
use crate::code::whole;
use crate::problem::Problem;
use crate::source::{LineKind, Lines};
use crate::syntax::{Block, Keyword, Label, Value, parse_block};
use std::sync::Arc;

/// Most files that one program may load.
const MOST_FILES: usize = 10_000;

impl Interpreter {
    /// Asks the loader for a subroutine; true if it is defined now.
    pub(crate) fn load_sub(&mut self, name: &str) -> Result<bool, Problem> {
        let Some(loader) = self.loader.clone() else {
            return Ok(false);
        };
        if self.diagnostics.files().len() >= MOST_FILES {
            return Err(Problem::TooManyFiles { limit: MOST_FILES });
        }
        let failed = |message| Problem::SubFile {
            name: name.to_owned(),
            message,
        };
        let Some(file) = loader.load(name).map_err(failed)? else {
            return Ok(false);
        };
        let limit = self.config.limits.held_bytes;
        self.loaded_bytes = self.loaded_bytes.saturating_add(file.text.len());
        if self.loaded_bytes > limit {
            return Err(Problem::TooMuchHeld { limit });
        }
        let file = Arc::new(file);
        self.diagnostics
            .provenance_mut()
            .add_file(Arc::clone(&file));
        self.define_from(&file.text, name)?;
        if self.flow.subs.contains_key(name) {
            Ok(true)
        } else {
            Err(failed(format!("it does not define o<{name}>")))
        }
    }

    /// Takes the definitions out of a file; a file without any is a subroutine of its own that ends
    /// with M99.
    fn define_from(&mut self, text: &[u8], wanted: &str) -> Result<(), Problem> {
        let file = self.diagnostics.files().len() as u32;
        let limits = &self.config.limits;
        let mut lines = Lines::new(text, limits.line_bytes);
        let mut block = Block::default();
        let (mut whole_file, mut open, mut defined) =
            (Tape::default(), None::<(String, Tape)>, false);
        while let Ok(Some((kind, line, start))) = lines.next() {
            if let LineKind::TooLong(bytes) = kind {
                return Err(Problem::LineTooLong {
                    bytes,
                    limit: limits.line_bytes,
                });
            }
            let place = Place { file, line, start };
            whole_file.push(lines.line(), place, limits.held_bytes)?;
            let flow = parse_block(lines.line(), &mut block, limits)
                .ok()
                .and(block.flow);
            let name = |label: Label| match label {
                Label::Name(text) => Some(String::from_utf8_lossy(block.name(text)).into_owned()),
                Label::Number(Value::Number(number)) => {
                    whole(number).map(|number| format!("{number}"))
                }
                Label::Number(_) => None,
            };
            if let Some((_, body)) = &mut open {
                body.push(lines.line(), place, limits.held_bytes)?;
            }
            match flow {
                Some((label, Keyword::Sub)) if open.is_none() => {
                    open = name(label).map(|name| (name, Tape::default()))
                }
                Some((label, Keyword::EndSub))
                    if open.as_ref().map(|(open, _)| open) == name(label).as_ref() =>
                {
                    if let Some((name, body)) = open.take() {
                        defined = true;
                        self.flow.subs.entry(name).or_insert_with(|| Arc::new(body));
                    }
                }
                _ => {}
            }
        }
        if !defined {
            self.flow
                .subs
                .insert(wanted.to_owned(), Arc::new(whole_file));
        }
        Ok(())
    }
}
