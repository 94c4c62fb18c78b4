//! Results made by hand.

/// A result with some of its fields given, the others at their default: results of the library
/// have no literals outside it, so that fields may be added.
macro_rules! made {
    ($type:ident { $($field:ident $(: $value:expr)?),* $(,)? }) => {{
        let mut made = $type::default();
        $(made.$field = made!(@ $field $(, $value)?);)*
        made
    }};
    (@ $field:ident, $value:expr) => { $value };
    (@ $field:ident) => { $field };
}
