//! Arguments of the commands that run a part program on a machine.

use super::Format;
use super::drives::Drives;
use super::interventions::Interventions;
use super::part::OnMachine;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// What `simulate` and `compare` share.
#[derive(Debug, Args)]
pub(crate) struct Run {
    #[command(flatten)]
    pub(crate) on: OnMachine,
    #[command(flatten)]
    pub(crate) drives: Drives,
    #[command(flatten)]
    pub(crate) interventions: Interventions,
    /// How much trouble to take over the time
    #[arg(long, value_enum, default_value_t)]
    pub(crate) quality: Quality,
    /// Tolerance of the contour error in micrometres; the machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) tolerance_um: Option<f64>,
    /// Size of a cutting force in newton, against the tool's way through the part on every feed
    /// move; the machine's (mostly none), if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) cutting_force_n: Option<f64>,
    /// How far the tool may bow from its way between two commands, in micrometres: the motion slows
    /// down to keep it; if left out the machine's, or 5, which is kept if a drive interpolates
    /// linearly and else warned of
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) bow_limit_um: Option<f64>,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    /// Folder for result, tables and picture; made if it does not exist
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Also write every sample of the contour error (needs --out; a row a servo tick)
    #[arg(long, requires = "out")]
    pub(crate) trace: bool,
    /// Tell the methods that may know it the gap of an axis from a result of `fit` (`fitted-lookup`
    /// needs one, and takes the load of `fit --motor-only`, too); y2 is the second motor of a
    /// gantry's Y; may be repeated
    #[arg(long, value_name = "AXIS=FILE.json")]
    pub(crate) fitted: Vec<String>,
    /// Threads to use at most; all cores, if left out. The answer does not depend on it
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
}

/// `simulate`.
#[derive(Debug, Args)]
pub(crate) struct Simulate {
    #[command(flatten)]
    pub(crate) run: Run,
    /// Compensation method
    #[arg(long, value_name = "NAME", default_value = "none")]
    pub(crate) method: String,
}

/// `compare`.
#[derive(Debug, Args)]
pub(crate) struct Compare {
    #[command(flatten)]
    pub(crate) run: Run,
    /// Compensation methods, separated by commas; all, if left out
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) methods: Vec<String>,
}

/// How much trouble the planner takes over the time of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Quality {
    /// As fast as programs are read
    #[default]
    Fast,
    /// Nearly the shortest time that the limits allow
    Optimal,
}

impl Quality {
    /// As the planner has it.
    pub(crate) fn of_planner(self) -> lostmotion::plan::Quality {
        match self {
            Quality::Fast => lostmotion::plan::Quality::Fast,
            Quality::Optimal => lostmotion::plan::Quality::Optimal,
        }
    }
}

/// `plan`.
#[derive(Debug, Args)]
pub(crate) struct Plan {
    #[command(flatten)]
    pub(crate) on: OnMachine,
    #[command(flatten)]
    pub(crate) interventions: Interventions,
    /// Time from row to row, 0.25 to 8 ms; the machine's command cycle, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) command_ms: Option<f64>,
    /// How much trouble to take over the time
    #[arg(long, value_enum, default_value_t)]
    pub(crate) quality: Quality,
    /// How far the tool may bow from its way between two commands, in micrometres: the motion slows
    /// down to keep it; if left out the machine's, or 5, which is kept if a drive interpolates
    /// linearly and else warned of
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) bow_limit_um: Option<f64>,
    /// CSV to write: t_s, a position per axis (x_mm ... c_deg), source line
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
}
