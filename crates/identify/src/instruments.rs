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

/// Variance of the rounding of the position difference, in parts of its variance within the sides, up to
/// which its mean is an instrument. A choice: at speeds of whole counts per row the rounding of a stroke
/// is one and the same, which makes the mean go with what is left of the fit.
const ROUNDING_SHARE: f64 = 1e-2;

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

/// Which exact columns a fit has for how the load is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Beside {
    /// None: as the motor.
    Nothing,
    /// The motor's speed: later or earlier.
    Speed,
    /// Speed and place: its lengths differ, too.
    PlaceAndSpeed,
}

/// F statistic of the instruments from which on they tell the torque. Staiger and Stock (1997): below, what
/// they tell is partly its noise, and intervals miss.
pub(crate) const LEAST_STRENGTH: f64 = 10.0;

/// Columns of a sample: the exact ones of every fit, those that go with the motor's own inertia and
/// friction, and the instruments.
const SIDE: usize = 0;
const OFFSET: usize = 1;
const ACCELERATION: usize = 2;
const VELOCITY: usize = 3;
const DIRECTION: usize = 4;
const TORQUE: usize = 5;
const TORQUE_CHANGE: usize = 6;
const DIFFERENCE_CHANGE: usize = 7;
const DIFFERENCE: usize = 8;
const PLACE: usize = 9;
const COLUMNS: usize = 10;
/// The instruments; the last one only where rounding is fine.
const INSTRUMENTS: [usize; 4] = [TORQUE, TORQUE_CHANGE, DIFFERENCE_CHANGE, DIFFERENCE];

/// The contact with each sample's torque and rate as told by its instruments; samples that have
/// none in their contact are left out; with the instruments' F statistic. Where rounding is not fine beside
/// the wind-up, the mean of the position difference is none of them.
pub(crate) fn tell(
    mut contact: Contact,
    windows: &[WindowSample],
    exact: Exact,
    finely: bool,
    beside: Beside,
) -> (Contact, f64) {
    let mut rows = Vec::with_capacity(contact.samples.len());
    let sides = &contact.sides;
    contact.samples.retain(|sample| {
        let told = instruments(sample, sides, windows);
        rows.extend(told.map(|[torque, torque_change, change, mean]| {
            let motor = &sample.window;
            [
                sample.side,
                1.0,
                motor.acceleration_rad_s2,
                motor.velocity_rad_s,
                motor.velocity_rad_s.signum(),
                torque,
                torque_change,
                change,
                mean,
                motor.position_rad,
            ]
        }));
        told.is_some()
    });
    let mut stage = Stage {
        samples: &mut contact.samples,
        rows: &rows,
    };
    // An acceleration that is no column of the fit would be no instrument either: its own noise (an
    // unsteady sampling time) is part of the torque's.
    let exact: &[usize] = match (exact, beside) {
        (Exact::Sides, Beside::Nothing) => &[SIDE, OFFSET],
        (Exact::Sides, Beside::Speed) => &[SIDE, OFFSET, VELOCITY],
        (Exact::Sides, Beside::PlaceAndSpeed) => &[SIDE, OFFSET, PLACE, VELOCITY],
        (Exact::Acceleration, Beside::Nothing) => &[SIDE, OFFSET, ACCELERATION],
        (Exact::Acceleration, Beside::Speed) => &[SIDE, OFFSET, ACCELERATION, VELOCITY],
        (Exact::Acceleration, Beside::PlaceAndSpeed) => {
            &[SIDE, OFFSET, ACCELERATION, PLACE, VELOCITY]
        }
        (Exact::Motion, Beside::Nothing | Beside::Speed) => {
            &[SIDE, OFFSET, ACCELERATION, VELOCITY, DIRECTION]
        }
        (Exact::Motion, Beside::PlaceAndSpeed) => {
            &[SIDE, OFFSET, ACCELERATION, VELOCITY, DIRECTION, PLACE]
        }
    };
    let strength = stage.tell(exact, finely);
    (contact, strength)
}

/// Whether the rounding of the position difference, of this standard deviation, is small beside its variation
/// within the sides.
pub(crate) fn rounds_finely(contact: &Contact, resolution_rad: f64) -> bool {
    let mut within = 0.0;
    for side in [1.0, -1.0] {
        let differences = || {
            let of_side = contact.samples.iter().filter(|sample| sample.side == side);
            of_side.map(|sample| sample.window.difference_rad)
        };
        let mean = differences().sum::<f64>() / differences().count().max(1) as f64;
        let squares = differences().map(|value| (value - mean) * (value - mean));
        within += squares.sum::<f64>();
    }
    let rounding = resolution_rad * resolution_rad * contact.samples.len() as f64;
    rounding <= ROUNDING_SHARE * within
}

/// The first stage.
struct Stage<'a> {
    samples: &'a mut [ContactSample],
    rows: &'a [[f64; COLUMNS]],
}

impl Stage<'_> {
    /// Torque and rate as exact columns and instruments tell them; returns the instruments' F
    /// statistic for the torque, how far they tell more of it than the exact columns alone.
    fn tell(&mut self, exact: &[usize], finely: bool) -> f64 {
        let instruments = &INSTRUMENTS[..if finely { 4 } else { 3 }];
        let alone = self.left(exact, |window| window.torque_nm);
        let columns = [exact, instruments].concat();
        let torques = self.left(&columns, |window| window.torque_nm);
        let rates = self.left(&columns, |window| window.rate_rad_s);
        let square = |left: &[f64]| left.iter().map(|value| value * value).sum::<f64>();
        let (without, with) = (square(&alone), square(&torques));
        let freedom = self.samples.len().saturating_sub(columns.len()) as f64;
        for ((sample, torque), rate) in self.samples.iter_mut().zip(torques).zip(rates) {
            sample.told_torque_nm = sample.window.torque_nm - torque;
            sample.told_rate_rad_s = sample.window.rate_rad_s - rate;
        }
        (without - with) / instruments.len() as f64 / (with / freedom)
    }

    /// What columns leave of a quantity in each sample.
    fn left(&self, columns: &[usize], measured: fn(&WindowSample) -> f64) -> Vec<f64> {
        // The number of columns is part of the regression's type.
        match *columns {
            [a, b] => self.left_by([a, b], measured),
            [a, b, c] => self.left_by([a, b, c], measured),
            [a, b, c, d] => self.left_by([a, b, c, d], measured),
            [a, b, c, d, e] => self.left_by([a, b, c, d, e], measured),
            [a, b, c, d, e, f] => self.left_by([a, b, c, d, e, f], measured),
            [a, b, c, d, e, f, g] => self.left_by([a, b, c, d, e, f, g], measured),
            [a, b, c, d, e, f, g, h] => self.left_by([a, b, c, d, e, f, g, h], measured),
            [a, b, c, d, e, f, g, h, i] => self.left_by([a, b, c, d, e, f, g, h, i], measured),
            _ => self.left_by(std::array::from_fn::<_, COLUMNS, _>(|at| at), measured),
        }
    }

    fn left_by<const P: usize>(
        &self,
        columns: [usize; P],
        measured: fn(&WindowSample) -> f64,
    ) -> Vec<f64> {
        let stage = Regression {
            rows: self
                .rows
                .iter()
                .map(|row| columns.map(|column| row[column]))
                .collect(),
            targets: self.samples.iter().map(|s| measured(&s.window)).collect(),
            nonnegative: [false; P],
        };
        let coefficients = stage.least_squares();
        (0..stage.targets.len())
            .map(|k| stage.residual(k, &coefficients))
            .collect()
    }
}

/// Mean and change of torque, and change and mean of the position difference, from [`LAG`] windows before to [`LAG`] windows
/// after, if both belong to the same contact.
fn instruments(sample: &ContactSample, sides: &[i8], windows: &[WindowSample]) -> Option<[f64; 4]> {
    let (first, last) = (sample.index.checked_sub(LAG)?, sample.index + LAG);
    // One contact throughout, not another on the same flank after a bounce.
    let side = sample.side as i8;
    let same = sides.get(first..=last)?.iter().all(|other| *other == side);
    let (before, after) = (windows.get(first)?, windows.get(last)?);
    let certain = |window: &WindowSample| window.one_way && window.whole;
    (same && certain(before) && certain(after)).then_some([
        0.5 * (before.torque_nm + after.torque_nm),
        after.torque_nm - before.torque_nm,
        after.difference_rad - before.difference_rad,
        0.5 * (before.difference_rad + after.difference_rad),
    ])
}
