//! What a refused block says all the same, so that one mistake gives one message: the words around a
//! fault are kept, and what follows from the missing ones is not told.

use super::Interpreter;
use crate::codes::{self, AxisUse, Code, Group};
use crate::exec::words::check;
use crate::ops::SourcedOp;
use crate::parameters::View;
use crate::problem::Problem;
use crate::syntax::evaluate::{evaluate, valued};
use crate::syntax::parse::words_behind;
use crate::syntax::typo::{is_utf16, look_alike, symbol};
use crate::syntax::{Block, Fault, Keyword, Target, Text, Value, parse_block};
use lostmotion_base::names::nearest;

/// How far a block has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Its words are being read.
    Read,
    /// Its parameters are set.
    Set,
    /// Its codes are being carried out.
    Run,
}

/// The part of a line that has the fault.
#[derive(Clone, Copy, Debug, Default)]
struct Faulty {
    /// Its first byte.
    start: usize,
    /// Its letter, upper case; `None` if it has none.
    letter: Option<u8>,
    /// Index of the word that is read, but goes on with something wrong (`X1O`).
    word: Option<usize>,
}

impl Interpreter {
    /// The problem of a line that cannot be parsed, and its place.
    #[cold]
    pub(super) fn fault_found(&mut self, fault: Fault) -> (Problem, Option<Text>) {
        // Faults count from the line's end, places from its start.
        let at = self.line.len() - fault.rest.min(self.line.len());
        self.fault = Some(at);
        // What stands before the fault, whatever other dialects have made of the line.
        let _ = parse_block(&self.line, &mut self.block, &self.config.limits);
        let here = |len: usize| {
            Some(Text {
                start: at as u32,
                len: len as u32,
            })
        };
        // Files that are no text of this language: one message instead of one for each line.
        if self.place.start == 0 && is_utf16(&self.line) {
            self.state.ended = true;
            return (Problem::Utf16, None);
        }
        let of_other_control = matches!(
            *fault.problem,
            Problem::Siemens { .. } | Problem::Heidenhain | Problem::Checksum { .. }
        );
        if !of_other_control
            && let Some((problem, text)) = look_alike(&self.line, at, &self.config.limits)
        {
            return (problem, Some(text));
        }
        if matches!(*fault.problem, Problem::BadCharacter { .. })
            && let Some(symbol) = symbol(&self.line, at)
        {
            return (Problem::BadSymbol { symbol }, here(symbol.len_utf8()));
        }
        (*fault.problem, here(usize::from(fault.rest > 0)))
    }

    /// Whether a problem only follows from a setting that was refused.
    pub(super) fn follows(&self, problem: &Problem) -> bool {
        let name = match problem {
            Problem::UnknownParameter { name, .. } => format!("#<{name}>"),
            Problem::UnsetParameter { number } => format!("#{number}"),
            _ => return false,
        };
        self.refused_settings.contains(&name)
    }

    /// The problem with the known name that is nearest to one that is not known.
    pub(super) fn with_near_name(&self, problem: Problem) -> Problem {
        match problem {
            Problem::UnknownParameter { name, near: None } => {
                let known = self.parameters.visible_names();
                let known = known.filter_map(|name| std::str::from_utf8(name).ok());
                let near = nearest(&name, known).map(str::to_owned);
                Problem::UnknownParameter { name, near }
            }
            Problem::NoSuchSub { name, near: None } => {
                let known = self.flow.subs.keys().map(String::as_str);
                let near = nearest(&name, known).map(str::to_owned);
                Problem::NoSuchSub { name, near }
            }
            other => other,
        }
    }

    /// Carries out what a refused block says all the same: its modes, F, S and T, where its motion
    /// leads. Nothing of that is told, and nothing moves.
    #[cold]
    pub(super) fn salvage(&mut self, out: &mut Vec<SourcedOp>) {
        if self.state.ended || self.block.percent {
            return;
        }
        if let Some((label, keyword)) = self.block.flow {
            // A branch or loop whose line has a fault is still open or closed by it.
            let calls = matches!(keyword, Keyword::Call | Keyword::Goto | Keyword::Then);
            if self.fault.is_some() && !calls {
                let _ = self.flow_line(label, keyword, out);
            }
            return;
        }
        // What the block warned of before its error belongs to it.
        self.warn();
        let is_plain = self.profile.is_none()
            && self.modal_macro.is_none()
            && !self.config.dialect.is_printer();
        // A block that failed while it was carried out has gone on by itself.
        if self.stage == Stage::Run || !is_plain {
            return self.keep_motion_mode();
        }
        let faulty = self.faulty_part();
        if self.stage == Stage::Read {
            self.salvage_settings();
        }
        let refused = self.salvage_words(faulty);
        let _ = check(&mut self.words, &self.state);
        self.exec(out).salvage(&refused);
        self.warnings.clear();
        (self.parameters.unset_read, self.parameters.vacant_read) = (None, false);
        self.jump = None;
    }

    /// Takes the motion mode from a refused block, so that the blocks after it are judged as they
    /// were meant.
    fn keep_motion_mode(&mut self) {
        for word in self.block.words.iter().filter(|word| word.letter == b'G') {
            // Only literal codes can be told without evaluating anything.
            let Value::Number(number) = word.value else {
                continue;
            };
            let Some(code) = Code::of('G', number) else {
                continue;
            };
            match codes::find(code) {
                Some(row) if row.group == Group::Motion && row.axes != AxisUse::None => {
                    self.state.motion = Some(code);
                    self.state.motion_unknown = false;
                }
                // An unknown code may have been a motion mode: later axis words are not blamed.
                None => self.state.motion_unknown = true,
                _ => {}
            }
        }
    }

    /// Finds the part of the line that has the fault.
    fn faulty_part(&self) -> Option<Faulty> {
        let at = self.fault?;
        let end = |text: Text| (text.start + text.len) as usize;
        let block = &self.block;
        let ends = block.words.iter().map(|word| word.text);
        let ends = ends.chain(block.settings.iter().map(|setting| setting.text));
        let last = ends
            .chain([block.line_number_text])
            .map(end)
            .filter(|end| *end <= at)
            .max()
            .unwrap_or(0);
        let byte = self.line.get(at).copied();
        // What touches a number and begins no word goes on with that number.
        let goes_on = byte.is_some_and(|byte| {
            !matches!(byte, b' ' | b'\t' | b'(' | b';')
                && (!byte.is_ascii_alphabetic() || matches!(byte, b'o' | b'O'))
        });
        let word = block
            .words
            .iter()
            .rposition(|word| goes_on && end(word.text) == at);
        if let Some((index, word)) = word.and_then(|index| Some((index, block.words.get(index)?))) {
            return Some(Faulty {
                start: word.text.start as usize,
                letter: Some(word.letter),
                word: Some(index),
            });
        }
        let blanks = self.line.get(last..at).unwrap_or_default();
        let start = last
            + blanks
                .iter()
                .take_while(|byte| byte.is_ascii_whitespace())
                .count();
        let first = self.line.get(start).copied();
        Some(Faulty {
            start,
            letter: first
                .filter(|byte| byte.is_ascii_alphabetic() || *byte == b'#')
                .map(|byte| byte.to_ascii_uppercase()),
            word: None,
        })
    }

    /// Sets the parameters whose values are right, and notes the others.
    fn salvage_settings(&mut self) {
        for index in 0..self.block.settings.len() {
            let Some(&setting) = self.block.settings.get(index) else {
                break;
            };
            let value = self.setting_value(setting);
            let result = match (value, setting.target) {
                (Ok((number, value)), Target::Numbered(_)) => self.parameters.set(number, value),
                (Ok((_, value)), Target::Named(name)) => {
                    self.parameters
                        .set_name(self.block.name(name), valued(value), &self.state)
                }
                (Err(problem), _) => Err(problem),
            };
            if result.is_err() {
                self.note_refused(setting.text.start as usize);
            }
        }
        // The setting that cannot be parsed, or that goes on with something wrong.
        let at = self.fault.unwrap_or_default();
        let touching = self.block.settings.iter().find(|setting| {
            self.fault.is_some() && (setting.text.start + setting.text.len) as usize == at
        });
        let start = touching.map(|setting| setting.text.start as usize);
        let unread = self
            .faulty_part()
            .filter(|faulty| faulty.letter == Some(b'#'))
            .map(|faulty| faulty.start);
        for start in [start, unread].into_iter().flatten() {
            self.note_refused(start);
        }
    }

    /// Notes that the parameter whose setting begins at a byte of the line was not set.
    fn note_refused(&mut self, start: usize) {
        let text = self.line.get(start..).unwrap_or_default();
        let name: Vec<u8> = text
            .iter()
            .take_while(|byte| **byte != b'=')
            .filter(|byte| !matches!(byte, b' ' | b'\t'))
            .map(u8::to_ascii_lowercase)
            .collect();
        // A program of nothing but faults must not fill memory.
        if self.refused_settings.len() < self.config.limits.named_parameters {
            self.refused_settings
                .insert(String::from_utf8_lossy(&name).into_owned());
        }
    }

    /// Collects the words that are right; gives the letters of those that are not.
    fn salvage_words(&mut self, faulty: Option<Faulty>) -> Vec<u8> {
        let mut refused: Vec<u8> = Vec::new();
        self.words.clear();
        for index in 0..self.block.words.len() {
            let Some(&word) = self.block.words.get(index) else {
                break;
            };
            let value = self.value_or_vacant(word.value);
            let is_refused = faulty.is_some_and(|faulty| faulty.word == Some(index));
            match value {
                Ok(value) if value.is_nan() => {}
                Ok(value)
                    if !is_refused && self.words.add(word.letter, value, word.text).is_ok() => {}
                _ => refused.push(word.letter),
            }
        }
        let Some(faulty) = faulty else {
            return refused;
        };
        match faulty.letter {
            Some(letter) => refused.push(letter),
            // Which word was meant cannot be told.
            None => refused.extend(b"XYZ"),
        }
        // Words behind the fault.
        let (mut behind, at) = (Block::default(), self.fault.unwrap_or_default());
        words_behind(
            &self.line,
            faulty.start,
            at,
            &mut behind,
            &self.config.limits,
        );
        for word in &behind.words {
            let mut view = View {
                parameters: &mut self.parameters,
                state: &self.state,
                tools: self.tools.as_ref(),
                config: &self.config,
            };
            let value = evaluate(&behind, word.value, &mut view, &mut self.stack);
            let added =
                value.and_then(|value| self.words.add(word.letter, valued(value), word.text));
            if added.is_err() {
                refused.push(word.letter);
            }
        }
        refused
    }
}
