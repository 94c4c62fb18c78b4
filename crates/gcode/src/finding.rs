//! What is known about a kind of finding: its severity, its row in the catalog, and the macro that
//! makes [`crate::problem::Problem`] from a table. An entry of the table:
//!
//! ```text
//! Name { fields } => error "stable-code" limit "name_of_the_limit",
//!     says("the message, with the {fields} it was seen with"),
//!     "What has been found, for the page of diagnostics.",
//!     "What to do about it.",
//!     hint "what to try, with the message";
//! ```
//!
//! `limit` and `hint` may be absent. A hint is an expression over the fields.

use serde::Serialize;

/// How bad a diagnostic is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A habit of writing, reported once a file with its count; no change is needed.
    Note,
    /// The program is accepted, but may not do what its author means.
    Warning,
    /// The block is not executed and the program is refused.
    Error,
}

impl Severity {
    /// Its name in messages, tables and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// What is known about a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CatalogRow {
    /// Stable name, kebab case.
    pub code: &'static str,
    /// Whether it refuses the program.
    pub severity: Severity,
    /// What has been found.
    pub summary: &'static str,
    /// What to do about it.
    pub advice: &'static str,
}

/// The severity of a word in the tables of problems and leniencies.
macro_rules! severity {
    (error) => {
        Severity::Error
    };
    (warning) => {
        Severity::Warning
    };
    (note) => {
        Severity::Note
    };
}

/// Makes the enum, its stable codes, severities, limits and hints, and the rows of the catalog.
macro_rules! problems {
    (
        kinds { $(
            $name:ident $({ $($field:ident: $type:ty),* $(,)? })? =>
                $severity:ident $code:literal $(limit $limit:literal)?,
            says($($message:tt)*),
            $summary:literal,
            $advice:literal
            $(, hint $hint:expr)?;
        )* }
        same_codes { $(
            $other:ident $({ $($part:ident: $kind:ty),* $(,)? })? => ($level:expr, $same:expr),
            says($($text:tt)*)
            $(, hint $try:expr)?;
        )* }
        machine { $(
            $machine_severity:ident $machine_code:literal, $machine_summary:literal, $machine_advice:literal;
        )* }
    ) => {
        /// What is wrong, with the values that show it. Lengths are in the program's units unless a
        /// name says otherwise.
        ///
        /// [`Problem::code`] is stable across releases; the wording is not.
        #[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize)]
        #[non_exhaustive]
        #[allow(missing_docs, reason = "each message names its fields")]
        pub enum Problem {
            $(#[error($($message)*)] $name $({ $($field: $type),* })?,)*
            $(#[error($($text)*)] $other $({ $($part: $kind),* })?,)*
        }

        #[allow(unused_variables, reason = "most entries use none of their fields")]
        impl Problem {
            /// Stable name, kebab case.
            pub fn code(&self) -> &'static str {
                match self {
                    $(Problem::$name { .. } => $code,)*
                    $(Problem::$other $({ $($part),* })? => $same,)*
                }
            }

            /// Errors refuse their block and the program; warnings and notes leave it accepted.
            pub fn severity(&self) -> Severity {
                match self {
                    $(Problem::$name { .. } => severity!($severity),)*
                    $(Problem::$other $({ $($part),* })? => $level,)*
                }
            }

            /// The limit of [`crate::Limits`] that has been exceeded.
            pub fn limit(&self) -> Option<&'static str> {
                match self {
                    $($(Problem::$name { .. } => Some($limit),)?)*
                    _ => None,
                }
            }

            /// What to try.
            pub fn hint(&self) -> Option<String> {
                if let Some(limit) = self.limit() {
                    return Some(format!(
                        "the limit `{limit}` can be raised: --limit {limit}=VALUE on the command \
            line"
                    ));
                }
                match self {
                    $(Problem::$name $({ $($field),* })? => {
                        let hint: Option<String> = None;
                        $(let hint = $hint.into_hint();)?
                        hint
                    })*
                    $(Problem::$other $({ $($part),* })? => {
                        let hint: Option<String> = None;
                        $(let hint = $try.into_hint();)?
                        hint
                    })*
                }
            }
        }

        /// Rows of the codes that have an entry.
        pub(crate) const ROWS: &[CatalogRow] = &[
            $(CatalogRow {
                code: $code,
                severity: severity!($severity),
                summary: $summary,
                advice: $advice,
            },)*
            $(CatalogRow {
                code: $machine_code,
                severity: severity!($machine_severity),
                summary: $machine_summary,
                advice: $machine_advice,
            },)*
        ];
    };
}

pub(crate) use {problems, severity};

/// A hint as a literal, or one that depends on the values.
pub(crate) trait IntoHint {
    fn into_hint(self) -> Option<String>;
}

impl IntoHint for &str {
    fn into_hint(self) -> Option<String> {
        Some(self.to_owned())
    }
}

impl IntoHint for String {
    fn into_hint(self) -> Option<String> {
        Some(self)
    }
}

impl IntoHint for Option<String> {
    fn into_hint(self) -> Option<String> {
        self
    }
}
