//! Control flow: O-words, and jumps to line numbers (GOTO of Macro B).

use super::Interpreter;
use super::flow::{Goto, Open, OpenKind, Skip};
use crate::codes::whole;
use crate::ops::SourcedOp;
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
                // Reached by running, not by skipping: the branch before it was taken, so the rest
                // is skipped.
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
                // Back to the `while` line, which evaluates its condition anew.
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
        // Opened even if the condition fails, so that its `endif` still closes something.
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
        // A `while` with the label of an open `do` is the end of that loop.
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
        // The number is evaluated once, before the first round.
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
        // A loop of the caller cannot be left from inside a subroutine.
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
        // Branches and loops inside the loop are closed with it.
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
        // Structures inside what is skipped have other labels.
        if wanted != label {
            return Ok(());
        }
        let skip = *skip;
        // What ends the skipping depends on what it looks for.
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
                self.flow.skip = None;
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

/// Lines that can be searched in the time of a block.
const LINES_A_BLOCK: usize = 16;

/// The N number of a line, from its text alone.
pub(crate) fn line_number(line: &[u8]) -> Option<f64> {
    // Block delete may stand before the N number.
    let text = line.trim_ascii_start();
    let text = match text.strip_prefix(b"/").map(<[u8]>::trim_ascii_start) {
        Some([b'1'..=b'9', rest @ ..] | rest) => rest.trim_ascii_start(),
        None => text,
    };
    let [b'N' | b'n', rest @ ..] = text else {
        return None;
    };
    let rest = rest.trim_ascii_start();
    // Jumps go to whole numbers: digits are enough.
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    std::str::from_utf8(rest.get(..digits)?).ok()?.parse().ok()
}

/// The number of an `END 1` line.
fn end_number(line: &[u8]) -> Option<f64> {
    let text = line.trim_ascii_start();
    let text = if line_number(line).is_some() {
        let letter = text.iter().position(|byte| matches!(byte, b'N' | b'n'))?;
        let rest = text.get(letter + 1..)?.trim_ascii_start();
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        rest.get(digits..)?.trim_ascii_start()
    } else {
        text
    };
    let rest = text
        .get(..3)
        .filter(|head| head.eq_ignore_ascii_case(b"end"))
        .and(text.get(3..))?
        .trim_ascii();
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    std::str::from_utf8(rest.get(..digits)?).ok()?.parse().ok()
}

impl Interpreter {
    /// Goes to a line: first among those that are held after this one, then before it, then further
    /// on in the program.
    pub(crate) fn goto(&mut self, number: f64) -> Result<(), Problem> {
        let number = whole(number)
            .filter(|number| *number >= 0.0)
            .ok_or(Problem::NoSuchLine { number })?;
        // A search costs time, too: every 16 lines count as one block towards the limit.
        self.looped += (self.flow.tape().len() / LINES_A_BLOCK) as u64;
        let (at, tape) = (self.flow.at, self.flow.tape());
        // Held lines are compared as text: parsing them again would cost more than the jump.
        let is_it = |index: &usize| {
            tape.get(*index)
                .is_some_and(|(_, line)| line_number(line) == Some(number))
        };
        if let Some(target) = (at..tape.len())
            .find(is_it)
            .or_else(|| (0..at.min(tape.len())).find(is_it))
        {
            self.leave_loops(Some(target));
            self.flow.at = target;
            return Ok(());
        }
        // A subroutine is held whole, and after the end nothing more is read.
        if !self.flow.frames.is_empty() || self.at_end {
            return Err(Problem::NoSuchLine { number });
        }
        self.leave_loops(None);
        self.flow.at = self.flow.main.len();
        self.flow.goto = Some(Goto { number });
        Ok(())
    }

    /// Closes the loops that a jump leaves. Beyond what is held, all of them are left but those
    /// whose end comes later.
    fn leave_loops(&mut self, target: Option<usize>) {
        while self.flow.own_opens() > 0
            && let Some(open) = self.flow.opens.last()
        {
            // A loop stays open only if the target lies inside it.
            let start = match open.kind {
                OpenKind::While(line) | OpenKind::Do(line) | OpenKind::Repeat(line, _) => line,
                OpenKind::If | OpenKind::Else => usize::MAX,
            };
            let tape = self.flow.tape();
            let is_end = |index: &usize| {
                tape.get(*index)
                    .and_then(|(_, line)| end_number(line))
                    .is_some_and(|end| format!("{end}") == open.label)
            };
            let end = (start.saturating_add(1)..tape.len())
                .find(is_end)
                .unwrap_or(usize::MAX);
            let place = target.unwrap_or_else(|| tape.len());
            if start < place && place <= end && start != usize::MAX {
                return;
            }
            self.flow.opens.pop();
        }
    }

    /// A line met while a jump looks for its target: true if it is passed over.
    pub(crate) fn passes_goto(&mut self) -> bool {
        let Some(goto) = self.flow.goto else {
            return false;
        };
        if line_number(&self.line) == Some(goto.number) {
            self.flow.goto = None;
            return false;
        }
        // An END on the way closes its loop.
        if let Some(end) = end_number(&self.line) {
            let label = format!("{end}");
            let base = self.flow.opens.len() - self.flow.own_opens();
            if let Some(index) = self
                .flow
                .opens
                .iter()
                .rposition(|open| open.label == label)
                .filter(|index| *index >= base)
            {
                self.flow.opens.truncate(index);
            }
        }
        true
    }

    /// The end of the source while a jump is looking.
    pub(crate) fn goto_failed(&mut self) -> bool {
        let Some(goto) = self.flow.goto.take() else {
            return false;
        };
        self.report(Problem::NoSuchLine {
            number: goto.number,
        });
        true
    }

    /// `IF [..] GOTO n`, `GOTO n` and `IF [..] THEN #1=..`.
    pub(crate) fn macro_flow(
        &mut self,
        label: &str,
        keyword: Keyword,
        out: &mut Vec<SourcedOp>,
    ) -> Result<(), Problem> {
        // GOTO without a condition always jumps.
        let holds = self.argument(0)?.is_none_or(|condition| condition != 0.0);
        if !holds {
            return Ok(());
        }
        match keyword {
            Keyword::Goto => self.goto(label.parse().unwrap_or(-1.0)),
            _ => self.apply_settings(out).map_err(|(problem, _)| problem),
        }
    }
}
