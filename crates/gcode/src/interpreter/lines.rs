//! One step: fetch a line, parse it, carry it out.

use super::flow::{Record, Tape};
use super::salvage::Stage;
use super::{Interpreter, Percent, Step};
use crate::codes::whole;
use crate::ops::SourcedOp;
use crate::problem::Problem;
use crate::syntax::{Block, Keyword, Label, Text, parse_block};
use lostmotion_base::span::Span;

impl Interpreter {
    /// Carries the next block out, appending its operations to `out`.
    pub fn step(&mut self, out: &mut Vec<SourcedOp>) -> Step {
        if self.state.ended {
            return Step::Ended;
        }
        if !self.fetch() {
            return if self.at_end {
                self.finish(out)
            } else {
                Step::NeedsLine
            };
        }
        let before = out.len();
        self.executed += 1;
        // Parse and carry out; a refused block leaves its motion mode to those that follow.
        (self.stage, self.fault) = (Stage::Read, None);
        if let Err((problem, text)) = self.line_step(out) {
            self.place_and_report(problem, text);
            self.salvage(out);
            self.spoil_profile();
        }
        if self.config.dialect.is_fanuc() && !self.is_passing() {
            self.note_line_number();
        }
        // A block may end the profile of a turning cycle, or a subroutine whose modes come back.
        if self.profile.is_some() {
            self.end_profile(out);
        }
        if self.returning.is_some()
            && let Err(problem) = self.restore_left(out)
        {
            self.report(problem);
        }
        if self.state.ended {
            self.release_held(out);
        }
        // Endless loops end here.
        self.watch(out.get(before..).unwrap_or_default());
        if self.state.ended {
            self.settle_habits();
            return Step::Ended;
        }
        Step::Ran
    }

    /// Brings the next line into `self.line`.
    fn fetch(&mut self) -> bool {
        // A search reads the main program without moving its own place.
        let found = match &self.flow.seek {
            Some(seek) => self.flow.main.get(seek.at),
            None => self.flow.tape().get(self.flow.at),
        };
        let Some((place, line)) = found else {
            return false;
        };
        self.line.clear();
        self.line.extend_from_slice(line);
        self.place = place;
        self.span = block_span(line, place);
        match &mut self.flow.seek {
            Some(seek) => seek.at += 1,
            None => self.flow.at += 1,
        }
        true
    }

    pub(crate) fn place_and_report(&mut self, problem: Problem, text: Option<Text>) {
        // A name whose setting was refused has been told there.
        if self.follows(&problem) {
            return;
        }
        let problem = self.with_near_name(problem);
        self.report_at(
            problem,
            text.map_or(self.span, |text| self.place.span(text)),
        );
    }

    /// Whether the line is the one that a local subroutine (M97) begins with.
    fn seeks_line(&self) -> bool {
        let Some(seek) = self
            .flow
            .seek
            .as_ref()
            .filter(|_| self.flow.record.is_none())
        else {
            return false;
        };
        // Local subroutines are named `n` and their line number.
        let wanted = seek
            .name
            .strip_prefix('n')
            .and_then(|number| number.parse::<f64>().ok());
        wanted.is_some() && wanted == self.block.line_number
    }

    /// Whether the current line is looked at only for O-words.
    pub(crate) fn is_passing(&self) -> bool {
        self.flow.skip.is_some() || self.flow.seek.is_some() || self.flow.record.is_some()
    }

    fn line_step(&mut self, out: &mut Vec<SourcedOp>) -> Result<(), (Problem, Option<Text>)> {
        // Lines that are passed over need no parsing unless they could hold an O-word.
        if self.is_passing() && !self.flow.keeps && !may_matter(&self.line) {
            self.recording(None, false)
                .map_err(|problem| (problem, None))?;
            return Ok(());
        }
        if self.passes_goto() {
            return Ok(());
        }
        // The grammar first; then what other dialects write differently.
        self.state.line = self.place.line;
        let parsed = parse_block(&self.line, &mut self.block, &self.config.limits)
            .or_else(|fault| self.parse_specially(fault));
        if let Err(fault) = parsed {
            if self.is_passing() {
                return self
                    .recording(None, false)
                    .map(|_| ())
                    .map_err(|problem| (problem, None));
            }
            return Err(self.fault_found(fault));
        }
        if self.block.percent {
            return self.percent_line().map_err(|problem| (problem, None));
        }
        // A `%` after this comes too late to enclose the program.
        if self.percent == Percent::Unknown && !self.block.is_blank() {
            self.percent = Percent::Absent;
        }
        if self.block.deletable && self.config.skips(self.block.skip_number) {
            return Ok(());
        }
        if self.config.dialect.is_fanuc() && !self.block.ops.is_empty() {
            self.note_program();
        }
        match self.block.flow {
            Some((label, keyword)) => self.flow_line(label, keyword, out),
            // The N number that M97 named: recorded from here to its M99.
            None if self.seeks_line() => {
                let name = self
                    .flow
                    .seek
                    .as_ref()
                    .map(|seek| seek.name.clone())
                    .unwrap_or_default();
                self.flow.record = Some(Record {
                    name,
                    bare: true,
                    body: Tape::default(),
                    span: self.span,
                });
                let ends_bare = has_code(&self.block, b'M', 99.0);
                self.recording(None, ends_bare)
                    .map(|_| ())
                    .map_err(|problem| (problem, None))
            }
            None if self.is_passing() => {
                let ends_bare = has_code(&self.block, b'M', 99.0);
                self.recording(None, ends_bare)
                    .map(|_| ())
                    .map_err(|problem| (problem, None))
            }
            None => self.plain_line(out),
        }
    }

    fn percent_line(&mut self) -> Result<(), Problem> {
        match self.percent {
            Percent::Unknown => {
                self.percent = Percent::Open;
                self.opened = self.place.line;
            }
            // The search for a subroutine goes through the program from its first line.
            Percent::Open if self.flow.seek.is_some() && self.flow.frames.is_empty() => {
                self.at_end |= self.place.line != self.opened;
            }
            Percent::Open if self.flow.frames.is_empty() => {
                self.check_open();
                self.state.ended = true;
            }
            Percent::Open => {}
            Percent::Absent => {
                // What follows is read as if the sign had come first.
                self.percent = Percent::Open;
                return Err(Problem::TextBeforePercent);
            }
        }
        Ok(())
    }

    pub(super) fn flow_line(
        &mut self,
        label: Label,
        keyword: Keyword,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), (Problem, Option<Text>)> {
        let unplaced = |problem| (problem, None);
        // While lines are passed over, parameters of a label need not have values yet.
        let label = match self.label(label) {
            Err(_) if self.is_passing() => String::new(),
            label => label.map_err(unplaced)?,
        };
        if self.flow.skip.is_some() {
            return self.while_skipping(&label, keyword).map_err(unplaced);
        }
        if self
            .recording(Some((&label, keyword)), false)
            .map_err(unplaced)?
        {
            return Ok(());
        }
        // While a subroutine is looked for, only definitions count.
        if let Some(seek) = &self.flow.seek {
            let wanted = seek.name == label || keyword == Keyword::Sub;
            return if wanted && matches!(keyword, Keyword::Sub | Keyword::Bare) {
                self.subroutine(label, keyword).map_err(unplaced)
            } else {
                Ok(())
            };
        }
        if keyword == Keyword::Bare && !self.begun {
            self.program_number = label.parse().unwrap_or(0.0);
        }
        // Comments of O-lines are carried out like those of other lines.
        self.run_comment(out)?;
        let result = match keyword {
            Keyword::Goto | Keyword::Then => self.macro_flow(&label, keyword, out),
            Keyword::Sub | Keyword::EndSub | Keyword::Call | Keyword::Return | Keyword::Bare => {
                self.subroutine(label, keyword)
            }
            _ => self.control(label, keyword),
        };
        result.map_err(unplaced)
    }

    /// The name of a label; numbers are evaluated.
    fn label(&mut self, label: Label) -> Result<String, Problem> {
        match label {
            Label::Name(text) => Ok(String::from_utf8_lossy(self.block.name(text)).into_owned()),
            Label::Number(value) => {
                let value = self.value(value)?;
                whole(value)
                    .map(|number| format!("{number}"))
                    .ok_or(Problem::BadWordValue { letter: 'O', value })
            }
        }
    }
}

/// Whether a line can begin with an O-word or a percent sign, or hold an M99.
fn may_matter(line: &[u8]) -> bool {
    line.iter()
        .any(|byte| matches!(byte, b'o' | b'O' | b':' | b'%' | b'm' | b'M'))
}

fn has_code(block: &Block, letter: u8, number: f64) -> bool {
    block
        .words
        .iter()
        .any(|word| word.letter == letter && word.value == crate::syntax::Value::Number(number))
}

/// The block within its line: without the blanks around it.
fn block_span(line: &[u8], place: super::Place) -> Span {
    let trimmed = line.trim_ascii();
    let from = line.len() - line.trim_ascii_start().len();
    Span {
        file: place.file,
        line: place.line,
        column: from as u32 + 1,
        start: place.start + from as u64,
        len: trimmed.len() as u32,
    }
}
