//! Look-ahead planning: program moves in, 1 ms samples of every joint out, all limits kept.

pub mod item;
pub mod sample;

pub use item::{Dwell, FeedLimit, Halt, Move, PathControl, PlanItem};
pub use sample::Sample;
