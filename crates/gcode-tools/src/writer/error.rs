//! Why operations cannot be written.

use lostmotion_base::span::BlockRef;
use lostmotion_gcode::ops::{CanonicalOp, SourcedOp};
use lostmotion_gcode::problem::Problem;

/// Why operations cannot be written as blocks.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriterError {
    /// No block means the same as an operation.
    #[error("{}: {op} cannot be written as a block of its own{got}", block.span)]
    NotWritable {
        /// The operation.
        op: String,
        /// What the nearest block would have meant; may be empty.
        got: String,
        /// The block that the operation came from.
        block: BlockRef,
    },
    /// A block that was written is refused when it is read.
    #[error("{}: the block `{line}` that it would become is refused: {problem}", block.span)]
    Refused {
        /// The block.
        line: String,
        /// Why.
        problem: Box<Problem>,
        /// The block that it came from.
        block: BlockRef,
    },
    /// An arc outside the XY plane while the coordinates are rotated.
    #[error("{}: an arc in the {plane} plane cannot be rotated by {degrees} degrees about Z", block.span)]
    RotatedArc {
        /// Its plane.
        plane: &'static str,
        /// The rotation.
        degrees: f64,
        /// The block that asked for it.
        block: BlockRef,
    },
    /// The frame asked for is rotated.
    #[error(
        "work coordinate system {system} is rotated by {degrees} degrees; take one that is not"
    )]
    RotatedFrame {
        /// The system, 1 for G54.
        system: u8,
        /// Its rotation.
        degrees: f64,
    },
    /// There is no such work coordinate system.
    #[error("work coordinate system {system} does not exist; they go from 1 (G54) to 9 (G59.3)")]
    NoSuchSystem {
        /// The number asked for.
        system: u8,
    },
    /// The program has errors.
    #[error("the program has {errors} errors")]
    Program {
        /// How many.
        errors: u64,
    },
    /// The output cannot be written.
    #[error("cannot write: {0}")]
    Io(#[from] std::io::Error),
}

impl WriterError {
    /// The same at a block.
    pub(super) fn at(self, place: BlockRef) -> WriterError {
        match self {
            WriterError::RotatedArc { plane, degrees, .. } => WriterError::RotatedArc {
                plane,
                degrees,
                block: place,
            },
            other => other,
        }
    }

    pub(super) fn not_writable(
        expected: Option<&SourcedOp>,
        got: Option<&CanonicalOp>,
        text: &str,
    ) -> WriterError {
        WriterError::NotWritable {
            op: expected.map_or("nothing".to_owned(), |sourced| sourced.op.to_string()),
            got: got.map_or(String::new(), |got| {
                format!(": `{}` is {got}", text.trim_end())
            }),
            block: expected.map(|sourced| sourced.block).unwrap_or_default(),
        }
    }
}
