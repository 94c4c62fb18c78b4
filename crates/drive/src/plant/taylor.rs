//! The solution within a step as a polynomial of time.

use super::dynamics::{Held, LOAD, Vector};
use super::mode::Mode;
use super::params::PlantParams;

/// Degree of the polynomial. With `rate * span <= 0.5` the remainder is below 0.5^15/15! = 2e-17 of
/// the states.
const DEGREE: usize = 14;
/// Number of its coefficients.
pub(super) const COEFFICIENTS: usize = DEGREE + 1;

/// States over `span` seconds as a polynomial of tau = t/span in [0, 1].
pub(super) struct Taylor {
    coefficients: [Vector; COEFFICIENTS],
}

impl Taylor {
    pub(super) fn new(
        params: &PlantParams,
        mode: Mode,
        x: &Vector,
        held: &Held,
        span: f64,
    ) -> Taylor {
        let mut coefficients = [*x; COEFFICIENTS];
        let mut derivative = params.linear(mode, x);
        for (d, f) in derivative.iter_mut().zip(params.forcing(mode, held)) {
            *d += f;
        }
        for (n, coefficient) in coefficients.iter_mut().enumerate().skip(1) {
            let factor = span / n as f64;
            let term = derivative.map(|d| d * factor);
            *coefficient = term;
            derivative = params.linear(mode, &term);
        }
        Taylor { coefficients }
    }

    /// A linear functional of the states, as a polynomial of tau.
    pub(super) fn functional(&self, offset: f64, row: &Vector) -> [f64; COEFFICIENTS] {
        let mut out = self
            .coefficients
            .map(|c| row[0] * c[0] + row[1] * c[1] + row[2] * c[2] + row[3] * c[3]);
        out[0] += offset;
        out
    }

    /// States at tau, and how far the load went since tau = 0 over the given span.
    pub(super) fn at(&self, tau: f64, span: f64) -> (Vector, f64) {
        let mut x = [0.0; 4];
        let mut travel = 0.0;
        for (n, c) in self.coefficients.iter().enumerate().rev() {
            for (sum, entry) in x.iter_mut().zip(c) {
                *sum = *sum * tau + entry;
            }
            travel = travel * tau + c[LOAD] / (n + 1) as f64;
        }
        (x, travel * (tau * span))
    }
}
