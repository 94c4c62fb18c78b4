//! Arguments of `machine`, `axis` and `fit`.

use super::drives::Cycles;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// `axis`.
#[derive(Debug, Args)]
pub(crate) struct Axis {
    /// CSV with the columns t_s and position, a row a command cycle; velocity and acceleration
    /// where the interpolator needs them
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) setpoints: PathBuf,
    /// Axis: a name from `machine list`, or a file with the tables of one axis
    #[arg(long, value_name = "FILE.toml|PRESET")]
    pub(crate) axis: String,
    /// Compensation method
    #[arg(long, value_name = "NAME", default_value = "none")]
    pub(crate) method: String,
    /// Column of the setpoints that holds the position, such as x_mm of a plan
    #[arg(long, value_name = "NAME")]
    pub(crate) column: Option<String>,
    /// How the drive goes from setpoint to setpoint; quintic-differences, or the axis' own where
    /// the setpoints bring velocity and acceleration
    #[arg(long, value_name = "NAME")]
    pub(crate) interpolator: Option<String>,
    #[command(flatten)]
    pub(crate) cycles: Cycles,
    /// CSV to write, a row a servo tick
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
}

/// `fit`.
#[derive(Debug, Args)]
pub(crate) struct Fit {
    /// CSV with the columns t_s, motor_U, load_U (U: mm, deg or rad) and current_a
    pub(crate) log: PathBuf,
    /// Use motor position and current alone: for a log without load_U (needs --axis for the motor's
    /// inertia)
    #[arg(long, requires = "axis")]
    pub(crate) motor_only: bool,
    /// The axis that was logged: motor data and transmission make the fit sharper
    #[arg(long, value_name = "FILE.toml|PRESET")]
    pub(crate) axis: Option<String>,
    /// JSON to write
    #[arg(long, value_name = "FILE.json")]
    pub(crate) out: PathBuf,
}

/// `machine`.
#[derive(Debug, Subcommand)]
pub(crate) enum Machine {
    /// List the machines and single axes that come with the program
    List,
    /// Print a machine as a file to start from
    Show {
        /// A name from `machine list`
        name: String,
    },
    /// Say everything that is wrong with a machine file, and how the loops of its axes are tuned
    Check {
        /// Machine file, or a name from `machine list`
        #[arg(value_name = "FILE.toml|NAME")]
        file: PathBuf,
    },
    /// Make a machine file of another program's description: LinuxCNC INI, grbl `$$`, FreeCAD .fcm,
    /// URDF
    Import {
        /// The description
        file: PathBuf,
        /// Format: linuxcnc, grbl, freecad or urdf; recognised if left out
        #[arg(long, value_name = "FORMAT")]
        from: Option<String>,
        /// Machine that lends what the description does not say: drives, loads, gaps, jerk
        #[arg(long, value_name = "NAME", default_value = "vmc3")]
        preset: String,
        /// Write the machine file here, and the report of every key to stdout; without it the file
        /// goes to stdout and the report to stderr
        #[arg(long, value_name = "FILE.toml")]
        out: Option<PathBuf>,
    },
}
