//! What can be wrong with an axis' description, and the checks that say so.

use lostmotion_base::units::number;

/// A value of an axis' description that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AxisConfigError {
    /// A number outside its range.
    #[error("{key} is {}; it has to be {allowed}", number(*value))]
    Range {
        /// Key, with the tables it stands in.
        key: String,
        /// The value found.
        value: f64,
        /// What would be allowed.
        allowed: String,
    },
    /// Two parts that do not go together.
    #[error("{key} does not fit: {reason}; {hint}")]
    Mismatch {
        /// Key of the part at fault.
        key: String,
        /// What does not fit.
        reason: String,
        /// How to mend it.
        hint: String,
    },
}

impl AxisConfigError {
    /// The same error with the key put into an outer table: `gap_um` in `load.slide` becomes
    /// `load.slide.gap_um`.
    #[must_use]
    pub fn within(self, table: &str) -> AxisConfigError {
        match self {
            AxisConfigError::Range {
                key,
                value,
                allowed,
            } => AxisConfigError::Range {
                key: format!("{table}.{key}"),
                value,
                allowed,
            },
            AxisConfigError::Mismatch { key, reason, hint } => AxisConfigError::Mismatch {
                key: format!("{table}.{key}"),
                reason,
                hint,
            },
        }
    }
}

fn range(key: &str, value: f64, allowed: &str) -> AxisConfigError {
    AxisConfigError::Range {
        key: key.to_owned(),
        value,
        allowed: allowed.to_owned(),
    }
}

/// A finite number above zero.
///
/// # Errors
/// [`AxisConfigError::Range`] with the key and the value.
pub fn positive(key: &str, value: f64) -> Result<(), AxisConfigError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(range(key, value, "a finite number above 0"))
    }
}

/// A finite number, zero or above.
///
/// # Errors
/// [`AxisConfigError::Range`] with the key and the value.
pub fn not_negative(key: &str, value: f64) -> Result<(), AxisConfigError> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(range(key, value, "a finite number, 0 or above"))
    }
}

/// A finite number.
///
/// # Errors
/// [`AxisConfigError::Range`] with the key and the value.
pub fn finite(key: &str, value: f64) -> Result<(), AxisConfigError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(range(key, value, "a finite number"))
    }
}

/// A number from `low` to `high`, both included.
///
/// # Errors
/// [`AxisConfigError::Range`] with the key and the value.
pub fn between(key: &str, value: f64, low: f64, high: f64) -> Result<(), AxisConfigError> {
    // a NaN compares false and is refused with the rest
    if value >= low && value <= high {
        Ok(())
    } else {
        Err(range(key, value, &format!("from {low} to {high}")))
    }
}
