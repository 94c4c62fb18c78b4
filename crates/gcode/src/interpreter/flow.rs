//! Where the program is: open loops and branches, calls, lines to be skipped, and the lines that are
//! held because they may run again.

use crate::parameters::MACRO_LOCALS;
use crate::problem::Problem;
use crate::source::Place;
use lostmotion_base::span::Span;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Bytes of the main program that are kept for jumps back.
const KEPT_BYTES: usize = 16 << 20;

/// An open branch or loop.
#[derive(Clone, Debug)]
pub(crate) struct Open {
    pub(crate) label: String,
    pub(crate) kind: OpenKind,
    /// Where it was opened, for the message if it is never closed.
    pub(crate) span: Span,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OpenKind {
    If,
    /// The last branch of an `if`.
    Else,
    /// Index of the `while` line.
    While(usize),
    /// Index of the `do` line.
    Do(usize),
    /// Index of the `repeat` line and further rounds.
    Repeat(usize, u64),
}

impl OpenKind {
    pub(crate) const fn is_loop(self) -> bool {
        !matches!(self, OpenKind::If | OpenKind::Else)
    }
}

/// What skipping looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Skip {
    /// `elseif`, `else` or `endif`.
    Branch,
    /// `endif` only.
    EndIf,
    /// The end of a loop, which is left.
    LoopEnd,
    /// The `while` of a `do`, which is then carried out.
    DoWhile,
}

/// A call in progress.
#[derive(Clone, Debug)]
pub(crate) struct CallFrame {
    pub(crate) name: String,
    pub(crate) body: Arc<Tape>,
    /// Where the caller goes on.
    pub(crate) return_to: usize,
    /// How many structures were open in the callers.
    pub(crate) opens: usize,
    /// The caller's numbered locals; `None` if the subroutine shares them (M98).
    pub(crate) locals: Option<Box<[f64; MACRO_LOCALS]>>,
    /// Index of the caller's own call.
    pub(crate) caller: u32,
    /// Whether an M code that the settings give this meaning has called it.
    pub(crate) by_m_code: bool,
    /// Further rounds of the call (L of M98).
    pub(crate) rounds: u64,
}

/// A search for a line further on than what has been read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goto {
    pub(crate) number: f64,
}

/// A search for a subroutine further on.
#[derive(Clone, Debug)]
pub(crate) struct Seek {
    pub(crate) name: String,
    /// Next line of the main program to look at.
    pub(crate) at: usize,
}

/// A definition being recorded.
#[derive(Clone, Debug)]
pub(crate) struct Record {
    pub(crate) name: String,
    /// A bare label, which ends with M99.
    pub(crate) bare: bool,
    pub(crate) body: Tape,
    pub(crate) span: Span,
}

/// What a subroutine takes beside its name and lines, in bytes.
const SUBROUTINE_OVERHEAD_BYTES: usize = 256;

#[derive(Clone, Debug, Default)]
pub(crate) struct Flow {
    /// Lines of the main program that are held.
    pub(crate) main: Tape,
    /// Next line of what is running: the main program or the last frame's body.
    pub(crate) at: usize,
    pub(crate) frames: Vec<CallFrame>,
    pub(crate) opens: Vec<Open>,
    pub(crate) skip: Option<(String, Skip, Span)>,
    pub(crate) seek: Option<Seek>,
    pub(crate) record: Option<Record>,
    /// A jump whose target has not been read yet.
    pub(crate) goto: Option<Goto>,
    /// Lines of the main program are kept, as far as there is room, because a jump may come back to
    /// them.
    pub(crate) keeps: bool,
    pub(crate) subs: BTreeMap<String, Arc<Tape>>,
    /// What the bodies of `subs` hold, in bytes.
    pub(crate) held: usize,
}

impl Flow {
    /// What is running.
    pub(crate) fn tape(&self) -> &Tape {
        self.frames.last().map_or(&self.main, |frame| &frame.body)
    }

    /// Forgets main program lines that cannot run again.
    pub(crate) fn forget(&mut self) {
        // Lines are needed again by open loops, by returns to the caller, and by searches.
        let may_return = self.seek.is_some()
            || !self.frames.is_empty()
            || self.opens.iter().any(|open| open.kind.is_loop());
        let keeps = self.keeps && self.main.bytes() < KEPT_BYTES;
        if !may_return && !keeps && self.at >= self.main.len() {
            self.main.clear();
            self.at = 0;
        }
    }

    /// Keeps a subroutine; an earlier one of the same name is forgotten.
    pub(crate) fn keep(&mut self, name: String, body: Tape) {
        // Overhead counts, too: many empty subroutines would fill memory.
        let beside = SUBROUTINE_OVERHEAD_BYTES + name.len();
        self.held += beside + body.size();
        if let Some(old) = self.subs.insert(name, Arc::new(body)) {
            self.held = self.held.saturating_sub(beside + old.size());
        }
    }

    /// Open structures of the subroutine that is running.
    pub(crate) fn own_opens(&self) -> usize {
        self.opens.len() - self.frames.last().map_or(0, |frame| frame.opens)
    }
}

/// How a subroutine is defined, which decides how it is called.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Definition {
    /// A file without a definition of its own: called in either way.
    #[default]
    File,
    /// From a label alone to M99: called by M98.
    Label,
    /// From `sub` to `endsub`: called by `call`.
    Sub,
}

/// What a line takes beside its bytes.
const LINE_OVERHEAD_BYTES: usize = 32;

/// Lines of source in one buffer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tape {
    /// How the subroutine whose body this is was defined.
    pub(crate) definition: Definition,
    bytes: Vec<u8>,
    lines: Vec<(Place, usize, usize)>,
}

impl Tape {
    pub(crate) fn push(&mut self, line: &[u8], place: Place, limit: usize) -> Result<(), Problem> {
        // Lines are held in one buffer, whose size is bounded before it grows.
        if self.size() + line.len() > limit {
            return Err(Problem::TooMuchHeld { limit });
        }
        let from = self.bytes.len();
        self.bytes.extend_from_slice(line);
        self.lines.push((place, from, self.bytes.len()));
        Ok(())
    }

    /// Bytes held, with what it takes to find the lines.
    pub(crate) fn size(&self) -> usize {
        self.bytes.len() + LINE_OVERHEAD_BYTES * self.lines.len()
    }

    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
        self.lines.clear();
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes.len()
    }

    pub(crate) fn len(&self) -> usize {
        self.lines.len()
    }

    pub(crate) fn get(&self, index: usize) -> Option<(Place, &[u8])> {
        let (place, from, to) = *self.lines.get(index)?;
        Some((place, self.bytes.get(from..to)?))
    }
}
