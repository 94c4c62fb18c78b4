//! Outputs and inputs of the machine (M62 to M68), and comments that are messages.

use super::Exec;
use crate::codes::{Code, whole};
use crate::dialect::Dialect;
use crate::exec::words::whole_within;
use crate::ops::{CanonicalOp, OutputValue, TextKind, WaitFor};
use crate::parameters::View;
use crate::problem::Problem;
use crate::syntax::evaluate::evaluate;
use crate::syntax::{Block, parse_block};

/// Highest number of an input or output.
const HIGHEST_PORT: f64 = 255.0;
/// Parameter that M66 puts its result in.
const INPUT_RESULT_PARAMETER: u16 = 5399;

impl Exec<'_> {
    fn port(&self, code: Code, letter: u8, value: f64) -> Result<u8, Problem> {
        whole_within(
            (code, letter),
            value,
            0.0..=HIGHEST_PORT,
            "a number from 0 to 255",
        )
        .map(|number| number as u8)
    }
}

/// M62 to M65: digital outputs; the odd ones switch off.
pub(crate) fn digital(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let number = exec.need(b'P', code, "P, the number of the output")?;
    let index = exec.port(code, b'P', number)?;
    let on = matches!(code.tenths, 620 | 640);
    exec.emit(CanonicalOp::SetOutput {
        index,
        value: OutputValue::Digital(on),
        with_motion: code.tenths < 640,
    });
    Ok(())
}

/// M67 and M68: analogue outputs.
pub(crate) fn analog(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let number = exec.need(b'E', code, "E, the number of the output")?;
    let index = exec.port(code, b'E', number)?;
    let value = exec.need(b'Q', code, "Q, the value of the output")?;
    exec.emit(CanonicalOp::SetOutput {
        index,
        value: OutputValue::Analog(value),
        with_motion: code.tenths == 670,
    });
    Ok(())
}

/// M66: reads an input into #5399. There are no inputs: the result is 0.
pub(crate) fn input(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    // Exactly one of P and E says which kind of input.
    let (letter, number) = match (exec.word(b'P'), exec.word(b'E')) {
        (Some(number), None) => (b'P', number),
        (None, Some(number)) => (b'E', number),
        _ => {
            return Err(Problem::WordMissing {
                code,
                what: "either P, a digital input, or E, an analogue one",
            });
        }
    };
    let index = exec.port(code, letter, number)?;
    let mode = exec.word(b'L').unwrap_or(0.0);
    let wait = match whole(mode) {
        Some(0.0) => WaitFor::Now,
        Some(1.0) => WaitFor::Rise,
        Some(2.0) => WaitFor::Fall,
        Some(3.0) => WaitFor::High,
        Some(4.0) => WaitFor::Low,
        _ => {
            return Err(Problem::WordOutOfRange {
                code,
                letter: 'L',
                value: mode,
                allowed: "0 to 4",
            });
        }
    };
    let analog = letter == b'E';
    let seconds = exec.word(b'Q').unwrap_or(0.0);
    // Analogue inputs have no edges to wait for.
    if wait != WaitFor::Now && analog {
        return Err(Problem::WordOutOfRange {
            code,
            letter: 'L',
            value: mode,
            allowed: "0 for an analogue input",
        });
    }
    if wait != WaitFor::Now && seconds <= 0.0 {
        return Err(Problem::WordMissing {
            code,
            what: "Q, how many seconds to wait at most",
        });
    }
    // Nothing is connected: the program goes on with the result of an idle input.
    exec.parameters.put(INPUT_RESULT_PARAMETER, 0.0);
    exec.emit(CanonicalOp::ReadInput {
        index,
        analog,
        wait,
        seconds,
    });
    Ok(())
}

/// Prefixes of comments that do something, and whether values are filled in.
const ACTIVE_COMMENTS: [(&str, TextKind, bool); 5] = [
    ("msg,", TextKind::Message, false),
    ("debug,", TextKind::Message, true),
    ("print,", TextKind::Print, true),
    ("log,", TextKind::Log, true),
    ("probeopen", TextKind::Log, false),
];

/// Prefix of the comment that stops the program.
const ABORT: &str = "abort,";

/// What follows a prefix, in any case.
fn after_prefix<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    let head = text.get(..prefix.len())?;
    head.eq_ignore_ascii_case(prefix)
        .then(|| text.get(prefix.len()..))
        .flatten()
}

impl Exec<'_> {
    /// Carries a comment out.
    ///
    /// # Errors
    /// `(ABORT,...)` stops the program with its message.
    pub(crate) fn comment(&mut self, inside: &[u8]) -> Result<(), Problem> {
        let text = String::from_utf8_lossy(inside).into_owned();
        // The prefix decides, whatever its case; blanks before it do not count.
        let start = text.trim_start();
        if let Some(message) = after_prefix(start, ABORT)
            && self.config.dialect == Dialect::LinuxCnc
        {
            self.state.ended = true;
            let message = self.fill(message.trim());
            return Err(Problem::Abort { message });
        }
        for (prefix, kind, fill) in ACTIVE_COMMENTS {
            if let Some(rest) = after_prefix(start, prefix) {
                let text = if fill {
                    self.fill(rest)
                } else {
                    rest.to_owned()
                };
                self.emit(CanonicalOp::Text { kind, text });
                return Ok(());
            }
        }
        self.emit(CanonicalOp::Text {
            kind: TextKind::Comment,
            text,
        });
        Ok(())
    }

    /// The text with every `#parameter` replaced by its value; what is no parameter stays as it is.
    fn fill(&mut self, text: &str) -> String {
        let mut filled = String::new();
        let mut rest = text;
        while let Some(at) = rest.find('#') {
            // Text up to the #, then the reference as value, or as it is where it has none.
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
            // The reference is read by the grammar of values: as the value of a word.
            format!("X{reference}").as_bytes(),
            &mut block,
            &self.config.limits,
        )
        .ok()?;
        let value = block.words.first()?.value;
        let mut view = View {
            parameters: self.parameters,
            state: self.state,
            tools: self.tools.as_ref(),
            config: self.config,
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
