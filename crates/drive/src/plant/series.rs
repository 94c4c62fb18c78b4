//! Arithmetic of power series, one coefficient at a time: what a product, a sine or an exponential
//! of series adds at order n follows from the orders up to n. Source: the recurrences of automatic
//! differentiation, as in Jorba and Zou, *A Software Package for the Numerical Integration of ODEs
//! by Means of High-Order Taylor Methods* (Experimental Mathematics 14, 2005).

use super::dynamics::COEFFICIENTS;
use super::params::{Bell, Wave};
use lostmotion_base::math;

/// Coefficients by powers of tau in [0, 1].
pub(super) type Series = [f64; COEFFICIENTS];
pub(super) const NOTHING: Series = [0.0; COEFFICIENTS];

/// The series' value at tau.
pub(super) fn value(series: &Series, tau: f64) -> f64 {
    series.iter().rev().fold(0.0, |sum, c| sum * tau + c)
}

/// Coefficient n of a product.
#[inline]
pub(super) fn product(a: &Series, b: &Series, n: usize) -> f64 {
    a[..=n]
        .iter()
        .zip(b[..=n].iter().rev())
        .map(|(x, y)| x * y)
        .sum()
}

/// Sum over k of `k inner_k outer_(n-k)`, over n: coefficient n of a series whose derivative is
/// `outer inner'`.
#[inline]
fn chain(inner: &Series, outer: &Series, n: usize) -> f64 {
    let mut sum = 0.0;
    for k in 1..=n {
        sum += k as f64 * inner[k] * outer[n - k];
    }
    sum / n as f64
}

/// `amplitude sin(per_rad angle + phase)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sine {
    wave: Wave,
    pub(super) sin: Series,
    cos: Series,
}

impl Sine {
    pub(super) fn new(wave: Wave) -> Sine {
        Sine {
            wave,
            sin: NOTHING,
            cos: NOTHING,
        }
    }

    /// Coefficient n of it.
    pub(super) fn extend(&mut self, angle: &Series, n: usize) -> f64 {
        let f = self.wave.per_rad;
        if n == 0 {
            // values at the start; higher orders from the derivative, cos times the inner
            // derivative
            (self.sin[0], self.cos[0]) = math::sin_cos(f * angle[0] + self.wave.phase_rad);
        } else {
            self.sin[n] = f * chain(angle, &self.cos, n);
            self.cos[n] = -f * chain(angle, &self.sin, n);
        }
        self.wave.amplitude * self.sin[n]
    }
}

/// `exp(-u^2)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gauss {
    square: Series,
    pub(super) value: Series,
}

impl Gauss {
    pub(super) const NEW: Gauss = Gauss {
        square: NOTHING,
        value: NOTHING,
    };

    pub(super) fn extend(&mut self, u: &Series, n: usize) {
        // exp of a series: its derivative is itself times the inner derivative
        self.square[n] = -product(u, u, n);
        self.value[n] = if n == 0 {
            math::exp(self.square[0])
        } else {
            chain(&self.square, &self.value, n)
        };
    }
}

/// Width of a worn gap over the load's place, and how it changes along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Width {
    bell: Bell,
    u: Series,
    gauss: Gauss,
    /// Times the gap elsewhere.
    pub(super) times: Series,
    /// Its derivative along the place, 1/rad.
    pub(super) slope: Series,
}

impl Width {
    pub(super) fn new(bell: Bell) -> Width {
        Width {
            bell,
            u: NOTHING,
            gauss: Gauss::NEW,
            times: NOTHING,
            slope: NOTHING,
        }
    }

    pub(super) fn extend(&mut self, place: &Series, n: usize) {
        let Bell {
            excess,
            at_rad,
            width_rad,
        } = self.bell;
        // distance from the middle of the worn place in widths of the bell
        self.u[n] = if n == 0 { place[0] - at_rad } else { place[n] } / width_rad;
        self.gauss.extend(&self.u, n);
        self.times[n] = excess * self.gauss.value[n];
        if n == 0 {
            self.times[0] += 1.0;
        }
        // derivative of the bell along the place
        self.slope[n] = -2.0 * excess / width_rad * product(&self.u, &self.gauss.value, n);
    }
}
