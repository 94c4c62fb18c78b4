//! Jumps to line numbers (GOTO of Macro B).

use super::Interpreter;
use super::flow::OpenKind;
use crate::code::whole;
use crate::problem::Problem;
use crate::syntax::Keyword;

/// Lines that can be searched in the time of a block.
const LINES_A_BLOCK: usize = 16;

/// A search for a line further on than what has been read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goto {
    number: f64,
}

/// The N number of a line, from its text alone.
pub(crate) fn line_number(line: &[u8]) -> Option<f64> {
    let text = line.trim_ascii_start();
    let text = text.strip_prefix(b"/").unwrap_or(text).trim_ascii_start();
    let [b'N' | b'n', rest @ ..] = text else {
        return None;
    };
    let rest = rest.trim_ascii_start();
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
        // Searching takes time too: so many lines count as a block.
        self.looped += (self.flow.tape().len() / LINES_A_BLOCK) as u64;
        let (at, tape) = (self.flow.at, self.flow.tape());
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
    pub(crate) fn macro_flow(&mut self, label: &str, keyword: Keyword) -> Result<(), Problem> {
        let holds = self.argument(0)?.is_none_or(|condition| condition != 0.0);
        if !holds {
            return Ok(());
        }
        match keyword {
            Keyword::Goto => self.goto(label.parse().unwrap_or(-1.0)),
            _ => self.apply_settings().map_err(|(problem, _)| problem),
        }
    }
}
