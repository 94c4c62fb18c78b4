//! Inertia and friction of the load, from the windows in firm contact while it slides.

use super::sides::Sides;
use crate::{
    error::FitError,
    huber::{HUBER_TUNING, Regression},
    result::FittedLoad,
    settings::FitSettings,
    solver::{QpSolver, SolveOptions},
    window::WindowSample,
};

/// Least windows of sliding contact from which the load's inertia and friction are estimated.
const MIN_SLIDING_WINDOWS: usize = 20;
/// Share of the largest speed below which the direction of sliding is not sure.
const SLOW_SHARE: f64 = 0.02;
/// Most windows that the regression takes; of more, every n-th. A choice: bounds the work; windows
/// beside each other tell the same.
const MAX_SLIDING_WINDOWS: usize = 4000;

/// `T = J alpha + b w + T_f sign(w) + T_0` over the windows that slide in settled contact.
pub(super) fn find_load(
    windows: &[WindowSample],
    sides: &Sides,
    settle: usize,
    settings: &FitSettings,
    solver: &dyn QpSolver,
) -> Result<Option<FittedLoad>, FitError> {
    // Friction acts against the motion: its sign is certain where the speed is not small.
    let fastest = windows
        .iter()
        .map(|window| window.rate_rad_s.abs())
        .fold(0.0, f64::max);
    let slides = |n: usize| windows[n].rate_rad_s.abs() > SLOW_SHARE * fastest;
    // settled: the same side and the same direction for the settling time
    let mut since = 0;
    let mut chosen = Vec::new();
    for n in 1..windows.len() {
        let same = sides.of(n) != 0
            && sides.of(n) == sides.of(n - 1)
            && windows[n].rate_rad_s * windows[n - 1].rate_rad_s > 0.0;
        since = if same && slides(n) { since + 1 } else { 0 };
        if since > settle && sides.firm(n) {
            chosen.push(n);
        }
    }
    if chosen.len() < MIN_SLIDING_WINDOWS {
        return Ok(None);
    }
    // Thinned evenly over the log.
    let step = chosen.len().div_ceil(MAX_SLIDING_WINDOWS);
    let taken = || chosen.iter().step_by(step).map(|&n| &windows[n]);
    // With one direction alone, friction and constant torque look alike.
    let both = taken().any(|w| w.rate_rad_s > 0.0) && taken().any(|w| w.rate_rad_s < 0.0);
    if !both {
        return Ok(None);
    }
    // Inertia, viscous and Coulomb friction, which are not negative, and the constant torque.
    let regression = Regression {
        rows: taken()
            .map(|w| {
                [
                    w.acceleration_rad_s2,
                    w.rate_rad_s,
                    w.rate_rad_s.signum(),
                    1.0,
                ]
            })
            .collect(),
        targets: taken().map(|w| w.torque_nm).collect(),
        nonnegative: [true, true, true, false],
    };
    // Robust scale of the residuals of least squares, from which delta follows.
    let start = regression.least_squares();
    let residuals = (0..regression.targets.len())
        .map(|k| regression.residual(k, &start).abs())
        .collect();
    let scale = lostmotion_base::math::quantile(residuals, 0.5) / crate::contact::MEDIAN_OF_NORMAL;
    let options = SolveOptions {
        tolerance: settings.solver_tolerance,
        iterations: settings.solver_iterations,
    };
    let delta = (HUBER_TUNING * scale).max(1e-9 * sides.largest_nm());
    let [inertia_kgm2, viscous_nm_s_per_rad, coulomb_nm, constant_nm] =
        regression.minimise(delta, solver, &options)?.x;
    Ok(Some(FittedLoad {
        inertia_kgm2,
        viscous_nm_s_per_rad,
        coulomb_nm,
        constant_nm,
    }))
}
