//! From the bytes of a line to a block: words, values, settings, comments. Nothing here knows what
//! a code means.

pub mod block;
pub mod comment;
pub(crate) mod evaluate;
pub mod expression;
pub mod fault;
pub mod flow;
pub mod number;
pub(crate) mod operators;
pub mod parse;
pub mod pieces;
mod plain;
pub(crate) mod siemens;
pub(crate) mod special;

pub use block::{Block, Keyword, Label, Op, Setting, Target, Text, Unary, Value, Word};
pub use fault::Fault;
pub use parse::parse_block;
pub use pieces::{Piece, PieceKind, Pieces};
