//! Filters on a drive's torque command.

use super::check::{AxisConfigError, between};
use serde::{Deserialize, Serialize};

/// Most filters that a drive has in series.
pub const MAX_TORQUE_FILTERS: usize = 4;

/// Highest frequency of a filter over the servo's rate: below it warped and true frequency still
/// have a finite ratio.
const HIGHEST_SHARE: f64 = 0.45;

/// One second-order filter on the current command, at the servo's rate.
///
/// In a file:
/// `torque_filter = [{ notch = { frequency_hz = 180.0, width_hz = 60.0, depth_db = 30.0 } }, { low-pass = { frequency_hz = 800.0 } }]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TorqueFilter {
    /// Takes a band out.
    Notch(Notch),
    /// Takes out what lies above a frequency.
    LowPass(LowPass),
}

/// `(s^2 + 2 D_n w s + w^2)/(s^2 + 2 D_d w s + w^2)` with `D_d = width/(2 frequency)` and
/// `D_n = D_d 10^(-depth/20)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Notch {
    /// Its middle, Hz.
    pub frequency_hz: f64,
    /// Width between the points where a notch of infinite depth lets half of the power through, Hz.
    pub width_hz: f64,
    /// Attenuation in the middle, dB.
    pub depth_db: f64,
}

/// `w^2/(s^2 + 2 D w s + w^2)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LowPass {
    /// Its corner, Hz.
    pub frequency_hz: f64,
    /// Damping D; 0.7071 (Butterworth) if left out.
    #[serde(default = "butterworth")]
    pub damping: f64,
}

fn butterworth() -> f64 {
    std::f64::consts::FRAC_1_SQRT_2
}

impl TorqueFilter {
    fn check(&self, highest_hz: f64) -> Result<(), AxisConfigError> {
        match self {
            TorqueFilter::Notch(notch) => {
                between("notch.frequency_hz", notch.frequency_hz, 1.0, highest_hz)?;
                between(
                    "notch.width_hz",
                    notch.width_hz,
                    0.01 * notch.frequency_hz,
                    10.0 * notch.frequency_hz,
                )?;
                between("notch.depth_db", notch.depth_db, 0.0, 200.0)
            }
            TorqueFilter::LowPass(low) => {
                between("low-pass.frequency_hz", low.frequency_hz, 1.0, highest_hz)?;
                between("low-pass.damping", low.damping, 0.05, 5.0)
            }
        }
    }
}

/// The filters of a drive, first to last; at most [`MAX_TORQUE_FILTERS`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<TorqueFilter>", into = "Vec<TorqueFilter>")]
pub struct TorqueFilters([Option<TorqueFilter>; MAX_TORQUE_FILTERS]);

impl TorqueFilters {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// The filters in their order.
    pub fn iter(&self) -> impl Iterator<Item = &TorqueFilter> {
        self.0.iter().flatten()
    }

    pub(super) fn check(&self, servo_period_s: f64) -> Result<(), AxisConfigError> {
        // the bilinear transformation maps half the servo's rate to infinity: near it a filter is
        // not the one asked for
        let highest_hz = HIGHEST_SHARE / servo_period_s;
        self.iter().enumerate().try_for_each(|(index, filter)| {
            filter
                .check(highest_hz)
                .map_err(|error| error.within(&format!("torque_filter[{index}]")))
        })
    }
}

impl TryFrom<Vec<TorqueFilter>> for TorqueFilters {
    type Error = String;

    fn try_from(list: Vec<TorqueFilter>) -> Result<TorqueFilters, String> {
        if list.len() > MAX_TORQUE_FILTERS {
            return Err(format!(
                "there are {} torque filters; a drive has at most {MAX_TORQUE_FILTERS}",
                list.len()
            ));
        }
        let mut filters = TorqueFilters::default();
        for (slot, filter) in filters.0.iter_mut().zip(list) {
            *slot = Some(filter);
        }
        Ok(filters)
    }
}

impl From<TorqueFilters> for Vec<TorqueFilter> {
    fn from(filters: TorqueFilters) -> Vec<TorqueFilter> {
        filters.iter().copied().collect()
    }
}
