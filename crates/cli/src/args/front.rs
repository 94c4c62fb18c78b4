//! Arguments of the commands that only read a part program.

use super::part::{Reading, Setup};
use super::{Form, Format};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// `canon`.
#[derive(Debug, Args)]
pub(crate) struct Canon {
    /// Part program
    pub(crate) part: PathBuf,
    /// Tool table in LinuxCNC's format
    #[arg(long, value_name = "FILE")]
    pub(crate) tool_table: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: Reading,
}

/// `lint`.
#[derive(Debug, Args)]
pub(crate) struct Lint {
    /// Part program
    pub(crate) part: PathBuf,
    #[command(flatten)]
    pub(crate) setup: Setup,
    /// Switch a lint off; may be repeated. `all` stands for every lint, and a code beats `all`
    #[arg(long, value_name = "CODE")]
    pub(crate) allow: Vec<String>,
    /// Report a lint as a warning
    #[arg(long, value_name = "CODE")]
    pub(crate) warn: Vec<String>,
    /// Report a lint as an error
    #[arg(long, value_name = "CODE")]
    pub(crate) deny: Vec<String>,
    /// Form of the answer on stdout; that of --diagnostics, if left out
    #[arg(long, value_enum)]
    pub(crate) format: Option<Form>,
}

/// `format`.
#[derive(Debug, Args)]
pub(crate) struct FormatPart {
    /// Part program
    pub(crate) part: PathBuf,
    /// Change nothing and say what would be changed; exit code 1 if there is something
    #[arg(long, conflicts_with = "write")]
    pub(crate) check: bool,
    /// Write the file in place instead of stdout
    #[arg(long)]
    pub(crate) write: bool,
    /// Case of letters outside comments
    #[arg(long, value_enum, default_value_t)]
    pub(crate) case: LetterCase,
    /// Blanks for each level of O-words
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub(crate) indent: usize,
    /// Line numbers: keep, remove, or the step to number anew by
    #[arg(long, value_name = "keep|remove|STEP", default_value = "keep")]
    pub(crate) line_numbers: String,
}

/// Case of letters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum LetterCase {
    /// G1 X10; O-words stay as they are
    #[default]
    Upper,
    /// g1 x10
    Lower,
    /// As it is
    Keep,
}

/// `explain`.
#[derive(Debug, Args)]
pub(crate) struct Explain {
    /// Part program and line
    #[arg(value_name = "PART:LINE")]
    pub(crate) place: String,
    #[command(flatten)]
    pub(crate) setup: Setup,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// `write`.
#[derive(Debug, Args)]
pub(crate) struct WritePart {
    /// Part program
    pub(crate) part: PathBuf,
    #[command(flatten)]
    pub(crate) setup: Setup,
    /// Work coordinate system, 1 for G54 to 9 for G59.3, that the coordinates of the new program
    /// are in
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) system: u8,
    /// File to write; stdout, if left out
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}
