//! Errors in a curve's description.

/// A curve that cannot exist.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// A number that is not finite, or a curve too large for its length to be.
    #[error("{what} is not a finite number: {value}")]
    NotFinite {
        /// Which quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// An arc of no turns.
    #[error("an arc needs a rotation of at least one turn in either sense, not 0")]
    NoRotation,
    /// An arc whose start or end is the centre, from where no angle can be told.
    #[error(
        "the {end} of the arc lies on its centre ({first_mm} mm, {second_mm} mm in the axes of the plane)"
    )]
    OnCenter {
        /// `start` or `end`.
        end: &'static str,
        /// Centre, first axis of the plane, mm.
        first_mm: f64,
        /// Centre, second axis of the plane, mm.
        second_mm: f64,
    },
    /// A nominal length that is not a positive finite number.
    #[error("the length of a polynomial piece is {value_mm} mm; it has to be positive and finite")]
    Length {
        /// Its value, mm.
        value_mm: f64,
    },
}

/// Refuses anything that is not finite.
pub(crate) fn finite(what: &'static str, values: &[f64]) -> Result<(), PathError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(PathError::NotFinite { what, value }),
        None => Ok(()),
    }
}
