//! The end of the source, and of the program.

use super::control::flow_error;
use super::flow::Skip;
use super::{Interpreter, Percent, Step};
use crate::dialect::Leniency;
use crate::ops::SourcedOp;
use crate::problem::Problem;
use lostmotion_base::span::Span;

impl Interpreter {
    /// The source is at its end: what is still open, and whether the program ended.
    pub(super) fn finish(&mut self, out: &mut Vec<SourcedOp>) -> Step {
        if self.goto_failed() {
            return Step::Ran;
        }
        if let Some(seek) = self.flow.seek.take() {
            self.flow.record = None;
            self.missing_sub = Some(seek.name);
            return Step::Ran;
        }
        self.check_open();
        self.let_go(out);
        self.span = Span {
            column: 1,
            len: 0,
            ..self.span
        };
        self.forgive(
            if self.percent == Percent::Open {
                Problem::NoClosingPercent
            } else {
                Problem::NoProgramEnd
            },
            Leniency::MissingEnd,
        );
        self.settle_habits();
        self.state.ended = true;
        Step::Ended
    }

    /// Moves that cutter compensation still holds go out as they are; a curve that is not closed is
    /// told.
    pub(super) fn let_go(&mut self, out: &mut Vec<SourcedOp>) {
        if self.state.nurbs.take().is_some() {
            self.report(crate::exec::curves::unclosed());
        }
        if let Err(problem) = self.exec(out).end_compensation() {
            self.report(problem);
        }
    }

    /// Reports structures that are not closed.
    pub(super) fn check_open(&mut self) {
        if let Some(record) = self.flow.record.take() {
            self.report_at(Problem::UnclosedSub { name: record.name }, record.span);
        }
        if let Some((label, skip, span)) = self.flow.skip.take() {
            let what = if matches!(skip, Skip::Branch | Skip::EndIf) {
                "if"
            } else {
                "loop"
            };
            self.report_at(
                flow_error(format!("the {what} o{label} is not closed")),
                span,
            );
        } else if let Some(open) = self.flow.opens.pop() {
            let what = if open.kind.is_loop() { "loop" } else { "if" };
            self.report_at(
                flow_error(format!("the {what} o{} is not closed", open.label)),
                open.span,
            );
        }
    }
}
