//! From the bytes of a line to a block: words, values, settings, comments. Nothing here knows what
//! a code means.
//!
//! ```
//! use lostmotion_gcode::Limits;
//! use lostmotion_gcode::syntax::{Block, Value, parse_block};
//!
//! let (line, mut block) = (b"G1 X[2+3] F200 (rough)", Block::default());
//! parse_block(line, &mut block, &Limits::default()).unwrap();
//! let letters: Vec<u8> = block.words.iter().map(|word| word.letter).collect();
//! assert_eq!(letters, b"GXF");
//! assert_eq!(block.words[2].value, Value::Number(200.0));
//!
//! // A fault has the number of bytes that were left where it was found.
//! let fault = parse_block(b"G1 X?", &mut block, &Limits::default()).unwrap_err();
//! assert_eq!(fault.problem.code(), "missing-number");
//! ```

pub mod block;
pub(crate) mod evaluate;
pub mod expression;
pub mod number;
pub mod parse;
pub(crate) mod reading;
pub(crate) mod special;
pub mod tokens;
pub(crate) mod typo;

pub use block::Fault;
pub use block::{Block, Keyword, Label, Op, Setting, Target, Text, Unary, Value, Word};
pub use parse::parse_block;
pub use special::{CORNER_CHAMFER, CORNER_RADIUS, line_checksum};
pub use tokens::{Token, TokenKind, Tokens};
