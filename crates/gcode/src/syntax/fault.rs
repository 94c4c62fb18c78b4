//! The error type of the nom parsers: a problem and where it is.

use crate::problem::Problem;
use nom::error::{ErrorKind, ParseError};
use nom::{Err, IResult};

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
