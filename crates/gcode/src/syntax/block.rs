//! A parsed block, and the fault of one that cannot be parsed.

use crate::problem::Problem;
use nom::error::{ErrorKind, ParseError};
use nom::{Err, IResult};
use serde::Serialize;

/// A stretch of the line, in bytes from its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Text {
    /// First byte.
    pub start: u32,
    /// Number of bytes.
    pub len: u32,
}

/// A value: a literal, or a stretch of [`Block::ops`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A literal number.
    Number(f64),
    /// Operations in postfix order: from, to.
    Ops(u32, u32),
}

/// Functions of one argument, and of two for `Atan`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it; angles are in degrees")]
pub enum Unary {
    Abs,
    Acos,
    Asin,
    Cos,
    Exp,
    Fix,
    Fup,
    Ln,
    Round,
    Sin,
    Sqrt,
    Tan,
}

/// Operators of two arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Binary {
    Power,
    Times,
    Divide,
    Modulo,
    Plus,
    Minus,
    Equal,
    NotEqual,
    Greater,
    GreaterEqual,
    Less,
    LessEqual,
    And,
    Or,
    Xor,
}

impl Binary {
    /// How tightly it binds, from 0. AND, OR and XOR share one precedence, and so do all
    /// comparisons.
    pub const fn precedence(self) -> u8 {
        match self {
            Binary::Power => 4,
            Binary::Times | Binary::Divide | Binary::Modulo => 3,
            Binary::Plus | Binary::Minus => 2,
            Binary::And | Binary::Or | Binary::Xor => 0,
            _ => 1,
        }
    }
}

/// One step of a postfix expression. Names are stretches of [`Block::names`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Op {
    /// Push a number.
    Push(f64),
    /// Replace the number on top by the parameter of that number.
    Parameter,
    /// Push a named parameter.
    Named(Text),
    /// Push 1 if a named parameter exists, 0 otherwise.
    Exists(Text),
    /// Replace the number on top by 1 if there is a parameter of that number, by 0 otherwise.
    ExistsNumber,
    /// Negate.
    Negate,
    /// Apply a function.
    Unary(Unary),
    /// Angle of (second on top, top) in degrees.
    Atan,
    /// Apply an operator.
    Binary(Binary),
}

/// A letter with its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// Upper case; of `,R` and `,C` [`CORNER_RADIUS`](super::CORNER_RADIUS) and
    /// [`CORNER_CHAMFER`](super::CORNER_CHAMFER).
    pub letter: u8,
    /// Its value.
    pub value: Value,
    /// Where it stands.
    pub text: Text,
}

/// What a setting sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// `#5=`, `##1=`, `#[1+1]=`.
    Numbered(Value),
    /// `#<name>=`: a stretch of [`Block::names`].
    Named(Text),
}

/// `#target = value`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// What is set.
    pub target: Target,
    /// To what.
    pub value: Value,
    /// Where it stands.
    pub text: Text,
}

/// The name after O.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Label {
    /// `O100`, `O#1`, `O[#1+1]`.
    Number(Value),
    /// `O<name>`: a stretch of [`Block::names`].
    Name(Text),
}

/// The word after an O-label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Keyword {
    Sub,
    EndSub,
    Call,
    Return,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    Repeat,
    EndRepeat,
    Break,
    Continue,
    /// GOTO of Macro B; with an argument, if that holds.
    Goto,
    /// `IF [..] THEN #1=..` of Macro B.
    Then,
    /// A bare label: the start of a subroutine that ends with M99.
    Bare,
}

/// One line of a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Block {
    /// Whether it began with `/`.
    pub deletable: bool,
    /// The number after its `/`; 0 for none.
    pub skip_number: u8,
    /// Whether it is a `%` line.
    pub percent: bool,
    /// Its N number.
    pub line_number: Option<f64>,
    /// Where N with its number stands; empty without.
    pub line_number_text: Text,
    /// Words in the order of the line, without N and O.
    pub words: Vec<Word>,
    /// Settings in the order of the line.
    pub settings: Vec<Setting>,
    /// Label and keyword of an O-line.
    pub flow: Option<(Label, Keyword)>,
    /// Where it stands, with its arguments; empty without.
    pub flow_text: Text,
    /// Arguments of an O-line.
    pub arguments: Vec<Value>,
    /// The inside of the last comment.
    pub comment: Option<Text>,
    /// Where the checksum stands, with its `*`.
    pub checksum: Option<Text>,
    /// Postfix code of all values that are not literals.
    pub ops: Vec<Op>,
    /// A word has its letter in lower case.
    pub lower_case: bool,
    /// A word begins where the one before it ends.
    pub glued: bool,
    /// Names of parameters and labels, lower case without blanks.
    pub names: Vec<u8>,
}

impl Block {
    /// Empties it and keeps its buffers.
    pub fn clear(&mut self) {
        self.deletable = false;
        self.skip_number = 0;
        self.percent = false;
        self.lower_case = false;
        self.glued = false;
        self.line_number = None;
        self.flow = None;
        self.line_number_text = Text::default();
        self.flow_text = Text::default();
        self.comment = None;
        self.checksum = None;
        self.words.clear();
        self.settings.clear();
        self.arguments.clear();
        self.ops.clear();
        self.names.clear();
    }

    /// The bytes of a name.
    pub fn name(&self, text: Text) -> &[u8] {
        self.names
            .get(text.start as usize..(text.start + text.len) as usize)
            .unwrap_or_default()
    }

    /// Whether there is nothing to execute on the line.
    pub fn is_blank(&self) -> bool {
        self.words.is_empty()
            && self.settings.is_empty()
            && self.flow.is_none()
            && self.comment.is_none()
    }
}

/// A problem found while parsing, with the number of bytes that were left of the line when it was
/// found.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Bytes of the line after the place of the fault.
    pub rest: usize,
    /// What is wrong.
    pub problem: Box<Problem>,
}

/// Result of a parser over the rest of a line.
pub type Parsed<'a, T> = IResult<&'a [u8], T, Fault>;

impl<'a> ParseError<&'a [u8]> for Fault {
    fn from_error_kind(input: &'a [u8], _: ErrorKind) -> Fault {
        // nom's kinds say nothing to a user: name the byte that could not be read.
        let problem = input
            .first()
            .map_or(Problem::Expected { expected: "more" }, |&byte| {
                Problem::BadCharacter { byte }
            });
        Fault {
            rest: input.len(),
            problem: Box::new(problem),
        }
    }

    fn append(_: &'a [u8], _: ErrorKind, other: Fault) -> Fault {
        other
    }
}

/// A fault that no alternative can recover from.
#[cold]
pub(crate) fn fail<T>(input: &[u8], problem: Problem) -> Parsed<'_, T> {
    Err(Err::Failure(Fault {
        rest: input.len(),
        problem: Box::new(problem),
    }))
}
