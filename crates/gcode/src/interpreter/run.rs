//! Carrying out a line of words, settings and comments.

use super::Interpreter;
use super::dialects::{Line, builders_words};
use super::salvage::Stage;
use crate::dialect::Leniency;
use crate::exec::Exec;
use crate::exec::words::check;
use crate::ops::SourcedOp;
use crate::problem::Problem;
use crate::syntax::evaluate::valued;
use crate::syntax::{Op, Setting, Target, Text, Value};
use lostmotion_base::span::BlockRef;

impl Interpreter {
    /// The comment of the current block.
    pub(crate) fn run_comment(
        &mut self,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), (Problem, Option<Text>)> {
        let Some(text) = self.block.comment else {
            return Ok(());
        };
        let from = text.start as usize;
        // The line is lent out, because executing borrows the interpreter.
        let inside = std::mem::take(&mut self.line);
        let result = self.exec(out).comment(
            inside
                .get(from..from + text.len as usize)
                .unwrap_or_default(),
        );
        self.line = inside;
        result.map_err(|problem| (problem, Some(text)))
    }

    pub(crate) fn exec<'a>(&'a mut self, out: &'a mut Vec<SourcedOp>) -> Exec<'a> {
        Exec {
            state: &mut self.state,
            parameters: &mut self.parameters,
            config: &self.config,
            tools: &mut self.tools,
            jump: &mut self.jump,
            saved: &mut self.saved,
            words: &self.words,
            block: BlockRef {
                span: self.span,
                call_stack: self.stack_index,
            },
            out,
            warnings: &mut self.warnings,
        }
    }

    /// A line of words, settings and comments.
    pub(crate) fn plain_line(
        &mut self,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), (Problem, Option<Text>)> {
        self.begun |= !self.block.words.is_empty();
        self.note_habits();
        // The codes of the block before are not this one's.
        self.words.clear();
        // 1. The fast path: plain moves without anything special in force.
        if self.quick_move(out) {
            return Ok(());
        }
        if self.special && matches!(self.dialect_line(out)?, Line::Done) {
            return Ok(());
        }
        // 2. Evaluate the words and look up their codes.
        if let Some((name, index)) = self.foreign_macro() {
            return self
                .macro_by_m_code(name, index)
                .map_err(|problem| (problem, None));
        }
        let foreign = self.take_foreign_m_codes();
        let mut collected = self.collect_words();
        if self.words.has(b'E') && self.merge_exponents() {
            collected = self.collect_words();
        }
        collected?;
        if foreign {
            self.words.free = builders_words();
        }
        if self.special {
            self.special_words(out);
        }
        self.note_axes();
        // A subroutine that stands further on is looked for before anything is carried out, so that
        // the line runs once.
        if let Some(name) = self
            .wanted_sub()
            .or_else(|| self.wanted_macro())
            .or_else(|| self.wanted_foreign())
            .or_else(|| self.wanted_profile())
        {
            return self.look_for(name).map_err(|problem| (problem, None));
        }
        // 3. Parameters are set before any code is carried out.
        self.apply_settings(out)?;
        self.stage = Stage::Set;
        self.warn();
        if self.profile.is_some() {
            return self.profile_line();
        }
        self.run_comment(out)?;
        if self.words.mask == 0 && self.words.codes().is_empty() {
            return self.run_foreign(out).map_err(|problem| (problem, None));
        }
        // 4. Find the motion, and check that every word has a code that uses it.
        if let Err((problem, place)) = check(&mut self.words, &self.state) {
            if !self.reconcile(&problem) {
                return Err((problem, place));
            }
            check(&mut self.words, &self.state)?;
        }
        // 5. Carry the codes out by phase, then go where M98, M99 or a turning cycle sends the program.
        self.stage = Stage::Run;
        let result = self.exec(out).run();
        self.warn();
        result?;
        if self.config.dialect.is_fanuc() {
            self.note_modes();
        }
        if foreign {
            self.run_foreign(out).map_err(|problem| (problem, None))?;
        }
        self.jump(out).map_err(|problem| (problem, None))?;
        if self.modal_macro.is_some() {
            self.call_modal_macro().map_err(|problem| (problem, None))
        } else {
            Ok(())
        }
    }

    /// Words that other dialects mean otherwise.
    fn special_words(&mut self, out: &mut Vec<SourcedOp>) {
        if let Some(leniency) = self.words.taken.take() {
            self.tell(leniency);
        }
        self.unpack_call();
        if self.config.dialect.is_fanuc() {
            self.fanuc_words(out);
            self.fanuc_dwell();
        }
    }

    pub(crate) fn collect_words(&mut self) -> Result<(), (Problem, Option<Text>)> {
        self.words.clear();
        let mut first = Ok(());
        for index in 0..self.block.words.len() {
            let Some(&word) = self.block.words.get(index) else {
                break;
            };
            // A word with a vacant value is left out, as Macro B has it.
            let value = self.value_or_vacant(word.value);
            if value.as_ref().is_ok_and(|value| value.is_nan()) {
                continue;
            }
            let added = value
                .and_then(|value| self.words.add(word.letter, value, word.text))
                .map_err(|problem| self.control_cycle(problem));
            // All faults of a line are told; the last is returned, the others are reported here.
            first = match (first, added) {
                (Ok(()), Err(problem)) => Err((problem, Some(word.text))),
                (Err((earlier, place)), Err(problem)) => {
                    self.place_and_report(earlier, place);
                    Err((problem, Some(word.text)))
                }
                (first, _) => first,
            };
        }
        first
    }

    /// Settings take effect together, after everything on the line has been read.
    pub(crate) fn apply_settings(
        &mut self,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), (Problem, Option<Text>)> {
        if self.block.settings.is_empty() {
            return Ok(());
        }
        // First all values, then all settings: `#1=2 #2=#1` reads the old #1.
        let mut values = Vec::with_capacity(self.block.settings.len());
        for index in 0..self.block.settings.len() {
            let Some(&setting) = self.block.settings.get(index) else {
                break;
            };
            self.read_before_set(index)
                .map_err(|problem| (problem, Some(setting.text)))?;
            let value = self
                .setting_value(setting)
                .map_err(|problem| (problem, Some(setting.text)))?;
            values.push((setting, value));
        }
        for (setting, (number, value)) in values {
            let result = match setting.target {
                Target::Numbered(_) if self.is_control_variable(number) => {
                    self.set_control_variable(number, value, out)
                }
                Target::Numbered(_) => self.parameters.set(number, value),
                Target::Named(name) => {
                    self.parameters
                        .set_name(self.block.name(name), valued(value), &self.state)
                }
            };
            result.map_err(|problem| (problem, Some(setting.text)))?;
        }
        Ok(())
    }

    /// LinuxCNC creates a name with 0 as soon as it reads `#<name>=`, so that `#<n>=[#<n>+1]`
    /// counts from 0.
    fn read_before_set(&mut self, index: usize) -> Result<(), Problem> {
        // Names that stand left of `=` on this line so far.
        let set = self.block.settings.get(..=index).unwrap_or_default();
        let Some(Value::Ops(from, to)) = set.last().map(|setting| setting.value) else {
            return Ok(());
        };
        let is_set = |name: &[u8]| {
            set.iter().any(|setting| matches!(setting.target, Target::Named(own) if self.block.name(own) == name))
        };
        let ops = self
            .block
            .ops
            .get(from as usize..to as usize)
            .unwrap_or_default();
        for op in ops {
            let Op::Named(name) = *op else { continue };
            let name = self.block.name(name);
            // Created with 0 before the expression is evaluated.
            if is_set(name)
                && !self.parameters.has_name(name, &self.state)
                && self.config.leniencies.has(Leniency::ReadBeforeSet)
            {
                self.parameters.set_name(name, 0.0, &self.state)?;
                self.warnings.push(Problem::Lenient {
                    leniency: Leniency::ReadBeforeSet,
                });
            }
        }
        Ok(())
    }

    /// Number of the parameter (0 for a named one) and its new value.
    pub(super) fn setting_value(&mut self, setting: Setting) -> Result<(f64, f64), Problem> {
        let number = match setting.target {
            Target::Numbered(number) => self.value(number)?,
            Target::Named(_) => 0.0,
        };
        Ok((number, self.value_or_vacant(setting.value)?))
    }

    /// Reports what the block only warns about.
    pub(super) fn warn(&mut self) {
        // Reads are noted by the parameters and told once the block is evaluated.
        if std::mem::take(&mut self.parameters.vacant_read) {
            self.tell(Leniency::Vacant);
        }
        if let Some(number) = self.parameters.unset_read.take() {
            self.place_and_report(Problem::UnsetParameter { number }, None);
        }
        self.warn_of_variables();
        while let Some(problem) = self.warnings.pop() {
            match problem {
                Problem::Lenient { leniency } => self.tell(leniency),
                problem => self.report(problem),
            }
        }
    }
}
