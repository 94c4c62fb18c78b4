//! Branches and loops.

use super::Interpreter;
use super::flow::{Open, OpenKind, Skip};
use crate::problem::Problem;
use crate::syntax::Keyword;

/// Most rounds of one `repeat`.
const MOST_ROUNDS: f64 = 1e15;

pub(crate) fn flow_error(message: impl Into<String>) -> Problem {
    Problem::Flow {
        message: message.into(),
    }
}

impl Interpreter {
    /// A branch or loop line that is carried out.
    pub(crate) fn control(&mut self, label: String, keyword: Keyword) -> Result<(), Problem> {
        match keyword {
            Keyword::If => self.branch(label),
            Keyword::ElseIf | Keyword::Else => {
                let kind = self.top(&label, "if", |kind| !kind.is_loop())?;
                self.skip(label.clone(), Skip::EndIf);
                if kind == OpenKind::Else {
                    Err(flow_error(format!("o{label} has had its else")))
                } else {
                    Ok(())
                }
            }
            Keyword::EndIf => {
                self.top(&label, "if", |kind| !kind.is_loop())?;
                self.flow.opens.pop();
                Ok(())
            }
            Keyword::While => self.while_line(label),
            Keyword::EndWhile => {
                if let OpenKind::While(line) =
                    self.top(&label, "while", |kind| matches!(kind, OpenKind::While(_)))?
                {
                    self.flow.opens.pop();
                    self.flow.at = line;
                }
                Ok(())
            }
            Keyword::Do => self.open(label, OpenKind::Do(self.flow.at - 1)),
            Keyword::Repeat => self.repeat(label),
            Keyword::EndRepeat => {
                if let OpenKind::Repeat(line, rounds) = self.top(&label, "repeat", |kind| {
                    matches!(kind, OpenKind::Repeat(..))
                })? {
                    self.next_round(line, rounds);
                }
                Ok(())
            }
            Keyword::Break => self.leave_loop(label, false),
            _ => self.leave_loop(label, true),
        }
    }

    /// Opens a structure. One too many ends the program: nothing after it would be where it
    /// belongs.
    fn open(&mut self, label: String, kind: OpenKind) -> Result<(), Problem> {
        let limit = self.config.limits.open_structures;
        if self.flow.opens.len() >= limit {
            self.state.ended = true;
            return Err(Problem::TooManyOpen { limit });
        }
        self.flow.opens.push(Open {
            label,
            kind,
            span: self.span,
        });
        Ok(())
    }

    fn skip(&mut self, label: String, to: Skip) {
        self.flow.skip = Some((label, to, self.span));
    }

    /// The innermost open structure, if it is the one that a line belongs to.
    fn top(
        &self,
        label: &str,
        what: &str,
        is_kind: impl Fn(OpenKind) -> bool,
    ) -> Result<OpenKind, Problem> {
        match self.flow.opens.last() {
            Some(open)
                if self.flow.own_opens() > 0 && open.label == label && is_kind(open.kind) =>
            {
                Ok(open.kind)
            }
            Some(open) if self.flow.own_opens() > 0 => Err(flow_error(format!(
                "o{label} does not close what is open: o{} of line {}",
                open.label, open.span.line
            ))),
            _ => Err(flow_error(format!("o{label} without its {what}"))),
        }
    }

    /// The condition of a line; none given is an error, one that fails counts as false.
    fn condition(&mut self) -> Result<bool, Problem> {
        Ok(self
            .argument(0)?
            .ok_or_else(|| flow_error("a condition in brackets is missing"))?
            != 0.0)
    }

    fn branch(&mut self, label: String) -> Result<(), Problem> {
        let condition = self.condition();
        self.open(label.clone(), OpenKind::If)?;
        if !matches!(condition, Ok(true)) {
            self.skip(label, Skip::Branch);
        }
        condition.map(|_| ())
    }

    /// `while` begins a loop, or ends that of a `do`.
    fn while_line(&mut self, label: String) -> Result<(), Problem> {
        let condition = self.condition();
        let holds = matches!(condition, Ok(true));
        match self.flow.opens.last() {
            Some(Open {
                label: open,
                kind: OpenKind::Do(line),
                ..
            }) if *open == label && self.flow.own_opens() > 0 => {
                if holds {
                    self.flow.at = line + 1;
                } else {
                    self.flow.opens.pop();
                }
            }
            _ if holds => self.open(label, OpenKind::While(self.flow.at - 1))?,
            _ => self.skip(label, Skip::LoopEnd),
        }
        condition.map(|_| ())
    }

    fn repeat(&mut self, label: String) -> Result<(), Problem> {
        let rounds = self.argument(0).and_then(|rounds| {
            rounds.ok_or_else(|| flow_error("the number of repetitions is missing"))
        });
        match rounds {
            Ok(rounds) if rounds.round() >= 1.0 => {
                self.open(
                    label,
                    OpenKind::Repeat(self.flow.at - 1, rounds.round().min(MOST_ROUNDS) as u64 - 1),
                )?;
            }
            _ => self.skip(label, Skip::LoopEnd),
        }
        rounds.map(|_| ())
    }

    /// Goes to the next round of the innermost loop, a `repeat`; leaves it after the last.
    fn next_round(&mut self, line: usize, rounds: u64) -> bool {
        if rounds == 0 {
            self.flow.opens.pop();
            return false;
        }
        if let Some(open) = self.flow.opens.last_mut() {
            open.kind = OpenKind::Repeat(line, rounds - 1);
        }
        self.flow.at = line + 1;
        true
    }

    /// `break` and `continue`.
    fn leave_loop(&mut self, label: String, go_on: bool) -> Result<(), Problem> {
        let base = self.flow.opens.len() - self.flow.own_opens();
        let index = self
            .flow
            .opens
            .iter()
            .rposition(|open| open.kind.is_loop() && open.label == label)
            .filter(|index| *index >= base);
        let Some(index) = index else {
            return Err(flow_error(format!(
                "o{label} is not a loop that is open here"
            )));
        };
        self.flow.opens.truncate(index + 1);
        let kind = self.flow.opens.last().map(|open| open.kind);
        match (kind, go_on) {
            (Some(OpenKind::While(line)), true) => {
                self.flow.opens.pop();
                self.flow.at = line;
            }
            (Some(OpenKind::Do(_)), true) => self.skip(label, Skip::DoWhile),
            (Some(OpenKind::Repeat(line, rounds)), true) => {
                if !self.next_round(line, rounds) {
                    self.skip(label, Skip::LoopEnd);
                }
            }
            _ => {
                self.flow.opens.pop();
                self.skip(label, Skip::LoopEnd);
            }
        }
        Ok(())
    }

    /// A flow line met while skipping: whether it ends the skipping, and has to be carried out
    /// itself.
    pub(crate) fn while_skipping(&mut self, label: &str, keyword: Keyword) -> Result<(), Problem> {
        let Some((wanted, skip, _)) = &self.flow.skip else {
            return Ok(());
        };
        if wanted != label {
            return Ok(());
        }
        let skip = *skip;
        match (skip, keyword) {
            (Skip::Branch | Skip::EndIf, Keyword::EndIf) => {
                self.flow.skip = None;
                self.flow.opens.pop();
            }
            (Skip::Branch, Keyword::Else) => {
                self.flow.skip = None;
                if let Some(open) = self.flow.opens.last_mut() {
                    open.kind = OpenKind::Else;
                }
            }
            (Skip::Branch, Keyword::ElseIf) => {
                let condition = self.condition();
                if matches!(condition, Ok(true)) {
                    self.flow.skip = None;
                }
                condition?;
            }
            (Skip::LoopEnd, Keyword::EndWhile | Keyword::EndRepeat | Keyword::While) => {
                self.flow.skip = None
            }
            (Skip::DoWhile, Keyword::While) => {
                self.flow.skip = None;
                self.while_line(label.to_owned())?;
            }
            _ => {}
        }
        Ok(())
    }
}
