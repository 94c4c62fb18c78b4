//! The fit from the motor alone: motor position and current, no load position.
//!
//! The contact torque `T = K_t i - J_M alpha - b_v w - T_cM sign(w)` is data, so the load's motion
//! follows from it but for the load's inertia and a few constants (`segments`). Over the windows in
//! firm contact of all crossings, with one set of constants for each,
//! ```text
//! minimise  sum Huber_delta( theta_M - x_L - s b - c T + c tau T' ),   b >= 0, c >= 0, p = 1/J_L >= 0
//! ```
//! is convex (`program`). The load's dynamics hold exactly within a crossing, which is the limit of
//! the tight weights that such a fit needs; between crossings nothing is assumed, so that errors of
//! the torque do not add up over the log.
//!
//! 1. `sides`: flank of each window from the torque.
//! 2. `load`: inertia and friction of the load while it slides in contact.
//! 3. `segments`: crossings in which it certainly rests or certainly slides, judged by that
//!    friction.
//! 4. `program` and a second round without the crossings that do not fit: their labels were wrong.
//! 5. `uncertainty`: how the current's noise adds up in the load's motion, and what the priors hold of the
//!    other coefficients.
//! 6. [`crate::spread`] over whole crossings.
//!
//! The torque is added up twice there, and with it the noise of the current: at 1 kHz with the noise
//! of a usual drive nothing is left. So where the crossings leave a wide interval, or none,
//!
//! 7. `replayed` drives a load through gap and shaft by the measured motion of the motor and looks
//!    for the gap, the shaft and the load whose torque is the measured one: `replay` integrates,
//!    `search` looks for the minimum from many starts, `interval` profiles the cost over the gap.
//!
//! Not determined from the motor alone: the middle of the gap (every crossing has its own zero),
//! and with it whether the two half gaps differ.

mod fit;
mod interval;
mod load;
mod profile;
mod program;
mod replay;
mod replayed;
mod search;
mod segments;
mod sides;
mod uncertainty;

pub use fit::{fit_motor_only, fit_motor_only_with};
