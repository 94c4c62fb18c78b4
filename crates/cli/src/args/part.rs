//! A part program and how it is read: arguments that commands share.

use clap::Args;
use std::path::PathBuf;

/// How a program is read.
#[derive(Debug, Default, Args)]
pub(crate) struct Reading {
    /// Dialect of the program: linuxcnc, fanuc, haas, marlin, klipper or siemens; the machine's, if
    /// left out
    #[arg(long, value_name = "NAME")]
    pub(crate) dialect: Option<String>,
    /// Accept, with a warning, what the dialect does not: the code of that warning; may be repeated
    #[arg(long, value_name = "CODE")]
    pub(crate) accept: Vec<String>,
    /// Refuse what the dialect accepts with a warning: the code of that warning; may be repeated
    #[arg(long, value_name = "CODE")]
    pub(crate) refuse: Vec<String>,
    /// Folder with files of subroutines, besides the part's own; may be repeated
    #[arg(long, value_name = "DIR")]
    pub(crate) subroutines: Vec<PathBuf>,
    /// Bound of the G-code front end, such as looped_blocks=1e6; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) limit: Vec<String>,
}

/// A part program that is read, on a machine or without one.
#[derive(Debug, Args)]
pub(crate) struct Setup {
    /// Take tools, offsets, the place at the start and, where it matters, the travel from a
    /// machine: a name from `machine list`, or a machine file
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub(crate) machine: Option<String>,
    /// Tool table in LinuxCNC's format
    #[arg(long, value_name = "FILE", conflicts_with = "machine")]
    pub(crate) tool_table: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: Reading,
}

/// A part program that is run on a machine.
#[derive(Debug, Args)]
pub(crate) struct OnMachine {
    /// Part program
    pub(crate) part: PathBuf,
    /// Machine: a name from `machine list`, or a machine file
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub(crate) machine: Option<String>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// How far the planned curves may lie from the splines (G5, G5.1, G5.2) that they stand for, in
    /// millimetres
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) spline_tolerance_mm: Option<f64>,
}
