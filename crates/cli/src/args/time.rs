//! Arguments of `time`.

use super::Format;
use super::interventions::Interventions;
use super::part::OnMachine;
use super::run::Quality;
use clap::Args;
use std::path::PathBuf;

/// `time`.
#[derive(Debug, Args)]
pub(crate) struct Time {
    #[command(flatten)]
    pub(crate) on: OnMachine,
    #[command(flatten)]
    pub(crate) interventions: Interventions,
    /// How much trouble to take over the time
    #[arg(long, value_enum, default_value_t)]
    pub(crate) quality: Quality,
    /// How far the tool may bow from its way between two commands, in micrometres: the motion slows
    /// down to keep it; if left out the machine's, or 5 if a drive interpolates linearly
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) bow_limit_um: Option<f64>,
    /// How many of the blocks that take longest to list
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub(crate) top: usize,
    /// What a tool change lasts, in seconds
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub(crate) tool_change_s: f64,
    /// What it takes the spindle to start, stop or turn round, in seconds
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub(crate) spindle_s: f64,
    /// Leave out the what-if table, for which the program is planned once more a row
    #[arg(long)]
    pub(crate) no_what_if: bool,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    /// Folder for time.json, time.txt and blocks.csv (a row each time a block runs); made if it
    /// does not exist
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Threads to use at most; all cores, if left out. The answer does not depend on it
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
}
