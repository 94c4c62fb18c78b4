//! Subroutines: definition, call, return.

use super::Interpreter;
use super::control::flow_error;
use super::flow::{CallFrame, Definition, Record, Seek, Tape};
use crate::codes::{Code, whole};
use crate::exec::Jump;
use crate::ops::SourcedOp;
use crate::problem::Problem;
use crate::source::{LineKind, Lines, Place};
use crate::state::Saved;
use crate::syntax::{Block, Keyword, Label, Value, parse_block};
use std::sync::Arc;

const M98: Code = Code::m(980);

impl Interpreter {
    /// A subroutine line that is carried out.
    pub(crate) fn subroutine(&mut self, label: String, keyword: Keyword) -> Result<(), Problem> {
        match keyword {
            Keyword::Bare if self.flow.seek.is_none() => {
                let called = self.flow.frames.last();
                // As in LinuxCNC, the program runs on through a label alone, which most often is its
                // own number.
                if called.is_some_and(|frame| frame.body.definition == Definition::Sub) {
                    Err(flow_error(format!(
                        "o{label} stands inside a subroutine that was called by `call`; only M98 \
                            runs through it"
                    )))
                } else {
                    if self.begun && called.is_none() {
                        self.report(Problem::RunsIntoSub { name: label });
                    }
                    Ok(())
                }
            }
            Keyword::Sub | Keyword::Bare => {
                // Definitions do not nest: the name would depend on whether the outer one has run.
                if !self.flow.frames.is_empty() && self.flow.seek.is_none() {
                    return Err(flow_error(format!(
                        "o{label} is defined inside another subroutine"
                    )));
                }
                self.flow.record = Some(Record {
                    name: label,
                    bare: keyword == Keyword::Bare,
                    body: Tape::default(),
                    span: self.span,
                });
                Ok(())
            }
            Keyword::Call => {
                // Arguments are evaluated in the caller's scope, before its locals are put away.
                let mut arguments = Vec::new();
                for index in 0..self.block.arguments.len() {
                    arguments.push(self.argument(index)?.unwrap_or_default());
                }
                self.check_definition(&label, false)?;
                self.call(label, Some(&arguments), 1)
            }
            // The label of a return is often that of the branch it stands in.
            Keyword::EndSub | Keyword::Return => match self.flow.frames.last() {
                Some(frame) if frame.name == label || keyword == Keyword::Return => {
                    let value = self.argument(0)?;
                    self.set_value(value);
                    self.leave();
                    Ok(())
                }
                Some(frame) => Err(flow_error(format!(
                    "o{label} cannot end o{}, which is running",
                    frame.name
                ))),
                None => Err(flow_error(format!(
                    "o{label} returns, but no subroutine is running"
                ))),
            },
            _ => Ok(()),
        }
    }

    fn set_value(&mut self, value: Option<f64>) {
        self.parameters
            .put_global(b"_value_returned", if value.is_some() { 1.0 } else { 0.0 });
        self.parameters
            .put_global(b"_value", value.unwrap_or_default());
    }

    /// Refuses to call a subroutine in the other style, as LinuxCNC does: `sub` by M98, whose
    /// `endsub` would not end it, or a label by `call`.
    fn check_definition(&self, name: &str, by_m98: bool) -> Result<(), Problem> {
        let definition = self.flow.subs.get(name).map(|body| body.definition);
        match definition {
            Some(Definition::Sub) if by_m98 => Err(flow_error(format!(
                "o{name} is defined by `o{name} sub`: M98 cannot call it, `o{name} call` does"
            ))),
            Some(Definition::Label) if !by_m98 => Err(flow_error(format!(
                "o{name} begins with a label alone: `call` cannot call it, M98 P{name} does"
            ))),
            _ => Ok(()),
        }
    }

    /// Calls a subroutine; without arguments it shares the caller's numbered locals. Looks further on if
    /// it is not defined yet.
    pub(crate) fn call(
        &mut self,
        name: String,
        arguments: Option<&[f64]>,
        rounds: u64,
    ) -> Result<(), Problem> {
        let Some(body) = self.flow.subs.get(&name).cloned() else {
            return self.look_for(name);
        };
        // Recursion is bounded: each level keeps the locals of its caller.
        let limit = self.config.limits.call_depth;
        if self.flow.frames.len() >= limit {
            return Err(Problem::CallsTooDeep { limit });
        }
        // M98 L0: the call is passed over.
        if rounds == 0 {
            return Ok(());
        }
        // The caller's numbered locals, open branches and place are kept in the frame.
        let locals = arguments.map(|arguments| Box::new(self.parameters.enter(arguments)));
        let frame = CallFrame {
            name,
            body,
            return_to: self.flow.at,
            opens: self.flow.opens.len(),
            locals,
            caller: self.stack_index,
            by_m_code: false,
            rounds: rounds - 1,
        };
        // The chain of calls is kept for the places of findings.
        self.stack_index = self.diagnostics.provenance_mut().call_stacks_mut().enter(
            &frame.name,
            self.span,
            self.stack_index,
        );
        self.saved.push(Saved::default());
        self.flow.frames.push(frame);
        self.flow.at = 0;
        Ok(())
    }

    /// The subroutine of an M98 on the line, if it is not known yet.
    pub(crate) fn wanted_sub(&self) -> Option<String> {
        let is_call = self.words.codes().iter().any(|used| used.row.code == M98);
        let number = if is_call {
            self.words.get(b'P').and_then(whole)
        } else {
            None
        };
        number
            .map(|number| format!("{number}"))
            .filter(|name| !self.flow.subs.contains_key(name))
    }

    /// Carries out what M98 or M99 asked for.
    pub(crate) fn jump(&mut self, out: &mut Vec<SourcedOp>) -> Result<(), Problem> {
        match self.jump.take() {
            Some(Jump::Call { name, rounds }) => {
                self.check_definition(&name, true)?;
                self.call(name, None, rounds)
            }
            Some(Jump::Profile(turning)) => self.begin_profile(*turning),
            Some(Jump::Return) if self.flow.frames.is_empty() => {
                self.report(Problem::EndlessMain);
                self.exec(out).end_program()
            }
            Some(Jump::Return) => {
                self.leave();
                Ok(())
            }
            Some(Jump::ReturnTo { line }) => {
                // M99 P leaves the subroutine for good, whatever rounds were left.
                if let Some(frame) = self.flow.frames.last_mut() {
                    frame.rounds = 0;
                    self.leave();
                }
                self.goto(line)
            }
            None => Ok(()),
        }
    }

    /// Reads on until the subroutine is defined, then comes back to the line that calls it.
    pub(crate) fn look_for(&mut self, name: String) -> Result<(), Problem> {
        // The whole program has been searched without success: the loader is the last resort.
        if self.missing_sub.as_ref() == Some(&name) {
            self.missing_sub = None;
            if self.load_sub(&name)? {
                self.flow.at -= 1;
                return Ok(());
            }
            return Err(Problem::NoSuchSub { name, near: None });
        }
        // Step back to the calling line, which runs again once the definition has been found.
        self.flow.at -= 1;
        let after = self
            .flow
            .frames
            .first()
            .map_or(self.flow.at + 1, |frame| frame.return_to);
        // A local subroutine may stand before its call.
        let at = if self.flow.keeps { 0 } else { after };
        self.flow.seek = Some(Seek { name, at });
        Ok(())
    }

    /// Goes back to the caller, or through the subroutine once more.
    pub(crate) fn leave(&mut self) {
        if let Some(frame) = self.flow.frames.last_mut() {
            let base = frame.opens;
            // L of M98: once more from the first line of the body.
            if frame.rounds > 0 {
                frame.rounds -= 1;
                self.flow.at = 0;
            } else if let Some(frame) = self.flow.frames.pop() {
                if let Some(locals) = &frame.locals {
                    self.parameters.leave(locals);
                }
                self.flow.at = frame.return_to;
                self.stack_index = frame.caller;
                self.leave_level();
            }
            // Branches and loops that the return leaves are closed.
            self.flow.opens.truncate(base);
        }
    }

    /// Adds the current line to the definition being recorded; true while there is one.
    pub(crate) fn recording(
        &mut self,
        flow: Option<(&str, Keyword)>,
        ends_bare: bool,
    ) -> Result<bool, Problem> {
        let Some(record) = &mut self.flow.record else {
            return Ok(false);
        };
        // The bodies of all subroutines share one bound of memory.
        let limit = self.config.limits.held_bytes;
        if record
            .body
            .push(&self.line, self.place, limit.saturating_sub(self.flow.held))
            .is_err()
        {
            self.flow.record = None;
            return Err(Problem::TooMuchHeld { limit });
        }
        let name = &record.name;
        // A bare label ends with M99, `sub` with the `endsub` of its own name.
        let ends = if record.bare {
            ends_bare
        } else {
            flow.is_some_and(|(label, keyword)| keyword == Keyword::EndSub && label == name)
        };
        if let Some((_, Keyword::Sub)) = flow {
            let message = format!(
                "subroutine o{name} of line {} is not closed before another begins",
                record.span.line
            );
            self.flow.record = None;
            return Err(flow_error(message));
        }
        if let Some(mut record) = self.flow.record.take_if(|_| ends) {
            record.body.definition = if record.bare {
                Definition::Label
            } else {
                Definition::Sub
            };
            if self
                .flow
                .seek
                .as_ref()
                .is_some_and(|seek| seek.name == record.name)
            {
                self.flow.seek = None;
            }
            self.flow.keep(record.name, record.body);
        }
        Ok(true)
    }
}

/// Most files that one program may load.
const MOST_FILES: usize = 10_000;

impl Interpreter {
    /// Asks the loader for a subroutine; true if it is defined now.
    pub(crate) fn load_sub(&mut self, name: &str) -> Result<bool, Problem> {
        let Some(loader) = self.loader.clone() else {
            return Ok(false);
        };
        // A computed name could ask for a new file each round.
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
        // Files count towards the same bound as the lines that are held.
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
            // Kept in case the file turns out to have no definition of its own.
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
            // Lines between `sub` and `endsub` are the body, the closing line with them.
            if let Some((_, body)) = &mut open {
                body.push(lines.line(), place, limits.held_bytes)?;
            }
            match flow {
                Some((label, Keyword::Sub)) if open.is_none() => {
                    open = name(label).map(|name| (name, Tape::default()));
                }
                Some((label, Keyword::EndSub))
                    if open.as_ref().map(|(open, _)| open) == name(label).as_ref() =>
                {
                    if let Some((name, mut body)) = open.take() {
                        defined = true;
                        body.definition = Definition::Sub;
                        self.flow.subs.entry(name).or_insert_with(|| Arc::new(body));
                    }
                }
                _ => {}
            }
        }
        // M98 of other controls: the file itself is the subroutine.
        if !defined {
            self.flow
                .subs
                .insert(wanted.to_owned(), Arc::new(whole_file));
        }
        Ok(())
    }
}
