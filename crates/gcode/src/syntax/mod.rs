//! From the bytes of a line to a block: words, values, settings, comments. Nothing here knows what
//! a code means.

pub mod block;
pub(crate) mod evaluate;
pub mod expression;
pub mod flow;
pub mod number;
pub mod parse;
pub(crate) mod special;
pub mod tokens;

pub use block::Fault;
pub use block::{Block, Keyword, Label, Op, Setting, Target, Text, Unary, Value, Word};
pub use parse::parse_block;
pub use tokens::{Token, TokenKind, Tokens};
