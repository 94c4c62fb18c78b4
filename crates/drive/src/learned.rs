//! What a compensator has learned of its axis: kept over the end of a run, and shown while it runs.
//!
//! All of it is at the motor's shaft, in SI units, so that it does not depend on the method that
//! learned it.

use crate::config::AxisConfigError;
use crate::config::check::{between, finite, not_negative, positive};
use lostmotion_base::linalg::cholesky;
use serde::{Deserialize, Serialize};

/// Unknowns of a load: inertia, viscous friction, Coulomb friction, constant torque.
const LOAD: usize = 4;

/// Load and gap of an axis as they were learned, with how far each is to be believed.
///
/// ```
/// use lostmotion_drive::Learned;
///
/// let learned = Learned {
///     load_inertia_kgm2: 0.003,
///     load_inertia_deviation_kgm2: 1e-4,
///     coulomb_nm: 0.4,
///     coulomb_deviation_nm: 0.02,
///     half_gap_rad: 2e-3,
///     half_gap_deviation_rad: 2e-5,
///     gap_readings: 6,
///     ..Learned::default()
/// };
/// learned.check()?;
/// assert_eq!(learned.covariance()[0][0], 1e-8);
/// # Ok::<(), lostmotion_drive::AxisConfigError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Learned {
    /// Half of the total gap, rad; 0 while it is unknown.
    pub half_gap_rad: f64,
    /// Its standard deviation, rad.
    pub half_gap_deviation_rad: f64,
    /// Readings that agree on it; 0 while it is unknown.
    pub gap_readings: u32,
    /// Whether the load may float between its flanks, so that the gap is not crossed.
    pub floats: bool,
    /// Inertia of the load, kg m2.
    pub load_inertia_kgm2: f64,
    /// Its standard deviation, kg m2.
    pub load_inertia_deviation_kgm2: f64,
    /// Viscous friction of the load, N m s/rad.
    pub viscous_nm_s_per_rad: f64,
    /// Its standard deviation, N m s/rad.
    pub viscous_deviation_nm_s_per_rad: f64,
    /// Coulomb friction of the load, N m.
    pub coulomb_nm: f64,
    /// Its standard deviation, N m.
    pub coulomb_deviation_nm: f64,
    /// Constant torque on the load, N m.
    pub constant_nm: f64,
    /// Its standard deviation, N m.
    pub constant_deviation_nm: f64,
    /// Correlations of these four in their order, -1 to 1: inertia with viscous friction, with
    /// Coulomb friction, with the constant torque; viscous with Coulomb friction, with the constant
    /// torque; Coulomb friction with the constant torque.
    pub correlations: [f64; 6],
}

/// Row and column of each correlation.
const PAIRS: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

/// Largest half gap that a memory may hold, rad: a turn of the motor.
const LARGEST_HALF_GAP_RAD: f64 = std::f64::consts::TAU;
/// By how much a correlation matrix may be indefinite: covariances of filters are rounded. A
/// choice.
const ROUNDING: f64 = 1e-6;

impl Learned {
    /// Standard deviations of inertia, viscous friction, Coulomb friction and constant torque.
    fn deviations(&self) -> [f64; LOAD] {
        [
            self.load_inertia_deviation_kgm2,
            self.viscous_deviation_nm_s_per_rad,
            self.coulomb_deviation_nm,
            self.constant_deviation_nm,
        ]
    }

    /// Covariance of inertia, viscous friction, Coulomb friction and constant torque, SI.
    pub fn covariance(&self) -> [[f64; LOAD]; LOAD] {
        let deviations = self.deviations();
        let mut covariance = [[0.0; LOAD]; LOAD];
        for (row, deviation) in deviations.into_iter().enumerate() {
            covariance[row][row] = deviation * deviation;
        }
        for ((row, column), correlation) in PAIRS.into_iter().zip(self.correlations) {
            let product = correlation * deviations[row] * deviations[column];
            covariance[row][column] = product;
            covariance[column][row] = product;
        }
        covariance
    }

    /// The same with this covariance of inertia, viscous friction, Coulomb friction and constant
    /// torque, SI. An unknown whose variance is not positive is as if it were known exactly.
    #[must_use]
    pub fn with_covariance(self, covariance: &[[f64; LOAD]; LOAD]) -> Learned {
        let deviations: [f64; LOAD] =
            std::array::from_fn(|index| covariance[index][index].max(0.0).sqrt());
        let correlations = PAIRS.map(|(row, column)| {
            let product = deviations[row] * deviations[column];
            if product > 0.0 {
                (covariance[row][column] / product).clamp(-1.0, 1.0)
            } else {
                0.0
            }
        });
        let learned = Learned {
            load_inertia_deviation_kgm2: deviations[0],
            viscous_deviation_nm_s_per_rad: deviations[1],
            coulomb_deviation_nm: deviations[2],
            constant_deviation_nm: deviations[3],
            correlations,
            ..self
        };
        if learned.is_possible() {
            return learned;
        }
        // rounding of long runs: the deviations hold, their correlations are given up
        Learned {
            correlations: [0.0; 6],
            ..learned
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range, with its key.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        between("half_gap_rad", self.half_gap_rad, 0.0, LARGEST_HALF_GAP_RAD)?;
        not_negative("half_gap_deviation_rad", self.half_gap_deviation_rad)?;
        // an inertia of nothing would be moved by any torque
        positive("load_inertia_kgm2", self.load_inertia_kgm2)?;
        not_negative(
            "load_inertia_deviation_kgm2",
            self.load_inertia_deviation_kgm2,
        )?;
        not_negative("viscous_nm_s_per_rad", self.viscous_nm_s_per_rad)?;
        not_negative(
            "viscous_deviation_nm_s_per_rad",
            self.viscous_deviation_nm_s_per_rad,
        )?;
        not_negative("coulomb_nm", self.coulomb_nm)?;
        not_negative("coulomb_deviation_nm", self.coulomb_deviation_nm)?;
        finite("constant_nm", self.constant_nm)?;
        not_negative("constant_deviation_nm", self.constant_deviation_nm)?;
        self.correlations
            .iter()
            .enumerate()
            .try_for_each(|(index, value)| {
                between(&format!("correlations[{index}]"), *value, -1.0, 1.0)
            })?;
        if self.is_possible() {
            return Ok(());
        }
        Err(AxisConfigError::Mismatch {
            key: "correlations".to_owned(),
            reason: "no four quantities can be correlated like this".to_owned(),
            hint: "set all of them to 0.0".to_owned(),
        })
    }

    /// Whether the correlations are those of some quantities: their matrix has no negative
    /// eigenvalue, but for rounding.
    fn is_possible(&self) -> bool {
        let mut matrix = [[0.0; LOAD]; LOAD];
        for (index, row) in matrix.iter_mut().enumerate() {
            row[index] = 1.0 + ROUNDING;
        }
        for ((row, column), correlation) in PAIRS.into_iter().zip(self.correlations) {
            matrix[row][column] = correlation;
            matrix[column][row] = correlation;
        }
        // the factor of an indefinite matrix has pivots of zero, and is not finite behind them
        let factor = cholesky(&matrix, 0.0);
        (0..LOAD).all(|index| factor[index][index] > 0.0)
            && factor.iter().flatten().all(|entry| entry.is_finite())
    }
}

/// What becomes of a reading of the gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ReadingVerdict {
    /// It joins the others.
    Counts,
    /// The motor's motion does not show a contact.
    NoContact,
    /// The model of the load does not explain the motor's motion.
    Unexplained,
    /// Its standard deviation is too large a part of its value.
    Vague,
    /// Its gap is larger than any that is looked for.
    TooLarge,
    /// The flank wavered, and the reading is not sharp enough for that.
    Wavering,
}

impl ReadingVerdict {
    /// In words.
    pub const fn text(self) -> &'static str {
        match self {
            ReadingVerdict::Counts => "counts",
            ReadingVerdict::NoContact => "no contact shows",
            ReadingVerdict::Unexplained => "the load as known does not explain it",
            ReadingVerdict::Vague => "its deviation is too large",
            ReadingVerdict::TooLarge => "larger than any gap looked for",
            ReadingVerdict::Wavering => "the flank wavered",
        }
    }
}

/// A reading of the gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GapReading {
    /// Its number, from 1.
    pub number: u32,
    /// Half gap, rad.
    pub half_gap_rad: f64,
    /// Its standard deviation, rad; 0 where no contact was found.
    pub deviation_rad: f64,
    /// What becomes of it.
    pub verdict: ReadingVerdict,
}

/// What a compensator that learns knows at a moment, for traces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Learning {
    /// What it has learned; `None` while it does not know the load.
    pub learned: Option<Learned>,
    /// Half gap that it corrects with now, rad; 0 for none.
    pub used_half_gap_rad: f64,
    /// Part of its correction that is in force: 1, or less where it fades out, 0 to 1.
    pub share: f64,
    /// Whether its changes of flank can be foreseen: the inertia is known where it matters.
    pub foresees: bool,
    /// How far the control and the other axes let it correct, 0 to 1.
    pub allowed: f64,
    /// The newest reading of the gap.
    pub reading: Option<GapReading>,
}
