//! `study` and `reproduce`.

use super::Format;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// What to study.
#[derive(Debug, Subcommand)]
pub(crate) enum Study {
    /// Run the test matrix: motions, gaps, friction, inertia and encoders, with every method
    Matrix(Matrix),
    /// Run one cell of the matrix and write its trace
    Cell(Cell),
    /// Two motors back to back, a coupler with a known gap and stiffness: what the fits and
    /// `adaptive` find of it
    Bench(Bench),
    /// An axis for an hour, turns and rests: whether what a method has learned stays
    Endurance(Endurance),
}

/// `study matrix`.
#[derive(Debug, Args)]
pub(crate) struct Matrix {
    /// Number of cells sampled
    #[arg(long, value_name = "N", default_value_t = 120, conflicts_with = "full")]
    pub(crate) cells: usize,
    /// Seed of the sample
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Every cell there is: takes days
    #[arg(long)]
    pub(crate) full: bool,
    /// Compensation methods, separated by commas; all but `fitted-lookup`, if left out
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) methods: Vec<String>,
    /// Folder for the tables, and for the results so far: run again, a stopped study goes on
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Forget the results so far in the folder
    #[arg(long, requires = "out")]
    pub(crate) fresh: bool,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    /// Threads to use at most; all cores, if left out. The answer does not depend on it
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
}

/// `study cell`.
#[derive(Debug, Args)]
pub(crate) struct Cell {
    /// Name of the cell, from a table of the matrix
    pub(crate) cell: String,
    /// Compensation method
    #[arg(long, value_name = "NAME", default_value = "none")]
    pub(crate) method: String,
    /// CSV to write: error and both axes, a row every 250 us
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: Option<PathBuf>,
    /// Write the cell's part program, too
    #[arg(long, value_name = "FILE.ngc")]
    pub(crate) program: Option<PathBuf>,
}

/// `study bench`.
#[derive(Debug, Args)]
pub(crate) struct Bench {
    /// Total gap of the coupler in radian; five couplers, if left out
    #[arg(long, value_name = "N", requires = "stiffness_nm_per_rad")]
    pub(crate) gap_rad: Option<f64>,
    /// Its stiffness in N m/rad
    #[arg(long, value_name = "N", requires = "gap_rad")]
    pub(crate) stiffness_nm_per_rad: Option<f64>,
}

/// `study endurance`.
#[derive(Debug, Args)]
pub(crate) struct Endurance {
    /// Cell of the matrix whose axis runs, drifting over the whole time if its name ends so
    #[arg(long, value_name = "NAME", default_value = lostmotion_study::endurance::USUAL)]
    pub(crate) cell: String,
    /// Compensation method
    #[arg(long, value_name = "NAME", default_value = "adaptive")]
    pub(crate) method: String,
    /// How long, in minutes of the machine's time
    #[arg(long, value_name = "N", default_value_t = 60.0)]
    pub(crate) minutes: f64,
}

/// What to reproduce.
#[derive(Debug, Subcommand)]
pub(crate) enum Reproduce {
    /// The experiments of Gan, Wang, Huang, Machines 2023, 11(2), 193: figures 3 and 7 to 11, and
    /// what the paper does not say, scanned
    Paper(Paper),
}

/// `reproduce paper`.
#[derive(Debug, Args)]
pub(crate) struct Paper {
    /// Folder for table, scan and figures; made if it does not exist
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}
