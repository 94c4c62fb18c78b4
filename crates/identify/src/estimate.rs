//! From the windows in contact to coefficients and their spread.

use crate::{
    contact::{Contact, MEDIAN_OF_NORMAL},
    error::{FitError, NotExcited},
    huber::{HUBER_TUNING, Minimiser, Regression},
    result::SolverReport,
    settings::FitSettings,
    solver::{QpSolver, SolveOptions},
    spread::{self, Spread},
};
use lostmotion_base::math::quantile;

/// Rounds in which the residual scale and the fit settle on one another. A choice: the third moves
/// the scale by less than its own error.
const SCALE_ROUNDS: usize = 3;
/// Most samples of the thinned copy on which they settle. A choice: the scale of so many residuals
/// is known to some 3 %.
const MAX_SCALE_SAMPLES: usize = 2000;
/// Most rounds in which the coefficients of torque and rate and the noise that they turn into
/// residuals settle. A choice: one is nearly always enough, since what the instruments lack of the torque is
/// orthogonal to what they tell.
const NOISE_ROUNDS: usize = 4;
/// Relative change of the compliance that counts as none. A choice: far below its standard error.
const SETTLED_SHARE: f64 = 1e-6;
/// Systematic error of averages as a share of the encoders' resolution: no encoder divides its
/// counts more finely, and errors that recur at the same angles do not average out.
pub(crate) const RESOLUTION_SHARE: f64 = 0.02;

/// Positions of the coefficients in an [`Estimate`].
pub(crate) const GAP: usize = 0;
pub(crate) const OFFSET: usize = 1;
pub(crate) const COMPLIANCE: usize = 2;
pub(crate) const DAMPING: usize = 3;
pub(crate) const INERTIA: usize = 4;
pub(crate) const VISCOUS: usize = 5;
pub(crate) const COULOMB: usize = 6;
/// What is left where the load was put right.
pub(crate) const PLACE: usize = 7;
pub(crate) const SPEED: usize = 8;
/// Number of coefficients.
pub(crate) const COEFFICIENTS: usize = 9;

/// Inputs of an estimate.
pub(crate) struct EstimateJob<'a> {
    pub(crate) contact: &'a Contact,
    pub(crate) settings: &'a FitSettings,
    pub(crate) resolution: f64,
    pub(crate) solver: &'a dyn QpSolver,
}

/// Fitted coefficients with their spread, and figures of the residuals.
pub(crate) struct Estimate {
    pub(crate) coefficients: [f64; COEFFICIENTS],
    pub(crate) gap_spread: Spread,
    /// What the half gap changes by for a unit of each sample's position difference.
    pub(crate) gap_pulls: Vec<f64>,
    /// `None` where the compliance is given.
    pub(crate) compliance_spread: Option<Spread>,
    /// `None` where the damping is left out.
    pub(crate) damping_spread: Option<Spread>,
    /// `None` where the load's lateness is left out.
    pub(crate) speed_spread: Option<Spread>,
    pub(crate) delta: f64,
    pub(crate) rms: f64,
    pub(crate) scale: f64,
    pub(crate) outliers: usize,
    pub(crate) solver: SolverReport,
}

impl EstimateJob<'_> {
    /// The regression with these columns, the half gap first; coefficients that are left
    /// out are known, or zero.
    fn regression<const P: usize>(&self, columns: [usize; P]) -> Regression<P> {
        // The wind-up of a known stiffness is subtracted from the targets.
        let known = self
            .settings
            .stiffness_nm_per_rad
            .map_or(0.0, |stiffness| 1.0 / stiffness);
        let samples = || self.contact.samples.iter();
        Regression {
            rows: samples()
                .map(|sample| {
                    let (side, window) = (sample.side, &sample.window);
                    // One column per coefficient, in the order of their places.
                    let all = [
                        side,
                        1.0,
                        sample.told_torque_nm,
                        -sample.told_rate_rad_s,
                        -window.acceleration_rad_s2,
                        -window.velocity_rad_s,
                        -window.velocity_rad_s.signum(),
                        window.position_rad,
                        window.velocity_rad_s,
                    ];
                    columns.map(|column| all[column])
                })
                .collect(),
            targets: samples()
                .map(|sample| sample.window.difference_rad - known * sample.window.torque_nm)
                .collect(),
            // the damping time stays free, since a current logged late lowers it, and so does what
            // is added to the inertia
            nonnegative: columns.map(|column| column == GAP || column == COMPLIANCE),
        }
    }

    /// The regression with the measured torque and rate in the residuals, its rows as told, for
    /// these coefficients of the two.
    fn measured<const P: usize>(
        &self,
        mut regression: Regression<P>,
        [compliance, damping]: [f64; 2],
    ) -> Regression<P> {
        for (target, sample) in regression.targets.iter_mut().zip(&self.contact.samples) {
            *target -= compliance * (sample.window.torque_nm - sample.told_torque_nm);
            *target += damping * (sample.window.rate_rad_s - sample.told_rate_rad_s);
        }
        regression
    }

    pub(crate) fn estimate<const P: usize>(
        &self,
        columns: [usize; P],
    ) -> Result<Estimate, FitError> {
        let told = self.regression(columns);
        let options = SolveOptions {
            tolerance: self.settings.solver_tolerance,
            iterations: self.settings.solver_iterations,
        };
        // Robust two-stage least squares: the rows hold torque and rate as told, the residuals the
        // measured ones, whose noise counts with the coefficients that the round before found.
        let place = columns.iter().position(|&column| column == COMPLIANCE);
        let noisy_of = |x: &[f64; P]| {
            let of = |column| {
                let place = columns.iter().position(|&other| other == column);
                place.map_or(0.0, |place| x[place])
            };
            [of(COMPLIANCE), of(DAMPING)]
        };
        let mut noisy = noisy_of(&told.least_squares());
        // Each fit begins where the one before ended.
        let mut near = None;
        let mut rounds = 1;
        let (regression, delta, minimiser) = loop {
            let regression = self.measured(told.clone(), noisy);
            // Where the loss turns linear: as given, or from the residuals themselves.
            let delta = match self.settings.huber_delta_rad {
                Some(delta) => delta,
                None => self.settle_delta(&regression, &mut near, &options)?,
            };
            let minimiser =
                regression.minimise_from(near.as_ref(), delta, self.solver, &options)?;
            near = Some(minimiser.x);
            let found = noisy_of(&minimiser.x);
            let settled =
                (0..2).all(|j| (found[j] - noisy[j]).abs() <= SETTLED_SHARE * found[j].abs());
            if settled || rounds == NOISE_ROUNDS {
                break (regression, delta, minimiser);
            }
            noisy = found;
            rounds += 1;
        };
        let Minimiser {
            x,
            status,
            iterations,
            solves,
            explicit,
            optimality,
        } = minimiser;
        // Blocks of whole episodes: samples of one contact err alike.
        let episodes: Vec<usize> = self
            .contact
            .samples
            .iter()
            .map(|sample| sample.episode)
            .collect();
        let blocks = spread::blocks(&episodes);
        let thin = || NotExcited::TooFewTraversals {
            seen: self.contact.traversals,
            needed: self.contact.traversals + 1,
        };
        // What is not fitted is known or zero; the fitted ones then take their places.
        let mut coefficients = [0.0; COEFFICIENTS];
        coefficients[COMPLIANCE] = self
            .settings
            .stiffness_nm_per_rad
            .map_or(0.0, |stiffness| 1.0 / stiffness);
        columns
            .iter()
            .zip(x)
            .for_each(|(&column, x)| coefficients[column] = x);
        let residuals: Vec<f64> = (0..regression.targets.len())
            .map(|k| regression.residual(k, &x).abs())
            .collect();
        let spread =
            |which| spread::spread(&regression, &x, delta, &blocks, which).ok_or_else(thin);
        let spread_of = |place: Option<usize>| place.map(spread).transpose();
        Ok(Estimate {
            coefficients,
            gap_spread: spread(0)?,
            gap_pulls: spread::pulls(&regression, &x, delta, 0).ok_or_else(thin)?,
            compliance_spread: spread_of(place)?,
            damping_spread: spread_of(columns.iter().position(|&c| c == DAMPING))?,
            speed_spread: spread_of(columns.iter().position(|&c| c == SPEED))?,
            delta,
            rms: (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt(),
            outliers: residuals.iter().filter(|r| **r > delta).count(),
            scale: quantile(residuals, 0.5) / MEDIAN_OF_NORMAL,
            solver: SolverReport {
                name: self.solver.name().to_owned(),
                status,
                iterations,
                solves,
                explicit_samples: explicit,
                optimality,
            },
        })
    }

    /// Delta as a multiple of the residuals' robust scale, which itself depends on the fit: a few
    /// rounds on a thinned copy, from least squares. The scale is not let below what the encoders
    /// resolve, nor below what rounding leaves of the data. `near` is where the fits begin, and
    /// where the last one ended.
    fn settle_delta<const P: usize>(
        &self,
        regression: &Regression<P>,
        near: &mut Option<[f64; P]>,
        options: &SolveOptions,
    ) -> Result<f64, FitError> {
        let thinned = regression.thinned(MAX_SCALE_SAMPLES);
        let count = thinned.targets.len().max(1) as f64;
        // The scale's floor: encoder resolution, then rounding at the size of the data.
        let size = (thinned.targets.iter().map(|y| y * y).sum::<f64>() / count).sqrt();
        let floor = (RESOLUTION_SHARE * self.resolution)
            .max(1e-9 * size)
            .max(f64::MIN_POSITIVE.sqrt());
        let scale_around = |x: &[f64; P]| {
            let residuals = (0..thinned.targets.len())
                .map(|k| thinned.residual(k, x).abs())
                .collect();
            HUBER_TUNING * (quantile(residuals, 0.5) / MEDIAN_OF_NORMAL).max(floor)
        };
        let mut delta = scale_around(&thinned.least_squares());
        // Residuals depend on delta, and delta on the residuals: alternated.
        for _ in 0..SCALE_ROUNDS {
            let found = thinned.minimise_from(near.as_ref(), delta, self.solver, options)?;
            delta = scale_around(&found.x);
            *near = Some(found.x);
        }
        Ok(delta)
    }
}
