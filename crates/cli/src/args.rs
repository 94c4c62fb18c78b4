//! The arguments of the command line.

pub(crate) mod drives;
pub(crate) mod interventions;
pub(crate) mod study;
pub(crate) mod time;

use crate::voice::Voice;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// How far a real machine leaves the programmed contour, and what each way of compensating backlash does about it.
#[derive(Debug, Parser)]
#[command(name = "lostmotion", version, max_term_width = 100, arg_required_else_help = true, subcommand_required = true)]
#[command(
    after_help = "Exit codes: 0 done, and within tolerance where there is one; 1 outside tolerance, warnings of lint, or unformatted; 2 bad input."
)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) voice: Voice,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a part program on a machine: contour error against a tolerance, with the blocks that cause it
    Simulate(Simulate),
    /// Run one plan with several compensation methods, side by side
    Compare(Compare),
    /// Print the canonical operations of a part program, one a line
    Canon(Canon),
    /// Look for what is allowed and may still break a tool, a part or a machine. Exit code 0 nothing, 1 warnings, 2 errors
    Lint(Lint),
    /// Put a part program into one style without changing what it does
    Format(FormatPart),
    /// Say what a line does, with the modes and the position before and after
    Explain(Explain),
    /// Write a program with everything computed: no parameters, loops, calls, cycles, offsets; lines and arcs with coordinates
    Write(WritePart),
    /// Write the planned motion of every axis as CSV, a row a command cycle
    Plan(Plan),
    /// Tell where the time of a part program goes: by block, by kind, by what limits it, and what better limits would save
    Time(time::Time),
    /// Run one axis alone on setpoints from a CSV
    Axis(Axis),
    /// Fit the gap of an axis to a log of motor position, load position and current
    Fit(Fit),
    /// List, show and check machines
    #[command(subcommand)]
    Machine(Machine),
    /// Compare methods over many machines and motions
    #[command(subcommand)]
    Study(study::Study),
    /// Run experiments of the literature again
    #[command(subcommand)]
    Reproduce(study::Reproduce),
}

/// Form of the answer on stdout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Tables for people
    #[default]
    Text,
    /// Versioned JSON for programs
    Json,
}

/// Form of findings about a part program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Form {
    /// With the lines they are about
    #[default]
    Text,
    /// Versioned JSON
    Json,
    /// SARIF 2.1.0
    Sarif,
}

/// The machine to run on.
#[derive(Debug, Args)]
pub(crate) struct OnMachine {
    /// Machine: a name from `machine list`, or a machine file
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub(crate) machine: Option<String>,
}

/// How a program is read.
#[derive(Debug, Default, Args)]
pub(crate) struct Reading {
    /// Dialect of the program: linuxcnc, fanuc, haas, marlin, klipper or siemens; the machine's, if left out
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

/// What `simulate` and `compare` share.
#[derive(Debug, Args)]
pub(crate) struct Run {
    /// Part program
    pub(crate) part: PathBuf,
    #[command(flatten)]
    pub(crate) on: OnMachine,
    #[command(flatten)]
    pub(crate) drives: drives::Drives,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) interventions: interventions::Interventions,
    /// How much trouble to take over the time
    #[arg(long, value_enum, default_value_t)]
    pub(crate) quality: Quality,
    /// Tolerance of the contour error in micrometres; the machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) tolerance_um: Option<f64>,
    /// How far arcs may lie from the splines (G5, G5.1, G5.2) that they stand for, in millimetres
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) spline_tolerance_mm: Option<f64>,
    /// Size of a cutting force in newton, against the tool's way through the part on every feed move; the machine's (mostly none), if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) cutting_force_n: Option<f64>,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    /// Folder for result, tables and picture; made if it does not exist
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Also write every sample of the contour error (needs --out; a row a servo tick)
    #[arg(long, requires = "out")]
    pub(crate) trace: bool,
    /// Tell the methods that may know it the gap of an axis from a result of `fit` (`fitted-lookup` needs one); may be repeated
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
    /// Hold it against the travel, tools and offsets of a machine too: a name from `machine list`, or a machine file
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub(crate) machine: Option<String>,
    /// Tool table in LinuxCNC's format
    #[arg(long, value_name = "FILE", conflicts_with = "machine")]
    pub(crate) tool_table: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Switch a lint off; may be repeated. `all` stands for every lint, and a code beats `all`
    #[arg(long, value_name = "CODE")]
    pub(crate) allow: Vec<String>,
    /// Report a lint as a warning
    #[arg(long, value_name = "CODE")]
    pub(crate) warn: Vec<String>,
    /// Report a lint as an error
    #[arg(long, value_name = "CODE")]
    pub(crate) deny: Vec<String>,
    /// Form of the answer on stdout
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Form,
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
    /// Take tools, offsets and the place at the start from a machine: a name from `machine list`, or a machine file
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub(crate) machine: Option<String>,
    /// Tool table in LinuxCNC's format
    #[arg(long, value_name = "FILE", conflicts_with = "machine")]
    pub(crate) tool_table: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// `write`.
#[derive(Debug, Args)]
pub(crate) struct WritePart {
    /// Part program
    pub(crate) part: PathBuf,
    /// Take tools, offsets and the place at the start from a machine: a name from `machine list`, or a machine file
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub(crate) machine: Option<String>,
    /// Tool table in LinuxCNC's format
    #[arg(long, value_name = "FILE", conflicts_with = "machine")]
    pub(crate) tool_table: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Work coordinate system, 1 for G54 to 9 for G59.3, that the coordinates of the new program are in
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) system: u8,
    /// File to write; stdout, if left out
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
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
    /// Part program
    pub(crate) part: PathBuf,
    #[command(flatten)]
    pub(crate) on: OnMachine,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) interventions: interventions::Interventions,
    /// How far arcs may lie from the splines (G5, G5.1, G5.2) that they stand for, in millimetres
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) spline_tolerance_mm: Option<f64>,
    /// Time from row to row, 0.25 to 8 ms; the machine's command cycle, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) command_ms: Option<f64>,
    /// How much trouble to take over the time
    #[arg(long, value_enum, default_value_t)]
    pub(crate) quality: Quality,
    /// CSV to write: t_s, a position per axis (x_mm ... c_deg), source line
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
}

/// `axis`.
#[derive(Debug, Args)]
pub(crate) struct Axis {
    /// CSV with the columns t_s and position, a row a command cycle; velocity and acceleration where the interpolator needs them
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
    /// How the drive goes from setpoint to setpoint; quintic-differences, or the axis' own where the setpoints bring velocity and acceleration
    #[arg(long, value_name = "NAME")]
    pub(crate) interpolator: Option<String>,
    #[command(flatten)]
    pub(crate) cycles: drives::Cycles,
    /// CSV to write, a row a servo tick
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: PathBuf,
}

/// `fit`.
#[derive(Debug, Args)]
pub(crate) struct Fit {
    /// CSV with the columns t_s, motor_U, load_U (U: mm, deg or rad) and current_a
    pub(crate) log: PathBuf,
    /// Use motor position and current alone: for a log without load_U (needs --axis for the motor's inertia)
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
    /// Make a machine file of another program's description: LinuxCNC INI, grbl `$$`, FreeCAD .fcm, URDF
    Import {
        /// The description
        file: PathBuf,
        /// Format: linuxcnc, grbl, freecad or urdf; recognised if left out
        #[arg(long, value_name = "FORMAT")]
        from: Option<String>,
        /// Machine that lends what the description does not say: drives, loads, gaps, jerk
        #[arg(long, value_name = "NAME", default_value = "vmc3")]
        preset: String,
        /// Write the machine file here, and the report of every key to stdout; without it the file goes to stdout and the report to stderr
        #[arg(long, value_name = "FILE.toml")]
        out: Option<PathBuf>,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn arguments_are_consistent() {
        Cli::command().debug_assert();
    }
}
