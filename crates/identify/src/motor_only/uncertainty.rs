//! Uncertainty beside the gap: noise of the current, which adds up in the load's motion, and
//! coefficients that are known roughly.
//!
//! White noise of the torque becomes an integrated random walk of the load's place. Between two
//! windows that the load has been under way for `s <= t` its covariance is
//! ```text
//! p^2 q s^2 (3 t - s)/6,      q = (K_t sigma_i)^2 T
//! ```
//! beside the white noise of a window. [`Drift`] turns a crossing's equations into ones whose
//! errors are alike and independent (generalised least squares), so that each window counts by
//! its information. A prior is one more equation for a coefficient: its presumed value, weighed by
//! its standard deviation.

use faer::{Mat, Side, linalg::solvers::Llt};

use super::segments::{
    CURRENT_LATENESS, DAMPING_TIME, DRAG, FRICTION, INVERSE_INERTIA, RESTING_RATE, SLIDING_RATE,
};
use crate::result::FittedLoad;

/// How well inertia and friction of the load are known from where it slides, as a part of them.
const LOAD_UNCERTAINTY: f64 = 1e-2;
/// Part of the walk that is weighed. In full it would make the windows' differences count most, in
/// which the noise of the torque exceeds its changes: the compliance comes out too small then, to a
/// fifth, and the gap too large.
const WALK_SHARE: f64 = 0.1;
/// How late a sampled current may be, in sampling periods. A choice: half, as of a mean over the
/// period.
const MAX_LATENESS: f64 = 0.5;
/// Longest damping time d/k of a shaft, s. Derived: 10 % of critical damping at 16 Hz, below the
/// first resonance of any feed drive.
const MAX_DAMPING_TIME_S: f64 = 2e-3;

/// Scale and compliance that a round of the fit found, for the next one.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoundResult {
    /// Robust standard deviation of the residuals, rad.
    pub(super) deviation: f64,
    /// rad/(N m).
    pub(super) compliance: f64,
}

/// Quantities known before the crossings are fitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct PriorKnowledge {
    /// Standard deviation of the noise of the motor's torque, N m.
    pub(super) torque_noise_nm: f64,
    /// Time between samples, s.
    pub(super) period_s: f64,
    /// Time between windows, s.
    pub(super) spacing_s: f64,
    /// The load as it was found while it slides.
    pub(super) load: FittedLoad,
    /// Largest speed of the motor, rad/s.
    pub(super) fastest_rad_s: f64,
    /// Largest contact torque, N m.
    pub(super) largest_nm: f64,
}

impl PriorKnowledge {
    /// The current's noise as it adds up in the load's place.
    pub(super) fn drift(&self, found: &RoundResult) -> Drift {
        if self.load.inertia_kgm2 <= 0.0 {
            return Drift(0.0);
        }
        // Noise of the torque as a random walk of the speed, then of the place, in window
        // deviations.
        let speed = self.torque_noise_nm * self.period_s.sqrt() / self.load.inertia_kgm2;
        let walk = WALK_SHARE * speed * self.spacing_s * self.spacing_s.sqrt() / found.deviation;
        Drift(walk * walk)
    }

    /// Priors of the coefficients other than gap and compliance.
    pub(super) fn priors(&self, found: &RoundResult) -> Vec<Prior> {
        let FittedLoad {
            inertia_kgm2,
            viscous_nm_s_per_rad,
            coulomb_nm,
            ..
        } = self.load;
        if inertia_kgm2 <= 0.0 {
            return Vec::new();
        }
        // Doubts: one per cent of the load, half a sample of the current, a shaft's damping time.
        let (p, late) = (1.0 / inertia_kgm2, MAX_LATENESS * self.period_s);
        let friction = LOAD_UNCERTAINTY * (coulomb_nm + LOAD_UNCERTAINTY * self.largest_nm);
        let compliance = found.compliance.max(1e-9);
        let of = |column, value, deviation| Prior {
            column,
            value,
            deviation,
        };
        vec![
            of(SLIDING_RATE, 0.0, compliance * MAX_DAMPING_TIME_S),
            of(INVERSE_INERTIA, p, LOAD_UNCERTAINTY * p),
            of(FRICTION, 0.0, p * friction),
            of(CURRENT_LATENESS, 0.0, p * late),
            of(DAMPING_TIME, 0.0, MAX_DAMPING_TIME_S),
            of(RESTING_RATE, 0.0, compliance * late),
            of(
                DRAG,
                p * viscous_nm_s_per_rad,
                p * friction / self.fastest_rad_s,
            ),
        ]
    }
}

/// Covariance of the load's place, over the variance of a window, for times in windows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drift(pub(super) f64);

impl Drift {
    /// The lower triangle that whitens windows, from how long the load has been under way in each,
    /// in windows; `None` if there is nothing to whiten.
    pub(super) fn whitener(self, under_way: &[f64]) -> Option<Mat<f64>> {
        if self.0 <= 0.0 {
            return None;
        }
        let size = under_way.len();
        let covariance = Mat::from_fn(size, size, |i, j| {
            // Integrated random walk and white noise (head of the module).
            let (s, t) = (
                under_way[i].min(under_way[j]),
                under_way[i].max(under_way[j]),
            );
            f64::from(u8::from(i == j)) + self.0 * s * s * (3.0 * t - s) / 6.0
        });
        Llt::new(covariance.as_ref(), Side::Lower)
            .ok()
            .map(|factor| factor.L().to_owned())
    }
}

/// Solves `L x = values` in place.
pub(super) fn whiten(lower: &Mat<f64>, values: &mut [f64]) {
    for i in 0..values.len() {
        let known: f64 = (0..i).map(|j| lower[(i, j)] * values[j]).sum();
        values[i] = (values[i] - known) / lower[(i, i)];
    }
}

/// A coefficient as it is known before the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Prior {
    /// Place of the coefficient.
    pub(super) column: usize,
    /// Its presumed value.
    pub(super) value: f64,
    /// Standard deviation.
    pub(super) deviation: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitened_random_walks_are_white() {
        // independent draws of the integrated walk, whitened, have the unit covariance; here by its
        // definition L L' = C
        let under_way = [0.0, 0.0, 1.0, 2.5, 4.0];
        let lower = Drift(0.3).whitener(&under_way).unwrap();
        let walk = |s: f64, t: f64| 0.3 * s * s * (3.0 * t - s) / 6.0;
        for j in 0..5 {
            let mut column: Vec<f64> = (0..5)
                .map(|k| {
                    walk(
                        under_way[k].min(under_way[j]),
                        under_way[k].max(under_way[j]),
                    )
                })
                .collect();
            column[j] += 1.0;
            whiten(&lower, &mut column);
            // L^-1 C e_j = L' e_j
            for (i, value) in column.into_iter().enumerate() {
                let wanted = if i <= j { lower[(j, i)] } else { 0.0 };
                assert!((value - wanted).abs() < 1e-12, "{i} {j}: {value} {wanted}");
            }
        }
        assert!(Drift(0.0).whitener(&under_way).is_none());
    }
}
