//! How much the program says on stderr, and how.

use crate::args::Form;
use clap::Args;

/// What every command shares.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Voice {
    /// Print no progress and no warnings
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Form of what is found in the part program, on stderr; a document is written even if nothing
    /// is found
    #[arg(long, global = true, value_enum, value_name = "FORM", default_value_t)]
    pub(crate) diagnostics: Form,
}
