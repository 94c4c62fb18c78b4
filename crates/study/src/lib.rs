//! Studies of compensators: many machines and motions, one table.
//!
//! [`matrix`] is the wide one: cells of motion, feed, gap, friction, inertia and encoder, each run
//! through the real chain from G-code to contour error with every registered method, each held
//! against the same machine without a gap.
//!
//! [`drawn`] is for judging: machines and programs drawn anew from a seed, which nobody has tuned on.
//!
//! [`paper`] runs the experiments of the paper again, [`mod@bench`] two motors back to back with a
//! coupler that is known, [`endurance`] an axis for an hour.
//!
//! Everything here computes; files are written by the caller.

pub mod bench;
pub mod drawn;
pub mod endurance;
pub mod error;
pub mod matrix;
pub mod paper;

pub use error::StudyError;
