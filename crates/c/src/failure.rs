//! What went wrong in a call, kept for the thread that made it.

use lostmotion::drive::AxisError;
use lostmotion::report::findings::Finding;
use lostmotion::report::refusal::{Refusal, RefusalKind};
use lostmotion::sim::machine::MachineError;
use lostmotion::sim::request::RequestError;
use serde_json::Value;
use std::cell::{Cell, RefCell};
use std::ffi::{CString, c_char};

/// How a call went.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LmStatus {
    /// It did what it says.
    Ok = 0,
    /// A pointer or handle that has to be given is null.
    Null = 1,
    /// No handle of this kind, or one that was freed.
    Handle = 2,
    /// Another thread, or a callback that is running, uses the object.
    Busy = 3,
    /// A size or an index that does not fit, a pointer that is not aligned.
    Size = 4,
    /// A value that means nothing.
    Option = 5,
    /// The part program.
    Program = 6,
    /// The description of the machine.
    Machine = 7,
    /// The compensator, or its axis.
    Method = 8,
    /// Columns of a log, setpoints.
    Data = 9,
    /// A callback has ended the run.
    Cancelled = 10,
    /// Something else; the message says what.
    Other = 11,
    /// A fault of the library's own. The object that was being changed can only be freed.
    Internal = 12,
}

/// A failure without anything of its own in memory: also of calls that a real-time thread makes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Brief {
    /// What it is about.
    pub(crate) what: &'static str,
    pub(crate) reason: Reason,
}

/// Its reason.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Reason {
    Null,
    OtherKind,
    NoHandle,
    Freed,
    Busy,
    Broken,
    Full,
    /// A pointer that is not aligned for what it points to.
    Unaligned,
    /// A number of items, and what it has to be.
    Size(usize, usize),
    /// A setpoint of this number, with its faulty value.
    NotFinite(u64, &'static str, f64),
    Force(u64, f64, f64),
    Incomplete(u64, &'static str),
    /// Anything else that an axis refuses.
    Axis,
    /// A compensator of the caller's has ended the axis.
    Compensator,
    /// A tick without a setpoint before it.
    NoSetpoint,
    /// A setpoint before all ticks of the last one.
    TicksLeft(usize),
}

impl Brief {
    fn status(self) -> LmStatus {
        match self.reason {
            Reason::Null => LmStatus::Null,
            Reason::OtherKind | Reason::NoHandle | Reason::Freed => LmStatus::Handle,
            Reason::Busy => LmStatus::Busy,
            Reason::Broken => LmStatus::Internal,
            Reason::Full => LmStatus::Other,
            Reason::Size(..) | Reason::Unaligned | Reason::NoSetpoint | Reason::TicksLeft(_) => {
                LmStatus::Size
            }
            Reason::NotFinite(..) | Reason::Force(..) | Reason::Incomplete(..) | Reason::Axis => {
                LmStatus::Data
            }
            Reason::Compensator => LmStatus::Method,
        }
    }

    /// Of what an axis refuses.
    pub(crate) fn axis(error: &AxisError) -> Brief {
        let reason = match *error {
            AxisError::SetpointNotFinite { tick, what, value } => {
                Reason::NotFinite(tick, what, value)
            }
            AxisError::LoadForce {
                tick,
                value,
                highest,
            } => Reason::Force(tick, value, highest),
            AxisError::SetpointIncomplete { tick, what } => Reason::Incomplete(tick, what),
            _ => Reason::Axis,
        };
        Brief {
            what: "setpoint",
            reason,
        }
    }

    fn refusal(self) -> Refusal {
        let what = self.what;
        let of = |code: &str, message: String, hint: &str| {
            Refusal::new(RefusalKind::Other, code, message, hint)
        };
        let axis =
            |error: AxisError| Refusal::new(RefusalKind::Data, "setpoint", error.to_string(), "");
        match self.reason {
            Reason::Null => of("null", format!("{what} is null"), ""),
            Reason::OtherKind => of(
                "handle",
                format!("this is no handle of a {what}"),
                "a handle is what the function that made it has given; it is of one kind",
            ),
            Reason::NoHandle => of("handle", format!("there is no such {what}"), ""),
            Reason::Freed => of(
                "freed",
                format!("the {what} has been freed"),
                "set a handle to null where it is freed",
            ),
            Reason::Busy => of(
                "busy",
                format!("the {what} is in use"),
                "another thread or a running callback has it; one thread at a time changes an object or frees it",
            ),
            Reason::Broken => of(
                "internal",
                format!("an earlier call has failed inside and left the {what} unusable"),
                "free it and make a new one; please report this",
            ),
            Reason::Full => of("full", format!("there are too many of {what}"), "free some"),
            Reason::Unaligned => of("size", format!("{what} is not aligned"), ""),
            Reason::Size(given, needed) => of(
                "size",
                format!("{what}: {given}, it has to be {needed}"),
                "",
            ),
            Reason::NotFinite(tick, what, value) => {
                axis(AxisError::SetpointNotFinite { tick, what, value })
            }
            Reason::Force(tick, value, highest) => axis(AxisError::LoadForce {
                tick,
                value,
                highest,
            }),
            Reason::Incomplete(tick, what) => axis(AxisError::SetpointIncomplete { tick, what }),
            Reason::Axis => of("setpoint", "the axis refuses the setpoint".to_owned(), ""),
            Reason::Compensator => of(
                "correction",
                "a compensator has failed, or answered what no drive can follow".to_owned(),
                "answer finite angles (rad), speeds (rad/s) and torques (N m); make a new axis",
            ),
            Reason::NoSetpoint => of(
                "tick",
                "a servo tick without a setpoint".to_owned(),
                "give the next setpoint after the last tick of the one before",
            ),
            Reason::TicksLeft(left) => of(
                "tick",
                format!("the last setpoint has {left} servo ticks left"),
                "step all ticks of a setpoint before the next one",
            ),
        }
    }
}

/// What went wrong.
#[derive(Debug)]
pub(crate) enum Failure {
    Brief(Brief),
    Full(LmStatus, Box<Refusal>),
}

impl Failure {
    pub(crate) fn brief(what: &'static str, reason: Reason) -> Failure {
        Failure::Brief(Brief { what, reason })
    }

    pub(crate) fn option(message: impl Into<String>, hint: &str) -> Failure {
        Refusal::option(message, hint).into()
    }

    pub(crate) fn method(code: &str, message: impl Into<String>) -> Failure {
        Refusal::new(RefusalKind::Method, code, message, "").into()
    }

    pub(crate) fn internal(message: impl Into<String>) -> Failure {
        let refusal = Refusal::new(
            RefusalKind::Other,
            "internal",
            message,
            "please report this",
        );
        Failure::Full(LmStatus::Internal, Box::new(refusal))
    }

    /// Keeps it for [`lm_error`](crate::error::lm_error).
    pub(crate) fn keep(self) -> LmStatus {
        match self {
            Failure::Brief(brief) => {
                BRIEF.set(Some(brief));
                brief.status()
            }
            Failure::Full(status, refusal) => {
                BRIEF.set(None);
                // A thread that is ending has no place for it any more.
                let _ = KEPT.try_with(|kept| *kept.borrow_mut() = Kept::of(status, &refusal));
                status
            }
        }
    }
}

impl From<MachineError> for Failure {
    fn from(error: MachineError) -> Failure {
        Refusal::from(error).into()
    }
}

impl From<RequestError> for Failure {
    fn from(error: RequestError) -> Failure {
        Refusal::from(error).into()
    }
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Failure {
        let status = match refusal.kind {
            RefusalKind::Program => LmStatus::Program,
            RefusalKind::Machine => LmStatus::Machine,
            RefusalKind::Method => LmStatus::Method,
            RefusalKind::Option => LmStatus::Option,
            RefusalKind::Data => LmStatus::Data,
            RefusalKind::Cancelled => LmStatus::Cancelled,
            _ => LmStatus::Other,
        };
        Failure::Full(status, Box::new(refusal))
    }
}

thread_local! {
    /// The last failure, if it was a brief one. Without a destructor: the first use registers none.
    static BRIEF: Cell<Option<Brief>> = const { Cell::new(None) };
    /// The last failure of the others, and the texts that the caller was given.
    static KEPT: RefCell<Kept> = RefCell::new(Kept::default());
}

/// A failure as C reads it.
#[derive(Default)]
pub(crate) struct Kept {
    pub(crate) status: Option<LmStatus>,
    pub(crate) code: CString,
    pub(crate) message: CString,
    pub(crate) hint: CString,
    pub(crate) findings: Vec<Told>,
}

impl Kept {
    fn of(status: LmStatus, refusal: &Refusal) -> Kept {
        Kept {
            status: Some(status),
            code: c_text(&refusal.code),
            message: c_text(&refusal.message),
            hint: c_text(&refusal.hint),
            findings: refusal.findings.iter().map(Told::of).collect(),
        }
    }
}

/// Looks at the last failure of this thread.
pub(crate) fn with_last<R>(look: impl FnOnce(&Kept) -> R) -> Option<R> {
    KEPT.try_with(|kept| {
        if let Some(brief) = BRIEF.take() {
            *kept.borrow_mut() = Kept::of(brief.status(), &brief.refusal());
        }
        look(&kept.borrow())
    })
    .ok()
}

/// Forgets it, and makes room for the next.
pub(crate) fn forget() {
    BRIEF.set(None);
    let _ = KEPT.try_with(|kept| *kept.borrow_mut() = Kept::default());
}

/// A finding as C reads it.
pub(crate) struct Told {
    code: CString,
    message: CString,
    hint: CString,
    file: CString,
    excerpt: CString,
    key: CString,
    is_error: bool,
    line: u32,
    column: u32,
    length: u32,
}

/// Something that was found in a program or a machine file, with its place.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmFinding {
    /// Stable name of the kind of finding.
    pub code: *const c_char,
    /// What was found, with values.
    pub message: *const c_char,
    /// What to do; may be empty.
    pub hint: *const c_char,
    /// Name of the file.
    pub file: *const c_char,
    /// The line that it is about; may be empty.
    pub excerpt: *const c_char,
    /// The key of a machine file that it is about; empty for a program.
    pub key: *const c_char,
    /// Whether it refuses the program or the machine.
    pub is_error: bool,
    /// Line, from 1; 0 for the file as a whole.
    pub line: u32,
    /// Column in bytes, from 1; 0 where there is none.
    pub column: u32,
    /// Length in bytes.
    pub length: u32,
}

impl Told {
    pub(crate) fn of(finding: &Finding) -> Told {
        Told {
            code: c_text(&finding.code),
            message: c_text(&finding.message),
            hint: c_text(finding.hint.as_deref().unwrap_or_default()),
            file: c_text(&finding.file),
            excerpt: c_text(&finding.excerpt),
            key: c_text(
                finding
                    .values
                    .get("key")
                    .and_then(Value::as_str)
                    .unwrap_or_default(),
            ),
            is_error: finding.severity == lostmotion::gcode::Severity::Error,
            line: finding.span.line,
            column: finding.span.column,
            length: finding.span.len,
        }
    }

    pub(crate) fn shown(&self) -> LmFinding {
        LmFinding {
            code: self.code.as_ptr(),
            message: self.message.as_ptr(),
            hint: self.hint.as_ptr(),
            file: self.file.as_ptr(),
            excerpt: self.excerpt.as_ptr(),
            key: self.key.as_ptr(),
            is_error: self.is_error,
            line: self.line,
            column: self.column,
            length: self.length,
        }
    }
}

/// A text as C reads it; a zero inside, which would end it, becomes a replacement character.
pub(crate) fn c_text(text: &str) -> CString {
    CString::new(text)
        .or_else(|_| CString::new(text.replace('\0', "\u{fffd}")))
        .unwrap_or_default()
}
