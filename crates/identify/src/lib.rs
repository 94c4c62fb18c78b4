//! Offline identification of an axis' backlash from a log.
//!
//! [`fit_backlash`] is the fit with the **load's position known** (a linear scale, a ballbar's
//! radius, a simulation): it finds the half gap `b`, the shaft's compliance `c` and the zero offset
//! `o` of one axis by the convex problem
//!
//! ```text
//! minimise  sum_k Huber_delta( y_k - s_k b - c T_k + tau y'_k - o ),   b >= 0,  c >= 0
//! y = theta_M - theta_L,   T = K_t i - J_M alpha - b_v w - T_cM sign(w),   s = sign(T)
//! ```
//!
//! The contact torque is `T = k (y - s b) + d y'` while in contact, so `c = 1/k` and `tau = d/k`.
//! The damping term is small, but it does not average out: the rising flank of a contact is spent
//! on settling and left out, the falling one is used, and without `tau` the half gap comes out
//! large by several standard errors.
//!
//! over the samples in which the shaft is in firm contact. All angles are motor-side: rad at the
//! motor shaft.
//!
//! How one log becomes one number, in order:
//! 1. [`BacklashLog`] holds the three columns and checks them; rows at uneven times are carried over
//!    to even ones.
//! 2. `plausible` refuses units, signs and columns that cannot be right.
//! 3. [`window`] averages position difference and contact torque with one and the same triangular
//!    window, so that the acceleration needs no separate filter and no lag arises between the two
//!    sides of the equation.
//! 4. [`contact`] keeps the samples in firm contact, grouped into episodes of one side each; the
//!    side comes from the position difference (`deadzone`), so that noise of the current selects
//!    nothing.
//! 5. `instruments` tells torque and rate free of their noise (two-stage least squares): noise in a
//!    regressor would make the gap too large.
//! 6. [`huber`] solves the convex problem exactly, through a [`solver::QpSolver`].
//! 7. [`spread`] gives the standard error from the scatter between whole blocks of the log.
//!
//! [`motor_only`] fits the gap from the motor's signals alone: the load's motion
//! follows from the contact torque. [`body`] takes the axis as one body: inertia, friction, servo,
//! and how position is lost along the travel after a reversal.

mod averages;
mod axis_fit;
pub mod body;
pub mod contact;
mod deadzone;
mod described;
pub mod error;
mod estimate;
mod even;
pub mod fit;
pub mod huber;
mod instruments;
mod jitter;
mod lateness;
pub mod log;
pub mod motor_only;
mod plausible;
pub mod result;
mod rounding;
pub mod settings;
pub mod solver;
pub mod spread;
pub mod window;

pub use axis_fit::{
    AxisFitError, AxisRows, FIT_SCHEMA, FitResult, LoadStiffness, UnitMismatch, fit_axis,
    motor_rad_per_unit,
};
pub use error::{Cause, FitError, NotExcited};
pub use fit::{fit_backlash, fit_backlash_with};
pub use log::{BacklashLog, MotorLog};
pub use motor_only::{fit_motor_only, fit_motor_only_with};
pub use result::{BacklashFit, FittedLoad, Otherwise, Presumed, SolverReport};
pub use settings::{FitSettings, LATENESS_S};
