//! Errors in the input of tracker and circular test.

use lostmotion_base::Tick;

/// An input that is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContourError {
    /// Segments pushed out of order.
    #[error("segment {pushed} was pushed after segment {last}; running numbers have to grow")]
    Order {
        /// The one pushed.
        pushed: u64,
        /// The one before.
        last: u64,
    },
    /// A sample whose commanded segment is not held: not pushed yet, or released.
    #[error(
        "the command at tick {tick} is on segment {segment}, which is not held ({held}); push segments before their samples"
    )]
    UnknownSegment {
        /// When.
        tick: Tick,
        /// The segment that the sample names.
        segment: u64,
        /// What is held.
        held: String,
    },
    /// A sample with a coordinate that is not a finite number.
    #[error("{what} at tick {tick} is not finite: {values:?}")]
    NotFinite {
        /// When.
        tick: Tick,
        /// Which vector.
        what: &'static str,
        /// Its values.
        values: [f64; 3],
    },
    /// A circle without a radius, or too few samples on one.
    #[error("a circular test needs {what}")]
    Circle {
        /// What is missing, with values.
        what: String,
    },
}
