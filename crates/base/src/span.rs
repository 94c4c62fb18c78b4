//! Places in a source text.

use serde::{Deserialize, Serialize};

/// A stretch of source bytes with its line and column for people.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Span {
    /// Index of the file in the session's list of files; 0 is the program itself.
    pub file: u32,
    /// Line, from 1.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
    /// Offset of the first byte.
    pub start: u64,
    /// Number of bytes.
    pub len: u32,
}

/// The block that an action came from.
///
/// Small and copyable, so that every segment and sample can carry one.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BlockRef {
    /// Where the block stands.
    pub span: Span,
    /// Index into the interpreter's list of call stacks; 0 is the main program.
    pub call_stack: u32,
}

impl std::fmt::Display for Span {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}, column {}", self.line, self.column)
    }
}
