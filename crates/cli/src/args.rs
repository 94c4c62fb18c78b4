//! The arguments of the command line.

pub(crate) mod drives;
pub(crate) mod front;
pub(crate) mod interventions;
pub(crate) mod machine;
pub(crate) mod part;
pub(crate) mod run;
pub(crate) mod study;
pub(crate) mod time;

use crate::voice::Voice;
use clap::{Parser, Subcommand, ValueEnum};

/// How far a real machine leaves the programmed contour, and what each way of compensating backlash
/// does about it.
#[derive(Debug, Parser)]
#[command(
    name = "lostmotion",
    version,
    max_term_width = 100,
    arg_required_else_help = true,
    subcommand_required = true
)]
#[command(
    after_help = "Exit codes: 0 done, and within tolerance where there is one; 1 outside tolerance, warnings of lint, or unformatted; 2 bad input; 130 ended by Ctrl-C."
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
    /// Run a part program on a machine: contour error against a tolerance, with the blocks that
    /// cause it
    Simulate(run::Simulate),
    /// Run one plan with several compensation methods, side by side
    Compare(run::Compare),
    /// Print the canonical operations of a part program, one a line
    Canon(front::Canon),
    /// Look for what is allowed and may still break a tool, a part or a machine. Exit code 0
    /// nothing, 1 warnings, 2 errors
    Lint(front::Lint),
    /// Put a part program into one style without changing what it does
    Format(front::FormatPart),
    /// Say what a line does, with the modes and the position before and after
    Explain(front::Explain),
    /// Write a program with everything computed: no parameters, loops, calls, cycles, offsets;
    /// lines and arcs with coordinates
    Write(front::WritePart),
    /// Write the planned motion of every axis as CSV, a row a command cycle
    Plan(run::Plan),
    /// Tell where the time of a part program goes: by block, by kind, by what limits it, and what
    /// better limits would save
    Time(time::Time),
    /// Run one axis alone on setpoints from a CSV
    Axis(machine::Axis),
    /// Fit the gap of an axis to a log of motor position, load position and current
    Fit(machine::Fit),
    /// List, show and check machines
    #[command(subcommand)]
    Machine(machine::Machine),
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn arguments_are_consistent() {
        Cli::command().debug_assert();
    }
}
