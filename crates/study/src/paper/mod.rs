//! The experiments of the paper: Gan, Wang, Huang, *Adaptive Backlash Compensation for CNC
//! Machining Applications*, Machines 2023, 11(2), 193.
//!
//! The paper's axis (its Tables 2 and 3, the preset `paper`) moves there and back, without
//! compensation and with the published one. Figures 3 and 7 to 11 are drawn again from our
//! simulation. The paper does not say how far and how fast the axis moved, nor P0 and lambda; these
//! are chosen, said so, and scanned.

pub mod figures;
pub mod motion;
pub mod outlook;
pub mod text;
mod trial;

pub use motion::Move;
pub use outlook::{ShaftTrial, shaft_trials};
pub use trial::{FORMS, Outcome, Scan, ScanPoint, Trial, Trials, scan, trials};

/// Part of half a gap that the paper's "less than 15 %" means.
pub const CLAIM: f64 = 0.15;
