//! The contact torque without the noise of the current: instrumental variables.
//!
//! In `y = s b + c T - tau y' + o` the torque `T` is measured with the noise of the current and the
//! rate `y'` with the rounding of the scale. Least squares takes these regressors for exact, finds
//! too small a compliance `c` (attenuation, errors in variables) and gives what is missing of the
//! wind-up to the gap `b`: always too large, and the surer the longer the log. The cure are
//! instruments: quantities that go with the true torque and rate but have no part in their noise.
//! Here they are torque and position difference of the same contact some windows earlier and later,
//! their mean and their change. The current's noise is independent from sample to sample, and so is
//! the rounding of a moving axis; the motion is not.
//!
//! Two-stage least squares (Theil 1953, Basmann 1957): torque and rate are regressed on the
//! instruments and on the fit's exact columns; the predictions then take their places in the fit.
//! What they lack of the truth is orthogonal to everything in the fit, so nothing is presumed of
//! load, friction or motion.
//!
//! The residuals, and with them loss and standard error, are those with the measured values, see
//! `estimate`.

use crate::{
    contact::{Contact, ContactSample},
    huber::Regression,
    window::WindowSample,
};

/// Windows between a window and its instruments: triangles two apart share no sample, but the second
/// differences of three apart do not even share an end.
const LAG: usize = 3;

/// Which exact columns a fit has beside side and offset: they are instruments, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exact {
    /// None: the motor is known.
    Sides,
    /// The motor's acceleration: its inertia is not.
    Acceleration,
    /// Acceleration, velocity and its sign: nor is its friction.
    Motion,
}

/// The contact with each sample's torque and rate as told by its instruments; samples that have
/// none in their contact are left out.
pub(crate) fn tell(mut contact: Contact, windows: &[WindowSample], exact: Exact) -> Contact {
    let mut rows = Vec::with_capacity(contact.samples.len());
    let sides = &contact.sides;
    contact.samples.retain(|sample| {
        let told = instruments(sample, sides, windows);
        rows.extend(told.map(|[mean, torque, change, torque_change]| {
            [sample.side, 1.0, mean, torque, change, torque_change]
        }));
        told.is_some()
    });
    // An acceleration that is no column of the fit would be no instrument either: its own noise (an
    // unsteady sampling time) is part of the torque's.
    match exact {
        Exact::Sides => predict(&mut contact.samples, rows),
        Exact::Acceleration => {
            let rows = rows
                .iter()
                .zip(&contact.samples)
                .map(|(&[a, b, c, d, e, f], sample)| {
                    [a, b, c, d, e, f, sample.window.acceleration_rad_s2]
                })
                .collect();
            predict(&mut contact.samples, rows);
        }
        Exact::Motion => {
            let rows = rows
                .iter()
                .zip(&contact.samples)
                .map(|(&[a, b, c, d, e, f], sample)| {
                    let motor = &sample.window;
                    let (acceleration, velocity) =
                        (motor.acceleration_rad_s2, motor.velocity_rad_s);
                    [a, b, c, d, e, f, acceleration, velocity, velocity.signum()]
                })
                .collect();
            predict(&mut contact.samples, rows);
        }
    }
    contact
}

/// The first stage: torque and rate as these columns tell them.
fn predict<const P: usize>(samples: &mut [ContactSample], rows: Vec<[f64; P]>) {
    let mut stage = Regression {
        rows,
        targets: Vec::new(),
        nonnegative: [false; P],
    };
    let mut told = |measured: fn(&WindowSample) -> f64| -> Vec<f64> {
        stage.targets = samples.iter().map(|s| measured(&s.window)).collect();
        let coefficients = stage.least_squares();
        (0..stage.targets.len())
            .map(|k| stage.targets[k] - stage.residual(k, &coefficients))
            .collect()
    };
    let torques = told(|window| window.torque_nm);
    let rates = told(|window| window.rate_rad_s);
    for ((sample, torque), rate) in samples.iter_mut().zip(torques).zip(rates) {
        sample.told_torque_nm = torque;
        sample.told_rate_rad_s = rate;
    }
}

/// Mean and change of position difference and torque from [`LAG`] windows before to [`LAG`] windows
/// after, if both belong to the same contact.
fn instruments(sample: &ContactSample, sides: &[i8], windows: &[WindowSample]) -> Option<[f64; 4]> {
    let (first, last) = (sample.index.checked_sub(LAG)?, sample.index + LAG);
    // One contact throughout, not another on the same flank after a bounce.
    let side = sample.side as i8;
    let same = sides.get(first..=last)?.iter().all(|other| *other == side);
    let (before, after) = (windows.get(first)?, windows.get(last)?);
    let certain = |window: &WindowSample| window.one_way && window.whole;
    (same && certain(before) && certain(after)).then_some([
        0.5 * (before.difference_rad + after.difference_rad),
        0.5 * (before.torque_nm + after.torque_nm),
        after.difference_rad - before.difference_rad,
        after.torque_nm - before.torque_nm,
    ])
}
